"""ballesta from Python: `check`, `loads` and `batch`, with the types of what they return.

`import ballesta` offers all of it, and imports this module when a name is first used.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from html import escape
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import reports.loads_summary as loads_summary
from ballesta.batches.job import sentence
from ballesta.commands.batch_command import Wanted, outcomes_of, summary
from ballesta.commands.loads_command import loads_of_file
from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.design.data import Design
from checks.design.effort import effort_of
from checks.design.errors import DesignError, NumericsError
from checks.result import verdict
from checks.result.verdict import Check, Gate, PartResult, Status
from checks.result.words import number
from checks.store.store import Store
from reports.answer_facts import HEADINGS, answer_of
from reports.loads_summary import loads_csv
from reports.loads_text import loads_text

__all__ = [
    "BatchResult",
    "Check",
    "Design",
    "DesignError",
    "DesignResult",
    "Gate",
    "LoadsResult",
    "NumericsError",
    "PartResult",
    "Status",
    "batch",
    "check",
    "loads",
    "read_design",
]

_COLUMNS = ("design", "status", "decided by", "mass, kg")


class DesignResult(verdict.DesignResult):
    """Result of `check`; a notebook shows it as its verdict and a row for each part.

    status    PASS, UNDECIDED or FAIL
    deciding  the check nearest to its limit, bars included
    parts     a `PartResult` each: checks, validity checks (`gates`), facts
    checks    of all parts and of the linkage: value and error bars in `unit`, limit, safety
    """

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each check, by its identifier in result.json.

        Columns are the keys of a check there, but for its derivation; bars without end are NaN.
        Raises ImportError where pandas is not installed.
        """
        data = self.to_dict()
        owners = [*(part["checks"] for part in data["parts"]), data["linkage"]]
        frame = _pandas().DataFrame([check for checks in owners for check in checks])
        return frame.drop(columns="derivation", errors="ignore").set_index("id")

    def _repr_html_(self) -> str:
        return answer_html(self)


class LoadsResult(loads_summary.LoadsResult):
    """Result of `loads`: reactions, efforts, drives, contacts and validity checks (`gates`).

    cycles  solved ones: `cycle.loads.reactions[JOINT].force` is (n, 2) N over the n positions,
            `.moment` (n,) N mm, `cycle.loads.efforts[FORCE]` (n,) N or N mm, `.times` (n,) s
    runs    measured ones
    """

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each position: the columns of `ballesta loads --csv`.

        Raises ImportError where pandas is not installed.
        """
        return _pandas().read_csv(StringIO(loads_csv(self.cycles, self.runs)))

    def _repr_html_(self) -> str:
        return loads_html(self)


@dataclass(frozen=True, eq=False)
class BatchResult:
    """Result of `batch`: an outcome for each design and variation, in their order.

    out       folder of the batch: index.html, results.csv, results.parquet, a folder per outcome
    outcomes  plain data: name, file, overrides, status, error, checks (as `Check.to_dict`), inputs,
              mass (kg), masses by part
    """

    out: Path
    outcomes: Sequence[Mapping[str, Any]]

    @property
    def exit_code(self) -> int:
        """The highest exit code of the designs: 0 all pass, 1, 2 or 3 as for `ballesta batch`."""
        return max((int(outcome["exit_code"]) for outcome in self.outcomes), default=0)

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each check of each design: `out`/results.parquet.

        Raises ImportError where pandas is not installed.
        """
        return _pandas().read_parquet(self.out / "results.parquet")

    def _repr_html_(self) -> str:
        rows = (
            (
                outcome["name"],
                outcome["status"],
                sentence(outcome),
                "" if outcome["mass"] is None else number(outcome["mass"]),
            )
            for outcome in self.outcomes
        )
        head, *more = map(escape, summary(self.outcomes, self.out).splitlines())
        return f"<p><b>{head}</b><br>{'<br>'.join(more)}</p>\n{html_table(_COLUMNS, rows)}"


def _pandas() -> Any:
    try:
        return import_module("pandas")
    except ImportError as error:
        raise ImportError("a frame needs pandas: pip install pandas") from error


def check(
    design: Design | str | Path,
    overrides: Sequence[str] = (),
    *,
    fidelity: str = "auto",
    within: str | None = None,
    store: str | Path | None = None,
) -> DesignResult:
    """Check all parts of a design over all its cycles.

    design     a design file, or what `read_design` has made of one
    overrides  "key=value" each, as `ballesta check --set` takes them; of a design file only
    fidelity   "formula" or "solid"; "auto" takes the cheapest that settles each part
    within     time limit such as "60 s"; the result then says what is left open
    store      folder that keeps loads, meshes and solutions for later checks

    Units of the result are N, mm, s, tonne and MPa, but for facts that name another.

    Raises DesignError for a file that cannot be checked as written (which file, key and value, and
    the nearest right answer), NumericsError where a solver gave up. A part that fails is a result.

    >>> import ballesta
    >>> result = ballesta.check("designs/gallery/yoke_actuator.toml", fidelity="formula")
    >>> str(result.status), result.exit_code
    ('pass', 0)
    >>> (bearing,) = (check for check in result.checks if check.kind == "bearing")
    >>> bearing.upper * bearing.required <= bearing.limit  # MPa: it passes
    True
    """
    effort = effort_of(fidelity, within)
    if not isinstance(design, Design):
        design = read_design(design, overrides)
    elif overrides:
        raise DesignError(
            design.file, "overrides", "are of a design file: give them to read_design"
        )
    kept = None if store is None else Store(Path(store))
    found = check_design(design, effort=effort, store=kept)
    return DesignResult(**{field.name: getattr(found, field.name) for field in fields(found)})


def loads(
    design: str | Path, overrides: Sequence[str] = (), *, cycles: Sequence[str] = ()
) -> LoadsResult:
    """Solve the cycles of a design file, and balance its measured runs, without checking parts.

    overrides  "key=value" each
    cycles     names of the cycles and runs that are wanted; none for all

    Forces are N, moments N mm, times s, positions mm or rad.

    Raises DesignError for a file that cannot be solved as written and for measured loads that do
    not balance, NumericsError where the mass of a part cannot be computed.

    >>> import ballesta
    >>> result = ballesta.loads("designs/gallery/yoke_actuator.toml")
    >>> cycle = result.cycles[0].loads
    >>> list(cycle.reactions)
    ['guide:piston', 'slot', 'O']
    >>> cycle.reactions["O"].force.shape == (len(cycle.times), 2)
    True
    """
    found = loads_of_file(Path(design), overrides, cycles)
    return LoadsResult(**{field.name: getattr(found, field.name) for field in fields(found)})


def batch(
    designs: str | Path | Sequence[str | Path],
    out: str | Path,
    overrides: Sequence[str] = (),
    *,
    sweeps: Sequence[str] = (),
    sample: int | None = None,
    seed: int = 0,
    fidelity: str = "auto",
    within: str | None = None,
    accuracy: str | None = None,
    jobs: int | None = None,
    time_limit: str = "600 s",
    memory: str | None = None,
    reports: bool | None = None,
    store: str | Path | None = None,
) -> BatchResult:
    """Check designs and their variations side by side; the same call resumes a stopped batch.

    designs     design files, or folders of them
    out         folder of the batch
    overrides   "key=value" each, for all
    sweeps      such as "parts.rod.thickness = 4..8 mm : 9"; several make every combination
    sample      number of points of a Sobol sequence over the sweeps, by `seed`; None for their grid
    fidelity, within, accuracy  as for `check`, of each design; accuracy such as "5 %"; fidelity
                may be "swept", solids on meshes carried over (docs/batch.md)
    jobs        designs at a time; None for one per core
    time_limit  such as "600 s", after which a design is stopped; "none" for no limit
    memory      such as "4 GB", above which a design is stopped; None for its share of what is free
    reports     True for a report.html each; None for up to 50 designs
    store       folder that keeps stages for later; None for `out`/store

    Progress is printed. A design that fails, crashes or takes too long is an outcome. Workers are
    interpreters of their own, which do not import the calling script: neither Windows nor a
    notebook needs an `if __name__ == "__main__"` around the call.

    Raises DesignError for a wrong option, a sweep that no design can take, and a folder that holds
    another batch or takes no files; NumericsError where no worker starts.

    >>> import ballesta, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     result = ballesta.batch(
    ...         "designs/gallery/yoke_actuator.toml", folder + "/heights", fidelity="formula",
    ...         sweeps=["parts.yoke.thickness = 36, 44 mm"],
    ...         reports=False,
    ...     )  # doctest: +ELLIPSIS
    [1/2] yoke_actuator-...
    [2/2] yoke_actuator-...
    >>> [outcome["status"] for outcome in result.outcomes], result.exit_code
    (['pass', 'pass'], 0)
    """
    given = [designs] if isinstance(designs, str | Path) else designs
    wanted = Wanted(
        out=Path(out),
        jobs=jobs,
        sweeps=tuple(sweeps),
        sample=sample,
        seed=seed,
        fidelity=fidelity,
        within=within,
        accuracy=accuracy,
        time_limit=time_limit,
        memory=memory,
        overrides=tuple(overrides),
        reports=reports,
        store=None if store is None else Path(store),
    )
    return BatchResult(Path(out), outcomes_of([Path(design) for design in given], wanted))


_WIDTH = 120
_LEFT = "text-align: left"


def answer_html(result: verdict.DesignResult) -> str:
    """Verdict, safety with its range, a row for each part's governing check, and the facts."""
    answer = answer_of(result)
    safety = ""
    if answer.check is not None:
        bars = f"; {answer.within} within its error bars" if answer.within else ""
        safety = f" safety {answer.safety}, {answer.required} required{bars}"
    facts = [*answer.headline, *answer.beside]
    return "\n".join(
        [
            f"<p><b>{escape(answer.name)}: {escape(str(answer.status).upper())}</b>"
            f"{escape(safety)}</p>",
            html_table(HEADINGS, (row.cells for row in answer.rows)),
            f"<p>{escape(answer.others)}</p>",
            html_table((), ((fact.label, fact.line) for fact in facts)),
        ]
    )


def loads_html(result: loads_summary.LoadsResult) -> str:
    """The loads as the terminal has them."""
    return f"<pre>{escape(loads_text(result, _WIDTH))}</pre>"


def html_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of plain texts; headings may be missing."""

    def cells(tag: str, texts: Sequence[str]) -> str:
        found = (f'<{tag} style="{_LEFT}">{escape(text)}</{tag}>' for text in texts)
        return f"<tr>{''.join(found)}</tr>"

    head = [f"<thead>{cells('th', headings)}</thead>"] if headings else []
    body = [cells("td", row) for row in rows]
    return "\n".join(["<table>", *head, "<tbody>", *body, "</tbody>", "</table>"])
