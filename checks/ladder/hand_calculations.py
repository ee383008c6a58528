"""Numbers a designer can do by hand, beside what the model says."""

from math import pi

import numpy as np

from checks.columns.stability import axial_compression
from checks.design.data import Part
from checks.joints.pin_diagrams import pin_diagram
from checks.ladder.hand_bodies import leaf_hand_checks, lever_hand_checks, link_hand_checks
from checks.part.first_maximum import first_largest
from checks.part.part_loads import PartLoads
from checks.result.verdict import HandCheck
from checks.stress.pins_in_bores import MIDDLE
from checks.stress.solid_mesh_level import Level
from fem.contact.persson import persson_half_arc, persson_pressure
from geometry.mesh import FloatArray
from geometry.parts import (
    LeafPack,
    Pin,
    PlateLink,
    PrismaticTube,
    SlottedLever,
    ToggleBar,
    TubeRod,
)


def hand_checks(part: Part, loads: PartLoads, level: Level) -> list[HandCheck]:
    """Hand estimates for the shapes that have them."""
    shape = part.geometry
    if isinstance(shape, Pin):
        one_sided = any(seat.single for seat in shape.seats)
        return [(_one_sided_pin if one_sided else _pin_bending)(shape, loads, level)]
    if isinstance(shape, LeafPack):
        return leaf_hand_checks(shape, loads, level)
    if isinstance(shape, PlateLink | TubeRod):
        return link_hand_checks(shape, loads, level)
    if isinstance(shape, SlottedLever):
        return lever_hand_checks(shape, loads, level)
    if not isinstance(shape, ToggleBar | PrismaticTube):
        return []
    force = axial_compression(part, loads)
    (worst,) = first_largest(np.abs(force))
    stress = level.history.at(worst)
    checks = [_axial(shape, float(force[worst]), level, stress)]
    if isinstance(shape, ToggleBar):
        checks += [
            _cheeks(shape, float(force[worst]), level, stress),
            _bearing(shape, loads, worst, level, stress),
        ]
    return checks


def _axial(
    shape: ToggleBar | PrismaticTube, force: float, level: Level, stress: FloatArray
) -> HandCheck:
    area = shape.sections[0].area
    near = np.abs(level.history.points[:, 0] - shape.length / 2) < 2 * shape.wall
    return HandCheck(
        "axial stress in the tube at mid-length",
        force / area,
        float(-stress[near, 0].mean()),
        "MPa",
        f"F/A = {force:.0f} N / {area:.1f} mm2",
    )


def _cheeks(shape: ToggleBar, force: float, level: Level, stress: FloatArray) -> HandCheck:
    """Gross section of the two cheeks, just behind the pin, where they carry the load alone.

    The side walls take their share further on, so the model's mean over the cheeks' height, one
    wall thickness behind the bore, lies somewhat below.
    """
    area = 2 * shape.width * shape.wall
    pressure = 4 * force / (pi * shape.hole * 2 * shape.wall)
    points = level.history.points
    half = shape.width / 2 - shape.wall
    behind = points[:, 0] - shape.hole / 2
    near = (behind > 0.5 * shape.wall) & (behind < 1.5 * shape.wall)
    near &= np.abs(points[:, 2]) > half - 1e-6 * shape.width
    strips = np.digitize(points[near, 1], np.linspace(-shape.width / 2, shape.width / 2, 9)[1:-1])
    means = [stress[near, 0][strips == strip].mean() for strip in np.unique(strips)]
    return HandCheck(
        "axial stress in the cheeks, gross section; the model's mean behind the pin",
        force / area,
        float(-np.mean(means)),
        "MPa",
        f"F/A = {force:.0f} N / (2 x {shape.width:g} x {shape.wall:g} mm2); "
        f"pressure under the pin {pressure:.0f} MPa",
    )


def _bearing(
    shape: ToggleBar, loads: PartLoads, position: int, level: Level, stress: FloatArray
) -> HandCheck:
    wrench = loads.wrenches["knee"][position]
    size = float(np.hypot(wrench[0], wrench[1]))
    direction = wrench[:2] / size if size else np.array([1.0, 0.0])
    radius = shape.hole / 2
    points = level.history.points
    on_bore = np.abs(np.hypot(points[:, 0], points[:, 1]) - radius) < 1e-3 * radius
    under = on_bore & (points[:, :2] @ direction > 0.995 * radius)
    radial = points[under, :2] / radius
    pressed = (
        stress[under, 0] * radial[:, 0] ** 2
        + stress[under, 1] * radial[:, 1] ** 2
        + 2 * stress[under, 3] * radial[:, 0] * radial[:, 1]
    )
    by_hand = 4 * size / (pi * shape.hole * 2 * shape.wall)
    formula = f"4 F/(pi d t) = 4 x {size:.0f} N / (pi x {shape.hole:g} x {2 * shape.wall:g} mm2)"
    if "knee" in level.solved_bores and size:
        assert level.contact is not None
        fit, material = level.contact.pins.fits["knee"], level.solutions.material
        softness = sum((1 - one.poisson_ratio**2) / one.youngs_modulus for one in (fit, material))
        parameter = fit.clearance(MIDDLE) / 2 / softness * 2 * shape.wall / size
        factor = persson_pressure(persson_half_arc(parameter))
        by_hand = factor * size / (radius * 2 * shape.wall)
        said = f"contact in a wide plate at E* dR t/F = {parameter:.3g} (Persson)"
        formula = f"{factor:.3g} F/(R t), {said}"
    return HandCheck(
        "largest pressure of the pin in the knee's bore",
        by_hand,
        float(-pressed.mean()),
        "MPa",
        formula,
    )


def _pin_bending(shape: Pin, loads: PartLoads, level: Level) -> HandCheck:
    """Bending at the mid-plane: every lug's force at its middle, a central lug's spread evenly."""
    n = len(loads.labels)
    moment = np.zeros((n, 2))
    diameter = shape.diameter
    for seat in shape.seats:
        force = loads.wrenches[seat.name][:, :2]
        arm = seat.at if seat.at else seat.width / 4
        moment += force / 2 * arm
        if not seat.at:
            diameter = seat.diameter or shape.diameter
    size = np.hypot(moment[:, 0], moment[:, 1])
    (worst,) = first_largest(size)
    stress = level.history.at(worst)
    near = np.abs(level.history.points[:, 2]) < 0.06 * shape.diameter
    return HandCheck(
        "bending stress at the pin's mid-plane",
        float(32 * size[worst] / (pi * diameter**3)),
        float(stress[near, 2].max()) if near.any() else 0.0,
        "MPa",
        f"32 M/(pi d^3), M = {size[worst] / 1e3:.1f} N m, d = {diameter:g} mm",
    )


def _one_sided_pin(shape: Pin, loads: PartLoads, level: Level) -> HandCheck:
    """Bending where it is largest, every lug pressing evenly over its width.

    That is inside the lug that holds the pin, under pressures as large as the stress sought: of the
    model it is the axial strain times E, which Hooke's law frees of them.
    """
    diagram = pin_diagram(shape, dict(loads.wrenches), spread=True)
    bending = diagram.bending_stress
    worst, section = first_largest(bending)
    place = float(diagram.places[section])
    near = np.abs(level.history.points[:, 2] - place) < 0.06 * shape.diameter
    stress = level.history.at(worst)[near]
    ratio = level.solutions.material.poisson_ratio
    fibres = np.abs(stress[:, 2] - ratio * (stress[:, 0] + stress[:, 1]))
    size = float(np.hypot(*diagram.moment[worst, section]))
    return HandCheck(
        f"bending stress of the pin at z = {round(place, 2) + 0.0:g} mm",
        float(bending[worst, section]),
        float(fibres.max(initial=0.0)),
        "MPa",
        f"32 M/(pi d^3), M = {size / 1e3:.3g} N m, d = {diagram.diameter[section]:g} mm, lugs "
        "pressing evenly over their widths; of the model E times the strain along the pin",
    )
