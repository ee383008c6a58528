"""Diagnosis of measured loads that do not balance: the slip that would explain it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from math import degrees

import numpy as np

from loads.bodies import FloatArray, IntArray, Vector
from loads.input_error_hypotheses import ALL, Slip, slips_of
from loads.kinematics import cross, rotated
from loads.measured import MeasuredBody, MeasuredLoads

_ROWS = 200  # that slips are tried on; what closes is then tried on all
_MOST_SUGGESTED = 3
_BETTER = 0.5  # of what is left: less than halved is no explanation
_EXPLAINED = 0.06  # of what was left, in the mean: more than that remains only where it is noise
_NOISY = 0.5  # of what was left, in the mean: more noise than that hides what is wrong
_COMPARABLE = 3.0  # times what the best suggestion leaves: worse ones are not told beside it
_SMALLER = 0.9  # of what was left in N, in the mean
_ROUND_OFF = 1e-9
_STRAIGHT = 0.98  # share of a direction in what is left, squared
_LEAST_GAIN = 0.05
_NOISE = 0.5  # correlation from row to row below which it looks like noise


@dataclass(frozen=True)
class Suggestion:
    """Slips that together explain the residual, and the share that remains without them."""

    words: str
    left: float
    point: str | None


@dataclass(frozen=True)
class Diagnosis:
    """Imbalance of a body, and slips that would close it, the likeliest first."""

    body: str
    share: float
    suggestions: tuple[Suggestion, ...]
    sentence: str

    def __str__(self) -> str:
        return self.sentence


def diagnose(loads: MeasuredLoads, body: str, tolerance: float) -> Diagnosis | None:
    """Return the diagnosis of the loads on a body, or None where they balance.

    tolerance  share of the largest force
    """
    entry, size = loads.body(body), loads.size(body)
    share = float(entry.shares(loads.gravity, size)[0].max())
    if share <= tolerance:
        return None
    suggestions = _explained(entry, loads.gravity, size, tolerance)
    return Diagnosis(
        body, share, suggestions, _sentence(loads, entry, size, tolerance, suggestions)
    )


def _explained(
    body: MeasuredBody, gravity: Vector, size: float, tolerance: float
) -> tuple[Suggestion, ...]:
    brief = body.at(_rows(body, gravity, size))
    slips = slips_of(brief, gravity, size)
    enough = min(tolerance, _BETTER * float(brief.shares(gravity, size)[0].max()))
    alone = {slip: slip.mend(brief) for slip in slips}
    for tried in (
        _singles(slips),
        _pairs(slips, bool(_mass_gains(body, gravity, size, tolerance))),
    ):
        found = []
        for together in tried:
            first, *others = together
            if _mended(alone[first], others).shares(gravity, size)[0].max() > enough:
                continue
            left = _mended(body, together).shares(gravity, size)[0]
            if left.max() <= tolerance and _explains(body, together, gravity, size):
                mean = max(_mean(left), _ROUND_OFF)
                rarity = sum(slip.rarity for slip in together)
                found.append((mean * (1 + 0.3 * rarity), mean, together, float(left.max())))
        if found:
            found.sort(key=lambda entry: entry[0])
            least = min(mean for _, mean, _, _ in found)
            return tuple(
                _suggestion(together, left)
                for _, mean, together, left in found
                if mean <= _COMPARABLE * least
            )[:_MOST_SUGGESTED]
    return ()


def _singles(slips: list[Slip]) -> Iterator[tuple[Slip, ...]]:
    return ((slip,) for slip in slips)


def _pairs(slips: list[Slip], mass_does: bool) -> Iterator[tuple[Slip, ...]]:
    """Yield the slips that can have happened together.

    mass_does  one other mass or inertia closes it, too: likelier than two slips of the motion
    """
    for pair in combinations(slips, 2):
        of_motion = pair[0].point is None and pair[1].point is None
        if not (pair[0].excludes(pair[1]) or (mass_does and of_motion)):
            yield pair


def _rows(body: MeasuredBody, gravity: Vector, size: float) -> IntArray:
    n = len(body.angle)
    marked = [int(body.shares(gravity, size)[0].argmax())]
    marked += [int(np.hypot(*load.force.T).argmax()) for load in body.loads]
    return np.unique([*np.linspace(0, n - 1, min(n, _ROWS)).astype(np.int64), *marked])


def _mended(body: MeasuredBody, slips: Sequence[Slip]) -> MeasuredBody:
    for slip in slips:
        body = slip.mend(body)
    return body


def _explains(body: MeasuredBody, slips: tuple[Slip, ...], gravity: Vector, size: float) -> bool:
    """Return True if slips that close the balance also account for its residual.

    They do if the residual that remains is small against it, or noise. A load or motion that a slip
    makes very small must still be needed: where leaving it out does as well, the reading itself is
    wrong.
    """
    mended = _mended(body, slips)
    (shares, largest), (left, of) = (entry.shares(gravity, size) for entry in (body, mended))
    before, after = _mean(shares), _mean(left)
    if after * of > _SMALLER * before * largest:
        return False  # it is only set against larger forces
    if after > _EXPLAINED * before and not (
        after <= _NOISY * before and _like_noise(mended.residual(gravity), size)
    ):
        return False
    for k, slip in enumerate(slips):
        if slip.without is not None:
            bare = (*slips[:k], replace(slip, mend=slip.without), *slips[k + 1 :])
            if after > _BETTER * _mean(_mended(body, bare).shares(gravity, size)[0]):
                return False
    return True


def _mean(shares: FloatArray) -> float:
    return float(np.sqrt(np.mean(shares**2)))


def _like_noise(left: FloatArray, size: float) -> bool:
    """Return True if a residual (n, 3) jumps from row to row."""
    scaled = left / np.array([1.0, 1.0, size or 1.0])
    steps = float(np.sum(np.diff(scaled, axis=0) ** 2))
    whole = float(np.sum(scaled**2)) * (len(left) - 1) / len(left)
    return len(left) > 2 and whole > 0.0 and 1 - steps / (2 * whole) < _NOISE


def _suggestion(slips: tuple[Slip, ...], left: float) -> Suggestion:
    points = {slip.point for slip in slips} - {None, ALL}
    return Suggestion(
        " and ".join(slip.words for slip in slips), left, points.pop() if points else None
    )


def _sentence(
    loads: MeasuredLoads,
    body: MeasuredBody,
    size: float,
    tolerance: float,
    suggestions: tuple[Suggestion, ...],
) -> str:
    shares, largest = body.shares(loads.gravity, size)
    worst = int(shares.argmax())
    left = body.residual(loads.gravity)
    force, moment = float(np.hypot(*left[worst, :2])), abs(float(left[worst, 2]))
    if not size or force >= moment / size:
        amount = f"{force:.4g} N ({percent(force / largest)} of the largest force)"
    else:
        amount = (
            f"{moment / 1e3:.4g} N m ({percent(moment / size / largest)} of the largest force "
            f"times {size:.4g} mm)"
        )
    name = body.body.name
    if suggestions and suggestions[0].point:
        name = f"pin {suggestions[0].point} of {name}"
    said = f"{name}: unbalanced by {amount} at {position_text(loads, worst)}"
    if not suggestions:
        return f"{said}; {_what_is_left(body, loads.gravity, size, tolerance)}"
    first, *others = (f"{entry.words}" for entry in suggestions)
    also = f"; so does {', or '.join(others)}" if others else ""
    return f"{said}; {first} closes it (left: {percent(suggestions[0].left)}){also}"


def position_text(loads: MeasuredLoads, row: int) -> str:
    """Position of a row in the run, in words."""
    value = float(loads.positions[row])
    shown = degrees(value) if loads.position_unit == "deg" else value
    return f"{loads.position_name} {shown:.4g} {loads.position_unit}"


def percent(share: float) -> str:
    """A share in percent, to two digits."""
    if share < _ROUND_OFF:
        return "round-off"
    return f"{100 * share:.2g} %" if share < 0.095 else f"{100 * share:.0f} %"


def _what_is_left(body: MeasuredBody, gravity: Vector, size: float, tolerance: float) -> str:
    """Return a sentence on loads that no slip explains: noise, or direction and place."""
    left = body.residual(gravity)
    said = "no single error of sign, axes, frame or unit explains it, nor do two together"
    if _like_noise(left, size):
        return (
            f"{said}; what is left jumps from row to row like noise: smooth the data, or state "
            "a larger tolerance"
        )
    hints = []
    for frame, vectors in (
        ("ground", left[:, :2]),
        ("body", rotated(left[:, :2], -body.angle)),
    ):
        values, axes = np.linalg.eigh(vectors.T @ vectors)
        if values[-1] > 0 and values[-1] >= _STRAIGHT * values.sum():
            x, y = axes[:, -1] * (1 if axes[:, -1] @ vectors.sum(axis=0) >= 0 else -1)
            hints.append(f"points along ({x:.2f}, {y:.2f}) in the {frame}'s axes")
            break
    limit = tolerance * body.shares(gravity, size)[1]
    through = _acts_through(body, left, size, limit)
    if through:
        hints.append(
            f"acts through {' and '.join(through)} (is a force missing, or one wrong there?)"
        )
    hints += _gains(body, gravity, size, tolerance)
    if not hints:
        hints.append("neither keeps one direction nor acts through a point of the body")
    return f"{said}; what is left {', '.join(hints)}"


def _acts_through(body: MeasuredBody, left: FloatArray, size: float, limit: float) -> list[str]:
    """Points about which the residual has no moment."""
    if not size or len(body.body.points) < 2 or np.hypot(*left[:, :2].T).max() <= limit:
        return []
    found = []
    for point, place in body.body.points.items():
        arm = rotated(np.array(place, dtype=float) - body.body.centre, body.angle)
        moment = left[:, 2] - cross(arm, left[:, :2])
        if np.abs(moment).max() <= limit * size:
            found.append(point)
    return found


def _gains(body: MeasuredBody, gravity: Vector, size: float, tolerance: float) -> list[str]:
    """The force or mass that a factor would bring into balance, such as a wrong calibration's."""
    found = _mass_gains(body, gravity, size, tolerance)
    for load in body.loads:
        share, gain = _gain(body, partial(_with_gain, body, load.point), gravity, size)
        if share <= tolerance:
            found.append((share, f"vanishes with {gain:.3g} times the force at {load.point}"))
    return [min(found)[1]] if found else []


def _mass_gains(
    body: MeasuredBody, gravity: Vector, size: float, tolerance: float
) -> list[tuple[float, str]]:
    """The factors of mass or inertia that close the balance: what they leave, and words."""

    def with_mass(gain: float) -> MeasuredBody:
        own = body.body
        changed = own.with_mass_properties(gain * own.mass, own.centre, own.inertia)
        return replace(body, body=changed)

    def with_inertia(gain: float) -> MeasuredBody:
        own = body.body
        changed = own.with_mass_properties(own.mass, own.centre, gain * own.inertia)
        return replace(body, body=changed)

    found = []
    for name, change in (("mass", with_mass), ("inertia", with_inertia)):
        share, gain = _gain(body, change, gravity, size)
        if share <= tolerance:
            found.append((share, f"vanishes with {gain:.3g} times the {name}"))
    return found


def _gain(
    body: MeasuredBody, change: Callable[[float], MeasuredBody], gravity: Vector, size: float
) -> tuple[float, float]:
    """Return the largest share left by the best factor, and that factor.

    The share is infinite where the factor is at most some percent.

    change  the body with something times a factor
    """
    without = change(0.0).residual(gravity)
    own = body.residual(gravity) - without
    for values in (without, own):
        values[:, 2] /= size or 1.0
    square = float(np.sum(own**2))
    gain = -float(np.sum(own * without)) / square if square else 0.0
    if gain <= _LEAST_GAIN:
        return float("inf"), gain
    return float(change(gain).shares(gravity, size)[0].max()), gain


def _with_gain(body: MeasuredBody, point: str, gain: float) -> MeasuredBody:
    return replace(
        body,
        loads=tuple(
            replace(load, force=gain * load.force, moment=gain * load.moment)
            if load.point == point
            else load
            for load in body.loads
        ),
    )
