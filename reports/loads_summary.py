"""The loads of a design's cycles as data for people: extremes with their places, drives, contacts.

Everything is computed from `loads.CycleLoads` once, for the terminal, the page and JSON alike.

A measured run has the extremes of the loads on each body at each of its points. No linkage is
solved for it, so that there are neither reactions of joints nor drives.
"""

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from math import nan
from typing import Any

import numpy as np

from checks.result.plain_data import plain_fields
from checks.result.verdict import Gate
from geometry.mesh import FloatArray
from loads import (
    Angle,
    Coordinate,
    CycleLoads,
    Distance,
    Fixed,
    Joint,
    MeasuredLoads,
    Prismatic,
    Revolute,
    Slot,
)
from reports.loads_figures import (
    BlowSummary,
    ContactStated,
    ContactSummary,
    Direction,
    DriveSummary,
    EventFigures,
    Extremes,
    JointSummary,
    MotorFigures,
    PointSummary,
    ShownPhase,
    contact_summaries,
)

_ROUNDING = 1e-9  # of the largest value of its kind: less is rounding, and shown as 0
_NO_WORK = 1e-5  # of the peak power all the time: less is what the trapezoidal rule leaves of 0


@dataclass(frozen=True, eq=False)
class ShownRun:
    """A measured run as people see it.

    file   where its loads stand
    shown  (n,) position, in `unit` ("mm", "deg" or "s"), called `shown_name`
    duty   how often it runs in the life; 0 for a run in no duty
    """

    loads: MeasuredLoads
    file: str
    shown_name: str
    unit: str
    shown: FloatArray
    duty: float

    @property
    def name(self) -> str:
        """The run's name."""
        return self.loads.name

    @property
    def duration(self) -> float | None:
        """Time from the first row to the last, s; None where no times were measured."""
        return None if self.loads.times is None else float(self.loads.times[-1])

    @property
    def points(self) -> list[PointSummary]:
        """Extremes of the load on every body at every point, axes of the ground."""
        return [
            PointSummary(
                body,
                str(load.point),
                tuple(
                    _extremes(quantity, values, angular, self)
                    for quantity, values, angular in (
                        ("Fx", load.force[:, 0], False),
                        ("Fy", load.force[:, 1], False),
                        ("|F|", np.hypot(load.force[:, 0], load.force[:, 1]), False),
                        ("M", load.moment, True),
                    )
                    if not angular or np.any(values)
                ),
            )
            for body in self.loads.bodies
            for load in self.loads.body_loads(body)
        ]

    def to_dict(self) -> dict[str, Any]:
        """The run as plain data: N, N mm, mm, s; without the history, which is the CSV's."""
        return {
            "name": self.name,
            "file": self.file,
            "shown_name": self.shown_name,
            "unit": self.unit,
            "n_positions": len(self.shown),
            "duration": self.duration,
            "duty": self.duty,
            "points": [plain_fields(point) for point in self.points],
        }


@dataclass(frozen=True, eq=False)
class ShownCycle:
    """A solved cycle as people see it.

    shown      (n,) position, in `unit` ("mm" or "deg"), called `shown_name`
    pace       what sets the time, in words
    duty       how often it runs in the life; 0 for a cycle in no duty
    available  force -> what its drive can give with a positive and a negative sign [N, N mm]
    allowed_irregularity  of the speed, above which constant speed does not count
    stated     the contacts as the design has them, by the name of their force
    motor      how a motor runs through it; None where none turns it
    event      the start or stop that it is; None for any other
    blows      of its contacts
    """

    loads: CycleLoads
    shown_name: str
    unit: str
    shown: FloatArray
    pace: str
    duty: float
    phases: tuple[ShownPhase, ...]
    available: Mapping[str, tuple[float, float]]
    allowed_irregularity: float
    stated: Mapping[str, ContactStated] = field(default_factory=dict)
    motor: MotorFigures | None = None
    event: EventFigures | None = None
    blows: Sequence[BlowSummary] = ()

    @property
    def name(self) -> str:
        """The cycle's name."""
        return self.loads.name

    @property
    def duration(self) -> float:
        """Time of one cycle, s."""
        return float(self.loads.times[-1])

    def phase_at(self, index: int) -> str:
        """Name of the phase of a position."""
        return self.loads.phases[int(self.loads.phase_of[index])]

    @property
    def joints(self) -> list[JointSummary]:
        """Extremes of every reaction."""
        reactions = self.loads.reactions
        force_scale = max(float(np.abs(load.force).max()) for load in reactions.values())
        moment_scale = max(
            force_scale,  # at an arm of 1 mm, where there are no moments at all
            *(
                float(np.abs(couple).max())
                for load in reactions.values()
                for couple in (load.moment, load.friction_couple)
            ),
        )
        result = []
        for joint in self.loads.linkage.joints:
            load = reactions[joint.name]
            friction = joint.name in self.loads.linkage.friction
            rows: list[tuple[str, FloatArray, bool]] = [
                ("Fx", load.force[:, 0], False),
                ("Fy", load.force[:, 1], False),
                ("|F|", np.hypot(load.force[:, 0], load.force[:, 1]), False),
            ]
            if isinstance(joint, Prismatic | Fixed):
                rows.append(("M", load.moment, True))
            if friction and isinstance(joint, Revolute):
                rows.append(("friction M", load.friction_couple, True))
            if friction and isinstance(joint, Prismatic | Slot):
                rows.append(("friction F", load.friction_force, False))
            result.append(
                JointSummary(
                    joint.name,
                    kind_of(joint),
                    joint.body_b,
                    joint.body_a,
                    tuple(
                        _extremes(
                            name, values, angular, self, moment_scale if angular else force_scale
                        )
                        for name, values, angular in rows
                    ),
                )
            )
        return result

    @property
    def efforts(self) -> list[Extremes]:
        """Extremes of every force and torque, given and solved."""
        return [
            _extremes(
                force.name,
                self.loads.efforts[force.name],
                force.coordinate.angular,
                self,
                float(np.abs(self.loads.efforts[force.name]).max()),
            )
            for force in self.loads.linkage.forces
        ]

    def role(self, force: str) -> str:
        """Role of a force: given, solved, or solved in some phases."""
        solved = [phase.name for phase in self.phases if phase.solve == force]
        if not solved:
            return "given"
        return "solved" if len(solved) == len(self.phases) else f"solved in {', '.join(solved)}"

    @property
    def drives(self) -> list[DriveSummary]:
        """Forces with a limit, or solved for and setting the pace or bringing work in."""
        result = []
        for force in self.loads.linkage.forces:
            limited = force.name in self.available
            if not limited and all(phase.solve != force.name for phase in self.phases):
                continue
            drive = self._drive(force.name)
            if limited or drive.work > 0.0 or _measure_the_same(force.coordinate, self.loads.pace):
                result.append(drive)
        return result

    def _drive(self, name: str) -> DriveSummary:
        figures = self.loads.drive(name)
        allowed = self.allowed_irregularity
        works = abs(figures.work) > _NO_WORK * figures.peak_power * self.duration
        ripple = figures.energy_ripple
        heavy = ripple is not None and figures.mean_reduced_mass > 0.0
        return DriveSummary(
            name=name,
            angular=figures.angular,
            directions=self.directions(name),
            closed=figures.closed,
            mean_power=figures.mean_power if works else 0.0,
            peak_power=figures.peak_power,
            work=figures.work if works else 0.0,
            impact_energy=sum(contact.energy for contact in self.contacts),
            reduced_inertia=None if ripple is None else figures.mean_reduced_mass,
            ripple=ripple,
            irregularity=figures.irregularity if heavy else None,
            flywheel=figures.reduced_mass_for(allowed) if heavy else None,
            allowed=allowed,
        )

    def directions(self, name: str) -> tuple[Direction, ...]:
        """The largest effort of a force in each direction in which it acts at all."""
        coordinate = self.loads.linkage.force(name).coordinate
        words = ("along its direction", "against its direction")
        if isinstance(coordinate, Distance):
            words = ("pull", "push")
        elif coordinate.angular:
            words = ("counter-clockwise", "clockwise")
        effort = self.loads.efforts[name]
        result = []
        for side, (sign, said) in enumerate(zip((1.0, -1.0), words, strict=True)):
            index = int((sign * effort).argmax())
            if sign * effort[index] <= _ROUNDING * np.abs(effort).max():
                continue
            limits = self.available.get(name)
            result.append(
                Direction(
                    said,
                    float(sign * effort[index]),
                    float(self.shown[index]),
                    self.phase_at(index),
                    None if limits is None else limits[side],
                )
            )
        return tuple(result)

    @property
    def contacts(self) -> list[ContactSummary]:
        """Every contact: where it touches, how hard, and how fast it is met."""
        return contact_summaries(self.loads, self.shown, self.stated)

    @property
    def closed(self) -> bool:
        """True if the cycle ends in the pose that it starts from."""
        return self.loads.drive(self.loads.linkage.forces[0].name).closed

    def to_dict(self) -> dict[str, Any]:
        """The cycle as plain data: N, N mm, mm, s; without the history, which is the CSV's."""
        return {
            "name": self.name,
            "shown_name": self.shown_name,
            "unit": self.unit,
            "n_positions": len(self.shown),
            "duration": self.duration,
            "pace": self.pace,
            "duty": self.duty,
            "phases": [plain_fields(phase) for phase in self.phases],
            "reactions": [plain_fields(joint) for joint in self.joints],
            "efforts": [
                plain_fields(effort) | {"role": self.role(effort.quantity)}
                for effort in self.efforts
            ],
            "drives": [plain_fields(drive) for drive in self.drives],
            "contacts": [plain_fields(contact) for contact in self.contacts],
            "blows": [plain_fields(blow) for blow in self.blows],
            "motor": None if self.motor is None else self.motor.to_dict(),
            **({} if self.event is None else {"event": vars(self.event)}),
        }


@dataclass(frozen=True, eq=False)
class LoadsResult:
    """The loads of a design: its cycles and runs, the gates they pass, what a reader must know.

    absent  what these loads leave out, in words
    runs    the measured ones
    """

    name: str
    file: str
    sha256: str
    overrides: Sequence[str]
    cycles: Sequence[ShownCycle]
    gates: Sequence[Gate]
    warnings: Sequence[str]
    absent: Sequence[str]
    assumed: Sequence[tuple[str, str]]
    command: str
    runs: Sequence[ShownRun] = ()

    @property
    def rubbing(self) -> bool:
        """True if any joint has friction in any cycle."""
        return any(cycle.loads.linkage.friction for cycle in self.cycles)

    @property
    def broken(self) -> list[Gate]:
        """The gates that do not hold."""
        return [gate for gate in self.gates if not gate.holds]

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data."""
        return {"format": "ballesta-loads/1"} | plain_fields(self)


def _extremes(
    quantity: str,
    values: FloatArray,
    angular: bool,
    shown: ShownCycle | ShownRun,
    scale: float = 0.0,
) -> Extremes:
    """Least, largest and mean of values (n,); what is rounding beside `scale` becomes 0."""
    tidy = np.where(np.abs(values) <= _ROUNDING * scale, 0.0, values)
    low, high = int(tidy.argmin()), int(tidy.argmax())
    loads, duration, mean = shown.loads, shown.duration, nan
    if loads.times is not None and duration:
        mean = float(np.trapezoid(tidy, loads.times) / duration)
        mean = 0.0 if abs(mean) <= _ROUNDING * scale else mean
    return Extremes(
        quantity,
        angular,
        float(tidy[low]),
        float(shown.shown[low]),
        loads.phases[int(loads.phase_of[low])],
        float(tidy[high]),
        float(shown.shown[high]),
        loads.phases[int(loads.phase_of[high])],
        mean,
    )


def _measure_the_same(first: Coordinate, second: Coordinate) -> bool:
    """Return True if two coordinates are the same, wherever a torque along them enters."""
    if isinstance(first, Angle) and isinstance(second, Angle):
        return (first.body, first.relative_to) == (second.body, second.relative_to)
    return first == second


def kind_of(joint: Joint) -> str:
    """A joint's kind in words."""
    return {Revolute: "pin", Prismatic: "guide", Slot: "slot", Fixed: "weld"}[type(joint)]


# The whole history of cycles as a table: one row per position.
_POSE = ("x [mm]", "y [mm]", "angle [rad]")
_VELOCITY = ("vx [mm/s]", "vy [mm/s]", "omega [rad/s]")
_ACCELERATION = ("ax [mm/s2]", "ay [mm/s2]", "alpha [rad/s2]")


def loads_csv(cycles: Sequence[ShownCycle], runs: Sequence[ShownRun] = ()) -> str:
    """The history of cycles of one linkage, then of measured runs, as comma-separated text.

    Columns, in this order; numbers have a decimal point and every digit they need:

    cycle, phase, time [s], coordinate, position [mm] (or [deg]: as the reports show it)
    <body>.x [mm], .y [mm], .angle [rad]                of the body's frame
    <body>.vx [mm/s], .vy [mm/s], .omega [rad/s]        of the frame's origin
    <body>.ax [mm/s2], .ay [mm/s2], .alpha [rad/s2]     of the frame's origin
    <body>.centre.ax [mm/s2], .centre.ay [mm/s2]        of the centre of mass
    <joint>.Fx [N], .Fy [N]                             on the joint's second body
    <joint>.M [N mm]                                    guides and welds
    <joint>.friction_couple [N mm], .friction_force [N] pins; guides and slots that have friction
    <body>@<point>.Fx [N], .Fy [N], .M [N mm]           all that acts on the body at the point
    <body>.M [N mm]                                     torques on the body that enter at no point
    <force>.effort [N] (or [N mm])                      given and solved

    A measured run has the columns of its bodies and points that it can have; its phase is "run". A
    cell is empty where its cycle has no such quantity, or a run no time. Axes are those of the
    ground; angles and moments count counter-clockwise.
    """
    every: list[ShownCycle | ShownRun] = [*cycles, *runs]
    units = list(dict.fromkeys(shown.unit for shown in every))
    histories = [dict(_columns(cycle.loads)) for cycle in cycles]
    histories += [dict(_run_columns(run.loads)) for run in runs]
    columns = list(dict.fromkeys(name for history in histories for name in history))
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    heading = ["cycle", "phase", "time [s]", "coordinate", f"position [{' or '.join(units)}]"]
    writer.writerow([*heading, *columns])
    for shown, history in zip(every, histories, strict=True):
        # a joint may have friction in one cycle and none in another
        none = [""] * len(shown.shown)
        numbers = [_written(history[name]) if name in history else none for name in columns]
        stamps = shown.loads.times
        times = none if stamps is None else _written(stamps)
        phases = [shown.loads.phases[k] for k in shown.loads.phase_of]
        for phase, time, position, *row in zip(
            phases, times, _written(shown.shown), *numbers, strict=True
        ):
            writer.writerow([shown.name, phase, time, shown.shown_name, position, *row])
    return out.getvalue()


def _written(values: FloatArray) -> list[str]:
    """Numbers with every digit."""
    return list(map(repr, values.tolist()))


def _columns(cycle: CycleLoads) -> Iterator[tuple[str, FloatArray]]:
    """Heading and values (n,) of everything but cycle, phase, time and position."""
    for body in cycle.linkage.moving:
        row = cycle.body_index(body.name)
        for headings, values in (
            (_POSE, cycle.poses),
            (_VELOCITY, cycle.velocities),
            (_ACCELERATION, cycle.accelerations),
        ):
            for k, heading in enumerate(headings):
                yield f"{body.name}.{heading}", values[:, row, k]
        centre = cycle.centre_acceleration(body.name)
        yield f"{body.name}.centre.ax [mm/s2]", centre[:, 0]
        yield f"{body.name}.centre.ay [mm/s2]", centre[:, 1]
    for joint in cycle.linkage.joints:
        load = cycle.reactions[joint.name]
        yield f"{joint.name}.Fx [N]", load.force[:, 0]
        yield f"{joint.name}.Fy [N]", load.force[:, 1]
        if isinstance(joint, Prismatic | Fixed):
            yield f"{joint.name}.M [N mm]", load.moment
        if joint.name in cycle.linkage.friction:
            if isinstance(joint, Revolute):
                yield f"{joint.name}.friction_couple [N mm]", load.friction_couple
            elif isinstance(joint, Prismatic | Slot):
                yield f"{joint.name}.friction_force [N]", load.friction_force
    for body in cycle.linkage.moving:
        yield from _on_points(cycle, body.name)
    for force in cycle.linkage.forces:
        unit = "N mm" if force.coordinate.angular else "N"
        yield f"{force.name}.effort [{unit}]", cycle.efforts[force.name]


def _run_columns(run: MeasuredLoads) -> Iterator[tuple[str, FloatArray]]:
    """Headings and values (n,) of motion and loads of the bodies in a run."""
    for name, body in run.bodies.items():
        yield f"{name}.angle [rad]", body.angle
        yield f"{name}.omega [rad/s]", body.angular_velocity
        yield f"{name}.alpha [rad/s2]", body.angular_acceleration
        acceleration = body.pull((0.0, 0.0))
        yield f"{name}.centre.ax [mm/s2]", acceleration[:, 0]
        yield f"{name}.centre.ay [mm/s2]", acceleration[:, 1]
        for load in run.body_loads(name):
            yield f"{name}@{load.point}.Fx [N]", load.force[:, 0]
            yield f"{name}@{load.point}.Fy [N]", load.force[:, 1]
            yield f"{name}@{load.point}.M [N mm]", load.moment


def _on_points(cycle: CycleLoads, body: str) -> Iterator[tuple[str, FloatArray]]:
    """Force and moment on a body, summed at each of its points; a couple alone is at no point."""
    n = len(cycle.times)
    sums: dict[str, FloatArray] = {}
    for load in cycle.body_loads(body):
        total = sums.setdefault(load.point or "", np.zeros((n, 3)))
        total[:, :2] += load.force
        total[:, 2] += load.moment
    for point, total in sums.items():
        alone = f"{body}@" if body in {joint.name for joint in cycle.linkage.joints} else body
        owner = f"{body}@{point}" if point else alone
        if point:
            yield f"{owner}.Fx [N]", total[:, 0]
            yield f"{owner}.Fy [N]", total[:, 1]
        yield f"{owner}.M [N mm]", total[:, 2]
