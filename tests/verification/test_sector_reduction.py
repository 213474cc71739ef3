"""A cyclic sector reduced for every nodal diameter: against the whole rotor, an independent program, and dense algebra."""

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

import cases
import cyclic_sector
import launch
import sector_model
import whole_rotor
from dovetail.cyclic import turn
from sector_model import ALL, INNER, N

DATA = np.load(Path(__file__).with_name("data") / "rotor_linear.npz")


@pytest.fixture(scope="module")
def complete(tmp_path_factory):
    """Reduced with all modes there are."""
    folder = tmp_path_factory.mktemp("sector")
    sector_model.write_model(folder / "model.h5", patterns=("lift", "second"))
    case = sector_model.write_case(folder / "case.toml", ALL, INNER)
    return reduce(case)


def reduce(case, **where):
    return launch.run(cases.Case(case, None, None, {}), command="reduce", **where).folder


def read(folder):
    with h5py.File(folder / "reduced.h5") as file:
        return [sector_model.index(file, h) for h in range(N // 2 + 1)]


def test_frequencies_are_those_of_an_independent_program(complete):
    for h, (K, M, _, _) in enumerate(read(complete)):
        stuck = sector_model.frequencies(K + sector_model.springs(ALL), M)[:20]
        np.testing.assert_allclose(stuck, DATA["stuck"][h], rtol=1e-10)
        np.testing.assert_allclose(np.sqrt(np.diag(K)[:20]), DATA["held"][h], rtol=1e-10)


def test_frequencies_are_those_of_the_whole_rotor(complete):
    """Each nodal diameter but 0 and N/2 twice, forward and backward."""
    spectra = [sector_model.frequencies(K + sector_model.springs(ALL), M) for K, M, _, _ in read(complete)]
    found = np.sort(np.concatenate([spectrum for h, spectrum in enumerate(spectra) for _ in range(1 + (0 < h < N / 2))]))
    pairs = [(a, b, axes, beyond) for part, beyond in (("root", 0), ("shroud", 1))
             for a, b, axes in zip(*(sector_model.SECTOR[f"{part}_{name}"] for name in ("a", "b", "axes")))]
    T, elastic = whole_rotor.coordinates(pairs)
    K, M = (T.T @ whole_rotor.sp.block_diag([whole(name)] * N) @ T for name in "KM")
    K = K.toarray() + np.diag(np.concatenate([np.zeros(elastic), np.tile(sector_model.STIFFNESS.ravel(), N)]))
    wanted = sector_model.frequencies(K, M.toarray())
    assert len(found) == len(wanted)
    np.testing.assert_allclose(found[:300], wanted[:300], rtol=1e-10)


def whole(name):
    parts = tuple(sector_model.SECTOR[f"{name}_{part}"] for part in ("data", "indices", "indptr"))
    return whole_rotor.sp.csr_matrix(parts)


def test_matrices_loads_and_motion_are_those_of_dense_algebra(complete):
    check_matrices(complete)


def check_matrices(complete, points=None):
    """The motion of all dofs brings the sector's own K, M and loads back: T^H K T, and nothing else moves."""
    K_full, M_full = (sector_model.matrix(name).toarray() for name in "KM")
    with h5py.File(complete / "model.h5") as file:
        loads = np.array([file[f"forces/{name}"][()] for name in ("lift", "second")])
    for h, (K, M, F, motion) in enumerate(read(complete)):
        for found, full in ((K, K_full), (M, M_full)):
            wanted = motion.conj().T @ full @ motion
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())
        np.testing.assert_allclose(F, (motion.conj().T @ loads.T).T, rtol=0, atol=1e-9 * np.abs(F).max())
        T = sector_model.transform(h, points)
        coordinates, left_over, *_ = np.linalg.lstsq(T, motion, rcond=None)
        np.testing.assert_allclose(T @ coordinates, motion, rtol=0, atol=1e-9 * np.abs(motion).max())
        np.testing.assert_allclose(coordinates[-24:], np.eye(len(K))[-24:], rtol=0, atol=1e-9 * np.abs(motion).max())


@pytest.mark.parametrize("ranks", [1, 3])
def test_nodes_on_faces_and_held_sides(tmp_path, ranks):
    """One root point on a face, one whose a is held, one on the ground; a shroud point on a face of the next sector."""
    points = sector_model.contacts()
    taken = [sector_model.SECTOR[name] for name in ("left", "right", "root_a", "root_b", "shroud_a", "shroud_b")]
    free, also, third = np.setdiff1d(sector_model.FREE, np.concatenate(taken))[:3]
    faces = {0: [(free, 0.7), (also, 0.3)], 6: [(points[6][1], 0.4), (third, 0.6)]}
    for k, a, b, face in ((0, 1, 0, faces[0]), (1, 0, 1, []), (2, 1, 0, []), (6, 1, 0, faces[6])):
        points[k] = (points[k][0] if a else -1, points[k][1] if b else -1, face, *points[k][3:])
    sector_model.write_model(tmp_path / "model.h5", patterns=("lift", "second"))
    with h5py.File(tmp_path / "model.h5", "a") as file:
        file["contact/nodes"][...] = [point[:2] for point in points]
        parts = [part for point in points for part in point[2]]
        file["contact/faces/begin"] = np.cumsum([0, *(len(point[2]) for point in points)])
        file["contact/faces/node"], file["contact/faces/weight"] = [node for node, _ in parts], [weight for _, weight in parts]
    check_matrices(reduce(sector_model.write_case(tmp_path / "case.toml", 60), ranks=ranks), points)


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_sector_all_of_which_is_held(tmp_path, ranks):
    """Faces and one point between sectors, nothing inside: the matrices follow from its motion, and the right face from the left one."""
    random, dofs = np.random.default_rng(1), np.arange(18)
    K = random.normal(size=(18, 18))
    K, M = K @ K.T + np.eye(18), np.diag(1 + random.random(18))
    with h5py.File(tmp_path / "model.h5", "w") as file:
        file.attrs["format"], file.attrs["version"] = "dovetail-model", 1
        sector_model.put(file, "K", K), sector_model.put(file, "M", M)
        file["forces/lift"], file["preload"] = random.normal(size=18), np.zeros(18)
        file["contact/nodes"], file["contact/axes"] = [[4, 5]], [np.eye(3)]
        for name, value in (("normal_stiffness", 1.0), ("tangential_stiffness", 1.0), ("friction", 0.3), ("gap", 0.0)):
            file[f"contact/{name}"] = [value]
        file["cyclic/left"], file["cyclic/right"], file["cyclic/next_sector"] = dofs[:6], dofs[6:12], [1]
        file["cyclic"].attrs.update({"sectors": N, "axis": [0.0, 0.0, 1.0], "origin": np.zeros(3)})
    folder = reduce(sector_model.write_case(tmp_path / "case.toml", 9), ranks=ranks)
    for h, (found, mass, _, motion) in enumerate(read(folder)):
        onwards = np.exp(-2j * np.pi * h / N) * np.kron(np.eye(2), turn((0, 0, 1), 2 * np.pi / N))
        np.testing.assert_allclose(motion[6:12], onwards @ motion[:6], rtol=0, atol=1e-12)
        for reduced, full in ((found, K), (mass, M)):
            np.testing.assert_allclose(reduced, motion.conj().T @ full @ motion, rtol=0, atol=1e-10 * np.abs(reduced).max())


def test_the_elastic_preload_is_that_of_nodal_diameter_0(complete):
    T, K = sector_model.transform(0).real, sector_model.matrix("K").toarray()
    with h5py.File(complete / "model.h5") as file:
        p = T.T @ file["preload"][()]
    K = T.T @ K @ T
    at_rest = np.linalg.solve(K[:-24, :-24], p[:-24])
    with h5py.File(complete / "reduced.h5") as file:
        R, xe0 = file["R"][()], file["recovery/xe0"][()][np.argsort(file["recovery/elastic_dofs"][()])]
    np.testing.assert_allclose(R, K[-24:, :-24] @ at_rest - p[-24:], rtol=0, atol=1e-9 * np.abs(p).max())
    np.testing.assert_allclose(xe0, T[:, :-24] @ at_rest, rtol=0, atol=1e-9 * np.abs(xe0).max())


def test_modes_prints_them_by_nodal_diameter(complete):
    out = launch.run(cases.Case(complete / "case.toml", None, None, {}), command="modes").out
    stuck, held = (np.array([[float(word) for word in line.split()[1:]] for line in block.splitlines()])
                   for block in re.findall(r"(?:stuck|held) \[Hz\]\n.*\n((?: .*\n){4})", out))
    np.testing.assert_allclose(2 * np.pi * stuck, DATA["stuck"][:, :8], rtol=1e-5)
    np.testing.assert_allclose(2 * np.pi * held[1], DATA["held"][1, :8], rtol=1e-5)


@pytest.mark.parametrize("ranks, exact", [(2, False), (3, False), (2, True), (3, True)])
def test_any_number_of_ranks_finds_the_same(tmp_path, ranks, exact):
    sector_model.write_model(tmp_path / "model.h5")
    case = sector_model.write_case(tmp_path / "case.toml", 12, 40, exact)
    one, more = read(reduce(case)), read(reduce(case, ranks=ranks, out="more"))
    for alone, together in zip(one, more):
        for a, b in zip(alone, together):
            np.testing.assert_allclose(b, a, rtol=0, atol=1e-8 * np.abs(a).max())


def test_fewer_interior_modes_cost_little_and_stiffness_is_exact(complete, tmp_path):
    sector_model.write_model(tmp_path / "model.h5")
    errors = []
    for interior in (10, 40):
        case = sector_model.write_case(tmp_path / "case.toml", 8, interior)
        few = read(reduce(case))
        exact = read(complete)
        held = [np.sqrt(np.diag(K)[:6].real / np.diag(L)[:6].real) - 1 for (K, *_), (L, *_) in zip(few, exact)]
        assert np.min(held) > -1e-9
        errors.append(np.max(held))
        for (K, *_), (L, *_) in zip(few, exact):
            np.testing.assert_allclose(K[-24:, -24:], L[-24:, -24:], rtol=0, atol=1e-10 * np.abs(L[-24:, -24:]).max())
    assert errors[1] < 1e-2 and errors[1] < errors[0] / 4


@pytest.mark.parametrize("interior", [2, 12])
def test_exact_modes_do_not_depend_on_the_interior_ones(complete, tmp_path, interior):
    sector_model.write_model(tmp_path / "model.h5", patterns=("lift", "second"))
    folder = reduce(sector_model.write_case(tmp_path / "case.toml", 8, interior, exact=True))
    check_matrices(folder)
    for (K, M, F, _), (L, W, G, _) in zip(read(folder), read(complete)):
        np.testing.assert_allclose(np.diag(K)[:8], np.diag(L)[:8], rtol=1e-10)
        for found, wanted in ((M[:8, 8:], W[:8, -24:]), (F[:, :8].T, G[:, :8].T)):  # but for the phase of each mode
            found, wanted = np.conj(found) @ found.T, np.conj(wanted) @ wanted.T
            np.testing.assert_allclose(np.abs(found), np.abs(wanted), rtol=0, atol=1e-6 * np.abs(wanted).max())


def test_what_interior_modes_cost_is_told(complete, tmp_path):
    sector_model.write_model(tmp_path / "model.h5")
    for interior in (15, 40):
        case = cases.Case(sector_model.write_case(tmp_path / "case.toml", 8, interior), None, None, {})
        done = launch.run(case, command="reduce")
        told, diameter = re.search(r"leave up to ([^ ]*) of a frequency, contact points held .nodal diameter (\d)", done.out).groups()
        errors = [np.sqrt(np.diag(K)[:8].real / np.diag(L)[:8].real).max() - 1 for (K, *_), (L, *_) in zip(read(tmp_path), read(complete))]
        assert 0.7 * errors[int(diameter)] < float(told) < 1.1 * errors[int(diameter)]


def test_without_the_key_five_times_as_many_interior_modes(tmp_path):
    sector_model.write_model(tmp_path / "model.h5")
    case = cases.Case(sector_model.write_case(tmp_path / "case.toml", 4), None, None, {})
    held = 3 * (6 + 2 * 2 + 2 * len(sector_model.SECTOR["left"]))  # of the root only what is relative
    assert (f"{held} dofs of contact points and faces held, 20 interior modes for nodal diameters 0 to 3"
            in launch.run(case, command="reduce").out)
    assert "reused" in launch.run(case, command="reduce").out


@pytest.mark.parametrize("name", cyclic_sector.CASES)
@pytest.mark.parametrize("complete", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_run_from_the_model_file_moves_as_the_whole_rotor_does(tmp_path, name, complete):
    """With all modes; and with twenty of each nodal diameter, exact ones, as an independent program says of these."""
    given, data = cyclic_sector.given(name), cyclic_sector.DATA if complete else cyclic_sector.FEW
    expected = data[f"{name}/X_rotor"][1, 0] if complete else data[f"{name}/X_modes20"][1]
    omega, points = float(given["omega"][1]), len(given["gap"])
    flat = expected.reshape(-1, expected.shape[-1])
    inner = INNER + 6 * (8 - points)
    modes, interior = (ALL + 3 * (8 - points), inner) if complete else (20, 30)
    sector_model.write_model(tmp_path / "model.h5", given["patterns"], points)
    path, models = cyclic_sector.write(tmp_path, name, omega, modes=modes)
    cyclic_sector.write_start(tmp_path, name, omega, models, 1.001 * flat)
    keys = f"reduction = {{ modes = {modes}, interior_modes = {interior}, exact_modes = {'false' if complete else 'true'} }}"
    path.write_text(path.read_text().replace('reduced = "sector.h5"', f'model = "model.h5"\n{keys}'))
    done = launch.run(cases.Case(path, None, None, {}))
    found = done.points["coefficients"][-1][-len(flat):]
    np.testing.assert_allclose(found, flat, rtol=0, atol=1e-8 * np.abs(flat).max())
    with h5py.File(tmp_path / "results.h5") as file:
        assert file["cyclic/nodal_diameters"][()].tolist() == [0, 1, 2, 3]
        frequencies = file["cyclic/frequencies"][()]
    assert frequencies.shape == (4, 20) and (np.diff(frequencies) >= 0).all()
