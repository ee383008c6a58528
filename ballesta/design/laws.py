"""Puts the laws of the forces in a phase together."""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from itertools import islice, pairwise

import loads
from ballesta.design.expressions import coordinate_of, dimension_along, expression_of
from ballesta.design.files import Sources
from ballesta.design.forces import dimension_of, wrong_dimension
from ballesta.design.measured import MOST_ROWS
from checks.design.errors import DesignError, Problems
from checks.design.model import DesignFile
from checks.design.tables import (
    ContactLaw,
    ExpressionLaw,
    ForceEntry,
    OpposingLaw,
    PistonLaw,
    TableLaw,
)
from checks.design.units import DIMENSIONS, Measured, measure
from checks.result.words import brief

_EXAMPLES = {
    "force": 'over = "A.y", at = ["0 mm", "5 mm"], force = ["0 N", "80 N"]',
    "pressure": 'over = "A.y", at = ["0 mm", "5 mm"], pressure = ["0 bar", "6 bar"]',
}


def law_of(
    key: str,
    force: str,
    entry: Measured | TableLaw | PistonLaw | ExpressionLaw | OpposingLaw | ContactLaw,
    file: DesignFile,
    forces: Mapping[str, loads.Force],
    sources: Sources,
    problems: Problems,
) -> loads.Law | None:
    """Return the law of a force in a phase, None where a problem was told."""
    stated = file.forces[force]
    if isinstance(entry, Measured):
        return _value(key, force, entry, stated, problems)
    if isinstance(entry, ContactLaw):
        return _contact(key, forces[force], entry, file, problems) if force in forces else None
    if isinstance(entry, OpposingLaw):
        return _opposing(key, force, entry, stated, problems)
    if isinstance(entry, ExpressionLaw):
        return expression_of(key, force, entry, file, forces, problems)
    if isinstance(entry, PistonLaw):
        return _piston(key, force, entry, file, forces, sources, problems)
    return _table(key, force, entry, file, forces, sources, problems)


def _value(
    key: str, force: str, value: Measured, stated: ForceEntry, problems: Problems
) -> float | None:
    wanted = dimension_of(stated)
    if value.dimension != wanted:
        kind = "a torque" if wanted == "moment" else "a force"
        problems.add(key, wrong_dimension(value, wanted, f"{force} is {kind}"))
        return None
    return value.value


def _contact(
    key: str, force: loads.Force, entry: ContactLaw, file: DesignFile, problems: Problems
) -> loads.Contact | None:
    own = force.coordinate
    direction = own.direction if isinstance(own, loads.PointCoordinate) else (1.0, 0.0)
    follows = file.forces[force.name].follows
    if own.angular or follows or all(direction):
        what = "is a torque" if own.angular else "pushes askew"
        if follows:
            what = f"turns with {follows}"
        problems.add(
            key, f"a contact needs a force along x or y, or between two points; {force.name} {what}"
        )
        return None
    if entry.touches.strip() != (wanted := own.label.removeprefix("-")):
        problems.add(
            f"{key}.touches",
            f'must be "{wanted}", the coordinate along which {force.name} pushes, '
            f'got "{entry.touches}"',
        )
        return None
    if entry.at.dimension != "length":
        kind = DIMENSIONS["length"]
        problems.add(
            f"{key}.at",
            f'must be {kind.title} such as "{kind.example}", '
            f"got {DIMENSIONS[entry.at.dimension].title}",
        )
        return None
    gives = file.elastic.joints or any(body.elastic for body in file.bodies.values())
    if entry.stiffness is None and not gives:
        problems.add(
            f"{key}.stiffness",
            'must be stated such as "80 kN/mm": where nothing gives way the force has no size; or '
            "let a body or joint give way: bodies.<body>.elastic, elastic.joints.<joint>",
        )
        return None
    apart = isinstance(own, loads.Distance)
    if entry.stops and apart:
        problems.add(
            f"{key}.stops", "holds a body on a line only, not two points apart; leave it out"
        )
        return None
    stops = entry.stops if entry.stops is not None else not apart
    # along its own direction, a force that points down has the coordinate -y; between two points
    # the contact pushes them apart when they come closer than `at`
    place = sum(direction) * entry.at.value
    struck = None if entry.blow is None else _struck(f"{key}.blow", entry, problems)
    return loads.Contact(place, entry.stiffness, 1, stops, entry.restitution, struck)


def _struck(key: str, entry: ContactLaw, problems: Problems) -> loads.Struck | None:
    assert entry.blow is not None
    stated = entry.blow
    if stated.stiffness is None and stated.yields is None:
        problems.add(
            key, 'needs yields such as "30 kN" or stiffness such as "80 kN/mm": what gives way'
        )
        return None
    if entry.restitution is not None:
        problems.add(f"{key[:-5]}.restitution", "follows from the blow; leave it out")
        return None
    anvil = stated.anvil
    return loads.Struck(
        stated.stiffness or math.inf,
        stated.yields or math.inf,
        anvil.mass if anvil else 0.0,
        anvil.stiffness if anvil else 0.0,
    )


def _opposing(
    key: str, force: str, entry: OpposingLaw, stated: ForceEntry, problems: Problems
) -> loads.Opposing | None:
    told = len(problems)
    turns = stated.turns is not None
    kind = "a torque" if turns else "a force"

    def in_order(field: str, values: Sequence[Measured], wanted: str) -> tuple[float, ...]:
        for value in values:
            if value.dimension != wanted:
                problems.add(f"{key}.{field}", wrong_dimension(value, wanted, f"{force} is {kind}"))
                break
        return tuple(value.value for value in values)

    sizes = [entry.dry] if entry.dry is not None else []
    dampings = [entry.viscous] if entry.viscous is not None else []
    tabled = entry.at_speed is not None or entry.resistance is not None
    if tabled and (sizes or dampings):
        problems.add(key, "is either dry and viscous, or at_speed with resistance")
        return None
    dry = in_order("dry", sizes, dimension_of(stated))
    viscous = in_order("viscous", dampings, "turning damping" if turns else "damping")
    if not tabled:
        return loads.Opposing(sum(dry), sum(viscous)) if len(problems) == told else None
    if entry.at_speed is None or entry.resistance is None:
        missing = "at_speed" if entry.at_speed is None else "resistance"
        problems.add(f"{key}.{missing}", "must be stated beside the other column of the table")
        return None
    speeds = in_order("at_speed", entry.at_speed, "angular speed" if turns else "speed")
    resistances = in_order("resistance", entry.resistance, dimension_of(stated))
    if len(problems) > told:
        return None
    try:
        return loads.Opposing(speeds=speeds, forces=resistances)
    except loads.LinkageError as error:
        problems.add(f"{key}.at_speed", str(error))
        return None


def _piston(
    key: str,
    force: str,
    entry: PistonLaw,
    file: DesignFile,
    forces: Mapping[str, loads.Force],
    sources: Sources,
    problems: Problems,
) -> loads.Law | None:
    """Return the pressure times the area of the piston, or of the ring around its rod."""
    if file.forces[force].turns is not None:
        problems.add(key, f"{force} is a torque, and a piston pushes")
        return None
    rod = entry.rod or 0.0
    if rod >= entry.bore:
        problems.add(
            f"{key}.rod", f"must be thinner than the bore of {entry.bore:g} mm, got {rod:g} mm"
        )
        return None
    area = math.pi / 4.0 * (entry.bore**2 - rod**2)
    if isinstance(entry.pressure, float):
        for field in ("over", "at", "table", "units"):
            if getattr(entry, field) is not None:
                problems.add(f"{key}.{field}", "is of a table; one pressure is the same everywhere")
                return None
        return area * entry.pressure
    pressures = entry.pressure
    stated = None if pressures is None else [Measured(value, "stress") for value in pressures]
    columns = _columns(key, entry, "pressure", stated, sources, problems)
    if columns is None:
        return None
    sizes = [Measured(area * value.value, "force") for value in columns[1]]
    return _tabled(key, force, entry, (columns[0], sizes), "pressure", file, forces, problems)


def _table(
    key: str,
    force: str,
    entry: TableLaw,
    file: DesignFile,
    forces: Mapping[str, loads.Force],
    sources: Sources,
    problems: Problems,
) -> loads.Table | None:
    columns = _columns(key, entry, "force", entry.force, sources, problems)
    if columns is None:
        return None
    return _tabled(key, force, entry, columns, "force", file, forces, problems)


def _columns(
    key: str,
    entry: TableLaw | PistonLaw,
    second: str,
    sizes: Sequence[Measured] | None,
    sources: Sources,
    problems: Problems,
) -> tuple[list[Measured], list[Measured]] | None:
    """Return values and forces, or pressures, of a table; second names the key of the latter."""
    if entry.table is not None:
        for field, there in (("at", entry.at), (second, sizes)):
            if there is not None:
                problems.add(f"{key}.{field}", "is in the file of table; leave one out")
                return None
        kinds = ("force", "moment") if second == "force" else ("stress",)
        return _from_csv(key, entry, kinds, sources, problems)
    if entry.at is None or sizes is None:
        missing = "at" if entry.at is None else second
        problems.add(
            f"{key}.{missing}", f"must be stated, such as {_EXAMPLES[second]}, or table a file"
        )
        return None
    if entry.units is not None:
        problems.add(f"{key}.units", "is only used with table; leave it out")
    return list(entry.at), list(sizes)


def _tabled(
    key: str,
    force: str,
    entry: TableLaw | PistonLaw,
    columns: tuple[list[Measured], list[Measured]],
    second: str,
    file: DesignFile,
    forces: Mapping[str, loads.Force],
    problems: Problems,
) -> loads.Table | None:
    """Return the table of a force over the coordinate that its entry names."""
    stated = file.forces[force]
    if entry.over is None:
        problems.add(f"{key}.over", 'must be stated, such as "crank.angle": the table is over it')
        return None
    over = coordinate_of(f"{key}.over", entry.over, file, forces, problems)
    if over is None:
        return None
    values, sizes = columns
    place = key if entry.table is None else f"{key}.table"
    fields = ("at", second) if entry.table is None else ("table", "table")
    if len(values) != len(sizes) or len(values) < 2:
        problems.add(
            place,
            f"needs as many {second}s as values and at least two, got "
            f"{len(values)} values and {len(sizes)} {second}s",
        )
        return None
    kind = dimension_along(over)
    checks = (
        (fields[0], values, kind, f"{over.label} is {DIMENSIONS[kind].title}"),
        (
            fields[1],
            sizes,
            dimension_of(stated),
            f"{force} is a {'torque' if stated.turns is not None else 'force'}",
        ),
    )
    right = True
    for field, column, wanted, why in checks:
        wrong = next((value for value in column if value.dimension != wanted), None)
        if wrong is not None:
            problems.add(f"{key}.{field}", wrong_dimension(wrong, wanted, why))
            right = False
    return _rising(f"{key}.{fields[0]}", over, values, sizes, problems) if right else None


def _rising(
    key: str,
    over: loads.Coordinate,
    values: Sequence[Measured],
    forces: Sequence[Measured],
    problems: Problems,
) -> loads.Table | None:
    for before, after in pairwise(value.value for value in values):
        if after <= before:
            first, second = (math.degrees(v) if over.angular else v for v in (before, after))
            unit = "deg" if over.angular else "mm"
            problems.add(key, f"must rise, got {first:g} {unit} and then {second:g} {unit}")
            return None
    return loads.Table(over, tuple(v.value for v in values), tuple(f.value for f in forces))


def _from_csv(
    key: str,
    entry: TableLaw | PistonLaw,
    kinds: tuple[str, ...],
    sources: Sources,
    problems: Problems,
) -> tuple[list[Measured], list[Measured]] | None:
    """Read the two columns of a CSV file; a first line of words is passed over."""
    assert entry.table is not None
    if entry.units is None:
        problems.add(
            f"{key}.units", 'must be stated beside table, for its two columns, such as ["mm", "N"]'
        )
        return None
    try:
        text = sources.read_beside(f"{key}.table", entry.table)
    except DesignError as error:
        problems.take(error)
        return None
    columns: tuple[list[Measured], list[Measured]] = ([], [])
    accepted = (("length", "angle"), kinds)
    delimiter = next((mark for mark in ";\t" if mark in text), ",")
    try:
        reader = csv.reader(io.StringIO(text), delimiter=delimiter)
        rows = list(islice(reader, MOST_ROWS + 2))
    except csv.Error as error:
        problems.add(f"{key}.table", f"{entry.table}: is not CSV: {error}")
        return None
    if len(rows) > MOST_ROWS + 1:
        told = f"has more than {MOST_ROWS} rows; resample it"
        problems.add(f"{key}.table", f"{entry.table}: {told}")
        return None
    for number, row in enumerate(rows, start=1):
        cells = [cell.strip() for cell in row]
        if not any(cells) or (number == 1 and not any(map(_is_number, cells))):
            continue
        where = f"{entry.table}, line {number}: "
        if len(cells) != 2:
            problems.add(f"{key}.table", f"{where}needs two columns, got {len(cells)}")
            return None
        for index, cell in enumerate(cells):
            if not _is_number(cell):
                hint = "; decimals are written with a point" if "," in cell else ""
                problems.add(f"{key}.table", f'{where}must be a number, got "{brief(cell)}"{hint}')
                return None
            try:
                columns[index].append(measure(f"{cell} {entry.units[index]}", *accepted[index]))
            except ValueError as error:
                problems.add(f"{key}.units[{index}]", f"{where}{error}")
                return None
    return columns


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
