"""What every page is made with: the templates, and how they write what they are given."""

import json
from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from numbers import Integral
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from reports.words import (
    brief,
    clean,
    gate_sentence,
    gate_word,
    moment,
    need_text,
    number,
    place_text,
    reason,
    safety_text,
    utilisation_text,
    value_and_bars,
    where,
)


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


def script_hash(text: str) -> str:
    """Hash of a script as a content security policy names it."""
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"


def json_markup(data: Any) -> Markup:
    """JSON for a script element: nothing in it can end the element."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    for mark in "<>&\u2028\u2029":
        text = text.replace(mark, f"\\u{ord(mark):04x}")
    return Markup(text)


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
        "moment": moment,
        "place": place_text,
        "reason": reason,
        "where": where,
        "value": value_text,
    }
    return result
