"""Checks of stress, whatever model made it, before its error bars are known."""

from checks.part.derived import Kind
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from checks.strength.fatigue_assessment import FatigueUse, FkmUse, LifeUse
from checks.strength.fatigue_facts import chord_at, plane_at
from checks.stress.stress_result import Stressed

STATIC = Kind(
    name="static",
    quantity="peak von Mises stress",
    demand="peak von Mises stress on the surface",
    limit="yield stress",
    require="static",
    source="[bearing](../theory/bearing.md), [models](../theory/rungs.md)",
)
FATIGUE = {  # by the criterion that decides
    kind.quantity.partition(" ")[0]: kind
    for kind in (
        Kind(
            name="fatigue",
            quantity="Goodman amplitude of equal safety",
            demand="amplitude of equal safety of the longest chord of the stress path",
            limit="endurance limit",
            require="fatigue",
            source="Shigley, 6-46; [strength](../theory/strength.md)",
        ),
        Kind(
            name="fatigue",
            quantity="Findley amplitude of equal safety",
            demand="amplitude of equal safety on the critical plane, where the stress path is not "
            "proportional",
            limit="endurance limit",
            require="fatigue",
            source="Findley 1959; [multiaxial](../theory/multiaxial.md)",
        ),
        Kind(
            name="fatigue",
            quantity="Miner amplitude of equal safety",
            demand="endurance limit over the safety that Miner's sum of the duty leaves, for a "
            "finite life",
            limit="endurance limit",
            require="fatigue",
            source="[life](../theory/life.md)",
        ),
        Kind(
            name="fatigue",
            quantity="FKM amplitude of equal safety",
            demand="utilisation by the FKM guideline's chain, times its reference strength",
            limit="reference strength of the component",
            require="fatigue",
            source="[strength](../theory/strength.md)",
        ),
    )
}
KINDS = (STATIC, *FATIGUE.values())


def static_check(loaded: LoadedPart, level: Stressed, method: str) -> Check:
    """The check of the largest von Mises stress, without error bars."""
    part, loads = loaded.part, loaded.loads
    return Check(
        part=part.name,
        kind=STATIC.name,
        quantity=STATIC.quantity,
        value=level.peak.value,
        unit="MPa",
        numerical=0.0,
        model=0.0,
        limit=part.material.yield_stress,
        required=STATIC.safety(loaded.required),
        cycle=loads.cycle_names[level.peak.position],
        position=loads.labels[level.peak.position],
        place=level.place_in_words(level.peak.point, part.geometry.placed_interfaces),
        method=method,
        basis=f"yield stress, guaranteed minimum ({part.material.source})",
    )


def fatigue_check(loaded: LoadedPart, level: Stressed, use: FatigueUse, method: str) -> Check:
    """The check of the largest amplitude of equal safety, without error bars."""
    part = loaded.part
    worst = use.worst(level)
    kind = FATIGUE[worst.criterion]
    if isinstance(use, FkmUse):
        found = use.found(level)
        amplitude, mean = found.amplitude, found.mean
        note = f"support {float(found.limit.support):.3f}, K_AK {found.mean_factor:.3f}"
        basis = (
            f"FKM guideline, {use.strength.material.group}, Rz {use.strength.roughness:g} um: even "
            "reversed stress; infinite life"
        )
    else:
        amplitude, mean = chord_at(level, worst)
        factor = use.limit / float(level.limits[worst.point])
        note = f"fatigue notch factor {factor:.3g}" if factor > 1 else ""
        if worst.criterion == "Findley":
            note = ", ".join(
                text for text in (f"longest chord; {plane_at(level, worst)}", note) if text
            )
        life = "infinite life"
        if isinstance(use, LifeUse):
            lasts = use.life(level)
            life = f"finite life: Miner's sum {lasts.damage:.3g} of {use.task.allowed_damage:g}"
            if lasts.raised > 1.0:
                raised = f"cycles raised by {lasts.raised:.4g}, Findley's plane over the chord"
                note = ", ".join(text for text in (raised, note) if text)
        basis = (
            f"endurance limit, Marin: {part.surface}, {100 * part.reliability:g} % survival; {life}"
        )
    said = f"amplitude {amplitude:.4g} MPa", f"mean {mean:.4g} MPa", note
    return Check(
        part=part.name,
        kind=kind.name,
        quantity=kind.quantity,
        value=worst.value,
        unit="MPa",
        numerical=0.0,
        model=0.0,
        limit=use.limit,
        required=kind.safety(loaded.required),
        cycle=worst.cycle,
        position=" to ".join(_position(loaded.loads, k, worst.cycle) for k in worst.pair),
        place=level.place_in_words(worst.point, part.geometry.placed_interfaces),
        method=method,
        basis=basis,
        note=", ".join(text for text in said if text),
    )


def _position(loads: PartLoads, position: int, cycle: str) -> str:
    """Where in the duty, with the cycle's name where the pair may be of two."""
    label = loads.labels[position]
    return label if cycle in loads.cycles else f"{loads.cycle_names[position]} {label}"
