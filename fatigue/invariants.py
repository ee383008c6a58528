"""Crossland's, Dang Van's and Papadopoulos' criteria, for comparison with the verdict.

    Crossland     J + a_C p   J = radius of the smallest ball around the deviator / sqrt(3)
    Dang Van      max over time of tau(t) + a_D p(t), tau = largest shear stress of the deviator
                              about the centre of that ball
    Papadopoulos  T + a_C p   T^2 = 5/(8 pi^2) times the integral of the squared resolved shear
                              amplitude over all planes and directions

p is the hydrostatic stress, its largest value of the cycle in the first and third. From the limits
b in reversed bending and t in reversed torsion, a_C = 3 (t/b - 1/sqrt(3)), a_D = 3 (t/b - 1/2), and
the limit of each parameter is t. Crossland, Int. Conf. Fatigue of Metals, London 1956, 138; Dang
Van, ASTM STP 1191 (1993) 120; Papadopoulos et al., Int. J. Fatigue 19 (1997) 219, for hard metals,
t/b from 1/sqrt(3) on. A pressure p < 0 all through the cycle relieves in all three, as published.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import isfinite, pi, sqrt

import numpy as np

from fatigue.shear_planes import DUCTILE, resolved_shear
from fatigue.smallest_circle import smallest_ball
from fatigue.stress_path import FloatArray, check_history, deviatoric_basis, principal_stresses

_DIRECTIONS = 8  # in half a turn; exact for amplitudes squared of degree 4


@dataclass(frozen=True)
class ComparedCriteria:
    """Utilisations of one stress path by criteria that stand beside the verdict.

    shear_radius  MPa, sqrt(J2,a): radius of the smallest ball around the deviator over sqrt(3)
    pressure      MPa, largest hydrostatic stress
    crossland, dang_van, papadopoulos    parameter over limit, 1
    """

    shear_radius: float
    pressure: float
    crossland: float
    dang_van: float
    papadopoulos: float


def compared_criteria(
    stress: FloatArray, bending_limit: float, torsion_limit: float | None = None
) -> ComparedCriteria:
    """Return the utilisations of a path, stress (6, n_positions), MPa.

    Limits in reversed bending and torsion, MPa; torsion is bending/sqrt(3) where it is not given.
    """
    t = DUCTILE * bending_limit if torsion_limit is None else torsion_limit
    if not (isfinite(bending_limit) and isfinite(t) and bending_limit > 0.0 and t > 0.0):
        raise ValueError(
            "the limits in reversed bending and torsion must be above 0 MPa, "
            f"got {bending_limit:g} and {t:g}"
        )
    stress = np.asarray(stress, dtype=np.float64)
    if stress.ndim == 2 and stress.shape[0] == 6:
        check_history(np.eye(6)[None], stress)
    else:
        raise ValueError(f"a stress path must be (6, n_positions), got {stress.shape}")
    path = deviatoric_basis(stress)
    centre, radius = smallest_ball(path)
    radius /= sqrt(3.0)
    pressure = stress[:3].mean(axis=0)
    principal = principal_stresses(deviator_components((path - centre[:, None]).T))
    shear = (principal[:, 2] - principal[:, 0]) / 2.0
    ratio = t / bending_limit
    by_invariants = 3.0 * (ratio - DUCTILE) * float(pressure.max())
    by_history = float((shear + 3.0 * (ratio - 0.5) * pressure).max())
    mean_shear = _mean_resolved_shear(stress)
    return ComparedCriteria(
        shear_radius=radius,
        pressure=float(pressure.max()),
        crossland=(radius + by_invariants) / t,
        dang_van=by_history / t,
        papadopoulos=(mean_shear + by_invariants) / t,
    )


# The inverse of the rows of `deviatoric_basis`, on deviators.
_FROM_VECTOR = np.array(
    [
        [2.0 / 3.0, 0.0, 0.0, 0.0, 0.0],
        [-1.0 / 3.0, 1.0 / sqrt(3.0), 0.0, 0.0, 0.0],
        [-1.0 / 3.0, -1.0 / sqrt(3.0), 0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0 / sqrt(3.0), 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0 / sqrt(3.0), 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0 / sqrt(3.0)],
    ]
)


def deviator_components(vectors: FloatArray) -> FloatArray:
    """Return the deviators (..., 6) of vectors (..., 5): the inverse of `deviatoric_basis`."""
    return np.asarray(vectors @ _FROM_VECTOR.T)


@cache
def _sphere() -> tuple[FloatArray, FloatArray]:
    """Return normals and weights, sum 1: Gauss in the height, even in the angle; degree 15."""
    height, weight = np.polynomial.legendre.leggauss(8)
    angle = 2.0 * pi * np.arange(16) / 16
    z, a = (grid.ravel() for grid in np.meshgrid(height, angle, indexing="ij"))
    level = np.sqrt(1.0 - z**2)
    normals = np.stack([level * np.cos(a), level * np.sin(a), z], axis=1)
    return normals, np.repeat(weight / 2.0, 16) / 16.0


def _mean_resolved_shear(stress: FloatArray) -> float:
    """Return T: sqrt(5) times the root mean square of the shear amplitude over planes and angles.

    The integral over the sphere and half a turn chi has the measure 4 pi * 2 pi = 8 pi^2. Exact
    where the amplitude squared is a polynomial, as of harmonic stresses in and out of phase.
    """
    normals, weights = _sphere()
    shear = resolved_shear(normals, stress)
    mean = np.zeros(len(normals))
    for chi in pi * np.arange(_DIRECTIONS) / _DIRECTIONS:
        along = np.cos(chi) * shear[:, 0] + np.sin(chi) * shear[:, 1]
        mean += ((along.max(axis=1) - along.min(axis=1)) / 2.0) ** 2 / _DIRECTIONS
    return float(np.sqrt(5.0 * (weights @ mean)))
