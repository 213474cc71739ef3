"""HDF5 files with something wrong in them, read by the C++ harness and by the Python readers.

First every edit of hdf5_edits alone, then some at a time, chosen at random, until the time is over. What crashes, hangs or is not
refused as it should be is kept in a folder, with the edits in a text file beside it.
"""

import argparse
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import crash
import hdf5_edits

HERE = Path(__file__).resolve().parent
BATCH = 100
SECONDS = 300  # for a batch; one file takes a hundredth of a second, and the readers have limits of their own


def batches(seconds, seed):
    """Lists of (kind, {label: edit}): all single ones, then random ones until the time is over."""
    edits = {kind: list(hdf5_edits.all_edits(kind)) for kind in hdf5_edits.KINDS}
    singles = [(kind, [edit]) for kind, all_ in edits.items() for edit in all_]
    dice = random.Random(seed)
    dice.shuffle(singles)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        batch, singles = singles[:BATCH], singles[BATCH:]
        if not batch:
            kinds = dice.choices(list(edits), k=BATCH)
            batch = [(kind, dice.sample(edits[kind], dice.choice((2, 2, 3, 4)))) for kind in kinds]
        yield batch


def run(command, files):
    """(file, what) for each file that a program did not take or refuse as it should."""
    found = []
    while files:
        try:
            done = subprocess.run([*command, *files], capture_output=True, text=True, errors="replace", timeout=SECONDS)
            code, out, err = done.returncode, done.stdout, done.stderr
        except subprocess.TimeoutExpired as error:
            code, out, err = "hang", (error.stdout or b"").decode(errors="replace"), (error.stderr or b"").decode(errors="replace")
        found += re.findall(r"^FAULT (\S+) (.*)$", out, re.M)
        if code in (0, 1) and not re.search("ERROR: |runtime error", err):
            break
        last = Path(re.findall(r"^Running: (\S+)", err, re.M)[-1])
        found.append((last.name, f"ended with {code}: {crash.describe(err)}"))
        files = files[files.index(str(last)) + 1:]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("found"), help="folder for what was found")
    parser.add_argument("harness", nargs="*", help="the program fuzz_hdf5_file and its options; without it, only the Python readers")
    chosen = parser.parse_args()
    programs = {"python": [sys.executable, str(HERE / "read_hdf5.py")]} | ({"c++": chosen.harness} if chosen.harness else {})
    count, found = 0, {}
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        for kind in hdf5_edits.KINDS:
            hdf5_edits.write(Path(folder) / f"good_{kind}.h5", kind, [])
        for batch in batches(chosen.seconds, chosen.seed):
            files = {}
            for i, (kind, edits) in enumerate(batch):
                path = Path(folder) / f"{i}.h5"
                hdf5_edits.write(path, kind, [edit for _, edit in edits])
                files[path.name] = f"{kind}: " + "; ".join(label for label, _ in edits)
            count += len(files)
            for program, command in programs.items():
                for name, what in run(command, [str(Path(folder) / name) for name in files]):
                    what = f"{program} {what}"
                    if what not in found:
                        found[what] = files[name]
                        print(f"{what}\n    {files[name]}", flush=True)
                        chosen.keep.mkdir(parents=True, exist_ok=True)
                        shutil.copy(Path(folder) / name, chosen.keep / f"{len(found)}.h5")
                        (chosen.keep / f"{len(found)}.txt").write_text(f"{what}\n{files[name]}\n")
    ours = [what for what in found if crash.LIBRARY not in what]
    print(f"hdf5: {count} files, {len(ours)} findings, {len(found) - len(ours)} in libhdf5")
    return bool(ours)


if __name__ == "__main__":
    sys.exit(main())
