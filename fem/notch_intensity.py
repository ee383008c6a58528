"""Notch stress intensities along sharp re-entrant edges, for every unit load of a part.

Near an edge the stress is a sum of Williams' fields (`williams`). Their sizes are fitted to the
stress at the integration points of the elements around a place of the edge, without those that meet
the edge, whose shape functions cannot follow it: least squares, each point weighted so that all
distances count alike. The sizes are linear functionals of the displacement, so those of unit loads
add up as stresses do.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.recovery import Recovery, tensor
from fem.singularity import EdgePlaces
from fem.williams import Mode, face_loads, modes, stress_of
from geometry.mesh import FloatArray

REACH = (1.0, 4.0)  # sides of the elements at an edge, between which stress is fitted
FARTHER = (1.5, 5.0)  # others, which show how well the fields describe it
_SHARE_OF_ROOM = 0.9
_BESIDE_AN_END = 1.5  # times the distance over which stress is fitted, an end must be away
_BEYOND = 1.5  # times a distance
_LEAST_ROOM = 2.5  # sides
_HIGHEST = 3.2  # order of the fields that are fitted
_PAIRS = ((0, 0), (1, 1), (0, 1), (0, 2), (1, 2))  # rr, tt, rt, zr, tz in the local frame


@dataclass(frozen=True, eq=False)
class NotchIntensity:
    """Sizes of the fields at one place of an edge.

    angle     rad, interior angle
    frame     (3, 3) rows: into the body along the bisector, normal to that, along the edge
    fields    the fields, the three leading ones first
    sizes     (n_fields, n_basis) MPa mm^(1 - order), per unit load
    inner     mm, the least distance at which stress was fitted
    outer     mm, the largest
    """

    angle: float
    frame: FloatArray
    fields: Sequence[Mode]
    sizes: FloatArray
    inner: float
    outer: float

    def on_plane(self, r: float, theta: float, *, leading: bool = False) -> FloatArray:
        """Stress (6, n_basis) that the plane through the edge at theta (rad) carries at r (mm).

        In the part's axes: the normal and the shear stresses on that plane alone, the others 0.

        leading  whether of the three leading fields alone
        """
        fields = self.fields[: 3 if leading else len(self.fields)]
        at = np.array([r]), np.array([theta])
        shapes = np.stack([stress_of(field, self.angle, *at)[0] for field in fields])
        local = shapes.T @ self.sizes[: len(fields)]  # (5, n_basis)
        normal = -np.sin(theta) * self.frame[0] + np.cos(theta) * self.frame[1]
        radial = np.cos(theta) * self.frame[0] + np.sin(theta) * self.frame[1]
        whole = np.zeros((3, 3, local.shape[1]))
        for axis, part in ((normal, local[1] / 2), (radial, local[2]), (self.frame[2], local[4])):
            both = np.outer(normal, axis)
            whole += (both + both.T)[:, :, None] * part
        return np.asarray(whole[[0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]])


def room_at(places: EdgePlaces, which: int) -> float:
    """Distance, mm, from a place of an edge within which stress can be fitted."""
    return float(min(_SHARE_OF_ROOM * places.room[which], places.ends[which] / _BESIDE_AN_END))


def has_room(places: EdgePlaces, which: int) -> bool:
    """True if elements at a place of an edge are small enough beside the room for a fit."""
    return room_at(places, which) >= _LEAST_ROOM * float(places.sizes[which])


def notch_intensity(
    recovery: Recovery,
    displacement: FloatArray,
    places: EdgePlaces,
    which: int,
    reach: tuple[float, float] = REACH,
    beyond: float = 0.0,
) -> NotchIntensity | None:
    """Fit the fields at one place of an edge; None where there is no room or too few elements.

    displacement  (3 n_nodes, m) mm, of unit loads
    reach         distances between which stress is fitted, in sides of elements at the place
    beyond        mm, distance beyond which it is fitted in any case, as far as there is room
    """
    size = float(places.sizes[which])
    room = room_at(places, which)
    reach = (reach[0] * size, min(max(reach[1] * size, _BEYOND * beyond), room))
    if not has_room(places, which):
        return None
    elements = recovery.elements
    frame, place, angle = places.frames[which], places.points[which], float(places.angles[which])
    rows = places.near(which, np.hypot(reach[1], size) + size)
    away = (elements.points[rows] - place) @ frame.T  # (e, q, 3)
    r = np.hypot(away[..., 0], away[..., 1])
    theta = np.arctan2(away[..., 1], away[..., 0])
    taken = (r > reach[0]) & (r < reach[1]) & (np.abs(away[..., 2]) < size)
    taken &= np.abs(theta) < angle / 2
    fields = modes(angle, _HIGHEST) + (face_loads() if places.loaded[which] else ())
    if np.count_nonzero(taken) < 3 * len(fields):
        return None
    used = taken.any(axis=1)
    stress = recovery.quadrature_stress(displacement, rows[used])[taken[used]]  # (n, 6, m)
    r, theta = r[taken], theta[taken]
    # each distance counts alike: a ring's area grows with r, its stress as r^(order - 1) falls
    weight = np.sqrt(elements.weights[rows][taken] / r) * r ** (1 - fields[0].order.real)
    radial = np.cos(theta)[:, None] * frame[0] + np.sin(theta)[:, None] * frame[1]
    turned = -np.sin(theta)[:, None] * frame[0] + np.cos(theta)[:, None] * frame[1]
    axes = np.stack([radial, turned, np.broadcast_to(frame[2], radial.shape)], axis=1)
    local = np.einsum("nai,nijm,nbj->nabm", axes, _tensors(stress), axes)
    seen = np.stack([local[:, a, b] for a, b in _PAIRS], axis=1)  # (n, 5, m)
    shapes = np.stack([stress_of(field, angle, r, theta) for field in fields], axis=-1)
    design = (weight[:, None, None] * shapes).reshape(-1, len(fields))
    scale = np.linalg.norm(design, axis=0)
    sizes, *_ = np.linalg.lstsq(
        design / scale, (weight[:, None, None] * seen).reshape(len(design), -1), rcond=1e-10
    )
    return NotchIntensity(
        angle,
        frame,
        fields,
        sizes / scale[:, None],
        float(r.min()),
        float(r.max()),
    )


def _tensors(stress: FloatArray) -> FloatArray:
    """Tensors (n, 3, 3, m) of components (n, 6, m)."""
    return np.moveaxis(tensor(np.moveaxis(stress, 1, -1)), 1, -1)
