"""Notch stress intensities along sharp re-entrant edges, for every unit load of a part.

Near an edge the stress is a sum of Williams' fields (`williams`). Their sizes are fitted to the
stress at the integration points of the elements around a place of the edge, without those that meet
the edge, whose shape functions cannot follow it: least squares, each point weighted so that all
distances count alike. The sizes are linear functionals of the displacement, so those of unit loads
add up as stresses do.

Williams' stresses at a sharp edge with free faces: eigenvalues and angular functions.

In polar coordinates about the edge, theta from the bisector of the body (M. L. Williams, J. Appl.
Mech. 19 (1952) 526), Airy's function r^(lambda + 1) F(theta) leaves both faces theta = +-omega/2
free where

    sin(lambda omega) + lambda sin(omega) = 0   symmetric:      F = A cos(l+1)t + B cos(l-1)t
    sin(lambda omega) - lambda sin(omega) = 0   antisymmetric:  F = A sin(l+1)t + B sin(l-1)t

with omega the interior angle. Complex roots give two real fields each. Out of the plane the
displacement r^mu sin(mu theta) or r^mu cos(mu theta) does so with mu = n pi / omega, n odd or even.
All of them together are complete: they describe any stress near the edge that does not change along
it, while both faces are free; even loads of the faces add six fields. The singular ones are scaled
as Gross and Mendelson do (Int. J. Fract. Mech. 8 (1972) 267): on the bisector the stress is
K / sqrt(2 pi) r^(lambda - 1).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from fem.recovery import Recovery, tensor
from fem.singularity import EdgePlaces
from geometry.mesh import FloatArray

_ROTATION = 1e-4  # of 1: an antisymmetric root that near is the rigid rotation's


@dataclass(frozen=True)
class Mode:
    """One field of stress at an edge.

    order     lambda or mu; its stress goes with r^(order - 1)
    family    "symmetric", "antisymmetric", "out of plane" or "faces"
    part      0: the real field, or the real part of a complex one; 1: its imaginary part; of faces
              which of the six
    leading   whether it is the first of its family
    """

    order: complex
    family: str
    part: int = 0
    leading: bool = False


@lru_cache(maxsize=64)
def modes(interior_angle: float, highest: float) -> tuple[Mode, ...]:
    """Fields with the real part of their order up to `highest`, the three leading ones first.

    interior_angle  rad, above pi

    Leading are the first symmetric, the first antisymmetric and the first out of plane, whether
    their stress is singular or not. Raises ValueError for an angle that has no re-entrant edge.
    """
    if not np.pi < interior_angle <= 2 * np.pi:
        raise ValueError(f"an interior angle above pi and up to 2 pi rad, got {interior_angle:g}")
    found: list[Mode] = []
    leading: list[Mode] = []
    for family, sign in (("symmetric", 1.0), ("antisymmetric", -1.0)):
        orders = _roots(interior_angle, sign, highest)
        own = [
            Mode(order, family, part) for order in orders for part in range(1 + (order.imag > 0))
        ]
        leading.append(replace(own[0], leading=True))
        found += own[1:]
    out = [
        Mode(complex(n * np.pi / interior_angle), "out of plane")
        for n in range(1, 1 + int(highest * interior_angle / np.pi))
    ]
    return (*leading, out[0], *found, *out[1:])


def face_loads() -> tuple[Mode, ...]:
    """Six fields that leave even stress on the faces: any even load of both is a sum of them.

    Airy's function r^2 times 1, cos 2t, sin 2t and t, and even shear out of the plane.
    """
    return tuple(Mode(1.0 + 0j, "faces", part) for part in range(6))


def stress_of(mode: Mode, interior_angle: float, r: FloatArray, theta: FloatArray) -> FloatArray:
    """Stress (n, 5) rr, tt, rt, zr, tz of a field of size 1 at r (n,) and theta (n,).

    A leading field is 1 / sqrt(2 pi) r^(order - 1) on the bisector: tt of a symmetric one, rt of an
    antisymmetric one, tz of one out of plane. Of others the largest tt or rr is that.
    """
    stress = np.zeros((len(r), 5))
    order = mode.order
    if mode.family == "faces":
        one, cosine, sine = np.ones(len(r)), np.cos(2 * theta), np.sin(2 * theta)
        zero, turned = np.zeros(len(r)), (np.cos(theta), np.sin(theta))
        return np.stack(
            (
                (2 * one, 2 * one, zero, zero, zero),
                (-2 * cosine, 2 * cosine, 2 * sine, zero, zero),
                (-2 * sine, 2 * sine, -2 * cosine, zero, zero),
                (2 * theta, 2 * theta, -one, zero, zero),
                (zero, zero, zero, turned[0], -turned[1]),
                (zero, zero, zero, turned[1], turned[0]),
            )[mode.part],
            axis=1,
        )
    if mode.family == "out of plane":
        mu = order.real
        size = r ** (mu - 1) / np.sqrt(2 * np.pi)
        odd = round(mu * interior_angle / np.pi) % 2
        along, across = (np.sin, np.cos) if odd else (np.cos, np.sin)
        stress[:, 3] = size * along(mu * theta)
        stress[:, 4] = (1.0 if odd else -1.0) * size * across(mu * theta)
        return stress
    own = _angular(mode, interior_angle, theta)
    if mode.leading:
        row = 1 if mode.family == "symmetric" else 2
        size = _angular(mode, interior_angle, np.zeros(1))[row, 0]
    else:
        around = np.linspace(0.0, interior_angle / 2, 91)
        size = np.abs(_angular(mode, interior_angle, around)).max()
    whole = own * (r ** (order - 1) / size / np.sqrt(2 * np.pi))
    stress[:, :3] = (whole.imag if mode.part else whole.real).T
    return stress


def _angular(mode: Mode, interior_angle: float, theta: FloatArray) -> npt.NDArray[np.complex128]:
    """Stress (3, n) rr, tt, rt at r = 1 of some size."""
    order = mode.order
    shape, slope, curve = _airy(order, mode.family, interior_angle, theta)
    return np.stack([curve + (order + 1) * shape, order * (order + 1) * shape, -order * slope])


def _airy(
    order: complex, family: str, interior_angle: float, theta: FloatArray
) -> tuple[npt.NDArray[np.complex128], ...]:
    """Airy's angular function and its first two slopes at theta (n,), complex as its order."""
    high, low, face = order + 1, order - 1, interior_angle / 2
    if family == "symmetric":
        # F(face) = 0 gives the ratio; where both cosines vanish there, F'(face) = 0 does
        first, second = np.cos(low * face), -np.cos(high * face)
        if abs(first) + abs(second) < 1e-9:
            first, second = low * np.sin(low * face), -high * np.sin(high * face)
        shape = first * np.cos(high * theta) + second * np.cos(low * theta)
        slope = -first * high * np.sin(high * theta) - second * low * np.sin(low * theta)
        curve = -first * high**2 * np.cos(high * theta) - second * low**2 * np.cos(low * theta)
        return shape, slope, curve
    first, second = low * np.cos(low * face), -high * np.cos(high * face)
    if abs(first) + abs(second) < 1e-9:
        first, second = np.sin(low * face), -np.sin(high * face)
    shape = first * np.sin(high * theta) + second * np.sin(low * theta)
    slope = first * high * np.cos(high * theta) + second * low * np.cos(low * theta)
    curve = -first * high**2 * np.sin(high * theta) - second * low**2 * np.sin(low * theta)
    return shape, slope, curve


def _roots(interior_angle: float, sign: float, highest: float) -> list[complex]:
    """Roots with a positive real part up to `highest`, ascending, of pairs that above the axis."""
    sine = np.sin(interior_angle)
    real, imaginary = np.meshgrid(np.arange(0.3, highest + 0.3, 0.05), np.arange(0.0, 1.6, 0.1))
    root = (real + 1j * imaginary).ravel()
    with np.errstate(all="ignore"):
        for _ in range(60):
            value = np.sin(root * interior_angle) + sign * root * sine
            change = interior_angle * np.cos(root * interior_angle) + sign * sine
            root = root - value / change
        left = np.abs(np.sin(root * interior_angle) + sign * root * sine)
    root = root[np.isfinite(root) & (left < 1e-10)]
    root = root[(root.real > 0.3) & (root.real <= highest) & (root.imag > -1e-8)]
    if sign < 0:
        root = root[np.abs(root - 1) > _ROTATION]
    found: list[complex] = []
    for one in sorted(root, key=lambda z: (round(z.real, 7), z.imag)):
        if not any(abs(one - other) < 1e-6 for other in found):
            found.append(complex(one.real, one.imag if one.imag > 1e-6 else 0.0))
    return found


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
        angle, frame, fields, sizes / scale[:, None], float(r.min()), float(r.max())
    )


def _tensors(stress: FloatArray) -> FloatArray:
    """Tensors (n, 3, 3, m) of components (n, 6, m)."""
    return np.moveaxis(tensor(np.moveaxis(stress, 1, -1)), 1, -1)
