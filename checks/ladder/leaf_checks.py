"""A leaf pack with friction between its leaves, beside leaves that slide on each other freely.

The model's leaves slide without friction: the pack has n times the stiffness of one leaf. What
friction and preload make of forces and stresses is solved on beams that press and rub on each other
(`checks.ladder.leaf_friction`) and is a band around the value of leaves that slide.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, isfinite

import loads
from checks.design.data import Part
from checks.ladder.leaf_friction import rubbed
from checks.ladder.levels import first_level
from checks.part.derived import VALUE, at_value
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import Derivation, Given, Item, Step
from checks.result.verdict import Check, Gate, PartResult
from checks.stress.solid_mesh_level import Level, Models
from fem.contact.condensed import ALLOWED
from fem.leaf_stack import tie_tension
from geometry.parts import LeafPack
from geometry.parts.leaf_pack import as_leaves

# Tension over compression: worth telling; and where ties pull as hard as they press.
_GAPS, _OPEN = 0.25, 1.0
_INDEX = {"static": 0, "fatigue": 1}  # of the checks that friction widens
WIDER = "Wider by friction between the leaves"  # the title of their section
_WIDENED = "friction between the leaves makes it wider"
_AGAIN = "solved by contact with friction"

Solved = Mapping[str, loads.CycleLoads | loads.MeasuredLoads]


@dataclass(frozen=True)
class Friction:
    """Stresses of a pack with friction between its leaves over those of leaves that slide freely.

    most, least  (static, fatigue)  at the most and the least, of what the design leaves open;
                 infinite if unknown
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
        said = f"most stress with friction over that of leaves that slide: {self.words}"
        return [
            Given("f_up", said, most, "", _AGAIN),
            Step("w_up", "friction adds above", f"(f_up - 1)*{value}", unit),
        ]

    def below(self, kind: str, value: str, unit: str) -> list[Item]:
        """Formulas of what it adds to the model band below a value of a kind of check."""
        least = self.least[_INDEX[kind]]
        if not least < 1:
            return []
        said = f"least stress with friction over that of leaves that slide: {self.words}"
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
        told = (
            f"with friction {least * check.value:.4g} to {most * check.value:.4g} MPa"
            if isfinite(most)
            else "with friction: unknown"
        )
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
            words = _joined(bars.words, f"with friction: unknown, {friction.words}")
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


def with_leaf_checks(loaded: LoadedPart, result: PartResult, models: Models) -> PartResult:
    """Return a pack's result with its gates and the model bands of friction between leaves."""
    part = loaded.part
    shape = as_leaves(part.geometry)
    if shape is None or shape.leaves == 1:
        return result
    free = first_level(loaded, models)
    band = leaf_band(loaded)
    return replace(
        result,
        checks=[_told(band, check, band(check)) for check in result.checks],
        gates=[*result.gates, gap_gate(part, shape, free), *friction_gates(loaded)],
        facts={**result.facts, **friction_facts(loaded)},
    )


def leaf_band(loaded: LoadedPart) -> LeafBand:
    """Widening of a pack's stress checks by the friction between its leaves."""
    if not _rubs(loaded):
        return LeafBand(None)
    found = rubbed(loaded)
    if isinstance(found, str):
        return LeafBand(Friction((inf, inf), (0.0, 0.0), found))
    cases = "; ".join(
        f"{case.words}: {static:.3f} static, {fatigue:.3f} fatigue"
        for case, static, fatigue in zip(found.cases, found.static, found.fatigue, strict=True)
    )
    return LeafBand(
        Friction(
            (max(found.static), max(found.fatigue)),
            (min(found.static), min(found.fatigue)),
            f"contact and friction of leaves as beams, {cases}",
        )
    )


def _rubs(loaded: LoadedPart) -> bool:
    shape = as_leaves(loaded.part.geometry)
    return shape is not None and shape.leaves > 1 and not loaded.loads.is_nothing


def friction_gates(loaded: LoadedPart) -> list[Gate]:
    """Validity check of contact and friction between leaves; none for other parts."""
    found = rubbed(loaded) if _rubs(loaded) else ""
    if isinstance(found, str):
        return []
    return [
        Gate(
            f"{loaded.name}: contact between leaves",
            found.missed,
            ALLOWED,
            "largest of the leaves' forces out of equilibrium and of what contact and friction "
            "miss of their laws, over the largest force between leaves or load",
        )
    ]


def friction_facts(loaded: LoadedPart) -> dict[str, float | str]:
    """Forces of contacts on a pack with friction between its leaves; none for other parts."""
    found = rubbed(loaded) if _rubs(loaded) else ""
    if isinstance(found, str) or not any(force for force, _ in found.forces):
        return {}
    told = "; ".join(
        f"{case.words}: {force:.4g}"
        for case, (_, force) in zip(found.cases, found.forces, strict=True)
    )
    sliding = max(force for force, _ in found.forces)
    return {
        "largest contact force by friction between leaves [N]": f"leaves that slide {sliding:.4g}; "
        f"{told}; over {', '.join(found.cycles)}"
    }


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
        level.solutions, level.coefficients, clamps, window=min(2 * shape.thickness, beside / 3)
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
