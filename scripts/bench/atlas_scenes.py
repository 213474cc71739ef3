"""The scenes of the atlas: the settings of evidence by name, and a stratified design with a fixed seed.

A `Scene` is numbers only. `build` makes the structure, the contact and the case out of it, and `write` puts model.h5 and case.toml
into a folder. Nothing here depends on how any solver fares.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.linalg

import atlas_evidence
import atlas_structures as structures
from atlas_structures import cases

from dovetail import Model, reference

SEED = 20240
DESIGNED = 300
DELIVERED = 5  # harmonics of the original and of plain continuation: fewer are easier for them
THREE_HARMONICS = [0, 0, 1, 0.3, 0.2, 0.1, 0.3]
UNITS = {  # what 1 of stiffness, mass and displacement is called
    "1": (1.0, 1.0, 1.0),
    "SI": (1e9, 10.0, 1e-6),  # 1e9 N/m, micrometres
    "mm t s N": (1e6, 1e-2, 1e-3),
    "small": (1e-3, 1e-12, 1e-9),  # 1 mN/m, nanogram, nanometre
}
FAMILIES = {"chain": structures.chain, "two bodies": structures.two_bodies, "dense": structures.dense,
            "held by its joint": structures.held_by_its_joint, "hardly held": structures.hardly_held,
            "near-rigid": structures.near_rigid, "1:3": structures.one_to_three, "symmetric": structures.fork}


@dataclass(frozen=True)
class Scene:
    """Everything about a scene, dimensionless unless said otherwise; the structure's stiffness K, mass and frequency are near 1.

    stiffness : k_n / K of all points together;  tangential : k_t / k_n;  friction : mu
    press : static force on the contacts, all together, over K times 1 of displacement;  gap : lift-off displacement
    force : amplitude;  damping : zeta of the first mode with the joint stuck
    backward : from the upper end of the range to the lower;  three : force with three harmonics
    step : first arc length over a sensible one;  units : of UNITS;  seed : of the structure
    """

    name: str
    family: str
    points: int
    stiffness: float
    tangential: float
    friction: float
    press: float
    gap: float
    force: float
    damping: float
    backward: bool
    three: bool
    step: float
    units: str
    seed: int


@dataclass
class Built:
    """A scene in its own units: what every method needs.

    structure, contact, reduced as in `cases` and `reference`; xi [s]; omega (from, to) [rad/s]
    harmonics : H of Dovetail;  delivered : H of the other two
    step : first arc length of Dovetail, scaled;  arc : of the others, in the plain norm of [q, Omega], user units
    """

    name: str
    structure: cases.Structure
    contact: reference.Contact
    reduced: reference.Reduced
    modes: int
    xi: float
    fourier: list
    omega: tuple
    harmonics: int
    delivered: int
    step: float
    arc: float
    initial: float = 0.0

    def fingerprint(self):
        """Short hash of all numbers."""
        s, c = self.structure, self.contact
        arrays = s.K, s.M, s.contact_dofs, s.force, s.preload, c.kn, c.kt, c.mu, c.gap
        numbers = self.modes, self.xi, self.fourier, self.omega, self.harmonics, self.delivered, self.step, self.arc, self.initial
        made = hashlib.sha256(repr(numbers).encode())
        for array in arrays:
            made.update(np.ascontiguousarray(array).tobytes())
        return made.hexdigest()[:16]


def spread(rng, count, low, high):
    """`count` values between low and high, one in each of as many equal parts, in random order."""
    return low + (high - low) * (rng.permutation(count) + rng.uniform(size=count)) / count


def shares(rng, count, parts):
    """`count` values in the given shares {value: share}, in random order."""
    bounds = np.cumsum(list(parts.values())) / sum(parts.values())
    values = list(parts)
    return [values[i] for i in rng.permutation(np.searchsorted(bounds, (np.arange(count) + 0.5) / count))]


def designed(count=DESIGNED, seed=SEED):
    """Scenes in which every number is spread evenly over its range and all are paired by chance (a Latin hypercube)."""
    rng = np.random.default_rng(seed)
    columns = {
        "family": shares(rng, count, {"chain": 6, "two bodies": 5, "dense": 3, "held by its joint": 2, "hardly held": 1, "near-rigid": 2,
                                      "1:3": 3, "symmetric": 2}),
        "points": shares(rng, count, {1: 44, 2: 22, 3: 12, 5: 10, 9: 6, 16: 3, 30: 2, 50: 1}),
        "stiffness": 10 ** spread(rng, count, -2, 4),
        "tangential": 10 ** spread(rng, count, -0.7, 0.1),
        "friction": np.maximum(0, spread(rng, count, -0.1, 2)),  # 1 in 21 without friction
        "separation": spread(rng, count, -1, 3),  # below 0 an open gap, above it static force from 0.03 to 30
        "force": 10 ** spread(rng, count, -2, 2),
        "damping": 10 ** spread(rng, count, np.log10(1e-4), np.log10(5e-2)),
        "backward": shares(rng, count, {False: 1, True: 1}),
        "three": shares(rng, count, {False: 4, True: 1}),
        "step": shares(rng, count, {1.0: 6, 1e-3: 1, 0.1: 1, 10.0: 1, 1000.0: 1}),
        "units": shares(rng, count, {"1": 7, "SI": 1, "mm t s N": 1, "small": 1}),
        "seed": rng.integers(1 << 31, size=count),
    }
    scenes = []
    for i in range(count):
        row = {name: column[i] for name, column in columns.items()}
        separation = row.pop("separation")
        row["press"] = float(10 ** (separation - 1.5)) if separation >= 0 else 0.0
        row["gap"] = float(-separation) if separation < 0 else 0.0
        if row["family"] == "symmetric":
            row["points"] = max(2, min(row["points"], 5))
        if row["family"] in ("held by its joint", "hardly held") and row["press"] == 0:
            row["press"], row["gap"] = 0.03, 0.0  # without static force such a body would be nowhere
        if row["points"] > 5:  # no impacts at many points, which would take more harmonics than a bench has time for
            row["stiffness"] = 10 ** (np.log10(row["stiffness"]) / 2)
        if row["points"] > 9:
            row["press"], row["gap"] = max(row["press"], 3 * row["force"]), 0.0
        row = {key: value.item() if isinstance(value, np.generic) else value for key, value in row.items()}
        scenes.append(Scene(name=f"{i:03d}", **row))
    return scenes


def scenes():
    """All of them, by name."""
    return {scene.name: scene for scene in atlas_evidence.scenes(Scene) + designed()}


def build(scene):
    """The scene in its own units."""
    if scene.family == "evidence":
        return atlas_evidence.build(scene, Built)
    rng = np.random.default_rng(scene.seed)
    kn = 2 * scene.stiffness / scene.points  # 2: the normal direction of the structures is twice as stiff as K
    kt = scene.tangential * kn
    springs = np.array([kt, kt, kn])
    extra = (springs,) if scene.family == "1:3" else ()
    made = FAMILIES[scene.family](scene.points, rng, *extra)
    share = np.ones(scene.points)
    if scene.family != "symmetric":
        share = rng.uniform(0.7, 1.4, scene.points)
    sidewards = rng.uniform(-0.3, 0.3) * (rng.uniform() < 1 / 3)  # static force along t1 in a third of the scenes
    press = made.press.copy()
    press[made.contact_dofs[:, 0]] = sidewards * press[made.contact_dofs[:, 2]]

    k, m, d = UNITS[scene.units]
    rate = np.sqrt(k / m)
    structure = cases.Structure(k * made.K, m * made.M, made.contact_dofs, k * d * scene.force * made.force,
                                k * d * scene.press * press)
    contact = reference.Contact.uniform(scene.points, k * kn * share, k * kt * np.outer(share, [1, 0.8]), scene.friction, d * scene.gap)
    reduced = reference.craig_bampton(structure.K, structure.M, structure.contact_dofs, structure.force, structure.preload, made.modes)
    free, stuck = structures.frequencies(made), structures.frequencies(made, springs)
    low, high = sweep_range(free, stuck)
    xi = 2 * scene.damping / high_mode(stuck)
    omega = (high, low) if scene.backward else (low, high)
    fourier = THREE_HARMONICS if scene.three else [0, 0, 1]
    built = Built(scene.name, structure, contact, reduced, made.modes, xi / rate, fourier, (omega[0] * rate, omega[1] * rate),
                  harmonics(scene, kn, low), DELIVERED, 0.02 * scene.step, 0.0)
    built.arc = scene.step * linear_arc(built) / 200
    return built


def high_mode(stuck):
    """The first frequency with the joint stuck that is no rigid motion."""
    return stuck[stuck > 1e-2][0]


def sweep_range(free, stuck):
    """From below the first resonance without joint to above the first with it stuck, but never wider than 1 : 3."""
    high = 1.25 * high_mode(stuck)
    return max(0.8 * free[free > 1e-2][0], high / 3), high


def harmonics(scene, kn, low):
    """H as a user might choose it: few where contacts hardly open or are many, else after the frequency of a closed contact."""
    if scene.points > 5:
        return 3 if scene.points > 9 else 5
    if scene.gap == 0 and scene.press > 30 * scene.force:
        return 5
    mass = 1 / (scene.points + 1)
    closed = np.sqrt(2 * (scene.points + 1) / mass + kn / mass)
    return int(np.clip(np.ceil(1.5 * closed / low), 5, 11 if scene.points <= 2 else 7))


def linear_arc(built, points=4000):
    """Length of the response curve with the joint stuck, in the plain norm of [X, Omega]: what a fixed step is chosen by."""
    K = scipy.linalg.block_diag(np.diag(built.reduced.kaa), built.reduced.kxx)
    M = np.block([[np.eye(built.modes), built.reduced.max], [built.reduced.max.T, built.reduced.mxx]])
    stuck = K.copy()
    contact = np.arange(built.modes, len(K))
    stuck[contact, contact] += np.column_stack([built.contact.kt, built.contact.kn]).ravel()
    squares, modes = scipy.linalg.eigh(stuck, M)
    damping = built.xi * np.einsum("ij,ij->j", modes, K @ modes)
    low, high = sorted(built.omega)
    inside = np.sqrt(np.maximum(squares, 0))
    near = [w + max(c, 1e-9 * w) * np.linspace(-20, 20, 400) for w, c in zip(inside, damping) if low < w < high]
    grid = np.unique(np.clip(np.concatenate([np.linspace(low, high, points), *near]), low, high))
    load = modes.T @ np.r_[built.reduced.fa, built.reduced.fx]
    curve = [np.zeros(len(grid)), grid]
    q = modes @ (load[:, None] / (squares[:, None] - grid ** 2 + 1j * grid * damping[:, None]))
    return np.sum(np.sqrt(np.sum(np.abs(np.diff(q, axis=1)) ** 2, axis=0) + np.diff(curve[1]) ** 2))


def write(built, folder):
    """model.h5 and case.toml in a folder; the path of the latter. What is not named is left to Dovetail's defaults."""
    folder = Path(folder)
    s, c = built.structure, built.contact
    Model(s.K, s.M, s.contact_dofs, s.force, s.preload).write(folder / "model.h5")
    frictionless = not np.any(c.mu)
    friction = {} if frictionless else {"tangential_stiffness": c.kt.tolist(), "friction": c.mu.tolist()}
    return cases.write(folder, built.name, "model.h5", s, built.reduced, {}, modes=built.modes, stiffness=built.xi, fourier=built.fourier,
                       law="unilateral" if frictionless else "coulomb", normal_stiffness=c.kn.tolist(), **friction,
                       gap=c.gap.tolist(), initial=built.initial, harmonics=built.harmonics, omega=list(built.omega),
                       step=built.step).path
