"""All kinds of checks, and derivations of those by models of stress, after these are made."""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

from checks import by_formula
from checks.columns.linkage_frame import LINKAGE
from checks.columns.stability import ELASTIC
from checks.derivations.bars import ERROR, rung_bars
from checks.derivations.buckling import elastic_share
from checks.derivations.stresses import fatigue, static
from checks.ladder.climb import Climb
from checks.models import stress_words
from checks.models.checked import BUCKLING, FATIGUE, STATIC
from checks.models.raised_bores import raised_in_bores
from checks.part.kind import Kind
from checks.part.part_loads import PartLoads
from checks.result.derivation import BARS, BarSymbols, Derivation, Given, Item, Section
from checks.result.verdict import Check
from checks.stress.part_model import RungLevel

UNKNOWN = "no derivation of this check is known: its numbers are put in as the check has them"


def known_kinds() -> list[Kind]:
    """Every kind of check: by models of stress, of buckling, and by formula."""
    return [*stress_words.KINDS, ELASTIC, LINKAGE, *by_formula.kinds()]


def explained(climb: Climb, checks: Sequence[Check]) -> list[Check]:
    """Return the checks of a part by its models of stress, each with its derivation.

    Those of a solid have theirs already (`checks.derivations.stresses`): its mesh is gone by now.
    Those at sharp edges have none yet, and say so (`UNKNOWN`).
    """
    done = []
    for check in checks:
        derivation = check.derivation
        if derivation is None and check.kind in (STATIC, FATIGUE, BUCKLING):
            derivation = _of_rung(climb, check)
        done.append(check.explained_by(derivation or _unknown(check)))
    return done


def _of_rung(climb: Climb, check: Check) -> Derivation | None:
    level = climb.levels.get(check.method)
    if level is None:
        return None
    part, part_loads = climb.part, climb.loads
    if check.kind == "buckling":
        load = level.model.buckling
        if load is None:
            return None
        found = elastic_share(climb.loaded, load)
    elif check.kind == "static":
        found = static(part, part_loads, level)
    else:
        if climb.use is None:
            return None
        found = fatigue(part, part_loads, level, climb.use)
    return _with_rung_bars(found, part_loads, climb, level, check)


def _with_rung_bars(
    found: Derivation, part_loads: PartLoads, climb: Climb, level: RungLevel, check: Check
) -> Derivation:
    if part_loads.is_nothing:
        return replace(found, bars=BarSymbols(words="nothing loads the part"))
    in_bores = 0.0
    if check.kind != "buckling":
        use = None if check.kind == "static" else climb.use
        in_bores = raised_in_bores(climb.part, part_loads, level, use)
    bars, items = rung_bars(climb.part, part_loads, level.model, check, found.value, in_bores)
    if (bars.above and not isfinite(check.model)) or (bars.below and not isfinite(check.below)):
        bars = BarSymbols(bars.numerical, words="no model band: see the note of the check")
        items = [item for item in items if item.symbol in (ERROR, bars.numerical)]
    found = replace(found, bars=bars, sections=(*found.sections, Section(BARS, tuple(items))))
    return climb.bands[check.method].explained(check, found)


def _unknown(check: Check) -> Derivation:
    """A derivation that derives nothing and says so."""
    source = f"the check, by {check.method}"
    bars, widths = {}, list[Item]()
    for side, name, size in (
        ("numerical", "numerical error bar", check.numerical - check.sampling),
        ("above", "model band above", check.model - check.loads),
        ("below", "model band below", check.below - check.loads_below),
    ):
        if size and isfinite(size):
            bars[side] = f"e_{side}"
            widths.append(Given(f"e_{side}", name, size, check.unit, source))
    return Derivation(
        cases=(),
        sections=(
            Section("Demand", (Given("v", check.quantity, check.value, check.unit, source, True),)),
            Section("Limit", (Given("L", check.basis, check.limit, check.unit, source, True),)),
            Section(BARS, tuple(widths)),
        ),
        value="v",
        limit="L",
        bars=BarSymbols(**bars, words="bars as the check has them"),
        unproved=UNKNOWN,
    )
