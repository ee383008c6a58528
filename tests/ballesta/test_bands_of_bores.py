"""The model band of bores: arcs on which a pin may press, and what contacts exceed these by."""

from dataclasses import replace

import numpy as np
import pytest

from checks.derivations.bars import solid_bars
from checks.handbook.lugs import lug_factor
from checks.ladder.solid import Asked, solve_levels
from checks.part.part_loads import PartLoads
from checks.strength.part_strength import endurance_of, fatigue_use
from checks.stress.error_bars import BEYOND_ARCS, StaticPeak, bars_of
from checks.stress.solid_mesh_level import Models

from ..small_machine import machine

ASKED = Asked(kinds=frozenset(("static", "fatigue")), modes=False)
FORCE, WIDTH, THICK = 1000.0, 30.0, 8.0
PULLED = PartLoads(
    {
        "first": np.array([[-FORCE, 0, 0, 0, 0, 0], [FORCE, 0, 0, 0, 0, 0]]),
        "second": np.array([[FORCE, 0, 0, 0, 0, 0], [-FORCE, 0, 0, 0, 0, 0]]),
    },
    np.zeros((2, 4)),
    {"turn": slice(0, 2)},
    ("pulled", "pushed"),
    ("turn", "turn"),
)


def bars(folder, share, stated=""):
    """Static and fatigue checks of a pulled link with holes of a share of its width."""
    text = f"""
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = {{ first = "A", second = "B" }}
material = "S275"
width = "{WIDTH} mm"
thickness = "{THICK} mm"
hole = "{share * WIDTH} mm"
mesh = {{ fineness = 0.5 }}
{stated}
"""
    design = replace(machine(folder, text), accuracy=0.2)
    part = design.parts["rod"]
    judged = [StaticPeak(PULLED), fatigue_use(design, part, PULLED)]
    limit = endurance_of(part).value
    levels, _, _ = solve_levels(
        design, part, PULLED, Models(), judged, limit, lambda _: None, ASKED
    )
    return [(what.value(levels[-1]), bars_of(what, part, levels, 0.2)) for what in judged]


@pytest.mark.parametrize("share", [0.3, 0.4, 0.5])
def test_the_default_bars_of_a_lug_reach_the_handbooks_factor(tmp_path, share):
    """A round end raises the peak above that of Peterson's square one (checks/handbook/lugs.py)."""
    chart = lug_factor(share * WIDTH, WIDTH) * FORCE / ((WIDTH - share * WIDTH) * THICK)
    (value, found), _ = bars(tmp_path, share)
    assert value + found.above > chart
    assert found.in_bores == pytest.approx((1 + BEYOND_ARCS) * max(found.by_arc.values()))


def test_a_bore_whose_arc_is_not_stated_has_more_above_and_its_derivation_says_so(tmp_path):
    for (value, taken), (_, known) in zip(
        bars(tmp_path, 0.4), bars(tmp_path, 0.4, 'bearing_arc = "90 deg"'), strict=True
    ):
        assert taken.below == pytest.approx(known.below)
        assert taken.above - known.above == pytest.approx(
            BEYOND_ARCS * max(taken.by_arc.values()), rel=1e-9
        )
        assert known.in_bores == 0.0
        assert value < taken.in_bores
        steps = {item.symbol: item for item in solid_bars(taken, "sigma")[1]}
        assert "p_b - p_1" in steps["b_up"].formula
        assert steps["p_b"].value == taken.in_bores
