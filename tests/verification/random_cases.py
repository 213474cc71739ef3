"""Random structures with frictional joints at one frequency, for properties that hold of all of them: see properties.py."""

import shutil
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from hypothesis import reject
from hypothesis import strategies as st

import cases
from dovetail import Results, reference, verify
from dovetail.reduced_system import equations
from launch import line, words_of

MEMORY = Path("/dev/shm")  # folders of single runs: no disk
TIGHT = {"step_tolerance": 1e-10, "residual_tolerance": 1e-10}


def numbers(low, high):
    """Floats of few digits, which can be read in a report."""
    return st.integers(0, 1000).map(lambda part: round(low + (high - low) * part / 1000, 6))


def per_point(points, values):
    return st.lists(values, min_size=points, max_size=points)


@dataclass(frozen=True)
class Scene:
    """A structure and the settings of its case, by the names of `cases`."""

    structure: cases.Structure
    settings: dict

    def __repr__(self):
        s = self.structure
        return f"Scene({len(s.K)} dofs, contact {s.contact_dofs.tolist()}, {self.settings})"

    @property
    def points(self):
        return len(self.structure.contact_dofs)

    def with_structure(self, **parts):
        return replace(self, structure=replace(self.structure, **parts))

    def having(self, **settings):
        return replace(self, settings=self.settings | settings)

    def changed(self, T, dofs=None):
        """The same in unknowns v with u = T v, and contact dofs at other places if they are named."""
        s = self.structure
        return self.with_structure(K=T.T @ s.K @ T, M=T.T @ s.M @ T, force=s.force @ T, preload=s.preload @ T,
                                   contact_dofs=s.contact_dofs if dofs is None else dofs)


@st.composite
def scenes(draw, laws=reference.LAWS, samples=("exact", 64), linear=False):
    """Contact laws by point are drawn from `laws`; `linear`: contacts neither slip nor open."""
    points, elastic = draw(st.integers(1, 3)), draw(st.integers(1, 6))
    structure = cases.random_structure(elastic, points, draw(st.integers(0, 10**6)))
    stiff, tangential = numbers(0.5, 8), st.lists(numbers(0.5, 4), min_size=2, max_size=2)
    friction = st.lists(numbers(0, 1) if not linear else st.just(1e4), min_size=2, max_size=2)
    law = draw(per_point(points, st.sampled_from(laws)))
    pairs = draw(per_point(points, friction))
    kt = draw(per_point(points, tangential))
    mu = [[pair[0]] * 2 if law[i] == "cone" else pair for i, pair in enumerate(pairs)]
    harmonics = draw(st.integers(2, 5))
    course = [draw(numbers(-0.5, 0.5)), *draw(st.lists(numbers(-1, 1), min_size=2, max_size=4))]
    if not any(course[1:]):
        course[1] = 1.0
    omega = draw(numbers(0.4, 4))
    return Scene(structure, {
        "modes": draw(st.integers(1, elastic)), "stiffness": draw(numbers(0.005, 0.1)), "mass": draw(numbers(0, 0.1)),
        "fourier": course, "law": law, "normal_stiffness": draw(per_point(points, stiff)), "tangential_stiffness": kt, "friction": mu,
        "gap": draw(per_point(points, numbers(-0.5, 0.3))) if not linear else [-1e4] * points, "initial": 0.0, "harmonics": harmonics,
        "samples": draw(st.sampled_from(samples)), "omega": [omega, omega], "kind": "auto", "estimates": False, "enabled": False, **TIGHT})


@dataclass
class Answer:
    """X (N_x, 3, 2H+1), motion of the contact points; `results`, with all files of the run."""

    X: np.ndarray
    results: Results


class Runs:
    """Runs in folders that go with the object; counts them, and solutions that are another one of the same equations."""

    def __init__(self):
        self.folder, self.count, self.others = tempfile.mkdtemp(dir=MEMORY if MEMORY.is_dir() else None), 0, 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.folder, ignore_errors=True)

    def case(self, scene):
        self.count += 1
        folder = Path(self.folder) / str(self.count)
        folder.mkdir()
        settings = scene.settings
        if not {"coulomb", "cone"} & set(np.atleast_1d(settings["law"])):
            settings = settings | dict.fromkeys(("friction", "tangential_stiffness"))  # which would be refused
        return cases.full(folder, "random", scene.structure, settings, modes=settings["modes"])

    def solve(self, scene, ranks=None):
        """The `Answer` of a scene. Rejects an example whose first point the program does not find (status 3)."""
        command, folder = line(self.case(scene), ranks=ranks)
        try:
            words_of(command)
        except AssertionError as error:
            if "ended with 3\n" in str(error):
                reject()
            raise
        results = Results(folder / "results.h5")
        return Answer(contact_part(results, results.coefficients_at(0)), results)

    def same(self, X, answer, tolerance=1e-6):
        """Asserts that X is the motion of the contact points of an answer, or else another solution of its equations."""
        size = np.linalg.norm(answer.X)
        off = np.linalg.norm(X - answer.X)
        if off <= tolerance * size:
            return
        missing = residual(answer.results, X)
        assert missing < tolerance, f"motions differ by {off / size:.1e}, and the equations by {missing:.1e} of the load"
        self.others += 1


def contact_part(results, q):
    return q[results.modes:].reshape(results.contact_points, 3, -1)


def residual(results, X):
    """What is missing of the equations of a run, relative to the load, when its contact points move as X: modes as that asks for."""
    samples = results.samples or verify.MANY
    system, omega = equations(results, samples), results.omega[0]
    q = np.zeros(system.shape)
    q[system.modes:] = X.reshape(-1, q.shape[1])
    n = system.modes
    for k in range(system.H + 1):
        K, M = system.matrices(k)
        D = K - (k * omega)**2 * M + (system.damper(k, omega) if k else 0)
        c, s = (2 * k - 1, 2 * k) if k else (0, 0)
        load = system.excitation[:, c] - 1j * (system.excitation[:, s] if k else 0)
        x = q[n:, c] - 1j * (q[n:, s] if k else 0)
        a = np.linalg.solve(D[:n, :n], load[:n] - D[:n, n:] @ x)
        q[:n, c] = a.real
        if k:
            q[:n, s] = -a.imag
    own, _ = verify.own_forces(system, q, results, system.H, verify.sampled_forces(system, q, samples, verify.OF_CONES).G)
    r = system.structure(q, omega) - system.excitation
    r[n:] += own.reshape(-1, q.shape[1])
    return np.linalg.norm(r) / (np.linalg.norm(system.excitation) + np.linalg.norm(own))
