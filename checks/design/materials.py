"""Materials: ballesta's own data file and what a design file adds."""

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from itertools import pairwise
from math import inf
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from checks.design.units import Density, PositiveLength, PositiveStressIntensity, Stress
from fatigue import FKM_GROUPS
from geometry.bars import RulingSection
from geometry.parameters import ParameterError, check_above

# What no material reaches: diamond 1.2e6 MPa, carbon fibres 7e3 MPa, osmium 2.26e-8 t/mm3; and the
# other way foams of 1e-3 MPa and aerogels of 1e-12 t/mm3.
_PLAUSIBLE = {
    "youngs_modulus": (1e-4, 1e7, "MPa"),
    "density": (1e-13, 1e-7, "t/mm3"),
    "yield_stress": (1e-6, 1e5, "MPa"),
    "ultimate_stress": (1e-6, 1e5, "MPa"),
}
ENDURANCE_CYCLES = 5e8  # of rotating-bar tests of metals without an endurance limit
_THRESHOLDS = (0.1 * 1000**0.5, 100 * 1000**0.5)  # MPa mm^0.5
_STEEL = (180e3, 230e3)  # MPa, Young's modulus of what takes steel's endurance limit
_CYCLES = (1e5, 1e10)  # of a stated endurance ratio


@dataclass(frozen=True)
class Grade:
    """Guaranteed minima of a material up to a size.

    thickness  mm, largest of what is flat; diameter: largest of what is round; inf: any
    """

    thickness: float
    diameter: float
    yield_stress: float
    ultimate_stress: float

    def holds(self, section: RulingSection) -> bool:
        """True for a size that is no larger, with round-off."""
        largest = self.diameter if section.round else self.thickness
        return section.size <= largest * (1 + 1e-9)


@dataclass(frozen=True)
class Material:
    """An isotropic material; stresses in MPa, density in tonne/mm3.

    up_to            mm, largest thickness of which the strengths hold; up_to_diameter: of rounds
    larger           strengths of larger sizes, the smallest first
    endurance_ratio  of a polished bar, of the ultimate strength; None: steel's 0.5, or brittle
    endurance_cycles at which a stated ratio holds, the knee of the S-N curve
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
    endurance_cycles: float = ENDURANCE_CYCLES
    fkm_group: str | None = None
    threshold: float | None = None
    up_to: float = inf
    up_to_diameter: float | None = None
    larger: tuple[Grade, ...] = ()

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
                "steel's, whose endurance limit is half the ultimate strength; aluminium 6082-T6 "
                "has 0.3 at 5e8 cycles",
            )
        if ratio is not None and not 0 < ratio < 1:
            raise ParameterError("endurance_ratio", f"must be between 0 and 1, got {ratio:g}")
        if not _CYCLES[0] <= self.endurance_cycles <= _CYCLES[1]:
            raise ParameterError(
                "endurance_cycles",
                f"must be between {_CYCLES[0]:g} and {_CYCLES[1]:g}, got {self.endurance_cycles:g}",
            )
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

        grades = self.grades
        for index, (one, other) in enumerate(pairwise(grades)):
            if one.thickness >= other.thickness or one.diameter >= other.diameter:
                raise ParameterError(f"larger[{index}]", "sizes must grow from one to the next")
            if not 0 < other.yield_stress <= other.ultimate_stress:
                raise ParameterError(
                    f"larger[{index}]", "yield stress must be above 0 MPa and below the strength"
                )

    @property
    def grades(self) -> tuple[Grade, ...]:
        """Its strengths by size, the smallest size first."""
        diameter = self.up_to if self.up_to_diameter is None else self.up_to_diameter
        own = Grade(self.up_to, diameter, self.yield_stress, self.ultimate_stress)
        return own, *self.larger

    def of(self, sections: Iterable[RulingSection]) -> "Material":
        """Return the material with the strengths of the largest of a part's ruling sections.

        Smaller sizes than those of its own strengths may be stronger; the part is not, as it may
        be cut from a larger one. Raises ParameterError for a size beyond all that are known.
        """
        grades, index, of_round = self.grades, 0, False
        for section in sections:
            fits = (k for k, grade in enumerate(grades) if grade.holds(section))
            found = next(fits, None)
            if found is None:
                last = grades[-1]
                raise ParameterError(
                    "material",
                    f"the strengths of {self.name} are known up to {last.thickness:g} mm of "
                    f"thickness and {last.diameter:g} mm of diameter; the part has "
                    f"{section.size:g} mm of {'diameter' if section.round else 'thickness'}; state "
                    "a material of your own with your supplier's values",
                )
            if found > index:
                index, of_round = found, section.round
        if not index:
            return self
        grade = grades[index]
        above, up_to = (g.diameter if of_round else g.thickness for g in grades[index - 1 :][:2])
        return replace(
            self,
            name=f"{self.name} above {above:g} mm",
            source=f"{self.source}; above {above:g} up to {up_to:g} mm",
            yield_stress=grade.yield_stress,
            ultimate_stress=grade.ultimate_stress,
            up_to=grade.thickness,
            up_to_diameter=grade.diameter,
            larger=grades[index + 1 :],
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


class GradeEntry(BaseModel):
    """Strengths of a material in larger sizes."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    up_to: PositiveLength = Field(description="largest thickness of which they hold")
    up_to_diameter: PositiveLength | None = Field(
        None, description="largest diameter of round bars; without it `up_to`"
    )
    yield_stress: Stress = Field(description="yield stress, the minimum that is guaranteed")
    ultimate_stress: Stress = Field(description="tensile strength, the minimum guaranteed")

    def grade(self) -> Grade:
        """Return the strengths and sizes."""
        diameter = self.up_to if self.up_to_diameter is None else self.up_to_diameter
        return Grade(self.up_to, diameter, self.yield_stress, self.ultimate_stress)


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
    endurance_cycles: Annotated[float, Field(strict=True, allow_inf_nan=False)] | None = Field(
        None,
        description="cycles at which `endurance_ratio` holds, the knee of a finite life's S-N "
        f"curve; without it {ENDURANCE_CYCLES:g}, not for steel's 0.5",
    )
    fkm_group: str | None = Field(
        None, description="material group of the FKM guideline; without it that chain is not used"
    )
    threshold: PositiveStressIntensity | None = Field(
        None,
        description="range of the stress intensity, at R = -1, below which no long crack grows; "
        "without it fatigue at sharp re-entrant edges is not judged",
    )

    up_to: PositiveLength | None = Field(
        None, description="largest thickness of which the strengths hold; without it any size's"
    )
    up_to_diameter: PositiveLength | None = Field(
        None, description="largest diameter of round bars; without it `up_to`"
    )
    larger: list[GradeEntry] = Field(
        default_factory=list, description="strengths of larger sizes, the smallest first"
    )

    def named(self, name: str) -> Material:
        """Return the checked material; raises ParameterError."""
        if self.up_to is None and (self.larger or self.up_to_diameter is not None):
            raise ParameterError("up_to", "must be stated where larger sizes are")
        if self.endurance_cycles is not None and self.endurance_ratio is None:
            raise ParameterError("endurance_ratio", "must be stated where endurance_cycles are")
        own = self.model_dump(exclude={"larger", "up_to", "endurance_cycles"})
        cycles = self.endurance_cycles
        return Material(
            name=name,
            endurance_cycles=ENDURANCE_CYCLES if cycles is None else cycles,
            up_to=inf if self.up_to is None else self.up_to,
            larger=tuple(entry.grade() for entry in self.larger),
            **own,
        )


@cache
def known_materials() -> dict[str, Material]:
    """Return the materials of ballesta's own data file, by name."""
    text = files("checks.design").joinpath("materials.toml").read_text(encoding="utf-8")
    return {
        name: MaterialEntry.model_validate(entry).named(name)
        for name, entry in tomllib.loads(text).items()
    }
