"""The frame of a slotted lever: two rails beside the slot between stiff ends (Vierendeel)."""

from itertools import pairwise

import numpy as np

from checks.design.data import Part
from checks.handbook.notch_factors import bent_plate_hole, curved_bar, stepped_bar
from checks.models.beam_bores import StripLug, bore_patch
from checks.models.beam_entries import bore_entry, slide_entry, tilting
from checks.models.beam_frames import elastic
from checks.models.beam_parts import Entry, PartFrame, Patch, Site
from checks.models.beam_sections import bore_places, bored, chord
from fem.frame import Frame, gauss_points
from fem.frame_fibres import Fibres, rectangle_fibres
from fem.frame_sections import Sections, rectangle
from fem.sliding import stations
from geometry.mesh import FloatArray, IntArray, Interface
from geometry.parts import SlottedLever

_SAME = 1e-9  # of the length: places closer than that are one
_ROUND = 6  # members along a round end of the slot
_PLATE = 6  # members between a hole and the slot
_ROOT = 16.67  # O'Donnell's turn of a cantilever's root, times pi E t h^2 / M
_RIGID = 1e4  # times a rail's depth and its stiffness: the plate that joins both rails


def slotted_lever(part: Part, shape: SlottedLever) -> PartFrame | None:
    """Plate, two rails, plate, boss; a contact presses on one rail at a time.

    Rails are joined to the plate's axis where the slot begins and ends, by members that give way
    only as a half-plane does under a cantilever's root (O'Donnell, J. Appl. Mech. 27 (1960) 461:
    a turn of 16.67 M/(pi E t h^2), plane stress). Beside the slot's round ends the rails taper, on
    straight axes. None for a boss without a fillet, where the elastic stress has no bound.
    """
    if shape.boss_diameter is not None and not shape.boss_fillet:
        return None
    build = _Build(part, shape)
    frame = build.frame()
    slot = slot_interface(shape)
    rail = (shape.width + shape.slot_width) / 4
    entries: list[Entry] = []
    depths = {"pivot": shape.thickness, "tip": shape.thickness + 2 * shape.boss_height}
    for name, x in (("pivot", 0.0), ("tip", shape.length)):
        centre = np.array([x, 0.0, 0.0])
        interface = Interface(name, "bore", centre, shape.hole / 2, depths[name], tilts=True)
        entries.append(bore_entry(frame, interface, tilting(frame, build.node(x, 0))))
    entries.append(
        slide_entry(
            frame,
            slot,
            (build.members_of(1), build.members_of(-1)),
            lambda x, side: build.node(x, 1 - 2 * side),
            rail - shape.slot_width / 2,
        )
    )
    return PartFrame(
        frame,
        build.node(0.0, 0),
        entries,
        build.sites(frame),
        "that the plate beside slot and holes gives way, how the boss spreads its force",
        ([build.node(0.0, 0)], [build.node(shape.length, 0)]),
        _rims(part, shape, entries[:2]),
        build.members_of(2).tolist(),
    )


def _rims(part: Part, shape: SlottedLever, entries: list[Entry]) -> list[Patch]:
    """Both bores; about the tip's, plate and boss are one lug as thick as both."""
    found = []
    for entry, room in zip(entries, (shape.slot_from, shape.length - shape.slot_to), strict=True):
        thick = entry.interface.length
        found.append(
            bore_patch(
                entry,
                StripLug(shape.width, shape.overhang, room, bar=shape.thickness),
                thick,
                (-thick / 2, thick / 2),
                part.material.poisson_ratio,
                mirrored=entry is entries[-1],
                tilts=True,
            )
        )
    return found


def slot_interface(shape: SlottedLever) -> Interface:
    """The slot as a sliding contact."""
    patch = (shape.slot_width if shape.contact_length is None else shape.contact_length) / 2
    first = shape.slot_from + shape.slot_width / 2 + patch
    last = shape.slot_to - shape.slot_width / 2 - patch
    return Interface(
        "slot",
        "slide",
        np.zeros(3),
        length=shape.thickness,
        travel=(
            first if shape.travel_from is None else shape.travel_from,
            last if shape.travel_to is None else shape.travel_to,
        ),
        patch=patch,
    )


class _Build:
    """Collects nodes and members: `side` is 0 on the plate's axis, 1 and -1 on the rails."""

    def __init__(self, part: Part, shape: SlottedLever) -> None:
        self.shape, self.part = shape, part
        self._unit = _SAME * shape.length
        self._nodes: dict[tuple[int, int], int] = {}
        self._places: list[tuple[float, float]] = []
        self._members: list[tuple[int, int, int]] = []  # from, to, side; 2 is a rigid piece
        beyond = shape.width / 2 if shape.overhang is None else shape.overhang
        self._chain(self._plate(-beyond, 0.0), 0)
        self._chain(self._plate(0.0, shape.slot_from), 0)
        self._chain(self._plate(shape.slot_to, shape.length), 0)
        self._chain(self._plate(shape.length, shape.length + beyond), 0)
        for side in (1, -1):
            self._chain(self._rail(), side)
            for x in (shape.slot_from, shape.slot_to):
                self._members.append((self.node(x, 0), self.node(x, side), 2))

    @property
    def _holes(self) -> tuple[tuple[float, float], ...]:
        return (0.0, self.shape.hole / 2), (self.shape.length, self.shape.hole / 2)

    def node(self, x: float, side: int) -> int:
        """Number of the node at a place, made if there is none yet."""
        key = side, round(x / self._unit)
        if key not in self._nodes:
            self._nodes[key] = len(self._places)
            self._places.append((x, side * (self.shape.width + self.shape.slot_width) / 4))
        return self._nodes[key]

    def members_of(self, side: int) -> IntArray:
        """Numbers of the members of a rail, or of what joins them."""
        return np.flatnonzero([own == side for _, _, own in self._members])

    def frame(self) -> Frame:
        """All of it."""
        nodes = np.array([(x, y, 0.0) for x, y in self._places])
        members = np.array([(start, end) for start, end, _ in self._members])
        kind = np.array([own for _, _, own in self._members])
        up = np.where((kind == 2)[:, None], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
        x = gauss_points(nodes, members)[..., 0]
        return Frame(nodes, members, up, self._sections(x, kind), elastic(self.part))

    def sites(self, frame: Frame) -> list[Site]:
        """Both ends of every member of the rails and of the plate between holes and slot."""
        found = []
        for number, (start, end, side) in enumerate(self._members):
            x = frame.nodes[[start, end], 0]
            for at, place in ((0.0, x[0] + 1e-6 * (x[1] - x[0])), (1.0, x[1])):
                if side == 0:
                    found += self._of_plate(number, at, float(place))
                elif side != 2:
                    found += self._of_rail(number, at, float(place), side)
        return found

    def _of_plate(self, member: int, at: float, place: float) -> list[Site]:
        """The plate from hole to hole; at the boss's foot, or where the slot ends, its fillet."""
        shape = self.shape
        if not shape.hole / 2 < place < shape.length - shape.hole / 2:
            return []
        fibres = rectangle_fibres(shape.width, float(thickness(shape, np.array(place))))
        if shape.boss_diameter is None or place < shape.slot_to:
            return [Site(member, at, fibres, "plate")]
        foot = shape.length - shape.boss_diameter / 2 - shape.boss_fillet
        if place > max(foot, shape.slot_to) + 1e-5 * shape.length:
            return []
        plate = rectangle_fibres(shape.width, shape.thickness)
        sizes = shape.thickness + 2 * shape.boss_height, shape.thickness, shape.boss_fillet
        pulled, bent = (stepped_bar(kind, *sizes) for kind in ("tension", "bending"))
        middles = plate.places[:, 0] == 0
        factors = np.array([pulled, 1.0, 1.0, 1.0, bent, 1.0])
        unit = np.where(middles[:, None, None], plate.unit * factors, plate.unit)
        return [Site(member, at, Fibres(plate.places, unit), "boss fillet")]

    def _of_rail(self, member: int, at: float, place: float, side: int) -> list[Site]:
        """A rail's straight part, and half-way into the slot's round end with its factors.

        There its own moment turns round the corner as in a curved bar, axial force finds a
        shoulder and bending out of the plane half of a hole.
        """
        shape = self.shape
        depth, round_end = (shape.width - shape.slot_width) / 2, shape.slot_width / 2
        away = min(place - shape.slot_from, shape.slot_to - place)
        fibres = rectangle_fibres(depth, shape.thickness)
        if away >= round_end * (1 - 1e-6):
            return [Site(member, at, fibres, "rail")]
        if abs(away - round_end / 2) > 1e-4 * round_end:
            return []
        factors = np.ones(6)
        factors[0] = stepped_bar("tension", shape.width, 2 * depth, round_end)
        factors[4] = bent_plate_hole(2 * round_end, shape.thickness) * 2 * depth / shape.width
        factors[5] = curved_bar(depth, round_end)
        inner = np.sign(fibres.places[:, 0]) == -side
        unit = np.where(inner[:, None, None], fibres.unit * factors, fibres.unit)
        return [Site(member, at, Fibres(fibres.places, unit), "slot's end")]

    def _chain(self, places: list[float], side: int) -> None:
        for start, end in pairwise(places):
            self._members.append((self.node(start, side), self.node(end, side), side))

    def _plate(self, start: float, stop: float) -> list[float]:
        boss = self.shape.length - (self.shape.boss_diameter or 0.0) / 2
        marks = {
            start,
            stop,
            *(x for x in (boss, boss - self.shape.boss_fillet) if start < x < stop),
        }
        marks |= {x for x in bore_places(self._holes) if start < x < stop}
        places = sorted(marks | set(np.linspace(start, stop, _PLATE + 1)[1:-1].tolist()))
        near = [b - a > 1e3 * self._unit for a, b in pairwise(places)]
        return [places[0], *(x for x, apart in zip(places[1:], near, strict=True) if apart)]

    def _rail(self) -> list[float]:
        """Places of a rail's nodes: fine at the round ends, and where the contact's hats change."""
        shape = self.shape
        start, stop, end = shape.slot_from, shape.slot_to, shape.slot_width / 2
        turn = end * (1 - np.cos(np.linspace(0, np.pi / 2, _ROUND + 1)))
        contact = stations(slot_interface(shape))
        spacing = float(contact[1] - contact[0])
        hats = np.r_[contact[0] - spacing, contact, contact[-1] + spacing]
        even = np.arange(start + end, stop - end, 2 * spacing)[1:]
        places = np.sort(np.r_[start + turn, hats, even, stop - turn[::-1]])
        kept = [float(places[0])]
        for place in places[1:]:
            if place - kept[-1] > 1e-3 * end:
                kept.append(float(place))
        kept[-1] = stop
        return kept

    def _sections(self, x: FloatArray, kind: IntArray) -> Sections:
        shape = self.shape
        height = np.where(
            (np.abs(kind) == 1)[:, None], depth(shape, x, 1), np.full_like(x, shape.width)
        )
        thick = thickness(shape, x)
        factor = np.where((kind == 2)[:, None], _RIGID, 1.0)
        taken = np.where((kind == 0)[:, None], chord(x, self._holes), 0.0)
        own = bored(rectangle(height, thick), taken, height, thick, thick**3 / 12)
        # E I of a link of length W/4 that turns 16.67 M/(pi E t h^2) under M, h = W/2
        root = thick * shape.width**2 * (shape.width + shape.slot_width) * np.pi / (16 * _ROOT)
        bent = np.where((kind == 2)[:, None], root / _RIGID, own.inertia_z)
        values = (own.area, own.inertia_y, bent, own.torsion)
        shear = (own.shear_area_y, own.shear_area_z)
        return Sections(*(factor * value for value in (*values, *shear)))


def _opening(shape: SlottedLever, x: FloatArray) -> FloatArray:
    """Half the slot's height at places within it."""
    end = shape.slot_width / 2
    away = np.maximum(np.maximum(shape.slot_from + end - x, x - shape.slot_to + end), 0.0)
    return np.asarray(np.sqrt(np.maximum(end**2 - away**2, 0.0)))


def depth(shape: SlottedLever, x: FloatArray, side: int) -> FloatArray:
    """Height of the plate (side 0) or of one rail, mm."""
    if side == 0:
        return np.full(np.shape(x), shape.width)
    return np.asarray(shape.width / 2 - _opening(shape, x))


def thickness(shape: SlottedLever, x: FloatArray) -> FloatArray:
    """Mean thickness of the plate with its boss, mm."""
    if shape.boss_diameter is None:
        return np.full(np.shape(x), shape.thickness)
    radius = shape.boss_diameter / 2
    chord = 2 * np.sqrt(np.maximum(radius**2 - (x - shape.length) ** 2, 0.0))
    return np.asarray(shape.thickness + 2 * shape.boss_height * chord / shape.width)
