"""Stress at the outer fibres of a member's sections, by its section forces.

Section forces are those of fem/frame.py: N, V_y, V_z, T, M_y, M_z in the member's local axes, so
that at a fibre (y, z)

    xx = N / A - M_z y / I_z + M_y z / I_y

and the shear stress on the surface runs along it. Stress is xx, yy, zz, xy, yz, zx.
"""

from dataclasses import dataclass

import numpy as np

from geometry.bars import rectangle_torsion
from geometry.mesh import FloatArray

_N, _V_Y, _V_Z, _T, _M_Y, _M_Z = range(6)
_XX, _XY, _ZX = 0, 3, 5


@dataclass(frozen=True, eq=False)
class Fibres:
    """Outer fibres of one section.

    places  (f, 2)     mm, local y and z
    unit    (f, 6, 6)  MPa per N or N mm: stress by section force, local axes
    """

    places: FloatArray
    unit: FloatArray


def rectangle_fibres(height: float, width: float) -> Fibres:
    """Corners and middles of the sides of a rectangle, `height` along y and `width` along z.

    Shear is 3/2 V/A in the middles of the sides along it and none at corners (Jourawski); the peak
    of torsion stands in the middle of the longer side. In the middle of the shorter one it is
    smaller by the sides' ratio (Roark, table 10.1, case 4: exact for a square, 0.74 where thin).
    """
    y, z = height / 2, width / 2
    places = np.array([[a * y, b * z] for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b])
    area = height * width
    unit = np.zeros((len(places), 6, 6))
    unit[:, _XX, _N] = 1 / area
    unit[:, _XX, _M_Z] = -places[:, 0] / (width * height**3 / 12)
    unit[:, _XX, _M_Y] = places[:, 1] / (height * width**3 / 12)
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
