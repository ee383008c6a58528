"""The one script of the report: readable source files, put together in a fixed order."""

from functools import cache
from importlib.resources import files

from reports import templating

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
def script_hash() -> str:
    """Hash of the script as a content security policy names it."""
    return templating.script_hash(script_text())


def joined(*names: str) -> str:
    """Text of a script of some files of this folder, one after the other.

    They share one scope: a name at the top of a file is known to all of them as soon as the file
    has run, so that no two may use a name there. A name in braces is a file's own.
    """
    folder = files("reports")
    parts = [folder.joinpath(name).read_text(encoding="utf-8").strip() for name in names]
    return "\n".join(['(() => { "use strict";', *parts, "})();"])
