"""Parts from CAD by formula: a bar of the section that the user states.

Stress at the outer fibres of a member's sections, by its section forces.

Section forces are those of fem/frame.py: N, V_y, V_z, T, M_y, M_z in the member's local axes, so
that at a fibre (y, z)

    xx = N / A - M_z y / I_z + M_y z / I_y

and the shear stress on the surface runs along it. Stress is xx, yy, zz, xy, yz, zx.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import BarForces
from checks.models.formula_bars import (
    Stretches,
    bar_loads,
    elastic_load,
    fine_cells,
    left_over,
    most_deflected,
)
from checks.models.formula_points import Points, in_section
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel, no_answer
from geometry.bars import rectangle, rectangle_torsion
from geometry.mesh import FloatArray
from geometry.parts.step_part import Pair, StepPart

_N, _V_Y, _V_Z, _T, _M_Y, _M_Z = range(6)
_XX, _XY, _ZX = 0, 3, 5
_STRAIGHT = 1e-3  # of the outermost holes' distance: how far a hole may stand beside the line
_BESIDE = 1e-9  # of it: how far a section just beside a hole is from the hole's axis
_BETWEEN = 13  # stations between two neighbouring holes
_CELLS = 96  # of the mass


@dataclass(frozen=True, eq=False)
class Fibres:
    """Outer fibres of one section.

    places  (f, 2)     mm, local y and z
    unit    (f, 6, 6)  MPa per N or N mm: stress by section force, local axes
    """

    places: FloatArray
    unit: FloatArray


def rectangle_fibres(height: float, width: float) -> Fibres:
    """Corners and middles of the sides of a rectangle, `height` along y and `width` along z.

    Shear is 3/2 V/A in the middles of the sides along it and none at corners (Jourawski); the peak
    of torsion stands in the middle of the longer side. In the middle of the shorter one it is
    smaller by the sides' ratio (Roark, table 10.1, case 4: exact for a square, 0.74 where thin).
    """
    y, z = height / 2, width / 2
    places = np.array([[a * y, b * z] for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b])
    area = height * width
    unit = np.zeros((len(places), 6, 6))
    unit[:, _XX, _N] = 1 / area
    unit[:, _XX, _M_Z] = -places[:, 0] / (width * height**3 / 12)
    unit[:, _XX, _M_Y] = places[:, 1] / (height * width**3 / 12)
    constant, modulus = (float(value) for value in rectangle_torsion(height, width))
    assert constant > 0
    longer = max(height, width)
    on_z, on_y = places[:, 0] == 0, places[:, 1] == 0
    unit[on_z, _XY, _V_Y] = 1.5 / area
    unit[on_y, _ZX, _V_Z] = 1.5 / area
    # a torque turns y to z: on the face at z > 0 the shear runs along -y
    unit[on_z, _XY, _T] = -np.sign(places[on_z, 1]) * height / longer / modulus
    unit[on_y, _ZX, _T] = np.sign(places[on_y, 0]) * width / longer / modulus
    return Fibres(places, unit)


def stress(part: Part, shape: StepPart, loads: PartLoads) -> RungModel | None:
    """A straight bar of the stated section along the line of the holes, as heavy as the solid.

    None without a stated section, where the holes do not stand on one line along x with their
    middles in one plane, and for contacts that slide. The buckling load takes the force at two
    holes; a force at a third one changes the compression along the bar.
    """
    centres = {name: shape.centre(name) for name in shape.interfaces}
    along = np.sort([centre[0] for centre in centres.values()])
    start, span = float(along[0]), float(along[-1] - along[0])
    aside = max(float(np.abs(centre[1:]).max()) for centre in centres.values())
    if shape.section is None or loads.reaches or aside > _STRAIGHT * span:
        return None
    height, thickness = shape.section
    stations = _stations(along - start)
    stiff, heavy = _stretches(shape, shape.section, start, stations)
    own = _on_line(loads, centres)
    places = {name: float(centre[0]) - start for name, centre in centres.items()}
    bar = bar_loads(part, own, places, heavy)
    points = Points(len(loads.accelerations))
    fibres = rectangle_fibres(height, thickness)
    _add_fibres(points, stations, start, bar.at(stations), fibres)
    return points.model(
        residual=left_over(bar, own, span),
        deflection=most_deflected(bar, part, stiff, span),
        buckles=partial(elastic_load, part, own, bar, stiff, span)
        if len(places) == 2
        else no_answer,
        neglects="holes, fillets, lugs and whatever else is not a straight bar of the stated "
        "section with its middle on the line of the holes; that the solid's mass is not spread "
        "evenly along it",
    )


def family(_part: Part, _shape: StepPart, _loads: PartLoads, _kind: str) -> str:
    """One for all: a part is named after its file, whatever that is called."""
    return "CAD part"


def _stations(along: FloatArray) -> FloatArray:
    """Sections on both sides of every hole and evenly between neighbours, from x (m,), rising."""
    beside = _BESIDE * along[-1]
    between = np.linspace(along[:-1], along[1:], _BETWEEN + 2, axis=1)[:, 1:-1]
    return np.sort(np.concatenate([along - beside, along + beside, between.ravel()]))


def _stretches(
    shape: StepPart, section: Pair, start: float, stations: FloatArray
) -> tuple[Stretches, Stretches]:
    """The bar by its stated section, and by one that has the solid's mass; x from `start`."""
    first = shape.found[shape.interfaces[0]].centre
    x = (shape.solid.outline - first) @ shape.axes[0] - start
    low, high = float(x.min()), float(x.max())
    inner = stations[(stations > low) & (stations < high)]
    cuts = fine_cells(np.concatenate([[low], inner, [high]]), _CELLS)
    found = rectangle(*section)
    ones = np.ones(len(cuts) - 1)
    stiff = Stretches(
        cuts,
        ones * found.area,
        ones * found.inertia_z,
        ones * found.inertia_y,
        ones * found.torsion,
    )
    return stiff, replace(stiff, area=ones * shape.solid.volume / (high - low))


def _on_line(loads: PartLoads, centres: Mapping[str, FloatArray]) -> PartLoads:
    """The same loads on the line y = z = 0.

    A force at (y, z) has the couple (-z F_y, z F_x, -y F_x) about the line. Accelerations stay
    those of the frame's origin, wherever the bar's x begins: of a bar in balance with its loads
    only omega2 is taken from them, which is the same everywhere.
    """
    moved = {}
    for name, wrench in loads.wrenches.items():
        _, y, z = centres[name]
        moved[name] = wrench.copy()
        moved[name][:, 3] -= z * wrench[:, 1]
        moved[name][:, 4] += z * wrench[:, 0]
        moved[name][:, 5] -= y * wrench[:, 0]
    return replace(loads, wrenches=moved)


def _add_fibres(
    points: Points, stations: FloatArray, start: float, forces: BarForces, fibres: Fibres
) -> None:
    """Add the corners and the middles of the sides of every section."""
    axial, shear, twist, bent, moment = fibres.unit[:, :, [0, 1, 3, 4, 5]].transpose(2, 0, 1)
    acting = (
        ("axial force", forces.axial, axial),
        ("shear force", forces.shear, shear),
        ("torque", forces.torque, twist),
        ("moment M_y", forces.moment_y, bent),
        ("moment M_z", forces.moment_z, moment),
    )
    for k, x in enumerate(stations):
        at = np.column_stack([np.full(len(fibres.places), x + start), fibres.places])
        stress = {
            points.column(values[k], in_section(x + start, kind)[0]): unit
            for kind, values, unit in acting
        }
        points.add("section", at, stress)


MODEL = ShapeModel(StepPart, stress, family=family)
