"""Stress of a rung in the bores of a part, where pins press on narrower arcs, and unevenly.

A rung's pins press by half a cosine. A pin with clearance presses on less of the bore
(docs/theory/bearing.md): the rung's lugs are solved again for the cosine on arcs down to the
narrowest that the part states, as a solid is.

Bores whose arc of contact is not stated, or whose pin bends, may have more than that. Contacts
exceed the assumed arcs by a share that solids have in their model band. The bands of the rungs were
compared with solids on the arcs alone, evenly pressed along: they have neither.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import repeat
from math import pi
from weakref import WeakKeyDictionary

import numpy as np

from checks.design.data import COMPARED_ARC, Part
from checks.handbook.pin_loaded_hole import BEYOND_ARCS
from checks.models.formula_points import PRESSED_IN, on_arc
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
    even    the same with pins that do not bend
    most    the same on any of the arcs, and the largest beside bores; 0 where nothing does
    least   of the whole part, on the arc where it is least, not raised
    by_arc  arc, rad -> the value of the whole part, not raised; empty where the rung knows none
    evened  the largest with every bent pin, also those in no band; 0 where every one is in it
    loose   the largest in a bore on the narrowest arc, raised, and what a loose pin adds to it
    """

    half: float = 0.0
    even: float = 0.0
    most: float = 0.0
    least: float = 0.0
    by_arc: Mapping[float, float] | None = None
    evened: float = 0.0
    loose: tuple[float, float] = (0.0, 0.0)

    @property
    def reached(self) -> float:
        """The largest of all; 0 where nothing moves the value."""
        return max(self.most, sum(self.loose))


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
            _on_arcs[self.level.model] = self._built()
        return _on_arcs[self.level.model]

    def _built(self) -> dict[float, RungModel]:
        loads, found = self.loaded.loads, dict[float, RungModel]()
        for arc in arcs_of(self.loaded.part):
            # how hard a bush presses depends on the arc, too
            known = None if loads.press_fits else next(iter(found.values()), None)
            model = on_arc(known, loads, arc) if known else self._again(replace(loads, arc=arc))
            if model is not None:
                found[arc] = model
        return found

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


@dataclass(frozen=True, eq=False)
class _Asked:
    """Points of a rung's model, under more of the forces in the linkage's plane.

    As in a solid (checks/stress/error_bars.py), the stress of couples out of the plane and of
    bushes that are pressed in stays.

    model   of the level or of another arc
    uneven  bore -> how much more its bent pin presses; with such, the points are on rims
    more    times the forces in all bores
    """

    model: RungModel
    points: IntArray
    uneven: Mapping[str, Uneven] = field(default_factory=dict)
    more: float = 1.0

    @property
    def times(self) -> float:
        """The most that any force is raised by."""
        return self.more * max((one.most for one in self.uneven.values()), default=1.0)

    @property
    def places(self) -> list[str]:
        """Names of the places at the points."""
        return [self.model.places[point] for point in self.points]

    @property
    def basis(self) -> FloatArray:
        """Stress (n, 6, n_basis) of the model's unit loads, raised, MPa per unit."""
        basis = self.model.history.basis[self.points]
        if not self.uneven and self.more == 1.0:
            return basis
        factors: FloatArray = np.full((len(basis), basis.shape[2]), self.more)
        for bore, one in self.uneven.items():
            pressed = [name.startswith(f"{bore} ") for name, _ in self.model.units]
            here = [place == bore for place in self.places]
            factors[np.ix_(here, pressed)] *= one.most
        factors[:, _across(self.model)] = 1.0
        return basis * factors[:, None, :]


def in_bores(arcs: Arcs, use: FatigueUse | None, value: float) -> InBores:
    """Return how narrower arcs and uneven pressure move a check.

    use    how fatigue is judged; None for von Mises stress
    value  MPa, of the check, on the half circle
    """
    loaded, level, points = arcs.loaded, arcs.level, arcs.points
    part = loaded.part
    if part.body is None or loaded.loads.is_nothing or not len(points):
        return InBores(least=value)
    every = loaded.uneven
    counts = that_count(part, every, static=use is None)
    more = 1.0 if part.arc_stated else 1.0 + BEYOND_ARCS
    elsewhere, on_half = _on_half_circle(level, use, value, points)
    models = list(arcs.models.values())
    inside, beside = ([_Asked(model, some) for model in models] for some in (points, arcs.beside))
    found = _largest(level, use, [*inside, *beside])
    own, others = found[: len(models)], found[len(models) :]
    narrow = [max(values) for values in zip(own, others, repeat(elsewhere))]
    by_arc = {pi: value} | dict(zip(arcs.models, narrow, strict=True))
    plain = not _across(level.model).any()

    def on_half_circle(uneven: Mapping[str, Uneven]) -> float:
        if plain and not uneven:
            return more * on_half  # all of the stress is in proportion to what is raised
        raised = [_Asked(level.model, points, uneven, more)]
        return _any_two(level, use, raised) if use else max(_largest(level, use, raised))

    def on_arcs(uneven: Mapping[str, Uneven], besides: Sequence[_Asked], reached: float) -> float:
        if use is None and plain and not uneven:
            return max([reached, *(more * one for one in own)])
        raised = [_Asked(model, points, uneven, more) for model in models]
        reached = max([reached, *_largest(level, use, raised)])
        if use is None:
            return reached
        # in the bores another two positions may govern than in the part
        return max(reached, _any_two(level, use, [*raised, *besides], reached))

    half = on_half_circle(counts) if counts or not part.arc_stated else 0.0
    most = on_arcs(counts, beside, max([half, *others]))
    loose = (_pressed_loosely(arcs, use, bore, counts, more) for bore in loaded.loose)
    evened = on_arcs(every, (), on_half_circle(every)) if len(counts) < len(every) else 0.0
    known = by_arc if len(by_arc) > 1 else None
    even = min(half, more * on_half) if counts else half
    least, loosest = min(by_arc.values()), max(loose, key=sum, default=(0.0, 0.0))
    return InBores(half, even, most, least, known, evened, loosest)


def _pressed_loosely(
    arcs: Arcs, use: FatigueUse | None, bore: str, uneven: Mapping[str, Uneven], more: float
) -> tuple[float, float]:
    """The largest in a bore on its narrowest arc, raised, and what a loose pin adds at the most."""
    level, places = arcs.level, np.array(arcs.level.model.places)
    points = arcs.points[places[arcs.points] == bore]
    faces = arcs.loaded.part.geometry.placed_interfaces
    (face,) = (face for face in faces if face.name == bore)
    at = level.model.history.points
    points = points[arcs.loaded.loads.pressed(face, at[points], COMPARED_ARC)]
    if not len(points):
        return 0.0, 0.0
    bent = uneven[bore].most if bore in uneven else 1.0
    adds = arcs.loaded.loose[bore].times(bent)
    narrowest = [level.model, *arcs.models.values()][-1]
    asked = _Asked(narrowest, points, uneven, more)
    # what is added may be more than all that others have: at any positions, however light
    states, basis = narrowest.history.coefficients, asked.basis
    if use is None:
        found = StressHistory(points, at[points], basis, states).peaks_by_point()
        return float(found.max()), adds.peak
    return use.anew(level, points, basis, states), use.of_pressure(level, points, adds)


def _on_half_circle(
    level: RungLevel, use: FatigueUse | None, value: float, points: IntArray
) -> tuple[float, float]:
    """The largest beside the bores and in them, MPa; of fatigue beside them perhaps less."""
    history, others = level.history, np.setdiff1d(np.arange(len(level.history.points)), points)
    if use is None:
        inside = level.peak.point in points
        other = _peak(level, _Asked(level.model, others if inside else points))
        return (other, value) if inside else (value, other)
    known, used = level.judged_duty.known, level.judged_duty.bound[points]
    elsewhere = value * float(known[others].max(initial=0.0) / known.max())
    if known[points].max() == known.max():
        return elsewhere, value
    near = points[used >= _NEAR * used.max()]
    return elsewhere, use.anew(level, near, history.basis[near], history.coefficients)


def _across(model: RungModel) -> BoolArray:
    """Which columns of a model no pin raises."""
    return np.array([any(word in name for word in _ACROSS) for name, _ in model.units])


def _largest(level: RungLevel, use: FatigueUse | None, asked: Sequence[_Asked]) -> list[float]:
    """The largest of each, MPa: fatigue between the two positions that govern on the level."""
    if use is None:
        return [_peak(level, one) for one in asked]
    pair = list(use.worst(level).pair)
    states = [one.basis @ one.model.history.coefficients[:, pair] for one in asked]
    return use.of_states(level, states, [level.limits[one.points] for one in asked])


def _peak(level: RungLevel, one: _Asked) -> float:
    """The largest von Mises stress, MPa, at the positions that strain the level's part most."""
    if not len(one.points):
        return 0.0
    peaks, history = level.peaks_by_position, one.model.history
    states = history.coefficients[:, peaks >= _HIGH / one.times * peaks.max()]
    found = StressHistory(one.points, history.points[one.points], one.basis, states)
    return float(found.peaks_by_point().max())


def _any_two(
    level: RungLevel, use: FatigueUse, asked: Sequence[_Asked], reached: float = 0.0
) -> float:
    """The largest fatigue of all that are asked, MPa, between any two positions.

    reached  MPa: less need not be known
    """
    for one in reversed(asked):  # the narrowest arcs first, which are likely to have most
        some = replace(one, points=_near(level, one))
        if len(some.points):
            states, basis = one.model.history.coefficients, some.basis
            acts = basis.any(axis=(0, 1))
            own = np.ascontiguousarray(basis[:, :, acts])
            found = use.anew(level, some.points, own, states[acts], reached=reached)
            reached = max(reached, found)
    return reached


def _near(level: RungLevel, one: _Asked) -> IntArray:
    """The points where fatigue may be the largest: by the level's, and how much is more."""
    bound = level.judged_duty.bound
    share, least = _NEAR, 0.0
    if one.model is not level.model:  # also where it may exceed the part's largest
        share, least = _HIGH, _HIGH / one.times * bound.max()
    used, places = bound[one.points], np.array(one.places)
    most: FloatArray = np.zeros(len(used))
    for place in set(one.places):
        most[places == place] = used[places == place].max()
    return one.points[used >= np.maximum(share * most, least)]
