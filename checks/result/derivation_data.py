"""Derivations as plain data and back, for result.json: givens, formulas, and their values."""

from collections.abc import Mapping
from dataclasses import fields
from math import inf, isfinite
from typing import Any, get_args, get_origin

from checks.result.derivation import Derivation, Given, Item, Step, Sum, Superposition
from checks.result.formulas import COMPONENTS, FormulaError, Value
from checks.result.plain_data import plain_fields
from checks.result.words import brief

_ITEMS: Mapping[str, Any] = {
    "given": Given,
    "step": Step,
    "sum": Sum,
    "superposition": Superposition,
}
_COUNTS = {"wrench": (6,), "accelerations": (0, 4), "stress": (len(COMPONENTS),)}  # of numbers


def plain_derivation(derivation: Derivation) -> dict[str, Any]:
    """Given values and formulas, each with its value; None where a formula has none."""
    try:
        values = derivation.values
    except FormulaError:
        values = {}
    return plain_fields(derivation, "sections") | {
        "sections": [
            {"title": one.title, "items": [_item_data(item, values) for item in one.items]}
            for one in derivation.sections
        ]
    }


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
