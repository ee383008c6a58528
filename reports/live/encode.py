"""One part's fields as the text that a page carries; viewer.js says what stands in it."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import FATIGUE, EncodedPart, IntArray, LiveFields, von_mises
from checks.result.words import brief
from reports.live.accuracy import LENGTH_METRIC, STRESS_METRIC, lost_in_single
from reports.live.extremes import displacements, scales
from reports.live.fitting import FLOOR, Fitted, fitted, kept_positions, sizes_with_floor
from reports.live.planes import Writer
from reports.live.sampling import Sample, looked_at
from reports.live.surface import (
    Neighbours,
    morton_order,
    neighbours,
    ordered_triangles,
    placed,
)

TOLERANCE = 1e-3  # of a cycle's peak
FATIGUE_LEVELS = 4095
# A shear stress counts thrice in the square of the von Mises stress.
_STRESS_STEPS = 2**0.5 * np.array([1.0, 1.0, 1.0, 3**-0.5, 3**-0.5, 3**-0.5])
_ROUND_OFF = 1e-6  # of a cycle's peak


def encode(live: LiveFields, cycles: Sequence[str], tolerance: float = TOLERANCE) -> EncodedPart:
    """Encode a part; the same fields give the same text.

    cycles     names of the design's cycles, in their order
    tolerance  of each cycle's peak, by which the von Mises stress may be off anywhere; single
               precision of the unit fields may cost more where they nearly cancel each other, which
               is then said in the notes

    Raises ArithmeticError if the fields cannot be written that exactly, and ValueError if they do
    not have the peaks that the solver found.
    """
    grid = placed(live.nodes)
    order = morton_order(grid.positions)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    triangles = ordered_triangles(rank[live.triangles])
    near = neighbours(triangles, len(order))
    writer = Writer()
    writer.add("triangles", _relative(triangles))
    writer.add("positions", _less_expected(grid.positions[:, order], near))
    head: dict[str, Any] = {
        "nodes": len(order),
        "triangles": triangles.shape[1],
        "bounds": [live.nodes.min(axis=0).tolist(), live.nodes.max(axis=0).tolist()],
        "coding": {"origin": grid.origin.tolist(), "step": grid.step, "layout": writer.layout},
        "fields": 0,
        "displacement": False,
        "cycles": [None] * len(cycles),
        "scale": {},
        "decides": live.decides,
        "estimated": live.estimated,
        "missing": dict(live.missing),
        "notes": list(live.notes),
        "peak": None,
        "accuracy": None,
        "limits": {"fatigue": 1.0 if live.judged else None},
    }
    _add_fatigue(head, writer, live, order, near)
    if live.n_fields:
        found = _fit(live, tolerance)
        if found is None:
            nothing = "nothing loads this part at any position: its stress is zero"
            head["missing"] |= dict.fromkeys(("mises", "principal", "displacement"), nothing)
            head["notes"].append(nothing)
        else:
            _write_fields(writer, found, order, near, cycles)
            _tell_fields(head, live, found, cycles, tolerance)
    if live.peak is not None:
        head["peak"] = {
            "node": int(rank[live.peak.node]),
            "cycle": list(cycles).index(live.peak.cycle),
            "position": live.peak.position,
            "value": live.peak.value,
            "place": live.peak.place,
        }
    return EncodedPart(head, writer.text())


@dataclass(frozen=True, eq=False)
class _Fit:
    """The fields over the cycles, in whole steps.

    sample    positions at which the stress was looked at, and what it is there
    kept      cycle -> (k,) numbers of the positions that the page carries
    groups    "stress", and "displacement" where that is known and not nothing
    measured  largest error of the von Mises stress that was found, over its cycle's peak
    ways      cycle -> mm, the largest displacement
    """

    sample: Sample
    kept: Mapping[str, IntArray]
    groups: Mapping[str, Fitted]
    measured: float
    ways: Mapping[str, float]

    @property
    def stress(self) -> Fitted:
        """The stress fields."""
        return self.groups["stress"]


def _fit(live: LiveFields, tolerance: float) -> _Fit | None:
    """Fit the stress and displacement fields at the kept positions; None where nothing loads."""
    sample = looked_at(live)
    peaks = sizes_with_floor(sample.peaks)
    if not any(peaks.values()):
        return None
    wanted = {name: at.tolist() for name, at in sample.positions.items()}
    if live.peak is not None:  # of equal ones it may be another than the largest to the last digit
        wanted[live.peak.cycle].append(live.peak.position)
    combined, kept = kept_positions(live.stress, live.coefficients, peaks, STRESS_METRIC, wanted)
    stress = fitted(
        combined, kept, STRESS_METRIC, _STRESS_STEPS, tolerance, _shares(sample.lost, peaks)
    )
    measured = _measured(live, sample, kept, stress)
    if measured > stress.bound + _ROUND_OFF:
        raise AssertionError(
            f"the proven error of the live stress is {stress.bound:.3g} of a cycle's peak, but "
            f"{measured:.3g} was found"
        )
    groups = {"stress": stress}
    ways = displacements(live, kept)
    if live.displacement is not None and any(ways.values()):
        moved = sizes_with_floor(ways)
        lost = _shares(lost_in_single(live.displacement, live.coefficients, LENGTH_METRIC), moved)
        combined, _ = kept_positions(
            live.displacement, live.coefficients, moved, LENGTH_METRIC, wanted
        )
        groups["displacement"] = fitted(combined, kept, LENGTH_METRIC, np.ones(3), tolerance, lost)
    return _Fit(sample, kept, groups, measured, ways)


def _write_fields(
    writer: Writer, found: _Fit, order: IntArray, near: Neighbours, cycles: Sequence[str]
) -> None:
    """Write the fields, and behind them their weights at the kept positions, cycle by cycle."""
    for name, group in found.groups.items():
        arrays = [row for field in group.fields[:, order] for row in field.T]
        writer.add(name, _less_expected(arrays, near))
    for number, cycle in enumerate(cycles):
        if cycle in found.kept:
            for name, group in found.groups.items():
                writer.add(f"{name} weights {number}", _bent(group.weights[cycle]))


def _tell_fields(
    head: dict[str, Any],
    live: LiveFields,
    found: _Fit,
    cycles: Sequence[str],
    tolerance: float,
) -> None:
    """Write the number of fields, the kept positions and the accuracy into the header."""
    kept, stress = found.kept, found.stress
    head |= {
        "fields": len(stress.fields),
        "displacement": "displacement" in found.groups,
        "cycles": [{"positions": kept[name].tolist()} if name in kept else None for name in cycles],
        "accuracy": _accuracy(found, _thinned(live, kept), cycles),
    }
    head["notes"] += [*_left_out(live, kept, stress), *_cancelling(stress, tolerance)]
    head["scale"] |= scales(live, found.sample, kept, found.ways)
    head["coding"] |= {
        name: {
            "fields": len(group.fields),
            "steps": group.steps.tolist(),
            "weights": [group.sizes.get(cycle, 0.0) for cycle in cycles],
        }
        for name, group in found.groups.items()
    }


def _thinned(live: LiveFields, kept: Mapping[str, IntArray]) -> list[str]:
    """Cycles that have more positions than a page carries."""
    return [name for name, at in kept.items() if len(at) < live.coefficients[name].shape[1]]


def _left_out(live: LiveFields, kept: Mapping[str, IntArray], stress: Fitted) -> list[str]:
    """Notes for the reader where a cycle has more positions than a page carries."""
    counts = {name: c.shape[1] for name, c in live.coefficients.items()}
    left = _thinned(live, kept)
    if not left:
        return []
    told = ", ".join(f"{len(kept[name])} of {counts[name]} of {brief(name)}" for name in left)
    return [
        f"the page carries the loads of some positions of long cycles ({told}), the peaks among "
        f"them; between these it takes straight lines, {100 * stress.between:.2g} % of the cycle's "
        "peak off at most"
    ]


def _measured(
    live: LiveFields, sample: Sample, kept: Mapping[str, IntArray], stress: Fitted
) -> float:
    """Largest difference of the von Mises stress at the sampled positions, over its cycle's peak.

    Of all nodes, in full precision, against what the page is handed.
    """
    worst = 0.0
    written = (stress.fields * stress.steps).reshape(len(stress.fields), -1)
    for name, positions in sample.positions.items():
        at = np.searchsorted(kept[name], positions)
        weights = stress.weights[name][:, at] * stress.sizes[name]
        shown = (written.T @ weights).reshape(len(live.nodes), 6, -1)
        off = np.abs(von_mises(shown.swapaxes(1, 2)) - sample.mises[name])
        size = sizes_with_floor(sample.peaks)[name]
        worst = max(worst, float(off.max()) / size if size else 0.0)
    return worst


def _shares(lost: Mapping[str, float], sizes: Mapping[str, float]) -> float:
    """The largest share of a cycle's size that is lost."""
    return max(lost[name] / size for name, size in sizes.items() if size > 0)


def _cancelling(stress: Fitted, tolerance: float) -> list[str]:
    """Notes for the reader where single precision costs more than the tolerance."""
    if stress.bound <= tolerance:
        return []
    return [
        f"its unit loads nearly cancel each other: its stress is drawn to {100 * stress.bound:.2g} "
        f"% of the cycle's peak, not to {100 * tolerance:g} %"
    ]


def _accuracy(found: _Fit, thinned: Collection[str], cycles: Sequence[str]) -> dict[str, Any]:
    """Error bounds of the drawing. thinned: cycles of which some positions are left out."""
    stress, sample, moved = found.stress, found.sample, found.groups.get("displacement")
    sizes, ways = sizes_with_floor(sample.peaks), sizes_with_floor(found.ways)
    count = sum(len(at) for at in sample.positions.values())
    floor = kept = between = ""
    if any(0 < sample.peaks[name] < size for name, size in sizes.items()):
        floor = f" (or of {100 * FLOOR:g} % of the largest cycle's, if that is more)"
    if thinned:
        kept = " that the page keeps"
        between = f", and by at most {100 * stress.between:.2g} % between those"
    words = (
        f"What is drawn differs from the solver's von Mises stress by at most "
        f"{100 * stress.bound:.2g} % of the cycle's peak{floor} at any node and position{kept}"
        f"{between}, proven when the page was written; at {count} positions "
        f"{100 * found.measured:.2g} % was measured."
    )

    def off(own: Mapping[str, float], at_kept: float, left_out: float) -> list[float | None]:
        """Error bound of each cycle's field, in its unit."""
        share = {name: left_out if name in thinned else at_kept for name in own}
        return [share[name] * own[name] if name in own else None for name in cycles]

    return {
        "share": stress.bound,
        "between": stress.between,
        "measured": found.measured,
        "positions": count,
        "mises": off(sizes, stress.bound, stress.between),
        "principal": off(sizes, stress.principal, stress.principal_between),
        "displacement": None if moved is None else moved.bound,
        "moved": None if moved is None else off(ways, moved.bound, moved.between),
        "words": words,
    }


def _add_fatigue(
    head: dict[str, Any], writer: Writer, live: LiveFields, order: IntArray, near: Neighbours
) -> None:
    """Add the fields over the duty, each in steps of its own."""
    steps = {}
    for name in FATIGUE:
        if name not in live.fatigue:
            head["missing"].setdefault(name, "fatigue was not judged: no cycle is in the duty")
            continue
        values = live.fatigue[name].astype(np.float64)
        largest = float(np.abs(values).max())
        steps[name] = largest / FATIGUE_LEVELS if largest else 1.0
        whole = np.rint(values / steps[name]).astype(np.int64)
        writer.add(name, _less_expected([whole[order]], near))
        head["scale"][name] = {
            "from": min(0.0, float(values.min())),
            "to": max(0.0, float(values.max())),
            "unit": "" if name == "utilisation" else "MPa",
        }
    head["coding"]["fatigue"] = steps


def _relative(triangles: npt.NDArray[np.int32]) -> list[npt.NDArray[np.int64]]:
    """First nodes as steps from the last triangle's, the others as steps from the first."""
    first, second, third = triangles.astype(np.int64)
    return [np.diff(first, prepend=0), second - first, third - first]


def _less_expected(arrays: Any, near: Neighbours) -> list[npt.NDArray[np.int64]]:
    """Values at the nodes less the values that their neighbours predict."""
    return [values.astype(np.int64) - near.expected(values.astype(np.int32)) for values in arrays]


def _bent(weights: npt.NDArray[np.int64]) -> list[npt.NDArray[np.int64]]:
    """Second differences of a row of weights: each less the line through the last two."""
    return list(np.diff(weights, n=2, axis=1, prepend=np.zeros((len(weights), 2), dtype=np.int64)))
