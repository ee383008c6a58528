"""Buckling of a frame by the whole matrices of its geometric stiffness, as textbooks have it.

Geometric stiffness of a frame under all section forces: columns, and bent bars that twist aside.

A section moves by u = (-y v' - z w', v - z t, w + y t) with the turns' signs of fem/frame.py. The
second-order work 1/2 integral s_ij u_k,i u_k,j of the stresses in a section, integrated over it, is
with N = int s_xx, M_y = int z s_xx, M_z = -int y s_xx, V = int s_xy and so on

    W = 1/2 N (v'^2 + w'^2 + r^2 t'^2) - M_z t' w' - M_y t' v' + V_y w' t - V_z v' t

per length: the first term is the column's (fem/frame.py), the others give lateral buckling
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

from dataclasses import replace

import numpy as np

from fem.frame import (
    POINTS,
    WEIGHTS,
    Frame,
    FrameModes,
    buckling_modes,
    integration_matrix,
    work_of_axial_force,
)
from geometry.mesh import FloatArray, IntArray
from tests.fem.solved_frames import HeldFrame

_N, _V_Y, _V_Z, _T, _M_Y, _M_Z = range(6)


def axial_stiffness(frame: Frame, axial: FloatArray) -> FloatArray:
    """Geometric stiffness (6 n, 6 n) of axial forces (m,) or (m, 6 points), N, tension above 0."""
    forces = np.asarray(axial, dtype=float)
    count = len(frame.members)
    if forces.shape not in ((count,), (count, 6)) or not np.isfinite(forces).all():
        raise ValueError(
            f"axial forces of {count} members must be finite, of shape ({count},) or ({count}, 6), "
            f"got {forces.shape}"
        )
    forces = np.broadcast_to(forces.reshape(count, -1), (count, 6))
    return frame.assembled(np.einsum("mg,mguv->muv", forces, work_of_axial_force(frame)))


def frame_buckling(
    frame: Frame, axial: FloatArray, held: IntArray, *, count: int = 1
) -> FrameModes:
    """Lowest buckling factors of a frame with unknowns `held` still; shapes (6 n, k).

    axial  (m,) or (m, 6 points)  N, tension above 0

    Raises ValueError if the frame can move as a rigid body.
    """
    fixed = HeldFrame(frame, np.unique(held)).held
    free = np.setdiff1d(np.arange(6 * len(frame.nodes)), fixed)
    inside = np.ix_(free, free)
    found = buckling_modes(
        frame.dense_stiffness()[inside], axial_stiffness(frame, axial)[inside], count=count
    )
    shapes = np.zeros((6 * len(frame.nodes), found.shapes.shape[1]))
    shapes[free] = found.shapes
    return replace(found, shapes=shapes)


def geometric_stiffness(frame: Frame, forces: FloatArray) -> FloatArray:
    """Geometric stiffness (6 n, 6 n) of section forces (m, 6 points, 6), local axes, N and N mm."""
    motions, turns = section_motions(frame), turns_at_ends(frame)
    weights = np.einsum("mgf,mgfij->mgij", forces, section_work(frame))
    blocks = np.einsum("mgiu,mgij,mgjv->muv", motions, weights, motions, optimize=True)
    ends = weights_at_ends(frame, forces)
    blocks += np.einsum("meiu,meij,mejv->muv", turns, ends, turns, optimize=True)
    result = np.zeros((6 * len(frame.nodes),) * 2)
    np.add.at(result, (frame.unknowns[:, :, None], frame.unknowns[:, None, :]), blocks)
    return result


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
