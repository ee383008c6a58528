"""Forces against the motion, and the reversals at which they jump.

A force of the law `Opposing` acts along its own coordinate q, against q's rate: of size
F_0 + c |q'|, or as a table over |q'| says, so its power -F |q'| is never above 0. Where q reverses
within a phase, dry friction jumps from one side to the other: there a phase ends and another one
begins, both with their own force at the same position, as at any other jump of a force.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.breakpoints import with_extremes, with_roots
from loads.joints import Coordinate
from loads.kinematics import dot
from loads.laws import Opposing
from loads.linkage import Linkage
from loads.motion import Motion, coordinate_share
from loads.path import Path, trace
from loads.phases import Cycle, Phase

_STEPS = 400  # of a phase, at first, between which a coordinate may reverse
_STILL = 1e-9  # share of the motion: below it a coordinate stands still, for round-off
_EDGE = 1e-6  # of a phase: a reversal nearer to its end is its end


def opposing(motion: Motion, name: str, law: Opposing) -> FloatArray:
    """Return the value of a force against the motion (n,), N or N mm.

    Raises LinkageError where a table does not cover the speed.
    """
    kinematics, n = motion.kinematics, len(motion.values)
    force = kinematics.linkage.force(name)
    speed = coordinate_speed(motion, name)
    size = law.dry + law.viscous * speed
    if law.speeds:
        if speed.max() > law.speeds[-1] * (1 + _STILL):
            unit, factor = ("rad/s", 1.0) if force.coordinate.angular else ("m/s", 1e-3)
            raise LinkageError(
                f"force {name!r}: its table goes up to {factor * law.speeds[-1]:g} {unit} and does "
                f"not cover {factor * speed.max():g} {unit} at {motion.place(int(speed.argmax()))}"
            )
        size = np.interp(speed, law.speeds, law.forces)
    share = coordinate_share(kinematics, force.coordinate, motion.poses, motion.heading)
    way = np.where(np.abs(share) > _STILL, np.sign(share), 0.0)
    if n > 1:  # an end at a reversal belongs to its own phase
        way[0], way[-1] = way[0] or way[1], way[-1] or way[-2]
    return np.asarray(-force.sign * way * size)


def coordinate_speed(motion: Motion, name: str) -> FloatArray:
    """Return the speed of a force's own coordinate (n,), mm/s or rad/s, never negative."""
    coordinate = motion.kinematics.linkage.force(name).coordinate
    gradient = motion.kinematics.gradient(coordinate, motion.poses)
    return np.asarray(np.abs(dot(gradient, motion.velocities.reshape(len(gradient), -1))))


def split_at_reversals(linkage: Linkage, cycle: Cycle) -> tuple[Cycle, tuple[int, ...]]:
    """Return the cycle with phases that end where a force against the motion reverses.

    Beside it the number of the phase, before the split, from which each has come. Parts of a phase
    are named <phase>-1, <phase>-2 and so on. Raises LinkageError where the cycle cannot be traced.
    """
    against = [
        [linkage.force(name).coordinate for name, law in phase.given.items()
         if isinstance(law, Opposing)]
        for phase in cycle.phases
    ]  # fmt: skip
    if not any(against):
        return cycle, tuple(range(len(cycle.phases)))
    ends = [cycle.start, *(phase.stop for phase in cycle.phases)]
    path = trace(linkage, cycle.coordinate, min(ends), max(ends))
    taken = {phase.name for phase in cycle.phases}
    phases: list[Phase] = []
    origin: list[int] = []
    for k, (phase, span) in enumerate(zip(cycle.phases, pairwise(ends), strict=True)):
        inner = _reversals(path, against[k], *span)
        stops = [*inner, phase.stop]
        names = [phase.name] if not inner else _free(phase.name, len(stops), taken)
        phases += [replace(phase, name=n, stop=s) for n, s in zip(names, stops, strict=True)]
        origin += [k] * len(stops)
    return replace(cycle, phases=tuple(phases)), tuple(origin)


def _free(name: str, count: int, taken: set[str]) -> list[str]:
    """Names of the parts of a phase that no other phase has."""
    names = [f"{name}-{k + 1}" for k in range(count)]
    return names if not taken & set(names) else _free(f"{name}-", count, taken)


def _reversals(
    path: Path, coordinates: Sequence[Coordinate], start: float, stop: float
) -> list[float]:
    """Places between the ends of a phase where one of the coordinates reverses, on the way."""
    even = np.linspace(start, stop, _STEPS + 1)
    found: set[float] = set()
    for coordinate in coordinates:

        def share(grid: FloatArray, coordinate: Coordinate = coordinate) -> FloatArray:
            geometry = path.at(grid)
            return coordinate_share(path.kinematics, coordinate, geometry.poses, geometry.first)

        grid = with_extremes(even, share)
        found |= set(with_roots(grid, share).tolist()) - set(grid.tolist())
        values = share(grid)
        found |= set(grid[1:-1][(values[1:-1] == 0.0) & (values[:-2] * values[2:] < 0.0)].tolist())
    edge = _EDGE * abs(stop - start)
    places = sorted(found, reverse=bool(stop < start))
    kept: list[float] = []
    for place in places:
        if all(abs(place - other) > edge for other in (start, stop, *kept)):
            kept.append(place)
    return kept
