"""Forks that hold a part's ends against tilting: a band of their own below the share."""

from dataclasses import replace

import numpy as np
import pytest

from ballesta.design.read import read_design
from checks.handbook.column_curves import column_force
from checks.models.bands import Band
from checks.models.checked import band_around

from .test_pulled import DESIGNS, PULL, estimated, link_loads


@pytest.fixture(scope="module")
def design():
    return read_design(DESIGNS / "slider_crank.toml")


def needing(design, share, utilisation):
    """The design with a required safety that makes this share use so much of it."""
    required = design.require.model_copy(update={"buckling": utilisation / share})
    return replace(design, require=required)


def test_stiff_forks_leave_a_quarter_of_a_thin_column(design):
    part = design.parts["rod"]
    thin = replace(part, geometry=replace(part.geometry, thickness=part.geometry.thickness / 2))
    model, _ = estimated(design, thin, link_loads(thin, -PULL, 0.0))
    assert model.buckling.words.startswith("out of plane")
    assert model.buckling.fixity == pytest.approx(0.75)


@pytest.mark.parametrize(("utilisation", "told"), [(0.9, True), (0.2, False)])
def test_fixity_is_a_band_of_its_own_near_the_limit(design, utilisation, told):
    """Far from its limit nobody is asked how its forks are, as for solids."""
    part = design.parts["rod"]
    loads = link_loads(part, -PULL, 0.0)
    model, _ = estimated(design, part, loads)
    _, estimate = estimated(needing(design, model.buckling.share, utilisation), part, loads)
    check, fixity = estimate.check, model.buckling.fixity
    assert 0.7 < fixity < 0.75
    assert ("fixity" in check.note) == told
    low = known_low(part, loads, model, check)
    below = (1 - low) + (fixity * low if told else 0.0)
    assert check.model_below / check.value == pytest.approx(below, rel=1e-6)
    # a better model takes none of the fixity away
    assert estimate.below / check.value == pytest.approx(1 - low, rel=1e-6)


def known_low(part, loads, model, check):
    band = band_around(part, loads, model, check)
    assert isinstance(band, Band)
    return band.low


def test_a_column_that_buckles_in_its_plane_has_no_fixity(design):
    part = design.parts["rod"]
    thick = replace(part, geometry=replace(part.geometry, thickness=3 * part.geometry.width))
    model, _ = estimated(design, thick, link_loads(thick, -PULL, 0.0))
    assert model.buckling.words.startswith("in plane")
    assert model.buckling.fixity == 0.0


def test_forks_take_no_more_than_what_is_left_in_the_plane(design):
    """1.5 times as wide as thick: in the plane 4/9 of the share, so that 5/9 of it is fixity."""
    part = design.parts["rod"]
    shape = replace(part.geometry, thickness=part.geometry.width / 1.5)
    square = replace(part, geometry=shape)
    model, _ = estimated(design, square, link_loads(square, -PULL, 0.0))
    inertia = shape.thickness * shape.width**3 / 12 * part.material.youngs_modulus
    euler = column_force(np.full(9, inertia), np.inf, shape.length)
    left = PULL / euler / model.buckling.share
    assert model.buckling.fixity == pytest.approx(1 - left, rel=0.01)
