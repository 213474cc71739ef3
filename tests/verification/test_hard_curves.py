"""Curves through stiff contacts that open. They are chaotic: last bits decide which way one takes, and how far it gets. So what is
tested holds on any way: of whatever is there after some seconds of the processor's time."""

import sys
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from launch import ROOT, in_parts
from residuals import residuals

sys.path.insert(0, str(ROOT / "scripts/bench"))
import atlas_jumps
import atlas_methods
import atlas_runs
import atlas_scenes

from dovetail import Results

pytestmark = pytest.mark.slow
SCENES = ["062", "067", "160", "198", "223", "275", "288"]
SECONDS, POINTS = 6, 600  # of each curve
AHEAD = ("leap", "integration")
FRESH = (*AHEAD, "outside", "harmonics")  # events behind which another piece begins
FINER = 4  # times shorter steps
COMPARED = 2  # steps of each curve
NOTICED = 32  # points


@dataclass
class Curve:
    """A curve as far as it was followed, and what it was made of."""

    case: Path
    built: atlas_scenes.Built
    run: atlas_methods.Run
    results: Results
    summary: dict

    def __post_init__(self):
        r = self.results
        self.width = abs(self.built.omega[1] - self.built.omega[0])
        self.ends = np.flatnonzero(r.points("located") == 0)  # of steps: other points were found within one
        self.harmonics = r.points("harmonics")
        self.z = atlas_jumps.coordinates(r.omega, r.coefficients, self.built.modes, self.width)
        self.pieces = np.split(np.arange(len(r.omega)), sorted(set(r.events.of(*FRESH).point + 1)))

    def events(self, *kinds):
        return self.results.events.of(*kinds)


def followed(name, folder, points=POINTS, seconds=SECONDS):
    """The curve of a scene, until the end of its sweep or one of the limits."""
    folder.mkdir()
    built = atlas_scenes.build(atlas_scenes.scenes()[name])
    case = atlas_scenes.write(built, folder)
    text = case.read_text()
    case.write_text(text + f"max_points = {points}\n")
    run, about = atlas_methods.dovetail(case, built.omega, folder, seconds)
    case.write_text(text)
    return Curve(case, built, run, Results(folder / "results.h5"), about)


@pytest.fixture(scope="module")
def curves(tmp_path_factory):
    folder = tmp_path_factory.mktemp("curves")
    return {name: followed(name, folder / name) for name in SCENES}


def test_they_are_hard(curves):
    """Else the other tests say little: there are corners, turning points, and what helps where a curve is lost."""
    met = Counter(kind for curve in curves.values() for kind in curve.results.events.kind)
    assert met["corner"] > 20 and met["fold"] > 10 and met["peak"] > 10, met
    assert met["harmonics"] > 0 and met["leap"] + met["integration"] > 0, met


def test_stored_points_solve_the_equations(curves):
    """Some with every number of harmonics, ends of steps and places within."""
    for name, curve in curves.items():
        for H in set(curve.harmonics):
            points = np.flatnonzero(curve.harmonics == H)
            some = points[np.linspace(0, len(points) - 1, min(len(points), 12)).astype(int)]
            missed = residuals(curve.built, curve.results.omega[some], curve.results.coefficients[some][:, :, :2 * H + 1])
            assert missed.max() < 1e-4, (name, H, missed)


def test_no_piece_is_passed_twice(curves):
    """A step that leads back, at a corner or elsewhere, puts those that follow on older pieces of the curve. That is noticed after some of
    them, before there is no point left to go back to."""
    for name, curve in curves.items():
        for piece in curve.pieces:
            z = curve.z[np.intersect1d(piece, curve.ends)]
            steps = np.linalg.norm(np.diff(z, axis=0), axis=1)
            on_older = [atlas_jumps.passed(z[:i - 1], z[i])[0].min() < 0.05 * steps[i - 1] for i in range(3, len(z))]
            longest = max(map(len, "".join("x" if one else " " for one in on_older).split()), default=0)
            assert longest <= NOTICED, (name, piece[0], piece[-1])


def test_no_step_leads_elsewhere_without_a_word(curves):
    """Steps that look like it are followed again, in short ones."""
    for name, curve in curves.items():
        follow = atlas_runs.follower(atlas_methods.DOVETAIL, curve.built, curve.case.parent, curve.run, SECONDS)
        jumps, _ = atlas_jumps.silent_jumps(curve.run.omega, curve.run.coefficients, curve.built.modes, curve.width, curve.run.announced,
                                            follow, True, curve.summary["places"])
        assert jumps == [], name


def test_the_frequency_turns_at_turning_points(curves):
    """And there only: none within a step is missed, also where there are two. A peak at the same place is a point of its own."""
    for name, curve in curves.items():
        omega, same = curve.results.omega, 1e-8 * curve.width
        for piece in curve.pieces:
            kept = piece[np.append(True, np.abs(np.diff(omega[piece])) > same)]
            sense = np.sign(np.diff(omega[kept]))
            turns = kept[1:-1][sense[1:] != sense[:-1]]
            folds = [p for p in curve.events("fold").point if kept[0] < p < kept[-1]]
            for one, others in ((turns, folds), (folds, turns)):
                for p in one:
                    near = [q for q in others if abs(p - q) <= 2 and abs(omega[p] - omega[q]) <= 2 * same]
                    assert near, (name, p, turns, folds)


def finer(curve, begin, end):
    """The results of a run from one end of a step past the next one, in steps FINER times shorter at least; None where the curve is not
    smooth, or no motion is found at the first frequency alone."""
    omega, folder = curve.results.omega, curve.case.parent / "finer"
    folder.mkdir(exist_ok=True)
    sense = np.sign(omega[begin + 1] - omega[begin])
    last = omega[begin] + sense * min(curve.width, omega[begin] / 2)
    points = 6 * FINER  # more than FINER: the measure of arc length is another one
    step = np.ptp(curve.results.points("arclength")[begin:end + 1]) / points
    case = atlas_scenes.write(replace(curve.built, omega=(float(omega[begin]), float(last)), harmonics=int(curve.harmonics[begin]),
                                      step=float(step)), folder)
    case.write_text(case.read_text() + f'start = "start.h5"\nadaptive = false\nmax_points = {2 * points}\n')
    atlas_runs.only(curve.case.parent / "results.h5", begin, folder / "start.h5")
    run, _ = atlas_methods.dovetail(case, (omega[begin], last), folder, SECONDS / 3)
    if run.points < FINER:
        return None
    both = atlas_jumps.joined(curve.results.coefficients, run.coefficients)
    z = atlas_jumps.coordinates(np.r_[omega, run.omega], both, curve.built.modes, curve.width)
    way = np.linalg.norm(np.diff(z[begin:end + 1], axis=0), axis=1).sum()
    distance, _ = atlas_jumps.passed(z[len(omega):], z[end])
    chords = np.diff(z[len(omega):], axis=0)[:np.argmin(distance) + 1]
    length = np.linalg.norm(chords, axis=1)
    smooth = np.all(np.sum(chords[1:] * chords[:-1], axis=1) > 0.7 * length[1:] * length[:-1])
    there = max(length.max(), distance.min()) < way / FINER
    return Results(folder / "results.h5") if smooth and there else None


def test_places_agree_with_a_finer_run(curves):
    """Turning points and peaks on smooth pieces are where shorter steps find them."""
    compared = 0
    for name, curve in curves.items():
        places = curve.events("fold", "peak")
        after = np.searchsorted(curve.ends, places.point)
        steps = Counter((curve.ends[i - 1], curve.ends[i]) for i in after if 0 < i < len(curve.ends))
        fresh = set(curve.events(*FRESH, "corner").point)
        for begin, end in [step for step, _ in steps.most_common() if not fresh & set(range(*step))][:COMPARED]:
            if compared >= len(curves):
                break
            again = finer(curve, begin, end)
            for kind in ("fold", "peak") if again else ():
                true = again.events.of(kind).omega
                here = places.omega[(places.kind == kind) & (places.point > begin) & (places.point < end)]
                here = here[(here - again.omega[0]) * (again.omega[-1] - again.omega[0]) > 0]  # before its beginning a run tells nothing
                off = [np.abs(true - omega).min(initial=np.inf) for omega in here]
                assert max(off, default=0) < 1e-8 * curve.width, (name, kind, here, true)
                compared += len(here)
    assert compared >= len(curves) / 2


def test_a_run_in_parts_is_the_same(curves):
    """Stopped right before and after what may happen on the way, at ends of steps."""
    for kinds in (AHEAD, ("harmonics",), ("corner",)):
        name = max(curves, key=lambda name: len(curves[name].events(*kinds)))
        curve = curves[name]
        if len(curve.events(*kinds)) == 0:
            continue  # no such thing on this processor
        stops = sorted({int(p) + 1 for at in curve.events(*kinds).point[:2] for p in curve.ends[curve.ends >= at][:2]})
        most = min(len(curve.results.omega), stops[-1] + 20)
        parts = in_parts(curve.case, [points for points in stops if points < most], most)
        whole, n = curve.results, len(parts.omega)  # one more than `most` where a place lies in a corner
        assert most <= n <= most + 1
        np.testing.assert_allclose(parts.omega, whole.omega[:n], rtol=1e-10, err_msg=name)
        np.testing.assert_allclose(parts.coefficients, whole.coefficients[:n, :, :parts.coefficients.shape[2]], rtol=0,
                                   atol=1e-8 * np.abs(parts.coefficients).max(), err_msg=name)
        np.testing.assert_array_equal(np.isnan(parts.error), np.isnan(whole.error[:n]), err_msg=name)


def test_harmonics_that_were_added_go_again(curves):
    """Down to the case's, never fewer; and not where the estimated error is above 0.1 then."""
    errors = []
    for name, curve in curves.items():
        assert curve.harmonics.min() >= curve.built.harmonics
        fewer = np.flatnonzero(np.diff(curve.harmonics) < 0) + 1
        errors.extend(curve.results.points("error_harmonics")[fewer])
    assert len(errors) > 0 and np.nanmax(errors) < 0.1


def test_where_estimates_would_cost_too_much(tmp_path):
    """Stiff contacts: some points have none, but all places that are located, and others all along the curve; the same ones where the run
    is done in parts, for it is not forgotten what estimates took."""
    curve = followed("268", tmp_path / "268", points=120, seconds=10)
    known, n = ~np.isnan(curve.results.error), len(curve.results.omega)
    located = curve.events("peak", "fold").point
    assert n == 120 and len(located) > 5 and known[located].all() and not known[curve.ends].all()
    assert all(known[part].any() for part in np.array_split(curve.ends, 10))
    without = curve.ends[(curve.ends > 20) & ~known[curve.ends]]
    parts = in_parts(curve.case, [int(without[0]) + 1, int(without[len(without) // 2]) + 1], n)
    np.testing.assert_array_equal(np.isnan(parts.error), ~known)
