"""Strength of a part: its elasticity, its endurance limit, and the assessment of its fatigue."""

from math import sqrt

import fatigue
from checks.design.data import Duty, Part
from checks.design.errors import DesignError
from checks.part.loaded_part import LoadedPart
from checks.strength.fatigue_assessment import FatigueUse, FkmUse, LifeUse
from checks.strength.finite_life import LifeTask, why_no_curve
from fatigue.marin import LARGEST_SIZE, ROTATING_AREA, load_factor, size_factor
from fem.unit_solutions import Elastic


def elastic_of(part: Part) -> Elastic:
    """Return the elastic constants of a part's material."""
    material = part.material
    return Elastic(material.youngs_modulus, material.poisson_ratio, material.density)


def endurance_of(part: Part) -> fatigue.EnduranceLimit:
    """Endurance limit by Marin's factors.

    The load factor is for bending where the shape's peaks are local, with a gradient below them,
    and for axial force where the whole section is stressed alike (`evenly_stressed`); there no size
    factor applies (Shigley, 6-20). The size factor takes an equivalent diameter; of a pin it grows
    up to the whole diameter as its load goes round it (`checks.part.loaded_part.bent_area`).
    """
    ultimate, ratio = part.material.ultimate_stress, part.material.endurance_ratio
    specimen = None if ratio is None else ratio * ultimate
    if evenly_stressed(part):
        return fatigue.endurance_limit(
            ultimate,
            part.surface,
            load="axial",
            reliability=part.reliability,
            specimen_limit=specimen,
        )
    return fatigue.endurance_limit(
        ultimate,
        part.surface,
        equivalent_diameter=equivalent_diameter(part),
        load="bending",
        reliability=part.reliability,
        specimen_limit=specimen,
    )


def evenly_stressed(part: Part) -> bool:
    """True for a part whose endurance limit has the load factor of axial force.

    Of a bar between bores whose shank decides the lower limit counts, as its bores are bent: axial
    force where the size factor of bending is above the load factor.
    """
    if part.geometry.stressed_evenly or not part.geometry.shank_decides:
        return part.geometry.stressed_evenly
    return size_factor(equivalent_diameter(part)) > load_factor("axial")


def starts_axial(part: Part) -> bool:
    """True for a part whose S-N curve starts at what 1e3 cycles of axial force leave.

    A shank that decides has no gradient, whichever factor its endurance limit has.
    """
    return part.geometry.stressed_evenly or part.geometry.shank_decides


def equivalent_diameter(part: Part) -> float:
    """Diameter of a rotating bar whose most stressed share is as large, mm."""
    section = part.geometry.stressed_section
    if len(section) == 1:
        return max(
            fatigue.round_equivalent_diameter(*section),
            sqrt(part.bent_area / ROTATING_AREA) * section[0],
        )
    return fatigue.rectangle_equivalent_diameter(*section)


def beyond_size_data(part: Part) -> str | None:
    """Assumption of a part's size factor beyond the end of its data; None within them."""
    if part.fkm is not None or part.geometry.stressed_evenly:
        return None
    diameter, end = equivalent_diameter(part), LARGEST_SIZE
    if not diameter > end:
        return None
    factor, last = (size_factor(size) for size in (diameter, end))
    return (
        f"Marin's size factor, whose data end at an equivalent diameter of {end:g} mm, goes on "
        f"along its curve to {diameter:.4g} mm: {factor:.3f} in place of {last:.3f}"
    )


def life_task(part: Part, duty: Duty) -> LifeTask:
    """Cycles that a part's finite life has to bear, and what of it is left."""
    return LifeTask(
        duty.cycles,
        part.material,
        starts_axial(part),
        duty.allowed_damage - duty.damage_so_far,
        begun=duty.damage_so_far > 0,
    )


def amplitude_use(loaded: LoadedPart) -> FatigueUse:
    """The amplitude of equal safety itself: of no number of cycles, nor by another guideline."""
    part = loaded.part
    return FatigueUse(loaded.loads, endurance_of(part).value, part.material.ultimate_stress)


def fatigue_use(loaded: LoadedPart) -> FatigueUse | None:
    """How the part's fatigue is judged, None where no cycle of the duty loads it."""
    part, loads = loaded.part, loaded.loads
    if not any(name in loads.cycles for name in loaded.duty.cycles):
        return None
    ultimate = part.material.ultimate_stress
    if part.fkm is not None:
        return FkmUse(loads, part.fkm.reference, ultimate, part.fkm)
    limit = endurance_of(part).value
    if loaded.duty.life == "finite":
        why = why_no_curve(part.material, limit, axial=starts_axial(part))
        if why:
            raise DesignError(loaded.design.file, f"parts.{part.name}.material", why)
        return LifeUse(loads, limit, ultimate, life_task(part, loaded.duty))
    return FatigueUse(loads, limit, ultimate)
