"""Nominal bending and shear of a pin over its stack, from the forces of its lugs."""

from math import sqrt

import numpy as np

from checks.design.data import Part
from checks.joints.pin_checks import BENDING, SHEAR, TOGETHER
from checks.joints.pin_diagrams import ANGLES, PinDiagram, pin_diagram
from checks.part.derived import load_case, shear_yield, yield_stress
from checks.part.first_maximum import first_largest
from checks.part.part_loads import PartLoads
from checks.result.derivation import BARS, Bars, Column, Derivation, Given, Item, Section, Step, Sum
from checks.result.verdict import Check
from geometry.mesh import FloatArray
from geometry.parts import Pin

_UNITS = (("F_x", "N"), ("F_y", "N"), ("M_x", "N mm"), ("M_y", "N mm"), ("M_z", "N mm"))
_ROWS = (0, 1, 3, 4, 5)  # of a wrench
_FITS = "docs/theory/fits.md"


def pin(part: Part, loads: PartLoads, check: Check) -> Derivation | None:
    """Of a pin's bending, its shear, or both together; None for another quantity."""
    assert isinstance(part.geometry, Pin)
    wrenches = dict(loads.wrenches)
    pushed = pin_diagram(part.geometry, wrenches, spread=False, ends_only=True)
    pressed = pin_diagram(part.geometry, wrenches, spread=True, ends_only=True)
    both, sheared = check.quantity == TOGETHER, check.quantity == SHEAR
    if both:
        stress, even = pushed.equivalent_peaks, float(pressed.equivalent_peaks.max())
    elif sheared:
        stress, even = pushed.shear_stress, pressed.most_sheared
    elif check.quantity == BENDING:
        stress, even = pushed.bending_stress, pressed.most_bent
    else:
        return None
    position, section = first_largest(stress)
    weights = _weights(part.geometry, list(wrenches), section)
    acting = {name: wrench[position] for name, wrench in wrenches.items()}
    items: list[Item] = [
        Given("d", f"diameter of the pin at z = {float(pushed.places[section]):.4g} mm",
              float(pushed.diameter[section]), "mm", "the part's shape")
    ]  # fmt: skip
    twisted = abs(float(pushed.torque[position, section])) > 0
    if both or sheared:
        items += _sheared(acting, weights, twisted)
    if not sheared:
        items += _bent(acting, weights)
    if both:
        items += _together(pushed, position, section)
    value = "sigma" if both else "tau" if sheared else "sigma_b"
    limit = [yield_stress(part)] + ([shear_yield()] if value == "tau" else [])
    return Derivation(
        cases=(load_case(part, loads, position),),
        sections=(
            Section("Demand", tuple(items)),
            Section("Limit", tuple(limit)),
            Section(
                BARS,
                (
                    Given("v", "the value where every lug presses evenly over its width", even,
                          "MPa", _FITS),
                    Step("b_up", "model band above", f"max(0, v - {value})", "MPa"),
                    Step("b_lo", "model band below", f"max(0, {value} - v)", "MPa"),
                ),
            ),
        ),
        value=value,
        limit="tau_y" if value == "tau" else "S_y",
        bars=Bars(above="b_up", below="b_lo", words="lugs press between their middles and evenly"),
    )  # fmt: skip


def _weights(shape: Pin, names: list[str], section: int) -> FloatArray:
    """Shear x, y, moment x, y and torque (5, seats, 5) of a section per unit of each component."""
    count = len(_ROWS) * len(names)
    units = {}
    for k, name in enumerate(names):
        units[name] = np.zeros((count, 6))
        units[name][np.arange(len(_ROWS)) + len(_ROWS) * k, list(_ROWS)] = 1.0
    diagram = pin_diagram(shape, units, spread=False, ends_only=True)
    found = [
        *diagram.shear[:, section].T,
        *diagram.moment[:, section].T,
        diagram.torque[:, section],
    ]
    return np.stack(found).reshape(len(found), len(names), len(_ROWS))


def _sum(
    symbol: str, meaning: str, unit: str, acting: dict[str, FloatArray], weights: FloatArray
) -> Sum:
    """Sum over the lugs beyond a section: each component times its lever or share."""
    rows = [
        (f"{name} {_UNITS[k][0]} [{_UNITS[k][1]}]", float(wrench[_ROWS[k]]), float(own[k]))
        for (name, wrench), own in zip(acting.items(), weights, strict=True)
        for k in range(len(_ROWS))
        if own[k] and wrench[_ROWS[k]]
    ]
    names = tuple(name for name, _, _ in rows)
    return Sum(
        symbol,
        meaning,
        "Q*w",
        names,
        (
            Column("Q", "what acts on the lug", "", tuple(size for _, size, _ in rows)),
            Column("w", "its lever or share beyond the section", "", tuple(w for *_, w in rows)),
        ),
        unit,
        "every lug at its mid-plane",
    )


def _sheared(acting: dict[str, FloatArray], weights: FloatArray, twisted: bool) -> list[Item]:
    items: list[Item] = [
        _sum("V_x", "shear force along x", "N", acting, weights[0]),
        _sum("V_y", "shear force along y", "N", acting, weights[1]),
        Step("V", "shear force", "sqrt(V_x^2 + V_y^2)", "N", main=True),
    ]
    formula = "16*V/(3*pi*d^2)"
    if twisted:
        items.append(_sum("T", "torque by friction", "N mm", acting, weights[4]))
        formula += " + 16*abs(T)/(pi*d^3)"
    said = "largest shear stress: 4/3 of the mean" + (", and of the twist" if twisted else "")
    return [*items, Step("tau", said, formula, "MPa", "Jourawski", main=True)]


def _bent(acting: dict[str, FloatArray], weights: FloatArray) -> list[Item]:
    return [
        _sum("M_x", "moment in the plane of x and z", "N mm", acting, weights[2]),
        _sum("M_y", "moment in the plane of y and z", "N mm", acting, weights[3]),
        Step("M", "bending moment", "sqrt(M_x^2 + M_y^2)", "N mm", main=True),
        Step("sigma_b", "nominal bending stress of a round bar", "32*M/(pi*d^3)", "MPa",
             "beam theory", main=True),
    ]  # fmt: skip


def _together(pushed: PinDiagram, position: int, section: int) -> list[Item]:
    """Bending and shear at the place of the rim where they are worst together."""
    bending = float(pushed.bending_stress[position, section])
    twist = float(pushed.twist_stress[position, section])
    shear = float(pushed.shear_stress[position, section]) - twist
    moment, force = pushed.moment[position, section], pushed.shear[position, section]
    apart = float(np.arctan2(moment[1], moment[0]) - np.arctan2(force[1], force[0]))
    found = [
        sqrt((bending * np.cos(a)) ** 2 + 3 * (shear * np.sin(a + apart) ** 2 + twist) ** 2)
        for a in ANGLES
    ]
    worst = int(np.argmax(found))
    if sqrt(3) * (shear + twist) >= found[worst]:
        return [Step("sigma", "von Mises in the middle, where nothing is bent", "sqrt(3)*tau",
                     "MPa", main=True)]  # fmt: skip
    return [
        Given("tau_T", "part of the shear stress that is twist's", twist, "MPa"),
        Given("a", "angle of the rim from where bending is largest", float(ANGLES[worst]), "rad",
              "the worst of every 5°"),
        Given("b", "angle from the shear force to the moment", apart, "rad"),
        Step("sigma", "von Mises stress there",
             "sqrt((sigma_b*cos(a))^2 + 3*((tau - tau_T)*sin(a + b)^2 + tau_T)^2)", "MPa",
             "Jourawski; von Mises", main=True),
    ]  # fmt: skip
