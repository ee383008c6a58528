"""A slider-crank that a motor turns, beside exudyn: speed, time of a turn and forces in its pins.

    python -m bench.motor_beside_exudyn

exudyn (pip install exudyn==1.13.6) integrates the same machine in time, with Cartesian coordinates
and constraints, from a speed that is 5 % off; ballesta seeks the turn that repeats. Compared is the
last of three turns, of which the first two are some hundred time constants of the motor. It is no
dependency of ballesta: where it is missing, this says so and ends with 1.
"""

import sys
from typing import Any

import numpy as np

import loads
from loads import Apply, Number, Reading

CRANK, ROD = 100.0, 400.0  # mm
# mass t, inertia about the centre t mm2, centre mm from the first pin
CRANK_BODY, ROD_BODY, SLIDER = (3e-3, 20.0, 30.0), (4e-3, 60.0, 180.0), 5e-3
GRAVITY = -9810.0  # mm/s2
MOTOR = loads.Motor(2e4, 140.0, 157.08, breakdown=2.8)
GEARED = loads.Geared(MOTOR, ratio=10.0, efficiency=0.9, inertia=0.02)
FLYWHEEL = 600.0  # t mm2
PUSH, AT, POWER = 600.0, 500.0, 1.2  # N at mm of a gas spring behind the slider
TURNS = 3
STEPS = (40_000, 80_000)  # over all turns; the second tells how much the first is off
ASKED = 1e-5
PINS = ("O", "A", "B")


def by_ballesta() -> loads.CycleLoads:
    """The turn that repeats."""
    place = loads.PointCoordinate("slider", "B", (1.0, 0.0))
    linkage = loads.Linkage(
        (
            loads.Body("ground", {"O": (0.0, 0.0)}),
            loads.Body(
                "crank",
                {"O": (0.0, 0.0), "A": (CRANK, 0.0)},
                CRANK_BODY[0],
                CRANK_BODY[1],
                (CRANK_BODY[2], 0.0),
            ),
            loads.Body(
                "rod",
                {"A": (0.0, 0.0), "B": (ROD, 0.0)},
                ROD_BODY[0],
                ROD_BODY[1],
                (ROD_BODY[2], 0.0),
            ),
            loads.Body("slider", {"B": (0.0, 0.0)}, SLIDER),
        ),
        (
            loads.Revolute("O", "ground", "crank", "O"),
            loads.Revolute("A", "crank", "rod", "A"),
            loads.Revolute("B", "rod", "slider", "B"),
            loads.Prismatic("guide", "ground", "slider", "O", "B", (1.0, 0.0)),
        ),
        (loads.Force("drive", loads.Angle("crank")), loads.Force("gas", place)),
        {"crank": (0.0, 0.0, 0.0), "rod": (CRANK, 0.0, 0.0), "slider": (CRANK + ROD, 0.0, 0.0)},
        gravity=(0.0, GRAVITY),
    )
    ratio = Apply("/", (Number(AT), Reading(place)))
    gas = loads.Expression("gas", Apply("*", (Number(PUSH), Apply("**", (ratio, Number(POWER))))))
    angle = loads.Angle("crank")
    pace = loads.MotorPace(loads.SteadyPace(angle, 14.0), GEARED, FLYWHEEL)
    phase = loads.Phase("turn", 2 * np.pi, {"gas": gas}, "drive")
    return loads.run_cycle(linkage, loads.Cycle("turn", angle, 0.0, pace, (phase,), 721))


def by_exudyn(exu: Any, speed: float, steps: int, duration: float) -> dict[str, np.ndarray]:
    """Time, angle and speed of the crank, forces x and y of the pins on the second body."""
    from exudyn import itemInterface as items

    system = exu.SystemContainer().AddSystem()
    ground = system.AddObject(items.ObjectGround(referencePosition=[0, 0, 0]))
    fixed = system.AddNode(items.NodePointGround(referenceCoordinates=[0, 0, 0]))
    nodes, bodies = [], []
    turning = FLYWHEEL + GEARED.reflected
    for (mass, inertia, centre), start, extra, rate in (
        (CRANK_BODY, 0.0, turning, speed),
        (ROD_BODY, CRANK, 0.0, -CRANK * speed / ROD),
    ):
        across = speed * centre if not start else CRANK * speed * (1 - centre / ROD)
        nodes.append(
            system.AddNode(
                items.NodeRigidBody2D(
                    referenceCoordinates=[start + centre, 0, 0],
                    initialVelocities=[0, across, rate],
                )
            )
        )
        bodies.append(
            system.AddObject(
                items.ObjectRigidBody2D(mass=mass, inertia=inertia + extra, nodeNumber=nodes[-1])
            )
        )
    slider = system.AddNode(items.NodePoint2D(referenceCoordinates=[CRANK + ROD, 0]))
    bodies.append(system.AddObject(items.ObjectMassPoint2D(mass=SLIDER, nodeNumber=slider)))
    for body, (mass, *_) in zip(bodies, (CRANK_BODY, ROD_BODY, (SLIDER,)), strict=True):
        middle = system.AddMarker(items.MarkerBodyPosition(bodyNumber=body))
        system.AddLoad(
            items.LoadForceVector(markerNumber=middle, loadVector=[0, mass * GRAVITY, 0])
        )

    def pin(body: int, at: float) -> Any:
        return system.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[at, 0, 0]))

    ends = {
        "O": (pin(ground, 0.0), pin(bodies[0], -CRANK_BODY[2])),
        "A": (pin(bodies[0], CRANK - CRANK_BODY[2]), pin(bodies[1], -ROD_BODY[2])),
        "B": (pin(bodies[1], ROD - ROD_BODY[2]), pin(bodies[2], 0.0)),
    }
    joints = {
        name: system.AddObject(items.ObjectJointRevolute2D(markerNumbers=list(markers)))
        for name, markers in ends.items()
    }
    still = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=fixed, coordinate=0))

    def coordinate(node: Any, number: int) -> Any:
        return system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=number))

    system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[still, coordinate(slider, 1)]))

    def motor(_s: Any, _t: float, _i: int, _u: float, v: float, *_: float) -> float:
        return -GEARED.torque(v)[0]

    def gas(_s: Any, _t: float, _i: int, u: float, *_: float) -> float:
        return -PUSH * (AT / (CRANK + ROD + u)) ** POWER

    for node, number, force in ((nodes[0], 2, motor), (slider, 0, gas)):
        system.AddObject(
            items.ObjectConnectorCoordinateSpringDamper(
                markerNumbers=[still, coordinate(node, number)],
                stiffness=1.0,
                damping=1.0,
                springForceUserFunction=force,
            )
        )
    kept = {
        name: system.AddSensor(
            items.SensorNode(nodeNumber=nodes[0], storeInternal=True, outputVariableType=kind)
        )
        for name, kind in (
            ("angle", exu.OutputVariableType.Coordinates),
            ("speed", exu.OutputVariableType.Coordinates_t),
        )
    }
    pins = {
        name: system.AddSensor(
            items.SensorObject(
                objectNumber=joint,
                storeInternal=True,
                outputVariableType=exu.OutputVariableType.Force,
            )
        )
        for name, joint in joints.items()
    }
    system.Assemble()
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps, integration.endTime = steps, duration
    integration.newton.relativeTolerance = 1e-10
    integration.generalizedAlpha.spectralRadius = 0.9
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = duration / steps
    system.SolveDynamic(settings)
    angle = system.GetSensorStoredData(kept["angle"])
    found = {
        "time": angle[:, 0],
        "angle": angle[:, 3],
        "speed": system.GetSensorStoredData(kept["speed"])[:, 3],
    }
    return found | {
        name: -system.GetSensorStoredData(sensor)[:, 1:3]  # theirs is on the first body
        for name, sensor in pins.items()
    }


def _last_turn(run: dict[str, np.ndarray], positions: np.ndarray) -> dict[str, np.ndarray]:
    """Quantities of a run at crank angles of its last turn."""
    from scipy.interpolate import CubicSpline

    rows = run["angle"] > 2 * np.pi * (TURNS - 1) - 0.1
    at = positions + 2 * np.pi * (TURNS - 1)
    return {
        name: CubicSpline(run["angle"][rows], values[rows])(at)
        for name, values in run.items()
        if name != "angle"
    }


def differences(exu: Any) -> tuple[loads.CycleLoads, list[tuple[str, float, float]]]:
    """Our turn; in words, largest difference of both, and what half of exudyn's step changes."""
    ours = by_ballesta()
    speed, duration = ours.velocities[:, 1, 2], float(ours.times[-1])
    start, whole = 1.05 * float(speed[0]), (TURNS + 0.05) * duration
    runs = [_last_turn(by_exudyn(exu, start, n, whole), ours.positions) for n in STEPS]
    for run in runs:
        run["time"] = run["time"] - run["time"][0]
    quantities = [
        ("speed over its mean", "speed", speed, 2 * np.pi / duration),
        ("time since the start over a turn's", "time", ours.times, duration),
    ]
    for name in PINS:
        force = ours.reactions[name].force
        size = float(np.hypot(*force.T).max())
        quantities.append((f"force of pin {name} over its largest", name, force, size))
    found = []
    for words, name, own, size in quantities:
        other, finer = (run[name] for run in runs)
        apart = float(np.abs(own - finer).max()) / size
        found.append((words, apart, float(np.abs(other - finer).max()) / size))
    return ours, found


def main() -> int:
    """Print the largest differences over the last turn; 0 where they are as small as asked."""
    try:
        import exudyn as exu
    except ImportError:
        print("exudyn is not installed: nothing is compared (pip install exudyn==1.13.6)")
        return 1
    ours, found = differences(exu)
    speed = ours.velocities[:, 1, 2]
    print(f"{ours.times[-1]:.9f} s a turn; {speed.min():.6f} to {speed.max():.6f} rad/s")
    print(f"{'largest difference':<40} {'from exudyn':>12} {'its half step':>14}")
    for words, apart, step in found:
        print(f"{words:<40} {apart:12.2e} {step:14.2e}")
    holds = all(apart <= ASKED for _, apart, _ in found)
    print("holds" if holds else "DOES NOT HOLD", f"{ASKED:g}")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
