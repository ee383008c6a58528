"""The report: one HTML page that stands alone, without scripts or anything from outside."""

from base64 import b64encode
from collections.abc import Mapping
from functools import cache
from numbers import Integral
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from reports.charts import cycle_chart, haigh_chart, utilisation_chart
from reports.files import replacing
from reports.pictures import PLAIN, Pictures
from reports.svg import colour_variables
from reports.verdict import DesignResult, HandCheck, PartResult
from reports.words import (
    assumptions,
    brief,
    broken_gates,
    check_titles,
    clean,
    gate_sentence,
    gate_word,
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
    pictures = pictures or Pictures(reason="no pictures were asked for")
    text: str = _template().render(
        result=result,
        status=str(result.status),
        sentence=verdict_sentence(result),
        deciding=result.deciding if result.checks else None,
        titled=list(zip(result.checks, check_titles(result.checks), strict=True)),
        broken=broken_gates(result),
        assumptions=assumptions(result),
        utilisation=Markup(utilisation_chart(result)),
        cycles=[(name, Markup(cycle_chart(name, cycle))) for name, cycle in result.cycles.items()],
        parts=[_part(part, result, pictures) for part in result.parts],
        pictures_reason=pictures.reason,
        light=Markup(colour_variables(dark=False)),
        dark=Markup(colour_variables(dark=True)),
    )
    return text


# What a picture shows: before and after the part's name for who cannot see it, and below it.
_CAPTIONS = {
    "whole": ("The whole part", "coloured by stress", "The whole part"),
    "peak": (
        "Surroundings of the peak",
        "coloured by stress",
        "Around the peak, which the dot marks",
    ),
    "mode": (
        "Lowest buckling mode",
        "coloured by displacement",
        "The lowest buckling mode, exaggerated, on the first mesh; the dot moves most",
    ),
}


def _captions(part: PartResult) -> dict[str, tuple[str, str, str]]:
    """Captions of a part's pictures; one that was not meshed names what decided it."""
    decided = ", ".join(dict.fromkeys(brief(check.method, 40) for check in part.checks))
    told = f"Not meshed: decided by {decided or 'no check'}"
    return {**_CAPTIONS, PLAIN: ("The whole part", "not meshed, without colours of stress", told)}


def _part(part: PartResult, result: DesignResult, pictures: Pictures) -> dict[str, Any]:
    """Collect what the template needs of one part beside the part itself."""
    columns = list(dict.fromkeys(key for mesh in part.meshes for key in mesh))
    images = pictures.images.get(part.name, {})
    return {
        "part": part,
        "titled": list(zip(part.checks, check_titles(part.checks), strict=True)),
        "images": [(view, b64encode(image).decode()) for view, image in images.items()],
        "captions": _captions(part),
        "columns": columns,
        "haigh": Markup(haigh_chart(part, result.cycles)),
    }


def ratio(check: HandCheck) -> str:
    """Ratio of the model's number to that by hand."""
    return number(check.model / check.hand) if check.hand else "–"


def value_text(value: Any) -> str:
    """Fact or number of a mesh as text: whole numbers whole, others to four digits."""
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "–"}[value]
    if isinstance(value, str):
        return clean(value)
    if isinstance(value, Integral):
        return f"{int(value):,}".replace(",", " ")  # a thin space
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
        "gate": gate_sentence,
        "gate_word": gate_word,
        "place": place_text,
        "reason": reason,
        "where": where,
        "ratio": ratio,
        "value": value_text,
    }
    return result


@cache
def _template() -> Any:
    return environment().get_template("report.html.j2")
