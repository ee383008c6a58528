"""The report: one HTML page that stands alone, with a script of its own, nothing from outside."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import isfinite, log
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from checks.design.errors import LINKAGE
from checks.result.derivation import LoadCase
from checks.result.formulas import number_text, shown_symbol
from checks.result.verdict import Check, DesignResult
from checks.result.words import assumptions, brief, clean
from reports.answer_facts import Answer, answer_of
from reports.charts import design_charts
from reports.derivation_text import bar_texts, legend, paragraphs, status_texts
from reports.files import write_text
from reports.gauge import shares
from reports.loads_words import broken_of
from reports.page_parts import (
    Row,
    by_label,
    check_rows,
    cycle_views,
    part_views,
    tiles,
    worst_first,
)
from reports.page_words import (
    capitalise,
    has_place,
    mirrored,
    page_bars,
    reach_words,
    rungs_beside,
    swings,
)
from reports.pictures import Pictures
from reports.templating import environment
from reports.what_if import what_if

_WORDS = {
    "bar_words": page_bars,
    "reach": reach_words,
    "mirrored": mirrored,
    "rungs_beside": rungs_beside,
    "capitalise": capitalise,
}

_INCLUDED = (
    "tables",
    "charts",
    "answer_below",
    "answer_card",
    "checks",
    "derivation",
    "ladder_tables",
    "report_part",
    "report_first",
    "report_inputs",
)


def write_report(
    result: DesignResult, pictures: Pictures | Callable[[], Pictures], path: str | Path
) -> None:
    """Write the page as a file, which is there whole or not at all.

    pictures  or what waits for them, which is asked when all else is ready
    """
    write_text(path, report_html(result, pictures))


def report_html(
    result: DesignResult, pictures: Pictures | Callable[[], Pictures] | None = None
) -> str:
    """Page as text. The same result and pictures give the same page.

    pictures  or what waits for them, which is asked when all else is ready
    """
    from reports.live.section import live_section, style_text
    from reports.mechanism_panel import mechanism_panel
    from reports.templating import report_hash, script_text

    rows = check_rows(result)
    card, below = _answer(result, rows)
    live = live_section(result, mechanism=mechanism_panel(result), answer=card, below=below)
    template = _template("report")
    charts = design_charts(result)
    if callable(pictures):
        pictures = pictures()
    pictures = pictures or Pictures(reason="no pictures were asked for")
    parts = part_views(result, rows, pictures, charts)
    linkage = worst_first([row for row in rows if any(row.check is c for c in result.linkage)])
    text: str = template.render(
        result=result,
        status=str(result.status),
        rows=worst_first(rows),
        broken=broken_of(result),
        assumed=sorted_assumptions(result),
        inputs=sorted_inputs(result),
        parts=parts,
        linkage=linkage,
        cycles=cycle_views(result, charts),
        live=live,
        live_style=style_text(),
        what_if=what_if(result),
        shares=shares(result.deciding) if result.checks else [],
        decides=f"{result.deciding.part} {result.deciding.kind}" if result.checks else "",
        pictures_reason=pictures.reason,
        script=Markup(script_text()),
        script_hash=Markup(report_hash()),
    )
    return text


def _answer(result: DesignResult, rows: Sequence[Row]) -> tuple[Markup, Markup]:
    """The answer beside the picture, and what stands under it."""
    answer = _first_screen(answer_of(result))
    deciding = next((row for row in rows if row.decides), None)
    scale = safety_scale(answer.check) if answer.check else None
    card = _template("answer_card").render(
        answer=answer,
        scale=scale,
        shown=deciding.shown if deciding and deciding.place else "",
        why=f"why-{deciding.number}" if deciding and deciding.check.derivation else "",
    )
    below = _template("answer_below").render(
        answer=answer,
        result=result,
        tiles=tiles(answer, result, rows),
        beside=by_label([*answer.beside, *answer.warnings]),
    )
    return Markup(card), Markup(below)


def _first_screen(answer: Answer) -> Answer:
    """The answer as the page shows it without scrolling: the mass of all parts above the changes.

    Changes are the rows of one table, at the place of the first.
    """
    told = sum(fact.label in ("decided by", "where", "when") for fact in answer.headline)
    mass = [fact for fact in answer.beside if fact.label == "mass"]
    total = [replace(fact, text=fact.text.partition(" (")[0]) for fact in mass]
    return replace(
        answer,
        headline=[*answer.headline[:told], *total, *answer.headline[told:]],
        beside=[fact for fact in answer.beside if fact.label != "mass"],
    )


@cache
def _template(name: str) -> Any:
    return _environment().get_template(f"{name}.html.j2")


@cache
def _environment() -> Any:

    found = environment()
    found.filters |= FILTERS | _WORDS
    found.tests |= {"with_place": has_place, "swinging": swings}
    for name in _INCLUDED:  # else they are compiled when the pictures have been waited for
        found.get_template(f"{name}.html.j2")
    return found


# Inputs of a result: stated by the design, set on the command line, by default, or assumed.

Pairs = Sequence[tuple[str, str]]
_VIBRATION = "for vibration only", "rigid in vibration"  # what bears on no check of a part


@dataclass(frozen=True)
class Inputs:
    """Inputs by where they come from, each (key, value).

    design    stated by the design file and the files that it takes from
    command   set on the command line, as the design file would state them
    unread    what the command line set as it was written, where no input has its key
    defaults  not stated anywhere
    """

    design: Pairs
    command: Pairs
    unread: Sequence[str]
    defaults: Pairs


@dataclass(frozen=True)
class Assumed:
    """Assumptions (keys, what): those that the design marks, and the tool's own.

    elsewhere  of either kind, those of other parts than the one that decides, and of vibration
    """

    design: Pairs
    tool: Pairs
    elsewhere: Pairs

    @property
    def count(self) -> int:
        """Number of all of them."""
        return len(self.design) + len(self.tool) + len(self.elsewhere)


def sorted_inputs(result: DesignResult) -> Inputs:
    """Keep apart what the design file states and what the command line set."""
    ways = {text: text.partition("=")[0].strip() for text in result.overrides}
    design: list[tuple[str, str]] = []
    command: list[tuple[str, str]] = []
    used: set[str] = set()
    for key, value in result.inputs:
        found = [text for text, way in ways.items() if _is_within(key, way)]
        used |= set(found)
        (command if found else design).append((key, value))
    return Inputs(
        design, command, [text for text in ways if text not in used], list(result.defaults)
    )


def _is_within(key: str, way: str) -> bool:
    """Return True if a dotted key is `way` itself or lies below it."""
    return key == way or key.startswith((f"{way}.", f"{way}["))


def sorted_assumptions(result: DesignResult) -> Assumed:
    """Keep apart what the design marks as assumed and what was assumed where it is silent."""
    marked = set(result.assumed_by_design)
    mine = {what for key, what in result.assumed if key in marked}
    pairs = assumptions(result)
    near = [pair for pair in pairs if _is_near(result, *pair)]
    return Assumed(
        [pair for pair in near if pair[1] in mine],
        [pair for pair in near if pair[1] not in mine],
        [pair for pair in pairs if pair not in near],
    )


def _is_near(result: DesignResult, keys: str, what: str) -> bool:
    """True if an assumption is of the deciding part, or of no part alone."""
    if what.endswith(_VIBRATION[0]) or what.startswith(_VIBRATION[1]):
        return False
    deciding = result.deciding.part if result.checks else LINKAGE
    stated, owners = dict(result.inputs), [deciding]
    while (like := stated.get(f"parts.{owners[-1]}.like")) and like not in owners:
        owners.append(like)
    names = [part.name for part in result.parts]
    if deciding not in names:
        return True

    def of(key: str) -> str:
        first, _, rest = key.partition(".")
        return rest.partition(".")[0] if first == "parts" else first

    of_parts = [of(key) for key in keys.split(", ")]
    return any(name not in names or name in owners for name in of_parts)


# The safety that decides on a scale: its range by the error bars, and what it must show.

_WIDTH, _HEIGHT = 100.0, 20.0
_LOWEST, _HIGHEST = 0.8, 1.25  # of the least and the largest that is shown: the ends of the scale
_FARTHEST = 4.0  # times the required safety: what lies beyond ends in an arrow


@dataclass(frozen=True)
class SafetyScale:
    """The scale as a picture without text, and where its labels stand.

    required  share of the width at which the required safety stands, percent
    """

    picture: Markup
    required: float


def safety_scale(check: Check) -> SafetyScale | None:
    """Draw a check's safety on a logarithmic scale; None for a part without load.

    Red is below the required safety, green above; the dot is the safety at the value, the line its
    range by the error bars, dotted where that has no end. Stretched to the width that it gets.
    """
    if not check.value:
        return None
    least = check.limit / check.upper if isfinite(check.upper) else 0.0
    most = check.limit / check.lower if check.lower > 0 else float("inf")
    need, has = check.required, check.safety
    top = _FARTHEST * need
    low = _LOWEST * min(need, has, least or need)
    high = _HIGHEST * max(need, min(has, top), min(most, top))

    def at(safety: float) -> float:
        return min(max(log(max(safety, low) / low) / log(high / low), 0.0), 1.0) * _WIDTH

    limit, middle = at(need), _HEIGHT / 2
    ends = at(least or low), at(min(most, high))
    drawn = [
        f'<rect class="short" x="0" y="5" width="{limit:.2f}" height="10"/>',
        f'<rect class="enough" x="{limit:.2f}" y="5" width="{_WIDTH - limit:.2f}" height="10"/>',
        f'<path class="range{"" if least else " endless"}" d="M{ends[0]:.2f} {middle:g}'
        f'H{ends[1]:.2f}"/>',
        "".join(f'<path class="end" d="M{x:.2f} 6V14"/>' for x in ends if 0 < x < _WIDTH),
        f'<path class="need" d="M{limit:.2f} 0V{_HEIGHT:g}"/>',
        f'<path class="has" d="M{at(has):.2f} {middle:g}h0"/>',
    ]
    if max(has, most if isfinite(most) else 0.0) > high:
        drawn.append(f'<path class="end" d="M{_WIDTH - 1.5:g} 6l1.4 4l-1.4 4"/>')
    picture = Markup(
        f'<svg class="safety-scale" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" '
        f'preserveAspectRatio="none" aria-hidden="true">{"".join(drawn)}</svg>'
    )
    return SafetyScale(picture, round(limit, 2))


# Derivations as the page shows them, and the filters of derivation.html.j2.

_SUBSCRIPT = re.compile(r"(?<![A-Za-z])([A-Za-zα-ωΑ-Ω]{1,2})_([A-Za-z0-9α-ω]+)")


def view_of(check: Check) -> dict[str, Any] | None:
    """A check's derivation as text for the template; None for a check that has none.

    cases  (symbol, cycle, position, index, rows of what acts) of each position
    """
    derivation = check.derivation
    if derivation is None:
        return None
    *ends, rule = status_texts(check)
    unit = f" {check.unit}".rstrip()
    return {
        "headline": f"{brief(check.quantity, 120)} = {number_text(check.value)}{unit} of "
        f"{number_text(check.limit)}{unit}",
        "cases": [
            (shown_symbol(case.symbol), case.cycle, case.position, case.index, _acting(case))
            for case in derivation.cases
        ],
        "paragraphs": paragraphs(derivation),
        "legend": legend(derivation),
        "bars": bar_texts(check),
        "compared": [
            (one.quantity, number_text(one.hand), number_text(one.model), one.unit, one.formula)
            for one in derivation.compared
        ],
        "unproved": derivation.unproved,
        "notes": derivation.notes,
        "rule": rule,
        "ends": ends,
    }


def _acting(case: LoadCase) -> tuple[tuple[str, ...], ...]:
    """Interface, point, size and components of each force and couple."""
    return tuple(
        (
            acts.interface,
            acts.on,
            number_text(acts.force),
            *(number_text(acts.wrench[k]) for k in (0, 1, 3, 4, 5)),
        )
        for acts in case.acting
    )


def formula_markup(text: object) -> Markup:
    """Text with its subscripts set as such, everything else escaped.

    >>> str(formula_markup("σ_a/S_e < 1"))
    'σ<sub>a</sub>/S<sub>e</sub> &lt; 1'
    """
    return Markup(_SUBSCRIPT.sub(r"\1<sub>\2</sub>", str(escape(clean(text)))))


FILTERS = {"derivation": view_of, "formula": formula_markup}  # that derivation.html.j2 uses


# A report on paper: printed to PDF by the browser that is there.
VARIABLE = "BALLESTA_BROWSER"
_NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge", "brave-browser"),
)
_PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    *(
        str(Path(root) / program)
        for root in map(os.environ.get, ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA"))
        if root
        for program in (
            "Google/Chrome/Application/chrome.exe",
            "Microsoft/Edge/Application/msedge.exe",
        )
    ),
)
_DRAWN = 20_000  # ms of the page's own clock, until its pictures are drawn
_LONGEST = 180.0  # s


class PrintError(RuntimeError):
    """No browser is there, or it printed nothing; the text says what to do."""


def find_browser() -> str:
    """Return the program that prints: Chromium, Chrome, Edge or Brave.

    `BALLESTA_BROWSER` names another one. Raises PrintError where there is none.
    """
    stated = os.environ.get(VARIABLE)
    if stated:
        found = shutil.which(stated)
        if found is None:
            raise PrintError(f"{VARIABLE} names {stated!r}, which is no program")
        return found
    for name in (*_NAMES, *_PLACES):
        found = shutil.which(name)
        if found is not None:
            return found
    raise PrintError(
        "a PDF is printed by Chromium, Chrome, Edge or Brave, and none was found; install one "
        f"(Debian, Ubuntu: apt-get install -y chromium), or name it in {VARIABLE}"
    )


def print_pdf(report: Path, pdf: Path, browser: str) -> None:
    """Print a report, an HTML file, to a PDF file; one that was there is replaced at the end.

    browser  from `find_browser`

    Raises PrintError where the browser ends without a PDF, and OSError for a file that cannot be
    written.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as scratch:
        made = Path(scratch) / "report.pdf"
        command = [
            browser, "--headless", "--disable-gpu", "--no-first-run", "--no-pdf-header-footer",
            f"--user-data-dir={scratch}/profile", f"--virtual-time-budget={_DRAWN}",
            f"--print-to-pdf={made}", *_unguarded(), report.resolve().as_uri(),
        ]  # fmt: skip
        try:
            ended = subprocess.run(
                command, capture_output=True, text=True, errors="replace", timeout=_LONGEST,
                check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise PrintError(
                f"{browser} printed nothing within {_LONGEST:.0f} s; open {report} and print it"
            ) from None
        except OSError as error:
            raise PrintError(f"{browser} cannot be started: {error.strerror}") from error
        if not made.is_file() or not made.read_bytes().startswith(b"%PDF"):
            last = next((line for line in reversed(ended.stderr.splitlines()) if line.strip()), "")
            raise PrintError(
                f"{browser} printed nothing (exit code {ended.returncode}{': ' * bool(last)}"
                f"{last.strip()[:200]}); open {report} and print it"
            )
        beside = pdf.with_name(f".{pdf.name}.tmp")
        shutil.copyfile(made, beside)
        beside.replace(pdf)


def _unguarded() -> list[str]:
    """Options without which root cannot print: the browser refuses its sandbox there."""
    if sys.platform != "win32" and os.geteuid() == 0:
        return ["--no-sandbox"]
    return []
