"""Contact of pins whose fit is not stated: by an assumed one, and clearances that would pass.

And edges of bores that would pass, had they run in.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from math import isfinite

from checks.handbook.fits import DEFAULT, clearances_of
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.part.pressed_along import that_count, why_even
from checks.result.verdict import Check, Status
from checks.result.ways import clearance_fact, edges_fact, run_in_fact, without_hits
from checks.strength.part_strength import endurance_of
from checks.stress.clearances import FIRST, some_positions, values_at
from checks.stress.error_bars import Bars
from checks.stress.judged import Judged, StaticPeak
from checks.stress.pins_in_bores import PinnedBores, widest_fits
from checks.stress.solid_mesh_level import Level, solve_level
from fem.contact.condensed import ContactError
from fem.unit_solutions import has_bearings
from geometry.mesh import Interface, MeshError

_POSITIONS = 40  # of each cycle, besides those that decide under assumed pressures


def with_assumed_fits(
    loaded: LoadedPart, level: Level, checks: Sequence[Check]
) -> LoadedPart | None:
    """The part with clearances in all its bores, where assumed arcs leave a check open.

    From none to those of the default fit: so a part passes if it does with that fit, and fails only
    if it does without clearance, too. None where no check is open, another one fails, the design
    states an arc or a fit, or contact cannot decide.
    """
    part = loaded.part
    fails = any(check.status is Status.FAIL for check in checks)
    if fails or part.arc_stated or not any(_is_open(check) for check in checks):
        return None
    bores = _bores_of_contact(loaded, level)
    try:
        largest = {bore.name: clearances_of(DEFAULT, 2 * bore.radius)[1] for bore in bores}
    except ValueError:  # larger than the standard's table
        return None
    if not largest:
        return None
    clearances = {name: (0.0, most) for name, most in largest.items()}
    said = f"{DEFAULT} or closer ASSUMED: the design states no fit"
    least = min(part.least_arc, loaded.narrowest_arc)  # where friction has its bars
    fitted = replace(part, clearances=clearances, fit_assumed=said, least_arc=least)
    return replace(loaded, part=fitted)


def _is_open(check: Check) -> bool:
    """True of a solid's stress check that stays open."""
    return (
        check.kind in ("static", "fatigue")
        and check.method.startswith("solid")
        and check.status is Status.UNDECIDED
        and isfinite(check.numerical)
    )


def _bores_of_contact(loaded: LoadedPart, level: Level) -> list[Interface]:
    """Bores whose pins have no stated fit and can be solved: all of a part, or none.

    None where a fit is stated, another bearing, such as a journal, keeps its arcs, or sharp edges
    are judged apart.
    """
    bores = [u.interface for u in level.solutions.interfaces if u.interface.kind == "bore"]
    names = [bore.name for bore in bores]
    if loaded.part.clearances or len(level.edges[0]) or has_bearings(level.solutions, names):
        return []
    return bores if level.history.coefficients.any() else []


def clearances_that_pass(
    loaded: LoadedPart,
    level: Level,
    judged: Sequence[Judged],
    checks: Sequence[Check],
    bars: Mapping[Judged, Bars],
) -> dict[str, float]:
    """The largest clearance, mm, up to which each open check passes by contact, by fact and bore.

    level  under assumed pressures
    bars   of the checks: what a pin that bends presses more stays in the band

    Contact is solved on the level's own factor at some of the positions. The band of arcs, or of
    the default fit, then falls; the numerical bar and the bar of the loads stay as they are.
    """
    open_ones = [
        (what, check)
        for what in judged
        for check in checks
        if check.kind == ("static" if isinstance(what, StaticPeak) else "fatigue")
        and _is_open(check)
        and not check.settled_by_mesh
    ]
    bores = _bores_of_contact(loaded, level) if open_ones else []
    if not bores:
        return {}
    part, duty = loaded.part, loaded.duty.cycles
    fits = widest_fits(loaded, bores)
    some = _some_of(loaded.loads, level, judged)
    try:
        pressed = solve_level(
            level.solutions,
            level.fineness,
            some,
            endurance_of(part).value,
            part.material.ultimate_stress,
            duty,
            part.geometry.notch_factors,
            PinnedBores(level.solutions, fits),
        )
    except (ContactError, MeshError):
        return {}
    found: dict[str, float] = {}
    for what, check in open_ones:
        along = bars[what].along if what in bars else None
        bends = any(_bends(loaded, bore.name, static=check.kind == "static") for bore in bores)
        if (bends and along is None) or any(fit.unstated for fit in fits.values()):
            continue  # by contact it would be more than what is known
        uneven = along.above if along else 0.0
        share = None
        for tried, value in values_at(what, pressed, FIRST, some).items():
            # what is left above the arcs' band are the bars of the loads
            model = check.loads + uneven
            known = replace(check, value=value, model=model, model_below=check.loads_below)
            if known.status is not Status.PASS:
                break
            share = tried
        if share is not None:
            found |= {
                clearance_fact(check.kind, name): round(fit.clearance(share), 6)
                for name, fit in fits.items()
            }
    return found


def edges_that_pass(
    loaded: LoadedPart,
    checks: Sequence[Check],
    again: Callable[[LoadedPart, str], tuple[Check, Check]],
) -> dict[str, float]:
    """Least safety of each open check that passes with run-in edges, by fact; fewest bores first.

    again  judges a kind of check of the same part with other edges, as it is and with bushes of
           steel where their material is not stated
    """
    found: dict[str, float] = {}
    part = loaded.part
    for check in checks:
        if check.kind not in ("static", "fatigue") or check.status is not Status.UNDECIDED:
            continue
        bent = sorted(that_count(part, loaded.uneven, static=check.kind == "static"))
        sets = [*((name,) for name in bent), *([tuple(bent)] if len(bent) > 1 else [])]
        tried = []
        for names in sets:
            edges = {**part.bore_edges, **dict.fromkeys(names, "run_in")}
            other = replace(loaded, part=replace(part, bore_edges=edges))
            tried.append((names, again(other, check.kind)))
        ways = ((False, False), (True, False), (False, True))
        passing = (
            (names, steel, cushioned, one)
            for steel, cushioned in ways
            for names, checks_of in tried
            for one in (without_hits(checks_of[0]) if cushioned else checks_of[steel],)
            if one.status is Status.PASS
        )
        for names, steel, cushioned, one in islice(passing, 1):
            fact = edges_fact(check.kind, names, steel=steel, cushioned=cushioned)
            found[fact] = one.limit / one.upper
    return found


def by_run_in_edges(
    loaded: LoadedPart,
    checks: Sequence[Check],
    again: Callable[[LoadedPart, str], tuple[Check, Check]],
) -> dict[str, float]:
    """Upper end of each check that passes by edges stated to have run in, and not as cut, by fact.

    again  as for `edges_that_pass`
    """
    found: dict[str, float] = {}
    part = loaded.part
    cut = replace(loaded, part=replace(part, bore_edges={}))
    for check in checks:
        if check.kind not in ("static", "fatigue") or check.status is not Status.PASS:
            continue
        counted = that_count(cut.part, loaded.uneven, static=check.kind == "static")
        bores = sorted(counted.keys() & part.bore_edges.keys())
        as_cut = again(cut, check.kind)[0] if bores else check
        if as_cut.status is not Status.PASS:
            found[run_in_fact(check.kind, bores)] = as_cut.upper
    return found


def _bends(loaded: LoadedPart, bore: str, *, static: bool) -> bool:
    """True if a bent pin is in the band of a check."""
    stack = loaded.stack(bore)
    return stack is not None and not why_even(loaded.part, bore, stack, static=static)


def _some_of(loads: PartLoads, level: Level, judged: Sequence[Judged]) -> PartLoads:
    """Positions spread over every cycle, and those that decide."""
    chosen, cycles = some_positions(loads, level, judged, _POSITIONS)
    return replace(
        loads,
        wrenches={name: wrench[chosen] for name, wrench in loads.wrenches.items()},
        accelerations=loads.accelerations[chosen],
        reaches={name: reach[chosen] for name, reach in loads.reaches.items()},
        cycles=cycles,
        labels=tuple(loads.labels[k] for k in chosen),
        cycle_names=tuple(loads.cycle_names[k] for k in chosen),
        stretch_of=None if loads.stretch_of is None else loads.stretch_of[chosen],
        path=None if loads.path is None else loads.path[chosen],
        spins={name: spin[chosen] for name, spin in loads.spins.items()},
        own_swing={place: across[chosen] for place, across in loads.own_swing.items()},
        doubts=(),
    )
