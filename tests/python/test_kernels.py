"""A better kernel of OpenBLAS is taken where OpenBLAS does not know the processor; the user's choice is left alone."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import cases
import launch
from launch import BINARY, SURROUNDINGS
from dovetail import blas_kernel

CHOICE = "OPENBLAS_CORETYPE"
PROCESSOR = blas_kernel.class_of_processor()
BEST = blas_kernel.better("Prescott", PROCESSOR)
TAKEN = f"{BEST} (chosen by Dovetail instead of Prescott)"
SHIM = Path(__file__).with_name("unknown_processor.cpp")
REFERENCE = Path("/usr/lib/x86_64-linux-gnu")  # where Debian has the reference BLAS, under blas and lapack
KERNELS = ["Prescott", "Core2", "Nehalem", "Sandybridge", "Haswell", "Zen", "SkylakeX"]  # of every OpenBLAS

pytestmark = pytest.mark.skipif(not BEST or not blas_kernel.kernel_at_work().name,
                                reason="BLAS is not OpenBLAS, or the processor has no AVX2: there is no better kernel to take")


@pytest.fixture(scope="module")
def shim(tmp_path_factory):
    library = tmp_path_factory.mktemp("shim") / "unknown_processor.so"
    subprocess.run([os.environ.get("CXX", "c++"), "-shared", "-fPIC", "-O1", "-o", library, SHIM, "-ldl"], check=True)
    return library


@pytest.fixture
def unknown(shim, tmp_path):
    """An environment in which OpenBLAS does not know the processor."""
    return {name: value for name, value in SURROUNDINGS.items() if name != CHOICE} | {
        "LD_PRELOAD": str(shim), "STARTS": str(tmp_path / "starts"),
        "ASAN_OPTIONS": "verify_asan_link_order=0:detect_leaks=0"}


def starts(environment, name):
    """Of every process of this name: OPENBLAS_CORETYPE at each of its starts, and last at its end."""
    found = {}
    for line in Path(environment["STARTS"]).read_text().splitlines():
        process, number, kernel = line.rsplit(" ", 2)
        if process == name:
            found.setdefault(number, []).append(kernel)
    return list(found.values())


def words(command, environment, **where):
    done = subprocess.run(list(map(str, command)), env=environment, capture_output=True, text=True,
                          timeout=launch.SECONDS, **where)
    assert done.returncode == 0, done.stderr
    return done


def kernel_in(text):
    """What --version -v says after "kernel"."""
    return next(line for line in text.splitlines() if line.startswith("BLAS ")).partition(", kernel ")[2]


@pytest.mark.parametrize("ranks", [None, 2])
def test_a_run_takes_a_better_kernel(unknown, tmp_path, monkeypatch, ranks):
    monkeypatch.setattr(launch, "SURROUNDINGS", unknown)
    folder = tmp_path / "with a space"
    folder.mkdir()
    case = cases.dof5(folder, harmonics=3, samples=32, omega=[0.9, 0.9])
    done = launch.run(case, "-hb_ksp_type", "preonly", ranks=ranks, out="out two")
    assert done.out.count("OpenBLAS kernel") == 1 and f"OpenBLAS kernel: {TAKEN}\n" in done.out
    assert done.folder.name == "out two"
    assert done.summary["blas_kernel"] == BEST and done.summary["ranks"] == (ranks or 1)
    assert starts(unknown, BINARY.name) == [["none", BEST, "none"]] * (ranks or 1)  # anew once; children find no choice


@pytest.mark.parametrize("way", ["absolute", "relative", "path", "link", "mpirun"])
def test_however_the_program_was_found(unknown, tmp_path, way):
    (tmp_path / "link").symlink_to(BINARY)
    command = {"absolute": [BINARY], "relative": [f"./{BINARY.name}"], "path": [BINARY.name],
               "link": [tmp_path / "link"], "mpirun": ["mpirun", "-n", "1", BINARY.name]}[way]
    unknown["PATH"] = f"{BINARY.parent}:{unknown['PATH']}"
    done = words([*command, "--version", "-v"], unknown, cwd=BINARY.parent)
    assert kernel_in(done.stdout) == TAKEN
    assert starts(unknown, "link" if way == "link" else BINARY.name) == [["none", BEST, "none"]]


@pytest.mark.parametrize("chosen", ["Prescott", BEST, ""])
def test_the_choice_of_the_user_stays(unknown, chosen):
    unknown[CHOICE] = chosen
    for command, name in ([BINARY], BINARY.name), ([sys.executable, "-m", "dovetail"], Path(sys.executable).name):
        done = words([*command, "--version", "-v"], unknown)
        said = kernel_in(done.stdout)
        assert "Dovetail" not in said and done.stderr == ""
        assert starts(unknown, name) == [[chosen, chosen]]
        if chosen == BEST:
            assert said == f"{BEST} (set by {CHOICE})"
        elif chosen:
            assert said == f"Prescott (set by {CHOICE}; {BEST} would suit this processor)"
        else:  # OpenBLAS looks for a kernel of this name, and then takes what suits the processor
            assert f'(not "", as {CHOICE} asks for' in said


def test_the_log_tells_of_a_slow_kernel_set_by_the_user(unknown, tmp_path, monkeypatch):
    monkeypatch.setattr(launch, "SURROUNDINGS", unknown | {CHOICE: "Prescott"})
    done = launch.run(cases.dof5(tmp_path, harmonics=3, samples=32, omega=[0.9, 0.9]))
    assert f"OpenBLAS kernel: Prescott (set by {CHOICE}; {BEST} would suit this processor)\n" in done.out
    monkeypatch.setattr(launch, "SURROUNDINGS", unknown | {CHOICE: BEST})
    done = launch.run(cases.dof5(tmp_path, harmonics=3, samples=32, omega=[0.9, 0.9]))
    assert "OpenBLAS" not in done.out and done.summary["blas_kernel"] == BEST


def test_a_library_that_does_not_listen_is_asked_once(unknown):
    unknown["DEAF_OPENBLAS"] = "1"
    told = f"Prescott (though Dovetail asked for {BEST} instead of Prescott; {BEST} would suit this processor)"
    for command, name in ([BINARY], BINARY.name), ([sys.executable, "-m", "dovetail"], Path(sys.executable).name):
        assert kernel_in(words([*command, "--version", "-v"], unknown).stdout) == told
        assert starts(unknown, name) == [["none", BEST, "none"]]


def test_a_program_that_cannot_be_started_anew_goes_on(unknown):
    """Started from an open file that is closed meanwhile, it has no path to itself."""
    start = ("import os, sys; file = os.open(sys.argv[1], os.O_RDONLY | os.O_CLOEXEC); "
             "os.execve(file, sys.argv[1:], os.environ)")
    done = words([sys.executable, "-c", start, BINARY, "--version", "-v"], unknown)
    assert kernel_in(done.stdout) == f"Prescott (chosen by OpenBLAS; {BEST} would suit this processor)"
    assert starts(unknown, BINARY.name) == [["none", "none"]]


def test_the_command_of_the_package_takes_a_better_kernel(unknown):
    done = words([sys.executable, "-m", "dovetail", "--version", "-v"], unknown)
    assert kernel_in(done.stdout) == TAKEN and done.stderr == ""
    assert starts(unknown, Path(sys.executable).name) == [["none", BEST, "none"]]


@pytest.mark.slow
def test_a_script_that_imports_the_package_is_warned_and_left_alone(unknown, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("import dovetail\nprint(dovetail.__version__)\n")
    name = Path(sys.executable).name
    done = words([sys.executable, script], unknown)
    told = f"RuntimeWarning: OpenBLAS kernel: Prescott (chosen by OpenBLAS; {BEST} would suit this processor)"
    assert f"script.py:1: {told}" in done.stderr and f"{CHOICE}={BEST}" in done.stderr
    assert starts(unknown, name) == [["none", "none"]]
    assert words([sys.executable, script], unknown | {CHOICE: "Prescott"}).stderr == ""
    done = words([sys.executable, "-m", "script"], unknown, cwd=tmp_path)
    assert "RuntimeWarning" in done.stderr


@pytest.mark.parametrize("kernel", [pytest.param(kernel, marks=() if kernel in ("Prescott", "Haswell", "SkylakeX") else pytest.mark.slow)
                                    for kernel in KERNELS])
def test_program_and_package_say_the_same(kernel):
    if blas_kernel.class_of(kernel) > PROCESSOR:
        pytest.skip("not on this processor")
    environment = SURROUNDINGS | {CHOICE: kernel}
    program, package = (kernel_in(words([*command, "--version", "-v"], environment).stdout)
                        for command in ([BINARY], [sys.executable, "-m", "dovetail"]))
    assert program == package and program.startswith(f"{kernel} (set by {CHOICE}")
    assert ("would suit" in program) == (blas_kernel.class_of(kernel) < PROCESSOR)


def test_versions_need_no_launcher(tmp_path):
    lines = words([BINARY, "--version", "-v"], SURROUNDINGS, cwd=tmp_path).stdout.splitlines()
    names = ["dovetail", "PETSc", "SLEPc", "MUMPS", "MPI", "BLAS", "HDF5", "compiler"]
    assert [line.split()[0] for line in lines] == names
    assert all(any(letter.isdigit() for letter in line) for line in lines if not line.startswith("BLAS"))
    short = words([BINARY, "--version"], SURROUNDINGS).stdout
    assert short.split() == lines[0].split() and short.count("\n") == 1


@pytest.mark.parametrize("flags, kernel", [
    ("sse2 avx avx2 fma avx512f avx512dq avx512bw avx512vl avx512cd", "SkylakeX"),
    ("sse2 avx avx2 fma avx512f avx512cd", "Haswell"), ("sse2 avx avx2 fma", "Haswell"),
    ("sse2 avx avx2", "Sandybridge"), ("sse2 avx", "Sandybridge"), ("sse2", "")])
def test_what_suits_a_processor(tmp_path, flags, kernel):
    file = tmp_path / "cpuinfo"
    file.write_text(f"processor : 0\nflags\t\t: fpu {flags}\n")
    assert blas_kernel.better("Prescott", blas_kernel.class_of_processor(file)) == kernel


def test_other_processors_are_left_alone(tmp_path):
    (tmp_path / "arm").write_text("processor : 0\nFeatures : fp asimd\n")
    for file in (tmp_path / "arm", tmp_path / "none"):
        assert blas_kernel.class_of_processor(file) is None
    assert blas_kernel.better("NEOVERSEN1", blas_kernel.AVX512) == blas_kernel.better("Prescott", None) == ""


@pytest.mark.skipif(not all((REFERENCE / name).exists() for name in ("blas/libblas.so.3", "lapack/liblapack.so.3")),
                    reason="needs the reference BLAS where Debian's libblas3 and liblapack3 put it")
def test_another_blas_is_named_by_its_file(unknown):
    unknown["LD_LIBRARY_PATH"] = f"{REFERENCE}/blas:{REFERENCE}/lapack"
    done = words([BINARY, "--version", "-v"], unknown)
    assert "blas/libblas.so.3\n" in done.stdout and "kernel" not in done.stdout
    done = words([sys.executable, "-m", "dovetail", "--version", "-v"], unknown)
    assert "kernel" not in done.stdout and done.stderr == ""
    for name in (BINARY.name, Path(sys.executable).name):  # neither is started anew
        assert starts(unknown, name) == [["none", "none"]]
