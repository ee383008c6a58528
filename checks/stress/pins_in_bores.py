"""Pins whose fit is stated: where they press in the bores of a part is solved, not assumed.

The range of clearances that a fit leaves is solved at its middle, which gives the value, and at
both ends, which give the model band.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from checks.part.loaded_part import LoadedPart
from fem.contact.bore import BoreHarmonics, bore_harmonics
from fem.contact.cycle import ContactCycle, FittedPin, solve_contact
from fem.contact.superposed import ContactSolutions, superposed
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray, IntArray, Interface

MIDDLE, LEAST, LARGEST = 0.5, 0.0, 1.0  # share of the range of clearances
CLEARANCES = (MIDDLE, LEAST, LARGEST)
_WIDEST = 2e-3  # of the bore's diameter: loose running fits
CLEARANCE_WORDS = {MIDDLE: "middle", LEAST: "least", LARGEST: "largest"}


@dataclass(frozen=True)
class Fit:
    """Fit of a pin in a bore.

    least, largest  mm, clearance on diameter
    youngs_modulus  MPa, of the pin
    poisson_ratio   of the pin
    material        of the pin, in words
    """

    least: float
    largest: float
    youngs_modulus: float
    poisson_ratio: float
    material: str

    def clearance(self, share: float) -> float:
        """Clearance on diameter, mm, at a share of the range."""
        return self.least + share * (self.largest - self.least)

    def pin(self, share: float) -> FittedPin:
        """The pin at a share of the range of clearances."""
        return FittedPin(self.clearance(share), self.youngs_modulus, self.poisson_ratio)


def fits_of(loaded: LoadedPart) -> dict[str, Fit]:
    """Fits that the design states of the pins in a part's bores, by bore, in order of its name.

    A pin is of the material of the pin part at that joint, of the part's own where there is none.
    """
    return {
        name: _fit(loaded, name, *loaded.part.clearances[name])
        for name in sorted(loaded.part.clearances)
    }


def widest_fits(loaded: LoadedPart, bores: Sequence[Interface]) -> dict[str, Fit]:
    """Fits from no clearance to the widest of a running pin, 2 thousandths of its bore."""
    return {bore.name: _fit(loaded, bore.name, 0.0, _WIDEST * 2 * bore.radius) for bore in bores}


def _fit(loaded: LoadedPart, name: str, least: float, largest: float) -> Fit:
    part = loaded.part
    joint = part.interfaces.get(name)
    pins = [one for one in loaded.design.parts.values() if joint and one.joint == joint]
    material = pins[0].material if pins else part.material
    words = (
        f"{pins[0].name} of {pins[0].material.name}"
        if pins
        else f"pin of the part's own {part.material.name}, as no part is that pin"
    )
    return Fit(least, largest, material.youngs_modulus, material.poisson_ratio, words)


@dataclass(frozen=True, eq=False)
class PinnedBores:
    """Bores of one mesh whose pins have a fit; their waves of pressure are solved once.

    solutions  of the part, under assumed pressures
    fits       bore -> fit of its pin
    """

    solutions: UnitSolutions
    fits: Mapping[str, Fit]

    @cached_property
    def harmonics(self) -> list[BoreHarmonics]:
        """Waves of pressure in each bore; raises MeshError."""
        return [bore_harmonics(self.solutions, name) for name in self.fits]

    def contact(
        self, coefficients: FloatArray, clearances: Sequence[float] = CLEARANCES
    ) -> "Contact":
        """Solve the contact at some shares of the range of clearances.

        coefficients  (n_basis, n_positions) of `solutions`, with the assumed pressure in the bores

        Raises ContactError and MeshError.
        """
        known = all(fit.least == fit.largest for fit in self.fits.values())
        shares = (MIDDLE,) if known else tuple(clearances)
        cycles = [
            solve_contact(
                self.harmonics,
                coefficients,
                {name: fit.pin(share) for name, fit in self.fits.items()},
            )
            for share in shares
        ]
        solutions, found, missed = superposed(self.harmonics, cycles)
        which = {share: 0 if known else shares.index(share) for share in clearances}
        return Contact(
            self,
            solutions,
            {share: found[k] for share, k in which.items()},
            {share: cycles[k] for share, k in which.items()},
            missed,
        )


def pinned_bores(solutions: UnitSolutions, fits: Mapping[str, Fit]) -> PinnedBores | None:
    """The bores of a mesh whose pins have a fit; None without any."""
    return PinnedBores(solutions, fits) if fits else None


@dataclass(frozen=True, eq=False)
class Contact:
    """Contact in the bores of one mesh over all positions.

    pins          of the mesh
    solutions     unit loads with the waves of pressure of these bores
    coefficients  share of the range of clearances -> (n_basis, n_positions) of `solutions`
    cycles        share -> contact
    missed        MPa, the largest pressure that is missed of a short wave
    """

    pins: PinnedBores
    solutions: ContactSolutions
    coefficients: Mapping[float, FloatArray]
    cycles: Mapping[float, ContactCycle]
    missed: float

    @cached_property
    def short_waves(self) -> IntArray:
        """Columns (n,) of `solutions` that have stress but no displacement."""
        names = [name for unit in self.solutions.interfaces for name in unit.names]
        return np.flatnonzero([name.startswith("short wave") for name in names])

    @property
    def residual(self) -> float:
        """Largest miss of complementarity or of equilibrium over all positions, scaled."""
        return max(max(one.not_complementary, one.unbalanced) for one in self.cycles.values())
