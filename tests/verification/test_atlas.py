"""The failure atlas: its parts on made-up numbers, and a few of its scenes by Dovetail, judged by time integration. Chaotic ones are in
test_hard_curves and test_first_points."""

import sys
from dataclasses import asdict, replace

import numpy as np
import pytest

from launch import ROOT

sys.path.insert(0, str(ROOT / "scripts/bench"))
import atlas_jumps
import atlas_map
import atlas_methods
import atlas_runs
import atlas_scenes
import atlas_table
import atlas_truth

from dovetail import reference

FIXED = ["dof5", "dof5_step_x40", "dof5_force_x10", "dof5_kn_100", "dof5_kn_100_down", "dof5_open_gap_H_25",
         "mass_1", "mass_2", "mass_2_back", "stop", "025", "119", "140", "295"]
WINDING = ["295"]  # last bits choose the path: between 240 and 800 points, by kernel


# ------------------------------------------------------------------------------------------------------- the scenes
def test_design_covers_what_it_says():
    scenes = atlas_scenes.designed()
    column = {key: np.array([getattr(scene, key) for scene in scenes]) for key in ("stiffness", "friction", "force", "damping", "points")}
    assert len(scenes) >= 300 and len({scene.name for scene in scenes}) == len(scenes)
    for key, low, high in (("stiffness", 1e-2, 1e4), ("force", 1e-2, 1e2), ("damping", 1e-4, 5e-2)):
        assert low <= column[key].min() < 1.1 * low and 0.9 * high < column[key].max() <= high
    assert column["friction"].min() == 0 and 1.98 < column["friction"].max() <= 2
    assert column["points"].min() == 1 and column["points"].max() == 50
    assert {scene.family for scene in scenes} == set(atlas_scenes.FAMILIES) and {scene.units for scene in scenes} == set(atlas_scenes.UNITS)
    assert sum(scene.gap > 0 for scene in scenes) > 30 and max(scene.press for scene in scenes) > 20
    assert 0.4 < np.mean([scene.backward for scene in scenes]) < 0.6 and any(scene.three for scene in scenes)


def test_design_is_the_same_every_time():
    assert atlas_scenes.designed() == atlas_scenes.designed()
    first, again = (atlas_scenes.build(atlas_scenes.scenes()["012"]) for _ in range(2))
    np.testing.assert_array_equal(first.structure.K, again.structure.K)
    assert (first.arc, first.omega) == (again.arc, again.omega)


def test_units_are_a_change_of_numbers_only():
    """In other units the response at corresponding frequencies is the same, times the unit of displacement."""
    scene = replace(atlas_scenes.scenes()["005"], units="1", points=1)
    found = []
    for units in ("1", "mm t s N"):
        built = atlas_scenes.build(replace(scene, units=units))
        system = atlas_methods.Plain(*atlas_methods.arguments(built, harmonics=2))
        contact = system.solve(1.4 * max(built.omega))[system.modes:]
        found.append(contact / atlas_scenes.UNITS[units][2])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-7, atol=1e-9 * np.abs(found[0]).max())


@pytest.mark.parametrize("family", ["held by its joint", "hardly held"])
def test_free_bodies_are_free(family):
    """Without contact the stiffness has as many (nearly) rigid motions as a node has directions; clamped structures have none."""
    for name, free in ((family, 3), ("two bodies", 0)):
        made = atlas_scenes.FAMILIES[name](2, np.random.default_rng(1))
        assert np.count_nonzero(atlas_scenes.structures.frequencies(made) < 1e-2) == free


def test_one_to_three_is_tuned():
    springs = np.array([0.5, 0.5, 1.0])
    made = atlas_scenes.FAMILIES["1:3"](1, np.random.default_rng(1), springs)
    first, second = atlas_scenes.structures.frequencies(made, springs)[[0, 3]]
    assert second / first == pytest.approx(3, abs=1e-4)


# ------------------------------------------------------------------------------------------------------ the methods
def test_plain_is_the_reference(rng=np.random.default_rng(3)):
    """Its faster evaluation gives the forces and the derivatives of `reference.law`, lift-off, landing and slip included."""
    reduced = reference.Reduced(np.array([2.0]), 0.1 * rng.normal(size=(1, 6)), np.eye(6), 4 * np.eye(6), np.ones(1), rng.normal(size=6),
                                np.array([0, 0, -2.0, 0, 0, -1.0]))
    contact = reference.Contact.uniform(2, [2.0, 3.0], [[1.0, 2.0], [0.5, 1.5]], [[0.3, 0.2], [0.4, 0.0]], [-0.1, 0.05])
    arguments = reduced, contact, reference.contact_preload(reduced, contact), 0.02, [0, 1, 0.5], 3, 32
    plain, slow = atlas_methods.Plain(*arguments), reference.HarmonicBalance(*arguments)
    for scale in (0.1, 1.0, 10.0):
        X = scale * rng.normal(size=(2, 3, 7))
        _, state = reference.law(np.swapaxes(reference.synthesis(X, 32), 1, 2), plain.preload.xp, plain.preload.w, contact.kn, contact.kt,
                                 contact.mu, contact.gap)
        assert scale < 1 or {reference.STICK, 1, -1, reference.OPEN} == set(state.ravel())
        np.testing.assert_allclose(plain.forces(X), reference.contact_coefficients(X, contact, plain.preload, 32), atol=1e-13 * scale)
        q = np.vstack([np.ones(7), X.reshape(6, 7)])
        np.testing.assert_allclose(plain.jacobian(q, 1.0), slow.jacobian(q, 1.0), atol=1e-12)


def test_limit_keeps_what_was_computed():
    built = atlas_scenes.build(atlas_scenes.scenes()["dof5"])
    run = atlas_methods.original(built, 0.5)
    assert run.end == "limit" and run.points > 5 and run.omega[0] == 0.9 and run.coefficients.shape == (run.points, 5, 21)


def test_what_a_curve_leaves_out():
    there, back = np.linspace(1, 2, 11), np.linspace(2, 1.4, 7)
    assert atlas_methods.left_out(there, (), (1, 2)) == atlas_methods.left_out(there, (), (2, 1)) == 0
    assert atlas_methods.left_out(there, [3, 7], (1, 2)) == pytest.approx(0.2)
    assert atlas_methods.left_out(np.concatenate([there[:4], back]), [4], (1, 2)) == pytest.approx(0.1)  # from the other end, to 1.4
    assert atlas_methods.left_out(there[4:], (), (1, 2)) == pytest.approx(0.4)
    assert atlas_methods.left_out(np.concatenate([there, back, there[4:]]), [11], (1, 2)) == 0
    assert atlas_methods.left_out(np.array([]), (), (1, 2)) == 1


# ---------------------------------------------------------------------------------------------------- silent jumps
def arcs(step, radius=1.0, gap=0.3):
    """Two quarter circles about each other's side: points on the first, then on the second, as if a step had gone from one to the other."""
    angle = np.arange(0, np.pi / 2, step)
    first = radius * np.column_stack([np.sin(angle), np.cos(angle)])
    return first, (radius + gap) * np.column_stack([np.sin(angle), np.cos(angle)])


def curve_of(points):
    """Points in a plane as a curve: frequency, and one modal and three contact coefficients."""
    q = np.zeros((len(points), 4, 1))
    q[:, 1, 0] = points[:, 1]
    return points[:, 0], q


def judged(points, truth, announced=()):
    omega, q = curve_of(points)
    return atlas_jumps.silent_jumps(omega, q, 1, 1.0, announced, lambda i, n: map(curve_of, truth))


def test_places_stored_twice_hide_no_jump_and_make_none():
    inner, outer = arcs(0.1)
    fine = arcs(0.002)[0]
    jumped = np.concatenate([inner[:8], inner[7:8], outer[8:9], outer[8:]])
    assert judged(jumped, [fine]) == ([7], [])
    line = np.column_stack([np.linspace(0, 1, 11)] * 2)
    nowhere = [line * [1, -1]]  # would say nothing, and leave a suspect step in doubt
    assert judged(np.repeat(line, [1, 1, 1, 1, 2, 2, 1, 1, 1, 1, 1], axis=0), nowhere) == ([], [])


@pytest.mark.parametrize("gap", [0.05, 0.3, -0.3])
def test_a_jump_to_a_curve_alongside_is_found(gap):
    inner, outer = arcs(0.1, gap=gap)
    jumped = np.concatenate([inner[:8], outer[8:]])
    fine = arcs(0.002, gap=gap)[0]
    if abs(gap) < 0.1:  # less than a step aside: not seen, and not called a jump
        assert judged(jumped, [fine]) == ([], [])
    else:
        assert judged(jumped, [fine]) == ([7], [])
        assert judged(jumped, [fine], announced=(8,)) == ([], [])
        assert judged(jumped, [fine[:10]]) == ([], [7])  # not followed that far: in doubt


def test_one_curve_that_comes_by_clears_a_step():
    """One that turned off elsewhere before does not condemn it."""
    inner, outer = arcs(0.1, gap=0.3)
    bridged = np.concatenate([inner[:8], np.linspace(inner[7], outer[8], 50), outer[8:]])
    assert judged(np.concatenate([inner[:8], outer[8:]]), [arcs(0.002)[0], bridged]) == ([], [])


def test_a_loop_cut_off_is_a_jump():
    leg = np.linspace(0, 1, 11)[:, None] * [1, 0]
    around = 0.3 * np.column_stack([np.sin(np.linspace(0, 2 * np.pi, 100)), np.cos(np.linspace(0, 2 * np.pi, 100)) - 1])
    bump = np.concatenate([leg, leg[-1] + [0.1, 0.3] + leg])
    assert judged(bump, [np.concatenate([leg, leg[-1] + around, bump[11:]])]) == ([10], [])
    assert judged(bump, [bump]) == ([], [])


def test_places_within_steps_do_not_make_the_next_one_long():
    points = np.column_stack([[0, 1, 2, 2.98, 3, 4, 4.3, 5, 6], np.zeros(9)])  # 2.98 and 4.3 were located
    omega, q = curve_of(points)
    assert atlas_jumps.silent_jumps(omega, q, 1, 1.0, (), lambda i, n: iter(())) == ([], [4])
    assert atlas_jumps.silent_jumps(omega, q, 1, 1.0, (), lambda i, n: iter(()), places=[3, 6]) == ([], [])


def test_corners_hairpins_and_uneven_steps_are_no_jumps():
    leg = np.linspace(0, 1, 11)[:, None]
    for turn in (np.pi / 2, 0.9 * np.pi, np.pi - 1e-3):
        there = leg * [1, 0.2]
        back = there[-1] + leg[1:] * [np.cos(turn), np.sin(turn)]
        bent = np.concatenate([there, back])
        assert judged(bent, [bent]) == ([], [])
    uneven = np.column_stack([np.cumsum([0, 1, 1, 9, 1, 1, 0.1, 0.1, 1]), np.zeros(9)])
    assert judged(uneven, [np.column_stack([np.linspace(0, 15, 500), np.zeros(500)])]) == ([], [])


# -------------------------------------------------------------------------------------------------------- the table
def row(name, end, jumps=(), settled=True, stays=True, error=1e-5, **scene):
    part = {"end": end, "jumps": list(jumps), "points": 10, "newton": 30, "seconds": 1.0, "said": "why", "reached": 0.5}
    scene = {**asdict(atlas_scenes.scenes()["dof5"]), "name": name, **scene}
    truth = {"places": [{"settled": settled, "stays": stays, "error": error}]}
    return {"scene": scene, "original": {**part, "end": "stopped", "jumps": []}, "plain": None, "dovetail": part, "truth": truth}


def test_table_counts():
    rows = [row("a", "arrived"), row("b", "arrived", jumps=[3]), row("c", "no start"), row("d", "limit", settled=False),
            row("e", "arrived", error=0.05)]
    made = atlas_table.figures(rows)
    assert made["dovetail"]["ends"] == {"arrived": 3, "no start": 1, "limit": 1} and made["dovetail"]["with_silent_jumps"] == 1
    assert made["dovetail"]["counted"] == 4 and made["dovetail"]["finished"] == pytest.approx(2 / 4)
    assert made["original"]["finished"] == 0 and made["plain"]["scenes"] == 0
    assert made["errors"] == {"scenes": 2, "within": {"0.0001": 1, "0.001": 1, "0.01": 1}}
    text = "\n".join(atlas_table.lines(rows))
    assert "not finished by Dovetail: 3" in text and "nothing periodic" in text
    assert made["branch_ends"] == 0 and "branch ends" not in text


def test_where_nothing_is_periodic_beyond_the_branch_ends():
    nothing, time = {"settled": False, "why": "no period settled"}, {"settled": False, "why": "not within 60 s"}
    for tried, ends in (([nothing, nothing], True), ([nothing, time], False), ([nothing, {"settled": True, "why": ""}], False)):
        made = row("a", "stopped")
        made["truth"]["beyond"] = tried
        assert atlas_table.branch_ends(made) == ends and ("branch ends" in "\n".join(atlas_table.lines([made]))) == ends


def test_map_is_drawn(tmp_path):
    rows = [row(str(i), end, stiffness=10.0 ** i, gap=float(i == 2), press=float(i != 2)) for i, end in enumerate(atlas_table.ENDS)]
    atlas_map.draw(rows, tmp_path / "map.png")
    assert (tmp_path / "map.png").read_bytes()[:4] == b"\x89PNG"


# --------------------------------------------------------------------------------------------------- the fixed part
@pytest.fixture(scope="module")
def fixed(tmp_path_factory):
    if not atlas_truth.PROGRAM.exists():
        pytest.skip(f"{atlas_truth.PROGRAM} is not built")
    folder, scenes = tmp_path_factory.mktemp("atlas"), atlas_scenes.scenes()
    program = {part: "" for part in (*atlas_methods.METHODS, "truth")}
    return {name: atlas_runs.run_scene(scenes[name], folder / name, program, ("dovetail", "truth")) for name in FIXED}


@pytest.mark.slow
@pytest.mark.parametrize("name", FIXED)
def test_scene(fixed, name):
    """Dovetail arrives without a silent jump, and integration that settles and stays on the branch agrees to 1 %.

    Of a curve that winds, stable motions alone: the others lie wherever the path chanced to pass, some beside sharp bends.
    """
    run, places = fixed[name]["dovetail"], fixed[name]["truth"]["places"]
    assert run["end"] == "arrived", run["said"]
    assert run["jumps"] == [] and run["reached"] == 1
    errors = [place["error"] for place in places if place.get("stays") and (name not in WINDING or place["multiplier"] < 1)]
    assert max(errors, default=0) < 0.01
    assert len(places) == atlas_truth.PLACES


@pytest.mark.slow
def test_most_places_of_the_fixed_part_count(fixed):
    places = [place for scene in fixed.values() for place in scene["truth"]["places"]]
    assert sum(place.get("stays", False) for place in places) >= 0.8 * len(places)
