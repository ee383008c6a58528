"""The one script of the report: readable source files, put together in a fixed order."""

from base64 import b64encode
from functools import cache
from hashlib import sha256
from importlib.resources import files

from reports.live.section import SCRIPTS as LIVE

SCRIPTS = (*(f"live/{name}.js" for name in LIVE),
           *(f"scripts/{name}.js" for name in ("mechanism", "cursors", "page")))  # fmt: skip


@cache
def script_text() -> str:
    """Text of the script: what a file names at its top is known to those after it, to no other."""
    folder = files("reports")
    parts = [folder.joinpath(name).read_text(encoding="utf-8").strip() for name in SCRIPTS]
    return "\n".join(['(() => { "use strict";', *parts, "})();"])


@cache
def script_hash() -> str:
    """Hash of the script as a content security policy names it."""
    return f"sha256-{b64encode(sha256(script_text().encode()).digest()).decode()}"
