"""A part as a straight bar: its cross sections along x, with holes filled or taken out.

A `Section` is one of a part that may buckle.

With the section properties of rolled and hollow profiles, roundings included.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from itertools import pairwise
from math import pi
from typing import Literal

import numpy as np

from geometry.mesh import FloatArray

Holes = Sequence[tuple[float, float]]
_ALIKE = 0.03  # of an area or a second moment: sections of one stretch
BESIDE = 1.25  # widths from a hole's axis to where a bar's stress is that of its section again


@dataclass(frozen=True)
class RulingSection:
    """Size of what a part is made from, by which standards grade strengths.

    size   mm, thickness of what is flat, diameter of what is round
    round  True for a round bar
    """

    size: float
    round: bool = False


@dataclass(frozen=True)
class Section:
    """A cross-section along a part in compression.

    name                  as reports call it
    area                  mm2
    inertia_in_plane      mm4, bending in the plane of the linkage (about z)
    inertia_out_of_plane  mm4, bending out of it (about y)
    length                mm, effective length in plane; None for the whole part's
    length_out_of_plane   mm, effective length out of plane; None for the whole part's
    depth_in_plane        mm, outer size in the plane of the linkage, along y
    depth_out_of_plane    mm, outer size out of it, along z
    stretch               mm, from where to where along x the part has it; None for all along
    inertia_built_up      mm4, about y, of plates that the pin makes bend together out of the plane
                          as a part of the whole column; None for `inertia_out_of_plane`
    racking_area          mm2, E times it is the shear stiffness out of plane of such plates, which
                          bend in S shape between the tube and the pin; None without shear strain
    """

    name: str
    area: float
    inertia_in_plane: float
    inertia_out_of_plane: float
    length: float | None = None
    length_out_of_plane: float | None = None
    depth_in_plane: float = field(kw_only=True)
    depth_out_of_plane: float = field(kw_only=True)
    stretch: tuple[float, float] | None = field(default=None, kw_only=True)
    inertia_built_up: float | None = field(default=None, kw_only=True)
    racking_area: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.stretch is not None and not self.stretch[0] < self.stretch[1]:
            raise ValueError(
                f"section {self.name!r} stretches from {self.stretch[0]:g} mm, to "
                f"{self.stretch[1]:g} mm"
            )


def stretches(
    places: FloatArray, values: FloatArray, depths: FloatArray, length: float
) -> list[Section]:
    """Stretches of a bar from 0 to its length, each with the least of its sections.

    places  (n,) mm, rising
    values  (n, 3) area, mm2, and second moments in the plane and out of it, mm4
    depths  (n, 2) mm, outer size in the plane and out of it

    One ends where area or a second moment has changed by `_ALIKE`. The first and the last reach to
    the pins.
    """
    found: list[Section] = []
    start, first = 0.0, 0
    for k in range(1, len(places) + 1):
        if k < len(places):
            group = values[first : k + 1]
            if (group.max(axis=0) <= (1 + _ALIKE) * group.min(axis=0)).all():
                continue
        stop = float(places[k - 1] + places[k]) / 2 if k < len(places) else length
        area, inertia, across = values[first:k].min(axis=0)
        within, beside = depths[first:k].max(axis=0)
        found.append(
            Section(
                f"section from x = {start:.4g} to {stop:.4g} mm",
                float(area),
                float(inertia),
                float(across),
                depth_in_plane=float(within),
                depth_out_of_plane=float(beside),
                stretch=(start, stop),
            )
        )
        start, first = stop, k
    return found


@dataclass(frozen=True)
class Walls:
    """A stretch of a part with one section, across which a weld may run all round.

    outline  "round": tube or bar, "rectangular": tube, "flat": rectangular bar, "I"
    size     mm, outer diameter or height in the linkage's plane
    wall     mm, thickness of the thickest wall, or of the flat bar; of a solid round bar its
             diameter
    stretch  mm, from where to where along x
    section  whose area and second moments count there
    corner   mm, outer radius of a rectangular tube's corners
    shear    1/mm2, of an I section: largest shear stress per N of shear force
    torsion  mm4, of an I section: Saint-Venant's constant
    warping  mm6, of an I section: flanges that bend against each other as it twists
    across   of a plate: a point of the section, x + i y in mm, and the unit vector normal to it
    """

    outline: Literal["round", "rectangular", "flat", "I"]
    size: float
    wall: float
    stretch: tuple[float, float]
    section: Section
    corner: float = 0.0
    shear: float = 0.0
    torsion: float = 0.0
    warping: float = 0.0
    across: tuple[complex, complex] | None = None


@dataclass(frozen=True, eq=False)
class Sections:
    """Stiffness properties of sections, each of any shape that broadcasts to (m, 6).

    area          mm2
    inertia_y     mm4, second moment about local y: bending along z
    inertia_z     mm4, about local z: bending along y
    torsion       mm4, Saint-Venant's constant
    shear_area_y  mm2, shear coefficient times area; infinite: no shear deflection along y
    shear_area_z  mm2, the same along z
    """

    area: FloatArray
    inertia_y: FloatArray
    inertia_z: FloatArray
    torsion: FloatArray
    shear_area_y: FloatArray
    shear_area_z: FloatArray

    def __post_init__(self) -> None:
        for one in fields(self):
            value = np.asarray(getattr(self, one.name))
            if not (value > 0).all():
                worst = float(value.ravel()[np.argmin(value > 0)])
                raise ValueError(f"a section's {one.name} must be above 0, got {worst}")
            if not one.name.startswith("shear") and not np.isfinite(value).all():
                raise ValueError(f"a section's {one.name} must be finite")

    def broadcast(self, shape: tuple[int, int]) -> "Sections":
        """Return the same sections with every array of this shape."""
        try:
            return Sections(*(np.broadcast_to(getattr(self, f.name), shape) for f in fields(self)))
        except ValueError as error:
            raise ValueError(f"sections do not fit {shape[0]} members: {error}") from error


def rectangle(
    height: FloatArray | float, width: FloatArray | float, *, shear_coefficient: float = 5 / 6
) -> Sections:
    """Rectangles of `height` along local y and `width` along local z, mm.

    An infinite shear coefficient gives Euler's and Bernoulli's beam.
    """
    height, width = np.broadcast_arrays(
        np.asarray(height, dtype=float), np.asarray(width, dtype=float)
    )
    area = height * width
    return Sections(
        area=area,
        inertia_y=height * width**3 / 12,
        inertia_z=width * height**3 / 12,
        torsion=rectangle_torsion(height, width)[0],
        shear_area_y=shear_coefficient * area,
        shear_area_z=shear_coefficient * area,
    )


def rectangle_torsion(
    height: FloatArray | float, width: FloatArray | float
) -> tuple[FloatArray, FloatArray]:
    """Torsion constant of rectangles, mm4, and torque per peak shear stress, mm3.

    Saint-Venant's series (Timoshenko and Goodier, Theory of Elasticity, 3rd ed., section 109): with
    the longer side b and the shorter t, over odd n,

        J = b t^3 (1/3 - 64 t / (pi^5 b) sum tanh(n pi b / 2 t) / n^5)
        J / W = t (1 - 8 / pi^2 sum 1 / (n^2 cosh(n pi b / 2 t)))

    The peak stands in the middle of the longer side.

    >>> [round(float(x), 9) for x in rectangle_torsion(1.0, 1.0)]
    [0.140577015, 0.20816526]
    """
    height, width = np.asarray(height, dtype=float), np.asarray(width, dtype=float)
    if not (height > 0).all() or not (width > 0).all():
        raise ValueError("a rectangle's height and width must be above 0 mm")
    long, short = np.maximum(height, width), np.minimum(height, width)
    odd = np.arange(1.0, 400.0, 2.0)
    angle = np.minimum(odd * np.pi / 2 * (long / short)[..., None], 700.0)
    rest = np.tanh(angle) - 1  # the sum of 1/n^5 itself is 31 zeta(5) / 32
    sums = 31 / 32 * 1.0369277551433699 + (rest / odd**5).sum(axis=-1)
    constant = long * short**3 * (1 / 3 - 64 * short / (np.pi**5 * long) * sums)
    peak = short * (1 - 8 / np.pi**2 * (1 / np.cosh(angle) / odd**2).sum(axis=-1))
    return np.asarray(constant), np.asarray(constant / peak)


def round_tube(diameter: FloatArray | float, bore: FloatArray | float = 0.0) -> Sections:
    """Round bars and tubes, mm; shear coefficients from 6/7 (no bore) to 1/2 (thin wall).

    The coefficient is Cowper's (J. Appl. Mech. 33 (1966) 335) with nu = 0: 6 (1 + m^2)^2 /
    (7 (1 + m^2)^2 + 20 m^2) for a bore of m diameters.
    """
    diameter, bore = np.asarray(diameter, dtype=float), np.asarray(bore, dtype=float)
    if not (bore >= 0).all() or not (bore < diameter).all():
        raise ValueError("a tube's bore must be at least 0 and less than its diameter")
    area = np.pi / 4 * (diameter**2 - bore**2)
    inertia = np.pi / 64 * (diameter**4 - bore**4)
    ratio = (bore / diameter) ** 2
    shear = 6 * (1 + ratio) ** 2 / (7 * (1 + ratio) ** 2 + 20 * ratio) * area
    return Sections(area, inertia, inertia, 2 * inertia, shear, shear)


def square_tube(width: float, wall: float, area: float, inertia: float) -> Sections:
    """Square tubes, mm: Bredt's torsion, shear coefficient 20/48 of a thin box.

    The coefficient is Cowper's (J. Appl. Mech. 33 (1966) 335) with nu = 0. Area, mm2, and second
    moment, mm4, count the fillets inside.
    """
    torsion = wall * (width - wall) ** 3
    values = (area, inertia, inertia, torsion, 20 / 48 * area, 20 / 48 * area)
    return Sections(*(np.array(value) for value in values))


@dataclass(frozen=True, eq=False)
class Bar:
    """A part as a straight bar along its x axis.

    cuts  (k,) mm, rising: its ends and where its section changes its kind
    at    sections at places x (m, 6), mm, none of which is on a cut
    """

    cuts: tuple[float, ...]
    at: Callable[[FloatArray], Sections]

    @property
    def main(self) -> tuple[float, float]:
        """Its longest stretch, mm: from where to where."""
        return max(pairwise(self.cuts), key=lambda one: one[1] - one[0])

    def stations(self, pieces: int, places: Sequence[float] = ()) -> list[float]:
        """Ends of members between the cuts and `places`, the longest stretch in `pieces`, mm."""
        ends = sorted({*self.cuts, *(x for x in places if self.cuts[0] < x < self.cuts[-1])})
        start, stop = self.main
        least = (stop - start) / pieces * (1 + 1e-9)
        stations = [ends[0]]
        for start, stop in pairwise(ends):
            count = int(np.ceil((stop - start) / least))
            stations += np.linspace(start, stop, count + 1)[1:].tolist()
        return stations


def even(sections: Sections, start: float, stop: float) -> Bar:
    """A bar of one section all along."""
    return Bar((start, stop), lambda x: sections.broadcast((x.shape[0], x.shape[1])))


def chord(x: FloatArray, holes: Holes) -> FloatArray:
    """Height (mm) that holes (centre, radius) along z take away at places x, mm."""
    taken = np.zeros(np.shape(x))
    for centre, radius in holes:
        taken += 2 * np.sqrt(np.maximum(radius**2 - (x - centre) ** 2, 0.0))
    return taken


def bored(
    sections: Sections, taken: FloatArray, height: FloatArray | float, depth: FloatArray | float
) -> Sections:
    """Sections less a hole along z of chord `taken`; `height` and `depth` of the solid, mm."""
    left = 1 - taken / height
    return Sections(
        sections.area - taken * depth,
        sections.inertia_y - taken * depth**3 / 12,
        sections.inertia_z - depth * taken**3 / 12,
        sections.torsion * left,
        sections.shear_area_y * left,
        sections.shear_area_z * left,
    )


def square_tube_section(name: str, width: float, wall: float, inner_radius: float) -> Section:
    """Return a square tube; the inner corners' fillets count in area and, at their place, in I.

    >>> square_tube_section("tube", 30.0, 1.6, 0.0).inertia_in_plane
    24510.941...
    """
    inner = width - 2 * wall
    fillet = (1 - 3.141592653589793 / 4) * inner_radius**2
    arm = inner / 2 - 0.2234 * inner_radius  # centroid of a spandrel: 0.2234 r from its walls
    inertia = (width**4 - inner**4) / 12 + 4 * fillet * arm**2
    return Section(
        name,
        width**2 - inner**2 + 4 * fillet,
        inertia,
        inertia,
        depth_in_plane=width,
        depth_out_of_plane=width,
    )


def round_tube_section(name: str, diameter: float, bore: float) -> Section:
    """Return a round tube; a bore of 0 is a solid bar.

    >>> round_tube_section("tube", 20.0, 15.0).area
    137.44...
    """
    inertia = pi * (diameter**4 - bore**4) / 64
    return Section(
        name,
        pi * (diameter**2 - bore**2) / 4,
        inertia,
        inertia,
        depth_in_plane=diameter,
        depth_out_of_plane=diameter,
    )


def plate_section(name: str, height: float, thickness: float) -> Section:
    """Return one flat plate, `height` in the plane of the linkage."""
    return Section(
        name,
        height * thickness,
        thickness * height**3 / 12,
        height * thickness**3 / 12,
        depth_in_plane=height,
        depth_out_of_plane=thickness,
    )


def plate_pair_section(
    name: str, height: float, wall: float, length: float, apart: float
) -> Section:
    """Two plates with their middles `apart`, `height` in the linkage's plane, free over `length`.

    In the plane they bend together between pin and tube. Out of it nothing keeps their ends from
    splaying apart or folding: each is a cantilever, of twice its free length.

    As a part of the whole column they carry its moment by pushing and pulling, A apart^2/4, and its
    shear by bending, hinged at the pin: the shear stiffness is 2 x 3 E I/length^2, I of one plate.
    """
    one = height * wall**3 / 12
    return Section(
        name,
        2 * height * wall,
        2 * wall * height**3 / 12,
        2 * one,
        length,
        2 * length,
        depth_in_plane=height,
        depth_out_of_plane=apart + wall,
        inertia_built_up=2 * (one + height * wall * (apart / 2) ** 2),
        racking_area=6 * one / length**2,
    )


def fine_cells(cuts: FloatArray, count: int) -> FloatArray:
    """Cuts of cells of about 1/count of the whole, none across one of the given cuts."""
    size = (cuts[-1] - cuts[0]) / count
    pieces = [
        np.linspace(a, b, max(1, int(np.ceil((b - a) / size))) + 1)[:-1] for a, b in pairwise(cuts)
    ]
    return np.concatenate([*pieces, cuts[-1:]])


@dataclass(frozen=True)
class Profile:
    """A beam's profile away from its bosses.

    section    with area and second moments
    sections   stiffnesses, of which shear areas are those of thin walls
    shear      1/mm2, shear stress in the middle of its height per N of shear force
    webs       mm, thickness of all webs together
    warping    mm6: flanges that bend against each other as the section twists
    """

    section: Section
    sections: Sections
    shear: float
    webs: float
    warping: float = 0.0


def hollow_profile(height: float, width: float, wall: float, corner: float) -> Profile:
    """Rectangular hollow section, mm: exact areas, Bredt's torsion along the walls' middle.

    corner  outer radius; the inner one is a wall less
    """
    h, w, t = height, width, wall
    inner = max(corner - t, 0.0)
    outside, inside = rounded(h, w, corner), rounded(h - 2 * t, w - 2 * t, inner)
    area, about_z, about_y = (o - i for o, i in zip(outside, inside, strict=True))
    middle = (corner + inner) / 2 if corner else 0.0
    around = 2 * (h + w - 2 * t) - (8 - 2 * pi) * middle
    enclosed = (h - t) * (w - t) - (4 - pi) * middle**2
    torsion = 4 * enclosed**2 * t / around + around * t**3 / 3
    shear_y, shear_z = (5 / 6 * area * side / (h + w) for side in (h, w))
    values = (area, about_y, about_z, torsion, shear_y, shear_z)
    # first moment of the half above y = 0, without the corners' roundings
    half = (w * h**2 - (w - 2 * t) * (h - 2 * t) ** 2) / 8
    return Profile(
        _section("hollow section", area, about_z, about_y, h, w),
        Sections(*(np.array(value) for value in values)),
        half / (2 * t * about_z),
        2 * t,
    )


def i_profile(height: float, width: float, web: float, flange: float, root: float) -> Profile:
    """I section, mm: exact areas, torsion with the circles at web and flanges.

    The torsion constant adds to thin strips the circles inscribed where web and flanges meet; its
    source was not opened, and the printed 0.70 cm4 of IPE 80 is what it has. Flanges h - f apart,
    each of half of I_y, have E I_y/2 ((h - f)/2 t'')^2 as energy of a twist t: warping I_y
    (h - f)^2/4.
    """
    h, b, s, f, r = height, width, web, flange, root
    inner = h - 2 * f
    corner, first, second = _spandrel(r)
    area = 2 * b * f + inner * s + 4 * corner
    about_z = (b * h**3 - (b - s) * inner**3) / 12
    about_z += 4 * (corner * inner**2 / 4 - first * inner + second)
    about_y = (2 * f * b**3 + inner * s**3) / 12
    about_y += 4 * (corner * s**2 / 4 + first * s + second)
    circle = ((r + s / 2) ** 2 + (r + f) ** 2 - r**2) / (2 * r + f)
    torsion = 2 / 3 * (b - 0.63 * f) * f**3 + inner * s**3 / 3
    torsion += 2 * s / f * (0.145 + 0.1 * r / f) * circle**4
    shear_y, shear_z = _shear_area(h, b, s, f), 5 / 6 * 2 * b * f
    values = (area, about_y, about_z, torsion, shear_y, shear_z)
    half = b * f * (h - f) / 2 + s * inner**2 / 8 + 2 * (corner * inner / 2 - first)
    return Profile(
        _section("I section", area, about_z, about_y, h, b),
        Sections(*(np.array(value) for value in values)),
        half / (s * about_z),
        s,
        about_y * (h - f) ** 2 / 4,
    )


def _shear_area(height: float, width: float, web: float, flange: float) -> float:
    """I^2 over the integral of S^2/t along the thin walls of an I section, mm2; no roots.

    In the web S = b t_f h_m/2 + s (c^2 - y^2)/2 up to c at the flanges, in these t_f z h_m/2. Wide
    flanges take 1 % (IPE 80) to 6 % (HEA 200) of the web's area s h_m away.
    """
    c, apart = height / 2 - flange, height - flange
    inertia = (width * height**3 - (width - web) * (2 * c) ** 3) / 12
    first = width * flange * apart / 2
    energy = 2 * (first**2 * c + 2 / 3 * first * web * c**3 + 2 / 15 * web**2 * c**5) / web
    energy += flange * apart**2 * width**3 / 24
    return inertia**2 / energy


def rounded(height: float, width: float, radius: float) -> tuple[float, float, float]:
    """Area, mm2, and second moments, mm4, about z and about y of a rectangle with round corners.

    >>> [round(value, 9) for value in rounded(2.0, 2.0, 1.0)]
    [3.141592654, 0.785398163, 0.785398163]
    """
    corner, first, second = _spandrel(radius)
    h, w = height / 2, width / 2
    return (
        height * width - 4 * corner,
        width * height**3 / 12 - 4 * (corner * h**2 - 2 * h * first + second),
        height * width**3 / 12 - 4 * (corner * w**2 - 2 * w * first + second),
    )


def _spandrel(radius: float) -> tuple[float, float, float]:
    """Area between two walls square to each other and a fillet, and its moments from one wall."""
    r = radius
    return r**2 * (1 - pi / 4), r**3 * (5 / 6 - pi / 4), r**4 * (1 - 5 * pi / 16)


def _section(
    name: str, area: float, about_z: float, about_y: float, height: float, width: float
) -> Section:
    return Section(name, area, about_z, about_y, depth_in_plane=height, depth_out_of_plane=width)
