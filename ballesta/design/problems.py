"""Says what pydantic found wrong with a design file in the words of the file's author."""

import dataclasses
import types
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, Tag, ValidationError

from ballesta.design.overrides import Way, dotted
from checks.design.errors import Problems, listed, nearest, no_such
from checks.design.model import PART_MODELS, DesignFile
from checks.design.tables import TAGS
from checks.result.words import brief
from geometry.parameters import GIVEN_BY_LINKAGE
from geometry.parts import SHAPES


def tell_problems(
    error: ValidationError, origins: dict[Way, Way], overridden: set[str], problems: Problems
) -> None:
    """Add each of pydantic's errors to the problems, at the key where the value is written."""
    for detail in error.errors(include_url=False):
        raw: Way = detail["loc"]
        way = _as_written(raw)
        bad_name = way[-1] == "[key]"
        problem = _wording(dict(detail), raw)
        way = way[:-1] if bad_name else way
        if way[:3] in origins:
            way = (*origins[way[:3]], *way[3:])
        if dotted(way) in overridden:
            problem += " (from --set)"
        problems.add(dotted(way), problem)


def _as_written(way: Way) -> Way:
    """Return a way without the steps by which pydantic says which of several models it took."""
    if way[0] == "parts" and len(way) > 2 and way[2] in PART_MODELS:
        way = (*way[:2], *way[3:])
    return tuple(step for step in way if step not in TAGS)


def _wording(detail: dict[str, Any], way: Way) -> str:
    kind, found, context = detail["type"], detail["input"], detail.get("ctx", {})
    shown = f'"{brief(found, 100)}"' if isinstance(found, str) else brief(found, 100)
    if kind == "value_error":
        return str(context["error"])
    if kind == "extra_forbidden":
        return _unknown_key(way)
    if kind == "missing":
        description = _description(way)
        return f"must be stated: {description}" if description else "must be stated"
    if kind == "union_tag_not_found":
        return f"shape must be stated, one of {listed(PART_MODELS)}"
    if kind == "union_tag_invalid":
        return no_such("shape", str(found.get("shape")), PART_MODELS)
    if kind == "literal_error":
        guess = nearest(
            str(found), context["expected"].replace("'", "").replace(" or ", ", ").split(", ")
        )
        hint = f", did you mean {guess}?" if guess else ""
        return f"must be {context['expected']}, got {shown}{hint}"
    if kind == "string_pattern_mismatch":
        return f"a name has letters, digits, _ and - only, got {shown}"
    if kind in ("greater_than", "greater_than_equal"):
        word, bound = ("above", "gt") if kind == "greater_than" else ("at least", "ge")
        return f"must be {word} {context[bound]:g}, got {shown}"
    if kind == "less_than_equal":
        return f"must be at most {context['le']}, got {shown}"
    wanted = {
        "model_type": "a table", "model_attributes_type": "a table", "dict_type": "a table",
        "list_type": "a list", "string_type": "text", "float_type": "a number",
        "int_type": "a whole number", "bool_type": "true or false",
        "finite_number": "a finite number",
        "too_short": f"at least {context.get('min_length')} long",
        "too_long": f"at most {context.get('max_length')} long",
    }.get(kind)  # fmt: skip
    return f"must be {wanted}, got {shown}" if wanted else f"{detail['msg']}, got {shown}"


def _unknown_key(way: Way) -> str:
    key = str(way[-1])
    shape = SHAPES.get(str(way[2])) if way[0] == "parts" and len(way) == 4 else None
    for parameter in dataclasses.fields(shape) if shape else ():
        if parameter.name == key and parameter.metadata.get("given_by") == GIVEN_BY_LINKAGE:
            return f"must not be stated: {parameter.metadata['meaning']} follows from the points"
    model = _model_at(way[:-1])
    known = list(model.model_fields) if model else []
    guess = nearest(key, known)
    hint = f"did you mean {guess}?" if guess else f"there are {listed(known)}"
    return f"unknown key, {hint}"


def _description(way: Way) -> str | None:
    model = _model_at(way[:-1])
    field = model.model_fields.get(str(way[-1])) if model else None
    return field.description if field else None


def _model_at(way: Way) -> type[BaseModel] | None:
    """Return the model of the table at a way through the file, as pydantic writes it."""
    here: Any = DesignFile
    for step in way:
        if step in TAGS:
            here = next(arg for arg in get_args(_inside(here)) if _tag_of(arg) == step)
        elif step in PART_MODELS and not (isinstance(here, type) and issubclass(here, BaseModel)):
            here = PART_MODELS[str(step)]
        elif isinstance(here, type) and issubclass(here, BaseModel):
            field = here.model_fields.get(str(step))
            here = field.annotation if field else None
        else:
            here = get_args(here)[-1] if get_args(here) else None
        here = _plain(here)
    return here if isinstance(here, type) and issubclass(here, BaseModel) else None


def _plain(annotation: Any) -> Any:
    """Return an annotation without None and without marks, but with the tags of a choice."""
    inside = _inside(annotation)
    if get_origin(inside) in (Union, types.UnionType):
        members = [arg for arg in get_args(inside) if arg is not type(None)]
        return _plain(members[0]) if len(members) == 1 else annotation
    return inside


def _inside(annotation: Any) -> Any:
    return annotation.__origin__ if hasattr(annotation, "__metadata__") else annotation


def _tag_of(annotation: Any) -> str | None:
    marks = getattr(annotation, "__metadata__", ())
    return next((mark.tag for mark in marks if isinstance(mark, Tag)), None)
