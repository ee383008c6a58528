"""Error bars of the rungs below the solid: how far solids lie from their numbers (bands.json).

Converged solids of variations of the machines' parts are compared with each rung
(`python -m bench.rung_bands`). The band of a check is the prediction interval of solid over rung,
in which the next solid lies in 95 % of all cases if the logarithm of that ratio scatters normally:
exp(m -+ t s sqrt(1 + 1/n)) with mean m and deviation s of the n compared.

Beyond the proportions compared a band is wider by exp(g d), with a g for either side: d is the
distance of the proportions from their ranges, a sum of logarithms, and g what solids drawn out
there need (beyond.json, `python -m bench.rung_beyond`). Arcs of contact reach as far as on the
worst of them. Farther out than those there is no band.

A bar's buckling load is the theory's the better the longer it is, so its length has no end there.

Proportions are the numbers without unit of a part and its loads on which the error of every rung
depends. What solids were compared with tells of a part only if it is like them in all of these: in
its shape's proportions, in how its loads pull, push and bend it, and in the arc on which pins
press.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from math import degrees, exp, inf, isfinite, log
from typing import Any

import numpy as np

from checks.design.data import Part
from checks.models.in_bores import InBores
from checks.models.shapes import shape_model
from checks.part.part_loads import TIE, PartLoads
from checks.result.derivation import Given, Item, Step
from checks.result.words import number
from geometry.shape import Shape

ARC = "arc of contact, deg"
SHARE = "share of the largest force: "
PULLED = SHARE + "pulled"
ACROSS, TURNED = SHARE + "across", SHARE + "couple over its size"
# Proportions up to which no wall buckles by itself below yield under what bends a pulled part or
# what a pin presses: docs/theory/buckling.md.
_STOCKY = {
    "thickness / hole": (0.1, inf),
    "hole / wall": (0.0, 10.0),
    "width / wall": (0.0, 16.0),
    "wall / tube": (0.03, inf),
}
_COUPLE = 1e-6  # of force times size: couples out of the plane that are more than round-off

_BEYOND = 0.1  # of the range that was compared: how far a part's proportions may be outside it
_BUCKLING, _FATIGUE = "buckling", "fatigue"
_LENGTH = "length / "
_OTHER_SHARE = 0.1  # how far a share of the largest force may be outside the range compared
_FRICTION = 0.3  # of a pin: couples up to it are like none, where no solid had any


_PAGE = "docs/theory/rungs.md"
_ARCS = "docs/theory/bearing.md"
Formulas = tuple[list[Item], list[Item]]  # above and below
LEAST = 0.5  # of a formula's stress, beyond the solids compared: these had 0.66 or more of it
_CLOSE = ("plate_link", "plate_link beside others", "tube_rod", "toggle_bar", "prismatic_tube")


@dataclass(frozen=True)
class Band:
    """Where solids lie, as a factor on a rung's value.

    low, high     factors between which 95 % of the solids lie
    count         solids compared
    above, below  how far the model band of the solids reaches (arcs of contact, forks), as shares
                  of the value: least and most of those compared
    wider         why it is wider than inside the range compared, in words
    fixity        what forks that hold the ends may take of a buckling share, over the share
    """

    low: float
    high: float
    count: int
    above: tuple[float, float]
    below: tuple[float, float]
    wider: str = ""
    fixity: float = 0.0

    @property
    def shared_below(self) -> float:
        """How far the band below reaches by what no better model takes away, over the value."""
        return self.below[0] + min(1.0, self.low) * self.fixity

    @property
    def width(self) -> float:
        """How wide the band is, as a share of the value."""
        return self.high - self.low

    def formulas(
        self, symbol: str, unit: str, value: float, bores: InBores | None = None
    ) -> Formulas:
        """Formulas of the model band above and below a value, by its symbol.

        bores  how narrower arcs and uneven pressure move the value; where its arcs are known,
               solids reach as far from the formula on each; else what the solids' own arcs do is
               added
        """
        most = 0.0 if bores is None or bores.most <= value else bores.most
        adds, beyond = 0.0, max(1.0, self.high)
        if bores is not None and bores.loose[0] + bores.loose[1] / beyond > max(most, value):
            most, adds = bores.loose
        arcs = bores is not None and bool(bores.by_arc)
        end = f"{{}} end of where 95 % of solids lie, over this value: {self.count} compared"
        reach = "reach of the solids' own model band {}, over the value"
        above: list[Item] = [bores_given(most)] if most else []
        above.append(Given("h_up", end.format("upper"), self.high, "", _PAGE))
        q_up = q_lo = ""
        if not arcs:
            above.append(Given("q_up", reach.format("above"), self.above[1], "", _PAGE))
            q_up, q_lo = " + q_up", f" + q_lo*{symbol}"
        total = f"(max(0, h_up - 1){q_up})*{symbol}"
        if most:
            total = f"(p_b/{symbol}*(max(1, h_up){q_up}) - 1)*{symbol}"
        if adds:
            said = "what a loose pin presses more than on the narrowest arc, in the measure of p_b"
            above.append(Given("p_m", said, adds, "MPa", _ARCS))
            total += " + p_m"
        above.append(Step("b_up", "model band above", total, unit, _PAGE))
        below: list[Item] = [Given("h_lo", end.format("lower"), self.low, "", _PAGE)]
        least = symbol
        if arcs:
            assert bores is not None
            said = "the least of the half circle and of narrower arcs of contact"
            below.append(Given("p_a", said, bores.least, "MPa", _ARCS))
            least = "p_a"
        else:
            below.append(Given("q_lo", reach.format("below"), self.below[1], "", _PAGE))
        forks = ""
        if self.fixity:
            said = "fixity: what forks that hold the ends against tilting may take, over the value"
            below.append(Given("q_f", said, self.fixity, "", _PAGE))
            forks = f" + min(1, h_lo)*q_f*{symbol}"
        total = f"{symbol} - min(1, h_lo)*{least}{q_lo}{forks}"
        return above, [*below, Step("b_lo", "model band below", total, unit, _PAGE)]


@dataclass(frozen=True)
class NoBand:
    """Why a rung's value has no band, in words.

    least  factor on the value below which no solid is plausible; -infinite where none is known
    most   factor above which none is; infinite where nothing is known
    bound  words for what that one is
    """

    why: str
    least: float = -inf
    most: float = inf
    bound: str = ""

    def formulas(
        self, symbol: str, unit: str, _value: float, _bores: InBores | None = None
    ) -> Formulas:
        """Formulas of the bounds above and below a value, by its symbol; none without a bound."""
        above: list[Item] = []
        below: list[Item] = []
        if isfinite(self.most):
            above = [
                Given("h_up", f"bound, over the share: {self.bound}", self.most, "", _PAGE),
                Step("b_up", "bound above", f"(h_up - 1)*{symbol}", unit, _PAGE),
            ]
        if isfinite(self.least):
            said = "least plausible share of a rung's value"
            below = [
                Given("h_lo", said, self.least, "", _PAGE),
                Step("b_lo", "bound below", f"(1 - h_lo)*{symbol}", unit, _PAGE),
            ]
        return above, below


def bores_given(value: float) -> Given:
    """The largest stress in bores whose arc of contact is not stated, or whose pin bends, MPa."""
    said = "the largest in bores or beside, raised as arcs that are not stated and bent pins may"
    return Given("p_b", said, value, "MPa", "docs/validation.md")


@cache
def _data() -> Mapping[str, Any]:
    text = files("checks.models").joinpath("bands.json").read_text(encoding="utf-8")
    return dict(json.loads(text)["families"])


def known_band(family: str, rung: str, kind: str) -> Band | None:
    """Band of a check for a family of solids, whatever its proportions; None if unknown."""
    entry = _data().get(family, {}).get(rung, {}).get(kind)
    if entry is None:
        return None
    above, below = ((float(entry[side][0]), float(entry[side][1])) for side in ("above", "below"))
    return Band(entry["low"], entry["high"], entry["count"], above, below)


def band_of(family: str, rung: str, kind: str, scales: Mapping[str, float]) -> Band | NoBand:
    """Band of a rung's check for a part with these proportions.

    Without one, a bar's stress that is over the limit at `LEAST` of it still is over the limit.
    """
    band = known_band(family, rung, kind)
    if band is None:
        return NoBand(f"no solids of the family {family!r} were compared with the rung {rung}")
    scales = of_buckling(scales) if kind == _BUCKLING else scales
    beyond = _beyond(family, rung, kind, scales)
    if isinstance(beyond, NoBand):
        return beyond
    if not beyond:
        return band
    far = sum(beyond.values())
    grown = _growth(family, rung, kind)
    name = max(beyond, key=lambda one: beyond[one])
    low, high = _data()[family][rung][kind]["scales"][name]
    told = f"{name} is {scales[name]:.3g}, solids were compared from {low:.3g} to {high:.3g}"
    if grown is None or far > grown["furthest"] or not _measured(grown, scales, beyond):
        return NoBand(told, LEAST if kind != _BUCKLING and family in _CLOSE else -inf)
    lower, wider = (exp(grown[side] * far) for side in ("lower", "higher"))
    return Band(
        band.low / lower,
        band.high * wider,
        band.count,
        (band.above[0], max(band.above[1], grown["above"])),
        (band.below[0], max(band.below[1], grown["below"])),
        f"{told}: {wider:.2f} times as high and {lower:.2f} times as low, as {grown['count']} "
        "solids out there need",
    )


def distance_from(family: str, rung: str, kind: str, scales: Mapping[str, float]) -> float | None:
    """How far proportions lie outside what was compared; None where they cannot be compared."""
    if known_band(family, rung, kind) is None:
        return None
    scales = of_buckling(scales) if kind == _BUCKLING else scales
    beyond = _beyond(family, rung, kind, scales)
    return None if isinstance(beyond, NoBand) else sum(beyond.values())


def _beyond(
    family: str, rung: str, kind: str, scales: Mapping[str, float]
) -> dict[str, float] | NoBand:
    """Distance of every proportion that lies outside its range, slack included.

    The logarithm of value over the end of the range, or the difference of a share of the force. An
    arc of contact that is wider than those compared leaves the pin less room, not more, and a
    longer bar buckles more like the theory's.
    """
    compared = _data()[family][rung][kind]["scales"]
    found = {}
    for name, value in scales.items():
        if name not in compared:
            return NoBand(f"{name} is {value:.3g}, no solid that has one was compared")
        low, high = compared[name]
        if name == ARC:
            high = inf
        slack = 1e-9 * abs(low) + (_BEYOND * (high - low) if high < inf else 0.0)
        if kind == _BUCKLING and name.startswith(_LENGTH):
            high = inf
        share = name.startswith(SHARE)
        if share:
            slack = max(slack, _OTHER_SHARE)
        if low - slack <= value <= high + slack:
            continue
        if share:
            found[name] = max(low - value, value - high)
        elif not value > 0.0 or not low > 0.0:
            found[name] = inf
        else:
            found[name] = log(low / value) if value < low else log(value / high)
    return found


def turned_otherwise(family: str, rung: str, kind: str, part: Part, loads: PartLoads) -> str:
    """Say that couples turn a part in its bores more than friction does, "" where they do not.

    Of fatigue couples and forces count as they swing in a cycle: a steady push hides neither. Where
    solids with couples were compared, they are among the shares of the largest force.
    """
    compared = _data()[family][rung][kind]["scales"].get(TURNED)
    faces = part.geometry.placed_interfaces
    radius = max((face.radius for face in faces if face.kind == "bore"), default=0.0)
    if part.body is None or not radius or compared is None or compared[1]:
        return ""
    runs = list(loads.cycles.values()) if kind == _FATIGUE else [slice(None)]
    wrenches = [wrench[run] for wrench in loads.wrenches.values() for run in runs]
    if kind == _FATIGUE:
        wrenches = [np.ptp(wrench, axis=0)[None] for wrench in wrenches]
    force = max(float(np.hypot(one[:, 0], one[:, 1]).max()) for one in wrenches)
    couple = max(float(np.abs(one[:, 5]).max()) for one in wrenches)
    if couple <= _FRICTION * radius * force + TIE * part.geometry.length * loads.largest_force:
        return ""
    swing = kind == _FATIGUE
    return (
        f"couples {'swing by' if swing else 'are'} up to {number(couple * 1e-3)} N m in bores "
        f"whose forces {'swing by' if swing else 'are'} up to {number(force)} N, more than "
        f"friction of {_FRICTION:g} makes of these; solids were compared without"
    )


def _measured(
    grown: Mapping[str, Any], scales: Mapping[str, float], beyond: Mapping[str, float]
) -> bool:
    """True if solids were drawn as far out, to a tenth, in each proportion that lies outside."""
    for name in beyond:
        low, high = grown["scales"].get(name, (inf, -inf))
        if name.startswith(SHARE):
            low, high = low - _OTHER_SHARE, high + _OTHER_SHARE
        else:
            low, high = low / (1 + _BEYOND), high * (1 + _BEYOND)
        if not low <= scales[name] <= high:
            return False
    return True


def _growth(family: str, rung: str, kind: str) -> Mapping[str, Any] | None:
    """Growth, farthest distance and number of the solids out there, reach of their arcs."""
    if rung != "formula":
        return None
    found: Mapping[str, Any] | None = _beyond_data().get(family, {}).get(kind)
    return found


@cache
def _beyond_data() -> Mapping[str, Any]:
    text = files("checks.models").joinpath("beyond.json").read_text(encoding="utf-8")
    return dict(json.loads(text)["families"])


def proportions_of(part: Part, loads: PartLoads) -> dict[str, float]:
    """All of them, by name; shares of the largest force begin with SHARE."""
    return {
        **part.geometry.proportions,
        ARC: degrees(part.bearing_arc),
        **_of_loads(part, loads),
        **_of_tilt(part, loads),
    }


def of_buckling(proportions: Mapping[str, float]) -> dict[str, float]:
    """The proportions that a buckling load depends on: loads over the largest that can buckle.

    A pull buckles nothing, however large it is beside them. A part that is only pulled has none.
    The arc of contact is none of them: every model buckles under resultants, or the half circle's
    pressure.
    """
    shares = {name: one for name, one in proportions.items() if name.startswith(SHARE)}
    shares.pop(PULLED, None)
    largest = max(shares.values(), default=0.0)
    shape = {
        name: one for name, one in proportions.items() if not name.startswith(SHARE) and name != ARC
    }
    return shape | {name: one / largest for name, one in shares.items() if largest}


def tilting_couple(part: Part, loads: PartLoads) -> float:
    """Largest couple out of the plane, N mm; 0 where it is not more than round-off."""
    size = loads.largest_force * part.geometry.length
    couple = max(float(np.abs(wrench[:, 3:5]).max()) for wrench in loads.wrenches.values())
    return couple if couple > _COUPLE * size else 0.0


def beside_others(part: Part, _shape: Shape, loads: PartLoads, kind: str) -> str:
    """A family: plates beside others are bent out of their plane; they buckle by shape alone."""
    beside = kind != _BUCKLING and tilting_couple(part, loads)
    return f"{part.shape} beside others" if beside else part.shape


def unknown_load(part: Part, loads: PartLoads) -> str:
    """Load on a part that no rung of its shape knows, in words; "" if there is none."""
    if _knows_tilt(part):
        return ""
    couple = tilting_couple(part, loads)
    if couple:
        return (
            f"couples out of the plane, up to {couple:.3g} N mm, which no rung of {part.shape} has"
        )
    return ""


def _knows_tilt(part: Part) -> bool:
    model = shape_model(part.geometry)
    return model is not None and model.tilts


def proportions_known(part: Part) -> bool:
    """True for the shapes that are built from dimensions: what comes from CAD tells no walls."""
    return bool(part.geometry.proportions)


def walls_known(proportions: Mapping[str, float]) -> bool:
    """True where a proportion tells how thin the walls are."""
    return not _STOCKY.keys().isdisjoint(proportions)


def thin_wall(proportions: Mapping[str, float]) -> str:
    """Name a proportion of walls that are so thin that they may buckle by themselves; or ""."""
    for name, (low, high) in _STOCKY.items():
        value = proportions.get(name)
        if value is not None and not low <= value <= high:
            return f"{name} is {value:.3g}: a wall may buckle by itself"
    return ""


def _of_tilt(part: Part, loads: PartLoads) -> dict[str, float]:
    """How far beside a plate its forces stand, over its width."""
    if part.body is None or not _knows_tilt(part):
        return {}
    couple, width = tilting_couple(part, loads), part.geometry.stressed_section[0]
    if not couple:
        return {}
    return {"couple out of the plane / force x width": couple / (loads.largest_force * width)}


def _of_loads(part: Part, loads: PartLoads) -> dict[str, float]:
    """How it is pulled and pushed at the end where it is more, pressed across and turned."""
    largest, model = loads.largest_force, shape_model(part.geometry)
    if part.body is None or not largest or len(loads.wrenches) < 2:
        return {}
    first, second = (loads.wrenches[name][:, 0] for name in part.geometry.interfaces[:2])
    pull = np.concatenate([second, -first])
    across, turned = (
        max(float(np.abs(wrench[:, row]).max()) for wrench in loads.wrenches.values())
        for row in (1, 5)
    )
    along = {
        PULLED: max(float(pull.max()), 0.0) / largest,
        SHARE + "pushed": max(float(-pull.min()), 0.0) / largest,
    }
    if model is not None and model.statics and loads.own_swing:
        return along
    return {
        **along,
        ACROSS: across / largest,
        TURNED: turned / (largest * part.geometry.length),
    }
