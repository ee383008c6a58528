"""Columns of a solved cycle, as a test rig or another program would hand them over."""

from dataclasses import replace
from math import pi

import numpy as np

from loads import (
    Angle,
    Cycle,
    MeasuredBody,
    MeasuredLoad,
    MeasuredLoads,
    Phase,
    SteadyPace,
    run_cycle,
)
from loads.kinematics import rotated, turned_left

from .machines import slider_crank

ROD = {"mass": 0.8e-3, "inertia": 6.0, "centre": (90.0, 4.0)}


def solved_slider_crank(gravity=(0.0, -9810.0), speed=60.0, push=-900.0, rod=ROD):
    """One turn of a slider-crank whose rod's inertia is a good part of its loads."""
    linkage = slider_crank(
        60.0,
        220.0,
        offset=12.0,
        crank_body={"mass": 1.5e-3, "inertia": 3.0, "centre": (20.0, 0.0)},
        rod_body=rod,
        slider_mass=0.6e-3,
        gravity=gravity,
    )
    angle = Angle("crank")
    cycle = Cycle(
        "turn",
        angle,
        0.0,
        SteadyPace(angle, speed),
        (Phase("turn", 2 * pi, {"push": push}, "drive"),),
        n_positions=121,
    )
    return run_cycle(linkage, cycle)


def measured_from(cycle, bodies=("crank", "rod"), in_body_frame=False):
    """The loads of a solved cycle in the form of measured ones, in the ground's or body's axes."""
    result = {}
    for name in bodies:
        body, row = cycle.linkage.body(name), cycle.body_index(name)
        angle, spin = cycle.poses[:, row, 2], cycle.velocities[:, row, 2]
        turn = cycle.accelerations[:, row, 2]
        arm = rotated(np.array(body.centre, dtype=float), angle)
        acceleration = (
            cycle.accelerations[:, row, :2]
            + turn[:, None] * turned_left(arm)
            - (spin**2)[:, None] * arm
        )
        sums = {}
        for load in cycle.body_loads(name):
            force, moment = sums.get(load.point, (0.0, 0.0))
            sums[load.point] = (force + load.force, moment + load.moment)
        turned = -angle if in_body_frame else np.zeros_like(angle)
        result[name] = MeasuredBody(
            body,
            tuple(
                MeasuredLoad(point, rotated(force, turned), moment, in_body_frame)
                for point, (force, moment) in sums.items()
            ),
            angle,
            rotated(acceleration, turned),
            spin,
            turn,
            in_body_frame,
        )
    return MeasuredLoads(
        cycle.name,
        cycle.positions,
        cycle.times,
        result,
        cycle.linkage.gravity,
        "crank angle",
        "deg",
    )


def with_body(run, name, **changes):
    """The same run with other data of one body."""
    return replace(run, bodies={**run.bodies, name: replace(run.bodies[name], **changes)})


def with_load(run, name, point, change):
    """The same run with other data at one point of a body; ``point`` None for all points."""
    entry = run.bodies[name]
    changed = tuple(change(load) if point in (load.point, None) else load for load in entry.loads)
    return with_body(run, name, loads=changed)


def noisy(run, name, size, seed=1):
    """The same run with readings of a body that are off by up to a share of themselves."""
    random = np.random.default_rng(seed)

    def off(values):
        return values * (1 + size * random.uniform(-1, 1, values.shape))

    entry = run.bodies[name]
    return with_body(
        run,
        name,
        loads=tuple(
            replace(load, force=off(load.force), moment=off(load.moment)) for load in entry.loads
        ),
        acceleration=off(entry.acceleration),
        angular_acceleration=off(entry.angular_acceleration),
    )
