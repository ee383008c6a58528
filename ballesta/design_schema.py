"""The JSON schema of design files, for editors that complete and check them while typing."""

import copy
from typing import Any

from ballesta.design_model import PART_MODELS, DesignFile


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
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


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
