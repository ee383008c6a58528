"""Every key of a design file as a page of docs/reference, from the models that read it."""

import inspect
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from checks.design.file_entries import Point, Unit
from checks.design.model import (
    BeamPartEntry,
    BodyPartEntry,
    DesignFile,
    PartEntry,
    PinPartEntry,
    PlatePartEntry,
    StepPartEntry,
)
from checks.design.units import DIMENSIONS, PAIRS, AnyQuantity, FitOrClearance, Quantity, Vector
from geometry.parts import SHAPES

HEAD = """\
# Keys of a design file

Written by `python tools/reference.py` from `checks/design/model.py`; do not edit.

A design file is [TOML](https://toml.io). A quantity is text with a unit, such as `"6.3 mm"`; any
unit of the dimension will do. `NAME` stands for a name of your own, `[]` for each entry of a list.
Unknown keys are refused. `like = "OTHER"` in a body, a cycle or a part takes all keys of another
one, and at the top of the file those of another file; keys beside it override them.

`ballesta schema` prints the same as a JSON schema, with which editors complete and check a file
while it is typed.
"""
PARTS = {  # heading -> model, whose keys stand in addition to those of the one before
    "parts.NAME": PartEntry,
    "parts.NAME of a body": BodyPartEntry,
    "parts.NAME from a STEP file": StepPartEntry,
    "parts.NAME of a lever or a drawn plate": PlatePartEntry,
    "parts.NAME of a beam": BeamPartEntry,
    "parts.NAME of a pin": PinPartEntry,
}
_BOUNDS = ((Gt, "gt", "above"), (Ge, "ge", "at least"), (Lt, "lt", "below"), (Le, "le", "at most"))


def design_file_page() -> str:
    """Every key of a design file: value, example, default, meaning."""
    lines = [HEAD]
    for heading, paths, model in _tables():
        lines += [f"## {heading}", "", _paragraph(model.__doc__), ""]
        if len(paths) > 1:
            lines += [f"Also at {', '.join(f'`{path}`' for path in paths[1:])}.", ""]
        if heading == "parts.NAME of a body":
            shapes = ", ".join(f"[`{name}`](../parts.md#{name})" for name in SHAPES)
            lines += [f"`shape` is one of {shapes}, whose parameters are further keys.", ""]
        lines += [
            "| Key | Value | Example | Default | Meaning |",
            "| --- | --- | --- | --- | --- |",
        ]
        base = _keys_above(model)
        for name, field in model.model_fields.items():
            if name not in base:
                lines.append(_row(heading, name, field))
        lines.append("")
    return "\n".join(lines)


def _keys_above(model: type[BaseModel]) -> set[str]:
    """Keys that stand in the table of a model that this one adds to."""
    above = {
        BodyPartEntry: PartEntry,
        PinPartEntry: PartEntry,
        StepPartEntry: BodyPartEntry,
        PlatePartEntry: BodyPartEntry,
        BeamPartEntry: BodyPartEntry,
    }
    return set(above[model].model_fields) if model in above else set()


@cache
def _tables() -> list[tuple[str, list[str], type[BaseModel]]]:
    """Heading, paths and model of every table of the file, each once, with those within it next."""
    paths: dict[type[BaseModel], list[str]] = {}
    _collect("", DesignFile, paths)
    places = Counter(path for all_paths in paths.values() for path in dict.fromkeys(all_paths))
    tables = []
    for model, all_paths in paths.items():
        first = all_paths[0]
        if places[first] > 1:  # one of several forms of a value
            first += f" with {next(iter(model.model_fields))}"
        tables.append((first or "The file", list(dict.fromkeys(all_paths)), model))
    return tables


def _collect(path: str, model: type[BaseModel], paths: dict[type[BaseModel], list[str]]) -> None:
    known = model in paths
    paths.setdefault(model, []).append(path)
    if known:
        return
    at = "parts.NAME" if model in PARTS.values() else path
    for name, field in model.model_fields.items():
        if name == "parts" and model is DesignFile:
            for heading, entry in PARTS.items():
                _collect(heading, entry, paths)
        elif name not in _keys_above(model):
            for suffix, inner in _models_in(field.annotation):
                _collect(f"{at}.{name}{suffix}".removeprefix("."), inner, paths)


def _models_in(kind: Any) -> Iterator[tuple[str, type[BaseModel]]]:
    """Models within a type, each with what its path has behind the key: .NAME or []."""
    origin, inner = get_origin(kind), get_args(kind)
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        yield "", kind
    elif origin is Annotated:
        yield from _models_in(inner[0])
    elif origin in (Union, UnionType):
        for one in inner:
            yield from _models_in(one)
    elif origin is list:
        yield from ((f"[]{more}", model) for more, model in _models_in(inner[0]))
    elif origin is dict:
        yield from ((f".NAME{more}", model) for more, model in _models_in(inner[1]))


def _row(heading: str, name: str, field: FieldInfo) -> str:
    if heading == "The file" and name == "parts":
        link = f"table: NAME = [part](#{anchor('parts.NAME')})"
        return f"| `parts` | {link} | | none | the parts that are checked |"
    described = _value(field.annotation, field.metadata)
    default = "must be stated" if field.is_required() else _default(field)
    example = ", ".join(
        f"`{one}`" for one in described.examples or map(_toml, field.examples or ())
    )
    meaning = field.description or (described.model.__doc__ if described.model else "") or ""
    cells = (f"`{name}`", described.words, example, default, _paragraph(meaning).rstrip("."))
    return "| " + " | ".join(cell.replace("|", "\\|").replace("<", "&lt;") for cell in cells) + " |"


def _default(field: FieldInfo) -> str:
    default = field.get_default(call_default_factory=True, validated_data={})
    if isinstance(default, BaseModel):
        return "those of its keys"
    if default is None or default in ({}, [], PydanticUndefined):
        return "none"
    return f"`{_toml(default)}`"


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return f"{value:g}" if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class Value:
    """A value of a key in words.

    model  of the table that it is, if it is one
    """

    words: str
    examples: tuple[str, ...] = ()
    model: type[BaseModel] | None = None


def _value(kind: Any, metadata: Any = ()) -> Value:
    """A type of the models in words."""
    marks = [
        mark
        for one in metadata
        for mark in (one.metadata if isinstance(one, FieldInfo) else (one,))
    ]
    for mark in marks:
        if isinstance(mark, Quantity):
            return _quantity(mark)
        if isinstance(mark, Vector):
            return _vector(mark)
        if isinstance(mark, AnyQuantity):
            return Value("quantity or number", ('"400 N"',))
        if isinstance(mark, Point):
            return Value("point in space", ('"250, 0, 0 mm"',))
        if isinstance(mark, FitOrClearance):
            kind = "interference" if mark.pressed else "clearance"
            examples = tuple(f'"{one}"' for one in mark.json_schema()["examples"])
            return Value(f"fit or {kind}", examples)
        if isinstance(mark, Unit):
            units = tuple(
                f'"{DIMENSIONS[one].example.partition(" ")[2]}"' for one in mark.dimensions
            )
            return Value("unit of " + " or ".join(mark.dimensions), units)
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _value(inner[0], (*inner[1:], *marks))
    if origin in (Union, UnionType):
        several = [_value(one) for one in inner if one is not NoneType]
        examples = tuple(example for one in several for example in one.examples)
        model = several[0].model if len(several) == 1 else None
        return Value(" or ".join(one.words for one in several), examples, model)
    if origin is Literal:
        return Value(" or ".join(f"`{_toml(one)}`" for one in inner))
    if origin is list:
        one = _value(inner[0])
        return Value(f"list{_count(marks)} of {one.words}", one.examples, one.model)
    if origin is dict:
        one = _value(inner[1])
        return Value(f"table: NAME = {one.words}", one.examples, one.model)
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        heading = next(heading for heading, _, model in _tables() if model is kind)
        return Value(f"[table](#{anchor(heading)})", model=kind)
    plain = {str: "text", bool: "`true` or `false`", int: "whole number", float: "number"}[kind]
    bounds = [
        f"{word} {getattr(mark, bound):g}"
        for mark in marks
        for made, bound, word in _BOUNDS
        if isinstance(mark, made)
    ]
    return Value(" ".join([plain, ", ".join(bounds)]).strip())


def _quantity(mark: Quantity) -> Value:
    names = " or ".join(mark.dimensions)
    bounds = ", ".join(mark.bounds())
    examples = tuple(f'"{DIMENSIONS[name].example}"' for name in mark.dimensions)
    return Value(f"{names} {bounds}".strip(), examples)


def _vector(mark: Vector) -> Value:
    example = f'"{PAIRS[mark.dimension]}"'
    return Value(f"pair: {mark.dimension}" if mark.dimension else "direction", (example,))


def _count(marks: list[Any]) -> str:
    least = next((mark.min_length for mark in marks if isinstance(mark, MinLen)), None)
    most = next((mark.max_length for mark in marks if isinstance(mark, MaxLen)), None)
    if least is None and most is None:
        return ""
    return f" ({least})" if least == most else f" (at least {least})"


def anchor(heading: str) -> str:
    """The id that a page of the site, and of a repository's browser, gives to a heading."""
    return re.sub(r"[^\w\- ]", "", heading).strip().lower().replace(" ", "-")


def _paragraph(text: str | None) -> str:
    """The first paragraph of a docstring, in one line."""
    return " ".join(inspect.cleandoc(text or "").partition("\n\n")[0].split())
