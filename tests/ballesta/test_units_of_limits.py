"""A design at one of its limits passes the door in every unit."""

from dataclasses import replace
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from geometry.cad_body import cad_body
from geometry.parameters import ParameterError, within

HAMMER = Path(__file__).parents[2] / "designs" / "spring_hammer.toml"
LENGTHS = ("width", "thickness", "arm", "overhang", "clamp_length", "rod_length", "contact_from",
           "contact_to", "contact_length")  # fmt: skip


@pytest.fixture(scope="module")
def leaves():
    return read_design(HAMMER).parts["leaves"].geometry


def test_the_hammers_leaf_at_its_limit_may_be_stated_in_feet(leaves):
    """contact_to = arm - contact_length / 2 in mm; in feet it was 6e-14 mm beyond.

    Dimensions are rounded to 12 digits, which takes it back.
    """
    feet = [f"parts.leaves.{name}={getattr(leaves, name) / 304.8!r} ft" for name in LENGTHS]
    restated = read_design(HAMMER, feet).parts["leaves"].geometry
    for name in LENGTHS:
        assert_allclose(getattr(restated, name), getattr(leaves, name), rtol=1e-15)
    assert restated == leaves


def test_a_shape_beyond_its_limit_by_round_off_is_built_as_the_one_at_it(leaves):
    beyond = replace(leaves, contact_to=leaves.contact_to * (1 + 5e-11))
    ours, theirs = cad_body(beyond), cad_body(leaves)
    assert_allclose(ours.volume, theirs.volume, rtol=1e-9)
    assert set(ours.interfaces) == set(theirs.interfaces)
    with pytest.raises(ParameterError, match=r"it must be at most 448\.5 mm"):
        replace(leaves, contact_to=leaves.contact_to + 1e-6)


def test_round_off_is_relative():
    assert within(1.0 + 1e-11, 1.0)
    assert not within(1.0 + 1e-9, 1.0)
    assert within(0.0, 0.0)
    assert not within(1e-300, 0.0)
    assert not within(float("nan"), 1.0)
