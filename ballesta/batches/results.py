"""The files that tell what came of a batch: its index, its tables, its timings."""

import csv
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any

from ballesta.batches.job import TIMINGS
from ballesta.batches.plan import Plan
from checks.result.words import clean
from reports.files import write_whole

Row = dict[str, Any]
MOST_VARIED = 40
_TEXTS = {"design", "file", "name in file", "design status", "error", "stage", "note",
          "design note", "part", "check", "kind", "quantity", "unit", "status", "cycle",
          "position", "place", "method"}  # fmt: skip
_NUMBERS = ("value", "numerical", "model", "model_below", "limit", "required", "safety",
            "utilisation", "mass [kg]", "part mass [kg]")  # fmt: skip
_UNKNOWN_IS_INFINITE = ("numerical", "model", "model_below", "safety")
_NUMBER = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)", re.DOTALL)


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


def varied_inputs(outcomes: Sequence[Mapping[str, Any]]) -> tuple[dict[str, list[Any]], int]:
    """Inputs in which the designs differ, each with a value per design, and how many are left out.

    A column of numbers of one unit carries it in its name, "parts.bar.wall [mm]"; others are text.
    What sweeps and --set vary comes first; of the rest what at least half of the designs state, up
    to `MOST_VARIED` in all. A design without the input, or that was not read, has None.
    """
    stated = [_stated(outcome) for outcome in outcomes]
    swept = dict.fromkeys(_keys_of_overrides(outcomes))
    keys = dict.fromkeys(key for inputs in stated for key in inputs)
    read = [inputs for inputs in stated if inputs]
    columns: dict[str, list[Any]] = {}
    left = 0
    for key in (*swept, *(key for key in keys if key not in swept)):
        values = [inputs.get(key) for inputs in stated]
        present = [value for value in values if value is not None]
        differ = len(set(present)) > 1 or (0 < len(present) < len(read))
        if not differ or (key not in swept and key in ("name",)):
            continue
        if key not in swept and (2 * len(present) < len(read) or len(columns) >= MOST_VARIED):
            left += 1
            continue
        name, column = _column(key, values)
        columns[name] = column
    return columns, left


def _stated(outcome: Mapping[str, Any]) -> dict[str, str]:
    """Inputs of a design; without a result only those that the command line sets."""
    if outcome["inputs"]:
        return dict(outcome["inputs"])
    pairs = (text.partition("=") for text in outcome["overrides"])
    return {key.strip(): value.strip().strip("\"'") for key, _, value in pairs}


def _keys_of_overrides(outcomes: Iterable[Mapping[str, Any]]) -> Iterable[str]:
    for outcome in outcomes:
        yield from (text.partition("=")[0].strip() for text in outcome["overrides"])


def _column(key: str, values: Sequence[str | None]) -> tuple[str, list[Any]]:
    found = [None if value is None else _NUMBER.fullmatch(value.strip()) for value in values]
    units = {match[2].strip() for match in found if match}
    missing = any(
        value is not None and match is None for value, match in zip(values, found, strict=True)
    )
    if missing or len(units) != 1:
        return key, [None if value is None else clean(value) for value in values]
    unit = units.pop()
    if any(letter in unit for letter in ",;[]\"'"):
        return key, [None if value is None else clean(value) for value in values]
    name = f"{key} [{unit}]" if unit else key
    return name, [None if match is None else float(match[1]) for match in found]


def result_rows(
    outcomes: Sequence[Mapping[str, Any]], notes: Mapping[str, str]
) -> tuple[list[str], list[Row]]:
    """Names of the columns, and a row per check; a design without checks has a row of its own.

    An error bar that is not known is infinite, and so is the safety of what carries no load.
    """
    varied, _ = varied_inputs(outcomes)
    names = ["design", "file", "name in file", "design status", "governing", "part", "check",
             "kind", "quantity", "value", "unit", "numerical", "model", "model_below", "limit",
             "required", "safety", "utilisation", "status", "cycle", "position", "place", "method",
             "note", "part mass [kg]", "mass [kg]", "error", "stage", "design note"]  # fmt: skip
    rows = []
    for index, outcome in enumerate(outcomes):
        common = {
            "design": outcome["name"],
            "file": outcome["file"],
            "name in file": outcome["design"],
            "design status": outcome["status"],
            "mass [kg]": outcome["mass"],
            "error": outcome["error"],
            "stage": outcome["stage"],
            "design note": _design_note(outcome, notes),
        }
        inputs = {f"input {name}": column[index] for name, column in varied.items()}
        for check in outcome["checks"] or [{}]:
            rows.append({**dict.fromkeys(names), **common, **_of_check(check, outcome), **inputs})
    return [*names, *(f"input {name}" for name in varied)], rows


def _of_check(check: Mapping[str, Any], outcome: Mapping[str, Any]) -> Row:
    if not check:
        return {}
    row = {key: value for key, value in check.items() if key != "note"}
    row |= {key: inf for key in _UNKNOWN_IS_INFINITE if row[key] is None}
    return row | {"note": check["note"], "part mass [kg]": outcome["masses"].get(check["part"])}


def _design_note(outcome: Mapping[str, Any], notes: Mapping[str, str]) -> str:
    """A note on the design as a whole: broken gates leave it UNDECIDED at best."""
    broken = outcome["broken_gates"]
    gates = f"validity checks that do not hold: {', '.join(broken)}" if broken else ""
    return "; ".join(filter(None, [gates, notes.get(outcome["name"], "")]))


def csv_text(names: Sequence[str], rows: Iterable[Row]) -> str:
    """Rows as comma-separated text: numbers to their last digit, nothing where there is nothing."""
    out = io.StringIO()
    writer = csv.DictWriter(out, names, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: _csv_value(row[name]) for name in names})
    return out.getvalue()


def _csv_value(value: Any) -> Any:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        text = clean(value)
        # a spreadsheet must not take a name for a formula
        return f"'{text}" if text[:1] in ("=", "+", "-", "@") else text
    return "" if value is None else repr(value) if isinstance(value, float) else value


def parquet_bytes(names: Sequence[str], rows: Sequence[Row]) -> bytes:
    """Rows as a parquet file: doubles and strings, nulls where there is nothing."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = []
    for name in names:
        values = [row[name] for row in rows]
        if name == "governing":
            columns.append(pa.array(values, pa.bool_()))
        elif name in _NUMBERS or (name not in _TEXTS and _all_numbers(values)):
            columns.append(pa.array(values, pa.float64()))
        else:
            texts = [None if value is None else clean(value) for value in values]
            columns.append(pa.array(texts, pa.string()))
    out = pa.BufferOutputStream()
    pq.write_table(pa.table(columns, names=[clean(name) for name in names]), out)
    data: bytes = out.getvalue().to_pybytes()
    return data


def _all_numbers(values: Sequence[Any]) -> bool:
    return all(value is None or isinstance(value, float) for value in values)
