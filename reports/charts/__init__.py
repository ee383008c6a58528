"""Charts of a result as SVG text, each with the table of its numbers."""

from reports.charts.chart import Chart, Charts, Missing, Series
from reports.charts.cycles import cycle_charts
from reports.charts.overlay import curves_chart
from reports.charts.parts import DesignCharts, design_charts, part_charts

__all__ = [
    "Chart",
    "Charts",
    "DesignCharts",
    "Missing",
    "Series",
    "curves_chart",
    "cycle_charts",
    "design_charts",
    "part_charts",
]
