"""A linkage's joints as rows of its frame that vanish, and what the forks hold."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

import loads
from checks.columns.link_model import LinkModel
from fem.frame_joints import Motion, PlacedLinks, pin, slide
from geometry.mesh import FloatArray

_SIDEWAYS, _TILTS, _TURN = 2, (3, 4), 5
_WHOLE = 1e-6  # rad, short of a whole turn


@dataclass(frozen=True, eq=False)
class JointRows:
    """The joints of one cycle.

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
        self, placed: PlacedLinks, joint: loads.Prismatic | loads.Slot, k: int
    ) -> tuple[Motion, Motion, FloatArray]:
        """Motions of the line's body at the contact and of the slider, and the line's normal."""
        b = self.motion(placed, joint.body_b, joint.point_b)
        link = self.model.number(joint.body_a)
        angle = 0.0
        if link is None:
            a = placed.motion(None, b.place)
        else:
            angle = float(self.cycle.poses[k, link + 1, 2])
            turn = placed.angles[link]
            c, s = np.cos(turn), np.sin(turn)
            own = np.array([[c, s], [-s, c]]) @ (b.place - placed.origins[link])
            a = placed.motion(link, own)
        x, y = np.array(joint.direction, dtype=float) / np.hypot(*joint.direction)
        c, s = np.cos(angle), np.sin(angle)
        return a, b, np.array([-s * x - c * y, c * x - s * y])

    def rows(self, placed: PlacedLinks, k: int, *, stiff: bool) -> FloatArray:
        """All joints and the held drive at position k, (r, n)."""
        found = []
        for joint in self.model.linkage.joints:
            if isinstance(joint, loads.Prismatic | loads.Slot):
                a, b, normal = self.contact(placed, joint, k)
                found.append(slide(a, b, normal, self._slide_holds(joint, stiff)))
                continue
            a, b = (self.motion(placed, body, joint.point) for body in (joint.body_a, joint.body_b))
            if isinstance(joint, loads.Fixed):
                found.append(b.rows - a.rows)
            else:
                axis = None if stiff else self._soft_axis(placed, joint)
                found.append(pin(a, b, axis))
        found.append(self._drive(placed))
        return np.vstack(found)

    def _slide_holds(self, joint: loads.Prismatic | loads.Slot, stiff: bool) -> tuple[int, ...]:
        guided = isinstance(joint, loads.Prismatic)
        if joint.body_a == loads.GROUND:
            return (_TURN, _SIDEWAYS, *_TILTS) if guided else (_SIDEWAYS,)
        if not stiff:
            sideways = (_SIDEWAYS,) if self.slots_hold else ()
            return (_TURN, *sideways) if guided else sideways
        return (_TURN, _SIDEWAYS, *_TILTS) if guided else (_SIDEWAYS,)

    def _soft_axis(self, placed: PlacedLinks, joint: loads.Revolute) -> FloatArray | None:
        """The axis about which a soft fork still holds: of the body at ground or guide."""
        supports = self._supports
        a, b = joint.body_a, joint.body_b
        if (a in supports) == (b in supports):
            return None
        link = self.model.number(b if a in supports else a)
        assert link is not None
        own = self.model.linkage.moving[link]
        joints = [j for j in self.model.linkage.joints if own.name in (j.body_a, j.body_b)]
        if len(own.points) < 2 or len(joints) < 2:  # a lever: nothing but its bearing holds it
            return None
        if own.name in self.shafts and loads.GROUND in (a, b):
            return None
        angle = placed.angles[link]
        return np.array([np.cos(angle), np.sin(angle)])

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
                row = np.array(direction) @ self.motion(placed, body, point).rows[:2]
            case loads.Distance():
                a, b = self.between(placed, self.cycle.pace)
                row = (b.place - a.place) @ (b.rows - a.rows)[:2]
            case loads.Angle(body=body, relative_to=other):
                row = self._turn(placed, body) - self._turn(placed, other)
        return np.atleast_2d(row)

    def _turn(self, placed: PlacedLinks, body: str) -> FloatArray:
        """Turn of a body about z, where its frame starts: at its first pin."""
        link = self.model.number(body)
        start = np.zeros(2) if link is None else self.model.own(link, np.zeros(2))
        return np.asarray(placed.motion(link, start).rows[_TURN])


def shafts(cycles: Iterable[loads.CycleLoads]) -> frozenset[str]:
    """Bodies that make a whole turn in a cycle: cranks, on shafts with bearings of their own."""
    return frozenset(
        body.name
        for run in cycles
        for body, angles in zip(run.linkage.moving, run.poses[:, 1:, 2].T, strict=True)
        if np.ptp(angles) > 2 * np.pi - _WHOLE
    )
