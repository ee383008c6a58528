"""The door: reads a design file, refuses what cannot be meant, converts the units once.

Inside ballesta a `Design` is trusted: names exist, quantities are finite and in N, mm, s and tonne.
"""

import dataclasses
import math
import types
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, Tag, ValidationError

import loads
from ballesta.design.cycles import cycles_of, duty_of, events_of, split_cycles
from ballesta.design.files import (
    Reading,
    Sources,
    Way,
    apply_override,
    dotted,
    parse_override,
    read_design_files,
    resolve_like,
    split_key,
)
from ballesta.design.forces import cylinders_of, forces_of
from ballesta.design.linkage import (
    bodies_of,
    body_compliances,
    check_points,
    friction_of,
    ground_of,
    joint_compliances,
    joints_of,
    pins_of,
)
from ballesta.design.measured import measured_of
from ballesta.design.parts import materials_of, parts_of
from ballesta.design.plate_parts import told_of_steps
from ballesta.design.stacks import told_of_overlaps, told_of_pairs, told_of_widths
from checks.design.data import Cycle, Design, Part, StatedMass
from checks.design.errors import Problems, listed, nearest, no_such
from checks.design.model import PART_MODELS, DesignFile
from checks.design.strength import strength_defaults
from checks.design.tables import TAGS
from checks.design.units import DIMENSIONS, Quantity, Vector
from checks.result.words import brief
from geometry.parameters import GIVEN_BY_LINKAGE
from geometry.parts import SHAPES


def read_design(path: str | Path, overrides: Sequence[str] = ()) -> Design:
    """Return the design that the file states, with the overrides ("key=value") put in first.

    Raises DesignError, or DesignErrors for several problems at once, in the words of the author.
    """
    file = Path(path)
    data, sources = read_design_files(file)
    changes = [parse_override(text) for text in overrides]
    for change in changes:
        apply_override(data, change, file)
        sources.override(change.key)
    inputs = tuple(_stated(data, ()))
    problems = Problems(file, sources.file_of)
    origins = resolve_like(data, problems)
    problems.raise_if_any()
    try:
        model = DesignFile.model_validate(data)
    except ValidationError as error:
        tell_problems(error, origins, {change.key for change in changes}, problems)
        problems.raise_if_any()
        raise  # an error that pydantic does not describe is ours
    return _assembled(model, data, inputs, sources, tuple(overrides), problems)


def _assembled(
    model: DesignFile,
    data: Mapping[str, Any],
    inputs: tuple[tuple[str, str], ...],
    sources: Sources,
    overrides: tuple[str, ...],
    problems: Problems,
) -> Design:
    if not model.cycles and not model.measured:
        problems.add("cycles", "must be stated: what the machine does, such as [cycles.press]")
    check_points(model, problems)
    bodies, assembled = bodies_of(model, problems)
    pins = pins_of(model)
    joints = joints_of(model, pins, bodies, problems)
    materials = materials_of(model, problems)
    assumed = {
        key: reason
        for key, reason in model.assumed.items()
        if _is_assumed(key, data, sources, problems)
    }
    held = [name for name, value in model.drive if value is not None and name != "brake"]
    if len(held) > 1 and set(held) != {"flywheel", "motor"}:
        problems.add(
            "drive", f"states {' and '.join(held)}; one of them says how it holds its speed"
        )
    forces, available = forces_of(model, problems)
    cylinders = cylinders_of(model, forces, materials, problems)
    friction = friction_of("friction", model.friction, model, joints, problems)
    joint_compliance = joint_compliances(model, joints, problems)
    for name in model.dynamics.cushioned:
        if name not in pins:
            problems.add("dynamics.cushioned", no_such("pin", name, pins))
    cycles = cycles_of(Reading(model, sources, problems, forces, joints))
    measured = {}
    if len(bodies) == len(model.bodies):
        measured = measured_of(model, bodies, assembled, sources, problems)
    events = events_of(model, cycles, problems)
    duty = duty_of(model, problems)
    parts = parts_of(model, bodies, pins, joints, materials, sources, problems)
    for name, part in parts.items():
        if part.fkm is not None and duty.life == "finite":
            problems.add(
                f"parts.{name}.strength",
                'must be "marin" where duty.life is "finite", got "fkm": a finite life is judged '
                "by Marin's chain only",
            )
    problems.raise_if_any()
    by_key: dict[str, str | None] = {**dict(_defaults(model, "")), **dict(strength_defaults(model))}
    unused = {f"parts.{name}.bearing_arc" for name, part in parts.items() if _is_fitted(part)}
    defaults = [
        (key, value) for key, value in by_key.items() if value is not None and key not in unused
    ]
    for name, force in forces.items():
        ends = force.coordinate
        if isinstance(ends, loads.Distance) and model.forces[name].on is None:
            on = ((ends.body_a, ends.point_a), (ends.body_b, ends.point_b))
            defaults += [
                (f"forces.{name}.on", body)
                for body, point in on
                if len(pins.get(point, ())) > 1 and body in bodies
            ]
    of_parts = {part.body for part in parts.values()}
    for name, entry in model.bodies.items():
        if name not in of_parts and entry.centre is None:
            defaults.append((f"bodies.{name}.centre", f"at its first pin, {entry.pins[0]}"))
    defaults += _contact_defaults(model, cycles)
    design = Design(
        name=model.name,
        file=sources.file,
        source=sources.texts[sources.file],
        sources=tuple((str(path), text) for path, text in sources.texts.items()),
        sha256=sources.sha256,
        inputs=inputs,
        overrides=overrides,
        accuracy=model.accuracy,
        require=model.require,
        load_factor=model.load_factor,
        gravity=model.gravity,
        points=dict(model.points),
        ground=ground_of(model),
        bodies=bodies,
        assembled=assembled,
        stated_masses={
            name: StatedMass(entry.mass, entry.centre, entry.inertia)
            for name, entry in model.bodies.items()
            if name in of_parts
        },
        pins=pins,
        joints=joints,
        forces=forces,
        available=available,
        friction=friction,
        compliance=(*body_compliances(model), *joint_compliance),
        as_parts=tuple(
            name
            for name, entry in model.bodies.items()
            if entry.elastic is not None and entry.elastic.stiffness is not None
        ),
        drive=model.drive,
        dynamics=model.dynamics,
        forks=model.forks,
        cycles=cycles,
        measured=measured,
        duty=duty,
        parts=parts,
        materials={part.material.name: part.material for part in parts.values()},
        defaults_used=tuple(defaults),
        assumed=(
            *assumed.items(),
            *_assumed_stops(model),
            *_assumed_sides(model),
            *(reason for run in measured.values() for reason in run.assumed),
            *told_of_steps(parts),
            *told_of_widths(parts, model.parts),
            *told_of_pairs(parts),
            *told_of_overlaps(parts),
        ),
        events=events,
        cylinders=cylinders,
    )
    return replace(design, cycles=split_cycles(design))


def _stated(value: Any, way: tuple[str | int, ...]) -> Iterator[tuple[str, str]]:
    """Everything that is stated, as dotted key and text, but the assumptions."""
    if isinstance(value, dict):
        for key, entry in value.items():
            if way or key != "assumed":
                yield from _stated(entry, (*way, key))
    elif isinstance(value, list) and any(isinstance(entry, dict) for entry in value):
        for index, entry in enumerate(value):
            yield from _stated(entry, (*way, index))
    else:
        yield dotted(way), str(value)


def _is_assumed(key: str, data: Mapping[str, Any], sources: Sources, problems: Problems) -> bool:
    """True if the design has a key that is marked as assumed; if it never had it, a problem.

    A reason lapses with its key where a later file or an override has replaced what held the key.
    """
    here: Any = data
    for step in split_key(key) or ("",):
        in_list = isinstance(here, list) and isinstance(step, int) and step < len(here)
        if in_list or (isinstance(here, dict) and step in here):
            here = here[step]
            continue
        if not sources.replaces(f"assumed.{key}", key):
            guess = nearest(key, list(_keys(data, ())))
            hint = f", did you mean {guess}?" if guess else ""
            problems.add(f"assumed.{key}", f"the design has no such key{hint}")
        return False
    return True


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


def _assumed_sides(model: DesignFile) -> Iterator[tuple[str, str]]:
    """Bodies that take a force at a point they share with others, as no `on` names one there."""
    for name, force in model.forces.items():
        key = f"forces.{name}.on"
        for point in force.between or ():
            users = [body for body, stated in model.bodies.items() if point in stated.pins]
            shared = len(users) > 1 and point not in model.ground and force.on not in users
            if shared and key not in model.assumed:
                yield (
                    key,
                    f"{users[0]} takes its force at {point}, as the first of {', '.join(users)} in "
                    "the file; what they pass on through the pin there depends on it",
                )


def _is_fitted(part: Part) -> bool:
    """True if the fit of every pin in a part's bores is stated, so that no arc is assumed."""
    if not part.clearances:
        return False
    round_ones = [f for f in part.geometry.placed_interfaces if f.kind in ("bore", "journal")]
    return all(face.name in part.clearances for face in round_ones)


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


def _contact_defaults(model: DesignFile, cycles: Mapping[str, Cycle]) -> Iterator[tuple[str, str]]:
    for name, cycle in cycles.items():
        for index, phase in enumerate(model.cycles[name].phases):
            for force, entry in phase.forces.items():
                law = cycle.run.phases[index].given[force]
                if not isinstance(law, loads.Contact):
                    continue
                assert isinstance(entry, BaseModel)
                key = f"cycles.{name}.phases[{index}].forces.{force}"
                if "stops" not in entry.model_fields_set:
                    yield f"{key}.stops", str(law.stops).lower()
                if law.stiffness is None:
                    yield f"{key}.stiffness", "rigid"


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


# Says what pydantic found wrong with a design file in the words of the file's author.


def tell_problems(
    error: ValidationError, origins: dict[Way, Way], overridden: set[str], problems: Problems
) -> None:
    """Add each of pydantic's errors to the problems, at the key where the value is written.

    A key that is missing because it is misspelt has one problem, where it is written.
    """
    errors = error.errors(include_url=False)
    meant = {
        (*detail["loc"][:-1], _guess(detail["loc"]))
        for detail in errors
        if detail["type"] == "extra_forbidden"
    }
    for detail in errors:
        raw: Way = detail["loc"]
        if detail["type"] == "missing" and raw in meant:
            continue
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
    if kind in ("less_than", "less_than_equal"):
        word, bound = ("below", "lt") if kind == "less_than" else ("at most", "le")
        return f"must be {word} {context[bound]:g}, got {shown}"
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
    guess = _guess(way)
    hint = f"did you mean {guess}?" if guess else f"there are {listed(_known_keys(way))}"
    return f"unknown key, {hint}"


def _guess(way: Way) -> str | None:
    """The key that an unknown one is nearest to, if one is near."""
    return nearest(str(way[-1]), _known_keys(way))


def _known_keys(way: Way) -> list[str]:
    model = _model_at(way[:-1])
    return list(model.model_fields) if model else []


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
        elif get_origin(here) is dict:  # the name may be that of a shape
            here = get_args(here)[-1]
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
