"""All charts of a design."""

from collections.abc import Sequence
from dataclasses import dataclass

from checks.result.verdict import DesignResult
from reports.charts.chart import Charts, Known
from reports.charts.cycles import cycle_charts
from reports.charts.parts import part_charts


@dataclass(frozen=True)
class DesignCharts:
    """The charts of a design's parts, in its order, and of its cycles by name."""

    parts: Sequence[Charts]
    cycles: Sequence[tuple[str, Charts]]


def design_charts(result: DesignResult, known: Known | None = None) -> DesignCharts:
    """Draw all charts of a result; `known` as in `cycle_charts` and `part_charts`."""
    parts = [part_charts(part, result, known) for part in result.parts]
    return DesignCharts(parts, cycle_charts(result, known))
