"""Pressure in a meshed bore that is uneven along the pin.

A shape along a lug, 1 + sum of a_k P_k(t) with Legendre's polynomials over t from -1 to 1, times
the even pressure around. It has the same force; P_1 is a couple, which bends a cheek.
Long waves around load the elements, short ones have the stress of a sheet (fem/contact/bore.py).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fem.contact.beds import Along, Lug, RoundBar, bore_bed
from fem.contact.bore import BoreHarmonics
from fem.contact.line_load import LineLoad
from fem.unit_loads import nodal_forces, resultants
from geometry.mesh import FloatArray

ORDERS = 2  # of the polynomials, a tilt and a bow: what is steeper is at the edges alone
_GAUSS = np.polynomial.legendre.leggauss(4)
_FLAT = 1e-6  # of the bore's length: cheeks are farther apart


def shares_along(pressed: LineLoad, lug: int) -> FloatArray:
    """The a_k (ORDERS,), from k = 1, of the line load of a lug over its mean.

    >>> from fem.contact.beds import Along, Lug, RoundBar
    >>> lug, hats = Lug(0.0, 2.0, (2.0, 0.0), 1.0, 0.3), Along(np.array([0.0, 1.0, 2.0]))
    >>> bar = RoundBar((0.0, 2.0), (1.0,), 1.0, 0.3)
    >>> grows = LineLoad(bar, [lug], [hats], [hats.nodes * hats.lengths])
    >>> bool(np.allclose(shares_along(grows, 0), [1.0, 0.0]))
    True
    """
    hats, one = pressed.hats[lug], pressed.lugs[lug]
    steps = np.diff(hats.nodes)
    z = hats.nodes[:-1, None] + steps[:, None] * (1 + _GAUSS[0]) / 2
    weight: FloatArray = steps[:, None] * _GAUSS[1] / 2
    line = np.interp(z, hats.nodes, pressed.intensity(lug)) / one.size
    t = 2 * (z - one.low) / one.width - 1
    orders = range(1, ORDERS + 1)
    return np.array([(2 * k + 1) * (weight * line * _legendre(k, t)).sum() for k in orders])


def _legendre(order: int, t: FloatArray) -> FloatArray:
    return np.asarray(np.polynomial.legendre.legval(t, np.eye(order + 1)[order]))


def shape_along(shares: FloatArray, t: FloatArray) -> FloatArray:
    """Sum of a_k P_k at places t (...) of a lug: the line load over its mean, less 1."""
    return np.asarray(np.polynomial.legendre.legval(t, np.r_[0.0, shares]))


def turn_in_bore(bar: RoundBar, lug: Lug) -> float:
    """Turn, rad/(N mm), that a bore alone, unlined, gives a couple of its pressure."""
    hats = Along.graded(lug, 12)
    own = (hats.places - (lug.low + lug.high) / 2) * hats.lengths * 12 / lug.width**3
    return float(own @ bore_bed(bar, replace(lug, lining=None), hats) @ own)


@dataclass(frozen=True, eq=False)
class BoreAlong:
    """A meshed bore along its pin: one lug about z = 0, or two alike on both sides of it."""

    harmonics: BoreHarmonics

    @cached_property
    def faces(self) -> tuple[float, float]:
        """The z of the faces of the lug, or of the upper one of a pair, mm."""
        mesh, interface = self.harmonics.solutions.mesh, self.harmonics.loads.interface
        height = np.abs(mesh.nodes[mesh.surfaces[interface.name]][..., 2])
        high = float(height.max())
        # of a single lug some facet meets the middle plane
        gap = float(height.min(axis=1).min())
        signed = mesh.nodes[mesh.surfaces[interface.name]][..., 2]
        crosses = bool(((signed.min(axis=1) < 0) & (signed.max(axis=1) > 0)).any())
        return (-high, high) if crosses or gap < _FLAT * interface.length else (gap, high)

    @property
    def paired(self) -> bool:
        """True if there are two lugs."""
        return self.faces[0] >= 0.0

    def places(self, z: FloatArray) -> FloatArray:
        """Places in a lug, -1 to 1, of heights z; of a pair outwards."""
        low, high = self.faces
        away = np.abs(z) if self.paired else z
        return np.asarray(np.clip(2 * (away - low) / (high - low) - 1, -1.0, 1.0))

    def vector(self, waves: FloatArray, shares: FloatArray) -> FloatArray:
        """Nodal forces (3 n_nodes,), N, of pressure with an uneven shape, without the even one.

        waves   (2 last + 1,) N, of the even pressure
        shares  (ORDERS,) a_k
        """
        bore = self.harmonics
        interface, elements = bore.loads.interface, bore.solutions.elements

        def traction(points: FloatArray) -> FloatArray:
            arm = points - interface.centre
            angle = np.arctan2(arm[..., 1], arm[..., 0])
            size = bore.unit_pressures(angle) @ waves
            size = size * shape_along(shares, self.places(points[..., 2]))
            outward = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
            return np.asarray(outward * size[..., None])

        found = nodal_forces(elements, elements.surface(interface.name), traction)
        left = resultants(elements, found[:, None], interface.centre)[:2, 0] / bore.share
        return np.asarray(found - bore.vectors[:, 1:3] @ left)

    def tilt(self, bar: RoundBar, lug: Lug, waves: FloatArray) -> float:
        """Turn of one lug of a pair, rad/(N mm), under a couple of its pressure; 0 of a single one.

        What the part gives way to a pressure that grows along the lug, less what the bore does.

        lug    as the pin knows it
        waves  (2 last + 1,) N, of a pressure whose force is the direction of the couple's arm
        """
        if not self.paired:
            return 0.0
        solutions = self.harmonics.solutions
        force = float(np.hypot(*waves[1:3]))
        vector = self.vector(waves / force, np.eye(ORDERS)[0])
        work = float(vector @ solutions.solve(vector[:, None])[:, 0]) / self.harmonics.share / 2
        couple = lug.width / 12  # half of 1 N on each lug
        return max(work / couple**2 - turn_in_bore(bar, lug), 0.0)

    def short_wave_stress(self, pressure: FloatArray, shares: FloatArray) -> FloatArray:
        """Stress (n, 6), MPa, at the bore's points of short waves of pressure (n,), unevenly."""
        bore = self.harmonics
        nodes = bore.solutions.recovery.points[bore.points]
        t = self.places(bore.solutions.mesh.nodes[nodes, 2])
        return bore.short_wave_stress * (pressure * shape_along(shares, t))[:, None]
