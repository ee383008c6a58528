"""Local error of a solution, and the element sizes that would make it small enough.

The estimate of Zienkiewicz and Zhu (Int. J. Num. Meth. Eng. 24 (1987) 337) compares the stress of
each element with the smoother one that averaging at the nodes recovers. It steers the mesh; the
error bar itself is taken from the change of the stress from mesh to mesh (`convergence`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.recovery import Recovery, von_mises
from geometry.mesh import FloatArray, IntArray
from geometry.sizing import SizeField, element_sizes, size_field

_HOT = 0.8  # share of the peak from which on an element is taken to decide it
_HOT_EDGE = 0.5  # the same on a sharp re-entrant edge
_NEAR = 0.5  # of the accuracy asked for that the estimate may reach in such an element
_FAR = 2.0  # and in all others, as a share of the peak too
_STEP = 1.6  # how much smaller deciding elements become at least, so that two meshes tell something
_STEEPEST = 3.0  # and any element at most
_ORDER = 2.0  # of stress with quadratic elements


@dataclass(frozen=True, eq=False)
class StressError:
    """Stress and its estimated error in every element, under one load state, MPa.

    stress, error  (n_elements,) von Mises, largest and root mean square over the element
    """

    stress: FloatArray
    error: FloatArray


def stress_error(recovery: Recovery, displacement: FloatArray) -> StressError:
    """Estimate the error of the stress in every element; displacement (3 n_nodes,) mm."""
    elements = recovery.elements
    raw = recovery.quadrature_stress(displacement[:, None], slice(None))[..., 0]  # (e, q, 6)
    local = elements.local_points
    design = np.column_stack([np.ones(len(local)), local])
    continuation = np.column_stack([np.ones(len(_NODES)), _NODES]) @ np.linalg.inv(design)
    volumes = elements.weights.sum(axis=1)
    nodes = elements.mesh.elements
    total, weight = np.zeros((len(elements.mesh.nodes), 6)), np.zeros(len(elements.mesh.nodes))
    at_nodes = np.matmul(continuation, raw) * volumes[:, None, None]
    np.add.at(total, nodes, at_nodes)
    np.add.at(weight, nodes, volumes[:, None])
    total[elements.mesh.cut_nodes, 4:] = 0.0  # as with the mirrored elements of the other half
    smooth = np.matmul(elements.values, (total / weight[:, None])[nodes])
    away = von_mises(smooth - raw) ** 2
    away[recovery.at_pressed_edges] = 0.0  # smaller ones would be as wrong, and none is judged
    error = np.sqrt((away * elements.weights).sum(axis=1) / volumes)
    return StressError(np.asarray(von_mises(raw).max(axis=1)), np.asarray(error))


_NODES = np.array(
    [
        [0, 0, 0],
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
        [0.5, 0, 0],
        [0.5, 0.5, 0],
        [0, 0.5, 0],
        [0, 0, 0.5],
        [0.5, 0, 0.5],
        [0, 0.5, 0.5],
    ]
)


def refined_sizes(
    recovery: Recovery,
    states: Sequence[StressError],
    accuracy: float,
    most_elements: float,
    sharp: IntArray | None = None,
    missed: FloatArray | None = None,
) -> tuple[SizeField, float]:
    """Return the sizes that bring every state's peak to an accuracy, and how far they go.

    accuracy       1, wanted error of the peak over the peak
    most_elements  what the mesh may have at most, as estimated: sizes are raised to fit
    sharp          nodes on sharp re-entrant edges: their stress may grow past today's peak
    missed         (n_elements,) share by which the stress of each is too low in a notch

    The elements that decide a peak become smaller in any case. The second value is the least by
    which those of any state do: below _STEP the limit on the elements was in the way.
    """
    mesh = recovery.elements.mesh
    now = element_sizes(mesh)
    factor, deciding = np.ones(len(now)), np.zeros(len(now), dtype=bool)
    too_low = np.zeros(len(now)) if missed is None else missed
    at_edge = np.isin(mesh.elements, [] if sharp is None else sharp).any(axis=1)
    for state in states:
        peak = float(state.stress.max())
        if not peak > 0:
            continue
        hot = state.stress * (1 + too_low) >= np.where(at_edge, _HOT_EDGE, _HOT) * peak
        allowed = np.where(hot, _NEAR, _FAR) * accuracy * peak
        with np.errstate(divide="ignore"):
            wanted = (allowed / state.error) ** (1 / _ORDER)
            resolved = np.sqrt(_NEAR * accuracy / too_low)
        wanted = np.where(hot, np.minimum(wanted, resolved), wanted)
        wanted = np.clip(wanted, 1 / _STEEPEST, np.where(hot, 1 / _STEP, 1.0))
        factor = np.minimum(factor, wanted)
        deciding |= hot
    relax = 1.0
    while (np.minimum(factor * relax, 1.0) ** -3.0).sum() > most_elements and relax < 1e3:
        relax *= 1.05
    factor = np.minimum(factor * relax, 1.0)
    refinement = float(1 / factor[deciding].max()) if deciding.any() else 1.0
    return size_field(mesh, now * factor), refinement
