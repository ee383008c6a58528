"""Stress of a rung in the bores of a part, where pins press on narrower arcs, and unevenly.

The stress of a rung is that of a pressure half a cosine wide. A pin with clearance presses on less
of the bore (docs/theory/bearing.md): the rung's lugs are solved again for the cosine on arcs down
to the narrowest that the part states, as a solid is.

Bores whose arc of contact is not stated, or whose pin bends, may have more than that. Contacts
exceed the assumed arcs by a share that solids have in their model band. The bands of the rungs were
compared with solids on the arcs alone, evenly pressed along: they have neither.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import pi

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
from geometry.mesh import FloatArray, IntArray

Again = Callable[[PartLoads], RungModel | None]
_PRESSURE = " cos 0"  # the unit load that only an interface with a bearing pressure has
# in names of unit loads: couples out of the linkage's plane, and bushes, which no pin raises
_ACROSS = ("M_x", "M_y", "torque", PRESSED_IN)
_NEAR = 0.8  # of the largest fatigue use in bores: points that are asked again


@dataclass(frozen=True)
class InBores:
    """Stress of a check where arcs of contact are narrower and pins press unevenly, MPa.

    half    the largest in bores, pressed on the half circle, raised; 0 where nothing raises it
    most    the same on any of the arcs; 0 where nothing does
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


def in_bores(
    loaded: LoadedPart, level: RungLevel, use: FatigueUse | None, value: float, again: Again
) -> InBores:
    """Return how narrower arcs and uneven pressure move a check.

    use    how fatigue is judged; None for von Mises stress
    value  MPa, of the check, on the half circle
    again  builds the rung's model under other loads
    """
    part, loads = loaded.part, loaded.loads
    if part.body is None or loads.is_nothing:
        return InBores(least=value)
    every = loaded.uneven
    counts = that_count(part, every, static=use is None)
    more = 1.0 if part.arc_stated else 1.0 + BEYOND_ARCS
    raises = not part.arc_stated or bool(counts)
    points = _in_bores(level)
    if not len(points):
        return InBores(least=value)
    half = _largest(loaded, level, level.model, use, points, counts, more) if raises else 0.0
    most, by_arc = half, {pi: value}
    elsewhere = _elsewhere(level, use, value, points)
    models = [level.model]
    for arc in arcs_of(part):
        model = again(replace(loads, arc=arc))
        assert model is not None
        models.append(model)
        own = _largest(loaded, level, model, use, points, {}, 1.0)
        by_arc[arc] = max(own, elsewhere)
        raised = _largest(loaded, level, model, use, points, counts, more) if raises else own
        most = max(most, raised)
    evened = 0.0
    if len(counts) < len(every):
        evened = max(_largest(loaded, level, one, use, points, every, more) for one in models)
    known = by_arc if len(by_arc) > 1 else None
    return InBores(half, most, min(by_arc.values()), known, evened)


def _in_bores(level: RungLevel) -> IntArray:
    """The points of a rung's model on the rims of bores that a pin presses."""
    bores = _bores(level.model)
    return np.flatnonzero([place in bores for place in level.model.places])


def _bores(model: RungModel) -> set[str]:
    units = [name for name, _ in model.units]
    return {name.removesuffix(_PRESSURE) for name in units if name.endswith(_PRESSURE)}


def _elsewhere(level: RungLevel, use: FatigueUse | None, value: float, points: IntArray) -> float:
    """The largest beside the bores, MPa, or less."""
    others = np.setdiff1d(np.arange(len(level.history.points)), points)
    if not len(others):
        return 0.0
    if use is None:
        return float(level.history.peaks_by_point()[others].max())
    known = level.judged_duty.known
    return value * float(known[others].max() / known.max())


def _largest(
    loaded: LoadedPart,
    level: RungLevel,
    model: RungModel,
    use: FatigueUse | None,
    points: IntArray,
    uneven: Mapping[str, Uneven],
    more: float,
) -> float:
    """The largest stress in bores, MPa, under more of the forces in the plane.

    As in a solid (checks/stress/error_bars.py), the stress of couples out of the plane and of
    bushes that are pressed in stays.

    model   the rung's, of the level or of another arc
    points  of the bores
    uneven  bore -> how much more its bent pin presses
    more    times the forces in all bores
    """
    units, history = [name for name, _ in model.units], model.history
    places = np.array(model.places)[points]
    if use is not None and model is level.model:
        used = level.judged_duty.bound[points]
        most = {bore: used[places == bore].max() for bore in set(places)}
        near = used >= _NEAR * np.array([most[bore] for bore in places])
        points, places = points[near], places[near]
    across = np.array([any(word in name for word in _ACROSS) for name in units])
    factors: FloatArray = np.full((len(points), len(units)), more)
    for bore, one in uneven.items():
        pressed = np.array([name.startswith(f"{bore} ") for name in units])
        factors[np.ix_(places == bore, pressed)] *= one.most
    factors[:, across] = 1.0
    raised = history.basis[points] * factors[:, None, :]
    if use is not None:
        return use.anew(level, points, raised, history.coefficients, loaded.loads.cycles)
    own = history.nodes[points], history.points[points]
    return float(StressHistory(*own, raised, history.coefficients).peaks_by_point().max())
