"""Linear buckling of frames: geometric stiffness of members, factors, proof of their count.

The work of the axial force on the slope of the deflection, 1/2 integral N (v'^2 + w'^2 + r^2 t'^2),
is taken with the member's own exact deflection: curvature and shear strain follow from its end
forces, so the slope is an unloaded Timoshenko member's, v' = turn + shear strain. A prismatic
pinned column then tends to Engesser's load Pe / (1 + Pe / k G A), and to Euler's without shear.
t' is the twist and r^2 = (I_y + I_z) / A (Wagner; Timoshenko and Gere, Theory of Elastic Stability,
2nd ed., 5.3 and 2.17). Bending moments do not act on the twist here (no lateral buckling of beams).

Every assumed deflection is a possible one, so factors come from above and fall with h^4.

Geometric stiffness of a frame under all section forces: columns, and bent bars that twist aside.

A section moves by u = (-y v' - z w', v - z t, w + y t) with the turns' signs of fem/frame.py. The
second-order work 1/2 integral s_ij u_k,i u_k,j of the stresses in a section, integrated over it, is
with N = int s_xx, M_y = int z s_xx, M_z = -int y s_xx, V = int s_xy and so on

    W = 1/2 N (v'^2 + w'^2 + r^2 t'^2) - M_z t' w' - M_y t' v' + V_y w' t - V_z v' t

per length: the first term is the column's (fem/frame_buckling.py), the others give lateral buckling
of a beam that is bent (-(M_z t)' w' after V_y = -M_z'; Timoshenko and Gere, Theory of Elastic
Stability, 2nd ed., 6.1; Yang and Kuo, Theory and Analysis of Nonlinear Framed Structures, 1994,
chapter 6).

It is the form of the solid's geometric stiffness. In it a moment M_z at a member's end comes from
parallel forces along x. A joint turns by (a, b, c) without strain, and the work of the stress in it
is 1/2 (tr S - S) of these, S = sum of the forces times their places (virial): -S_xy a b for S_xy =
M_z at a member's end and -M_z at its start. By balance S_xy is also the sum over the forces along y
of the members that leave aside, so each member brings half of its own,

    -1/2 [M_z a b] + 1/2 [M_y a c]  from start to end,

in its own axes. It cancels between members in line, and makes couples from outside those of forces
that keep their direction, half along each of two axes (semi-tangential, Argyris), as a friction
all round a bore is. Left out: effects of torque, the warping of sections, forces beside the axis.
"""

from dataclasses import dataclass, replace

import numpy as np

from fem.frame import POINTS, WEIGHTS, Frame
from fem.solvers import SolverError
from geometry.mesh import FloatArray

_N, _V_Y, _V_Z, _T, _M_Y, _M_Z = range(6)

_NONE = 1e-9  # of the largest factor's inverse: below it, round-off
_BESIDE = 1e-6  # of a factor: how far from it the modes are counted
_MECHANISM = 1e-13  # of the largest: stiffness below it is none, in unknowns of equal stiffness
_ROUND_OFF = 4 * np.finfo(float).eps  # of the largest stiffness, in the same unknowns


class LooseFrameError(ValueError):
    """A frame in which something moves without strain, or without any that double precision has."""


@dataclass(frozen=True, eq=False)
class FrameModes:
    """Buckling modes of one load state, lowest first.

    factors    (k,) load factors above 0
    shapes     (n, k) unknowns, without a scale of their own
    reversed   the factor of the loads turned round, > 0, that buckles first; None: none does
    round_off  of a factor, over it: members of unlike stiffness leave few digits to the softest
    """

    factors: FloatArray
    shapes: FloatArray
    reversed: float | None
    round_off: float = 0.0


def integration_matrix() -> FloatArray:
    """Integrals from 0 to each Gauss point of the polynomial through values there, (6, 6)."""
    powers = np.arange(6.0)
    primitive = POINTS[:, None] ** (powers + 1) / (powers + 1)
    return np.asarray(np.linalg.solve((POINTS[:, None] ** powers).T, primitive.T).T)


def work_of_axial_force(frame: Frame) -> FloatArray:
    """Geometric stiffness per unit of axial force at each Gauss point, (m, 6, 12, 12).

    In global axes and the order of `frame.unknowns`; each is symmetric and positive semidefinite.
    """
    ends = np.linalg.solve(frame.flexibility, frame.deformation)  # (m, 6, 12)
    reach = frame.lengths[:, None] * (1 - POINTS)
    compliance = frame.compliance
    force = np.repeat(ends[:, None], 6, axis=1)  # (m, g, 6, 12)
    force[:, :, 5] += reach[..., None] * ends[:, None, 1]
    force[:, :, 4] -= reach[..., None] * ends[:, None, 2]
    strain = compliance[..., None] * force
    turned = np.einsum("gh,m,mhiu->mgiu", integration_matrix(), frame.lengths, strain[:, :, 4:])
    start = np.zeros((len(frame.members), 3, 12))
    start[:, :, 3:6] = frame.axes  # local turns of the start
    slope_y = start[:, None, 2] + turned[:, :, 1] + strain[:, :, 1]
    slope_z = -start[:, None, 1] - turned[:, :, 0] + strain[:, :, 2]
    s = frame.sections.broadcast((len(frame.members), 6))
    twist = np.sqrt((s.inertia_y + s.inertia_z) / s.area)[..., None] * strain[:, :, 3]
    rows = np.stack([slope_y, slope_z, twist], axis=2)
    weight = WEIGHTS * frame.lengths[:, None]
    return np.asarray(np.einsum("mg,mgku,mgkv->mguv", weight, rows, rows, optimize=True))


def buckling_modes(stiffness: FloatArray, geometric: FloatArray, *, count: int = 1) -> FrameModes:
    """Lowest factors f > 0 at which (K + f K_s) x = 0, by the largest mu of -K_s x = mu K x.

    The loads' size drops out; those in tension or without load give none. That none was skipped is
    proven by the number of negative eigenvalues of K + f K_s just below the first and just above
    the last factor, as far from them as round-off may move them. Raises LooseFrameError
    if something moves without strain, SolverError where the counts differ.
    """
    scaled, scale, softest = _scaled(stiffness)
    round_off = _ROUND_OFF / softest
    beside = max(_BESIDE, round_off)
    size = float(np.abs(geometric).max(initial=0.0))
    nothing = FrameModes(np.zeros(0), np.zeros((len(stiffness), 0)), None)
    if not size > 0:
        return nothing
    lower = np.linalg.cholesky(scaled)
    load = -scale[:, None] * (geometric / size) * scale
    reduced = np.linalg.solve(lower, np.linalg.solve(lower, load).T)
    values, vectors = np.linalg.eigh((reduced + reduced.T) / 2)
    least = _NONE * np.abs(values).max()
    opposite = 1 / (-values[0] * size) if values[0] < -least else None
    order = np.flatnonzero(values > least)[::-1]
    if not len(order):
        return replace(nothing, reversed=opposite)
    positive = 1 / values[order]
    factors = positive[:count]
    for factor in (factors[0] * (1 - beside), factors[-1] * (1 + beside)):
        wanted = int((positive < factor).sum())
        found = _negative(scaled - factor * load)
        if found != wanted:
            raise SolverError(
                f"{found} buckling modes of a frame stand below the factor {factor / size:.6g}, "
                f"{wanted} were found"
            )
    shapes = np.linalg.solve(lower.T, vectors[:, order[:count]])
    return FrameModes(factors / size, scale[:, None] * shapes, opposite, round_off)


def whitening(stiffness: FloatArray) -> FloatArray:
    """Combinations X (n, n) with X' K X = 1; LooseFrameError if something moves without strain."""
    scaled, scale = _unit_diagonal(stiffness)
    try:
        inverse = _lower_inverse(scaled)
        # the smallest eigenvalue is above 1/|inverse|^2, the largest below the trace
        proven = (inverse**2).sum() * len(scaled) * _MECHANISM < 1
    except np.linalg.LinAlgError:
        proven = False
    if not proven:
        _softest(scaled)
        inverse = _lower_inverse(scaled)
    return np.asarray(scale[:, None] * inverse.T)


def _lower_inverse(matrix: FloatArray) -> FloatArray:
    """Inverse of the lower triangle that makes a matrix, LinAlgError where there is none."""
    lower = np.linalg.cholesky(matrix)
    return np.asarray(np.linalg.inv(lower))


def _scaled(stiffness: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Stiffness scaled to ones on its diagonal, the factors of the unknowns that do so.

    And the smallest eigenvalue over the largest.
    """
    scaled, scale = _unit_diagonal(stiffness)
    return scaled, scale, _softest(scaled)


def _unit_diagonal(stiffness: FloatArray) -> tuple[FloatArray, FloatArray]:
    diagonal = np.diag(stiffness)
    if not (diagonal > 0).all():
        raise LooseFrameError("the frame can move: an unknown has no stiffness")
    scale = 1 / np.sqrt(diagonal)
    return scale[:, None] * stiffness * scale, scale


def _softest(scaled: FloatArray) -> float:
    """The smallest eigenvalue over the largest."""
    values = np.linalg.eigvalsh(scaled)
    if values[0] < _MECHANISM * values[-1]:
        raise LooseFrameError("the frame can move without strain")
    return float(values[0] / values[-1])


def _negative(matrix: FloatArray) -> int:
    """Number of negative eigenvalues."""
    return int((np.linalg.eigvalsh(matrix) < 0).sum())


def section_motions(frame: Frame) -> FloatArray:
    """v', w', t' and t at the Gauss points by the members' unknowns, (m, 6, 4, 12).

    The members' own exact deflections without load, as in `work_of_axial_force`.
    """
    ends = np.linalg.solve(frame.flexibility, frame.deformation)
    reach = frame.lengths[:, None] * (1 - POINTS)
    force = np.repeat(ends[:, None], len(POINTS), axis=1)
    force[:, :, _M_Z] += reach[..., None] * ends[:, None, _V_Y]
    force[:, :, _M_Y] -= reach[..., None] * ends[:, None, _V_Z]
    strain = frame.compliance[..., None] * force
    turned = np.einsum("gh,m,mhiu->mgiu", integration_matrix(), frame.lengths, strain[:, :, 3:])
    start = np.zeros((len(frame.members), 3, 12))
    start[:, :, 3:6] = frame.axes
    slope_y = start[:, None, 2] + turned[:, :, 2] + strain[:, :, _V_Y]
    slope_z = -start[:, None, 1] - turned[:, :, 1] + strain[:, :, _V_Z]
    return np.stack(
        [slope_y, slope_z, strain[:, :, _T], start[:, None, 0] + turned[:, :, 0]], axis=2
    )


def section_work(frame: Frame) -> FloatArray:
    """Weight of each section force in W, per unit, (m, 6 points, 6 forces, 4, 4): symmetric.

    Rows and columns are v', w', t', t of `section_motions`; lengths of integration are in it.
    """
    s = frame.sections.broadcast((len(frame.members), len(POINTS)))
    work = np.zeros((*s.area.shape, 6, 4, 4))
    work[:, :, _N, 0, 0] = work[:, :, _N, 1, 1] = 1.0
    work[:, :, _N, 2, 2] = (s.inertia_y + s.inertia_z) / s.area
    for force, i, j, sign in (
        (_M_Z, 2, 1, -1),
        (_M_Y, 2, 0, -1),
        (_V_Y, 1, 3, 1),
        (_V_Z, 0, 3, -1),
    ):
        work[:, :, force, i, j] = work[:, :, force, j, i] = sign
    return np.asarray(work * (WEIGHTS * frame.lengths[:, None])[:, :, None, None, None])


def weights_at_ends(frame: Frame, forces: FloatArray) -> FloatArray:
    """Weights (m, 2 ends, 3, 3) of the turns at members' ends by section forces (m, 6, 6)."""
    powers = np.vander(POINTS, increasing=True)
    ends = np.linalg.solve(powers.T, np.vander([0.0, 1.0], len(POINTS), increasing=True).T).T
    moments = np.einsum("eg,mgf->mef", ends, forces[:, :, [_M_Y, _M_Z]]) * np.array([[-1.0], [1.0]])
    weights = np.zeros((len(frame.members), 2, 3, 3))
    weights[:, :, 0, 2] = weights[:, :, 2, 0] = moments[:, :, 0] / 2
    weights[:, :, 0, 1] = weights[:, :, 1, 0] = -moments[:, :, 1] / 2
    return weights


def turns_at_ends(frame: Frame) -> FloatArray:
    """Turns at members' ends about their own axes, by their unknowns, (m, 2, 3, 12)."""
    turns = np.zeros((len(frame.members), 2, 3, 12))
    turns[:, 0, :, 3:6] = turns[:, 1, :, 9:12] = frame.axes
    return turns


def geometric_forms(frame: Frame, forces: FloatArray, fields: FloatArray) -> FloatArray:
    """Second-order work (c, k, k) of c cases of forces (m, 6, 6, c) between fields (6 n, k)."""
    own = fields[frame.unknowns][:, None]
    moved, turned = (
        section_motions(frame) @ own,
        turns_at_ends(frame) @ own,
    )  # (m, g or 2, 4 or 3, k)
    work, count = section_work(frame), fields.shape[1]
    rows, ends = moved.reshape(-1, count), turned.reshape(-1, count)
    forms = np.zeros((forces.shape[-1], count, count))
    for c in np.flatnonzero(np.abs(forces).max(axis=(0, 1, 2)) > 0):
        weights = np.einsum("mgf,mgfij->mgij", forces[..., c], work)
        forms[c] = rows.T @ (weights @ moved).reshape(-1, count)
        forms[c] += ends.T @ (weights_at_ends(frame, forces[..., c]) @ turned).reshape(-1, count)
    return forms
