"""Results as files: JSON for programs and its schema, VTU for ParaView; whole or not at all."""

import json
import os
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.verdict import DesignResult, PartResult, Status

FORMAT = "ballesta-result/1"
_on_a_line = json.JSONEncoder(allow_nan=False, ensure_ascii=False).encode


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Path to write to, beside `path`, which it replaces in one step when all went well."""
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = target.with_name(f".{secrets.token_hex(8)}.tmp")
    try:
        yield temporary
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)


def write_whole(path: Path, data: bytes) -> None:
    """Write a file so that it is whole or as before, also after the machine has lost its power."""
    with replacing(path) as temporary, temporary.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())


def write_text(path: str | Path, text: str) -> None:
    """Write text as a file, which is there whole or not at all, with the same bytes everywhere."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def plain(data: Any) -> Any:
    """Plain data as JSON knows it: arrays as lists, null for what is infinite or no number."""
    if type(data) is float:
        return data if isfinite(data) else None
    if isinstance(data, str):  # a lone half of a surrogate pair cannot be written as UTF-8
        return data if data.isascii() else data.encode(errors="replace").decode()
    if data is None or isinstance(data, bool):
        return data
    if isinstance(data, list | tuple) and all(type(item) is float for item in data):
        return [item if isfinite(item) else None for item in data]
    if isinstance(data, Mapping):
        return {plain(str(key)): plain(value) for key, value in data.items()}
    if isinstance(data, np.ndarray | np.generic):
        return plain(data.tolist())
    if isinstance(data, int):
        return int(data)
    if isinstance(data, float):
        return float(data) if isfinite(data) else None
    if isinstance(data, Sequence):
        return [plain(item) for item in data]
    if isinstance(data, Path):
        return plain(str(data))
    raise TypeError(f"a result holds {type(data).__name__}, which no JSON file can")


def write_json(result: DesignResult, path: str | Path) -> None:
    """Write the result as JSON: keys in the order of the result, numbers to the last digit.

    A list of numbers stands on one line.
    """
    write_text(path, _over_lines(plain(result.to_dict())) + "\n")


def _over_lines(data: Any, start: str = "\n") -> str:
    """JSON with a line for each value: `json.dumps` does that in Python, number by number."""
    within = f"{start} "
    if isinstance(data, dict) and data:
        lines = [f"{_on_a_line(key)}: {_over_lines(item, within)}" for key, item in data.items()]
        return f"{{{within}{f',{within}'.join(lines)}{start}}}"
    if isinstance(data, list) and any(isinstance(item, str | list | dict) for item in data):
        lines = [_over_lines(item, within) for item in data]
        return f"[{within}{f',{within}'.join(lines)}{start}]"
    return _on_a_line(data)


def write_volume(
    path: Path,
    nodes: npt.NDArray[np.float64],
    elements: npt.NDArray[np.int64],
    fields: Mapping[str, npt.NDArray[np.float64]],
) -> None:
    """Write ten-node tetrahedra with fields at their nodes as .vtu, in single precision."""
    single = {name: values.astype(np.float32) for name, values in fields.items()}
    _write_mesh(path, nodes.astype(np.float32), "tetra10", elements, single)


def _write_mesh(path: str | Path, nodes: Any, kind: str, cells: Any, fields: Any) -> None:
    import meshio

    mesh = meshio.Mesh(nodes, [(kind, cells)], point_data=fields)
    with replacing(path) as temporary:
        meshio.write(temporary, mesh, file_format="vtu")


def write_pvd(path: Path, steps: Sequence[tuple[float, str]]) -> None:
    """Write a ParaView collection: (time, file beside it) for each step."""
    from xml.sax.saxutils import quoteattr  # loads the modules of network connections: 50 ms

    lines = [
        f'<DataSet timestep="{time:.9g}" part="0" file={quoteattr(file)}/>' for time, file in steps
    ]
    text = "\n".join(
        ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1"><Collection>', *lines]
    )
    write_text(path, f"{text}\n</Collection></VTKFile>\n")


def write_vtu(part: PartResult, path: str | Path) -> None:
    """Write the surface of a part with its fields, mm and the unit that the field's name states.

    Displacement is a vector, stress a symmetric tensor, in ParaView's order of the six components.
    """
    surface = part.surface
    fields = {k: np.asarray(v) for k, v in (*surface.fields.items(), *surface.directed.items())}
    nodes, triangles = np.asarray(surface.nodes, float), np.asarray(surface.triangles, np.int64)
    _write_mesh(path, nodes, "triangle", triangles, fields)


# JSON schema of result.json: every key with its meaning and unit. Objects are closed, so that a
# key which is not described here fails the validation of a result.
Schema = dict[str, Any]


def result_schema() -> Schema:
    """Return the JSON schema (draft 2020-12) of result.json; numbers are N, mm, s, tonne, MPa."""
    parts = {"Check": _CHECK, "PartCheck": _PART_CHECK, "ValidityCheck": _GATE, "Part": _PART}
    parts |= {"Cycle": _CYCLE, "Derivation": _DERIVATION, "Way": _WAY, "Change": _CHANGE}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Result of a check by ballesta",
        **_closed(
            format={"const": FORMAT},
            name=_text("name of the design"),
            file=_text("design file, as it was named on the command line"),
            sha256=_text("hash of the design file"),
            date=_text("day of the check, as 2026-11-23; empty if it is not known"),
            overrides=_list(_text("key=value of --set")),
            status=_STATUS,
            exit_code=_told({"enum": [0, 1]}, "0: all parts pass and all validity checks hold"),
            decided_by=_or_null(
                _closed(id=_text("of the check"), part=_text(), kind=_text()),
                "the check nearest to its limit, error bars included; null if nothing was checked",
            ),
            parts=_list(_of("Part")),
            linkage=_list(_of("PartCheck"), "checks of the linkage as a whole"),
            cycles=_by_name(_of("Cycle"), "by name: cycles and measured runs"),
            gates=_list(_of("ValidityCheck"), "validity checks of the loads"),
            warnings=_list(_text()),
            not_checked=_list(_text(), "subjects that no check covers"),
            assumed=_list(_PAIR, "keys, and what is assumed of them"),
            assumed_by_design=_list(_text(), "keys of `assumed` that the design file marks itself"),
            defaults=_list(_PAIR, "keys that the file does not state, and their values as text"),
            inputs=_list(_PAIR, "every key, and its value as text with its unit"),
            versions=_by_name(_text(), "of ballesta, its libraries, Python and the platform"),
            command=_text("that repeats the check"),
            timings=_by_name(_number(), "stage: s"),
            ways_out=_list(_of("Way"), "out of what is open, the cheapest first"),
            changes=_list(
                _of("Change"),
                "single changes that make the design pass or save mass, best first",
            ),
            unchanged=_text(
                'why there are none; "" where there are, and where none were sought, as in batches'
            ),
        ),
        "$defs": parts,
    }


def _told(schema: Schema, description: str) -> Schema:
    return schema | {"description": description} if description else schema


def _text(description: str = "") -> Schema:
    return _told({"type": "string"}, description)


def _number(description: str = "") -> Schema:
    return _told({"type": "number"}, description)


def _or_null(schema: Schema, description: str = "") -> Schema:
    return _told({"anyOf": [schema, {"type": "null"}]}, description)


def _list(items: Schema, description: str = "") -> Schema:
    return _told({"type": "array", "items": items}, description)


def _by_name(values: Schema, description: str = "") -> Schema:
    return _told({"type": "object", "additionalProperties": values}, description)


def _of(name: str) -> Schema:
    return {"$ref": f"#/$defs/{name}"}


def _closed(*optional: str, **keys: Schema) -> Schema:
    """An object with these keys and no other, all of them but the optional ones."""
    return {
        "type": "object",
        "properties": keys,
        "required": [key for key in keys if key not in optional],
        "additionalProperties": False,
    }


_PAIR = {"type": "array", "prefixItems": [_text(), _text()], "minItems": 2, "maxItems": 2}
_STATUS = _told({"enum": [str(status) for status in Status]}, "only pass is a pass")
_SERIES = _list(_or_null(_number()), "one number for each position")
_BAR = _number("half-width, in `unit`; null: unknown, without end") | {"minimum": 0}
_OF_CHECK = {
    "part": _text("of the design; linkage for the linkage as a whole"),
    "kind": _text("such as static, fatigue, buckling, bearing, bush"),
    "quantity": _text("name of `value`"),
    "value": _number("demand, in `unit`") | {"minimum": 0},
    "unit": _text("of value, limit and bars; empty for a plain number"),
    "numerical": _or_null(_BAR, "error bar of mesh and positions, to both sides"),
    "model": _or_null(_BAR, "model band above the value"),
    "model_below": _or_null(_BAR, "model band below the value"),
    "sampling": _number("part of `numerical` for peaks between positions, in `unit`"),
    "loads": _number("part of `model` for loads that are not certain, in `unit`"),
    "loads_below": _number("part of `model_below` for these, in `unit`"),
    "doubts": _list(
        {
            "type": "array",
            "prefixItems": [_text(), _number(), _number()],
            "minItems": 3,
            "maxItems": 3,
        },
        "what is not certain of the loads, with its part of `loads` and of `loads_below`",
    ),
    "limit": _number("largest value that the part can take, in `unit`"),
    "required": _number("safety that must be shown"),
    "safety": _or_null(_number(), "limit / value; null where the value is 0"),
    "utilisation": _number("value * required / limit: at most 1 is enough, error bars apart"),
    "status": _told(
        _STATUS,
        "pass if (value + numerical + model) * required <= limit; FAIL if "
        "(value - numerical - model_below) * required > limit",
    ),
    "cycle": _text("where the value is largest"),
    "position": _text("of that cycle, as shown to people"),
    "place": _text("on the part"),
    "method": _text("model that gave the value: formula, solid or frame"),
    "basis": _text("where the limit comes from"),
    "note": _text("what else must be known"),
    "plane": _text("in which it buckles as a column; empty where it does otherwise"),
    "span": _number("mm, between that column's ends; 0 without one, or where a section alone is"),
    "derivation": _of("Derivation"),
}
_CHECK = _closed("derivation", **_OF_CHECK)
_ID = _text("part/kind, or part/kind/quantity where the part has two of the kind")
_PART_CHECK = _closed("derivation", id=_ID, **_OF_CHECK)
_GATE = _closed(
    name=_text(),
    value=_or_null(_number(), "measured; null if infinite"),
    limit=_number("largest value with which it holds"),
    holds={"type": "boolean"},
    meaning=_text(),
    binding=_told({"type": "boolean"}, "the verdict depends on it"),
    cure=_text("what makes it hold; empty where nothing simple does"),
    key=_text("override for --set that makes it hold; empty without one"),
)
_HAND = _closed(
    quantity=_text(), hand=_number(), model=_number(), unit=_text(), formula=_text("of the hand")
)
_VALUE = {"type": ["number", "string", "boolean", "null", "array"]}
_RUNG = _closed(
    rung={"enum": ["formula", "solid"]},
    seconds=_number("taken; 0 if it was passed over"),
    unknowns={"type": "integer"},
    checks=_list(_of("Check"), "as this model alone answers them"),
    why=_text("why it stopped, went on, or was passed over"),
    left=_list(_text(), "kinds of checks that a better model may still settle"),
    expected=_or_null(_number(), "s, of one for which there was no time"),
)
_PART = _closed(
    name=_text(),
    shape=_text(),
    material=_text(),
    checks=_list(_of("PartCheck")),
    gates=_list(_of("ValidityCheck")),
    hand_checks=_list(_HAND, "numbers by hand beside the model's"),
    meshes=_list(_by_name(_VALUE), "meshes that were solved, coarse to fine; MPa"),
    facts=_by_name(_VALUE, "mass, strength and forces; names state the unit"),
    charts=_told({"type": "object"}, "what the page draws, which may change with any version"),
    assumed=_list(_text()),
    rungs=_list(_RUNG, "models that were tried, cheapest first"),
)
_CYCLE = _closed(
    shown_name=_text("of the position"),
    unit=_text("of the position"),
    position=_SERIES,
    time=_told(_SERIES, "s; empty where no speed is known"),
    phase=_list(_text(), "name of the phase at each position"),
    efforts=_by_name(_SERIES, "force: N"),
    torques=_by_name(_SERIES, "torque: N mm"),
    powers=_by_name(_SERIES, "force or torque: N mm/s that it does on the linkage"),
    works=_by_name(_number(), "force or torque: N mm over the cycle"),
    links=_by_name(_SERIES, "part and interface: N, size of the force there"),
    peaks=_by_name(_SERIES, "part: MPa, largest von Mises stress at each position"),
    duty=_number("times in the life; 0: in no duty"),
)
_DERIVATION = _told(
    {"type": "object", "required": ["cases", "sections", "value", "limit", "bars"]},
    "given values and formulas from which value, limit and bars follow (docs/derivations.md)",
)
_CHANGE = _closed(
    key=_text("of the design file"),
    was=_text("its value"),
    value=_text("its other value"),
    parts=_list(_text(), "that pass with it"),
    safety=_or_null(_number(), "of the check that then governs these parts; null: no load"),
    lower_safety=_or_null(_number(), "the same at the end of its error bars"),
    required=_number("safety that this check must show"),
    governing=_text("that check: part and kind"),
    model=_text("whose error bars the safety has"),
    mass_kg=_number("of all parts"),
    saved_kg=_number("less than before"),
    verified=_or_null(_STATUS, "verdict of a check with it; null: an estimate"),
    verified_safety=_or_null(_number(), "that this check found"),
)
_WAY = _closed(
    settles=_text("checks or validity check"),
    text=_text("what is to be done or stated; where nothing settles it, why"),
    command=_text("that tries it; empty where there is none"),
    seconds=_or_null(_number(), "expected; null if not known"),
)
