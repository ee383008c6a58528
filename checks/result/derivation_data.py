"""Derivations as plain data and back, for result.json: givens, formulas, and their values."""

from collections.abc import Mapping
from dataclasses import fields
from math import inf, isfinite
from typing import Any

from checks.result.derivation import (
    Acting,
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
    Superposition,
    UnitLoad,
)
from checks.result.formulas import COMPONENTS, FormulaError, Value
from checks.result.words import brief

_ITEMS: Mapping[str, Any] = {
    "given": Given,
    "step": Step,
    "sum": Sum,
    "superposition": Superposition,
}
_WRENCH, _ACCELERATIONS = 6, (0, 4)  # how many numbers


def plain_derivation(derivation: Derivation) -> dict[str, Any]:
    """Given values and formulas, each with its value; None where a formula has none."""
    try:
        values = derivation.values
    except FormulaError:
        values = {}
    return {
        "cases": [
            _fields(case, "acting") | {"acting": [_fields(acts) for acts in case.acting]}
            for case in derivation.cases
        ],
        "sections": [
            {"title": one.title, "items": [_item_data(item, values) for item in one.items]}
            for one in derivation.sections
        ],
        "value": derivation.value,
        "limit": derivation.limit,
        "bars": _fields(derivation.bars),
        "unproved": derivation.unproved,
        "equal": [list(pair) for pair in derivation.equal],
        "compared": [_fields(one) for one in derivation.compared],
        "notes": list(derivation.notes),
    }


def _fields(thing: Any, *left_out: str) -> dict[str, Any]:
    names = (name for name in thing.__dataclass_fields__ if name not in left_out)
    return {name: _plain(getattr(thing, name)) for name in names}


def _plain(value: Any) -> Any:
    return [_plain(one) for one in value] if isinstance(value, tuple) else value


def _item_data(item: Item, values: Mapping[str, Value]) -> dict[str, Any]:
    kind = next(name for name, made in _ITEMS.items() if type(item) is made)
    data = {"item": kind} | _fields(item, "columns", "loads")
    if isinstance(item, Sum):
        data["columns"] = [_fields(column) for column in item.columns]
    if isinstance(item, Superposition):
        data["loads"] = [_fields(load) for load in item.loads]
    if not isinstance(item, Given):
        value = values.get(item.symbol)
        if value is None or isinstance(value, float):
            data["value"] = value
        else:
            data["value"] = [float(one) for one in value]
    return data


def derivation_of_data(data: Mapping[str, Any]) -> Derivation:
    """Return the derivation that `Derivation.to_dict` has written; raises ValueError.

    What the file says is taken for nothing: every text, number and length is asked for.
    """
    try:
        return Derivation(
            cases=tuple(_case(case) for case in _list(data["cases"])),
            sections=tuple(
                Section(text_of(s["title"]), tuple(_item(item) for item in _list(s["items"])))
                for s in _list(data["sections"])
            ),
            value=text_of(data["value"]),
            limit=text_of(data["limit"]),
            bars=BarSymbols(**{name: text_of(text) for name, text in data["bars"].items()}),
            unproved=text_of(data["unproved"]),
            equal=tuple((text_of(one), text_of(other)) for one, other in _list(data["equal"])),
            compared=tuple(
                HandComparison(**_own(HandComparison, one, hand=number_of, model=number_of))
                for one in _list(data["compared"])
            ),
            notes=tuple(text_of(note) for note in _list(data["notes"])),
        )
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(f"not a derivation of this version: {brief(error, 120)}") from error


def _own(made: Any, data: Mapping[str, Any], **read: Any) -> dict[str, Any]:
    """The fields of a class from its data, each by what reads it: texts but for those named."""
    if not isinstance(data, dict):
        raise TypeError(f"{brief(data, 40)!r} has no fields")
    names = {field.name for field in fields(made)}
    odd = data.keys() - names
    if odd:
        raise TypeError(f"a {made.__name__} has no {brief(min(odd), 40)!r}")
    return {name: read.get(name, text_of)(value) for name, value in data.items()}


def _case(data: Mapping[str, Any]) -> LoadCase:
    return LoadCase(
        **_own(
            LoadCase,
            data,
            index=_index,
            acting=lambda all_of_them: tuple(_acting(acts) for acts in _list(all_of_them)),
            accelerations=lambda values: _numbers(values, *_ACCELERATIONS),
        )
    )


def _acting(data: Mapping[str, Any]) -> Acting:
    return Acting(**_own(Acting, data, wrench=lambda values: _numbers(values, _WRENCH)))


def _item(data: Mapping[str, Any]) -> Item:
    own = dict(data)
    made = _ITEMS[text_of(own.pop("item"))]
    if made is Given:
        return Given(**_own(Given, own, value=_number_or_vector, main=_flag))
    own.pop("value", None)
    if made is Step:
        return Step(**_own(Step, own, main=_flag))
    if made is Sum:
        return Sum(**_own(Sum, own, names=_texts, columns=_columns, main=_flag))
    return Superposition(**_own(Superposition, own, loads=_loads, main=_flag))


def _columns(data: Any) -> tuple[Column, ...]:
    return tuple(Column(**_own(Column, one, values=_numbers)) for one in _list(data))


def _loads(data: Any) -> tuple[UnitLoad, ...]:
    def stress(values: Any) -> tuple[float, ...]:
        return _numbers(values, len(COMPONENTS))

    return tuple(
        UnitLoad(**_own(UnitLoad, one, value=number_of, stress=stress)) for one in _list(data)
    )


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


def _number_or_vector(value: Any) -> float | tuple[float, ...]:
    return _numbers(value) if isinstance(value, list) else number_of(value)


def _texts(values: Any) -> tuple[str, ...]:
    return tuple(text_of(value) for value in _list(values))


def _numbers(values: Any, *counts: int) -> tuple[float, ...]:
    """The numbers of a list; of so many, where that is said."""
    found = tuple(number_of(value) for value in _list(values))
    if counts and len(found) not in counts:
        raise TypeError(f"{len(found)} numbers stand where {counts[-1]} must")
    return found


def _index(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError(f"{brief(value, 40)!r} is no index")
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"{brief(value, 40)!r} is neither true nor false")
    return value
