"""The numerical error bar of a peak, from the same quantity on several meshes.

Roache's grid convergence index (J. Fluids Eng. 116 (1994) 405): the difference of two meshes,
extrapolated with the order of the method and a safety factor of 3 for two meshes, or with the order
observed and a factor of 1.25 for three. Added in the worst combination: the truncation of the
bearing series, measured against a direct solution; never less than the scatter of the elements that
meet at the point.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_ORDER = 2.0  # of recovered stress with quadratic elements


@dataclass(frozen=True)
class ErrorBar:
    """What is left of a peak's numerical error.

    discretisation  extrapolated from the meshes
    scatter         of the elements that meet at the point
    truncation      of the bearing series
    singular        exponent of a singularity at the point, 0 if there is none
    """

    discretisation: float
    scatter: float
    truncation: float
    singular: float = 0.0

    @property
    def value(self) -> float:
        """The bar: infinite at a singular point."""
        if self.singular:
            return float("inf")
        return max(self.discretisation, self.scatter) + self.truncation


def discretisation_error(values: Sequence[float], sizes: Sequence[float]) -> float:
    """Error of the last of `values`, computed on meshes of falling element `sizes`.

    Two meshes: 3 |difference| / (r^2 - 1). Three: 1.25 |difference| / (r^p - 1) with the observed
    order p, at most 2; without convergence (p <= 0.5) the spread of all three values, three times.
    """
    if len(values) < 2:
        raise ValueError("an error bar needs at least two meshes")
    ratio = sizes[-2] / sizes[-1]
    difference = abs(values[-1] - values[-2])
    if len(values) == 2:
        return float(3 * difference / (ratio**_ORDER - 1))
    before = abs(values[-2] - values[-3])
    if before == difference == 0:
        return 0.0
    if (values[-1] - values[-2]) * (values[-2] - values[-3]) <= 0:
        return float(3 * difference + 1.25 * before / (ratio**_ORDER - 1) / ratio**_ORDER)
    order = min(np.log(before / difference) / np.log(ratio), _ORDER) if before else 0.0
    if order <= 0.5:
        return float(3 * np.ptp(values[-3:]))
    return float(1.25 * difference / (ratio**order - 1))


def moves_like_singular(values: Sequence[float], sizes: Sequence[float], exponent: float) -> bool:
    """Whether the stress on a sharp re-entrant edge moves with the mesh as a singular one does.

    True when it changes from any mesh to the next, up or down, by more than a twentieth of what
    stress ~ size^-exponent predicts. Coarse meshes scatter about the growth, so the sign tells
    nothing; but an edge that carries a uniform stress (a tube's inner corner under axial force)
    does not move at all.
    """
    if exponent <= 0 or len(values) < 2:
        return False
    for before, after, coarse, fine in zip(values, values[1:], sizes, sizes[1:], strict=False):
        predicted = (coarse / fine) ** exponent - 1
        if abs(after - before) / max(abs(before), 1e-300) > predicted / 20:
            return True
    return False
