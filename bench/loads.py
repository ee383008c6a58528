"""Loads of four machines over a cycle, against solving each position by itself; a line of JSON.

The other way is a script written for one linkage: for every position scipy's ``root``
(hybr) closes the joints from the position before, then one dense solve each gives velocities,
accelerations and forces. Same coordinates (poses of all bodies), constraints and balance on both
sides; the answers are compared before anything is timed. Run by bench/run.py from the repository.
"""

import json
import statistics
import sys
import tracemalloc
from collections.abc import Callable
from math import cos, sin
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from scipy.optimize import root

sys.path.insert(0, str(Path(__file__).parent.parent))

from loads import (
    GROUND,
    Angle,
    Cycle,
    Phase,
    Prismatic,
    SteadyPace,
    move,
    run_cycle,
    solve_forces,
    trace,
)
from loads.kinematics import Kinematics, rotated, turned_left
from tests.loads.machines import hammer, quick_return, slider_crank, toggle, toggle_height
from tests.loads.test_cycle_invariants import SLIDER_CRANK

CRANK = Angle("crank")
N = 720
SPEED = 5.0
RUNS = 5
START = 0.3


class Machine:
    """A linkage, what it is swept along, and which force is given and which one solved for."""

    def __init__(self, linkage: Any, coordinate: Any, low: float, high: float, solve: str) -> None:
        self.linkage, self.coordinate, self.solve = linkage, coordinate, solve
        self.low, self.high = low, high
        self.given = {force.name: -150.0 for force in linkage.forces if force.name != solve}

    def positions(self, n: int = N) -> Any:
        """Equally spaced values of the swept coordinate."""
        return np.linspace(self.low, self.high, n)


def machines() -> dict[str, Machine]:
    """The four machines of the reference, frictionless, in SI units."""
    press = toggle(0.5, 0.35, 4.14134, 10.0, 0.02156947917, 9.81)
    turn = (START, START + 2 * np.pi, "drive")
    return {
        "toggle": Machine(press, toggle_height(press), 0.3, 0.498, "cylinder"),
        "slider-crank": Machine(slider_crank(**SLIDER_CRANK, at=START), CRANK, *turn),
        "hammer": Machine(hammer(at=START), CRANK, *turn),
        "quick return": Machine(quick_return(at=START), CRANK, *turn),
    }


def together(machine: Machine, n: int = N) -> tuple[Any, Any]:
    """Ours: all positions at once. Accelerations and the effort solved for."""
    path = trace(machine.linkage, machine.coordinate, machine.low, machine.high)
    motion = move(path.at(machine.positions(n)), machine.coordinate, SPEED, 1)
    solution = solve_forces(motion, machine.given, machine.solve)
    return motion.accelerations, solution.efforts[machine.solve]


def whole_cycle(machine: Machine) -> None:
    """Ours with what a cycle adds: where positions lie, the join of phases and times."""
    phase = Phase("all", machine.high, machine.given, machine.solve)
    pace = SteadyPace(machine.coordinate, SPEED)
    run_cycle(machine.linkage, Cycle("all", machine.coordinate, machine.low, pace, (phase,), N))


def in_plain_floats(machine: Machine) -> Callable[[Any, float], list[float]]:
    """The same constraints as a designer writes them for one machine: floats, no arrays."""
    linkage, coordinate = machine.linkage, machine.coordinate
    row = {name: 3 * i for i, name in enumerate(linkage.body_names)}
    turns = {name: pose[2] for name, pose in linkage.assembled.items()} | {GROUND: 0.0}

    def closed(q: Any, value: float) -> list[float]:
        pose = [0.0, 0.0, 0.0, *q.tolist()]
        c, s = [cos(angle) for angle in pose[2::3]], [sin(angle) for angle in pose[2::3]]

        def place(body: str, point: tuple[float, float]) -> tuple[float, float]:
            i = row[body]
            a, b = c[i // 3], s[i // 3]
            return (
                pose[i] + a * point[0] - b * point[1],
                pose[i + 1] + b * point[0] + a * point[1],
            )

        errors = []
        for name, a, b, point_a, point_b, line in joints:
            xa, ya = place(a, point_a)
            xb, yb = place(b, point_b)
            if line is None:
                errors += [xb - xa, yb - ya]
                continue
            k = row[a] // 3
            x, y = c[k] * line[0] - s[k] * line[1], s[k] * line[0] + c[k] * line[1]
            errors.append(x * (yb - ya) - y * (xb - xa))
            if name in guides:
                errors.append(pose[row[b] + 2] - pose[row[a] + 2] - turns[b] + turns[a])
        if isinstance(coordinate, Angle):
            errors.append(pose[row[coordinate.body] + 2] - value)
        else:
            x, y = place(coordinate.body, linkage.body(coordinate.body).place(coordinate.point))
            errors.append(coordinate.direction[0] * x + coordinate.direction[1] * y - value)
        return errors

    guides = {joint.name for joint in linkage.joints if isinstance(joint, Prismatic)}
    joints = [
        (
            joint.name,
            joint.body_a,
            joint.body_b,
            linkage.body(joint.body_a).place(joint.point_a),
            linkage.body(joint.body_b).place(joint.point_b),
            getattr(joint, "direction", None),
        )
        for joint in linkage.joints
    ]
    return closed


def one_by_one(machine: Machine, residual: str) -> tuple[Any, Any]:
    """The other way, position by position; residual: arrays, jacobian (arrays too) or floats."""
    linkage, coordinate = machine.linkage, machine.coordinate
    k = Kinematics(linkage)
    fixed = np.zeros((1, 1, 3))

    def whole(q: Any) -> Any:
        return np.concatenate([fixed, q.reshape(1, -1, 3)], axis=1)

    def closed(q: Any, value: float) -> Any:
        poses = whole(q)
        return np.append(k.constraints(poses)[0], k.value(coordinate, poses) - value)

    def slopes(q: Any, value: float) -> Any:
        poses = whole(q)
        return np.vstack([k.jacobian(poses)[0, :, 3:], k.gradient(coordinate, poses)[:, 3:]])

    errors = in_plain_floats(machine) if residual == "floats" else closed
    solved_for = linkage.force(machine.solve)
    q = trace(linkage, coordinate, machine.low, machine.low + 1e-3).at(machine.positions()[:1])
    q = q.poses[0, 1:].ravel()
    accelerations, efforts = [], []
    for value in machine.positions():
        jacobian = slopes if residual == "jacobian" else None
        result = root(errors, q, args=(value,), method="hybr", jac=jacobian, tol=1e-12)
        q = result.x
        poses = whole(q)
        matrix = slopes(q, value)
        right = np.zeros(len(q))
        right[-1] = SPEED
        rates = whole(np.linalg.solve(matrix, right))
        bend = np.append(k.quadratic(poses, rates)[0], k.curvature(coordinate, poses, rates))
        rises = whole(np.linalg.solve(matrix, -bend))
        load = np.zeros((len(linkage.moving), 3))
        for i, body in enumerate(linkage.moving):
            arm = rotated(np.array(body.centre, dtype=float), poses[0, i + 1, 2])
            spin, turn = rates[0, i + 1, 2], rises[0, i + 1, 2]
            pull = rises[0, i + 1, :2] + turn * turned_left(arm) - spin**2 * arm - linkage.gravity
            load[i, :2] = body.mass * pull
            load[i, 2] = body.inertia * turn + body.mass * (arm[0] * pull[1] - arm[1] * pull[0])
        balance = load.ravel()
        for name, size in machine.given.items():
            force = linkage.force(name)
            balance = balance - size * force.sign * k.gradient(force.coordinate, poses)[0, 3:]
        acts = solved_for.sign * k.gradient(solved_for.coordinate, poses)[0, 3:]
        unknowns = np.linalg.solve(np.column_stack([matrix[:-1].T, acts]), balance)
        accelerations.append(rises[0])
        efforts.append(unknowns[-1])
    return np.array(accelerations), np.array(efforts)


def agree(machine: Machine) -> float:
    """The largest difference of the two ways, over the largest acceleration or effort."""
    ours, worst = together(machine), 0.0
    for residual in ("arrays", "jacobian", "floats"):
        theirs = one_by_one(machine, residual)
        for a, b in zip(ours, theirs, strict=True):
            worst = max(worst, float(np.abs(a - b).max() / np.abs(b).max()))
    assert worst < 1e-6, worst
    return worst


def medians(ways: dict[str, Callable[[], Any]]) -> dict[str, float]:
    """Median seconds of each way, run in turns."""
    times: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(RUNS):
        for name, way in ways.items():
            start = perf_counter()
            way()
            times[name].append(perf_counter() - start)
    return {name: statistics.median(runs) for name, runs in times.items()}


def costs(machine: Machine) -> dict[str, Any]:
    """Time per position for 1e2 ... 1e5 positions, exponent and memory at the end."""
    counts = [100, 1000, 10000, 100000]
    seconds = [medians({"ours": lambda n=n: together(machine, n)})["ours"] for n in counts]
    exponent = np.log10(seconds[-1] / seconds[-2])
    tracemalloc.start()
    together(machine, counts[-1])
    peak = tracemalloc.get_traced_memory()[1] / 2**20
    tracemalloc.stop()
    each = {str(n): s / n * 1e6 for n, s in zip(counts, seconds, strict=True)}
    return {"microseconds": each, "exponent": float(exponent), "mebibytes": peak}


def main() -> None:
    """Measure everything."""
    rows: dict[str, Any] = {"machines": {}}
    for name, machine in machines().items():
        difference = agree(machine)
        measured = medians(
            {
                "together": lambda m=machine: together(m),
                "cycle": lambda m=machine: whole_cycle(m),
                "arrays": lambda m=machine: one_by_one(m, "arrays"),
                "jacobian": lambda m=machine: one_by_one(m, "jacobian"),
                "floats": lambda m=machine: one_by_one(m, "floats"),
            }
        )
        rows["machines"][name] = {"difference": difference, **measured}
    rows["costs"] = costs(machines()["quick return"])
    print(json.dumps(rows))


if __name__ == "__main__":
    main()
