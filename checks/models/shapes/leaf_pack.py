"""Leaf packs by formula."""

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import BarLoads, balanced_bar, deflection
from checks.models.formula_bars import left_over
from checks.models.formula_points import Points, along_x, in_section, sheared
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from geometry.bars import fine_cells
from geometry.mesh import FloatArray
from geometry.parts import LeafPack

_SPREAD = 6  # forces by which a clamp's pressure is told; even, so that its middle is exact
_INSIDE = 9  # places inside the clamp at the pivot
_BESIDE = 6  # places between clamps and contact


def stress(part: Part, shape: LeafPack, loads: PartLoads) -> RungModel:
    """Leaves that slide on each other freely: each bears an equal share of the bending moment.

    Pivot and rod hold them by a pressure that is even over their clamps, as on the solid.
    """
    bar = leaf_bar(part, shape, loads)
    points = Points(len(loads.accelerations))
    half, rod = shape.clamp_length / 2, shape.rod_length / 2
    near = shape.length - rod
    stretches = [
        ("leaves", np.linspace(-shape.contact_to, -half, _BESIDE + 1)[:-1], 1.0),
        ("leaves at the clamp", np.linspace(-half, half, _INSIDE), shape.clamp_factor),
        ("leaves", np.linspace(half, near, _BESIDE + 1)[1:], 1.0),
        ("leaves at the rod", np.linspace(near, shape.length, 3)[1:], 1.0),
    ]
    for name, places, fretting in stretches:
        _add_fibres(points, shape, name, places, bar, fretting)
    return points.model(
        residual=left_over(bar, loads, shape.length),
        deflection=_deflection(part, shape, bar),
        neglects="peaks where clamp and contact press; friction between leaves; that wide leaves "
        "resist bending across",
    )


def leaf_bar(part: Part, shape: LeafPack, loads: PartLoads) -> BarLoads:
    """All loads of a leaf pack along its axis: contact, clamps, inertia as it moves and bends."""
    area = shape.leaves * shape.thickness * shape.width
    ends = np.array([-shape.arm, 0.0, shape.length + shape.overhang])
    cuts = fine_cells(ends, 192)
    mass = part.material.density * area * np.diff(cuts)
    reach = loads.reaches.get("contact")
    contact = loads.wrenches["contact"].copy()
    if reach is None:
        reach = np.full(len(contact), -(shape.contact_from + shape.contact_to) / 2)
    contact[:, 5] -= reach * contact[:, 1]
    points: list[tuple[float | FloatArray, FloatArray]] = [(reach, contact)]
    points += _clamped(loads.wrenches["pivot"], 0.0, shape.clamp_length)
    points += _clamped(loads.wrenches["rod"], shape.length, shape.rod_length)
    for place, across in loads.own_swing.items():
        bending = np.zeros_like(contact)
        bending[:, 1] = across
        points.append((place, bending))
    return balanced_bar(points, (cuts[1:] + cuts[:-1]) / 2, mass, loads.accelerations)


def _clamped(
    wrench: FloatArray, centre: float, length: float
) -> list[tuple[float | FloatArray, FloatArray]]:
    """A clamp's forces: even over its length, its couple as forces that grow along it."""
    places = ((np.arange(_SPREAD) + 0.5) / _SPREAD - 0.5) * length
    second = (places**2).sum()
    found: list[tuple[float | FloatArray, FloatArray]] = []
    for place in places:
        own = np.zeros_like(wrench)
        own[:, :2] = wrench[:, :2] / _SPREAD
        own[:, 1] += wrench[:, 5] * place / second
        found.append((float(centre + place), own))
    return found


def _add_fibres(
    points: Points, shape: LeafPack, name: str, places: FloatArray, bar: BarLoads, fretting: float
) -> None:
    """Add the faces of the outer leaves, and their edges' middles, where shear is largest."""
    forces = bar.at(places)
    area = shape.leaves * shape.thickness * shape.width
    modulus = shape.inertia_separate / (shape.thickness / 2)
    top = shape.leaves * shape.thickness / 2
    for k, x in enumerate(places):
        axial, moment, shear = points.columns(
            np.stack([forces.axial[k], forces.moment_z[k], forces.shear[k]]),
            in_section(x, "axial force", "moment M_z", "shear force"),
        )
        at = np.array([[x, top, 0], [x, -top, 0], [x, top - shape.thickness / 2, shape.width / 2]])
        points.add(
            name,
            at,
            {
                axial: along_x(np.full(3, 1 / area)),
                moment: along_x(np.array([-1.0, 1.0, 0.0]) / modulus),
                shear: sheared(np.array([0.0, 0.0, 1.5 / area])),
            },
            fretting,
        )


def _deflection(part: Part, shape: LeafPack, bar: BarLoads) -> float:
    """Largest deflection, mm, off the chord of contact and rod."""
    places = np.linspace(-(shape.contact_from + shape.contact_to) / 2, shape.length, 49)
    moment = bar.at(places).moment_z
    chosen = np.unique(np.abs(moment).argmax(axis=1))
    stiffness = np.full(len(places), part.material.youngs_modulus * shape.inertia_separate)
    return float(np.abs(deflection(moment[:, chosen], stiffness, places)).max())


MODEL = ShapeModel(LeafPack, stress, statics=True)
