"""Stress of a rung in the bores of a part, where pins press on narrower arcs, and unevenly.

A rung's pins press by half a cosine. A pin with clearance presses on less of the bore
(docs/theory/bearing.md): the rung's lugs are solved again for the cosine on arcs down to the
narrowest that the part states, as a solid is.

Bores whose arc of contact is not stated, or whose pin bends, may have more than that. Contacts
exceed the assumed arcs by a share that solids have in their model band. The bands of the rungs were
compared with solids on the arcs alone, evenly pressed along: they have neither.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi
from weakref import WeakKeyDictionary

import numpy as np

from checks.design.data import Part
from checks.handbook.pin_loaded_hole import BEYOND_ARCS
from checks.models.formula_points import PRESSED_IN
from checks.models.shapes import shape_model
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.part.pressed_along import Uneven, that_count
from checks.strength.fatigue_assessment import FatigueUse
from checks.stress.stress_result import RungLevel, RungModel
from fem.stress_history import StressHistory
from geometry.mesh import BoolArray, FloatArray, IntArray

Again = Callable[[PartLoads], RungModel | None]
_PRESSURE = " cos 0"  # the unit load that only an interface with a bearing pressure has
# in names of unit loads: couples out of the linkage's plane, and bushes, which no pin raises
_ACROSS = ("M_x", "M_y", "torque", PRESSED_IN)
_NEAR = 0.8  # of the largest fatigue use in bores: points that are asked again
# of the peak, and of that use: positions and points that are asked on other arcs, which have up to
# 1.7 times the half circle's pressure
_HIGH = 0.55


@dataclass(frozen=True)
class InBores:
    """Stress of a check where arcs of contact are narrower and pins press unevenly, MPa.

    half    the largest in bores, pressed on the half circle, raised; 0 where nothing raises it
    most    the same on any of the arcs, and the largest beside bores; 0 where nothing does
    least   of the whole part, on the arc where it is least, not raised
    by_arc  arc, rad -> the value of the whole part, not raised; empty where the rung knows none
    evened  the largest with every bent pin, also those in no band; 0 where every one is in it
    """

    half: float = 0.0
    most: float = 0.0
    least: float = 0.0
    by_arc: Mapping[float, float] | None = None
    evened: float = 0.0


def arcs_of(part: Part) -> list[float]:
    """Arcs of contact, rad, that a rung knows besides the half circle: down to the narrowest."""
    model, narrow = shape_model(part.geometry), part.bearing_arc
    if model is None or not model.arcs or narrow >= pi:
        return []
    return [(pi + narrow) / 2, narrow]


_on_arcs: WeakKeyDictionary[RungModel, dict[float, RungModel]] = WeakKeyDictionary()


class Arcs:
    """A rung's level with its models on narrower arcs of contact, each built when it is asked for.

    again  builds the rung's model under other loads
    """

    def __init__(self, loaded: LoadedPart, level: RungLevel, again: Again) -> None:
        self.loaded, self.level, self._again = loaded, level, again

    @cached_property
    def models(self) -> dict[float, RungModel]:
        """Arc, rad -> the model with pins that press on it."""
        if self.level.model not in _on_arcs:  # of another material they are the same
            loads = self.loaded.loads
            found = {arc: self._again(replace(loads, arc=arc)) for arc in arcs_of(self.loaded.part)}
            _on_arcs[self.level.model] = {a: one for a, one in found.items() if one is not None}
        return _on_arcs[self.level.model]

    @cached_property
    def points(self) -> IntArray:
        """The points of the models on the rims of bores that a pin presses."""
        model = self.level.model
        units = [name for name, _ in model.units]
        bores = {name.removesuffix(_PRESSURE) for name in units if name.endswith(_PRESSURE)}
        return np.flatnonzero([place in bores for place in model.places])

    @cached_property
    def beside(self) -> IntArray:
        """The points off these rims, as in fillets of eyes, that change with the pressure's arc."""
        model = self.level.model
        waves = [re.search(r" (?:cos|sin) (\d+)$", name) for name, _ in model.units]
        without_force = [wave is not None and wave[1] != "1" for wave in waves]
        reached = model.history.basis[:, :, without_force].any(axis=(1, 2))
        return np.setdiff1d(np.flatnonzero(reached), self.points)


def in_bores(arcs: Arcs, use: FatigueUse | None, value: float) -> InBores:
    """Return how narrower arcs and uneven pressure move a check.

    use    how fatigue is judged; None for von Mises stress
    value  MPa, of the check, on the half circle
    """
    loaded, level = arcs.loaded, arcs.level
    part, points = loaded.part, arcs.points
    if part.body is None or loaded.loads.is_nothing or not len(points):
        return InBores(least=value)
    every = loaded.uneven
    counts = that_count(part, every, static=use is None)
    more = 1.0 if part.arc_stated else 1.0 + BEYOND_ARCS
    elsewhere, on_half = _on_half_circle(level, use, value, points)
    by_arc = {pi: value}
    own, beside = {pi: on_half}, dict[float, float]()
    for arc, model in arcs.models.items():
        own[arc], beside[arc] = (
            _largest(loaded, level, model, use, some, {}, 1.0) for some in (points, arcs.beside)
        )
        by_arc[arc] = max(own[arc], beside[arc], elsewhere)
        if use is not None:
            more_beside = _largest(loaded, level, model, use, arcs.beside, {}, 1.0, every=True)
            beside[arc] = max(beside[arc], more_beside)

    def raised(arc: float, uneven: Mapping[str, Uneven]) -> float:
        model = arcs.models.get(arc, level.model)
        same = use is None or model is level.model
        if same and not uneven and not _across(model).any():
            return more * own[arc]  # all of the stress is in proportion to what is raised
        found = _largest(loaded, level, model, use, points, uneven, more)
        if same:
            return found
        # in the bores another two positions may govern than in the part
        return max(found, _largest(loaded, level, model, use, points, uneven, more, every=True))

    half = raised(pi, counts) if counts or not part.arc_stated else 0.0
    most = max([half, *(raised(arc, counts) for arc in arcs.models), *beside.values()])
    evened = 0.0
    if len(counts) < len(every):
        evened = max(raised(arc, every) for arc in own)
    known = by_arc if len(by_arc) > 1 else None
    return InBores(half, most, min(by_arc.values()), known, evened)


def _on_half_circle(
    level: RungLevel, use: FatigueUse | None, value: float, points: IntArray
) -> tuple[float, float]:
    """The largest beside the bores and in them, MPa; of fatigue beside them perhaps less."""
    history, others = level.history, np.setdiff1d(np.arange(len(level.history.points)), points)
    if use is None:
        inside = level.peak.point in points
        other = _peak(level, history, others if inside else points)
        return (other, value) if inside else (value, other)
    known, used = level.judged_duty.known, level.judged_duty.bound[points]
    elsewhere = value * float(known[others].max(initial=0.0) / known.max())
    if known[points].max() == known.max():
        return elsewhere, value
    near = points[used >= _NEAR * used.max()]
    return elsewhere, use.anew(level, near, history.basis[near], history.coefficients)


def _peak(
    level: RungLevel,
    history: StressHistory,
    points: IntArray,
    basis: FloatArray | None = None,
    times: float = 1.0,
) -> float:
    """The largest von Mises stress at some points, of some basis, where positions strain most.

    times  how much more than on the half circle that basis may have, arcs apart
    """
    if not len(points):
        return 0.0
    peaks = level.peaks_by_position
    states = history.coefficients[:, peaks >= _HIGH / times * peaks.max()]
    own = history.basis[points] if basis is None else basis
    found = StressHistory(history.nodes[points], history.points[points], own, states)
    return float(found.peaks_by_point().max())


def _across(model: RungModel) -> BoolArray:
    """Which columns of a model no pin raises."""
    return np.array([any(word in name for word in _ACROSS) for name, _ in model.units])


def _largest(
    loaded: LoadedPart,
    level: RungLevel,
    model: RungModel,
    use: FatigueUse | None,
    points: IntArray,
    uneven: Mapping[str, Uneven],
    more: float,
    *,
    every: bool = False,
) -> float:
    """The largest stress in bores, MPa, under more of the forces in the plane.

    Fatigue on other arcs is between the two positions that govern on the half circle, as of solids,
    or between any two.

    As in a solid (checks/stress/error_bars.py), the stress of couples out of the plane and of
    bushes that are pressed in stays.

    model   the rung's, of the level or of another arc
    points  of the bores
    uneven  bore -> how much more its bent pin presses
    more    times the forces in all bores
    every   True for fatigue between any two positions
    """
    if not len(points):
        return 0.0
    units, history = [name for name, _ in model.units], model.history
    places = np.array(model.places)[points]
    times = more * max((one.most for one in uneven.values()), default=1.0)
    every = every or model is level.model
    if use is not None and every:
        used = level.judged_duty.bound[points]
        most = {bore: used[places == bore].max() for bore in set(places)}
        share, least = _NEAR, 0.0
        if model is not level.model:  # also where it may exceed the part's largest
            share, least = _HIGH, _HIGH / times * level.judged_duty.bound.max()
        near = used >= np.maximum(share * np.array([most[bore] for bore in places]), least)
        points, places = points[near], places[near]
        if not len(points):
            return 0.0
    factors: FloatArray = np.full((len(points), len(units)), more)
    for bore, one in uneven.items():
        pressed = np.array([name.startswith(f"{bore} ") for name in units])
        factors[np.ix_(places == bore, pressed)] *= one.most
    factors[:, _across(model)] = 1.0
    raised = history.basis[points] * factors[:, None, :]
    if use is None:
        return _peak(level, history, points, raised, times)
    if every:
        return use.anew(level, points, raised, history.coefficients, loaded.loads.cycles)
    pair = history.coefficients[:, list(use.worst(level).pair)]
    return use.of_states(level, raised @ pair, level.limits[points])
