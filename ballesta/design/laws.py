"""Puts the laws of the forces in a phase together."""

import csv
import io
import math
from collections.abc import Sequence
from itertools import islice, pairwise

import loads
from ballesta.design.expressions import coordinate_of, dimension_along, expression_of
from ballesta.design.files import Reading, telling
from ballesta.design.forces import check_dimension, dimension_of, wrong_dimension
from ballesta.design.measured import MOST_ROWS
from checks.design.errors import Problems
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
from geometry.parameters import ParameterError

_EXAMPLES = {
    "force": 'over = "A.y", at = ["0 mm", "5 mm"], force = ["0 N", "80 N"]',
    "pressure": 'over = "A.y", at = ["0 mm", "5 mm"], pressure = ["0 bar", "6 bar"]',
}


def law_of(
    read: Reading,
    key: str,
    force: str,
    entry: Measured | TableLaw | PistonLaw | ExpressionLaw | OpposingLaw | ContactLaw,
) -> loads.Law | None:
    """Return the law of a force in a phase, None where a problem was told."""
    stated = read.file.forces[force]
    with telling(read.problems, key):
        if isinstance(entry, Measured):
            return _value(force, entry, stated)
        if isinstance(entry, ContactLaw):
            return _contact(read, read.forces[force], entry) if force in read.forces else None
        if isinstance(entry, OpposingLaw):
            return _opposing(read.problems, key, force, entry, stated)
        if isinstance(entry, ExpressionLaw):
            return expression_of(read, key, force, entry)
        if isinstance(entry, PistonLaw):
            return _piston(read, key, force, entry)
        columns = _columns(read, key, entry, "force", entry.force)
        return _tabled(read, key, force, entry, columns, "force")
    return None


def _value(force: str, value: Measured, stated: ForceEntry) -> float:
    wanted = dimension_of(stated)
    if value.dimension != wanted:
        kind = "a torque" if wanted == "moment" else "a force"
        raise ParameterError("", wrong_dimension(value, wanted, f"{force} is {kind}"))
    return value.value


def _contact(read: Reading, force: loads.Force, entry: ContactLaw) -> loads.Contact:
    own, file = force.coordinate, read.file
    direction = own.direction if isinstance(own, loads.PointCoordinate) else (1.0, 0.0)
    follows = file.forces[force.name].follows
    if own.angular or follows or all(direction):
        what = "is a torque" if own.angular else "pushes askew"
        if follows:
            what = f"turns with {follows}"
        raise ParameterError(
            "",
            f"a contact needs a force along x or y, or between two points; {force.name} {what}",
        )
    if entry.touches.strip() != (wanted := own.label.removeprefix("-")):
        raise ParameterError(
            "touches",
            f'must be "{wanted}", the coordinate along which {force.name} pushes, '
            f'got "{entry.touches}"',
        )
    check_dimension("at", entry.at, "length")
    gives = file.elastic.joints or any(body.elastic for body in file.bodies.values())
    if entry.stiffness is None and not gives:
        raise ParameterError(
            "stiffness",
            'must be stated such as "80 kN/mm": where nothing gives way the force has no size; or '
            "let a body or joint give way: bodies.<body>.elastic, elastic.joints.<joint>",
        )
    apart = isinstance(own, loads.Distance)
    if entry.stops and apart:
        raise ParameterError(
            "stops", "holds a body on a line only, not two points apart; leave it out"
        )
    stops = entry.stops if entry.stops is not None else not apart
    # along its own direction, a force that points down has the coordinate -y; between two points
    # the contact pushes them apart when they come closer than `at`
    place = sum(direction) * entry.at.value
    struck = None if entry.blow is None else _struck(entry)
    return loads.Contact(place, entry.stiffness, 1, stops, entry.restitution, struck)


def _struck(entry: ContactLaw) -> loads.Struck:
    assert entry.blow is not None
    stated = entry.blow
    if stated.stiffness is None and stated.yields is None:
        raise ParameterError(
            "blow", 'needs yields such as "30 kN" or stiffness such as "80 kN/mm": what gives way'
        )
    if entry.restitution is not None:
        raise ParameterError("restitution", "follows from the blow; leave it out")
    anvil = stated.anvil
    return loads.Struck(
        stated.stiffness or math.inf,
        stated.yields or math.inf,
        anvil.mass if anvil else 0.0,
        anvil.stiffness if anvil else 0.0,
    )


def _opposing(
    problems: Problems, key: str, force: str, entry: OpposingLaw, stated: ForceEntry
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
        raise ParameterError("", "is either dry and viscous, or at_speed with resistance")
    dry = in_order("dry", sizes, dimension_of(stated))
    viscous = in_order("viscous", dampings, "turning damping" if turns else "damping")
    if not tabled:
        return loads.Opposing(sum(dry), sum(viscous)) if len(problems) == told else None
    if entry.at_speed is None or entry.resistance is None:
        missing = "at_speed" if entry.at_speed is None else "resistance"
        raise ParameterError(missing, "must be stated beside the other column of the table")
    speeds = in_order("at_speed", entry.at_speed, "angular speed" if turns else "speed")
    resistances = in_order("resistance", entry.resistance, dimension_of(stated))
    if len(problems) > told:
        return None
    try:
        return loads.Opposing(speeds=speeds, forces=resistances)
    except loads.LinkageError as error:
        raise ParameterError("at_speed", str(error)) from error


def _piston(read: Reading, key: str, force: str, entry: PistonLaw) -> loads.Law | None:
    """Return the pressure times the area of the piston, or of the ring around its rod.

    Between two points the whole piston pushes, below 0, and the ring pulls.
    """
    if read.file.forces[force].turns is not None:
        raise ParameterError("", f"{force} is a torque, and a piston pushes")
    rod = entry.rod or 0.0
    if rod >= entry.bore:
        raise ParameterError(
            "rod", f"must be thinner than the bore of {entry.bore:g} mm, got {rod:g} mm"
        )
    apart = not rod and read.file.forces[force].between is not None
    area = math.pi / 4.0 * (entry.bore**2 - rod**2) * (-1.0 if apart else 1.0)
    if isinstance(entry.pressure, float):
        for field in ("over", "at", "table", "units"):
            if getattr(entry, field) is not None:
                raise ParameterError(field, "is of a table; one pressure is the same everywhere")
        return area * entry.pressure + 0.0
    pressures = entry.pressure
    stated = None if pressures is None else [Measured(value, "stress") for value in pressures]
    values, found = _columns(read, key, entry, "pressure", stated)
    sizes = [Measured(area * value.value + 0.0, "force") for value in found]  # never -0
    return _tabled(read, key, force, entry, (values, sizes), "pressure")


def _columns(
    read: Reading,
    key: str,
    entry: TableLaw | PistonLaw,
    second: str,
    sizes: Sequence[Measured] | None,
) -> tuple[list[Measured], list[Measured]]:
    """Return values and forces, or pressures, of a table; second names the key of the latter."""
    if entry.table is not None:
        for field, there in (("at", entry.at), (second, sizes)):
            if there is not None:
                raise ParameterError(field, "is in the file of table; leave one out")
        return _from_csv(
            read, key, entry, ("force", "moment") if second == "force" else ("stress",)
        )
    if entry.at is None or sizes is None:
        raise ParameterError(
            "at" if entry.at is None else second,
            f"must be stated, such as {_EXAMPLES[second]}, or table a file",
        )
    if entry.units is not None:
        read.problems.add(f"{key}.units", "is only used with table; leave it out")
    return list(entry.at), list(sizes)


def _tabled(
    read: Reading,
    key: str,
    force: str,
    entry: TableLaw | PistonLaw,
    columns: tuple[list[Measured], list[Measured]],
    second: str,
) -> loads.Table | None:
    """Return the table of a force over the coordinate that its entry names."""
    stated = read.file.forces[force]
    if entry.over is None:
        raise ParameterError("over", 'must be stated, such as "crank.angle": the table is over it')
    try:
        over = coordinate_of(read, entry.over)
    except ParameterError as error:
        raise ParameterError("over", error.problem) from error
    values, sizes = columns
    fields = ("at", second) if entry.table is None else ("table", "table")
    if len(values) != len(sizes) or len(values) < 2:
        raise ParameterError(
            "" if entry.table is None else "table",
            f"needs as many {second}s as values and at least two, got "
            f"{len(values)} values and {len(sizes)} {second}s",
        )
    kind = dimension_along(over)
    what = f"{force} is a {'torque' if stated.turns is not None else 'force'}"
    right = True
    for field, column, wanted, why in (
        (fields[0], values, kind, f"{over.label} is {DIMENSIONS[kind].title}"),
        (fields[1], sizes, dimension_of(stated), what),
    ):
        wrong = next((value for value in column if value.dimension != wanted), None)
        if wrong is not None:
            read.problems.add(f"{key}.{field}", wrong_dimension(wrong, wanted, why))
            right = False
    for before, after in pairwise(value.value for value in values if right):
        if after <= before:
            first, later = (math.degrees(v) if over.angular else v for v in (before, after))
            unit = "deg" if over.angular else "mm"
            raise ParameterError(
                fields[0], f"must rise, got {first:g} {unit} and then {later:g} {unit}"
            )
    if not right:
        return None
    return loads.Table(over, tuple(v.value for v in values), tuple(f.value for f in sizes))


def _from_csv(
    read: Reading, key: str, entry: TableLaw | PistonLaw, kinds: tuple[str, ...]
) -> tuple[list[Measured], list[Measured]]:
    """Read the two columns of a CSV file; a first line of words is passed over."""
    assert entry.table is not None
    if entry.units is None:
        raise ParameterError(
            "units", 'must be stated beside table, for its two columns, such as ["mm", "N"]'
        )
    text = read.sources.read_beside(f"{key}.table", entry.table)
    columns: tuple[list[Measured], list[Measured]] = ([], [])
    accepted = (("length", "angle"), kinds)
    delimiter = next((mark for mark in ";\t" if mark in text), ",")
    try:
        rows = list(islice(csv.reader(io.StringIO(text), delimiter=delimiter), MOST_ROWS + 2))
    except csv.Error as error:
        raise ParameterError("table", f"{entry.table}: is not CSV: {error}") from error
    if len(rows) > MOST_ROWS + 1:
        told = f"has more than {MOST_ROWS} rows; resample it"
        raise ParameterError("table", f"{entry.table}: {told}")
    for number, row in enumerate(rows, start=1):
        cells = [cell.strip() for cell in row]
        if not any(cells) or (number == 1 and not any(map(_is_number, cells))):
            continue
        where = f"{entry.table}, line {number}: "
        if len(cells) != 2:
            raise ParameterError("table", f"{where}needs two columns, got {len(cells)}")
        for index, cell in enumerate(cells):
            if not _is_number(cell):
                hint = "; decimals are written with a point" if "," in cell else ""
                raise ParameterError("table", f'{where}must be a number, got "{brief(cell)}"{hint}')
            try:
                columns[index].append(measure(f"{cell} {entry.units[index]}", *accepted[index]))
            except ValueError as error:
                raise ParameterError(f"units[{index}]", f"{where}{error}") from error
    return columns


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
