"""The forces of a cycle on the frame of its linkage: axial forces of bars, and what goes along."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import loads
from checks.columns.link_joints import JointRows
from checks.columns.link_model import LinkModel
from fem.frame import Frame
from fem.frame_joints import PlacedLinks, dead_force, following_force, slot_force
from geometry.mesh import FloatArray

_ON_AXIS = 1e-9  # of a size: a shorter arm is none
_AXES = np.eye(2)
_ROUND_OFF = 1e-10  # of the largest force of the linkage


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

    def per_force(self, k: int) -> FloatArray:
        """Axial force per force of position k at the Gauss points, (l, m, 6).

        What forces leave unbalanced is taken by the bar's own weight and inertia, spread evenly
        between the outermost of them.
        """
        at = self.along[:, k]
        start, length = at.min(), np.ptp(at)
        taken = self.points > start
        if length > 0:
            taken = np.clip((self.points - start) / length, 0.0, 1.0)
        return np.asarray(taken - (self.points > at[:, None, None]))

    def axial(self, k: int) -> FloatArray:
        """Axial force of position k at the Gauss points (m, 6), N, tension above 0."""
        return np.asarray(np.tensordot(self.pushed[:, k], self.per_force(k), 1))


@dataclass(frozen=True, eq=False)
class LinkForces:
    """Forces of one cycle on the links, by number of the link.

    bars    on bars, along them
    arms    (link, (n, 2) mm in its axes, (n, 2) N in ground axes) of forces beside nodes of links
    """

    joints: JointRows
    bars: Mapping[int, BarForces]
    arms: tuple[tuple[int, FloatArray, FloatArray], ...]

    def sizes(self) -> FloatArray:
        """All forces over the cycle (n, c) N, in the order of `forms`; round-off is none."""
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

    def forms(self, placed: PlacedLinks, k: int) -> FloatArray:
        """Geometric stiffness per force in the pose of position k, (c, n, n)."""
        found: list[FloatArray] = []
        for link, bar in self.bars.items():
            found.extend(placed.axial(link, bar.per_force(k)))
        for link, places, _ in self.arms:
            motion = placed.motion(link, places[k])
            found += [dead_force(motion, axis) for axis in _AXES]
        for force in self._between():
            found.append(following_force(*self.joints.between(placed, force.coordinate), 1.0))
        for joint in self._slides():
            a, b, normal = self.joints.contact(placed, joint, k)
            found += [slot_force(a, b, normal, float(share)) for share in normal]
        return np.array(found)

    def geometric(self, placed: PlacedLinks, k: int) -> FloatArray:
        """Geometric stiffness (n, n) of all forces of position k."""
        return np.asarray(np.tensordot(self.sizes()[k], self.forms(placed, k), 1))

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
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[:, 0], vectors[:, 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=1)
