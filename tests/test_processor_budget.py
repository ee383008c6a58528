"""The budget of processor time that a test of this repository has."""

import pytest

from . import processor_budget

pytest_plugins = ("pytester",)
TESTS = """
import subprocess, sys, time
import pytest

BURN = "import time\\nwhile time.process_time() < 0.2: pass"

def burn():
    end = time.process_time() + 0.2
    while time.process_time() < end:
        pass

def test_burns():
    burn()

def test_lets_a_child_burn():
    subprocess.run([sys.executable, "-I", "-c", BURN], check=True)

def test_waits():
    time.sleep(0.2)

@pytest.mark.slow
def test_is_slow():
    burn()

@pytest.mark.budget(60.0, "as is known")
def test_has_its_own_budget():
    burn()

@pytest.fixture
def shared():
    burn()

def test_uses_what_is_shared(shared):
    pass

def test_is_wrong_and_burns():
    burn()
    assert 1 == 2
"""


@pytest.fixture
def run(pytester, monkeypatch):
    monkeypatch.delenv("BALLESTA_TEST_BUDGET", raising=False)
    pytester.makeini("[pytest]\nmarkers =\n    slow\n    budget(seconds, why)\n")
    pytester.makepyfile(test_some=TESTS)

    def run_pytest():
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(processor_budget, "BUDGET", 0.15)
            return pytester.runpytest_inprocess("-rf", plugins=[processor_budget])

    return run_pytest


def test_a_test_above_its_budget_fails_and_names_itself(run):
    result = run()
    result.assert_outcomes(passed=4, failed=3)
    for name in ("test_burns", "test_lets_a_child_burn"):
        result.stdout.fnmatch_lines(
            [f"test_some.py::{name} took * s of a processor, its budget is 0.15 s: *"]
        )
    result.stdout.fnmatch_lines(["FAILED test_some.py::test_is_wrong_and_burns - assert 1 == 2*"])


def test_without_budgets_nothing_is_counted(run, monkeypatch):
    monkeypatch.setenv("BALLESTA_TEST_BUDGET", "off")
    run().assert_outcomes(passed=6, failed=1)


def test_the_budget_holds_in_this_repository(request):
    """The plugin is one of these tests' own."""
    assert request.config.pluginmanager.is_registered(processor_budget)
