"""The slider-crank's pin as a solid: its peak lies where the crank's pressure ends, at z = 5 mm.

References: the limits from inside the crank of a Fourier series of axisymmetric elements of 0.02 mm
(tests/fem/fourier_pin.py) under the same unit loads, 0.04 mm from the edge.
"""

from dataclasses import replace
from pathlib import Path

import pytest

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from checks.ladder.levels import Asked, solve_levels
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from checks.strength.part_strength import endurance_of, fatigue_use
from checks.stress.error_bars import bars_of
from checks.stress.judged import StaticPeak
from checks.stress.solid_mesh_level import Models

DESIGN = Path(__file__).parents[2] / "designs" / "slider_crank.toml"
STATIC, FATIGUE = 21.03, 20.24  # MPa, von Mises stress and Findley's amplitude of equal safety
ASKED = Asked(kinds=frozenset(("static", "fatigue")), modes=False)


@pytest.mark.parametrize("accuracy", [0.05, pytest.param(0.03, marks=pytest.mark.slow)])
def test_a_peak_at_a_pressed_edge_lies_inside_its_bar(accuracy):
    design = replace(read_design(DESIGN), accuracy=accuracy)
    part = design.parts["pin_A"]
    loads = loads_on(design, part, solve_cycles(design, {}))
    judged = [StaticPeak(loads), fatigue_use(LoadedPart(design, part, loads))]
    limit = endurance_of(part).value
    levels, _, _ = solve_levels(
        LoadedPart(design, part, loads), Models(), judged, limit, lambda _: None, ASKED
    )
    for what, reference in zip(judged, (STATIC, FATIGUE), strict=True):
        bars = bars_of(what, part, levels, accuracy)
        assert levels[-1].order(what.point(levels[-1])) == 1.0
        assert abs(what.value(levels[-1]) - reference) < bars.numerical.value < 0.1 * reference
        assert "the peak lies where a pressure ends with a jump" in bars.note
