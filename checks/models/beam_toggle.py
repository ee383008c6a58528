"""The frame of a toggle bar: a tube, and beside the cut-out its two cheeks as bars of their own."""

from itertools import pairwise

import numpy as np

from checks.design.data import Part
from checks.handbook.notch_factors import stepped_bar
from checks.models.beam_bores import StripLug, bore_patch
from checks.models.beam_entries import bore_entry
from checks.models.beam_frames import elastic
from checks.models.beam_parts import Entry, PartFrame, Patch, Site
from checks.models.beam_sections import bore_places, bored, chord
from fem.frame import Frame, FrameLoads, gauss_points
from fem.frame_fibres import Fibres, rectangle_fibres, square_tube_fibres
from fem.frame_sections import Sections, rectangle
from geometry.mesh import FloatArray, IntArray, Interface
from geometry.parts import ToggleBar
from geometry.sections import square_tube_section

_SAME = 1e-7  # of the length: places closer than that are one
_PIECES = 12  # of the longest stretch
_RIGID = 1e4  # times as stiff as the tube: what joins it to its cheeks


def toggle_bar(part: Part, shape: ToggleBar) -> PartFrame:
    """A tube between two pins; its cheeks alone, side by side, where it is cut open."""
    build = _Build(part, shape)
    frame = build.frame()
    entries = []
    for name, x in zip(shape.interfaces, (0.0, shape.length), strict=True):
        centre = np.array([x, 0.0, 0.0])
        interface = Interface(name, "bore", centre, shape.hole / 2, 2 * shape.wall, tilts=True)
        entries.append(bore_entry(frame, interface, _tilting(frame, build.at(x))))
    return PartFrame(
        frame,
        build.at(shape.length)[0],
        entries,
        build.sites(),
        "that the tube's end gives way under its cheeks, its warping, local buckling of its walls",
        (build.at(0.0), build.at(shape.length)),
        _patches(part, shape, entries),
        build.joints,
    )


def _patches(part: Part, shape: ToggleBar, entries: list[Entry]) -> list[Patch]:
    """Bores of the cheeks, whose edges the side walls stiffen where these stand."""
    half = shape.width / 2
    free = shape.cutout_length - shape.overhang
    found = []
    for entry, walls_from in zip(entries, (free, -np.inf), strict=True):
        lug = StripLug(shape.width, shape.overhang, shape.length / 2, half - shape.wall, walls_from)
        found.append(
            bore_patch(
                entry,
                lug,
                2 * shape.wall,
                (-half, half),
                part.material.poisson_ratio,
                mirrored=entry is entries[-1],
                tilts=False,
            )
        )
    return found


def _tilting(frame: Frame, nodes: list[int]) -> FrameLoads:
    """Two cases: unit couples about x and y, by forces on cheeks side by side where there are."""
    loads = frame.no_loads(2)
    heights = frame.nodes[nodes, 2]
    second = float((heights**2).sum())
    for node, z in zip(nodes, heights, strict=True):
        if second:
            loads.nodal[6 * node + 1, 0] = -z / second
            loads.nodal[6 * node, 1] = z / second
        else:
            loads.nodal[6 * node + np.array([3, 4]), [0, 1]] = 1 / len(nodes)
    return loads


class _Build:
    """Collects nodes and members; `row` is 0 in the tube, 1 and -1 in the cheeks, 2 between."""

    def __init__(self, part: Part, shape: ToggleBar) -> None:
        self.shape, self.part = shape, part
        self._unit = _SAME * shape.length
        self._nodes: dict[tuple[int, int], int] = {}
        self._places: list[tuple[float, float]] = []
        self._members: list[tuple[int, int, int]] = []
        start, stop = -shape.overhang, shape.length + shape.overhang
        free = shape.cutout_length - shape.overhang
        self.free = free if free > start else start
        holes = ((0.0, shape.hole / 2), (shape.length, shape.hole / 2))
        places = {start, 0.0, self.free, shape.length, stop, *bore_places(holes)}
        places |= set(np.linspace(self.free, shape.length, _PIECES + 1).tolist())
        places |= set(np.linspace(0.0, self.free, _PIECES // 2 + 1).tolist())
        along = [k * self._unit for k in sorted({self._number(x) for x in places})]
        along = [x for x in along if self._number(start) <= self._number(x) <= self._number(stop)]
        self.holes = holes
        self.free = self._number(self.free) * self._unit
        for low, high in pairwise(along):
            for row in (1, -1) if high <= self.free else (0,):
                self._members.append((self._node(low, row), self._node(high, row), row))
        for row in (1, -1):
            if self.free > along[0]:
                self._members.append((self._node(self.free, 0), self._node(self.free, row), 2))

    @property
    def joints(self) -> list[int]:
        """Numbers of the members that join tube and cheeks."""
        return [number for number, (_, _, row) in enumerate(self._members) if row == 2]

    def _number(self, x: float) -> int:
        """Which place it is: those closer than the unit are one."""
        return round(x / self._unit)

    def _node(self, x: float, row: int) -> int:
        key = row, self._number(x)
        if key not in self._nodes:
            self._nodes[key] = len(self._places)
            self._places.append((x, row * (self.shape.width - self.shape.wall) / 2))
        return self._nodes[key]

    def at(self, x: float) -> list[int]:
        """The nodes that stand at a place."""
        wanted = self._number(x)
        own = [node for (_, place), node in self._nodes.items() if place == wanted]
        assert own
        return own

    def frame(self) -> Frame:
        """All of it."""
        nodes = np.array([(x, 0.0, z) for x, z in self._places])
        members = np.array([(start, end) for start, end, _ in self._members])
        rows = np.array([row for _, _, row in self._members])
        up = np.where((rows == 2)[:, None], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
        x = gauss_points(nodes, members)[..., 0]
        return Frame(nodes, members, up, self._sections(x, rows), elastic(self.part))

    def sites(self) -> list[Site]:
        """Both ends of every member between the bores."""
        shape, found = self.shape, []
        tube = square_tube_section("tube", shape.width, shape.wall, shape.inner_radius)
        whole = square_tube_fibres(shape.width, shape.wall, tube.area, tube.inertia_in_plane)
        cheek = rectangle_fibres(shape.width, shape.wall)
        for number, (start, end, row) in enumerate(self._members):
            if row == 2:
                continue
            for at, node in ((0.0, start), (1.0, end)):
                x = self._places[node][0]
                if shape.hole / 2 <= x <= shape.length - shape.hole / 2:
                    fibres, name = (cheek, "cheek") if row else (whole, "tube")
                    if row and x == self.free:
                        fibres, name = self._corner(cheek, row), "cut-out corner"
                    found.append(Site(number, at, fibres, name))
        return found

    def _corner(self, cheek: Fibres, row: int) -> Fibres:
        """Fibres of a cheek at the fillet by which it widens into a side wall.

        At its edge cheek and wall are half of a stepped bar, as wide as the tube and, beside the
        cut-out, as both cheeks.
        """
        shape = self.shape
        factor = stepped_bar("tension", shape.width, 2 * shape.wall, shape.cutout_corner)
        inner = (np.sign(cheek.places[:, 1]) == -row) & (cheek.places[:, 0] != 0)
        unit = np.where(inner[:, None, None], cheek.notched(factor, factor).unit, cheek.unit)
        return Fibres(cheek.places, unit)

    def _sections(self, x: FloatArray, rows: IntArray) -> Sections:
        shape = self.shape
        section = square_tube_section("tube", shape.width, shape.wall, shape.inner_radius)
        taken = chord(x, self.holes)
        apart = (shape.width - shape.wall) / 2
        area, inertia = section.area, section.inertia_in_plane
        torsion, shear = shape.wall * (shape.width - shape.wall) ** 3, 20 / 48 * area
        values = (area, inertia, inertia, torsion, shear, shear)
        full = Sections(*(np.full_like(x, value) for value in values))
        second = 2 * (shape.wall**3 / 12 + shape.wall * apart**2)
        tube = bored(full, taken, 2 * shape.width, 2 * shape.wall, second)
        plate = rectangle(np.full_like(x, shape.width), shape.wall)
        cheek = bored(plate, taken, shape.width, shape.wall, shape.wall**3 / 12)
        which = np.abs(rows)[:, None]
        names = ("area", "inertia_y", "inertia_z", "torsion", "shear_area_y", "shear_area_z")
        picked = (
            np.select(
                [which == 0, which == 1],
                [getattr(tube, name), getattr(cheek, name)],
                _RIGID * getattr(full, name),
            )
            for name in names
        )
        return Sections(*picked)
