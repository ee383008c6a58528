"""Fewer and better fields for the same stress: unit loads combined by how they are driven.

A stress is a sum of fields times coefficients, S c. Of any invertible T the fields S inv(T) and the
coefficients T c give the same. If each field is then rounded to whole steps, the error at a
position is a sum of rounding errors times T c: as small as the vector T c is short. So T is chosen
such that the ellipsoid of smallest volume around all c becomes the unit ball: at a given number of
digits no other T allows larger steps (the digits that all fields take together grow with the
ellipsoid's volume). Unit loads that always act in proportion become one field; what never acts
becomes none. A rotation, which the ball allows, then makes the fields uncorrelated, so that the
small ones take few digits.

The ellipsoid is found by the multiplicative algorithm of D-optimal design (Silvey, Titterington &
Torsney, Communications in Statistics A 7 (1978) 1379); stopped early it is only a little large.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import FloatArray

NOTHING = 1e-7  # of a cycle's peak: what may be left out with a direction that hardly acts
_ROUNDS, _CLOSE = 300, 1.005


@dataclass(frozen=True, eq=False)
class Combined:
    """Fields and coefficients of the same sum.

    fields   (r, n, c) numbers at the nodes
    weights  cycle -> (r, n_positions), in shares of the cycle's size: no column is longer than 1
    sizes    cycle -> size that the coefficients have been divided by, in the unit of the sum
    """

    fields: FloatArray
    weights: Mapping[str, FloatArray]
    sizes: Mapping[str, float]


def combine(
    fields: npt.NDArray[Any],
    coefficients: Mapping[str, FloatArray],
    sizes: Mapping[str, float],
    metric: FloatArray,
) -> Combined:
    """Return the fewest fields whose weighted sums are those of `fields`.

    fields        (M, n, c) of unit loads
    coefficients  cycle -> (M, n_positions)
    sizes         cycle -> the size of the cycle's sums, such as its peak; 0 where nothing acts
    metric        (rows, c) by which a vector of c numbers is measured
    """
    acting = {name: c for name, c in coefficients.items() if sizes[name] > 0}
    count, n, parts = fields.shape
    flat = fields.reshape(count, n * parts)
    scale = np.array([float(np.abs(row).max(initial=0.0)) for row in flat])
    used = np.flatnonzero(scale)
    if not acting or not len(used):
        weights = {name: np.zeros((0, c.shape[1])) for name, c in coefficients.items()}
        return Combined(np.zeros((0, n, parts)), weights, sizes)
    scale, flat = scale[used], flat[used].astype(np.float64)
    path = np.concatenate([scale[:, None] * c[used] / sizes[q] for q, c in acting.items()], axis=1)
    directions, values, shares = np.linalg.svd(path, full_matrices=False)
    # no number of the scaled fields exceeds 1: nor does a sum with weights of length 1 this
    most = (len(used) * parts * float((metric**2).sum())) ** 0.5
    left = np.sqrt(np.cumsum((values[:, None] * shares)[::-1] ** 2, axis=0).max(axis=1))[::-1]
    rank = int(np.count_nonzero(left * most > NOTHING))
    if not rank:
        weights = {name: np.zeros((0, c.shape[1])) for name, c in coefficients.items()}
        return Combined(np.zeros((0, n, parts)), weights, sizes)
    whitened, ball = _rounded(values[:rank, None] * shares[:rank])
    mixed = ((directions[:, :rank] @ whitened).T / scale) @ flat
    rotation = _uncorrelating(mixed.reshape(rank, n, parts), metric)
    mixed, ball = rotation @ mixed, rotation @ ball
    weights, column = {}, 0
    for name, c in coefficients.items():
        width = c.shape[1] if name in acting else 0
        part = ball[:, column : column + width]
        weights[name] = part if name in acting else np.zeros((rank, c.shape[1]))
        column += width
    return Combined(mixed.reshape(rank, n, parts), weights, sizes)


def _rounded(path: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Matrix A (r, r) and path (r, K) of columns no longer than 1 with A times it the given one."""
    rank, count = path.shape
    share = np.full(count, 1.0 / count)
    for _ in range(_ROUNDS):
        length = (path * np.linalg.solve((path * share) @ path.T, path)).sum(axis=0) / rank
        share *= length
        share /= share.sum()
        if length.max() < _CLOSE:
            break
    root = np.linalg.cholesky((path * share) @ path.T)
    ball = np.linalg.solve(root, path)
    longest = float(np.sqrt((ball**2).sum(axis=0)).max())
    return root * longest, np.asarray(ball / longest, dtype=np.float64)


def _uncorrelating(fields: FloatArray, metric: FloatArray) -> FloatArray:
    """Rotation (r, r) after which the fields are uncorrelated over the nodes, the largest first."""
    rank = len(fields)
    measured = (fields @ metric.T).reshape(rank, -1)
    _, vectors = np.linalg.eigh(measured @ measured.T)
    rows = vectors[:, ::-1].T
    # a field's sign is anyone's choice: the same one everywhere
    signs = np.sign(rows[np.arange(rank), np.abs(rows).argmax(axis=1)])
    return np.asarray(rows * signs[:, None])
