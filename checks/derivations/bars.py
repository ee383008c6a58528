"""Error bars of a stress check, term by term."""

from collections.abc import Mapping
from math import degrees, isfinite, pi

from checks.design.data import Part
from checks.handbook.pin_loaded_hole import BEYOND_ARCS
from checks.models.bands import NoBand
from checks.models.checked import band_around
from checks.part.part_loads import PartLoads
from checks.result.derivation import Bars, Given, Item, Step
from checks.result.verdict import Check
from checks.stress.error_bars import Bars as SolidBars
from checks.stress.part_model import RungModel
from fem.convergence import FINER, LEAST, ORDER, REPEATS, SAFETY, SCATTER

ERROR = "e_r"  # the symbol of a rung's own error
Told = tuple[Bars, list[Item]]
_OF_MESH = "numerical: last refinement, scatter of the elements, series of the pins' pressure"
_OF_ARCS = "model: arcs on which pins may press"
_CALIBRATED = "docs/theory/error_bars.md"


def rung_bars(
    part: Part, loads: PartLoads, model: RungModel, check: Check, value: str, in_bores: float = 0.0
) -> Told:
    """Of a rung below the solid: its own numerical error, and where solids lie around it.

    value     symbol of the check's value
    in_bores  MPa, the largest in bores whose arc is not stated, raised; 0 without such
    """
    items: list[Item] = []
    numerical = ""
    if model.numerical:
        numerical = "e_num"
        said = f"numerical error of the rung {model.rung} over its peak"
        items += [
            Given(ERROR, said, model.numerical, "", f"docs/theory/rungs_{model.rung}.md"),
            Step(numerical, "numerical error bar", f"{ERROR}*{value}", check.unit),
        ]
    band = band_around(part, loads, model, check)
    if isinstance(band, NoBand):
        return _unbanded(band, numerical, check, value, items), items
    page = "docs/theory/rungs.md"
    for symbol, side, edge, formula, reach in (
        ("up", "above", band.high, "max(0, h_up - 1)", band.above[1]),
        ("lo", "below", band.low, "max(0, 1 - h_lo)", band.below[1]),
    ):
        said = f"{'upper' if symbol == 'up' else 'lower'} end of where 95 % of solids lie"
        own = f"reach of the solids' own model band {side}"
        total = f"({formula} + q_{symbol})*{value}"
        if symbol == "up" and in_bores > check.value:
            items.append(_in_bores(in_bores))
            total = f"(p_b/{value}*(max(1, h_up) + q_up) - 1)*{value}"
        items += [
            Given(f"h_{symbol}", f"{said}, over this value: {band.count} compared", edge, "", page),
            Given(f"q_{symbol}", f"{own}, over the value", reach, "", page),
            Step(
                f"b_{symbol}",
                f"model band {side}",
                total,
                check.unit,
                page,
            ),
        ]
    words = f"the model band is where 95 % of {band.count} solids lie around such a value"
    return Bars(numerical, "b_up", "b_lo", words), items


def _unbanded(band: NoBand, numerical: str, check: Check, value: str, items: list[Item]) -> Bars:
    """Of a rung without a band: what is plausible at least, and at most if that is known."""
    page, above, below = "docs/theory/rungs.md", "", ""
    if isfinite(band.most):
        above = "b_up"
        said = "bound on a part that is only pulled: 10 times the share of what bends it, and 12 "
        said += "times its peak stress over E, over the share"
        items += [
            Given("h_up", said, band.most, "", page),
            Step(above, "bound above", f"(h_up - 1)*{value}", check.unit, page),
        ]
    if isfinite(band.least):
        below = "b_lo"
        items += [
            Given("h_lo", "least plausible share of a rung's value", band.least, "", page),
            Step(below, "bound below", f"(1 - h_lo)*{value}", check.unit, page),
        ]
    return Bars(numerical, above, below, f"no model band: {band.why}")


def solid_bars(bars: SolidBars, value: str, more: float = 0.0) -> Told:
    """Of a solid: what its last refinement leaves, scatter, series and notch; arcs of contact.

    more  MPa, how far another criterion lies above
    """
    own = bars.numerical
    items: list[Item] = []
    if own.singular:
        told = Bars("", words="no numerical bar: the place is singular, no mesh settles it")
    elif len(bars.values) < 2:
        told = Bars("", words="no numerical bar: it takes two meshes")
    else:
        told = Bars("e_num", words=_OF_MESH)
        items += [
            Given("v_1", "the value on the last mesh but one", bars.values[-2], "MPa", "the solid"),
            Given("h_1", "elements there on the last mesh but one", bars.sizes[-2], "mm"),
            Given("h_2", "elements there on the last mesh", bars.sizes[-1], "mm"),
            Step("r_m", "refinement there", f"max(h_1/h_2, {FINER:g})", "", _CALIBRATED),
            Step("e_h", f"left by the last refinement, of order {ORDER:g}",
                 f"max({SAFETY:g}/(r_m^{ORDER:g} - 1), {_written(LEAST)})*abs({value} - v_1)",
                 "MPa", _CALIBRATED),
            Given("e_s", "scatter of the elements that meet there", own.scatter, "MPa"),
            Given("e_n", "what elements of this size miss in the notch", own.notch, "MPa"),
            Given("e_t", "what the series of the pins' pressure misses", own.truncation, "MPa"),
            Step("e_num", "numerical error bar",
                 f"max(e_h, {SCATTER:g}*e_s, e_n) + {REPEATS:g}*{value} + e_t", "MPa",
                 _CALIBRATED),
        ]  # fmt: skip
    above, below = _arcs(bars.by_arc, bars.in_bores, items)
    if more:
        items.append(Given("b_c", "how far another criterion lies above", more, "MPa", "the note"))
        above = f"{above} + b_c" if above else "b_c"
    up = "b_up" if above else ""
    low = "b_lo" if below else ""
    if up:
        items.append(Step(up, "model band above", above, "MPa", "docs/theory/bearing.md"))
    if low:
        items.append(Step(low, "model band below", below, "MPa", "docs/theory/bearing.md"))
    words = "; ".join(text for text in (told.words, _OF_ARCS if up or low else "") if text)
    return Bars(told.numerical, up, low, words), items


def _written(share: float) -> str:
    """A share as a fraction where it is one of a whole, such as 1/3."""
    parts = round(1 / share)
    return f"1/{parts}" if share == 1 / parts else f"{share:.17g}"


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
        items.append(_in_bores(in_bores))
        more += f", p_b - {half}"
    less = ", ".join(f"{half} - {name}" for name in names.values())
    return f"max({more})", f"max({less})"


def _in_bores(value: float) -> Given:
    said = f"the largest in the bores under {1 + BEYOND_ARCS:g} of the forces in the plane"
    return Given("p_b", said, value, "MPa", "docs/validation.md")
