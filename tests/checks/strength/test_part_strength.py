"""Strength of parts from their design."""

from types import SimpleNamespace

import pytest

from checks.strength.part_strength import beyond_size_data


def part(*section, **other):
    geometry = SimpleNamespace(stressed_evenly=other.pop("evenly", False), stressed_section=section)
    return SimpleNamespace(geometry=geometry, fkm=other.pop("fkm", None))


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
