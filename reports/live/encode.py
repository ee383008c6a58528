"""One part's fields as the text that a page carries; viewer.js says what stands in it.

A surface and numbers at its nodes are planes of bytes, which are read again to the last bit.
"""

import zlib
from base64 import b64encode
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import FATIGUE, EncodedPart, LiveFields
from checks.result.words import brief
from geometry.mesh import FloatArray, IntArray
from reports.live.fitting import (
    FLOOR,
    LENGTH_METRIC,
    STRESS_METRIC,
    Fitted,
    Sums,
    fewest,
    fitted,
    largest_anywhere,
    largest_principal_stress,
    largest_sizes,
    lost_in_single,
    sizes_with_floor,
)

Integers = npt.NDArray[np.int32]

GZIP = 16 + zlib.MAX_WBITS
BITS = 16  # of a position, over the longest side
_MOST = 4  # planes: numbers of 32 bits


@dataclass
class Writer:
    """Collects arrays; `layout` then says what stands in the text, in its order.

    layout  per section its name, the length of its arrays, and the number of planes of each
    """

    layout: list[dict[str, object]] = field(default_factory=list)
    _chunks: list[bytes] = field(default_factory=list)

    def add(self, name: str, arrays: Sequence[npt.NDArray[np.int64]]) -> None:
        """Add a section of arrays of one length; raises ValueError beyond 32 bits.

        Signs go to the lowest bit: 0, -1, 1, -2 become 0, 1, 2, 3.
        """
        counts = []
        for values in arrays:
            folded = np.where(values < 0, -2 * values - 1, 2 * values)
            largest = int(folded.max(initial=0))
            if largest >= 1 << 8 * _MOST:
                raise ValueError(f"live payload: {name} needs more than 32 bits ({largest})")
            planes = (largest.bit_length() + 7) // 8
            whole = folded.astype("<u4").view(np.uint8).reshape(-1, 4)
            self._chunks += [whole[:, plane].tobytes() for plane in range(planes)]
            counts.append(planes)
        length = len(arrays[0]) if len(arrays) else 0
        self.layout.append({"name": name, "length": length, "planes": counts})

    def text(self) -> str:
        """All of it: base64 of gzip, the same for the same numbers."""
        # level 9 takes ten times as long for 2 % less
        packer = zlib.compressobj(5, zlib.DEFLATED, GZIP, 9, zlib.Z_FILTERED)
        return b64encode(packer.compress(b"".join(self._chunks)) + packer.flush()).decode()


@dataclass(frozen=True, eq=False)
class Placed:
    """Nodes as whole steps of a grid.

    origin     (3,) mm
    step       mm
    positions  (3, n) steps
    """

    origin: FloatArray
    step: float
    positions: Integers


def placed(nodes: FloatArray) -> Placed:
    """Round nodes (n, 3) to a grid of 2**BITS over their longest side."""
    origin = nodes.min(axis=0)
    side = float(np.ptp(nodes, axis=0).max())
    step = side / (2**BITS - 1) if side > 0 else 1.0
    return Placed(origin, step, np.rint((nodes - origin) / step).astype(np.int32).T.copy())


def morton_order(positions: Integers) -> IntArray:
    """Order of nodes along Morton's curve, which keeps neighbours together."""
    code = np.zeros(positions.shape[1], dtype=np.uint64)
    for bit in range(BITS):
        for axis in range(3):
            digit = (positions[axis].astype(np.uint64) >> np.uint64(bit)) & np.uint64(1)
            code |= digit << np.uint64(3 * bit + axis)
    return np.argsort(code, kind="stable").astype(np.int64)


def ordered_triangles(triangles: IntArray) -> Integers:
    """Triangles (3, m), each from its smallest node on, sorted by their nodes."""
    first = triangles.argmin(axis=1)
    turned = triangles[np.arange(len(triangles))[:, None], (first[:, None] + np.arange(3)) % 3]
    order = np.lexsort(turned.T[::-1])
    return np.ascontiguousarray(turned[order].T.astype(np.int32))


@dataclass(frozen=True, eq=False)
class Neighbours:
    """The neighbours of every node that come before it, each once.

    lower   all of them, node after node
    nodes   nodes that have any, ascending
    starts  where theirs begin in `lower`
    counts  how many they are
    """

    lower: IntArray
    nodes: IntArray
    starts: IntArray
    counts: IntArray

    def expected(self, values: Integers) -> npt.NDArray[np.int64]:
        """Prediction of values (n,) by earlier ones: neighbours' rounded mean, else the last value.

        The mean of k numbers of sum s is floor((2 s + k) / (2 k)), in whole numbers.
        """
        said = np.zeros(len(values), dtype=np.int64)
        said[1:] = values[:-1]
        if len(self.nodes):
            sums = np.add.reduceat(values[self.lower].astype(np.int64), self.starts)
            said[self.nodes] = (2 * sums + self.counts) // (2 * self.counts)
        return said

    def less_expected(self, arrays: Any) -> list[npt.NDArray[np.int64]]:
        """Rows of values at the nodes (n,), less what their neighbours predict."""
        return [
            values.astype(np.int64) - self.expected(values.astype(np.int32)) for values in arrays
        ]


def neighbours(triangles: Integers, count: int) -> Neighbours:
    """Neighbours along the edges of triangles (3, m) of `count` nodes."""
    first, second = triangles.astype(np.int64), np.roll(triangles, -1, axis=0).astype(np.int64)
    low, high = np.minimum(first, second).ravel(), np.maximum(first, second).ravel()
    edges = np.unique(high * count + low)
    high, lower = edges // count, edges % count
    nodes, starts, counts = np.unique(high, return_index=True, return_counts=True)
    return Neighbours(lower, nodes, starts, counts)


def relative(triangles: Integers) -> list[npt.NDArray[np.int64]]:
    """First nodes as steps from the last triangle's, the others as steps from the first."""
    first, second, third = triangles.astype(np.int64)
    return [np.diff(first, prepend=0), second - first, third - first]


def bent(weights: npt.NDArray[np.int64]) -> list[npt.NDArray[np.int64]]:
    """Second differences of a row of weights: each less the line through the last two."""
    return list(np.diff(weights, n=2, axis=1, prepend=np.zeros((len(weights), 2), dtype=np.int64)))


TOLERANCE = 1e-3  # of a cycle's peak
FATIGUE_LEVELS = 4095
_MODE_LEVELS = 127  # a mode has a shape and no size: to look at
# A shear stress counts thrice in the square of the von Mises stress.
_STRESS_STEPS = 2**0.5 * np.array([1.0, 1.0, 1.0, 3**-0.5, 3**-0.5, 3**-0.5])
_ALIKE = 1e-5  # of a cycle's peak: round-off between fields and the peaks told beside them
_SINGLE = 2.0**-24
_COMPARED = 12  # positions of a cycle


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
    writer.add("triangles", relative(triangles))
    writer.add("positions", near.less_expected(grid.positions[:, order]))
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
    if live.mode is not None:
        head["coding"]["mode"] = 1 / _MODE_LEVELS
        whole = np.rint(_MODE_LEVELS * live.mode.T.astype(np.float64)).astype(np.int64)
        writer.add("mode", near.less_expected(whole[:, order]))
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

    groups  "stress", and "displacement" where that is known and not nothing
    peaks   cycle -> MPa, largest von Mises stress
    ways    cycle -> mm, the largest displacement
    most    MPa, largest size of a principal stress
    """

    groups: Mapping[str, Fitted]
    peaks: Mapping[str, float]
    ways: Mapping[str, float]
    most: float

    @property
    def stress(self) -> Fitted:
        """The stress fields."""
        return self.groups["stress"]


def _fit(live: LiveFields, tolerance: float) -> _Fit | None:
    """Fit the stress and displacement fields at the kept positions; None where nothing loads."""
    if not live.coefficients:
        return None
    lost = lost_in_single(live.stress, live.coefficients, STRESS_METRIC)
    peaks = {name: float(peak.max()) for name, peak in live.peaks.items()}
    loaded = any(peaks.values())
    sums = fewest(live.stress, live.coefficients, sizes_with_floor(peaks) if loaded else None)
    _refuse_other_peaks(live, sums, lost)
    if not loaded:
        return None
    wanted = {name: [int(peak.argmax())] for name, peak in live.peaks.items()}
    if live.peak is not None:  # of equal ones it may be another than the largest to the last digit
        wanted[live.peak.cycle].append(live.peak.position)

    def fit(
        sums: Sums, sizes: Mapping[str, float], lost: Mapping[str, float], metric: FloatArray
    ) -> Fitted:
        steps = _STRESS_STEPS if metric is STRESS_METRIC else np.ones(3)
        sizes = sizes_with_floor(sizes)
        share = max(lost[name] / size for name, size in sizes.items() if size > 0)
        return fitted(sums, wanted, sizes, metric, steps, tolerance, share)

    groups = {"stress": fit(sums, peaks, lost, STRESS_METRIC)}
    ways = dict.fromkeys(peaks, 0.0)
    if live.displacement is not None:
        moved = fewest(live.displacement, live.coefficients)
        ways = {
            name: float(largest_anywhere(moved.fields, weights, LENGTH_METRIC)[0])
            for name, weights in moved.weights.items()
        }
        if any(ways.values()):
            lost_ways = lost_in_single(live.displacement, live.coefficients, LENGTH_METRIC)
            groups["displacement"] = fit(moved, ways, lost_ways, LENGTH_METRIC)
    return _Fit(groups, peaks, ways, largest_principal_stress(live, lost))


def _refuse_other_peaks(live: LiveFields, sums: Sums, lost: Mapping[str, float]) -> None:
    """Raise ValueError if the fields do not have the peaks that the solver found.

    At the position of each cycle's peak and at others evenly spread: fields of other loads, or of
    another part, have other peaks everywhere.
    """
    for name, weights in sums.weights.items():
        peak = live.peaks[name]
        spread = np.linspace(0, len(peak) - 1, _COMPARED).astype(np.int64)
        places = np.unique(np.append(spread, peak.argmax()))
        found = largest_sizes(sums.fields, weights[:, places], STRESS_METRIC)[0]
        off = np.abs(found - peak[places])
        if off.max() > _ALIKE * peak.max() + lost[name]:
            worst = int(off.argmax())
            place = int(places[worst])
            raise ValueError(
                f"live fields: the peak at position {place} of {name!r} is {peak[place]:.6g} MPa, "
                f"but the fields have {found[worst]:.6g}"
            )


def _write_fields(
    writer: Writer, found: _Fit, order: IntArray, near: Neighbours, cycles: Sequence[str]
) -> None:
    """Write the fields, and behind them their weights at the kept positions, cycle by cycle."""
    for name, group in found.groups.items():
        arrays = [row for field in group.fields[:, order] for row in field.T]
        writer.add(name, near.less_expected(arrays))
    for number, cycle in enumerate(cycles):
        if cycle in found.stress.kept:
            for name, group in found.groups.items():
                writer.add(f"{name} weights {number}", bent(group.weights[cycle]))


def _tell_fields(
    head: dict[str, Any],
    live: LiveFields,
    found: _Fit,
    cycles: Sequence[str],
    tolerance: float,
) -> None:
    """Write the number of fields, the kept positions and the accuracy into the header."""
    stress, kept = found.stress, found.stress.kept
    head |= {
        "fields": len(stress.fields),
        "displacement": "displacement" in found.groups,
        "cycles": [{"positions": kept[name].tolist()} if name in kept else None for name in cycles],
        "accuracy": _accuracy(found, _thinned(live, kept), cycles),
    }
    head["notes"] += [*_left_out(live, kept, stress), *_cancelling(stress, tolerance)]
    head["scale"] |= {
        "mises": {"from": 0.0, "to": max(found.peaks.values()), "unit": "MPa"},
        "principal": {"from": -found.most, "to": found.most, "unit": "MPa"},  # 0 in the middle
    }
    if any(found.ways.values()):
        head["scale"]["displacement"] = {"from": 0.0, "to": max(found.ways.values()), "unit": "mm"}
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
    off = 100 * stress.between.norm
    told = ", ".join(f"{len(kept[name])} of {counts[name]} of {brief(name)}" for name in left)
    return [
        f"the page carries the loads of some positions of long cycles ({told}), the peaks among "
        f"them; between these it takes straight lines, {off:.2g} % of the cycle's peak off at "
        "most"
    ]


def _cancelling(stress: Fitted, tolerance: float) -> list[str]:
    """Notes for the reader where single precision costs more than the tolerance."""
    if stress.bound.norm <= tolerance:
        return []
    return [
        f"its unit loads nearly cancel each other: its stress is drawn to "
        f"{100 * stress.bound.norm:.2g} % of the cycle's peak, not to {100 * tolerance:g} %"
    ]


def _accuracy(found: _Fit, thinned: Collection[str], cycles: Sequence[str]) -> dict[str, Any]:
    """Error bounds of the drawing. thinned: cycles of which some positions are left out."""
    stress, moved = found.stress, found.groups.get("displacement")
    sizes, ways = sizes_with_floor(found.peaks), sizes_with_floor(found.ways)
    floor = kept = between = ""
    if any(0 < found.peaks[name] < size for name, size in sizes.items()):
        floor = f" (or of {100 * FLOOR:g} % of the largest cycle's, if that is more)"
    if thinned:
        kept = " that the page keeps"
        between = f", and by at most {100 * stress.between.norm:.2g} % between those"
    words = (
        f"What is drawn differs from the solver's von Mises stress by at most "
        f"{100 * stress.bound.norm:.2g} % of the cycle's peak{floor} at any node and position"
        f"{kept}{between}, measured at all of them when the page was written."
    )

    def off(own: Mapping[str, float], at_kept: float, left_out: float) -> list[float | None]:
        """Error bound of each cycle's field, in its unit."""
        share = {name: left_out if name in thinned else at_kept for name in own}
        return [share[name] * own[name] if name in own else None for name in cycles]

    single = _SINGLE * found.most  # a principal stress may exceed the cycle's peak
    principal = off(sizes, stress.bound.principal, stress.between.principal)
    return {
        "share": stress.bound.norm,
        "between": stress.between.norm,
        "mises": off(sizes, stress.bound.norm, stress.between.norm),
        "principal": [None if each is None else each + single for each in principal],
        "displacement": None if moved is None else moved.bound.norm,
        "moved": None if moved is None else off(ways, moved.bound.norm, moved.between.norm),
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
        writer.add(name, near.less_expected([whole[order]]))
        head["scale"][name] = {
            "from": min(0.0, float(values.min())),
            "to": max(0.0, float(values.max())),
            "unit": "" if name == "utilisation" else "MPa",
        }
    head["coding"]["fatigue"] = steps
