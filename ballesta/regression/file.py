"""Baseline files: `NAME.baseline.json` beside the design `NAME.toml`, small and readable.

Bands tell how far a number may move before its test fails, by its repeatability.
"""

import json
import os
import signal
import site
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import inf, isfinite
from pathlib import Path
from typing import Any

from checks.design.errors import DesignError, NumericsError, no_such
from checks.result.verdict import DesignResult

KINDS = ("static", "fatigue", "buckling")  # of checks that the rungs of the ladder decide
MASS = "mass [kg]"
LINKAGE = "linkage"
LADDER = ("formula", "solid")
# The one buckling check that is a rung's, as `checks.columns.stability.ELASTIC_SHARE` has it (a
# test compares them): its import would bring the solvers into every run of pytest.
ELASTIC_SHARE = "elastic load share"
_DIGEST_DIGITS = 12  # hex digits of a digest that a reader can still compare by eye
ROUND_OFF = 1e-6  # another processor's arithmetic; the same one repeats to 1e-9
LARGEST = 0.04  # a peak stress that changes by 5 % must always be seen
MARGIN = 1.5  # band over the worst scatter of re-meshed parts
MASS_KIND = "mass"
NOISE = Path(__file__).with_name("noise.json")
_MESHED = "solid"
_REFINED = ("static", "fatigue")  # kinds that a solid's meshes are refined for
_BOUNDED = 1.5  # times the accuracy: what meshes leave, and what the bearing series cuts off


@dataclass(frozen=True)
class Tolerance:
    """Share of a baseline's number by which it may move; None where none is known, then why."""

    width: float | None
    why: str = ""

    @property
    def text(self) -> str:
        """The band as a table shows it."""
        return "none" if self.width is None else f"±{percent(self.width)}"


def percent(share: float) -> str:
    """Return a share as people read it.

    >>> percent(1e-6), percent(0.0125)
    ('0.0001 %', '1.25 %')
    """
    text = f"{100 * share:.3g}"
    return f"{float(text):f}".rstrip("0").rstrip(".") + " %" if "e" in text else f"{text} %"


def mass_band(part: str, stated: Mapping[str, float]) -> Tolerance:
    """The band of a part's mass: round-off, for the CAD kernel weighs it."""
    return Tolerance(_stated(part, MASS_KIND, stated) or ROUND_OFF)


def band_of(
    part: str, key: str, check: Mapping[str, Any], accuracy: float, stated: Mapping[str, float]
) -> Tolerance:
    """The band of a check of a part.

    key, check  as a baseline has them ("static: peak von Mises stress")
    accuracy    numerical error, as a share, that the design asks its meshes for
    stated      bands that the baseline file states, by kind or by part and kind
    """
    kind, rung = key.partition(":")[0], str(check["rung"])
    own = _stated(part, kind, stated)
    if own is not None:
        return Tolerance(own)
    if rung != _MESHED:
        return Tolerance(ROUND_OFF)
    bar = check.get("numerical", 0.0)
    if not is_bounded(rung, kind, bar, accuracy):
        known = "is not known" if bar is None else f"is {percent(bar)}"
        return Tolerance(
            None,
            f"the numerical error {known}, where {percent(accuracy)} is asked for: its "
            f"noise is not bounded; raise mesh.most_unknowns{_or_state(part, kind)}",
        )
    return _measured_band(part, rung, kind, accuracy)


def largest_bar(rung: str, kind: str, accuracy: float) -> float | None:
    """The largest numerical bar, as a share, that re-mesh noise is measured for.

    None where nothing is refined: then the bar is the same on every mesh.
    """
    if rung != _MESHED or kind not in _REFINED:
        return None
    return _BOUNDED * accuracy


def is_bounded(rung: str, kind: str, numerical: float | None, accuracy: float) -> bool:
    """True if re-mesh noise is measured for a numerical error bar, given as a share."""
    largest = largest_bar(rung, kind, accuracy)
    return largest is None or (numerical is not None and numerical <= largest)


def _measured_band(part: str, rung: str, kind: str, accuracy: float) -> Tolerance:
    """Band of measured re-mesh noise; a finer accuracy's band counts for a coarser one."""
    known = sorted(
        (entry["accuracy"], band_width(entry["worst"]))
        for entry in _noise()
        if entry["rung"] == rung and entry["kind"] == kind
    )
    covering = next((measured for measured, _ in known if measured >= accuracy), None)
    width = max((width for measured, width in known if measured <= (covering or 0)), default=inf)
    if covering is not None and width <= LARGEST:
        return Tolerance(width)
    quiet = [measured for measured, width in known if width <= LARGEST]
    if covering is not None:
        said = f"re-meshing moves it by more than {percent(LARGEST)} at this accuracy"
    else:
        said = f"the re-mesh noise of {kind} by the {rung} is not measured at {percent(accuracy)}"
    cure = f'set accuracy = "{percent(max(quiet))}" or finer' if quiet else "pin another rung"
    return Tolerance(None, f"{said}: {cure}{_or_state(part, kind)}")


def band_width(worst: float) -> float:
    """The band for a worst scatter of re-meshed parts, as shares."""
    return max(MARGIN * worst, 10 * ROUND_OFF)


def _or_state(part: str, kind: str) -> str:
    return f', or state bands = {{"{part}: {kind}": "2 %"}} in the baseline'


@cache
def _noise() -> list[dict[str, Any]]:
    """Worst scatter by rung, kind and accuracy, as `python -m bench.remesh_noise` measured it."""
    return list(json.loads(NOISE.read_text(encoding="utf-8"))["worst"])


def _stated(part: str, kind: str, stated: Mapping[str, float]) -> float | None:
    return stated.get(f"{part}: {kind}", stated.get(kind))


def parse_bands(stated: object, parts: Mapping[str, Iterable[str]]) -> dict[str, float]:
    """Return the bands that a baseline file states, as shares.

    stated  {"static": "2 %", "bar_upper: fatigue": 0.01, "mass": 1e-4}
    parts   part -> the kinds of its checks

    Raises ValueError with what was found and what was expected.
    """
    if not isinstance(stated, Mapping):
        raise ValueError(f'bands: must be a table such as {{"static": "2 %"}}, got {stated!r}')
    kinds = {kind: [*found, MASS_KIND] for kind, found in parts.items()}
    known = {kind: None for found in kinds.values() for kind in found}
    known |= {f"{part}: {kind}": None for part, found in kinds.items() for kind in found}
    bands = {}
    for key, value in stated.items():
        if key not in known:
            raise ValueError(f"bands: {no_such('kind of check', str(key), known)}")
        bands[str(key)] = _stated_share(str(key), value)
    return bands


def _stated_share(key: str, value: object) -> float:
    number: object = value
    if isinstance(value, str) and value.strip().endswith("%"):
        try:
            number = float(value.strip()[:-1]) / 100
        except ValueError:
            number = None
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise ValueError(f'bands.{key}: must be a share such as "2 %" or 0.02, got {value!r}')
    if not isfinite(number) or not 0 < number < 1:
        raise ValueError(f"bands.{key}: must be above 0 % and below 100 %, got {value!r}")
    return float(number)


def record_of(
    result: Mapping[str, Any], stages: Mapping[str, str], accuracy: float
) -> dict[str, Any]:
    """The numbers of a result, as plain data (`DesignResult.to_dict`), that a baseline keeps.

    stages    digest of what the result was made from, by stage (`fingerprints.stages_of`)
    accuracy  numerical error, as a share, that the design asks its meshes for
    """
    return {
        "design": result["name"],
        "status": result["status"],
        "accuracy": accuracy,
        "parts": {
            part["name"]: {
                MASS: part["facts"][MASS],
                "rungs": rungs_of(part),
                "checks": _checks(part["checks"]),
            }
            for part in result["parts"]
        },
        LINKAGE: _checks(result[LINKAGE]),
        "stages": {stage: digest[:_DIGEST_DIGITS] for stage, digest in stages.items()},
    }


def rungs_of(part: Mapping[str, Any]) -> dict[str, str]:
    """The rung that decided each kind of check of a part.

    Where a solid was solved, kinds without an answer are the solid's: it was asked for them.
    """
    rungs = {
        check["kind"]: _rung(check)
        for check in part["checks"]
        if check["kind"] in KINDS
        and _rung(check) in LADDER
        and (check["kind"] != "buckling" or check["quantity"] == ELASTIC_SHARE)
    }
    if any(tried["rung"] == "solid" and tried["unknowns"] for tried in part["rungs"]):
        rungs = {kind: rungs.get(kind, "solid") for kind in KINDS}
    return rungs


def has_new_solid(
    rungs: Mapping[str, Mapping[str, str]], found: Mapping[str, Mapping[str, str]]
) -> bool:
    """True if a solid decided a kind that was not pinned to it: pinned, it is refined otherwise."""
    return any(
        "solid" in kinds.values() and dict(rungs.get(part, {})) != dict(kinds)
        for part, kinds in found.items()
    )


def _checks(checks: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Checks by kind and quantity; equal names are numbered, so that none is lost."""
    kept: dict[str, dict[str, Any]] = {}
    for check in checks:
        name = key = f"{check['kind']}: {check['quantity']}"
        number = 1
        while key in kept:
            number += 1
            key = f"{name} ({number})"
        kept[key] = {
            "value": check["value"],
            "unit": check["unit"],
            "safety": check["safety"],
            "status": check["status"],
            "rung": _rung(check),
            "numerical": _share(check),
            "above": check["model"],
            "below": check["model_below"],
            "limit": check["limit"],
            "required": check["required"],
        }
    return kept


def _rung(check: Mapping[str, Any]) -> str:
    """The rung of a check's method, such as "solid (two meshes)"."""
    return str(check["method"]).split(maxsplit=1)[0]


def verdicts_of(record: Mapping[str, Any]) -> dict[tuple[str, str], str]:
    """The verdict of every check of a record, by part and check."""
    named = {name: part["checks"] for name, part in record["parts"].items()}
    return {
        (name, key): check["status"]
        for name, checks in (named | {LINKAGE: record[LINKAGE]}).items()
        for key, check in checks.items()
    }


def _share(check: Mapping[str, Any]) -> float | None:
    """Numerical error bar over the value, None where it is not known."""
    if check["numerical"] is None:
        return None
    return float(check["numerical"] / check["value"]) if check["value"] else 0.0


FORMAT = "ballesta-baseline/2"
SUFFIX = ".baseline.json"
_DIGITS = 10  # numbers repeat to 1e-9


class BaselineError(Exception):
    """A baseline file that cannot be used, in the user's words."""


@dataclass(frozen=True)
class Baseline:
    """A baseline as it stands in its file.

    record  as `record_of` makes it, without accuracy and error bars
    bands   as the file states them; `shares` the same as shares
    """

    record: Mapping[str, Any]
    bands: Mapping[str, Any]
    shares: Mapping[str, float]

    @property
    def rungs(self) -> dict[str, dict[str, str]]:
        """Part -> kind of check -> the rung that decides it."""
        return {name: dict(part["rungs"]) for name, part in self.record["parts"].items()}


def baseline_path(design_file: str | Path) -> Path:
    """Path of a design's baseline, beside the design."""
    path = Path(design_file)
    return path.with_name(path.stem + SUFFIX)


def design_path(baseline_file: Path) -> Path:
    """The design that a baseline is of."""
    return baseline_file.with_name(baseline_file.name.removesuffix(SUFFIX) + ".toml")


def read_baseline(path: Path) -> Baseline:
    """Read a baseline; raises BaselineError."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"), parse_constant=_no_constant)
    except OSError as error:
        raise BaselineError(f"{path.name}: cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise BaselineError(f"{path.name}: is no JSON text in UTF-8: {error}") from error
    try:
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            found = data.get("format") if isinstance(data, dict) else data
            raise ValueError(f"format: must be {FORMAT!r}, got {found!r}; delete it and write anew")
        _check_record(data)
        kinds = {name: _kinds(part["checks"]) for name, part in data["parts"].items()}
        bands = data.get("bands", {})
        shares = parse_bands(bands, kinds | {LINKAGE: _kinds(data[LINKAGE])})
    except ValueError as error:
        raise BaselineError(f"{path.name}: {error}") from error
    return Baseline(data, bands, shares)


def write_record(path: Path, record: Mapping[str, Any], bands: Mapping[str, Any]) -> None:
    """Write a baseline, whole or not at all; raises OSError."""
    text = baseline_text(record, bands)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".tmp")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def baseline_text(record: Mapping[str, Any], bands: Mapping[str, Any]) -> str:
    """The text of a baseline file: a check a line."""
    parts = {
        name: {
            MASS: _rounded(part[MASS]),
            "rungs": _Line(part["rungs"]),
            "checks": {key: _line(check) for key, check in part["checks"].items()},
        }
        for name, part in record["parts"].items()
    }
    data = {
        "format": FORMAT,
        "design": record["design"],
        "status": record["status"],
        "bands": _Line(bands),
        "parts": parts,
        LINKAGE: {key: _line(check) for key, check in record[LINKAGE].items()},
        "stages": record["stages"],
    }
    return _text(data) + "\n"


class _Line(dict[str, Any]):
    """A table that is written on one line."""


def _line(check: Mapping[str, Any]) -> _Line:
    return _Line(
        {
            "value": _rounded(check["value"]),
            "unit": check["unit"],
            "safety": _rounded(check["safety"]),
            "status": check["status"],
            "rung": check["rung"],
        }
    )


def _rounded(number: float | None) -> float | None:
    return None if number is None else float(f"{number:.{_DIGITS}g}")


def _text(data: Any, indent: int = 0) -> str:
    if not isinstance(data, Mapping) or isinstance(data, _Line) or not data:
        return json.dumps(data, ensure_ascii=False, allow_nan=False)
    pad = " " * (indent + 1)
    lines = ",\n".join(
        f"{pad}{json.dumps(key, ensure_ascii=False)}: {_text(value, indent + 1)}"
        for key, value in data.items()
    )
    return "{\n" + lines + "\n" + " " * indent + "}"


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


def _kinds(checks: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(key.partition(":")[0] for key in checks))


def _check_record(data: Mapping[str, Any]) -> None:
    """Raise ValueError unless the data have all keys that a comparison reads."""
    _table(data, "parts")
    _text_of(data, "status", "")
    for stage, digest in _table(data, "stages").items():
        if not isinstance(digest, str):
            raise ValueError(f"stages.{stage}: must be a text, got {digest!r}")
    for name in data["parts"]:
        part, where = _table(data["parts"], name, "parts."), f"parts.{name}."
        if not _is_number(part.get(MASS)):
            raise ValueError(f"{where}{MASS}: must be a number, got {part.get(MASS)!r}")
        for kind, rung in _table(part, "rungs", where).items():
            if kind not in KINDS:
                raise ValueError(f"{where}rungs: {no_such('kind of check', kind, KINDS)}")
            if rung not in LADDER:
                raise ValueError(f"{where}rungs.{kind}: {no_such('rung', str(rung), LADDER)}")
        _check_checks(_table(part, "checks", where), f"{where}checks.")
    _check_checks(_table(data, LINKAGE), f"{LINKAGE}.")


def _check_checks(checks: Mapping[str, Any], where: str) -> None:
    for key in checks:
        check, here = _table(checks, key, where), f"{where}{key}."
        if not _is_number(check.get("value")):
            raise ValueError(f"{here}value: must be a number, got {check.get('value')!r}")
        if "safety" not in check:
            raise ValueError(f"{here}safety: is missing; it must be a number or null")
        if check["safety"] is not None and not _is_number(check["safety"]):
            raise ValueError(f"{here}safety: must be a number or null, got {check['safety']!r}")
        for name in ("unit", "status", "rung"):
            _text_of(check, name, here)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)


def _table(data: Mapping[str, Any], key: str, where: str = "") -> Mapping[str, Any]:
    if not isinstance(data.get(key), Mapping):
        raise ValueError(f"{where}{key}: must be a table, got {data.get(key)!r}")
    table: Mapping[str, Any] = data[key]
    return table


def _text_of(data: Mapping[str, Any], key: str, where: str) -> None:
    if not isinstance(data.get(key), str):
        raise ValueError(f"{where}{key}: must be a text, got {data.get(key)!r}")


# Writes the baseline of a design. Its check runs in a process of its own, so that the user's
# modules and ours never meet.
WORKER = Path(__file__).resolve().with_name("worker.py")
_LAST_LINES = 15
_OPTION = "--write-baseline"


class CheckError(Exception):
    """A check that came to no numbers; `exit_code` is the tool's, None where it died."""

    def __init__(self, exit_code: int | None, words: str) -> None:
        super().__init__(exit_code, words)
        self.exit_code, self.words = exit_code, words

    def __str__(self) -> str:
        return self.words


def write_baseline(result: DesignResult) -> Path:
    """Write the baseline beside the design, whole or not at all; returns its path.

    The rungs are those that decided the result; the numbers are measured as a test will measure
    them, in a process of its own with one thread. Bands that a baseline states are kept.

    Raises DesignError and NumericsError as the check does, OSError where it cannot be written.
    """
    path = baseline_path(result.file)
    if result.overrides:
        said = (
            f"keeps the numbers of the file as it stands; leave out {', '.join(result.overrides)}"
        )
        raise DesignError(path, _OPTION, said)
    try:
        bands = read_baseline(path).bands if path.exists() else {}
    except BaselineError as error:
        raise DesignError(path, _OPTION, f"{error}; mend or delete it") from error
    rungs = {part["name"]: rungs_of(part) for part in result.to_dict()["parts"]}
    try:
        record = measure(Path(result.file), rungs=rungs)
    except CheckError as error:
        if error.exit_code == 2:  # the file was changed meanwhile
            raise DesignError(path, _OPTION, str(error)) from error
        raise NumericsError(str(error), f"{path}: {_OPTION}", "try a coarser fidelity") from error
    write_record(path, record, bands)
    return path


def measure(
    design: Path,
    *,
    fidelity: str = "auto",
    rungs: Mapping[str, Mapping[str, str]] | None = None,
    timeout: float | None = None,
) -> dict[str, Any]:
    """Check a design in an isolated process, of one thread; returns its record (`record_of`).

    fidelity  of parts whose rungs are not pinned
    rungs     part -> kind of check -> the rung that decides it
    timeout   s

    Raises CheckError with the tool's own words.
    """
    command = [sys.executable, *_isolation(), str(WORKER), design.name, "--fidelity", fidelity]
    process = subprocess.Popen(
        command,
        cwd=design.resolve().parent,  # so that no digest or message has a path of this machine
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        errors="replace",
    )
    try:
        answer, said = process.communicate(json.dumps(rungs or {}), timeout)
    except subprocess.TimeoutExpired as error:
        process.kill()
        _, said = process.communicate()
        raise CheckError(
            None, f"the check took longer than {timeout:g} s (ballesta_timeout){_last(said)}"
        ) from error
    finally:  # whatever stopped us, such as a time limit of another plugin
        if process.poll() is None:
            process.kill()
            process.wait()
    return _record(process.returncode, answer, said)


def _record(code: int, answer: str, said: str) -> dict[str, Any]:
    if code < 0:
        raise CheckError(None, f"the check was killed by {_signal(-code)}{_last(said)}")
    try:
        found = json.loads(answer)
    except ValueError as error:
        raise CheckError(None, f"the check died with exit code {code}{_last(said)}") from error
    if "error" in found:
        raise CheckError(found["exit_code"], found["error"])
    record: dict[str, Any] = found["record"]
    return record


def _isolation() -> list[str]:
    """Options of Python that shut the user's modules out, but for the site that holds us."""
    here = site.getusersitepackages()
    return ["-E", "-P"] if WORKER.is_relative_to(Path(here).resolve()) else ["-I"]


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _last(said: str) -> str:
    lines = said.strip().splitlines()[-_LAST_LINES:]
    return "\n".join(["; it said last:", *lines]) if lines else ", and said nothing"
