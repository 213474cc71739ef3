"""The scripts of docs/how-to/cluster.md under a stand-in for srun and scontrol, and under Slurm itself where it is installed."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import time

import numpy as np
import pytest

import chain
from document_pages import fenced
from dovetail.__main__ import main
from launch import BINARY, ROOT, SECONDS, SURROUNDINGS, read_points, wait_for

SCRIPTS = {block.file: block.text for block in fenced(ROOT / "docs/how-to/cluster.md") if block.file}
SRUN = """#!/bin/bash
[ "$1" = --mpi=pmix ] || exit 99
shift
mpirun -n "$SLURM_NTASKS" "$@" &
if [ -n "${SIGNAL_AFTER:-}" ]; then
  while kill -0 $! && [ ! -e "$SIGNAL_AFTER" ]; do sleep 0.05; done
  kill -USR1 $!  # mpirun gives it to all ranks, as Slurm does
fi
wait $!
"""
SCONTROL = """#!/bin/sh
echo "$*" >>"$0.log"
"""
FIXED = "adaptive = false, step = 1e-4, "  # so that a curve takes minutes
CONFIGURATION = """ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
AuthType=auth/none
CredType=cred/none
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SlurmdParameters=config_overrides
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 SocketsPerBoard=1 CoresPerSocket=4 ThreadsPerCore=1 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
"""


@pytest.fixture
def home(tmp_path):
    """A home with dovetail installed, as the scripts look for it, and both scripts."""
    (tmp_path / "dovetail/bin").mkdir(parents=True)
    (tmp_path / "dovetail/bin/dovetail").symlink_to(BINARY)
    for name, text in SCRIPTS.items():
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.fixture
def stand_in(home):
    """Runs a script as a job of two tasks; returns its status, and what it asked scontrol for."""
    for name, text in {"srun": SRUN, "scontrol": SCONTROL}.items():
        (home / "bin").mkdir(exist_ok=True)
        (home / "bin" / name).write_text(text)
        (home / "bin" / name).chmod(0o755)

    def job(script, folder, **surroundings):
        asked = home / "bin/scontrol.log"
        asked.unlink(missing_ok=True)
        surroundings = SURROUNDINGS | {"HOME": str(home), "PATH": f"{home}/bin:{os.environ['PATH']}", "SLURM_NTASKS": "2",
                                       "SLURM_JOB_ID": "7"} | surroundings
        process = subprocess.Popen(["bash", home / script], cwd=folder, env=surroundings, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, start_new_session=True)
        try:
            status = process.wait(SECONDS)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # what it has started, too
            raise
        return status, asked.read_text() if asked.exists() else ""
    return job


def endless(folder):
    """A case that takes so many points that any signal comes in time, and its text."""
    case = chain.write(folder, 4, most=10**6)
    case.write_text(case.read_text().replace("max_points", f"{FIXED}max_points"))
    return case, case.read_text()


def bounded(case, text, points):
    case.write_text(text.replace(f"max_points = {10**6}", f"max_points = {points}"))


def compare_with_whole(case, points):
    """The run in the case's folder beside one that nobody interrupted."""
    whole = case.parent / "whole"
    subprocess.run([BINARY, "run", case, "--out", whole], env=SURROUNDINGS, check=True, stdout=subprocess.DEVNULL, timeout=SECONDS)
    found, wanted = read_points(case.parent), read_points(whole)
    assert len(found["omega"]) == points
    for name in ("omega", "coefficients"):
        np.testing.assert_allclose(found[name], wanted[name], rtol=0, atol=1e-8 * np.abs(wanted[name]).max())


def test_a_job_that_the_signal_stops_goes_back_and_on(stand_in, tmp_path):
    folder = tmp_path / "case"
    case, text = endless(folder)
    assert stand_in("run.sh", folder, SIGNAL_AFTER="state.h5") == (3, "requeue 7\n")
    points = len(read_points(folder)["omega"]) + 20
    bounded(case, text, points)
    assert stand_in("run.sh", folder, SLURM_RESTART_COUNT="1") == (0, "")
    assert json.loads((folder / "summary.json").read_text())["parts"] == 2
    compare_with_whole(case, points)


def test_a_job_that_cannot_go_on_does_not_go_back(stand_in, tmp_path):
    """Also where the part before it, whose summary is there, was interrupted."""
    folder = tmp_path / "case"
    case, text = endless(folder)
    assert stand_in("run.sh", folder, SIGNAL_AFTER="state.h5") == (3, "requeue 7\n")
    (folder / "model.h5").rename(folder / "elsewhere.h5")
    assert stand_in("run.sh", folder, SLURM_RESTART_COUNT="1") == (2, "")
    (folder / "elsewhere.h5").rename(folder / "model.h5")
    case.write_text(text.replace(FIXED, "") + "newton = { max_iterations = 1 }\n")  # no step converges, but for very short ones
    assert stand_in("run.sh", folder) == (3, "")
    assert json.loads((folder / "summary.json").read_text())["end"] != "interrupted"


def test_a_job_that_was_lost_before_its_first_point_begins_anew(stand_in, tmp_path):
    bounded(*endless(tmp_path / "case"), 5)
    assert stand_in("run.sh", tmp_path / "case", SLURM_RESTART_COUNT="1") == (0, "")


def array():
    """Numbers of the tasks, as the script asks for them."""
    first, last = map(int, re.search(r"^#SBATCH --array=(\d+)-(\d+)", SCRIPTS["study.sh"], re.MULTILINE).groups())
    return range(first, last + 1)


def frictions(folder):
    """Of the runs in a folder, from the cases and from what came out: by friction, the largest coefficient."""
    found = {}
    for case in folder.glob("friction_*.toml"):
        value = re.search(r"^friction = ([0-9.]+)", case.read_text(), re.MULTILINE)[1]
        found[float(value)] = read_points(folder / f"friction_{value}")["coefficients"].max()
    return found


def joint(folder):
    """That of the template, with a curve of few points."""
    assert main(["new", str(folder)]) == 0
    subprocess.run([os.environ.get("DOVETAIL_PYTHON", "/usr/bin/python3"), "model.py"], cwd=folder, env=SURROUNDINGS, check=True,
                   stdout=subprocess.DEVNULL, timeout=SECONDS)
    case = folder / "case.toml"
    case.write_text(case.read_text().replace("# max_points = 20000", "max_points = 25"))


def test_every_task_of_an_array_has_a_value_of_its_own(stand_in, tmp_path):
    joint(tmp_path / "joint")
    for task in array():
        assert stand_in("study.sh", tmp_path / "joint", SLURM_ARRAY_TASK_ID=str(task), SLURM_NTASKS="1") == (0, "")
    assert set(frictions(tmp_path / "joint")) == {0.1, 0.2, 0.3, 0.4}


# --------------------------------------------------------------------------------------------------------- Slurm itself
def free_ports(count):
    """Numbers of ports that nobody listens at."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    try:
        return [one.getsockname()[1] for one in sockets]
    finally:
        for one in sockets:
            one.close()


@pytest.fixture
def slurm(tmp_path):
    """Commands of Slurm, whose daemons run for one test on this host: `slurm("sbatch", ...)` returns what is said."""
    if os.getuid() or not all(map(shutil.which, ("slurmctld", "slurmd", "sbatch"))):
        pytest.skip("no Slurm here, or not root")
    folder = tmp_path / "slurm"
    folder.mkdir()
    (folder / "slurm.conf").write_text(CONFIGURATION.format(host=socket.gethostname().split(".")[0], folder=folder, ports=free_ports(2)))
    (folder / "cgroup.conf").touch()
    surroundings = SURROUNDINGS | {"SLURM_CONF": str(folder / "slurm.conf"), "HOME": str(tmp_path)}

    def command(*words, cwd=None):
        done = subprocess.run(list(map(str, words)), cwd=cwd, env=surroundings, capture_output=True, text=True, timeout=SECONDS)
        assert done.returncode == 0, f"{words}: {done.stderr}"
        return done.stdout

    (folder / "state").mkdir()
    (folder / "spool").mkdir()
    daemons = [subprocess.Popen([daemon, "-D"], env=surroundings, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
               for daemon in ("slurmctld", "slurmd")]
    try:
        wait_for(lambda: all(daemon.poll() is None for daemon in daemons) and "idle" in
                 subprocess.run(["sinfo", "-h"], env=surroundings, capture_output=True, text=True).stdout, "a node of Slurm")
        yield command
        command("scancel", "--quiet", "--user", "root")
    finally:
        for daemon in reversed(daemons):
            daemon.terminate()
            daemon.wait(SECONDS)


def is_so(slurm, job, words):
    """Whether Slurm says so of a job; asks no more than twice a second."""
    time.sleep(0.5)
    return re.search(words, slurm("scontrol", "show", "job", job)) is not None


@pytest.mark.slow
def test_slurm_runs_the_job_signals_it_and_takes_it_again(slurm, home):
    folder = home / "case"
    case, text = endless(folder)
    job = slurm("sbatch", "--parsable", "--ntasks=2", home / "run.sh", cwd=folder).strip()
    wait_for((folder / "state.h5").exists, "the first points")
    slurm("scancel", "--signal=USR1", job)
    wait_for(lambda: is_so(slurm, job, "Restarts=1"), "the job in the queue again")
    points = len(read_points(folder)["omega"]) + 20
    bounded(case, text, points)
    time.sleep(5)  # a node refuses what it has just ended
    slurm("scontrol", "update", f"JobId={job}", "StartTime=now")  # in place of two minutes
    wait_for(lambda: is_so(slurm, job, "JobState=(COMPLETED|FAILED)"), "the end of the job")
    assert is_so(slurm, job, "JobState=COMPLETED")
    assert json.loads((folder / "summary.json").read_text())["ranks"] == 2
    compare_with_whole(case, points)


@pytest.mark.slow
def test_slurm_runs_the_array(slurm, home):
    joint(home / "joint")
    slurm("sbatch", "--wait", home / "study.sh", cwd=home / "joint")
    assert set(frictions(home / "joint")) == {0.1, 0.2, 0.3, 0.4}
