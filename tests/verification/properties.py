"""What holds of every structure with frictional joints: each function draws one, runs it in two ways, and asserts a property.

The tests run some examples of each, `scripts/properties` as many as wanted.
"""

import hashlib
from dataclasses import dataclass, field

import h5py
import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import seed as seeded
from hypothesis import strategies as st
from hypothesis.errors import UnsatisfiedAssumption

from dovetail import reference, verify
from dovetail.reduced_system import equations
from launch import line, words_of
from random_cases import Runs, numbers, per_point, scenes

LINEAR = ("coulomb", "cone", "bilateral")  # that are springs while the normal force is large
WITHOUT_CONE = ("coulomb", "unilateral", "bilateral")
FINE = 1024  # samples, of a run against an exact one
WRONG = {  # key of a case: values that are refused
    "friction": [-0.5, "high", [0.3] * 5], "normal_stiffness": [-1.0, 0.0, "stiff"], "gap": ["wide", True], "harmonics": [-1, 0, 2.5],
    "samples": [-4, "some", 3], "omega": [[1.0], "fast", [-1.0, 2.0]], "stiffness": [-0.1, "soft"], "modes": [-1, 10**6],
    "law": ["glue", 3], "fourier": ["cos", [], [0, 0, 0]], "residual_tolerance": [0, -1.0], "kind": ["other"]}


def energy(data, runs):
    """Work of the load = damped + rubbed, the last as the file has it; exact forces."""
    results = runs.solve(data.draw(scenes(WITHOUT_CONE, samples=("exact",)))).results
    system, q, omega = equations(results, 64), results.coefficients_at(0), results.omega[0]
    put_in, damped = verify.work(system.excitation, q), verify.work(system.times(lambda k: system.damper(k, omega), q), q)
    rubbed = results.contact_activity(0).dissipation
    assert rubbed.min() >= -1e-9 * put_in and damped > 0
    assert abs(put_in - damped - rubbed.sum()) < 1e-7 * put_in


def reference_holds(data, runs):
    """The NumPy reference calls a point of any laws and samples a solution."""
    results = runs.solve(data.draw(scenes())).results
    found = verify.verdict(results, 0, 8192)
    assert not found.complaints, found.complaints


def ranks(data, runs):
    """One rank, two and three have the same answer."""
    scene = data.draw(scenes())
    runs.same(runs.solve(scene).X, runs.solve(scene, ranks=data.draw(st.sampled_from([2, 3]))))


def renumbering(data, runs):
    """Degrees of freedom and contact points in another order."""
    scene = data.draw(scenes())
    order, dofs = data.draw(st.permutations(range(scene.points))), data.draw(st.permutations(range(len(scene.structure.K))))
    other = scene.changed(np.eye(len(dofs))[:, dofs], np.argsort(dofs)[scene.structure.contact_dofs[order]])
    lists = ("law", "normal_stiffness", "tangential_stiffness", "friction", "gap")
    other = other.having(**{key: [scene.settings[key][i] for i in order] for key in lists})
    runs.same(runs.solve(scene).X[order], runs.solve(other))


def units(data, runs):
    """Other units of length, mass and time."""
    scene = data.draw(scenes())
    length, mass, time = (10.0 ** data.draw(st.integers(-3, 3)) for _ in range(3))
    s, force, stiffness = scene.settings, mass * length / time**2, mass / time**2
    other = scene.with_structure(K=scene.structure.K * stiffness, M=scene.structure.M * mass, force=scene.structure.force * force,
                                 preload=scene.structure.preload * force)
    other = other.having(stiffness=s["stiffness"] * time, mass=s["mass"] / time, omega=[value / time for value in s["omega"]],
                         gap=[value * length for value in s["gap"]],
                         normal_stiffness=[value * stiffness for value in s["normal_stiffness"]],
                         tangential_stiffness=(np.array(s["tangential_stiffness"]) * stiffness).tolist())
    runs.same(runs.solve(scene).X * length, runs.solve(other))


def rotation(data, runs):
    """Other axes: any of the elastic unknowns, and of the tangents where a law has no direction of its own."""
    scene = data.draw(scenes(("cone", "unilateral", "bilateral")))
    kt = [[pair[0]] * 2 for pair in scene.settings["tangential_stiffness"]]
    scene = scene.having(tangential_stiffness=kt)
    s, n = scene.structure, len(scene.structure.K)
    elastic = np.setdiff1d(np.arange(n), s.contact_dofs)
    T = np.eye(n)
    T[np.ix_(elastic, elastic)] = np.linalg.qr(np.random.default_rng(data.draw(st.integers(0, 10**6))).normal(size=[len(elastic)] * 2))[0]
    turns = [np.eye(3) for _ in s.contact_dofs]
    for turn, dofs in zip(turns, s.contact_dofs):
        angle = data.draw(numbers(0, 2 * np.pi))
        turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        T[np.ix_(dofs, dofs)] = turn
    runs.same(np.array([turn.T @ X for turn, X in zip(turns, runs.solve(scene).X)]), runs.solve(scene.changed(T)))


def mirror(data, runs):
    """Tangents the other way round, and both in each other's place."""
    scene = data.draw(scenes())
    signs = np.array(data.draw(per_point(scene.points, st.tuples(*[st.sampled_from([-1.0, 1.0])] * 2))))
    swapped = data.draw(per_point(scene.points, st.booleans()))
    T = np.eye(len(scene.structure.K))
    for sign, dofs in zip(signs, scene.structure.contact_dofs):
        T[dofs[:2], dofs[:2]] = sign
    rows = np.array([[1, 0, 2] if swap else [0, 1, 2] for swap in swapped])
    other = scene.changed(T, np.take_along_axis(scene.structure.contact_dofs, rows, axis=1))
    other = other.having(**{key: [pair[::-1] if swap else pair for pair, swap in zip(scene.settings[key], swapped)]
                            for key in ("tangential_stiffness", "friction")})
    X = runs.solve(scene).X
    X[:, :2] *= signs[..., None]
    runs.same(np.take_along_axis(X, rows[..., None], axis=1), runs.solve(other))


def shift(data, runs):
    """A load that begins later; by whole samples where there are some. Not of cones: where one comes to rest, its way there counts."""
    scene = data.draw(scenes(WITHOUT_CONE))
    phase = 2 * np.pi * data.draw(st.integers(1, 63)) / 64
    turned = np.array(scene.settings["fourier"] + [0.0] * (1 - len(scene.settings["fourier"]) % 2))
    other = scene.having(fourier=_shifted(turned, phase).tolist())
    runs.same(_shifted(runs.solve(scene).X, phase), runs.solve(other))


def _shifted(series, phase):
    """Coefficients (..., 2H+1) of f(theta - phase)."""
    k, out = np.arange(1, series.shape[-1] // 2 + 1), series.copy()
    values = (series[..., 1::2] - 1j * series[..., 2::2]) * np.exp(-1j * k * phase)
    out[..., 1::2], out[..., 2::2] = values.real, -values.imag
    return out


def split_load(data, runs):
    """A load in one pattern or in several with the same course."""
    scene = data.draw(scenes())
    parts = data.draw(st.lists(numbers(-2, 2), min_size=1, max_size=3))
    shares = np.random.default_rng(data.draw(st.integers(0, 10**6))).normal(size=(len(parts), len(scene.structure.K)))
    shares = np.vstack([shares * np.array(parts)[:, None], scene.structure.force - np.array(parts) @ shares])
    course = scene.settings["fourier"]
    other = scene.with_structure(force=shares).having(loads={f"part{i}": course for i in range(len(shares))}, fourier=None)
    runs.same(runs.solve(scene).X, runs.solve(other))


def course(data, runs):
    """A pattern in other units and its course in theirs: to the last bit, for powers of two."""
    scene = data.draw(scenes())
    unit = 2.0 ** data.draw(st.integers(-30, 30))
    other = scene.with_structure(force=scene.structure.force / unit)
    other = other.having(fourier=[unit * number for number in scene.settings["fourier"]])
    np.testing.assert_array_equal(runs.solve(scene).X, runs.solve(other).X)


def all_modes(data, runs):
    """With all modes of Craig and Bampton, harmonics and means solve the elastic rows of the full model, eq (1)."""
    scene = data.draw(scenes())
    s = scene.structure
    scene = scene.having(modes=len(s.K) - 3 * scene.points)
    results = runs.solve(scene).results
    e, c, K, M = reference.split(s.K, s.M, s.contact_dofs)
    _, phi, psi = reference.bases(s.K, s.M, s.contact_dofs, results.modes)
    omega, q = results.omega[0], results.coefficients_at(0)
    with h5py.File(results.reduced, "r") as file:
        phi = phi * np.sign(np.sum(phi * s.force[e][:, None], axis=0)) * np.sign(file["Fa"][()].ravel())
    motion = np.zeros((len(K), q.shape[1]))
    motion[e], motion[c] = phi @ q[:results.modes] + psi @ q[results.modes:], q[results.modes:]
    course = np.zeros(q.shape[1])
    course[:len(scene.settings["fourier"])] = scene.settings["fourier"]
    C = scene.settings["stiffness"] * K + scene.settings["mass"] * M
    off = [K[e] @ motion[:, 0] - s.force[e] * course[0]]
    for k in range(1, results.harmonics + 1):
        u, load = (values[..., 2 * k - 1] - 1j * values[..., 2 * k] for values in (motion, course))
        off.append((K - (k * omega)**2 * M + 1j * k * omega * C)[e] @ u - s.force[e] * load)
    assert np.linalg.norm(np.concatenate(off)) < 1e-7 * (np.linalg.norm(s.force) + np.linalg.norm(K[e] @ motion))


def scaling(data, runs):
    """Scales chosen, none, and by hand."""
    scene = data.draw(scenes())
    frequency, modal, contact = (10.0 ** data.draw(numbers(-2, 2)) for _ in range(3))
    by_hand = scene.having(kind="manual", frequency=frequency, modal=modal, contact=contact)
    other = data.draw(st.sampled_from([scene.having(kind="none"), by_hand]))
    runs.same(runs.solve(scene).X, runs.solve(other))


def sampled(data, runs):
    """Exact forces, and those of many samples: to 1/N^2 of the coefficients that do not hang on where a slider comes to rest."""
    scene = data.draw(scenes(WITHOUT_CONE, samples=("exact",)))
    runs.same(runs.solve(scene.having(samples=FINE)).X, runs.solve(scene), 1e-3)


def harmonics(data, runs):
    """Twice the harmonics change nothing where the answer has none but those of the load."""
    scene = data.draw(scenes(LINEAR, linear=True))
    H = scene.settings["harmonics"]
    X, twice = runs.solve(scene).X, runs.solve(scene.having(harmonics=2 * H))
    runs.same(np.concatenate([X, np.zeros((*X.shape[:2], 2 * H))], axis=2), twice)
    assert np.linalg.norm(twice.X[..., 2 * H + 1:]) < 1e-8 * np.linalg.norm(X)


def refusal(data, runs):
    """Wrong input ends with status 2 and words, and the folder of an earlier run stays as it was."""
    scene = data.draw(scenes())
    folder = runs.solve(scene).results.path.parent
    rubs = {"coulomb", "cone"} & {*np.atleast_1d(scene.settings["law"])}  # else runs.case leaves friction out
    key = data.draw(st.sampled_from(sorted(key for key in WRONG if rubs or key != "friction")))
    wrong = runs.case(scene.having(**{key: data.draw(st.sampled_from(WRONG[key]))}))
    before = _contents(folder)
    command, _ = line(wrong, out=folder)
    assert key in words_of(command, 2)[1]
    assert _contents(folder) == before


def _contents(folder):
    return {path.name: (path.stat().st_mtime_ns, hashlib.sha256(path.read_bytes()).hexdigest()) for path in sorted(folder.iterdir())}


PROPERTIES = {function.__name__: function for function in (
    energy, reference_holds, ranks, renumbering, units, rotation, mirror, shift, split_load, course, all_modes, scaling, sampled,
    harmonics, refusal)}


@dataclass
class Count:
    """Of one property: examples that were judged, had no first point, had another solution; failures in words."""

    judged: int = 0
    without: int = 0
    others: int = 0
    failures: list = field(default_factory=list)


def judge(name, examples, seed, count):
    """Draws that many examples of a property and adds them to a `Count`. Raises what a failing one raises, once it is made small."""
    @settings(max_examples=examples, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @seeded(seed)
    @given(st.data())
    def judged(data):
        with Runs() as runs:
            try:
                PROPERTIES[name](data, runs)
            except UnsatisfiedAssumption:
                count.without += 1
                raise
            count.judged += 1
            count.others += runs.others
    judged()
