"""Buckling of a bar out of a plane by energy: as a column, and sideways where it is bent."""

from math import pi

import numpy as np

from geometry.mesh import FloatArray

_TERMS = 3


def column_force(stiffness: FloatArray, shear: FloatArray | float, length: float) -> float:
    """Buckling force, N, of a hinged column whose stiffness changes along it.

    Timoshenko's quotient with one sine wave (Timoshenko and Gere, Theory of Elastic Stability, 2nd
    ed., 2.8), with the shear strain of 2.17: integral of w'^2 over integral of w^2/(E I) + w'^2/S.
    Never below the exact force; exact for a column of constant section.

    stiffness  (k,) E I at even places from end to end, N mm2
    shear      (k,) or one S, N; infinite without shear strain

    >>> bool(np.isclose(column_force(np.full(9, 2.0), np.inf, 3.0), 2 * np.pi**2 / 9, rtol=1e-12))
    True
    """
    count = len(stiffness)
    s = np.linspace(0.0, pi, count)
    weights = np.full(count, 1.0)
    weights[[0, -1]] = 0.5
    wave, slope = np.sin(s) ** 2 * weights, (pi / length * np.cos(s)) ** 2 * weights
    return float(slope.sum() / ((wave / stiffness) + slope / shear).sum())


def plate_stress(thickness: float, width: float, young: float, poisson_ratio: float) -> float:
    """Stress, MPa, at which a long plate buckles that is pressed along and held at both edges.

    4 pi^2 E t^2/(12 (1 - nu^2) b^2) (Timoshenko and Gere, 2nd ed., 9.2).
    """
    return float(pi**2 * young / (3 * (1 - poisson_ratio**2)) * (thickness / width) ** 2)


def lateral_share(
    compression: FloatArray,
    moment: FloatArray,
    stiffness: FloatArray,
    twisting: FloatArray,
    length: float,
) -> FloatArray:
    """Share (n,) that loads are of those under which a bar buckles out of its plane.

    compression  (n,) axial force over the column's critical one out of the plane; < 0 is tension
    moment       (k, n) N mm in the plane at k even places between the ends
    stiffness    (k,) E I out of the plane, N mm2
    twisting     (k,) G J, N mm2

    A deflection aside w follows the twist t by E I w'' = -M t where both ends are held sideways.
    Then the energy integral of G J t'^2 - M^2 t^2/(E I) is stationary (Timoshenko and Gere, Theory
    of Elastic Stability, 2nd ed., 6.2 and 6.3), t = 0 at the first end and free at the second.
    Three sines of odd quarter waves are taken: a cantilever's lowest m is at most 1 % above
    4.013 sqrt(E I G J)/(F L^2). An axial force p (over critical) takes a share of the stiffness
    aside: (1 - s p) = (s m)^2 at the load factor s (same, 6.1), so the share is
    (p + sqrt(p^2 + 4 m^2))/2.
    """
    count = len(stiffness)
    s = np.linspace(0.0, 1.0, count)
    weights = np.full(count, length / (count - 1))
    weights[[0, -1]] /= 2
    order = (2 * np.arange(_TERMS) + 1) * pi / 2
    waves, slopes = np.sin(np.outer(order, s)), np.cos(np.outer(order, s)) * order[:, None] / length
    elastic = (slopes * (twisting * weights)) @ slopes.T
    root = np.linalg.inv(np.linalg.cholesky(elastic))
    normal = root @ waves  # the elastic energy of these is 1
    pairs = np.einsum("ik,jk->kij", normal, normal) * (weights / stiffness)[:, None, None]
    forms = (moment**2).T @ pairs.reshape(count, -1)
    squares = np.linalg.eigvalsh(forms.reshape(-1, _TERMS, _TERMS))[:, -1]
    bent = np.sqrt(np.maximum(squares, 0.0))
    return np.asarray((compression + np.sqrt(compression**2 + 4 * bent**2)) / 2)
