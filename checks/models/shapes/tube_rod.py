"""Round rods with an eye at each end, by formula.

The stress at their eyes is by solids of eyes of many proportions.
An eye is solved as half a rod under every pattern of a pin's pressure (`bench.rod_eyes`), the shank
in balance. Made free of size, the stress at places in the bore, along the fillet and inside the
tube's bore is

    sigma = s v,   v = v_0 + sum_k a_k(q) w_k

with the main modes w_k of all solids' v (singular value decomposition) and factors a_k that are
smooth functions of five proportions q, which meet those of the solids but for their numerical
scatter: sums of Gaussians about the solids' q and a linear part, whose lengths are those of the
largest likelihood (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, sections
2.2, 2.7 and 5.4). The scales s carry what is known: the bore's stress goes with the
ligament L behind the hole, the fillet's with the stepped shaft's factor.

Proportions beyond those of the solids count as the nearest of these (docs/theory/rungs.md).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from math import log, pi, sqrt
from typing import Any

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import BarLoads
from checks.handbook.lug_stress import cartesian, stepped_shaft
from checks.handbook.pin_loaded_hole import PATTERNS, patterns_of
from checks.models.formula_bars import BarPart, Stretches
from checks.models.formula_points import (
    XX,
    XY,
    YY,
    ZZ,
    Points,
    along_x,
    bore_columns,
    in_section,
    sheared,
)
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.stress.stress_result import RungModel
from fem.unit_loads import harmonics_of
from geometry.bars import fine_cells
from geometry.mesh import FloatArray
from geometry.parts import TubeRod

_AROUND = np.radians(np.arange(0.0, 360.0, 45.0))
_STATIONS = 9
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
_COS, _SIN, _COUPLE = (PATTERNS.index(name) for name in ("cos 1", "sin 1", "couple"))
FULLEST = 0.97  # largest `fullness` of the solids
BORE, FILLET, INSIDE = "bore", "fillet", "inside"
ANGLES = np.radians(np.arange(0.0, 181.0, 15.0))  # in the bore, from the shank on
HEIGHTS = np.array([0.0, 0.55, 0.98])  # in the bore, of half the eye's width
ARC = np.array([0.0, 0.15, 0.3, 0.45, 0.6, 0.8])  # of the fillet's arc, from the shank on
WITHIN = np.array([0.22, 0.07])  # rad of the hemisphere, from the cylinder on
AROUND = np.radians([0.0, 45.0, 90.0])  # about the rod's axis, from +y towards +z
ROWS = {BORE: len(HEIGHTS), FILLET: len(ARC), INSIDE: len(WITHIN)}
ALONG = {BORE: len(ANGLES), FILLET: len(AROUND), INSIDE: len(AROUND)}
PARITY = np.array([-1.0 if name[:3] in ("sin", "cou") else 1.0 for name in PATTERNS])  # about y = 0


@dataclass(frozen=True, eq=False)
class Fitted:
    """Fit of v of some patterns at the places of one kind.

    middle, spread  (5,) of the solids' proportions
    lengths         (5,) of the Gaussians, over the spread
    slope           weight of the linear part
    solids          (n, 5) proportions less their middle, over the spread
    weights         (n, k) of the solids in each mode's factor
    mean, modes     (m,) and (k, m) v: rows, places along them, two components, patterns
    """

    place: str
    patterns: Sequence[int]
    middle: FloatArray
    spread: FloatArray
    lengths: FloatArray
    slope: float
    solids: FloatArray
    weights: FloatArray
    mean: FloatArray
    modes: FloatArray

    def at(self, proportions: FloatArray) -> FloatArray:
        """Return v (rows, along, 2, patterns) at proportions (5,)."""
        near = (proportions - self.middle) / self.spread
        near = np.clip(near, self.solids.min(axis=0), self.solids.max(axis=0))
        factors = kernel(near[None], self.solids, self.lengths, self.slope)[0] @ self.weights
        found = self.mean + factors @ self.modes
        return np.asarray(found.reshape(ROWS[self.place], ALONG[self.place], 2, -1))


def kernel(first: FloatArray, second: FloatArray, lengths: FloatArray, slope: float) -> FloatArray:
    """Covariance (n, m) of the factors at proportions (n, 5) and (m, 5): Gaussian and linear."""
    away = ((first[:, None] - second) / lengths) ** 2
    return np.asarray(np.exp(-away.sum(axis=2) / 2) + slope * (1 + first @ second.T))


def fullness(rod: TubeRod) -> float:
    """Eye's width over the width at which its flats end at the hole's edge."""
    return rod.eye_width / sqrt(rod.eye_diameter**2 - rod.hole**2)


def proportions(rod: TubeRod, place: str) -> FloatArray:
    """Proportions (5,) in which the fit of a kind of place is smooth, as logarithms."""
    eye, tube = rod.eye_diameter, rod.tube_diameter
    wall = (tube - rod.bore) / 2
    across = rod.sections[0].area / rod.ligament if place == FILLET else wall / tube
    numbers = (1 - rod.hole / eye, fullness(rod), tube / eye, across, rod.fillet / tube)
    return np.array([log(number) for number in numbers])


def section_place(rod: TubeRod, place: str) -> float:
    """Distance of the section whose forces a fillet or a bore's end has, from the pin, mm."""
    return rod.shank_end if place == FILLET else (rod.eye_diameter + rod.bore) / 2


def scales(rod: TubeRod, place: str) -> FloatArray:
    """Stress (8,) that v = 1 stands for, MPa per N and N mm of the patterns."""
    ligament, area = rod.ligament, rod.sections[0].area
    found = np.full(len(PATTERNS), 1 / ligament)
    if place == BORE:
        found[_COUPLE] = 2 / (ligament * rod.hole)
        return found
    pulled, bent, full = 1.0, 1.0, area
    if place == FILLET:
        sizes = (rod.eye_diameter, rod.tube_diameter, rod.fillet)
        pulled, bent = (stepped_shaft(kind, *sizes) for kind in ("tension", "bending"))
        full = pi / 4 * rod.tube_diameter**2
    modulus = rod.sections[0].inertia_in_plane / (rod.tube_diameter / 2)
    found *= sqrt(pulled)
    found[_COS] = pulled / sqrt(area * full)
    found[_SIN] = bent * section_place(rod, place) / modulus
    found[_COUPLE] = bent / modulus
    return found


def eye_stress(rod: TubeRod, place: str) -> FloatArray:
    """Stress (rows, along, 2, 8), MPa per N and N mm of the patterns, at y >= 0 and z >= 0.

    In the bore the hoop stress and the stress along z, at `HEIGHTS` and `ANGLES`; else along the
    meridian and around the rod's axis, at `ARC` or `WITHIN` and `AROUND`.
    """
    found = np.zeros((ROWS[place], ALONG[place], 2, len(PATTERNS)))
    for fitted in _fits():
        if fitted.place == place:
            found[..., list(fitted.patterns)] = fitted.at(proportions(rod, place))
    return np.asarray(found * scales(rod, place))


def pressed(rod: TubeRod, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Radial and shear stress (k, 8) in a bore, of the patterns themselves, MPa per N and N mm."""
    radius, width = rod.hole / 2, rod.eye_width
    radial, shear = np.zeros((2, len(angles), len(PATTERNS)))
    for k, name in enumerate(PATTERNS[:_COUPLE]):
        wave, number = name.split()
        size = (np.cos if wave == "cos" else np.sin)(int(number) * angles)
        radial[:, k] = -size / (np.pi * radius * width)
    shear[:, _COUPLE] = -1 / (2 * np.pi * radius**2 * width)
    return radial, shear


@cache
def _fits() -> Sequence[Fitted]:
    text = files("checks.models").joinpath("rod_eyes.json").read_text(encoding="utf-8")
    return [_fit_of(entry) for entry in json.loads(text)["fits"]]


def _fit_of(entry: Mapping[str, Any]) -> Fitted:
    names = ("middle", "spread", "lengths", "solids", "weights", "mean", "modes")
    arrays = {name: np.array(entry[name]) for name in names}
    return Fitted(entry["place"], entry["patterns"], slope=entry["slope"], **arrays)


def stress(part: Part, shape: TubeRod, loads: PartLoads) -> RungModel | None:
    """Two eyes by solids of eyes (`checks.models.shapes.tube_rod`), and the tube between them.

    None for a rod without fillets, where the elastic stress has no bound, and for eyes whose flats
    leave less beside the holes than those of the solids: a pin presses on a feather edge there.
    """
    if not shape.fillet or fullness(shape) > FULLEST:
        return None
    places = {"first": 0.0, "second": shape.length}
    mass = _stretches(shape)
    whole = BarPart.of(part, loads, places, mass, shape.length, (shape.hole / 2, shape.hole / 2))
    for name, x in places.items():
        _add_eye(whole, shape, name, x)
    _add_tube(whole.points, shape, whole.forces)
    return whole.model(neglects="how near the eyes are to each other; inertia within an eye")


def _add_eye(whole: BarPart, shape: TubeRod, name: str, x: float) -> None:
    """Add an eye's bore, fillet and end of the tube's bore; the second is the first turned."""
    points, radius = whole.points, shape.hole / 2
    angles = np.concatenate([ANGLES, -ANGLES[1:-1]])
    names = patterns_of(harmonics_of(whole.loads.arc))
    stress = _rim(shape, angles, names) * (_turned(names) if x else 1.0)
    plane = stress[0][:, [XX, YY, XY]]
    columns, patterns = bore_columns(
        points, whole.part, whole.loads, name, plane, angles, shape.eye_width
    )
    arms = np.column_stack([radius * np.cos(angles), radius * np.sin(angles)])
    for height, block in zip(HEIGHTS * shape.eye_width / 2, stress, strict=True):
        at = np.column_stack([arms, np.full(len(angles), height)])
        points.add_block(name, _placed(at, x), columns, block[:, :, patterns])
    resultants = [PATTERNS[k] for k in (_COS, _SIN, _COUPLE)]
    squeezing = [
        (column, PATTERNS.index(names[pattern]))
        for column, pattern in zip(columns, patterns, strict=True)
        if names[pattern] in PATTERNS and names[pattern] not in resultants
    ]
    for place in (FILLET, INSIDE) if shape.bore else (FILLET,):
        _add_beside(whole, shape, place, squeezing, x)


def _placed(at: FloatArray, x: float) -> FloatArray:
    """Places (k, 3) of the first eye, or turned by 180 degrees to those of one at x."""
    return at * [-1, -1, 1] + [x, 0, 0] if x else at


def _turned(names: Sequence[str]) -> FloatArray:
    """Signs of patterns turned by 180 degrees."""
    return np.array([1.0 if name == "couple" else (-1.0) ** int(name[4:]) for name in names])


def _rim(shape: TubeRod, angles: FloatArray, names: Sequence[str]) -> FloatArray:
    """Stress (rows, k, 6, patterns) in the first eye's bore, MPa per N and N mm of the patterns.

    Harmonics that the half circle does not have are those of a wide plate: p cos(n t) has the hoop
    stress -p cos(n t) (Bickley). Of thin eyes n = 3 has more, 2.7 times in a lug of d/W = 0.55: on
    90 degrees the bore is up to 11 % low there, which the bands, compared on arcs, hold.
    """
    own = _known_rim(shape, angles)
    stress = np.zeros((*own.shape[:3], len(names)))
    for k, name in enumerate(names):
        if name in PATTERNS:
            stress[..., k] = own[..., PATTERNS.index(name)]
            continue
        wave = np.cos if name.startswith("cos") else np.sin
        size = -wave(int(name[4:]) * angles) / (np.pi * shape.hole / 2 * shape.eye_width)
        stress[:, :, [XX, YY], k] = size[:, None]
    return stress


def _known_rim(shape: TubeRod, angles: FloatArray) -> FloatArray:
    """Stress (rows, k, 6, 8) in the first eye's bore of the patterns of the half circle."""
    hoop, aside = np.moveaxis(_both_sides(eye_stress(shape, BORE), ends=False), 2, 0)
    radial, shear = pressed(shape, angles)
    every = np.repeat(angles, len(PATTERNS))
    stress = np.zeros((len(hoop), len(angles), 6, len(PATTERNS)))
    for level, along_z, block in zip(hoop, aside, stress, strict=True):
        plane = cartesian(level.ravel(), radial.ravel(), shear.ravel(), every)
        block[:, [XX, YY, XY]] = plane.reshape(len(angles), -1, 3).transpose(0, 2, 1)
        block[:, ZZ] = along_z
    return stress


def _add_beside(
    whole: BarPart,
    shape: TubeRod,
    place: str,
    squeezing: Sequence[tuple[int, int]],
    x: float,
) -> None:
    """Add a fillet, or the end of the tube's bore: by the section's forces and the pin's pressure.

    squeezing  columns of the pressure without a resultant, and which of the patterns each is of
    x          mm, of the eye
    """
    at, stress = _surface(shape, place)
    section = section_place(shape, place)
    if x:
        stress = stress * np.array([1, 1, 1, 1, -1, -1])[:, None]  # yz and zx turn round
    cut = x - section if x else section
    forces = whole.forces.at(np.array([cut]))
    columns = whole.points.columns(
        np.concatenate([forces.axial, forces.moment_z, forces.shear]),
        in_section(cut, "axial force", "moment M_z", "shear force"),
    )
    # in an eye's own axes: F_x = -N, F_y = -V, and M_z = -M - x V at the pin
    couple = stress[:, :, _COUPLE]
    own = [-stress[:, :, _COS], couple if x else -couple]
    own.append(-stress[:, :, _SIN] - section * couple)
    own += [stress[:, :, pattern] for _, pattern in squeezing]
    columns += [column for column, _ in squeezing]
    name = "fillet" if place == FILLET else "end of the tube's bore"
    whole.points.add_block(name, _placed(at, x), columns, np.stack(own, axis=2))


def _surface(shape: TubeRod, place: str) -> tuple[FloatArray, FloatArray]:
    """Points (k, 3), mm, and stress (k, 6, 8) of the first eye's fillet or bored end."""
    if place == FILLET:
        slope = ARC * np.arcsin((shape.shank_end - shape.joint) / shape.fillet)
        x = shape.shank_end - shape.fillet * np.sin(slope)
        off = shape.tube_diameter / 2 + shape.fillet * (1 - np.cos(slope))
    else:
        slope = -WITHIN
        x = section_place(shape, place) - shape.bore / 2 * np.sin(WITHIN)
        off = shape.bore / 2 * np.cos(WITHIN)
    around = np.concatenate([AROUND, np.pi - AROUND[:-1]])
    cos, sin = np.cos(around), np.sin(around)
    at = np.stack(np.broadcast_arrays(x[:, None], off[:, None] * cos, off[:, None] * sin), axis=-1)
    values = _both_sides(eye_stress(shape, place), ends=True)
    outward = np.stack([0 * cos, cos, sin], axis=1)
    ring = np.stack([0 * cos, -sin, cos], axis=1)
    meridian = np.cos(slope)[:, None, None] * [1, 0, 0] - np.sin(slope)[:, None, None] * outward
    stress = np.zeros((*at.shape[:2], 6, len(PATTERNS)))
    for k, vectors in enumerate((meridian, np.broadcast_to(ring, meridian.shape))):
        dyad = np.stack([vectors[..., i] * vectors[..., j] for i, j in _PAIRS], axis=-1)
        stress += dyad[..., None] * values[:, :, None, k]
    return at.reshape(-1, 3), stress.reshape(-1, 6, len(PATTERNS))


def _both_sides(values: FloatArray, *, ends: bool) -> FloatArray:
    """Values (rows, along, 2, 8) with those at y < 0 behind them; of the last place, too, or not.

    ends  False where the first and the last place lie at y = 0
    """
    other = values[:, :-1] if ends else values[:, 1:-1]
    return np.concatenate([values, other * PARITY], axis=1)


def _add_tube(points: Points, shape: TubeRod, bar: BarLoads) -> None:
    """Add the tube's fibres all round, between the fillets."""
    end = shape.shank_end
    places = np.linspace(end, shape.length - end, _STATIONS)[1:-1]
    forces = bar.at(places)
    (section,) = shape.sections
    modulus = section.inertia_in_plane / (shape.tube_diameter / 2)
    for k, x in enumerate(places):
        axial, moment, shear = points.columns(
            np.stack([forces.axial[k], forces.moment_z[k], forces.shear[k]]),
            in_section(x, "axial force", "moment M_z", "shear force"),
        )
        y, z = np.sin(_AROUND), np.cos(_AROUND)
        at = np.column_stack([np.full(len(y), x), y, z])
        at[:, 1:] *= shape.tube_diameter / 2
        points.add(
            "tube",
            at,
            {
                axial: along_x(np.full(len(y), 1 / section.area)),
                moment: along_x(-y / modulus),
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
