"""A leaf pack between its two bounds: leaves that slide on each other freely, and glued together.

The model's leaves slide without friction: the pack has n times the stiffness of one leaf. Friction
between them stiffens it, at the most as far as a bonded pack, n^3 times: n^2 times stiffer, and
under an equal bending moment with 1/n of the stress, M (n t/2) / (n^3 I) against M (t/2) / (n I).
Where a deflection is imposed the moment is n^2 times as large, and so the stress n times.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf, isfinite

import numpy as np

import loads
from checks.design.data import Part
from checks.ladder.levels import first_level
from checks.part.derived import VALUE, at_value
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads, loads_on
from checks.result.derivation import Derivation, Given, Item, Step
from checks.result.verdict import Check, Gate, PartResult
from checks.stress.solid_mesh_level import Level, Models
from checks.stress.stress_result import Stressed
from fem.tie_tension import tie_tension
from geometry.mesh import FloatArray
from geometry.parts import LeafPack
from geometry.parts.leaf_pack import as_leaves

# Tension over compression: worth telling; and where ties pull as hard as they press.
_GAPS, _OPEN = 0.25, 1.0
_INDEX = {"static": 0, "fatigue": 1}  # of the checks that friction widens
WIDER = "Wider by friction between the leaves"  # the title of their section
_WIDENED = "friction between the leaves, from sliding to bonded, makes it wider"
_AGAIN = "solved once more"

_Compliance = loads.BeamCompliance | loads.MatrixCompliance | loads.JointCompliance
Solved = Mapping[str, loads.CycleLoads | loads.MeasuredLoads]


@dataclass(frozen=True)
class Friction:
    """Stresses of a pack with friction between its leaves over those of leaves that slide freely.

    most, least  (static, fatigue)  of the bonded pack, infinite if unknown; at the least with any
                 friction
    words        how they were found
    """

    most: tuple[float, float]
    least: tuple[float, float]
    words: str

    def above(self, kind: str, value: str, unit: str) -> list[Item]:
        """Formulas of what it adds to the model band above a value of a kind of check."""
        most = self.most[_INDEX[kind]]
        if not 1 < most < inf:
            return []
        said = f"stress of the bonded pack over that of leaves that slide: {self.words}"
        return [
            Given("f_up", said, most, "", _AGAIN),
            Step("w_up", "friction adds above", f"(f_up - 1)*{value}", unit),
        ]

    def below(self, kind: str, value: str, unit: str) -> list[Item]:
        """Formulas of what it adds to the model band below a value of a kind of check."""
        least = self.least[_INDEX[kind]]
        if not least < 1:
            return []
        said = f"least stress with any friction over that of leaves that slide: {self.words}"
        return [
            Given("f_lo", said, least, "", _AGAIN),
            Step("w_lo", "friction adds below", f"(1 - f_lo)*{value}", unit),
        ]


@dataclass(frozen=True)
class LeafBand:
    """Widening of a part's stress checks by friction; none without leaves that slide."""

    friction: Friction | None

    def __call__(self, check: Check) -> Check:
        """Return a check with its model band widened."""
        friction, kind = self.friction, check.kind
        if friction is None or kind not in _INDEX:
            return check
        most, least = friction.most[_INDEX[kind]], friction.least[_INDEX[kind]]
        told = f"bonded {most * check.value:.4g} MPa" if isfinite(most) else "bonded: unknown"
        if least < min(1.0, most):
            told += f", with less friction {least * check.value:.4g} MPa or more"
        above = friction.above(kind, VALUE, check.unit)
        below = friction.below(kind, VALUE, check.unit)
        more = (at_value(check, above) if above else 0.0) if isfinite(most) else inf
        return replace(
            check,
            model=check.model + more,
            model_below=check.below + (at_value(check, below) if below else 0.0),
            note=f"{check.note}{'; ' if check.note else ''}leaves slide freely; {told}: "
            f"{friction.words}",
        )

    def explained(self, check: Check, derivation: Derivation) -> Derivation:
        """Return a widened check's derivation with the formulas by which it was widened."""
        friction, kind = self.friction, check.kind
        if friction is None or kind not in _INDEX:
            return derivation
        bars, value = derivation.bars, derivation.value
        above = friction.above(kind, value, check.unit) if isfinite(check.model) else []
        below = friction.below(kind, value, check.unit) if isfinite(check.below) else []
        if not isfinite(friction.most[_INDEX[kind]]):
            words = _joined(bars.words, f"bonded: unknown, {friction.words}")
            bars = replace(bars, above="", words=words)
        if above:
            bars = replace(bars, above=f"{bars.above} w_up".strip())
        if below:
            bars = replace(bars, below=f"{bars.below} w_lo".strip())
        if not above and not below:
            return replace(derivation, bars=bars)
        bars = replace(bars, words=_joined(bars.words, _WIDENED))
        return replace(derivation, bars=bars).with_items(WIDER, [*above, *below])


def _joined(*texts: str) -> str:
    return "; ".join(text for text in texts if text)


def with_leaf_checks(
    loaded: LoadedPart,
    result: PartResult,
    models: Models,
) -> PartResult:
    """Return a pack's result with its gaps' gate and the model bands of bonded leaves."""
    part = loaded.part
    shape = as_leaves(part.geometry)
    if shape is None or shape.leaves == 1:
        return result
    free = first_level(loaded, models)
    band = leaf_band(loaded, lambda other: first_level(loaded.under(other), models))
    return replace(
        result,
        checks=[_told(band, check, band(check)) for check in result.checks],
        gates=[*result.gates, gap_gate(part, shape, free)],
    )


def leaf_band(
    loaded: LoadedPart,
    level_of: Callable[[PartLoads], Stressed],
) -> LeafBand:
    """Widening of a pack's stress checks by the friction between its leaves.

    level_of  the stress of leaves that slide freely under some loads, by any model
    """
    shape = as_leaves(loaded.part.geometry)
    if shape is None or shape.leaves == 1:
        return LeafBand(None)
    return LeafBand(_friction(loaded, shape, level_of))


def _told(band: LeafBand, free: Check, widened: Check) -> Check:
    """A widened check with its terms in the derivation that it had before, if it had one."""
    if free.derivation is None:
        return widened
    return replace(widened, derivation=band.explained(widened, free.derivation))


def gap_gate(part: Part, shape: LeafPack, level: Level) -> Gate:
    """How far the ties between leaves pull beside the clamps, over how far they press.

    Inside a clamp the leaves are squeezed together, which is in no load. Beside it leaves that bend
    alike need no force between them; where the ties pull as hard as they press, the pack rests on
    what leaves cannot do. Forces count over two thicknesses to either side, about as far as a leaf
    spreads them.
    """
    clamps = [
        (centre - length / 2, centre + length / 2)
        for centre, length in ((0.0, shape.clamp_length), (shape.length, shape.rod_length))
    ]
    beside = shape.contact_from - shape.clamp_length / 2  # above 0; three windows fit in
    tension, compression = tie_tension(
        level.solutions,
        level.coefficients,
        clamps,
        window=min(2 * shape.thickness, beside / 3),
    )
    share = tension / compression if compression else (inf if tension else 0.0)
    return Gate(
        f"{part.name}: gaps between leaves",
        share,
        _GAPS,
        f"largest tension beside the clamps, {tension:.3g} MPa, between leaves that must not part, "
        f"over the largest compression, {compression:.3g} MPa, on the first mesh; the verdict "
        f"depends on it above {_OPEN:g}",
        binding=share > _OPEN,
    )


def _friction(
    loaded: LoadedPart,
    shape: LeafPack,
    level_of: Callable[[PartLoads], Stressed],
) -> Friction:
    """Stress of a bonded pack under its own loads, and the least of any pack between.

    With friction every position's stress is between both packs'. Some fall and some grow, so the
    least comes from a history made of the smaller one at every position.
    """
    part, part_loads = loaded.part, loaded.loads
    count = shape.leaves
    stiffer = [
        name
        for name, cycle in loaded.runs.items()
        if isinstance(cycle, loads.CycleLoads) and _gives(part, cycle)
    ]
    relieved = (1 / count, 1 / count)
    if not stiffer:
        words = f"forces are imposed on it, so a bonded pack has 1/{count} of the stress"
        return Friction(relieved, relieved, words)
    try:
        other = dict(loaded.runs) | {name: _stiffened(loaded, name, count**2) for name in stiffer}
        other_loads = loads_on(loaded.design, part, other)
        free, again = level_of(part_loads), level_of(other_loads)
    except loads.LinkageError as error:
        words = f"a bonded pack's loads cannot be found: {error}"
        return Friction((inf, inf), relieved, words)
    share = np.ones(len(part_loads.labels))
    for name, columns in part_loads.cycles.items():
        own, bonded = free.peaks_by_position[columns], again.peaks_by_position
        bonded = bonded[other_loads.cycles[name]] / count
        if name in stiffer:
            times, other_times = loaded.runs[name].times, other[name].times
            assert times is not None
            assert other_times is not None
            bonded = np.interp(times, other_times, bonded)
        share[columns] = np.minimum(1.0, bonded / np.where(own > 0, own, 1.0))
    least = level_of(_weakened(part_loads, share))
    return Friction(
        _ratios(again, free, 1 / count),
        _ratios(least, free),
        f"contacts impose a deflection on it in {', '.join(stiffer)}, solved again with {count**2} "
        "times its bending stiffness",
    )


def _ratios(level: Stressed, free: Stressed, factor: float = 1.0) -> tuple[float, float]:
    """Static and fatigue stress of a level over those of another; the static for no fatigue."""
    static = factor * level.peak.value / free.peak.value if free.peak.value else 1.0
    if free.fatigue is None or level.fatigue is None or not free.fatigue.value:
        return static, static
    return static, factor * level.fatigue.value / free.fatigue.value


def _weakened(part_loads: PartLoads, share: FloatArray) -> PartLoads:
    """The same loads times a share (n,) of their own at every position."""
    return replace(
        part_loads,
        wrenches={name: share[:, None] * w for name, w in part_loads.wrenches.items()},
        accelerations=share[:, None] * part_loads.accelerations,
    )


def _gives(part: Part, cycle: loads.CycleLoads) -> bool:
    """True if the part's body gives way in front of a contact of the cycle."""
    return bool(cycle.touches) and any(
        isinstance(entry, loads.BeamCompliance | loads.MatrixCompliance) and entry.body == part.body
        for entry in cycle.linkage.compliance
    )


def _stiffened(loaded: LoadedPart, name: str, factor: float) -> loads.CycleLoads:
    """Solve a cycle again with a body that bends `factor` times less."""
    cycle = loaded.runs[name]
    assert isinstance(cycle, loads.CycleLoads)

    def stiffer(entry: _Compliance) -> _Compliance:
        if isinstance(entry, loads.JointCompliance) or entry.body != loaded.part.body:
            return entry
        if isinstance(entry, loads.MatrixCompliance):
            return replace(entry, matrix=entry.matrix / factor)
        bending = None if entry.bending is None else factor * entry.bending
        return replace(entry, bending=bending)

    linkage = replace(
        cycle.linkage, compliance=tuple(stiffer(entry) for entry in cycle.linkage.compliance)
    )
    return loads.run_cycle(linkage, loaded.design.cycles[name].run)
