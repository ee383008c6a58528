"""Pins whose fit is stated: where they press in the bores of a part is solved, not assumed.

The range of clearances that a fit leaves is solved at its middle over all positions, which gives
the value, and over the whole range at some of them, for the model band (checks/stress/clearances).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from checks.design.data import Part
from checks.part.loaded_part import LoadedPart
from checks.part.pressed_along import Stack, lining_in
from fem.contact.bore import BoreHarmonics, bore_harmonics
from fem.contact.cycle import ContactCycle, FittedPin, PartContact
from fem.contact.cylinder_waves import Lining
from fem.contact.superposed import ContactSolutions, superposed
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray, IntArray, Interface
from geometry.parts.pin import as_pin

MIDDLE, LEAST, LARGEST = 0.5, 0.0, 1.0  # share of the range of clearances
CLEARANCES = (MIDDLE, LEAST, LARGEST)
SOFT = -1.0  # not a share: the middle, with bushes whose material is not stated as soft as any
_SOFTEST = 100.0  # MPa: clearance and arc no longer matter
_WIDEST = 2e-3  # of the bore's diameter: loose running fits
CLEARANCE_WORDS = {MIDDLE: "middle", LEAST: "least", LARGEST: "largest"}


@dataclass(frozen=True)
class Fit:
    """Fit of a pin in a bore.

    least, largest  mm, clearance on diameter
    youngs_modulus  MPa, of the pin
    poisson_ratio   of the pin
    material        of the pin and of its bush, in words
    lining          the bush in the bore
    unstated        True: the bush's material is not stated
    stack           of the pin; None where the design has none that tells how it bends
    """

    least: float
    largest: float
    youngs_modulus: float
    poisson_ratio: float
    material: str
    lining: Lining | None = None
    unstated: bool = False
    stack: Stack | None = None

    def clearance(self, share: float) -> float:
        """Clearance on diameter, mm, at a share of the range."""
        share = MIDDLE if share == SOFT else share
        return self.least + share * (self.largest - self.least)

    def pin(self, share: float, factor: float = 1.0) -> FittedPin:
        """The pin at a share of the range, under a factor on the loads as `Contact` has it."""
        elastic, lining = (self.youngs_modulus, self.poisson_ratio), self.lining
        if lining is not None and self.unstated and share == SOFT:
            lining = replace(lining, youngs_modulus=_SOFTEST)
        return FittedPin(self.clearance(share) / factor, *elastic, lining=lining)


def fits_of(loaded: LoadedPart) -> dict[str, Fit]:
    """Fits that the design states of the pins in a part's bores, by bore, in order of its name.

    A pin is of the material of the pin part at that joint, of the part's own where there is none.
    """
    return {
        name: replace(
            _fit(loaded, name, *loaded.part.clearances[name]),
            stack=loaded.stack(name, loaded.part.clearances[name][0]),
        )
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
    lining = lining_in(loaded.design, pins[0], part.body) if pins and part.body else None
    unstated = lining is not None and part.body not in pins[0].bushes
    if lining is not None:
        words += _through(pins[0], part.body or "", lining)
    elif pins and any(entry.bush for entry in pins[0].stack if entry.name == part.body):
        words += ", whose bush has no room in the hole and is left out,"
    elastic = material.youngs_modulus, material.poisson_ratio
    return Fit(least, largest, *elastic, words, lining, unstated)


def _through(pin: Part, lug: str, lining: Lining) -> str:
    """Its bush, in words."""
    index, entry = next((k, e) for k, e in enumerate(pin.stack) if e.name == lug)
    shape = as_pin(pin.geometry)
    assert shape is not None
    thick = (lining.ratio - 1) * (entry.diameter or shape.diameter) / 2
    own, bush = pin.bushes.get(lug), entry.bush
    said = f"{thick:.3g} mm thick,"
    if bush and bush.length < entry.width * (1 - 1e-6):
        said += f" {bush.length:g} mm long but taken as long as the lug of {entry.width:g} mm,"
    if own:
        return f" through a bush of {own.name}, {said}"
    return (
        f" through a bush {said} of a material ASSUMED between steel and so soft that it evens all "
        f"(parts.{pin.name}.stack[{index}].bush.material is not stated),"
    )


@dataclass(frozen=True, eq=False)
class PinnedBores:
    """Bores of one mesh whose pins have a fit; their waves of pressure are solved once.

    solutions  of the part, under assumed pressures
    fits       bore -> fit of its pin
    lasting    bore -> (n,) N of its even pressure that is no pin's
    """

    solutions: UnitSolutions
    fits: Mapping[str, Fit]
    lasting: Mapping[str, FloatArray] = field(default_factory=dict)

    @cached_property
    def harmonics(self) -> list[BoreHarmonics]:
        """Waves of pressure in each bore; raises MeshError."""
        return [bore_harmonics(self.solutions, name) for name in self.fits]

    def contact(self, coefficients: FloatArray) -> "Contact":
        """Solve the contact at the middle of the range of clearances, at all positions.

        coefficients  (n_basis, n_positions) of `solutions`, with the assumed pressure in the bores

        Raises ContactError and MeshError.
        """
        cycle = self.problem(coefficients, MIDDLE).solve()
        return Contact(self, *superposed(self.harmonics, cycle), cycle, coefficients)

    def problem(
        self, coefficients: FloatArray, share: float, factor: float = 1.0, finer: int = 1
    ) -> PartContact:
        """The contact at a share of the range of clearances, not solved yet.

        factor  on the loads, as `Contact` has it
        finer   times as many hats of pressure as its arcs ask for
        """
        pins = {name: fit.pin(share, factor) for name, fit in self.fits.items()}
        return PartContact(self.harmonics, coefficients, pins, finer, self.lasting)


def pinned_bores(solutions: UnitSolutions, fits: Mapping[str, Fit]) -> PinnedBores | None:
    """The bores of a mesh whose pins have a fit; None without any."""
    return PinnedBores(solutions, fits) if fits else None


@dataclass(frozen=True, eq=False)
class Contact:
    """Contact in the bores of one mesh: over all positions at the middle of the clearances.

    Other clearances of the range are solved at the positions that are asked for, and so is a factor
    on all loads. Bodies and gaps are linear but for what touches: with all loads and clearances
    times a factor pressures and stresses are that factor higher and touch in the same places. So
    the contact under a factor, over it, is the contact of the loads as they are, on clearances over
    it.

    pins          of the mesh
    solutions     unit loads with the waves of pressure of these bores
    coefficients  (n_basis, n_positions) of `solutions`
    missed        (n_points of the bore, n_positions) MPa, pressure of short waves that the patterns
                  miss, bore by bore
    cycle         at all positions
    assumed       (n_basis_without_waves, n_positions), with the assumed pressure
    """

    pins: PinnedBores
    solutions: ContactSolutions
    coefficients: FloatArray
    missed: Sequence[FloatArray]
    cycle: ContactCycle
    assumed: FloatArray

    @cached_property
    def _problems(self) -> dict[tuple[float, float], PartContact]:
        return {}

    @cached_property
    def _solved(self) -> dict[tuple[float, float, bytes], ContactCycle]:
        return {}

    @cached_property
    def one_clearance(self) -> bool:
        """True if the fits leave no range of clearances."""
        return all(fit.least == fit.largest for fit in self.pins.fits.values())

    @property
    def unstated(self) -> bool:
        """True if the material of a bush is not stated."""
        return any(fit.unstated for fit in self.pins.fits.values())

    def is_middle(self, share: float) -> bool:
        """True if a share of the range is the clearance that is solved at all positions."""
        return share == MIDDLE or (self.one_clearance and share != SOFT)

    def over(self, positions: IntArray, share: float, factor: float = 1.0) -> ContactCycle:
        """The contact at some positions (m,) and a share of the range; raises ContactError.

        Under loads a factor higher, over that factor.
        """
        if self.is_middle(share) and factor == 1.0:
            return self.cycle.over(positions)
        key = share, factor, positions.tobytes()
        if key not in self._solved:
            if key[:2] not in self._problems:
                self._problems[key[:2]] = self.pins.problem(self.assumed, share, factor)
            self._solved[key] = self._problems[key[:2]].solve(positions.tolist())
        return self._solved[key]

    def finer(self, positions: IntArray, times: int) -> ContactCycle:
        """The contact at the middle of the clearances, with more hats; raises ContactError."""
        key = -float(times), 1.0, positions.tobytes()
        if key not in self._solved:
            problem = self.pins.problem(self.assumed, MIDDLE, finer=times)
            self._solved[key] = problem.solve(positions.tolist())
        return self._solved[key]

    def add_short_waves(
        self,
        stress: FloatArray,
        points: IntArray,
        positions: IntArray,
        share: float,
        factor: float = 1.0,
    ) -> None:
        """Add to stress (n, 6, m), MPa, what short waves make of it, which no state has.

        points     (n,) rising surface points
        positions  (m,)
        """
        key = share, factor, positions.tobytes()
        if key not in self._short_waves:
            self._short_waves[key] = [
                bore.harmonics.short_waves(bore.hats, bore.forces)
                for bore in self.over(positions, share, factor).bores.values()
            ]
        for bore, pressure in zip(self.pins.harmonics, self._short_waves[key], strict=True):
            _, here, there = np.intersect1d(points, bore.points, return_indices=True)
            own = bore.short_wave_stress[there]
            stress[here] += own[:, :, None] * pressure[there][:, None, :]

    @cached_property
    def _short_waves(self) -> dict[tuple[float, float, bytes], list[FloatArray]]:
        return {}

    def with_missed(self, points: IntArray) -> tuple[FloatArray, FloatArray]:
        """Stress (n, 6, n) of pressures that patterns miss, a column for each of some points (n,).

        And these pressures (n, n_positions), MPa.
        """
        stress = np.zeros((len(points), 6, len(points)))
        pressures = np.zeros((len(points), self.coefficients.shape[1]))
        for bore, missed in zip(self.pins.harmonics, self.missed, strict=True):
            _, here, there = np.intersect1d(points, bore.points, return_indices=True)
            stress[here, :, here] = bore.short_wave_stress[there]
            pressures[here] = missed[there]
        return stress, pressures

    @cached_property
    def most_missed(self) -> FloatArray:
        """The largest pressure (n_points,), MPa, that patterns miss at each surface point."""
        most = np.zeros(len(self.solutions.recovery.points))
        for bore, missed in zip(self.pins.harmonics, self.missed, strict=True):
            most[bore.points] = np.abs(missed).max(axis=1, initial=0.0)
        return most

    @cached_property
    def short_waves(self) -> IntArray:
        """Columns (n,) of `solutions` that have stress but no displacement."""
        names = [name for unit in self.solutions.interfaces for name in unit.names]
        return np.flatnonzero([name.startswith("short wave") for name in names])

    @property
    def residual(self) -> float:
        """Largest miss of complementarity or of equilibrium of all that was solved, scaled."""
        every = [self.cycle, *self._solved.values()]
        return max(max(one.not_complementary, one.unbalanced) for one in every)
