"""Doubts about the loads: each a pair of load histories, put through the same model.

A check is made again under the loads at the ends of each doubt. Its bars reach to the farther end
on either side; several doubts add up.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, pi

from checks.design.data import COMPARED_ARC
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from checks.result.words import DOUBTED, UNKNOWN_BAR

AMPLITUDE = "amplitude"  # of equal safety, beside the values of checks
_ROUND_OFF = 1e-9  # of a value
_NOTHING = 1e-6  # MPa or N
_RUBBED = "pins that rub where they press"
# Times friction and the peak stress, of pins that press on arcs down to 90 degrees. On less
# a swing has more, up to a share of the peak, as the angle of friction moves all of the pressure.
_STEADY, _SWING = 0.85, 1.3
_ON_NARROW, _GROWTH, _MOST_SWING = 1.1, 1.2, 0.6


def with_doubts(check: Check, ends: Mapping[str, Sequence[float]]) -> Check:
    """Return a check with its load bars, which are part of its model band.

    ends  words of a doubt -> the check's value at its ends, in its unit
    """
    above = below = 0.0
    told = list[tuple[str, float, float]]()
    for words, values in ends.items():
        more = max(0.0, *(value - check.value for value in values))
        less = max(0.0, *(check.value - value for value in values))
        if max(more, less) > _ROUND_OFF * check.value:
            above, below = above + more, below + less
            told.append((words, more, less))
    if not told:
        return check
    names = ", ".join(words for words, *_ in told)
    note = f"{DOUBTED} ({names}): {_sides(check, above, below)}"
    found = replace(
        check,
        model=check.model + above,
        model_below=check.below + below,
        loads=check.loads + above,
        loads_below=check.loads_below + below,
        doubts=(*check.doubts, *told),
        note="; ".join(text for text in (check.note, note) if text),
    )
    return found.explained_by(check.derivation)


def _sides(check: Check, above: float, below: float) -> str:
    return f"+{above:.3g} -{below:.3g} {check.unit}".rstrip()


def doubted(
    make: Callable[[PartLoads], Sequence[Check]], loads: PartLoads, checks: Sequence[Check]
) -> list[Check]:
    """Checks that are formulas of the loads, with what may be otherwise of these in their bars.

    make    makes the checks under other loads of the part
    checks  under its own

    A check of the same kind and quantity at an end of a doubt counts by its utilisation. One that
    is only there at an end stands by itself, and fails nothing.
    """
    found = list(checks)
    known = {(check.kind, check.quantity) for check in found}
    ends: dict[tuple[str, str], dict[str, list[float]]] = {name: {} for name in known}
    only: dict[tuple[str, str], Check] = {}
    for doubt in loads.doubts:
        for end in doubt.ends:
            made = {(check.kind, check.quantity): check for check in make(end)}
            for name in known:
                used = made[name].utilisation if name in made else 0.0
                ends[name].setdefault(doubt.words, []).append(used)
            for name, check in made.items():
                if name not in known:
                    worse = only.get(name)
                    if worse is None or check.utilisation > worse.utilisation:
                        only[name] = only_at(doubt.words, check)
    done = []
    for check in found:
        unit = check.limit / check.required
        values = {w: [unit * u for u in us] for w, us in ends[check.kind, check.quantity].items()}
        done.append(with_doubts(check, values))
    return [*done, *only.values()]


def only_at(words: str, check: Check) -> Check:
    """A check that is only there at an end of a doubt: its value may as well be none."""
    note = "; ".join(text for text in (check.note, f"only at: {words}") if text)
    found = replace(
        check,
        model_below=check.value,
        loads_below=check.value,
        doubts=(*check.doubts, (words, 0.0, check.value)),
        note=note,
    )
    return found.explained_by(check.derivation)


@dataclass(frozen=True)
class LoadBars:
    """Widening of a model's checks: their values at the ends of each doubt, over their own.

    shares  kind of check -> words of a doubt -> value at each end over the value; infinite where
            nothing loads the part but there
    """

    shares: Mapping[str, Mapping[str, Sequence[float]]]

    def __call__(self, check: Check) -> Check:
        """Return a check with its load bars, without end where it has no value to widen."""
        shares = self.shares.get(check.kind, {})
        only = [words for words, own in shares.items() if inf in own]
        if not check.value and only:
            said = f"{UNKNOWN_BAR}the part is loaded only at the ends of: {', '.join(only)}"
            note = "; ".join(text for text in (check.note, said) if text)
            return replace(check, model=inf, note=note).explained_by(check.derivation)
        if not check.value or not (isfinite(check.model) or isfinite(check.below)):
            return check
        return with_doubts(check, {w: [s * check.value for s in own] for w, own in shares.items()})


def load_bars(
    loads: PartLoads, values_of: Callable[[PartLoads], Mapping[str, float]], arc: float = pi
) -> LoadBars:
    """Return the load bars of a model.

    values_of  the values of its checks, by kind, under some loads of the part; with fatigue and
               friction an `AMPLITUDE` beside them
    arc        rad, the narrowest on which pins press in its bores
    """
    if not loads.doubts and not loads.rubs[0]:
        return LoadBars({})
    own = values_of(loads)
    shares: dict[str, dict[str, list[float]]] = {kind: {} for kind in own if kind != AMPLITUDE}
    for kind, most in _rubbed(loads, own, arc).items():
        shares[kind][_RUBBED] = [1 + most, max(1 - most, 0.0)]
    for doubt in loads.doubts:
        for end in doubt.ends:
            other = values_of(end)
            for kind in shares:
                value, here = own[kind], other.get(kind, 0.0)
                share = here / value if value else (inf if here > _NOTHING else 1.0)
                shares[kind].setdefault(doubt.words, []).append(share)
    return LoadBars(shares)


def _rubbed(loads: PartLoads, own: Mapping[str, float], arc: float) -> dict[str, float]:
    """How far stress in bores may lie off as friction is an even shear there, over the values.

    A pin that rubs where it presses adds to the peak of a bore, and to its amplitude at the most
    when it turns to and fro (docs/theory/bearing.md, "Friction"). Friction is the largest of all
    ends of the doubts, which may have more of it.

    own  MPa, by kind of check: the peak stress of bores is no larger than the part's
    """
    ends = (end.rubs for doubt in loads.doubts for end in doubt.ends)
    steady, swing = map(max, zip(loads.rubs, *ends, strict=True))
    found = {"static": (_STEADY if arc >= COMPARED_ARC else _ON_NARROW) * steady}
    if own.get(AMPLITUDE):  # which a life or another guideline multiplies
        narrow = max(1.0, COMPARED_ARC / arc) ** _GROWTH * _SWING * swing
        more = max(_SWING * swing, min(narrow, _MOST_SWING))
        found["fatigue"] = more * own["static"] / own[AMPLITUDE]
    return {kind: most for kind, most in found.items() if most and own.get(kind)}
