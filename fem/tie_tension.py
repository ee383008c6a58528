"""Tension of a stack's ties across its faces: where they pull, the real leaves would part."""

from collections.abc import Sequence

import numpy as np

from fem.ties import bodies_of
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray, IntArray


def tie_tension(
    solutions: UnitSolutions,
    coefficients: FloatArray,
    clamped: Sequence[tuple[float, float]] = (),
    *,
    window: float,
) -> tuple[float, float]:
    """Largest tension and largest compression along y between the bodies of a stack, MPa.

    coefficients  (n_basis,) of one position or (n_basis, n) of several
    clamped       mm, lowest and highest x of stretches where tension is not looked for: a clamp
                  presses the bodies together there, which is in no load
    window        mm along x to either side over which a tie's force counts, less with distance

    The forces are those that hold tied nodes together, K u - f of the bodies by themselves: they
    balance each body's loads to round-off on any mesh, where stresses recovered on faces that
    carry next to nothing are all scatter of the bending beside them. They are summed over the width
    of every face and over hats of half-width `window`, and divided by the hats' areas. Each is 0
    where there is none of it. Raises ValueError if nothing is tied along y.
    """
    mesh = solutions.mesh
    pairs = [tie.pairs for tie in mesh.ties if tie.axis == 1 and len(tie.pairs)]
    if not pairs:
        raise ValueError("nothing is tied along y: the part has no faces that lie on each other")
    nodes = np.concatenate(pairs)
    body = bodies_of(mesh)
    count = np.bincount(body)
    middle = np.bincount(body, weights=mesh.nodes[:, 1]) / count
    upwards = np.sign(middle[body[nodes[:, 1]]] - middle[body[nodes[:, 0]]])
    pull = upwards[:, None] * _holding(solutions, 3 * nodes[:, 0] + 1)  # (n_pairs, n_basis)
    x, y, z = mesh.nodes[nodes[:, 0]].T
    step = window / 2
    places = np.linspace(x.min(), x.max(), 1 + max(1, round(np.ptp(x) / step)))
    weights = np.maximum(0.0, 1 - np.abs(x - places[:, None]) / window)
    sides = np.minimum(window, np.abs(places - np.array([[x.min()], [x.max()]])))
    lengths = (sides - sides**2 / (2 * window)).sum(axis=0)  # of the hats, less at the ends
    free = np.ones(len(places), dtype=bool)
    for low, high in clamped:
        free &= (places + window <= low) | (places - window >= high)
    tension = compression = 0.0
    faces = np.round(y / np.ptp(mesh.nodes[:, 1]), 6)
    for face in np.unique(faces):
        on = faces == face
        line = (weights[:, on] @ pull[on]) / (lengths[:, None] * np.ptp(z[on]))
        stress = line @ coefficients
        tension = max(tension, float(stress[free].max(initial=0.0)))
        compression = max(compression, float(-stress.min(initial=0.0)))
    return tension, compression


def _holding(solutions: UnitSolutions, unknowns: IntArray) -> FloatArray:
    """Forces (len(unknowns), n_basis) N that the ties of the unknowns give them per unit load."""
    upper = solutions.stiffness
    rows = upper[unknowns] + upper.T.tocsr()[unknowns]
    diagonal = upper.diagonal()[unknowns]
    internal = rows @ solutions.displacement - diagonal[:, None] * solutions.displacement[unknowns]
    return np.asarray(internal - solutions.loads[unknowns])
