"""Templates of every page, and the rules by which they write their data."""

import json
import sys
from base64 import b64encode
from collections.abc import Mapping
from contextlib import suppress
from hashlib import sha256
from importlib.metadata import version
from importlib.util import cache_from_source
from numbers import Integral
from pathlib import Path
from typing import Any

from jinja2 import BytecodeCache, Environment, FileSystemLoader, StrictUndefined
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
