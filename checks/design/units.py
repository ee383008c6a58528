"""Units at the door: text such as "6.3 mm" becomes a number in N, mm, s and tonne, once.

Inside ballesta every number is in N, mm, s, tonne, hence MPa, N mm and tonne mm2; angles are rad.
The types at the end (`Length`, `Force`, ...) do the conversion in the models of the design file
and describe themselves in its JSON schema.
"""

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import ge, gt, le, lt
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import core_schema

from checks.design.errors import nearest
from checks.result.words import brief

if TYPE_CHECKING:
    import pint

Pair = tuple[float, float]


@dataclass(frozen=True)
class Dimension:
    """A kind of quantity: its name in a sentence, ballesta's unit, and an example to copy."""

    title: str
    unit: str
    example: str


DIMENSIONS = {
    "length": Dimension("a length", "mm", "6.3 mm"),
    "force": Dimension("a force", "N", "11 kN"),
    "mass": Dimension("a mass", "t", "10 kg"),
    "inertia": Dimension("a moment of inertia", "t mm2", "0.02 kg m2"),
    "stress": Dimension("a stress", "MPa", "140 MPa"),
    "density": Dimension("a density", "t/mm3", "7850 kg/m3"),
    "speed": Dimension("a speed", "mm/s", "0.1 m/s"),
    "angular speed": Dimension("an angular speed", "rad/s", "30 deg/s"),
    "acceleration": Dimension("an acceleration", "mm/s2", "9.81 m/s2"),
    "angle": Dimension("an angle", "rad", "120 deg"),
    "power": Dimension("a power", "N mm/s", "5.5 kW"),
    "rate": Dimension("a rate", "1/s", "20 1/min"),
    "fraction": Dimension("a share", "", "5 %"),
    "time": Dimension("a time", "s", "1.5 s"),
    "flow": Dimension("a volume in time", "mm3/s", "40 l/min"),
    "moment": Dimension("a moment", "N mm", "12 N m"),
    "turning stiffness": Dimension("a stiffness against turning", "N mm/rad", "20 kN m/rad"),
    "stiffness": Dimension("a stiffness", "N/mm", "80 kN/mm"),
    "damping": Dimension("a damping", "N s/mm", "0.2 N s/mm"),
    "turning damping": Dimension("a damping against turning", "N mm s/rad", "0.5 N m s/rad"),
    "pressure speed": Dimension("a pressure times a speed", "MPa mm/s", "0.5 MPa m/s"),
    "bending stiffness": Dimension("a bending stiffness E I", "N mm2", "2787 N m2"),
    "angular acceleration": Dimension("an angular acceleration", "rad/s2", "2 rad/s2"),
    "stress intensity": Dimension("a stress intensity", "MPa mm^0.5", "6.5 MPa m^0.5"),
    "roughness": Dimension("a roughness Rz", "mm", "25 um"),
}
# examples of pairs, by their dimension; "" is a direction
PAIRS = {"length": "200, 150 mm", "acceleration": "0, -9.81 m/s2", "": "0, 1"}
# only to name what was found where another dimension was expected
_OTHER_TITLES = {
    "mm2": "an area", "mm3": "a volume", "K": "a temperature",
}  # fmt: skip
_COMMON_UNITS = [
    *("mm", "cm", "m", "um", "inch", "N", "kN", "MN", "g", "kg", "t", "tonne", "Pa", "MPa", "GPa"),
    *("s", "ms", "min", "h", "Hz", "rad", "deg", "%"),
]
_SEVERAL = {  # names of units of several sizes
    "ton": "is 1000 kg to some, 907 or 1016 kg to others: write t, or kg",
    "gallon": "is 3.785 l to some, 4.546 l to others: write l",
}
_SEVERAL |= {"tons": _SEVERAL["ton"], "gal": _SEVERAL["gallon"], "gallons": _SEVERAL["gallon"]}
_FITS = {  # by whether what is in the bore is pressed in
    False: '"H7/f7", or a clearance on diameter such as "0.02 .. 0.06 mm"',
    True: '"H7/p6", or an interference on diameter such as "0.02 .. 0.05 mm"',
}
MOST = 1e20  # N, mm, s, ...: what is larger than any machine's; its powers are finite numbers
_MOST_STIFFNESS = 1e30  # N mm2: E I grows with the fourth power of a length
_MOST_OF = {"length": 1e9, "bending stiffness": _MOST_STIFFNESS}  # mm (1000 km), N mm2
_NO_MACHINE = "which is not finite or beyond any machine"
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*")
_FACTOR = re.compile(
    r"\s*([*·/]?)\s*(1(?=\s*/)|[A-Za-zµμ°%]+)(?:\s*(?:\^|\*\*)\s*(-?\d+\.5)|\s*(?:\^|\*\*)?\s*(-?\d+)|([²³]))?"
)


@dataclass(frozen=True)
class Unit:
    """One of a unit: its size in pint's root units, and their powers."""

    size: float
    powers: Mapping[str, float]

    def __mul__(self, other: "Unit") -> "Unit":
        # in one order: numbers are multiplied in it
        names = sorted(self.powers.keys() | other.powers.keys())
        powers = {name: self.powers.get(name, 0) + other.powers.get(name, 0) for name in names}
        return Unit(self.size * other.size, {name: p for name, p in powers.items() if p})

    def __pow__(self, power: float) -> "Unit":
        return Unit(self.size**power, {name: p * power for name, p in self.powers.items()})


_LENGTH, _TIME, _ANGLE = {"meter": 1}, {"second": 1}, {"radian": 1}
_FORCE = {"gram": 1, "meter": 1, "second": -2}
_PRESSURE = {"gram": 1, "meter": -1, "second": -2}
# The units that nearly all designs are written in: pint, which knows all others, takes half a
# second to load.
KNOWN_UNITS = {
    **{name: Unit(size, _LENGTH) for name, size in (("mm", 1e-3), ("cm", 1e-2), ("m", 1.0),
                                                    ("um", 1e-6), ("km", 1e3))},
    **{name: Unit(size, _FORCE) for name, size in (("N", 1e3), ("kN", 1e6), ("MN", 1e9))},
    **{name: Unit(size, {"gram": 1}) for name, size in (("g", 1.0), ("kg", 1e3), ("t", 1e6),
                                                        ("tonne", 1e6))},
    **{name: Unit(size, _PRESSURE) for name, size in (("Pa", 1e3), ("kPa", 1e6), ("MPa", 1e9),
                                                      ("GPa", 1e12), ("bar", 1e8))},
    **{name: Unit(size, _TIME) for name, size in (("s", 1.0), ("ms", 1e-3), ("min", 60.0),
                                                  ("h", 3600.0))},
    **{name: Unit(size, _ANGLE) for name, size in (("rad", 1.0), ("deg", math.pi / 180))},
    **{name: Unit(size, {"gram": 1, "meter": 2, "second": -3}) for name, size in (("W", 1e3),
                                                                                  ("kW", 1e6))},
    "J": Unit(1e3, {"gram": 1, "meter": 2, "second": -2}),
    "rpm": Unit(2.0 * math.pi / 60.0, {"radian": 1, "second": -1}),
    "inch": Unit(0.0254, _LENGTH),
    "Hz": Unit(1.0, {"second": -1}),
    "percent": Unit(0.01, {}),
}  # fmt: skip


@lru_cache(maxsize=1)
def _registry() -> "pint.UnitRegistry[float]":
    import pint

    return pint.UnitRegistry()


def pint_unit(name: str) -> Unit:
    """Return one of a unit that pint knows; raises ValueError for any other."""
    import pint

    registry = _registry()
    try:
        root = registry.Quantity(1.0, registry.parse_units(name)).to_root_units()
    except pint.UndefinedUnitError as error:
        raise ValueError(str(error)) from error
    powers: dict[str, Any] = dict(sorted(root.unit_items()))
    return Unit(float(root.magnitude), powers)


@lru_cache(maxsize=1024)
def _unit(text: str) -> Unit:
    """Return one of the unit in root units; raises ValueError in the user's words."""
    result = Unit(1.0, {})
    position = 0
    while position < len(text):
        factor = _FACTOR.match(text, position)
        if factor is None:
            raise ValueError(f'unit "{text}" is not understood, write it such as kg m2 or 1/min')
        operator, name, root, digits, superscript = factor.groups()
        position = factor.end()
        if name == "1":
            continue
        name = {"°": "deg", "%": "percent"}.get(name, name)
        if name in _SEVERAL:
            raise ValueError(f'unit "{name}" {_SEVERAL[name]}')
        try:
            unit = KNOWN_UNITS.get(name) or pint_unit(name)
        except ValueError:
            guess = nearest(name, _COMMON_UNITS)
            hint = f", did you mean {guess}?" if guess else ""
            raise ValueError(f'unit "{name}" is unknown{hint}') from None
        power = float(root) if root else int(digits or {"²": 2, "³": 3, None: 1}[superscript])
        result = result * unit ** (-power if operator == "/" else power)
    return result


Powers = Mapping[str, float]
PLAIN: Powers = {}
ANGLE: Powers = _ANGLE
_COHERENT = {"gram": 1e-6, "meter": 1e3, "second": 1.0, "radian": 1.0}  # t, mm, s, rad


def powers_of(unit: str) -> Powers:
    """Return the powers of pint's root units that a unit has."""
    return _unit(unit).powers


def title_of(powers: Powers) -> str:
    """Return a dimension in a sentence, such as "a force"."""
    return _title(Unit(1.0, powers)) if powers else "a plain number"


@dataclass(frozen=True)
class Constant:
    """A number of any mechanical unit in N, mm, s, t and rad; `text` is what was written."""

    text: str
    value: float
    powers: Powers


def measure_any(value: object) -> Constant:
    """Convert text of any mechanical unit, or a plain number.

    >>> measure_any("2 kN/m")
    Constant(text='2 kN/m', value=2.0, powers={'gram': 1, 'second': -2})
    """
    must_be = f'must be a number or a quantity such as "400 N", got {_shown(value)}'
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        number, unit = float(value) if abs(value) <= MOST else math.inf, Unit(1.0, PLAIN)
    else:
        match = _QUANTITY.fullmatch(value) if isinstance(value, str) else None
        if match is None:
            raise ValueError(must_be)
        try:
            number, unit = float(match[1]), _unit(match[2])
        except ValueError as error:
            raise ValueError(f"{must_be}: {error}") from None
    if not unit.powers.keys() <= _COHERENT.keys():
        raise ValueError(f"{must_be}, which is {_title(unit)}")
    number *= unit.size
    for name, power in unit.powers.items():
        number *= _COHERENT[name] ** power
    if not abs(number) <= _MOST_STIFFNESS:
        raise ValueError(f"{must_be}, {_NO_MACHINE}")
    return Constant(str(value), number, unit.powers)


def _title(found: Unit) -> str:
    for dimension in DIMENSIONS.values():
        if _unit(dimension.unit).powers == found.powers:
            return dimension.title
    for unit, title in _OTHER_TITLES.items():
        if _unit(unit).powers == found.powers:
            return title
    from pint.util import UnitsContainer

    return f"in {_registry().Unit(UnitsContainer(found.powers)):~}"


def _shown(value: object) -> str:
    return f'"{brief(value, 100)}"' if isinstance(value, str) else brief(value, 100)


@dataclass(frozen=True)
class Measured:
    """A converted number that still knows which of the accepted dimensions it has."""

    value: float
    dimension: str


def measure(value: object, *accepted: str) -> Measured:
    """Convert text to ballesta's units; it may have any of the accepted dimensions.

    >>> measure("0.1 m/s", "speed")
    Measured(value=100.0, dimension='speed')
    """
    expected = " or ".join(
        f'{DIMENSIONS[name].title} such as "{DIMENSIONS[name].example}"' for name in accepted
    )
    must_be = f"must be {expected}, got {_shown(value)}"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if not abs(value) <= MOST:  # of whole numbers, too, that no float can hold
            raise ValueError(f"{must_be}, {_NO_MACHINE}")
        if accepted == ("fraction",):
            return Measured(float(value), "fraction")
        raise ValueError(f"{must_be} without a unit")
    match = _QUANTITY.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        raise ValueError(must_be)
    number, unit_text = float(match[1]), match[2]
    if unit_text.startswith(","):
        raise ValueError(f"{must_be}; decimals are written with a point, and one value is needed")
    if not unit_text and "fraction" not in accepted:
        raise ValueError(f"{must_be} without a unit")
    try:
        unit = _unit(unit_text)
    except ValueError as error:
        raise ValueError(f"{must_be}: {error}") from None
    for name in accepted:
        own = _unit(DIMENSIONS[name].unit)
        if own.powers == unit.powers:
            converted = number * (unit.size / own.size)
            most = _MOST_OF.get(name, MOST)
            if not abs(converted) <= most:
                beyond = f"at most {most:g} {DIMENSIONS[name].unit} is taken"
                raise ValueError(f"{must_be}, {_NO_MACHINE}; {beyond}")
            return Measured(converted, name)
    raise ValueError(f"{must_be}, which is {_title(unit)}")


def measure_each(texts: Sequence[str], dimension: str) -> list[float]:
    """Convert several texts; the unit of the last one serves those before it that have none.

    >>> measure_each(["200", "1 m"], "length")
    [200000.0, 1000.0]
    """
    last = _QUANTITY.fullmatch(texts[-1])
    unit = f" {last[2]}" if last is not None else ""
    bare = (re.fullmatch(rf"\s*{_NUMBER}\s*", text) for text in texts)
    whole = (f"{text}{unit}" if alone else text for text, alone in zip(texts, bare, strict=True))
    return [measure(text.strip(), dimension).value for text in whole]


def measure_pair(value: object, dimension: str) -> Pair:
    """Convert text such as "200, 150 mm" to two numbers in ballesta's units."""
    unit = DIMENSIONS[dimension].unit if dimension else ""
    example = PAIRS[dimension]
    what = f"two numbers with a unit, such as {example!r}" if unit else f"such as {example!r}"
    must_be = f"must be {what}, got {_shown(value)}".replace("'", '"')
    parts = value.split(",") if isinstance(value, str) else []
    if len(parts) != 2:
        hint = "; decimals are written with a point" if len(parts) > 2 else ""
        raise ValueError(must_be + hint)
    if not dimension:
        numbers = [_QUANTITY.fullmatch(part) for part in parts]
        if any(number is None or number[2] for number in numbers):
            raise ValueError(f"{must_be}; a direction has no unit")
        x, y = (float(part) for part in parts)
        if not (math.isfinite(x) and math.isfinite(y)) or math.hypot(x, y) == 0.0:
            raise ValueError(f"{must_be}, which is no direction")
        return x / math.hypot(x, y), y / math.hypot(x, y)
    try:
        x, y = measure_each(parts, dimension)
    except ValueError as error:
        raise ValueError(f"{must_be}: {error}") from None
    return x, y


class Marker(ABC):
    """Marks a text of a pydantic model, which it reads."""

    @abstractmethod
    def read(self, value: object) -> object:
        """Return what the text says, or raise ValueError."""

    @abstractmethod
    def json_schema(self) -> dict[str, Any]:
        """Schema of the text, for editors."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return self.json_schema()


@dataclass(frozen=True)
class Quantity(Marker):
    """Marks a number of a pydantic model as a quantity of one of the dimensions, within bounds.

    The bounds are in ballesta's units and are shown with them. `if_negative` is said, too, of a
    number below 0 where that is out of bounds.
    """

    dimensions: tuple[str, ...]
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    keep_dimension: bool = False
    if_negative: str = ""

    def read(self, value: object) -> float | Measured:
        """Return the number in ballesta's units, or raise ValueError."""
        measured = measure(value, *self.dimensions)
        number = measured.value
        for word, bound, breaks in self._bounds():
            if breaks(number, bound):
                limit = _limit(bound, measured.dimension)
                hint = f"; {self.if_negative}" if self.if_negative and number < 0.0 else ""
                raise ValueError(f"must be {word} {limit}, got {_shown(value)}{hint}")
        return measured if self.keep_dimension else measured.value

    def bounds(self) -> list[str]:
        """The bounds in words, such as "above 0 mm", in units of the first dimension."""
        return [f"{word} {_limit(bound, self.dimensions[0])}" for word, bound, _ in self._bounds()]

    def _bounds(self) -> Iterator[tuple[str, float, Callable[[float, float], bool]]]:
        """Word, bound and the comparison that breaks it."""
        for word, bound, breaks in (
            ("above", self.above, le),
            ("at least", self.at_least, lt),
            ("below", self.below, ge),
            ("at most", self.at_most, gt),
        ):
            if bound is not None:
                yield word, bound, breaks

    def json_schema(self) -> dict[str, Any]:
        """Schema of the text, for editors."""
        kinds = [DIMENSIONS[name] for name in self.dimensions]
        if self.dimensions == ("fraction",):
            return {
                "anyOf": [{"type": "string", "pattern": rf"^\s*{_NUMBER}\s*%?\s*$"},
                          {"type": "number"}],
                "examples": ["5 %"],
            }  # fmt: skip
        return {
            "type": "string",
            "pattern": rf"^\s*{_NUMBER}\s*[A-Za-zµμ°1][^,]*$",
            "examples": [kind.example for kind in kinds],
        }


@dataclass(frozen=True)
class FitOrClearance(Marker):
    """Marks a fit of pin and bore: an ISO code (text, as it stands) or its clearances, mm.

    pressed  True for the interferences of what is pressed in, above 0
    """

    pressed: bool = False

    def read(self, value: object) -> str | Pair:
        """Return a code such as "H7/f7" or least and largest clearance, or raise ValueError."""
        wanted = f"must be a fit such as {_FITS[self.pressed]}, got {_shown(value)}"
        if not isinstance(value, str):
            raise ValueError(wanted)
        if "/" in value:
            return value.strip()
        ends = value.split("..") if ".." in value else [value, value]
        try:
            least, largest = measure_each(ends, "length")
        except ValueError:
            raise ValueError(wanted) from None
        if not 0.0 <= least <= largest or (self.pressed and not least):
            kind = "an interference above" if self.pressed else "a clearance of at least"
            raise ValueError(
                f"must be {kind} 0 mm, the smaller end first, such as "
                f'"0.02 .. 0.06 mm", got {_shown(value)}'
            )
        return least, largest

    def json_schema(self) -> dict[str, Any]:
        """Schema of the text, for editors."""
        code = "H7/p6" if self.pressed else "H7/f7"
        return {"type": "string", "examples": [code, "0.02 .. 0.06 mm"]}


class AnyQuantity(Marker):
    """Marks a number of any mechanical unit, or a plain one."""

    def read(self, value: object) -> Constant:
        """Return the number in ballesta's units, or raise ValueError."""
        return measure_any(value)

    def json_schema(self) -> dict[str, Any]:
        """Schema of the text, for editors."""
        text = {"type": "string", "pattern": rf"^\s*{_NUMBER}\s*[A-Za-zµμ°1][^,]*$"}
        return {"anyOf": [text, {"type": "number"}], "examples": ["400 N"]}


def _limit(bound: float, dimension: str) -> str:
    if dimension == "angle":
        return f"{math.degrees(bound):g} deg"
    if dimension == "fraction":
        return f"{100 * bound:g} %"
    own = DIMENSIONS[dimension]
    if bound == 0.0:  # zero needs no conversion to the unit that people write
        return f"0 {own.example.partition(' ')[2]}"
    return f"{bound:g} {own.unit}"


@dataclass(frozen=True)
class Vector(Marker):
    """Marks a pair of a pydantic model as a vector of one dimension; "" is a unit direction."""

    dimension: str

    def read(self, value: object) -> Pair:
        """Return the pair in ballesta's units, or raise ValueError."""
        return measure_pair(value, self.dimension)

    def json_schema(self) -> dict[str, Any]:
        """Schema of the text, for editors."""
        unit = r"\s*[A-Za-zµμ°].*" if self.dimension else r"\s*"
        return {
            "type": "string",
            "pattern": rf"^\s*{_NUMBER}[^,]*,\s*{_NUMBER}{unit}$",
            "examples": [PAIRS[self.dimension]],
        }


Length = Annotated[float, Quantity(("length",))]
PositiveLength = Annotated[float, Quantity(("length",), above=0.0)]
OffsetLength = Annotated[float, Quantity(("length",), at_least=0.0)]
# the skin left by rolling, forging or casting is the roughest that the FKM guideline knows
Roughness = Annotated[float, Quantity(("roughness",), above=0.0, at_most=0.2 * (1 + 1e-9))]
Force = Annotated[float, Quantity(("force",))]
PositiveForce = Annotated[float, Quantity(("force",), above=0.0)]
ForceFromZero = Annotated[float, Quantity(("force",), at_least=0.0)]
Mass = Annotated[float, Quantity(("mass",), at_least=0.0)]
PositiveMass = Annotated[float, Quantity(("mass",), above=0.0)]
Inertia = Annotated[float, Quantity(("inertia",), at_least=0.0)]
Stress = Annotated[float, Quantity(("stress",))]
PositiveStress = Annotated[float, Quantity(("stress",), above=0.0)]
PositiveStressIntensity = Annotated[float, Quantity(("stress intensity",), above=0.0)]
Density = Annotated[float, Quantity(("density",))]
Speed = Annotated[float, Quantity(("speed",))]
Angle = Annotated[float, Quantity(("angle",))]
BearingArc = Annotated[float, Quantity(("angle",), above=math.radians(30 - 1e-9), at_most=math.pi)]
Rate = Annotated[float, Quantity(("rate",), above=0.0)]
StatedFit = Annotated[str | Pair, FitOrClearance()]
PressedFit = Annotated[str | Pair, FitOrClearance(pressed=True)]
Fraction = Annotated[float, Quantity(("fraction",), above=0.0, below=1.0)]
# where the normal distribution of endurance limits is meant (fatigue.marin.reliability_factor)
Survival = Annotated[float, Quantity(("fraction",), at_least=0.5, at_most=0.999999)]
LengthOrAngle = Annotated[Measured, Quantity(("length", "angle"), keep_dimension=True)]
SweepSpeed = Annotated[
    Measured,
    Quantity(
        ("speed", "angular speed"),
        above=0.0,
        keep_dimension=True,
        if_negative="the direction comes from `to` of each phase",
    ),
]
SweepAcceleration = Annotated[
    Measured, Quantity(("acceleration", "angular acceleration"), keep_dimension=True)
]
PositivePressureSpeed = Annotated[float, Quantity(("pressure speed",), above=0.0)]
PositivePower = Annotated[float, Quantity(("power",), above=0.0)]
PositiveAngularSpeed = Annotated[float, Quantity(("angular speed",), above=0.0)]
PositiveMoment = Annotated[float, Quantity(("moment",), above=0.0)]
TimeFromZero = Annotated[float, Quantity(("time",), at_least=0.0)]
PositiveFlow = Annotated[float, Quantity(("flow",), above=0.0)]
PositiveTime = Annotated[float, Quantity(("time",), above=0.0)]
PositiveStiffness = Annotated[float, Quantity(("stiffness",), above=0.0)]
PositiveTurning = Annotated[float, Quantity(("turning stiffness",), above=0.0)]
PositiveBending = Annotated[float, Quantity(("bending stiffness",), above=0.0)]
ForceOrMoment = Annotated[Measured, Quantity(("force", "moment"), keep_dimension=True)]
PositiveDamping = Annotated[
    Measured, Quantity(("damping", "turning damping"), above=0.0, keep_dimension=True)
]
ForceOrMomentFromZero = Annotated[
    Measured, Quantity(("force", "moment"), at_least=0.0, keep_dimension=True)
]
SpeedFromZero = Annotated[
    Measured, Quantity(("speed", "angular speed"), at_least=0.0, keep_dimension=True)
]
PositiveForceOrMoment = Annotated[
    Measured, Quantity(("force", "moment"), above=0.0, keep_dimension=True)
]
AnyConstant = Annotated[Constant, AnyQuantity()]
Point2 = Annotated[Pair, Vector("length")]
Acceleration2 = Annotated[Pair, Vector("acceleration")]
Direction2 = Annotated[Pair, Vector("")]

BY_DIMENSION: dict[str, Any] = {
    "length": Length,
    "angle": Angle,
    "force": Force,
    "mass": Mass,
    "number": Annotated[float, Field(strict=True, allow_inf_nan=False)],
    "count": Annotated[int, Field(strict=True)],
}
