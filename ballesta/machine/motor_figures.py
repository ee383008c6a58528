"""Speed, torque and energy of a motor over a cycle."""

import numpy as np

import loads
from checks.design.data import Design
from checks.part.part_loads import shown_position
from geometry.mesh import FloatArray
from reports.loads_figures import MotorFigures


def motor_figures(design: Design, cycle: loads.CycleLoads) -> MotorFigures | None:
    """Return the figures of a cycle that a motor turns; None for any other."""
    stated = design.cycles[cycle.name]
    pace = stated.run.pace
    if not isinstance(pace, loads.MotorPace):
        return None
    geared = pace.motor
    drive = stated.run.phases[0].solve
    speed = np.abs(cycle.rate(drive))
    torque = np.array([geared.torque(float(value))[0] for value in speed])
    own = np.array([geared.motor.torque(float(value) * geared.ratio)[0] for value in speed])
    shown = shown_position(stated, cycle.positions)
    slowest, fastest = int(speed.argmin()), int(speed.argmax())
    duration = float(cycle.times[-1])
    return MotorFigures(
        slowest=float(speed[slowest]),
        slowest_at=float(shown[slowest]),
        fastest=float(speed[fastest]),
        fastest_at=float(shown[fastest]),
        mean=float(_summed(speed, cycle.times)) / duration,
        largest=float(np.abs(own).max()),
        effective=float(np.sqrt(_summed(own**2, cycle.times) / duration)),
        rated=geared.motor.rated_torque,
        power=float(_summed(own * speed * geared.ratio, cycle.times)) / duration,
        ratio=geared.ratio,
        missing=_missing(cycle, drive, torque * speed),
        speed=speed,
        torque=torque,
    )


def _missing(cycle: loads.CycleLoads, drive: str, power: FloatArray) -> float:
    """Energy of a turn that motor and drive do not agree on, over what the drive turns over."""
    sign = cycle.linkage.force(drive).sign
    taken = sign * cycle.efforts[drive] * cycle.rate(drive)
    whole = _summed(np.abs(taken), cycle.times)
    return float(abs(_summed(power - taken, cycle.times)) / whole) if whole else 0.0


def _summed(values: FloatArray, times: FloatArray) -> float:
    return float(np.trapezoid(values, times))
