"""Checks of a part whose peak lies on a sharp re-entrant edge, where no elastic stress is finite.

Static: a stress field in balance with the loads that spares the edges (`spared_edges`); where it
yields nowhere a ductile part does not collapse (lower bound theorem of limit analysis).

Fatigue: Taylor's point method. An edge endures what a plain bar does whose stress is that at half
the critical distance L from it, L = (threshold / range of the endurance limit)^2 / pi at R = -1;
what the mean stress does comes after.

The surface away from edges is judged as ever, and the worse of both decides. The rules, their bars
and what they leave open: docs/theory/notch_edges.md.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, pi
from typing import cast
from weakref import WeakKeyDictionary

import numpy as np

from checks.design.data import Part
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check, Status
from checks.strength.fatigue_assessment import FatigueUse, FkmUse
from checks.strength.part_strength import endurance_of
from checks.stress.clearances import OverClearances, over_clearances
from checks.stress.error_bars import Bars, arcs_of, bars_of, mesh_bar
from checks.stress.judged import Judged
from checks.stress.sharp_edges import (
    EdgeLevel,
    Spared,
    SparedLevel,
    beside_edges,
    edge_level,
    spared_level,
    without,
)
from checks.stress.solid_mesh_level import Level
from checks.stress.stress_result import Stressed
from fem.convergence import ErrorBar, discretisation_error
from fem.notch_intensity import FARTHER, room_at
from geometry.memory import TooLargeError

_LEAST_BAR = 0.05  # of the value: what fits missed at most on V-notches and steps, and more
_ENOUGH = 0.1  # of the value: bar at sharp edges that asks for no finer mesh
_POINT_METHOD = 0.2  # of the value: band for the point method itself, ours
_DOMINATES = 0.8  # of the value that the leading fields alone must make at L/2
_ORDER = (Status.PASS, Status.UNDECIDED, Status.FAIL)

Make = Callable[[Stressed, Bars], Check]


@dataclass(frozen=True)
class NotJudged:
    """Why sharp edges are not judged.

    why    in words
    finer  True if a finer mesh may change it
    """

    why: str
    finer: bool = False


def critical_distance(part: Part) -> float | None:
    """Taylor's length L of a part's material, mm; None where no threshold is stated.

    The endurance limit is a polished bar's: a lower one would make L longer, and the stress
    at half of it lower.
    """
    threshold = part.material.threshold
    if threshold is None:
        return None
    return float((threshold / (2 * endurance_of(part).uncorrected)) ** 2 / pi)


def edge_fatigue(
    loaded: LoadedPart, levels: Sequence[Level], use: FatigueUse, make: Make
) -> Check | NotJudged:
    """The check of fatigue with sharp edges judged, or why they cannot be.

    make  a check of what was judged on some level, with its bars
    """
    part, loads = loaded.part, loaded.loads
    length = critical_distance(part)
    if length is None:
        return NotJudged("or state the material's threshold, for the point method")
    if isinstance(use, FkmUse):
        return NotJudged("the FKM guideline's chain does not judge sharp edges")
    duty = loaded.duty.cycles
    edges = [edge_level(level, loads, duty, length / 2) for level in levels[-2:]]
    before, finest = edges[0], edges[-1]
    farther = edge_level(levels[-1], loads, duty, length / 2, reach=FARTHER)
    leading = edge_level(levels[-1], loads, duty, length / 2, leading=True)
    if before is None or finest is None or farther is None or leading is None:
        why = "the elements at the edge are too large beside the faces there to fit its stress"
        return NotJudged(why, finer=True)
    value = use.value(finest)
    room = min(room_at(finest.places, int(k)) for k in finest.fitted)
    if length / 2 > room or use.value(leading) < _DOMINATES * value:
        return NotJudged(
            f"half the critical distance, {length / 2:.3g} mm, lies outside of what the edge's "
            "singular stress dominates",
            finer=True,
        )
    others = [use.value(level) for level in (before, farther, leading)]
    bars = _bars(part, finest, use, max(abs(value - other) for other in others))
    at_edge = make(finest, bars)
    at_edge = replace(
        at_edge,
        note=f"{at_edge.note}. Sharp edge by the point method: stress {length / 2:.3g} mm from it, "
        f"half of L = {length:.3g} mm; its model band is 20 % and that of the arcs",
    )
    # on coarser meshes than these two the edge spoils more than what is left out
    beside = beside_edges(levels[-2:], [before, finest], loads, duty)
    beside_bars = bars_of(use, part, beside, loaded.accuracy, loaded.uneven, loaded.loose)
    elsewhere = make(beside[-1], beside_bars)
    if not isfinite(elsewhere.numerical):
        why = f"away from where stress at the edge could be fitted: {beside_bars.note}"
        return NotJudged(why, finer=True)
    return _worse(at_edge, elsewhere, "sharp edges by the point method")


def edge_static(
    loaded: LoadedPart, levels: Sequence[Level], peak: Judged, make: Make
) -> Check | NotJudged:
    """The static check with sharp edges spared, or why there is none.

    make  a check of what was judged on some level, with its bars
    """
    part, loads = loaded.part, loaded.loads
    if not part.material.ductile:
        return NotJudged("the material is brittle: nothing redistributes the stress at the edge")
    spared = Spared.of(levels[0])
    for old in levels[:-2]:
        _solved.pop(old, None)  # its factor takes memory
    try:
        both = [_spared(level, loads, spared) for level in levels[-2:]]
    except TooLargeError as error:
        return NotJudged(f"a stress field that spares the edge was not solved: {error}")
    finest = both[-1]
    values = [level.peak.value for level in both]
    place = finest.history.points[finest.peak.point]
    sizes = [level.size_at(level.nearest(place)) for level in levels[-2:]]
    by_arc = _by_arc(part, peak, finest, levels[-1])
    clearances = over_clearances(peak, cast(Level, finest))
    bar = ErrorBar(
        discretisation_error(values, sizes, 1.0),
        finest.scatter,
        abs(by_arc[pi] - values[-1]) if by_arc else 0.0,
        values[-1],
    )
    bars = Bars(bar, *_band(by_arc, clearances), "", by_arc=by_arc, clearances=clearances)
    at_edge = make(finest, bars)
    at_edge = replace(
        at_edge,
        quantity="peak von Mises stress, sharp edges spared",
        model_below=at_edge.value,
        note=". ".join(
            text
            for text in (
                at_edge.note,
                "Sharp re-entrant edges have no finite elastic stress: this is the peak of a "
                "stress field in balance with the loads that spares them; a ductile part that "
                "yields nowhere under it does not collapse. It proves no failure",
            )
            if text
        ),
    )
    beside = [
        without(level, np.flatnonzero(spared.share(level, level.history.points) < 1), loads, {})
        for level in levels
    ]
    if any(len(level.left_out) == len(level.history.nodes) for level in beside):
        return at_edge  # the whole surface is near the edges, and judged with them
    elsewhere = make(
        beside[-1],
        bars_of(peak, part, beside, loaded.accuracy, loaded.uneven, loaded.loose),
    )
    if not isfinite(elsewhere.numerical):
        return NotJudged("the stress grows away from the edges, too", finer=True)
    return _worse(at_edge, elsewhere, "sharp edges spared")


def known_at_edges(
    loaded: LoadedPart,
    levels: Sequence[Level],
    judged: Sequence[Judged],
    checks: Sequence[Check],
    edges: Sequence[Check | NotJudged | None],
) -> str:
    """Why no finer mesh is needed, where sharp edges are known well enough; "" if one is.

    checks  of what is judged, in its order
    edges   of each whose peak lies on a sharp edge, its check or why there is none; else None
    """
    accuracy = loaded.accuracy
    never = [isinstance(one, NotJudged) and not one.finer for one in edges]
    known = all(
        lost
        or (
            check.numerical - check.sampling <= max(accuracy, _ENOUGH) * check.value
            if isinstance(one, Check)
            else mesh_bar(what, levels) <= accuracy
        )
        for what, check, one, lost in zip(judged, checks, edges, never, strict=True)
    )
    if not known or all(one is None for one in edges):
        return ""
    if any(never):
        return "no mesh makes stress at its sharp edges finite: no finer one was solved"
    return f"sharp edges are judged to {100 * _ENOUGH:g} %: no finer mesh was solved"


def _spared(level: Level, loads: PartLoads, spared: Spared) -> SparedLevel:
    """The stress that spares the edges, solved once a mesh."""
    if level not in _solved:
        _solved[level] = spared_level(level, loads, spared)
    return _solved[level]


_solved: WeakKeyDictionary[Level, SparedLevel] = WeakKeyDictionary()


def _worse(at_edge: Check, elsewhere: Check, said: str) -> Check:
    if max((at_edge, elsewhere), key=_severity) is at_edge:
        return at_edge
    told = f"{said}: {at_edge.value:.4g} MPa"
    return replace(elsewhere, note=". ".join(t for t in (elsewhere.note, told) if t))


def _severity(check: Check) -> tuple[int, float]:
    most = (check.value + check.numerical + check.model) * check.required / check.limit
    return _ORDER.index(check.status), most


def _bars(part: Part, level: EdgeLevel, use: FatigueUse, moved: float) -> Bars:
    """Numerical bar and model band at the edges.

    moved  MPa, the most by which the mesh before, another window and the leading fields differ
    """
    value = use.value(level)
    by_arc = _by_arc(part, use, level, level.solid)
    clearances = over_clearances(use, cast(Level, level))
    truncation = abs(by_arc[pi] - value) if by_arc else 0.0
    bar = ErrorBar(max(moved, _LEAST_BAR * value), 0.0, truncation, value)
    above, below = (side + _POINT_METHOD * value for side in _band(by_arc, clearances))
    return Bars(bar, above, below, "", by_arc=by_arc, clearances=clearances)


def _by_arc(
    part: Part, judged: Judged, level: EdgeLevel | SparedLevel, solid: Level
) -> dict[float, float]:
    """The judged quantity by the arc of contact, rad; empty without pins."""
    arcs = arcs_of(part, solid)
    solved = cast(Level, level)  # has all that `direct` asks of one
    return dict(zip(arcs, judged.direct(solved, arcs), strict=True)) if arcs else {}


def _band(by_arc: Mapping[float, float], clearances: OverClearances | None) -> tuple[float, float]:
    """How far arcs of contact and clearances reach above and below the value, MPa."""
    above = below = 0.0
    if by_arc:
        above += max(by_arc.values()) - by_arc[pi]
        below += by_arc[pi] - min(by_arc.values())
    if clearances is not None:
        above += clearances.above
        below += clearances.below
    return above, below
