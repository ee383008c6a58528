"""A part's text read again in Python: what viewer.js does, to test what is written."""

import zlib
from base64 import b64decode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import FATIGUE
from geometry.mesh import FloatArray, IntArray
from reports.live.encode import GZIP, Neighbours, neighbours

_Whole = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class DecodedPart:
    """Data of a part, decoded from a page.

    nodes      (n, 3) mm
    triangles  (m, 3)
    fields     "stress" (r, n, 6) and "displacement" (r, n, 3), as far as they are there
    weights    the same names -> number of a cycle -> (r, n_kept), MPa or mm per field
    kept       number of a cycle -> (n_kept,) positions of the cycle
    fatigue    field -> (n,)
    mode       (n, 3), None without
    """

    nodes: FloatArray
    triangles: IntArray
    fields: Mapping[str, FloatArray]
    weights: Mapping[str, Mapping[int, FloatArray]]
    kept: Mapping[int, IntArray]
    fatigue: Mapping[str, FloatArray]
    mode: FloatArray | None

    def stress(self, cycle: int, index: float) -> FloatArray:
        """Stress (n, 6) at a position of the whole cycle, which may lie between two, MPa."""
        return self._sum("stress", cycle, index)

    def displacement(self, cycle: int, index: float) -> FloatArray:
        """Displacement (n, 3) at a position of the whole cycle, mm."""
        return self._sum("displacement", cycle, index)

    def _sum(self, name: str, cycle: int, index: float) -> FloatArray:
        rows = self.weights[name][cycle]
        weights = np.array([np.interp(index, self.kept[cycle], row) for row in rows])
        return np.asarray(np.tensordot(weights, self.fields[name], axes=1))


def decode(head: Mapping[str, Any], text: str) -> DecodedPart:
    """Read a part's text by its entry in the header; ValueError if they do not fit each other."""
    coding, count = head["coding"], head["nodes"]
    sections = read_planes(text, coding["layout"])
    first, second, third = sections["triangles"]
    first = np.cumsum(first)
    triangles = np.stack([first, first + second, first + third])
    near = neighbours(triangles.astype(np.int32), count)
    steps = _nodal(sections["positions"], near)
    fields, weights = {}, {}
    for name in ("stress", "displacement"):
        if name in coding:
            told = coding[name]
            numbers = _nodal(sections[name], near).reshape(told["fields"], len(told["steps"]), -1)
            fields[name] = np.moveaxis(numbers, 1, 2) * np.array(told["steps"])
            weights[name] = {
                number: step * _straight(sections[f"{name} weights {number}"])
                for number, step in enumerate(told["weights"])
                if f"{name} weights {number}" in sections
            }
    return DecodedPart(
        nodes=np.array(coding["origin"]) + coding["step"] * steps.T,
        triangles=triangles.T,
        fields=fields,
        weights=weights,
        kept={
            number: np.array(cycle["positions"])
            for number, cycle in enumerate(head["cycles"])
            if cycle is not None
        },
        fatigue={
            name: coding["fatigue"][name] * _nodal(sections[name], near)[0]
            for name in FATIGUE
            if name in sections
        },
        mode=coding["mode"] * _nodal(sections["mode"], near).T if "mode" in coding else None,
    )


def _nodal(left: Sequence[_Whole], near: Neighbours) -> _Whole:
    """Return values (k, n) at the nodes from their differences to the neighbours' prediction."""
    if not left:
        return np.zeros((0, 0), dtype=np.int64)
    values = np.stack(left, axis=1)
    ends = near.starts + near.counts
    found = {int(node): k for k, node in enumerate(near.nodes)}
    for node in range(len(values)):
        k = found.get(node)
        if k is not None:
            n = int(near.counts[k])
            sums = values[near.lower[near.starts[k] : ends[k]]].sum(axis=0)
            values[node] += (2 * sums + n) // (2 * n)
        elif node:
            values[node] += values[node - 1]
    return values.T


def _straight(left: Sequence[_Whole]) -> FloatArray:
    """Return rows of weights from their second differences."""
    return np.cumsum(np.cumsum(np.stack(left).astype(np.float64), axis=1), axis=1)


def read_planes(
    text: str, layout: Sequence[dict[str, object]]
) -> dict[str, list[npt.NDArray[np.int64]]]:
    """Sections of a payload by name: what was added to its `Writer`; ValueError if damaged."""
    data = np.frombuffer(zlib.decompress(b64decode(text), GZIP), dtype=np.uint8)
    found: dict[str, list[npt.NDArray[np.int64]]] = {}
    place = 0
    for section in layout:
        length, planes = section["length"], section["planes"]
        assert isinstance(length, int)
        assert isinstance(planes, list)
        arrays = []
        for count in planes:
            folded = np.zeros(length, dtype=np.int64)
            for plane in range(count):
                folded |= data[place : place + length].astype(np.int64) << 8 * plane
                place += length
            arrays.append(np.where(folded & 1, -(folded + 1) // 2, folded // 2))
        found[str(section["name"])] = arrays
    if place != len(data):
        raise ValueError(f"live payload: {len(data)} bytes, its header tells of {place}")
    return found
