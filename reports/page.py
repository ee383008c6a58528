"""The report: one HTML page that stands alone, with a script of its own, nothing from outside."""

from collections.abc import Mapping
from functools import cache
from numbers import Integral
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from reports.files import replacing
from reports.gauge import limit_share
from reports.page_inputs import sorted_assumptions, sorted_inputs
from reports.page_parts import (
    broken_of,
    check_rows,
    counts,
    cycle_views,
    part_views,
    tiles,
    worst_first,
)
from reports.pictures import Pictures
from reports.svg import colour_variables
from reports.verdict import DesignResult
from reports.words import (
    bar_words,
    brief,
    clean,
    gate_sentence,
    gate_word,
    headline,
    moment,
    need_text,
    number,
    place_text,
    reason,
    safety_text,
    utilisation_text,
    value_and_bars,
    verdict_sentence,
    where,
)


def write_report(result: DesignResult, pictures: Pictures, path: str | Path) -> None:
    """Write the page as a file, which is there whole or not at all."""
    text = report_html(result, pictures)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def report_html(result: DesignResult, pictures: Pictures | None = None) -> str:
    """Page as text. The same result and pictures give the same page."""
    from reports.live.section import live_section
    from reports.mechanism_panel import mechanism_panel
    from reports.page_script import script_hash, script_text

    pictures = pictures or Pictures(reason="no pictures were asked for")
    rows = check_rows(result)
    parts = part_views(result, rows, pictures)
    linkage = worst_first([row for row in rows if any(row.check is c for c in result.linkage)])
    text: str = _template().render(
        result=result,
        status=str(result.status),
        headline=headline(result),
        sentence=verdict_sentence(result),
        deciding=next((row for row in rows if row.decides), None),
        rows=worst_first(rows),
        counts=counts(result.checks),
        tiles=tiles(parts, linkage),
        broken=broken_of(result),
        assumed=sorted_assumptions(result),
        inputs=sorted_inputs(result),
        parts=parts,
        linkage=linkage,
        cycles=cycle_views(result),
        live=live_section(result, mechanism=mechanism_panel(result)),
        pictures_reason=pictures.reason,
        limit_share=limit_share(),
        script=Markup(script_text()),
        script_hash=Markup(script_hash()),
        light=Markup(colour_variables(dark=False)),
        dark=Markup(colour_variables(dark=True)),
    )
    return text


def value_text(value: Any) -> str:
    """Fact or number of a mesh as text: whole numbers whole, others to four digits."""
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "–"}[value]
    if isinstance(value, str):
        return clean(value)
    if isinstance(value, Integral):
        return f"{int(value):,}".replace(",", " ")
    if isinstance(value, Mapping):
        return ", ".join(f"{key}: {value_text(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(value_text(item) for item in value)
    try:
        return number(value, 4)
    except (TypeError, ValueError):
        return clean(value)


def environment() -> Environment:
    """Return a new environment that finds the templates and escapes what they are given."""
    result = Environment(
        loader=PackageLoader("reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: value if isinstance(value, Markup) else clean(value, lines=True),
    )
    result.filters |= {
        "brief": brief,
        "need": need_text,
        "number": number,
        "safety": safety_text,
        "utilisation": utilisation_text,
        "bars": value_and_bars,
        "bar_words": bar_words,
        "gate": gate_sentence,
        "gate_word": gate_word,
        "moment": moment,
        "place": place_text,
        "reason": reason,
        "where": where,
        "value": value_text,
    }
    return result


@cache
def _template() -> Any:
    from reports.derivation_view import FILTERS

    found = environment()
    found.filters |= FILTERS
    return found.get_template("report.html.j2")
