"""The stress at surface points over a cycle, as a basis times coefficients.

    stress(point, :, position) = sum_j basis[point, :, j] * coefficients[j, position]

    basis         (n_points, 6, n_basis)    MPa per unit of each unit load
    coefficients  (n_basis, n_positions)    the units that act

The six components stand in the order of COMPONENTS, in every array of this package.

The longest chord of many paths is found exactly, without comparing all pairs of positions.
Let x_k be the positions of one path in the five-dimensional space of `deviatoric_basis`, where
the distance of two positions is the von Mises norm of the difference of their stresses.

1. A few steps to the farthest position give a chord of length L, so the longest is at least L.
2. Take any centre c, r_k = |x_k - c| and R = max r_k. By the triangle inequality
   |x_k - x_l| <= r_k + r_l <= r_k + R. So a position with r_k + R < L is on no chord as long as L,
   and is dropped. No chord of length L or more, the longest and its equals among them, is lost.
3. All pairs of the positions that are left are compared.

The result equals comparing all pairs; the choice of c and L changes only the time. A centre near
the smallest enclosing ball's centre drops most: for the straight or slender paths of most points
only a few positions near the two ends are left.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")

# Where each component of COMPONENTS stands in the symmetric 3 x 3 tensor.
_TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])

_ROOT3 = float(np.sqrt(3.0))

# Rows: xx - (yy + zz)/2, sqrt(3)/2 (yy - zz), sqrt(3) times each shear stress.
_DEVIATOR = np.array(
    [
        [1.0, -0.5, -0.5, 0.0, 0.0, 0.0],
        [0.0, _ROOT3 / 2.0, -_ROOT3 / 2.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, _ROOT3, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, _ROOT3, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, _ROOT3],
    ]
)

# Numbers in one block of the stress history, 8 bytes each; measured, the caches like this size.
BLOCK = 400_000

_MANY = 1000  # points from which on fewer unit loads pay for being found
_WORTH = 0.7  # of the unit loads: with more left nothing is gained
_NOTHING = 1e-14  # of the largest singular value
# Chords that differ by less than this fraction count as equally long. Round-off is far smaller;
# solutions of a finite-element system repeat to about this much.
TIE = 1e-9

_N_FARTHEST = 3  # steps to the farthest position, from the first chord on
_N_CENTRE = 12  # steps of the centre towards that of the smallest enclosing ball
_PAIRS = 1_000_000  # squared distances held at once


def deviatoric_basis(basis: FloatArray) -> FloatArray:
    """Return (n_points, 5, n_basis) vectors whose Euclidean norm is the von Mises stress.

    With a = xx - (yy+zz)/2 and b = sqrt(3)/2 (yy-zz),
    a**2 + b**2 = xx**2 + yy**2 + zz**2 - xx*yy - yy*zz - zz*xx, and von Mises' equivalent stress
    squared is that plus 3 (xy**2 + yz**2 + zx**2): Ilyushin's five-dimensional stress space.
    """
    return np.asarray(_DEVIATOR @ basis, dtype=np.float64)


def von_mises(stress: FloatArray) -> FloatArray:
    """Return the von Mises stress, MPa, of stresses whose last axis holds the six components.

    >>> float(von_mises(np.array([3.0, 3.0, 3.0, 4.0, 0.0, 0.0])) / np.sqrt(3.0))
    4.0
    """
    return np.asarray(np.linalg.norm(stress @ _DEVIATOR.T, axis=-1))


def principal_stresses(stress: FloatArray) -> FloatArray:
    """Return the three principal stresses, MPa, smallest first: (..., 6) to (..., 3).

    >>> principal_stresses(np.array([0.0, 0.0, 0.0, 4.0, 0.0, 0.0])).tolist()
    [-4.0, 0.0, 4.0]
    """
    return np.asarray(np.linalg.eigvalsh(stress[..., _TENSOR]))


def check_history(basis: FloatArray, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return both arrays as floats, or say which point or position cannot be used."""
    basis = np.asarray(basis, dtype=np.float64)
    coefficients = np.asarray(coefficients, dtype=np.float64)
    if basis.ndim != 3 or basis.shape[1] != 6 or coefficients.ndim != 2:
        raise ValueError(
            "the stress history needs a basis (n_points, 6, n_basis) and coefficients "
            f"(n_basis, n_positions), got {basis.shape} and {coefficients.shape}"
        )
    if basis.shape[2] != coefficients.shape[0]:
        raise ValueError(
            f"the basis holds {basis.shape[2]} unit loads, the coefficients {coefficients.shape[0]}"
        )
    if basis.shape[0] == 0 or coefficients.shape[1] == 0:
        raise ValueError(
            "the stress history needs at least one point and one position, got "
            f"{basis.shape[0]} points and {coefficients.shape[1]} positions"
        )
    if not np.isfinite(basis).all():
        bad = np.flatnonzero(~np.isfinite(basis).all(axis=(1, 2)))
        raise ValueError(
            f"the stress basis is not finite at point {bad[0]} ({len(bad)} of {len(basis)} points)"
        )
    if not np.isfinite(coefficients).all():
        bad = np.flatnonzero(~np.isfinite(coefficients).all(axis=0))
        raise ValueError(
            f"the coefficients are not finite at position {bad[0]} "
            f"({len(bad)} of {coefficients.shape[1]} positions)"
        )
    return basis, coefficients


def with_fewer_loads(basis: FloatArray, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the same history by as few unit loads as it has to round-off.

    Of few points, or where hardly any unit load would go, both come back as they are.
    """
    n_loads, n_positions = coefficients.shape
    if len(basis) < max(_MANY, n_positions):
        return basis, coefficients
    turn, fewer = fewer_loads(basis, coefficients)
    if len(fewer) > _WORTH * n_loads:
        return basis, coefficients
    return (basis.reshape(-1, n_loads) @ turn).reshape(len(basis), 6, -1), fewer


def fewer_loads(
    basis: FloatArray, coefficients: FloatArray, lost: float = _NOTHING
) -> tuple[FloatArray, FloatArray]:
    """Return the shares (n_basis, m) of unit loads in as few that do for a history, and these.

    Their coefficients are (m, n_positions). Unit loads that act in step, such as the waves of a
    pressure that only grows, are one load.

    lost  of the largest singular value of the coefficients, each times the largest stress of its
          unit load: less is left out
    """
    sizes = np.maximum(basis.max(axis=(0, 1)), -basis.min(axis=(0, 1)))
    sizes[sizes == 0.0] = 1.0
    turn, values, paths = np.linalg.svd(sizes[:, None] * coefficients, full_matrices=False)
    count = max(1, int(np.count_nonzero(values > lost * values[0])))
    return turn[:, :count] / sizes[:, None], values[:count, None] * paths[:count]


def point_blocks(n_points: int, numbers_per_point: int) -> Iterator[slice]:
    """Yield slices over the points whose history holds about BLOCK numbers each."""
    size = max(1, BLOCK // max(1, numbers_per_point))
    for start in range(0, n_points, size):
        yield slice(start, min(start + size, n_points))


def von_mises_peaks(basis: FloatArray, coefficients: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the largest von Mises stress of each point over the cycle, MPa, and its position.

    Both have shape (n_points,). Of equal peaks the first position is named.
    """
    basis, coefficients = check_history(basis, coefficients)
    vectors = deviatoric_basis(basis)
    n_points, n_positions = len(basis), coefficients.shape[1]
    peak = np.empty(n_points)
    position = np.empty(n_points, dtype=np.intp)
    for block in point_blocks(n_points, 5 * n_positions):
        path = vectors[block] @ coefficients
        squared = np.einsum("pdk,pdk->pk", path, path)
        position[block] = squared.argmax(axis=1)
        peak[block] = np.sqrt(squared.max(axis=1))
    return peak, position


def path_lengths(basis: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Return the length (n_points,) of each point's closed path in von Mises stress, MPa.

    No reading of the path along a chord goes farther up and down in all.
    """
    basis, coefficients = check_history(basis, coefficients)
    vectors, steps = deviatoric_basis(basis), np.roll(coefficients, -1, axis=1) - coefficients
    lengths = np.empty(len(basis))
    for block in point_blocks(len(basis), 5 * steps.shape[1]):
        path = vectors[block] @ steps
        lengths[block] = np.sqrt(np.einsum("pdk,pdk->pk", path, path)).sum(axis=1)
    return lengths


# Refusal of a number among many: a message with the fault, its first place and its count.


def refuse(
    bad: npt.NDArray[np.bool_], problem: str, values: npt.NDArray[np.generic], item: str = "cycle"
) -> None:
    """Raise ValueError with the problem, its first place and the value there, where any is bad."""
    if not bad.any():
        return
    place = np.argwhere(bad)[0].tolist()
    names = ["point", item][2 - len(place) :]
    where = ", ".join(f"{name} {index}" for name, index in zip(names, place, strict=True))
    raise ValueError(
        f"{problem}: {values[tuple(place)]:g}"
        + (f" at {where} ({bad.sum()} of {bad.size})" if place else "")
    )


def checked_cycles(amplitude: npt.ArrayLike, mean: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return amplitudes and means, MPa, as floats of one shape; ValueError names a bad cycle."""
    amplitude = np.asarray(amplitude, dtype=np.float64)
    mean = np.asarray(mean, dtype=np.float64)
    refuse(~np.isfinite(amplitude), "the amplitude is not finite", amplitude)
    refuse(~np.isfinite(mean), "the mean stress is not finite", mean)
    refuse(amplitude < 0.0, "the amplitude, half the range, is below 0 MPa", amplitude)
    amplitude, mean = np.broadcast_arrays(amplitude, mean)
    return amplitude, mean


@dataclass(frozen=True, eq=False)
class TiedChords:
    """The longest chord of each path, and every pair of positions that is as long.

    length  (n_paths,)   MPa, von Mises norm
    path    (n_ties,)    index of the path, ascending; each path has at least one row
    first   (n_ties,)    positions at the two ends, first <= second
    second  (n_ties,)
    """

    length: FloatArray
    path: IntArray
    first: IntArray
    second: IntArray


def longest_chords(vectors: FloatArray, round_off: FloatArray) -> TiedChords:
    """Return the longest chords of paths (n_paths, 5, n_positions).

    `round_off` (n_paths,), MPa, is how well the vectors are known; a path no longer than twice
    that is a single point: length 0, and the chords of length 0 from each position to itself tie.
    """
    n_positions = vectors.shape[2]
    squared, centre, radii = _enclose(vectors)
    floor = _tie_floor(squared, round_off)
    left = radii >= (floor - radii.max(axis=1))[:, None]
    counts = np.count_nonzero(left, axis=1)

    best = squared.copy()
    path: list[IntArray] = []
    ends: list[IntArray] = []
    size = 2
    smaller = 0
    while smaller < n_positions:
        members = np.flatnonzero((counts > smaller) & (counts <= size))
        step = max(1, _PAIRS // size**2)
        for start in range(0, len(members), step):
            some = members[start : start + step]
            kept = _kept(left[some])
            # Centred vectors: the Gram matrix below would lose the digits a large mean takes.
            near = np.take_along_axis(vectors[some], kept[:, None, :], axis=2) - centre[some]
            found, rows, pairs = _compare_all(near, best[some], round_off[some])
            best[some] = found
            path.append(some[rows])
            ends.append(kept[rows[:, None], pairs])
        smaller, size = size, 2 * size

    point_like = np.sqrt(best) <= 2.0 * round_off
    paths, pairs = np.concatenate(path), np.sort(np.concatenate(ends), axis=1)
    keep = ~point_like[paths]
    still = np.flatnonzero(point_like)
    each = np.arange(n_positions)
    paths = np.concatenate([paths[keep], np.repeat(still, n_positions)])
    first = np.concatenate([pairs[keep, 0], np.tile(each, len(still))])
    second = np.concatenate([pairs[keep, 1], np.tile(each, len(still))])
    order = np.argsort(paths, kind="stable")
    length = np.where(point_like, 0.0, np.sqrt(best))
    return TiedChords(length, paths[order], first[order], second[order])


def _tie_floor(squared: FloatArray, round_off: FloatArray) -> FloatArray:
    """Return the length from which on a chord counts as long as the longest, never negative."""
    return np.asarray(np.maximum(0.0, (1.0 - TIE) * np.sqrt(squared) - 2.0 * round_off))


def _position(vectors: FloatArray, index: IntArray) -> FloatArray:
    return np.take_along_axis(vectors, index[:, None, None], axis=2)


class _Paths:
    """Paths, and their squared distances from a point in one pass over them.

    |x - c|**2 = |x|**2 - 2 x . c + |c|**2 is known to some eps of the largest |x|**2 and |c|**2
    only. `slack` is more than that: distances are told too long by it, never too short.
    """

    def __init__(self, vectors: FloatArray) -> None:
        self.vectors = vectors
        self.norms = np.einsum("pdk,pdk->pk", vectors, vectors)
        self.slack = 64.0 * np.finfo(float).eps * self.norms.max(axis=1, keepdims=True)

    def some(self, index: IntArray) -> _Paths:
        """Return some of the paths."""
        chosen = object.__new__(_Paths)
        chosen.vectors, chosen.norms = self.vectors[index], self.norms[index]
        chosen.slack = self.slack[index]
        return chosen

    def squared_distances(self, point: FloatArray) -> FloatArray:
        """Upper bounds (n, k) of the squared distances from points (n, 5, 1) between positions."""
        squared = (np.swapaxes(-2.0 * point, 1, 2) @ self.vectors)[:, 0]
        squared += self.norms
        squared += np.einsum("pdo,pdo->po", point, point) + self.slack
        return squared


def _enclose(vectors: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the square of a long chord, a centre (n, 5, 1) and the distances (n, k) from it.

    The chord is not longer than the longest, the distances are not too short. The centre starts
    at the middle of the chord. Where positions lie outside the ball on it, the centre goes towards
    the farthest position (Badoiu and Clarkson 2003); the best is kept.
    """
    paths = _Paths(vectors)
    end = _position(vectors, paths.norms.argmax(axis=1))
    squared = np.full(len(vectors), -1.0)
    middle = np.empty_like(end)
    for _ in range(_N_FARTHEST):
        other = _position(vectors, paths.squared_distances(end).argmax(axis=1))
        length = ((end - other) ** 2).sum(axis=(1, 2))
        longer = length > squared
        squared = np.where(longer, length, squared)
        middle = np.where(longer[:, None, None], (end + other) / 2.0, middle)
        end = other

    radii = paths.squared_distances(middle)
    largest = radii.max(axis=1)
    outside = np.flatnonzero(largest > 0.25 * squared * (1.0 + TIE) + paths.slack[:, 0])
    if len(outside):
        some, centre = paths.some(outside), middle[outside]
        distances = radii[outside]
        for step in range(_N_CENTRE):
            farthest = _position(some.vectors, distances.argmax(axis=1))
            centre = centre + (farthest - centre) / (step + 3)
            distances = some.squared_distances(centre)
            size = distances.max(axis=1)
            better = size < largest[outside]
            largest[outside[better]] = size[better]
            radii[outside[better]] = distances[better]
            middle[outside[better]] = centre[better]
    return squared, middle, np.sqrt(radii, out=radii)


def _kept(left: npt.NDArray[np.bool_]) -> IntArray:
    """Return the columns that are set in each row, filled up by repeating the first one."""
    counts = np.count_nonzero(left, axis=1)
    rows, columns = np.nonzero(left)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    kept = np.repeat(columns[starts][:, None], counts.max(), axis=1)
    kept[rows, np.arange(len(rows)) - starts[rows]] = columns
    return kept


def _compare_all(
    vectors: FloatArray, best: FloatArray, round_off: FloatArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the largest squared distance of each path, and path and ends of all that equal it.

    `best` is known to be reached; in blocks of rows, so that memory stays bounded.
    """
    size = vectors.shape[2]
    norms = np.einsum("pdk,pdk->pk", vectors, vectors)
    step = max(1, _PAIRS // (len(vectors) * size))
    rows: list[IntArray] = []
    pairs: list[IntArray] = []
    values: list[FloatArray] = []
    for start in range(0, size, step):
        part = slice(start, start + step)
        squared = np.swapaxes(vectors[:, :, part], 1, 2) @ vectors
        squared *= -2.0
        squared += norms[:, part, None]
        squared += norms[:, None, :]
        best = np.maximum(best, squared.max(axis=(1, 2)))
        floor = _tie_floor(best, round_off)
        hits = np.flatnonzero((squared >= (floor**2)[:, None, None]).ravel())  # faster than in 3-D
        row, first, second = np.unravel_index(hits, squared.shape)
        upper = first + start < second
        row, first, second = row[upper], first[upper], second[upper]
        rows.append(row)
        pairs.append(np.stack([first + start, second], axis=1))
        values.append(squared[row, first, second])
    row, value = np.concatenate(rows), np.concatenate(values)
    tied = value >= (_tie_floor(best, round_off) ** 2)[row]
    return best, row[tied], np.concatenate(pairs)[tied]
