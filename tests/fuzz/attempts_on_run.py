"""What an adversary does around a run: its command line, output folder, surroundings, ranks and signals."""

import fcntl
import shutil
import signal
from dataclasses import replace

from attempt import Attempt, many_points, rewrite

LONG = "x" * 300
REFUSED = [(), ("",), ("run",), ("run", ""), ("run", "absent.toml"), ("run", "."), ("run", "/dev/null"), ("run", "out"), ("run",
                                                                                                                          "case.toml",
                                                                                                                          "case.toml"),
           ("run", "case.toml", "--out"), ("run", "case.toml", "--out", "a", "--out", "b"), ("run", "case.toml", "--out", ""),
           ("run", "case.toml", "--restrat"), ("run", "case.toml", "--"), ("run", "case.toml", "\u2014restart"), ("rnu", "case.toml"),
           ("run", "reduce", "case.toml"), ("reduce", "case.toml", "--restart"), ("check", "case.toml", "--restart"), ("modes",
                                                                                                                       "case.toml",
                                                                                                                       "--dry-run"),
           ("--restart",), ("run", LONG * 20), ("run", "case.toml\n"), ("run", "case.toml", "--out=a"),
           ("RUN", "case.toml"), ("run", "model.h5"), ("run", "case.toml", "x" * 100_000), ("run", "case.toml", "-options_file", "absent")]
OTHER_MODES = ["-modes_eps_nev 5", "-modes_eps_type absent", "-modes_st_shift 3", "-modes_eps_ncv 1", "-modes_eps_target 2",
               "-modes_eps_largest_real"]
TAKEN = [("--help",), ("--version", "-v"), ("--schema",), ("--version", "case.toml"), ("check", "case.toml"), ("modes", "case.toml"),
         ("run", "case.toml", "--dry-run"),
         ("run", "case.toml", "--restart", "--restart"), ("run", "--out", "new", "case.toml"), ("run", "./case.toml"), ("run",
                                                                                                                        "out/../case.toml")]
PETSC = ["-absent", "-absent 3", "-log_view", "-log_view :/dev/full", "-options_left", "-options_view", "-malloc_debug", "-malloc_dump",
         "-no_signal_handler", "-info :absent/x", "-info", "-version", "-help", "-vec_type absent", "-mat_type absent",
         "-dm_vec_type cuda", "-hb_ksp_type absent",
         "-hb_pc_type absent", "-hb_snes_max_it 0", "-hb_snes_max_it -5", "-hb_snes_rtol nan", "-hb_snes_rtol 1e300", "-hb_snes_stol abc",
         "-hb_snes_type absent", "-kee_mat_mumps_icntl_7 99", "-kee_mat_mumps_icntl_14 -50", "-kee_mat_mumps_icntl_23 1",
         "-kee_mat_mumps_cntl_1 nan", "-kee_pc_type none",
         "-kee_pc_type lu", "-kee_whole maybe", "-modes_eps_tol 0", "-modes_eps_tol nan", "-modes_eps_tol 1e300", "-modes_eps_max_it 0",
         "-modes_eps_ncv 1",
         "-modes_eps_ncv 1000000000", "-hb_modal_ksp_rtol 1e300", "-hb_modal_ksp_max_it 0", "-hb_factors_most -1", "-hb_factors_most abc",
         "-preload_ksp_type absent",
         "-preload_ksp_max_it 1", "-options_file", "-prefix_push a -prefix_pop -prefix_pop", "-", "--absent", "-log_view\n", "-memory_view",
         "-check_pointer_intensity 99", "-objects_dump", "-get_total_flops", "-log_trace", "-saws_options", "-viewfromoptions x",
         "-on_error_abort"]
SURROUNDINGS = {"no home": {"HOME": ""}, "a home that is not there": {"HOME": "/absent"}, "no threads": {"OMP_NUM_THREADS": "0"},
                "threads in words": {"OMP_NUM_THREADS": "many", "OPENBLAS_NUM_THREADS": "many"},
                "a thousand threads": {"OMP_NUM_THREADS": "1000"},
                "an unknown kernel": {"OPENBLAS_CORETYPE": "absent"}, "an empty kernel": {"OPENBLAS_CORETYPE": ""},
                "the oldest kernel": {"OPENBLAS_CORETYPE": "Prescott"},
                "an unknown language": {"LC_ALL": "xx_YY.UTF-8", "LANG": "xx"}, "another decimal point": {"LC_ALL": "de_DE.UTF-8",
                                                                                                          "LC_NUMERIC": "de_DE.UTF-8"},
                "no terminal of that name": {"TERM": "absent"}, "columns of nothing": {"COLUMNS": "0", "LINES": "-1"},
                "columns in words": {"COLUMNS": "wide"},
                "no folder for what is passing": {"TMPDIR": "/absent"}, "locks of HDF5 refused": {"HDF5_USE_FILE_LOCKING": "FALSE"},
                "a plugin folder of HDF5": {"HDF5_PLUGIN_PATH": "/absent"}, "another time zone": {"TZ": ":/etc/passwd"},
                "a date in the past": {"SOURCE_DATE_EPOCH": "-1"},
                "an empty path": {"PATH": ""}, "memory that is checked": {"MALLOC_CHECK_": "3", "MALLOC_PERTURB_": "165"},
                "a parameter of MPI in words": {"OMPI_MCA_mpi_yield_when_idle": "maybe"}, "a very long variable": {"LONG": "x" * 100_000}}


def commands():
    for words in REFUSED:
        yield Attempt("command line", repr(" ".join(words))[:60], words=words, refuse=True)
    for words in TAKEN:
        yield Attempt("command line", " ".join(words), words=words)
    for text in OTHER_MODES:
        yield Attempt("options of PETSc", text, lambda folder: shutil.rmtree(folder / "out"), ("run", "case.toml", *text.split()),
                      refuse=True)
    for text in PETSC:
        yield Attempt("options of PETSc", f"behind the case: {text}", words=("run", "case.toml", *text.split(" ")))
    for text in PETSC[::3]:
        yield Attempt("options of PETSc", f"PETSC_OPTIONS={text}", surroundings={"PETSC_OPTIONS": text})
    for text in (*PETSC[::4], "-hb_snes_max_it 1\n-log_view", "\0", "#" * 10_000):
        yield Attempt("options of PETSc", f".petscrc: {text[:30]!r}", lambda folder,
                      text=text: (folder / ".petscrc").write_text(text + "\n"))


def surroundings():
    for name, changed in SURROUNDINGS.items():
        yield Attempt("surroundings", name, surroundings=changed)
    yield Attempt("surroundings", "a full device for the output", stdout="/dev/full")
    for stream in (0, 1, 2):
        yield Attempt("surroundings", f"stream {stream} closed", closed=stream)


def beside(*steps):
    """Changes of the output folder, done by its path."""
    return lambda folder: [step(folder / "out") for step in steps]


def in_the_way(name):
    def make(out):
        (out / name).unlink(missing_ok=True)
        (out / name).mkdir()
        (out / name / "kept.txt").write_text("of somebody else")
    return make


def linked(name, target):
    def make(out):
        (out / name).unlink(missing_ok=True)
        (out / name).symlink_to(target)
    return make


def another_file(name):
    return lambda out: (out / name).write_text("of somebody else")


def as_file(out):
    out.rename(out.with_name("earlier"))
    out.write_text("of somebody else")


def as_link(target):
    def make(out):
        out.rename(out.with_name("earlier"))
        out.symlink_to(target)
    return make


held_files = []  # stay open, and so locked, as long as this process lives


def held(out):
    file = open(out / "dovetail.lock", "w")
    fcntl.flock(file, fcntl.LOCK_EX)
    held_files.append(file)


def folders():
    files = ("results.h5", "reduced.h5", "state.h5", "summary.json", "dovetail.lock", "case.toml")
    for name in files:
        yield Attempt("output folder", f"a folder in the place of {name}", beside(in_the_way(name)))
        yield Attempt("output folder", f"{name} a link to nowhere", beside(linked(name, "absent")))
        yield Attempt("output folder", f"{name} a link to the model", beside(linked(name, "../model.h5")))
        yield Attempt("output folder", f"{name} a link to itself", beside(linked(name, name)))
        yield Attempt("output folder", f"{name} of somebody else", beside(another_file(name)))
        yield Attempt("output folder", f"{name}.partial of somebody else", beside(another_file(f"{name}.partial")))
    yield Attempt("output folder", "a file in its place", beside(as_file), refuse=True)
    for target in ("absent", "out", "earlier", "model.h5", "/dev/null", "/proc/self"):
        yield Attempt("output folder", f"a link to {target}", beside(as_link(target)), refuse=target != "earlier")
    for name in ("/proc/x", "/sys/x", "/dev/null/x", "/dev/full", "model.h5", "case.toml/x", "x" * 300, "y/" * 3000, "a\x01"):
        yield Attempt("output folder", f"--out {name[:30]!r}", words=("run", "case.toml", "--out", name), refuse=len(name) > 2)
    for name in ("with blanks", "with\nan end of line", "with\ttab", "\u00e9\u4e2d\U0001f529", '"quoted"', "'", "-dash", "--out", "*",
                 "$HOME", "a;rm -rf b", "%s%n", "\\", " ", "~",
                 "a/b/c/d", ".", "..x", "new/../other", "\x1b[2J"):
        yield Attempt("output folder", f"--out {name!r}", words=("run", "case.toml", "--out", name))
    yield Attempt("output folder", "held by another run", beside(held), refuse=True)
    yield Attempt("output folder", "held by another run, --restart", beside(held), ("run", "case.toml", "--restart"), refuse=True)
    for bytes_ in (1, 100, 1000, 4096, 10_000, 20_000, 40_000, 100_000, 220_000, 250_000):
        yield Attempt("output folder", f"no space beyond {bytes_} bytes", largest_file=bytes_)
        yield Attempt("output folder", f"no space beyond {bytes_} bytes, --restart", rewrite(continuation__max_points="40"), ("run",
                                                                                                                              "case.toml",
                                                                                                                              "--restart"),
                      largest_file=bytes_)


def signals(dice, each):
    for name in ("SIGTERM", "SIGINT", "SIGHUP", "SIGUSR1", "SIGKILL", "SIGQUIT", "SIGALRM", "SIGPIPE", "SIGUSR2"):
        for _ in range(each):
            after = dice.uniform(0.1, 2.5)
            yield Attempt("signals", f"{name} after {after:.3f} of the time", many_points, interrupt=(getattr(signal, name), after))


def on_ranks(attempts, dice, count):
    """Some of those that are refused by one rank or run on it, on two to four ranks: one contact point, two modes."""
    plain = [attempt for attempt in attempts if attempt.words[:1] == ("run",) and not (attempt.interrupt or attempt.largest_file)
             and attempt.kind not in ("surroundings", "options of PETSc", "command line")]
    for ranks in (2, 3, 4):
        yield Attempt("more ranks than points", f"{ranks} ranks", ranks=ranks)
    for attempt in dice.sample(plain, min(count, len(plain))):
        yield replace(attempt, kind="more ranks than points", name=f"{attempt.kind}: {attempt.name}", ranks=dice.choice((2, 2, 3)))
