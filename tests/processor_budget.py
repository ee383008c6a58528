"""A plugin of pytest: a test that takes more of a processor than its budget fails.

Marked `slow` it has no budget, nor has a design beside its baseline; marked `budget(seconds, why)`
one of its own. Set-ups that tests share are not counted. BALLESTA_TEST_BUDGET=off counts nothing.
"""

import os
import resource
from collections.abc import Iterator

import pytest

BUDGET = 30.0  # s of a processor: twice over for cores that are shared with other work


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Fail a test that ends above its budget, and say by how much."""
    own = item.get_closest_marker("budget")
    budget = own.args[0] if own else BUDGET
    begin = _processor_seconds()
    yield
    if item.get_closest_marker("slow") or item.get_closest_marker("ballesta"):
        return
    if os.environ.get("BALLESTA_TEST_BUDGET") == "off":
        return
    taken = _processor_seconds() - begin
    if taken > budget:
        pytest.fail(
            f"{item.nodeid} took {taken:.2f} s of a processor, its budget is {budget:g} s: make "
            "its scene smaller, or mark it slow or budget(seconds, why)",
            pytrace=False,
        )


def _processor_seconds() -> float:
    """Processor time of this process and of its children that have ended [s]."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)
