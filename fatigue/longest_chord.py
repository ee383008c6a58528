"""The longest chord of many stress paths, exactly, without comparing all pairs of positions.

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

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fatigue.stress_path import FloatArray, IntArray

# Chords that differ by less than this fraction count as equally long. Round-off is far smaller;
# solutions of a finite-element system repeat to about this much.
TIE = 1e-9

_N_FARTHEST = 3  # steps to the farthest position, from the first chord on
_N_CENTRE = 12  # steps of the centre towards that of the smallest enclosing ball
_PAIRS = 1_000_000  # squared distances held at once


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
