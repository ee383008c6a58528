"""Reads the loads of a measured run from its file, in ballesta's units, as they act on bodies."""

import math
from collections.abc import Mapping, Set
from dataclasses import dataclass

import numpy as np

import loads
from ballesta.design.csv_columns import Columns, ColumnsError, read_columns
from ballesta.design.files import Sources
from checks.design.data import MeasuredRun, Pair
from checks.design.errors import DesignError, Problems, no_such
from checks.design.measured_entry import MeasuredBodyEntry, MeasuredEntry
from checks.design.model import DesignFile
from checks.design.units import Measured
from geometry.mesh import FloatArray


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
        result: FloatArray = times - times[0]
        return result

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
