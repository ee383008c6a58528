"""Pull-through: a drive takes a linkage through its dead centre against an elastic resistance.

Near a dead centre of the process a rigid linkage presses without bound. The body that it presses on
and the linkage itself give way. A resistance of stiffness k in all, touched at some position, asks
the drive for a force that first rises and then falls again towards the dead centre, where the drive
holds nothing. If the drive can give the largest of these forces, nothing stops the linkage there.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from loads.bodies import FloatArray, Force, LinkageError
from loads.forces import solve_forces
from loads.kinematics import Kinematics
from loads.linkage import Linkage
from loads.motion import Geometry, Motion, coordinate_share
from loads.path import Path, assemble, trace

_POSITIONS = 400
_DOUBLINGS = 200
_TOGETHER = 34  # places between which a sign changes, asked together
_HALVINGS = 200
_CLOSE = 1e-10  # of a force, or of a stiffness
_STEP = 0.1  # of the size of the linkage, the first way looked ahead


@dataclass(frozen=True)
class PullThrough:
    """The stiffness below which a drive pulls a linkage through its dead centre.

    stiffness    N/mm (N mm/rad), of everything in the way of the process force, in series
    force        N (N mm), what the process force reaches at the dead centre at that stiffness
    dead_centre  mm or rad, value of the drive's coordinate there
    """

    stiffness: float
    force: float
    dead_centre: float


def pull_through(
    linkage: Linkage,
    drive: str,
    pull: float,
    process: str,
    touch: float,
    given: Mapping[str, float] | None = None,
) -> PullThrough | None:
    """Return the stiffness that a drive just overcomes, at rest.

    pull   N (N mm) of the drive, constant
    touch  mm or rad, value of the process force's coordinate where the resistance begins
    given  all other forces

    The stiffness is of everything in series, the compliance of the linkage included.
    None where the way from the assembled pose has no dead centre of the process, or does not come
    by the touch before it. Raises LinkageError where friction locks the linkage on the way.
    """
    if drive == process:
        raise LinkageError(f"force {drive!r} cannot be drive and process at once")
    if not (np.isfinite(pull) and pull and np.isfinite(touch)):
        raise LinkageError(f"pull {pull:g} and touch {touch:g} must be finite, the pull not 0")
    moving, resisting = linkage.force(drive), linkage.force(process)
    way = int(np.sign(pull)) * moving.sign
    path, dead_centre = _to_dead_centre(linkage, moving, resisting, way)
    if path is None:
        return None
    start = _touched(path, resisting, touch, dead_centre, way)
    if start is None:
        return None
    grid = np.linspace(start, dead_centre, _POSITIONS + 1)[1:-1]
    motion = _at_rest(path.at(grid), way)
    depth = np.abs(path.kinematics.value(resisting.coordinate, motion.poses) - touch)
    sense = _sense(path, resisting, start, dead_centre)

    def hardest(stiffness: float) -> float:
        """Largest force of the drive, less the pull, N."""
        forces: dict[str, float | FloatArray] = {**(given or {})}
        forces[process] = sense * stiffness * depth
        needed = np.sign(pull) * solve_forces(motion, forces, drive).efforts[drive]
        return _peak(needed, int(np.argmax(needed))) - abs(pull)

    if depth.max() <= 1e-12 * path.kinematics.coordinate_scale(resisting.coordinate):
        return None
    low, high = 0.0, abs(pull) / float(depth.max())
    below = hardest(low)
    if below >= 0.0:
        return PullThrough(0.0, 0.0, dead_centre)
    for _ in range(_DOUBLINGS):
        above = hardest(high)
        if above >= 0.0:
            break
        low, below, high = high, above, 2.0 * high
    else:
        return None  # nothing that is touched asks the drive for anything
    stiffness = _zero(hardest, (low, high), (below, above))
    deepest = abs(float(_process_value(path, resisting, dead_centre)) - touch)
    return PullThrough(stiffness, stiffness * deepest, dead_centre)


def _zero(
    function: Callable[[float], float], ends: tuple[float, float], values: tuple[float, float]
) -> float:
    """Return where a function that rises from below 0 to above comes to 0.

    By false position; an end that stays for a second time counts half (Illinois), so that both
    come near.
    """
    (low, high), (below, above) = ends, values
    close = _CLOSE * (above - below)
    stayed = 0
    for _ in range(_HALVINGS):
        middle = low + (high - low) * (below / (below - above))
        value = function(middle)
        if abs(value) <= close or high - low <= _CLOSE * high:
            return middle
        if value < 0.0:
            low, below = middle, value
            above *= 0.5 if stayed > 0 else 1.0
            stayed = 1
        else:
            high, above = middle, value
            below *= 0.5 if stayed < 0 else 1.0
            stayed = -1
    return middle  # where it jumps over 0


def _peak(values: FloatArray, k: int) -> float:
    """Return the top of the parabola through a largest value and its neighbours."""
    if not 0 < k < len(values) - 1:
        return float(values[k])
    before, top, after = (float(value) for value in values[k - 1 : k + 2])
    bend = before - 2.0 * top + after
    return top - (after - before) ** 2 / (8.0 * bend) if bend < 0.0 else top


def _to_dead_centre(
    linkage: Linkage, moving: Force, resisting: Force, way: int
) -> tuple[Path | None, float]:
    """Return the path of the drive from the assembled pose to the process's dead centre."""
    kinematics = Kinematics(linkage)
    start = float(kinematics.value(moving.coordinate, assemble(kinematics))[0])
    reach = _STEP * kinematics.coordinate_scale(moving.coordinate)
    step, last = reach, start
    for _ in range(60):
        try:
            path = trace(linkage, moving.coordinate, start, last + way * step)
        except LinkageError:
            step /= 2.0  # the drive's own end of travel is near
            if step < 1e-6 * reach:
                return None, 0.0
            continue
        last += way * step
        step *= 3.0
        share = _process_share(path, resisting, path.values)
        turned = np.flatnonzero(share[1:] * share[:-1] <= 0.0)
        if len(turned):
            k = turned[0] if way > 0 else turned[-1]
            return path, _dead_centre(path, resisting, path.values[k : k + 2])
    return None, 0.0


def _process_share(path: Path, resisting: Force, values: FloatArray) -> FloatArray:
    geometry = path.at(values)
    return coordinate_share(path.kinematics, resisting.coordinate, geometry.poses, geometry.first)


def _process_value(path: Path, resisting: Force, value: float) -> float:
    poses = path.poses_at(np.array([value]))
    return float(path.kinematics.value(resisting.coordinate, poses)[0])


def _dead_centre(path: Path, resisting: Force, ends: FloatArray) -> float:
    def share(values: FloatArray) -> FloatArray:
        return _process_share(path, resisting, values)

    low, high = _crossing(share, float(ends[0]), float(ends[1]))
    return 0.5 * (low + high)


def _crossing(
    function: Callable[[FloatArray], FloatArray], low: float, high: float
) -> tuple[float, float]:
    """Return neighbouring numbers between which a function changes its sign from that at `low`.

    Of two places it is asked many between them together: the linkage closes at all of them at once.
    """
    sign = np.sign(function(np.array([low]))[0])
    while True:
        values = np.linspace(low, high, _TOGETHER)
        inside = values[1:-1]
        inside = inside[(inside != low) & (inside != high)]
        if not len(inside):
            return low, high
        others = np.flatnonzero(np.sign(function(inside)) != sign)
        first = int(others[0]) if len(others) else len(inside)
        ends = [low, *inside.tolist(), high]
        low, high = ends[first], ends[first + 1]


def _touched(
    path: Path, resisting: Force, touch: float, dead_centre: float, way: int
) -> float | None:
    """Return the drive's coordinate where the process coordinate is at the touch, before the end.

    None where the linkage does not come by it on its way.
    """
    kinematics = path.kinematics
    before = path.values[way * path.values < way * dead_centre]
    values = np.append(before if way > 0 else before[::-1], dead_centre)
    off = kinematics.value(resisting.coordinate, path.poses_at(values)) - touch
    crossing = np.flatnonzero(off[1:] * off[:-1] <= 0.0)
    if not len(crossing):
        return None

    def beyond(values: FloatArray) -> FloatArray:
        return kinematics.value(resisting.coordinate, path.poses_at(values)) - touch

    return _crossing(beyond, *(float(value) for value in values[crossing[-1] :][:2]))[1]


def _sense(path: Path, resisting: Force, start: float, dead_centre: float) -> int:
    """Return the sign of the process force's value that works against the motion."""
    begin, end = (_process_value(path, resisting, value) for value in (start, dead_centre))
    return -int(np.sign(end - begin)) * resisting.sign


def _at_rest(geometry: Geometry, way: int) -> Motion:
    still = np.zeros_like(geometry.poses)
    return Motion(
        geometry.kinematics,
        geometry.coordinate,
        geometry.values,
        geometry.poses,
        still,
        still,
        geometry.first * way,
    )
