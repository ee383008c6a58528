"""Templates, JSON schema and materials of design files, for those who write them."""

import copy
from importlib.resources import files
from math import inf
from pathlib import Path
from typing import Any

from checks.design.errors import DesignError, no_such
from checks.design.materials import Grade, Material, known_materials
from checks.design.model import PART_MODELS, DesignFile
from checks.result.words import number
from reports.terminal import labelled, table

_WIDTH = 100
_PER_METRE = 1000**0.5  # MPa mm^0.5 in a MPa m^0.5


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


def materials_text(name: str = "") -> str:
    """Return all materials, a line each, or every value of one.

    Raises DesignError for a name that no material has.
    """
    known = known_materials()
    if not name:
        heads = ["material", "yield, MPa", "ultimate, MPa", "E, GPa", "up to"]
        rows = [_row(material) for material in known.values()]
        return "\n".join(table(heads, rows, {1, 2, 3}, _WIDTH, between="  "))
    if name not in known:
        raise DesignError(Path("materials"), name, no_such("material", name, known))
    lines = [labelled(label, text, _WIDTH, indent=11) for label, text in _values(known[name])]
    return "\n".join(line for several in lines for line in several)


def _row(material: Material) -> list[str]:
    grades = material.grades
    return [
        material.name,
        _range(*(grade.yield_stress for grade in grades)),
        _range(*(grade.ultimate_stress for grade in grades)),
        number(material.youngs_modulus / 1e3),
        _size(grades[-1]),
    ]


def _range(*values: float) -> str:
    """The value of the smallest size, and of the largest where that differs."""
    first, last = values[0], values[-1]
    return f"{first:g}" if first == last else f"{first:g} .. {last:g}"


def _size(grade: Grade) -> str:
    if grade.thickness == inf:
        return "any size"
    rounds = "" if grade.diameter == grade.thickness else f", rounds {grade.diameter:g} mm"
    return f"{grade.thickness:g} mm{rounds}"


def _values(material: Material) -> list[tuple[str, str]]:
    """Labels and texts of all values of a material."""
    values = [
        ("material", material.name),
        ("elastic", f"E {material.youngs_modulus / 1e3:g} GPa, nu "
         f"{material.poisson_ratio:g}, density {material.density * 1e12:g} kg/m3"),
    ]  # fmt: skip
    values += [
        ("strength", f"yield {g.yield_stress:g} MPa, ultimate {g.ultimate_stress:g} MPa: "
         + (_size(g) if g.thickness == inf else f"up to {_size(g)}"))
        for g in material.grades
    ]  # fmt: skip
    if material.why_not_goodman:
        values.append(("fatigue", material.why_not_goodman))
    else:
        ratio = material.endurance_ratio
        at = f" at {material.endurance_cycles:g} cycles"
        share, of = (0.5, ", as steel's") if ratio is None else (ratio, at)
        values.append(
            ("fatigue", f"endurance limit of a polished bar {share:g} of the ultimate strength{of}")
        )
    if material.threshold is not None:
        threshold = number(material.threshold / _PER_METRE)
        values.append(("threshold", f"{threshold} MPa m^0.5, at R = -1, for sharp edges"))
    if material.fkm_group is not None:
        values.append(("FKM group", material.fkm_group))
    return [*values, ("source", material.source)]
