"""The numerical error bar of a peak, from the same quantity on two meshes.

Richardson: quadratic elements recover stress with order 2, so of a step between meshes whose
elements there are r times smaller, 1/(r^2 - 1) is left. The bar is 1.5 times that, not less than
0.45 of the scatter of the elements that meet at the point, plus 0.25 % of the value, by which a
peak repeats from one unstructured mesh to another. These three numbers are calibrated: over the
public validation cases the reference lies inside in at least nine of ten, and the median bar is at
most three times the median error (docs/validation.md, measured by bench/error_bars.py). A first
mesh may be too coarse for any order to hold: never less than a third of the step is taken, nor
less than what elements of this size must miss in a notch of its radius (`notch_resolution`). Added
in the worst combination: the truncation of the bearing series, measured against a direct solution.

Where a pressure ends the stress has a kink, which elements cut off: order 1, always too low, and by
about the scatter itself (a hole under 100 |cos t| MPa, at 90 degrees, on meshes of 1/4 to 1/16 of
its radius: errors of 8.7 to 2.3 MPa, scatter 9.3 to 2.3). There the bar takes order 1 and the whole
scatter.

Roache's grid convergence index (J. Fluids Eng. 116 (1994) 405) has the same form with a factor of
3 and no scatter; on the same cases it holds 4 of 5 references with a wider bar.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

ORDER = 2.0  # of recovered stress with quadratic elements
FINER = 1.1  # times smaller elements make a mesh finer at some point
SAFETY = 1.5  # times what is left of the last step
LEAST = 1 / 3  # of the last step, however much smaller the elements became
SCATTER = 0.45  # of the elements' scatter
REPEATS = 0.0025  # of the value, from mesh to mesh
_GROWTH = 0.08  # the smallest exponent that counts; 0.46 is that of a square corner


@dataclass(frozen=True)
class ErrorBar:
    """Remaining numerical error of a peak, term by term.

    discretisation  error to be expected after the last refinement
    scatter         of the elements that meet at the point
    truncation      of the bearing series
    size            of the value
    singular        exponent of a singularity at the point, 0 if there is none
    notch           part of the peak that elements of this size miss in the notch at the point
    order           order of convergence of the value: 1 where a pressure ends
    """

    discretisation: float
    scatter: float
    truncation: float
    size: float = 0.0
    singular: float = 0.0
    notch: float = 0.0
    order: float = ORDER

    @property
    def mesh(self) -> float:
        """Part of the error that a finer mesh makes smaller."""
        largest = max(self.discretisation, self._scattered, self.notch)
        return largest + REPEATS * self.size

    @property
    def _scattered(self) -> float:
        """The scatter's share of the bar: all of it where it falls as slowly as the error."""
        return self.scatter if self.order < ORDER else SCATTER * self.scatter

    @property
    def notch_decides(self) -> bool:
        """True if the largest term is the part of the peak that such elements miss in the notch."""
        return self.notch > max(self.discretisation, self._scattered)

    @property
    def value(self) -> float:
        """The bar: infinite at a singular point."""
        return float("inf") if self.singular else self.mesh + self.truncation


def discretisation_error(
    values: Sequence[float], sizes: Sequence[float], order: float = ORDER
) -> float:
    """Error of the last of `values`, computed on meshes of falling element `sizes`.

    order  with which they converge: 1 where a pressure ends

    Raises ValueError for less than two meshes.
    """
    if len(values) < 2:
        raise ValueError("an error bar needs at least two meshes")
    ratio = max(sizes[-2] / sizes[-1], FINER)
    return float(max(SAFETY / (ratio**order - 1), LEAST) * abs(values[-1] - values[-2]))


def moves_like_singular(values: Sequence[float], sizes: Sequence[float], exponent: float) -> bool:
    """Return True if stress on a sharp re-entrant edge moves with the mesh as a singular one does.

    True when it changes from any mesh to the next, up or down, by more than a twentieth of what
    stress ~ size^-exponent predicts, and by more than meshes repeat. Coarse meshes scatter about
    the growth, so the sign tells nothing; but an edge that carries a uniform stress (a tube's inner
    corner under axial force) does not move at all.
    """
    if exponent <= 0 or len(values) < 2:
        return False
    for before, after, coarse, fine in zip(values, values[1:], sizes, sizes[1:], strict=False):
        if coarse < FINER * fine:  # two meshes that are alike there tell nothing
            continue
        predicted = (coarse / fine) ** exponent - 1
        if abs(after - before) / max(abs(before), 1e-300) > max(predicted / 20, 2 * REPEATS):
            return True
    return False


def growth_exponent(values: Sequence[float], sizes: Sequence[float]) -> float:
    """Exponent with which a peak grows like a power of the element size, 0 if it settles.

    A singular stress ~ size^-exponent keeps its exponent from mesh to mesh; of a peak that
    converges with any order the growth dies away. So the last two steps of three meshes must both
    grow, the later one with at least 0.8 times the exponent of the earlier; or three steps in a
    row, each with twice the exponent that counts.
    """
    if len(values) < 3 or not min(values) > 0:
        return 0.0
    exponents = []
    for k in range(1, len(values)):
        if sizes[k - 1] < FINER * sizes[k]:
            exponents.append(0.0)
        else:
            step = np.log(values[k] / values[k - 1]) / np.log(sizes[k - 1] / sizes[k])
            exponents.append(float(step))
    earlier, later = exponents[-2:]
    if len(exponents) > 2 and min(exponents[-3:]) > 2 * _GROWTH:
        return later
    if earlier > _GROWTH and later > _GROWTH and later > 0.8 * earlier:
        return float(later)
    return 0.0
