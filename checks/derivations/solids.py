"""Derivations of a solid's stress checks, made while its meshes are still there."""

from collections.abc import Sequence
from dataclasses import replace

from checks.derivations.bars import solid_bars
from checks.derivations.stresses import fatigue, static
from checks.design.data import Part
from checks.part.part_loads import PartLoads
from checks.result.derivation import BARS, Comparison, Section
from checks.result.verdict import Check, HandCheck
from checks.strength.fatigue_assessment import FatigueUse
from checks.stress.error_bars import Bars, Judged
from checks.stress.solid_mesh_level import Level


def of_solid(
    part: Part,
    part_loads: PartLoads,
    level: Level,
    judged: Judged,
    bars: Bars,
    check: Check,
    by_hand: Sequence[HandCheck],
) -> Check:
    """Return a solid's stress check with its derivation."""
    more = 0.0
    if isinstance(judged, FatigueUse):
        found, (more, _) = fatigue(part, part_loads, level, judged), judged.band(level)
    else:
        found = static(part, part_loads, level)
    told, items = solid_bars(bars, found.value, more)
    compared = tuple(
        Comparison(hand.quantity, hand.hand, hand.model, hand.unit, hand.formula)
        for hand in by_hand
    )
    sections = (*found.sections, Section(BARS, tuple(items)))
    return replace(
        check, derivation=replace(found, bars=told, sections=sections, compared=compared)
    )
