"""What-if of the page: checks under other settings, where a formula or a proportion gives them.

No part is solved again: the stresses stay, and the formulas of the checks' derivations are
evaluated with other numbers put in. Error bars stay in proportion to their value. A factor on all
loads divides the safeties. Where pins press by contact, whose arc it changes, loads, clearances and
arcs lie between those that a solid's check has solved (`checks.ladder.pin_settings`).
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import exp, isfinite, log
from operator import attrgetter
from shlex import quote
from typing import Any

import numpy as np
from markupsafe import Markup

from checks.design.materials import Material, known_materials
from checks.result.derivation import BARS, Derivation, Given, Item, Step, Sum, value_of
from checks.result.formulas import FormulaError, Value, evaluate
from checks.result.verdict import Check, DesignResult, PartResult
from checks.result.ways import SOLID
from checks.result.words import CONTACT, check_titles, clipped, need_text
from reports.templating import json_markup

_STEPS = (0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.15, 1.2, 1.3, 1.4, 1.5)
_COUNTS = (0.01, 0.03, 0.1, 0.3, 0.5, 1.0, 2.0, 3.0, 10.0, 30.0, 100.0)
_SURVIVAL = (0.5, 0.9, 0.99, 0.999, 0.9999)
_FACTORS = (
    0.5,
    0.6,
    0.7,
    0.8,
    0.85,
    0.9,
    0.95,
    1.0,
    1.05,
    1.1,
    1.15,
    1.2,
    1.3,
    1.4,
    1.5,
    1.75,
    2.0,
)
_CLEARANCES = tuple(k / 32 for k in (0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 20, 24, 28, 32))
_HALF = 180.0
_ARCS = (90.0, 105.0, 120.0, 135.0, 150.0, 165.0, _HALF)  # deg
_UNTOLD = "untold"  # among changes: no formula tells what they do
_MADE = "safety"  # among changes: the safety that checks made beforehand have for them
_HALVINGS = 20  # of the range of a factor that is sought
_REQUIRED = ("buckling", "fatigue", "bush")  # kinds with a required safety of their own
_LOAD = "load_factor"
_HERTZ = "Hertz pressure"
_CROOKED = "crooked bar "
_SHARED = re.compile(r"the (weaker|softer)")  # limits that another part may give, too
Changes = Mapping[str, float]  # symbol -> other value; of a column the factor on it


@dataclass(frozen=True)
class Lever:
    """An input that the page can set.

    key      of the design file
    now      the design's own setting, as text
    changes  by setting, to the formulas of the check that it acts on
    overrides  by setting, where they are not the key with the text
    """

    key: str
    title: str
    now: str
    changes: Mapping[str, Changes]
    overrides: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Data of the page's script."""
        return {
            "title": clipped(self.title, 80),
            "texts": list(self.changes),
            "sets": [
                " --set ".join(map(quote, self.overrides.get(text, (f"{self.key}={text}",))))
                for text in self.changes
            ],
            "now": list(self.changes).index(self.now),
            "material": self.key.endswith(".material"),
        }

    @property
    def settings(self) -> list[Changes]:
        """Changes of all settings, none of the design's own."""
        return [{} if text == self.now else one for text, one in self.changes.items()]


def what_if(result: DesignResult) -> Markup | None:
    """Data of the what-if as the page holds it; None where there is nothing to set."""
    levers = _Levers(result)
    contacts = {gate.name.removesuffix(CONTACT) for part in result.parts for gate in part.gates}
    checks = [
        found
        for check, title in zip(result.checks, check_titles(result.checks), strict=True)
        if (found := _check(check, title, levers, check is result.deciding)) is not None
    ]
    if not checks:
        return None
    load = levers.number(levers.load())
    for each, check in zip(checks, (check for check in result.checks if check.value), strict=True):
        pressed = check.part in contacts and check.method.startswith(SOLID)
        followed = check.kind in ("static", "fatigue") and (pressed or levers.lasts(check))
        each["load"] = 0 if followed else _exponent_of_load(check)
        each["pins"] = _by_pins(check, levers, followed)
    data = {
        "command": result.command,
        "doubted": any(gate.binding and not gate.holds for gate in result.gates),
        "levers": [lever.to_dict() for lever in levers.found],
        "load": load,
        "loaded": float(levers.found[load].now),
        "checks": checks,
    }
    return json_markup(data)


def _check(check: Check, title: str, levers: "_Levers", governs: bool) -> dict[str, Any] | None:
    """A check as the page's script needs it; None for one without load.

    safety  at its value, for all settings of its levers, the last lever's first; None for unknown
    upper   end of its error bars over its value, lower alike; None for an infinite one
    shared  True if another part's material may give its limit
    """
    if not check.value:
        return None
    mine = list(levers.of(check))
    settings = product(*(lever.settings for lever in mine))
    required = levers.required(check)
    return {
        "governs": governs,
        "name": clipped(f"{check.part} {title}", 80),
        "required": check.required if required is None else levers.number(required),
        "levers": [levers.number(lever) for lever in mine],
        "safety": [_safety(check, [c for c in changes if c]) for changes in settings],
        "upper": check.upper / check.value if isfinite(check.upper) else None,
        "lower": check.lower / check.value if isfinite(check.lower) else None,
        "shared": _is_shared(check),
        "status": str(check.status),
    } | ({"fixed": True} if required is None else {})


def _by_pins(check: Check, levers: "_Levers", pressed: bool) -> list[dict[str, Any]]:
    """A check's value and bars by the settings of its pins, each over the value as it is.

    pressed  contact decides it, or a bush pressed in: neither goes with a factor on all loads

    None where a setting is not followed: the stress of a like part that no solid was solved for.
    """
    found = []
    for lever, settings in (*levers.of_pins(check), *([levers.of_load(check)] if pressed else [])):
        rows = [one and [one.value, one.upper, one.lower] for one in settings]
        found.append({"lever": levers.number(lever), "rows": rows})
    return found


def _exponent_of_load(check: Check) -> float:
    """Exponent p of value ~ factor^p, for a factor on all loads.

    A Hertz pressure of a line goes with the root of the force; every other value is linear in the
    loads, or one over the factor on all of them at which the limit is met.
    """
    return 0.5 if check.quantity.startswith(_HERTZ) else 1.0


def _is_weld_fatigue(check: Check) -> bool:
    return check.kind == "weld" and check.quantity.startswith("fatigue")


def _is_shared(check: Check) -> bool:
    return any(
        isinstance(item, Given) and _SHARED.search(item.meaning)
        for item in (check.derivation.items if check.derivation else ())
    )


def _safety(check: Check, changes: Sequence[Changes]) -> float | None:
    """Safety under some changes of what is put into its formulas; None where they do not tell."""
    if not changes:
        return check.safety
    if any(_UNTOLD in one for one in changes):
        return None
    made = [one[_MADE] for one in changes if _MADE in one]
    if made:
        return made[0] if len(changes) == 1 else None
    derivation = check.derivation
    assert derivation is not None  # else it has no lever
    try:
        value, limit = changed(derivation, {s: v for one in changes for s, v in one.items()})
    except (FormulaError, ValueError):
        return None
    return limit / value if value > 0 else None


def changed(derivation: Derivation, changes: Changes) -> tuple[float, float]:
    """Value and limit of a check with other numbers put into its formulas.

    The factor that brings Miner's sum to what is allowed is sought again. Raises FormulaError where
    a formula has no value, ValueError where the endurance limit would decide instead of the sum, or
    a place would have to be sought again.
    """
    items = [
        item for section in derivation.sections if section.title != BARS for item in section.items
    ]
    scope = _evaluated(items, derivation.values, changes)
    if derivation.equal:
        damage = next((i for i in items if isinstance(i, Sum) and i.symbol == "D"), None)
        if damage is None or set(changes) != {"m"}:
            raise ValueError("a place was sought, too")

        def missed(factor: float) -> float:
            found = _evaluated(items, derivation.values, {**changes, "n": factor})
            return float(found["D"] / found["D_a"]) - 1.0

        used = Sum("u", "", "a/S_p + b/S_u", damage.names, damage.columns)
        endless = 1.0 / max(
            float(evaluate(used.formula, row)) for row in used.scopes(derivation.values)
        )
        low, high = endless, derivation.number("n")
        if missed(low) > 0:
            raise ValueError("the endurance limit decides")
        while missed(high) < 0:  # or a formula has no value any more
            low, high = high, 1.2 * high
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if missed(middle) < 0 else (low, middle)
        scope = _evaluated(items, derivation.values, {**changes, "n": high})
    return float(scope[derivation.value]), float(scope[derivation.limit])


def _evaluated(
    items: Sequence[Item], base: Mapping[str, Value], changes: Changes
) -> dict[str, Any]:
    """Values of all symbols; formulas that do not use what has changed are not evaluated again."""
    scope: dict[str, Any] = {**base, **{s: v for s, v in changes.items() if s in base}}
    moved = set(changes)
    for item in items:
        if isinstance(item, Sum):
            columns = tuple(
                replace(c, values=tuple(changes[c.symbol] * v for v in c.values))
                if c.symbol in changes
                else c
                for c in item.columns
            )
            item = replace(item, columns=columns)
        if isinstance(item, Step | Sum) and moved & set(re.findall(r"\w+", item.formula)):
            scope[item.symbol] = value_of(item, scope)
            moved.add(item.symbol)
    return scope


class _Levers:
    """Inputs that the checks of a result can be followed over; `found` are those that were used."""

    def __init__(self, result: DesignResult) -> None:
        self.inputs = dict(result.defaults) | dict(result.inputs)
        self.stated = {key for key, _ in result.inputs}
        self.parts = {part.name: part for part in result.parts}
        self.found: list[Lever] = []

    def number(self, lever: Lever) -> int:
        """Place of a lever on the page; levers of one key are one."""
        keys = [one.key for one in self.found]
        if lever.key not in keys:
            self.found.append(lever)
            return len(keys)
        return keys.index(lever.key)

    def load(self) -> Lever:
        """Factor on all loads; the page divides safeties by it, no formula is evaluated."""
        now = float(self.inputs.get(_LOAD, "1"))
        texts = {f"{now * step:.4g}" if step != 1.0 else f"{now:g}" for step in _FACTORS}
        return Lever(
            _LOAD, "load factor", f"{now:g}", {text: {} for text in sorted(texts, key=float)}
        )

    def lasts(self, check: Check) -> bool:
        """True where a bush pressed into the part stresses it whatever the loads."""
        part = self.parts.get(check.part)  # none of the linkage
        return part is not None and "pressed" in part.charts

    def of_load(self, check: Check) -> tuple[Lever, list["Pressed | None"]]:
        """Factor on all loads, and a check by it whose pins press by contact."""
        lever, kinds = self.load(), self.parts[check.part].charts.get("pins", {}).get("kinds", {})
        own, now = kinds.get(check.kind), float(lever.now)
        if not isfinite(check.upper):
            return lever, [None] * len(lever.changes)
        if self.lasts(check):
            as_it_is = Pressed(1.0, check.upper / check.value, check.lower / check.value)
            return lever, [as_it_is if text == lever.now else None for text in lever.changes]
        if own is None:
            return lever, [None] * len(lever.changes)
        return lever, [_by_load(check, own, float(text) / now) for text in lever.changes]

    def required(self, check: Check) -> Lever | None:
        """Required safety of a check's kind; None where another one is required of it."""
        if _is_weld_fatigue(check):
            return None  # its partial factor may be the one
        crooked = check.quantity.startswith("crooked")
        kind = check.kind if check.kind in _REQUIRED and not crooked else "static"
        key = f"require.{kind}"
        if float(self.inputs.get(key, "nan")) != check.required:
            return None
        now = need_text(check.required)
        texts = [
            need_text(round(check.required * step, 2)) if step != 1 else now for step in _STEPS
        ]
        return Lever(key, f"required safety, {kind}", now, {text: {} for text in texts})

    def of(self, check: Check) -> Iterator[Lever]:
        """Levers that act on a check."""
        if check.derivation is None:
            return
        if check.quantity.startswith(_CROOKED):
            yield from self._of_crooked(check)
            return
        given = {
            i.symbol: i.value
            for i in check.derivation.items
            if isinstance(i, Given) and not isinstance(i.value, tuple)
        }
        # a number that is put in, or another chain of strength, hides what they act on
        hidden = check.kind == "fatigue" and ("S_p" in given or not {"R", "S_u"} <= set(given))
        untold: dict[str, float] = {_UNTOLD: 0.0} if hidden else {}
        if "R" in given:
            shares = sorted({*_SURVIVAL, given["R"]})
            part, key = self._owner(check.part, "reliability")
            texts = {share: f"{100 * share:.6g} %" for share in shares}
            changes = {text: {"R": share} | untold for share, text in texts.items()}
            yield Lever(key, f"parts that survive, {part}", texts[given["R"]], changes)
        if hidden or (({"S_y", "S_u"} & set(given)) and not _is_shared(check)):
            yield from self._material(check, given, untold)
        if "p_a" in given:
            yield from self._allowable(check)
        if check.quantity.startswith("Miner"):
            yield from self._runs(not check.derivation.equal)
        if _is_weld_fatigue(check) and self.inputs.get("duty.life") == "finite":
            yield from self._runs(True, told=False)

    def _of_crooked(self, check: Check) -> Iterator[Lever]:
        """Eccentricity and material of a crooked bar, whose worst place is sought for each anew."""
        assert check.derivation is not None
        owner, key = self._owner(check.part, "column")
        alike = [name for name in self.parts if self._owner(name, "column")[0] == owner]
        made = {name: self.parts[name].charts.get("crooked") for name in alike}
        own, plane = made.get(check.part), check.quantity.removeprefix(_CROOKED)
        shown = next((one for one in made.values() if one and plane in one["yields"]), None)
        if own is None or shown is None or plane not in own["yields"]:
            return
        used = [[at, 1 / safety] for at, safety in own["eccentricities"][plane]]
        yields = [[log(at), log(safety)] for at, safety in own["yields"][plane]]
        limit = check.derivation.number("S_y")
        now, level = _between(used, own["own"]), _between(yields, log(limit))

        def beside(at: float) -> Changes:  # a moment grows with it
            other = _within(used, at)
            return {_UNTOLD: 0.0} if other is None else {_MADE: check.safety * now / other}

        def of_yield(at: float) -> Changes:  # in proportion, up to buckling
            other = _within(yields, log(at))
            return {_UNTOLD: 0.0} if other is None else {_MADE: check.safety * exp(other - level)}

        changes = {
            f"{at:g} mm": {} if at == own["own"] else beside(at)
            for at, _ in shown["eccentricities"][plane]
        }
        title = f"eccentricity of the push, {owner}"
        yield Lever(f"{key}.eccentricity", title, f"{own['own']:g} mm", changes)
        for lever in self._material(check, {"S_y": limit}, {}):
            found = {text: of_yield(one["S_y"]) for text, one in lever.changes.items()}
            yield replace(lever, changes=found)

    def _material(
        self, check: Check, given: Mapping[str, Any], untold: dict[str, float]
    ) -> Iterator[Lever]:
        result = self.parts.get(check.part)
        known = known_materials()
        own = known.get(result.material.partition(" above ")[0]) if result else None
        if own is None or "q" in given:
            return
        strengths = {
            other.name: {"S_y": found[0], "S_u": found[1]}
            for other in sorted(known.values(), key=lambda m: m.yield_stress)
            if _stiff_as(other, own) and (found := _strengths(other, own, result))
        }
        if own.name not in strengths or len(strengths) == 1:
            return
        part, key = self._owner(check.part, "material")
        changes = {
            name: {s: v for s, v in both.items() if s in given} | untold
            for name, both in strengths.items()
        }
        yield Lever(key, f"material, {part}", own.name, changes)

    def _allowable(self, check: Check) -> Iterator[Lever]:
        of = check.quantity.rpartition(" ")[2]
        texts = {step: f"{check.limit * step:.4g} MPa" for step in _STEPS}
        changes = {text: {"p_a": check.limit * step} for step, text in texts.items()}
        for key, value in self.inputs.items():
            seat = re.fullmatch(
                rf"(parts\.{re.escape(check.part)}\.stack\[\d+\])\.(body|force)", key
            )
            if seat and value == of and f"{seat[1]}.bush.allowable" in self.inputs:
                title = f"allowable pressure, {check.quantity}"
                yield Lever(f"{seat[1]}.bush.allowable", title, texts[1.0], changes)

    def _runs(self, endless: bool, *, told: bool = True) -> Iterator[Lever]:
        """Runs of the only cycle of a duty; endless: more of them change nothing, fewer may.

        told  False where no formula tells of other runs
        """
        keys = [key for key in self.inputs if key.startswith("duty.cycles.")]
        if len(keys) == 1:
            texts = {step: f"{float(self.inputs[keys[0]]) * step:.4g}" for step in _COUNTS}
            changes = {
                text: {"m": step} if not endless else {_UNTOLD: 0.0} if step < 1 or not told else {}
                for step, text in texts.items()
            }
            title = f"runs of {keys[0].removeprefix('duty.cycles.')} in the life"
            yield Lever(keys[0], title, texts[1.0], changes)

    def of_pins(self, check: Check) -> Iterator[tuple[Lever, list["Pressed | None"]]]:
        """Clearance and arc of the pins in a part, and its check by their settings.

        The first setting is the design's own. Parts that are alike have one lever.
        """
        if check.kind not in ("static", "fatigue") or not isfinite(check.upper):
            return
        for key, lever_of, values_of in (
            ("fits", self._clearance, _by_clearance),
            ("bearing_arc", self._arc, _by_arc),
        ):
            owner = self._owner(check.part, key)[0]
            alike = [name for name in self.parts if self._owner(name, key)[0] == owner]
            data = {name: self.parts[name].charts.get("pins", {}) for name in alike}
            levers = [lever_of(owner, data[name]) for name in alike]
            lever = next((one for one in levers if one is not None), None)
            if lever is None:
                continue
            own = data[check.part].get("kinds", {}).get(check.kind)
            if own is None or not check.method.startswith(SOLID):
                yield lever, [Pressed(1.0, 1.0, 1.0), *[None] * (len(lever.changes) - 1)]
                continue
            yield lever, [values_of(check, own, one) for one in lever.changes.values()]

    def _clearance(self, owner: str, pins: Mapping[str, Any]) -> Lever | None:
        """Clearance of all pins of a part, at a share of the range of its fit."""
        fits: Mapping[str, Sequence[float]] = pins.get("fits", {})
        if not any("clearances" in kind for kind in pins.get("kinds", {}).values()):
            return None
        ranges = {tuple(ends) for ends in fits.values()}
        now = f"{' or '.join(f'{low:.4g} to {high:.4g}' for low, high in sorted(ranges))} mm"
        changes: dict[str, Changes] = {now: {}}
        overrides = {}
        for share in _CLEARANCES:
            sizes = {name: low + share * (high - low) for name, (low, high) in fits.items()}
            text = f"{' or '.join(f'{size:.4g}' for size in sorted(set(sizes.values())))} mm"
            changes[text] = {"share": share}
            overrides[text] = [
                f'parts.{owner}.fits.{name}="{size:.4g} mm"' for name, size in sizes.items()
            ]
        return Lever(f"parts.{owner}.fits", f"clearance of pins, {owner}", now, changes, overrides)

    def _arc(self, owner: str, pins: Mapping[str, Any]) -> Lever | None:
        """Arc on which the pins of a part press."""
        arcs = [kind["arcs"] for kind in pins.get("kinds", {}).values() if "arcs" in kind]
        if not arcs:
            return None
        narrow = min(arc for arc, *_ in arcs[0])
        key = f"parts.{owner}.bearing_arc"
        now = f"{narrow:g} deg" if key in self.stated else "not stated"
        changes: dict[str, Changes] = {now: {}}
        changes |= {f"{arc:g} deg": {"arc": arc} for arc in _ARCS if f"{arc:g} deg" not in changes}
        changes = {text: one for text, one in changes.items() if one.get("arc", narrow) >= narrow}
        return Lever(key, f"arc on which pins press, {owner}", now, changes)

    def _owner(self, part: str, key: str) -> tuple[str, str]:
        """Part that states a key for a part that is like it, and the key."""
        while f"parts.{part}.like" in self.stated and not any(
            one == f"parts.{part}.{key}" or one.startswith(f"parts.{part}.{key}.")
            for one in self.stated
        ):
            part = self.inputs[f"parts.{part}.like"]
        return part, f"parts.{part}.{key}"


@dataclass(frozen=True)
class Pressed:
    """A check's value, upper and lower end under another press of its pins, over its own value."""

    value: float
    upper: float
    lower: float


def _by_clearance(check: Check, own: Mapping[str, Any], at: Changes) -> Pressed | None:
    """At one clearance: no band of clearances is left, the other bars stay in proportion."""
    return _by_row(check, own, own.get("clearances", ()), at["share"]) if at else _as_is(check)


def _by_load(check: Check, own: Mapping[str, Any], factor: float) -> Pressed | None:
    """Under a factor on all loads; between solved ones on lines over its logarithm."""
    if factor == 1.0:
        return _as_is(check)
    rows = [[log(row[0]), *row[1:]] for row in own.get("loads", ())]
    inside = rows and rows[0][0] <= log(factor) <= rows[-1][0]
    return _by_row(check, own, rows, log(factor), factor) if inside else None


def _by_row(
    check: Check,
    own: Mapping[str, Any],
    rows: Sequence[Sequence[float]],
    at: float,
    times: float = 1.0,
) -> Pressed | None:
    """Times what the rows have at a setting; the other bars stay in proportion to the value."""
    if not rows:
        return None
    value, *sides = (times * _between([(row[0], row[k]) for row in rows], at) for k in (1, 2, 3))
    less = value / check.value
    others = check.model - own["band"][0], check.below - own["band"][1]
    above, below = (side + less * other for side, other in zip(sides, others, strict=True))
    return _pressed(check, value, above, below, check.numerical * less)


def _by_arc(check: Check, own: Mapping[str, Any], at: Changes) -> Pressed | None:
    """With an arc stated the value is still the half circle's; its band reaches to this arc."""
    if not at:
        return _as_is(check)
    if "arcs" not in own:
        return None
    values = [row[:2] for row in own["arcs"]]
    most, half = [(arc, reached) for arc, _, reached in own["arcs"]], _between(values, _HALF)
    arcs = at["arc"], (_HALF + at["arc"]) / 2, _HALF
    above = check.model - own["of_arcs"][0] + max(_between(most, arc) for arc in arcs) - half
    below = check.below - own["of_arcs"][1] + half - min(_between(values, arc) for arc in arcs)
    return _pressed(check, check.value, above, below)


def _as_is(check: Check) -> Pressed:
    return _pressed(check, check.value, check.model, check.below)


def _pressed(
    check: Check, value: float, above: float, below: float, numerical: float | None = None
) -> Pressed:
    bar = check.numerical if numerical is None else numerical
    ends = value + bar + max(above, 0.0), value - bar - max(below, 0.0)
    return Pressed(value / check.value, ends[0] / check.value, ends[1] / check.value)


def _between(points: Sequence[Sequence[float]], at: float) -> float:
    """Value between solved ones, (place, value) each, on straight lines."""
    places, values = zip(*sorted(map(tuple, points)), strict=True)
    return float(np.interp(at, places, values))


def _within(points: Sequence[Sequence[float]], at: float) -> float | None:
    """Value between rising points, None beyond them."""
    return _between(points, at) if points[0][0] <= at <= points[-1][0] else None


def _stiff_as(one: Material, other: Material) -> bool:
    """True if stresses and loads are the same of both, and their chains of fatigue begin alike."""

    def form(of: Material) -> tuple[object, ...]:
        return (
            of.youngs_modulus, of.poisson_ratio, of.density, of.ductile, of.endurance_ratio,
            of.endurance_cycles, of.fkm_group, of.threshold,
        )  # fmt: skip

    return form(one) == form(other)


def _strengths(
    material: Material, own: Material, part: PartResult | None
) -> tuple[float, float] | None:
    """Strengths of a material in all sizes that a part may have, of which its own tell a range.

    None where they differ within that range.
    """
    facts = part.facts if part else {}
    has = facts.get("yield stress [MPa]"), facts.get("ultimate stress [MPa]")
    grades = [(g.yield_stress, g.ultimate_stress) for g in own.grades]
    if has not in grades:
        return None
    index = grades.index(has)
    found: set[tuple[float, float] | None] = set()
    for size in attrgetter("thickness"), attrgetter("diameter"):
        least, most = size(own.grades[index - 1]) if index else 0.0, size(own.grades[index])
        below = 0.0
        for grade in material.grades:
            if below < most and size(grade) > least:
                found.add((grade.yield_stress, grade.ultimate_stress))
            below = size(grade)
        if below < most:  # larger than any whose strengths are known
            found.add(None)
    return found.pop() if len(found) == 1 else None
