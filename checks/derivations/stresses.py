"""Derivations of the stress checks: the largest von Mises stress, and fatigue by each criterion.

Their error bars are told term by term.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import degrees, isclose, isfinite, pi

import numpy as np

from checks.derivations.superposed import (
    BOOK,
    at_point,
    findley,
    limit_section,
    patterns_of,
    superposed,
)
from checks.design.data import Part
from checks.models.bands import NoBand, bores_given
from checks.models.checked import band_around
from checks.models.in_bores import InBores
from checks.part.derived import amplitude_and_mean, load_case, yield_stress
from checks.part.part_loads import PartLoads
from checks.result.derivation import (
    BARS,
    BarSymbols,
    Column,
    Derivation,
    Given,
    HandComparison,
    Item,
    LoadCase,
    Section,
    Step,
    Sum,
)
from checks.result.verdict import Check
from checks.result.ways import STEEL_BUSH
from checks.strength.fatigue_assessment import FatigueUse, FkmUse, LifeUse
from checks.strength.finite_life import DutyLife, life_curve
from checks.strength.fkm_strength import FkmJudgement
from checks.stress.clearances import OverClearances
from checks.stress.error_bars import Bars
from checks.stress.judged import Judged
from checks.stress.pins_in_bores import CLEARANCE_WORDS, MIDDLE
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import RungModel, Stressed
from fem.convergence import FINER, LEAST, ORDER, REPEATS, SAFETY, SCATTER

_BOOK = "FKM guideline, 6th ed., chapter 4"
_THEORY = "docs/theory/life.md"
Told = tuple[BarSymbols, list[Item]]
_OF_MESH = "numerical: last refinement, scatter of the elements, series of the pins' pressure"
_SERIES = "what the series of the pins' pressure misses"
_PATTERNS = "what patterns, nodes and short waves miss of solved contact, and series of other pins'"
_OF_ARCS = "model: arcs on which pins may press"
_OF_FITS = "model: the range of the pins' clearances"
_OF_BENDING = "model: bent pins, which press unevenly"
_EVENED = "in no band: bent pins, with which it is up to {:.4g} MPa, elastic"
_OF_BUSHES = "model: bushes, whose material is not stated"
_CALIBRATED = "docs/theory/error_bars.md"


def rung_bars(
    part: Part,
    loads: PartLoads,
    model: RungModel,
    check: Check,
    value: str,
    bores: InBores | None = None,
) -> Told:
    """Of a formula: where solids lie around it.

    value  symbol of the check's value
    bores  how narrower arcs and uneven pressure move it
    """
    band = band_around(part, loads, model, check)
    above, below = band.formulas(value, check.unit, check.value, bores)
    name = ""
    if isinstance(band, NoBand):
        words = f"no model band: {band.why}"
    else:
        name = f"formula in place of a solid: 95 % of {band.count} solids lie around such a value"
        words = f"the model band is where 95 % of {band.count} solids lie around such a value"
        if bores is not None and bores.most > check.value:
            reached = f"above about {bores.most:.4g} MPa (bent pins, arcs)"
            words = f"the model band: 95 % of {band.count} solids, {reached}"
    if bores is not None and bores.evened:
        words = f"{words}; {_EVENED.format(max(bores.evened, check.value))}"
    up, low = (side[-1].symbol if side else "" for side in (above, below))
    return BarSymbols("", up, low, words, name), [*above, *below]


def solid_bars(bars: Bars, value: str, more: float = 0.0) -> Told:
    """Of a solid: what its last refinement leaves, scatter, series and notch; arcs of contact.

    more  MPa, how far another criterion lies above
    """
    own = bars.numerical
    items: list[Item] = []
    if own.singular:
        told = BarSymbols("", words="no numerical bar: the place is singular, no mesh settles it")
    elif len(bars.values) < 2:
        told = BarSymbols("", words="no numerical bar: it takes two meshes")
    else:
        told = BarSymbols("e_num", words=_OF_MESH)
        scatter = "e_s" if own.order < ORDER else f"{SCATTER:g}*e_s"  # where a pressure ends
        items += [
            Given("v_1", "the value on the last mesh but one", bars.values[-2], "MPa", "the solid"),
            Given("h_1", "elements there on the last mesh but one", bars.sizes[-2], "mm"),
            Given("h_2", "elements there on the last mesh", bars.sizes[-1], "mm"),
            Step("r_m", "refinement there", f"max(h_1/h_2, {FINER:g})", "", _CALIBRATED),
            Step("e_h", f"left by the last refinement, of order {own.order:g}",
                 f"max({SAFETY:g}/(r_m^{own.order:g} - 1), {_written(LEAST)})*abs({value} - v_1)",
                 "MPa", _CALIBRATED),
            Given("e_s", "scatter of the elements that meet there", own.scatter, "MPa"),
            Given("e_n", "what elements of this size miss in the notch", own.notch, "MPa"),
            Given("e_t", _PATTERNS if bars.clearances else _SERIES, own.truncation, "MPa"),
            Step("e_num", "numerical error bar",
                 f"max(e_h, {scatter}, e_n) + {REPEATS:g}*{value} + e_t", "MPa",
                 _CALIBRATED),
        ]  # fmt: skip
    above, below = _arcs(bars.by_arc, bars.in_bores, items)
    more_above, more_below = _clearances(bars.clearances, items)
    above, below = _sum(above, more_above), _sum(below, more_below)
    bends = bars.along is not None and bars.along.uneven != bars.along.even
    if bars.along is not None and bends:
        items += [
            Given("q_1", "the value where pins press evenly along", bars.along.even, "MPa"),
            Given("q_2", "the value where bent pins press unevenly", bars.along.uneven, "MPa",
                  "the line load, solved"),
        ]  # fmt: skip
        above, below = _sum(above, "max(q_2 - q_1, 0)"), _sum(below, "max(q_1 - q_2, 0)")
    if bars.clearances is not None and bars.clearances.soft is not None:
        said = "the value with soft bushes, as their material is not stated"
        items += [
            Given("s_b", said, bars.clearances.soft, "MPa", "contact, solved"),
            Step(STEEL_BUSH, "model band above with bushes of steel", above, "MPa"),
        ]
        above, below = f"max({STEEL_BUSH}, s_b - {value})", f"max({below}, {value} - s_b)"
    if more:
        items.append(Given("b_c", "how far another criterion lies above", more, "MPa", "the note"))
        above = _sum(above, "b_c")
    up = "b_up" if above else ""
    low = "b_lo" if below else ""
    if up:
        items.append(Step(up, "model band above", above, "MPa", "docs/theory/bearing.md"))
    if low:
        items.append(Step(low, "model band below", below, "MPa", "docs/theory/bearing.md"))
    of = (
        _OF_ARCS if bars.by_arc or more else "",
        _OF_FITS if bars.clearances else "",
        _OF_BENDING if bends else "",
        _EVENED.format(bars.evened) if bars.evened else "",
        _OF_BUSHES if bars.clearances and bars.clearances.soft is not None else "",
    )
    words = "; ".join(text for text in (told.words, *of) if text)
    return BarSymbols(told.numerical, up, low, words), items


def _written(share: float) -> str:
    """A share as a fraction where it is one of a whole, such as 1/3."""
    parts = round(1 / share)
    return f"1/{parts}" if share == 1 / parts else f"{share:.17g}"


def _sum(*terms: str) -> str:
    return " + ".join(term for term in terms if term)


def _clearances(over: OverClearances | None, items: list[Item]) -> tuple[str, str]:
    """Formulas of the band above and below, by the clearances that a fit leaves."""
    if over is None:
        return "", ""
    names = {}
    for number, (share, value) in enumerate(over.values.items(), 1):
        names[share] = f"fit_{number}"
        at = f"{100 * share:g} % of the way from the least to the largest"
        said = f"the value at the {CLEARANCE_WORDS.get(share, at)} clearance of the pins"
        items.append(Given(names[share], said, value, "MPa", "contact, solved"))
    middle = names[MIDDLE]
    more = ", ".join(f"{name} - {middle}" for name in names.values())
    less = ", ".join(f"{middle} - {name}" for name in names.values())
    ends = []
    for symbol, side, beyond in (
        ("fit_up", "above", over.above_these),
        ("fit_lo", "below", over.below_these),
    ):
        if beyond:
            said = f"how far it may lie {side} these between them: half the smaller step beside"
            items.append(Given(symbol, said, beyond, "MPa", "docs/theory/contact.md"))
        ends.append(f" + {symbol}" if beyond else "")
    return f"max({more}){ends[0]}", f"max({less}){ends[1]}"


def _arcs(by_arc: Mapping[float, float], in_bores: float, items: list[Item]) -> tuple[str, str]:
    """Formulas of the band above and below, by the arcs on which a pin may press.

    in_bores  MPa, the largest in bores whose arc is not stated; 0 without such
    """
    if not by_arc:
        return "", ""
    names = {}
    for number, (arc, value) in enumerate(by_arc.items(), 1):
        names[arc] = f"p_{number}"
        said = f"the value where pins press on an arc of {degrees(arc):.0f}°, without a series"
        items.append(Given(names[arc], said, value, "MPa", "solved once more"))
    half = names[pi]
    more = ", ".join(f"{name} - {half}" for name in names.values())
    if in_bores:
        items.append(bores_given(in_bores))
        more += f", p_b - {half}"
    less = ", ".join(f"{half} - {name}" for name in names.values())
    return f"max({more})", f"max({less})"


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


def _both_ends(
    part: Part, loads: PartLoads, level: Stressed, point: int, pair: tuple[int, int], of: str
) -> tuple[tuple[LoadCase, ...], Section]:
    """Load cases of two positions, and the stress s_1 and s_2 at a point there."""
    ends = tuple(zip(pair, ("s_1", "s_2"), strict=True))
    return (
        tuple(load_case(part, loads, position, symbol) for position, symbol in ends),
        Section(
            f"Stress at the point, at both ends of {of}",
            tuple(superposed(level, loads, point, position, symbol) for position, symbol in ends),
        ),
    )


_CHORD = "its longest chord"
_GOODMAN = Step("u", "stress over strength by Goodman", "sigma_a/S_p + sigma_m/S_u", "",
                f"{BOOK}, eq. 6-46", main=True)  # fmt: skip


def _goodman(part: Part, loads: PartLoads, level: Stressed, use: FatigueUse) -> Derivation:
    worst = use.worst(level)
    cases, stresses = _both_ends(part, loads, level, worst.point, worst.pair, _CHORD)
    return Derivation(
        cases=cases,
        sections=(
            stresses,
            amplitude_and_mean("; compression earns nothing", "docs/theory/multiaxial.md"),
            limit_section(part),
            Section(
                "Demand",
                (
                    *at_point(level, use, worst.point),
                    _GOODMAN,
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
    cases, stresses = _both_ends(part, loads, level, found.point, found.pair, _CHORD)
    return Derivation(
        cases=cases,
        sections=(
            stresses,
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
    of = "the cycle that harms most"
    cases, largest = _both_ends(part, loads, level, life.point, life.pair, of)
    at = float(level.limits[life.point])
    endless = not isfinite(life.safety) or (use.task.endless and _endless(life, at, use.ultimate))
    return Derivation(
        cases=cases,
        sections=(
            largest,
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
        replace(_GOODMAN, meaning="stress over the endurance limit"),
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
