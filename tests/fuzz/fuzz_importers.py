"""The importers on changed files, for some time: with Atheris, which looks for inputs that reach new code, or where it is not
installed with random changes alone.

The work is done in a process of its own, which is started again when it crashes or hangs. What was found is kept in a folder, as a
copy of the file that stands in the place of one of the job.
"""

import argparse
import importlib.util
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import mutate
import verdict

BIG = 1 << 16  # bytes; larger files get random changes only
GIB = 1 << 30
HANG = 60  # seconds without an input done


class Harness:
    """Runs inputs: a job, one of its files, and what stands in its place."""

    def __init__(self, folder, importer_jobs, wanted=None):
        self.folder, self.importer_jobs = folder, importer_jobs
        (folder / "make").mkdir(parents=True, exist_ok=True)
        self.jobs = {name: job for name, job in importer_jobs.jobs(folder / "make").items() if not wanted or name in wanted}
        for name, job in self.jobs.items():
            importer_jobs.lay_out(job, folder / name)
        self.places = [(name, file) for name, job in sorted(self.jobs.items()) for file in job.files]

    def run(self, name, file, content):
        """None, or (where, traceback)."""
        path, job = self.folder / name / file, self.jobs[name]
        (self.folder / "current").write_text(f"{name}/{file}")
        path.write_bytes(content)
        try:
            return verdict.fault(lambda: job.run(path.parent), job.files)
        finally:
            path.write_bytes(job.files[file])


class Report:
    """Prints and keeps each kind of finding once."""

    def __init__(self, folder):
        self.folder = folder

    def __call__(self, where, place, content, text):
        label = "".join(c if c.isalnum() else "_" for c in where)
        kept = self.folder / place[0] / f"{place[1]}~{label}"
        if not kept.exists():
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_bytes(content)
            print(f"{place[0]}/{place[1]}: {where}\n    {text.strip().splitlines()[-1][:300]}\n    {kept}", flush=True)


def prepare():
    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (6 * GIB, 6 * GIB))


def plainly(folder, report, seed, wanted, end, all_places):
    """Random changes to the good files."""
    import importer_jobs

    harness, dice, count = Harness(folder, importer_jobs, wanted), random.Random(seed), 0
    places = [(name, file) for name, file in harness.places if all_places or len(harness.jobs[name].files[file]) > BIG]
    while time.time() < end and places:
        place = dice.choice(places)
        content = mutate.mutate(harness.jobs[place[0]].files[place[1]], dice)
        found = harness.run(*place, content)
        if found:
            report(found[0], place, content, found[1])
        count += 1
    print(f"importers: {count} random inputs", flush=True)


def guided(folder, report, seed, wanted, end):
    """With Atheris. An input is the number of the file it stands for, as one byte, and the content."""
    import atheris

    with atheris.instrument_imports(include=["dovetail"]):
        import importer_jobs

        import dovetail.importers as importers
        for kind in importers.FORMATS:
            __import__(f"dovetail.importers.{kind}")
    harness = Harness(folder, importer_jobs, wanted)
    places = [(name, file) for name, file in harness.places if len(harness.jobs[name].files[file]) <= BIG]
    corpus = folder / "corpus"
    corpus.mkdir(exist_ok=True)
    for i, (name, file) in enumerate(places):
        (corpus / f"{name}-{file}").write_bytes(bytes([i]) + harness.jobs[name].files[file])

    def test(data):
        place, content = places[data[0] % len(places) if data else 0], data[1:]
        found = harness.run(*place, content)
        if found:
            report(found[0], place, content, found[1])

    def custom(data, size, seed):
        dice = random.Random(seed)
        if dice.random() < 0.3:
            return atheris.Mutate(data, size)
        return (data[:1] + mutate.mutate(data[1:], dice))[:size]

    options = [f"-max_total_time={max(1, int(end - time.time()))}", f"-seed={seed}", f"-max_len={BIG}", "-rss_limit_mb=0", "-timeout=0",
               "-print_final_stats=1", f"-artifact_prefix={folder}/", str(corpus)]
    atheris.Setup([sys.argv[0], *options], test, custom_mutator=custom)
    atheris.Fuzz()


def supervise(command, folder, report, end):
    """Starts the worker until the time is over; a crash or a hang is a finding."""
    seed = 0
    while time.time() < end - 5:
        seed += 1
        worker = subprocess.Popen([*command, f"--seed={seed}", f"--end={end}"], start_new_session=True)
        marker, ending = folder / "current", None
        while ending is None:
            time.sleep(1)
            ending = worker.poll()
            late = marker.exists() and time.time() - max(marker.stat().st_mtime, end - 1e9) > HANG
            if ending is None and (late or time.time() > end + HANG):
                os.killpg(worker.pid, signal.SIGKILL)
                ending = "hang" if late and time.time() < end else worker.wait() and 0
        if ending in (0, 1):
            continue
        name, _, file = marker.read_text().partition("/")
        what = ending if ending == "hang" else f"ended with {ending}"
        report(what, (name, file), (folder / name / file).read_bytes(), f"{what}: not in Python")
        marker.unlink()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--keep", type=Path, default=Path("found"), help="folder for what was found")
    parser.add_argument("--jobs", nargs="+", help="some of importer_jobs only")
    parser.add_argument("--worker", help=argparse.SUPPRESS)
    parser.add_argument("--folder", help=argparse.SUPPRESS)
    parser.add_argument("--seed", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--end", type=float, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    report = Report(chosen.keep)
    if chosen.worker:
        prepare()
        work = {"guided": guided, "big": plainly, "plain": plainly}[chosen.worker]
        more = () if chosen.worker == "guided" else (chosen.worker == "plain",)
        work(Path(chosen.folder), report, chosen.seed, chosen.jobs, chosen.end, *more)
        return 0
    if importlib.util.find_spec("atheris"):
        shares = {"guided": 0.9, "big": 0.1}
    else:
        print("importers: Atheris is not installed; random changes only", flush=True)
        shares = {"plain": 1.0}
    before = set(chosen.keep.rglob("*~*"))
    for worker, share in shares.items():
        with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
            command = [sys.executable, __file__, "--worker", worker, "--folder", folder, "--keep", str(chosen.keep)]
            command += ["--jobs", *chosen.jobs] if chosen.jobs else []
            supervise(command, Path(folder), report, time.time() + share * chosen.seconds)
    found = set(chosen.keep.rglob("*~*")) - before
    print(f"importers: {len(found)} findings")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
