"""Wrong input ends with status 2 and one message that names file, key or dataset and the value found; nothing is written, no rank hangs."""

import subprocess

import h5py
import numpy as np
import pytest
import scipy.sparse as sp

from launch import BINARY, SURROUNDINGS

SECONDS = 120  # far more than any of these needs, far less than a hang

CASE = """\
title = "wrong on purpose"
model = "model.h5"
[reduction]
modes = 2
[damping]
stiffness = 0.05
[excitation]
fourier = [0, 0, 1]
[contact]
normal_stiffness = 1.0
tangential_stiffness = [1.0, 1.0]
friction = [1.0, 1.0]
gap = -3.5
[preload]
initial = 1e-5
[harmonic_balance]
harmonics = 5
samples = 64
[newton]
step_tolerance = 1e-5
residual_tolerance = 1e-5
max_iterations = 50
[scaling]
kind = "none"
[continuation]
omega = [0.9, 1.3]
step = 0.05
adaptive = true
max_points = 3
[output]
directory = "out"
"""

K = np.array([[10, -10, 0, 0, 0], [-10, 20, -10, 0, 0], [0, -10, 20, -10, 0], [0, 0, -10, 20, -10], [0, 0, 0, -10, 20]], dtype=float)


def write_sparse(file, name, matrix):
    columns = sp.csc_matrix(matrix)
    group = file.create_group(name)
    group.attrs["MATLAB_sparse"] = np.uint64(columns.shape[0])
    for key, values in (("data", columns.data), ("ir", columns.indices.astype(np.uint64)), ("jc", columns.indptr.astype(np.uint64))):
        group[key] = values


def write_model(path, K=K, M=np.eye(5), dofs=((2, 3, 4),), without=(), **datasets):
    """The five-degree-of-freedom model; `datasets` replaces or adds some ("/" written as two underscores)."""
    vectors = {"force": [1.0, 1, 0, 0, 0], "preload": [1.0, 0.1, 0.1, 0.1, 0.1], "contact__dofs": np.array(dofs, dtype=np.int64)}
    with h5py.File(path, "w") as file:
        file.attrs["format"], file.attrs["version"], file.attrs["units"] = "dovetail-model", 1, "SI"
        write_sparse(file, "K", K)
        write_sparse(file, "M", M)
        for name, values in (vectors | datasets).items():
            file[name.replace("__", "/")] = np.asarray(values)
        for name in without:
            del file[name]


def run(folder, *options, ranks=None, status=2):
    """Runs the case in `folder` and returns what it says on stderr."""
    mpirun = ["mpirun", "-n", str(ranks)] if ranks else []
    done = subprocess.run([*mpirun, BINARY, "run", folder / "case.toml", *options], capture_output=True, text=True, timeout=SECONDS,
                          env=SURROUNDINGS)
    assert done.returncode == status, f"status {done.returncode}\n{done.stdout}\n{done.stderr}"
    if status:
        assert not list(folder.rglob("results.h5*")), "results of a run that was refused"
    return done.stderr


def expect(message, words):
    for word in words:
        assert word in message, message
    assert "PETSC ERROR" not in message and "Traceback" not in message, message


def edit(old, new):
    """CASE with one line changed, and the number of that line."""
    lines = CASE.splitlines()
    at = lines.index(old)
    lines[at:at + 1] = new.splitlines()
    return "\n".join(lines) + "\n", at + 1


@pytest.fixture
def folder(tmp_path):
    write_model(tmp_path / "model.h5")
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path


# Line of CASE, what stands there instead (the fault in its first line), words of the message beside the place.
CASES = [
    ("title = \"wrong on purpose\"", "title = 5", ["title = 5", "quotes"]),
    ("model = \"model.h5\"", "model = \"nowhere.h5\"", ["model = \"nowhere.h5\"", "no file"]),
    ("model = \"model.h5\"", "reduced = \"nowhere.h5\"", ["reduced = \"nowhere.h5\"", "no file"]),
    ("modes = 2", "modes = 2.0", ["reduction.modes = 2.0", "write 2"]),
    ("modes = 2", "modes = -2", ["reduction.modes = -2", "at least 0"]),
    ("modes = 2", "mode = 2", ["reduction.mode = 2", "did you mean modes"]),
    ("gap = -3.5", "stiffness = 1.0", ["contact.stiffness = 1.0",
                                       "did you mean normal_stiffness in [contact] or tangential_stiffness in [contact]"]),
    ("max_iterations = 50", "tolerance = 1e-6", ["did you mean step_tolerance in [newton] or residual_tolerance in [newton]?"]),
    ("initial = 1e-5", "gap = 1e-5", ["did you mean gap in [contact]? allowed in [preload]: initial"]),
    ("[damping]", "[dampnig]", ["[dampnig]", "did you mean [damping]"]),
    ("[damping]", "[solver]", ["[solver]", "[harmonic_balance]"]),
    ("stiffness = 0.05", "stiffness = -0.05", ["damping.stiffness = -0.05", "negative"]),
    ("stiffness = 0.05", "stiffness = nan", ["damping.stiffness = nan", "finite"]),
    ("stiffness = 0.05", "stiffness = \"0.05\"", ["damping.stiffness = \"0.05\"", "without quotes"]),
    ("stiffness = 0.05", "stiffness = 0,05", ["stiffness = 0,05"]),
    ("stiffness = 0.05", "mass = -1.0", ["damping.mass = -1", "negative"]),
    ("stiffness = 0.05", "structural = -0.01", ["damping.structural = -0.01", "negative"]),
    ("stiffness = 0.05", "ratios = [[1, 2.0]]", ["entry 2 of entry 1 of damping.ratios = 2", "at most 1", "2 % are 0.02"]),
    ("stiffness = 0.05", "ratios = [[1, -0.1]]", ["entry 2 of entry 1 of damping.ratios = -0.1", "negative"]),
    ("stiffness = 0.05", "ratios = [[0, 0.1]]", ["entry 1 of entry 1 of damping.ratios = 0", "at least 1"]),
    ("stiffness = 0.05", "ratios = [[1, 0.1], [1, 0.2]]", ["entry 1 of entry 2 of damping.ratios = 1", "there already"]),
    ("stiffness = 0.05", "ratios = [1, 0.1]", ["entry 1 of damping.ratios = 1", "[mode, ratio]"]),
    ("stiffness = 0.05", "ratios = 0.1", ["damping.ratios = 0.1", "[[1, 0.002], [2, 0.003]]"]),
    ("stiffness = 0.05", "ratios = [[6, 0.1]]", ["damping.ratios", "mode 6", "5 modes"]),
    ("stiffness = 0.05", "of = \"open\"\nratios = [[1, 0.1]]", ["damping.of = \"open\"", "must be \"stuck\" or \"fixed\""]),
    ("stiffness = 0.05", "ratios = [[3, 0.1]]\nof = \"fixed\"", ["damping.ratios", "mode 3", "2 fixed-interface modes"]),
    ("stiffness = 0.05", "matrix = true", ["damping.matrix = true", "has no /C"]),
    ("stiffness = 0.05", "contact = true\nmass = 0.1", ["damping.contact = true", "damping.stiffness"]),
    ("stiffness = 0.05", "of = \"stuck\"", ["damping.of = \"stuck\"", "not given"]),
    ("stiffness = 0.05", "structual = 0.01", ["damping.structual = 0.01", "did you mean structural"]),
    ("fourier = [0, 0, 1]", "fourier = [0, 0, 0]", ["excitation.fourier = [0, 0, 0]", "nothing would move"]),
    ("fourier = [0, 0, 1]", "fourier = [7]", ["excitation.fourier = [7]", "constant alone, nothing would vibrate", "/preload"]),
    ("fourier = [0, 0, 1]", "fourier = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]", ["excitation.fourier", "harmonic 6", "harmonics = 5"]),
    ("normal_stiffness = 1.0", "normal_stiffness = 0.0", ["contact.normal_stiffness = 0", "greater than 0"]),
    ("normal_stiffness = 1.0", "normal_stiffness = [1.0, 2.0, 3.0]", ["contact.normal_stiffness", "3 values", "N_x = 1"]),
    ("tangential_stiffness = [1.0, 1.0]", "tangential_stiffness = [1.0, -1.0]", ["contact.tangential_stiffness = -1", "greater than 0"]),
    ("tangential_stiffness = [1.0, 1.0]", "tangential_stiffness = [[1.0, 1.0], [1.0, 1.0]]", ["2 pairs", "N_x = 1"]),
    ("friction = [1.0, 1.0]", "friction = -1.0", ["contact.friction = -1", "negative"]),
    ("gap = -3.5", "law = \"banana\"", ["contact.law = \"banana\"", "must be \"coulomb\", \"cone\", \"unilateral\" or \"bilateral\""]),
    ("gap = -3.5", "law = 1", ["contact.law = 1", "\"coulomb\""]),
    ("gap = -3.5", "law = [\"cone\", \"coulomb\"]", ["contact.law: 2 words found", "N_x = 1"]),
    ("friction = [1.0, 1.0]", "friction = [1.0, 0.5]\nlaw = \"cone\"", ["contact.friction = [1, 0.5]", "point 0", "t1 and t2"]),
    ("tangential_stiffness = [1.0, 1.0]", "tangential_stiffness = 1.0\nlaw = [\"bilateral\"]",
     ["contact.tangential_stiffness = 1.0", "no effect", "delete this key"]),
    ("gap = -3.5", "gap = inf", ["contact.gap = inf", "finite"]),
    ("initial = 1e-5", "initial = [0, 0, 0, 0, 0, 0]", ["preload.initial", "6 values", "3 in all"]),
    ("initial = 1e-5", "initial = [0, 0]", ["preload.initial = [0, 0]", "2 values"]),
    ("harmonics = 5", "harmonics = 0", ["harmonic_balance.harmonics = 0", "at least 1"]),
    ("samples = 64", "samples = 8", ["harmonic_balance.samples = 8 is too small for harmonics = 5: at least 2*5+1 = 11"]),
    ("samples = 64", "samples = \"many\"", ["harmonic_balance.samples = \"many\"", "\"exact\"", "number"]),
    ("step_tolerance = 1e-5", "step_tolerance = 0", ["newton.step_tolerance = 0", "greater than 0"]),
    ("residual_tolerance = 1e-5", "residual_tolerance = 2", ["newton.residual_tolerance = 2", "less than 1"]),
    ("max_iterations = 50", "max_iterations = 50.0", ["newton.max_iterations = 50.0", "write 50"]),
    ("kind = \"none\"", "kind = \"some\"", ["scaling.kind = \"some\"", "manual"]),
    ("kind = \"none\"", "modal = 1.0\nkind = \"none\"", ["scaling.modal = 1.0", "manual"]),
    ("omega = [0.9, 1.3]", "omega = [0, 1.3]", ["entry 1 of continuation.omega = 0", "greater than 0"]),
    ("omega = [0.9, 1.3]", "omega = 1.3", ["continuation.omega = 1.3", "[from, to]"]),
    ("omega = [0.9, 1.3]", "omega = [1.1, 1.1000000000000003]", ["continuation.omega = [1.1, 1.1000000000000003]", "same number twice"]),
    ("omega = [0.9, 1.3]", "omega = [1.1, 1.0999999999999]", ["continuation.omega = [1.1, 1.0999999999999]", "last digits"]),
    ("omega = [0.9, 1.3]", "at = [1.4]\nomega = [0.9, 1.3]", ["continuation.at = 1.4", "outside"]),
    ("omega = [0.9, 1.3]", "at = [1.2, 1.1]\nomega = [0.9, 1.3]", ["continuation.at = 1.1", "order"]),
    ("omega = [0.9, 1.3]", "start = \"no.h5\"\nomega = [0.9, 1.3]", ["continuation.start = \"no.h5\"", "no file"]),
    ("step = 0.05", "step = 0", ["continuation.step = 0", "greater than 0"]),
    ("adaptive = true", "adaptive = 1", ["continuation.adaptive = 1", "true or false"]),
    ("max_points = 3", "max_points = 0", ["continuation.max_points = 0", "at least 1"]),
    ("model = \"model.h5\"", "stability.enabled = 1\nmodel = \"model.h5\"", ["stability.enabled = 1", "true or false"]),
    ("model = \"model.h5\"", "recovery.strategies = [\"leap\"]\nmodel = \"model.h5\"",
     ["entry 1 of recovery.strategies = \"leap\"", "\"jump\""]),
    ("model = \"model.h5\"", "recovery.strategies = \"none\"\nmodel = \"model.h5\"", ["recovery.strategies = \"none\"", "must be a list"]),
    ("model = \"model.h5\"", "recovery.work = 0\nmodel = \"model.h5\"", ["recovery.work = 0"]),
    ("max_points = 3", "watch = \"tip\"\nmax_points = 3", ["continuation.watch = \"tip\"", "x1.t1", "a1"]),
    ("directory = \"out\"", "directory = 5", ["output.directory = 5", "quotes"]),
    ("directory = \"out\"", "directory = \"model.h5/out\"", ["output.directory", "model.h5/out"]),
]
MISSING = [
    ("model = \"model.h5\"", ["model is missing", "reduced"]),
    ("modes = 2", ["reduction.modes is missing"]),
    ("fourier = [0, 0, 1]", ["excitation.fourier is missing", "fourier = [0, 1]"]),
    ("normal_stiffness = 1.0", ["contact.normal_stiffness is missing"]),
    ("friction = [1.0, 1.0]", ["contact.friction is missing"]),
    ("harmonics = 5", ["harmonic_balance.harmonics is missing"]),
    ("omega = [0.9, 1.3]", ["continuation.omega is missing"]),
]
NAN = K.copy()
NAN[0, 0] = np.nan
SKEW = K.copy()
SKEW[0, 1] = -9
# Keywords of write_model, words of the message beside the file.
MODELS = {
    "without_K": (dict(without=["K"]), ["/K"]),
    "without_M_data": (dict(without=["M/data"]), ["/M/data"]),
    "without_force": (dict(without=["force"]), ["/force"]),
    "without_contact_dofs": (dict(without=["contact/dofs"]), ["/contact/dofs"]),
    "unsymmetric": (dict(K=SKEW), ["/K", "symmetric"]),
    "sizes_differ": (dict(M=np.eye(4)), ["/M", "4", "5"]),
    "contact_dof_too_large": (dict(dofs=[(2, 3, 5)]), ["/contact/dofs", "5"]),
    "contact_dof_negative": (dict(dofs=[(2, 3, -1)]), ["/contact/dofs", "-1"]),
    "contact_dof_repeated": (dict(dofs=[(2, 3, 3)]), ["/contact/dofs", "3", "repeated"]),
    "contact_dofs_in_pairs": (dict(dofs=[(2, 3)]), ["/contact/dofs"]),
    "neither_force_nor_forces": (dict(without=["force"]), ["/force: missing", "group /forces"]),
    "force_is_zero": (dict(force=np.zeros(5)), ["load pattern \"force\" has no force other than zero", "excitation.fourier = "]),
    "pattern_of_another_name": (dict(without=["force"], forces__lift=np.ones(5)), ["excitation.fourier", "\"force\"", "\"lift\""]),
    "pattern_too_short": (dict(forces__lift=np.ones(4)), ["/forces/lift", "4", "5"]),
    "pattern_not_finite": (dict(forces__lift=[1, 0, np.inf, 0, 0]), ["/forces/lift", "inf", "2"]),
    "pattern_in_a_group": (dict(forces__wind__lift=np.ones(5)), ["/forces/wind", "a dataset is wanted"]),
    "patterns_no_group": (dict(forces=np.ones(5)), ["/forces", "a group is wanted"]),
    "force_twice": (dict(forces__force=np.ones(5)), ["/forces/force", "another name"]),
    "force_too_short": (dict(force=np.ones(4)), ["/force", "4", "5"]),
    "nan_in_force": (dict(force=[1, np.nan, 0, 0, 0]), ["/force", "nan"]),
    "nan_in_K": (dict(K=NAN), ["/K", "nan"]),
    "negative_stiffness": (dict(contact__normal_stiffness=[-1.0]), ["/contact/normal_stiffness", "-1"]),
}


def test_the_case_itself_is_good(folder):
    run(folder, "--dry-run", status=0)


@pytest.mark.parametrize("old, new, words", CASES, ids=[new.replace("\n", " ") for _, new, _ in CASES])
def test_case_file(folder, old, new, words):
    text, line = edit(old, new)
    (folder / "case.toml").write_text(text)
    expect(run(folder), [f"case.toml:{line}: ", *words])


def test_friction_is_not_needed_without_friction(folder):
    text = CASE.replace("tangential_stiffness = [1.0, 1.0]\n", "").replace("friction = [1.0, 1.0]", "law = \"unilateral\"")
    (folder / "case.toml").write_text(text)
    run(folder, "--dry-run", status=0)
    write_model(folder / "model.h5", contact__friction=[[0.1, 0.2]])  # a model may serve other cases as well
    run(folder, "--dry-run", status=0)


@pytest.mark.parametrize("old, words", MISSING, ids=[old for old, _ in MISSING])
def test_key_missing(folder, old, words):
    (folder / "case.toml").write_text(CASE.replace(old + "\n", ""))
    expect(run(folder), ["case.toml", *words])


def test_case_file_missing(folder):
    (folder / "case.toml").unlink()
    expect(run(folder), ["case.toml", "no such case file"])


def test_folder_for_a_case_file(folder):
    (folder / "case.toml").unlink()
    (folder / "case.toml").mkdir()
    expect(run(folder), ["case.toml", "is a folder"])


def test_model_file_for_a_case_file(folder):
    (folder / "model.h5").rename(folder / "case.toml")
    expect(run(folder), ["case.toml", "not a text file"])


@pytest.mark.parametrize("name", MODELS)
def test_model_file(folder, name):
    changes, words = MODELS[name]
    write_model(folder / "model.h5", **changes)
    if "negative" in name and "stiffness" in name:  # else the case file wins
        (folder / "case.toml").write_text(CASE.replace("normal_stiffness = 1.0\n", ""))
    expect(run(folder), ["model.h5", *words])


def test_force_that_was_never_written(folder):
    with h5py.File(folder / "model.h5", "r+") as file:
        del file["force"]
        file.create_dataset("force", (5,), float)
    expect(run(folder), ["model.h5", "has no force other than zero"])


def test_a_reduction_needs_no_force(folder):
    write_model(folder / "model.h5", force=np.zeros(5))
    done = subprocess.run([BINARY, "reduce", folder / "case.toml"], capture_output=True, text=True, timeout=SECONDS, env=SURROUNDINGS)
    assert done.returncode == 0, done.stderr
    expect(run(folder, "--dry-run"), ["no force other than zero"])


LOADS = "[[excitation.load]]\npattern = \"%s\"\nfourier = [0, 1]\n"


@pytest.mark.parametrize("lift, drag", [([0, 1], [0, -1]), ([3, 0.3, 0, 0.7], [2, -0.3, 0, -0.7])], ids=["all", "but for a constant"])
def test_loads_that_add_up_to_nothing(folder, lift, drag):
    """Steps then went from rounding error to rounding error. Of a model, and of the reduced file that is made of it."""
    write_model(folder / "model.h5", forces__lift=np.arange(5) / 3, forces__drag=np.arange(5) / 3)
    begin = CASE.index("[excitation]")
    text = CASE[:begin] + CASE[CASE.index("[contact]"):]
    cancelling = "".join((LOADS % name).replace("[0, 1]", str(course)) for name, course in (("lift", lift), ("drag", drag)))
    (folder / "case.toml").write_text(text + cancelling)
    said = ["case.toml:", "excitation.load.pattern = \"lift\"", "add up to no force that varies"]
    expect(run(folder), [*said, "model.h5"])
    (folder / "case.toml").write_text(text + LOADS % "lift")
    run(folder, status=0)
    (folder / "out/results.h5").unlink()
    text = text.replace('model = "model.h5"', 'reduced = "out/reduced.h5"').replace("[reduction]\nmodes = 2\n", "")
    (folder / "case.toml").write_text(text.replace('directory = "out"', 'directory = "next"') + cancelling)
    expect(run(folder), [*said, "reduced.h5"])


def test_loads_of_a_reduced_file(folder):
    """Names that are not there, names for other patterns than there are, and patterns without any force."""
    write_model(folder / "model.h5", forces__lift=np.ones(5), forces__rest=np.zeros(5))
    (folder / "case.toml").write_text(CASE)
    run(folder, status=0)
    (folder / "case.toml").rename(folder / "first.toml")
    (folder / "out/results.h5").unlink()
    text = CASE.replace('model = "model.h5"', 'reduced = "out/reduced.h5"').replace("[reduction]\nmodes = 2\n", "")
    text = text.replace('directory = "out"', 'directory = "next"')
    begin = text.index("[excitation]")
    text = text[:begin] + text[text.index("[contact]"):]
    (folder / "case.toml").write_text(text + LOADS % "lift" + LOADS % "drag")
    expect(run(folder), ["case.toml:", "excitation.load.pattern = \"drag\"", "reduced.h5", "it has \"force\", \"lift\", \"rest\""])
    (folder / "case.toml").write_text(text + LOADS % "rest")
    expect(run(folder), ["case.toml:", "\"rest\" has no force other than zero", "nothing would move"])
    (folder / "case.toml").write_text(text + (LOADS % "lift").replace("[0, 1]", "[5]") + LOADS % "rest")
    expect(run(folder), ["case.toml:", "load.pattern = \"rest\": of", "\"rest\" has no force other than zero", "would vibrate"])
    (folder / "case.toml").write_text(text + LOADS % "lift")
    for names, words in ((["a", "b"], ["force_names has 2 names", "3 load patterns"]), (["a", "b", "a"], ["one name twice"])):
        with h5py.File(folder / "out/reduced.h5", "a") as file:
            file.attrs["force_names"] = names
        expect(run(folder), ["reduced.h5", *words])


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_model_file_cut_short(folder, share):
    whole = (folder / "model.h5").read_bytes()
    (folder / "model.h5").write_bytes(whole[:int(share * len(whole))])
    expect(run(folder), ["model.h5"])


def test_more_modes_than_the_model_has(folder):
    (folder / "case.toml").write_text(CASE.replace("modes = 2", "modes = 50"))
    expect(run(folder), ["reduction.modes = 50", "model.h5"])


@pytest.mark.parametrize("ranks", [None, 2])
def test_nothing_that_could_move(folder, ranks):
    write_model(folder / "model.h5", dofs=np.zeros((0, 3)))
    (folder / "case.toml").write_text(CASE.replace("modes = 2", "modes = 0"))
    expect(run(folder, ranks=ranks), ["case.toml:4: reduction.modes = 0", "model.h5 has no contact points", "at least 1"])


@pytest.mark.parametrize("ranks", [None, 2])
@pytest.mark.parametrize("solver", ["modal", "assembled"])
def test_contact_dof_without_mass(folder, ranks, solver):
    write_model(folder / "model.h5", M=np.diag([1.0, 1, 1, 0, 1]))
    (folder / "case.toml").write_text(CASE.replace("samples = 64\n", f"samples = 64\nsolver = \"{solver}\"\n"))
    expect(run(folder, ranks=ranks), ["model.h5: the reduced mass matrix", "not positive definite", "contact dof needs mass"])


def test_out_below_a_file(folder):
    expect(run(folder, "--out", folder / "model.h5" / "out"), ["--out", "model.h5/out"])


def test_results_that_cannot_be_overwritten(folder):
    (folder / "out" / "results.h5").mkdir(parents=True)
    done = subprocess.run([BINARY, "run", folder / "case.toml"], capture_output=True, text=True, timeout=SECONDS, env=SURROUNDINGS)
    assert done.returncode == 2, done.stderr
    expect(done.stderr, ["case.toml:31: output.directory", "results.h5", "not a file"])


PARALLEL = {
    "case_file": (lambda folder: (folder / "case.toml").write_text(CASE.replace("samples = 64", "samples = 8")), "too small for harmonics"),
    "case_file_missing": (lambda folder: (folder / "case.toml").unlink(), "no such case file"),
    "output": (lambda folder: (folder / "case.toml").write_text(CASE.replace("\"out\"", "\"model.h5/out\"")), "model.h5/out"),
    "contact_length": (lambda folder: (folder / "case.toml").write_text(CASE.replace("gap = -3.5", "gap = [1, 2]")), "contact.gap"),
    "cut_short": (lambda folder: (folder / "model.h5").write_bytes((folder / "model.h5").read_bytes()[:900]), "model.h5"),
    "nan_on_one_rank": (lambda folder: write_model(folder / "model.h5", K=NAN), "/K"),
    "unsymmetric": (lambda folder: write_model(folder / "model.h5", K=SKEW), "symmetric"),
    "contact_dof": (lambda folder: write_model(folder / "model.h5", dofs=[(2, 3, 9)]), "/contact/dofs"),
    "force_of_zeros": (lambda folder: write_model(folder / "model.h5", force=np.zeros(5)), "no force other than zero"),
}


@pytest.mark.parametrize("name", PARALLEL)
@pytest.mark.slow
def test_two_ranks_stop_together_and_say_it_once(folder, name):
    spoil, word = PARALLEL[name]
    spoil(folder)
    message = run(folder, ranks=2)
    expect(message, [word])
    assert sum(word in line for line in message.splitlines()) == 1, message
