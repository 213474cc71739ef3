"""Changes a line of a source file, runs the tests that guard it, and tabulates how many such changes they notice.

See docs/developer/testing.md. Reads the tree and its build folder, and writes to a temporary folder and the file of --kept alone.
"""

import argparse
import hashlib
import json
import os
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from operators import mutants
from rooms import CPP, PYTHON, CppRoom, Mutant, PythonRoom

ROOT = Path(__file__).resolve().parents[2]
VERDICTS = ["killed near", "killed far", "survived", "survived near", "equivalent", "not compiled"]


def room_of(name, scratch, near):
    if name in CPP:
        return CppRoom(name, ROOT, scratch, near)
    sources, own, others = PYTHON[name]
    return PythonRoom(ROOT, scratch, sources, own, None if near else others)


def mutants_of(room):
    """All mutants of a room's files, in order."""
    for source in room.sources:
        text = source.read_text()
        lines, file = text.splitlines(), str(source.relative_to(room.root))
        yield from (Mutant(file, line, lines[line - 1], after) for line, after in mutants(text, source.suffix))


def key_of(mutant):
    """The same as long as the file is."""
    return hashlib.sha256((ROOT / mutant.file).read_bytes() + f"{mutant.line} {mutant.after}".encode()).hexdigest()[:24]


def told(mutant):
    """A survivor, in lines: what is, and what could be."""
    return f"{mutant.file}:{mutant.line}\n    - {mutant.before.strip()}\n    + {mutant.after.strip()}"


def table(counts):
    """Of {room: {verdict: number}}, in the manner of a Markdown document, so that a note can take it."""
    lines = ["| room | mutants | " + " | ".join(VERDICTS) + " | score near | score |", "|---|" + "---:|" * (len(VERDICTS) + 3)]
    if len(counts) > 1:
        counts = counts | {"all": sum(counts.values(), Counter())}
    for room, found in counts.items():
        near, judged = found["killed near"], sum(found[verdict] for verdict in VERDICTS[:4])
        scores = [f"{100 * killed / judged:.0f} %" if judged else "" for killed in (near, near + found["killed far"])]
        lines.append("| " + " | ".join(map(str, [room, sum(found.values()), *(found[verdict] for verdict in VERDICTS), *scores])) + " |")
    return "\n".join(lines)


def known_verdicts(kept, again):
    """Verdicts of before, by key; without survivors if these are tried again."""
    entries = [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []
    return {entry["key"]: entry["verdict"] for entry in entries if not (again and entry["verdict"].startswith("survived"))}


def try_room(name, chosen, known, scratch):
    """Counts by verdict, and the survivors, of the room's share of mutants."""
    room = room_of(name, scratch, chosen.near)
    wanted = list(mutants_of(room))
    random.Random(f"{chosen.seed} {name}").shuffle(wanted)
    if chosen.at:
        wanted = [mutant for mutant in wanted if {mutant.file, f"{mutant.file}:{mutant.line}"} & set(chosen.at)]
    counts, survivors, begin = Counter(), [], time.monotonic()
    for mutant in wanted[:chosen.mutants]:
        key = key_of(mutant)
        before = known.get(key)
        if before is None or before == "survived near" and not chosen.near:
            if time.monotonic() - begin > 60 * chosen.minutes:
                break
            known[key], killer = room.verdict(mutant, before is not None)
            with chosen.kept.open("a") as file:
                file.write(json.dumps({"key": key, "verdict": known[key], "by": killer, "at": told(mutant)}) + "\n")
            print(f"{known[key]}: {mutant.file}:{mutant.line} {killer}", file=sys.stderr, flush=True)
        counts[known[key]] += 1
        if known[key].startswith("survived"):
            survivors.append(mutant)
    return counts, survivors


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--room", nargs="+", choices=[*CPP, *PYTHON], default=[*CPP, *PYTHON])
    parser.add_argument("--mutants", type=int, default=30, help="of each room, at most")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="for each room; then no further mutant is begun")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--at", nargs="+", metavar="FILE[:LINE]", help="only mutants of these places")
    parser.add_argument("--near", action="store_true", help="by the room's own tests alone; without it, survivors are judged by the rest")
    parser.add_argument("--kept", type=Path, default=ROOT / "build" / "mutation.jsonl", help="verdicts, which the next call goes on from")
    parser.add_argument("--again", action="store_true", help="try survivors again, after a test was added")
    chosen = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C does, so that the temporary folder goes
    known, counts, survivors = known_verdicts(chosen.kept, chosen.again), {}, []
    for name in chosen.room:
        with tempfile.TemporaryDirectory(prefix="dovetail-mutation-") as scratch:
            os.environ["TMPDIR"] = scratch  # of all tests
            counts[name], survived = try_room(name, chosen, known, Path(scratch))
            del os.environ["TMPDIR"]
        survivors += survived
    for mutant in survivors:
        print("survived:", told(mutant))
    print(table(counts))


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("mutation: interrupted; the same command goes on")
