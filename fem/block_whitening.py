"""Motions of unit stiffness where most unknowns are free of constraints, the same in all poses.

Their stiffness is taken apart by blocks: the root of what nothing constrains is inverted once, and
what is left for a pose is as small as the unknowns that constraints hold.
"""

from dataclasses import dataclass

import numpy as np

from fem.frame import MECHANISM, LooseFrameError, lower_inverse, unit_diagonal
from geometry.mesh import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Inner:
    """Unknowns that no constraint holds, i of n, and their tie to the b held ones.

    held     (n,) true for the b unknowns that constraints hold
    outer    (b, b) stiffness of those
    scale    (i,) factors of the others that make their stiffness ones on its diagonal
    unit     (i, i) combinations of the others whose stiffness is the unit matrix
    size     its squares, rows over `scale`, summed
    reach    (i, b) unit' times the stiffness between both
    """

    held: BoolArray
    outer: FloatArray
    scale: FloatArray
    unit: FloatArray
    size: float
    reach: FloatArray

    def unit_motions(self, free: FloatArray) -> FloatArray | None:
        """Motions (..., n, m) whose stiffness is the unit matrix, for free ones (..., b, k).

        Those are of the held unknowns, in one pose or many. None where it takes more than this to
        tell if something moves without strain.
        """
        own = np.swapaxes(free, -1, -2) @ self.outer @ free
        diagonal = np.diagonal(own, axis1=-2, axis2=-1)
        if not (diagonal > 0).all():
            return None
        scale = 1 / np.sqrt(diagonal)
        moved = free * scale[..., None, :]
        across = self.reach @ moved
        tied = scale[..., :, None] * own * scale[..., None, :]
        try:
            root = np.swapaxes(lower_inverse(tied - np.swapaxes(across, -1, -2) @ across), -1, -2)
        except np.linalg.LinAlgError:
            return None
        carried = -self.unit @ (across @ root)
        size = self.size + (root**2).sum(axis=(-2, -1))
        size += ((carried / self.scale[:, None]) ** 2).sum(axis=(-2, -1))
        count, further = len(self.scale), root.shape[-1]
        if not (size * (count + further) * MECHANISM < 1).all():  # as `fem.frame.whitening`
            return None
        result = np.zeros((*free.shape[:-2], len(self.held), count + further))
        result[..., ~self.held, :count] = self.unit
        result[..., ~self.held, count:] = carried
        result[..., self.held, count:] = moved @ root
        return result


def inner_unknowns(stiffness: FloatArray, held: BoolArray) -> Inner | None:
    """Return the unknowns of a stiffness (n, n) that are not held; None where they are loose."""
    free = ~held
    try:
        scaled, scale = unit_diagonal(stiffness[np.ix_(free, free)])
        inverse = lower_inverse(scaled)
    except (LooseFrameError, np.linalg.LinAlgError):
        return None
    unit, size = scale[:, None] * inverse.T, float((inverse**2).sum())
    reach = unit.T @ stiffness[np.ix_(free, held)]
    return Inner(held, stiffness[np.ix_(held, held)], scale, unit, size, reach)
