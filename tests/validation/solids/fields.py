"""Exact stress fields of elasticity, to be applied as tractions on the rim of finite bodies."""

import numpy as np

_AXIAL = np.array([0.0, 0.0, 1.0])
_DELTA = np.eye(3)


def around_a_cavity(points, radius, tension, poisson_ratio):
    """Stress (..., 3, 3) around a spherical cavity in an endless body pulled along z.

    Goodier, J. Appl. Mech. 1 (1933) 39, by potentials of Papkovich and Neuber: with psi = c1 D_z
    along z and phi = c2 / r + c3 D_zz, D the derivatives of 1/r,
    2 mu u = 4 (1 - nu) psi - grad(z psi_z + phi); the three constants free the cavity of traction.
    """
    nu = poisson_ratio
    angles = np.linspace(0.1, 1.5, 9)
    skin = radius * np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=-1)
    normals = skin / radius
    pull = tension * np.outer(_AXIAL, _AXIAL)
    parts = [np.einsum("nij,nj->ni", part, normals).ravel() for part in _parts(skin, nu)]
    constants, *_ = np.linalg.lstsq(np.stack(parts, axis=1), -(normals @ pull).ravel(), rcond=None)
    whole = pull + sum(c * part for c, part in zip(constants, _parts(points, nu), strict=True))
    return whole


def _parts(points, nu):
    """The stresses of the three constants."""
    r = np.linalg.norm(points, axis=-1)[..., None, None]
    x = points[..., :, None] * points[..., None, :]  # x_i x_j
    z = points[..., 2][..., None, None]
    along = points[..., :, None] * _AXIAL + _AXIAL[:, None] * points[..., None, :]
    axial = np.outer(_AXIAL, _AXIAL)
    second = 3 * x / r**5 - _DELTA / r**3
    third = -15 * x * z / r**7 + 3 * (_DELTA * z + along) / r**5  # D_ijz
    fourth = (
        105 * x * z**2 / r**9
        - 15 * (_DELTA * z**2 + x + 2 * z * along) / r**7
        + 3 * (_DELTA + 2 * axial) / r**5
    )  # D_ijzz
    column = second[..., :, 2]  # D_iz
    mixed = _AXIAL[:, None] * column[..., None, :]  # delta_iz D_jz
    moved = mixed + np.swapaxes(mixed, -1, -2) + z * third  # second derivatives of z D_z
    slopes = [4 * (1 - nu) * mixed - moved, -second, -fourth]  # 2 mu du_i/dx_j
    stresses = []
    for slope in slopes:
        strain = (slope + np.swapaxes(slope, -1, -2)) / 2
        trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None]
        stresses.append(strain + nu / (1 - 2 * nu) * trace * _DELTA)
    return stresses


def around_a_hole(points, radius, tension, poisson_ratio):
    """Stress (..., 3, 3) around a round hole along z, pulled along x, no strain along z.

    Kirsch 1898 (Timoshenko and Goodier, section 35).
    """
    x, y, _ = np.moveaxis(points, -1, 0)
    k, angle = radius / np.hypot(x, y), np.arctan2(y, x)
    half, c, s = tension / 2, np.cos(2 * angle), np.sin(2 * angle)
    radial = half * (1 - k**2) + half * (1 - 4 * k**2 + 3 * k**4) * c
    hoop = half * (1 + k**2) - half * (1 + 3 * k**4) * c
    shear = -half * (1 + 2 * k**2 - 3 * k**4) * s
    return _from_polar(angle, radial, hoop, shear, poisson_ratio)


def in_a_curved_bar(points, inner, outer, force, poisson_ratio):
    """Stress (..., 3, 3) of a quarter ring with a radial force (per thickness) at its end y = 0.

    Timoshenko and Goodier, section 33, no strain along z.
    """
    x, y, _ = np.moveaxis(points, -1, 0)
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    squares, product = inner**2 + outer**2, (inner * outer) ** 2
    scale = force / (inner**2 - outer**2 + squares * np.log(outer / inner))
    radial = scale * (r + product / r**3 - squares / r)
    hoop = scale * (3 * r - product / r**3 - squares / r)
    sine, cosine = np.sin(angle), np.cos(angle)
    return _from_polar(angle, radial * sine, hoop * sine, -radial * cosine, poisson_ratio)


def _from_polar(angle, radial, hoop, shear, poisson_ratio):
    c, s = np.cos(angle), np.sin(angle)
    stress = np.zeros((*angle.shape, 3, 3))
    stress[..., 0, 0] = radial * c * c + hoop * s * s - 2 * shear * s * c
    stress[..., 1, 1] = radial * s * s + hoop * c * c + 2 * shear * s * c
    stress[..., 0, 1] = stress[..., 1, 0] = (radial - hoop) * s * c + shear * (c * c - s * s)
    stress[..., 2, 2] = poisson_ratio * (radial + hoop)
    return stress
