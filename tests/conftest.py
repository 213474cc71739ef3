import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "tests"), str(ROOT / "tests" / "verification")]


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: not among what scripts/test --quick runs")


def pytest_collection_modifyitems(items):
    for item in items:
        if getattr(item, "callspec", None) and item.callspec.params.get("ranks") == 3:
            item.add_marker("slow")  # two ranks are enough for those
