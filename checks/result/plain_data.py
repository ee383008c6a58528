"""Fields of results as plain data, for JSON."""

from collections.abc import Mapping
from math import isfinite
from typing import Any


def plain_fields(thing: Any, *left_out: str) -> dict[str, Any]:
    """Fields of a dataclass as plain data, in their order; None for what is not finite.

    A `to_dict` of a field's value is used; sequences and further dataclasses follow item by item,
    mappings stay as they are.
    """
    names = (name for name in thing.__dataclass_fields__ if name not in left_out)
    return {name: _plain(getattr(thing, name)) for name in names}


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, Mapping):
        return dict(value)
    if hasattr(value, "to_dict"):
        return value.to_dict()
    return plain_fields(value) if hasattr(value, "__dataclass_fields__") else value
