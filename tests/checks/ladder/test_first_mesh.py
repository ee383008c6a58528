"""The first mesh of a solid: coarser where little accuracy is asked of a verdict on stress."""

from dataclasses import replace

import numpy as np
import pytest

from ballesta.commands.plan import plan
from checks.ladder.levels import COARSE, LOOSE, Asked, first_of, solve_levels
from checks.part.loaded_part import FIRST, LoadedPart
from checks.part.part_loads import PartLoads
from checks.strength.part_strength import endurance_of
from checks.stress.error_bars import bars_of
from checks.stress.judged import StaticPeak
from checks.stress.solid_mesh_level import Models

from ...small_machine import machine

PULL = np.array([[-1000.0, 0, 0, 0, 0, 0]])
PULLED = PartLoads(
    {"first": PULL, "second": -PULL},
    np.zeros((1, 4)),
    {"turn": slice(0, 1)},
    ("pulled",),
    ("turn",),
)
LINK = """
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = { first = "A", second = "B" }
material = "S275"
width = "30 mm"
thickness = "8 mm"
hole = "12 mm"
"""


def meshes(folder, first, accuracy, settled="", fineness=1.0, most=300_000):
    """Levels of a pulled link, static peak only, and value and bar of the last one."""
    mesh = f"parts.rod.mesh.fineness={fineness}", f"parts.rod.mesh.most_unknowns={most}"
    design = machine(folder, LINK, *mesh)
    design = replace(design, accuracy=accuracy)
    part = design.parts["rod"]
    peak = StaticPeak(PULLED)
    asked = Asked(frozenset(["static"]), modes=False, first=first)
    levels, _, _ = solve_levels(
        LoadedPart(design, part, PULLED),
        Models(),
        [peak],
        endurance_of(part).value,
        lambda _: None,
        asked,
        lambda _: settled,
    )
    return levels, peak.value(levels[-1]), bars_of(peak, part, levels, accuracy).numerical.value


def test_only_a_verdict_on_stress_to_a_loose_accuracy_begins_coarse():
    assert first_of(LOOSE, {"static", "fatigue"}) == COARSE
    assert first_of(0.9 * LOOSE, {"static", "fatigue"}) == FIRST
    assert first_of(LOOSE, {"fatigue", "buckling"}) == FIRST, "its first mesh is its only one"


def test_a_verdict_that_the_coarse_pair_leaves_open_gets_a_third_mesh(tmp_path):
    """The accuracy of 20 % is reached on two meshes either way."""
    assert len(meshes(tmp_path, COARSE, 0.2, fineness=0.6)[0]) == 3
    assert len(meshes(tmp_path, COARSE, 0.2, "settled", fineness=0.6)[0]) == 2
    assert len(meshes(tmp_path, FIRST, 0.2, fineness=0.6)[0]) == 2


@pytest.mark.slow
def test_a_first_mesh_that_would_be_too_large_is_a_coarse_one(tmp_path):
    """A plan and a check take it; the bar is then one of a coarse pair."""
    usual = meshes(tmp_path, FIRST, 0.05, "settled")[0][0].unknowns
    levels, _, bar = meshes(tmp_path, FIRST, 0.05, "settled", most=usual - 1)
    coarse = meshes(tmp_path, COARSE, 0.05, "settled")[0]
    assert levels[0].unknowns == coarse[0].unknowns < 0.8 * usual
    assert len(levels) == 2
    assert np.isfinite(bar)
    design = machine(tmp_path, LINK, f"parts.rod.mesh.most_unknowns={usual - 1}")
    assert plan(design)[0].unknowns[0] < usual


@pytest.mark.slow
def test_the_bar_of_a_coarse_pair_holds_what_finer_meshes_find(tmp_path):
    coarse, value, bar = meshes(tmp_path, COARSE, LOOSE, "settled")
    finer, better, left = meshes(tmp_path, FIRST, 0.01)
    assert 1.5 * coarse[-1].unknowns < finer[-1].unknowns
    assert abs(value - better) <= bar + left
    assert bar <= LOOSE * value
