"""Write docs/reference and docs/parts.md from the code that they describe.

`--check` writes nothing and exits 1 if a page would change. The pictures of the shapes are drawn by
`python tools/describe_parts.py`.
"""

import argparse
import inspect
import re
import sys
from collections.abc import Callable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import describe_parts
from reference_keys import anchor, design_file_page
from typer.main import get_group

import ballesta
from ballesta.cli import app
from checks.design.materials import Material, known_materials
from checks.design.model import Requirements
from checks.ladder.part_ladder import known_kinds

ROOT = Path(__file__).parent.parent
REFERENCE = ROOT / "docs" / "reference"
MATERIALS = """\
# Materials

Written by `python tools/reference.py` from `checks/design/materials.toml`; do not edit.

`material = "NAME"` in a part takes one of these. Values are the standard's minimum for the state
that the source names. Where they depend on size, a part takes those of its own: thickness of a
plate or wall, the smaller side of an eye or boss with its plate, length of a hole of a CAD part;
diameter of a pin, journal or solid rod, in brackets where it differs. A smaller part has no more
than the first values, as it may be cut from a larger bar; beyond the last size it is refused.
Another material stands under `[materials.NAME]` in the design file, with
[these keys](design_file.md#{anchor}).

| Name | E, GPa | ν | ρ, kg/m3 | Yield, MPa | Tensile, MPa | S_e/S_u | FKM group | Source |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
{rows}

E is Young's modulus, ν Poisson's ratio, ρ the density, S_e/S_u the endurance limit of a polished
bar over the tensile strength, at the cycles beside it; without cycles steel's, at 10⁶. A material
that is not steel must state it; stainless and cast steels here do. A brittle material has none:
neither von Mises nor Goodman can judge it, and the result says so.
"""
CHECKS = """\
# Checks

Written by `python tools/reference.py` from the checks in `checks/`; do not edit.

A check compares a demand with a limit. It passes when the upper end of the demand's error bars,
times the required safety, stays within the limit. `require.KEY` in the design file sets that
safety; the number in brackets is its default.

| Kind | Demand | Limit | Required safety | Source |
| --- | --- | --- | --- | --- |
{rows}

[How a part is judged](../judgement.md) says which checks a part gets, and which of them decides.
"""
COMMANDS = """\
# Commands and exit codes

Written by `python tools/reference.py` from `ballesta/cli.py`; do not edit.

| Exit code | Meaning |
| --- | --- |
| 0 | every part passes |
| 1 | a part fails or stays UNDECIDED |
| 2 | an input is wrong: the message names file, key, what was found and what was expected |
| 3 | the numerics gave up |
| 130 | stopped by Ctrl-C; what was finished is written |

Of several designs the highest code counts, and a bad file costs that file alone. Commands that
judge nothing, such as `why` and `diff`, end with 0 whatever the verdict.

"""

PYTHON = """\
# Python

Written by `python tools/reference.py` from `ballesta/api.py`; do not edit.

`import ballesta` offers these names, and loads what they need when one is first used. A notebook
shows results as tables: the verdict, its safety with the range of its error bars, and a row for
each part.
"""


def materials_page() -> str:
    """Every material that ballesta knows, with its values and their source."""
    rows = []
    for one in known_materials().values():
        cells = (
            f"`{one.name}`",
            f"{one.youngs_modulus / 1e3:g}",
            f"{one.poisson_ratio:g}",
            f"{one.density * 1e12:g}",
            _by_size(one, "yield_stress"),
            _by_size(one, "ultimate_stress"),
            _endured(one),
            one.fkm_group or "none",
            one.source,
        )
        rows.append(row(*cells))
    return MATERIALS.format(anchor=anchor("materials.NAME"), rows="\n".join(rows))


def _endured(material: Material) -> str:
    """Its endurance ratio, and the cycles of a stated one."""
    if material.endurance_ratio:
        return f"{material.endurance_ratio:g} at {material.endurance_cycles:g}"
    return "0.5" if material.ductile else "brittle"


def _by_size(material: Material, name: str) -> str:
    """A strength with the sizes up to which it holds."""
    told = []
    for grade in material.grades:
        size = f"{grade.thickness:g}"
        if grade.diameter != grade.thickness:
            size += f" ({grade.diameter:g})"
        to = f" to {size} mm" if isfinite(grade.thickness) else ""
        told.append(f"{getattr(grade, name):g}{to}")
    return "; ".join(told)


def checks_page() -> str:
    """Every check with its demand, limit, required safety and source."""
    rows = []
    for kind in known_kinds():
        default = Requirements.model_fields[kind.require].default
        safety = f"`require.{kind.require}` ({default:g})"
        rows.append(row(kind.name, kind.demand, kind.limit, safety, kind.source))
    return CHECKS.format(rows="\n".join(rows))


def commands_page() -> str:
    """Every command with its arguments and options, and the exit codes."""
    lines = []
    for name, command in get_group(app).commands.items():
        lines += [f"## ballesta {name}", "", inspect.cleandoc(command.help or ""), ""]
        if command.params:
            lines += [row("Argument", "Meaning", "Default"), row("---", "---", "---")]
            lines += [*map(_parameter, command.params), ""]
    return COMMANDS + "\n".join(lines)


def _parameter(parameter: Any) -> str:
    name = parameter.metavar or parameter.name.upper()
    if parameter.param_type_name == "argument":
        words = [name]
    else:
        value = "" if parameter.is_flag else f" {name}"
        words = [f"{option}{value}" for option in (*parameter.opts, *parameter.secondary_opts)]
    default = "" if parameter.default in (None, False, True, "") else f"`{parameter.default}`"
    variable = getattr(parameter, "envvar", None)
    meaning = f"{parameter.help}; environment: `{variable}`" if variable else parameter.help
    words_shown = ", ".join(f"`{word}`" for word in words)
    return row(words_shown, meaning, "must be stated" if parameter.required else default)


def python_page() -> str:
    """Every public name of the package with its signature and docstring."""
    lines = [PYTHON]
    for name in sorted(ballesta.__all__, key=lambda name: (name[0].isupper(), name)):
        found = getattr(ballesta, name)
        lines += [f"## {name}", ""]
        if not isinstance(found, type):
            lines += ["```python", _signature(name, found), "```", ""]
        lines += ["```text", inspect.cleandoc(found.__doc__), "```", ""]
    return "\n".join(lines)


def _signature(name: str, function: Callable[..., Any]) -> str:
    """The signature with one parameter a line, types as they are written."""
    signature = inspect.signature(function)
    lines: list[str] = []
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and "    *," not in lines:
            lines.append("    *,")
        lines.append(f"    {_without_modules(str(parameter))},")
    return "\n".join([f"ballesta.{name}(", *lines, f") -> {signature.return_annotation.__name__}"])


def _without_modules(text: str) -> str:
    return re.sub(r"\b(?:[a-z_]+\.)+(?=[A-Z])", "", text)


def row(*cells: str) -> str:
    """A row of a table in Markdown."""
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


PAGES: Mapping[Path, Callable[[], str]] = {
    REFERENCE / "design_file.md": design_file_page,
    REFERENCE / "materials.md": materials_page,
    REFERENCE / "checks.md": checks_page,
    REFERENCE / "commands.md": commands_page,
    REFERENCE / "python.md": python_page,
    describe_parts.PAGE: describe_parts.page,
}


def main() -> int:
    """Write the pages, or say which would change."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; 1 if one would change")
    check = parser.parse_args().check
    stale = 0
    for file, page in PAGES.items():
        text = page()
        if not check:
            file.parent.mkdir(exist_ok=True)
            file.write_text(text, encoding="utf-8")
        elif not file.exists() or file.read_text(encoding="utf-8") != text:
            stale = 1
            print(f"{file.relative_to(ROOT)} is out of date: run this tool", file=sys.stderr)
    return stale


if __name__ == "__main__":
    sys.exit(main())
