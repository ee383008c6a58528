"""Reports of a result: the verdict as text, as a page with charts and pictures, and as files."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from checks.result.verdict import (
        Check,
        DesignResult,
        Gate,
        HandCheck,
        PartResult,
        Status,
        Surface,
    )
    from reports.charts import cycle_charts, part_charts
    from reports.files import read_json, replacing, write_json, write_vtu
    from reports.page import report_html, write_report
    from reports.pictures import Pictures, render_stills
    from reports.terminal import verdict_text

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
    "verdict_text",
    "write_json",
    "write_report",
    "write_vtu",
]

_MODULES = (  # the quickest first
    "checks.result.verdict",
    "reports.files",
    "reports.terminal",
    "reports.charts",
    "reports.pictures",
    "reports.page",
)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: who tells of an error needs no page."""
    if name in __all__:
        for module in _MODULES:
            found = import_module(module)
            if hasattr(found, name):
                return getattr(found, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
