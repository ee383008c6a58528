"""A derivation for every check of a part: one door, asked after the checks are made."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import isfinite

import loads
from checks.columns.stability import ELASTIC_SHARE
from checks.derivations.bars import ERROR, rung_bars
from checks.derivations.buckling import elastic_share
from checks.derivations.columns import columns
from checks.derivations.contacts import bush, contact
from checks.derivations.crooked import crooked
from checks.derivations.pins import pin
from checks.derivations.proven import unknown, with_derivation
from checks.derivations.stresses import fatigue, static
from checks.ladder.climb import Climb
from checks.models.raised_bores import raised_in_bores
from checks.part.part_loads import PartLoads
from checks.result.derivation import BARS, Bars, Derivation, Section
from checks.result.verdict import Check
from checks.stress.part_model import RungLevel
from geometry.cad_body import SolidBody

Solved = Mapping[str, loads.CycleLoads | loads.MeasuredLoads]


def explained(
    climb: Climb,
    checks: Sequence[Check],
    body: SolidBody,
) -> list[Check]:
    """Return the checks of a part, each with its derivation.

    Those of a solid have theirs already (`checks.derivations.solids`): its mesh is gone by now. A
    check that nothing here knows gets one that says so (`checks.derivations.proven.unknown`).
    """
    loaded, part, part_loads = climb.loaded, climb.part, climb.loads
    by_quantity = columns(loaded) | crooked(loaded)
    of_kind: Mapping[str, Callable[[Check], Derivation | None]] = {
        "static": lambda check: _of_rung(climb, check),
        "fatigue": lambda check: _of_rung(climb, check),
        "buckling": lambda check: (
            _of_rung(climb, check)
            if check.quantity == ELASTIC_SHARE
            else by_quantity.get(check.quantity)
        ),
        "pin bending": lambda check: pin(part, part_loads, check),
        "pin shear": lambda check: pin(part, part_loads, check),
        "bush": lambda check: bush(loaded, check),
        "contact": lambda check: contact(part, part_loads, body.interfaces, check),
    }
    done = []
    for check in checks:
        derivation = check.derivation
        if derivation is None and check.kind in of_kind:
            derivation = of_kind[check.kind](check)
        done.append(with_derivation(check, derivation or unknown(check)))
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
        return replace(found, bars=Bars(words="nothing loads the part"))
    in_bores = 0.0
    if check.kind != "buckling":
        use = None if check.kind == "static" else climb.use
        in_bores = raised_in_bores(climb.part, part_loads, level, use)
    bars, items = rung_bars(climb.part, part_loads, level.model, check, found.value, in_bores)
    if (bars.above and not isfinite(check.model)) or (bars.below and not isfinite(check.below)):
        bars = Bars(bars.numerical, words="no model band: see the note of the check")
        items = [item for item in items if item.symbol in (ERROR, bars.numerical)]
    found = replace(found, bars=bars, sections=(*found.sections, Section(BARS, tuple(items))))
    return climb.bands[check.method].explained(check, found)
