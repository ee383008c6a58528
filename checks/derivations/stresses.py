"""Derivations of the stress checks: the largest von Mises stress, and fatigue by each criterion."""

from collections.abc import Sequence
from dataclasses import replace
from math import isclose, isfinite

import numpy as np

from checks.derivations.bars import solid_bars
from checks.derivations.superposed import (
    BOOK,
    at_point,
    findley,
    limit_section,
    patterns_of,
    superposed,
)
from checks.design.data import Part
from checks.part.derived import amplitude_and_mean, load_case, yield_stress
from checks.part.part_loads import PartLoads
from checks.result.derivation import (
    BARS,
    Column,
    Derivation,
    Given,
    HandComparison,
    Item,
    Section,
    Step,
    Sum,
)
from checks.result.verdict import Check
from checks.strength.fatigue_assessment import FatigueUse, FkmUse, LifeUse
from checks.strength.finite_life import DutyLife, life_curve
from checks.strength.fkm_strength import FkmJudgement
from checks.stress.error_bars import Bars
from checks.stress.judged import Judged
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import Stressed

_BOOK = "FKM guideline, 6th ed., chapter 4"
_THEORY = "docs/theory/life.md"


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
                    Step("sigma", "amplitude of equal safety", "u*S_e", "MPa", main=True),
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
    by_hand: Sequence[HandComparison],
) -> Check:
    """Return a solid's stress check with its derivation."""
    more = 0.0
    if isinstance(judged, FatigueUse):
        found, (more, _) = fatigue(part, part_loads, level, judged), judged.band(level)
    else:
        found = static(part, part_loads, level)
    told, items = solid_bars(bars, found.value, more)
    sections = (*found.sections, Section(BARS, tuple(items)))
    return replace(
        check, derivation=replace(found, bars=told, sections=sections, compared=tuple(by_hand))
    )


# The FKM guideline's chain at the worst point, as docs/theory/strength.md has it.


def fkm(part: Part, loads: PartLoads, level: Stressed, use: FkmUse) -> Derivation:
    """Of the utilisation times the reference strength."""
    found = use.found(level)
    pair = tuple(zip(found.pair, ("s_1", "s_2"), strict=True))
    return Derivation(
        cases=tuple(load_case(part, loads, position, symbol) for position, symbol in pair),
        sections=(
            Section(
                "Stress at the point, at both ends of its longest chord",
                tuple(superposed(level, loads, found.point, k, symbol) for k, symbol in pair),
            ),
            amplitude_and_mean(", not below 0", _BOOK),
            Section("Limit: component strength without support", tuple(_limit(use))),
            Section("Demand", tuple(_demand(found))),
        ),
        value="sigma",
        limit="sigma_ref",
        notes=(patterns_of(level),),
    )


def _limit(use: FkmUse) -> list[Item]:
    own, plain = use.strength, use.strength.plain
    group = own.material.numbers
    return [
        Given("R_m", "ultimate strength", own.material.ultimate_strength, "MPa", "the material"),
        Given("f_W", f"fully reversed over ultimate strength, {own.material.group}",
              group.strength_ratio, "", _BOOK),
        Step("sigma_W", "fully reversed strength of the material", "f_W*R_m", "MPa", _BOOK),
        Given("a_R", "weight of the roughness", group.roughness, "", _BOOK),
        Given("R_N", "least strength of the group", group.least_strength, "MPa", _BOOK),
        Given("R_z", "roughness", own.roughness, "µm", "the design, roughness or surface"),
        Step("K_R", "roughness factor",
             "1 - a_R*log10(max(R_z, 1))*max(0, log10(2*R_m/R_N))", "", _BOOK),
        Given("K_n", "notch factor of the surface, K_f~", plain.notch_factor, "", _BOOK),
        Step("q", "what the roughness takes", "1 + (1/K_R - 1)/K_n", "", _BOOK),
        Given("K_BK", "endured for ever over endured at 1e6 cycles", own.endurance_share, "",
              _BOOK),
        Step("sigma_ref", "even, fully reversed amplitude endured for ever", "sigma_W/q*K_BK",
             "MPa", _BOOK, main=True),
    ]  # fmt: skip


def _demand(found: FkmJudgement) -> list[Item]:
    return [
        Given("G", "related stress gradient below the point", found.gradient, "1/mm",
              "the solid's displacements", main=True),
        Given("n_s", "Stieler's support number of it", float(found.limit.support), "", _BOOK),
        Step("sigma_WK", "strength of the part there, fully reversed", "sigma_W*n_s/q", "MPa",
             _BOOK, main=True),
        Given("M", "mean stress sensitivity", found.limit.sensitivity, "", _BOOK),
        Step("r", "mean over amplitude", "sigma_m/sigma_a", "", _BOOK),
        Step("K_AK", "mean stress factor, constant R",
             "(1 + M/3)/((1 + M*min(r, 1))*(1 + M/3*max(1, min(r, 3))))", "", _BOOK, main=True),
        Step("u", "utilisation a_BK", "sigma_a/(K_AK*sigma_WK*K_BK)", "", _BOOK, main=True),
        Step("sigma", "the utilisation as an even, reversed stress", "u*sigma_ref", "MPa", _BOOK,
             main=True),
    ]  # fmt: skip


# A finite life: counted cycles, Miner's sum, and the safety that it leaves.


def miner(part: Part, loads: PartLoads, level: Stressed, use: LifeUse) -> Derivation:
    """Of the endurance limit over the safety that a finite life leaves."""
    life = use.life(level)
    largest = tuple(
        superposed(level, loads, life.point, position, symbol)
        for position, symbol in zip(life.pair, ("s_1", "s_2"), strict=True)
    )
    at = float(level.limits[life.point])
    endless = not isfinite(life.safety) or (use.task.endless and _endless(life, at, use.ultimate))
    return Derivation(
        cases=tuple(
            load_case(part, loads, position, symbol)
            for position, symbol in zip(life.pair, ("s_1", "s_2"), strict=True)
        ),
        sections=(
            Section("Stress at the point, at both ends of the cycle that harms most", largest),
            limit_section(part),
            Section(
                "Safety",
                tuple(_without_end(life, at, use.ultimate) if endless else _miner(use, life, at)),
            ),
            Section(
                "Demand",
                (
                    Step(
                        "sigma",
                        "the endurance limit over the safety that the life leaves",
                        "S_e/n" if not endless else "S_e*u",
                        "MPa",
                        _THEORY,
                        main=True,
                    ),
                ),
            ),
        ),
        value="sigma",
        limit="S_e",
        equal=() if endless else (("D", "D_a"),),
        notes=(
            patterns_of(level),
            f"{len(life.cycles.cycle_counts)} different cycles were counted by rainflow along the "
            f"longest chord of the path {life.run!r}"
            + (f", raised by {life.raised:.4g} for Findley's plane" if life.raised > 1 else "")
            + f" ({_THEORY})",
        ),
    )


def _endless(life: DutyLife, limit: float, strength: float) -> bool:
    """True if the largest cycle gives the safety, against the endurance limit."""
    used = life.cycles.stress_amplitude / limit + life.cycles.mean_stress / strength
    return isclose(float(used.max()) * life.safety, 1.0, rel_tol=1e-9)


def _without_end(life: DutyLife, limit: float, strength: float) -> list[Item]:
    amplitude, mean = life.cycles.stress_amplitude, life.cycles.mean_stress
    worst = int(np.argmax(amplitude / limit + mean / strength))
    return [
        Given("sigma_a", "amplitude of the largest cycle", float(amplitude[worst]), "MPa",
              "rainflow"),
        Given("sigma_m", "mean of the largest cycle", float(mean[worst]), "MPa", "rainflow"),
        Given("S_p", "endurance limit at the point", limit, "MPa", "S_e over its fretting factor"),
        Step("u", "stress over the endurance limit", "sigma_a/S_p + sigma_m/S_u", "",
             f"{BOOK}, eq. 6-46", main=True),
    ]  # fmt: skip


def _miner(use: LifeUse, life: DutyLife, limit: float) -> list[Item]:
    curve = life_curve(use.task.material, np.array([limit]), axial=use.task.axial)
    cycles = life.cycles
    order = np.argsort(-cycles.stress_amplitude, kind="stable")

    def column(symbol: str, meaning: str, unit: str, values: object) -> Column:
        return Column(symbol, meaning, unit, tuple(float(v) for v in np.asarray(values)[order]))

    return [
        Given("S_p", "endurance limit at the point", limit, "MPa", "S_e over its fretting factor"),
        Given("N_D", "cycles of the knee", float(np.max(curve.knee_cycles)), "", _THEORY),
        Given("k_1", "slope above the knee", float(np.max(curve.slope)), "", _THEORY),
        Given("k_2", "slope below it, Haibach", float(np.max(curve.slope_below)), "", _THEORY),
        Given("D_a", "allowed damage", use.task.allowed_damage, "", "the design, duty"),
        Given("n", "factor on all loads, sought until the damage is the allowed one", life.safety,
              "", _THEORY, main=True),
        Sum(
            "D",
            "Miner's sum of the life under n times the loads",
            "m/N_D*(n*a/(1 - n*b/S_u)/S_p)^choose(n*a/(1 - n*b/S_u), S_p, k_1, k_2)",
            tuple(str(number) for number in range(1, len(order) + 1)),
            (
                column("a", "amplitude", "MPa", cycles.stress_amplitude),
                column("b", "mean", "MPa", cycles.mean_stress),
                column("m", "how often in the life", "", cycles.cycle_counts),
            ),
            "",
            f"Palmgren-Miner, {_THEORY}",
            main=True,
        ),
    ]  # fmt: skip
