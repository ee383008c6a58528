"""Checks of stress, whatever model made it, before its error bars are known.

With facts on a part's fatigue: the stresses behind its verdict, and its life.
"""

from math import inf, isfinite

import numpy as np

import fatigue
from checks.part.derived import Kind
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from checks.strength.fatigue_assessment import FatigueUse, FkmUse, LifeUse
from checks.stress.duty_verdict import FatiguePeak, widest
from checks.stress.stress_result import Stressed
from fatigue.proportionality import PROPORTIONAL
from geometry.mesh import FloatArray, IntArray

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


def path_of(level: Stressed, peak: FatiguePeak) -> IntArray:
    """Positions of the path that decides; of a finite life those of all cycles."""
    runs = level.judged_duty.runs
    if peak.cycle in runs:
        return runs[peak.cycle]
    return runs[widest(runs)]


def deciding_pair(level: Stressed, peak: FatiguePeak) -> tuple[int, int]:
    """Positions of the deciding pair; where Findley's plane decides, the longest chord's ends."""
    if peak.criterion != "Findley":
        return peak.pair
    run = path_of(level, peak)
    path = np.ascontiguousarray(level.coefficients[:, run])
    chords = fatigue.goodman(level.history.basis[[peak.point]], path, 1.0, 1.0)
    first, second = (int(run[k]) for k in chords.pair[0])
    return first, second


def chord_at(level: Stressed, peak: FatiguePeak) -> tuple[float, float]:
    """Amplitude and mean as Goodman counts it, of the `deciding_pair`, MPa."""
    path = np.ascontiguousarray(level.coefficients[:, list(deciding_pair(level, peak))])
    chord = fatigue.chord_path(level.history.basis[peak.point], path, (0, 1))
    return chord.amplitude, chord.mean


def plane_at(level: Stressed, peak: FatiguePeak) -> str:
    """Findley's critical plane of the critical point, in words."""
    plane = fatigue.critical_plane(_stress(level, peak), fatigue.findley_criterion().k)
    x, y, z = plane.normal
    return (
        f"on the plane with normal ({x:.3f}, {y:.3f}, {z:.3f}) shear amplitude "
        f"{plane.shear_amplitude:.4g} MPa, normal stress {plane.normal_stress:.4g} MPa"
    )


def _stress(level: Stressed, peak: FatiguePeak) -> FloatArray:
    """Stress (6, n) of the critical point over the path that decides, MPa."""
    path = np.ascontiguousarray(level.coefficients[:, path_of(level, peak)])
    return np.asarray(level.history.basis[peak.point] @ path)


def fatigue_facts(level: Stressed, peak: FatiguePeak) -> dict[str, float | str]:
    """Facts of the critical point, by name: its stresses, and whether their path is straight.

    The safety by Findley's plane is on all loads.
    """
    amplitude, mean = chord_at(level, peak)
    facts: dict[str, float | str] = {
        "fatigue amplitude [MPa]": amplitude,
        "fatigue mean stress [MPa]": mean,
    }
    limit = float(level.limits[peak.point])
    criterion = fatigue.findley_criterion()
    path = np.ascontiguousarray(level.coefficients[:, path_of(level, peak)])
    bounds = fatigue.path_bounds(level.history.basis[[peak.point]], path, criterion.k)
    stress = _stress(level, peak)
    width = float(bounds.width[0])
    if width <= PROPORTIONAL:
        facts["stress path at the critical point"] = "proportional: Goodman alone decides"
    else:
        facts["stress path at the critical point"] = (
            f"not proportional, {width:.2g} as wide as long"
        )
        used = fatigue.critical_plane(stress, criterion.k).value / (criterion.limit_ratio * limit)
        facts["Findley's critical plane"] = (
            f"{plane_at(level, peak)}; safety for infinite life {_safety(used)}"
        )
    return facts


def _safety(utilisation: float) -> str:
    safety = 1.0 / utilisation if utilisation > 0.0 else inf
    return f"{safety:.3g}" if isfinite(safety) else "no limit"


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
