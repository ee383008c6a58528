"""A plugin of pytest: workers of pytest-xdist take first what lasts longest.

The tests of a file stay in one process (`--dist loadfile`), which shares what its module has
computed; slow tests are shared out one by one (`--dist load`). A process that is free takes the
next, so whoever ends last is late by something short. longest_first.txt tells the order, in s of
files and of slow tests. BALLESTA_LONGEST_FIRST=write takes a run's times into it.
"""

import os
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

ORDER = Path(__file__).with_suffix(".txt")
WORTH_TELLING = 2.0  # s; the order of what is shorter does not matter


def unit_of(nodeid: str, keywords: Any) -> str:
    """Test itself if it is slow, else its file."""
    return nodeid if "slow" in keywords else nodeid.partition("::")[0]


def told() -> dict[str, float]:
    """Seconds of files and slow tests, the longest first."""
    lines = ORDER.read_text(encoding="utf-8").splitlines()
    pairs = (line.split(" ", 1) for line in lines)
    return {unit: float(seconds) for seconds, unit in pairs}


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order the tests of a worker; a run without workers keeps its order."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        seconds = told()
        items.sort(key=lambda item: -seconds.get(unit_of(item.nodeid, item.keywords), 0.0))


class Times:
    """Sums up how long each unit takes, set-ups and all, s."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add one phase of a test."""
        self.seconds[unit_of(report.nodeid, report.keywords)] += report.duration

    def pytest_sessionfinish(self) -> None:
        """Write the order: what ran as it ran now, the rest as it was told."""
        whole = told() | self.seconds
        pairs = sorted(((seconds, unit) for unit, seconds in whole.items()), reverse=True)
        lines = [f"{seconds:.1f} {unit}\n" for seconds, unit in pairs if seconds > WORTH_TELLING]
        ORDER.write_text("".join(lines), encoding="utf-8")


def pytest_configure(config: pytest.Config) -> None:
    """Measure where the order is to be written, but not in a worker, which sees its own only."""
    wanted = os.environ.get("BALLESTA_LONGEST_FIRST") == "write"
    if wanted and "PYTEST_XDIST_WORKER" not in os.environ:
        config.pluginmanager.register(Times())
