"""Derivations of a solid's stress checks, made while its meshes are still there."""

from collections.abc import Sequence
from dataclasses import replace

from ballesta.design_data import Part
from ballesta.explained.bars import solid_bars
from ballesta.explained.proven import BARS
from ballesta.explained.stresses import fatigue, static
from ballesta.judged import Bars, Judged
from ballesta.judged_fatigue import FatigueUse
from ballesta.levels import Level
from ballesta.part_loads import PartLoads
from reports.derivation import Comparison, Section
from reports.verdict import Check, HandCheck


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
