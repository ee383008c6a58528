"""Shear, bending and twist along a pin from the lugs of its stack, as a designer draws them.

Every lug presses evenly over its width: what a straight pin does in elastic lugs. A pin that bends
presses more where lugs face each other, which bends it less (docs/theory/fits.md). A couple that
closes a pin with lugs on one side is taken by the lug that the pin is fixed in, as a pressure that
grows along the lug.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import pairwise
from math import pi

import numpy as np
import numpy.typing as npt

from geometry.mesh import FloatArray
from geometry.parts import Pin, Seat

_INSIDE = 16  # sections between two changes of load or diameter
ANGLES = np.radians(np.arange(0, 180, 5))
_TIED = 1e-6  # of a stress: nearer ones are all computed


@dataclass(frozen=True, eq=False)
class PinDiagram:
    """Shear, bending and twist along a pin.

    places    (m,) mm; two sections share a place where load or diameter changes
    diameter  (m,) mm
    shear     (n, m, 2) N, along x and y
    moment    (n, m, 2) N mm, in the planes of x and y with z
    torque    (n, m) N mm, by friction in the lugs
    """

    places: FloatArray
    diameter: FloatArray
    shear: FloatArray
    moment: FloatArray
    torque: FloatArray

    @cached_property
    def bending_stress(self) -> FloatArray:
        """Largest bending stress (n, m), MPa."""
        return round_bending(np.hypot(self.moment[..., 0], self.moment[..., 1]), self.diameter)

    @cached_property
    def shear_stress(self) -> FloatArray:
        """Largest shear stress (n, m), MPa: at a rim where shear and twist run the same way."""
        return round_shear(np.hypot(self.shear[..., 0], self.shear[..., 1]), self.diameter) + (
            self.twist_stress
        )

    @cached_property
    def twist_stress(self) -> FloatArray:
        """Largest shear stress by the torque alone (n, m), MPa."""
        return round_torsion(np.abs(self.torque), self.diameter)

    @property
    def equivalent_peaks(self) -> FloatArray:
        """Von Mises stress of bending with shear and twist (n, m), MPa, where it may be largest.

        Elsewhere a bound from below. At the angle a of the rim bending is cos(a - a_M) of its
        largest and shear, the same all across (Jourawski), sin^2(a - a_V); inside the section
        bending is less and shear the same. The twist runs with the shear on one of two opposite
        rims, which are bent alike. The stress is at most what bending and shear have at one place,
        sqrt(sigma^2 + 3 tau^2), and at least either of them.
        """
        bent, sheared = self.bending_stress**2, 3 * self.shear_stress**2
        least = np.sqrt(np.maximum(bent, sheared))
        near = np.sqrt(bent + sheared) >= (1 - _TIED) * least.max()
        least[near] = self._equivalent(near)
        return np.asarray(least)

    def rim_at(self, position: int, section: int) -> float | None:
        """Angle of the rim, rad from where it is bent most, with the largest von Mises stress.

        None in the middle of the section, where nothing is bent.
        """
        chosen = np.zeros(self.torque.shape, dtype=bool)
        chosen[position, section] = True
        worst = int(np.argmax(list(self._rims(chosen))))
        return float(ANGLES[worst - 1]) if worst else None

    def _equivalent(self, chosen: npt.NDArray[np.bool_]) -> FloatArray:
        """Largest von Mises stress (k,) of the chosen (n, m), MPa."""
        return reduce(np.maximum, self._rims(chosen))

    def _rims(self, chosen: npt.NDArray[np.bool_]) -> Iterator[FloatArray]:
        """Von Mises stress (k,) of the chosen (n, m), MPa: in the middle, then at every angle."""
        bending, twist = self.bending_stress[chosen], self.twist_stress[chosen]
        shear = self.shear_stress[chosen] - twist
        yield np.sqrt(3) * (shear + twist)  # in the middle, where nothing is bent
        moment, force = self.moment[chosen], self.shear[chosen]
        along_m = np.arctan2(moment[:, 1], moment[:, 0])
        along_v = np.arctan2(force[:, 1], force[:, 0])
        for turn in ANGLES:
            angle = along_m + turn
            bent = bending * np.cos(turn)
            sheared = shear * np.sin(angle - along_v) ** 2 + twist
            yield np.sqrt(bent**2 + 3 * sheared**2)


def pin_diagram(
    shape: Pin, wrenches: dict[str, FloatArray], *, ends_only: bool = False
) -> PinDiagram:
    """Shear and bending along a pin under the wrenches (n, 6) of its seats.

    ends_only  of stretches without pressure only both ends: shear is even there and the moment
               linear, so that every stress is largest at one of them
    """
    points, diameters = _stations(shape, ends_only=ends_only)
    share, lever, turned, pulled = np.zeros((4, len(shape.seats), len(points)))
    for k, seat in enumerate(shape.seats):
        for part in _pressed(seat, points):
            for total, own in zip((share, lever, turned, pulled), part, strict=True):
                total[k] += own
    count = np.array([len(seat.places) for seat in shape.seats])
    acting = np.stack([wrenches[seat.name] for seat in shape.seats], axis=1)  # (n, seats, 6)
    # the two directions stand apart in memory, each is read and written by itself
    shear, moment = np.moveaxis(np.empty((2, 2, len(acting), len(points))), 1, -1)
    for axis, dipole in ((0, acting[:, :, 4]), (1, -acting[:, :, 3])):
        force = acting[:, :, axis] / count
        shear[..., axis] = force @ share + dipole @ pulled
        moment[..., axis] = force @ lever + dipole @ turned
    return PinDiagram(points, diameters, shear, moment, acting[:, :, 5] / count @ share)


_Part = tuple[FloatArray, FloatArray, FloatArray, FloatArray]


def _pressed(seat: Seat, points: FloatArray) -> list[_Part]:
    """Per lug: shear and moment of 1 N, pressed evenly; moment and shear of the seat's dipole.

    The moment of forces at heights z is sum z F; a couple (M_x, M_y) is the dipole (M_y, -M_x),
    which a pressure takes that grows along z.
    """
    half = seat.width / 2
    centre = 0.0 if seat.paired else seat.at
    second = sum(seat.width**3 / 12 + seat.width * (z - centre) ** 2 for z in seat.places)
    parts = []
    for place in seat.places:
        low = place - half
        inside = np.clip(points - low, 0.0, seat.width)  # of the lug, below the section
        after = np.maximum(points - place - half, 0.0)  # of the pin, beyond the lug
        share = inside / seat.width
        lever = inside**2 / (2 * seat.width) + after
        # q = s / J, s = z - centre: its integral is the shear, once more the moment
        start = low - centre
        pulled = (start * inside + inside**2 / 2) / second
        turned = (start * inside**2 / 2 + inside**3 / 6) / second + pulled * after
        parts.append((share, lever, turned, pulled))
    return parts


def _stations(shape: Pin, *, ends_only: bool) -> tuple[FloatArray, FloatArray]:
    """Sections along a pin, mm, from stretch to stretch of equal load and diameter."""
    seated = shape.seated()
    necks = [(low, high, seat.diameter or shape.diameter) for seat, low, high in seated]
    cuts = {shape.ends[0], shape.ends[1]}
    for low, high, _ in necks:
        cuts |= {low, (low + high) / 2, high}
    edges = sorted(cuts)
    points, diameters = [], []
    for start, stop in pairwise(edges):
        middle = (start + stop) / 2
        own = next((d for low, high, d in necks if low < middle < high), None)
        count = 2 if ends_only and own is None else _INSIDE + 1
        points.append(np.linspace(start, stop, count))
        diameters.append(np.full(count, own or shape.diameter))
    return np.concatenate(points), np.concatenate(diameters)


# Stress of a round pin by formula.


def round_bending(moment: FloatArray, diameter: FloatArray) -> FloatArray:
    """Largest bending stress of a round bar, MPa: 32 M / (pi d^3)."""
    return 32 * moment / (pi * diameter**3)


def round_shear(force: FloatArray, diameter: FloatArray) -> FloatArray:
    """Largest shear stress of a round bar, MPa: 4/3 of V / A, in the middle (Jourawski)."""
    return 16 * force / (3 * pi * diameter**2)


def round_torsion(torque: FloatArray, diameter: FloatArray) -> FloatArray:
    """Largest shear stress of a twisted round bar, MPa: 16 T / (pi d^3)."""
    return 16 * torque / (pi * diameter**3)
