"""Order of tests in a worker, the longest first: files of tests, slow tests one by one."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from . import longest_first

ROOT = Path(__file__).parent.parent


@pytest.fixture
def order(tmp_path, monkeypatch):
    monkeypatch.setattr(longest_first, "ORDER", tmp_path / "order.txt")
    return tmp_path / "order.txt"


def ordered(*nodeids):
    items = [
        SimpleNamespace(nodeid=name, keywords={"slow": 1} if "slow" in name else {})
        for name in nodeids
    ]
    longest_first.pytest_collection_modifyitems(items)
    return [item.nodeid for item in items]


def test_a_worker_takes_the_files_of_the_order_first_and_leaves_the_rest_as_it_is(
    order, monkeypatch
):
    monkeypatch.setenv("PYTEST_XDIST_WORKER", "gw0")
    order.write_text("9.0 d.py\n3.0 b.py\n")
    given = ("c.py::two", "c.py::one", "b.py::two", "b.py::one", "a.py::b.py::one", "d.py::A::one")
    assert ordered(*given) == [given[5], given[2], given[3], given[0], given[1], given[4]]


def test_slow_tests_are_ordered_one_by_one(order, monkeypatch):
    monkeypatch.setenv("PYTEST_XDIST_WORKER", "gw0")
    order.write_text("30.0 a.py::slow_two[a b]\n20.0 a.py::slow_one\n10.0 a.py\n")
    given = ("a.py::one", "a.py::slow_one", "a.py::slow_two[a b]", "a.py::slow_three")
    assert ordered(*given) == [given[2], given[1], given[0], given[3]]


def test_one_process_keeps_the_order_of_the_files(order, monkeypatch):
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)
    order.write_text("3.0 b.py\n")
    assert ordered("a.py::one", "b.py::one") == ["a.py::one", "b.py::one"]


def test_the_order_is_that_of_the_last_runs_of_each_set_up_and_all(order):
    order.write_text("30.0 a.py\n7.0 d.py\n")
    times = longest_first.Times()
    phases = [("a.py::one", 2.5), ("a.py::two", 1.0), ("b.py::one", 2.1), ("b.py::one", 2.0)]
    for nodeid, seconds in [*phases, ("c.py::one", longest_first.WORTH_TELLING)]:
        report = SimpleNamespace(nodeid=nodeid, duration=seconds, keywords={})
        times.pytest_runtest_logreport(report)
    times.pytest_runtest_logreport(
        SimpleNamespace(nodeid="a.py::slow", duration=60.0, keywords={"slow": 1})
    )
    times.pytest_sessionfinish()
    assert order.read_text() == "60.0 a.py::slow\n7.0 d.py\n4.1 b.py\n3.5 a.py\n"


def test_every_file_of_the_order_is_there():
    files = {unit.partition("::")[0] for unit in longest_first.told()}
    assert files
    assert [file for file in files if not (ROOT / file).is_file()] == []
