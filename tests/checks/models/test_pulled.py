"""Parts that are only pulled: no column buckles, and a bound on what bends them says the rest."""

from dataclasses import replace
from math import inf, isfinite
from pathlib import Path

import numpy as np
import pytest

from ballesta.design.read import read_design
from checks.handbook.column_curves import lateral_share
from checks.models.checked import (
    MOST_FAR,
    MOST_PULLED,
    band_around,
    rung_estimates,
    rung_level,
    stress_share,
)
from checks.models.shapes import model_of
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Status
from geometry.bars import rectangle_torsion

DESIGNS = Path(__file__).parents[3] / "designs"
PULL, PRESS = 20e3, 300.0  # N, along and across


@pytest.fixture(scope="module")
def design():
    return read_design(DESIGNS / "slider_crank.toml")


def loads_of(along, across):
    """Wrenches of a link that is pulled with `along`, and pressed across at its second end."""
    second = np.array([[along, across, 0.0, 0.0, 0.0, 0.0]])
    first = -second
    return first, second


def link_loads(part, along, across):
    first, second = loads_of(along, across)
    first[0, 5] = -across * part.geometry.length
    return PartLoads(
        {"first": first, "second": second},
        np.zeros((1, 4)),
        {"turn": slice(0, 1)},
        ("k = 0",),
        ("turn",),
        {},
        "first",
    )


def estimated(design, part, loads):
    model = model_of(part, loads)
    loaded = LoadedPart(design, part, loads)
    level = rung_level(loaded, model)
    found = rung_estimates(loaded, level, None, lambda some: model_of(part, some))
    return model, found.get("buckling")


def test_what_bends_a_pulled_part_counts_without_the_pull(design):
    """A cantilever of even section under an end force, by the same energy with no compression."""
    part = design.parts["crank"]
    shape, steel = part.geometry, part.material
    model = model_of(part, link_loads(part, PULL, PRESS))
    assert model.buckling.pulled
    young, width, thick = steel.youngs_modulus, shape.width, shape.thickness
    torsion, _ = rectangle_torsion(width, thick)
    moment = PRESS * np.linspace(shape.length, 0.0, 33)[:, None]
    share = lateral_share(
        np.zeros(1),
        moment,
        np.full(33, young * width * thick**3 / 12),
        np.full(33, young / 2 / (1 + steel.poisson_ratio) * torsion),
        shape.length,
    )
    assert model.buckling.share == pytest.approx(float(share[0]), rel=1e-9)
    pushed = model_of(part, link_loads(part, -PULL, PRESS))
    assert not pushed.buckling.pulled
    assert pushed.buckling.share > model.buckling.share


def test_a_part_that_is_only_pulled_passes_its_buckling_and_says_so(design):
    part = design.parts["crank"]
    model, buckling = estimated(design, part, link_loads(part, PULL, PRESS))
    check = buckling.check
    assert check.status is Status.PASS
    by_stress = stress_share(part, model)
    assert check.upper == pytest.approx(MOST_PULLED * check.value + by_stress, rel=1e-12)
    assert check.lower == pytest.approx(0.0, abs=1e-15)
    assert "the part is only pulled, which buckles no column" in check.note
    assert buckling.settled


def test_what_bends_a_pulled_part_enough_leaves_its_buckling_open(design):
    """A force across so large that ten times its share are beyond what the design requires."""
    part = design.parts["crank"]
    _, little = estimated(design, part, link_loads(part, PULL, PRESS))
    factor = 1.1 / (MOST_PULLED * little.check.utilisation)
    _, much = estimated(design, part, link_loads(part, PULL, factor * PRESS))
    assert much.check.status is Status.UNDECIDED


def test_a_pulled_part_with_nothing_across_has_no_check_of_buckling(design):
    part = design.parts["crank"]
    model, buckling = estimated(design, part, link_loads(part, PULL, 0.0))
    assert (model.buckling.share, buckling) == (0.0, None)


def test_a_plate_so_thin_that_its_pin_may_dish_it_has_no_bound(design):
    part = design.parts["crank"]
    thin = replace(part, geometry=replace(part.geometry, thickness=0.05 * part.geometry.hole))
    loads = link_loads(thin, PULL, 0.01)
    _, buckling = estimated(design, thin, loads)
    assert buckling.check.model == inf
    assert buckling.check.status is Status.UNDECIDED
    assert "a wall may buckle by itself" in buckling.check.note
    stout = link_loads(part, PULL, 0.01)
    own = band_around(part, stout, model_of(part, stout), buckling.check)
    assert isfinite(own.most)


def test_a_part_that_is_hardly_ever_pressed_has_its_push_in_the_bound_and_no_credit_for_its_pull(
    design,
):
    """4 % of the pull as a push at one of two positions: the same as under that push alone."""
    part = design.parts["crank"]
    both = both_ways(part, PULL, 0.04 * PULL)
    model, buckling = estimated(design, part, both)
    alone = model_of(part, link_loads(part, -0.04 * PULL, 0.0))
    assert model.buckling.pulled
    assert model.buckling.share == pytest.approx(alone.buckling.share, rel=1e-9)
    assert "the part is hardly pressed, by 0.04 of its largest force" in buckling.check.note
    assert buckling.check.status is Status.PASS
    assert not model_of(part, both_ways(part, PULL, 0.06 * PULL)).buckling.pulled


def both_ways(part, pull, push):
    first, second = (
        np.concatenate(ends) for ends in zip(loads_of(pull, 0.0), loads_of(-push, 0.0), strict=True)
    )
    one = link_loads(part, pull, 0.0)
    return replace(
        one,
        wrenches={"first": first, "second": second},
        accelerations=np.zeros((2, 4)),
        cycles={"turn": slice(0, 2)},
        labels=("k = 0", "k = 1"),
        cycle_names=("turn", "turn"),
    )


def test_a_pressed_part_unlike_all_that_were_compared_passes_far_from_its_bound(design):
    """A plate ten times as thick as its bore is wide: the bar's own share and what stress adds."""
    part = design.parts["crank"]
    shape = part.geometry
    thick = replace(part, geometry=replace(shape, thickness=10 * shape.hole))
    model, buckling = estimated(design, thick, link_loads(thick, -PULL, 0.0))
    check = buckling.check
    assert check.status is Status.PASS
    assert buckling.settled
    by_stress = stress_share(thick, model)
    assert check.upper == pytest.approx(MOST_FAR * check.value + by_stress, rel=1e-12)
    assert check.lower == pytest.approx(0.0, abs=1e-15)
    assert "solids were compared" in check.note
    factor = 1.1 / (MOST_FAR * check.utilisation)
    _, much = estimated(design, thick, link_loads(thick, -factor * PULL, 0.0))
    assert much.check.status is Status.UNDECIDED
