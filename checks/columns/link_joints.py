"""A linkage's joints as rows of its frame that vanish, and what the forks hold.

A design's bodies are links of the frame: bars where their parts are, rigid bodies elsewhere. The
forces of a cycle act on it as axial forces of bars, and what goes along.

Many positions of a cycle are solved together.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, sin

import numpy as np

import loads
from checks.design.data import Design
from checks.part.part_loads import Placing, part_placing
from checks.strength.part_strength import elastic_of
from fem.frame import Frame
from fem.frame_joints import (
    Link,
    Motion,
    PlacedLinks,
    bar_frame,
    dead_force,
    following_force,
    pin,
    slide,
    slot_force,
)
from geometry.bars import Bar
from geometry.mesh import FloatArray, IntArray

_ON_AXIS = 1e-9  # of a size: a shorter arm is none
_ROUND_OFF = 1e-10  # of the largest force of the linkage


_ASIDE = 1e-6  # of a bar's length: how far from its axis a point may be to be on it
_SIDEWAYS, _TILTS, _TURN = 2, (3, 4), 5
_WHOLE = 1e-6  # rad, short of a whole turn
_NUMBERS_AT_ONCE = 2**22  # of geometric stiffness: 32 MB
Place = tuple[str, int]  # cycle and position


@dataclass(frozen=True, eq=False)
class LinkModel:
    """The links of a linkage, one per moving body, in the linkage's order.

    linkage
    links     in the axes of their parts
    bars      number of the link -> its sections
    placings  of the links' axes in the bodies'
    """

    linkage: loads.Linkage
    links: tuple[Link, ...]
    bars: Mapping[int, Bar]
    placings: tuple[Placing, ...]

    @property
    def has_bars(self) -> bool:
        """True if any body can bend."""
        return bool(self.bars)

    @property
    def n_unknowns(self) -> int:
        """Of all links together."""
        return sum(link.n_unknowns for link in self.links)

    def number(self, body: str) -> int | None:
        """Return the link of a body; None for the ground."""
        return self._numbers[body]

    @cached_property
    def _numbers(self) -> dict[str, int | None]:
        moving = enumerate(body.name for body in self.linkage.moving)
        return {loads.GROUND: None, **{name: number for number, name in moving}}

    def bending(self, number: int, plane: str) -> float:
        """E I in the middle of a bar's longest stretch, N mm2, "in plane" or out of it."""
        bar, frame = self.bars[number], self.links[number].frame
        assert frame is not None
        sections = bar.at(np.full((1, 6), sum(bar.main) / 2))
        inertia = sections.inertia_z if plane == "in plane" else sections.inertia_y
        return float(frame.material.youngs_modulus * np.ravel(inertia)[0])

    def own(self, link: int, places: FloatArray) -> FloatArray:
        """Places (..., 2) in a link's axes, for those in its body's."""
        placing = self.placings[link]
        c, s = cos(placing.angle), sin(placing.angle)
        return np.asarray((places - np.array(placing.origin)) @ np.array([[c, -s], [s, c]]))

    def placed(self, poses: FloatArray) -> PlacedLinks:
        """The links in poses (..., bodies, 3) of the linkage, the ground first."""
        places = np.array([placing.origin for placing in self.placings])
        turns = np.array([placing.angle for placing in self.placings])
        angles = poses[..., 1:, 2]
        origins = poses[..., 1:, :2] + _turned(places, angles)
        return PlacedLinks(self.links, origins, angles + turns)

    def moved(
        self, placed: PlacedLinks, shape: FloatArray
    ) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
        """Places (n, 2) and motions (n, 6) by body, ground axes, the largest displacement 1."""
        places, moves = {}, {}
        for k, link in enumerate(self.links):
            where = np.zeros((1, 2)) if link.frame is None else link.frame.nodes[:, :2]
            motions = [placed.motion(k, place) for place in where]
            places[link.name] = np.array([motion.place for motion in motions])
            moves[link.name] = np.array([motion.rows @ shape for motion in motions])
        largest = max(float(np.abs(move[:, :3]).max()) for move in moves.values())
        return places, {name: move / largest for name, move in moves.items()}


@dataclass(frozen=True, eq=False)
class JointRows:
    """The joints of one cycle; at one position of it, or at many.

    slots_hold  whether a slot or guide on a moving body holds sideways also with soft forks
    shafts      bodies that turn round in the ground: their bearings hold tilts, no fork does
    """

    model: LinkModel
    cycle: loads.CycleLoads
    slots_hold: bool = False
    shafts: frozenset[str] = frozenset()

    def motion(self, placed: PlacedLinks, body: str, point: str) -> Motion:
        """How a named point of a body moves."""
        place = np.array(self.model.linkage.body(body).place(point), dtype=float)
        link = self.model.number(body)
        return placed.motion(link, place if link is None else self.model.own(link, place))

    def between(self, placed: PlacedLinks, between: loads.Coordinate) -> tuple[Motion, Motion]:
        """Motions of the two points of a distance."""
        assert isinstance(between, loads.Distance)
        return (
            self.motion(placed, between.body_a, between.point_a),
            self.motion(placed, between.body_b, between.point_b),
        )

    def contact(
        self, placed: PlacedLinks, joint: loads.Prismatic | loads.Slot, k: int | IntArray
    ) -> tuple[Motion, Motion, FloatArray]:
        """Motions of the line's body at the contact and of the slider, and the line's normal."""
        b = self.motion(placed, joint.body_b, joint.point_b)
        link = self.model.number(joint.body_a)
        x, y = np.array(joint.direction, dtype=float) / np.hypot(*joint.direction)
        normal = np.array([-y, x])
        if link is None:
            return placed.motion(None, b.place), b, normal
        own = _turned(b.place - placed.origins[..., link, :], -placed.angles[..., link])
        angle = self.cycle.poses[k, link + 1, 2]
        return placed.motion(link, own), b, _turned(normal, angle)

    def rows(self, placed: PlacedLinks, k: int | IntArray, *, stiff: bool) -> FloatArray:
        """All joints and the held drive at positions k (...), (..., r, n)."""
        found = []
        for joint in self.model.linkage.joints:
            if isinstance(joint, loads.Prismatic | loads.Slot):
                a, b, normal = self.contact(placed, joint, k)
                found.append(slide(a, b, normal, self._slide_holds(joint, stiff)))
            elif isinstance(joint, loads.Fixed):
                ends = joint.body_a, joint.body_b
                a, b = (self.motion(placed, body, joint.point) for body in ends)
                found.append(b.rows - a.rows)
        for point, (first, *others) in self._pins:
            a = self.motion(placed, first, point)
            for body in others:
                axis = None if stiff else self._soft_axis(placed, first, body)
                found.append(pin(a, self.motion(placed, body, point), axis))
        found.append(self._drive(placed))
        return np.concatenate(found, axis=-2)

    @cached_property
    def _pins(self) -> list[tuple[str, list[str]]]:
        """Points with all bodies that turn on one pin there, the ground or a guided one first.

        Which of them a linkage's joints pair depends on the order of its bodies.
        """
        found = []
        for joints in loads.shared_pins(self.model.linkage.joints):
            bodies = dict.fromkeys(body for one in joints for body in (one.body_a, one.body_b))
            found.append((joints[0].point, sorted(bodies, key=self._is_moving)))
        return found

    def _is_moving(self, body: str) -> bool:
        return body not in self._supports

    def _slide_holds(self, joint: loads.Prismatic | loads.Slot, stiff: bool) -> tuple[int, ...]:
        guided = isinstance(joint, loads.Prismatic)
        if joint.body_a == loads.GROUND:
            return (_TURN, _SIDEWAYS, *_TILTS) if guided else (_SIDEWAYS,)
        if not stiff:
            sideways = (_SIDEWAYS,) if self.slots_hold else ()
            return (_TURN, *sideways) if guided else sideways
        return (_TURN, _SIDEWAYS, *_TILTS) if guided else (_SIDEWAYS,)

    def _soft_axis(self, placed: PlacedLinks, first: str, body: str) -> FloatArray | None:
        """The axis about which a soft fork still holds: of a body at ground or guide."""
        if self._is_moving(first) or not self._is_moving(body):
            return None
        link = self.model.number(body)
        assert link is not None
        own = self.model.linkage.moving[link]
        joints = [j for j in self.model.linkage.joints if own.name in (j.body_a, j.body_b)]
        if len(own.points) < 2 or len(joints) < 2:  # a lever: nothing but its bearing holds it
            return None
        if own.name in self.shafts and first == loads.GROUND:
            return None
        angle = placed.angles[..., link]
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    @cached_property
    def _supports(self) -> set[str]:
        """The ground and what is guided on it or welded to it."""
        found = {loads.GROUND}
        for joint in self.model.linkage.joints:
            if isinstance(joint, loads.Prismatic | loads.Fixed) and loads.GROUND in (
                joint.body_a,
                joint.body_b,
            ):
                found |= {joint.body_a, joint.body_b}
        return found

    def _drive(self, placed: PlacedLinks) -> FloatArray:
        """The row of the coordinate that sets the pace."""
        match self.cycle.pace:
            case loads.PointCoordinate(body=body, point=point, direction=direction):
                row = np.array(direction) @ self.motion(placed, body, point).rows[..., :2, :]
            case loads.Distance():
                a, b = self.between(placed, self.cycle.pace)
                span = (b.place - a.place)[..., None, :]
                row = (span @ (b.rows - a.rows)[..., :2, :])[..., 0, :]
            case loads.Angle(body=body, relative_to=other):
                row = self._turn(placed, body, other) - self._turn(placed, other, body)
        return np.asarray(row[..., None, :])

    def _turn(self, placed: PlacedLinks, body: str, other: str) -> FloatArray:
        """Turn of a body about z at the pin that it has with the other body.

        Bars bend, and a drive between two bodies holds them where they turn on each other. Without
        such a pin it is held where its frame starts, at its first pin.
        """
        link = self.model.number(body)
        place = np.zeros(2)
        for point, bodies in self._pins:
            if {body, other} <= set(bodies):
                own = self.model.linkage.body(body)
                place = np.array(own.place(point), dtype=float)
        start = place if link is None else self.model.own(link, place)
        return np.asarray(placed.motion(link, start).rows[..., _TURN, :])


@dataclass(frozen=True, eq=False)
class BarForces:
    """Forces along a bar over a cycle.

    points  (m, 6)  mm along the bar, its Gauss points
    along   (l, n)  mm, where they act
    pushed  (l, n)  N along the bar's x axis
    """

    points: FloatArray
    along: FloatArray
    pushed: FloatArray

    def per_force(self, k: int | IntArray) -> FloatArray:
        """Axial force per force of positions k (...) at the Gauss points, (l, ..., m, 6).

        What forces leave unbalanced is taken by the bar's own weight and inertia, spread evenly
        between the outermost of them.
        """
        at = self.along[:, k]
        start, length = (end[..., None, None] for end in (at.min(axis=0), np.ptp(at, axis=0)))
        spread = np.clip((self.points - start) / np.where(length > 0, length, 1.0), 0.0, 1.0)
        taken = np.where(length > 0, spread, self.points > start)
        return np.asarray(taken - (self.points > at[..., None, None]))

    def axial(self, k: int | IntArray) -> FloatArray:
        """Axial force of positions k (...) at the Gauss points (..., m, 6), N, tension above 0."""
        return np.asarray(np.einsum("l...,l...mg->...mg", self.pushed[:, k], self.per_force(k)))


@dataclass(frozen=True, eq=False)
class LinkForces:
    """Forces of one cycle on the links, by number of the link.

    bars    on bars, along them
    arms    (link, (n, 2) mm in its axes, (n, 2) N in ground axes) of forces beside nodes of links
    """

    joints: JointRows
    bars: Mapping[int, BarForces]
    arms: tuple[tuple[int, FloatArray, FloatArray], ...]

    @cached_property
    def sizes(self) -> FloatArray:
        """All forces over the cycle (n, c) N; round-off is none.

        Along bars, at arms, between points and in slots.
        """
        cycle = self.joints.cycle
        columns = [force for bar in self.bars.values() for force in bar.pushed]
        columns += [force[:, i] for _, _, force in self.arms for i in (0, 1)]
        columns += [-force.sign * cycle.efforts[force.name] for force in self._between()]
        columns += [
            cycle.reactions[joint.name].force[:, i] for joint in self._slides() for i in (0, 1)
        ]
        sizes = np.stack(columns, axis=1)
        sizes[np.abs(sizes) <= _ROUND_OFF * self._largest()] = 0.0
        return sizes

    def _largest(self) -> float:
        """The largest force of the linkage over the cycle, N; torques over its size."""
        cycle = self.joints.cycle
        size = float(np.ptp(cycle.poses[:, :, :2])) or 1.0
        found = [np.abs(load.force).max() for load in cycle.reactions.values()]
        found += [np.abs(load.moment).max() / size for load in cycle.reactions.values()]
        for force in cycle.linkage.forces:
            arm = size if force.coordinate.angular else 1.0
            found.append(np.abs(cycle.efforts[force.name]).max() / arm)
        return float(max(found))

    def geometric(self, placed: PlacedLinks, k: int | IntArray) -> FloatArray:
        """Geometric stiffness (..., n, n) of all forces of positions k (...)."""
        sizes, first = self.sizes[k], 0
        result = np.zeros((*sizes.shape[:-1], placed.n_unknowns, placed.n_unknowns))
        for link, bar in self.bars.items():
            count = len(bar.pushed)
            own = sizes[..., first : first + count]
            axial = np.einsum("...l,l...mg->...mg", own, bar.per_force(k))
            flat = placed.axial(link, axial.reshape(-1, *axial.shape[-2:]))
            result += flat.reshape(result.shape)
            first += count
        for link, places, _ in self.arms:
            result += dead_force(placed.motion(link, places[k]), sizes[..., first : first + 2])
            first += 2
        for force in self._between():
            motions = self.joints.between(placed, force.coordinate)
            result += following_force(*motions, sizes[..., first])
            first += 1
        for joint in self._slides():
            a, b, normal = self.joints.contact(placed, joint, k)
            along = np.sum(normal * sizes[..., first : first + 2], axis=-1)
            result += slot_force(a, b, normal, along)
            first += 2
        return result

    def _between(self) -> list[loads.Force]:
        """Forces between two points."""
        forces = self.joints.cycle.linkage.forces
        return [force for force in forces if isinstance(force.coordinate, loads.Distance)]

    def _slides(self) -> list[loads.Prismatic | loads.Slot]:
        """Slots and guides on bodies that move."""
        return [
            joint
            for joint in self.joints.cycle.linkage.joints
            if isinstance(joint, loads.Prismatic | loads.Slot) and joint.body_a != loads.GROUND
        ]


def shafts(cycles: Iterable[loads.CycleLoads]) -> frozenset[str]:
    """Bodies that make a whole turn in a cycle: cranks, on shafts with bearings of their own."""
    return frozenset(
        body.name
        for run in cycles
        for body, angles in zip(run.linkage.moving, run.poses[:, 1:, 2].T, strict=True)
        if np.ptp(angles) > 2 * np.pi - _WHOLE
    )


def link_model(design: Design, linkage: loads.Linkage, pieces: int) -> LinkModel:
    """Return the links of a design, bars in `pieces` per longest stretch."""
    parts = {part.body: part for part in design.parts.values() if part.body is not None}
    links, bars, placings = [], {}, []
    for k, body in enumerate(linkage.moving):
        part = parts.get(body.name)
        bar = None if part is None else part.geometry.link(part.material.poisson_ratio)
        placing = Placing((0.0, 0.0), 0.0) if part is None else part_placing(design, part)
        placings.append(placing)
        if part is None or bar is None:
            links.append(Link(body.name))
            continue
        bars[k] = bar
        places = _on_axis(placing, body, bar)
        links.append(Link(body.name, bar_frame(bar, elastic_of(part), pieces, places)))
    return LinkModel(linkage, tuple(links), bars, tuple(placings))


def _on_axis(placing: Placing, body: loads.Body, bar: Bar) -> Sequence[float]:
    """Where points of the body are on the bar's axis, mm along it."""
    c, s = cos(placing.angle), sin(placing.angle)
    found = []
    for point in body.points.values():
        x, y = np.array(point) - np.array(placing.origin)
        along, aside = c * x + s * y, -s * x + c * y
        length = bar.cuts[-1] - bar.cuts[0]
        if abs(aside) < _ASIDE * length and all(
            abs(along - cut) > _ASIDE * length for cut in bar.cuts
        ):
            found.append(float(along))
    return found


def forces_of(model: LinkModel, joints: JointRows) -> LinkForces:
    """Return the forces of a cycle on its links.

    A bar's own weight and inertia are spread evenly along it; a rigid body's act at its centre.
    """
    cycle = joints.cycle
    bars, arms = {}, []
    for k, body in enumerate(model.linkage.moving):
        angle = cycle.poses[:, k + 1, 2]
        link = model.links[k]
        along, pushed = [], []
        total = np.zeros((len(angle), 2))
        for load in cycle.body_loads(body.name):
            if load.point is None:
                continue  # a torque
            total += load.force
            reach = _turned(load.reach, -angle)
            place = model.own(k, np.array(body.place(load.point), dtype=float) + reach)
            along.append(place[:, 0])
            pushed.append(_turned(load.force, -angle - model.placings[k].angle)[:, 0])
            if _beside(link.frame, place):
                arms.append((k, place, load.force))
        if link.frame is None:
            centre = model.own(k, np.array(body.centre, dtype=float))
            if centre.any():
                arms.append((k, np.broadcast_to(centre, total.shape), -total))
        else:
            points = link.frame.points[..., 0]
            bars[k] = BarForces(points, np.array(along), np.array(pushed))
    return LinkForces(joints, bars, tuple(arms))


def _beside(frame: Frame | None, place: FloatArray) -> bool:
    """True if a load acts beside a bar's axis, beyond its ends or off a rigid body's origin."""
    nodes = np.zeros(1) if frame is None else frame.nodes[:, 0]
    slack = _ON_AXIS * float(np.ptp(nodes))
    x, y = place.T
    beyond = np.maximum(nodes[0] - x, x - nodes[-1])
    return bool(np.abs(y).max() > slack or beyond.max() > slack)


def _turned(vectors: FloatArray, angle: FloatArray | float) -> FloatArray:
    """Vectors (..., 2) turned by angles (...)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


@dataclass(frozen=True, eq=False)
class Together:
    """Positions (p,) of one cycle with the forces there.

    name       of the cycle
    forces     on its links
    positions  (p,)
    """

    name: str
    forces: LinkForces
    positions: IntArray

    @cached_property
    def placed(self) -> PlacedLinks:
        """The links as they stand in each."""
        joints = self.forces.joints
        return joints.model.placed(joints.cycle.poses[self.positions])

    @cached_property
    def geometric(self) -> FloatArray:
        """Geometric stiffness (p, n, n) of all forces."""
        return self.forces.geometric(self.placed, self.positions)

    @cached_property
    def _rows(self) -> dict[bool, FloatArray]:
        return {}

    def rows(self, *, stiff: bool) -> FloatArray:
        """All joints and the held drive (p, r, n); cases share them."""
        if stiff not in self._rows:
            joints = self.forces.joints
            self._rows[stiff] = joints.rows(self.placed, self.positions, stiff=stiff)
        return self._rows[stiff]

    @cached_property
    def places(self) -> list[Place]:
        """Cycle and position of each."""
        return [(self.name, int(k)) for k in self.positions]


def together(forces: Mapping[str, LinkForces], places: Sequence[Place]) -> Iterator[Together]:
    """Yield places by cycle in their order, so many at once as memory is meant for."""
    for name in dict.fromkeys(name for name, _ in places):
        size = forces[name].joints.model.n_unknowns
        most = max(1, _NUMBERS_AT_ONCE // size**2)
        positions = np.array([k for other, k in places if other == name])
        for first in range(0, len(positions), most):
            yield Together(name, forces[name], positions[first : first + most])
