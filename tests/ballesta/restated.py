"""A design stated otherwise: reordered, renamed, in other units, turned, mirrored, scaled."""

import re
import tomllib
from math import cos, pi, radians, sin
from pathlib import Path

from ballesta.design.files import resolve_like
from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.ladder.part_ladder import Effort

from ..lighter import without_fatigue

DESIGNS = Path(__file__).parents[2] / "designs"
MACHINES = ("slider_crank", "quick_return", "spring_hammer", "toggle_press")
_NUMBER = r"[+-]?\d+\.?\d*(?:e[+-]?\d+)?"
_QUANTITY = re.compile(rf"({_NUMBER}(?:(, | \.\. ){_NUMBER})?)(?: ([A-Za-z0-9/% ]+))?")
_LBF = 4.4482216152605

# unit: how it grows with lengths at the same density and stress; another unit, how much of this one
UNITS = {
    "mm": (1, "inch", 25.4),
    "m": (1, "ft", 0.3048),
    "g": (3, "lb", 453.59237),
    "kg": (3, "lb", 0.45359237),
    "kg m2": (5, "lb ft2", 0.45359237 * 0.3048**2),
    "N": (2, "lbf", _LBF),
    "kN": (2, "lbf", _LBF / 1e3),
    "N m2": (4, "lbf ft2", _LBF * 0.3048**2),
    "m/s2": (-1, "ft/s2", 0.3048),
    "m/s": (0, "inch/s", 0.0254),
    "rad/s": (-1, "rpm", 2 * pi / 60),
    "rpm": (-1, "rad/s", 60 / (2 * pi)),
    "deg": (0, "rad", 180 / pi),
    "MPa": (0, "psi", _LBF / 25.4**2),
    "GPa": (0, "psi", _LBF / 25.4**2 / 1e3),
    "kg/m3": (0, "lb/ft3", 0.45359237 / 0.3048**3),
    "1/min": (-1, "1/h", 1 / 60),
    "%": (0, "%", 1.0),
}


def stated(machine, cycles, positions=73, duty=None):
    """The data of a shipped design without its `like`s, some of its cycles, and no reasons.

    cycles  those that stay
    duty    those in the duty; None for all of them
    """
    data = flattened(machine)
    data["cycles"] = {name: data["cycles"][name] | {"positions": positions} for name in cycles}
    data["duty"]["cycles"] = dict.fromkeys(duty or cycles, 1e7)
    data.pop("assumed", None)
    parts = {
        name: {"overhang": "5 mm"} | part if part.get("shape") == "pin" else part
        for name, part in data["parts"].items()
    }
    # defaults are stated, so that they can be changed
    return {"gravity": "0, -9.81 m/s2"} | data | {"parts": parts}


def flattened(machine):
    """The data of a shipped design without its `like`s."""
    data = tomllib.loads((DESIGNS / f"{machine}.toml").read_text(encoding="utf-8"))
    resolve_like(data, None)
    return data


def checked(folder, data, fidelity="formula", fatigue=True):
    """The result of a design that is given as data."""
    design = designed(folder, data)
    design = design if fatigue else without_fatigue(design)
    return check_design(design, effort=Effort(fidelity=fidelity))


def designed(folder, data):
    """The design that is given as data."""
    path = folder / "restated.toml"
    path.write_text(written(data), encoding="utf-8")
    return read_design(path)


def written(data):
    """Data as TOML, each table in one line."""
    return "".join(f"{_key(name)} = {_value(value)}\n" for name, value in data.items())


def _key(name):
    return '"' + name + '"'


def _value(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_value(each) for each in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return '"' + value + '"' if isinstance(value, str) else repr(value)


def reordered(data):
    """Every table the other way round; lists stay, as their order has a meaning."""
    if isinstance(data, dict):
        return {name: reordered(data[name]) for name in reversed(data)}
    return [reordered(each) for each in data] if isinstance(data, list) else data


def ends_swapped(data):
    """The same links, their first ends called second, and levers told from their last bore on."""
    twin = {"first": "second", "second": "first", "hole": "second_hole", "second_hole": "hole"}

    def other(table):
        return {twin.get(name, name): value for name, value in table.items()}

    def swap(part):
        if isinstance(part.get("shape"), dict) and "lever" in part["shape"]:
            return part | {"shape": {"lever": part["shape"]["lever"][::-1]}}
        if set(part.get("interfaces", {})) != {"first", "second"}:
            return part
        screws = [
            one | {"at": twin[one["at"]], "opens": pair(one["opens"], lambda x, y: (-x, -y))}
            for one in part.get("bolts", ())
        ]
        part = {k: other(v) if isinstance(v, dict) else v for k, v in part.items()}
        part |= {"bolts": screws} if screws else {}
        return other(part) if "second_hole" in part else part

    return data | {"parts": {name: swap(part) for name, part in data["parts"].items()}}


def numbers(result, names=None):
    """Value, bars, limit and required safety of each check by part, kind, quantity and place in it.

    names  new name -> old name, of parts and bodies that were renamed
    """
    found = {}
    for check in result.checks:
        own = (names or {}).get(check.part, check.part)
        words = [(names or {}).get(word, word) for word in check.quantity.split()]
        key = (own, check.kind, " ".join(words))
        row = (check.value, check.numerical, check.model, check.below, check.limit)
        found.setdefault(key, []).append(row)
    return {key: sorted(rows) for key, rows in found.items()}


def each_quantity(data, change):
    """The data with `change(numbers, unit)` instead of every text that is a quantity.

    change  of one or two numbers and a unit in `UNITS` or "", to the same
    """
    if isinstance(data, dict):
        return {name: each_quantity(value, change) for name, value in data.items()}
    if isinstance(data, list):
        return [each_quantity(value, change) for value in data]
    match = _QUANTITY.fullmatch(data) if isinstance(data, str) else None
    if match is None:
        return data
    between = match[2] or ", "
    values, unit = change([float(n) for n in match[1].split(between)], match[3] or "")
    return (between.join(repr(value) for value in values) + f" {unit}").strip()


def in_other_units(data, chosen=lambda count: True):
    """Inches, pounds and turns for millimetres, kilograms and radians.

    chosen  of the how-manyth quantity: whether it changes
    """
    count = 0

    def change(values, unit):
        nonlocal count
        count += 1
        if unit not in UNITS or not chosen(count):
            return values, unit
        _, other, factor = UNITS[unit]
        return [value / factor for value in values], other

    return each_quantity(data, change)


def with_arcs(data):
    """The machine with stated arcs: how loose a pin is depends on size and load."""
    parts = {
        name: part if part.keys() & {"joint", "fits", "like"} else {"bearing_arc": "90 deg"} | part
        for name, part in data["parts"].items()
    }
    return data | {"parts": parts}


def of_any_size(data, machine):
    """The machine of materials and fits that stay in every size as in that of its parts."""
    parts = read_design(DESIGNS / f"{machine}.toml").parts
    materials, named = dict(data.get("materials", {})), {}
    for name, part in data["parts"].items():
        own = parts[name].material
        materials[f"{name}_steel"] = {
            "youngs_modulus": f"{own.youngs_modulus!r} MPa",
            "poisson_ratio": own.poisson_ratio,
            "density": f"{own.density * 1e12!r} kg/m3",
            "yield_stress": f"{own.yield_stress!r} MPa",
            "ultimate_stress": f"{own.ultimate_stress!r} MPa",
            **(
                {
                    "endurance_ratio": own.endurance_ratio,
                    "endurance_cycles": own.endurance_cycles,
                }
                if own.endurance_ratio
                else {}
            ),
        }
        fits = {
            bore: f"{least!r} .. {most!r} mm"
            for bore, (least, most) in parts[name].clearances.items()
            if bore in part.get("fits", {})
        }
        named[name] = part | {"material": f"{name}_steel"} | ({"fits": fits} if fits else {})
    return data | {"materials": materials, "parts": named}


def scaled(data, factor):
    """All lengths times a factor, at the same densities, stresses and angles of the crank."""

    def change(values, unit):
        power = UNITS[unit][0] if unit else 0
        return [value * factor**power for value in values], unit

    return each_quantity(data, change)


def pair(text, change, unit=""):
    """Two numbers and a unit in a text, changed."""
    match = _QUANTITY.fullmatch(text)
    x, y = change(*(float(n) for n in match[1].split(",")))
    return f"{x!r}, {y!r} {match[3] or unit}".strip()


def placed(data, point, vector, angle, axis):
    """The machine elsewhere: changes of points, of vectors (x, y), and of an angle in degrees.

    axis  of the name and value, mm, of a coordinate such as D.y, to the same
    """

    def law(coordinate, text):
        value, unit = text.split(" ")
        if unit == "deg":
            return coordinate, f"{angle(float(value))!r} deg"
        coordinate, value = axis(coordinate, float(value))
        return coordinate, f"{value!r} mm"

    def force_law(entry):
        if not isinstance(entry, dict) or "touches" not in entry:
            return entry
        touches, at = law(entry["touches"], entry["at"])
        return entry | {"touches": touches, "at": at}

    def cycle_of(entry):
        swept = entry["coordinate"]
        new = entry | {"coordinate": law(swept, entry["start"])[0]}
        new["start"] = law(swept, entry["start"])[1]
        new.pop("shown", None)
        new["phases"] = [
            phase
            | {
                "to": law(swept, phase["to"])[1],
                "forces": {name: force_law(each) for name, each in phase["forces"].items()},
            }
            for phase in entry["phases"]
        ]
        return new

    def with_vector(entry, key):
        return entry | {key: pair(entry[key], vector)} if key in entry else entry

    return data | {
        "points": {name: pair(text, point) for name, text in data["points"].items()},
        "gravity": pair(data["gravity"], vector),
        "bodies": {
            name: body | {"guide": with_vector(body["guide"], "along")} if "guide" in body else body
            for name, body in data["bodies"].items()
        },
        "forces": {name: with_vector(entry, "direction") for name, entry in data["forces"].items()},
        "cycles": {name: cycle_of(entry) for name, entry in data["cycles"].items()},
    }


def turned(data, degrees):
    """The machine turned ccw, with its weight; one led by x or y by 90 degrees only."""
    c, s = cos(radians(degrees)), sin(radians(degrees))

    def turn(x, y):
        return c * x - s * y, s * x + c * y

    def axis(name, value):
        assert degrees == 90, f"{name} is no coordinate of the turned machine"
        body, along = name.split(".")
        return (f"{body}.y", value) if along == "x" else (f"{body}.x", -value)

    return placed(data, turn, turn, lambda angle: angle + degrees, axis)


def moved(data, x, y):
    """The machine elsewhere, by x and y in mm."""

    def axis(name, value):
        return name, value + (x if name.endswith(".x") else y)

    return placed(data, lambda px, py: (px + x, py + y), lambda *v: v, lambda angle: angle, axis)


def mirrored(data):
    """The machine seen in a mirror along the x axis; no torque is given in any of them."""

    def mirror(x, y):
        return x, -y

    def axis(name, value):
        return name, -value if name.endswith(".y") else value

    new = placed(data, mirror, mirror, lambda angle: -angle, axis)
    for table, key in (("bodies", "centre"), ("joints", "along")):
        new[table] = {
            name: entry | {key: pair(entry[key], mirror)} if ", " in entry.get(key, "") else entry
            for name, entry in new.get(table, {}).items()
        }
    return new


def renamed(data):
    """Every body, point, joint, force, cycle and part by another name, and which was which."""
    kinds = ("bodies", "points", "joints", "forces", "cycles", "parts")
    old = sorted({name for kind in kinds for name in data.get(kind, {})})
    names = {name: f"n{len(old) - k:02d}" for k, name in enumerate(old)}  # sorted the other way

    def word(text):
        first, dot, rest = text.partition(".")
        return names.get(first, first) + dot + rest if first in names else text

    def change(entry, table=""):
        if isinstance(entry, dict):
            return {
                word(name) if table in (*kinds, "friction") else name: (
                    value if name in ("kind", "shape") else change(value, name)
                )
                for name, value in entry.items()
            }
        if isinstance(entry, list):
            return [change(each) for each in entry]
        return word(entry) if isinstance(entry, str) else entry

    return change(data), {new: name for name, new in names.items()}


def with_cycles(data, change):
    """The data with every cycle changed."""
    return data | {"cycles": {name: change(entry) for name, entry in data["cycles"].items()}}


def a_turn_later(data):
    """Led by the crank from 360 degrees on."""
    return placed(data, lambda *p: p, lambda *v: v, lambda angle: angle + 360.0, None)


def backwards(data):
    """From the end of its one phase to its start."""

    def change(cycle):
        (phase,) = cycle["phases"]
        return cycle | {"start": phase["to"], "phases": [phase | {"to": cycle["start"]}]}

    return with_cycles(data, change)


def three_times_loaded(data):
    """Three times the forces and weights, and speeds with three times the inertia forces."""

    def change(values, unit):
        grows = {"N": 3.0, "kN": 3.0, "m/s2": 3.0, "rad/s": 3**0.5, "rpm": 3**0.5, "m/s": 3**0.5}
        return [value * grows.get(unit, 1.0) for value in values], unit

    return each_quantity(data, change)
