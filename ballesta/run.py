"""Running checks for people: files out, progress, one bad file costing that file alone."""

import json
import os
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from math import inf, nan
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from checks.design.errors import DesignError, NumericsError
from geometry import progress as telling

if TYPE_CHECKING:
    from ballesta.unfinished import Keep
    from checks.design.effort import Effort
    from checks.result.verdict import DesignResult
    from checks.store.store import KeptResult, Store
    from reports.pictures import Pictures

Say = Callable[[str], None]

UNDECIDED, WRONG_INPUT, GAVE_UP = 1, 2, 3
_DONE = "done"  # name of what is kept of finished designs: exit codes and results


def check_all(
    designs: Sequence[Path],
    *,
    out: Path,
    as_json: bool = False,
    overrides: Sequence[str] = (),
    baseline: bool = False,
    fidelity: str = "auto",
    within: str | None = None,
    store: Path | None = None,
    fields: bool = False,
    pdf: bool = False,
    verbose: bool = False,
) -> int:
    """Check designs one after the other and write their results; returns the exit code.

    store    folder of what earlier checks have left; None for none
    fields   whether parts whose checks need no mesh get one, for the live view
    pdf      whether each report is printed, too, to report.pdf beside it
    verbose  all checks, warnings and assumptions instead of the answer in about twenty lines

    Verdicts go to standard output, progress and errors to standard error.
    """
    folders = output_folders(designs, out)
    codes: list[int] = []
    results: list[dict[str, Any]] = []
    done: tuple[list[int], list[dict[str, Any]]] | None = telling.recovered(_DONE)
    if done:
        codes, results = done
    opened: list[Store | None] = []
    browsers: list[str] = []
    wrong = guarded(lambda: opened.append(store_at(store)))
    if pdf and not wrong:
        wrong = guarded(lambda: browsers.append(_browser()))
    if wrong:
        return wrong
    ended = telling.ended()
    for path, folder in list(zip(designs, folders, strict=True))[len(codes) :]:

        def one(path: Path = path, folder: Path = folder, ended: str = ended) -> int:
            from checks.design.effort import effort_of

            effort = effort_of(fidelity, within, fields=fields)
            begun = perf_counter() - (0.0 if codes else telling.since_begun())
            if ended:
                recovered = _ended_to_folder(folder)
                if recovered is None:
                    print(f"ballesta: {path}: nothing was finished: {ended}", file=sys.stderr)
                    return UNDECIDED
                result = recovered
            else:
                telling.limit(effort.within, perf_counter() - begun)
                result = check_to_folder(
                    path,
                    folder,
                    overrides,
                    baseline=baseline,
                    effort=effort,
                    store=opened[0],
                    begun=begun,
                )
                telling.limit(None)
            if as_json:
                results.append(result.to_dict() | {"report": str(folder / "report.html")})
            else:
                print(_printed(result, folder / "report.html", verbose=verbose), flush=True)
            if browsers and not telling.stops():
                _print_pdf(path, folder, browsers[0])
            return result.exit_code

        codes.append(guarded(one))
        ended = ""
        telling.forget("")
        telling.keep(_DONE, (codes, results))
        if telling.stops():
            break
    if as_json:
        from reports.files import plain

        print(json.dumps(plain(results), indent=1, allow_nan=False))
    return max(codes, default=0)


def _browser() -> str:
    """Return the browser that prints; raises DesignError where there is none."""
    from reports.page import PrintError, find_browser

    try:
        return find_browser()
    except PrintError as error:
        raise DesignError(Path("--pdf"), "browser", str(error)) from error


def _print_pdf(path: Path, folder: Path, browser: str) -> None:
    """Print the report of a design; raises DesignError where the browser does not."""
    from reports.page import PrintError, print_pdf

    pdf = folder / "report.pdf"
    start = perf_counter()
    with progress(path) as say, told_of_folder(folder):
        say("printing the report")
        try:
            print_pdf(folder / "report.html", pdf, browser)
        except PrintError as error:
            raise DesignError(Path("--pdf"), "browser", str(error)) from error
        say(f"{pdf} printed in {perf_counter() - start:.1f} s")


def _printed(result: "DesignResult", report: Path, *, verbose: bool) -> str:
    if verbose:
        from reports.terminal import verdict_text

        return verdict_text(result, report=report)
    from reports.answer_facts import answer_text

    return answer_text(result, report=report)


def _ended_to_folder(folder: Path) -> "DesignResult | None":
    """Write the parts that an ended process had finished of a design, without pictures.

    None where nothing was.
    """
    from ballesta.unfinished import unfinished
    from reports.files import write_json
    from reports.page import write_report
    from reports.pictures import Pictures

    why = telling.ended()
    result = unfinished(telling.recovered, why)
    if result is None:
        return None
    with told_of_folder(folder):
        for left in folder.glob(".*.tmp"):  # of a file that was being written
            left.unlink(missing_ok=True)
        write_json(result, folder / "result.json")
        write_report(result, Pictures(reason=why), folder / "report.html")
    return result


def store_at(folder: Path | None) -> "Store | None":
    """Return the store in a folder; None without one. Raises DesignError for a wrong limit."""
    if folder is None:
        return None
    from checks.store.store import GIB, Store

    stated = os.environ.get("BALLESTA_STORE_LIMIT")
    if not stated:
        return Store(folder)
    try:
        limit = float(stated)
    except ValueError:
        limit = nan
    if not 0 < limit < inf:
        expected = f'must be a number of GiB above 0 such as "20", got "{stated}"'
        raise DesignError(Path("environment"), "BALLESTA_STORE_LIMIT", expected)
    return Store(folder, limit=int(limit * GIB))


def check_to_folder(
    path: Path,
    folder: Path,
    overrides: Sequence[str] = (),
    *,
    baseline: bool = False,
    effort: "Effort | None" = None,
    store: "Store | None" = None,
    begun: float | None = None,
) -> "DesignResult":
    """Check one design and write its folder: report.html, result.json, <part>.vtu.

    store  of stages and whole results (docs/store.md): an unchanged design is not checked again
    begun  when its time began, on the clock of `perf_counter`; None for now

    Raises DesignError (also for a folder that cannot be written) and NumericsError.
    """
    from checks.design.effort import DEFAULT_EFFORT
    from checks.store.store import keep_files, recalled_result
    from reports.live.section import has_fields, without_fields
    from reports.pictures import drawing, prepare_drawing

    effort = effort or DEFAULT_EFFORT
    kept = recalled_result(store, path, overrides, effort)
    if kept is not None and (kept.files or has_fields(kept.result)):
        result = without_fields(kept.result)
        with progress(path) as say, told_of_folder(folder):
            say("unchanged: taken from the store")
            if kept.files:
                write_kept(kept, folder)
            else:
                with drawing(kept.result.parts) as pictures:
                    files = write_folder(kept.result, pictures, folder, say)
                keep_files(store, path, overrides, effort, replace(kept, result=result), files)
            if baseline:
                _write_baseline(result, say)
        return result

    from ballesta.design.read import read_design

    start = perf_counter()
    design = read_design(path, overrides)
    reading = perf_counter() - start
    with told_of_folder(folder):
        folder.mkdir(parents=True, exist_ok=True)
    prepare_drawing(stress=effort.shows_stress)

    from ballesta.pipeline import check_with_cycles
    from ballesta.sweeps.improve import with_changes
    from checks.store.store import keep_result
    from reports.answer_facts import first_word
    from reports.live.section import with_encoded_fields

    with progress(path) as say:
        checked = check_with_cycles(
            design,
            effort=effort,
            say=say,
            reading=reading,
            store=store,
            live=True,
            begun=begun,
            keep=_kept() if telling.is_supervised() else None,
        )
        shown = checked.result
        if telling.is_supervised():  # what follows decides nothing, but takes seconds
            print(first_word(shown), file=sys.stderr, flush=True)
        with drawing(shown.parts) as pictures, told_of_folder(folder):
            if effort.within is None:  # a limit of time is for the checks
                say("seeking single changes by formula")
                shown = with_changes(design, shown, checked.cycles, checked.rubbing, say)
            say("encoding the fields of the live view")
            shown = with_encoded_fields(shown)
            result = without_fields(shown)
            files = write_folder(shown, pictures, folder, say)
            if baseline:
                _write_baseline(result, say)
        keep_result(store, design, effort, result if files else shown, files)
    return result


def _kept() -> "Keep":
    """Return what hands over what is finished, and has drawn what can be of it."""
    from ballesta.unfinished import PART
    from reports.pictures import draw_ahead

    def kept(name: str, value: Any) -> None:
        telling.keep(name, value)
        if name.startswith(PART) and not value.left:
            draw_ahead(value.result)

    return kept


def write_folder(
    result: "DesignResult", pictures: "Callable[[], Pictures]", folder: Path, say: Say
) -> dict[str, bytes]:
    """Write report.html, result.json and a .vtu per part; raises OSError.

    pictures  waits for stills

    Returns what was written, by name; nothing if pictures are missing that may be there next time.
    """
    from checks.stress.kept_models import report_seconds
    from reports.files import write_json, write_vtu
    from reports.page import write_report

    start = perf_counter()
    say("writing the report")
    if not all(part.surface.is_bare for part in result.parts):  # the rest takes a second
        telling.expect("pictures and page", report_seconds(len(result.parts)))
    names = [f"{part.name}.vtu" for part in result.parts]
    for part, name in zip(result.parts, names, strict=True):
        write_vtu(part, folder / name)
    write_json(result, folder / "result.json")
    write_report(result, pictures, folder / "report.html")
    say(f"report written in {perf_counter() - start:.1f} s")
    names += ["report.html", "result.json"]
    return {} if pictures().reason else {name: (folder / name).read_bytes() for name in names}


def write_kept(kept: "KeptResult", folder: Path) -> None:
    """Write the files of a result from the store; raises OSError."""
    from reports.files import replacing

    for name, content in kept.files.items():
        with replacing(folder / name) as temporary:
            temporary.write_bytes(content)


def _write_baseline(result: "DesignResult", say: Say) -> None:
    from ballesta.regression.file import write_baseline

    say(f"baseline written to {write_baseline(result)}")


@contextmanager
def told_of_folder(folder: Path, option: str = "--out") -> Iterator[None]:
    """Tell of an error which folder or file of an option cannot be written: DesignError."""
    try:
        yield
    except OSError as error:
        raise DesignError(folder, option, f"cannot be written: {error.strerror}") from error


def output_folders(designs: Sequence[Path], out: Path) -> list[Path]:
    """One folder per design, named after its file; designs of one name get their folder's too."""
    stems = [folder_name(path.stem) for path in designs]
    folders: list[Path] = []
    for path, stem in zip(designs, stems, strict=True):
        name = stem if stems.count(stem) == 1 else f"{path.resolve().parent.name}_{stem}"
        number, folder = 2, out / name
        while folder in folders:
            folder, number = out / f"{name}_{number}", number + 1
        folders.append(folder)
    return folders


def folder_name(stem: str) -> str:
    """Name of the folder of a file's results: inside of the output folder, and not hidden.

    >>> folder_name(".."), folder_name(".work"), folder_name("press")
    ('design', 'work', 'press')
    """
    return stem.lstrip(".") or "design"


def guarded(work: Callable[[], int | None]) -> int:
    """Run some work; turn the errors a person can act on into a line and an exit code."""
    try:
        return work() or 0
    except DesignError as error:
        print(f"ballesta: {error}", file=sys.stderr)
        return WRONG_INPUT
    except NumericsError as error:
        print(f"ballesta: {error}", file=sys.stderr)
        return GAVE_UP
    except BrokenPipeError:
        raise
    except Exception:  # a bug of ours must not cost the other designs of a run
        traceback.print_exc()
        print("ballesta: an internal error, not your design's fault", file=sys.stderr)
        return GAVE_UP


@contextmanager
def progress(path: Path) -> Iterator[Say]:
    """Yield a function that tells a step: to who supervises, or as a line with its time."""
    name, start = path.stem, perf_counter()

    def tell(text: str) -> None:
        if telling.is_supervised():
            telling.step(text, name)
        else:
            print(f"{name} {perf_counter() - start:6.1f} s  {text}", file=sys.stderr, flush=True)

    yield tell


def write_new(template: str, file: Path | None) -> int:
    """Print a template or write it to a file that does not exist yet; returns the exit code."""
    from ballesta.design.authoring import new_design, templates

    if not template:
        print("\n".join(name.replace("_", "-") for name in templates()))
        return 0

    def write() -> int:
        text = new_design(template.replace("-", "_"))
        if file is None:
            print(text, end="")
            return 0
        with told_of_folder(file, "--file"), file.open("x", encoding="utf-8") as stream:
            stream.write(text)
        print(f"{file} written; check it with: ballesta check {file}")
        return 0

    return guarded(write)
