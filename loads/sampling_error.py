"""Rise of loads between the positions of a cycle: the part that too few positions miss."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from loads.bodies import FloatArray
from loads.forces import ForceSolution
from loads.kinematics import rotated
from loads.motion import Motion


@dataclass(frozen=True)
class Unresolved:
    """The largest load that other positions of a cycle have and its own have not.

    share  by which it is beyond that at the cycle's positions, over the largest of its kind
    what   the load, in words
    """

    share: float
    what: str


NOTHING = Unresolved(0.0, "")
LEAST_SIZE = 1e-9  # over the largest load: below it stands what rounding leaves of balanced halves
Solved = Sequence[tuple[Motion, ForceSolution]]


def unresolved(cycle: Solved, others: Sequence[Solved]) -> Unresolved:
    """Return the peaks that the positions of a cycle miss, found at other positions of it.

    cycle   motion and loads, phase by phase, at the positions that count
    others  the same at other positions

    Compared are the largest and least components of every joint's force in the axes of both its
    bodies, over the joint's largest force, and those of every effort over the largest effort: what
    bends and presses the parts. A size is at least `LEAST_SIZE` of the largest of all. A smooth
    peak between positions a step h apart is missed by a share of order h^2, so that a grid as fine
    as the cycle's own but placed otherwise tells its size.
    """
    found = NOTHING
    taken = {what: (low, high, size) for what, low, high, size in _extremes(cycle)}
    least_size = LEAST_SIZE * max(size for _, _, size in taken.values())
    for other in others:
        for what, low, high, size in _extremes(other):
            least, most, largest = taken[what]
            scale = max(size, largest, least_size)
            share = max(high - most, least - low, 0.0) / scale if scale else 0.0
            if share > found.share:
                found = Unresolved(share, what)
    return found


def _extremes(solved: Solved) -> Iterator[tuple[str, float, float, float]]:
    """Least and largest of every load over all phases, and the size of its kind."""
    motion, solution = solved[0]
    linkage = motion.kinematics.linkage
    for joint in linkage.joints:
        forces = [s.joints[joint.name].force for _, s in solved]
        size = max(float(np.hypot(*force.T).max()) for force in forces)
        for body in (joint.body_a, joint.body_b):
            row = motion.kinematics.index[body]
            turned = [
                rotated(force, -m.poses[:, row, 2])
                for force, (m, _) in zip(forces, solved, strict=True)
            ]
            for axis, name in enumerate("xy"):
                yield (
                    f"{name} of the force in joint {joint.name} on {body}",
                    *_ends([force[:, axis] for force in turned]),
                    size,
                )
    for name in solution.efforts:
        low, high = _ends([s.efforts[name] for _, s in solved])
        yield f"the effort of {name}", low, high, max(-low, high)


def _ends(values: Sequence[FloatArray]) -> tuple[float, float]:
    return min(float(v.min()) for v in values), max(float(v.max()) for v in values)
