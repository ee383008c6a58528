"""Which chain of strength judges the fatigue of a part: Marin's, or the FKM guideline's.

The two are never mixed: a key that only one of them reads is refused beside the other.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import fatigue
from checks.design.errors import Problems, listed, nearest
from checks.design.materials import Material
from checks.design.model import DesignFile, PartEntry
from geometry.mesh import FloatArray
from geometry.shape import Shape

# Rz in micrometres by `surface`. The guideline states the skin's (section 4.3.1.4). For what is
# ground and machined: the withdrawn DIN 3141, row 2 of its three and two triangles, at the rough
# end of common practice; drawn bars are taken as machined.
ROUGHNESS = {
    "ground": 6.3,
    "machined": 25.0,
    "cold_drawn": 25.0,
    "hot_rolled": fatigue.CAST_ROUGHNESS,
    "as_forged": fatigue.CAST_ROUGHNESS,
}
_MICROMETRES = 1e3  # in a millimetre
_DUCTILE = 0.577  # shear over tension strength of the groups that von Mises holds for
_SECOND_KNEE = 1e2  # knees of 1e6 cycles in the 1e8 from which the guideline's curves are flat
_MARIN_ONLY = {
    "reliability": "FKM's strengths hold for 97.5 % survival; what is asked beyond that is the "
    "safety, require.fatigue",
    "section": "FKM's size is in the ultimate strength and in the stress gradient",
}


@dataclass(frozen=True)
class FkmStrength:
    """Data of a part for the chain of the FKM guideline.

    material   as the guideline sees it
    roughness  micrometres, Rz
    """

    material: fatigue.FkmMaterial
    roughness: float

    def __post_init__(self) -> None:
        if self.material.numbers.shear_ratio != _DUCTILE:
            raise ValueError(
                f"the group {self.material.group!r} is not judged by von Mises alone: its strength "
                f"in shear is {self.material.numbers.shear_ratio:g} of that in tension, not "
                f"{_DUCTILE:g}; the groups that can be checked are {listed(ductile_groups())}"
            )
        _ = self.plain

    def limit(self, gradient: FloatArray | float) -> fatigue.ComponentLimit:
        """Return sigma_WK with Stieler's support of related gradients, 1/mm."""
        return fatigue.component_limit(self.material, roughness=self.roughness, gradient=gradient)

    @cached_property
    def plain(self) -> fatigue.ComponentLimit:
        """sigma_WK without support, as for an even stress."""
        return fatigue.component_limit(self.material, roughness=self.roughness)

    @property
    def endurance_share(self) -> float:
        """K_BK: what is endured for ever over what is endured at the knee of 1e6 cycles.

        1 for steel; 0.736 of aluminium and austenitic steel, whose curve goes on with slope 15 to
        1e8 cycles (FKM guideline, 6th ed., section 4.4.3).
        """
        return float(_SECOND_KNEE ** (-1.0 / float(fatigue.fkm_curve(self.plain).slope_below)))

    @property
    def reference(self) -> float:
        """Endurable amplitude of an even, fully reversed stress, MPa."""
        return float(self.plain.limit) * self.endurance_share

    def utilisation(
        self,
        amplitude: FloatArray | float,
        mean: FloatArray | float,
        limit: fatigue.ComponentLimit,
    ) -> FloatArray:
        """Return a_BK = sigma_a / (K_AK K_BK sigma_WK), without a safety factor.

        It is linear in the load, and grows with the amplitude and the mean, each by itself.
        """
        return fatigue.fkm_utilisation(amplitude, mean, limit) / self.endurance_share


def ductile_groups() -> list[str]:
    """Groups of the guideline that von Mises holds for."""
    return [name for name, group in fatigue.FKM_GROUPS.items() if group.shear_ratio == _DUCTILE]


def fkm_of(
    key: str, entry: PartEntry, material: Material, geometry: Shape, problems: Problems
) -> FkmStrength | None:
    """Return what FKM's chain needs if the part asks for it; adds problems where it cannot be."""
    if entry.strength == "marin":
        if entry.roughness is not None:
            problems.add(
                f"{key}.roughness",
                "is read by FKM's chain only; state strength = \"fkm\", or leave it out: Marin's "
                "chain takes surface",
            )
        return None
    for name, reason in _MARIN_ONLY.items():
        if name in entry.model_fields_set and getattr(entry, name) is not None:
            problems.add(f"{key}.{name}", f'belongs to Marin\'s chain, not to "fkm": {reason}')
    factors = [f"{name} {value:g}" for name, value in geometry.notch_factors.items() if value > 1]
    if factors:
        problems.add(
            f"{key}.strength",
            'must be "marin" for this shape, got "fkm": its fatigue notch factors (surface '
            f"{listed(factors)}) are of Marin's chain; with factors of 1 FKM's can be used",
        )
    if material.fkm_group is None:
        problems.add(f"{key}.strength", _without_group(material))
        return None
    try:
        own = fatigue.FkmMaterial(material.ultimate_stress, material.fkm_group)
        return FkmStrength(own, roughness_of(entry) * _MICROMETRES)
    except ValueError as error:
        problems.add(f"{key}.strength", f"{material.name} cannot go through FKM's chain: {error}")
        return None


def roughness_of(entry: PartEntry) -> float:
    """Rz of a part, stated or by its surface, mm."""
    if entry.roughness is not None:
        return entry.roughness
    return ROUGHNESS[entry.surface] / _MICROMETRES


def strength_defaults(file: DesignFile) -> Iterator[tuple[str, str | None]]:
    """Defaults that hang on the chain: (key, value), None for a key that the part does not use."""
    for name, entry in file.parts.items():
        if entry.strength == "fkm":
            yield f"parts.{name}.reliability", None
            if entry.roughness is None:
                said = f"{ROUGHNESS[entry.surface]:g} um, {entry.surface}"
                yield f"parts.{name}.roughness", said


def _without_group(material: Material) -> str:
    groups = ductile_groups()
    guess = nearest(material.name, groups)
    hint = f", such as {guess}" if guess else ""
    return (
        f'must be "marin" for {material.name}, got "fkm": the material has no fkm_group; state '
        f"materials.{material.name}.fkm_group{hint}, one of {listed(groups)}"
    )
