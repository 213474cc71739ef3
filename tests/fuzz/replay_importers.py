"""Runs the importers on files kept by fuzz_importers.py (JOB/FILE~WHAT); says what was not as it should be, and ends with 1 then."""

import sys
import tempfile
from pathlib import Path

import importer_jobs
from fuzz_importers import Harness, prepare


def main():
    prepare()
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        harness = Harness(Path(folder), importer_jobs)
        for path in map(Path, sys.argv[1:]):
            print(f"Running: {path}", file=sys.stderr, flush=True)
            if path.parent.name not in harness.jobs:
                continue  # its reader is not installed
            found = harness.run(path.parent.name, path.name.partition("~")[0], path.read_bytes())
            if found:
                failed = True
                print(f"FAULT {path}: {found[0]}\n{found[1]}", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
