"""Nominal bending, shear and twist of a pin over its stack, against yield.

The value is for lugs that press at their mid-planes; the model band reaches to lugs that press
evenly over their widths (`checks.joints.pin_diagrams`).
"""

import numpy as np

from checks.joints.pin_diagrams import PinDiagram as PinDiagram
from checks.joints.pin_diagrams import pin_diagram as pin_diagram
from checks.part.first_maximum import first_largest
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from geometry.mesh import FloatArray
from geometry.parts import Pin

# What the checks are called; their derivations know them by it.
BENDING = "nominal bending stress 32 M/(pi d^3)"
SHEAR = "nominal shear stress 4/3 of 4 V/(pi d^2)"
TOGETHER = "bending with shear, von Mises"
_COUNTS = 1.01  # times bending or shear alone, from which their sum is a check of its own
_ROUND_OFF = 1e-12  # of a stress


def pin_checks(loaded: LoadedPart) -> list[Check]:
    """Nominal bending and shear of a pin over its stack; their sum where it is more than either."""
    part, loads = loaded.part, loaded.loads
    if not isinstance(part.geometry, Pin):
        return []
    wrenches = dict(loads.wrenches)
    pushed = pin_diagram(part.geometry, wrenches, spread=False, ends_only=True)
    pressed = pin_diagram(part.geometry, wrenches, spread=True, ends_only=True)
    pressures = _pressures(part.geometry, loads)
    bending = _check(
        loaded,
        pushed.bending_stress,
        pressed.most_bent,
        pushed,
        "pin bending",
        BENDING,
        pressures,
    )
    shear = _check(
        loaded,
        pushed.shear_stress,
        pressed.most_sheared,
        pushed,
        "pin shear",
        SHEAR,
        "",
    )
    both = pushed.equivalent_peaks
    alone = max(bending.value, np.sqrt(3) * shear.value)
    if both.max() <= _COUNTS * alone:
        return [bending, shear]
    even = float(pressed.equivalent_peaks.max())
    more = _check(loaded, both, even, pushed, "pin bending", TOGETHER, "")
    return [bending, shear, more]


def _check(
    loaded: LoadedPart,
    stress: FloatArray,
    even: float,
    diagram: PinDiagram,
    kind: str,
    quantity: str,
    more: str,
) -> Check:
    """Check the worst section; the model band reaches to what lugs with even pressure give."""
    part, loads = loaded.part, loaded.loads
    position, section = first_largest(stress)
    value = float(stress[position, section])
    if abs(even - value) <= _ROUND_OFF * value:
        even = value  # no band
    diameter = float(diagram.diameter[section])
    if kind == "pin shear":
        limit, rule = part.material.yield_stress / np.sqrt(3), "yield stress over sqrt 3"
        size = float(np.hypot(*diagram.shear[position, section]))
        acts = f"V = {size:.0f} N"
        torque = abs(float(diagram.torque[position, section]))
        if torque:
            acts += f", T = {torque / 1e3:.3g} N m by friction: 16 T/(pi d^3) more"
    else:
        limit, rule = part.material.yield_stress, "yield stress"
        size = float(np.hypot(*diagram.moment[position, section]))
        acts = f"M = {size / 1e3:.1f} N m"
    note = (
        f"{acts}, d = {diameter:g} mm; every lug at its mid-plane; pressing evenly over their "
        f"widths: {even:.4g} MPa"
    )
    return Check(
        part=part.name,
        kind=kind,
        quantity=quantity,
        value=value,
        unit="MPa",
        numerical=0.0,
        model=max(0.0, even - value),
        model_below=max(0.0, value - even),
        limit=float(limit),
        required=loaded.required.static,
        cycle=loads.cycle_names[position],
        position=loads.labels[position],
        place=f"z = {round(float(diagram.places[section]), 2) + 0.0:g} mm",
        method="formula",
        basis=f"{rule}, guaranteed minimum ({part.material.source}); nominal, without steps' peaks",
        note="; ".join(text for text in (note, more) if text),
    )


def _pressures(shape: Pin, loads: PartLoads) -> str:
    """The largest mean pressure F/(d w) in each seat, in words."""
    told = []
    for seat in shape.seats:
        area = (seat.diameter or shape.diameter) * seat.width * len(seat.places)
        told.append(f"{seat.name} {loads.resultant(seat.name).max() / area:.3g}")
    return "mean pressure F/(d w), MPa: " + ", ".join(told)
