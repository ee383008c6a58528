"""All charts of a design."""

from collections.abc import Sequence
from dataclasses import dataclass

from checks.result.verdict import DesignResult
from reports.charts.chart import Charts
from reports.charts.cycles import cycle_charts
from reports.charts.parts import part_charts


@dataclass(frozen=True)
class DesignCharts:
    """The charts of a design's parts, in its order, and of its cycles by name."""

    parts: Sequence[Charts]
    cycles: Sequence[tuple[str, Charts]]


def design_charts(result: DesignResult) -> DesignCharts:
    """Draw all charts of a result."""
    return DesignCharts([part_charts(part, result) for part in result.parts], cycle_charts(result))
