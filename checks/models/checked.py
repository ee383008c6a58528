"""Checks of a part by a rung below the solid, with its calibrated bars.

Around a pin the largest stress may lie between the angles at which a model has its points. Around a
section every component of stress is a trigonometric polynomial of the angle, of a degree below half
the number of points, so that its values at even angles give it at all angles exactly:

    f(a) = sum_k f(a_k) D(a - a_k),   D(x) = (1 + 2 sum_(m < n/2) cos m x)/n

Where a section comes near the largest, static or of fatigue, it is asked at finer and finer angles;
those where it is largest join the model's points. So a pin's result does not depend on how it lies
in its axes.

An `Estimate` is a check by any model; its bars leave the verdict open or not.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from checks.columns.stability import ELASTIC, FAR
from checks.design.data import Part
from checks.design.effort import FORMULA
from checks.models.bands import (
    SHARE,
    Band,
    NoBand,
    band_of,
    proportions_known,
    proportions_of,
    thin_wall,
    turned_otherwise,
    unknown_load,
    walls_known,
)
from checks.models.in_bores import Again, Arcs, InBores, in_bores
from checks.models.shapes import family_of
from checks.models.stress_words import fatigue_check, static_check
from checks.part.derived import VALUE, at_value
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.part.pressed_along import raised_words, that_count, uncounted_words
from checks.result.verdict import Check, Status
from checks.result.words import UNKNOWN_BAR, by_arc_words
from checks.strength.fatigue_assessment import FatigueUse
from checks.strength.part_strength import endurance_of
from checks.strength.sampling import buckling_rise, fatigue_rise, static_rise, with_sampling
from checks.stress.duty_verdict import duty_runs, most_used
from checks.stress.stress_result import ElasticLoad, RungLevel, RungModel, judge
from fem.stress_history import StressHistory
from geometry.mesh import FloatArray, IntArray

GUARD = 1.5  # times the bars of a rung: what climbing stops at must not flip by a solid
_NEARLY = 0.97  # of the largest: sections and angles beside which there may be more
_FINER = 5  # times, from one round to the next
_ROUNDS = 5  # from 15 degrees to 0.005: the peak, flat there, is missed by 1e-8
_MOST = 16  # angles that are followed
_ROUND_OFF = 1e-12  # of the largest wave of a stress around its ring
_SAME = 1e-6  # of a degree's radians: two points are one
# Of a history's points with their fretting (n,): what is judged where it is known, exact at the
# worst, and a bound (n,) that it does not exceed.
Values = Callable[[StressHistory, FloatArray], tuple[FloatArray, FloatArray]]
STATIC, FATIGUE, BUCKLING = "static", "fatigue", "buckling"
BALANCE = 1e-6  # of the largest force: what may be left of a part's balance
MOST_PULLED = 10.0  # times a bent part's share; solids of levers have 0.42 to 0.91 times it
# Times a bar's share beyond all proportions compared, and what its peak stress adds: of 165 solids
# within them none has more than 1.01 times it, of 93 beyond them none more than 1.11 times.
MOST_FAR = 2.0
MOST_BENT = 3.2  # of a plate that bends, which is laid straight as a bar: 1.71 was seen
# Peak stress over E that a solid's share may exceed a bar's by: beyond the proportions compared,
# where 4.0 was seen, and within them, where 2.1 was.
BY_STRESS = 12.0
STOUT = 2.5
ONLY_PULLED = "the part is only pulled, which buckles no column"
NOTHING = "nothing loads the part at any position: no model would find a stress"


@dataclass(frozen=True)
class Estimate:
    """A check, and which part of its model band a better model can take away.

    check         with its bars, all of them
    above, below  of the model band: how far the rung's own error reaches, in the check's unit
    guard         times the rung's own error that must leave the verdict as it is
    error         (above, below) of those: without arcs, which solids have, too; None: all of them
    bores         of a formula: how narrower arcs and uneven pressure move it; None of other checks
    """

    check: Check
    above: float = 0.0
    below: float = 0.0
    guard: float = GUARD
    error: tuple[float, float] | None = None
    bores: InBores | None = None

    @property
    def spread(self) -> float:
        """All that a better model can take away, over the value."""
        value = self.check.value
        return (self.above + self.below + 2 * self.check.numerical) / value if value else 0.0

    @property
    def settled(self) -> bool:
        """True if a better model cannot be expected to change the verdict, guard included."""
        if self.check.status is Status.UNDECIDED:
            return False
        return self._widened(self.guard).status is self.check.status

    @property
    def open_for_good(self) -> bool:
        """True if no better model would settle it: the bars that all models share leave it open."""
        if self.check.status is not Status.UNDECIDED:
            return False
        low = self._moved(-self.below - self.check.numerical)
        high = self._moved(self.above + self.check.numerical)
        return low is Status.UNDECIDED and high is Status.UNDECIDED

    def agrees(self, other: "Estimate") -> bool:
        """True if the bars of two models of one check overlap."""
        (low, high), (lowest, highest) = self._ends, other._ends
        return low <= highest and lowest <= high

    @property
    def _ends(self) -> tuple[float, float]:
        """Where the bars end."""
        check = self.check
        return (
            check.value - check.numerical - check.below,
            check.value + check.numerical + check.model,
        )

    @property
    def _shared_above(self) -> float:
        return max(0.0, self.check.model - self.above) if self.check.model < inf else 0.0

    @property
    def _shared_below(self) -> float:
        return max(0.0, self.check.below - self.below) if self.check.below < inf else 0.0

    def _widened(self, guard: float) -> Check:
        check, (above, below) = self.check, self.error or (self.above, self.below)
        return replace(
            check,
            numerical=guard * check.numerical,
            model=check.model + (guard - 1) * above,
            model_below=check.below + (guard - 1) * below,
        )

    def _moved(self, by: float) -> Status:
        """Status of a better model's check with the value moved and only the shared band left."""
        if not abs(by) < inf:
            return Status.PASS  # unknown: a better model may say anything
        return replace(
            self.check,
            value=max(0.0, self.check.value + by),
            numerical=0.0,
            model=self._shared_above,
            model_below=self._shared_below,
        ).status


def rung_level(loaded: LoadedPart, model: RungModel, *, all_round: bool = True) -> RungLevel:
    """Judge the stress of a rung's model over all cycles of the design.

    all_round  True to seek the largest around a pin between the angles of its points
    """
    part, loads = loaded.part, loaded.loads
    limit = endurance_of(part).value
    ultimate, cycles = part.material.ultimate_stress, loaded.duty.cycles
    if model.ring and all_round and not loads.is_nothing:
        model = with_peaks(model, static_values)
        runs = duty_runs(loads.cycles, cycles)

        def used(history: StressHistory, fretting: FloatArray) -> tuple[FloatArray, FloatArray]:
            return most_used(history.basis, history.coefficients, limit / fretting, ultimate, runs)

        if runs:
            model = with_peaks(model, used)
    limits = limit / model.fretting
    judged = judge(model.history, limits, limit, ultimate, loads, cycles)
    return RungLevel(**judged, model=model)


def rung_estimates(
    loaded: LoadedPart,
    level: RungLevel,
    use: FatigueUse | None,
    again: Again,
    kinds: Collection[str] = (STATIC, FATIGUE, BUCKLING),
) -> dict[str, Estimate]:
    """The checks of some kinds that a rung answers, by kind.

    use    how the part's fatigue is judged; None where no cycle of the duty loads it
    again  builds the rung's model under other loads
    """
    loads, arcs = loaded.loads, Arcs(loaded, level, again)
    found: dict[str, Estimate] = {}
    if STATIC in kinds:
        check = with_sampling(static_check(loaded, level, FORMULA), static_rise(level, loads))
        found[STATIC] = _stress_estimate(arcs, check, None)
    if FATIGUE in kinds and use is not None:
        check = fatigue_check(loaded, level, use, FORMULA)
        check = with_sampling(check, fatigue_rise(level, loads, use))
        found[FATIGUE] = _stress_estimate(arcs, check, use)
    load = level.model.buckling if BUCKLING in kinds else None
    if load is not None and load.share > 0.0:
        found[BUCKLING] = _buckling_estimate(loaded, level.model, buckling_rise(loads, load, again))
    return found


def _stress_estimate(arcs: Arcs, check: Check, use: FatigueUse | None) -> Estimate:
    loaded, bores = arcs.loaded, in_bores(arcs, use, check.value)
    if bores.evened:
        largest = max(bores.evened, check.value)
        even = uncounted_words(loaded.part, loaded.uneven, largest, static=use is None)
        check = replace(check, note="; ".join(text for text in (check.note, even) if text))
    if loaded.loads.is_nothing:
        return Estimate(_told(check, 0.0, 0.0, NOTHING))
    return replace(_with_band(loaded, arcs.level.model, check, bores), bores=bores)


def _buckling_estimate(loaded: LoadedPart, model: RungModel, rise: float) -> Estimate:
    loads = loaded.loads
    assert model.buckling is not None
    position = model.buckling.position
    check = Check(
        part=loaded.part.name,
        kind=BUCKLING,
        quantity=ELASTIC.quantity,
        value=model.buckling.share,
        unit="",
        numerical=0.0,
        model=0.0,
        limit=1.0,
        required=ELASTIC.safety(loaded.required),
        cycle=loads.cycle_names[position],
        position=loads.labels[position],
        place="whole part",
        method=FORMULA,
        basis="elastic, both ends held sideways and free to tilt: knows neither yield nor "
        "crookedness",
        note=model.buckling.words,
        plane=model.buckling.plane,
        span=model.buckling.span,
    )
    return _with_band(loaded, model, with_sampling(check, rise))


def _with_band(
    loaded: LoadedPart, model: RungModel, check: Check, bores: InBores | None = None
) -> Estimate:
    """The check with the band of solids around the rung's value.

    bores  how narrower arcs and uneven pressure move its value
    """
    band, value = band_around(loaded.part, loaded.loads, model, check), check.value
    above, below = (
        at_value(check, items) if items else inf
        for items in band.formulas(VALUE, check.unit, value, bores)
    )
    if isinstance(band, NoBand):  # only the least, and perhaps the most, plausible value are known
        said = band.why if above < inf else f"{UNKNOWN_BAR}{band.why}"
        return Estimate(_told(check, above, below, said), above, below)
    shared, said = band.above[0] * value, _of_solids(band, model)
    if bores is not None and bores.half > value:
        shared = bores.half * (1 + band.above[0]) - value
    error = (above - shared, below - band.shared_below * value)
    if bores is not None and bores.by_arc:
        error = (above - max(bores.reached - value, 0.0), below - (value - bores.least))
    if bores is not None and bores.by_arc and max(bores.by_arc.values()) > bores.least:
        said = f"{said}; {by_arc_words(bores.by_arc)}"
    if bores is not None and bores.half > value:  # solved contact knows how a bent pin presses
        shared = max(bores.even, value) * (1 + band.above[0]) - value
    if bores is not None and bores.half and bores.reached > value:
        counts = that_count(loaded.part, loaded.uneven, static=check.kind == STATIC)
        pressed = {bore: one.peak for bore, one in loaded.loose.items()}
        said = f"{said}; model band: {raised_words(loaded.part, counts, pressed)}"
    told = _told(check, above, below, said)
    return Estimate(told, above - shared, below - band.shared_below * value, error=error)


def band_around(part: Part, loads: PartLoads, model: RungModel, check: Check) -> Band | NoBand:
    """Where solids lie around a rung's check, or why that is not known."""
    unknown = unknown_load(part, loads)
    if unknown:
        return NoBand(unknown)
    if model.residual > BALANCE:
        return NoBand(f"the rung {FORMULA} leaves {model.residual:.3g} of the loads out of balance")
    if not check.value > 0.0:
        return NoBand(f"the rung {FORMULA} finds nothing where the part is loaded")
    if part.loose_pin and check.kind != BUCKLING:
        return NoBand(
            "a fit is stated with which contact may exceed what assumed arcs make: it is solved on "
            "a solid only"
        )
    if check.kind == BUCKLING and model.buckling is not None and model.buckling.weakest is not None:
        return _of_sections(part, model, check, model.buckling)
    proportions = proportions_of(part, loads)
    if check.kind == BUCKLING and model.buckling is not None and model.buckling.pulled:
        return _of_pulled(part, model, check, proportions)
    family = family_of(part, loads, check.kind)
    band = band_of(family, FORMULA, check.kind, proportions)
    if check.kind != BUCKLING and isinstance(band, Band):
        turned = turned_otherwise(family, FORMULA, check.kind, part, loads)
        return NoBand(turned) if turned else band
    if check.kind == BUCKLING and isinstance(band, NoBand):
        return _of_far(part, model, check, proportions, band)
    if check.kind == BUCKLING and isinstance(band, Band):
        times = BY_STRESS if band.wider else STOUT
        more = times / BY_STRESS * stress_share(part, model) / check.value
        said = f"a stout body may have {times:g} times its peak stress over E more"
        near = check.value * check.required * FAR > 1.0  # as solids ask for it
        fixity = model.buckling.fixity if near and model.buckling is not None else 0.0
        forks = f"fixity: forks that hold its ends would take up to {100 * fixity:.0f} % of it"
        texts = (band.wider, said, forks if fixity else "")
        wider = "; ".join(text for text in texts if text)
        above = (band.above[0], band.above[1] + more)
        return replace(band, above=above, wider=wider, fixity=fixity)
    return band


def _of_pulled(
    part: Part, model: RungModel, check: Check, proportions: Mapping[str, float]
) -> NoBand:
    """Bound on the buckling of a part that is hardly pressed, where no wall buckles by itself."""
    thin = thin_wall(proportions)
    pushed = proportions.get(f"{SHARE}pushed", 0.0)
    owner = f"the part is hardly pressed, by {pushed:.2g} of its largest force"
    told = owner if pushed > 0.0 else ONLY_PULLED
    if thin or not proportions_known(part):
        return NoBand(f"{told}, but {thin or 'its walls are not known'}")
    most = MOST_PULLED + stress_share(part, model) / check.value
    bound = f"{MOST_PULLED:g} times the share of what bends or presses it, the pull left out"
    return _bounded(told, bound, most, BY_STRESS)


def _of_far(
    part: Part, model: RungModel, check: Check, proportions: Mapping[str, float], band: NoBand
) -> NoBand:
    """Bound on the buckling of a bar unlike all that were compared, where no wall is thin."""
    if not walls_known(proportions) or thin_wall(proportions):
        return band
    times = MOST_BENT if "bend, deg" in proportions else MOST_FAR
    most = times + stress_share(part, model) / check.value
    return _bounded(band.why, f"{times:g} times the bar's share", most, BY_STRESS)


def _of_sections(part: Part, model: RungModel, check: Check, load: ElasticLoad) -> NoBand:
    """Bound on the buckling of a bar of any sections, by the weakest of them and its walls."""
    assert load.weakest is not None
    times = MOST_PULLED if load.pulled else MOST_FAR
    most = (times * load.weakest + load.local * stress_share(part, model)) / check.value
    bound = f"{times:g} times the share of the weakest section all along, {load.weakest:.3g}"
    return _bounded("no solids like it were compared", bound, most, BY_STRESS * load.local)


def _bounded(why: str, bound: str, most: float, by_stress: float) -> NoBand:
    """No band, but a bound above: a multiple of the value, in words, and what the stress adds."""
    bound = f"{bound}, and {by_stress:.4g} times its peak stress over E"
    return NoBand(f"{why}; {bound} bound how it could give way", 0.0, most, bound)


def stress_share(part: Part, model: RungModel) -> float:
    """Share by which a solid may have more than a bar: stout bodies buckle at stresses of E's size.

    `BY_STRESS` times the largest von Mises stress of the model over E.
    """
    values, _ = model.history.peaks_by_position()
    return BY_STRESS * float(values.max()) / part.material.youngs_modulus


def _told(check: Check, above: float, below: float, said: str) -> Check:
    note = "; ".join(text for text in (check.note, said) if text)
    return replace(check, model=above, model_below=below, note=note)


def _of_solids(band: Band, model: RungModel) -> str:
    return (
        f"95 % of {band.count} solids lie {100 * (band.low - 1):+.0f} to "
        f"{100 * (band.high - 1):+.0f} % from this; neglects {model.neglects}"
        + (f"; {band.wider}" if band.wider else "")
    )


def with_peaks(model: RungModel, judged: Values) -> RungModel:
    """Return a model of rings of points with the point of one more, where `judged` is largest."""
    count = model.ring
    finest = count * _FINER**_ROUNDS  # angles are numbers of these parts of a turn
    followed = _largest(*judged(model.history, model.fretting), _NEARLY)
    followed = followed[followed < len(model.history.points) // count * count]
    rings, parts = followed // count, followed % count * _FINER**_ROUNDS
    # the nearest angle, half a step off, is lower by at most degree^2/8 step^2 (Bernstein)
    lower = _degree(model) ** 2 / 7
    for k in reversed(range(_ROUNDS)):
        beside = _FINER**k * np.arange(-_FINER, _FINER + 1)
        places = rings[:, None] * finest + (parts[:, None] + beside) % finest
        _, first = np.unique(places, return_index=True)  # windows of neighbours overlap
        rings, parts = np.divmod(places.ravel()[np.sort(first)], finest)
        at = _around(model, rings, 2 * np.pi / finest * parts)
        step = 2 * np.pi / finest * _FINER**k
        best = _largest(*judged(at, model.fretting[rings * count]), 1 - lower * step**2)
        rings, parts = rings[best], parts[best]
    ring = rings[:1]
    more = _around(model, ring, 2 * np.pi / finest * parts[:1])
    history = model.history
    if np.min(np.linalg.norm(history.points - more.points, axis=1)) < _SAME:
        return model
    together = StressHistory(
        np.arange(len(history.points) + 1),
        np.concatenate([history.points, more.points]),
        np.concatenate([history.basis, more.basis]),
        history.coefficients,
    )
    return replace(
        model,
        history=together,
        places=[*model.places, model.places[int(ring[0]) * count]],
        fretting=np.append(model.fretting, model.fretting[ring * count]),
    )


def static_values(history: StressHistory, _: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The largest von Mises stress (n,) of each point, MPa."""
    found = history.peaks_by_point()
    return found, found


def _largest(values: FloatArray, bounds: FloatArray, share: float) -> IntArray:
    """The places that may have at least a share of the largest value, the one that has it first."""
    order = np.argsort(-bounds, kind="stable")[:_MOST]
    worst = int(values.argmax())
    order = order[(bounds[order] >= share * values[worst]) & (order != worst)]
    return np.concatenate([[worst], order])


def _degree(model: RungModel) -> int:
    """Degree of the polynomials of the angle that the stress of a model's rings is."""
    count, basis = model.ring, model.history.basis
    whole = len(basis) // count * count
    waves = np.abs(np.fft.rfft(basis[:whole].reshape(-1, count, *basis.shape[1:]), axis=1))
    sizes = waves.max(axis=(0, 2, 3))
    return int(np.flatnonzero(sizes > _ROUND_OFF * sizes.max()).max(initial=1))


def _around(model: RungModel, rings: IntArray, angles: FloatArray) -> StressHistory:
    """The history at angles (n,), rad, of rings (n,)."""
    count, history = model.ring, model.history
    whole = len(history.points) // count * count
    even = 2 * np.pi * np.arange(count) / count
    order = np.arange(1, (count + 1) // 2)
    apart = angles[:, None] - even
    weights = (1 + 2 * np.cos(apart[..., None] * order).sum(axis=-1)) / count
    basis = history.basis[:whole].reshape(-1, count, *history.basis.shape[1:])
    points = history.points[:whole].reshape(-1, count, 3)
    return StressHistory(
        np.arange(len(angles)),
        np.einsum("nk,nki->ni", weights, points[rings]),
        np.einsum("nk,nkij->nij", weights, basis[rings]),
        history.coefficients,
    )
