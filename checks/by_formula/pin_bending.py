"""Nominal bending, shear and twist of a pin over its stack, against yield.

Lugs press evenly over their widths (`checks.handbook.pin_diagrams`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from checks.design.data import Part
from checks.handbook.pin_diagrams import PinDiagram, pin_diagram
from checks.part.derived import Heading, Kind, shear_yield, yield_stress
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads, first_largest
from checks.result.derivation import Column, Given, Item, Step, Sum
from checks.result.formulas import Value
from checks.result.verdict import Check
from geometry.mesh import FloatArray
from geometry.parts import Pin
from geometry.parts.pin import as_pin

BENDING = Kind(
    name="pin bending",
    quantity="nominal bending stress 32 M/(pi d^3)",
    demand="bending stress of the pin as a beam",
    limit="yield stress",
    require="static",
    source="[fits](../theory/fits.md)",
)

TOGETHER = Kind(
    name="pin bending",
    quantity="bending with shear, von Mises",
    demand="von Mises stress at the rim, where it exceeds both others",
    limit="yield stress",
    require="static",
    source="[fits](../theory/fits.md)",
)

SHEAR = Kind(
    name="pin shear",
    quantity="nominal shear stress 4/3 of 4 V/(pi d^2)",
    demand="shear stress in the middle of the pin, friction included",
    limit="yield stress over √3",
    require="static",
    source="Jourawski; [fits](../theory/fits.md)",
)
KINDS = (BENDING, TOGETHER, SHEAR)

_COUNTS = 1.01  # times bending or shear alone, from which their sum is a check of its own
_ROUND_OFF = 1e-12  # of a stress
_UNITS = (("F_x", "N"), ("F_y", "N"), ("M_x", "N mm"), ("M_y", "N mm"), ("M_z", "N mm"))
_ROWS = (0, 1, 3, 4, 5)  # of a wrench


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Nominal bending and shear of a pin over its stack; their sum where it is more than either."""
    shape, wrenches = as_pin(loaded.part.geometry), dict(loaded.loads.wrenches)
    if shape is None:
        return
    diagram = pin_diagram(shape, wrenches, ends_only=True)
    bent = _Worst.of(loaded, shape, diagram, diagram.bending_stress)
    sheared = _Worst.of(loaded, shape, diagram, diagram.shear_stress)
    bending = bent.check(
        BENDING,
        [bent.diameter, *bent.bent],
        [yield_stress(loaded.part)],
        _pressures(shape, loaded.loads),
    )
    shear = sheared.check(
        SHEAR,
        [sheared.diameter, *sheared.sheared],
        [yield_stress(loaded.part), shear_yield()],
    )
    yield from (bending, shear)
    both = diagram.equivalent_peaks
    if both.max() <= _COUNTS * max(bending.value, np.sqrt(3) * shear.value):
        return
    worst = _Worst.of(loaded, shape, diagram, both)
    yield worst.check(
        TOGETHER,
        [worst.diameter, *worst.sheared, *worst.bent, *worst.together],
        [yield_stress(loaded.part)],
    )


@dataclass(frozen=True, eq=False)
class _Worst:
    """The section and the position at which a stress of a pin is largest.

    diagram  of the pin
    weights  (5, seats, 5) shear x, y, moment x, y and torque there per unit of each component
    """

    loaded: LoadedPart
    diagram: PinDiagram
    position: int
    section: int
    weights: FloatArray

    @staticmethod
    def of(loaded: LoadedPart, shape: Pin, diagram: PinDiagram, stress: FloatArray) -> "_Worst":
        """Where a stress (n, m) of the diagram is largest."""
        position, section = first_largest(stress)
        weights = _weights(shape, list(loaded.loads.wrenches), section)
        return _Worst(loaded, diagram, position, section, weights)

    def check(self, kind: Kind, demand: list[Item], limit: list[Item], more: str = "") -> Check:
        """The check there."""

        def note(found: Mapping[str, Value]) -> str:
            acts = f"M = {found['M'] / 1e3:.1f} N m" if "M" in found else f"V = {found['V']:.0f} N"
            if kind is SHEAR and "T" in found:
                torque = abs(float(found["T"])) / 1e3
                acts += f", T = {torque:.3g} N m by friction: 16 T/(pi d^3) more"
            told = f"{acts}, d = {found['d']:g} mm; every lug presses evenly over its width"
            return f"{told}; {more}" if more else told

        return self.loaded.at(
            self.position,
            Heading(
                kind=kind,
                place=f"z = {round(float(self.diagram.places[self.section]), 2) + 0.0:g} mm",
                basis=_basis(self.loaded.part, limit),
                note=note,
            ),
            demand,
            limit,
        )

    @property
    def diameter(self) -> Given:
        """Diameter of the pin in the section."""
        said = f"diameter of the pin at z = {float(self.diagram.places[self.section]):.4g} mm"
        size = float(self.diagram.diameter[self.section])
        return Given("d", said, size, "mm", "the part's shape")

    @property
    def bent(self) -> list[Item]:
        """Bending of a round bar by the moment in the section."""
        return [
            self._sum("M_x", "moment in the plane of x and z", "N mm", 2),
            self._sum("M_y", "moment in the plane of y and z", "N mm", 3),
            Step("M", "bending moment", "sqrt(M_x^2 + M_y^2)", "N mm", main=True),
            Step("sigma_b", "nominal bending stress of a round bar", "32*M/(pi*d^3)", "MPa",
                 "beam theory", main=True),
        ]  # fmt: skip

    @property
    def sheared(self) -> list[Item]:
        """Shear in the middle of a round bar, and what friction twists it by."""
        items: list[Item] = [
            self._sum("V_x", "shear force along x", "N", 0),
            self._sum("V_y", "shear force along y", "N", 1),
            Step("V", "shear force", "sqrt(V_x^2 + V_y^2)", "N", main=True),
        ]
        formula, said = "16*V/(3*pi*d^2)", "largest shear stress: 4/3 of the mean"
        if self.diagram.torque[self.position, self.section]:
            items.append(self._sum("T", "torque by friction", "N mm", 4))
            formula, said = f"{formula} + 16*abs(T)/(pi*d^3)", f"{said}, and of the twist"
        return [*items, Step("tau", said, formula, "MPa", "Jourawski", main=True)]

    @property
    def together(self) -> list[Item]:
        """Bending and shear at the place of the rim where they are worst together."""
        here = self.position, self.section
        angle = self.diagram.rim_at(*here)
        if angle is None:
            said = "von Mises in the middle, where nothing is bent"
            return [Step("sigma", said, "sqrt(3)*tau", "MPa", main=True)]
        moment, force = self.diagram.moment[here], self.diagram.shear[here]
        apart = float(np.arctan2(moment[1], moment[0]) - np.arctan2(force[1], force[0]))
        twist = float(self.diagram.twist_stress[here])
        return [
            Given("tau_T", "part of the shear stress that is twist's", twist, "MPa"),
            Given("a", "angle of the rim from where bending is largest", angle, "rad",
                  "the worst of every 5°"),
            Given("b", "angle from the shear force to the moment", apart, "rad"),
            Step("sigma", "von Mises stress there",
                 "sqrt((sigma_b*cos(a))^2 + 3*((tau - tau_T)*sin(a + b)^2 + tau_T)^2)", "MPa",
                 "Jourawski; von Mises", main=True),
        ]  # fmt: skip

    def _sum(self, symbol: str, meaning: str, unit: str, row: int) -> Sum:
        """Sum over the lugs beyond the section: each component times its lever or share."""
        rows = [
            (f"{name} {_UNITS[k][0]} [{_UNITS[k][1]}]", float(wrench[_ROWS[k]]), float(own[k]))
            for (name, whole), own in zip(
                self.loaded.loads.wrenches.items(), self.weights[row], strict=True
            )
            for wrench in [whole[self.position]]
            for k in range(len(_ROWS))
            if own[k] and wrench[_ROWS[k]]
        ]
        return Sum(
            symbol,
            meaning,
            "Q*w",
            tuple(name for name, *_ in rows),
            (
                Column("Q", "what acts on the lug", "", tuple(size for _, size, _ in rows)),
                Column(
                    "w", "its lever or share beyond the section", "", tuple(w for *_, w in rows)
                ),
            ),
            unit,
            "every lug presses evenly over its width",
        )  # fmt: skip


def _weights(shape: Pin, names: list[str], section: int) -> FloatArray:
    """Shear x, y, moment x, y and torque (5, seats, 5) of a section per unit of each component."""
    count = len(_ROWS) * len(names)
    units = {}
    for k, name in enumerate(names):
        units[name] = np.zeros((count, 6))
        units[name][np.arange(len(_ROWS)) + len(_ROWS) * k, list(_ROWS)] = 1.0
    diagram = pin_diagram(shape, units, ends_only=True)
    found = [
        *diagram.shear[:, section].T,
        *diagram.moment[:, section].T,
        diagram.torque[:, section],
    ]
    return np.stack(found).reshape(len(found), len(names), len(_ROWS))


def _basis(part: Part, limit: list[Item]) -> str:
    """Where the limit is from, in words."""
    rule = "yield stress" if len(limit) == 1 else "yield stress over sqrt 3"
    return f"{rule}, guaranteed minimum ({part.material.source}); nominal, without steps' peaks"


def _pressures(shape: Pin, loads: PartLoads) -> str:
    """The largest mean pressure F/(d w) in each seat, in words."""
    told = []
    for seat in shape.seats:
        area = (seat.diameter or shape.diameter) * seat.width * len(seat.places)
        told.append(f"{seat.name} {loads.resultant(seat.name).max() / area:.3g}")
    return "mean pressure F/(d w), MPa: " + ", ".join(told)
