"""Fields in whole steps, as large as a tolerance allows, and their error at every position shown.

A stress is a sum of unit fields times coefficients. Its proper orthogonal decomposition gives the
same sum with the fewest fields: they are orthogonal over the nodes and their weights over the
positions, so that the small ones take few digits. Unit loads that always act in proportion become
one field; what never acts becomes none. The fields are rounded to whole steps; the error is then
measured at all nodes and positions, and the steps are made smaller until it is small enough.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import LiveFields, largest_principal
from fem.stress_history import DEVIATOR
from geometry.mesh import FloatArray, IntArray

# Rows whose squares sum up to that of the von Mises stress, and the mean stress.
STRESS_METRIC = np.vstack([DEVIATOR, [1 / 3, 1 / 3, 1 / 3, 0.0, 0.0, 0.0]])
LENGTH_METRIC = np.eye(3)
_NUMBER = np.eye(1)
_TOGETHER = 200_000  # nodes times positions, so that their sums stay near the processor
_BLOCK = 32  # positions whose sums are bounded together
_TOP = 64  # nodes of the highest bounds, which tell what others must reach

_MORE = 1.0 + 1e-5  # peaks are known in double precision, fields in single


def largest_sizes(fields: FloatArray, weights: FloatArray, metric: FloatArray) -> FloatArray:
    """Largest sizes (2, K) of sums of fields (r, n, c) times weights (r, K), over the nodes.

    metric  STRESS_METRIC, or LENGTH_METRIC

    Row 0 is the von Mises stress, or the length of a displacement; row 1 a bound of any principal
    stress: no principal value of a deviator exceeds 2/3 of its von Mises stress. Both are norms of
    the sum, hence convex in the weights: between two positions they do not exceed the larger of
    both. Sums are in single precision. One field is only scaled.
    """
    if len(fields) == 1 < weights.shape[1]:
        return np.asarray(largest_sizes(fields, np.ones((1, 1)), metric) * np.abs(weights))
    return _largest(_rows(fields, metric), np.ascontiguousarray(weights, dtype=np.float32))


def largest_anywhere(fields: FloatArray, weights: FloatArray, metric: FloatArray) -> FloatArray:
    """Largest (2,) of `largest_sizes` over all positions.

    In a block of positions a node reaches at most the sizes of its fields times their largest
    weights there. Only nodes that may reach more than is known are asked for their sums, those of
    the highest bounds first.
    """
    if not fields.size or not weights.size:
        return np.zeros(2)
    rows = _rows(fields, metric)
    shares = np.ascontiguousarray(weights, dtype=np.float32)
    reached = [np.sqrt(_squared(rows.copy()))]  # (n, r)
    if metric is STRESS_METRIC:
        reached.append(2 / 3 * reached[0] + np.abs(rows[:, 5]))
    starts = np.arange(0, shares.shape[1], _BLOCK)
    most = np.maximum.reduceat(np.abs(shares), starts, axis=1)  # (r, blocks)
    bounds = np.stack([one @ most for one in reached])  # (1 or 2, n, blocks)
    bounds *= 1 + 4 * len(fields) * _SINGLE
    known = np.zeros((2, 1))
    for block in np.argsort(-bounds[0].max(axis=0), kind="stable"):
        own = shares[:, starts[block] : starts[block] + _BLOCK]
        top = np.argpartition(bounds[0, :, block], -min(_TOP, len(rows)))[-_TOP:]
        known = np.maximum(known, _largest(rows[top], own).max(axis=1, keepdims=True))
        left = (bounds[:, :, block] > known[: len(bounds)]).any(axis=0)
        known = np.maximum(known, _largest(rows[left], own).max(axis=1, keepdims=True))
    return known[:, 0]


def _rows(fields: FloatArray, metric: FloatArray) -> npt.NDArray[np.float32]:
    """Rows (n, m, r) of a metric (m, c) for fields (r, n, c), in single precision."""
    return np.ascontiguousarray((fields @ metric.T).transpose(1, 2, 0), dtype=np.float32)


def _squared(sums: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Squares (n, k) of the sizes of sums (n, m, k): of the first five of m, in place."""
    squares = np.square(sums[:, :5], out=sums[:, :5])
    return np.asarray(squares.sum(axis=1))


def _largest(rows: npt.NDArray[np.float32], weights: npt.NDArray[np.float32]) -> FloatArray:
    """`largest_sizes` (2, K) of sums of rows (n, m, r) times weights (r, K)."""
    count, m, r = rows.shape
    found = np.zeros((2, weights.shape[1]))
    size = max(1, _TOGETHER // max(1, weights.shape[1]))
    for first in range(0, count if r else 0, size):
        some = rows[first : first + size]
        sums = (some.reshape(-1, r) @ weights).reshape(len(some), m, -1)
        sizes = np.sqrt(_squared(sums))
        np.maximum(found[0], sizes.max(axis=0), out=found[0])
        if m > 5:
            both = 2 / 3 * sizes + np.abs(sums[:, 5])
            np.maximum(found[1], both.max(axis=0), out=found[1])
    return found


def lost_in_single(
    fields: npt.NDArray[Any], coefficients: Mapping[str, FloatArray], metric: FloatArray
) -> dict[str, float]:
    """Cycle -> largest error of a sum at any node by single precision of unit fields (M, n, c).

    In the unit of the sum; of its norm, and of any principal stress. It is much where unit loads
    nearly cancel each other: their sizes count, not the size of their sum.
    """
    # v' G v is at most the sum of v_i^2 times the sizes in row i of G
    rows = np.abs(metric.T @ metric).sum(axis=1)
    sizes = np.array([np.sqrt((field.astype(np.float64) ** 2 @ rows).max()) for field in fields])
    return {
        name: _SINGLE * float((sizes @ np.abs(c)).max(initial=0.0))
        for name, c in coefficients.items()
    }


def largest_principal_stress(live: LiveFields, lost: Mapping[str, float]) -> float:
    """Largest size of a principal stress at any node and position, MPa.

    lost  cycle -> what single precision of the unit fields may cost, MPa

    No principal stress exceeds the mean stress by more than 2/3 of the von Mises stress, and that
    one is not above its peak at the position: only positions and nodes that this bound leaves are
    looked at, the most promising position first.
    """
    means = live.stress[..., :3].astype(np.float64).mean(axis=2)
    order = []
    for name, weights in live.coefficients.items():
        mean = float(largest_anywhere(means[..., None], weights, _NUMBER)[0])
        about = 2 / 3 * live.peaks[name] * _MORE + mean * _MORE + (live.n_fields + 4) * lost[name]
        order += [(-most, name, k) for k, most in enumerate(about.tolist())]
    known = 0.0
    for most, name, k in sorted(order):
        if -most <= known:
            break
        weights = live.coefficients[name][:, k]
        reach = 2 / 3 * _MORE * live.peaks[name][k] + (live.n_fields + 4) * lost[name]
        some = np.flatnonzero(np.abs(weights @ means) + reach > known)
        stress = np.tensordot(weights, live.stress[:, some].astype(np.float64), axes=1)
        known = largest_principal(stress, known)
    return known


MOST_POSITIONS = 3601  # of a cycle in a page
FLOOR = 1e-4  # of the largest cycle's size: cycles below that are as exact as if they had it
NOTHING = 1e-6  # of a cycle's size: what may be left out with fields that hardly act
_DEPENDENT = 1e-13  # of the largest singular value: below are loads that others make in proportion
_WEIGHT_BITS = 18
_SINGLE = 2.0**-24  # precision of the browser's values
_SAMPLE = 8  # every n-th node tells the size of the steps; all of them show that it is enough
_FIRST, _LESS, _ROUNDS = 0.4, 0.95, 20
_LEAST = 0.25  # of the tolerance: what the steps may take even if all of it is lost elsewhere
_LARGEST = 2**30


@dataclass(frozen=True, eq=False)
class Sums:
    """Sums of fields times weights at the positions of cycles.

    fields   (r, n, c)
    weights  cycle -> (r, n_positions)
    """

    fields: FloatArray
    weights: Mapping[str, FloatArray]


@dataclass(frozen=True)
class Error:
    """Largest errors, in shares of the size of a position's cycle.

    norm       of the von Mises stress, or the length of a displacement
    principal  of any principal stress; 0 of displacements
    """

    norm: float
    principal: float


@dataclass(frozen=True, eq=False)
class Fitted:
    """Fields and weights in whole steps: sum_j steps * fields[j] * sizes[q] * weights[q][j, k].

    fields   (r, n, c) whole numbers
    steps    (c,) what one is worth
    kept     cycle -> (k,) numbers of the positions that the page carries
    weights  cycle -> (r, k) whole numbers at the kept positions
    sizes    cycle -> what one whole step of a weight is worth, in the unit of the sum
    bound    largest error at kept positions, measured at all nodes, with what was lost before
    between  as bound, over all positions: those left out are taken from the straight line
    """

    fields: npt.NDArray[np.int64]
    steps: FloatArray
    kept: Mapping[str, IntArray]
    weights: Mapping[str, npt.NDArray[np.int64]]
    sizes: Mapping[str, float]
    bound: Error
    between: Error


def sizes_with_floor(sizes: Mapping[str, float]) -> dict[str, float]:
    """Sizes of cycles, none below FLOOR of the largest but those that are nothing."""
    floor = FLOOR * max(sizes.values(), default=0.0)
    return {name: max(size, floor) if size > 0 else 0.0 for name, size in sizes.items()}


def fewest(
    fields: npt.NDArray[Any],
    coefficients: Mapping[str, FloatArray],
    sizes: Mapping[str, float] | None = None,
) -> Sums:
    """Return the fewest fields with the sums of unit fields (M, n, c) times coefficients.

    sizes  cycle -> the size of its sums, such as its peak; None: their largest root of the mean
           square over the nodes

    The fields that are left out make less than NOTHING of that at any node and position.
    """
    flat = fields.reshape(len(fields), -1).astype(np.float64)
    scale = np.abs(flat).max(axis=1, initial=0.0)
    paths = {name: scale[:, None] * c for name, c in coefficients.items()}
    driven = {name: float(np.linalg.norm(path, axis=0).max()) for name, path in paths.items()}
    alike = np.concatenate([path / (driven[name] or 1.0) for name, path in paths.items()], axis=1)
    # combined by how they are driven: loads that cancel, or act in proportion, are one field now
    mix, values, along = np.linalg.svd(alike, full_matrices=False)
    used = values > _DEPENDENT * values.max(initial=0.0)
    if not used.any():
        nothing = {name: np.zeros((0, c.shape[1])) for name, c in coefficients.items()}
        return Sums(np.zeros((0, *fields.shape[1:])), nothing)
    scale[scale == 0] = 1.0
    mixed = (mix[:, used] * values[used] / scale[:, None]).T @ flat
    squares, turn = np.linalg.eigh(mixed @ mixed.T)
    squares, turn = np.maximum(squares[::-1], 0.0), turn[:, ::-1]
    along = turn.T @ along[used]
    ends = np.cumsum([path.shape[1] for path in paths.values()])[:-1]
    shares = dict(zip(paths, np.split(along, ends, axis=1), strict=True))
    left = np.zeros(len(squares))  # length of all nodes' numbers without a field and those after it
    for name, share in shares.items():
        rest = np.sqrt(np.cumsum((squares[:, None] * share**2)[::-1], axis=0).max(axis=1))[::-1]
        size = (
            sizes[name] if sizes else driven[name] * rest.max(initial=0.0) * flat.shape[1] ** -0.5
        )
        left = np.maximum(left, driven[name] * rest / size if size else 0.0)
    used = left > NOTHING
    # a field's sign is anyone's choice: the same one everywhere
    signs = np.sign(turn[np.abs(turn).argmax(axis=0), np.arange(len(turn))])[used]
    return Sums(
        ((turn[:, used] * signs).T @ mixed).reshape(-1, *fields.shape[1:]),
        {name: driven[name] * signs[:, None] * share[used] for name, share in shares.items()},
    )


def thinned(path: FloatArray, wanted: Sequence[int], most: int) -> IntArray:
    """Choose about `most` positions of a path (r, K): its ends, `wanted`, and others.

    A quarter of them is evenly spread, the others are where the path bends most: between them the
    page takes straight lines.
    """
    count = path.shape[1]
    if count <= most:
        return np.arange(count)
    even = np.rint(np.linspace(0, count - 1, most // 4)).astype(np.int64)
    bend = np.zeros(count)
    bend[1:-1] = np.linalg.norm(np.diff(path, n=2, axis=1), axis=0)
    bend[even], bend[list(wanted)] = -1.0, np.inf
    return np.union1d(even, np.argsort(-bend, kind="stable")[: most - len(even)])


def fitted(
    sums: Sums,
    wanted: Mapping[str, Sequence[int]],
    sizes: Mapping[str, float],
    metric: FloatArray,
    components: FloatArray,
    tolerance: float,
    lost: float,
) -> Fitted:
    """Round fields to the largest steps whose error stays within a tolerance.

    wanted      cycle -> positions that must be among those kept
    sizes       cycle -> the size of its sums, such as its peak; 0 where nothing acts
    components  (c,) how large the steps of the components are beside each other
    tolerance   of a cycle's size
    lost        of a cycle's size, by which the fields are off before they are rounded; where this
                is almost all of the tolerance or more, `bound` exceeds it

    Raises ArithmeticError if no step does, which needs fields without any bound.
    """
    fields, paths = _shares(sums, sizes)
    kept = {name: thinned(path, wanted[name], MOST_POSITIONS) for name, path in paths.items()}
    whole = {
        name: np.rint(path[:, kept[name]] * 2.0**_WEIGHT_BITS).astype(np.int64)
        for name, path in paths.items()
    }
    shown = {name: _drawn(whole[name], kept[name], path.shape[1]) for name, path in paths.items()}
    digits = lost + 2 * NOTHING + _SINGLE

    def largest(fields: FloatArray, weights: Mapping[str, FloatArray]) -> tuple[FloatArray, ...]:
        """Largest norm and principal stress of sums at kept positions, and at all."""
        at_kept = np.hstack([path[:, kept[name]] for name, path in weights.items()])
        at_all = np.hstack([*weights.values()])
        found = largest_anywhere(fields, at_kept, metric)
        if at_kept.shape == at_all.shape:
            return found, found
        return found, largest_anywhere(fields, at_all, metric)

    by_weights = largest(fields, {name: shown[name] - path for name, path in paths.items()})
    other = by_weights[0][0] + digits
    target = max(tolerance - other, _LEAST * tolerance)
    sample = np.ascontiguousarray(fields[:, ::_SAMPLE])
    step, highest = _FIRST * tolerance, float(np.abs(fields).max(initial=0.0))
    for looked in (sample, sample, *[fields] * _ROUNDS):
        steps = step * components
        if not highest < _LARGEST * float(steps.min()):
            raise ArithmeticError(
                f"live fields need more than 30 bits for an error of {tolerance:.2g} of the peak"
            )
        numbers = np.rint(looked / steps)
        by_steps = largest(numbers * steps - looked, shown)
        norm = float(by_steps[0][0])
        if looked is fields and norm <= target:
            break
        # an error that is all of a small field tells nothing of steps: never more than 4 times
        step *= _LESS * min(4.0, target / norm if norm else 4.0)
    else:
        raise ArithmeticError(f"no steps were found for an error of {tolerance:.2g} of the peak")
    bound, between = (
        Error(*(rounded + weights + digits).tolist())
        for rounded, weights in zip(by_steps, by_weights, strict=True)
    )
    used = np.flatnonzero(numbers.reshape(len(numbers), -1).any(axis=1))
    return Fitted(
        fields=numbers[used].astype(np.int64),
        steps=steps,
        kept=kept,
        weights={name: weights[used] for name, weights in whole.items()},
        sizes={name: sizes[name] * 2.0**-_WEIGHT_BITS for name in kept},
        bound=bound,
        between=between,
    )


def _shares(sums: Sums, sizes: Mapping[str, float]) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Fields and weights of the sums in shares of their cycles' sizes, the weights up to 1."""
    paths = {
        name: path / sizes[name] if sizes[name] else np.zeros_like(path)
        for name, path in sums.weights.items()
    }
    most = np.max([np.abs(path).max(axis=1) for path in paths.values()], axis=0)
    most[most == 0] = 1.0
    return sums.fields * most[:, None, None], {q: path / most[:, None] for q, path in paths.items()}


def _drawn(whole: npt.NDArray[np.int64], kept: IntArray, count: int) -> FloatArray:
    """Weights (r, count) as the page has them: straight lines between the kept positions."""
    lines = [np.interp(np.arange(count), kept, row) for row in whole * 2.0**-_WEIGHT_BITS]
    return np.array(lines).reshape(len(whole), count)
