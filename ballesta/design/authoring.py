"""Templates and JSON schema of design files, for those who write them."""

import copy
from importlib.resources import files
from pathlib import Path
from typing import Any

from checks.design.errors import DesignError, no_such
from checks.design.model import PART_MODELS, DesignFile

# Design files to start from: `ballesta new <template>`.


def templates() -> tuple[str, ...]:
    """Return the names of the templates."""
    folder = files("ballesta.design").joinpath("templates")
    names = [entry.name for entry in folder.iterdir()]
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


def new_design(template: str) -> str:
    """Return the text of a template: a commented design file that runs as it is."""
    if template not in templates():
        raise DesignError(
            Path("new"),
            template,
            no_such(
                "template", template.replace("_", "-"), [n.replace("_", "-") for n in templates()]
            ),
        )
    entry = files("ballesta.design").joinpath("templates", f"{template}.toml")
    return entry.read_text(encoding="utf-8")


# The JSON schema of design files, for editors that complete and check them while typing.


def design_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a design file as it is written, units in text."""
    schema = DesignFile.model_json_schema()
    definitions = schema["$defs"]
    for entry in ("BodyEntry", "CycleEntry"):
        definitions[entry + "Like"] = _like([definitions[entry]])
        section = schema["properties"]["bodies" if entry == "BodyEntry" else "cycles"]
        _allow(section, {"$ref": f"#/$defs/{entry}Like"})
    definitions["PartLike"] = _like([definitions[model.__name__] for model in PART_MODELS.values()])
    _allow(schema["properties"]["parts"], {"$ref": "#/$defs/PartLike"})
    reason = {"type": "string"}
    definitions["Reasons"] = {
        "additionalProperties": {"anyOf": [reason, {"$ref": "#/$defs/Reasons"}]},
        "type": "object",
    }
    schema["properties"]["assumed"]["additionalProperties"] = {
        "anyOf": [reason, {"$ref": "#/$defs/Reasons"}]
    }
    return _also_derived({"$schema": "https://json-schema.org/draft/2020-12/schema", **schema})


def _also_derived(schema: dict[str, Any]) -> dict[str, Any]:
    """Return the schema that also takes a file that is `like` another and states a part of it."""
    own = {"$defs", "$schema"}
    whole = {key: value for key, value in schema.items() if key not in own}
    derived = _without_demands(whole)
    derived["properties"]["like"] = {
        "type": "string",
        "description": "another design file: all of it, then the keys of this one",
    }
    definitions = schema["$defs"]
    definitions |= {
        f"{name}Derived": _without_demands(entry) for name, entry in definitions.items()
    }
    return {
        "$schema": schema["$schema"],
        "title": schema["title"],
        "description": schema["description"],
        "type": "object",
        "$defs": definitions,
        # not if, then, else: editors complete keys through anyOf only
        "anyOf": [whole, {**derived, "required": ["like"]}],
    }


def _without_demands(schema: Any) -> Any:
    """Return a copy in which nothing must be stated, at any depth."""
    if isinstance(schema, list):
        return [_without_demands(entry) for entry in schema]
    if not isinstance(schema, dict):
        return schema
    copied = {}
    for key, entry in schema.items():
        if key in ("required", "discriminator", "minProperties"):
            continue
        if key == "$ref":
            copied[key] = f"{entry}Derived"
        else:
            # without what tells them apart, several forms may fit
            copied["anyOf" if key == "oneOf" else key] = _without_demands(entry)
    return copied


def _allow(section: dict[str, Any], other: dict[str, Any]) -> None:
    for place in ("additionalProperties", "patternProperties"):
        inner = section.get(place)
        if place == "patternProperties" and inner:
            for pattern, entry in inner.items():
                inner[pattern] = {"anyOf": [entry, other]}
        elif isinstance(inner, dict):
            section[place] = {"anyOf": [inner, other]}


def _like(originals: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the schema of a table that takes from another what it does not state."""
    properties: dict[str, Any] = {
        "like": {"type": "string", "description": "the table whose keys are taken over"}
    }
    for original in originals:
        for name, entry in original["properties"].items():
            known = properties.setdefault(name, {"anyOf": []})
            if name != "like" and entry not in known["anyOf"]:
                known["anyOf"].append(copy.deepcopy(entry))
    return {
        "type": "object",
        "additionalProperties": False,
        "required": ["like"],
        "properties": properties,
    }
