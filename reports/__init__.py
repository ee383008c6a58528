"""What we tell people: the verdict as text, as a page with charts and pictures, and as files."""

from reports.charts import cycle_charts, part_charts
from reports.files import read_json, replacing, write_json, write_vtu
from reports.page import report_html, write_report
from reports.pictures import Pictures, render_stills
from reports.terminal import verdict_renderable, verdict_text
from reports.verdict import (
    Check,
    DesignResult,
    Gate,
    HandCheck,
    PartResult,
    Status,
    Surface,
)

__all__ = [
    "Check",
    "DesignResult",
    "Gate",
    "HandCheck",
    "PartResult",
    "Pictures",
    "Status",
    "Surface",
    "cycle_charts",
    "part_charts",
    "read_json",
    "render_stills",
    "replacing",
    "report_html",
    "verdict_renderable",
    "verdict_text",
    "write_json",
    "write_report",
    "write_vtu",
]
