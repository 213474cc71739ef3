"""What the benches share: run a command and weigh it, the median run, the figures kept in build/bench."""

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BINARY = Path(os.environ.get("DOVETAIL", ROOT / "build/dovetail"))
OUTPUT = ROOT / "build/bench"


@dataclass
class Cost:
    wall: float  # [s]
    cpu: float  # user and system, of the process and all it waited for: under mpirun, of all ranks [s]
    peak_mib: float  # resident memory of the largest of those processes; the bench's own counts as that of its child [MiB]


def weigh(command):
    """Run a command from the project's folder; its output (str) and Cost. Ends the bench if it fails."""
    with tempfile.TemporaryFile("w+") as output:
        start = time.perf_counter()
        process = subprocess.Popen([str(word) for word in command], cwd=ROOT, stdout=output, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read()
    if process.returncode:
        sys.exit(f"{text}\nbench: exit status {process.returncode} of {' '.join(map(str, command))}")
    return text, Cost(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


def summary_of(folder):
    """summary.json of a run, and the seconds of each stage on the slowest rank."""
    summary = json.loads((folder / "summary.json").read_text())
    return summary, {stage["name"]: max(stage["seconds"]) for stage in summary["stages"]}


def keep(name, figures):
    """Write the figures to build/bench/NAME.json and say where."""
    OUTPUT.mkdir(parents=True, exist_ok=True)
    path = OUTPUT / f"{name}.json"
    path.write_text(json.dumps(figures, indent=2) + "\n")
    print(f"\nfigures: {path.relative_to(ROOT)}")


def surroundings():
    """What a timing depends on besides the code."""
    return {"cores": len(os.sched_getaffinity(0)), "load_at_start": os.getloadavg()[0],
            "program": weigh([BINARY, "--version"])[0].strip()}
