"""Numbers a designer can do by hand for links, levers and leaf packs, beside the model's."""

import numpy as np

from checks.handbook.lugs import lug_factor
from checks.part.first_maximum import first_largest
from checks.part.part_loads import PartLoads
from checks.result.verdict import HandCheck
from checks.stress.solid_mesh_level import Level
from fem.recovery import von_mises
from fem.unit_loads import ACCELERATIONS
from geometry.mesh import FloatArray
from geometry.parts import LeafPack, PlateLink, SlottedLever, TubeRod

Place = float | FloatArray

_SMALL = 0.05  # share of the other nominal stress below which one is not worth a line
_OWN = "its own weight and inertia as those of an even bar"
_STRAIGHT = 0.1  # of a lug's pull: what may act on it besides, its couples over its width


def link_hand_checks(shape: PlateLink | TubeRod, loads: PartLoads, level: Level) -> list[HandCheck]:
    """Axial and bending stress of a link at mid-length; the peak beside a hole that is pulled."""
    first, second = (loads.wrenches[name] for name in shape.interfaces)
    middle, section = shape.length / 2, shape.sections[0]
    left = _own(level, section.area, 0.0, middle, middle)
    right = _own(level, section.area, middle, shape.length, middle)
    axial = (second[:, 0] + right[0] - first[:, 0] - left[0]) / 2
    moment = (second[:, 5] + middle * second[:, 1] + right[1]) / 2
    moment -= (first[:, 5] - middle * first[:, 1] + left[1]) / 2
    height = shape.width if isinstance(shape, PlateLink) else shape.tube_diameter
    modulus = section.inertia_in_plane / (height / 2)
    by_axial, by_moment = np.abs(axial) / section.area, np.abs(moment) / modulus
    size = height / 4
    checks = []
    if by_axial.max() > _SMALL * by_moment.max():
        (worst,) = first_largest(by_axial)
        mean, _ = _beam_stress(level, worst, middle, size)
        checks.append(
            HandCheck(
                "axial stress at mid-length",
                float(axial[worst] / section.area),
                mean,
                "MPa",
                f"F/A = {axial[worst]:.0f} N / {section.area:.1f} mm2, {_OWN}",
            )
        )
    if by_moment.max() > _SMALL * by_axial.max():
        (worst,) = first_largest(by_moment)
        _, slope = _beam_stress(level, worst, middle, size)
        checks.append(
            HandCheck(
                "bending stress at mid-length",
                float(by_moment[worst]),
                abs(slope) * height / 2,
                "MPa",
                f"M h/(2 I), M = {abs(moment[worst]) / 1e3:.3g} N m, {_OWN}",
            )
        )
    if isinstance(shape, PlateLink):
        for name in shape.interfaces:
            checks += _pulled_lug(name, shape.width, shape.thickness, loads, level)
    return checks


def lever_hand_checks(shape: SlottedLever, loads: PartLoads, level: Level) -> list[HandCheck]:
    """Mean stress in the strips beside the slot, and the peak beside the pivot's hole if it pulls.

    Between the block and the slot's far end the two strips bend together, as the section with the
    slot in it, and each by itself by its share of the shear, which vanishes about half-way and in
    the mean of a strip's edges.
    """
    tip = loads.wrenches["tip"]
    block = loads.reaches.get("slot", np.zeros(len(tip)))
    place = (block + shape.slot_to - shape.slot_width / 2) / 2
    strip = (shape.width - shape.slot_width) / 2
    inertia = shape.thickness * (shape.width**3 - shape.slot_width**3) / 12
    own = _own(level, 2 * strip * shape.thickness, place, shape.length, place)[1]
    moment = tip[:, 5] + (shape.length - place) * tip[:, 1] + own
    apart = shape.width - strip
    (worst,) = first_largest(np.abs(moment))
    mean = [
        sum(_edge_stress(level, worst, float(place[worst]), y, strip) for y in edges) / 2
        for edges in (
            (shape.slot_width / 2, shape.width / 2),
            (-shape.slot_width / 2, -shape.width / 2),
        )
    ]
    return [
        HandCheck(
            "mean stress by bending in the strips beside the slot",
            float(np.abs(moment[worst])) * apart / (2 * inertia),
            abs(mean[0] - mean[1]) / 2,
            "MPa",
            f"M a/(2 I), M = {abs(moment[worst]) / 1e3:.3g} N m at x = {place[worst]:.1f} mm, "
            f"half-way between block and slot's end, strips {apart:g} mm apart, I = {inertia:.5g} "
            "mm4 of both",
        ),
        *_pulled_lug("pivot", shape.width, shape.thickness, loads, level),
    ]


def leaf_hand_checks(shape: LeafPack, loads: PartLoads, level: Level) -> list[HandCheck]:
    """Bending of the leaves at the pivot, and at the edges of the clamp.

    The pivot's force is even over the clamp's length in the model. A clamp that is stiffer than the
    leaves carries it at its edges and leaves the middle without stress of its own.
    """
    force = loads.wrenches["contact"][:, 1]
    reach = loads.reaches.get("contact", np.zeros(len(force)))
    moment = force * reach
    (worst,) = first_largest(np.abs(moment))
    modulus = shape.inertia_separate / (shape.thickness / 2)
    half = shape.clamp_length / 2
    middle = _leaf_bending(shape, level, worst, 0.0)
    checks = [
        HandCheck(
            "bending stress of the leaves at the pivot, x = 0; the model spreads the clamp's force",
            float(np.abs(moment[worst])) / modulus,
            middle,
            "MPa",
            f"M t/(2 n I), M = {abs(force[worst]):.2f} N x {abs(reach[worst]):.1f} mm, n = "
            f"{shape.leaves}, n I = {shape.inertia_separate:.5g} mm4, without the arm's own weight "
            "and inertia",
        )
    ]
    rod, area = loads.wrenches["rod"], shape.leaves * shape.thickness * shape.width
    for place, end in ((-half, -shape.arm), (half, shape.length + shape.overhang)):
        own = _own(level, area, min(place, end), max(place, end), place)[1][worst]
        if place < 0:
            acting = force[worst] * (reach[worst] - place)
        else:
            acting = rod[worst, 5] + rod[worst, 1] * (shape.length - place)
        edge = _leaf_bending(shape, level, worst, place)
        checks.append(
            HandCheck(
                f"bending stress of the leaves at the clamp's edge, x = {place:g} mm",
                abs(float(acting + own)) / modulus,
                edge,
                "MPa",
                f"M t/(2 n I), M = {abs(acting + own) / 1e3:.4g} N m, of it {own / 1e3:+.3g} N m "
                f"by {_OWN}; {edge / middle:.3f} of the model's at x = 0: a clamp stiffer than the "
                "leaves relieves the middle, and this edge governs with its fretting",
            )
        )
    return checks


def _own(
    level: Level, area: float, start: Place, stop: Place, about: Place
) -> tuple[FloatArray, FloatArray]:
    """Force along x (n,) and moment about a place (n,) of a bar's own weight and inertia.

    An even bar along x from `start` to `stop`, d'Alembert: -rho A (a_x - omega^2 x) along x and
    -rho A (a_y + alpha x) across, with all that the model's inertia balances.
    """
    a_x, a_y, alpha, omega2 = level.coefficients[-len(ACCELERATIONS) :]
    even = -level.solutions.material.density * area
    first = (stop**2 - start**2) / 2
    along = even * (a_x * (stop - start) - omega2 * first)
    lever = first - about * (stop - start)
    second = (stop**3 - start**3) / 3 - about * first
    return along, even * (a_y * lever + alpha * second)


def _edge_stress(level: Level, position: int, place: float, y: float, window: float) -> float:
    """Stress along x on the faces at height y near x = place, by a straight line, MPa."""
    points = level.history.points
    near = np.abs(points[:, 0] - place) < window
    near &= np.abs(points[:, 1] - y) < 1e-6 * abs(y)
    along = points[near, 0] - place
    terms = np.stack([np.ones_like(along), along], axis=1)
    stress = level.history.at(position)[near, 0]
    return float(np.linalg.lstsq(terms, stress, rcond=None)[0][0])


def _leaf_bending(shape: LeafPack, level: Level, position: int, place: float) -> float:
    """Bending stress of the model's outer leaf faces at `place`, half of top less bottom, MPa.

    A straight line through the points within one leaf thickness, so that no kink beside counts
    twice: the moment is smooth where the clamp's pressure is even.
    """
    stress = level.history.at(position)[:, 0]
    points = level.history.points
    top = shape.leaves * shape.thickness / 2
    near = np.abs(points[:, 0] - place) < shape.thickness
    inside = np.abs(points[:, 2]) < 0.45 * shape.width
    sides = []
    for y in (-top, top):
        chosen = near & inside & (np.abs(points[:, 1] - y) < 1e-6 * top)
        along = points[chosen, 0] - place
        terms = np.stack([np.ones_like(along), along], axis=1)
        sides.append(float(np.linalg.lstsq(terms, stress[chosen], rcond=None)[0][0]))
    return abs(sides[1] - sides[0]) / 2


def _beam_stress(level: Level, position: int, place: float, window: float) -> tuple[float, float]:
    """Axial stress, MPa, and its slope across the plane, MPa/mm, on the surface near x = place.

    Least squares of a + b y + c z + d x + e x y over the surface points within the window.
    """
    points = level.history.points
    near = np.abs(points[:, 0] - place) < window
    x, y, z = (points[near] - np.array([place, 0.0, 0.0])).T
    terms = np.stack([np.ones_like(x), y, z, x, x * y], axis=1)
    found = np.linalg.lstsq(terms, level.history.at(position)[near, 0], rcond=None)[0]
    return float(found[0]), float(found[1])


def _pulled_lug(
    name: str, width: float, thickness: float, loads: PartLoads, level: Level
) -> list[HandCheck]:
    """Peak beside the hole of a flat lug where the pin pulls most towards its end, if it does."""
    interface = level.solutions.mesh.interfaces[name]
    hole, at = 2 * interface.radius, interface.centre
    outward = -1.0 if at[0] == 0 else 1.0
    pull = outward * loads.wrenches[name][:, 0]
    (worst,), factor = first_largest(pull), lug_factor(hole, width)
    besides = np.abs(loads.wrenches[name][worst, 1:]) / np.array([1, 1, width, width, width])
    if factor is None or not besides.max() < _STRAIGHT * pull[worst]:
        return []
    arm = level.history.points - at
    on_bore = np.abs(np.hypot(arm[:, 0], arm[:, 1]) - hole / 2) < 1e-3 * hole
    beside = on_bore & (np.abs(arm[:, 1]) > 0.35 * hole)
    peak = von_mises(level.history.at(worst))[beside]
    net = (width - hole) * thickness
    return [
        HandCheck(
            f"peak beside the hole at {name}, which the pin pulls",
            factor * float(pull[worst]) / net,
            float(peak.max()),
            "MPa",
            f"Kt F/((H - d) t) = {factor:.3f} x {pull[worst]:.0f} N / {net:.1f} mm2 (Peterson, "
            "Pilkey); for an end at least H away; one that is round about the pin has some "
            "20 to 30 % more",
        )
    ]
