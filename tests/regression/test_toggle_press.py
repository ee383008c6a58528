"""The toggle press keeps its numbers: a change must be explained, not overlooked."""

import copy
from pathlib import Path

import pytest

from ballesta.baseline import baseline_path, compare, measure, read_baseline

DESIGN = Path(__file__).parents[2] / "designs" / "toggle_press.toml"
STATIC = "static: peak von Mises stress"


@pytest.fixture(scope="module")
def baseline():
    """The baseline beside the design."""
    return read_baseline(baseline_path(DESIGN))


@pytest.fixture(scope="module")
def now(baseline):
    """What the press gives now, by the rungs that its baseline pins: solids, about a minute."""
    return measure(DESIGN, rungs=baseline.rungs)


def test_the_toggle_press_stays_inside_its_baseline(baseline, now):
    found = compare(baseline, now)
    assert found.holds, f"the toggle press has left its baseline:\n{found.text()}"


@pytest.mark.parametrize("part", ["bar_upper", "bar_lower", "pin_B"])
@pytest.mark.parametrize("factor", [0.95, 1.05])
def test_a_peak_stress_that_changes_by_five_per_cent_leaves_the_baseline(
    baseline, now, part, factor
):
    changed = copy.deepcopy(now)
    check = changed["parts"][part]["checks"][STATIC]
    check["value"] *= factor
    check["safety"] /= factor
    assert check["rung"] == "solid"
    found = {row.quantity for row in compare(baseline, changed).left}
    assert found == {f"{part}: {STATIC} [MPa]", f"{part}: {STATIC}, safety"}


def test_a_verdict_or_a_part_that_changes_leaves_the_baseline(baseline, now):
    changed = copy.deepcopy(now)
    changed["parts"]["bar_upper"]["checks"][STATIC]["status"] = "FAIL"
    changed["parts"]["pin_new"] = changed["parts"].pop("pin_B")
    told = {row.quantity: row.cells[1:3] for row in compare(baseline, changed).left}
    assert told == {
        f"bar_upper: {STATIC}, verdict": ("pass", "FAIL"),
        "pin_B": ("present", "absent"),
        "pin_new": ("absent", "present"),
    }
