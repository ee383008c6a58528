"""Closed-form stress and displacement fields of plane elasticity."""

import numpy as np

from geometry.mesh import FloatArray


def tractions_of(stress):
    """The traction on an edge of a stress field: points (..., 2) -> (..., 3) of xx, yy, xy."""

    def traction(points: FloatArray, normals: FloatArray) -> FloatArray:
        xx, yy, xy = np.moveaxis(stress(points), -1, 0)
        x, y = np.moveaxis(normals, -1, 0)
        return np.stack([xx * x + xy * y, xy * x + yy * y], axis=-1)

    return traction


def kirsch_stress(points: FloatArray, radius: float, far: float) -> FloatArray:
    """Stress xx, yy, xy around a hole in an infinite sheet under tension `far` along x.

    G. Kirsch (1898); Timoshenko and Goodier, 3rd ed., equations (61).
    """
    x, y = np.moveaxis(points, -1, 0)
    angle, k2 = np.arctan2(y, x), radius**2 / (x**2 + y**2)
    double = np.cos(2 * angle)
    normal = far / 2 * (1 - k2 + (1 - 4 * k2 + 3 * k2**2) * double)
    hoop = far / 2 * (1 + k2 - (1 + 3 * k2**2) * double)
    shear = -far / 2 * (1 + 2 * k2 - 3 * k2**2) * np.sin(2 * angle)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack(
        [
            normal * c**2 + hoop * s**2 - 2 * shear * s * c,
            normal * s**2 + hoop * c**2 + 2 * shear * s * c,
            (normal - hoop) * s * c + shear * (c**2 - s**2),
        ],
        axis=-1,
    )


def ring_end_traction(inner: float, outer: float, force: float):
    """Traction on the end theta = 0 of a quarter ring: `force` per thickness to the centre.

    Timoshenko and Goodier, 3rd ed., article 33.
    """
    squares = inner**2 + outer**2
    n = inner**2 - outer**2 + squares * np.log(outer / inner)

    def traction(points: FloatArray, _normals: FloatArray) -> FloatArray:
        r = points[..., 0]
        along = force / n * (r + inner**2 * outer**2 / r**3 - squares / r)
        return np.stack([along, 0 * r], axis=-1)

    return traction


class Cantilever:
    """FE-03: a cantilever under a parabolic end shear, sign as in the case.

    Timoshenko and Goodier, 3rd ed., article 21; a root that moves as the exact field does.
    """

    load, young, poisson, length, depth = 1000.0, 3e7, 0.3, 48.0, 12.0
    inertia = 144.0

    @classmethod
    def displacement(cls, points: FloatArray) -> FloatArray:
        x, y = np.moveaxis(points, -1, 0)
        p, e, i, nu, length = cls.load, cls.young, cls.inertia, cls.poisson, cls.length
        quarter = cls.depth**2 / 4
        u = -p * y / (6 * e * i) * ((6 * length - 3 * x) * x + (2 + nu) * (y**2 - quarter))
        v = (
            p
            / (6 * e * i)
            * (3 * nu * y**2 * (length - x) + (4 + 5 * nu) * quarter * x + (3 * length - x) * x**2)
        )
        return np.stack([u, v], axis=-1)

    @classmethod
    def root(cls):
        """The exact displacement as a support."""
        return tuple(lambda points, k=k: cls.displacement(points)[:, k] for k in range(2))

    @classmethod
    def stress(cls, points: FloatArray) -> FloatArray:
        """Stress xx, yy, xy."""
        x, y = np.moveaxis(points, -1, 0)
        xx = -cls.load * (cls.length - x) * y / cls.inertia
        xy = cls.load / (2 * cls.inertia) * (cls.depth**2 / 4 - y**2)
        return np.stack([xx, 0 * x, xy], axis=-1)


def elliptic_hole_stress(points: FloatArray, along: float, across: float, far: float) -> FloatArray:
    """Stress xx, yy, xy around a free elliptic hole in an infinite sheet under tension along y.

    along, across  semi-axes of the hole along x and along y

    N. I. Muskhelishvili, Some Basic Problems of the Mathematical Theory of Elasticity, section 82a:
    complex potentials on the exterior of the unit circle, z = c (s + m / s).
    """
    z = points[..., 0] + 1j * points[..., 1]
    c, m, turn = (along + across) / 2, (along - across) / (along + across), -1.0
    root = np.sqrt(z - 2 * c * np.emath.sqrt(m)) * np.sqrt(z + 2 * c * np.emath.sqrt(m))
    s = (z + root) / (2 * c)  # the branch outside the circle
    slope, slope2 = c * (1 - m / s**2), 2 * c * m / s**3
    phi1 = far * c / 4 * (1 - (2 * turn - m) / s**2)
    phi2 = far * c / 2 * (2 * turn - m) / s**3
    rest = (1 + m**2) * (turn - m) / m
    psi1 = -far * c / 2 * (turn - turn / (m * s**2) + rest * (s**2 + m) / (s**2 - m) ** 2)
    total = 4 * np.real(phi1 / slope)
    curl = (phi2 * slope - phi1 * slope2) / slope**3
    apart = 2 * (np.conj(z) * curl + psi1 / slope)
    return np.stack(
        [(total - apart.real) / 2, (total + apart.real) / 2, apart.imag / 2],
        axis=-1,
    )
