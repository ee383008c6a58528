"""A child process can be ended whatever it does, and ends with who started it."""

import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

import psutil
import pytest

from geometry.progress import Child

ROOT = Path(__file__).parents[2]
# PyDLL keeps Python's lock, as CHOLMOD does: no signal handler and no thread of Python runs
WORK = """
import ctypes, os, subprocess, sys

def answer(parent):
    parent.send((parent.receive(), os.getpid()))

def hold(parent):
    helper = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    parent.send(helper.pid)
    ctypes.PyDLL(None).sleep(600)

def idle(parent):
    print(os.getpid(), flush=True)
    parent.receive()
"""

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="sleep(3) of the C library"
)


@pytest.fixture
def work(tmp_path, monkeypatch):
    """A module `work` that children find as this process does."""
    (tmp_path / "work.py").write_text(WORK)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def messages(child):
    found = []
    while not found:
        found = child.messages(1.0)
    return found


def is_gone(pid):
    """Whether a process has ended, or does within ten seconds."""
    for _ in range(100):
        if not psutil.pid_exists(pid) or psutil.Process(pid).status() == "zombie":
            return True
        sleep(0.1)
    return False


def test_a_child_finds_the_modules_of_its_parent_and_answers(work):
    child = Child("work:answer")
    child.send({"a": 1})
    ((said, pid),) = messages(child)
    assert said == {"a": 1}
    assert pid != psutil.Process().pid
    assert child.ended() == 0
    assert child.messages(0.1) is None


def test_a_child_that_holds_pythons_lock_is_ended_at_once_with_its_own(work):
    child = Child("work:hold")
    (helper,) = messages(child)
    start = monotonic()
    child.kill()
    assert monotonic() - start < 1.0
    assert child.ended() < 0
    assert is_gone(helper)


def test_a_child_ends_when_its_parent_is_killed(work):
    code = f"import sys; sys.path[:0] = {[str(work), str(ROOT)]!r}; import time; "
    code += "from geometry.progress import Child; child = Child('work:idle'); time.sleep(600)"
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        pid = int(parent.stdout.readline())
        parent.kill()
    assert is_gone(pid)
