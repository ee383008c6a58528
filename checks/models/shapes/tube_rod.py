"""Round rods with an eye at each end, by formula."""

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import BarLoads
from checks.handbook.lug_stress import Lug, mirrored, round_outline, stepped_shaft
from checks.handbook.pin_loaded_hole import ComplexArray, pin_loaded_hole
from checks.models.formula_bars import BarPart, Stretches
from checks.models.formula_lugs import add_bore
from checks.models.formula_points import Points, along_x, in_section, sheared
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from fem.unit_loads import harmonics_of
from geometry.bars import fine_cells
from geometry.mesh import FloatArray
from geometry.parts import TubeRod

_AROUND = np.radians(np.arange(0.0, 360.0, 45.0))
_STATIONS = 9
_FACTORS = ("tension", "bending")


def stress(part: Part, shape: TubeRod, loads: PartLoads) -> RungModel | None:
    """Two eyes as round lugs as thick as they are wide, and the tube between them.

    An eye is a ball cut flat: as a lug it gets the outline that leaves it the same ligament. None
    for a rod without fillets, where the elastic stress has no bound.
    """
    if not shape.fillet:
        return None
    places = {"first": 0.0, "second": shape.length}
    mass = _stretches(shape)
    whole = BarPart.of(part, loads, places, mass, shape.length, (shape.hole / 2, shape.hole / 2))
    bar, points = whole.forces, whole.points
    ligament = shape.ligament / shape.eye_width
    radius = shape.hole / 2 + ligament
    outline = round_outline(radius, min(shape.tube_diameter / 2, 0.95 * radius))
    nu = part.material.poisson_ratio
    hole = pin_loaded_hole(shape.hole / 2, outline, nu, harmonics_of(loads.arc))
    rear = np.radians([180.0, 150.0, 120.0, 90.0, 270.0, 240.0, 210.0])
    edge: ComplexArray = np.asarray(radius * np.exp(1j * rear))
    for name, x in places.items():
        lug = Lug(hole, shape.eye_width, mirrored=x > 0)
        own = mirrored(edge) if x > 0 else edge
        add_bore(points, part, loads, name, x, lug, (0.0,), edges=own)
    _add_tube(points, shape, bar)
    return whole.model(
        neglects="that a ball's eye is thinner towards its outline; where the tube's bore ends",
    )


def _add_tube(points: Points, shape: TubeRod, bar: BarLoads) -> None:
    """Add the tube's fibres all round, with the fillets' factors where these begin."""
    end = shape.shank_end
    places = np.linspace(end, shape.length - end, _STATIONS)
    forces = bar.at(places)
    (section,) = shape.sections
    modulus = section.inertia_in_plane / (shape.tube_diameter / 2)
    sizes = (shape.eye_diameter, shape.tube_diameter, shape.fillet)
    for k, x in enumerate(places):
        ends = k in (0, len(places) - 1)
        pulled, bent = (stepped_shaft(kind, *sizes) if ends else 1.0 for kind in _FACTORS)
        axial, moment, shear = points.columns(
            np.stack([forces.axial[k], forces.moment_z[k], forces.shear[k]]),
            in_section(x, "axial force", "moment M_z", "shear force"),
        )
        y, z = np.sin(_AROUND), np.cos(_AROUND)
        at = np.column_stack([np.full(len(y), x), y, z])
        at[:, 1:] *= shape.tube_diameter / 2
        points.add(
            "fillet" if ends else "tube",
            at,
            {
                axial: along_x(np.full(len(y), pulled / section.area)),
                moment: along_x(-bent * y / modulus),
                shear: sheared(_around_middle(z) * 2 / section.area),
            },
        )


def _around_middle(z: FloatArray) -> FloatArray:
    """1 at the tube's sides, where bending vanishes and shear is twice the mean of a thin tube."""
    return (np.abs(z) > 1 - 1e-9).astype(float)


def _stretches(shape: TubeRod) -> Stretches:
    radius = shape.eye_diameter / 2
    ends = np.array([-radius, radius, shape.length - radius, shape.length + radius])
    cuts = fine_cells(ends, 160)
    x = (cuts[1:] + cuts[:-1]) / 2
    (section,) = shape.sections
    beside = np.minimum(np.abs(x), np.abs(x - shape.length))
    own = np.sqrt(np.maximum(radius**2 - beside**2, 0.0))
    height = np.minimum(own, shape.eye_width / 2)
    angle = np.arcsin(np.divide(height, own, out=np.zeros_like(own), where=own > 0))
    disc = 2 * own**2 * angle + 2 * height * np.sqrt(own**2 - height**2)  # a circle cut flat
    chord = 2 * np.sqrt(np.maximum(shape.hole**2 / 4 - beside**2, 0.0))
    area = np.where(beside < radius, disc - chord * np.minimum(2 * own, shape.eye_width), 0.0)
    area = np.maximum(area, np.where(beside < radius, 0.0, section.area))
    ones = np.ones(len(x))
    return Stretches(
        cuts,
        area,
        ones * section.inertia_in_plane,
        ones * section.inertia_out_of_plane,
        ones * 2 * section.inertia_in_plane,
    )


MODEL = ShapeModel(TubeRod, stress, arcs=True)
