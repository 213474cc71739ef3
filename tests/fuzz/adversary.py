"""Attempts of an adversary on the program and the package, each one judged, in a table: see docs/developer/testing.md.

An attempt may be refused in words with status 2, which leaves the files of the earlier run as they were; it may run, and then the NumPy
reference must call the answer right; or it may be stopped in words with status 3. Everything else is a finding.
"""

import argparse
import os
import random
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "tests"), str(ROOT / "tests/fuzz")]

import attempts_on_input as on_input  # noqa: E402
import attempts_on_run as on_run  # noqa: E402
from attempt import BAD, GOOD, Adversary  # noqa: E402


def all_attempts(adversary, seed, scale=1.0):
    """Those that are listed, and of what is drawn as many as `scale` says."""
    dice, start = random.Random(seed), adversary.start

    def many(count):
        return max(1, round(scale * count))
    found = [*on_input.case_keys(adversary.program, dice, many(160)), *on_input.case_texts(), *on_input.damaged_case(dice, many(40)),
             *on_input.model_numbers(), *on_input.model_files(dice, many(80), many(10)),
             *on_input.restart_files(start, dice, many(20), many(4)),
             *on_input.imports(adversary.folder / "jobs", dice, many(4)), *on_input.readers(dice, many(4)), *on_run.commands(),
             *on_run.surroundings(), *on_run.folders(), *on_run.signals(dice, many(4))]
    return [*found, *on_run.on_ranks(found, dice, many(60))]


def table(done):
    """In the manner of a Markdown document, so that a note can take it."""
    heads = ["kind", "attempts", *GOOD, *BAD.values()]
    lines = ["| " + " | ".join(heads) + " |", "|---|" + "---:|" * (len(heads) - 1)]
    kinds = list(dict.fromkeys(attempt.kind for attempt in done))
    for kind in [*kinds, None]:
        found = Counter(attempt.outcome for attempt in done if kind in (attempt.kind, None))
        lines.append("| " + " | ".join(map(str, [kind or "all", found.total(), *(found[name] or "" for name in (*GOOD, *BAD))])) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scale", type=float, default=1.0, help="of the attempts that are drawn")
    parser.add_argument("--only", default="", help="a part of the kind and name")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at a time")
    parser.add_argument("--say", action="store_true", help="also what became of the good ones")
    parser.add_argument("program", type=Path)
    chosen = parser.parse_args()
    done = []
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder, ThreadPoolExecutor(chosen.jobs) as threads:
        adversary = Adversary(chosen.program, folder)
        attempts = [attempt for attempt in all_attempts(adversary, chosen.seed, chosen.scale)
                    if chosen.only in f"{attempt.kind}: {attempt.name}"]
        for attempt in threads.map(adversary.attempt, attempts):
            done.append(attempt)
            if attempt.outcome in BAD or chosen.say:
                print(f"{BAD.get(attempt.outcome, attempt.outcome)}: {attempt.kind}: {attempt.name}: {attempt.why}", flush=True)
    print(table(done))
    return any(attempt.outcome in BAD for attempt in done)


if __name__ == "__main__":
    sys.exit(main())
