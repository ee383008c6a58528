"""Design files to start from: `ballesta new <template>`."""

from importlib.resources import files
from pathlib import Path

from checks.design.errors import DesignError, no_such


def templates() -> tuple[str, ...]:
    """Return the names of the templates."""
    folder = files("ballesta.design").joinpath("templates")
    names = [entry.name for entry in folder.iterdir()]
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


def new_design(template: str) -> str:
    """Return the text of a template: a commented design file that runs as it is."""
    if template not in templates():
        raise DesignError(
            Path("new"),
            template,
            no_such(
                "template", template.replace("_", "-"), [n.replace("_", "-") for n in templates()]
            ),
        )
    entry = files("ballesta.design").joinpath("templates", f"{template}.toml")
    return entry.read_text(encoding="utf-8")
