"""Properties of random structures in rounds, with a table at the end: `scripts/properties --help`."""

import argparse
import sys
import time
import traceback

from conftest import SESSIONS
from properties import PROPERTIES, Count, judge

ROUND = 25  # examples of a property, by one seed; a failure ends its round, which hypothesis then makes small


def table(counts):
    lines = ["| property | examples | no first point | another solution | failures |", "|---|---|---|---|---|"]
    for name, count in counts.items():
        lines.append(f"| {name} | {count.judged} | {count.without} | {count.others} | {len(count.failures)} |")
    total = [sum(getattr(count, key) for count in counts.values()) for key in ("judged", "without", "others")]
    return "\n".join([*lines, "| all | {} | {} | {} | {} |".format(*total, sum(len(count.failures) for count in counts.values()))])


def main(words):
    parser = argparse.ArgumentParser(prog="scripts/properties", description="Draw random structures, run each in two ways, and see whether "
                                     f"the properties of tests/verification/properties.py hold: rounds of {ROUND} examples of each.")
    parser.add_argument("names", nargs="*", metavar="PROPERTY", help="default: all; there are " + ", ".join(PROPERTIES))
    parser.add_argument("--rounds", type=int, default=6, help="default: %(default)s")
    parser.add_argument("--seed", type=int, default=1, help="of the first round, the next ones count on: where an earlier call has ended, "
                        "this one goes on; default: %(default)s")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="begin no property after so many")
    arguments = parser.parse_args(words)
    if unknown := set(arguments.names) - set(PROPERTIES):
        parser.error(f"no property {', '.join(sorted(unknown))}; there are {', '.join(PROPERTIES)}")
    counts, end = {name: Count() for name in arguments.names or PROPERTIES}, time.monotonic() + 60 * arguments.minutes
    seed = arguments.seed
    try:
        for seed in range(arguments.seed, arguments.seed + arguments.rounds):
            for name, count in counts.items():
                if time.monotonic() > end:
                    raise TimeoutError
                try:
                    judge(name, ROUND, seed, count)
                    print(f"{name}, seed {seed}: {count.judged} examples so far hold", file=sys.stderr, flush=True)
                except Exception as error:
                    count.failures.append(f"{name}, seed {seed}: " + "".join(traceback.format_exception(error)))
                    print(count.failures[-1], file=sys.stderr, flush=True)
        seed += 1
    except (KeyboardInterrupt, TimeoutError):
        pass  # the table is of what was done
    print(table(counts), f"\nnext: --seed {seed}")
    return 1 if any(count.failures for count in counts.values()) else 0


if __name__ == "__main__":
    with SESSIONS:
        sys.exit(main(sys.argv[1:]))
