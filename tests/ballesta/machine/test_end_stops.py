"""Warnings of travels that nothing mechanical ends."""

from pathlib import Path

import pytest

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.machine.warnings_of import load_warnings

DESIGNS = Path(__file__).parents[3] / "designs"
BAR = (4.14134e-3, (125.0, 0.0), 21.56947917)


def told(design, *changes):
    read = read_design(DESIGNS / design, changes)
    masses = {name: BAR for name in ("lower", "upper") if name in read.bodies}
    return load_warnings(read, masses, solve_cycles(read, masses))


def test_an_assumed_stop_tells_the_stiffness_below_which_the_knee_is_pulled_through():
    """79.7 kN/mm and 159 kN at x = 2 mm under 11 kN (79.8 and 160 without the weights)."""
    (warning,) = [text for text in told("toggle_press.toml") if "ASSUMED" in text]
    assert "softer than 79.7 kN/mm, 11 kN of cylinder pull the linkage through" in warning
    assert "process reaches up to 159 kN" in warning


def test_a_mechanical_stop_is_not_doubted():
    changes = ["cycles.press.stop.basis=mechanical", "cycles.capacity.stop.basis=mechanical"]
    assert not [text for text in told("toggle_press.toml", *changes) if "Nothing" in text]


def test_a_drive_that_passes_the_dead_centre_is_named_and_one_that_jams_too():
    """A stack of 100 kN/mm, bars and bed in series are 72.4 kN/mm: 145 kN at the dead centre."""
    warnings = told("toggle_press_pull_through.toml")
    (soft,) = [text for text in warnings if text.startswith("soft:")]
    (stiff,) = [text for text in warnings if text.startswith("stiff:")]
    assert "nothing stops the linkage: cylinder needs 10 kN at most" in soft
    assert "has 11.31 kN and pulls it through the dead centre of process" in soft
    assert "reaches 145 kN" in soft
    assert "cylinder has 11.31 kN and jams at lower.angle = 85.8" in stiff


def test_a_stronger_drive_pulls_through():
    warnings = told(
        "toggle_press_pull_through.toml",
        "cycles.soft.phases[0].to=91 deg",
        'forces.cylinder.available={ push = "1 MN", pull = "1 MN" }',
    )
    (soft,) = [text for text in warnings if text.startswith("soft:")]
    assert "has 1000 kN and pulls it through" in soft


@pytest.mark.parametrize("end", ["499.9 mm", "499.999 mm"])
def test_a_stop_close_to_the_dead_centre_still_gets_its_warning(end):
    warnings = told(
        "toggle_press.toml",
        f"cycles.press.phases[1].to={end}",
        f"cycles.capacity.phases[0].to={end}",
        "cycles.press.positions=91",
    )
    assert any("cannot be: the loads grow" in text for text in warnings)


def test_a_crank_may_pass_the_dead_centre_of_what_it_forges():
    """A hammer's lowest position is its purpose, not a danger."""
    assert not told("spring_hammer.toml", "cycles.at_5.positions=91")
