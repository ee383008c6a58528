"""Buckling of a frame by the whole matrices of its geometric stiffness, as textbooks have it."""

from dataclasses import replace

import numpy as np

from fem.frame import Frame
from fem.frame_buckling import (
    FrameModes,
    buckling_modes,
    section_motions,
    section_work,
    turns_at_ends,
    weights_at_ends,
    work_of_axial_force,
)
from geometry.mesh import FloatArray, IntArray


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
    fixed = frame.held(held).held
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
