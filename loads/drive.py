"""Effort, work and power of a drive over a cycle, and the irregularity of its speed."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.joints import Force
from loads.kinematics import Kinematics, dot, rotated, turned_left

_STEADY = 1e-6  # of the speed: what a steady speed may vary by rounding
_NO_TIME = 1e-12  # of a cycle


@dataclass(frozen=True, eq=False)
class DriveFigures:
    """Effort, work and power of one force or torque over a cycle.

    angular             True for a torque (N mm, rad), False for a force (N, mm)
    closed              True if the cycle ends in the pose that it starts from
    smallest, largest   N or N mm, signed
    mean_effort         over the way of its coordinate, N or N mm; 0 where it does not move
    work                N mm, done on the linkage over the cycle
    mean_power, peak_power  N mm/s; the peak is the largest magnitude
    reduced_mass        (n,) t or t mm2, kinetic energy over half the squared rate
    mean_reduced_mass   over the way
    speed               mm/s or rad/s, way over time
    energy_ripple       N mm, largest less smallest of the integral of effort - mean over the way;
                        None unless the cycle is closed and the coordinate turns at one speed
    """

    force: str
    angular: bool
    closed: bool
    smallest: float
    largest: float
    mean_effort: float
    work: float
    mean_power: float
    peak_power: float
    reduced_mass: FloatArray
    mean_reduced_mass: float
    speed: float
    energy_ripple: float | None

    @property
    def irregularity(self) -> float | None:
        """Largest less smallest speed over the mean speed that the ripple would cause.

        ripple / (mean reduced mass x speed^2) (Norton, Design of Machinery, ch. 11), which takes
        the speed as nearly constant: above some tenths it only says that the speed is not.
        Raises LinkageError where nothing that moves has mass.
        """
        if self.energy_ripple is None:
            return None
        if self.mean_reduced_mass <= 0.0:
            raise LinkageError(
                f"force {self.force!r}: nothing that it drives has a mass, so the ripple of "
                "its speed is unknown; state the masses"
            )
        return self.energy_ripple / (self.mean_reduced_mass * self.speed**2)

    def reduced_mass_for(self, irregularity: float) -> float | None:
        """Reduced mass [t, t mm2] in all, with a flywheel, that keeps to an irregularity."""
        if self.energy_ripple is None:
            return None
        return self.energy_ripple / (irregularity * self.speed**2)


def drive_figures(
    kinematics: Kinematics,
    force: Force,
    efforts: FloatArray,
    times: FloatArray,
    poses: FloatArray,
    velocities: FloatArray,
    heading: FloatArray,
) -> DriveFigures:
    """Return the figures of a force over the positions of a cycle."""
    n = len(times)
    coordinate = force.coordinate
    gradient = kinematics.gradient(coordinate, poses)
    steps = kinematics.steps(coordinate, poses)
    # from one turn of a start to the next the positions go back to the first one's, in no time
    steps = np.where(np.diff(times) > _NO_TIME * float(times[-1]), steps, 0.0)
    way = float(np.abs(steps).sum())
    push = force.sign * efforts
    work = float(np.sum(0.5 * (push[:-1] + push[1:]) * steps))
    lead = dot(gradient, heading.reshape(n, -1))
    energy = 2.0 * kinetic_energy(kinematics, poses, heading, kinematics.linkage.body_names)
    reduced = np.divide(energy, lead**2, out=np.full(n, np.inf), where=lead != 0.0)
    duration = float(times[-1] - times[0])
    closed = is_closed(kinematics, poses)
    rate = dot(gradient, velocities.reshape(n, -1))
    steady = bool(np.ptp(rate) <= _STEADY * np.abs(rate).max())
    ripple = None
    if closed and steady and coordinate.angular and way > 0.0:
        value = kinematics.value(coordinate, poses)
        mean = work / float(value[-1] - value[0])
        left = push - mean
        stored = np.concatenate([[0.0], np.cumsum(0.5 * (left[:-1] + left[1:]) * steps)])
        ripple = float(np.ptp(stored))
    weights = np.abs(steps) / way if way else np.zeros(n - 1)
    middle = 0.5 * (reduced[:-1] + reduced[1:])
    # the reduced mass is infinite where the coordinate stands still; the mean then is, too
    moving = weights > 0.0
    mean_mass = float(np.sum(weights[moving] * middle[moving])) if way else float("inf")
    return DriveFigures(
        force=force.name,
        angular=coordinate.angular,
        closed=closed,
        smallest=float(efforts.min()),
        largest=float(efforts.max()),
        mean_effort=float(np.sum(weights * 0.5 * (efforts[:-1] + efforts[1:]))),
        work=work,
        mean_power=work / duration if duration else 0.0,
        peak_power=float(np.abs(push * rate).max()),
        reduced_mass=reduced,
        mean_reduced_mass=mean_mass,
        speed=way / duration if duration else 0.0,
        energy_ripple=ripple,
    )


def kinetic_energy(
    kinematics: Kinematics, poses: FloatArray, rates: FloatArray, bodies: Collection[str]
) -> FloatArray:
    """Return the kinetic energy of some bodies for rates of the poses (n,)."""
    total = np.zeros(len(poses))
    for i, body in enumerate(kinematics.linkage.moving, start=1):
        if body.name not in bodies:
            continue
        arm = rotated(np.array(body.centre, dtype=float), poses[:, i, 2])
        spin = rates[:, i, 2]
        speed = rates[:, i, :2] + spin[:, None] * turned_left(arm)
        total += 0.5 * (body.mass * dot(speed, speed) + body.inertia * spin**2)
    return total


def is_closed(kinematics: Kinematics, poses: FloatArray) -> bool:
    """Return True if the last pose is the first, whole turns aside."""
    change = poses[-1, 1:] - poses[0, 1:]
    turns = change[:, 2] / (2.0 * np.pi)
    change = change.copy()
    change[:, 2] = 2.0 * np.pi * (turns - np.round(turns))
    scaled = np.abs(change.reshape(-1) / kinematics.pose_scale)
    return bool(scaled.max(initial=0.0) < 1e-6)
