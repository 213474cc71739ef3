import os
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "python"), *(str(ROOT / "tests" / folder) for folder in ("", "verification", "fuzz", "faults", "mutation"))]

# Open MPI removes its folder when the last run of a user ends, also if another one begins: so each process has its own.
SESSIONS = tempfile.TemporaryDirectory(prefix="ompi-")
os.environ["OMPI_MCA_orte_tmpdir_base"] = SESSIONS.name
os.environ.setdefault("OMPI_MCA_pml", "ob1")  # no look for fast networks, for which each start sleeps a fifth of a second


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: not among what scripts/test --quick runs")


def pytest_collection_modifyitems(items):
    for item in items:
        if getattr(item, "callspec", None) and item.callspec.params.get("ranks") == 3:
            item.add_marker("slow")  # two ranks are enough for those
