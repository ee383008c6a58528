"""Lumped mass of a linkage that vibrates: points on its beams, one place on every other body."""

from dataclasses import dataclass

import numpy as np

from loads.bodies import Body, FloatArray, IntArray
from loads.compliance import BeamCompliance
from loads.kinematics import rotated, turned_left
from loads.linkage import Linkage
from loads.motion import Motion

_POINTS = 5  # along a beam; the first mode between two pins is then 0.02 % off


@dataclass(frozen=True, eq=False)
class Lumps:
    """Ways in which mass can move, d in all: of a place along its body's x or y, or its turn.

    bodies  (d,)    rows of their bodies in poses
    way     (d,)    0 along x, 1 along y of the body, 2 turning
    places  (d, 2)  mm, in the body's frame
    arms    (d, 2)  mm, from the body's centre of mass
    masses  (d,)    tonne, of a turn tonne mm2: all above 0
    """

    bodies: IntArray
    way: IntArray
    places: FloatArray
    arms: FloatArray
    masses: FloatArray

    def of(self, row: int) -> IntArray:
        """Return which of them belong to a body."""
        return np.flatnonzero(self.bodies == row)

    def wrenches(self, angles: FloatArray) -> FloatArray:
        """Return the force and couple of unit loads at their body's centre (n, 3, d), ground axes.

        angles  (n, bodies) rad
        """
        along = np.eye(3)[self.way][:, :2]
        result = np.zeros((len(angles), 3, len(self.way)))
        result[:, :2] = np.swapaxes(rotated(along[None], angles[:, self.bodies]), 1, 2)
        turning = self.arms[:, 0] * along[:, 1] - self.arms[:, 1] * along[:, 0]
        result[:, 2] = np.where(self.way == 2, 1.0, turning)
        return result

    def inertia_loads(self, motion: Motion) -> FloatArray:
        """Return weight and inertia of a motion on every lump (n, d): N, and N mm on turns."""
        gravity = np.array(motion.kinematics.linkage.gravity, dtype=float)
        angles = motion.poses[:, self.bodies, 2]
        places = rotated(self.places[None], angles)
        spin, turn = motion.velocities[:, self.bodies, 2], motion.accelerations[:, self.bodies, 2]
        pull = (
            motion.accelerations[:, self.bodies, :2]
            + turn[..., None] * turned_left(places)
            - (spin**2)[..., None] * places
            - gravity
        )
        own = rotated(pull, -angles)
        each = np.where(self.way == 0, own[..., 0], np.where(self.way == 1, own[..., 1], turn))
        result: FloatArray = -self.masses * each
        return result

    def body_motions(self, shapes: FloatArray, poses: FloatArray) -> FloatArray:
        """Return the mean motion of every body (n, bodies, 3, k) for shapes (n, d, k).

        Of its centre of mass in ground axes and its turn: as a rigid body that has the same
        momentum; rates, accelerations or displacements alike.
        """
        n, _, k = shapes.shape
        result = np.zeros((n, poses.shape[1], 3, k))
        wrenches = self.wrenches(poses[:, :, 2])
        for row in np.unique(self.bodies):
            own = self.of(row)
            momentum = wrenches[:, :, own] @ (self.masses[own, None] * shapes[:, own])
            result[:, row, :2] = momentum[:, :2] / (self.masses[own] @ (self.way[own] == 0) or 1.0)
            spread = self.arms[own, 0] * (self.way[own] == 1) - self.arms[own, 1] * (
                self.way[own] == 0
            )
            inertia = float(self.masses[own] @ np.where(self.way[own] == 2, 1.0, spread**2))
            result[:, row, 2] = momentum[:, 2] / (inertia or 1.0)
        return result


def lumps_of(linkage: Linkage) -> Lumps:
    """Return the lumps of a linkage; mass, centre and inertia of every body are kept.

    A beam has the mass of an even bar with its mass and inertia, sqrt(12 I / m) long, in Gauss
    points along its x axis. Every other body has all of it at its centre.
    """
    beams = {c.body for c in linkage.compliance if isinstance(c, BeamCompliance)}
    rows: list[tuple[int, int, float, float, float, float, float]] = []
    for row, body in enumerate(linkage.moving, start=1):
        rows += [(row, *entry) for entry in _of_body(body, body.name in beams)]
    table = np.array([entry for entry in rows if entry[6] > 0.0], dtype=float).reshape(-1, 7)
    whole = table[:, :2].astype(int)
    return Lumps(whole[:, 0], whole[:, 1], table[:, 2:4], table[:, 4:6], table[:, 6])


def _of_body(body: Body, beam: bool) -> list[tuple[int, float, float, float, float, float]]:
    x, y = body.centre
    if not beam or body.mass <= 0.0 or body.inertia <= 0.0:
        return [(way, x, y, 0.0, 0.0, mass) for way, mass in enumerate((body.mass,) * 2)] + [
            (2, x, y, 0.0, 0.0, body.inertia)
        ]
    half = np.sqrt(3.0 * body.inertia / body.mass)
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    return [
        (way, x + half * float(node), y, half * float(node), 0.0, body.mass * float(weight) / 2.0)
        for node, weight in zip(nodes, weights, strict=True)
        for way in (0, 1)
    ]
