"""The toggle press keeps its numbers: a change must be explained, not overlooked.

The bars by the check that all tests share. The whole press by the rungs that its baseline pins is
compared where pytest collects the baseline itself (make slow); here its pin, by a solid there.
"""

import copy
from dataclasses import replace
from pathlib import Path

import pytest

from ballesta.design.read import read_design
from ballesta.regression.compare import compare
from ballesta.regression.file import baseline_path, read_baseline, record_of
from checks.store.fingerprints import stages_of

DESIGN = Path(__file__).parents[2] / "designs" / "toggle_press.toml"
STATIC = "static: peak von Mises stress"
BARS = ("bar_upper", "bar_lower")


def of_bars(record):
    return {**record, "parts": {name: record["parts"][name] for name in BARS}}


@pytest.fixture(scope="module")
def baseline():
    """The baseline beside the design."""
    return read_baseline(baseline_path(DESIGN))


@pytest.fixture(scope="module")
def bars(baseline):
    """The baseline without the pin."""
    return replace(baseline, record=of_bars(baseline.record))


@pytest.fixture(scope="module")
def now(press):
    """What the bars of the press give now."""
    design = read_design(DESIGN)
    return of_bars(record_of(press.result, stages_of(design), design.accuracy))


def left_by(baseline, now, part, factor):
    """What leaves the baseline when a part's peak stress changes."""
    changed = copy.deepcopy(now)
    check = changed["parts"][part]["checks"][STATIC]
    check["value"] *= factor
    check["safety"] /= factor
    assert check["rung"] == "solid"
    return {row.quantity for row in compare(baseline, changed).left}


def test_the_bars_of_the_press_stay_inside_their_baseline(bars, now):
    found = compare(bars, now)
    assert found.holds, f"the toggle press has left its baseline:\n{found.text()}"


@pytest.mark.parametrize("part", BARS)
@pytest.mark.parametrize("factor", [0.95, 1.05])
def test_a_peak_stress_that_changes_by_five_per_cent_leaves_the_baseline(bars, now, part, factor):
    found = left_by(bars, now, part, factor)
    assert found == {f"{part}: {STATIC} [MPa]", f"{part}: {STATIC}, safety"}


def test_a_verdict_or_a_part_that_changes_leaves_the_baseline(bars, now):
    changed = copy.deepcopy(now)
    changed["parts"]["bar_upper"]["checks"][STATIC]["status"] = "FAIL"
    changed["parts"]["bar_new"] = changed["parts"].pop("bar_lower")
    told = {row.quantity: row.cells[1:3] for row in compare(bars, changed).left}
    assert told == {
        f"bar_upper: {STATIC}, verdict": ("pass", "FAIL"),
        "bar_lower": ("present", "absent"),
        "bar_new": ("absent", "present"),
    }


@pytest.mark.parametrize("factor", [0.95, 1.05])
def test_a_peak_stress_of_the_pin_that_changes_by_five_per_cent_leaves_it_too(baseline, factor):
    """By the solid that the baseline pins: what it gives now is compared by the baseline's file."""
    recorded = {**baseline.record, "accuracy": read_design(DESIGN).accuracy}
    left = left_by(baseline, recorded, "pin_B", factor)
    assert left == {f"pin_B: {STATIC} [MPa]", f"pin_B: {STATIC}, safety"}
