"""Reads the loads of a measured run from its file, in ballesta's units, as they act on bodies."""

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass

import numpy as np

import loads
from ballesta.design.files import Sources
from checks.design.data import MeasuredRun, Pair
from checks.design.errors import DesignError, Problems, listed, no_such
from checks.design.file_entries import MeasuredBodyEntry, MeasuredEntry
from checks.design.model import DesignFile
from checks.design.units import MOST, Measured
from geometry.mesh import FloatArray

# Named columns of numbers in a text file, as measuring and simulation programs write them.

_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
_MARKS = {";": "semicolons", "\t": "tabs", ",": "commas"}
_MOST_NAMES = 30
MOST_ROWS = 20_000  # as many positions as a cycle may have


class ColumnsError(ValueError):
    """A file that has no columns of numbers, or not those asked for; says the line."""


@dataclass(frozen=True)
class Columns:
    """The cells of a file by column, as text.

    lines  number of the line in the file that each row stands in
    """

    names: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]

    def numbers(self, name: str) -> FloatArray:
        """Return a column; raises ColumnsError where it is missing or not all finite numbers."""
        where = [k for k, known in enumerate(self.names) if known == name]
        if not where:
            raise ColumnsError(no_such("column", name, self.names[:_MOST_NAMES]))
        if len(where) > 1:
            places = listed(str(k + 1) for k in where)
            raise ColumnsError(f"{len(where)} columns are named {name!r}: {places}; rename them")
        return np.array(
            [
                _number(row[where[0]], line, name)
                for row, line in zip(self.rows, self.lines, strict=True)
            ]
        )


def read_columns(text: str) -> Columns:
    """Return the columns of a text: names in the first line, then at least two rows of numbers.

    Cells are parted by semicolons, tabs or commas, whichever the first line has, in this order.
    """
    text = text.removeprefix("\ufeff")
    if not text.strip():
        raise ColumnsError("the file is empty; its first line must name the columns")
    if "\0" in text:
        raise ColumnsError("is not text (it may be UTF-16); save the file as UTF-8")
    first = next(line for line in text.splitlines() if line.strip())
    mark = next((mark for mark in _MARKS if mark in first), ",")
    reader = csv.reader(io.StringIO(text), delimiter=mark)
    table: list[tuple[int, tuple[str, ...]]] = []
    try:
        for found in reader:
            cells = tuple(cell.strip() for cell in found)
            if any(cells):
                table.append((reader.line_num, cells))
            if len(table) > 1 + MOST_ROWS:
                raise ColumnsError(f"has more than {MOST_ROWS} rows of numbers; resample it")
    except csv.Error as error:
        raise ColumnsError(f"line {reader.line_num}: is not CSV: {error}") from None
    (line, names), *rows = table
    if all(_is_number(name) for name in names if name):
        raise ColumnsError(
            f"line {line}: must name the columns, got numbers: {listed(names[:_MOST_NAMES])}"
        )
    for line, row in rows:
        if len(row) != len(names):
            raise ColumnsError(_uneven(line, row, names, mark))
    if len(rows) < 2:
        count = "one row" if rows else "no row"
        raise ColumnsError(f"has {count} of numbers under the names; at least two are needed")
    return Columns(names, tuple(row for _, row in rows), tuple(line for line, _ in rows))


def _uneven(line: int, row: Sequence[str], names: Sequence[str], mark: str) -> str:
    said = f"line {line}: has {len(row)} cells, the first line names {len(names)} columns"
    if mark == "," and len(row) > len(names):
        return f"{said}; are these decimal commas? Decimals are written with a point"
    other = next((other for other in _MARKS if other != mark and other in "".join(row)), None)
    if len(row) == 1 and other:
        return f"{said} parted by {_MARKS[mark]}; this line is parted by {_MARKS[other]}"
    return said


def _number(cell: str, line: int, name: str) -> float:
    here = f"line {line}, column {name!r}"
    try:
        if "_" in cell:  # Python would take 1_000
            raise ValueError
        value = float(cell)
    except ValueError:
        if not cell:
            raise ColumnsError(f"{here}: is empty, a number is needed") from None
        if _DECIMAL_COMMA.fullmatch(cell):
            raise ColumnsError(
                f'{here}: "{cell}" has a decimal comma; decimals are written with a point'
            ) from None
        hint = "; units stand in the design, not in the file" if line == 2 else ""
        raise ColumnsError(f'{here}: must be a number, got "{cell[:40]}"{hint}') from None
    if not abs(value) <= MOST:
        raise ColumnsError(
            f'{here}: must be a finite number, got "{cell[:40]}"; at most {MOST:g} is taken'
        )
    return value


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", ".", 1))
    except ValueError:
        return False
    return True


# The loads of a run.


def measured_of(
    file: DesignFile,
    bodies: Mapping[str, loads.Body],
    assembled: Mapping[str, loads.Pose],
    sources: Sources,
    problems: Problems,
) -> dict[str, MeasuredRun]:
    """Return the measured runs whose entries and files are in order."""
    guided = {name for name in bodies if file.bodies[name].guide is not None}
    angles = {name: pose[2] for name, pose in assembled.items()}
    runs = {}
    for name, entry in file.measured.items():
        if name in file.cycles:
            problems.add(f"measured.{name}", "there is a cycle of that name; rename one of them")
        key = f"measured.{name}.loads"
        try:
            columns = read_columns(sources.read_beside(key, entry.loads))
        except ColumnsError as error:
            problems.add(key, f"{entry.loads}: {error}")
            continue
        except DesignError as error:
            problems.take(error)
            continue
        key = f"measured.{name}"
        reader = _Reader(key, entry, columns, bodies, angles, guided, file.gravity, problems)
        run = reader.run(name)
        if run is not None:
            runs[name] = run
    return runs


@dataclass
class _Reader:
    """Reads one run; whatever is wrong goes to the problems, and zeros stand in for it.

    angles  rad, of the assembled bodies
    guided  bodies that a guide holds at their angle
    """

    key: str
    entry: MeasuredEntry
    columns: Columns
    bodies: Mapping[str, loads.Body]
    angles: Mapping[str, float]
    guided: Set[str]
    gravity: Pair
    problems: Problems
    sound: bool = True

    def run(self, name: str) -> MeasuredRun | None:
        position = self.entry.position
        positions = self._column("position.column", position.column, position.unit)
        if self.sound and np.ptp(positions) == 0.0:
            self._tell("position.column", f"{position.column!r} is the same in every row")
        times = self._times()
        read, assumed = {}, []
        for body, entry in self.entry.bodies.items():
            if body not in self.bodies:
                self._tell(f"bodies.{body}", no_such("body", body, self.bodies))
                continue
            read[body] = self._body(self.bodies[body], entry)
            assumed += self._assumed(self.bodies[body], entry, read[body])
        if not self.sound:
            return None
        shown = {"angle": "deg", "length": "mm", "time": "s"}[position.unit.dimension]
        return MeasuredRun(
            name=name,
            file=self.entry.loads,
            tolerance=self.entry.tolerance,
            loads=loads.MeasuredLoads(
                name=name,
                positions=positions,
                times=times,
                bodies=read,
                gravity=self.gravity,
                position_name=position.name or position.column,
                position_unit=shown,
            ),
            assumed=tuple(assumed),
        )

    def _tell(self, key: str, problem: str) -> None:
        self.sound = False
        self.problems.add(f"{self.key}.{key}", problem)

    def _column(self, key: str, name: str, unit: Measured) -> FloatArray:
        try:
            return self.columns.numbers(name) * unit.value
        except ColumnsError as error:
            self._tell(key, f"{self.entry.loads}: {error}")
            return np.zeros(len(self.columns.rows))

    def _pair(self, key: str, names: list[str], unit: Measured) -> FloatArray:
        if names[0] == names[1]:
            self._tell(f"{key}.columns", f"{names[0]!r} is named twice")
        return np.column_stack(
            [self._column(f"{key}.columns[{k}]", name, unit) for k, name in enumerate(names)]
        )

    def _times(self) -> FloatArray | None:
        entry = self.entry.time
        if entry is None:
            return None
        times = self._column("time.column", entry.column, entry.unit)
        back = np.flatnonzero(np.diff(times) < 0)
        if len(back):
            line = self.columns.lines[int(back[0]) + 1]
            self._tell("time.column", f"{self.entry.loads}: line {line}: time runs backwards")
        return np.asarray(times - times[0])

    def _body(self, body: loads.Body, entry: MeasuredBodyEntry) -> loads.MeasuredBody:
        key, n = f"bodies.{body.name}", len(self.columns.rows)
        point_loads = []
        for point, at in entry.at.items():
            here = f"{key}.at.{point}"
            if point not in body.points:
                known = no_such(f"point of body {body.name}", point, body.points)
                self._tell(here, known)
                continue
            if at.force is None and at.moment is None:
                self._tell(here, "needs a force, a moment or both")
            force, moment, frame = np.zeros((n, 2)), np.zeros(n), "ground"
            if at.force is not None:
                force = self._pair(f"{here}.force", at.force.columns, at.force.unit)
                force, frame = force * at.force.sign, at.force.frame
            if at.moment is not None:
                moment = self._column(f"{here}.moment.column", at.moment.column, at.moment.unit)
                moment = moment * at.moment.sign
            point_loads.append(loads.MeasuredLoad(point, force, moment, frame == "body"))
        acceleration = np.zeros((n, 2))
        if entry.acceleration is not None:
            stated = entry.acceleration
            acceleration = self._pair(f"{key}.acceleration", stated.columns, stated.unit)
        spin, turn = np.zeros(n), np.zeros(n)
        if entry.angular_velocity is not None:
            where = f"{key}.angular_velocity.column"
            spin = self._column(where, entry.angular_velocity.column, entry.angular_velocity.unit)
        if entry.angular_acceleration is not None:
            where, stated_turn = f"{key}.angular_acceleration.column", entry.angular_acceleration
            turn = self._column(where, stated_turn.column, stated_turn.unit)
        return loads.MeasuredBody(
            body=loads.Body(body.name, body.points),
            loads=tuple(point_loads),
            angle=self._angle(body, entry),
            acceleration=acceleration,
            angular_velocity=spin,
            angular_acceleration=turn,
            acceleration_in_body_frame=entry.acceleration is not None
            and entry.acceleration.frame == "body",
        )

    def _angle(self, body: loads.Body, entry: MeasuredBodyEntry) -> FloatArray:
        """The stated angle (n,), rad; the assembled body's own where none is stated."""
        key, n, stated = f"bodies.{body.name}.angle", len(self.columns.rows), entry.angle
        if stated is None:
            frames = [at.force.frame for at in entry.at.values() if at.force is not None]
            frames += [entry.acceleration.frame] if entry.acceleration is not None else []
            if body.name not in self.guided and ("ground" in frames or self.gravity != (0.0, 0.0)):
                why = "loads are" if "ground" in frames else "gravity is"
                self._tell(
                    key,
                    f"must be stated, {why} in the ground frame: "
                    '{ column = "theta", unit = "deg" }, or { constant = "30 deg" }',
                )
            return np.full(n, self.angles[body.name])
        if stated.constant is not None:
            if stated.column is not None or stated.unit is not None:
                self._tell(key, "needs either column and unit, or constant")
            return np.full(n, stated.constant)
        if stated.column is None or stated.unit is None:
            self._tell(key, "needs column and unit, or constant")
            return np.zeros(n)
        return self._column(f"{key}.column", stated.column, stated.unit)

    def _assumed(
        self, body: loads.Body, entry: MeasuredBodyEntry, read: loads.MeasuredBody
    ) -> list[tuple[str, str]]:
        key = f"{self.key}.bodies.{body.name}"
        found = []
        if entry.acceleration is None:
            found.append((f"{key}.acceleration", "not stated: the centre of mass is taken at rest"))
        if body.name not in self.guided:
            turned = math.degrees(float(np.ptp(read.angle)))
            but = f", though the angle changes by {turned:.4g} deg" if turned > 0 else ""
            if entry.angular_velocity is None:
                found.append((f"{key}.angular_velocity", f"not stated: taken as 0{but}"))
            if entry.angular_acceleration is None:
                found.append((f"{key}.angular_acceleration", f"not stated: taken as 0{but}"))
        return found
