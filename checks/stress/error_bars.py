"""Stress at the worst point of a part, and its error bars from one mesh to the next.

A judged stress in bores whose contact is solved, between the nodes of the mesh.

Pressure under a loose pin rises and falls within an arc that may be narrower than the elements, and
what swings at its ends is narrower still. What else the bore's surface has of stress is as even as
the elements: it goes straight from node to node, and pressure is added where it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import degrees, pi
from weakref import WeakKeyDictionary

import numpy as np

from checks.design.data import COMPARED_ARC, Part
from checks.handbook.pin_loaded_hole import BEYOND_ARCS
from checks.part.loaded_part import Loose
from checks.part.part_loads import PartLoads
from checks.part.pressed_along import Uneven, raised_words, that_count, uncounted_words
from checks.result.words import by_arc_words
from checks.stress.beyond_even import BeyondEven, beyond_even
from checks.stress.clearances import (
    POSITIONS,
    OverClearances,
    over_clearances,
    some_positions,
    that_swing,
)
from checks.stress.judged import Judged, RaisedInBores, StaticPeak
from checks.stress.pins_in_bores import CLEARANCE_WORDS, MIDDLE
from checks.stress.solid_mesh_level import Level
from fem.contact.bore import BoreHarmonics
from fem.contact.cycle import BorePressure
from fem.convergence import (
    ORDER,
    ErrorBar,
    discretisation_error,
    growth_exponent,
    moves_like_singular,
)
from fem.recovery import von_mises
from fem.singularity import singular_exponent
from fem.unit_solutions import has_bearings
from geometry.mesh import FloatArray, IntArray

_SHORT_WAVES = 0.1  # of their stress: 0.005 to 0.11 was missed (docs/theory/contact.md)
_FEW = 64  # points that are judged at once, before their bound is asked again
_UNRESOLVED = 0.05  # error that elements make in a notch, over the peak


@dataclass(frozen=True)
class Bars:
    """Numerical error bar, model band above and below, and what must be said of them.

    values, sizes  MPa and mm: the quantity, and the elements at its place, mesh by mesh
    by_arc         arc of contact, rad -> the quantity under that pressure, MPa; empty without pins
    in_bores       the largest in the bores, raised, MPa; 0 where the arc is stated
    clearances     the quantity over the clearances that fits leave; None without fits
    along          the quantity where bent pins press unevenly; None where no stack tells
    above_steel    `above` with bushes as stiff as steel where their material is not stated
    evened         the quantity with all bent pins, MPa, where some of them are in no band; else 0
    """

    numerical: ErrorBar
    above: float
    below: float
    note: str
    values: Sequence[float] = ()
    sizes: Sequence[float] = ()
    by_arc: Mapping[float, float] = field(default_factory=dict)
    in_bores: float = 0.0
    clearances: OverClearances | None = None
    along: BeyondEven | None = None
    evened: float = 0.0
    above_steel: float = 0.0


def bars_of(
    judged: Judged,
    part: Part,
    levels: Sequence[Level],
    accuracy: float,
    uneven: Mapping[str, Uneven] | None = None,
    loose: Mapping[str, Loose] | None = None,
) -> Bars:
    """Numerical bar, model band and a note for a quantity known on several meshes.

    uneven  bore -> how much more its bent pin presses at the most, and where; it counts in bores
            whose contact is not solved
    loose   bore -> how much more a loose pin may press than on the assumed arcs
    """
    finest = levels[-1]
    value = judged.value(finest)
    arcs = arcs_of(part, finest)
    by_arc = dict(zip(arcs, judged.direct(finest, arcs), strict=True)) if arcs else {}
    clearances = over_clearances(judged, finest)
    values = [judged.value(level) for level in levels]
    sizes = sizes_at_peak(judged, levels)
    angle, exponent = singular_edge(judged, levels)
    own = float(finest.notch_errors[judged.point(finest)])
    order = finest.order(judged.point(finest))
    # while a mesh does not follow a notch yet the peak grows, too, and so does the stress beside a
    # pressed edge as elements come nearer: finite both, with an error in the bar
    follow = [k for k, size in enumerate(sizes) if own * (size / sizes[-1]) ** 2 <= _UNRESOLVED]
    grows, between = 0.0, missed_between_nodes(judged, finest)
    steady = len(values) < 2 or abs(values[-1] - values[-2]) > between  # else nodes came nearer
    if not exponent and order >= ORDER and steady:
        grows = growth_exponent([values[k] for k in follow], [sizes[k] for k in follow])
    bar = ErrorBar(
        discretisation_error(values, sizes, order),
        judged.scatter(finest),
        (_truncation(judged, levels, by_arc[pi], sizes) if by_arc else 0.0)
        + _missed_of_contact(judged, finest)
        + between
        + _of_short_waves(judged, finest),
        abs(value),
        exponent or grows,
        _notch_bar(judged, finest),
        order,
    )
    notes = []
    if exponent:
        notes.append(
            f"singular: a sharp re-entrant edge of {degrees(angle):.0f} deg, where stress grows "
            f"like 1/distance^{exponent:.2f} and {value:.4g} MPa is only what this mesh "
            "shows; give the edge its radius"
        )
    elif grows:
        notes.append(
            f"singular: the peak grows like 1/size^{grows:.2f} of the elements from mesh to mesh, "
            f"and {value:.4g} MPa is only what the last one shows"
        )
    elif bar.value > accuracy * abs(value):
        why = ": elements too large for the notch at the peak" if bar.notch_decides else ""
        if order < ORDER and not why:
            why = ": the peak lies where a pressure ends with a jump"
        notes.append(
            f"numerical error {100 * bar.value / abs(value):.2g} %, asked for {100 * accuracy:g} %"
            + why
        )
    if by_arc:
        notes.append(by_arc_words(by_arc))
    bars = Bars(bar, 0.0, 0.0, "; ".join(notes), values, sizes, by_arc, clearances=clearances)
    return banded(bars, judged, part, finest, uneven, loose)


def banded(
    bars: Bars,
    judged: Judged,
    part: Part,
    level: Level,
    uneven: Mapping[str, Uneven] | None = None,
    loose: Mapping[str, Loose] | None = None,
) -> Bars:
    """Return the bars with the model band of a part whose bores have edges as it states them.

    level  the last one; uneven, loose: as for `bars_of`
    """
    value, every = judged.value(level), uneven or {}
    by_arc, clearances = bars.by_arc, bars.clearances
    notes, arcs, in_bores, evened = [bars.note], list(by_arc), 0.0, 0.0
    if by_arc and len(level.in_bores) and (every or not part.arc_stated):
        static = isinstance(judged, StaticPeak)
        counts = that_count(part, every, static=static)
        more = 0.0 if part.arc_stated else BEYOND_ARCS
        if counts or not part.arc_stated:
            in_bores = max(judged.direct(level, arcs, RaisedInBores(more, counts)))
            for bore, adds in (loose or {}).items():
                points = pressed_points(judged.loads, level, bore)
                if not len(points):
                    continue
                under = RaisedInBores(more, counts, points)
                adds = adds.times(counts[bore].most if bore in counts else 1.0)
                worst = judged.deciding_at(level, points)
                (own,) = judged.direct(level, arcs[-1:], under, worst)
                in_bores = max(in_bores, own + judged.of_pressure(level, points, adds))
            pressed = {bore: one.peak for bore, one in (loose or {}).items()}
            notes.append(f"model band: {raised_words(part, counts, pressed)}")
        if len(counts) < len(every):
            evened = max(value, *judged.direct(level, arcs, RaisedInBores(more, every)))
            notes.append(uncounted_words(part, every, evened, static=static))
    reached = [*by_arc.values(), in_bores]
    above = max(reached) - by_arc[pi] if by_arc else 0.0
    below = max((by_arc[pi] - other for other in by_arc.values()), default=0.0)
    if clearances is not None:
        by = ", ".join(f"{word} {clearances.values[s]:.4g}" for s, word in CLEARANCE_WORDS.items())
        ends = f"{min(clearances.values.values()):.4g} to {max(clearances.values.values()):.4g}"
        notes.append(f"by clearance of the pins, MPa: {by}; over all of them {ends}")
        above += clearances.above
        below += clearances.below
    along = beyond_even(judged, level, part)
    if along is not None:
        evened = along.bent if along.uneven != along.bent else 0.0
        notes.append(along.words)
        above += along.above
        below += along.below
    steel = above
    if clearances is not None and clearances.soft is not None:  # even along, and on a wider arc
        notes.append(f"with bushes that are soft {clearances.soft:.4g} MPa")
        above, below = max(above, clearances.soft - value), max(below, value - clearances.soft)
    return replace(
        bars,
        above=above,
        below=below,
        note="; ".join(text for text in notes if text),
        in_bores=in_bores,
        along=along,
        evened=evened,
        above_steel=steel,
    )


def pressed_points(loads: PartLoads, level: Level, bore: str) -> IntArray:
    """Surface points (n,) in a bore where its pin presses on the narrowest assumed arc."""
    points = level.in_bores_of(bore)
    faces = (unit.interface for unit in level.solutions.interfaces)
    (face,) = (face for face in faces if face.name == bore)
    return np.asarray(points[loads.pressed(face, level.history.points[points], COMPARED_ARC)])


def mesh_bar(judged: Judged, levels: Sequence[Level]) -> float:
    """The part of the numerical bar that a finer mesh makes smaller, over the value."""
    values = [judged.value(level) for level in levels]
    finest, value = levels[-1], abs(values[-1])
    if not value:
        return 0.0
    point = judged.point(finest)
    left = discretisation_error(values, sizes_at_peak(judged, levels), finest.order(point))
    notch = _notch_bar(judged, finest)
    scatter = judged.scatter(finest, of_edges=False)
    order = finest.order(point)
    return ErrorBar(left, scatter, 0.0, value, 0.0, notch, order).mesh / value


def _notch_bar(judged: Judged, level: Level) -> float:
    """How far elements in notches may carry the quantity too low, MPa, sought once.

    At its point, or at another one whose elements are so much larger that it may well be used more
    than its own shows: a mesh that is fine somewhere finds its peak there, not where the peak is.
    """
    known = _notch_bars.setdefault(level, WeakKeyDictionary())
    if judged not in known:
        known[judged] = _missed_in_notches(judged, level)
    return known[judged]


_notch_bars: WeakKeyDictionary[Level, WeakKeyDictionary[Judged, float]] = WeakKeyDictionary()


def _missed_in_notches(judged: Judged, level: Level) -> float:
    value, errors = judged.value(level), level.notch_errors
    most = float(errors[judged.point(level)]) * abs(value)
    points = np.setdiff1d(np.flatnonzero(errors > _UNRESOLVED), level.left_out)
    found, _ = _largest(judged, level, points, 1 + errors[points], value + most)
    return max(most, found - value)


def _largest(
    judged: Judged, level: Level, points: IntArray, times: FloatArray, least: float
) -> tuple[float, int]:
    """The largest of the quantity times a factor over some points, and its point.

    least  MPa; where no point has more, 0 and the first of them
    """
    highest = judged.bound(level, points) * times
    order, best, where = (
        np.argsort(-highest, kind="stable"),
        0.0,
        int(points[0]) if len(points) else 0,
    )
    for first in range(0, len(order), _FEW):
        some = order[first : first + _FEW]
        some = some[highest[some] > max(best, least)]
        if not len(some):
            break
        found = judged.at(level, points[some]) * times[some]
        if found.max() > best:
            best, where = float(found.max()), int(points[some[found.argmax()]])
    return best, where


def _truncation(
    judged: Judged, levels: Sequence[Level], direct: float, sizes: Sequence[float]
) -> float:
    """Truncation error of the bearing series, with what its measure may still change by.

    A half cosine ends with a kink: what it differs by from its series converges with order 1.
    """
    before, finest = levels[-2], levels[-1]
    missing = [judged.direct(before, [pi])[0] - judged.value(before), direct - judged.value(finest)]
    return abs(missing[1]) + discretisation_error(missing, sizes[-2:], 1.0)


def _missed_of_contact(judged: Judged, level: Level) -> float:
    """How far the quantity is off by pressure that the patterns of short waves miss, MPa.

    At its point, or as another point of a bore is used more with it: those that may be are judged
    again, with all of their pressure.
    """
    contact = level.contact
    if contact is None:
        return 0.0
    value, own = judged.value(level), judged.point(level)
    points = np.flatnonzero(contact.most_missed)
    missed = contact.most_missed[points]
    if not isinstance(judged, StaticPeak):  # MPa of pressure, in the measure of the quantity
        missed = missed * np.maximum(1.0, level.judged_duty.limit / judged.endured(level, points))
    may = judged.bound(level, points) + missed > value
    points = np.setdiff1d(points[may], level.left_out)
    off = 0.0
    for some in (points, np.intersect1d(points, [own])):
        if not len(some):
            continue
        stress, pressures = contact.with_missed(some)
        found = judged.anew(
            level,
            some,
            np.concatenate([level.history.basis[some], stress], axis=2),
            np.concatenate([level.coefficients, pressures]),
        )
        off = max(off, found - value, abs(found - value) if own in some and len(some) == 1 else 0.0)
    return off


def _of_short_waves(judged: Judged, level: Level) -> float:
    """How far the quantity may be off, MPa, as short waves are taken as those of a sheet."""
    if level.contact is None:
        return 0.0
    waves = level.contact.short_waves
    stress = level.history.basis[judged.point(level)][:, waves] @ judged.states(level)[0][waves]
    return _SHORT_WAVES * float(von_mises(stress))


def sizes_at_peak(judged: Judged, levels: Sequence[Level]) -> list[float]:
    """Size of the elements of every mesh where the last one has its peak, mm."""
    finest = levels[-1]
    place = finest.history.points[judged.point(finest)]
    return [level.size_at(level.nearest(place)) for level in levels]


def arcs_of(part: Part, level: Level) -> list[float]:
    """Arcs of contact: the half circle of the unit loads, and down to the narrowest stated."""
    if not has_bearings(level.solutions, level.solved_bores):
        return []
    narrow = part.bearing_arc
    return [pi] if narrow >= pi else [pi, (pi + narrow) / 2, narrow]


def singular_edge(judged: Judged, levels: Sequence[Level]) -> tuple[float, float]:
    """Interior angle (rad) and exponent of a sharp re-entrant edge that spoils a peak, else 0, 0.

    An edge counts if it carries at least half the peak and its largest value moves with the mesh.
    A sharp edge of the body is sharp on every mesh; what only some show is a coarse fillet.
    """
    if not all(len(level.edges[0]) for level in levels):
        return 0.0, 0.0
    values, sizes, worst = [], [], 0
    for level in levels:
        on_edge = level.edges[0]
        found, worst = _largest(judged, level, on_edge, np.ones(len(on_edge)), 0.0)
        values.append(found)
        sizes.append(level.size_at(worst))
    points, angles = levels[-1].edges
    angle = float(angles[points == worst][0])
    exponent = singular_exponent(angle)
    if values[-1] >= judged.value(levels[-1]) / 2 and moves_like_singular(values, sizes, exponent):
        return angle, exponent
    return 0.0, 0.0


_FINER = 2  # times as many hats of pressure
_MOST = 24  # places from one node to the next
_TOGETHER = 4000
_LEAST = 0.9  # of the value: what does not reach it there is not sought


def missed_between_nodes(judged: Judged, level: Level) -> float:
    """How far the quantity is off, MPa, by what pressure does between nodes, and by its hats.

    Sought at the middle of the clearances, over some positions of every cycle, with twice as many
    hats. Where it is judged in a bore it may be off either way.
    """
    contact = level.contact
    if contact is None:
        return 0.0
    value, own = judged.value(level), judged.point(level)
    positions, cycles = some_positions(judged.loads, level, [judged], POSITIONS)
    finer = contact.finer(positions, _FINER)
    coarse = contact.over(positions, MIDDLE)
    in_bore = any(own in bore.points for bore in contact.pins.harmonics)
    best = _LEAST * value if in_bore else value
    states, whole = level.coefficients[:, positions], np.eye(len(positions))
    for bore, missed in zip(contact.pins.harmonics, contact.missed, strict=True):
        name = bore.loads.interface.name
        nodes = level.history.basis[bore.points] @ states
        known = coarse.bores[name].at(bore.angles) - missed[:, positions]
        places = _Places(bore, nodes, known, finer.bores[name])
        if isinstance(judged, StaticPeak):
            bound = von_mises(np.moveaxis(nodes, 1, -1)).max(axis=1)
            rise = np.abs(places.more).max(axis=1)
        else:
            duty = level.judged_duty
            bound, endured = (found(level, bore.points) for found in (judged.bound, judged.endured))
            rise = np.ptp(places.more, axis=1) / 2 * duty.limit / endured[places.ends].min(axis=1)
            rise += np.abs(places.more).max(axis=1) * duty.limit / duty.ultimate
        most = bound[places.ends].max(axis=1) + rise
        order = np.argsort(-most, kind="stable")
        order = order[~np.isin(bore.points[places.nearer[order]], level.left_out)]
        for first in range(0, len(order), _TOGETHER):
            some = order[first : first + _TOGETHER]
            some = some[most[some] > best]
            if not len(some):
                break
            stress, points = places.stress(some), bore.points[places.nearer[some]]
            if not isinstance(judged, StaticPeak):
                kept = that_swing(level, endured[places.nearer[some]], stress, best)
                stress, points = stress[kept], points[kept]
            if len(points):
                best = max(best, judged.anew(level, points, stress, whole, cycles, states))
    return abs(best - value)


class _Places:
    """Places on the sides of a bore's elements, from each node towards its neighbours.

    ends    (n, 2) nodes, of the bore's points, that each is between; nearer: (n,) the nearer one
    more    (n, m) MPa, pressure there less what the stress at the nodes has of it
    """

    def __init__(
        self, bore: BoreHarmonics, nodes: FloatArray, known: FloatArray, pressure: BorePressure
    ) -> None:
        """Place them; nodes (n_points, 6, m) MPa, of which `known` (n_points, m) is pressure."""
        sides, turns = bore.sides
        widest = float(np.abs(turns).max(initial=0.0))
        count = int(np.clip(np.ceil(widest / pressure.hats.widths.min()), 2, _MOST))
        shares = np.arange(count) / count
        self.ends: IntArray = np.repeat(sides, count, axis=0)
        self._share: FloatArray = np.tile(shares, len(sides))
        angles = (bore.angles[sides[:, :1]] + turns[:, None] * shares).ravel()
        self.nearer = np.where(self._share < 0.5, *self.ends.T)
        self._bore, self._nodes = bore, nodes
        self.more = pressure.at(angles) - self._between(known, slice(None))

    def _between(self, at_nodes: FloatArray, some: IntArray | slice) -> FloatArray:
        share = self._share[some].reshape(-1, *[1] * (at_nodes.ndim - 1))
        left, right = self.ends[some].T
        return np.asarray((1 - share) * at_nodes[left] + share * at_nodes[right])

    def stress(self, some: IntArray) -> FloatArray:
        """Stress (n, 6, m), MPa, at some of the places (n,)."""
        own = self._bore.short_wave_stress[self.nearer[some]][:, :, None]
        return self._between(self._nodes, some) + own * self.more[some][:, None, :]
