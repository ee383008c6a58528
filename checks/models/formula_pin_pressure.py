"""Pressure of lugs on a pin in the rung `formula`: along it, around it and below their edges."""

from dataclasses import dataclass

import numpy as np

from checks.handbook.pin_stress import surface_stress, under_band
from checks.models.formula_points import YZ, ZX
from geometry.mesh import FloatArray
from geometry.parts import Pin, Seat

ANGLES = np.radians(np.arange(0.0, 360.0, 15.0))
_SLICES = 8  # of a pressure that grows along a lug
_WAVES = np.stack(
    [
        np.ones_like(ANGLES),
        *(wave(n * ANGLES) for n in (1, 2, 4) for wave in (np.cos, np.sin)),
        np.zeros_like(ANGLES),  # the friction couple presses nothing
    ]
)


def _pressed() -> FloatArray:
    """Stress (3, k, 6, waves) of each wave along the pin, around it and along the radius."""
    none = np.zeros_like(_WAVES.T)
    return np.array(
        [
            surface_stress(ANGLES, none, none, _WAVES.T, none),
            surface_stress(ANGLES, none, _WAVES.T, none, none),
            surface_stress(ANGLES, _WAVES.T, none, none, none),
        ]
    )


def _sheared() -> FloatArray:
    """Stress (k, 6, waves) of each wave as a shear between the radius and z."""
    found = np.zeros((len(ANGLES), 6, len(_WAVES)))
    found[:, YZ], found[:, ZX] = (np.sin(ANGLES) * _WAVES).T, (np.cos(ANGLES) * _WAVES).T
    return found


_PRESSED, _SHEARED = _pressed(), _sheared()
_X, _Y = 1, 2  # the waves cos and sin


@dataclass(frozen=True)
class PinSection:
    """A section of the pin.

    index   in the diagram
    seat    whose lug is there, if any; `middle` of that lug, mm
    side    mm, where its surface stress is taken: off the place by next to nothing, as a lug's
            pressure ends in a step, and so does the stress; or at the place
    edge    1 or -1 just below the surface at a lug's upper or lower edge, else 0
    """

    index: int
    seat: Seat | None
    middle: float
    side: float
    edge: int = 0

    @property
    def name(self) -> str:
        """Where it is, in words."""
        return "pin" if self.seat is None else f"{self.seat.name} on the pin"


def pressure_shares(
    shape: Pin, seat: Seat, sides: FloatArray, poisson_ratio: float
) -> tuple[FloatArray, FloatArray]:
    """Stress (3, s) at places (s,) along the pin of a seat's pressure per waves around, 1/mm2.

    Of the half cosine's waves, and of the waves x and y of a couple: 1/mm3.
    """
    radius = shape.neck(seat) / 2
    middles = np.array(seat.places)
    half = seat.width / 2
    even = under_band(sides, middles - half, middles + half, radius, poisson_ratio).sum(axis=2)
    even /= np.pi * radius * seat.width * len(middles)
    centre = 0.0 if seat.paired else seat.at
    second = sum(seat.width**3 / 12 + seat.width * (z - centre) ** 2 for z in middles)
    cuts = np.concatenate([z - half + seat.width * np.arange(_SLICES) / _SLICES for z in middles])
    thin = seat.width / _SLICES
    arms = cuts + thin / 2 - centre
    grown = under_band(sides, cuts, cuts + thin, radius, poisson_ratio) @ arms
    return even, grown / (second * np.pi * radius)


def add_pressure(
    stress: FloatArray,
    even: FloatArray,
    grown: FloatArray,
    pressing: list[int],
    forces: list[int],
) -> None:
    """Add a lug's pressure: the half cosine, and of a couple one that grows along the pin.

    stress      (s, k, 6, columns) at the sections, which is added to
    even, grown (3, s) as `pressure_shares` has them
    """
    stress[..., pressing] += np.tensordot(even.T, _PRESSED, axes=1)
    # f_x = z M_y/J pushes along +x where the pressure is -cos, f_y = -z M_x/J
    couples = np.tensordot(grown.T, _PRESSED[..., [_Y, _X]], axes=1)
    stress[..., forces[2]] += couples[..., 0]
    stress[..., forces[3]] -= couples[..., 1]


def add_edge(
    stress: FloatArray,
    shape: Pin,
    section: PinSection,
    pressing: list[int],
    forces: list[int],
) -> None:
    """Add the shear just below an edge of a lug's pressure p, p/pi straight beneath it.

    A half-space's under a pressure that ends in a step (Johnson, Contact Mechanics, 1985, 2.5), to
    the stress (k, 6, columns) at one section.
    """
    seat = section.seat
    assert seat is not None
    radius, count = shape.neck(seat) / 2, len(seat.places)
    centre = 0.0 if seat.paired else seat.at
    arm = section.middle + section.edge * seat.width / 2 - centre
    second = sum(seat.width**3 / 12 + seat.width * (z - centre) ** 2 for z in seat.places)
    unit = section.edge / (np.pi**2 * radius)
    stress[..., pressing] += unit / (seat.width * count) * _SHEARED
    stress[..., forces[2]] += unit * arm / second * _SHEARED[..., _Y]
    stress[..., forces[3]] -= unit * arm / second * _SHEARED[..., _X]
