"""Derivations of the stress checks: the largest von Mises stress, and fatigue by each criterion."""

from collections.abc import Sequence
from dataclasses import replace

from checks.derivations.bars import solid_bars
from checks.derivations.findley import findley
from checks.derivations.fkm import fkm
from checks.derivations.marin import BOOK, at_point, limit_section
from checks.derivations.miner import miner
from checks.derivations.superposed import patterns_of, superposed
from checks.design.data import Part
from checks.part.derived import amplitude_and_mean, load_case, yield_stress
from checks.part.part_loads import PartLoads
from checks.result.derivation import BARS, Derivation, HandComparison, Section, Step
from checks.result.verdict import Check, HandCheck
from checks.strength.fatigue_assessment import FatigueUse, FkmUse, LifeUse
from checks.stress.error_bars import Bars, Judged
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import Stressed


def static(part: Part, loads: PartLoads, level: Stressed) -> Derivation:
    """Of the largest von Mises stress over all cycles."""
    peak = level.peak
    stress = superposed(level, loads, peak.point, peak.position, "s")
    demand = Step("sigma", "von Mises stress there", "von_mises(s)", "MPa", main=True)
    return Derivation(
        cases=(load_case(part, loads, peak.position, "s"),),
        sections=(
            Section("Stress at the point, by superposition", (stress,)),
            Section("Demand", (demand,)),
            Section("Limit", (yield_stress(part),)),
        ),
        value="sigma",
        limit="S_y",
        notes=(patterns_of(level),),
    )


def fatigue(part: Part, loads: PartLoads, level: Stressed, use: FatigueUse) -> Derivation:
    """Of the largest amplitude of equal safety over the duty, by what has judged it."""
    if isinstance(use, FkmUse):
        return fkm(part, loads, level, use)
    if isinstance(use, LifeUse):
        return miner(part, loads, level, use)
    if use.worst(level).criterion == "Findley":
        return findley(part, loads, level, use)
    return _goodman(part, loads, level, use)


def _goodman(part: Part, loads: PartLoads, level: Stressed, use: FatigueUse) -> Derivation:
    worst = use.worst(level)
    first, second = worst.pair
    stresses = tuple(
        superposed(level, loads, worst.point, position, symbol)
        for position, symbol in ((first, "s_1"), (second, "s_2"))
    )
    return Derivation(
        cases=(load_case(part, loads, first, "s_1"), load_case(part, loads, second, "s_2")),
        sections=(
            Section("Stress at the point, at both ends of its longest chord", stresses),
            amplitude_and_mean("; compression earns nothing", "docs/theory/multiaxial.md"),
            limit_section(part),
            Section(
                "Demand",
                (
                    *at_point(level, use, worst.point),
                    Step(
                        "u",
                        "stress over strength by Goodman",
                        "sigma_a/S_p + sigma_m/S_u",
                        "",
                        f"{BOOK}, eq. 6-46",
                        main=True,
                    ),
                    Step(
                        "sigma",
                        "amplitude of equal safety",
                        "u*S_e",
                        "MPa",
                        main=True,
                    ),
                ),
            ),
        ),
        value="sigma",
        limit="S_e",
        notes=(patterns_of(level),),
    )


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
        HandComparison(hand.quantity, hand.hand, hand.model, hand.unit, hand.formula)
        for hand in by_hand
    )
    sections = (*found.sections, Section(BARS, tuple(items)))
    return replace(
        check, derivation=replace(found, bars=told, sections=sections, compared=compared)
    )
