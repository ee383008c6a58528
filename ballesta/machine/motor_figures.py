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
        mean=float(_summed(cycle, speed)) / duration,
        largest=float(np.abs(own).max()),
        effective=float(np.sqrt(_summed(cycle, own**2) / duration)),
        rated=geared.motor.rated_torque,
        power=float(_summed(cycle, own * speed * geared.ratio)) / duration,
        ratio=geared.ratio,
        missing=_missing(cycle, drive, torque * speed),
        speed=speed,
        torque=torque,
    )


def _missing(cycle: loads.CycleLoads, drive: str, power: FloatArray) -> float:
    """Energy balance error of a turn: motor less drive, over the energy the drive turns over."""
    sign = cycle.linkage.force(drive).sign
    taken = sign * cycle.efforts[drive] * cycle.rate(drive)
    whole = _summed(cycle, np.abs(taken))
    return float(abs(_summed(cycle, power - taken)) / whole) if whole else 0.0


def _summed(cycle: loads.CycleLoads, values: FloatArray) -> float:
    """Integral over the time of a cycle, by parabolas within each phase."""
    from scipy.integrate import simpson

    rows = [cycle.phase_of == k for k in range(len(cycle.phases))]
    return float(sum(simpson(values[row], x=cycle.times[row]) for row in rows))
