"""Files of tests that last longest begin first in a worker."""

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
    items = [SimpleNamespace(nodeid=nodeid) for nodeid in nodeids]
    longest_first.pytest_collection_modifyitems(items)
    return [item.nodeid for item in items]


def test_a_worker_takes_the_files_of_the_order_first_and_leaves_the_rest_as_it_is(
    order, monkeypatch
):
    monkeypatch.setenv("PYTEST_XDIST_WORKER", "gw0")
    order.write_text("d.py\nb.py\n")
    given = ("c.py::two", "c.py::one", "b.py::two", "b.py::one", "a.py::b.py::one", "d.py::A::one")
    assert ordered(*given) == [given[5], given[2], given[3], given[0], given[1], given[4]]


def test_one_process_keeps_the_order_of_the_files(order, monkeypatch):
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)
    order.write_text("b.py\n")
    assert ordered("a.py::one", "b.py::one") == ["a.py::one", "b.py::one"]


def test_the_order_is_that_of_the_seconds_of_a_file_s_tests_set_up_and_all(order):
    times = longest_first.Times()
    phases = [("a.py::one", 2.5), ("a.py::two", 1.0), ("b.py::one", 2.1), ("b.py::one", 2.0)]
    for nodeid, seconds in [*phases, ("c.py::one", longest_first.WORTH_TELLING)]:
        times.pytest_runtest_logreport(SimpleNamespace(nodeid=nodeid, duration=seconds))
    times.pytest_sessionfinish()
    assert order.read_text() == "b.py\na.py\n"


def test_every_file_of_the_order_is_there_once():
    files = longest_first.ORDER.read_text(encoding="utf-8").split()
    assert files
    assert len(set(files)) == len(files)
    assert [file for file in files if not (ROOT / file).is_file()] == []
