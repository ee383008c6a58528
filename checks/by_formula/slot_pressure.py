"""Sliding contacts by formula: Hertz pressure of a pin or roller, mean pressure of a block.

Width, pressure and the shear below the surface of cylinders in contact are Hertz's: Johnson,
Contact Mechanics, 1985, section 4.2(c), with the stress on the axis below. Bodies are half-spaces
there, so the patch must be small against the radius of what presses on the flat.
"""

from collections.abc import Iterator, Mapping
from math import sqrt

import numpy as np

from checks.design.data import Part, Roller
from checks.design.errors import DesignError
from checks.design.materials import Material
from checks.part.derived import Band, Heading, Kind, Series, yield_stress
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.derivation import Given, Step
from checks.result.formulas import Value
from checks.result.verdict import Check
from geometry.mesh import FloatArray, Interface

_WIDEST = 0.5  # half width over the radius: an arc of 60 degrees
FLAT = Kind(
    name="contact",
    quantity="mean pressure at {}",
    demand="mean pressure of a flat block, with its couple",
    limit="yield stress",
    require="static",
    source="[fits](../theory/fits.md)",
)
ROUND = Kind(
    name="contact",
    quantity="Hertz pressure at {}",
    demand="largest pressure of a pin or roller on a line",
    limit="1.67 times the yield stress of the softer one",
    require="static",
    source="Johnson, Contact Mechanics, 1985, 4.2(c); [fits](../theory/fits.md)",
)
KINDS = (FLAT, ROUND)
# Johnson, Contact Mechanics, 1985, 4.2(c) and 6.1(a): the largest shear under a line contact is
# 0.300283 p0, and Tresca's yield begins where it is half the yield stress: p0 = 1.67 Sy.
FIRST_YIELD = 0.5 / 0.300283
# On the axis the shear is p0 (s - s^2 / sqrt(1 + s^2)) at s half widths, whatever Poisson's ratio:
# its greatest is at s^2 = (sqrt 5 - 1) / 2.
_DEEP = sqrt((sqrt(5) - 1) / 2)
_SHEARED = _DEEP - _DEEP**2 / sqrt(1 + _DEEP**2)
_TURNED = 1e-6  # of force times length: a couple that is more than round-off
_JOHNSON = "Johnson, Contact Mechanics, 1985, 4.2(c)"
_SHAPE, _DESIGN = "the part's shape", "the design"


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Pressure of every sliding contact of a part at its worst position; raises DesignError."""
    for interface in loaded.solid.interfaces.values():
        if interface.kind != "slide":
            continue
        roller = loaded.part.contacts.get(interface.name)
        across = Series(
            "N",
            f"force across the contact {interface.name}",
            np.abs(loaded.loads.wrenches[interface.name][:, 1]),
            "N",
            main=True,
        )
        if roller is None:
            yield _flat(loaded, interface, across)
        elif across.values.max() > 0:
            yield _round(loaded, interface, roller, across)


def _round(loaded: LoadedPart, interface: Interface, roller: Roller, across: Series) -> Check:
    """Check a pin or roller on the flat flank; raises DesignError where Hertz does not apply."""
    key = f"parts.{loaded.name}.contacts.{interface.name}.radius"
    most = float(_couple(loaded.loads, interface).max())
    # between positions forces and reach have a spline each: a roller seems to take a couple
    if loaded.solved and most > _TURNED * float(across.values.max()) * 2 * roller.radius:
        raise DesignError(
            loaded.design.file,
            key,
            f"a pin or roller takes no couple, but up to {most / 1e3:.3g} N m act here: the block "
            "turns with this part; leave the radius out, or make the joint a slot",
        )
    own, softer = loaded.part.material, _softer(loaded.part, roller)
    young_2, poisson_2, source = _elasticity(roller)
    found = loaded.worst(
        Heading(
            kind=ROUND,
            of=interface.name,
            place=f"{interface.name}, radius {roller.radius:g} mm on a flat "
            f"{interface.length:g} mm wide",
            basis=f"{FIRST_YIELD:.2f} times the yield stress of {softer.name}: where yield begins "
            "below the surface (Johnson 1985)",
            note=lambda found: (
                f"N = {found['N']:.0f} N, {2 * found['b']:.3g} mm wide; largest shear "
                f"{_SHEARED * found['p']:.3g} MPa at {_DEEP * found['b']:.2g} mm depth; even along "
                "the line, contact fatigue not checked"
            ),
        ),
        [
            across,
            Given("l", "width of the flat", interface.length, "mm", _SHAPE),
            Given("r", "radius of the pin or roller", roller.radius, "mm", _DESIGN),
            Given("E_1", f"Young's modulus of {own.name}", own.youngs_modulus, "MPa", own.source),
            Given("nu_1", "its Poisson's ratio", own.poisson_ratio, "", own.source),
            Given("E_2", "Young's modulus of the roller", young_2, "MPa", source),
            Given("nu_2", "its Poisson's ratio", poisson_2, "", source),
            Step("E_s", "modulus of both", "1/((1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2)", "MPa",
                 _JOHNSON),
            Step("b", "half width of the contact", "sqrt(4*N/l*r/(pi*E_s))", "mm", _JOHNSON),
            Step("p", "largest pressure by Hertz", "sqrt(N/l*E_s/(pi*r))", "MPa", _JOHNSON,
                 main=True),
        ],
        [
            Given("S_y", f"yield stress of {softer.name}, the softer", softer.yield_stress, "MPa",
                  softer.source),
            Given("c", "pressure over yield stress where yield begins below the surface",
                  FIRST_YIELD, "", "Johnson 1985, 6.1(a), Tresca"),
            Step("p_y", "pressure at first yield", "c*S_y", "MPa", main=True),
        ],
        Band(words="a formula has no mesh; the bodies are half-spaces"),
    )  # fmt: skip
    assert found.derivation is not None
    half = found.derivation.number("b")
    if half > _WIDEST * roller.radius:
        raise DesignError(
            loaded.design.file,
            key,
            f"a contact of {half:.3g} mm half width is not small against a radius of "
            f"{roller.radius:.3g} mm (limit {_WIDEST:g}): Hertz's theory does not apply",
        )
    return found


def _flat(loaded: LoadedPart, interface: Interface, across: Series) -> Check:
    """Check a flat block: mean pressure, and what a couple on the block adds at its end."""
    length = 2 * interface.patch

    def note(found: Mapping[str, Value]) -> str:
        turned = found["C"] > _TURNED * found["N"] * length
        couple = f", couple {found['C'] / 1e3:.3g} N m in it" if turned else ""
        return (
            f"N = {found['N']:.0f} N{couple}; a flat block, whose sharp edges press without a "
            f"bound: they are not modelled; state contacts.{interface.name}.radius for a pin or "
            "roller"
        )

    return loaded.worst(
        Heading(
            kind=FLAT,
            of=interface.name,
            place=f"{interface.name}, block of {length:g} x {interface.length:g} mm",
            basis=f"yield stress, guaranteed minimum ({loaded.part.material.source})",
            note=note,
        ),
        [
            across,
            Series("C", "couple on the block about its middle", _couple(loaded.loads, interface),
                   "N mm"),
            Given("l", "length of the block", length, "mm", _SHAPE),
            Given("b", "its width", interface.length, "mm", _SHAPE),
            Step("p", "pressure at the block's end", "N/(l*b) + 6*C/(b*l^2)", "MPa",
                 "docs/theory/fits.md", main=True),
        ],
        [yield_stress(loaded.part)],
        Band(words="a formula has no mesh; the block's sharp edges are not modelled"),
    )  # fmt: skip


def _elasticity(roller: Roller) -> tuple[float, float, str]:
    """Young's modulus, MPa, and Poisson's ratio of a pin or roller, and where they are from."""
    stated = roller.material
    if stated is None:
        return 210e3, 0.3, "assumed: steel"
    return stated.youngs_modulus, stated.poisson_ratio, f"{stated.name}: {stated.source}"


def _softer(part: Part, roller: Roller) -> Material:
    """Whose yield limits the contact: the part's where nothing is stated of the roller."""
    own, other = part.material, roller.material
    return own if other is None or own.yield_stress <= other.yield_stress else other


def _couple(loads: PartLoads, interface: Interface) -> FloatArray:
    """Couple (n,) on a sliding contact about where it touches, N mm."""
    wrench = loads.wrenches[interface.name]
    reach = loads.reaches.get(interface.name, np.zeros(len(wrench)))
    return np.asarray(np.abs(wrench[:, 5] - reach * wrench[:, 1]))
