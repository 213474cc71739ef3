"""Ranks on hosts that do not share the output folder, played by mount namespaces; ranks that outnumber cores or contact points."""

import os
import shutil
import socket
import subprocess
from types import SimpleNamespace

import chain
import pytest
from launch import BINARY, run, words_of

# The second rank has an empty folder of its own in the place of the first argument.
ELSEWHERE = """#!/bin/sh
folder=$1
shift
[ "$OMPI_COMM_WORLD_RANK" = 1 ] || exec "$@"
exec unshare -m sh -c 'mount -t tmpfs none "$0" && exec "$@"' "$folder" "$@"
"""


def namespaces_missing():
    """Why they cannot be had, or an empty text."""
    if not shutil.which("unshare"):
        return "no unshare here"
    tried = subprocess.run(["unshare", "-m", "sh", "-c", "mount -t tmpfs none /mnt"], capture_output=True, text=True)
    return "" if tried.returncode == 0 else f"no mount namespaces here: {tried.stderr.strip()}"


@pytest.mark.slow  # file systems over a network are given some seconds
def test_a_folder_that_one_rank_does_not_see_is_refused(tmp_path):
    if why := namespaces_missing():
        pytest.skip(why)
    case, folder, elsewhere = chain.write(tmp_path, 2), tmp_path / "out", tmp_path / "elsewhere"
    folder.mkdir()
    elsewhere.write_text(ELSEWHERE)
    elsewhere.chmod(0o755)
    _, err = words_of(["mpirun", "-n", "2", elsewhere, folder, BINARY, "run", case, "--out", folder], 2)
    assert f"{folder}: rank 1 on host {socket.gethostname()} does not see what rank 0" in err
    assert "output.directory or --out" in err
    assert list(folder.iterdir()) == []


def test_a_restart_says_which_rank_does_not_see_the_earlier_run(tmp_path):
    if why := namespaces_missing():
        pytest.skip(why)
    case, folder, elsewhere = chain.write(tmp_path, 2, most=2), tmp_path / "out", tmp_path / "elsewhere"
    words_of([BINARY, "run", case, "--out", folder])
    before = sorted(folder.iterdir())
    for rank, seen in (("1", ("does not see it", "sees it")), ("0", ("sees it", "does not see it"))):
        elsewhere.write_text(ELSEWHERE.replace("= 1 ]", f"= {rank} ]"))
        elsewhere.chmod(0o755)
        _, err = words_of(["mpirun", "-n", "2", elsewhere, folder, BINARY, "run", case, "--out", folder, "--restart"], 2)
        host = socket.gethostname()
        assert f"{folder}/state.h5: rank 1 on host {host} {seen[0]}, rank 0 on host {host} {seen[1]}; all ranks need one folder" in err
    assert sorted(folder.iterdir()) == before


def test_ranks_that_have_to_share_cores_or_have_no_contact_point_are_told(tmp_path):
    core = min(os.sched_getaffinity(0))  # one of them, however many this machine has
    done = run(SimpleNamespace(path=chain.write(tmp_path, 1, most=2)), ranks=2, prefix=["taskset", "-c", str(core)])
    assert f"note: 2 ranks on 1 core of host {socket.gethostname()}" in done.out
    assert "note: 2 ranks for 1 contact point" in done.out


def test_one_rank_needs_no_words(tmp_path):
    assert "note:" not in run(SimpleNamespace(path=chain.write(tmp_path, 1, most=2))).out
