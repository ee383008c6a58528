"""Derivation of a check's number: `ballesta why DESIGN|RESULT [PART] [KIND...]`."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ballesta.diff.difference import RESULT, read_result, result_files
from ballesta.run import Say, guarded, store_at
from checks.design.effort import effort_of
from checks.design.errors import LINKAGE, DesignError, listed, no_such
from checks.result.formulas import FormulaError
from checks.result.verdict import Check, deciding_of
from checks.result.words import brief, check_titles
from geometry.progress import step
from reports.files import FORMAT

if TYPE_CHECKING:
    from checks.design.effort import Effort
    from checks.store.store import Store

_UNTOLD = "cannot be explained"
_HERE = Path("command line")
_WRITTEN = (".html", ".vtu")  # files that a check writes beside its result
_LISTED = 20  # results of a folder of many
_ROUND_OFF = 1e-9  # of a value: its formulas, evaluated once more, differ by rounding alone


@dataclass(frozen=True)
class Wanted:
    """Options of `ballesta why`: which checks, and how much of each.

    part     whose; "" for the one that decides the design
    kinds    such as "fatigue", or words of what is checked, such as "crooked"; none for all
    every    every check that is meant, else the nearest to its limit of each kind
    verbose  every symbol, formula and unit load
    """

    part: str = ""
    kinds: tuple[str, ...] = ()
    every: bool = False
    verbose: bool = False
    as_json: bool = False


def run_why(
    target: Path,
    wanted: Wanted,
    overrides: Sequence[str] = (),
    fidelity: str | None = None,
    store: Path | None = None,
) -> int:
    """Print the derivations that are wanted; returns the exit code.

    0: told, whatever the verdict; 2: an input is wrong; 3: the numerics gave up.
    """

    def work() -> None:
        checks = checks_behind(target, overrides, fidelity, store, step, part=wanted.part)
        found = wanted_checks(target, checks, wanted)
        if all(check.derivation is None for check, _ in found):
            said = "has no derivation, as another version wrote it: check the design again"
            raise DesignError(target, _UNTOLD, said)
        for check, _ in found:
            _must_agree(target, check)
        if wanted.as_json:
            plain = [check.to_dict() for check, _ in found]
            print(json.dumps(plain, indent=1, allow_nan=False, ensure_ascii=False))
            return
        print(told(checks, found, wanted), end="")

    return guarded(work)


def checks_behind(
    target: Path,
    overrides: Sequence[str] = (),
    fidelity: str | None = None,
    store: Path | None = None,
    say: Say = lambda _: None,
    *,
    part: str = "",
) -> list[Check]:
    """Return all checks of a design file, which is checked, or of a result; raises DesignError.

    A result.json, or a folder with one, is read as it is. A `part` that a design does not have is
    refused before anything is computed.
    """
    if target.is_dir() or target.suffix.lower() == ".json":
        for option, given in (("--set", bool(overrides)), ("--fidelity", fidelity is not None)):
            if given:
                told = f"belongs to a design file; {target} is a result, which is told as it is"
                raise DesignError(_HERE, option, told)
        return _read(target)
    if target.suffix.lower() in _WRITTEN and target.is_file():
        raise _beside(target)
    effort = effort_of(fidelity or "auto", None)
    return list(_checked(target, tuple(overrides), effort, store_at(store), say, part))


def _checked(
    path: Path,
    overrides: tuple[str, ...],
    effort: "Effort",
    store: "Store | None",
    say: Say,
    part: str,
) -> Sequence[Check]:
    from ballesta.design.read import read_design
    from ballesta.pipeline import check_design
    from checks.store.store import recalled_result

    kept = recalled_result(store, path, overrides, effort)
    if kept is not None:
        return kept.result.checks
    design = read_design(path, overrides)
    names = [*design.parts, LINKAGE]
    if part and part not in names:
        raise DesignError(path, "PART", no_such("part", part, names))
    return check_design(
        design, effort=effort, store=store, say=lambda text: say(f"{path.stem}: {text}")
    ).checks


def _read(target: Path) -> list[Check]:
    """The checks of a result that was written; raises DesignError."""
    result = read_result(_one_result(target), _UNTOLD)
    if result.data["format"] != FORMAT:
        raise _of_another_version(Path(result.path), f"format {result.data['format']!r}")
    try:
        plain = {
            f"parts[{part}].checks[{k}]": check
            for part, own in enumerate(result.data.get("parts", ()))
            for k, check in enumerate(own.get("checks", ()))
        }
        plain |= {f"linkage[{k}]": c for k, c in enumerate(result.data.get("linkage", ()))}
        return [_check_at(key, check) for key, check in plain.items()]
    except (TypeError, ValueError, AttributeError) as error:
        raise _of_another_version(Path(result.path), str(error)) from error


def _check_at(key: str, data: Any) -> Check:
    """A check from its data; raises ValueError with the key that is wrong."""
    try:
        return Check.from_dict(data)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{key}: {error}") from error


def _one_result(target: Path) -> Path:
    """The result that is meant by its file or by a folder with no other; raises DesignError."""
    if not target.is_dir():
        return target
    files = result_files(target)
    if not files:
        designs = sorted(target.glob("*.toml"))
        advice = (
            f"ballesta why {designs[0]} tells of a design file"
            if designs
            else f"ballesta check FILE --out {target} writes one"
        )
        raise DesignError(target, _UNTOLD, f"there is no {RESULT} in the folder; {advice}")
    if len(files) > 1:
        named = [str(file.parent) for file in files]
        more = f" and {len(named) - _LISTED} more" if len(named) > _LISTED else ""
        told = f"has {len(named)} results, name one of them: {listed(named[:_LISTED])}{more}"
        raise DesignError(target, _UNTOLD, told)
    return files[0]


def _beside(target: Path) -> DesignError:
    """The error of a page or drawing that was named, with the result to name instead."""
    result = target.with_name(RESULT)
    advice = "name a design file (.toml) or a result"
    if result.is_file():
        advice = f"the result stands beside it: ballesta why {result}"
    return DesignError(target, _UNTOLD, f"is neither a design file nor a result; {advice}")


def _of_another_version(target: Path, why: str) -> DesignError:
    told = f"is no result of this version ({brief(why, 300)}): check the design again"
    return DesignError(target, _UNTOLD, told)


def _must_agree(target: Path, check: Check) -> None:
    """Raises DesignError where a check's numbers are not those of its derivation's formulas.

    An eigenvalue's error bars have none.
    """
    derivation = check.derivation
    if derivation is None:
        return
    number, bars = derivation.number, derivation.bars
    pairs = [
        ("value", check.value, (derivation.value,)),
        ("limit", check.limit, (derivation.limit,)),
        ("numerical error bar", check.numerical, bars.numerical.split()),
        ("model error bar above", check.model, bars.above.split()),
        ("model error bar below", check.below, bars.below.split()),
    ]
    try:
        found = [
            (name, stated, sum(map(number, symbols)))
            for name, stated, symbols in pairs
            if symbols or not derivation.unproved
        ]
    except FormulaError as error:
        told = f"{check.part} {check.kind}: the formulas give no number: {error}"
        raise _of_another_version(target, told) from error
    for name, stated, own in found:
        if isfinite(stated) and not abs(own - stated) <= _ROUND_OFF * max(check.value, stated):
            told = (
                f"a {name} of {stated:.6g} stands in the result, and its own formulas give "
                f"{own:.6g}: one of them was changed; check the design again"
            )
            raise DesignError(target, f"{check.part} {check.kind}", told)


def wanted_checks(target: Path, checks: Sequence[Check], wanted: Wanted) -> list[tuple[Check, str]]:
    """Return the checks that are meant, each with its title; raises DesignError for none."""
    titled = list(zip(checks, check_titles(checks), strict=True))
    if not titled:
        raise DesignError(target, _UNTOLD, "nothing was checked")
    if wanted.part:
        names = list(dict.fromkeys(check.part for check in checks))
        if wanted.part not in names:
            raise DesignError(target, "PART", no_such("part", wanted.part, names))
        titled = [pair for pair in titled if pair[0].part == wanted.part]
    groups = [titled]
    if wanted.kinds:
        groups = [_of_kind(target, titled, kind) for kind in wanted.kinds]
    if wanted.every:
        return [pair for group in groups for pair in group]
    return [_nearest(group) for group in groups]


def _of_kind(
    target: Path, titled: Sequence[tuple[Check, str]], kind: str
) -> list[tuple[Check, str]]:
    """The checks of a kind, else those whose kind or quantity has the words."""
    exact = [pair for pair in titled if pair[0].kind == kind]
    folded = kind.casefold()
    loose = [
        pair
        for pair in titled
        if folded in pair[1].casefold() or folded in pair[0].quantity.casefold()
    ]
    if not exact and not (loose and folded):
        known = list(dict.fromkeys(check.kind for check, _ in titled))
        raise DesignError(target, "KIND", no_such("check", kind, known))
    return exact or loose


def _nearest(titled: Sequence[tuple[Check, str]]) -> tuple[Check, str]:
    """The check that is nearest to its limit, as a design's verdict has it."""
    deciding = deciding_of([check for check, _ in titled])
    return next(pair for pair in titled if pair[0] is deciding)


def told(checks: Sequence[Check], found: Sequence[tuple[Check, str]], wanted: Wanted) -> str:
    """The derivations as text, and what other checks the same part has."""
    from reports.derivation_text import derivation_text

    texts = [derivation_text(check, title, everything=wanted.verbose) for check, title in found]
    shown = {id(check) for check, _ in found}
    parts = {check.part for check, _ in found}
    others = [
        title
        for check, title in zip(checks, check_titles(checks), strict=True)
        if check.part in parts and id(check) not in shown
    ]
    if others and not wanted.kinds:
        texts.append(f"other checks of {listed(sorted(parts))}: {brief(listed(others), 400)}\n")
    return "\n".join(texts)
