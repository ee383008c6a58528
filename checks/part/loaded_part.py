"""A part with its loads, and with what its machine asks of it."""

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, isfinite, radians, sqrt
from typing import NamedTuple, Protocol

import numpy as np

from checks.design.data import COMPARED_ARC, Design, Duty, Part, StatedMass
from checks.design.errors import DesignError
from checks.design.model import Requirements
from checks.handbook.fits import DEFAULT, clearances_of
from checks.part.derived import (
    NO_BAND,
    Band,
    Heading,
    Series,
    demand_over,
    derivation_at,
    derived_check,
    load_case,
)
from checks.part.part_loads import Doubt, PartLoads, Runs, first_largest, loads_on
from checks.part.pressed_along import UNSTATED, Stack, Uneven, stack_in, uneven_bores
from checks.result.derivation import Derivation, Item
from checks.result.verdict import Check
from fem.contact.persson import persson_half_arc, persson_pressure
from geometry.cad_body import SolidBody, cad_body
from geometry.closed_form import closed_body
from geometry.mesh import FloatArray, Interface, Mesh
from geometry.meshing import mesh_shape
from geometry.shape import Buildable

FIRST = 0.7  # fineness of the first mesh; where the stress decides, later ones are finer


class Bodies(Protocol):
    """Bodies and meshes of shapes; both functions raise MeshError."""

    def body(self, shape: Buildable) -> SolidBody:
        """The body of a shape as it is known without a mesh."""

    def measured(self, shape: Buildable, fineness: float) -> Mesh:
        """A mesh of a shape to measure it on, of a fineness if none is known."""


class _Unkept:
    """Bodies and meshes that are built each time they are asked for."""

    def body(self, shape: Buildable) -> SolidBody:
        return closed_body(shape) or cad_body(shape)

    def measured(self, shape: Buildable, fineness: float) -> Mesh:
        return mesh_shape(shape, fineness=fineness)


UNKEPT = _Unkept()
_AROUND = 180  # angles, around half of a pin
_ROWS = 20_000  # positions of which all angles are asked at once
_TOGETHER = 500  # positions whose pressure around a bore is asked at once
_SMALL = 1e-12  # of the largest force
_GONE = 0.01  # of the largest force
_STRESSED = 0.95  # of the largest amplitude


def bent_area(loads: PartLoads, cycles: Iterable[str]) -> float:
    """Area of a round pin with 95 % of its largest stress amplitude, over its diameter squared.

    The definition of Shigley's equivalent diameter (9th ed., eq. 6-22 to 6-24): 0.0766 where a
    force goes round the pin, 0.01046 where it stays in one plane. At the angle t its fibres have
    the amplitude r a(t), a half the range of F . (cos t, sin t) over a cycle. The largest of the
    seats and cycles with half of the largest amplitude, in the pin's frame; 0 without any.
    """
    angles = np.linspace(0.0, np.pi, _AROUND, endpoint=False)
    ways = np.stack([np.cos(angles), np.sin(angles)])
    swings = np.array(
        [
            _swings(wrench[loads.cycles[name], :2], ways)
            for name in cycles
            if name in loads.cycles
            for wrench in loads.wrenches.values()
        ]
    ).reshape(-1, _AROUND)
    peaks = swings.max(axis=1, initial=0.0)
    strong = swings[peaks > 0.5 * peaks.max(initial=0.0)]
    if not len(strong):
        return 0.0
    shares = np.maximum(strong / strong.max(axis=1, keepdims=True), _STRESSED)
    areas = (1.0 - (_STRESSED / shares) ** 2).sum(axis=1) * np.pi / _AROUND / 4.0
    return float(areas.max())


def _swings(force: FloatArray, ways: FloatArray) -> FloatArray:
    """Ranges (k,) of forces (n, 2) along each of the unit vectors (2, k)."""
    pieces = np.array_split(ways, 1 + len(force) // _ROWS, axis=1)
    return np.concatenate([np.ptp(force @ some, axis=0) for some in pieces])


@dataclass(frozen=True, eq=False)
class LoadedPart:
    """A part of a design under its loads over all cycles: what every model and check is given.

    design  the machine that it is a part of
    loads   on its interfaces, in its own axes, at all positions
    runs    name -> loads of the whole linkage in a computed cycle or a measured run
    bodies  where its body and mesh are from
    solved  whether its loads are those of solved positions: between them forces, couples and
            reaches have a spline each
    """

    design: Design
    part: Part
    loads: PartLoads
    runs: Runs = field(default_factory=dict)
    bodies: Bodies = UNKEPT
    solved: bool = True

    @staticmethod
    def of(
        design: Design,
        part: Part,
        runs: Runs,
        bodies: Bodies | None = None,
        doubts: Sequence[Doubt] = (),
    ) -> "LoadedPart":
        """Gather a part's loads over all runs.

        bodies  of shapes, as the run has them
        doubts  what the runs may be instead

        Raises loads.LinkageError where a force meets the part at no interface, or nothing loads it,
        and DesignError where a contact slides off the stretch that the part has for it.
        """
        loads = loads_on(design, part, runs, doubts)
        if part.clearances:
            pins = {one.joint: one for one in design.parts.values() if one.joint is not None}
            part = with_fits(part, loads, part.geometry.placed_interfaces, pins)
        if part.joint is not None:
            part = replace(part, bent_area=bent_area(loads, design.duty.cycles))
        found = LoadedPart(design, part, loads, runs, bodies or UNKEPT)
        check_reach(found, found.solid.interfaces)
        return found

    def under(self, loads: PartLoads) -> "LoadedPart":
        """The same part under other loads."""
        return replace(self, loads=loads)

    def between(self, loads: PartLoads) -> "LoadedPart":
        """The same part under loads that are splined between the solved positions."""
        return replace(self, loads=loads, solved=False)

    def worst(
        self,
        heading: Heading,
        demand: Sequence[Series | Item],
        limit: Sequence[Item],
        band: Band = NO_BAND,
    ) -> Check:
        """The check of a demand against a limit, where over all positions the demand is largest.

        demand  items in an order in which each uses only what stands before; the last is the value.
                A `Series` has a value for each position
        limit   items; the last one is the limit
        band    formulas of the model band, of the value and all other symbols

        Of equal positions the first is taken. The value, the limit and the bars are those of the
        formulas at that position, which are the check's derivation. Raises FormulaError.
        """
        (position,) = first_largest(demand_over(demand))
        return self.at(position, heading, demand, limit, band)

    def at(
        self,
        position: int,
        heading: Heading,
        demand: Sequence[Series | Item],
        limit: Sequence[Item],
        band: Band = NO_BAND,
    ) -> Check:
        """The same check at one of all positions, which is known to be the worst. As `worst`."""
        case = load_case(self.part, self.loads, position)
        return self.derived(heading, position, derivation_at(case, position, demand, limit, band))

    def derived(self, heading: Heading, position: int, derivation: Derivation) -> Check:
        """The check at one of all positions whose numbers are those of its derivation."""
        part, loads = self.part, self.loads
        cycle, label = loads.cycle_names[position], loads.labels[position]
        return derived_check(part.name, cycle, label, heading, derivation, self.required)

    @cached_property
    def uneven(self) -> Mapping[str, Uneven]:
        """By bore, how much more its bent pin presses at the most than on average, and where.

        As models without contact have it; without bores that are pressed evenly.
        """
        return uneven_bores(self.design, self.part, self.loads, self.runs)

    @cached_property
    def loose(self) -> "Mapping[str, Loose]":
        """By bore, how much more a pin of the default fit may press than on assumed arcs."""
        pins = {one.joint: one for one in self.design.parts.values() if one.joint is not None}
        return pressed_loosely(self.part, self.loads, self.part.geometry.placed_interfaces, pins)

    @property
    def narrowest_arc(self) -> float:
        """The narrowest arc, rad, on which pins may press in its bores, loose ones too."""
        return min([self.part.narrowest_arc, *(one.arc for one in self.loose.values())])

    def stack(self, bore: str, clearance: float = 0.0) -> Stack | None:
        """The stack of the pin in a bore, where one is known (`stack_in`)."""
        return stack_in(self.design, self.part, self.loads, self.runs, bore, clearance)

    @property
    def name(self) -> str:
        """Name of the part."""
        return self.part.name

    @property
    def stated(self) -> StatedMass:
        """Mass properties that the file states beside the part's own."""
        return self.design.stated_mass(self.part)

    @property
    def solid(self) -> SolidBody:
        """The body of the part, not meshed; raises MeshError."""
        return self.bodies.body(self.part.geometry)

    @property
    def measurable(self) -> Mesh | SolidBody:
        """The body as its ligaments are known: of one from CAD they are measured on its mesh."""
        if any(self.part.geometry.ligaments(name) is None for name in self.part.interfaces):
            return self.bodies.measured(self.part.geometry, FIRST * self.part.fineness)
        return self.solid

    @property
    def duty(self) -> Duty:
        """How often each cycle runs."""
        return self.design.duty

    @property
    def required(self) -> Requirements:
        """Least safety factors, by kind of check."""
        return self.design.require

    @property
    def accuracy(self) -> float:
        """Numerical error, as a share of a stress, that a mesh is refined to."""
        return self.design.accuracy


def check_reach(loaded: LoadedPart, interfaces: Mapping[str, Interface]) -> None:
    """Raise DesignError where a contact slides off the stretch that the part has for it."""
    part = loaded.part
    for name, reach in loaded.loads.reaches.items():
        interface = interfaces[name]
        low, high = interface.travel
        slack = 1e-6 * (high - low)
        first, last = float(reach.min()), float(reach.max())
        if first >= low - slack and last <= high + slack:
            continue
        loads, worst = loaded.loads, int(np.argmax(np.maximum(low - reach, reach - high)))
        zero = float(interface.centre[0])
        stated = [
            field.name
            for field in dataclasses.fields(part.geometry)
            if field.name.startswith(("travel_", "contact_", "slot_"))
        ]
        raise DesignError(
            loaded.design.file,
            f"parts.{part.name}.interfaces.{name}",
            f"the contact slides from x = {zero + first:.4g} to {zero + last:.4g} mm along the "
            f"part, which has it from {zero + low:.4g} to {zero + high:.4g} mm; at "
            f"{loads.cycle_names[worst]}, {loads.labels[worst]} it leaves that; change "
            f"{', '.join(stated)}",
        )


# Arcs on which pins may press, from stated fits, for models that do not solve the contact.
#
# With p = E* dR t/F of the largest clearance and force, cosine pressures on arcs from 129
# deg/sqrt(p) to the half circle hold the stress of frictionless contact; below p = 1.2 those from
# 120 deg do, or lie above it. Where the arc comes out below 90 deg, the band of an arc that is
# not stated holds it: 90 deg, and a share more in bores (docs/validation.md, Pins in holes).

_ARC, _WIDEST = radians(129), radians(120)

# Largest pressure over F/(R t) of a cosine on 90 deg, and how much more than Persson's a loose pin
# may have at a bore's ends.
_ON_COMPARED, _LOOSE = 3 / (2 * sqrt(2)), 1.1


class Loose(NamedTuple):
    """How a pin of the default fit may press in a bore, beside the narrowest assumed arc.

    peak   MPa, by how much more at the most
    swing  MPa, by how much more pressure comes and goes at a point of the bore, not below `peak`
    arc    rad, on which it presses under the largest force
    """

    peak: float
    swing: float
    arc: float

    def times(self, more: float) -> "Loose":
        """The same where all of the pressure is more times as large."""
        return self._replace(peak=more * self.peak, swing=more * self.swing)


def with_fits(
    part: Part, loads: PartLoads, interfaces: Sequence[Interface], pins: Mapping[str, Part]
) -> Part:
    """Return the part with the narrowest arc of contact of all its bores, by their stated fits.

    pins  point -> the part that is the pin of its joint; where there is none, the pin is of the
          part's own material

    A bore without a stated fit keeps the part's arc. A pin is loose where its arc is narrower than
    those on which formulas were compared with solids; `least_arc` is as narrow as that.
    """
    if not part.clearances:
        return part
    arcs, known, least = [], True, _WIDEST
    for face in interfaces:
        if face.kind != "bore":
            continue
        if face.name not in part.clearances:
            arcs.append(part.bearing_arc)
            known = known and part.arc_stated
            continue
        pin = pins.get(part.interfaces[face.name])
        arc = _WIDEST
        if p := _parameter(part, _elastic(pin or part), face, loads, part.clearances[face.name][1]):
            arc = min(_ARC / sqrt(p), _WIDEST)
        least = min(least, arc)
        arcs.append(max(arc, COMPARED_ARC))
    stated = known and least >= COMPARED_ARC
    return replace(part, bearing_arc=min(arcs), arc_stated=stated, least_arc=least)


def pressed_loosely(
    part: Part, loads: PartLoads, interfaces: Sequence[Interface], pins: Mapping[str, Part]
) -> dict[str, Loose]:
    """By bore, how much more a loose pin may press than on the narrowest assumed arc.

    Of bores whose arc and fit are not stated, with the largest clearance of the default fit, up to
    the diameters of its table; without those in which the arc of that is no narrower. Where no part
    is the pin, it is as stiff as steel, if not more. The difference of both pressures moves no
    force; around a hole it makes as much hoop stress, both of one sign. So von Mises stress, a
    norm, has at most that more (docs/theory/bearing.md).
    """
    found: dict[str, Loose] = {}
    for face in interfaces:
        if face.kind != "bore" or part.arc_stated or face.name in part.clearances:
            continue
        try:
            clearance = clearances_of(DEFAULT, 2 * face.radius)[1]
        except ValueError:
            continue
        pin = pins.get(part.interfaces[face.name])
        stiff = max(_elastic(part), UNSTATED) if pin is None else _elastic(pin)
        p = _parameter(part, stiff, face, loads, clearance)
        if isfinite(p) and p:
            mean = float(loads.resultant(face.name).max()) / face.radius / face.length
            half = persson_half_arc(p)
            largest = _LOOSE * persson_pressure(half)
            more = mean * (largest - _ON_COMPARED)
            if more > 0.0:
                swing = mean * _swung_more(loads.wrenches[face.name][:, :2], half, largest)
                found[face.name] = Loose(more, max(more, swing), 2 * half)
    return found


def _swung_more(forces: FloatArray, half: float, largest: float) -> float:
    """How much more a loose pin's pressure swings than the cosine on 90 deg does, over F/(R t).

    Each the most of all points of the bore. Under a steady force that sways by some degrees narrow
    contact leaves points on which the cosine stays. Smaller forces press on arcs as Hertz has them.

    forces         (n, 2) on the bore over all positions
    half, largest  arc, rad, and pressure under the largest force F
    """
    share = np.hypot(*forces.T)
    share /= share.max()
    if share.min() < _GONE:  # then both are as good as gone from every point
        return largest - (1 - _GONE) * _ON_COMPARED
    around = np.linspace(-np.pi, np.pi, 2 * _AROUND, endpoint=False)
    steady: FloatArray = np.full((2, len(around)), inf)
    most = np.zeros_like(steady)
    for some in np.array_split(np.arange(len(forces)), 1 + len(forces) // _TOGETHER):
        way = np.arctan2(forces[some, 1], forces[some, 0])
        off = np.abs((around - way[:, None] + np.pi) % (2 * np.pi) - np.pi)
        size = share[some, None]
        reach = half * np.sqrt(np.maximum(size, _SMALL))
        narrow = np.sqrt(size * np.maximum(1.0 - (off / reach) ** 2, 0.0))
        cosine = size * np.cos(np.minimum(2 * off, np.pi / 2))
        pressed = np.stack([largest * narrow, _ON_COMPARED * cosine])
        most = np.maximum(most, pressed.max(axis=1))
        steady = np.minimum(steady, pressed.min(axis=1))
    loose, assumed = (most - steady).max(axis=1)
    return float(loose - assumed)


def _parameter(
    part: Part,
    pin: tuple[float, float],
    face: Interface,
    loads: PartLoads,
    clearance: float,
) -> float:
    """E* dR t/F under the largest force, in plane strain.

    pin        its Young's modulus, MPa, and Poisson's ratio
    clearance  on diameter, mm
    """
    if not clearance:
        return 0.0
    softness = sum((1 - nu**2) / modulus for modulus, nu in (_elastic(part), pin))
    force = float(loads.resultant(face.name).max())
    return clearance / 2 / softness * face.length / force if force else inf


def _elastic(part: Part) -> tuple[float, float]:
    return part.material.youngs_modulus, part.material.poisson_ratio
