"""Assemblies that buckle together: the linkage as a frame, at its worst position over all cycles.

Parts that are bars are members with their sections along them, other bodies are rigid, pins are
hinges about z. In the plane the drive is held where it is: the linkage would move with it, and
whether its force can keep it there is a question of its own. Out of the plane two bounds of what
the forks hold enclose the truth (docs/theory/linkage_frames.md):

soft   where a body is pinned to the ground or to a guided body it may tilt about the axis across
       itself, not about its own, but for cranks that turn round, on shafts; a body in another's
       slot is not held sideways by it
stiff  all bodies at a pin share all tilts, bodies in a slot hold each other sideways

A design may state which of them its forks are (`forks`).

The load factor multiplies all forces of the position together, inertia included.
"""

from collections.abc import Mapping, Sequence

import numpy as np

import loads
from checks.columns.linkage_search import (
    CASES,
    IN,
    SOFT,
    STIFF,
    Case,
    FreeMotions,
    LinkageMode,
    LooseError,
    Search,
)
from checks.design.data import Design
from checks.part.derived import Kind
from checks.result.verdict import Check
from checks.result.words import UNKNOWN_BAR
from checks.strength.sampling import with_sampling

LINKAGE = Kind(
    name="buckling",
    quantity="linkage frame, elastic load share",
    demand="load over the lowest elastic buckling load of the linkage",
    limit="1",
    require="buckling",
    source="[linkage frames](../theory/linkage_frames.md)",
)
COARSE, MIDDLE, FINE = 4, 8, 16  # pieces of a bar's longest stretch
_LOOSE = (
    "with soft forks the linkage moves out of the plane without strain; its forks are not stated"
)
Solved = Mapping[str, loads.CycleLoads | loads.MeasuredLoads]


def worst_mode(
    design: Design, solved: Solved, motions: FreeMotions | None = None
) -> LinkageMode | None:
    """Return the lowest buckling mode of the linkage over all positions of the solved cycles.

    motions  of earlier runs of the same design, kept for later ones

    None where no part is a bar, or no position has a factor above 0. Measured runs are left out:
    they tell no positions of the bodies. Raises loads.LinkageError where the frame can move.
    """
    motions = FreeMotions() if motions is None else motions
    cycles = _solved_cycles(solved)
    # forks that are not stated are soft, or stiff at best
    cases = (IN, _asked(design)) if design.forks else CASES
    found = _lowest(design, cycles, motions, cases)
    if found is None:
        return None
    fine, lowest = found
    asked = STIFF if fine.loose else _asked(design)
    worst = [(*lowest[case], case) for case in (IN, asked) if case in lowest]
    if not worst:
        return None
    factor, name, k, case = min(worst)
    middle = Search(design, cycles, MIDDLE, motions, slots_hold=fine.slots_hold)
    return fine.told(
        name,
        k,
        case,
        error=abs(factor - (middle.factor(name, k, case) or np.inf)),
        rise=fine.rise(name, k, case, factor),
        other=next((f for f, _, _, other in worst if other != case), None),
        stiff=min((lowest[case][0] for case in (IN, STIFF) if case in lowest), default=None),
    )


def least_factor(design: Design, solved: Solved, motions: FreeMotions) -> float | None:
    """Factor of `worst_mode` without the rest of it, for a third less; None as there."""
    found = _lowest(design, _solved_cycles(solved), motions, (IN, _asked(design)))
    return min((factor for factor, *_ in found[1].values()), default=None) if found else None


def _solved_cycles(solved: Solved) -> dict[str, loads.CycleLoads]:
    return {name: run for name, run in solved.items() if isinstance(run, loads.CycleLoads)}


def _asked(design: Design) -> Case:
    """The case out of the plane whose factor is the check's."""
    return STIFF if design.forks == "stiff" else SOFT


def _lowest(
    design: Design,
    cycles: Mapping[str, loads.CycleLoads],
    motions: FreeMotions,
    cases: Sequence[Case],
) -> tuple[Search, dict[Case, tuple[float, str, int]]] | None:
    """Search of the finest frames, and the lowest factor of each case with cycle and position.

    Where something is loose, slots hold sideways, or else forks that are not stated are stiff. None
    where no part is a bar. Raises loads.LinkageError where the frame can move.
    """
    if not cycles:
        return None
    for held, loose in ((False, False), (True, False), (False, True)):
        asked = (IN, STIFF) if loose else cases
        coarse = Search(design, cycles, COARSE, motions, asked, slots_hold=held, loose=loose)
        if not coarse.model.has_bars:
            return None
        try:
            ranked = coarse.ranked()
        except LooseError as error:
            if loose or (held and (error.apart or design.forks is not None)):
                raise
            continue
        fine = Search(design, cycles, FINE, motions, slots_hold=held, loose=loose)
        return fine, {case: fine.lowest(case, places) for case, places in ranked.items()}
    raise AssertionError("the last of them is found, or raises")


def linkage_check(design: Design, mode: LinkageMode) -> Check:
    """Return the verdict's line about the assembly, value 1/factor with soft or stated forks."""
    value = 1 / mode.factor
    # without a mode of stiff forks nothing of the value is certain
    below = value if mode.stiff_factor is None else max(value - 1 / mode.stiff_factor, 0.0)
    forks = f"{mode.forks} forks as stated"
    if mode.forks is None:
        stiff = "none" if mode.stiff_factor is None else f"{mode.stiff_factor:.3g}"
        forks = f"with forks that share all tilts: {stiff}"
    else:
        below = 0.0
    other = "in plane" if mode.plane == "out of plane" else "out of plane"
    beside = "none" if mode.other_plane is None else f"{mode.other_plane:.3g}"
    column = ""
    if mode.body is not None:
        column = (
            f"; {mode.body} with {mode.compression:.4g} N is as a hinged column of "
            f"{mode.effective_length:.4g} mm"
        )
    rigid = f"; taken as rigid: {', '.join(mode.rigid)}" if mode.rigid else ""
    slots = "; slots hold sideways, else something were loose" if mode.slots_hold else ""
    shares = ", ".join(f"{name} {share:.0%}" for name, share in mode.shares.items() if share > 5e-3)
    loose = f"; {UNKNOWN_BAR}{_LOOSE}" if mode.loose else ""
    check = Check(
        part="linkage",
        kind=LINKAGE.name,
        quantity=LINKAGE.quantity,
        value=value,
        unit="",
        numerical=value * mode.error / mode.factor,
        model=np.inf if mode.loose else 0.0,
        model_below=below,
        limit=1.0,
        required=LINKAGE.safety(design.require),
        cycle=mode.cycle,
        position=mode.position,
        place=f"{mode.plane} mode",
        method="frame",
        basis="linear eigenvalue of all bars and rigid bodies together, drive held: knows neither "
        "yield nor crookedness nor snapping through",
        note=f"lowest factor {mode.factor:.3g} {mode.plane}, {beside} {other}; {forks}; strain "
        f"energy: {shares}{column}{slots}{rigid}{loose}",
    )
    return with_sampling(check, mode.rise)
