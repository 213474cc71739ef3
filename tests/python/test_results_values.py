"""What Results makes of each value of a file: names, units, points, what is optional, and what is there by default."""

import re

import h5py
import numpy as np
import pytest
import synthetic_results
from test_results import CONTACT, TWO, one_point

from dovetail import Results, hdf5_read, motion
from dovetail import results as module


@pytest.fixture(autouse=True)
def without_pauses(monkeypatch):
    monkeypatch.setattr(hdf5_read, "READ_PAUSE", 0)


def changed(path, change, **attributes):
    """The results file at a path, with a change: a function of the open file."""
    with h5py.File(path, "r+") as file:
        change(file)
        file.attrs.update(attributes)
    return Results(path)


def plain(path, n=3, **more):
    """Points at 1, 2, ...; a1 moves by 10, x1.t2 by its number from zero."""
    coefficients = np.zeros((n, 4, 3))
    coefficients[:, 0, 1], coefficients[:, 2, 2] = 10.0, np.arange(n)
    return synthetic_results.write(path, np.arange(1.0, n + 1), coefficients, 1, CONTACT, **more)


def test_words_of_the_header(tmp_path):
    results = Results(plain(tmp_path / "r.h5", title="T", watch="x1.n", units="t, mm, s, N", reduced="sub/reduced.h5"))
    assert (results.title, results.case, results.units) == ("T", "title = 'x'", "t, mm, s, N")
    assert results.watch == results.watched == "x1.n"
    assert results.reduced == tmp_path / "sub" / "reduced.h5" and results.path == tmp_path / "r.h5" and results.model is None
    assert (results.parameter_name, results.parameter_unit, results.reduced_fingerprint) == ("", "", "")
    assert [results.unit_of(dof) for dof in ("a1", 0, "x1.t1", 3)] == ["mm √t", "mm √t", "mm", "mm"]
    assert results.along_unit == "rad/s" and results.place(1.5) == "1.5 rad/s" and results.place(1 / 3, 3) == "0.333 rad/s"

    def without(file):
        for name in ("version", "units", "watch", "title", "reduced"):
            del file.attrs[name]

    bare = changed(results.path, without, reduced_fingerprint="ff")
    assert (bare.units, bare.watch, bare.title, bare.reduced, bare.reduced_fingerprint) == ("SI", "", "", None, "ff")
    assert bare.unit_of("x1.n") == "m" and bare.wave is None and bare.sensitivity is None
    np.testing.assert_array_equal(bare.frequency, bare.omega / (2 * np.pi))
    np.testing.assert_allclose(changed(bare.path, len, units="kg, mm, ms").frequency, 1e3 * bare.omega / (2 * np.pi), rtol=1e-15)


@pytest.mark.parametrize("attributes, message", [
    ({"version": 2}, "version 2 of the results format; this package reads version 1"),
    ({"version": 0}, "version 0 of the results format"),
    ({"format": "dovetail-model"}, "format must be dovetail-results, found dovetail-model"),
    ({"samples": -1}, "attribute samples must be one whole number"), ({"contact_points": 2}, "wanted shape")])
def test_wrong_headers_are_refused(tmp_path, attributes, message):
    with pytest.raises(ValueError, match=f"r.h5: .*{message}"):
        changed(plain(tmp_path / "r.h5"), len, **attributes)


def test_a_file_without_a_format_is_refused(tmp_path):
    with pytest.raises(ValueError, match="format must be dovetail-results, found unnamed"):
        changed(plain(tmp_path / "r.h5"), lambda file: file.attrs.__delitem__("format"))


@pytest.mark.parametrize("name", [
    *(f"points/{name}" for name in ("omega", "arclength", "newton_iterations", "seconds", "stick", "slip", "open")),
    *(f"contact/{name}" for name in CONTACT), *(f"preload/{name}" for name in ("xp", "g", "w"))])
def test_what_every_file_has(tmp_path, name):
    path = plain(tmp_path / "r.h5")
    with pytest.raises(ValueError, match=f"r.h5: not a readable results file: /{name} is missing"):
        changed(path, lambda file: file.__delitem__(name))
    with pytest.raises(ValueError, match=f"r.h5: /{name}: wanted shape"):
        changed(path, lambda file: file.create_dataset(name, data=np.ones((3, 3, 3, 3))))


def test_places_are_finite(tmp_path):
    with pytest.raises(ValueError, match="/points/arclength is not finite everywhere"):
        Results(plain(tmp_path / "r.h5", arclength=[0, np.inf, 1]))
    with pytest.raises(ValueError, match="/points/omega is not finite everywhere"):
        one_point(tmp_path / "r.h5", np.ones((2, 4, 3)), omega=[1.0, np.nan])


def test_what_a_run_may_have_stored(tmp_path):
    path = plain(tmp_path / "r.h5")
    without = Results(path)
    for name in ("stable", "multiplier", "instability", "error", "parameter", "tracked_amplitude", *module.OF_MODES):
        assert getattr(without, name) is None, name
    values = {name: np.arange(4.0) + i for i, name in enumerate((*module.OF_MODES, "tracked_amplitude", "multiplier"))}
    values |= {"error_harmonics": [1.0, 2, 3], "error_sampling": [10.0, 20, 30], "stable": [1, 0, -1, 1], "instability": [0, 1, 2, 3]}
    results = Results(plain(path, **values))
    for name in (*module.OF_MODES, "tracked_amplitude", "multiplier", "stable", "instability"):
        assert getattr(results, name).tolist() == list(values[name][:3]), name
    assert results.stable.dtype == results.instability.dtype == np.int64
    assert results.stable.tolist() == [module.STABLE, module.UNSTABLE, module.UNCERTAIN]
    assert results.error.tolist() == [11, 22, 33] and results.parameter is results.modal_amplitude and results.along is results.parameter
    results = Results(plain(path, **values, error_modes=[100.0, 200, 300], parameter=[5.0, 6, 7]))
    assert results.error.tolist() == [111, 222, 333] and results.along.tolist() == [5, 6, 7] and results.at(6.4) == 1
    assert Results(plain(path, error_harmonics=[1.0, 2, 3])).error.tolist() == [1, 2, 3]
    with pytest.raises(ValueError, match="/points/stable: wanted whole numbers"):
        Results(plain(path, **values | {"stable": [1.0, 1.0, 1.0]}))


def test_points_have_numbers_from_either_end(tmp_path):
    results = Results(plain(tmp_path / "r.h5"))
    assert [results.number(point) for point in (0, 2, -1, -3)] == [0, 2, 2, 0]
    for point in (3, -4, 1.0, np.nan, "1", [1], True):
        with pytest.raises(ValueError, match=re.escape(f"point must be a whole number from -3 to 2, found {point!r}")):
            results.number(point)
    assert [results.at(value) for value in (-5, 1.4, np.float32(2.6), np.array(9))] == [0, 0, 2, 2]
    for value in (np.nan, np.inf, -np.inf, "1", None, [1.0], np.ones((3, 1)), 1j):
        with pytest.raises(ValueError, match=re.escape(f"value must be one finite number, found {value!r}")):
            results.at(value)
    t, x = results.time_history(-1, "x1.t2")
    assert t.size == x.size == 256 and t[1] == pytest.approx(2 * np.pi / 3 / 256) and x.max() == pytest.approx(2.0)
    np.testing.assert_array_equal(results.coefficients_at(-1), results.coefficients[2])
    np.testing.assert_allclose(results.motion(2, 4)[:, 2], [0, 2, 0, -2], atol=1e-15)
    np.testing.assert_allclose(results.motion(2, times=[np.pi / 6])[:, 2], [2.0], atol=1e-15)


@pytest.mark.parametrize("call, words", [
    *[(lambda r, name=name: getattr(r, name)(["a1", "x1.n"]), "one unknown or node is wanted, found ['a1', 'x1.n']; response() takes")
      for name in ("amplitude", "curve", "peaks", "peak", "peak_point", "largest_point", "ends")],
    (lambda r: r.curve("a1", 2.5), "n must be a whole number from 1 on, found 2.5"),
    (lambda r: r.harmonic("a1", 0.5), "harmonic must be a whole number from 0 to 1, found 0.5"),
    (lambda r: r.time_history(0, "a1", 0), "n must be a whole number from 1 on, found 0"),
    (lambda r: r.time_history(0.0, "a1"), "point must be a whole number from -3 to 2, found 0.0"),
    (lambda r: r.motion(0, times=[0.0, np.nan]), "times must be a list of finite numbers, found [0.0, nan]"),
    (lambda r: r.motion(0, times=[[0.0, 1.0]]), "times must be a list of finite numbers, found [[0.0, 1.0]]"),
    (lambda r: r.unknowns(0, [0.5]), "dofs must be a list of whole numbers from 0 on, found [0.5]"),
    (lambda r: r.unknowns(0, [[0, 1]]), "dofs must be a list of whole numbers from 0 on, found [[0, 1]]"),
    (lambda r: r.dissipated(0, 1.5), "contact point must be a whole number from 1 to"),
    (lambda r: r.hysteresis(0, 1, n=-4), "n must be a whole number from 1 on, found -4"),
    (lambda r: r.contact_force(0, 1, n=0), "n must be a whole number from 1 on, found 0")])
def test_numbers_that_cannot_be_meant_are_refused(tmp_path, call, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        call(Results(plain(tmp_path / "r.h5")))


def test_what_is_watched_by_default(tmp_path):
    """Not the mode that moves more; of peaks, the unknown of the largest."""
    path = tmp_path / "r.h5"
    assert Results(plain(path)).watched == "x1.t2"
    peaks = [("peak", 0, 1.0, 3.0, 1), ("peak", 1, 2.0, 1.0, 3), ("peak", 2, 3.0, 9.0, -1)]  # the last is of a node
    assert Results(plain(path, events=peaks)).watched == "x1.t1"
    assert Results(plain(path, events=[("peak", 0, 1.0, 9.0, -1), ("peak", 1, 2.0, 0.0, 1)])).watched == "x1.t1"
    assert Results(plain(path, events=[("peak", 0, 1.0, 9.0, 0), ("peak", 1, 2.0, 5.0, 1)])).watched == "a1"
    assert Results(plain(path, events=[("peak", 0, 1.0, 9.0, 0)])).watched == "a1"
    none = {name: values[:0] for name, values in CONTACT.items()}
    for rows, name in (([[1], [2]], "a2"), ([[2], [1]], "a1")):
        assert Results(synthetic_results.write(path, [1.0], np.ones((1, 2, 3)) * rows, 2, none)).watched == name


def test_curves_of_several_and_of_none(tmp_path):
    results = Results(plain(tmp_path / "r.h5"))
    a, t2 = results.response(["a1", "x1.t2"])
    assert (a.name, t2.name) == ("a1", "x1.t2") and results.response(("a1",))[0].name == "a1" and results.response().name == "x1.t2"
    assert t2.amplitude.tolist() == [0, 1, 2] == results.amplitude().tolist()
    assert a.unit == "m √kg" and a.slopes is None and a.breaks == ()
    assert results.harmonic("x1.t2", 1).tolist() == [0, 1, 2] and results.curve("x1.t2")[1].tolist() == [0, 1, 2]
    with pytest.raises(ValueError) as found:
        results.peak("a1")
    assert str(found.value).endswith("a1 has no peak between the ends of the sweep")
    assert results.ends("x1.t2")[0][:2] == (3.0, 2.0)
    events = [("leap", 1, 1.0, 0.0, -1), ("outside", 0, 1.0, 0.0, -1), ("integration", 1, 1.0, 0.0, -1), ("fold", 2, 1.0, 0.0, -1)]
    assert Results(plain(results.path, events=events)).jumps.tolist() == [0, 1]


def test_curves_follow_their_tangents_and_break_where_harmonics_change(tmp_path):
    path = tmp_path / "r.h5"
    slopes = np.zeros((3, 4, 3))
    slopes[:, 2, 2] = [3.0, 0.0, 0.0]
    stored = {"tangent": slopes, "tangent_parameter": np.ones(3), "harmonics": [1, 1, 2]}
    results = Results(plain(path, **stored))
    curve = results.response("x1.t2")
    assert curve.breaks.tolist() == [1] and curve.slopes()[0].tolist() == [1, 1, 1] and curve.slopes()[1][0].tolist() == [0, 0, 3]
    along, amplitude = results.curve("x1.t2", 2)
    np.testing.assert_allclose(along, [1, 1.5, 2, 3], rtol=1e-15)
    np.testing.assert_allclose(amplitude, [0, 0.5 + 3 / 8, 1, 2], rtol=1e-14)  # a cubic, then a straight line
    for name in ("tangent", "tangent_parameter"):
        assert Results(plain(path, **{key: value for key, value in stored.items() if key != name})).response("x1.t2").slopes is None
    with pytest.raises(ValueError, match=r"/points/tangent: wanted shape \(any, 4, 3\), found \(3, 4, 5\)"):
        Results(plain(path, **stored | {"tangent": np.zeros((3, 4, 5))}))


def test_curves_of_nodes_are_read_in_blocks(tmp_path, monkeypatch):
    path, row = tmp_path / "r.h5", np.array([1.0, 0, 2.0, 0])
    plain(path, n=7, tangent=np.ones((7, 4, 3)), tangent_parameter=np.ones(7), harmonics=np.ones(7))
    asked = []
    monkeypatch.setattr(motion, "node_row", lambda results, dof: asked.append(dof) or row)
    reads, read = [], Results._coefficients
    monkeypatch.setattr(Results, "_coefficients", lambda *which, **name: reads.append(which) or read(*which, **name))
    for block, times in ((1, 7), (24, 4), (36, 3), (module.BLOCK, 1)):
        monkeypatch.setattr(module, "BLOCK", block)
        results = Results(path)
        reads.clear()
        results.amplitude("tip.y")
        assert len(reads) == times
        curve = results.response("tip.y")
        np.testing.assert_array_equal(curve.coefficients, np.stack([np.zeros(7), np.full(7, 10.0), 2 * np.arange(7.0)], axis=1))
        np.testing.assert_array_equal(curve.slopes()[1], np.full((7, 3), 3.0))
        np.testing.assert_allclose(results.time_history(3, "tip.y", 4)[1], [10, 6, -10, -6], atol=1e-14)
    assert asked == 4 * ["tip.y"] and results.unit_of("tip.y") == "m"
    empty = one_point(tmp_path / "empty.h5", np.zeros((0, 4, 3)), omega=[])
    assert empty._of_dof("tip.y").shape == (0, 3)


def test_motions_are_asked_for_at_64_instants_unless_others_are_wanted(tmp_path, monkeypatch):
    results = Results(plain(tmp_path / "r.h5"))
    monkeypatch.setattr(motion, "nodal_displacement", lambda *asked: asked)
    for name in ("elastic", "unknowns", "full"):
        monkeypatch.setattr(module.recovery, name, lambda *asked: asked)
    assert results.displacement(1) == (results, 1, None, 64, None, None, None, "sector")
    assert results.displacement(1, [5], 8, [0.5], "m.h5", 2, "fixed") == (results, 1, [5], 8, [0.5], "m.h5", 2, "fixed")
    assert results.elastic(1) == results.full(1) == (results, 1, 64, None, None)
    assert results.elastic(1, 8, [0.5], 2) == results.full(1, 8, [0.5], 2) == (results, 1, 8, [0.5], 2)
    assert results.unknowns(1, [3]) == (results, 1, [3], 64, None, None)
    assert results.motion(1).shape == (64, 4)


def test_other_sectors_do_the_same_later(tmp_path):
    coefficients = np.random.default_rng(1).standard_normal((1, 4, 7))
    path = synthetic_results.write(tmp_path / "r.h5", (2.0,), coefficients, 1, CONTACT)
    results = changed(path, len, sectors=4, engine_order=1)
    t, own = results.time_history(0, "x1.t1", 8)
    for sector in range(4):
        np.testing.assert_allclose(results.time_history(0, "x1.t1", 8, sector)[1], np.roll(own, 2 * sector), atol=1e-13)
        np.testing.assert_allclose(results.motion(0, 8, sector=sector)[:, 1], np.roll(own, 2 * sector), atol=1e-13)
    assert results.wave.sectors == 4 and results.wave.index.tolist() == [0, 1, 2, -1]
    with pytest.raises(ValueError, match="sector must be a whole number from 0 to 3, found 4"):
        results.coefficients_at(0, 4)


def test_parameters_of_contact_points(tmp_path):
    coefficients = np.zeros((2, 7, 3))
    xp, w = np.arange(6.0), np.arange(4.0).reshape(2, 2)
    results = Results(synthetic_results.write(tmp_path / "r.h5", [1.0, 2.0], coefficients, 1, {**TWO, "law": [3, 0]}, xp=xp, w=w))
    assert results.contact["law"].tolist() == [3, 0] and results.contact["friction"].tolist() == [[0.5, 0.25]] * 2
    assert results.contact["normal_stiffness"].tolist() == [2, 2]
    assert results.xp.tolist() == xp.tolist() and results.w.tolist() == w.tolist()
    assert results.g.tolist() == [0] * 6 and (results.modes, results.contact_points, results.samples) == (1, 2, 256)
    assert results.has_activity and results.contact_activity().stick.shape == (2, 2) and results.contact_activity(1).stick.shape == (2,)
    x, force = results.hysteresis(1, 2, 1, 16)
    assert x.size == force.size == 16 and np.all(x == xp[4])
