"""Shapes in which bars buckle, as displacements of the nodes of a part's surface.

They are those of the formula that gives the buckling load: Euler's half wave, a bar that is bent
aside and twists, a stretch by itself. Their size is free.
"""

from collections.abc import Callable
from math import pi

import numpy as np

from checks.handbook.bar_forces import deflection
from checks.handbook.column_curves import lateral_twist
from geometry.mesh import FloatArray

Mode = Callable[[FloatArray], FloatArray]
"""Displacements (n, 3) of nodes (n, 3) mm, in the part's frame."""
_PLACES = 65  # of an axis


def moved_with(nodes: FloatArray, places: FloatArray, motions: FloatArray) -> FloatArray:
    """Displacements (n, 3) of nodes (n, 3) whose sections move with the axis of a bar.

    places   (m, 3) mm of the axis, in a straight row; a single one is of a rigid body
    motions  (m, 6) mm and rad
    """
    way = places[-1] - places[0]
    along = places @ way
    order = np.argsort(along)
    axis = np.hstack([places, motions])[order]
    at = np.stack([np.interp(nodes @ way, along[order], column) for column in axis.T], axis=1)
    return np.asarray(at[:, 3:6] + np.cross(at[:, 6:9], nodes - at[:, :3]))


def half_wave(first: FloatArray, last: FloatArray, plane: str) -> Mode:
    """Euler's mode of an even bar from `first` to `last` (3,) mm, hinged; sections turn with it."""
    share = np.linspace(0.0, 1.0, _PLACES)[:, None]
    way, out = last - first, np.array([0.0, 0.0, 1.0])
    length = np.linalg.norm(way)
    aside = np.cross(out, way / length) if plane == "in plane" else out
    slope = pi / length * np.cos(pi * share)
    turns = slope * np.cross(way / length, aside)
    places, motions = first + share * way, np.hstack([np.sin(pi * share) * aside, turns])
    return lambda nodes: moved_with(nodes, places, motions)


def laid_straight(corners: FloatArray) -> Mode:
    """Euler's mode in the plane of a bar along corners x + i y, mm, as if they stood in a row.

    It has the half wave's curvature at every place, and both ends stay on the line between them.
    """
    arms = np.diff(corners)
    reached = np.r_[0.0, np.cumsum(np.abs(arms))]
    along = np.linspace(0.0, reached[-1], _PLACES)
    at, _ = _on_arms(corners, along)
    turn = pi / reached[-1] * np.cos(pi * along / reached[-1])
    moved = np.r_[0.0, np.cumsum(1j * (turn[1:] + turn[:-1]) / 2 * np.diff(at))]
    chord = corners[-1] - corners[0]
    back = (moved[-1] / chord).imag
    moved, turn = moved - 1j * back * (at - corners[0]), turn - back
    nothing = np.zeros_like(along)
    places = np.stack([at.real, at.imag, nothing], axis=1)
    motions = np.stack([moved.real, moved.imag, nothing, nothing, nothing, turn], axis=1)
    return lambda nodes: moved_with(nodes, places, motions)


def bent_aside(
    corners: FloatArray, along: FloatArray, aside: FloatArray, slope: FloatArray, twist: FloatArray
) -> Mode:
    """The mode of a bent and twisted bar laid along corners x + i y, mm.

    along  (m,) mm from the first corner, at which it has w, w' and t
    """
    at, way = _on_arms(corners, along)
    nothing = np.zeros_like(along)
    turns = twist * way - 1j * slope * way
    places = np.stack([at.real, at.imag, nothing], axis=1)
    motions = np.stack([nothing, nothing, aside, turns.real, turns.imag, nothing], axis=1)
    return lambda nodes: moved_with(nodes, places, motions)


def _on_arms(corners: FloatArray, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places x + i y and directions (m,) at distances along corners from the first."""
    arms = np.diff(corners)
    reached = np.r_[0.0, np.cumsum(np.abs(arms))]
    arm = np.clip(np.searchsorted(reached, along) - 1, 0, len(arms) - 1)
    way = (arms / np.abs(arms))[arm]
    return corners[arm] + (along - reached[arm]) * way, way


def sideways(
    compression: float,
    moment: FloatArray,
    stiffness: tuple[FloatArray, FloatArray],
    twisting: FloatArray,
    length: float,
    pressed: tuple[float, float],
    held_last: bool,
    nodes: FloatArray,
) -> FloatArray:
    """The mode of a bar along x that is bent in its plane and pressed (`lateral_share`).

    stiffness  (k,) E I out of the plane between the pins, and between where they press
    pressed    mm, where both pins press
    held_last  as `lateral_share` has it

    With p and m of the compression and of the moment alone, and W and T for w and t of unit energy,
    (1 - s p) W = s m T and T = s m W at the factor s: m t has T = m, and w is p times the column's
    wave and s m^2 times what E I w'' = -M t gives, of unit energy each. A bar goes straight on
    beyond the places where it is pressed, and its pins stand still.
    """
    across, firm = stiffness
    x = np.linspace(0.0, length, len(moment))
    bent, twist = lateral_twist(moment, across, twisting, length, held_last=held_last)
    share = (compression + np.sqrt(compression**2 + 4 * bent**2)) / 2
    (first, last), column = pressed, pressed[1] - pressed[0]
    angle = pi * np.clip((x - first) / column, 0.0, 1.0)
    beyond = np.maximum(first - x, 0.0) + np.maximum(x - last, 0.0)
    wave = np.sin(angle) - pi / column * beyond
    wave -= wave[0] + (wave[-1] - wave[0]) * x / length
    s = np.linspace(0.0, pi, len(firm))
    wave /= np.sqrt(np.trapezoid(firm * np.sin(s) ** 2, s) * (pi / column) ** 3)
    by_moment = deflection((-bent / share * moment * twist)[:, None], across, x)[:, 0]
    if by_moment @ wave < 0.0:
        wave = -wave
    aside = compression * wave + by_moment
    slope = np.gradient(aside, x, edge_order=2)
    return bent_aside(np.array([0.0, length]), x, aside, slope, bent * twist)(nodes)


def from_start(mode: Mode, start: float, nodes: FloatArray) -> FloatArray:
    """A mode whose x begins at `start`, mm, of nodes (n, 3)."""
    return mode(nodes - [start, 0.0, 0.0])
