"""Pins that bend in their stack, which press more at the edges of a part's bores.

Contact is solved with an even pressure along the pin. Where the design has the pin and its stack,
the line load along it is solved, too (fem/contact/line_load.py), with the least clearance of the
fit and other lugs as soft as slender forks, which bend it nearly as much as free ones; the part's
own cheeks tilt as its mesh does.
The judged stress under that pressure is the model band's. Pins with lugs on one side are left out.

What edges have more than under even pressure counts in no band where they are stated to have run
in, nor in a static one where part and pin are ductile and the pin holds under even pressure: by the
lower bound theorem of limit analysis the edges yield, no more (docs/theory/contact.md).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import inf
from typing import NamedTuple

import numpy as np

from checks.design.data import Design, Part
from checks.handbook.fits import DEFAULT
from checks.handbook.pin_diagrams import pin_diagram
from checks.handbook.pin_loaded_hole import BEYOND_ARCS
from checks.part.part_loads import PartLoads, Runs, loads_on
from fem.contact.beds import Lug, RoundBar
from fem.contact.condensed import ContactError
from fem.contact.cylinder_waves import Lining
from fem.contact.line_load import LineLoad, line_load
from fem.contact.uneven import shares_along, turn_in_bore
from geometry.mesh import FloatArray
from geometry.parts import Pin
from geometry.parts.pin import as_pin

_FREE = 1e4  # times a strip's: own lugs that tilt as they like
# Times a strip's: lugs of other parts, whose shape is seldom stated. A fork's cheek three times as
# long as wide, weakened by its hole as the one beside CalculiX (docs/theory/contact.md).
_SOFT = 3 * 1.3
SOFT_LUGS = "lugs of other parts tilt no more than a fork's cheeks three times as long as wide"
_ALIKE = 1e-6  # of the mean line load
UNSTATED = 210e3, 0.3  # MPa and 1, of bushes whose material is not stated: steel's
_NOTHING = 1e-6  # of the largest force in a stack: a lug that carries none


@dataclass(frozen=True, eq=False)
class Stack:
    """A pin in its stack, as one bore of a part meets it.

    design     the machine
    pin        the part that is the pin
    loads      on the pin
    bore       name of the body whose lugs are the part's
    clearance  mm on diameter, of all lugs
    """

    design: Design
    pin: Part
    loads: PartLoads
    bore: str
    clearance: float

    @property
    def shape(self) -> Pin:
        """Shape of the pin."""
        shape = as_pin(self.pin.geometry)
        assert shape is not None
        return shape

    @property
    def paired(self) -> bool:
        """True if the part has two lugs on the pin."""
        return any(seat.paired for seat in self.shape.seats if seat.name == self.bore)

    @cached_property
    def bar(self) -> RoundBar:
        """The pin as a beam."""
        shape = self.shape
        cuts, diameters = [shape.ends[0]], []
        for seat, low, high in shape.seated():
            if low > cuts[-1]:
                cuts.append(low)
                diameters.append(shape.diameter)
            cuts.append(high)
            diameters.append(shape.neck(seat))
        if shape.ends[1] > cuts[-1]:
            cuts.append(shape.ends[1])
            diameters.append(shape.diameter)
        material = self.pin.material
        return RoundBar(
            tuple(cuts), tuple(diameters), material.youngs_modulus, material.poisson_ratio
        )

    @cached_property
    def pin_safety(self) -> float:
        """Yield stress of the pin over its largest nominal stress while all lugs press evenly.

        Von Mises of bending, shear and twist, as its own checks have it, or the mean pressure of a
        seat where that is more.
        """
        wrenches = self.loads.wrenches.items()
        stress = _even_peak(self.shape, tuple((name, one.tobytes()) for name, one in wrenches))
        return self.pin.material.yield_stress / stress if stress else inf

    @cached_property
    def bush_safety(self) -> float:
        """Yield stress of the lug's bush over its mean pressure; inf where none is stated."""
        bush = self.pin.bushes.get(self.bore)
        seat = next(seat for seat in self.shape.seats if seat.name == self.bore)
        area = self.shape.neck(seat) * seat.width * len(seat.places)
        force = float(self.loads.resultant(self.bore).max())
        return bush.yield_stress * area / force if bush and force else inf

    def yields_even(self, factor: float = 1.0) -> bool:
        """True if even pressure is known to be carried once edges yield: the lower bound theorem.

        Part, pin and bush are ductile, and pin and bush hold under even pressure with the safety
        that static checks must have.
        """
        return self.is_ductile and factor <= self.even_up_to

    @property
    def even_up_to(self) -> float:
        """Largest factor on all loads under which pin and bush hold even pressure as they must."""
        return min(self.pin_safety, self.bush_safety) / self.design.require.static

    @property
    def is_ductile(self) -> bool:
        """True if part, pin and bush, where its material is stated, are ductile."""
        part = self.design.part_of(self.bore)
        materials = [self.pin.material, self.pin.bushes.get(self.bore)]
        materials += [part.material] if part else []
        return all(material.ductile for material in materials if material is not None)

    def lugs(self, position: int, tilt: float) -> tuple[list[Lug], int]:
        """Lugs that carry a force, and which of them is the part's: the upper one of a pair.

        tilt  rad/(N mm), of the part's own lugs
        """
        wrenches = {name: w[position, :2] for name, w in self.loads.wrenches.items()}
        largest = max(float(np.hypot(*force)) for force in wrenches.values())
        found: list[Lug] = []
        own = -1
        for seat, low, high in self.shape.seated():
            force = -wrenches[seat.name] / len(seat.places)
            if np.hypot(*force) <= _NOTHING * largest:
                continue
            if seat.name == self.bore:
                own = len(found)
            body = self.design.part_of(seat.name)
            material = (body or self.pin).material
            lug = Lug(
                low,
                high,
                (float(force[0]), float(force[1])),
                material.youngs_modulus,
                material.poisson_ratio,
                0.0,
                self.clearance,
                lining_in(self.design, self.pin, seat.name),
            )
            way = tilt if seat.name == self.bore else _SOFT * _bent(lug)
            found.append(replace(lug, tilt=way) if seat.paired else lug)
        return found, own

    def most_pressed(self, position: int) -> tuple[float, str]:
        """`most_pressed` where the part's lugs tilt as little as they may, or as they like."""
        lugs, own = self.lugs(position, 0.0)
        if own < 0:
            return 1.0, ""
        tilts = {self._least_tilt(lugs[own]), _FREE * _bent(lugs[own])} if self.paired else {0.0}
        every = [self.shares(position, tilt) for tilt in sorted(tilts)]
        return max(most_pressed(shares) for shares in every if shares is not None)

    def _least_tilt(self, lug: Lug) -> float:
        """The least that a lug of the part may tilt, rad/(N mm)."""
        part = self.design.part_of(self.bore)
        turn = part.geometry.cheeks_turn / lug.youngs_modulus if part else 0.0
        return max(turn - turn_in_bore(self.bar, lug), 0.0) if turn else 0.0

    def shares(self, position: int, tilt: float) -> FloatArray | None:
        """The a_k (n,) by which the part's line load differs from a straight pin's.

        A straight pin, too, presses more at the sharp edges of a bore, next to them alone, as
        elements and tests have it; None where the lug carries nothing. Raises ContactError where
        the pin's forces are not in balance.
        """
        lugs, own = self.lugs(position, tilt)
        if own < 0:
            return None
        alike = under_one(lugs)
        held = tuple(replace(lug, tilt=0.0) for lug in alike)  # as a straight pin has them anyway
        bent, straight = _pressed(self.bar, alike, True), _pressed(self.bar, held, False)
        return shares_along(bent, own) - shares_along(straight, own)


@lru_cache(maxsize=16)
def _even_peak(shape: Pin, forces: tuple[tuple[str, bytes], ...]) -> float:
    """Largest stress of a pin, MPa, under even pressure: once for all parts that it meets.

    forces  seat and its wrenches (n, 6), as bytes
    """
    wrenches = {name: np.frombuffer(one).reshape(-1, 6) for name, one in forces}
    stress = pin_diagram(shape, wrenches, ends_only=True).equivalent_peaks.max()
    for seat in shape.seats:
        area = shape.neck(seat) * seat.width * len(seat.places)
        stress = max(stress, np.hypot(*wrenches[seat.name][:, :2].T).max() / area)
    return float(stress)


def _bent(lug: Lug) -> float:
    """12/(E t^3), 1/(N mm): what a strip as long as wide and as thick as a lug turns by."""
    return 12 / (lug.youngs_modulus * lug.width**3)


def under_one(lugs: Sequence[Lug]) -> tuple[Lug, ...]:
    """The lugs with forces over the largest, of four digits, and clearances over that force.

    The line load over its mean is the same: nothing pulls and no gap opens along the pin, so it
    grows with the forces; around, it has the clearance over the force alone.
    """
    largest = max(lug.size for lug in lugs)
    found = []
    for lug in lugs:
        size = float(f"{lug.size / largest:.4g}")
        x, y = (size * round(part / lug.size, 4) for part in lug.force)
        found.append(replace(lug, force=(x, y), clearance=lug.clearance / largest))
    return tuple(found)


@lru_cache(maxsize=256)
def _pressed(bar: RoundBar, lugs: tuple[Lug, ...], bends: bool) -> LineLoad:
    """Variations of a design that leave the pin, its lugs and their shares alike solve nothing."""
    return line_load(bar, lugs, bends=bends)


def lining_in(design: Design, pin: Part, lug: str) -> Lining | None:
    """The bush of a lug of a pin, as wide as the bore of the lug's part.

    As stiff as steel where the design does not state its material: the stiffest that bushes are
    made of. None without a bush, and where no part tells the bore: as stiff as the lug then.
    """
    shape, part = as_pin(pin.geometry), design.part_of(lug)
    if part is None or shape is None or not any(e.bush for e in pin.stack if e.name == lug):
        return None
    neck = next(shape.neck(seat) for seat in shape.seats if seat.name == lug)
    for face in part.geometry.placed_interfaces:
        if face.kind == "bore" and part.interfaces.get(face.name) == pin.joint:
            ratio = 2 * face.radius / neck
            own = pin.bushes.get(lug)
            elastic = (own.youngs_modulus, own.poisson_ratio) if own else UNSTATED
            return Lining(ratio, *elastic) if ratio > 1 else None
    return None


def stack_in(
    design: Design, part: Part, loads: PartLoads, runs: Runs, interface: str, clearance: float
) -> Stack | None:
    """The stack of the pin in a bore; None where the design has none, or lugs on one side.

    loads      of the part; None as well where the pin's are not known at its positions
    clearance  mm on diameter, with which the pin bends
    """
    joint = part.interfaces.get(interface)
    if joint is None or part.body is None or not runs:
        return None
    for pin in design.parts.values():
        shape = as_pin(pin.geometry)
        if pin.joint != joint or shape is None:
            continue
        names = [seat.name for seat in shape.seats]
        even = all(seat.paired or seat.at == 0.0 for seat in shape.seats)
        if even and len(names) > 1 and part.body in names:
            of_pin = loads_on(design, pin, runs)
            if of_pin.labels != loads.labels:
                return None
            return Stack(design, pin, of_pin, part.body, clearance)
    return None


class Uneven(NamedTuple):
    """How much more a bent pin presses in a bore at the most than on average, and at which edge."""

    most: float
    edge: str
    stack: Stack


def why_even(part: Part, bore: str, stack: Stack, *, static: bool, factor: float = 1.0) -> str:
    """Why what a bent pin presses more at a bore's edges counts in no band; "" where it does.

    static  True for the static check
    factor  on all loads
    """
    stated = part.bore_edges.get(bore)
    if stated is not None:
        return f"its edges are stated as {stated.replace('_', ' ')}"
    if static and stack.yields_even(factor):
        return (
            f"edges yield, no more (lower bound theorem), as part and pin are ductile and "
            f"{stack.pin.name} has a safety of {stack.pin_safety:.3g} under even pressure"
        )
    return ""


def that_count(part: Part, uneven: Mapping[str, Uneven], *, static: bool) -> Mapping[str, Uneven]:
    """The bores whose bent pin is in the band of a check."""
    return {
        name: one
        for name, one in uneven.items()
        if not why_even(part, name, one.stack, static=static)
    }


def uncounted_words(part: Part, uneven: Mapping[str, Uneven], value: float, *, static: bool) -> str:
    """How bores that count in no band would be pressed, and why they do not, for a note.

    value  MPa, of the check with all that bent pins press
    """
    told = [
        f"not in the band: {one.most:.3g} times as much at the {one.edge} of {name}, as the pin "
        f"bends: {why}"
        for name, one in uneven.items()
        if (why := why_even(part, name, one.stack, static=static))
    ]
    return "; ".join([*told, f"elastic, with it, up to {value:.4g} MPa"]) if told else ""


def uneven_bores(design: Design, part: Part, loads: PartLoads, runs: Runs) -> Mapping[str, Uneven]:
    """By bore, how much more a bent pin presses at the most than on average, and at which edge.

    Of bores whose pin's stack is known, where the force is largest, without clearance and with lugs
    of the part that tilt as little or as much as they may: no less than solved contact has. Bores
    that are pressed evenly are left out. A `bearing_arc` states how the pin presses around, not
    along.
    """
    found = {}
    for name, wrenches in loads.wrenches.items():
        stack = stack_in(design, part, loads, runs, name, 0.0)
        if stack is None:
            continue
        forces = np.hypot(wrenches[:, 0], wrenches[:, 1])
        try:
            most, edge = stack.most_pressed(int(forces.argmax())) if forces.any() else (1.0, "")
        except ContactError:  # other bodies press as well, or from where the stack does not say
            continue
        if most > 1 + _ALIKE:
            found[name] = Uneven(most, edge, stack)
    return found


def raised_words(
    part: Part, uneven: Mapping[str, Uneven], loose: Mapping[str, float] | None = None
) -> str:
    """How much more bores may have than under even pressure on the assumed arcs, for a note.

    loose  bore -> how much more a pin of the default fit may press, MPa
    """
    told = (
        []
        if part.arc_stated
        else [f"{100 * BEYOND_ARCS:g} % more in bores, whose arc is not stated"]
    )
    told += [
        f"{one.most:.3g} times as much at the {one.edge} of {name}, as the pin bends"
        for name, one in uneven.items()
    ]
    told += [
        f"up to {more:.3g} MPa more pressure in {name} of a pin as loose as {DEFAULT} leaves it"
        for name, more in (loose or {}).items()
    ]
    return ", ".join(told)


def most_pressed(shares: FloatArray) -> tuple[float, str]:
    """Line load over its mean where it is largest, by a_k (n,), and where that is, in words.

    >>> most_pressed(np.array([-0.2, 0.04]))
    (1.24, 'inner edge')
    """
    t = np.linspace(-1.0, 1.0, 41)
    line = 1 + np.polynomial.legendre.legval(t, np.r_[0.0, shares])
    most = float(line.max())
    if most - line[[0, -1]].max() > _ALIKE:
        return most, "middle"
    if abs(line[0] - line[-1]) < _ALIKE:
        return most, "edges"
    return most, "inner edge" if line[0] > line[-1] else "outer edge"
