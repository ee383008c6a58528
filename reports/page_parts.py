"""Data of the report's templates: checks as rows, parts, cycles, what to know first."""

import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite

from markupsafe import Markup

from checks.result.derivation import HandComparison
from checks.result.verdict import Check, DesignResult, PartResult, Status, deciding_of
from checks.result.words import brief, check_titles, number, utilisation_text
from reports.answer_facts import Answer, Fact, PartRow
from reports.charts import Charts, DesignCharts
from reports.gauge import gauge
from reports.live.section import estimate_of
from reports.page_words import Place, capitalise, doubt_of, place_of, shown_of
from reports.pictures import Pictures, stress_field
from reports.plain_still import ESTIMATE, PLAIN

ORDER = (Status.FAIL, Status.UNDECIDED, Status.PASS)  # worst first
_ALIKE = 0.01  # of a value: parts that differ by more are told one by one
_SAME = ("mass [kg]", "inertia about the centre [kg m2]")  # facts in which such parts are equal
_OPEN_CYCLES = 3  # so many stand open at first; of more only the one that decides

# What a picture shows: before and after the part's name for who cannot see it, and below it.
_CAPTIONS = {
    "whole": ("The whole part", "coloured by stress", "The whole part"),
    "peak": (
        "Surroundings of the peak",
        "coloured by stress",
        "Around the peak, which the dot marks",
    ),
    "mode": (
        "Lowest buckling mode",
        "coloured by displacement",
        "The lowest buckling mode, exaggerated, on the first mesh; the dot moves most",
    ),
}
_BY_SECTIONS = (
    "at most {:.3g} of 1, by formula: stress of the section forces; peaks at bores, fillets and "
    "pressed edges, which the checks count, are not in it: utilisation {} of the check that decides"
)
_STRAY = 1.005  # times the check: facets of the drawn surface stray by less
_RELIEVED = (
    "; that is less, as what presses on a bent part relieves it, which the estimate leaves out"
)


@dataclass(frozen=True, eq=False)
class Row:
    """A check as the page shows it.

    number   of the check in the result, for links
    title    its kind, with the quantity where a part has two of the kind
    decides  True if it decides the verdict; leads: True if it is the worst of its part
    gauge    its utilisation as a picture
    place    (cycle, position, part) by their numbers, to be shown in the live view; None if unknown
    shown    JSON of what the live view shows of it (reports/page_words.py)
    doubt    what a pass rests on that does not hold, in a few words
    part     whose check it is; None for the linkage
    """

    number: int
    check: Check
    title: str
    decides: bool
    leads: bool
    gauge: Markup
    place: Place | None
    shown: str
    doubt: str = ""
    part: PartResult | None = None


@dataclass(frozen=True, eq=False)
class PartView:
    """A part: its rows, worst first, its pictures (view, base64 of PNG) with captions, its charts.

    hand     hand checks, each with the ratio of the model's number to it, in words
    columns  of the table of its meshes
    status   of its worst check, None without any
    alike    name of a worse part of the same form and how far values differ; "" without one
    """

    part: PartResult
    rows: Sequence[Row]
    images: Sequence[tuple[str, str]]
    captions: Mapping[str, tuple[str, str, str]]
    hand: Sequence[tuple[HandComparison, str]]
    columns: Sequence[str]
    charts: Charts
    alike: str = ""

    @property
    def status(self) -> Status | None:
        """Status of its worst check; None without checks."""
        return self.rows[0].check.status if self.rows else None

    @property
    def broken(self) -> int:
        """Number of its gates that do not hold."""
        return sum(not gate.holds for gate in self.part.gates)


@dataclass(frozen=True, eq=False)
class CycleView:
    """A cycle: its name, number of positions, how often in the life, charts; whether it is open."""

    name: str
    count: int
    duty: float
    charts: Charts
    open: bool


def check_rows(result: DesignResult) -> list[Row]:
    """All checks, in the order of the result."""
    checks = result.checks
    if not checks:
        return []
    owners = list(dict.fromkeys(check.part for check in checks))
    leading = [deciding_of([c for c in checks if c.part == owner]) for owner in owners]
    return [
        Row(
            number=number,
            check=check,
            title=title,
            decides=check is result.deciding,
            leads=any(check is lead for lead in leading),
            gauge=gauge(check),
            place=place_of(check, result),
            shown=json.dumps(shown_of(check, result)),
            doubt=doubt_of(check, result),
            part=next((part for part in result.parts if part.name == check.part), None),
        )
        for number, (check, title) in enumerate(
            zip(checks, check_titles(checks), strict=True), start=1
        )
    ]


def worst_first(rows: Sequence[Row]) -> list[Row]:
    """Rows by status, then by the upper end of their error bars; equal ones stay in order."""
    return sorted(rows, key=lambda row: (ORDER.index(row.check.status), -_upper(row.check)))


def _upper(check: Check) -> float:
    end = check.upper if isfinite(check.upper) else check.value
    return end * check.required / check.limit


def part_views(
    result: DesignResult, rows: Sequence[Row], pictures: Pictures, charts: DesignCharts
) -> list[PartView]:
    """All parts, in the order of the result."""
    alike = alike_parts(result.parts)
    return [
        _part_view(part, rows, pictures, drawn, alike.get(part.name, ""))
        for part, drawn in zip(result.parts, charts.parts, strict=True)
    ]


def alike_parts(parts: Sequence[PartResult]) -> dict[str, str]:
    """Parts like a worse one: name -> sentence that names it, and how far the values differ.

    Alike are parts of one shape, material, mass and inertia, whose checks have the same kinds,
    limits and outcomes, and values within 1 % of each other.
    """
    told: list[PartResult] = []
    found = {}
    for part in sorted(parts, key=lambda part: -max(map(_upper, part.checks), default=0.0)):
        pairs = ((one, _difference(part, one)) for one in told)
        one, most = next((pair for pair in pairs if pair[1] <= _ALIKE), (None, 0.0))
        if one is None:
            told.append(part)
        else:
            share = f"within {number(100.0 * most, 2)} %" if most else "equal"
            found[part.name] = f"As {one.name}: the same shape, material and limits, values {share}"
    return found


def _difference(part: PartResult, other: PartResult) -> float:
    """Largest relative difference of two parts' check values; infinite where they are not alike."""

    def form(part: PartResult) -> list[object]:
        checks = [(c.kind, c.quantity, c.limit, c.required, c.status) for c in part.checks]
        return [part.shape, part.material, *map(part.facts.get, _SAME), *checks]

    if form(part) != form(other) or not part.checks or _SAME[0] not in part.facts:
        return inf
    pairs = [(a.value, b.value) for a, b in zip(part.checks, other.checks, strict=True)]
    return max(abs(a - b) / max(abs(a), abs(b)) if a != b else 0.0 for a, b in pairs)


def _part_view(
    part: PartResult, rows: Sequence[Row], pictures: Pictures, charts: Charts, alike: str
) -> PartView:
    mine = [row for row in rows if any(row.check is check for check in part.checks)]
    images = pictures.images.get(part.name, {})
    return PartView(
        part=part,
        rows=worst_first(mine),
        images=[(view, b64encode(image).decode()) for view, image in images.items()],
        captions=_captions(part),
        hand=[(hand, ratio(hand)) for hand in part.hand_checks],
        columns=list(dict.fromkeys(key for mesh in part.meshes for key in mesh)),
        charts=charts,
        alike=alike,
    )


def ratio(check: HandComparison) -> str:
    """Ratio of the model's number to that by hand."""
    return number(check.model / check.hand) if check.hand else "–"


def _captions(part: PartResult) -> dict[str, tuple[str, str, str]]:
    """Captions of a part's pictures; one that was not meshed names what decided it."""
    decided = ", ".join(dict.fromkeys(brief(check.method, 40) for check in part.checks))
    told = f"Not meshed: decided by {decided or 'no check'}"
    captions = {
        **_CAPTIONS,
        PLAIN: ("The whole part", "not meshed, without colours of stress", told),
    }
    estimate = estimate_of(part)
    if estimate is not None:
        name = stress_field(estimate)
        most, checked = estimate.fields[name][estimate.peak], deciding_of(part.checks).utilisation
        told_most = _BY_SECTIONS.format(most, utilisation_text(checked))
        if most > _STRAY * checked:
            told_most += _RELIEVED
        said = f"{told}. {capitalise(name)}: {told_most}"
        captions[ESTIMATE] = ("The whole part", f"coloured by {name}", said)
    if part.meshes or part.surface.is_bare:
        return captions
    beside = f"; of one mesh, to look at: the checks are decided by {decided or 'no model'}"
    return {view: (one, two, said + beside) for view, (one, two, said) in captions.items()}


def cycle_views(result: DesignResult, charts: DesignCharts) -> list[CycleView]:
    """All cycles; where there are many, only the one that decides stands open."""
    decides = result.deciding.cycle if result.checks else ""
    few = len(result.cycles) <= _OPEN_CYCLES
    return [
        CycleView(
            name=name,
            count=len(result.cycles[name].get("position", ())),
            duty=result.cycles[name].get("duty", 0),
            charts=drawn,
            open=few or name == decides,
        )
        for name, drawn in charts.cycles
    ]


def tiles(
    answer: Answer, result: DesignResult, rows: Sequence[Row]
) -> list[tuple[PartRow, str, Markup, str]]:
    """Governing check of each part and of the linkage: (its row, doubt, gauge, id of its section).

    Those nearest to their limit come first.
    """
    sections = {part.name: f"part-{n}" for n, part in enumerate(result.parts, 1)}
    own = {id(row.check): row for row in rows}
    found = [(row, own[id(row.check)]) for row in answer.rows]
    order = {id(row): k for k, row in enumerate(worst_first([row for _, row in found]))}
    return [
        (part, row.doubt, row.gauge, sections.get(row.check.part, "linkage"))
        for part, row in sorted(found, key=lambda pair: order[id(pair[1])])
    ]


def by_label(facts: Sequence[Fact]) -> list[tuple[str, list[str]]]:
    """Texts of facts under their labels, each once."""
    found: dict[str, list[str]] = {}
    for fact in facts:
        found.setdefault(fact.label, []).append(fact.line)
    return list(found.items())
