"""Plates that stand side by side on a pin: whether the part's model has the couple of it.

A pin that is fixed in one lug hands it, beside their force, the couple of all other lugs that press
on the pin beside its middle: the sum of (z_k - z) F_k. In the part's own model that couple comes
from `offsets`; stack and offsets are stated apart and must say the same. The other lugs' pins turn
in them and give no couple.
"""

from collections.abc import Mapping

import numpy as np

import loads
from checks.design.data import Design, Part
from checks.design.stacks import APART
from checks.part.part_loads import is_loaded, loads_on
from checks.result.verdict import Gate
from geometry.parts import Pin


def offset_gates(
    design: Design, part: Part, solved: Mapping[str, loads.CycleLoads | loads.MeasuredLoads]
) -> list[Gate]:
    """Return a gate for every pin of a part: the lever arm, mm, that its model leaves out."""
    if part.body is None:
        return []
    gates = []
    for pin in design.parts.values():
        if not isinstance(pin.geometry, Pin) or part.body not in {lug.body for lug in pin.stack}:
            continue
        interface = next((name for name, at in part.interfaces.items() if at == pin.joint), None)
        if interface is None or not any(is_loaded(pin, cycle) for cycle in solved.values()):
            continue
        offset = part.offsets.get(interface, 0.0)
        arm, couple, wanted = _missing_arm(
            pin, part.body, offset, loads_on(design, pin, solved).wrenches
        )
        cure = (
            f'; state offsets = {{ {interface} = "{wanted:.4g} mm" }}'
            if abs(wanted - offset) > APART
            else "; no offset has it, as the lugs' forces do not keep step"
        )
        gates.append(
            Gate(
                f"{part.name}: lever arm of {pin.name} left out, mm",
                arm,
                APART,
                f"the stack of {pin.name} has lugs beside {part.name}, whose couple its offsets "
                f"do not have: {couple:.3g} N mm{_bending(part, couple)}{cure}"
                if arm > APART
                else "couple of the lugs beside it on the pin less that of offsets, over the force",
            )
        )
    return gates


def _missing_arm(
    pin: Part, body: str, offset: float, wrenches: Mapping[str, np.ndarray]
) -> tuple[float, float, float]:
    """Largest couple that is left out over the largest force, mm; that couple, N mm; an offset.

    The offset, mm, is the one that leaves least by least squares: all of it where the other lugs
    have one height, or where their forces keep step. The arm is 0 where nothing presses.
    """
    assert isinstance(pin.geometry, Pin)
    heights = {seat.name: seat.at if seat.single else 0.0 for seat in pin.geometry.seats}
    others = [name for name in wrenches if name != body]
    forces = np.stack([wrenches[name][:, :2] for name in others])
    largest = float(np.hypot(forces[..., 0], forces[..., 1]).max(initial=0.0))
    if not largest:
        return 0.0, 0.0, offset
    fixed = pin.fixed_to == body
    arms = np.array([heights[name] - heights[body] if fixed else 0.0 for name in others])
    whole = np.einsum("k,knx->nx", arms, forces)
    own = forces.sum(axis=0)
    weight = float((own**2).sum())
    wanted = float((whole * own).sum()) / weight if weight > (1e-9 * largest) ** 2 else offset
    left = whole - offset * own
    couple = float(np.hypot(left[:, 0], left[:, 1]).max())
    return couple / largest, couple, wanted


def _bending(part: Part, couple: float) -> str:
    """What a couple is as nominal stress of bending out of the plane, in words, of a plate."""
    width, thickness = (getattr(part.geometry, name, None) for name in ("width", "thickness"))
    if not (width and thickness):
        return ""
    stress = 6.0 * couple / (width * thickness**2)
    return f", {stress:.3g} MPa of bending in its plate of {width:g} x {thickness:g} mm"
