"""Error bars of a stress check, term by term."""

from collections.abc import Mapping
from math import degrees, pi

from checks.design.data import Part
from checks.models.bands import NoBand, bores_given
from checks.models.checked import band_around
from checks.models.in_bores import InBores
from checks.part.part_loads import PartLoads
from checks.result.derivation import BarSymbols, Given, Item, Step
from checks.result.verdict import Check
from checks.result.ways import STEEL_BUSH
from checks.stress.clearances import OverClearances
from checks.stress.error_bars import Bars
from checks.stress.pins_in_bores import CLEARANCE_WORDS, MIDDLE
from checks.stress.stress_result import RungModel
from fem.convergence import FINER, LEAST, ORDER, REPEATS, SAFETY, SCATTER

Told = tuple[BarSymbols, list[Item]]
_OF_MESH = "numerical: last refinement, scatter of the elements, series of the pins' pressure"
_SERIES = "what the series of the pins' pressure misses"
_PATTERNS = "what patterns, nodes and short waves miss of solved contact, and series of other pins'"
_OF_ARCS = "model: arcs on which pins may press"
_OF_FITS = "model: the range of the pins' clearances"
_OF_BENDING = "model: bent pins, which press unevenly"
_RAISED = "to which arcs of contact that are not stated and pins that bend may raise it"
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
    if isinstance(band, NoBand):
        words = f"no model band: {band.why}"
    else:
        words = f"the model band is where 95 % of {band.count} solids lie around such a value"
        if bores is not None and bores.most > check.value:
            words = f"{words}, above around {bores.most:.4g} MPa, {_RAISED}"
    if bores is not None and bores.evened:
        words = f"{words}; {_EVENED.format(max(bores.evened, check.value))}"
    up, low = (side[-1].symbol if side else "" for side in (above, below))
    return BarSymbols("", up, low, words), [*above, *below]


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
