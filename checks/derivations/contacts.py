"""Pins in their holes, bushes, and contacts that slide: pressures, and pins that tear out."""

from collections.abc import Mapping

import numpy as np

import loads
from checks.design.data import Part, Roller
from checks.design.model import StackEntry
from checks.joints.bush_sliding import bush_count, bush_diameter, sliding_quantity
from checks.joints.bushes import SHARE_BAND
from checks.joints.slot_checks import (
    FIRST_YIELD,
    couple_on,
    flat_pressure,
    flat_quantity,
    force_across,
    roller_material,
    round_quantity,
    softer_of,
)
from checks.part.derived import load_case, yield_stress
from checks.part.first_maximum import first_largest
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.derivation import BARS, Bars, Derivation, Given, Item, Section, Step
from checks.result.verdict import Check
from geometry.mesh import Interface

Solved = Mapping[str, loads.CycleLoads | loads.MeasuredLoads]
_EXACT = Bars(words="a formula has no mesh; its limit is one of mean stress")
_SHAPE, _LOADS, _DESIGN = "the part's shape", "the loads", "the design"
_FITS = "docs/theory/fits.md"


def bush(loaded: LoadedPart, check: Check) -> Derivation | None:
    """Of the pressure of a bush, or its pressure times speed; None for one that is not found."""
    part, part_loads = loaded.part, loaded.loads
    entries = [one for one in part.stack if one.bush is not None]
    slid = next((one for one in entries if check.quantity == sliding_quantity(one)), None)
    entry = slid
    if entry is None or entry.bush is None:
        return None
    speed = entry is slid
    turn = 0.0
    if speed:
        position, turn = _fastest(loaded, entry, check.cycle)
    else:
        (position,) = first_largest(part_loads.resultant(entry.name))
    name, count = entry.name, bush_count(entry)
    items: list[Item] = [
        Given("F", f"force of {name} on the pin", float(part_loads.resultant(name)[position]), "N",
              _LOADS, main=True),
        Given("m", "bushes that share it", float(count), "", _DESIGN),
        Given("d", "diameter of the pin", bush_diameter(part, entry), "mm", _DESIGN),
        Given("l", "length of a bush", entry.bush.length, "mm", _DESIGN),
        Step("p", "mean pressure on the projected area", "F/(m*d*l)", "MPa", _FITS, main=True),
    ]  # fmt: skip
    limit = Given("p_a", "allowable pressure", entry.bush.allowable, "MPa", _DESIGN, main=True)
    value = "p"
    if speed:
        assert entry.bush.pv is not None
        items += [
            Given("omega", "angular speed against the pin", turn, "rad/s", _LOADS),
            Step("v", "sliding speed", "omega*d/2000", "m/s"),
            Step("q", "pressure times speed", "p*v", "MPa m/s", main=True),
        ]
        limit = Given("q_a", "allowable p v", entry.bush.pv / 1e3, "MPa m/s", _DESIGN, main=True)
        value = "q"
    bars = Bars(words="a formula has no mesh")
    band: list[Item] = []
    if count == 2:
        bars = Bars(above="b_up", words="a pair shares the load evenly only if nothing is askew")
        band = [
            Given("s", "share that one of a pair may take beyond its half", SHARE_BAND, "",
                  "assumed"),
            Step("b_up", "model band above", f"s*{value}", check.unit),
        ]  # fmt: skip
    return Derivation(
        cases=(load_case(part, part_loads, position),),
        sections=(
            Section("Demand", tuple(items)),
            Section("Limit", (limit,)),
            Section(BARS, tuple(band)),
        ),
        value=value,
        limit=limit.symbol,
        bars=bars,
    )


def _fastest(loaded: LoadedPart, entry: StackEntry, name: str) -> tuple[int, float]:
    """Position of the largest p v in a computed cycle, as labels may repeat; the speed, rad/s."""
    part_loads, cycle = loaded.loads, loaded.runs[name]
    assert isinstance(cycle, loads.CycleLoads)
    columns = part_loads.cycles[name]
    speed = np.abs(part_loads.spins[entry.name][columns])
    (at,) = first_largest(part_loads.resultant(entry.name)[columns] * speed)
    return int(columns.start) + at, float(speed[at])


def contact(
    part: Part, part_loads: PartLoads, interfaces: Mapping[str, Interface], check: Check
) -> Derivation | None:
    """Of the pressure of a contact that slides; None for one that is not found."""
    for name, interface in interfaces.items():
        roller = part.contacts.get(name)
        if interface.kind != "slide":
            continue
        if roller is None and check.quantity == flat_quantity(name):
            return _flat(part, part_loads, interface)
        if roller is not None and check.quantity == round_quantity(name):
            return _round(part, part_loads, interface, roller)
    return None


def _round(part: Part, part_loads: PartLoads, interface: Interface, roller: Roller) -> Derivation:
    (position,) = first_largest(force_across(part_loads, interface))
    own, other, softer = part.material, roller_material(roller), softer_of(part, roller)
    johnson = "Johnson, Contact Mechanics, 1985, 4.2(c)"
    return Derivation(
        cases=(load_case(part, part_loads, position),),
        sections=(
            Section(
                "Demand",
                (
                    _across(part_loads, interface, position),
                    Given("l", "width of the flat", interface.length, "mm", _SHAPE),
                    Given("r", "radius of the pin or roller", roller.radius, "mm", _DESIGN),
                    Given("E_1", f"Young's modulus of {own.name}", own.youngs_modulus, "MPa",
                          own.source),
                    Given("nu_1", "its Poisson's ratio", own.poisson_ratio, "", own.source),
                    Given("E_2", "Young's modulus of the roller", other.youngs_modulus, "MPa",
                          other.source),
                    Given("nu_2", "its Poisson's ratio", other.poisson_ratio, "", other.source),
                    Step("E_s", "modulus of both",
                         "1/((1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2)", "MPa", johnson),
                    Step("b", "half width of the contact", "sqrt(4*N/l*r/(pi*E_s))", "mm", johnson),
                    Step("p", "largest pressure by Hertz", "2*N/l/(pi*b)", "MPa", johnson,
                         main=True),
                ),
            ),
            Section(
                "Limit",
                (
                    Given("S_y", f"yield stress of {softer.name}, the softer", softer.yield_stress,
                          "MPa", softer.source),
                    Given("c", "pressure over yield stress where yield begins below the surface",
                          FIRST_YIELD, "", "Johnson 1985, 6.1(a), Tresca"),
                    Step("p_y", "pressure at first yield", "c*S_y", "MPa", main=True),
                ),
            ),
        ),
        value="p",
        limit="p_y",
        bars=Bars(words="a formula has no mesh; the bodies are half-spaces"),
    )  # fmt: skip


def _across(part_loads: PartLoads, interface: Interface, position: int) -> Given:
    """The force across a contact at a position."""
    force = float(force_across(part_loads, interface)[position])
    said = f"force across the contact {interface.name}"
    return Given("N", said, force, "N", _LOADS, main=True)


def _flat(part: Part, part_loads: PartLoads, interface: Interface) -> Derivation:
    (position,) = first_largest(flat_pressure(part_loads, interface))
    couple = float(couple_on(part_loads, interface)[position])
    return Derivation(
        cases=(load_case(part, part_loads, position),),
        sections=(
            Section(
                "Demand",
                (
                    _across(part_loads, interface, position),
                    Given("C", "couple on the block about its middle", couple, "N mm", _LOADS),
                    Given("l", "length of the block", 2 * interface.patch, "mm", _SHAPE),
                    Given("b", "its width", interface.length, "mm", _SHAPE),
                    Step("p", "pressure at the block's end", "N/(l*b) + 6*C/(b*l^2)", "MPa",
                         _FITS, main=True),
                ),
            ),
            Section("Limit", (yield_stress(part),)),
        ),
        value="p",
        limit="S_y",
        bars=Bars(words="a formula has no mesh; the block's sharp edges are not modelled"),
    )  # fmt: skip
