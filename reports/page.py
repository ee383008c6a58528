"""The report: one HTML page that stands alone, with a script of its own, nothing from outside."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from markupsafe import Markup

from checks.result.verdict import DesignResult
from reports.answer_facts import Answer, answer_of
from reports.charts import design_charts
from reports.files import replacing
from reports.loads_words import broken_of
from reports.page_inputs import sorted_assumptions, sorted_inputs
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
from reports.safety_scale import safety_scale
from reports.svg import colour_variables
from reports.templating import environment
from reports.tornado import shares
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
    text = report_html(result, pictures)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def report_html(
    result: DesignResult, pictures: Pictures | Callable[[], Pictures] | None = None
) -> str:
    """Page as text. The same result and pictures give the same page.

    pictures  or what waits for them, which is asked when all else is ready
    """
    from reports.live.section import live_section
    from reports.mechanism_panel import mechanism_panel
    from reports.page_script import script_hash, script_text

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
        what_if=what_if(result),
        shares=shares(result.deciding) if result.checks else [],
        pictures_reason=pictures.reason,
        script=Markup(script_text()),
        script_hash=Markup(script_hash()),
        light=Markup(colour_variables(dark=False)),
        dark=Markup(colour_variables(dark=True)),
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
        beside=by_label([*answer.beside, *answer.warnings], len(result.warnings)),
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
    from reports.derivation_view import FILTERS

    found = environment()
    found.filters |= FILTERS | _WORDS
    found.tests |= {"with_place": has_place, "swinging": swings}
    for name in _INCLUDED:  # else they are compiled when the pictures have been waited for
        found.get_template(f"{name}.html.j2")
    return found
