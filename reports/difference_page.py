"""A difference as one HTML page that stands alone: every change, with where it comes from."""

from functools import cache
from pathlib import Path
from typing import Any

from markupsafe import Markup

from reports.difference_summary import GROUPS, ROUND_OFF, Difference
from reports.difference_text import change_text, summary_sentence, values_text
from reports.files import replacing
from reports.svg import colour_variables
from reports.templating import environment


def difference_html(difference: Difference) -> str:
    """Page as text. The same difference gives the same page."""
    text: str = _template().render(
        difference=difference,
        sentence=summary_sentence(difference),
        groups=GROUPS,
        round_off=f"{ROUND_OFF:g}",
        light=Markup(colour_variables(dark=False)),
        dark=Markup(colour_variables(dark=True)),
    )
    return text


def write_difference(difference: Difference, path: str | Path) -> None:
    """Write the page as a file, which is there whole or not at all."""
    text = difference_html(difference)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


@cache
def _template() -> Any:
    pages = environment()
    pages.filters |= {"change": change_text, "amounts": values_text}
    return pages.get_template("difference.html.j2")
