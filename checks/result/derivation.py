"""Derivation of a check's number: given values, formulas, and their results.

A derivation holds no result that could drift away from its formulas: every value but the given ones
is evaluated from the text that is shown (`checks.result.formulas`). A number that no formula gives,
such as an eigenvalue of thousands of unknowns, is a given one whose source says so.

For result.json derivations become plain data and come back: givens, formulas, and their values.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, Self, get_args, get_origin

import numpy as np

from checks.result.formulas import COMPONENTS, FormulaError, Scope, Value, evaluate, functions_of
from checks.result.plain_data import plain_fields
from checks.result.words import brief

if TYPE_CHECKING:
    from checks.result.verdict import Check

BARS = "Error bars"  # the title of their section, in every derivation
_DOUBTED = "the check under loads that are not known for certain"


@dataclass(frozen=True)
class Given:
    """A number, or the components of a vector, that is put in.

    source  where it comes from: the design, the loads, a solver, a table
    main    True if it stands in the short telling, too
    """

    symbol: str
    meaning: str
    value: float | tuple[float, ...]
    unit: str = ""
    source: str = ""
    main: bool = False


@dataclass(frozen=True)
class Step:
    """A formula over the symbols before it (`formulas`), and the meaning of its value."""

    symbol: str
    meaning: str
    formula: str
    unit: str = ""
    source: str = ""
    main: bool = False


@dataclass(frozen=True)
class Column:
    """A symbol with a value in every row of a sum."""

    symbol: str
    meaning: str
    unit: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Sum:
    """A formula summed over the rows of a table.

    names    of the rows
    columns  of numbers, each with as many values as there are names
    """

    symbol: str
    meaning: str
    formula: str
    names: tuple[str, ...]
    columns: tuple[Column, ...]
    unit: str = ""
    source: str = ""
    main: bool = False

    def __post_init__(self) -> None:
        for column in self.columns:
            if len(column.values) != len(self.names):
                raise ValueError(
                    f"the sum {self.symbol} has {len(self.names)} rows, but {column.symbol} "
                    f"{len(column.values)} values"
                )

    def scopes(self, scope: Scope) -> Iterator[dict[str, Value]]:
        """Yield the values of all symbols, row by row."""
        for row in range(len(self.names)):
            yield dict(scope) | {column.symbol: column.values[row] for column in self.columns}


@dataclass(frozen=True)
class UnitLoad:
    """Contribution of a unit load to the stress at a point.

    name    of the load, with where it acts
    unit    of its coefficient
    value   the coefficient at the position
    stress  (6,) MPa per unit: xx, yy, zz, xy, yz, zx
    """

    name: str
    unit: str
    value: float
    stress: tuple[float, ...]

    @property
    def contribution(self) -> tuple[float, ...]:
        """Its contribution to the stress, (6,) MPa."""
        return tuple(self.value * one for one in self.stress)


@dataclass(frozen=True)
class Superposition:
    """The stress at a point at a position: the sum of coefficient times unit stress.

    symbol    of the stress, a vector of six components
    position  cycle and position, in words
    """

    symbol: str
    meaning: str
    position: str
    loads: tuple[UnitLoad, ...]
    source: str = ""
    unit: str = "MPa"
    main: bool = True

    @property
    def stress(self) -> tuple[float, ...]:
        """The sum (6,), MPa."""
        total = np.zeros(len(COMPONENTS))
        for load in self.loads:
            total += load.contribution
        return tuple(float(one) for one in total)


Item = Given | Step | Sum | Superposition


@dataclass(frozen=True)
class Section:
    """Items under a title; what follows may use their symbols."""

    title: str
    items: tuple[Item, ...]


@dataclass(frozen=True)
class Acting:
    """Force and moment at an interface of a part: N and N mm, in the part's axes.

    on       the point of the machine that the interface is
    wrench   (6,) F_x, F_y, F_z, M_x, M_y, M_z at the interface's centre
    """

    interface: str
    on: str
    wrench: tuple[float, ...]

    @property
    def force(self) -> float:
        """Size of the force in the plane, N."""
        return float(np.hypot(self.wrench[0], self.wrench[1]))


@dataclass(frozen=True)
class LoadCase:
    """A position of a cycle, and the loads on the part there.

    symbol         the stress at this position, "" for none
    position       as shown to people
    index          of the position in its cycle, from 0
    accelerations  (4,) a_x, a_y less gravity, mm/s2; alpha and omega squared, rad/s2, 1/s2
    """

    symbol: str
    cycle: str
    position: str
    index: int
    acting: tuple[Acting, ...]
    accelerations: tuple[float, ...] = ()


@dataclass(frozen=True)
class HandComparison:
    """A number by hand beside the model's."""

    quantity: str
    hand: float
    model: float
    unit: str
    formula: str


@dataclass(frozen=True)
class BarSymbols:
    """Symbols of the error bars, "" where nothing adds to one, and what each is made of, in words.

    The symbols are of items of the section of the error bars.

    name  of the model's own band, apart from other doubts; "" if `words` name it
    """

    numerical: str = ""
    above: str = ""
    below: str = ""
    words: str = ""
    name: str = ""


@dataclass(frozen=True)
class Derivation:
    """Derivation of the value and the limit of a check.

    cases      positions and forces that it holds for
    sections   items in an order in which each uses only what stands before
    value      symbol of the check's value
    limit      symbol of its limit
    bars       of its error bars
    unproved   why the value is no formula's, in words; "" for one that is
    equal      pairs of symbols whose values must agree, as a root that was sought proves
    compared   hand checks beside it
    notes      what a reader must know to follow
    """

    cases: tuple[LoadCase, ...]
    sections: tuple[Section, ...]
    value: str
    limit: str
    bars: BarSymbols = field(default_factory=BarSymbols)
    unproved: str = ""
    equal: tuple[tuple[str, str], ...] = ()
    compared: tuple[HandComparison, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def items(self) -> list[Item]:
        """All items in their order."""
        return [item for section in self.sections for item in section.items]

    @cached_property
    def values(self) -> Mapping[str, Value]:
        """Every symbol's value, evaluated in order; raises FormulaError."""
        scope: dict[str, Value] = {}
        for item in self.items:
            if item.symbol in scope:
                raise FormulaError(f"the symbol {item.symbol!r} is given twice")
            scope[item.symbol] = value_of(item, scope)
        return scope

    def number(self, symbol: str) -> float:
        """Value of a symbol that is a number; raises FormulaError."""
        value = self.values.get(symbol)
        if not isinstance(value, float):
            raise FormulaError(f"no number is named {symbol!r}")
        return value

    def with_items(self, title: str, items: Sequence[Item]) -> Self:
        """Return it with a section more."""
        return replace(self, sections=(*self.sections, Section(title, tuple(items))))

    def with_bars_of(self, check: "Check") -> "Derivation":
        """Return it with a check's sampling error and doubts of its loads among its error bars."""
        found = self
        for side, symbol, size, whole, said in (
            ("numerical", "e_pos", check.sampling, check.numerical,
             "what the check rises by between the positions of the cycle, with a margin"),
            ("above", "e_load", check.loads, check.model, f"{_DOUBTED}, above its value"),
            ("below", "e_load_lo", check.loads_below, check.below, f"{_DOUBTED}, below its value"),
        ):  # fmt: skip
            known = getattr(found.bars, side)
            if not size or not isfinite(whole) or symbol in known.split():
                continue
            item = Given(symbol, said, size, check.unit, "docs/theory/error_bars.md")
            bars = replace(found.bars, **{side: f"{known} {symbol}".strip()})
            found = replace(found._with_bar(item), bars=bars)
        return found

    def _with_bar(self, item: Item) -> "Derivation":
        """Return it with one more of what its error bars are made of."""
        *before, last = self.sections
        if last.title == BARS:
            sections = (*before, replace(last, items=(*last.items, item)))
        else:
            sections = (*self.sections, Section(BARS, (item,)))
        return replace(self, sections=sections)

    def to_dict(self) -> dict[str, Any]:
        """Given values and formulas, each with its value; None where a formula has none."""
        try:
            values = self.values
        except FormulaError:
            values = {}
        return plain_fields(self, "sections") | {
            "sections": [
                {"title": one.title, "items": [_item_data(item, values) for item in one.items]}
                for one in self.sections
            ]
        }


def value_of(item: Item, scope: Scope) -> Value:
    """Value of an item, which may use the symbols of a scope; raises FormulaError."""
    if isinstance(item, Given):
        if isinstance(item.value, tuple):
            return np.array(item.value, dtype=np.float64)
        return float(item.value)
    if isinstance(item, Superposition):
        stress = np.array(item.stress)
        if not np.isfinite(stress).all():
            raise FormulaError(f"the stress {item.symbol!r} is not finite")
        return stress
    if isinstance(item, Step):
        return _number(item, scope)
    functions_of(item.formula)  # of no rows nothing would be read
    total = float(sum(_number(item, row) for row in item.scopes(scope)))
    if not isfinite(total):
        raise FormulaError(f"the sum {item.symbol!r} is not finite")
    return total


def _number(item: Step | Sum, scope: Scope) -> float:
    value = evaluate(item.formula, scope)
    if not isinstance(value, float):
        raise FormulaError(f"{item.symbol!r} must be a number, its formula gives a vector")
    return value


_ITEMS: Mapping[str, Any] = {
    "given": Given,
    "step": Step,
    "sum": Sum,
    "superposition": Superposition,
}
_COUNTS = {"wrench": (6,), "accelerations": (0, 4), "stress": (len(COMPONENTS),)}  # of numbers


def _item_data(item: Item, values: Mapping[str, Value]) -> dict[str, Any]:
    kind = next(name for name, made in _ITEMS.items() if type(item) is made)
    data = {"item": kind} | plain_fields(item)
    if not isinstance(item, Given):
        value = values.get(item.symbol)
        data["value"] = value if value is None or isinstance(value, float) else value.tolist()
    return data


def derivation_of_data(data: Mapping[str, Any]) -> Derivation:
    """Return the derivation that `Derivation.to_dict` has written; raises ValueError.

    What the file says is taken for nothing: every text, number and length is asked for.
    """
    try:
        found: Derivation = _made(Derivation, data)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(f"not a derivation of this version: {brief(error, 120)}") from error
    return found


def _made(made: Any, data: Any) -> Any:
    """A dataclass from its data, each field by what reads its type."""
    if not isinstance(data, dict):
        raise TypeError(f"{brief(data, 40)!r} has no fields")
    kinds = {field.name: field.type for field in fields(made)}
    odd = data.keys() ^ kinds.keys()
    if odd:
        owner = "it has" if min(odd) in kinds else f"a {made.__name__} has"
        raise TypeError(f"{owner} no {brief(min(odd), 40)!r}")
    own = {name: _read(kinds[name], value) for name, value in data.items()}
    for name in own.keys() & _COUNTS.keys():
        if len(own[name]) not in _COUNTS[name]:
            raise TypeError(f"{len(own[name])} numbers stand where {_COUNTS[name][-1]} must")
    return made(**own)


def _read(kind: Any, value: Any) -> Any:
    """A value of a type; raises TypeError for any other."""
    if kind in _READ:
        return _READ[kind](value)
    if kind == Item:
        return _item(value)
    if kind == float | tuple[float, ...]:
        kind = tuple[float, ...] if isinstance(value, list) else float
        return _read(kind, value)
    if get_origin(kind) is not tuple:
        return _made(kind, value)
    inside, *others = get_args(kind)
    if others != [...] and len(_list(value)) != 1 + len(others):
        raise TypeError(f"{brief(value, 40)!r} has not {1 + len(others)} members")
    return tuple(_read(inside, one) for one in _list(value))


def _item(data: Mapping[str, Any]) -> Item:
    own = dict(data)
    made = _ITEMS[text_of(own.pop("item"))]
    if made is not Given:
        own.pop("value", None)
    item: Item = _made(made, own)
    return item


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise TypeError(f"{brief(value, 40)!r} is no list")
    return value


def text_of(value: Any) -> str:
    """A text as such, which UTF-8 can hold; raises TypeError and UnicodeEncodeError."""
    if not isinstance(value, str):
        raise TypeError(f"{brief(value, 40)!r} is no text")
    value.encode()
    return value


def number_of(value: Any) -> float:
    """A finite number as a float; raises TypeError."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{brief(value, 40)!r} is no number")
    try:
        found = float(value)
    except OverflowError:
        found = inf
    if not isfinite(found):
        raise TypeError("a number is too large")
    return found


def _index(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError(f"{brief(value, 40)!r} is no index")
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"{brief(value, 40)!r} is neither true nor false")
    return value


_READ = {str: text_of, float: number_of, int: _index, bool: _flag}
