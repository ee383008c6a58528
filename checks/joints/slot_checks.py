"""Sliding contacts by formula: Hertz pressure of a pin or roller, mean pressure of a block."""

from collections.abc import Mapping
from math import inf
from typing import NamedTuple

import numpy as np

from checks.design.data import Part, Roller
from checks.design.errors import DesignError
from checks.design.materials import Material
from checks.handbook.hertz import HertzBody, HertzError, line_contact
from checks.part.first_maximum import first_largest
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from geometry.mesh import FloatArray, Interface

# Johnson, Contact Mechanics, 1985, 4.2(c) and 6.1(a): the largest shear under a line contact is
# 0.300283 p0, and Tresca's yield begins where it is half the yield stress: p0 = 1.67 Sy.
FIRST_YIELD = 0.5 / 0.300283
_TURNED = 1e-6  # of force times length: a couple that is more than round-off


class RollerMaterial(NamedTuple):
    """Elasticity of a pin or roller, MPa, and where it is from."""

    youngs_modulus: float
    poisson_ratio: float
    source: str


def roller_material(roller: Roller) -> RollerMaterial:
    """The stated material of a pin or roller; of one without, steel is assumed."""
    stated = roller.material
    if stated is None:
        return RollerMaterial(210e3, 0.3, "assumed: steel")
    return RollerMaterial(
        stated.youngs_modulus, stated.poisson_ratio, f"{stated.name}: {stated.source}"
    )


def softer_of(part: Part, roller: Roller) -> Material:
    """Whose yield limits the contact: the part's where nothing is stated of the roller."""
    own, other = part.material, roller.material
    return own if other is None or own.yield_stress <= other.yield_stress else other


def round_quantity(name: str) -> str:
    """Quantity of the check of a pin or roller on an interface."""
    return f"Hertz pressure at {name}"


def flat_quantity(name: str) -> str:
    """Quantity of the check of a flat block on an interface."""
    return f"mean pressure at {name}"


def slot_checks(
    loaded: LoadedPart,
    interfaces: Mapping[str, Interface],
    *,
    solved: bool = True,
) -> list[Check]:
    """Pressure of every sliding contact of a part at its worst position; raises DesignError.

    solved  whether the loads are the solved positions': between them forces and reach have a spline
            each, so that a roller seems to take a couple, which is then none to refuse
    """
    part = loaded.part
    checks = []
    for name, interface in interfaces.items():
        if interface.kind != "slide":
            continue
        roller = part.contacts.get(name)
        if roller is None:
            checks.append(_flat(loaded, interface))
            continue
        try:
            check = _round(loaded, interface, roller, solved=solved)
        except HertzError as error:
            key = f"parts.{part.name}.contacts.{name}.radius"
            raise DesignError(loaded.design.file, key, str(error)) from error
        if check is not None:
            checks.append(check)
    return checks


def _round(
    loaded: LoadedPart,
    interface: Interface,
    roller: Roller,
    *,
    solved: bool,
) -> Check | None:
    """Check a pin or roller on the flat flank; None where nothing ever presses."""
    part, loads = loaded.part, loaded.loads
    force = force_across(loads, interface)
    (worst,) = first_largest(force)
    if not force[worst] > 0:
        return None
    most = float(couple_on(loads, interface).max())
    if solved and most > _TURNED * force[worst] * 2 * roller.radius:
        key = f"parts.{part.name}.contacts.{interface.name}.radius"
        raise DesignError(
            loaded.design.file,
            key,
            f"a pin or roller takes no couple, but up to {most / 1e3:.3g} N m act here: the block "
            "turns with this part; leave the radius out, or make the joint a slot",
        )
    own, other = part.material, roller_material(roller)
    found = line_contact(
        float(force[worst]) / interface.length,
        HertzBody(inf, own.youngs_modulus, own.poisson_ratio),
        HertzBody(roller.radius, other.youngs_modulus, other.poisson_ratio),
    )
    softer = softer_of(part, roller)
    return Check(
        part=part.name,
        kind="contact",
        quantity=round_quantity(interface.name),
        value=found.peak_pressure,
        unit="MPa",
        numerical=0.0,
        model=0.0,
        limit=FIRST_YIELD * softer.yield_stress,
        required=loaded.required.static,
        cycle=loads.cycle_names[worst],
        position=loads.labels[worst],
        place=f"{interface.name}, radius {roller.radius:g} mm on a flat {interface.length:g} mm "
        "wide",
        method="formula",
        basis=f"{FIRST_YIELD:.2f} times the yield stress of {softer.name}: where yield begins "
        "below the surface (Johnson 1985)",
        note=f"N = {force[worst]:.0f} N, {2 * found.half_width:.3g} mm wide; largest shear "
        f"{found.shear:.3g} MPa at {found.shear_depth:.2g} mm depth; even along the line, contact "
        "fatigue not checked",
    )


def _flat(loaded: LoadedPart, interface: Interface) -> Check:
    """Check a flat block: mean pressure, and what a couple on the block adds at its end."""
    part, loads = loaded.part, loaded.loads
    force, couple = force_across(loads, interface), couple_on(loads, interface)
    length, width = 2 * interface.patch, interface.length
    pressure = flat_pressure(loads, interface)
    (worst,) = first_largest(pressure)
    turned = couple[worst] > _TURNED * force[worst] * length
    return Check(
        part=part.name,
        kind="contact",
        quantity=flat_quantity(interface.name),
        value=float(pressure[worst]),
        unit="MPa",
        numerical=0.0,
        model=0.0,
        limit=part.material.yield_stress,
        required=loaded.required.static,
        cycle=loads.cycle_names[worst],
        position=loads.labels[worst],
        place=f"{interface.name}, block of {length:g} x {width:g} mm",
        method="formula",
        basis=f"yield stress, guaranteed minimum ({part.material.source})",
        note=f"N = {force[worst]:.0f} N"
        + (f", couple {couple[worst] / 1e3:.3g} N m in it" if turned else "")
        + "; a flat block, whose sharp edges press without a bound: they are not modelled; "
        f"state contacts.{interface.name}.radius for a pin or roller",
    )


def flat_pressure(loads: PartLoads, interface: Interface) -> FloatArray:
    """Pressure (n,) at the end of a flat block, MPa: the mean, and what the couple adds."""
    force, couple = force_across(loads, interface), couple_on(loads, interface)
    length, width = 2 * interface.patch, interface.length
    return force / (length * width) + 6 * couple / (width * length**2)


def force_across(loads: PartLoads, interface: Interface) -> FloatArray:
    """Force (n,) across a sliding contact, N."""
    return np.asarray(np.abs(loads.wrenches[interface.name][:, 1]))


def couple_on(loads: PartLoads, interface: Interface) -> FloatArray:
    """Couple (n,) on a sliding contact about where it touches, N mm."""
    wrench = loads.wrenches[interface.name]
    reach = loads.reaches.get(interface.name, np.zeros(len(wrench)))
    return np.asarray(np.abs(wrench[:, 5] - reach * wrench[:, 1]))
