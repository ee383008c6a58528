"""Stresses by how the pins of a solid press, as they were solved: for settings between them."""

from collections.abc import Mapping, Sequence
from math import ceil, degrees, pi, radians
from typing import Any

import numpy as np

from checks.design.data import Part
from checks.part.pressed_along import Uneven, that_count
from checks.stress.beyond_even import Setting, beyond_even, known_stacks
from checks.stress.clearances import values_at
from checks.stress.error_bars import Bars
from checks.stress.judged import Judged, RaisedInBores, StaticPeak
from checks.stress.pins_in_bores import LARGEST, LEAST, MIDDLE, Contact
from checks.stress.solid_mesh_level import Level

_SMOOTH = 0.02  # of a value, by which it may lie off the line through its neighbours
_MOST = 16  # clearances
_LEAST_LOAD, _MOST_LOAD = 0.7, 2.0  # factors on all loads
_LOADS = (_LEAST_LOAD, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.7, _MOST_LOAD)
_JUMP = 1e-9  # of a factor, to either side of a band's jump
_ALIKE = 0.1  # of the largest clearances: bores whose ranges are in one proportion
_ARC_STEP = radians(15.0)
Row = list[float]


def pins_data(
    part: Part, level: Level, bars: Mapping[Judged, Bars], uneven: Mapping[str, Uneven]
) -> dict[str, Any]:
    """Stresses by clearance and arc of the pins and by load, under "pins"; empty without pins.

    It is for the page alone.

    uneven  as in `bars_of`

    fits   bore -> least and largest clearance, mm
    kinds  kind of check -> rows of a setting, the value there, MPa, and how far the model band that
           comes of the pins reaches above and below it:
             "clearances"  by share of the fit
             "loads"       by the factor on all loads, all over that factor
           rows of an arc, deg, the value, and the most that bent pins make of it: "arcs"
           the model band above and below that all of the pins make: "band", arcs alone: "of_arcs"
    """
    fits = {} if level.contact is None else level.contact.pins.fits
    kinds: dict[str, Any] = {}
    for what, own in bars.items():
        found: dict[str, Any] = {}
        # a bush pressed in closes the fits that are stated, and lasts whatever the loads
        if level.contact is not None and own.clearances is not None and not level.lasting:
            found |= _of_clearances(part, what, level, level.contact, own)
        if len(own.by_arc) > 1:
            counts = that_count(part, uneven, static=isinstance(what, StaticPeak))
            arcs = _by_arc(what, level, own, counts)
            if not _beside({row[0]: row[1] for row in arcs}):
                found |= {"arcs": arcs, "of_arcs": list(_arcs_band(own))}
        if found:
            kind = "static" if isinstance(what, StaticPeak) else "fatigue"
            kinds[kind] = found | {"band": [own.above, own.below]}
    ranges = {name: [fit.least, fit.largest] for name, fit in fits.items()}
    return {"pins": {"fits": ranges, "kinds": kinds}} if kinds else {}


def _of_clearances(
    part: Part, what: Judged, level: Level, contact: Contact, own: Bars
) -> dict[str, list[Row]]:
    """Rows by clearance and by load, as `pins_data` has them; none where the stress jumps.

    The stress is solved by the sum of all pins' clearances over the factor on the loads, mm: while
    clearances are in proportion it says how pins press (`Contact`).
    """
    over, fits = own.clearances, contact.pins.fits.values()
    assert over is not None
    low, middle, high = (
        sum(fit.clearance(share) for fit in fits) for share in (LEAST, MIDDLE, LARGEST)
    )
    ratios = [fit.least / fit.largest if fit.largest > 0 else 0.0 for fit in fits]
    loads = max(ratios) - min(ratios) <= _ALIKE and all(fit.least >= 0 for fit in fits)
    known = {low + share * (high - low): value for share, value in over.values.items()}
    asked = {low / _MOST_LOAD, high / _LEAST_LOAD} if loads else set()
    while asked := asked - set(known):
        for one in sorted(asked):
            share = (one - low) / (high - low) if low < one < high else float(one >= high)
            factor = 1.0 if low <= one <= high else (high if share else low) / one
            known[one] = values_at(what, level, [share], factor=factor)[share]
        asked = _beside(known) if len(known) < _MOST else set()
    if _beside(known):
        return {}
    places, values = zip(*sorted(known.items()), strict=True)
    rows = {}
    if low < high:
        bent = [_bent(part, what, level, Setting(share, share)) for share in (LEAST, LARGEST)]
        rows["clearances"] = [
            _row(own, (one - low) / (high - low), value, (0.0, 0.0), _at(one, (low, high), bent))
            for one, value in zip(places, values, strict=True)
            if low <= one <= high
        ]
    if loads:
        jumps = _jumps(contact) if isinstance(what, StaticPeak) else []
        few = sorted({_LEAST_LOAD, 1.0, _MOST_LOAD, *jumps})
        bent = [_bent(part, what, level, Setting(factor=factor)) for factor in few]
        rows["loads"] = []
        for factor in sorted({*_LOADS, *jumps}):
            value = float(np.interp(middle / factor, places, values))
            ends = np.interp([low / factor, high / factor], places, values).tolist()
            ends += [v for one, v in known.items() if low < one * factor < high]
            band = max(ends) - value + over.above_these, value - min(ends) + over.below_these
            rows["loads"].append(_row(own, factor, value, band, _at(factor, few, bent)))
    return rows


def _beside(known: Mapping[float, float]) -> set[float]:
    """Places half-way to both neighbours of values that lie 2 % off the line through these.

    Without any everything between is known better.
    """
    ordered = sorted(known.items())
    found = set()
    for (a, before), (b, value), (c, after) in zip(ordered, ordered[1:], ordered[2:], strict=False):
        if abs(np.interp(b, (a, c), (before, after)) - value) > _SMOOTH * abs(value):
            found |= {(a + b) / 2, (b + c) / 2}
    return found


def _jumps(contact: Contact) -> list[float]:
    """Factors just below and above those beyond which a static band has what a bent pin presses."""
    ends = [s.even_up_to for _, s in known_stacks(contact) if s.is_ductile]
    found = [factor * side for factor in ends for side in (1 - _JUMP, 1 + _JUMP)]
    return [factor for factor in found if _LEAST_LOAD < factor < _MOST_LOAD]


def _bent(part: Part, what: Judged, level: Level, at: Setting) -> tuple[float, float]:
    """How far bent pins carry it above and below, MPa."""
    along = beyond_even(what, level, part, at)
    return (0.0, 0.0) if along is None else (along.above, along.below)


def _at(one: float, places: Sequence[float], bands: Sequence[tuple[float, float]]) -> list[float]:
    """Bands above and below (2,) at a place between others."""
    return [float(np.interp(one, places, side)) for side in zip(*bands, strict=True)]


def _row(own: Bars, at: float, value: float, *bands: Sequence[float]) -> Row:
    """Row of a setting with the sum of its bands above and below.

    With bushes that are soft a pin presses alike at each clearance and under each load.
    """
    above, below = np.sum([*bands, _arcs_band(own)], axis=0).tolist()
    soft = own.clearances.soft if own.clearances else None
    if soft is not None:
        above, below = max(above, soft - value), max(below, value - soft)
    return [at, value, above, below]


def _arcs_band(own: Bars) -> tuple[float, float]:
    """How far arcs of bores without a fit carry it above and below, MPa."""
    if not own.by_arc:
        return 0.0, 0.0
    reached, half = [*own.by_arc.values(), own.in_bores], own.by_arc[pi]
    return max(reached) - half, half - min(own.by_arc.values())


def _by_arc(what: Judged, level: Level, own: Bars, uneven: Mapping[str, Uneven]) -> list[Row]:
    """Rows by arc: the quantity, and the most of it with what bent pins press unevenly."""
    narrow, wide = min(own.by_arc), max(own.by_arc)
    count = 1 + max(2, ceil((wide - narrow) / _ARC_STEP - 1e-9))
    arcs: list[float] = np.linspace(wide, narrow, count).tolist()
    values = most = what.direct(level, arcs)
    if uneven and len(level.in_bores):
        raised = what.direct(level, arcs, RaisedInBores(0.0, uneven))
        most = [max(pair) for pair in zip(values, raised, strict=True)]
    return [[degrees(arc), *both] for arc, *both in zip(arcs, values, most, strict=True)]
