"""Linear buckling of a solid part with the end conditions of a link, not those of the stress hold.

The pins are hinges about their own axis: at each interface the mean displacement is held, in the
plane of the mechanism the part may turn at both ends, about its own axis it may not turn at the
first. Out of plane the ends are as stiff as their forks; both bounds are computed, ends free to
tilt and ends that cannot.

The conditions are imposed on the factor of the stress analysis by bordering: with the rigid modes R
and constraint rows C, K u + C' m = f, C u = 0 needs only solves with the held stiffness and a small
dense system (docs/theory/buckling.md). The largest mu of -K_s x = mu K x is found, so that the load
factor 1/mu is right at any size of the load and tension gives no positive factor.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from fem.assembly import full, geometric_stiffness
from fem.recovery import tensor
from fem.solvers import SolverError
from fem.unit_solutions import UnitSolutions, rigid_modes
from geometry.mesh import FloatArray


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


def buckling_modes(
    solutions: UnitSolutions,
    coefficients: FloatArray,
    *,
    tilt_held: bool,
    count: int = 2,
) -> list[BucklingMode]:
    """Return the lowest positive buckling factors of one load state, lowest first.

    coefficients  (n_basis,) of the unit loads
    tilt_held     whether the forks hold the ends against tilting out of the plane
    count         how many factors, smallest in size, are computed; negative ones (the part would
                  buckle if its loads turned round) are left out, so a part in tension has none

    Raises SolverError if the eigenvalues do not converge, ValueError for the tied bodies of a
    stack, whose leaves buckle by themselves, and for half of a part.
    """
    solutions.mesh.check_whole("buckling, which may be sideways,")
    if solutions.ties is not None:
        raise ValueError(
            "buckling is computed for parts of one body; this one is a stack of tied bodies that "
            "slide on each other"
        )
    displacement = solutions.displacement @ coefficients
    stress = solutions.recovery.quadrature_stress(displacement[:, None], slice(None))[..., 0]
    size = np.abs(stress).max()
    if not size > 0:
        return []
    geometric = full(geometric_stiffness(solutions.pattern, tensor(stress / size)))
    stiffness = full(solutions.stiffness)
    project = _ConstrainedInverse(solutions, tilt_held=tilt_held)
    n = stiffness.shape[0]
    start = project(np.random.default_rng(1).standard_normal(n))
    try:
        values, vectors = eigsh(
            -geometric,
            k=count,
            M=stiffness,
            Minv=LinearOperator((n, n), matvec=project, dtype=float),
            which="LM",  # the smallest factors of either sign
            v0=start,
            tol=1e-9,
        )
    except ArpackNoConvergence as error:
        raise SolverError(f"the buckling factors did not converge: {error}") from error
    modes = []
    for value, vector in zip(values, vectors.T, strict=True):
        left = project(-geometric @ vector) / value - vector
        if np.linalg.norm(left) > 1e-4 * np.linalg.norm(vector):
            raise SolverError("a buckling mode does not satisfy its own equation")
    for value, vector in sorted(zip(values, vectors.T, strict=True), key=lambda pair: -pair[0]):
        if value <= 1e-12 * np.abs(values).max():
            continue
        shape = vector.reshape(-1, 3)
        shape = shape / np.abs(shape).max()
        sideways = np.abs(shape[:, 2]).max() > np.abs(shape[:, 1]).max()
        plane = "out of plane" if sideways else "in plane"
        modes.append(BucklingMode(float(1 / (value * size)), plane, shape))
    return modes


def end_conditions(solutions: UnitSolutions, *, tilt_held: bool) -> FloatArray:
    """Rows (n_rows, 3 n_nodes) of mean displacements and rotations held to zero."""
    rows = []
    for number, loads in enumerate(solutions.interfaces[:2]):
        surface = solutions.elements.surface(loads.interface.name)
        weights = np.zeros(len(solutions.mesh.nodes))
        np.add.at(weights, surface.nodes, np.einsum("aq,fq->fa", surface.shape, surface.weights))
        weights /= weights.sum()
        arm = solutions.mesh.nodes - loads.interface.centre

        def mean(axis: int, factor: FloatArray, weights: FloatArray = weights) -> FloatArray:
            row = np.zeros((len(weights), 3))
            row[:, axis] = weights * factor
            return row.ravel()

        one = np.ones(len(weights))
        rows += [mean(axis, one) for axis in ((0, 1, 2) if number == 0 else (1, 2))]
        if number == 0:  # no turning about the part's own axis
            rows.append(mean(2, arm[:, 1]) - mean(1, arm[:, 2]))
        if tilt_held:
            rows.append(mean(0, arm[:, 2]) - mean(2, arm[:, 0]))
    return np.array(rows)


class _ConstrainedInverse:
    """u = K^-1 f on the subspace where the end conditions hold."""

    def __init__(self, solutions: UnitSolutions, *, tilt_held: bool) -> None:
        self._solutions = solutions
        self._rows = end_conditions(solutions, tilt_held=tilt_held)
        self._modes = rigid_modes(solutions.mesh.nodes)
        self._responses = solutions.solve(self._rows.T.copy())
        n_rows, n_modes = len(self._rows), self._modes.shape[1]
        bordered = np.zeros((n_rows + n_modes, n_rows + n_modes))
        bordered[:n_rows, :n_rows] = self._rows @ self._responses
        bordered[:n_rows, n_rows:] = -self._rows @ self._modes
        bordered[n_rows:, :n_rows] = self._modes.T @ self._rows.T
        self._bordered = bordered
        self._free = np.setdiff1d(np.arange(len(self._modes)), solutions.held)

    def __call__(self, force: FloatArray) -> FloatArray:
        response = np.zeros(len(force))
        response[self._free] = self._solutions.factor.apply(force[self._free])
        right = np.concatenate([self._rows @ response, self._modes.T @ force])
        unknown = np.linalg.solve(self._bordered, right)
        count = len(self._rows)
        return np.asarray(
            response - self._responses @ unknown[:count] + self._modes @ unknown[count:]
        )
