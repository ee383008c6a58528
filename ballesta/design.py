"""The door: reads a design file, refuses what cannot be meant, converts the units once.

Inside ballesta a `Design` is trusted: names exist, quantities are finite and in N, mm, s and tonne.
"""

import hashlib
import math
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from ballesta.design_cycles import cycles_of, duty_of
from ballesta.design_data import Design
from ballesta.design_linkage import bodies_of, check_points, forces_of, friction_of, joints_of
from ballesta.design_model import DesignFile
from ballesta.design_parts import materials_of, parts_of
from ballesta.design_problems import tell_problems
from ballesta.errors import DesignError, Problems
from ballesta.names import nearest, no_such
from ballesta.overrides import apply_override, dotted, parse_override, resolve_like, split_key
from ballesta.units import DIMENSIONS, Quantity, Vector


def read_design(path: str | Path, overrides: Sequence[str] = ()) -> Design:
    """Return the design that the file states, with the overrides ("key=value") put in first.

    Raises DesignError, or DesignErrors for several problems at once, in the words of the author.
    """
    file = Path(path)
    source = _read_text(file)
    data = _parse(file, source)
    changes = [parse_override(text) for text in overrides]
    for change in changes:
        apply_override(data, change, file)
    problems = Problems(file)
    origins = resolve_like(data, problems)
    problems.raise_if_any()
    try:
        model = DesignFile.model_validate(data)
    except ValidationError as error:
        tell_problems(error, origins, {change.key for change in changes}, problems)
        problems.raise_if_any()
        raise  # an error that pydantic does not describe is ours
    return _assembled(model, data, file, source, tuple(overrides), problems)


def _assembled(
    model: DesignFile,
    data: Mapping[str, Any],
    file: Path,
    source: str,
    overrides: tuple[str, ...],
    problems: Problems,
) -> Design:
    check_points(model, problems)
    bodies = bodies_of(model, problems)
    joints = joints_of(model)
    materials = materials_of(model, problems)
    for key in model.assumed:
        _check_key(key, data, problems)
    for name in model.claims:
        if name not in model.parts:
            problems.add(f"claims.{name}", no_such("part", name, model.parts))
    design_forces = forces_of(model, problems)
    friction = friction_of(model, joints, problems)
    cycles = cycles_of(model, problems)
    duty = duty_of(model, problems)
    parts = parts_of(model, bodies, joints, materials, problems)
    problems.raise_if_any()
    defaults = [*_defaults(model, "")]
    for name, force in model.forces.items():
        ends = design_forces[name].between
        if ends is not None and force.on is None:
            on = [body for body, point in ends if len(joints.get(point, ())) > 1 and body in bodies]
            defaults += [(f"forces.{name}.on", body) for body in on]
    for name, entry in model.bodies.items():
        if bodies[name].part is None and entry.centre is None:
            defaults.append((f"bodies.{name}.centre", f"at its first pin, {entry.pins[0]}"))
    return Design(
        name=model.name,
        file=file,
        source=source,
        sha256=hashlib.sha256(source.encode()).hexdigest(),
        overrides=overrides,
        accuracy=model.accuracy,
        require=model.require,
        gravity=model.gravity,
        ground=tuple(model.ground),
        points=dict(model.points),
        bodies=bodies,
        joints=joints,
        forces=design_forces,
        friction=friction,
        cycles=cycles,
        duty=duty,
        parts=parts,
        materials={part.material.name: part.material for part in parts.values()},
        defaults_used=tuple(defaults),
        assumed=(*model.assumed.items(), *_assumed_stops(model)),
        claims={
            (part, kind): (claim.safety, claim.source)
            for part, kinds in model.claims.items()
            for kind, claim in kinds.items()
        },
    )


def _read_text(file: Path) -> str:
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        raise DesignError(file, "cannot be read", "there is no such file") from None
    except IsADirectoryError:
        raise DesignError(file, "cannot be read", "is a directory, not a design file") from None
    except OSError as error:
        raise DesignError(file, "cannot be read", str(error.strerror).lower()) from None
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise DesignError(
            file, f"line {line}", "is not UTF-8 text; save the file as UTF-8"
        ) from None
    if not text.strip():
        raise DesignError(file, "cannot be read", "the file is empty; ballesta new writes one")
    return text.replace("\r\n", "\n")


def _parse(file: Path, text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        place = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)$", message)
        what = message[: place.start()] if place else message
        if place and place[1]:
            where = f"line {place[1]}, column {place[2]}"
        else:
            where = f"line {text.count(chr(10)) + 1}, at the end"
        raise DesignError(file, where, f"is not TOML: {what}") from None


def _check_key(key: str, data: Mapping[str, Any], problems: Problems) -> None:
    here: Any = data
    for step in split_key(key) or ("",):
        in_list = isinstance(here, list) and isinstance(step, int) and step < len(here)
        if in_list or (isinstance(here, dict) and step in here):
            here = here[step]
        else:
            known = list(_keys(data, ()))
            guess = nearest(key, known)
            hint = f", did you mean {guess}?" if guess else ""
            problems.add(f"assumed.{key}", f"the design has no such key{hint}")
            return


def _keys(data: Any, way: tuple[str | int, ...]) -> Iterator[str]:
    entries = data.items() if isinstance(data, dict) else enumerate(data)
    for step, value in entries:
        if not way and step == "assumed":
            continue
        yield dotted((*way, step))
        if isinstance(value, (dict, list)):
            yield from _keys(value, (*way, step))


def _assumed_stops(model: DesignFile) -> Iterator[tuple[str, str]]:
    for name, cycle in model.cycles.items():
        key = f"cycles.{name}.stop"
        if cycle.stop is not None and cycle.stop.basis == "assumed" and key not in model.assumed:
            yield key, "nothing mechanical ends the travel there"


def _defaults(table: BaseModel, key: str) -> Iterator[tuple[str, str]]:
    """Every value that the file does not state and that is not simply absent."""
    for name, field in type(table).model_fields.items():
        value = getattr(table, name)
        here = f"{key}.{name}" if key else name
        if isinstance(value, BaseModel):
            yield from _defaults(value, here)
        elif isinstance(value, (dict, list)):
            entries = value.items() if isinstance(value, dict) else enumerate(value)
            for step, entry in entries:
                if isinstance(entry, BaseModel):
                    inner = f"[{step}]" if isinstance(step, int) else f".{step}"
                    yield from _defaults(entry, here + inner)
        elif name not in table.model_fields_set and value is not None:
            yield here, _with_unit(value, field.metadata)


def _with_unit(value: object, metadata: Sequence[object]) -> str:
    for mark in metadata:
        if isinstance(mark, Quantity) and isinstance(value, float):
            if mark.dimensions == ("fraction",):
                return f"{100 * value:g} %"
            if mark.dimensions == ("angle",):
                return f"{math.degrees(value):g} deg"
            return f"{value:.4g} {DIMENSIONS[mark.dimensions[0]].unit}"
        if isinstance(mark, Vector) and isinstance(value, tuple):
            return f"{value[0]:g}, {value[1]:g} {DIMENSIONS[mark.dimension].unit}"
    return str(value)
