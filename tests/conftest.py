import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "tests"), str(ROOT / "tests" / "verification")]


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: not among what scripts/test --quick runs")
