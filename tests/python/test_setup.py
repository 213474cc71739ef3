"""What scripts/setup does where the distribution lacks a package."""

import os
import subprocess

import pytest

from launch import ROOT, SECONDS

FAKES = {
    "dpkg-query": 'case "$*" in *{lacks}*) exit 1 ;; esac; echo installed',
    "apt-get": 'echo "$*" >>"$0.log"; case "$*" in *{lacks}*) exit 100 ;; esac',
    "apt-cache": "exit 100",  # knows none
    "id": "echo 0",
    "pip": "true",
}


def set_up(folder, lacks):
    """Its status and words where `lacks` is neither installed nor to be had, and what it asked apt-get for."""
    for name, text in FAKES.items():
        (folder / name).write_text("#!/bin/sh\n" + text.replace("{lacks}", lacks) + "\n")
        (folder / name).chmod(0o755)
    done = subprocess.run(["bash", ROOT / "scripts/setup"], env=os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"},
                          capture_output=True, text=True, timeout=SECONDS)
    return done.returncode, done.stderr, (folder / "apt-get.log").read_text().splitlines()


@pytest.mark.slow  # it builds
def test_a_package_that_only_some_tests_want_may_be_missing(tmp_path):
    status, said, asked = set_up(tmp_path, "calculix-ccx")
    assert status == 0 and "note: there is no package calculix-ccx here" in said, said
    assert asked[1:] == ["update -qq"]


def test_one_that_the_program_needs_may_not(tmp_path):
    status, said, asked = set_up(tmp_path, "libtoml11-dev")
    assert status != 0 and "note" not in said and len(asked) == 3
