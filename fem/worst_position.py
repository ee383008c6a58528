"""Position of a cycle at which a part buckles first: modes of some positions judge the others.

The geometric stiffness is linear in the unit loads. The modes of a few load states that all
positions are made of, of either sign, are displacement fields that the part could take at any; the
largest mu of -K_s x = mu K x among them, at every position, is never above the true one (Rayleigh
and Ritz), and close to it where the part buckles alike. The position where it is largest is solved
next, its modes join, until the position that looks worst has been solved. The reported factor is a
solved one; that no other position has a lower one is not proved but sought.
"""

from collections.abc import Sequence

import numpy as np

from fem.buckling import Buckling, part_buckling
from fem.mode_energies import elastic_and_geometric_energy, geometric_forms
from fem.solvers import SolverError
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray

_MOST = 6  # positions that are solved
_TIE = 1e-6  # factors that are closer are equal: the first position is named
_CLOSE = 0.98  # of the lowest factor: an estimate above that asks for no further position
_PATTERNS = 4  # load states whose modes are taken to begin with
_SMALL = 0.1  # of the largest stress: what is left of all states counts as known
_DEPENDENT = 1e-8  # of the largest energy: fields that say nothing new


def worst_buckling(
    solutions: UnitSolutions, coefficients: FloatArray, starts: Sequence[int], *, tilt_held: bool
) -> tuple[int, Buckling] | None:
    """Return the position with the lowest factor found and its modes; None where none buckles.

    coefficients (n_basis, n) of the unit loads over all positions; starts: positions solved first
    """
    solved: dict[int, Buckling] = {}
    fields: list[FloatArray] = []
    for pattern in _patterns(solutions, coefficients):
        for sign in (1.0, -1.0):
            one = part_buckling(solutions, sign * pattern, tilt_held=tilt_held, prove=False)
            fields += [mode.shape.ravel() for mode in one.modes]
    waiting = list(dict.fromkeys(starts))
    while waiting and len(solved) < _MOST:
        position = waiting.pop(0)
        found = buckling_at(solutions, coefficients[:, position], tilt_held=tilt_held)
        solved[position] = found
        fields += [mode.shape.ravel() for mode in found.modes]
        if waiting or not fields:
            continue
        estimates = shares_of(solutions, coefficients, np.stack(fields, axis=1))
        lowest = min((one.modes[0].factor for one in solved.values() if one.modes), default=np.inf)
        for other in np.argsort(-estimates):
            if estimates[other] <= 0.0 or 1.0 / estimates[other] > _CLOSE * lowest:
                break
            if int(other) not in solved:
                waiting.append(int(other))
                break
    buckling = {k: one for k, one in solved.items() if one.modes}
    if not buckling:
        return None
    lowest = min(one.modes[0].factor for one in buckling.values())
    worst = min(k for k, one in buckling.items() if one.modes[0].factor <= (1.0 + _TIE) * lowest)
    return worst, buckling[worst]


def buckling_at(solutions: UnitSolutions, state: FloatArray, *, tilt_held: bool) -> Buckling:
    """Modes of a position, proven where that can be done.

    Far beyond any stress that a metal bears, such as of a part that is pulled, modes are many and
    the search may not find what the count does: then they stand without proof (`proven` is 0).
    Raises SolverError where none is found and it is not proven that there is none.
    """
    try:
        return part_buckling(solutions, state, tilt_held=tilt_held, weaker=True)
    except SolverError:
        found = part_buckling(solutions, state, tilt_held=tilt_held, prove=False)
        if not found.modes:
            raise
        return found


def _patterns(solutions: UnitSolutions, coefficients: FloatArray) -> list[FloatArray]:
    """Load states that those of all positions are made of, to a tenth of the largest.

    What each position adds to the ones before it, the largest first, measured by the stress at the
    surface.
    """
    stress = solutions.basis.reshape(-1, len(coefficients))
    root = np.linalg.qr(stress, mode="r")
    left, states = root @ coefficients, coefficients.copy()
    sizes = np.linalg.norm(left, axis=0)
    largest = float(sizes.max(initial=0.0))
    found: list[FloatArray] = []
    while largest > 0.0 and len(found) < _PATTERNS:
        sizes = np.linalg.norm(left, axis=0)
        most = int(sizes.argmax())
        if sizes[most] < _SMALL * largest:
            break
        found.append(states[:, most].copy())
        along = (left[:, most] @ left) / sizes[most] ** 2
        states -= np.outer(states[:, most].copy(), along)
        left -= np.outer(left[:, most].copy(), along)
    return found


def shares_of(solutions: UnitSolutions, coefficients: FloatArray, fields: FloatArray) -> FloatArray:
    """Share (n,) of its lowest factor that each position's load is at least; 0 without any."""
    elements, material = solutions.elements, solutions.material
    none = np.zeros((*elements.weights.shape, 3, 3))
    energy, _ = elastic_and_geometric_energy(elements, material, none, fields)
    values, vectors = np.linalg.eigh(energy)
    kept = values > _DEPENDENT * values[-1]
    whiten = vectors[:, kept] / np.sqrt(values[kept])
    stress = solutions.recovery.quadrature_stress(solutions.displacement, slice(None))
    forms = whiten.T @ geometric_forms(elements, stress, fields) @ whiten
    states = -np.tensordot(coefficients.T, forms, axes=1)
    return np.asarray(np.linalg.eigvalsh(states)[:, -1])
