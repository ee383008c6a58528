"""Mean pressure in the bushes of a pin against what the bush material may take."""

import numpy as np

from ballesta.design_data import Design, Part
from ballesta.part_loads import PartLoads
from geometry.parts import Pin
from reports.verdict import Check

# A pair of lugs shares the load evenly only if nothing is out of square; ASSUMED band.
_SHARE_BAND = 0.05


def bush_checks(design: Design, part: Part, loads: PartLoads) -> list[Check]:
    """One check per bush (or pair of bushes) in a pin's stack: p = F / (d L), projected area."""
    if not isinstance(part.geometry, Pin):
        return []
    checks = []
    for entry in part.stack:
        if entry.bush is None:
            continue
        name = entry.body or entry.force
        assert name is not None
        lugs = 2 if entry.at else 1
        diameter = entry.diameter or part.geometry.diameter
        force = loads.resultant(name) / lugs
        worst = int(np.argmax(force))
        pressure = float(force[worst]) / (diameter * entry.bush.length)
        checks.append(
            Check(
                part=part.name,
                kind="bush",
                quantity=f"bush of {name}",
                value=pressure,
                unit="MPa",
                numerical=0.0,
                model=_SHARE_BAND * pressure if lugs == 2 else 0.0,
                limit=entry.bush.allowable,
                required=design.require.bush,
                cycle=loads.cycle_names[worst],
                position=loads.labels[worst],
                place=f"mean pressure on {diameter:g} x {entry.bush.length:g} mm",
                method="formula",
                basis="allowable pressure as stated in the design",
                model_below=0.0,
                note=f"p = {force[worst]:.0f} N / ({diameter:g} x {entry.bush.length:g} mm2)"
                + ("; 50 to 52.5 % of the load in one bush of the pair" if lugs == 2 else ""),
            )
        )
    return checks
