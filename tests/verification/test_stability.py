"""Stability as the program judges it, against time integration: multipliers of the map over one period, and what becomes of a
motion that is pushed.

Points lie on both sides of every change of stability: turning points of a mass that lifts off (with and without friction),
period doubling of a mass against a stop; and in slip and in separation where nothing changes. In all of them the judged
motion is that of harmonic balance, the true one is found by shooting from there.
"""

import json
from dataclasses import dataclass

import numpy as np
import pytest

import cases
from dovetail import Results, reference
from launch import BINARY, run, words_of
from poincare import Orbit

STABLE, UNSTABLE, UNCERTAIN = 1, 0, -1
NO_KIND, JUMP, PERIOD_DOUBLING, SECOND_FREQUENCY = range(4)
POINTS = 6  # per branch at least, hence more than 30 in all
WIDER = 1e-4  # differences, to see whether the derivative is about to change
PUSHES = 1e-5, 1e-6  # of the size of the motion: the larger may change the order of contact states, rounding may hide the smaller


def stop(folder, **overrides):
    """A mass on a spring against an elastic stop without friction: a bilinear oscillator, without a model of its own in `cases`."""
    static = overrides.pop("static")
    reduced = reference.Reduced(kaa=np.ones(1), max=np.zeros((1, 3)), mxx=np.eye(3), kxx=np.eye(3), fa=np.zeros(1),
                                fx=np.array([0, 0, 1.0]), r=np.array([0, 0, static]))
    cases.write_reduced(folder, reduced)
    case = cases.write(folder, "mass and stop", "reduced.h5", None, reduced, overrides, stiffness=0.02, fourier=[0, 1],
                       normal_stiffness=8.0, gap=0.0, law="unilateral", initial=0.0, harmonics=20, samples="exact", step=0.05,
                       kind="none", **cases.TIGHT)
    case.settings.update(tangential_stiffness=1e-9, friction=1e9, fourier=[0, 1, 0])  # the integration knows friction only
    return case


def loose(folder, **overrides):
    """The five-dof example without preload, its contact open at rest by 0.2: it opens and slips in every period."""
    structure = cases.Structure(K=20 * np.eye(5) - 10 * np.eye(5, k=1) - 10 * np.eye(5, k=-1), M=np.eye(5),
                                contact_dofs=np.array([[2, 3, 4]]), force=np.array([1.0, 1, 0, 0, 0]), preload=np.zeros(5))
    structure.K[0, 0] = 10
    return cases.full(folder, "no preload", structure, overrides, modes=2, stiffness=0.05, fourier=[0, 0, 1, 0, 0],
                      normal_stiffness=100.0, tangential_stiffness=50.0, friction=0.3, gap=0.2, initial=0.0, harmonics=25,
                      samples="exact", step=0.05, **cases.TIGHT)


@dataclass
class Branch:
    """How to get it, steps per period for its integration, how its changes of stability are called, relative accuracy."""

    make: callable
    steps: int
    changes: list
    accuracy: float = 5e-4


def settings(make, **more):
    return lambda folder: make(folder, samples="exact", **more)


BRANCHES = {
    "slip": Branch(settings(cases.dof5, omega=[0.98, 1.14]), 64, [], 1e-4),
    "lift-off": Branch(settings(lambda folder, **o: cases.single_mass(folder, 1, **o), omega=[9, 13]), 48, 2 * [JUMP]),
    "lift-off with friction": Branch(settings(lambda folder, **o: cases.single_mass(folder, 2, harmonics=20, **o), omega=[9, 13]), 48,
                                     2 * [JUMP], 1e-4),  # with 10, 1e-3 off right beside a turning point, which lies elsewhere then
    "lift-off and slip": Branch(settings(loose, omega=[1.25, 0.85]), 192, [], 5e-3),
    "period doubling": Branch(settings(stop, static=-0.5, omega=[5, 3]), 48, 2 * [PERIOD_DOUBLING]),
    "resonance of a stop": Branch(settings(stop, static=1.0, harmonics=40, omega=[1.55, 1.35]), 48, 2 * [JUMP]),  # 20: too few, likewise
}


class Judged:
    """A branch, its points in slip or separation, and what is said of them."""

    def __init__(self, folder, branch):
        self.branch, self.case = branch, branch.make(folder)
        done = run(self.case)
        self.results = Results(done.folder / "results.h5")
        words, _ = words_of([BINARY.parent / "tests/unit/judge_points", str(self.case.path), str(self.results.path)])
        self.verdicts = [json.loads(line) for line in words.splitlines() if line.startswith("{")]
        assert len(self.verdicts) == len(self.results)
        self.stable = np.array([v["stable"] for v in self.verdicts])
        self.moves = self.results.points("slip") + self.results.points("open") > 0

    def changes(self):
        """Numbers (i, j) of points with different verdicts that follow each other but for uncertain ones."""
        certain = np.flatnonzero(self.stable != UNCERTAIN)
        return [(i, j) for i, j in zip(certain, certain[1:]) if self.stable[i] != self.stable[j]]

    def chosen(self):
        """Points beside every change, two steps away from it, and others in between: POINTS of them that slip or open."""
        points = {k for i, j in self.changes() for k in (i - 2, i, j, j + 2)}
        active = np.flatnonzero(self.moves & (self.stable != UNCERTAIN))
        points |= set(active[np.linspace(0, len(active) - 1, max(2, POINTS - len(points) // 2) + 2).astype(int)[1:-1]])
        return sorted(points & set(active))

    def orbit(self, i):
        return Orbit(self.case, self.results.omega[i], self.results.coefficients[i], self.branch.steps)


@pytest.fixture(scope="module", params=BRANCHES)
def judged(request, tmp_path_factory):
    return Judged(tmp_path_factory.mktemp("stability"), BRANCHES[request.param])


def test_changes_and_their_kinds(judged):
    """Stability changes where it should and nowhere else, is uncertain next to these changes only, and the kind is named."""
    changes = judged.changes()
    assert len(changes) == len(judged.branch.changes)
    for (i, j), kind in zip(changes, judged.branch.changes):
        assert j - i <= 3
        assert judged.verdicts[i if judged.stable[i] == UNSTABLE else j]["kind"] == kind
    near = {k for i, j in changes for k in range(i, j + 1)}
    assert set(np.flatnonzero(judged.stable == UNCERTAIN)) <= near
    for v in judged.verdicts:
        assert (v["kind"] == NO_KIND) == (v["stable"] == STABLE) or v["stable"] == UNCERTAIN
        assert np.log(v["multiplier"]) / (2 * np.pi) == pytest.approx(v["growth"], abs=1e-9)


@pytest.mark.slow
def test_multipliers_and_pushes(judged):
    """The largest multiplier as by differences of the integrated map; a motion pushed along it returns or leaves as fast."""
    points = judged.chosen()
    assert len(points) >= POINTS - 1
    compared = 0
    for i in points:
        orbit, v = judged.orbit(i), judged.verdicts[i]
        y = orbit.close()
        multipliers, vectors = np.linalg.eig(orbit.derivative(y))
        multipliers[np.abs(multipliers - 1) < 1e-7] = 0  # sliders at rest where the motion just does not reach them
        largest = np.abs(multipliers).max()
        wider = np.linalg.eigvals(orbit.derivative(y, WIDER)) - multipliers[np.argmax(np.abs(multipliers))]
        if np.abs(wider).min() > judged.branch.accuracy * largest:
            continue  # a slider all but slips, and the multiplier jumps; the orbit may be on the other side than the branch
        compared += 1
        assert v["multiplier"] == pytest.approx(largest, rel=judged.branch.accuracy), (i, v)
        assert v["stable"] == (STABLE if largest < 1 else UNSTABLE), (i, v)

        # Of those that move the contact: in the single-mass checks a mode without coupling is the slowest to come to rest.
        contact = np.abs(vectors[orbit.modes:orbit.n]).max(axis=0) > 1e-6 * np.abs(vectors[:orbit.n]).max(axis=0)
        lead = np.argmax(np.where(contact, np.abs(multipliers), 0))
        rate = np.abs(multipliers[lead])
        periods = min(40, int(np.ceil(2 / abs(np.log(rate)))))
        along = vectors[:, lead].real / np.linalg.norm(vectors[:, lead].real / orbit.unit)
        expected = np.linalg.norm((multipliers[lead] ** periods * vectors[:, lead]).real / orbit.unit)
        expected /= np.linalg.norm(vectors[:, lead].real / orbit.unit)
        left = [orbit.distance(orbit.map(y + along * push, periods), y) / push for push in PUSHES]
        assert pytest.approx(expected, rel=0.15, abs=0.02) in left, (i, v, left)
    assert compared >= POINTS - 2
