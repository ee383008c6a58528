"""The files that tell what came of a batch: its index, its tables, its timings."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ballesta.batches.outcome import TIMINGS
from ballesta.batches.plan import Plan
from ballesta.batches.table import csv_text, parquet_bytes, result_rows, varied_inputs
from checks.result.words import clean
from reports.files import write_whole


def prepare() -> None:
    """Import what writing takes: a second that passes while workers start."""
    import reports.index_page  # noqa: F401

    parquet_bytes(["value"], [{"value": 1.0}])  # pyarrow imports pandas where there is one


def write_results(
    plan: Plan,
    out: Path,
    outcomes: Sequence[Mapping[str, Any]],
    timings: Sequence[Mapping[str, float]],
) -> None:
    """Write all of them, each whole or not at all; only timings.csv differs from run to run.

    Raises OSError.
    """
    from reports.index_page import IndexDesign, index_html

    names, rows = result_rows(outcomes, plan.notes)
    write_whole(out / "results.csv", csv_text(names, rows).encode())
    write_whole(out / "results.parquet", parquet_bytes(names, rows))
    write_whole(out / "timings.csv", _timings_text(plan, timings).encode())
    varied, left_out = varied_inputs(outcomes)
    designs = [
        IndexDesign(
            name=job.name,
            title=outcome["design"],
            file=outcome["file"],
            status=outcome["status"],
            error=outcome["error"],
            stage=outcome["stage"],
            note=plan.notes.get(job.name, ""),
            broken_gates=outcome["broken_gates"],
            mass=outcome["mass"],
            checks=outcome["checks"],
            link=_link(job.folder) if outcome["checks"] else "",
            thumbnail=_thumbnail(job.folder) if outcome["checks"] else b"",
        )
        for job, outcome in zip(plan.jobs, outcomes, strict=True)
    ]
    page = index_html(out.resolve().name, designs, varied, left_out)
    write_whole(out / "index.html", page.encode("utf-8", "replace"))


def _timings_text(plan: Plan, timings: Sequence[Mapping[str, float]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["design", *TIMINGS])
    for job, row in zip(plan.jobs, timings, strict=True):
        writer.writerow([clean(job.name), *(row.get(name, "") for name in TIMINGS)])
    return text.getvalue()


def _link(folder: str) -> str:
    """Where a design's own page is, relative to the index; "" if there is none."""
    for name in ("report.html", "result.json"):
        if (Path(folder) / name).is_file():
            return f"{Path(folder).name}/{name}"
    return ""


def _thumbnail(folder: str) -> bytes:
    """The small picture of a design; empty where no report was asked for."""
    try:
        return (Path(folder) / "thumbnail.png").read_bytes()
    except OSError:
        return b""
