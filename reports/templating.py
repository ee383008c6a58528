"""Templates of every page, and the rules by which they write their data."""

import gzip
import json
import sys
from base64 import b64encode
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from importlib.resources import files
from importlib.util import cache_from_source
from numbers import Integral
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from jinja2 import BytecodeCache, Environment, FileSystemLoader, StrictUndefined, Template
from jinja2.bccache import Bucket
from markupsafe import Markup

from checks.result.words import (
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
from reports.files import replacing
from reports.svg import colour_variables

_TEMPLATES = Path(__file__).with_name("templates")


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


class _Compiled(BytecodeCache):
    """Keeps compiled templates beside themselves, as Python keeps its modules; if it may write."""

    def get_source_checksum(self, source: str) -> str:
        """Checksum of the text and of the version of jinja2, which compiles it."""
        return super().get_source_checksum(f"{version('jinja2')}\n{source}")

    def load_bytecode(self, bucket: Bucket) -> None:
        """Load the compiled template of the same text, if there is one."""
        with suppress(OSError), self._file(bucket).open("rb") as stream:
            bucket.load_bytecode(stream)

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Write the compiled template, if Python writes its own compiled modules."""
        if sys.dont_write_bytecode:
            return
        file = self._file(bucket)
        with suppress(OSError):
            file.parent.mkdir(exist_ok=True)
            with replacing(file) as temporary, temporary.open("wb") as stream:
                bucket.write_bytecode(stream)

    def _file(self, bucket: Bucket) -> Path:
        """File of a compiled template, one for each set of options it is compiled with."""
        return Path(cache_from_source(str(_TEMPLATES / f"{bucket.key}.py")))


def environment() -> Environment:
    """Return a new environment that finds the templates and escapes their data."""
    result = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        bytecode_cache=_Compiled(),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: value if isinstance(value, Markup) else clean(value, lines=True),
    )
    result.globals |= {
        "light": Markup(colour_variables(dark=False)),
        "dark": Markup(colour_variables(dark=True)),
    }
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


@cache
def page_template(name: str, **filters: Callable[..., object]) -> Template:
    """Template of a page, with filters of its own beside those of all pages."""
    pages = environment()
    pages.filters |= filters
    return pages.get_template(f"{name}.html.j2")


# Numbers as a page's script unpacks them: reports/live/data.js reads what is written here.

_STEPS = 60_000  # of a quantity's range: of a path of 600 mm each is 0.01 mm


def packed_json(data: Any) -> str:
    """Base64 of gzip of JSON; equal data give equal text."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def series(values: npt.NDArray[Any]) -> dict[str, Any]:
    """Numbers (k,) as whole differences of steps, each right to half a step of their range.

    A series is {from, step, d}: value k is from + step * (d[0] + ... + d[k]), `d` being whole.
    """
    low, high = float(values.min()), float(values.max())
    start = float(f"{low:.9g}")
    step = float(f"{(high - low) / _STEPS:.6g}")
    if step == 0.0:
        return {"from": start, "step": 0, "d": [0] * len(values)}
    whole = np.rint((values - start) / step).astype(int)
    return {"from": start, "step": step, "d": np.diff(whole, prepend=0).tolist()}


# The one script of the report: readable source files, put together in a fixed order.

# The scripts of the live view, each after those that it uses while it is read.
LIVE = (
    "data", "numbers", "viewer", "fields", "camera", "scene", "motion", "overlay", "controls",
    "positions", "transport", "picture", "readings", "app",
)  # fmt: skip
BESIDE = ("arrows", "mechanism", "cursors", "hover", "what_if", "page")
SCRIPTS = (*(f"live/{name}.js" for name in LIVE), *(f"scripts/{name}.js" for name in BESIDE))


@cache
def script_text() -> str:
    """Text of the script of the report."""
    return joined(*SCRIPTS)


@cache
def report_hash() -> str:
    """Hash of the script as a content security policy names it."""
    return script_hash(script_text())


def joined(*names: str) -> str:
    """Text of a script of some files of this folder, one after the other.

    They share one scope: a name at the top of a file is known to all of them as soon as the file
    has run, so that no two may use a name there. A name in braces is a file's own.
    """
    folder = files("reports")
    parts = [folder.joinpath(name).read_text(encoding="utf-8").strip() for name in names]
    return "\n".join(['(() => { "use strict";', *parts, "})();"])
