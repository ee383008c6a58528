"""A picture of the mechanism as SVG, and the numbers by which a page's script moves it.

Lengths are mm of the machine; y points down in SVG, so y and angles change their sign here.
"""

from typing import Any

import numpy as np

from checks.result.words import brief, number, quantity_unit
from reports.loads_figures import FloatArray
from reports.loads_summary import ShownCycle
from reports.mechanism_layout import Layout
from reports.mechanism_picture import TIP, Picture

_MOST_FRAMES = 240


def mechanism_svg(cycle: ShownCycle, prefix: str) -> str:
    """The linkage as it is assembled: bodies, pivots, guides, slots and the paths of its points.

    Every moving thing has an id that begins with `prefix`, for the script; arrows are hidden.
    """
    label = f"The mechanism in cycle {brief(cycle.name, 40)}, as it is assembled"
    return Picture(Layout(cycle.loads), prefix).svg(label)


def mechanism_data(cycle: ShownCycle, prefix: str) -> dict[str, Any]:
    """Data for the script to show any position: poses, points, arrows and readings by frame."""
    loads = cycle.loads
    layout = Layout(loads)
    frames = _frames(len(loads.times))
    poses = loads.poses[frames, 1:]
    moved = np.stack([poses[..., 0], -poses[..., 1], -np.degrees(poses[..., 2])], axis=-1)
    torques = layout.torques[frames] * layout.scaled(layout.turned)[frames, None]
    return {
        "prefix": prefix,
        "bodies": _rounded(moved.reshape(len(frames), -1), 3),
        "points": _rounded(layout.marked[frames].reshape(len(frames), -1), 3),
        "spans": _rounded(layout.span_ends[frames].reshape(len(frames), -1), 3),
        "arrows": _rounded(layout.arrow_ends[frames].reshape(len(frames), -1), 3),
        "barrels": [_rounded(length, 3) for length in layout.barrels],
        "torques": _rounded(torques, 4),
        "centres": _rounded(layout.centres[frames].reshape(len(frames), -1), 3),
        "times": _rounded(loads.times[frames], 6),
        "readings": [_reading(cycle, int(frame)) for frame in frames],
        "duration": cycle.duration,
        "lifts": [round(lift, 3) for lift in Picture(layout, prefix).lifts],
        "tip": TIP * layout.unit,
    }


def arrow_scale(cycle: ShownCycle) -> str:
    """Force that the longest arrow of the picture stands for, in words."""
    return force_text(Layout(cycle.loads).largest[0])


def force_text(force: float) -> str:
    """A force in the unit in which it is read well, N or kN."""
    unit, factor = quantity_unit(False, force)
    return f"{number(force * factor, 4)} {unit}"


def _frames(n: int) -> Any:
    return np.unique(np.linspace(0, n - 1, min(n, _MOST_FRAMES)).round().astype(int))


def _rounded(values: FloatArray, digits: int) -> Any:
    return (np.round(values, digits) + 0.0).tolist()


def _reading(cycle: ShownCycle, index: int) -> str:
    """Position, phase, time and efforts in one line."""
    said = [
        f"{brief(cycle.shown_name, 20)} = {cycle.shown[index] + 0.0:.1f} {cycle.unit}",
        f"{cycle.loads.times[index]:.3f} s",
        brief(cycle.phase_at(index), 24),
    ]
    for effort in cycle.efforts:
        unit, factor = quantity_unit(effort.angular, effort.largest)
        value = float(cycle.loads.efforts[effort.quantity][index])
        if abs(value) < 1e-9 * effort.largest:
            value = 0.0
        said.append(f"{brief(effort.quantity, 24)} {number(value * factor)} {unit}")
    return " · ".join(said)
