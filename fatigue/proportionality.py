"""First pass over all points: straightness of each stress path, and bounds of every criterion.

A path is proportional where it is a straight line in the space of all six components: the stress is
a constant plus one tensor times a number, whatever the constant is. The line taken is the main
axis of the deviator's second moments, which the moments of the coefficients give without the path;
the distances from it are taken from the path itself, so that a single spike counts in full.

    s_t        component of the deviator (von Mises norm) along the line; half its range is a
    e_t        the four components off the line, w = max |e_t|
    h_t        hydrostatic stress that does not go with s_t; half its range is g
    width      sqrt(w^2 + 9/2 g^2) / a, 0 for a straight path; 9/2 so that a change of stress counts
               with sqrt(3/2) times its Frobenius norm

With c the tensor in the middle of the line, R the radius of the path's ball around it, U the tensor
of the line per unit of s with principal stresses u_1 >= u_2 >= u_3 and trace 3 eta, proved in
docs/theory/multiaxial.md:

    half longest chord <= R
    Goodman's mean     <= largest principal of c + (2/3 + |eta|) sqrt(R^2 - a^2) + g, or 0
    Findley            <= k max(0, largest principal of c) + the smaller of
                            a [(u_1 - u_3)/2 sqrt(1 + k^2) + k |u_1 + u_3|/2]
                              + w (1/sqrt(3) + 2k/3) + k g
                            R (1/sqrt(3) + 2k/3) + k (|eta| a + g)
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from fatigue.stress_path import (
    TIE,
    FloatArray,
    check_history,
    deviatoric_basis,
    point_blocks,
    with_fewer_loads,
)

# The inverse of the rows of `deviatoric_basis`, on deviators.
_FROM_VECTOR = np.array(
    [
        [2.0 / 3.0, 0.0, 0.0, 0.0, 0.0],
        [-1.0 / 3.0, 1.0 / sqrt(3.0), 0.0, 0.0, 0.0],
        [-1.0 / 3.0, -1.0 / sqrt(3.0), 0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0 / sqrt(3.0), 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0 / sqrt(3.0), 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0 / sqrt(3.0)],
    ]
)
# A width up to which a path counts as proportional.
PROPORTIONAL = 0.01
# Bounds are raised by this fraction, more than `_principal` is off by, and by this much of the sum
# of the sizes of what is added up, more than `goodman` counts as round-off.
_MARGIN = 1e-7
_ROUND_OFF = 4e-12
_POWERS = 6
# From six components to the deviator's vector and the hydrostatic stress.
_READING = np.vstack([deviatoric_basis(np.eye(6)[None])[0], [[1.0 / 3.0] * 3 + [0.0] * 3]])
_SMALLER = 2  # blocks than elsewhere: the same path is read several times and should stay near


@dataclass(frozen=True, eq=False)
class PathBounds:
    """Bounds of each point's path under one cycle, all (n_points,).

    width      1, off-line distance over half the length; at most PROPORTIONAL: proportional
    amplitude  MPa, not less than half the longest chord, von Mises
    mean       MPa, not less than the mean of that chord as Goodman counts it
    findley    MPa, not less than Findley's parameter on any plane, compression without credit
    """

    width: FloatArray
    amplitude: FloatArray
    mean: FloatArray
    findley: FloatArray

    def __post_init__(self) -> None:
        n = len(self.width)
        shapes = [a.shape for a in (self.amplitude, self.mean, self.findley)]
        if shapes != [(n,)] * 3:
            raise ValueError(f"bounds of {n} points need three arrays ({n},), got {shapes}")


def path_bounds(basis: FloatArray, coefficients: FloatArray, k: float) -> PathBounds:
    """Return straightness and bounds of every point; k is the weight of Findley's normal stress.

    basis (n_points, 6, n_basis) and coefficients (n_basis, n_positions) as in `stress_path`. Costs
    about as much as the product that rebuilds the stress histories once more or twice.
    """
    basis, coefficients = with_fewer_loads(*check_history(basis, coefficients))
    mean = coefficients.mean(axis=1)
    swing = coefficients - mean[:, None]
    root = _moment_root(swing)
    largest = np.abs(coefficients).max(axis=1)
    result = np.empty((4, len(basis)))
    for block in point_blocks(len(basis), 6 * len(coefficients)):
        some = basis[block]
        sizes = np.sqrt(np.einsum("pij,pij->pj", some, some)) @ largest
        lines = _lines(some @ root, _ROUND_OFF * sizes * sqrt(swing.shape[1]))
        extents = _extents(lines.reading @ some, swing)
        result[:, block] = _bounds(lines, extents, some @ mean, _ROUND_OFF * sizes, k)
    return PathBounds(*result)


def _moment_root(swing: FloatArray) -> FloatArray:
    """Return F (n_basis, n_basis) with F F^T = swing swing^T."""
    values, vectors = np.linalg.eigh(swing @ swing.T)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


@dataclass(frozen=True, eq=False)
class _Lines:
    """The lines that paths are measured along, n of them.

    reading    (n, 6, 6)  takes six components to the deviator along the line, its four components
                          off the line, and the hydrostatic stress that does not go with the first
    direction  (n, 5)     unit vector of the deviator
    trace      (n,)       hydrostatic stress per unit along the line
    """

    reading: FloatArray
    direction: FloatArray
    trace: FloatArray


def _bounds(
    lines: _Lines, extents: FloatArray, static: FloatArray, round_off: FloatArray, k: float
) -> FloatArray:
    """Return width and the three bounds, (4, n); static (n, 6) is the mean stress, MPa."""
    half, middle, pressure, loose, off, radius = extents
    line = deviator_components(lines.direction)
    line[:, :3] += lines.trace[:, None]
    centre = static + line * middle[:, None]
    centre[:, :3] += loose[:, None]
    tension = _principal(centre)[0] + _MARGIN * np.abs(centre).sum(axis=1)
    highest, _, lowest = _principal(line)
    shear, normal = (highest - lowest) / 2.0, np.abs(highest + lowest) / 2.0

    shortest = np.maximum((1.0 - TIE) * half - 2.0 * round_off, 0.0)  # that Goodman takes as tied
    sideways = np.sqrt(np.maximum(radius**2 - shortest**2, 0.0))
    mean = np.maximum(tension + (2.0 / 3.0 + np.abs(lines.trace)) * sideways + pressure, 0.0)
    any_way = 1.0 / sqrt(3.0) + 2.0 / 3.0 * k
    by_line = half * (shear * sqrt(1.0 + k**2) + k * normal) + any_way * off + k * pressure
    by_ball = any_way * radius + k * (np.abs(lines.trace) * half + pressure)
    findley = k * np.maximum(tension, 0.0) + np.minimum(by_line, by_ball)
    wide = np.sqrt(off**2 + 4.5 * pressure**2)
    straight = (half <= round_off) & (off <= round_off)  # one point, or a line of pressures
    width = np.where(straight, 0.0, wide / np.where(half > 0.0, half, 1.0))
    bounds = np.stack([radius, mean, findley]) * (1.0 + _MARGIN) + round_off
    return np.concatenate([width[None], bounds])


def _extents(turned: FloatArray, swing: FloatArray) -> FloatArray:
    """Return the extents of the turned rows (n, 6, n_basis) over the cycle, (6, n), MPa.

    Half the range and the middle of the first row, the same of the last row, the largest size of
    the four between, and the largest size of the first five with the first taken about its middle.
    """
    result = np.empty((6, len(turned)))
    blocks = list(point_blocks(len(turned), _SMALLER * 6 * swing.shape[1]))
    room = np.empty((blocks[0].stop, 6, swing.shape[1]))  # the same memory for every block
    for block in blocks:
        path = room[: block.stop - block.start]
        # one product of all rows: three times as fast as one of six rows for each point
        rows = turned[block].reshape(-1, len(swing))
        np.matmul(rows, swing, out=path.reshape(-1, swing.shape[1]))
        ends = path[:, ::5]
        top, bottom = ends.max(axis=2).T, ends.min(axis=2).T
        result[:4:2, block], result[1:4:2, block] = (top - bottom) / 2.0, (top + bottom) / 2.0
        squared = np.einsum("pdk,pdk->pk", path[:, 1:5], path[:, 1:5])
        result[4, block] = squared.max(axis=1)
        along = path[:, 0]
        along -= result[1, block, None]
        along *= along
        squared += along
        result[5, block] = squared.max(axis=1)
    np.sqrt(result[4:], out=result[4:])
    return result


def _lines(moments: FloatArray, round_off: FloatArray) -> _Lines:
    """Return the main axis of the deviators' second moments; moments (n, 6, r) are a root of them.

    Power iterations find it at once where a path is straight; for round ones any direction serves.
    """
    roots = _READING @ moments
    second = roots @ np.swapaxes(roots, 1, 2)
    deviator = second[:, :5, :5]
    size = np.einsum("pii->p", deviator)[:, None, None]
    scaled = deviator / np.where(size > 0.0, size, 1.0)
    start = np.einsum("pii->pi", scaled).argmax(axis=1)
    found = np.take_along_axis(scaled, start[:, None, None], axis=2)
    for _ in range(_POWERS):
        found = scaled @ found
    length = np.linalg.norm(found, axis=1)
    unit = np.eye(5)[0]
    axis = np.where(length > 0.0, found[:, :, 0] / np.where(length > 0.0, length, 1.0), unit)
    # Householder's reflection that takes -sign(axis_0) axis to the first unit vector, and back
    mirror = axis + np.where(axis[:, :1] >= 0.0, 1.0, -1.0) * unit
    mirror /= np.linalg.norm(mirror, axis=1, keepdims=True)
    turn = np.zeros((len(roots), 6, 6))
    turn[:, :5, :5] = np.eye(5) - 2.0 * mirror[:, :, None] * mirror[:, None, :]
    turn[:, 5, 5] = 1.0
    direction = turn[:, 0, :5].copy()
    both = (second[:, :, :5] @ direction[:, :, None])[:, :, 0]
    spread = np.einsum("pi,pi->p", direction, both[:, :5])
    # a deviator that is round-off alone carries no pressure along
    trace = both[:, 5] / np.where(spread > round_off**2, spread, np.inf)
    turn[:, 5, :5] = -trace[:, None] * direction
    return _Lines(turn @ _READING, direction, trace)


def _principal(stress: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the principal stresses of (n, 6), largest first, by the cubic's cosine.

    Several times faster than a decomposition; where two are equal, known to some 1e-8 of the von
    Mises stress, which _MARGIN covers.
    """
    mean = stress[:, :3].mean(axis=1)
    xx, yy, zz = (stress[:, i] - mean for i in range(3))
    xy, yz, zx = stress[:, 3:].T
    second = (xx**2 + yy**2 + zz**2) / 2.0 + xy**2 + yz**2 + zx**2
    third = xx * yy * zz + 2.0 * xy * yz * zx - xx * yz**2 - yy * zx**2 - zz * xy**2
    size = np.sqrt(second / 3.0)
    cube = 2.0 * size**3
    cosine = np.clip(third / np.where(cube > 0.0, cube, 1.0), -1.0, 1.0)
    angle = np.arccos(cosine) / 3.0
    turns = (angle, angle - 2.0 * pi / 3.0, angle + 2.0 * pi / 3.0)
    return tuple(mean + 2.0 * size * np.cos(turn) for turn in turns)


def deviator_components(vectors: FloatArray) -> FloatArray:
    """Return the deviators (..., 6) of vectors (..., 5): the inverse of `deviatoric_basis`."""
    return np.asarray(vectors @ _FROM_VECTOR.T)
