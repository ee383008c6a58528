"""Stress at the outer fibres of a member's sections, by its section forces.

Section forces are those of fem/frame.py: N, V_y, V_z, T, M_y, M_z in the member's local axes, so
that at a fibre (y, z)

    xx = N / A - M_z y / I_z + M_y z / I_y

and the shear stress on the surface runs along it. Stress is xx, yy, zz, xy, yz, zx.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from fem.frame_sections import rectangle_torsion
from geometry.mesh import FloatArray

_N, _V_Y, _V_Z, _T, _M_Y, _M_Z = range(6)
_XX, _XY, _ZX = 0, 3, 5
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))


@dataclass(frozen=True, eq=False)
class Fibres:
    """Outer fibres of one section.

    places  (f, 2)     mm, local y and z
    unit    (f, 6, 6)  MPa per N or N mm: stress by section force, local axes
    """

    places: FloatArray
    unit: FloatArray

    def notched(self, axial: float, bending: float, torsion: float = 1.0) -> Self:
        """The same fibres with stress concentration factors on their nominal stress."""
        factors = np.array([axial, 1.0, 1.0, torsion, bending, bending])
        return replace(self, unit=self.unit * factors)

    def chosen(self, which: FloatArray) -> Self:
        """Some of the fibres, by number or by mask."""
        return replace(self, places=self.places[which], unit=self.unit[which])

    def turned(self, axes: FloatArray) -> FloatArray:
        """Stress by section force in global axes, (f, 6, 6); the rows of `axes` are local axes."""
        tensor = np.zeros((*self.unit.shape[:1], 3, 3, 6))
        for k, (i, j) in enumerate(_PAIRS):
            tensor[:, i, j] = tensor[:, j, i] = self.unit[:, k]
        whole = np.einsum("ia,fijk,jb->fabk", axes, tensor, axes, optimize=True)
        return np.stack([whole[:, i, j] for i, j in _PAIRS], axis=1)


def _bent(places: FloatArray, area: float, inertia_y: float, inertia_z: float) -> FloatArray:
    unit = np.zeros((len(places), 6, 6))
    unit[:, _XX, _N] = 1 / area
    unit[:, _XX, _M_Z] = -places[:, 0] / inertia_z
    unit[:, _XX, _M_Y] = places[:, 1] / inertia_y
    return unit


def rectangle_fibres(height: float, width: float) -> Fibres:
    """Corners and middles of the sides of a rectangle, `height` along y and `width` along z.

    Shear is 3/2 V/A in the middles of the sides along it and none at corners (Jourawski); the peak
    of torsion stands in the middle of the longer side. In the middle of the shorter one it is
    smaller by the sides' ratio (Roark, table 10.1, case 4: exact for a square, 0.74 where thin).
    """
    y, z = height / 2, width / 2
    places = np.array([[a * y, b * z] for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b])
    area = height * width
    unit = _bent(places, area, height * width**3 / 12, width * height**3 / 12)
    constant, modulus = (float(value) for value in rectangle_torsion(height, width))
    assert constant > 0
    longer = max(height, width)
    on_z, on_y = places[:, 0] == 0, places[:, 1] == 0
    unit[on_z, _XY, _V_Y] = 1.5 / area
    unit[on_y, _ZX, _V_Z] = 1.5 / area
    # a torque turns y to z: on the face at z > 0 the shear runs along -y
    unit[on_z, _XY, _T] = -np.sign(places[on_z, 1]) * height / longer / modulus
    unit[on_y, _ZX, _T] = np.sign(places[on_y, 0]) * width / longer / modulus
    return Fibres(places, unit)


def round_fibres(
    diameter: float, bore: float = 0.0, *, poisson_ratio: float = 0.3, count: int = 36
) -> Fibres:
    """Fibres all round the rim of a round bar or tube.

    Shear by a transverse force runs along the rim, as sin of the angle from the force: (1 + 2 nu)/
    (1 + nu) V/A at its most in a bar (Timoshenko and Goodier, Theory of Elasticity, 3rd ed.,
    section 121), 4/3 (R^2 + R r + r^2)/(R^2 + r^2) V/A in a tube (Jourawski).
    """
    outer, inner = diameter / 2, bore / 2
    angle = 2 * np.pi * np.arange(count) / count
    c, s = np.cos(angle), np.sin(angle)
    places = outer * np.stack([c, s], axis=1)
    area = np.pi * (outer**2 - inner**2)
    inertia = np.pi / 4 * (outer**4 - inner**4)
    unit = _bent(places, area, inertia, inertia)
    if inner:
        most = 4 / 3 * (outer**2 + outer * inner + inner**2) / (outer**2 + inner**2)
    else:
        most = (1 + 2 * poisson_ratio) / (1 + poisson_ratio)
    twist = outer / (2 * inertia)
    for row, along in ((_XY, -s), (_ZX, c)):
        unit[:, row, _V_Y] = -most / area * s * along
        unit[:, row, _V_Z] = most / area * c * along
        unit[:, row, _T] = twist * along
    return Fibres(places, unit)


def square_tube_fibres(width: float, wall: float, area: float, inertia: float) -> Fibres:
    """Corners and middles of the walls of a square tube.

    Shear in the middle of the walls along it is V Q/(2 I t) (Jourawski), torsion T/(2 A_m t)
    everywhere (Bredt); at corners both walls' shear is not added.
    """
    half, inner = width / 2, width - 2 * wall
    places = np.array([[a * half, b * half] for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b])
    unit = _bent(places, area, inertia, inertia)
    shear = (width**3 - inner**3) / 8 / (2 * inertia * wall)
    twist = 1 / (2 * (width - wall) ** 2 * wall)
    on_z, on_y = places[:, 0] == 0, places[:, 1] == 0
    unit[on_z, _XY, _V_Y] = shear
    unit[on_y, _ZX, _V_Z] = shear
    unit[:, _XY, _T] = np.where(on_y, 0.0, -np.sign(places[:, 1]) * twist)
    unit[on_y, _ZX, _T] = np.sign(places[on_y, 0]) * twist
    return Fibres(places, unit)
