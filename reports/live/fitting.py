"""Fields in whole steps, as large as a tolerance allows, and the proof that they keep it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import FloatArray, IntArray
from reports.live.accuracy import Corners, corners, error_bound, largest_sizes
from reports.live.combine import NOTHING, Combined, combine

MOST_POSITIONS = 3601  # of a cycle in a page
FLOOR = 1e-4  # of the largest cycle's size: cycles below that are as exact as if they had it
_WEIGHT_BITS = 18
_DOUBLE = 2.0**-51  # over root 3: precision of the browser's sums
_SINGLE = 2.0**-24  # and of what it makes of them
_CORNERS, _NEAR = 256, 0.02
_SAMPLE = 8  # every n-th node tells the size of the steps; all of them prove it
_FIRST, _LESS, _ROUNDS = 0.4, 0.95, 20
_LEAST = 0.25  # of the tolerance: what the steps may take even if all of it is lost elsewhere
_LARGEST = 2**30


@dataclass(frozen=True, eq=False)
class Fitted:
    """Fields and weights in whole steps: sum_j steps * fields[j] * sizes[q] * weights[q][j, k].

    fields     (r, n, c) whole numbers
    steps      (c,) what one is worth
    weights    cycle -> (r, n_kept) whole numbers at the kept positions
    sizes      cycle -> what one whole step of a weight is worth, in the unit of the sum
    bound      proven largest error at kept positions, over the size of the position's cycle
    principal  the same of a principal stress; 0 of displacements
    between    as bound, at positions that were left out, taken from the straight line
    principal_between  as principal, at those
    """

    fields: npt.NDArray[np.int64]
    steps: FloatArray
    weights: Mapping[str, npt.NDArray[np.int64]]
    sizes: Mapping[str, float]
    bound: float
    principal: float
    between: float
    principal_between: float


def sizes_with_floor(sizes: Mapping[str, float]) -> dict[str, float]:
    """Sizes of cycles, none below FLOOR of the largest but those that are nothing."""
    floor = FLOOR * max(sizes.values(), default=0.0)
    return {name: max(size, floor) if size > 0 else 0.0 for name, size in sizes.items()}


def kept_positions(
    fields: npt.NDArray[Any],
    coefficients: Mapping[str, FloatArray],
    sizes: Mapping[str, float],
    metric: FloatArray,
    wanted: Mapping[str, Sequence[int]],
) -> tuple[Combined, dict[str, IntArray]]:
    """Combine unit fields, and choose the positions of each cycle that a page carries.

    wanted  cycle -> positions that must be among them
    """
    combined = combine(fields, coefficients, sizes, metric)
    kept = {}
    for name, path in combined.weights.items():
        if path.shape[1] <= MOST_POSITIONS:
            kept[name] = np.arange(path.shape[1])
        else:
            kept[name] = corners([path], MOST_POSITIONS, wanted=[wanted[name]]).kept[0]
    return combined, kept


def fitted(
    combined: Combined,
    kept: Mapping[str, IntArray],
    metric: FloatArray,
    components: FloatArray,
    tolerance: float,
    lost: float,
) -> Fitted:
    """Round fields to the largest steps whose proven error stays within a tolerance.

    components  (c,) how large the steps of the components are beside each other
    tolerance   of a cycle's size
    lost        of a cycle's size, by which the fields are off before they are rounded; where this
                is almost all of the tolerance or more, `bound` exceeds it

    Raises ArithmeticError if no step does, which needs fields without any bound.
    """
    whole = {
        name: np.rint(combined.weights[name][:, at] * 2.0**_WEIGHT_BITS).astype(np.int64)
        for name, at in kept.items()
    }
    rounded = {
        name: np.asarray(weights * 2.0**-_WEIGHT_BITS, dtype=np.float64)
        for name, weights in whole.items()
    }
    reach, plain = largest_sizes(combined.fields, metric)
    at_kept, between = _missed(combined.weights, kept, rounded)
    rank = len(combined.fields)
    digits = rank * _DOUBLE * plain + _SINGLE  # no norm is above root 3 times the plain length
    digits += lost + NOTHING
    other = reach.norm * at_kept + digits
    around = corners(list(rounded.values()), _CORNERS, _NEAR) if rounded and rank else None
    fields, steps, bound, principal = _stepped(
        combined.fields, around, metric, components, max(tolerance - other, _LEAST * tolerance)
    )
    reached = max(between, at_kept)
    more = digits + _SINGLE * reach.principal  # a principal stress may exceed the cycle's size
    used = np.flatnonzero(fields.reshape(rank, -1).any(axis=1))
    return Fitted(
        fields=fields[used],
        steps=steps,
        weights={name: weights[used] for name, weights in whole.items()},
        sizes={name: combined.sizes[name] * 2.0**-_WEIGHT_BITS for name in kept},
        bound=bound + other,
        principal=principal + reach.principal * at_kept + more if principal else 0.0,
        between=bound + reach.norm * reached + digits,
        principal_between=principal + reach.principal * reached + more if principal else 0.0,
    )


def _stepped(
    fields: FloatArray,
    around: Corners | None,
    metric: FloatArray,
    components: FloatArray,
    tolerance: float,
) -> tuple[npt.NDArray[np.int64], FloatArray, float, float]:
    """Whole numbers, the steps, and the proven bounds of the norm and of principal stresses."""
    if around is None or not fields.size:
        return np.zeros(fields.shape, dtype=np.int64), components.copy(), 0.0, 0.0
    step = _FIRST * tolerance
    sample = np.ascontiguousarray(fields[:, ::_SAMPLE])
    for looked in (sample, sample, *[fields] * _ROUNDS):
        steps = step * components
        if not float(np.abs(fields).max()) < _LARGEST * float(steps.min()):
            raise ArithmeticError(
                f"live fields need more than 30 bits for an error of {tolerance:.2g} of the peak"
            )
        numbers = np.rint(looked / steps)
        bound = error_bound(numbers * steps - looked, around, metric)
        if looked is fields and bound.norm <= tolerance:
            return numbers.astype(np.int64), steps, bound.norm, bound.principal
        # an error that is all of a small field tells nothing of steps: never more than 4 times
        step *= _LESS * min(4.0, tolerance / bound.norm if bound.norm else 4.0)
    raise ArithmeticError(f"no steps were found for an error of {tolerance:.2g} of the peak")


def _missed(
    weights: Mapping[str, FloatArray],
    kept: Mapping[str, IntArray],
    rounded: Mapping[str, FloatArray],
) -> tuple[float, float]:
    """Largest errors of weights in whole steps, at kept positions and over all positions."""
    at_kept, between = 0.0, 0.0
    for name, path in weights.items():
        count = path.shape[1]
        if not path.size:
            continue
        line = np.stack([np.interp(np.arange(count), kept[name], row) for row in rounded[name]])
        away = np.sqrt(((path - line) ** 2).sum(axis=0))
        at_kept = max(at_kept, float(away[kept[name]].max()))
        between = max(between, float(away.max()))
    return at_kept, between
