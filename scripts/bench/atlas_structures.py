"""Structures of the atlas: small, dimensionless, first frequencies near 1, overall stiffness near 1. Each as matrices with contact dofs.

Contact dofs are t1, t2, n of each point, and positive n closes. The matrices are perturbed by the random numbers they are given, so
that directions couple and no two scenes are alike; those that are about symmetry are not.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.linalg
import scipy.optimize

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests/verification"))
import cases

DIRECTIONS = np.array([1.0, 1.5, 2.0])  # stiffness of a link along t1, t2, n, relative to its own


@dataclass
class Structure:
    """K, M (n, n); contact_dofs (N_x, 3); force (n,), largest entry 1; press (n,): static force, 1 in all on the contact normals.

    modes : N_a, fixed-interface modes worth keeping;  bodies : 1 (contacts against the ground) or 2
    """

    K: np.ndarray
    M: np.ndarray
    contact_dofs: np.ndarray
    force: np.ndarray
    press: np.ndarray
    modes: int
    bodies: int = 1


class Links:
    """Nodes with three dofs each, connected by links (three springs) to each other and to the ground."""

    def __init__(self, nodes, rng=None):
        self.K, self.M = np.zeros((3 * nodes, 3 * nodes)), np.zeros(3 * nodes)
        self.rng = rng

    def add(self, node, other, stiffness):
        """A link between two nodes, or to the ground (other = None), its axes slightly turned if there is chance."""
        axes = np.eye(3)
        springs = stiffness * DIRECTIONS
        if self.rng is not None:
            axes = scipy.linalg.expm(0.15 * (lambda a: a - a.T)(self.rng.normal(size=(3, 3))))
            springs = springs * self.rng.uniform(0.8, 1.25, 3)
        block = axes @ np.diag(springs) @ axes.T
        rows = [slice(3 * i, 3 * i + 3) for i in (node, other) if i is not None]
        for i, row in enumerate(rows):
            for j, column in enumerate(rows):
                self.K[row, column] += block if i == j else -block

    def weigh(self, node, mass):
        self.M[3 * node:3 * node + 3] = mass


def chain(points, rng):
    """Clamped chain of `points` nodes on the ground and a free tip: the chain of evidence, perturbed."""
    nodes = points + 1
    links = Links(nodes, rng)
    for node in range(nodes):
        links.add(node, node - 1 if node else None, nodes)
        links.weigh(node, 1 / nodes)
    return one_body(links, points, rng, shaken=points)


def one_body(links, points, rng, shaken, modes=3):
    """The first `points` nodes stand on the ground; node `shaken` is excited in a direction of chance, more along t1 and n."""
    n = len(links.M)
    force, press = np.zeros(n), np.zeros(n)
    force[3 * shaken:3 * shaken + 3] = excitation(rng)
    press[2:3 * points:3] = 1 / points
    return Structure(links.K, np.diag(links.M), np.arange(3 * points).reshape(-1, 3), force, press, modes)


def excitation(rng):
    direction = rng.uniform(-1, 1, 3) * [1, 0.5, 1]
    return direction / np.abs(direction).max()


def two_bodies(points, rng, hold=0.8):
    """Two chains that touch along all nodes but their tips; the second, `hold` times as stiff at its clamp, may be free (hold = 0).

    Its contact dofs are relative: u1 = (s + r) / 2, u2 = (s - r) / 2, so that r_n > 0 closes when the first lies above the second.
    """
    nodes = points + 1
    links = Links(2 * nodes, rng)
    for body in range(2):
        first = body * nodes
        for node in range(nodes):
            anchor = first + node - 1 if node else None
            stiffness = nodes if node or body == 0 else hold * nodes
            if stiffness > 0:
                links.add(first + node, anchor, stiffness)
            links.weigh(first + node, (1, 0.7)[body] / nodes)
    n = 6 * nodes
    change = np.eye(n)
    one, two = np.arange(3 * points), np.arange(3 * points) + 3 * nodes
    change[one, one], change[one, two], change[two, one], change[two, two] = 0.5, 0.5, 0.5, -0.5
    force, press = np.zeros(n), np.zeros(n)
    force[3 * points:3 * points + 3] = excitation(rng)
    force[3 * nodes + 3 * points:3 * nodes + 3 * points + 3] = 0.3 * excitation(rng)
    press[one[2::3]], press[two[2::3]] = 1 / points, -1 / points
    return Structure(change.T @ links.K @ change, change.T @ np.diag(links.M) @ change, two.reshape(-1, 3), change.T @ force,
                     change.T @ press, modes=4, bodies=2)


def held_by_its_joint(points, rng):
    """The second body is clamped nowhere: only the joint holds it, so without contact its stiffness is singular."""
    return two_bodies(points, rng, hold=0.0)


def hardly_held(points, rng):
    """The second body hangs on springs that are a millionth of the others: a near-rigid motion the contacts see."""
    return two_bodies(points, rng, hold=1e-6)


def near_rigid(points, rng):
    """The chain with a mass on very soft springs at its tip and another on very stiff ones: modes near 0.001 and 1000."""
    nodes = points + 1
    links = Links(nodes + 2, rng)
    for node in range(nodes):
        links.add(node, node - 1 if node else None, nodes)
        links.weigh(node, 1 / nodes)
    links.add(nodes, points, 1e-6)
    links.add(nodes + 1, points, 1e5)
    links.weigh(nodes, 0.5)
    links.weigh(nodes + 1, 0.1)
    return one_body(links, points, rng, shaken=points, modes=7)


def dense(points, rng):
    """Full matrices with contact dofs scattered among the others, as in the verification tests."""
    made = cases.random_structure(elastic=8, points=points, seed=int(rng.integers(1 << 31)))
    press = np.zeros(len(made.K))
    press[made.contact_dofs[:, 2]] = 1 / points
    return Structure(made.K / 4, made.M, made.contact_dofs, made.force / np.abs(made.force).max(), press, modes=5)


def one_to_three(points, rng, springs):
    """The chain with one node more, tuned so that with `springs` (3,) at each contact the second bending is thrice as fast as the first.

    Frequencies come in threes, as directions do: the fourth is three times the first. Tuned by the stiffness of the last link; if none
    gives 3, the one that comes closest.
    """
    perturbation = int(rng.integers(1 << 31))

    def build(log_stiffness):
        again = np.random.default_rng(perturbation)
        links = Links(points + 2, again)
        for node in range(points + 1):
            links.add(node, node - 1 if node else None, points + 1)
            links.weigh(node, 1 / (points + 1))
        links.add(points + 1, points, np.exp(log_stiffness))
        links.weigh(points + 1, 1 / (points + 1))
        return one_body(links, points, again, shaken=points + 1, modes=5)

    def off(log_stiffness):
        made = build(log_stiffness)
        first, second = frequencies(made, springs)[[0, 3]]
        return second / first - 3

    grid = np.log(points + 1) + np.linspace(-3, 3, 31)
    values = np.array([off(g) for g in grid])
    change = np.flatnonzero(values[:-1] * values[1:] < 0)
    if len(change) == 0:
        return build(grid[np.argmin(np.abs(values))])
    return build(scipy.optimize.brentq(off, grid[change[0]], grid[change[0] + 1], xtol=1e-6))


def fork(points, rng):
    """Mirror images: `points` equal prongs on a middle node that is shaken along n alone. Nothing is perturbed, so branches may cross."""
    links = Links(points + 1)
    links.add(points, None, 1.0)
    links.weigh(points, 0.4)
    for node in range(points):
        links.add(node, points, 2.0)
        links.weigh(node, 0.6 / points)
    made = one_body(links, points, rng, shaken=points)
    made.force[3 * points:] = 0, 0, 1
    return made


def dof5():
    """The five-degree-of-freedom example."""
    K = 20 * np.eye(5) - 10 * np.eye(5, k=1) - 10 * np.eye(5, k=-1)
    K[0, 0] = 10
    return Structure(K, np.eye(5), np.array([[2, 3, 4]]), np.array([1.0, 1, 0, 0, 0]), np.array([1, 0.1, 0.1, 0.1, 0.1]), modes=2)


def frequencies(structure, springs=(0.0, 0.0, 0.0)):
    """Eigenfrequencies, ascending, with springs [t1, t2, n] at every contact point."""
    K = structure.K.copy()
    K[structure.contact_dofs, structure.contact_dofs] += springs
    return np.sqrt(np.maximum(scipy.linalg.eigh(K, structure.M, eigvals_only=True), 0))
