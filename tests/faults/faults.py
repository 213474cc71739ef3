"""Lets single calls of small runs fail, one a run, and tabulates what becomes of the run: see docs/developer/testing.md.

A fault must end the run within a minute, on all ranks, with a message and status 3 or 2; what was computed can be read; and the
next run, with --restart where there is something to go on from, gives the branch that an undisturbed one gives.
"""

import argparse
import os
import random
import shutil
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "python"), *(str(ROOT / "tests" / folder) for folder in ("", "verification"))]

from trial import KINDS, Scene, Trial  # noqa: E402

FINDINGS = {"hang": "hangs", "loss": "losses", "crash": "crashes", "silent": "silent wrong", "mute": "no message", "status": "other status",
            "told": "crashes told"}


def trials_of(scene, counts, kinds, most, dice):
    """All calls of every kind on every rank, or `most` of each kind and rank."""
    for kind in kinds:
        for rank, count in enumerate(counts):
            calls = range(1, count[kind] + 1)
            for k in sorted(dice.sample(calls, most)) if most and most < len(calls) else calls:
                yield Trial(scene, kind, rank, k)


def attempt(trial, folder):
    """Where ranks that wait for each other make fewer calls than were counted, and so not the k-th, an earlier one is to fail."""
    own = folder / f"{trial.scene.name}{trial.scene.ranks}-{trial.kind}-{trial.rank}-{trial.k}"
    trial.scene.attempt(trial, own)
    shutil.rmtree(own, ignore_errors=True)
    if trial.call or trial.verdict or trial.k == 1:
        return trial
    trial.k //= 2
    return attempt(trial, folder)


def told(trial):
    """A finding, in lines."""
    where = f"{trial.scene.name}, {trial.scene.ranks} ranks, rank {trial.rank}: {trial.kind} {trial.k}"
    callers = [line for line in trial.call.splitlines() if "libfault.so" not in line]
    return "\n    ".join([f"{FINDINGS[trial.verdict]}: {where}: status {trial.status}: {trial.why}", *callers])


def table(calls, done):
    """In the manner of a Markdown document, so that a note can take it."""
    heads = ["kind", "calls", "tried", *FINDINGS.values()]
    lines = ["| " + " | ".join(heads) + " |", "|---|" + "---:|" * (len(heads) - 1)]
    for kind in calls:
        of_kind = [trial for trial in done if trial.kind == kind]
        found = Counter(trial.verdict for trial in of_kind)
        lines.append("| " + " | ".join(map(str, [kind, calls[kind], len(of_kind), *(found[name] for name in FINDINGS)])) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--most", type=int, default=3, help="calls of each kind, rank and scene; 0: all")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--scenes", nargs="+", choices=["fresh", "again", "restart"], default=["fresh", "again", "restart"])
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at a time")
    parser.add_argument("--messages", action="store_true", help="also what the runs said, with how often")
    parser.add_argument("program", type=Path)
    parser.add_argument("library", type=Path, help="libfault.so")
    chosen = parser.parse_args()
    dice, calls, done, messages = random.Random(chosen.seed), Counter(), [], Counter()
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder, ThreadPoolExecutor(chosen.jobs) as threads:
        folder, waiting = Path(folder), []
        for ranks in chosen.ranks:
            for name in chosen.scenes:
                scene = Scene(name, chosen.program.resolve(), chosen.library.resolve(), folder, ranks)
                counts = scene.count(folder / "count")
                shutil.rmtree(folder / "count")
                for count in counts:
                    calls.update({kind: count[kind] for kind in chosen.kinds})
                waiting += [threads.submit(attempt, trial, folder)
                            for trial in trials_of(scene, counts, chosen.kinds, chosen.most, dice)]
        for future in waiting:
            trial = future.result()
            done.append(trial)
            messages.update(line.replace(str(folder), "") for line in trial.said)
            if trial.verdict:
                print(told(trial), flush=True)
    if chosen.messages:
        for text, count in sorted(messages.items()):
            print(f"{count:5d} {text}")
    print(table(calls, done))
    return any(trial.verdict for trial in done)


if __name__ == "__main__":
    sys.exit(main())
