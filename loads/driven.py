"""Cycles that a motor can turn over and over, and how the force solved for follows its angle."""

from collections.abc import Sequence

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.drive import is_closed
from loads.kinematics import Kinematics, dot
from loads.motion import Geometry
from loads.phases import Cycle

_SAME = 1e-9  # of a rate


def driven_by(cycle: Cycle, kinematics: Kinematics, places: Sequence[Geometry]) -> list[FloatArray]:
    """Return per phase the torque along the way over the force solved for (n,): 1 or -1.

    Raises LinkageError unless the cycle goes round once and again in one direction, by the angle
    that sets its pace, and every phase solves for a torque on that angle.
    """
    pace = cycle.pace.coordinate
    if cycle.coordinate != pace:
        raise LinkageError(
            f"cycle {cycle.name!r}: a motor turns {pace.label}, so that coordinate must lead the "
            f"cycle, not {cycle.coordinate.label}"
        )
    ends = np.stack([places[0].poses[0], places[-1].poses[-1]])
    rising = {stop > start for start, stop in cycle.spans}
    if len(rising) > 1 or not is_closed(kinematics, ends):
        raise LinkageError(
            f"cycle {cycle.name!r}: a motor turns {pace.label} over and over, so the cycle must go "
            "on in one direction and end in the pose that it starts from"
        )
    if len({phase.solve for phase in cycle.phases}) > 1:
        raise LinkageError(
            f"cycle {cycle.name!r}: one torque on {pace.label} is the motor's, so all phases must "
            "solve for the same"
        )
    found = []
    for phase, geometry in zip(cycle.phases, places, strict=True):
        force = kinematics.linkage.force(phase.solve)
        first = geometry.first.reshape(len(geometry.values), -1)
        rates = [
            dot(kinematics.gradient(coordinate, geometry.poses), first)
            for coordinate in (force.coordinate, pace)
        ]
        if (
            not force.coordinate.angular
            or (np.abs(np.abs(rates[0] / rates[1]) - 1.0) > _SAME).any()
        ):
            raise LinkageError(
                f"cycle {cycle.name!r}, phase {phase.name!r}: the motor turns {pace.label}, so the "
                f"phase must solve for a torque on it, not for {force.name!r}"
            )
        found.append(force.sign * np.sign(rates[0] * (1.0 if rising == {True} else -1.0)))
    return found
