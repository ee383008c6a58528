"""Linear buckling of a solid part with the end conditions of a link, not those of the stress hold.

The pins are hinges about their own axis: at each interface the mean displacement is held, in the
plane of the mechanism the part may turn at both ends, about its own axis it may not turn at the
first. Out of plane the ends are as stiff as their forks; both bounds are computed, ends free to
tilt and ends that cannot (docs/theory/buckling.md).

The largest mu of -K_s x = mu K x is found, so that the load factor 1/mu is right at any size of the
load and tension gives no positive factor; that no lower one was skipped is proven by a count.

Of the positions of a cycle, modes of some judge the others.

The geometric stiffness is linear in the unit loads. The modes of a few load states that all
positions are made of, of either sign, are displacement fields that the part could take at any; the
largest mu of -K_s x = mu K x among them, at every position, is never above the true one (Rayleigh
and Ritz), and close to it where the part buckles alike. The position where it is largest is solved
next, its modes join, until the position that looks worst has been solved. The reported factor is a
solved one; that no other position has a lower one is not proved but sought.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.assembly import full, geometric_stiffness
from fem.end_conditions import SupportedSolid, link_solid
from fem.lowest_modes import elastic_and_geometric_energy, geometric_forms, lowest_modes
from fem.recovery import tensor
from fem.solvers import SolverError
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray

_MOST = 6  # positions that are solved
_TIE = 1e-6  # factors that are closer are equal: the first position is named
_CLOSE = 0.98  # of the lowest factor: an estimate above that asks for no further position
_PATTERNS = 4  # load states whose modes are taken to begin with
_SMALL = 0.1  # of the largest stress: what is left of all states counts as known
_DEPENDENT = 1e-8  # of the largest energy: fields that say nothing new

# A mode that needs a larger elastic stress than this share of Young's modulus somewhere is none of
# a structure; pi^2 / slenderness^2 of a column of slenderness 5 is 0.39.
_STRESS_LIMIT = 1.0


@dataclass(frozen=True, eq=False)
class BucklingMode:
    """One buckling mode.

    factor  load factor at which the part buckles elastically; > 0
    plane   "in plane" or "out of plane" of the mechanism, by where the mode moves
    shape   (n_nodes, 3) largest displacement 1
    """

    factor: float
    plane: str
    shape: FloatArray


@dataclass(frozen=True, eq=False)
class Buckling:
    """The lowest buckling modes of a load state, and what is known about others.

    modes     lowest factor first; none in tension or without load
    proven    every factor below this one is among the modes, or follows the last of them in
              steps below 0.2 %: a count by inertia says so. 0 if no count was asked for, infinite
              without load
    reversed  size of the lowest factor of the same loads turned round, None without one
    limit     the factor at which the largest stress is Young's modulus; modes above it are none
    """

    modes: tuple[BucklingMode, ...]
    proven: float
    reversed: float | None
    limit: float


def buckling_modes(
    solutions: UnitSolutions, coefficients: FloatArray, *, tilt_held: bool, count: int = 2
) -> list[BucklingMode]:
    """Return the lowest positive buckling factors of one load state, lowest first.

    As `part_buckling`, without what is known beside the modes.
    """
    found = part_buckling(solutions, coefficients, tilt_held=tilt_held, count=count)
    return list(found.modes)


def part_buckling(
    solutions: UnitSolutions,
    coefficients: FloatArray,
    *,
    tilt_held: bool,
    count: int = 2,
    prove: bool = True,
    weaker: bool = False,
) -> Buckling:
    """Return the buckling of a part held by its pins, under one load state.

    coefficients  (n_basis,) of the unit loads
    tilt_held     True if the forks hold the ends against tilting out of the plane
    count         how many modes are wanted at most
    prove         True if it is proven that no lower mode was skipped
    weaker        True if a proof of less will do where that fails: `proven` is then below the modes

    Raises SolverError if the modes do not converge or cannot be proven, ValueError for the tied
    bodies of a stack, whose leaves buckle by themselves, and for half of a part.
    """
    solid = link_solid(solutions, tilt_held=tilt_held, what="buckling")
    displacement = solutions.displacement @ coefficients
    stress = solutions.recovery.quadrature_stress(displacement[:, None], slice(None))[..., 0]
    return solid_buckling(solid, stress, count=count, prove=prove, weaker=weaker)


def solid_buckling(
    solid: SupportedSolid,
    stress: FloatArray,
    *,
    count: int = 2,
    prove: bool = True,
    weaker: bool = False,
) -> Buckling:
    """Return the buckling of a supported solid under a stress state.

    stress  (n_elements, n_q, 6) at the integration points, MPa (fem.recovery)
    """
    size = float(np.abs(stress).max())
    if not size > 0:
        return Buckling((), np.inf, None, np.inf)
    unit = tensor(stress / size)
    upper = geometric_stiffness(solid.pattern, unit)
    upper.data *= -1.0
    by_node = full(upper[::3][:, ::3].tocsr())  # the blocks are multiples of the identity

    def times(fields: FloatArray) -> FloatArray:
        return np.asarray(by_node @ fields.reshape(by_node.shape[0], -1)).reshape(fields.shape)

    def energies(fields: FloatArray) -> tuple[FloatArray, FloatArray]:
        elastic, geometric = elastic_and_geometric_energy(
            solid.elements, solid.material, unit, fields
        )
        return elastic, -geometric

    limit = _STRESS_LIMIT * solid.material.youngs_modulus
    found = lowest_modes(
        solid, upper, times, energies, count, limit=limit, prove=prove, weaker=weaker
    )
    modes = tuple(
        _mode(value / size, vector)
        for value, vector in zip(found.values, found.shapes.T, strict=True)
    )
    turned = None if found.negative is None else -found.negative / size
    return Buckling(modes, found.proven / size, turned, limit / size)


def effective_length(force: float, youngs_modulus: float, inertia: float) -> float:
    """Length of the hinged column that buckles at the same force, mm: pi sqrt(E I / force).

    force    N, at which the part buckles
    inertia  mm4, of the section in the plane of the mode

    >>> round(effective_length(20726.169, 210e3, 1e4), 3)
    1000.0
    """
    for name, value in (("force", force), ("modulus", youngs_modulus), ("inertia", inertia)):
        if not value > 0:
            raise ValueError(f"the effective length needs a {name} above 0, got {value}")
    return float(np.pi * np.sqrt(youngs_modulus * inertia / force))


def _mode(factor: float, vector: FloatArray) -> BucklingMode:
    shape = vector.reshape(-1, 3)
    shape = shape / np.abs(shape).max()
    sideways = np.abs(shape[:, 2]).max() > np.abs(shape[:, 1]).max()
    return BucklingMode(float(factor), "out of plane" if sideways else "in plane", shape)


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
