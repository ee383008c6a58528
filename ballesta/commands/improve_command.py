"""Single changes that make a design pass: `ballesta improve`."""

import json
import re
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ballesta.run import guarded
from ballesta.sweeps.improve import MOST, Improved, improve
from checks.design.effort import effort_of
from checks.design.errors import DesignError, listed
from checks.result.verdict import Change, Status
from checks.result.ways import command_with
from checks.result.words import need_text, number, safety_text
from reports.terminal import labelled, table


@dataclass(frozen=True)
class Wanted:
    """Options of `ballesta improve`."""

    verify: bool = False
    apply: bool = False
    fidelity: str = "auto"
    as_json: bool = False


def run_improve(design: Path, wanted: Wanted, overrides: Sequence[str]) -> int:
    """Print the changes, write the first that passes if asked; returns the exit code."""
    code = 0

    def find() -> None:
        nonlocal code
        found = improve(
            design,
            overrides,
            effort=effort_of(wanted.fidelity, None),
            verify=wanted.verify,
            say=lambda words: print(f"{design.stem:15} {words}", file=sys.stderr),
        )
        code = found.exit_code
        if wanted.as_json:
            print(json.dumps(found.to_dict(), indent=1))
        else:
            print(_text(found, shutil.get_terminal_size((100, 24)).columns), end="")
        if wanted.apply:
            passing = [change for change in found.changes if change.verified is Status.PASS]
            if not passing:
                raise DesignError(design, "--apply", "no change that was checked passes")
            _apply(design, passing[0])
            print(f"{design}: {passing[0].override} written", file=sys.stderr)

    return guarded(find) or code


def _apply(file: Path, change: Change) -> None:
    """Write a change into a design file, nothing else; DesignError where its line is not found."""
    table, _, name = change.key.rpartition(".")
    text = file.read_text(encoding="utf-8")
    line = re.compile(
        rf"(^\[{re.escape(table)}\][^\[]*?^{re.escape(name)}\s*=\s*\"){re.escape(change.was)}\"",
        re.MULTILINE | re.DOTALL,
    )
    changed, count = line.subn(lambda found: f'{found[1]}{change.value}"', text)
    if count != 1:
        raise DesignError(
            file,
            change.key,
            f'no line `{name} = "{change.was}"` stands in a table [{table}]; write it by hand',
        )
    file.write_text(changed, encoding="utf-8")


def _text(found: Improved, width: int = 100) -> str:
    """The changes in lines of at most `width` columns."""
    result = found.result
    aim = f"for {listed(found.open)} to pass" if found.open else "to save mass"
    lines = labelled("", f"{result.name} ({result.file}): {result.status}; {aim}", width)
    if not found.changes:
        none = (
            "no single change of a dimension or material makes it pass"
            if found.open
            else "nothing to save"
        )
        return "\n".join([*lines, f"{none} within a factor of {MOST:g}"]) + "\n"
    heads = ["change", "safety", "with error bars", "required", "mass, kg", "of", "verdict"]
    rows = []
    for change in found.changes:
        need = need_text(change.required)
        rows.append(
            [
                f"{change.key} = {change.was} -> {change.value}",
                safety_text(change.verified_safety or change.safety, change.required),
                safety_text(change.lower, change.required),
                need,
                f"{number(1e3 * change.mass, 4)} ({0.0 - 1e3 * change.saved:+.2g})",
                change.governing,
                "estimate" if change.verified is None else str(change.verified),
            ]
        )
    lines += table(heads, rows, {1, 2, 3, 4}, width)
    best = found.changes[0]
    note = command_with(result, best.override)
    if any(change.verified is None for change in found.changes):
        note += "; estimates by formula, set against the models that decided: --verify checks them"
    return "\n".join([*lines, *labelled("next", note, width)]) + "\n"
