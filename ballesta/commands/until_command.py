"""`ballesta batch --sweep ... --until pass`: searches of designs, one after the other.

Whatever is checked is kept in the store of the output folder, so that a search that was killed goes
on where it was, and a wider one begins with what is known.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ballesta.batches.plan import design_files
from ballesta.design.read import read_design
from ballesta.run import guarded, output_folders, store_at, told_of_folder
from ballesta.sweeps.threshold_search import UntilResult, until_pass, until_text
from checks.design.effort import Effort, effort_of
from checks.design.errors import DesignError, listed
from checks.result.verdict import DesignResult
from checks.store.results import keep_result, recalled_result
from checks.store.store import Store
from geometry.progress import step
from reports.files import plain, write_whole

_HERE = Path("command line")


@dataclass(frozen=True)
class Wanted:
    """The options of a search, as they were written.

    until   "pass", or "pass of PART, PART" to judge only these
    store   where stages are shared; None: the folder `store` of `out`
    unused  options that were given and that a search does not have
    """

    out: Path
    until: str = "pass"
    overrides: tuple[str, ...] = ()
    fidelity: str = "auto"
    within: str | None = None
    store: Path | None = None
    unused: tuple[str, ...] = ()


def run_until(designs: Sequence[Path], sweeps: Sequence[str], wanted: Wanted) -> int:
    """Search every design, print the threshold and write OUT/DESIGN/until.json.

    Returns the highest exit code: 0 a value passes, 1 none does, 2 an input is wrong, 3 the
    numerics gave up.
    """

    def every() -> int:
        parts = parts_of(wanted.until)
        if len(sweeps) != 1:
            raise DesignError(_HERE, "--until", f"needs one --sweep, got {len(sweeps)}")
        if wanted.unused:
            told = (
                f"searches by itself, one check after the other: leave out {listed(wanted.unused)}"
            )
            raise DesignError(_HERE, "--until", told)
        effort = effort_of(wanted.fidelity, wanted.within)
        files, _ = design_files([str(path) for path in designs])
        store = store_at(wanted.store or wanted.out / "store")
        folders = output_folders(files, wanted.out)

        def one(file: Path, folder: Path) -> int:
            with told_of_folder(wanted.out):
                folder.mkdir(parents=True, exist_ok=True)
            before = read_design(file, wanted.overrides).sources
            result = until_pass(
                file,
                sweeps[0],
                wanted.overrides,
                parts=parts,
                effort=effort,
                check=stored_check(file, store),
                say=lambda text: step(f"{file.stem}: {text}"),
            )
            if read_design(file, wanted.overrides).sources != before:
                raise DesignError(file, "--until", "was edited during the search: search again")
            _write(result, folder / "until.json", wanted.out)
            print(until_text(result), end="", flush=True)
            return result.exit_code

        codes = [
            guarded(lambda file=file, folder=folder: one(file, folder))  # type: ignore[misc]
            for file, folder in zip(files, folders, strict=True)
        ]
        return max(codes, default=0)

    return guarded(every)


def parts_of(until: str) -> tuple[str, ...]:
    """Return the parts that are judged; none for all of them. Raises DesignError.

    >>> parts_of("pass of bar_upper, bar_lower"), parts_of("pass")
    (('bar_upper', 'bar_lower'), ())
    """
    word, of, names = until.strip().partition(" of ")
    parts = tuple(name.strip() for name in names.split(",")) if of else ()
    if word.strip() != "pass" or not all(parts):
        raise DesignError(
            _HERE, "--until", f'must be pass, or such as "pass of bar_upper", got "{until}"'
        )
    return parts


def stored_check(
    file: Path, store: Store | None
) -> Callable[[tuple[str, ...], Effort], DesignResult]:
    """Return a check of a design with overrides that computes nothing twice."""
    from ballesta.pipeline import check_design

    def check(overrides: tuple[str, ...], effort: Effort) -> DesignResult:
        kept = recalled_result(store, file, overrides, effort)
        if kept is not None:
            return kept.result
        design = read_design(file, overrides)
        result = check_design(design, effort=effort, store=store)
        keep_result(store, design, effort, result, {})
        return result

    return check


def _write(result: UntilResult, path: Path, out: Path) -> None:
    text = json.dumps(plain(result.to_dict()), indent=1, allow_nan=False, ensure_ascii=False)
    with told_of_folder(out):
        write_whole(path, f"{text}\n".encode())
