"""Changes between two designs or two runs: `ballesta diff A B`."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ballesta.diff.compared import compared
from ballesta.run import Say, guarded, told_of_folder
from checks.design.effort import effort_of
from checks.design.errors import DesignError, listed
from checks.result.words import brief
from geometry.parameters import MEBIBYTE, read_bounded
from geometry.progress import step
from reports.difference_text import VERDICTS, DesignDifference, Difference
from reports.files import plain

if TYPE_CHECKING:
    from checks.design.data import Design
    from checks.design.effort import Effort

RESULT = "result.json"
_JSON_NAMES = {list: "a list", str: "a text", bool: "true or false", type(None): "null"}

_MOST_RESULT = 256 * MEBIBYTE


@dataclass(frozen=True)
class Wanted:
    """Options of `ballesta diff`; fidelity and within for design files, which are checked.

    html  file for the page; None for none
    """

    html: Path | None = None
    as_json: bool = False
    fidelity: str = "auto"
    within: str | None = None


@dataclass(frozen=True)
class Found:
    """A result that was read or made: where, and its data."""

    path: str
    data: Mapping[str, Any]


def differences_of(
    a: str | Path, b: str | Path, *, effort: "Effort | None" = None, say: Say = lambda _: None
) -> Difference:
    """Compare two design files (which are checked), result.json files or folders of a run.

    Folders may hold several designs; they are paired by the folders of their results, and a single
    one on both sides whatever its name. A result of several that cannot be read is a note. Raises
    DesignError where nothing can be read or checked, NumericsError where a solver gave up.
    """
    before, after = (results_at(Path(path), effort, say) for path in (a, b))
    if len(before) == len(after) == 1:
        pairs = [(next(iter(before)), next(iter(after)))]
    else:
        pairs = [(name, name) for name in before if name in after]
    if not pairs:
        raise DesignError(
            Path(b),
            "cannot be compared",
            f"no design stands on both sides: {a} has {brief(listed(before), 200)}, "
            f"{b} has {brief(listed(after), 200)}",
        )
    designs, errors = [], []
    for old, new in pairs:  # one after the other: results of thousands do not fit into memory
        try:
            one, other = before[old](), after[new]()
        except DesignError as error:
            errors.append(error)
            continue
        name = old if old == new else f"{old} → {new}"
        designs.append(compared(name, one.data, other.data, (one.path, other.path)))
    if not designs:
        raise errors[0]
    designs.sort(key=_importance)
    paired = {old for old, _ in pairs}, {new for _, new in pairs}
    return Difference(
        a=str(a),
        b=str(b),
        designs=designs,
        only_a=[name for name in before if name not in paired[0]],
        only_b=[name for name in after if name not in paired[1]],
        notes=[f"not compared: {error}" for error in errors],
    )


def _importance(design: DesignDifference) -> tuple[int, float]:
    """Designs whose verdicts turned come first, then the largest changes."""
    return -len(design.changes.get(VERDICTS, ())), -design.largest


def result_files(folder: Path) -> list[Path]:
    """Every result.json in a folder and in those inside of it, but for hidden ones."""
    return sorted(
        file
        for file in folder.rglob(RESULT)
        if not any(step.startswith(".") for step in file.relative_to(folder).parts)
    )


def results_at(path: Path, effort: "Effort | None", say: Say) -> dict[str, Callable[[], Found]]:
    """Functions that read or compute the results behind a path, by name; raises DesignError."""
    if path.is_dir():
        files = result_files(path)
        if not files:
            raise DesignError(
                path,
                "cannot be compared",
                f"the folder has no {RESULT}; ballesta check FILE --out {path} writes one",
            )
        named = {file.parent.relative_to(path).as_posix(): file for file in files}
        own = path.resolve().name
        return {
            own if name == "." else name: partial(read_result, file) for name, file in named.items()
        }
    if path.suffix.lower() == ".json":
        name = path.resolve().parent.name if path.name == RESULT else path.stem
        return {name: partial(read_result, path)}
    from ballesta.design.read import read_design

    # read at once: a wrong file is told before the other is checked
    return {path.stem: partial(_checked, read_design(path), path, effort, say)}


def read_result(path: Path, cannot: str = "cannot be compared") -> Found:
    """Read a result, also of another version of the tool; raises DesignError.

    cannot  what is said of a file that is no result
    """
    try:
        text = read_bounded(path, _MOST_RESULT).decode("utf-8")
        data = json.loads(text, parse_constant=_refuse)
    except FileNotFoundError:
        raise DesignError(path, "cannot be read", "there is no such file") from None
    except UnicodeDecodeError:
        raise DesignError(path, "cannot be read", "is not UTF-8 text") from None
    except OSError as error:
        problem = str(error.strerror or error).lower()
        raise DesignError(path, "cannot be read", problem) from None
    except (ValueError, RecursionError) as error:
        raise DesignError(path, "cannot be read", f"is not JSON: {error}") from None
    found = data.get("format") if isinstance(data, dict) else None
    if not isinstance(found, str) or not found.startswith("ballesta-result/"):
        told = f"has format {found!r}" if isinstance(found, str) else "has no format"
        if not isinstance(data, dict):
            told = f"holds {_JSON_NAMES.get(type(data), 'a number')}"
        raise DesignError(
            path, cannot, f"must be a {RESULT} that ballesta check wrote, it {brief(told, 100)}"
        )
    return Found(str(path), data)


def _refuse(constant: str) -> None:
    raise ValueError(f"a result holds no {constant}")


def _checked(design: "Design", path: Path, effort: "Effort | None", say: Say) -> Found:
    from ballesta.pipeline import check_design
    from checks.design.effort import DEFAULT_EFFORT

    result = check_design(
        design, effort=effort or DEFAULT_EFFORT, say=lambda text: say(f"{path.stem}: {text}")
    )
    return Found(str(path), plain(result.to_dict()))


def run_diff(a: Path, b: Path, wanted: Wanted) -> int:
    """Print what changed and write the page that is wanted; returns the exit code.

    0: compared, whatever changed; 2: an input is wrong; 3: the numerics gave up.
    """

    def work() -> None:
        effort = effort_of(wanted.fidelity, wanted.within)
        difference = differences_of(a, b, effort=effort, say=step)
        if wanted.html is not None:
            from reports.difference_text import write_difference

            with told_of_folder(wanted.html, "--html"):
                write_difference(difference, wanted.html)
        if wanted.as_json:
            files = [] if wanted.html is None else [str(wanted.html)]
            report = plain(difference.to_dict() | {"files": files})
            print(json.dumps(report, indent=1, allow_nan=False, ensure_ascii=False))
        else:
            from reports.difference_text import difference_text

            print(difference_text(difference), end="")
            if wanted.html is not None:
                print(f"written: {wanted.html}")

    return guarded(work)
