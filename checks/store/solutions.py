"""Unit solutions from the store: all but the factor, which is made again if something needs it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
import scipy

from checks.store.fingerprints import digest
from checks.store.store import Store
from fem.assembly import Elements, Pattern, stiffness, ties_of
from fem.solvers import Factor
from fem.unit_loads import InterfaceLoads
from fem.unit_solutions import Elastic, UnitSolutions, held_factor, solve_unit_loads
from geometry.mesh import FloatArray, IntArray, Interface, Mesh

PACKAGES = ("fem", "geometry")
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class KeptInterface:
    """An interface's unit loads without their vectors, which stand among all the loads."""

    interface: Interface
    names: tuple[str, ...]
    raw_deviation: float


@dataclass(frozen=True, eq=False)
class KeptSolutions:
    """Kept part of unit solutions: all that takes time, but the factor.

    solver          that gave them, in the words of `Factor`
    loads, displacement, basis, held, residual   as in `UnitSolutions`
    unit_reactions  (n_supports, n_basis) N per unit
    """

    solver: str
    interfaces: tuple[KeptInterface, ...]
    loads: FloatArray
    displacement: FloatArray
    basis: FloatArray
    held: IntArray
    residual: float
    unit_reactions: FloatArray


def stored_solutions(store: Store, mesh: Mesh, material: Elastic) -> "StoredSolutions":
    """Return the unit solutions of a mesh, from the store if they are there; raises as solving."""
    identity = digest(mesh, material)
    fresh: list[UnitSolutions] = []

    def solve() -> KeptSolutions:
        fresh.append(solve_unit_loads(mesh, material))
        return _kept(fresh[0])

    kept = store.remember("solutions", PACKAGES, identity, solve)
    return StoredSolutions(store, identity, mesh, material, kept, fresh[0] if fresh else None)


def _kept(solved: UnitSolutions) -> KeptSolutions:
    return KeptSolutions(
        solver=solved.factor.solver,
        interfaces=tuple(
            KeptInterface(unit.interface, unit.names, unit.raw_deviation)
            for unit in solved.interfaces
        ),
        loads=solved.loads,
        displacement=solved.displacement,
        basis=solved.basis,
        held=solved.held,
        residual=solved.residual,
        unit_reactions=solved.reactions(np.eye(solved.loads.shape[1])),
    )


class StoredSolutions(UnitSolutions):
    """Unit solutions whose matrix and factor wait until something needs them.

    What is solved with the factor besides the unit loads is remembered, too.
    """

    _store: Store
    _identity: str
    _unit_reactions: FloatArray

    def __init__(
        self,
        store: Store,
        identity: str,
        mesh: Mesh,
        material: Elastic,
        kept: KeptSolutions,
        fresh: UnitSolutions | None,
    ) -> None:
        known: dict[str, Any] = dict(vars(fresh)) if fresh else _recalled(mesh, material, kept)
        known |= {"basis": kept.basis, "_unit_reactions": kept.unit_reactions}
        known.setdefault("factor", LaterFactor(kept.solver, self._factorised))
        self.__dict__.update(known, _store=store, _identity=identity)

    @cached_property
    def stiffness(self) -> "scipy.sparse.csr_array":
        """Upper triangle of the whole stiffness matrix, without ties."""
        return stiffness(self.pattern, self.material.youngs_modulus, self.material.poisson_ratio)

    def reactions(self, coefficients: FloatArray) -> FloatArray:
        """Reactions (n_supports, n) at the supports, N; of tied unknowns their sum."""
        return np.asarray(self._unit_reactions @ coefficients)

    def solve(self, loads: FloatArray) -> FloatArray:
        """Displacement (3 n_nodes, m) of other nodal forces under the same hold."""
        return self.remember("displacement", loads, lambda: UnitSolutions.solve(self, loads))

    def remember(self, what: str, inputs: object, compute: Callable[[], T]) -> T:
        """Return what is computed of these solutions and other inputs, from the store if there."""
        return self._store.remember(what, PACKAGES, (self._identity, inputs), compute)

    def _factorised(self) -> Factor:
        return held_factor(self.mesh, self.stiffness, self.held, self.ties)


class LaterFactor(Factor):
    """A factor that is made when it is first used."""

    def __init__(self, solver: str, make: Callable[[], Factor]) -> None:
        self.__dict__.update(solver=solver, _make=make)

    @cached_property
    def _made(self) -> Factor:
        made: Factor = self.__dict__["_make"]()
        return made

    def apply(self, right: FloatArray) -> FloatArray:
        """Solution without a check, for use inside an iteration that checks its own result."""
        return self._made.apply(right)

    def solve(self, right: FloatArray) -> tuple[FloatArray, float]:
        """Solution for right-hand sides (n,) or (n, m), and the largest backward error."""
        return self._made.solve(right)


def remembered(solutions: UnitSolutions, what: str, inputs: object, compute: Callable[[], T]) -> T:
    """Return what is computed of some solutions and other inputs, from their store if any.

    inputs  all that `compute` takes besides the solutions
    """
    if isinstance(solutions, StoredSolutions):
        return solutions.remember(what, inputs, compute)
    return compute()


def _recalled(mesh: Mesh, material: Elastic, kept: KeptSolutions) -> dict[str, Any]:
    """The fields of unit solutions but for matrix and factor."""
    elements = Elements(mesh)
    interfaces, first = [], 0
    for own in kept.interfaces:
        columns = slice(first, first + len(own.names))
        first = columns.stop
        vectors = np.ascontiguousarray(kept.loads[:, columns])
        interfaces.append(InterfaceLoads(own.interface, own.names, vectors, own.raw_deviation))
    return {
        "elements": elements,
        "pattern": Pattern(elements),
        "material": material,
        "interfaces": tuple(interfaces),
        "loads": kept.loads,
        "displacement": kept.displacement,
        "held": kept.held,
        "residual": kept.residual,
        "ties": ties_of(mesh),
    }
