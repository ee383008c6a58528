"""The whole history of cycles as a table: one row per position, a unit in every heading.

Columns, in this order; numbers have a decimal point and every digit they need:

cycle, phase, time [s], coordinate, position [mm] (or [deg]: as the reports show it)
<body>.x [mm], .y [mm], .angle [rad]                of the body's frame
<body>.vx [mm/s], .vy [mm/s], .omega [rad/s]        of the frame's origin
<body>.ax [mm/s2], .ay [mm/s2], .alpha [rad/s2]     of the frame's origin
<body>.centre.ax [mm/s2], .centre.ay [mm/s2]        of the centre of mass
<joint>.Fx [N], .Fy [N]                             on the joint's second body
<joint>.M [N mm]                                    guides and welds
<joint>.friction_couple [N mm], .friction_force [N] pins; guides and slots that have friction
<body>@<point>.Fx [N], .Fy [N], .M [N mm]           everything that acts on the body at the point
<body>.M [N mm]                                     torques on the body that enter at no point
<force>.effort [N] (or [N mm])                      given and solved

A measured run has the columns of its bodies and points that it can have; its phase is "run". A cell
is empty where its cycle has no such quantity, or a run no time. Axes are those of the ground;
angles and moments count counter-clockwise.
"""

import csv
from collections.abc import Iterator, Sequence
from io import StringIO

import numpy as np

from loads import CycleLoads, Fixed, MeasuredLoads, Prismatic, Revolute, Slot
from reports.loads_figures import FloatArray
from reports.loads_summary import ShownCycle, ShownRun

_POSE = ("x [mm]", "y [mm]", "angle [rad]")
_VELOCITY = ("vx [mm/s]", "vy [mm/s]", "omega [rad/s]")
_ACCELERATION = ("ax [mm/s2]", "ay [mm/s2]", "alpha [rad/s2]")


def loads_csv(cycles: Sequence[ShownCycle], runs: Sequence[ShownRun] = ()) -> str:
    """The history of cycles of one linkage, then of measured runs, as comma-separated text."""
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
        centre = _centre_acceleration(cycle, body.name)
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


def _centre_acceleration(cycle: CycleLoads, body: str) -> FloatArray:
    row = cycle.body_index(body)
    x, y = cycle.linkage.body(body).centre
    angle, spin = cycle.poses[:, row, 2], cycle.velocities[:, row, 2]
    turn = cycle.accelerations[:, row, 2]
    arm_x, arm_y = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
    return np.stack(
        [
            cycle.accelerations[:, row, 0] - turn * arm_y - spin**2 * arm_x,
            cycle.accelerations[:, row, 1] + turn * arm_x - spin**2 * arm_y,
        ],
        axis=1,
    )
