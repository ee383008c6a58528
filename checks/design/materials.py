"""Materials: ballesta's own data file and what a design file adds."""

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from checks.design.units import Density, PositiveStressIntensity, Stress
from fatigue import FKM_GROUPS
from geometry.parameters import ParameterError, check_above

# What no material reaches: diamond 1.2e6 MPa, carbon fibres 7e3 MPa, osmium 2.26e-8 t/mm3; and the
# other way foams of 1e-3 MPa and aerogels of 1e-12 t/mm3.
_PLAUSIBLE = {
    "youngs_modulus": (1e-4, 1e7, "MPa"),
    "density": (1e-13, 1e-7, "t/mm3"),
    "yield_stress": (1e-6, 1e5, "MPa"),
    "ultimate_stress": (1e-6, 1e5, "MPa"),
}
_THRESHOLDS = (0.1 * 1000**0.5, 100 * 1000**0.5)  # MPa mm^0.5
_STEEL = (180e3, 230e3)  # MPa, Young's modulus of what takes steel's endurance limit


@dataclass(frozen=True)
class Material:
    """An isotropic material; stresses in MPa, density in tonne/mm3.

    endurance_ratio  of a polished bar, of the ultimate strength; None: steel's 0.5, or brittle
    fkm_group        one of `fatigue.FKM_GROUPS`; None: the guideline's chain cannot be used
    threshold        MPa mm^0.5, range of the stress intensity at R = -1 below which no long crack
                     grows; None: fatigue at sharp re-entrant edges is not judged
    """

    name: str
    youngs_modulus: float
    poisson_ratio: float
    density: float
    yield_stress: float
    ultimate_stress: float
    ductile: bool
    source: str
    endurance_ratio: float | None = None
    fkm_group: str | None = None
    threshold: float | None = None

    def __post_init__(self) -> None:
        check_above("youngs_modulus", self.youngs_modulus, 0, "MPa")
        if not -1 < self.poisson_ratio < 0.5:
            raise ParameterError(
                "poisson_ratio", f"must be above -1 and below 0.5, got {self.poisson_ratio:g}"
            )
        check_above("density", self.density, 0, "t/mm3")
        check_above("yield_stress", self.yield_stress, 0, "MPa")
        for name, (least, most, unit) in _PLAUSIBLE.items():
            value = getattr(self, name)
            if not least <= value <= most:
                raise ParameterError(
                    name,
                    f"must be between {least:g} and {most:g} {unit}, as of any material, "
                    f"got {value:g} {unit}",
                )
        if self.ultimate_stress < self.yield_stress:
            raise ParameterError(
                "ultimate_stress",
                f"must be at least the yield stress of {self.yield_stress:g} MPa, "
                f"got {self.ultimate_stress:g} MPa",
            )
        ratio = self.endurance_ratio
        if ratio is None and self.ductile and not _STEEL[0] <= self.youngs_modulus <= _STEEL[1]:
            raise ParameterError(
                "endurance_ratio",
                f"must be stated: Young's modulus of {self.youngs_modulus / 1e3:g} GPa is not "
                "steel's, whose endurance limit is half the ultimate strength; wrought aluminium "
                "has about 0.4 at 5e8 cycles (Norton, Machine Design, ch. 6)",
            )
        if ratio is not None and not 0 < ratio < 1:
            raise ParameterError("endurance_ratio", f"must be between 0 and 1, got {ratio:g}")
        if self.threshold is not None and not _THRESHOLDS[0] <= self.threshold <= _THRESHOLDS[1]:
            low, high = (limit / 1000**0.5 for limit in _THRESHOLDS)
            raise ParameterError(
                "threshold",
                f"must be between {low:g} and {high:g} MPa m^0.5, as of any metal, "
                f"got {self.threshold / 1000**0.5:g} MPa m^0.5",
            )
        if self.fkm_group is not None and self.fkm_group not in FKM_GROUPS:
            raise ParameterError(
                "fkm_group", f"must be one of {', '.join(FKM_GROUPS)}, got {self.fkm_group!r}"
            )

    @property
    def why_not_goodman(self) -> str | None:
        """Why the Goodman rule and von Mises cannot judge the material, None if they can."""
        if self.ductile:
            return None
        return (
            f"{self.name} is brittle: it breaks from its largest flaw under the largest tension, "
            "without yielding, so von Mises is not safe for it, its strength falls with the "
            "stressed volume, and it has no endurance limit for a Goodman line"
        )


class MaterialEntry(BaseModel):
    """A material as a file states it."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    youngs_modulus: Stress = Field(description="Young's modulus")
    poisson_ratio: Annotated[float, Field(strict=True, allow_inf_nan=False)] = Field(
        description="Poisson's ratio, above -1 and below 0.5"
    )
    density: Density = Field(description="mass per volume")
    yield_stress: Stress = Field(description="yield stress, the minimum that is guaranteed")
    ultimate_stress: Stress = Field(description="tensile strength, the minimum guaranteed")
    ductile: Annotated[bool, Field(strict=True)] = Field(
        True, description="true when it yields visibly before it breaks"
    )
    source: str = Field("stated in the design file", description="where the values come from")
    endurance_ratio: Annotated[float, Field(strict=True, allow_inf_nan=False)] | None = Field(
        None,
        description="endurance limit of a polished bar over the tensile strength; without it 0.5, "
        "for steel only",
    )
    fkm_group: str | None = Field(
        None, description="material group of the FKM guideline; without it that chain is not used"
    )
    threshold: PositiveStressIntensity | None = Field(
        None,
        description="range of the stress intensity, at R = -1, below which no long crack grows; "
        "without it fatigue at sharp re-entrant edges is not judged",
    )

    def named(self, name: str) -> Material:
        """Return the checked material; raises ParameterError."""
        return Material(name=name, **self.model_dump())


@cache
def known_materials() -> dict[str, Material]:
    """Return the materials of ballesta's own data file, by name."""
    text = files("checks.design").joinpath("materials.toml").read_text(encoding="utf-8")
    return {
        name: MaterialEntry.model_validate(entry).named(name)
        for name, entry in tomllib.loads(text).items()
    }
