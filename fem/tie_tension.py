"""What the ties of a stack carry across its faces: where they pull, the real leaves would part."""

from collections.abc import Sequence

import numpy as np

from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray

_YY = 1  # of the components xx, yy, zz, xy, yz, zx
_CHUNK = 2000


def tie_tension(
    solutions: UnitSolutions,
    coefficients: FloatArray,
    clamped: Sequence[tuple[float, float]] = (),
) -> tuple[float, float]:
    """Largest tension and largest compression along y between the bodies of a stack, MPa.

    coefficients  (n_basis,) of one position or (n_basis, n) of several
    clamped       mm, lowest and highest x of stretches where tension is not looked for: a clamp
                  presses the bodies together there, which is in no load

    The stress is that recovered at the nodes tied along y, which is the normal of the faces where
    the bodies lie on each other, as the mean of both sides. Each is 0 where there is none of it.
    Raises ValueError if nothing is tied along y.
    """
    pairs = [tie.pairs for tie in solutions.mesh.ties if tie.axis == 1 and len(tie.pairs)]
    if not pairs:
        raise ValueError("nothing is tied along y: the part has no faces that lie on each other")
    nodes = np.concatenate(pairs)
    points = np.searchsorted(solutions.recovery.points, nodes)
    inside = np.minimum(points, len(solutions.recovery.points) - 1)
    if not np.array_equal(solutions.recovery.points[inside], nodes):
        raise ValueError("nodes are tied that are not on the surface of their bodies")
    tension = compression = 0.0
    for start in range(0, len(points), _CHUNK):
        basis = solutions.basis[points[start : start + _CHUNK], _YY]  # (p, 2, n_basis)
        stress = basis.mean(axis=1) @ coefficients
        x = solutions.mesh.nodes[nodes[start : start + _CHUNK, 0], 0]
        free = np.ones(len(x), dtype=bool)
        for low, high in clamped:
            free &= (x < low) | (x > high)
        tension = max(tension, float(stress[free].max(initial=0.0)))
        compression = max(compression, float(-stress.min()))
    return tension, compression
