"""Bolts: a force that pulls two sets of nodes together, kept or locked after tightening; and the static state it makes.

Let c be the unit pull of a bolt, so that c^T u is the approach of its two ends, and F its force. Tightened:

    K u + [0; g(x)] = P + sum c F

A locked bolt keeps its length: its force is F - k_b (c^T u - a), a the approach when tightened. That is a stiffness
k_b c c^T beside K and a load c (F + k_b a) beside P, under which the same u is the static state again.

Without friction while tightening, the state is found with normal forces alone. Displacements are then measured from it, so that
the sliders of friction begin there without force: the preload becomes the normal forces themselves, and the gaps of the contact
points what is left of them: -g_n / k_n where they are pressed.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from .condensation import Condensed
from .sparse_rows import is_petsc
from .units import parse, with_unit

RIGID = 1e4  # stiffness of a locked bolt that has none given, as a multiple of what the structure itself sets against its pull
ITERATIONS = 60  # of Newton's method
SOFT, ROUNDS = 1e-4, 30  # of tangential stiffness: springs that hold a joint without friction along itself until they carry nothing
TOLERANCE = 1e-11  # of what is left of the forces, relative to the largest


@dataclass(frozen=True)
class Bolt:
    """A bolt of a model.

    pull : (n,) load of a unit force that draws both ends together
    force : [N], when tightened
    lock : afterwards its length stays; else its force does
    stiffness : of a locked one [N/m]; None: as good as rigid
    """

    name: str
    pull: np.ndarray
    force: float
    lock: bool = False
    stiffness: float = None


def tightened(model, bolts, friction=True):
    """The model with its bolts tightened, all together, and what was done, one sentence each.

    Parameters
    ----------
    model : dovetail.Model
        With SciPy matrices.
    bolts : list of Bolt
    friction : bool
        While tightening. Without it, or with a bolt that is locked, stiffnesses of the contact points must be known, and friction.

    Returns
    -------
    Model, list of str
    """
    unit = parse(model.units)

    def said(bolt):
        return with_unit(f"{bolt.force:g}", unit.force)

    pulls = sum(bolt.pull * bolt.force for bolt in bolts)
    locked = [bolt for bolt in bolts if bolt.lock]
    if not locked and friction:
        return (model.with_loads(preload=model.preload + pulls),
                [f"bolt {bolt.name}: force {said(bolt)}, which stays" for bolt in bolts])
    if is_petsc(model.K):
        raise ValueError("bolts that are locked, or tightened without friction, need a model with SciPy matrices")
    statics = _Statics(model)
    u, g = statics.state(model.preload + pulls, friction)
    K, preload, notes = sp.csr_matrix(model.K), model.preload + pulls, []
    for bolt in bolts:
        approach = bolt.pull @ u
        nearer = f"its ends approach by {with_unit(f'{approach:.4g}', unit.length)}"
        if not bolt.lock:
            notes.append(f"bolt {bolt.name}: force {said(bolt)}, which stays; {nearer}")
            continue
        stiffness = bolt.stiffness or RIGID / (bolt.pull @ statics.stuck(bolt.pull))
        column = sp.csr_matrix(bolt.pull[:, None])
        K = K + stiffness * (column @ column.T)
        preload = preload + bolt.pull * (stiffness * approach)
        notes.append(f"bolt {bolt.name}: tightened to {said(bolt)}, {nearer}; then locked by a stiffness of "
                     + with_unit(f"{stiffness:.4g}", unit.stiffness))
    contact = dict(model.contact)
    if not friction:
        normal = model.contact_dofs[:, 2]
        preload = np.zeros(model.n)
        preload[normal] = g[:, 2]
        contact["gap"] = model.contact.get("gap", 0.0) - u[normal]
        notes.append("tightened without friction: displacements count from that state, the preload is that of the contact points, and "
                     "their gaps hold what presses them")
    return model.with_stiffness(K).with_loads(preload=preload).with_contact(contact), notes


def static_state(model, load, friction=True):
    """Displacements and contact forces under a load, from rest.

    Parameters
    ----------
    model : dovetail.Model
        Its matrices whole in this process. Stiffnesses of the contact points must be known, and friction.
    load : (n,) array [N]
    friction : bool
        Coulomb's law, or none along the joint.

    Returns
    -------
    u (n,) [m], g (N_x, 3) [N] : K u + [0; g] = load
    """
    return _Statics(model).state(load, friction)


class _Statics:
    """The joint under loads of the structure, seen from the contact dofs: one factorisation serves all."""

    def __init__(self, model):
        if model.cyclic:
            raise ValueError("a bolt of a cyclic sector keeps its force and is tightened with friction; one that is locked, or "
                             "tightened without friction, is not computed there")
        missing = [key for key in ("normal_stiffness", "tangential_stiffness", "friction") if key not in model.contact]
        if missing:
            raise ValueError(f"a bolt that is locked, or tightened without friction, needs {missing[0]} of the joints here, "
                             "not in the case file")
        self.contact = model.contact
        self.structure = Condensed(model.K, model.contact_dofs.ravel())

    def stuck(self, load):
        """Displacements (n,) with all contact points closed and stuck."""
        return self.structure.displacements(self._stuck(self.structure.load(load)), load)

    def state(self, load, friction):
        """As in `static_state`. Newton's method."""
        force, scale = self.structure.load(load), np.abs(load).max()
        x = self._stuck(force)
        if friction:
            x, g = self._newton(x, force, scale, None)
            return self.structure.displacements(x, load), g
        for _ in range(ROUNDS):  # springs from where the last ones ended: what holds the joint besides takes over
            x, g = self._newton(x, force, scale, x.reshape(-1, 3)[:, :2])
            if np.abs(g[:, :2]).max() <= 10 * TOLERANCE * np.abs(g).max():
                return self.structure.displacements(x, load), g * [0.0, 0.0, 1.0]
        raise ValueError("the bolts cannot be tightened without friction: the loads push a part along the joint, and nothing else "
                         "holds it there")

    def _stuck(self, force):
        springs = np.column_stack([self.contact["tangential_stiffness"], self.contact["normal_stiffness"]]).ravel()
        K = self.structure.stiffness + np.diag(springs)
        x = _solved(K, force)
        if not np.all(np.isfinite(x)) or np.abs(K @ x - force).max() > 1e-6 * np.abs(force).max():
            raise ValueError("the bolts cannot be tightened: a part moves freely even with all contact points closed")
        return x

    def _newton(self, x, force, scale, anchors):
        """The static state (3 N_x,) from a start x; with `anchors` (N_x, 2) soft springs from there in place of friction."""
        K, points = self.structure.stiffness, np.arange(len(x) // 3)
        left, g, slopes = self._residual(x, force, anchors)
        for _ in range(ITERATIONS):
            if np.abs(left).max() <= TOLERANCE * max(scale, np.abs(g).max()):
                return x, g
            J = K.copy()
            J.reshape(len(points), 3, len(points), 3)[points, :, points, :] += slopes
            step = _solved(J, -left)
            if not np.all(np.isfinite(step)) or np.abs(J @ step + left).max() > 1e-6 * np.abs(left).max():
                raise ValueError("the bolts cannot be tightened: under their forces a part moves freely")
            length = 1.0
            while True:
                tried = self._residual(x + length * step, force, anchors)
                if np.linalg.norm(tried[0]) < np.linalg.norm(left) or length < 1e-3:
                    break
                length /= 2
            x, (left, g, slopes) = x + length * step, tried
        raise ValueError(f"the state under the forces of the bolts was not found in {ITERATIONS} iterations; what is left of the "
                         f"forces is {np.abs(left).max():.3g}")

    def _residual(self, x, force, anchors):
        """K x + g - force, the contact forces g (N_x, 3) and their slopes (N_x, 3, 3)."""
        g, slopes = _contact_forces(x.reshape(-1, 3), self.contact, anchors)
        return self.structure.stiffness @ x - force + g.ravel(), g, slopes


def _solved(matrix, right):
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:  # singular to the last bit
        return np.full(right.shape, np.nan)


def _contact_forces(x, contact, anchors):
    """Forces (N_x, 3) of contact points at x (N_x, 3), and their slopes (N_x, 3, 3); `anchors` as in `_Statics`."""
    k_n = contact["normal_stiffness"]
    pressed = x[:, 2] - contact.get("gap", 0.0)
    closed = pressed > 0
    g, slopes = np.zeros((len(x), 3)), np.zeros((len(x), 3, 3))
    g[:, 2] = np.where(closed, k_n * pressed, 0.0)
    slopes[:, 2, 2] = np.where(closed, k_n, 0.0)
    for axis in (0, 1):
        if anchors is not None:
            slopes[:, axis, axis] = SOFT * contact["tangential_stiffness"][:, axis]
            g[:, axis] = slopes[:, axis, axis] * (x[:, axis] - anchors[:, axis])
            continue
        k_t, bound = contact["tangential_stiffness"][:, axis], contact["friction"][:, axis] * g[:, 2]
        trial = k_t * x[:, axis]
        sticks = closed & (np.abs(trial) <= bound)
        slips = closed & ~sticks
        g[:, axis] = np.where(sticks, trial, np.where(slips, np.sign(trial) * bound, 0.0))
        slopes[:, axis, axis] = np.where(sticks, k_t, 0.0)
        slopes[:, axis, 2] = np.where(slips, np.sign(trial) * contact["friction"][:, axis] * k_n, 0.0)
    return g, slopes
