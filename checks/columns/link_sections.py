"""Stiffness of a part against bending, twist and shear along its axis, as a bar of a linkage.

Sections are taken without the bores: a pin fills them, and in compression its force enters beyond.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from checks.design.data import Part
from fem.frame import Frame, gauss_points
from fem.frame_joints import chain
from fem.frame_sections import Sections, rectangle, round_tube
from fem.unit_solutions import Elastic
from geometry.mesh import FloatArray
from geometry.parts import LeafPack, PlateLink, PrismaticTube, ToggleBar, TubeRod
from geometry.sections import square_tube_section

_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Bar:
    """A part as a straight bar along its x axis.

    material
    cuts     (k,) mm, rising: its ends and where its section changes its kind
    main     number of the stretch that is cut most finely
    at       sections at places x (m, 6), mm, none of which is on a cut
    """

    material: Elastic
    cuts: tuple[float, ...]
    main: int
    at: Callable[[FloatArray], Sections]

    def frame(self, pieces: int, places: Sequence[float] = ()) -> Frame:
        """Members between the cuts and `places`, the longest stretches in at least `pieces`."""
        ends = sorted({*self.cuts, *(x for x in places if self.cuts[0] < x < self.cuts[-1])})
        least = (self.cuts[self.main + 1] - self.cuts[self.main]) / pieces * (1 + 1e-9)
        stations: list[float] = [ends[0]]
        for start, end in pairwise(ends):
            count = int(np.ceil((end - start) / least))
            stations += list(np.linspace(start, end, count + 1)[1:])
        nodes = np.zeros((len(stations), 3))
        nodes[:, 0] = stations
        members = chain(len(stations))
        x = gauss_points(nodes, members)[..., 0]
        return Frame(nodes, members, _UP, self.at(x), self.material)

    def bending_at_middle(self, plane: str) -> float:
        """E I in the middle of the longest stretch, N mm2, "in plane" or out of it."""
        middle = (self.cuts[self.main] + self.cuts[self.main + 1]) / 2
        sections = self.at(np.full((1, 6), middle))
        inertia = sections.inertia_z if plane == "in plane" else sections.inertia_y
        return float(self.material.youngs_modulus * np.ravel(inertia)[0])


def bar_of(part: Part) -> Bar | None:
    """A part as a bar from its first interface to its second; None for one that is no bar."""
    shape, steel = part.geometry, part.material
    material = Elastic(steel.youngs_modulus, steel.poisson_ratio, steel.density)
    match shape:
        case PrismaticTube():
            cuts: Sequence[float] = (0.0, shape.length)
            tube = square_tube_section("tube", shape.width, shape.wall, shape.inner_radius)
            at = _even(_square_tube(tube.area, tube.inertia_in_plane, shape.width, shape.wall))
        case ToggleBar():
            free = shape.cutout_length - shape.overhang
            cuts = (0.0, free, shape.length) if 0 < free < shape.length else (0.0, shape.length)
            at = _toggle_bar(shape, material)
        case TubeRod():
            cuts = (0.0, shape.length)
            bore = 0.0 if shape.wall is None else shape.tube_diameter - 2 * shape.wall
            at = _even(round_tube(shape.tube_diameter, bore))
        case PlateLink():
            cuts = (0.0, shape.length)
            at = _even(rectangle(shape.width, shape.thickness))
        case LeafPack():
            cuts = (-shape.arm, 0.0, shape.length)
            at = _even(_leaves(shape))
        case _:
            return None
    lengths = np.diff(cuts)
    return Bar(material, tuple(float(x) for x in cuts), int(np.argmax(lengths)), at)


def _even(sections: Sections) -> Callable[[FloatArray], Sections]:
    return lambda x: sections.broadcast((x.shape[0], x.shape[1]))


def _square_tube(area: float, inertia: float, width: float, wall: float) -> Sections:
    """Bredt's torsion; shear coefficient 20/48 of a thin square box (Cowper 1966, nu = 0)."""
    torsion = wall * (width - wall) ** 3
    values = (area, inertia, inertia, torsion, 20 / 48 * area, 20 / 48 * area)
    return Sections(*(np.array(value) for value in values))


def _toggle_bar(shape: ToggleBar, material: Elastic) -> Callable[[FloatArray], Sections]:
    """A tube, and its cheeks alone beside the cut-out at the knee.

    The cheeks alone carry out-of-plane bending by pushing and pulling, as the pin makes them turn
    together, and the shear by their own bending, hinged at the pin. Without an axial force their
    shear stiffness were 6 E I/free^2; they sway aside under pi^2/2 E I/free^2, I of one cheek, and
    the bar buckles where its force is its shear stiffness, so this lower one is taken.
    """
    tube = square_tube_section("tube", shape.width, shape.wall, shape.inner_radius)
    whole = _square_tube(tube.area, tube.inertia_in_plane, shape.width, shape.wall)
    free = shape.cutout_length - shape.overhang
    if not free > 0:
        return _even(whole)
    beside = (shape.width - shape.wall) / 2
    cheek = rectangle(shape.width, shape.wall)
    ratio = 2 * (1 + material.poisson_ratio)  # E/G
    sway = np.pi**2 / 2 * ratio * cheek.inertia_y / free**2
    cheeks = Sections(
        area=2 * cheek.area,
        inertia_y=2 * (cheek.area * beside**2 + cheek.inertia_y),
        inertia_z=2 * cheek.inertia_z,
        torsion=2 * (cheek.shear_area_y * beside**2 + cheek.torsion),
        shear_area_y=2 * cheek.shear_area_y,
        shear_area_z=np.minimum(sway, 2 * cheek.shear_area_z),
    )

    def at(x: FloatArray) -> Sections:
        pairs = ((getattr(cheeks, f.name), getattr(whole, f.name)) for f in fields(Sections))
        return Sections(*(np.where(x < free, own, tube) for own, tube in pairs))

    return at


def _leaves(shape: LeafPack) -> Sections:
    """Leaves that slide on each other in the plane, side by side out of it; no clamp."""
    one = rectangle(shape.thickness, shape.width)
    n = shape.leaves
    return Sections(
        n * one.area,
        n * one.inertia_y,
        n * one.inertia_z,
        n * one.torsion,
        n * one.shear_area_y,
        n * one.shear_area_z,
    )
