"""pytest plugin: every design with a baseline beside it is a test.

It runs inside the user's tests, so it imports nothing of ours that imports `loads`, `reports`,
`fem`, `fatigue` or `geometry`: the user's own modules of these names would be taken for ours.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ballesta.regression.compare import Comparison, compare
from ballesta.regression.file import (
    SUFFIX,
    Baseline,
    BaselineError,
    CheckError,
    baseline_path,
    design_path,
    measure,
    read_baseline,
    write_record,
)

_TIMEOUT = "1800"
_UPDATE = "--update-baselines"
_DESIGN = re.compile(r"^\s*\[{1,2}\s*[\"']?parts[\"']?\s*[.\]]", re.MULTILINE)
_LIKE = re.compile(r"^\s*like\s*=", re.MULTILINE)


class BaselineFailure(Exception):
    """A design that is not as its baseline has it, in words; needs no traceback."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add what can be said of baselines."""
    group = parser.getgroup("ballesta", "baselines of machine designs (ballesta)")
    group.addoption(
        _UPDATE,
        action="store_true",
        dest="update_baselines",
        help="write NAME.baseline.json of every design collected, also where there is none yet; "
        "the tests still fail, so that each is reviewed and committed",
    )
    group.addoption(
        "--baseline-fidelity",
        metavar="RUNG",
        default=None,
        choices=("auto", "formula", "solid"),
        help="with --update-baselines: choose the rungs anew; else those of the baseline stay, "
        "and auto chooses for what has none",
    )
    parser.addini("ballesta_timeout", "time limit of a design's check, s", default=_TIMEOUT)


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker, and refuse options that mean nothing."""
    config.addinivalue_line("markers", "ballesta: a machine design compared with its baseline")
    if config.getoption("baseline_fidelity") and not config.getoption("update_baselines"):
        raise pytest.UsageError(f"--baseline-fidelity needs {_UPDATE}: a baseline pins its rungs")
    _timeout(config)


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> "BaselineFile | None":
    """Collect a baseline, or a design that is named or is to get its first baseline."""
    is_test = _is_baseline(file_path) or _is_wanted(file_path, parent)
    return BaselineFile.from_parent(parent, path=file_path) if is_test else None


def _is_baseline(path: Path) -> bool:
    """True for a baseline of ours, also where it is broken or its design is gone."""
    if not path.name.endswith(SUFFIX):
        return False
    return _is_design(design_path(path)) or "ballesta-baseline" in _start(path)


def _is_wanted(path: Path, parent: pytest.Collector) -> bool:
    """True for a design that is named, or that is to get its first baseline."""
    if path.suffix != ".toml":
        return False
    updates = parent.config.getoption("update_baselines")
    named = parent.session.isinitpath(path)
    return (named or (updates and not baseline_path(path).exists())) and _is_design(path)


def _start(path: Path) -> str:
    """The first lines of a file, as far as they can be read."""
    try:
        with path.open(encoding="utf-8", errors="replace") as stream:
            return stream.read(500)
    except OSError:
        return ""


def _is_design(path: Path) -> bool:
    """True if a TOML file looks like a design, read as text: it may be broken."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return bool(_DESIGN.search(text) or _LIKE.search(text.partition("\n[")[0]))


class BaselineFile(pytest.File):
    """A design or its baseline, named by either file."""

    def collect(self) -> Iterator["DesignItem"]:
        """The one test of a design: all of its parts are checked in one go."""
        of_baseline = self.path.name.endswith(SUFFIX)
        design = design_path(self.path) if of_baseline else self.path
        yield DesignItem.from_parent(self, name=design.stem, design=design)


class DesignItem(pytest.Item):
    """A design against its baseline."""

    def __init__(self, *, design: Path, **others: object) -> None:
        super().__init__(**others)  # type: ignore[arg-type]
        self.design, self.baseline = design, baseline_path(design)
        self.add_marker("ballesta")

    def runtest(self) -> None:
        """Check the design and compare; raises BaselineFailure."""
        if not self.design.is_file():
            raise BaselineFailure(f"{self.baseline.name} is the baseline of no design: there is no "
                                  f"{self.design.name} beside it")  # fmt: skip
        if self.config.getoption("update_baselines"):
            self._update()
        if not self.baseline.is_file():
            raise BaselineFailure(
                f"{self.design.name} has no baseline; {_UPDATE} writes {self.baseline.name}"
            )
        baseline = read_baseline(self.baseline)
        now = measure(self.design, rungs=baseline.rungs, timeout=_timeout(self.config))
        found = compare(baseline, now)
        if not found.holds:
            raise BaselineFailure(self._left(found))

    def _left(self, found: Comparison) -> str:
        said = f"{self.name} has left its baseline" if found.left else f"{self.name}: no band"
        return "\n".join(
            [
                f"{said} ({self.baseline.name})",
                "",
                found.text(),
                "",
                f"if the change is meant: pytest {self.nodeid} {_UPDATE}, review, commit",
            ]
        )

    def _update(self) -> None:
        """Write the baseline and fail, saying what there is to review."""
        before = self._before()
        fidelity = self.config.getoption("baseline_fidelity")
        rungs = {} if fidelity or before is None else before.rungs
        now = measure(
            self.design, fidelity=fidelity or "auto", rungs=rungs, timeout=_timeout(self.config)
        )
        bands = {} if before is None else before.bands
        try:
            write_record(self.baseline, now, bands)
        except OSError as error:
            raise BaselineFailure(
                f"{self.baseline.name}: cannot be written: {error.strerror}"
            ) from error
        try:
            written = read_baseline(self.baseline)
        except BaselineError as error:
            raise BaselineFailure(f"{self.baseline.name} was written, but: {error}") from error
        raise BaselineFailure(
            _to_review(self.baseline.name, before or written, now, before is None)
        )

    def _before(self) -> Baseline | None:
        """The baseline so far; one that cannot be read may state bands, so it is not replaced."""
        return read_baseline(self.baseline) if self.baseline.exists() else None

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Message of an error in the input; a traceback of any other."""
        error = excinfo.value
        if isinstance(error, CheckError) and error.exit_code is not None:
            return f"{self.name} could not be checked (exit code {error.exit_code}):\n{error}"
        if isinstance(error, BaselineFailure | BaselineError | CheckError):
            return str(error)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where the test stands: pytest shows its last item as the test's title."""
        return self.path, None, f"design {self.name}"


def _to_review(name: str, before: Baseline, now: dict[str, object], is_new: bool) -> str:
    """Message on a written baseline: what to review in it."""
    found = compare(before, now)
    end = f"review {name} and commit it; run without {_UPDATE} after that"
    if is_new:
        watch = [f"{quantity}: has no band: {why}" for quantity, why in found.bandless]
        return "\n".join([f"{name} is new: {end}", *watch])
    if found.holds:
        return f"{name} was written again, and no number left its band: {end}"
    return "\n".join([f"{name} was written again: {end}", "", found.text()])


def _timeout(config: pytest.Config) -> float:
    text = config.getini("ballesta_timeout")
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not seconds > 0:
        raise pytest.UsageError(f"ballesta_timeout: must be above 0 s, got {text!r}")
    return seconds
