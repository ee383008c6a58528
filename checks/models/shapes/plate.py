"""Plates and levers with any number of pins, by formula."""

from cmath import phase
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from checks.design.data import Part
from checks.handbook.lug_stress import Lug, curved_bar, strip_outline
from checks.handbook.pin_loaded_hole import CurvedSection, open_hole, pin_loaded_hole
from checks.models.formula_points import ANGLES, XX, XY, YY, Points, bore_columns
from checks.models.plate_buckling import PlateForces, deflected, directed, elastic_load
from checks.models.shape_model import ShapeModel
from checks.part.part_loads import PartLoads
from checks.part.plate_loads import FlatSection
from checks.stress.stress_result import RungModel
from fem.unit_loads import harmonics_of
from geometry.bars import BESIDE
from geometry.mesh import FloatArray
from geometry.outlines import ComplexArray
from geometry.parts.plate import Plate, PlateBore

_PLANE = [XX, YY, XY]
_STATIONS = 13  # between two bores
_ON_ARC = (0.1, 0.3, 0.5, 0.7, 0.9)  # of a hollow edge, where it is asked
_ROUND = 0.05  # of half a width: an end that is as far as the sides are is round
_STRAIGHT = 1e-6  # of a unit vector
_LEAST_ARC = 0.15  # of the depth behind a hollow edge: a shorter arc counts as so long
_BENT = 5.0  # deg of turning, from which on a lever is bent


def stress(part: Part, shape: Plate, loads: PartLoads) -> RungModel | None:
    """Sections between neighbouring bores, hollow edges as curved bars, and the bores.

    None where the line between two neighbours leaves the plate, or a window is not round: what
    carries the load there, and the stress at the window's corners, is a solid's to say.
    """
    if any(window.circle is None for window in shape.windows):
        return None
    points = Points(len(loads.accelerations))
    forces = PlateForces(part, shape, loads, points)
    if not _add_arms(points, forces):
        return None
    for bore in shape.bores:
        _add_bore(part, points, forces, bore)
    for window in shape.windows:
        assert window.circle is not None
        _add_window(points, forces, *window.circle)
    _add_hollow_edges(points, forces)
    return points.model(
        residual=forces.residual,
        deflection=deflected(part, forces),
        buckles=partial(elastic_load, part, forces),
        neglects="that the load paths of the arms disturb each other; stress not linear across "
        "the arms; couples out of the plane",
    )


def family(part: Part, shape: Plate, _loads: PartLoads, kind: str) -> str:
    """Levers that go straight on and bent ones scatter each in their own way."""
    if part.shape != "lever":
        return "drawn plate"
    return "bent lever" if shape.bend > _BENT else "lever"


def _add_arms(points: Points, forces: PlateForces) -> bool:
    """Add fibres of the sections between neighbours; whether all of them have a straight way."""
    shape = forces.shape
    for i, j in shape.neighbours:
        first, last = shape.bores[i], shape.bores[j]
        way = (last.centre - first.centre) / abs(last.centre - first.centre)
        ends = (first.centre + way * first.diameter / 2, last.centre - way * last.diameter / 2)
        for share in (np.arange(_STATIONS) + 0.5) / _STATIONS:
            cut = shape.outline.cut(ends[0] + share * (ends[1] - ends[0]), way)
            if cut is None:
                return False
            section = FlatSection(cut, shape.thickness)
            if not forces.met(section):
                ahead = forces.is_ahead(section)
                _add_fibres(points, forces, section, ahead, f"arm {first.name} to {last.name}")
    return True


def _add_fibres(
    points: Points, forces: PlateForces, section: FlatSection, ahead: Mapping[str, float], name: str
) -> None:
    """Add the ends of a section's spans, and the middle of its highest with the largest shear."""
    axial, shear, moment = forces.across(section, ahead)
    spans = section.cut.spans
    highest = spans[int(np.argmax(np.diff(spans, axis=1)[:, 0]))]
    at = np.r_[spans.ravel(), highest.mean()]
    along = axial / section.area - np.outer(at - section.middle, moment) / section.inertia
    sheared = np.zeros_like(along)
    sheared[-1] = 1.5 * shear / section.area
    places = np.asarray(section.cut.point + 1j * section.cut.along * at)
    _add(points, forces, name, places, directed(section.cut.along, along, sheared))


def _add(
    points: Points, forces: PlateForces, name: str, places: ComplexArray, stress: FloatArray
) -> None:
    """Add points x + i y (k,) of the middle plane with stress (k, columns, 6)."""
    at = np.column_stack([places.real, places.imag, np.zeros(len(places))])
    points.add_block(name, at, forces.columns, np.moveaxis(stress, 2, 1))


def _add_bore(part: Part, points: Points, forces: PlateForces, bore: PlateBore) -> None:
    """Add a bore's rim: the lug that holds its pin, and what the arms pass on past it.

    At an end the arm holds the lug. Between two arms the one holds it and the other passes on
    through it, along the mean of their ways; where they bend, the pin may as well pull away from
    both, and then they hold it together as one shank on the inner side of the bend.
    """
    shape, middle, thickness = forces.shape, bore.centre, forces.shape.thickness
    ways = _ways(shape, bore)
    if len(ways) == 1:
        angles = _from(ways[0])
        lug = _lug(part, forces, bore, ways[0], angles, round_end=True)
        columns = bore_columns(
            points, part, forces.loads, bore.name, lug[:, _PLANE], angles, thickness
        )
        _add_rim(points, forces, bore, columns, angles, lug, None)
        return
    mean = (ways[0] - ways[1]) / abs(ways[0] - ways[1])
    inner = ways[0] + ways[1]
    cut = shape.outline.cut(middle, mean)
    assert cut is not None, "a bore's middle is inside of the outer contour"
    section = FlatSection(cut, shape.thickness)
    angles = _from(mean)
    passing = _passing(forces, section, bore, 1.0, angles)
    lug = _lug(part, forces, bore, mean, angles, round_end=False)
    columns = bore_columns(
        points, part, forces.loads, bore.name, lug[:, _PLANE], angles, thickness,
        (forces.columns, passing[:, _PLANE]),
    )  # fmt: skip
    _add_rim(points, forces, bore, columns, angles, lug, passing)
    if abs(inner) > _STRAIGHT:
        angles = _from(inner)
        lug = _lug(part, forces, bore, inner / abs(inner), angles, round_end=True)
        arch = _Arch.of(shape, bore)
        crown = np.maximum(np.cos(angles - phase(-inner)), 0.0)
        passing = _passing(forces, section, bore, 0.5, angles)
        passing *= (1 - (1 - arch.share) * crown**2)[:, None, None]
        passing += _straightened(forces, section, bore, arch, inner / abs(inner), angles)
        _add_rim(points, forces, bore, columns, angles, lug, passing)
    for share in (0.0, 1.0):
        ahead = forces.is_ahead(section) | {bore.name: share}
        _add_fibres(points, forces, section, ahead, f"beside the bore {bore.name}")


def _from(along: complex) -> FloatArray:
    """Angles of a rim, rad, from a direction of the plate: the same places in any axes."""
    angles: FloatArray = ANGLES + phase(along)
    return angles


@dataclass(frozen=True)
class _Arch:
    """The ligament on the outer side of a bend at a bore: an arch of the bend's angle, two-hinged.

    radius  mm, of the bore
    width   mm, of the ligament
    half    rad, half of the bend
    """

    radius: float
    width: float
    half: float

    @classmethod
    def of(cls, shape: Plate, bore: PlateBore) -> "_Arch":
        """The arch at a bore; its `half` is 0 where one arm ends, or two go straight on."""
        ways = _ways(shape, bore)
        inner = ways[0] + ways[1] if len(ways) == 2 else 0j
        if abs(inner) < _STRAIGHT:
            return cls(bore.diameter / 2, bore.diameter, 0.0)
        width = shape.outline.reach(bore.centre, -inner / abs(inner)) - bore.diameter / 2
        return cls(bore.diameter / 2, width, abs(phase(-ways[1] / ways[0])) / 2)

    @property
    def middle(self) -> float:
        """Radius of its middle line, mm."""
        return self.radius + self.width / 2

    @property
    def rise(self) -> float:
        """Rise of its middle line above its chord, mm."""
        return self.middle * (1 - float(np.cos(self.half)))

    @property
    def share(self) -> float:
        """Its stiffness along its chord over a straight bar's."""
        if not self.half:
            return 1.0
        a, s, c = self.half, float(np.sin(self.half)), float(np.cos(self.half))
        bent = (a * (1 + 2 * c**2) - 3 * s * c) / (2 * a)
        return 1 / (1 + 12 * (self.middle / self.width) ** 2 * bent)


def _straightened(
    forces: PlateForces,
    section: FlatSection,
    bore: PlateBore,
    arch: _Arch,
    inner: complex,
    angles: FloatArray,
) -> FloatArray:
    """Stress (k, 6, columns) at angles of what bends the ligament on the outer side of a bend.

    Its force N pulls the arch straight: N times its rise bends its crown, more at the bore as in a
    curved bar.

    inner  unit vector to the inner side of the bend
    """
    axial, _, moment = forces.across(section, forces.is_ahead(section) | {bore.name: 0.5})
    out = bore.centre - inner * arch.middle - section.cut.point
    at = (out / section.cut.along).imag
    even = axial / section.area - moment * (at - section.middle) / section.inertia
    crown = np.cos(angles - phase(-inner))
    share = np.where(crown > 0, np.maximum(2 * crown**2 - 1, 0.0), 0.0)
    bent = 6 * arch.rise / arch.width * curved_bar(arch.width, arch.radius)
    return _hoop(np.outer(share, even) * arch.share * bent, angles)


def _ways(shape: Plate, bore: PlateBore) -> list[complex]:
    """Unit vectors from a bore to its neighbours."""
    number = shape.bores.index(bore)
    others = (
        shape.bores[pair[1 - pair.index(number)]].centre
        for pair in shape.neighbours
        if number in pair
    )
    return [(other - bore.centre) / abs(other - bore.centre) for other in others]


def _lug(
    part: Part,
    forces: PlateForces,
    bore: PlateBore,
    along: complex,
    angles: FloatArray,
    *,
    round_end: bool,
) -> FloatArray:
    """Stress (k, 6, 8) at angles of a lug's rim, by patterns of the pin's pressure.

    along  to where it is held
    """
    shape, harmonics = forces.shape, harmonics_of(forces.loads.arc)
    middle, radius = bore.centre, bore.diameter / 2
    beside, further = (
        min(shape.outline.reach(at, along * side) for side in (1j, -1j))
        for at in (middle, middle + radius * along)
    )
    half = (beside + further) / 2 if round_end and further > radius else beside
    behind = min(shape.outline.reach(middle, -along), 2 * BESIDE * half)
    end = None if round_end and abs(behind / half - 1) < _ROUND else behind
    outline = strip_outline(half, end, max(2 * BESIDE * half, 1.5 * radius))
    found = pin_loaded_hole(radius, outline, part.material.poisson_ratio, harmonics)
    own = np.zeros((len(angles), 6, len(found.patterns)))
    turn = phase(along)
    rim = radius * np.exp(1j * (angles - turn))
    own[:, [0, 1, 3]] = Lug(found, shape.thickness).stress(rim)
    basis = own.copy()
    for n in harmonics:
        if n:
            cosine, sine = found.patterns.index(f"cos {n}"), found.patterns.index(f"sin {n}")
            c, s = np.cos(n * turn), np.sin(n * turn)
            basis[:, :, cosine] = c * own[:, :, cosine] - s * own[:, :, sine]
            basis[:, :, sine] = s * own[:, :, cosine] + c * own[:, :, sine]
    return _turned(basis, along)


def _add_rim(
    points: Points,
    forces: PlateForces,
    bore: PlateBore,
    columns: tuple[list[int], list[int]],
    angles: FloatArray,
    lug: FloatArray,
    passing: FloatArray | None,
) -> None:
    """Add the rim with the stress of its lug and of what passes it; columns as `bore_columns`."""
    pressed, patterns = columns
    lug = lug[:, :, patterns]
    at = bore.centre + bore.diameter / 2 * np.exp(1j * angles)
    places = np.column_stack([at.real, at.imag, np.zeros(len(at))])
    if passing is None:
        points.add_block(bore.name, places, pressed, lug)
        return
    points.add_block(
        bore.name, places, [*pressed, *forces.columns], np.concatenate([lug, passing], axis=2)
    )


def _passing(
    forces: PlateForces, section: FlatSection, bore: PlateBore, share: float, angles: FloatArray
) -> FloatArray:
    """Stress (k, 6, columns) at angles of a bore's rim, of what the arms pass on past it.

    share  of the pin's own force that is counted to the arm ahead
    """
    filled, along = section.filled(), section.cut.along
    axial, shear, moment = forces.across(filled, forces.is_ahead(section) | {bore.name: share})
    at = (bore.centre - section.cut.point) / along
    even = axial / filled.area - moment * (at.imag - filled.middle) / filled.inertia
    rate = -moment / filled.inertia * bore.diameter / 2
    sheared = 1.5 * shear / filled.area
    width = 2 * min(forces.shape.outline.reach(bore.centre, along * side) for side in (1j, -1j))
    waves = open_hole(angles - phase(along), bore.diameter / width)
    hoop = waves @ np.stack([even, rate, sheared])
    return _hoop(hoop, angles)


def _hoop(hoop: FloatArray, angles: FloatArray) -> FloatArray:
    """Stress (k, 6, columns) of a hoop stress (k, columns) at angles."""
    s, c = np.sin(angles)[:, None], np.cos(angles)[:, None]
    found = np.zeros((len(angles), 6, hoop.shape[1]))
    found[:, 0], found[:, 1], found[:, 3] = hoop * s**2, hoop * c**2, -hoop * s * c
    return found


def _turned(basis: FloatArray, along: complex) -> FloatArray:
    """Stress (k, 6, m) of a plane state from axes turned by `along` to those of the plate."""
    c, s = along.real, along.imag
    xx, yy, xy = basis[:, 0], basis[:, 1], basis[:, 3]
    found = np.zeros_like(basis)
    found[:, 0] = xx * c**2 + yy * s**2 - 2 * xy * s * c
    found[:, 1] = xx * s**2 + yy * c**2 + 2 * xy * s * c
    found[:, 3] = (xx - yy) * s * c + xy * (c**2 - s**2)
    return found


def _add_window(points: Points, forces: PlateForces, middle: complex, radius: float) -> None:
    """Add the rim of a round hole without a pin, across the nearest line between bores."""
    shape = forces.shape
    lines = [(shape.bores[i].centre, shape.bores[j].centre) for i, j in shape.neighbours]
    first, last = min(lines, key=lambda line: _distance(middle, *line))
    along = (last - first) / abs(last - first)
    cut = shape.outline.cut(middle, along)
    if cut is None:
        return
    own = PlateBore("", 2 * radius, (middle.real, middle.imag))
    angles = _from(along)
    basis = _passing(forces, FlatSection(cut, shape.thickness), own, 0.0, angles)
    at = middle + radius * np.exp(1j * angles)
    places = np.column_stack([at.real, at.imag, np.zeros(len(at))])
    points.add_block("round window", places, forces.columns, basis)


def _distance(point: complex, first: complex, last: complex) -> float:
    way = last - first
    share = ((point - first) * way.conjugate()).real / abs(way) ** 2
    return abs(point - first - min(max(share, 0.0), 1.0) * way)


def _add_hollow_edges(points: Points, forces: PlateForces) -> None:
    """Add hollow edges of the outer contour: sections along their radii, as of a curved bar."""
    shape = forces.shape
    for middle, centre, turn in shape.hollow_edges(_ON_ARC):
        radius = abs(middle - centre)
        inward = (middle - centre) / radius
        cut = shape.outline.cut(middle + 1e-6 * radius * inward, -1j * inward)
        if cut is None:
            continue
        section = FlatSection(cut, shape.thickness)
        turned = max(radius, _LEAST_ARC * (cut.ends[1] - cut.ends[0]) / turn)
        met = forces.met(section)
        near = min(shape.bores, key=lambda bore: abs(bore.centre - middle))
        beyond = ((near.centre - cut.point) * np.conj(cut.along)).imag
        outside = (cut.spans.mean(axis=1) > beyond) & (near.name in met)
        part = np.where(outside, _Arch.of(shape, near).share, 1.0)
        curved = CurvedSection(cut.spans + turned, part * shape.thickness)
        shifted = curved.centroid - turned - section.middle
        at = cut.spans.ravel()
        for shares in product((0.0, 1.0), repeat=len(met)):
            ahead = forces.is_ahead(section) | dict(zip(met, shares, strict=True))
            axial, _, moment = forces.across(section, ahead)
            along = curved.stress(at + turned) @ np.stack([axial, moment + axial * shifted])
            along *= np.repeat(part, 2)[:, None]
            places = np.asarray(cut.point + 1j * cut.along * at)
            stresses = directed(cut.along, along, np.zeros_like(along))
            _add(points, forces, f"hollow edge beside {near.name}", places, stresses)


MODEL = ShapeModel(Plate, stress, family=family, press_fits=True, arcs=True)
