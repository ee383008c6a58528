"""Calibration of the error bars: every catalogued reading against its reference.

``python -m bench.error_bars`` prints the table; with ``--write`` it becomes docs/validation.md,
together with the multiaxial criteria of bench/multiaxial.py. ``python -m bench.error_bars 0.5 0.8``
prints the sums of another pair of meshes, without the cases whose body so coarse a mesh cuts off.
The readings are those of tests/validation: stresses and peaks with exact or converged references,
on meshes as a user would make them: the last mesh of the pair 0.7, 1 and of the pair 1, 1.4.
"""

import statistics
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench import multiaxial
from fem.convergence import ErrorBar, discretisation_error
from geometry.mesh import MeshError
from tests.validation.plane.catalogue import CASES as PLANE
from tests.validation.solids.catalogue import CASES as SOLIDS

PAIRS = ((0.7, 1.0), (1.0, 1.4))
PAGE = Path(__file__).parents[1] / "docs" / "validation.md"
PARTS = Path(__file__).parent / "validation_notes.md"


@dataclass(frozen=True)
class BarReading:
    """One quantity on the finer of two meshes, all relative to its reference.

    error        distance from the reference
    uncertainty  of the reference
    bar          numerical error bar
    """

    case: str
    quantity: str
    reference: float
    value: float
    error: float
    uncertainty: float
    bar: float

    @property
    def inside(self) -> bool:
        """True if the reference lies inside the bar, as well as it is known."""
        return self.error <= self.bar + self.uncertainty


@dataclass(frozen=True)
class Calibration:
    """How many bars hold their reference, and how wide they are."""

    inside: int
    count: int
    median_bar: float
    median_error: float
    worst: float  # largest error over bar
    low: int  # how many read nearer to zero than their reference

    @property
    def holds(self) -> bool:
        """Nine of ten inside, the median bar at most three median errors, none twice too small."""
        enough = self.inside >= 0.9 * self.count
        return enough and self.median_bar <= 3 * self.median_error and self.worst <= 2


def readings(
    pair: tuple[float, float],
    done: dict[tuple[int, float], tuple],
    cases: Sequence[Any] = (*PLANE, *SOLIDS),
) -> list[BarReading]:
    """Solve every case on two meshes; `done` keeps what was solved, for another pair."""
    found = []
    for number, case in enumerate(cases):
        for fineness in pair:
            if (number, fineness) not in done:
                reading = case.solve(fineness)
                done[number, fineness] = (reading.value, reading.scatter or 0.0)
        values = [done[number, fineness][0] for fineness in pair]
        scatter = done[number, pair[1]][1]
        step = discretisation_error(values, [1 / fineness for fineness in pair], case.order)
        bar = ErrorBar(step, scatter, 0.0, abs(values[-1]), order=case.order)
        size = abs(case.reference)
        found.append(
            BarReading(
                case.id,
                case.quantity,
                case.reference,
                values[-1],
                abs(values[-1] - case.reference) / size,
                case.uncertainty / size,
                bar.value / size,
            )
        )
    return found


def calibration(found: Sequence[BarReading]) -> Calibration:
    """Sum up the readings of one pair of meshes."""
    return Calibration(
        sum(reading.inside for reading in found),
        len(found),
        statistics.median(reading.bar for reading in found),
        statistics.median(reading.error for reading in found),
        max(max(reading.error - reading.uncertainty, 0.0) / reading.bar for reading in found),
        sum(abs(reading.value) < abs(reading.reference) for reading in found),
    )


def table(pairs: Sequence[Sequence[BarReading]]) -> str:
    """Return the readings as a Markdown table."""
    lines = [
        "| Case | Quantity | Reference | Value | Error | Bar | Value, finer | Error | Bar |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for coarse, fine in zip(*pairs, strict=True):
        cells = [coarse.case, coarse.quantity, f"{coarse.reference:.6g}"]
        for reading in (coarse, fine):
            mark = "" if reading.inside else " **outside**"
            cells += [
                f"{reading.value:.5g}",
                f"{100 * reading.error:.2f} %{mark}",
                f"{100 * reading.bar:.2f} %",
            ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def summary(
    pairs: Sequence[Sequence[BarReading]], fineness: Sequence[tuple[float, float]] = PAIRS
) -> str:
    """Return k of n and the medians, one line for each pair of meshes."""
    lines = []
    for pair, found in zip(fineness, pairs, strict=True):
        sums = calibration(found)
        lines.append(
            f"- meshes of fineness {pair[0]:g} and {pair[1]:g}: {sums.inside} of {sums.count} "
            f"references inside the bar ({100 * sums.inside / sums.count:.0f} %); median bar "
            f"{100 * sums.median_bar:.2f} %, median error {100 * sums.median_error:.2f} % (ratio "
            f"{sums.median_bar / sums.median_error:.1f}); largest error {sums.worst:.2f} bars; "
            f"{sums.low} read low"
        )
    return "\n".join(lines)


def another(pair: tuple[float, float]) -> str:
    """Sum up another pair of meshes, and tell how many cases its first one refused."""
    every, meshed = (*PLANE, *SOLIDS), []
    for case in every:
        with suppress(MeshError):
            case.solve(pair[0])
            meshed.append(case)
    told = summary([readings(pair, {}, meshed)], [pair])
    return f"{told}; {len(every) - len(meshed)} of {len(every)} refused by the coarser mesh"


def main() -> None:
    """Measure, print, and write the page if asked to."""
    stated = [float(word) for word in sys.argv[1:] if not word.startswith("-")]
    if stated:
        print(another((stated[0], stated[1])))
        return
    done: dict[tuple[int, float], tuple] = {}
    pairs = [readings(pair, done) for pair in PAIRS]
    print(summary(pairs))
    if "--write" in sys.argv:
        notes = PARTS.read_text(encoding="utf-8")
        parts = {
            "summary": summary(pairs),
            "table": table(pairs),
            "multiaxial": multiaxial.table(),
            "multiaxial_ranges": multiaxial.ranges(),
        }
        for name, part in parts.items():
            notes = notes.replace("{{" + name + "}}", part)
        PAGE.write_text(notes, encoding="utf-8")
        multiaxial.draw(multiaxial.PLOT)
    else:
        print(table(pairs))


if __name__ == "__main__":
    main()
