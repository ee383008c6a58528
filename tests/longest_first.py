"""A plugin of pytest: workers of pytest-xdist take the files of tests that last longest first.

A file stays in one process (`--dist loadfile`), which shares what its module has computed, and a
process that is free takes the next one: whoever ends last is late by a short file at most.
longest_first.txt tells the order. BALLESTA_LONGEST_FIRST=write writes it anew after a run.
"""

import os
from collections import defaultdict
from pathlib import Path

import pytest

ORDER = Path(__file__).with_suffix(".txt")
WORTH_TELLING = 2.0  # s; the order of shorter files does not matter


def file_of(nodeid: str) -> str:
    """File of a test, from the root of the repository."""
    return nodeid.partition("::")[0]


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order the tests of a worker; a run without workers keeps its order."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        files = ORDER.read_text(encoding="utf-8").split()
        rank = {file: k for k, file in enumerate(files)}
        items.sort(key=lambda item: rank.get(file_of(item.nodeid), len(files)))


class Times:
    """Sums up how long the tests of each file take, set-up and all, s."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add one phase of a test."""
        self.seconds[file_of(report.nodeid)] += report.duration

    def pytest_sessionfinish(self) -> None:
        """Write the order."""
        told = [file for file, seconds in self.seconds.items() if seconds > WORTH_TELLING]
        told.sort(key=lambda file: -self.seconds[file])
        ORDER.write_text("".join(f"{file}\n" for file in told), encoding="utf-8")


def pytest_configure(config: pytest.Config) -> None:
    """Measure where the order is to be written, but not in a worker, which sees its own only."""
    wanted = os.environ.get("BALLESTA_LONGEST_FIRST") == "write"
    if wanted and "PYTEST_XDIST_WORKER" not in os.environ:
        config.pluginmanager.register(Times())
