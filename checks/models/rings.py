"""The largest stress around a pin, between the angles at which a model has its points.

Around a section every component of stress is a trigonometric polynomial of the angle, of a degree
below half the number of points, so that its values at even angles give it at all angles exactly:

    f(a) = sum_k f(a_k) D(a - a_k),   D(x) = (1 + 2 sum_(m < n/2) cos m x)/n

Where a section comes near the largest, static or of fatigue, it is asked at finer and finer angles;
those where it is largest join the model's points. So a pin's result does not depend on how it lies
in its axes.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from checks.stress.stress_result import RungModel
from fem.stress_history import StressHistory
from geometry.mesh import FloatArray, IntArray

_NEAR = 0.97  # of the largest: sections and angles beside which there may be more
_FINER = 5  # times, from one round to the next
_ROUNDS = 5  # from 15 degrees to 0.005: the peak, flat there, is missed by 1e-8
_MOST = 16  # angles that are followed
_ROUND_OFF = 1e-12  # of the largest wave of a stress around its ring
_SAME = 1e-6  # of a degree's radians: two points are one

Values = Callable[[StressHistory, FloatArray], tuple[FloatArray, FloatArray]]
"""Of a history's points with their fretting (n,): what is judged where it is known, exact at the
worst, and a bound (n,) that it does not exceed."""


def with_peaks(model: RungModel, judged: Values) -> RungModel:
    """Return a model of rings of points with the point of one more, where `judged` is largest."""
    count = model.ring
    finest = count * _FINER**_ROUNDS  # angles are numbers of these parts of a turn
    followed = _largest(*judged(model.history, model.fretting), _NEAR)
    followed = followed[followed < len(model.history.points) // count * count]
    rings, parts = followed // count, followed % count * _FINER**_ROUNDS
    # the nearest angle, half a step off, is lower by at most degree^2/8 step^2 (Bernstein)
    lower = _degree(model) ** 2 / 7
    for k in reversed(range(_ROUNDS)):
        beside = _FINER**k * np.arange(-_FINER, _FINER + 1)
        places = rings[:, None] * finest + (parts[:, None] + beside) % finest
        _, first = np.unique(places, return_index=True)  # windows of neighbours overlap
        rings, parts = np.divmod(places.ravel()[np.sort(first)], finest)
        at = _around(model, rings, 2 * np.pi / finest * parts)
        step = 2 * np.pi / finest * _FINER**k
        best = _largest(*judged(at, model.fretting[rings * count]), 1 - lower * step**2)
        rings, parts = rings[best], parts[best]
    ring = rings[:1]
    more = _around(model, ring, 2 * np.pi / finest * parts[:1])
    history = model.history
    if np.min(np.linalg.norm(history.points - more.points, axis=1)) < _SAME:
        return model
    together = StressHistory(
        np.arange(len(history.points) + 1),
        np.concatenate([history.points, more.points]),
        np.concatenate([history.basis, more.basis]),
        history.coefficients,
    )
    return replace(
        model,
        history=together,
        places=[*model.places, model.places[int(ring[0]) * count]],
        fretting=np.append(model.fretting, model.fretting[ring * count]),
    )


def static_values(history: StressHistory, _: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The largest von Mises stress (n,) of each point, MPa."""
    found = history.peaks_by_point()
    return found, found


def _largest(values: FloatArray, bounds: FloatArray, share: float) -> IntArray:
    """The places that may have at least a share of the largest value, the one that has it first."""
    order = np.argsort(-bounds, kind="stable")[:_MOST]
    worst = int(values.argmax())
    order = order[(bounds[order] >= share * values[worst]) & (order != worst)]
    return np.concatenate([[worst], order])


def _degree(model: RungModel) -> int:
    """Degree of the polynomials of the angle that the stress of a model's rings is."""
    count, basis = model.ring, model.history.basis
    whole = len(basis) // count * count
    waves = np.abs(np.fft.rfft(basis[:whole].reshape(-1, count, *basis.shape[1:]), axis=1))
    sizes = waves.max(axis=(0, 2, 3))
    return int(np.flatnonzero(sizes > _ROUND_OFF * sizes.max()).max(initial=1))


def _around(model: RungModel, rings: IntArray, angles: FloatArray) -> StressHistory:
    """The history at angles (n,), rad, of rings (n,)."""
    count, history = model.ring, model.history
    whole = len(history.points) // count * count
    even = 2 * np.pi * np.arange(count) / count
    order = np.arange(1, (count + 1) // 2)
    apart = angles[:, None] - even
    weights = (1 + 2 * np.cos(apart[..., None] * order).sum(axis=-1)) / count
    basis = history.basis[:whole].reshape(-1, count, *history.basis.shape[1:])
    points = history.points[:whole].reshape(-1, count, 3)
    return StressHistory(
        np.arange(len(angles)),
        np.einsum("nk,nki->ni", weights, points[rings]),
        np.einsum("nk,nkij->nij", weights, basis[rings]),
        history.coefficients,
    )
