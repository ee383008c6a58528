"""Fatigue life of a part: Goodman on the stress path of each point, endurance limits by Marin."""

from fatigue.fkm import (
    CAST_ROUGHNESS,
    FKM_GROUPS,
    FKM_SENSITIVITIES,
    ComponentLimit,
    FkmGroup,
    FkmMaterial,
    component_limit,
    fkm_curve,
    fkm_factor,
    fkm_sensitivity,
    fkm_utilisation,
    roughness_factor,
    stieler_support,
)
from fatigue.goodman import (
    ChordPath,
    FatigueResult,
    chord_path,
    equivalent_amplitude,
    goodman,
    goodman_utilisation,
)
from fatigue.life import (
    Cycles,
    LifeVerdict,
    count_closed_cycles,
    duty_cycles,
    life_verdict,
    miner_damage,
)
from fatigue.marin import (
    EnduranceLimit,
    endurance_limit,
    rectangle_equivalent_diameter,
    round_equivalent_diameter,
)
from fatigue.proportionality import PathBounds, path_bounds
from fatigue.shear_planes import (
    CriticalPlane,
    FindleyCriterion,
    critical_plane,
    findley_criterion,
    smallest_circles,
)
from fatigue.sn_curve import SNCurve, basquin_curve, low_cycle_fraction
from fatigue.stress_path import COMPONENTS, principal_stresses, von_mises, von_mises_peaks
from fatigue.verdict import Verdict, ductile_verdict

__all__ = [
    "CAST_ROUGHNESS",
    "COMPONENTS",
    "FKM_GROUPS",
    "FKM_SENSITIVITIES",
    "ChordPath",
    "ComponentLimit",
    "CriticalPlane",
    "Cycles",
    "EnduranceLimit",
    "FatigueResult",
    "FindleyCriterion",
    "FkmGroup",
    "FkmMaterial",
    "LifeVerdict",
    "PathBounds",
    "SNCurve",
    "Verdict",
    "basquin_curve",
    "chord_path",
    "component_limit",
    "count_closed_cycles",
    "critical_plane",
    "ductile_verdict",
    "duty_cycles",
    "endurance_limit",
    "equivalent_amplitude",
    "findley_criterion",
    "fkm_curve",
    "fkm_factor",
    "fkm_sensitivity",
    "fkm_utilisation",
    "goodman",
    "goodman_utilisation",
    "life_verdict",
    "low_cycle_fraction",
    "miner_damage",
    "path_bounds",
    "principal_stresses",
    "rectangle_equivalent_diameter",
    "roughness_factor",
    "round_equivalent_diameter",
    "smallest_circles",
    "stieler_support",
    "von_mises",
    "von_mises_peaks",
]
