"""Numbers that have left a baseline, by how much, and the likely cause."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from ballesta.regression.file import (
    ELASTIC_SHARE,
    LINKAGE,
    MASS,
    Baseline,
    Tolerance,
    band_of,
    largest_bar,
    mass_band,
    verdicts_of,
)

_ORDER = ("pass", "UNDECIDED", "FAIL")
_NOTHING = 1e-9  # of a limit: a smaller value is no load, and its changes are round-off
_MOST_ROWS = 40
_SHARED = {
    "loads": "the loads (linkage, cycles, friction or stated masses)",
    "code": "the code of ballesta",
    "libraries": "the libraries, Python or the processor",
}
_HEAD = ("quantity", "baseline", "now", "change", "band")


@dataclass(frozen=True)
class Departure:
    """A quantity that has left its baseline.

    change  relative to the baseline, None of what is no number
    band    as people read it
    """

    quantity: str
    before: float | str | None
    now: float | str | None
    change: float | None
    band: str

    @property
    def cells(self) -> tuple[str, str, str, str, str]:
        """The row of a table, as text."""
        before, now = _pair(self.before, self.now)
        change = "" if self.change is None else f"{100 * self.change:+.3g} %"
        return self.quantity, before, now, change, self.band


@dataclass(frozen=True)
class Comparison:
    """A record against a baseline.

    left      what has left its band, verdicts first, then the largest change
    bandless  (quantity, why) of numbers whose noise is not bounded: they cannot be watched
    causes    what the baseline's numbers were made from and these were not
    """

    left: Sequence[Departure]
    bandless: Sequence[tuple[str, str]]
    causes: Sequence[str]

    @property
    def holds(self) -> bool:
        """True if every number is as the baseline has it."""
        return not self.left and not self.bandless

    def text(self) -> str:
        """A table of what left, the likely cause, and what cannot be watched."""
        lines = table(self.left) if self.left else []
        if self.left:
            lines += ["", f"likely cause: {'; '.join(self.causes) or _NO_CAUSE}"]
        lines += [f"{quantity}: has no band: {why}" for quantity, why in self.bandless]
        return "\n".join(lines)


_NO_CAUSE = (
    "unknown: design, code and libraries are those of the baseline, so the numbers do not repeat "
    "or the baseline was edited"
)


def compare(baseline: Baseline, now: Mapping[str, Any]) -> Comparison:
    """Compare a record (`record_of`) with a baseline."""
    before, accuracy = baseline.record, float(now["accuracy"])
    rows: list[Departure] = []
    bandless: list[tuple[str, str]] = []
    turned: dict[tuple[str, str], str] | None = (
        {} if _same_design(before["stages"], now["stages"]) else None
    )
    for part in _names(before["parts"], now["parts"]):
        old, new = before["parts"].get(part), now["parts"].get(part)
        if old is None or new is None:
            rows.append(Departure(part, _presence(old), _presence(new), None, ""))
            continue
        band = mass_band(part, baseline.shares)
        rows += _moved(f"{part}: {MASS}", old[MASS], new[MASS], band, 0.0)
        for key, was, found in _checks(old["checks"], new["checks"]):
            rows += _left(part, key, was, found, accuracy, baseline.shares, bandless, turned)
    for key, was, found in _checks(before[LINKAGE], now[LINKAGE]):
        rows += _left(LINKAGE, key, was, found, accuracy, baseline.shares, bandless, turned)
    rows = [*_design_verdict(before, now, turned or {}), *rows]
    rows.sort(key=lambda row: -(inf if row.change is None else abs(row.change)))
    return Comparison(rows, bandless, causes(before["stages"], now["stages"]))


def _names(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    return list(dict.fromkeys([*before, *now]))


def _presence(thing: object) -> str:
    return "absent" if thing is None else "present"


Found = Mapping[str, Any]


def _checks(
    before: Mapping[str, Found], now: Mapping[str, Found]
) -> Iterator[tuple[str, Found | None, Found | None]]:
    for key in _names(before, now):
        yield key, before.get(key), now.get(key)


def _left(
    part: str,
    key: str,
    was: Found | None,
    found: Found | None,
    accuracy: float,
    stated: Mapping[str, float],
    bandless: list[tuple[str, str]],
    turned: dict[tuple[str, str], str] | None,
) -> Iterator[Departure]:
    """Rows of a check: its value, safety, verdict and rung, as far as they left.

    bandless  what has no band; added to
    turned    verdicts so far that another mesh turned; added to. None for a design that was
              edited: its verdicts are the edit's
    """
    name = f"{part}: {key}"
    if was is None or found is None:
        yield Departure(name, _presence(was), _presence(found), None, "")
        return
    band = band_of(part, key, found, accuracy, stated)
    if was["status"] != found["status"]:
        kind = key.partition(":")[0]
        if turned is not None and is_mesh_noise(was["status"], found, kind, accuracy, band):
            turned[part, key] = was["status"]
        else:
            yield Departure(f"{name}, verdict", was["status"], found["status"], None, "")
    if was["rung"] != found["rung"] or was["unit"] != found["unit"]:
        before, now = (f"{c['rung']} {c['unit']}".strip() for c in (was, found))
        yield Departure(f"{name}, rung and unit", before, now, None, "")
        return
    if band.width is None:
        bandless.append((name, band.why))
        return
    limit = (found["safety"] or 0.0) * found["value"]
    unit = f" [{found['unit']}]" if found["unit"] else ""
    yield from _moved(f"{name}{unit}", was["value"], found["value"], band, _NOTHING * limit)
    yield from _safety_moved(name, was, found, band)


def _safety_moved(name: str, was: Found, found: Found, band: Tolerance) -> Iterator[Departure]:
    """The row of a safety that left its band; a part without load has none."""
    name += ", buckling factor" if name.endswith(ELASTIC_SHARE) else ", safety"
    before, now = was["safety"], found["safety"]
    uses = [0.0 if safety is None else 1 / safety for safety in (before, now)]
    if abs(uses[1] - uses[0]) <= _NOTHING:
        return
    if before is None or now is None:
        yield Departure(name, before, now, None, band.text)
    else:
        yield from _moved(name, before, now, band, 0.0)


def _moved(
    name: str, before: float, now: float, band: Tolerance, nothing: float
) -> Iterator[Departure]:
    """The departure of a number that left its band by more than what counts as nothing."""
    assert band.width is not None
    # half a unit of the tenth digit, to which a baseline is written, is no change
    if abs(now - before) > max((band.width + 5e-10) * abs(before), nothing):
        change = (now - before) / before if before else inf
        yield Departure(name, before, now, change, band.text)


def _design_verdict(
    before: Mapping[str, Any], now: Mapping[str, Any], turned: Mapping[tuple[str, str], str]
) -> Iterator[Departure]:
    """The row of the design's verdict, unless another mesh turned it with a check's."""
    verdicts = verdicts_of(now)
    by_checks = worst(verdicts.values()) == now["status"]
    as_before = worst({**verdicts, **turned}.values()) == before["status"]
    if before["status"] != now["status"] and not (turned and by_checks and as_before):
        yield Departure("the design, verdict", before["status"], now["status"], None, "")


def _same_design(before: Mapping[str, str], now: Mapping[str, str]) -> bool:
    """True if two records are of one design, be it by other code or libraries."""
    stages = (set(before) | set(now)) - {"code", "libraries"}
    return all(before.get(stage) == now.get(stage) for stage in stages)


def causes(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Differences between the inputs of two records, the design's own first."""
    changed = [stage for stage in _names(before, now) if before.get(stage) != now.get(stage)]
    of_parts: dict[str, list[str]] = {}
    for stage in changed:
        part, colon, what = stage.rpartition(": ")
        if colon:
            of_parts.setdefault(what, []).append(part)
    n_parts = len({stage.rpartition(": ")[0] for stage in now if ": " in stage})
    found = [_SHARED["loads"]] if "loads" in changed else []
    for what, parts in of_parts.items():
        whose = "all parts" if 1 < n_parts == len(parts) else ", ".join(parts)
        found.append(f"the {what} of {whose}")
    return [*found, *(_SHARED[stage] for stage in ("code", "libraries") if stage in changed)]


def table(rows: Sequence[Departure]) -> list[str]:
    """Lines of a table of what left."""
    cells = [_HEAD, *(row.cells for row in rows[:_MOST_ROWS])]
    widths = [max(len(line[column]) for line in cells) for column in range(len(_HEAD))]
    lines = [
        "  ".join(
            text.ljust(width) if column == 0 else text.rjust(width)
            for column, (text, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in cells
    ]
    more = len(rows) - _MOST_ROWS
    return [*lines, f"and {more} more"] if more > 0 else lines


def _pair(before: float | str | None, now: float | str | None) -> tuple[str, str]:
    """Two values with digits enough to tell them apart."""
    for digits in (5, 8, 12):
        texts = _shown(before, digits), _shown(now, digits)
        if texts[0] != texts[1]:
            break
    return texts


def _shown(value: float | str | None, digits: int) -> str:
    if value is None:
        return "none"
    return value if isinstance(value, str) else f"{value:.{digits}g}"


def is_mesh_noise(
    before: str, now: Mapping[str, Any], kind: str, accuracy: float, band: Tolerance
) -> bool:
    """True if a verdict would be as before with a number that re-meshing gives as well.

    before  the verdict so far
    now     the check as a record has it, with its bars

    That is a value within the band, and a numerical bar from nothing to the largest that a band
    holds for; bars of the model, limit and required safety are taken as they are now. A verdict now
    that its own numbers do not give is no noise.
    """
    largest = largest_bar(str(now["rung"]), kind, accuracy)
    if largest is None or band.width is None or now["numerical"] is None:
        return False
    low, high = (now["value"] * (1 + sign * band.width) for sign in (-1, 1))
    bar, limit, required = largest * high, now["limit"], now["required"]
    above, below = _model_bars(now)
    if now["status"] != _verdict(now):
        return False
    if before == "pass":
        return bool((low + above) * required <= limit)
    if before == "FAIL":
        return bool((high - below) * required > limit)
    return bool((high + bar + above) * required > limit and (low - bar - below) * required <= limit)


def _verdict(check: Mapping[str, Any]) -> str:
    """The verdict that the numbers of a check give, as `Check.status` has it."""
    bar, (above, below) = check["numerical"] * check["value"], _model_bars(check)
    if (check["value"] + bar + above) * check["required"] <= check["limit"]:
        return "pass"
    failed = (check["value"] - bar - below) * check["required"] > check["limit"]
    return "FAIL" if failed else "UNDECIDED"


def _model_bars(check: Mapping[str, Any]) -> tuple[float, float]:
    above, below = (inf if check[name] is None else check[name] for name in ("above", "below"))
    return above, below


def worst(verdicts: Iterable[str]) -> str:
    """The worst of some verdicts, pass of none."""
    return max(verdicts, key=_ORDER.index, default=_ORDER[0])
