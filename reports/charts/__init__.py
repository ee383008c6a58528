"""Charts of a result as SVG text, each with the table of its numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

from checks.result.verdict import DesignResult, PartResult
from reports.charts.buckling import buckling_chart
from reports.charts.chart import Charts, gathered
from reports.charts.cycles import cycle_charts
from reports.charts.haigh import haigh_chart
from reports.charts.ladder import convergence_chart, ladder_chart
from reports.charts.sn import sn_chart

__all__ = [
    "Charts",
    "DesignCharts",
    "cycle_charts",
    "design_charts",
    "part_charts",
]


def part_charts(part: PartResult, result: DesignResult) -> Charts:
    """Haigh's diagram, S-N line, column curves, ladder and convergence of a part of a result."""
    return gathered(
        [
            haigh_chart(part, result),
            sn_chart(part, result),
            buckling_chart(part, result),
            ladder_chart(part),
            convergence_chart(part),
        ]
    )


@dataclass(frozen=True)
class DesignCharts:
    """The charts of a design's parts, in its order, and of its cycles by name."""

    parts: Sequence[Charts]
    cycles: Sequence[tuple[str, Charts]]


def design_charts(result: DesignResult) -> DesignCharts:
    """Draw all charts of a result."""
    return DesignCharts([part_charts(part, result) for part in result.parts], cycle_charts(result))
