"""Derivations as plain data and back, for result.json: givens, formulas, and their values."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

from reports.derivation import (
    Acting,
    Bars,
    Column,
    Comparison,
    Derivation,
    Given,
    Item,
    LoadCase,
    Section,
    Step,
    Sum,
    Superposition,
    UnitLoad,
)
from reports.formulas import FormulaError, Value

_ITEMS: Mapping[str, Any] = {
    "given": Given,
    "step": Step,
    "sum": Sum,
    "superposition": Superposition,
}


def plain_derivation(derivation: Derivation) -> dict[str, Any]:
    """What was given and the formulas, each with its value; None where a formula has none."""
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
    """Return the derivation that `Derivation.to_dict` has written; raises ValueError."""
    try:
        return Derivation(
            cases=tuple(_case(case) for case in data["cases"]),
            sections=tuple(
                Section(str(s["title"]), tuple(_item(item) for item in s["items"]))
                for s in data["sections"]
            ),
            value=str(data["value"]),
            limit=str(data["limit"]),
            bars=Bars(**{name: str(text) for name, text in data["bars"].items()}),
            unproved=str(data["unproved"]),
            equal=tuple((str(one), str(other)) for one, other in data["equal"]),
            compared=tuple(Comparison(**one) for one in data["compared"]),
            notes=tuple(str(note) for note in data["notes"]),
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not a derivation of this version: {error!r}") from error


def _case(data: Mapping[str, Any]) -> LoadCase:
    own = dict(data)
    own["acting"] = tuple(
        Acting(str(acts["interface"]), str(acts["on"]), _numbers(acts["wrench"]))
        for acts in own["acting"]
    )
    own["accelerations"] = _numbers(own["accelerations"])
    return LoadCase(**own)


def _item(data: Mapping[str, Any]) -> Item:
    own = dict(data)
    made = _ITEMS[own.pop("item")]
    if made is Given:
        value = own["value"]
        own["value"] = _numbers(value) if isinstance(value, list) else _number(value)
        return Given(**own)
    own.pop("value", None)
    if made is Step:
        return Step(**own)
    if made is Sum:
        own["names"] = tuple(str(name) for name in own["names"])
        own["columns"] = tuple(
            Column(str(c["symbol"]), str(c["meaning"]), str(c["unit"]), _numbers(c["values"]))
            for c in own["columns"]
        )
        return Sum(**own)
    own["loads"] = tuple(
        UnitLoad(str(u["name"]), str(u["unit"]), _number(u["value"]), _numbers(u["stress"]))
        for u in own["loads"]
    )
    return Superposition(**own)


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise TypeError(f"{value!r} is no number")
    return float(value)


def _numbers(values: Sequence[Any]) -> tuple[float, ...]:
    return tuple(_number(value) for value in values)
