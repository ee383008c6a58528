"""Strength of parts from their design."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from ballesta.design.read import read_design
from checks.strength.part_strength import beyond_size_data, equivalent_diameter

DESIGNS = Path(__file__).parents[3] / "designs"


def part(*section, **other):
    geometry = SimpleNamespace(stressed_evenly=other.pop("evenly", False), stressed_section=section)
    turns = other.pop("turns", False)
    return SimpleNamespace(geometry=geometry, fkm=other.pop("fkm", None), turns=turns)


def test_a_pin_that_turns_in_its_loads_is_bent_all_round():
    """Shigley's 95 % of the largest stress: 0.0766 d^2 of a bar that rotates, 0.01046 d^2 else."""
    assert equivalent_diameter(part(20.0, turns=True)) == 20.0
    assert equivalent_diameter(part(20.0)) == pytest.approx(
        20 * (0.01046 / 0.0766) ** 0.5, rel=2e-3
    )


@pytest.mark.parametrize(
    ("design", "turning"),
    [("slider_crank", {"pin_A"}), ("spring_hammer", {"pin_B"}), ("toggle_press", set())],
)
def test_pins_that_are_fixed_to_a_crank_turn_in_their_loads(design, turning):
    parts = read_design(DESIGNS / f"{design}.toml").parts
    assert {name for name, one in parts.items() if one.turns} == turning


def test_a_crank_that_swings_to_and_fro_turns_no_pin_round():
    short = [f'cycles.{name}.phases[0].to="200 deg"' for name in ("bench", "at_300")]
    parts = read_design(DESIGNS / "slider_crank.toml", short).parts
    assert not any(one.turns for one in parts.values())


def test_a_size_factor_beyond_the_end_of_its_data_is_told_with_the_last_that_has_data():
    """0.808 sqrt(400 mm 300 mm) = 279.9 mm: 1.51 d^-0.157 is 0.623, at 254 mm 0.633."""
    told = beyond_size_data(part(400.0, 300.0))
    assert "end at an equivalent diameter of 254 mm" in told
    assert "to 279.9 mm: 0.623 in place of 0.633" in told


@pytest.mark.parametrize(
    "within",
    [part(400.0, 240.0), part(400.0, 300.0, evenly=True), part(400.0, 300.0, fkm=object())],
    ids=["250 mm", "axial force has no size factor", "FKM has another"],
)
def test_nothing_is_told_where_the_factor_has_data_or_is_not_used(within):
    assert beyond_size_data(within) is None
