"""The toggle press keeps its numbers: a change must be explained, not overlooked."""

import copy
import json
from pathlib import Path

import pytest

from ballesta.baseline import baseline_of, differences

BASELINE = Path(__file__).parents[2] / "designs" / "toggle_press.baseline.json"
STATIC = "static: peak von Mises stress"


def test_the_toggle_press_stays_inside_its_baseline(press):
    left = differences(json.loads(BASELINE.read_text()), baseline_of(press.result))
    assert not left, "\n".join(["the toggle press has left its baseline:", *left])


@pytest.mark.parametrize("factor", [0.95, 1.05])
def test_a_peak_stress_that_changes_by_five_per_cent_leaves_the_baseline(press, factor):
    now = baseline_of(press.result)
    before = copy.deepcopy(now)
    before["parts"]["bar_upper"]["checks"][STATIC]["value"] *= factor
    (line,) = differences(before, now)
    assert "bar_upper" in line
    assert STATIC in line


def test_a_verdict_or_a_part_that_changes_leaves_the_baseline(press):
    now = baseline_of(press.result)
    before = copy.deepcopy(now)
    before["parts"]["bar_upper"]["checks"][STATIC]["status"] = "FAIL"
    before["parts"]["bar_gone"] = before["parts"].pop("pin_B")
    lines = "\n".join(differences(before, now))
    assert "'FAIL'" in lines
    assert "bar_gone" in lines
    assert "pin_B" in lines
