"""Everything about a part that does not depend on the size of its loads: solved once.

Unit loads of every interface and of four rigid-body accelerations, one factorisation, and the
stress basis at the surface nodes. The part is held at six displacements that just stop it from
moving as a rigid body; loads in equilibrium need no reaction there, which is checked for every
position of the cycle. The bodies of a stack are solved with the unknowns that its ties leave.

Half of a part (geometry/shape.py) takes half of each load. It is held along z all over its cut,
which stands for the other half, and at three displacements in its plane.

The compliance of a part at its interfaces is for a linkage that gives way. The displacement of an
interface is the mean motion of its loaded surface, weighted with the unit load itself: c_ij = f_i .
u_j, the work of load i on the displacements of load j, which makes the matrix symmetric (Maxwell
and Betti). A single load is not in equilibrium. It is balanced by the inertia of the accelerated
part, not by supports, whose point reactions have no finite compliance in a solid; for loads that
balance each other the choice drops out.

Bearing pressures that are applied as they are, on an arc, without a series, measure two errors of
the unit loads at the positions that govern: the truncation of the bearing series, and the effect of
the arc on which a pin presses.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from fem.assembly import Elements, Pattern, Ties, stiffness, ties_of
from fem.recovery import Recovery
from fem.sliding import sliding_coefficients, sliding_loads
from fem.solvers import Factor, chosen_fill, factorize, node_dissection
from fem.unit_loads import (
    ACCELERATIONS,
    InterfaceLoads,
    acceleration_loads,
    bearing_coefficients,
    direct_bearing,
    interface_loads,
    resultants,
)
from geometry.memory import check_memory, compactness_of
from geometry.mesh import FloatArray, IntArray, Mesh

_INTERFACE_MOTION = [0, 1, 5]

_IN_PLANE, _OUT_OF_PLANE = [0, 1, 5], [2, 3, 4]
_UNBALANCED = 1e-9  # of force times size: what loads may leave out of the plane
_UNEVEN = 1e-4  # of the inertia: what a mesh that is not quite symmetric about z = 0 may leave
EVEN = "cos 0"  # column of the even pressure in a bore, 1/(pi R L)
_TILTING = ("M_x", "M_y")  # columns whose pressure has no resultant force, hence no direction


@dataclass(frozen=True)
class Elastic:
    """Isotropic linear elasticity.

    youngs_modulus  MPa
    poisson_ratio   1
    density         t/mm3
    """

    youngs_modulus: float
    poisson_ratio: float
    density: float

    def __post_init__(self) -> None:
        if not self.youngs_modulus > 0:
            raise ValueError(f"Young's modulus must be above 0 MPa, got {self.youngs_modulus}")
        if not -1 < self.poisson_ratio < 0.5:
            raise ValueError(f"Poisson's ratio must be in (-1, 0.5), got {self.poisson_ratio}")
        if not self.density >= 0:
            raise ValueError(f"density must not be negative, got {self.density}")


@dataclass(frozen=True, eq=False)
class UnitSolutions:
    """Solved unit loads of one part.

    elements      the finite elements
    material      elastic constants
    interfaces    unit loads per interface, in the order of their columns
    loads         (3 n_nodes, n_basis)  N per unit
    displacement  (3 n_nodes, n_basis)  mm per unit
    held          (n_held,) unknowns held still, 6 of a whole part; of tied ones the first
    factor        of the stiffness matrix without the held unknowns
    stiffness     upper triangle of the whole stiffness matrix, without ties
    residual      largest backward error of the solves
    ties          of a stack; the factor is then of its independent unknowns
    softened      (n_elements,) of Young's modulus, that each element has; None: all of it
    """

    elements: Elements
    pattern: Pattern
    material: Elastic
    interfaces: tuple[InterfaceLoads, ...]
    loads: FloatArray
    displacement: FloatArray
    held: IntArray
    factor: Factor
    stiffness: "scipy.sparse.csr_array"
    residual: float
    ties: Ties | None = None
    softened: FloatArray | None = None

    @property
    def mesh(self) -> Mesh:
        """The part's mesh."""
        return self.elements.mesh

    @property
    def supports(self) -> IntArray:
        """The held unknowns without those of a half's cut: loads in balance need none of them."""
        return np.setdiff1d(self.held, _cut_unknowns(self.mesh))

    @cached_property
    def recovery(self) -> Recovery:
        """The rule that turns displacements into stress at surface nodes."""
        material = self.material
        return Recovery(
            self.elements, material.youngs_modulus, material.poisson_ratio, self.softened
        )

    @cached_property
    def basis(self) -> FloatArray:
        """Stress of the unit loads at the surface nodes, (n_points, 6, n_basis), MPa per unit."""
        return self.recovery.surface_stress(self.displacement)

    @cached_property
    def bore_waves(self) -> dict[str, Any]:
        """Solved waves of pressure in its bores, by name, for all parts that have this body."""
        return {}

    def moved(self, coefficients: FloatArray) -> FloatArray:
        """Displacement (3 n_nodes, ...), mm, of coefficients (n_basis, ...)."""
        return np.asarray(self.displacement @ coefficients)

    @property
    def raw_deviation(self) -> float:
        """Largest relative error of a unit load's resultant before it was normalised."""
        return max(loads.raw_deviation for loads in self.interfaces)

    @cached_property
    def unit_resultants(self) -> FloatArray:
        """Force and moment about the frame origin of every unit load, (6, n_basis).

        As they act on the mesh: on half of a part half of them, and what its cut balances.
        """
        return resultants(self.elements, self.loads, np.zeros(3))

    def coefficients(
        self,
        wrenches: Mapping[str, FloatArray],
        accelerations: FloatArray,
        reaches: Mapping[str, FloatArray] | None = None,
        tilt_held_at: str | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Coefficients (n_basis, n) of the unit loads, and what inertia was added (n, 3).

        wrenches       interface -> (n, 6) N, N mm at the interface's centre, in the part's axes
        accelerations  (n, 4)  a_x, a_y (less gravity), alpha, omega^2 of the part's frame
        reaches        interface -> (n,) mm, where a sliding contact is along x from the centre;
                       of use to sliding contacts only

        Loads that come with other mass properties than the mesh's leave a residual; it is balanced
        by a rigid-body acceleration field, returned as (a_x, a_y, alpha) for the report. Nothing
        balances forces along z and couples about x and y: they must vanish in sum. Half of a part
        takes the wrenches on the whole, which must have none at any interface.
        """
        self._check_names(wrenches)
        columns = []
        for loads in self.interfaces:
            name = loads.interface.name
            reach = None if reaches is None else reaches.get(name)
            columns.append(_columns(loads, np.asarray(wrenches[name]), reach, half=self.mesh.half))
        columns.append(np.asarray(accelerations))
        coefficients = np.concatenate(columns, axis=1).T
        balance = self.unit_resultants[_IN_PLANE]
        first = coefficients.shape[0] - len(ACCELERATIONS)
        added = -np.linalg.solve(balance[:, first : first + 3], balance @ coefficients)
        coefficients[first : first + 3] += added
        held = self._tilt_columns(tilt_held_at)
        if held:
            coefficients[held] -= self.unit_resultants[[3, 4]] @ coefficients
        if not self.mesh.half:
            self._check_out_of_plane(wrenches, coefficients, first)
        return coefficients, np.asarray(added.T, dtype=np.float64)

    def _tilt_columns(self, name: str | None) -> list[int]:
        """Numbers of an interface's unit couples about x and y; none if it does not tilt."""
        first = 0
        for loads in self.interfaces:
            if loads.interface.name == name and loads.interface.tilts:
                return [first + loads.names.index(couple) for couple in ("M_x", "M_y")]
            first += len(loads.names)
        return []

    def _check_names(self, wrenches: Mapping[str, FloatArray]) -> None:
        """ValueError unless every interface has its load, and every load its interface."""
        own = [unit.interface.name for unit in self.interfaces]
        for name in own:
            if name not in wrenches:
                raise ValueError(f"no load is given at interface {name!r} of {', '.join(own)}")
        for name in wrenches:
            if name not in own:
                raise ValueError(f"a load at {name!r}, but the part's interfaces are {own}")

    def _check_out_of_plane(
        self, wrenches: Mapping[str, FloatArray], coefficients: FloatArray, first: int
    ) -> None:
        """ValueError if the loads leave a force along z or a couple about x or y.

        first  of the inertia's columns, whose share a mesh that is not even may miss by a little
        """
        size = float(np.ptp(self.mesh.nodes, axis=0).max())
        acting = np.stack([np.asarray(wrenches[unit.interface.name]) for unit in self.interfaces])
        acting = np.abs(acting) / [1, 1, 1, size, size, size]
        inertia = np.abs(self.loads[:, first:]).sum(axis=0)  # may balance itself: no resultant
        limit = _UNBALANCED * acting.max(axis=(0, 2))
        limit += _UNEVEN * (inertia @ np.abs(coefficients[first:]))
        left = self.unit_resultants[_OUT_OF_PLANE] @ coefficients
        for row, what, unit, arm in (
            (0, "force along z", "N", 1.0),
            (1, "couple about x", "N mm", size),
            (2, "couple about y", "N mm", size),
        ):
            excess = np.abs(left[row]) - limit * arm
            if excess.max(initial=0.0) > 0:
                worst = int(excess.argmax())
                raise ValueError(
                    f"the loads leave a {what} of {left[row, worst]:.4g} {unit} at position "
                    f"{worst + 1} of {len(excess)}; the part moves in its plane only, so they must "
                    "balance each other"
                )

    def reactions(self, coefficients: FloatArray) -> FloatArray:
        """Reactions (n_supports, n) at the supports, N; of tied unknowns their sum."""
        supports = self.supports
        if self.ties is None:
            unknowns = place = supports
        else:
            unknowns = np.flatnonzero(np.isin(self.ties.number, self.ties.number[supports]))
            place = self.ties.first[self.ties.number[unknowns]]
        rows = self.stiffness[unknowns] + self.stiffness.T.tocsr()[unknowns]
        diagonal = self.stiffness.diagonal()[unknowns]
        internal = rows @ self.displacement - diagonal[:, None] * self.displacement[unknowns]
        needed = np.zeros((len(supports), self.loads.shape[1]))
        np.add.at(needed, np.searchsorted(supports, place), internal - self.loads[unknowns])
        return np.asarray(needed @ coefficients)

    def solve(self, loads: FloatArray) -> FloatArray:
        """Displacement (3 n_nodes, m) of other nodal forces under the same hold."""
        return _solve_held(self.factor, self.held, loads, self.ties)[0]


def solve_unit_loads(
    mesh: Mesh, material: Elastic, softened: FloatArray | None = None
) -> UnitSolutions:
    """Solve the unit loads of a part.

    softened  (n_elements,) of Young's modulus, that each element has; None: all of it

    Raises MeshError if an interface's loads cannot be brought onto the mesh, TooLargeError if there
    is not enough memory, SolverError if the equations cannot be solved.
    """
    elements = Elements(mesh)
    interfaces = tuple(
        sliding_loads(elements, i) if i.kind == "slide" else interface_loads(elements, i)
        for i in mesh.interfaces.values()
    )
    inertia = acceleration_loads(elements, material.density)
    loads = np.concatenate([*(i.vectors for i in interfaces), inertia], axis=1)
    check_memory(
        len(loads), loads.shape[1], compactness_of(mesh.nodes, mesh.volume), fill=chosen_fill()
    )
    pattern = Pattern(elements)
    upper = stiffness(pattern, material.youngs_modulus, material.poisson_ratio, softened)
    ties = ties_of(mesh)
    held = _half_hold(mesh) if mesh.half else determinate_hold(mesh.nodes, ties)
    factor = held_factor(mesh, upper, held, ties)
    displacement, residual = _solve_held(factor, held, loads, ties)
    return UnitSolutions(
        elements=elements,
        pattern=pattern,
        material=material,
        interfaces=interfaces,
        loads=loads,
        displacement=displacement,
        held=held,
        factor=factor,
        stiffness=upper,
        residual=residual,
        ties=ties,
        softened=softened,
    )


def held_factor(
    mesh: Mesh, upper: "scipy.sparse.csr_array", held: IntArray, ties: Ties | None
) -> Factor:
    """Factorise a part's stiffness without its held unknowns, tied ones collected.

    upper  triangle of the whole stiffness matrix, without ties

    Raises SolverError.
    """
    matrix = upper if ties is None else ties.collect_upper(upper)
    free = _free(matrix.shape[0], held, ties)
    by_node = node_dissection(mesh.elements) if ties is None else None
    return factorize(
        matrix[free][:, free].tocsr(), place=None if by_node is None else by_node[free // 3]
    )


def rigid_modes(nodes: FloatArray) -> FloatArray:
    """Six rigid-body displacement fields about the middle of the part, (3 n_nodes, 6)."""
    x, y, z = (nodes - nodes.mean(axis=0)).T
    modes = np.zeros((len(nodes), 3, 6))
    modes[:, [0, 1, 2], [0, 1, 2]] = 1
    modes[:, 1, 3], modes[:, 2, 3] = -z, y
    modes[:, 2, 4], modes[:, 0, 4] = -x, z
    modes[:, 0, 5], modes[:, 1, 5] = -y, x
    return modes.reshape(-1, 6)


def determinate_hold(nodes: FloatArray, ties: Ties | None = None) -> IntArray:
    """Six unknowns that hold a part statically determinately, as far apart as pivoting finds."""
    modes = rigid_modes(nodes)
    modes[:, 3:] /= np.abs(nodes - nodes.mean(axis=0)).max()
    candidates = np.arange(len(modes)) if ties is None else ties.first
    *_, order = scipy.linalg.qr(modes[candidates].T, mode="economic", pivoting=True)
    return np.sort(candidates[order[:6]])


def _half_hold(mesh: Mesh) -> IntArray:
    """Unknowns that hold half of a part: along z on its cut, and three in its plane."""
    modes = rigid_modes(mesh.nodes)[:, _IN_PLANE]
    modes[:, 2] /= np.abs(mesh.nodes - mesh.nodes.mean(axis=0)).max()
    *_, order = scipy.linalg.qr(modes.T, mode="economic", pivoting=True)
    return np.union1d(order[:3], _cut_unknowns(mesh))


def _cut_unknowns(mesh: Mesh) -> IntArray:
    """Displacements along z where a half was cut."""
    return 3 * mesh.cut_nodes + 2


def _columns(
    loads: InterfaceLoads, wrench: FloatArray, reach: FloatArray | None, *, half: bool
) -> FloatArray:
    """Coefficients (n, n_columns) of one interface's unit loads for its wrench (n, 6)."""
    interface = loads.interface
    refused = [2] if interface.tilts else [2, 3, 4]
    other = np.abs(wrench[:, refused]).max(initial=0.0)
    if other > 1e-9 * max(np.abs(wrench).max(initial=0.0), 1e-300):
        what = "forces along z" if interface.tilts else "forces along z or moments about x or y"
        raise ValueError(
            f"interface {interface.name!r} carries {what} up to {other:.3g}; this model"
            f"{' of half of the part' if half else ''} has no unit load for them"
        )
    planar = wrench[:, _IN_PLANE]
    if interface.kind == "slide":
        if reach is None:
            raise ValueError(
                f"interface {interface.name!r} slides: its loads need the place of the contact at "
                "every position"
            )
        return sliding_coefficients(interface, planar, reach)
    if interface.kind in ("face", "clamp"):
        return planar
    bearing = bearing_coefficients(planar, interface.kind == "journal")
    return np.column_stack([bearing, wrench[:, 3:5]]) if interface.tilts else bearing


def _free(count: int, held: IntArray, ties: Ties | None) -> IntArray:
    """The unknowns of the factor among the independent ones."""
    still = held if ties is None else ties.number[held]
    free = np.ones(count, dtype=bool)
    free[still] = False
    return np.flatnonzero(free)


def _solve_held(
    factor: Factor, held: IntArray, loads: FloatArray, ties: Ties | None
) -> tuple[FloatArray, float]:
    own = loads if ties is None else ties.collect(loads)
    free = _free(len(own), held, ties)
    displacement = np.zeros_like(own)
    displacement[free], residual = factor.solve(own[free])
    return displacement if ties is None else ties.expand(displacement), residual


def compliance(solutions: UnitSolutions, places: Sequence[str | tuple[str, float]]) -> FloatArray:
    """Compliance (3 m, 3 m) of a part at m places: mm/N, rad/N, rad/(N mm).

    places  names of interfaces; of a sliding contact its name and where it is along x from the
            interface's centre, mm

    Displacements x, y and turn of every place for forces x, y and couple at every place, in the
    part's axes, against a frame that moves with the part as a whole. A bore or journal is loaded by
    the first harmonic of a pin's pressure, a sliding contact half on each of its two surfaces.
    Raises ValueError for a place that the part does not have, a part without mass, or half of one.
    """
    solutions.mesh.check_whole("a compliance")
    if not solutions.material.density > 0:
        raise ValueError("a compliance needs a density above 0: inertia balances its unit loads")
    columns = np.concatenate([_unit_forces(solutions, place) for place in places], axis=1)
    balance = solutions.unit_resultants[_INTERFACE_MOTION]
    first = len(columns) - len(ACCELERATIONS)
    columns[first : first + 3] -= np.linalg.solve(balance[:, first : first + 3], balance @ columns)
    return np.asarray((solutions.loads @ columns).T @ (solutions.displacement @ columns))


def _unit_forces(solutions: UnitSolutions, place: str | tuple[str, float]) -> FloatArray:
    """Coefficients (n_basis, 3) of the unit loads for 1 N along x, along y, and 1 N mm there."""
    name, at = (place, None) if isinstance(place, str) else place
    result = np.zeros((solutions.loads.shape[1], 3))
    column = 0
    for loads in solutions.interfaces:
        columns = slice(column, column + len(loads.names))
        column = columns.stop
        if loads.interface.name == name:
            result[columns] = _of_interface(loads, at)
            return result
    known = ", ".join(loads.interface.name for loads in solutions.interfaces)
    raise ValueError(f"the part has no interface {name!r}; it has {known}")


def _of_interface(loads: InterfaceLoads, at: float | None) -> FloatArray:
    interface = loads.interface
    if (interface.kind == "slide") != (at is not None):
        need = "needs" if interface.kind == "slide" else "does not slide, so it takes no"
        raise ValueError(f"interface {interface.name!r} {need} place along x")
    if at is not None:
        unit = np.eye(3)
        unit[1, 2] = at  # a force at the contact has a moment about the centre
        reach = np.full(3, at)
        pushed = sliding_coefficients(interface, unit, reach)
        pulled = sliding_coefficients(interface, -unit, reach)
        return np.asarray((pushed - pulled).T / 2)
    result = np.zeros((len(loads.names), 3))
    if interface.kind in ("bore", "journal"):
        sign = -1.0 if interface.kind == "journal" else 1.0
        rows, sizes = ("cos 1", "sin 1", "couple"), (sign, sign, 1.0)
    else:
        rows, sizes = ("F_x", "F_y", "M_z"), (1.0, 1.0, 1.0)
    for axis, (row, size) in enumerate(zip(rows, sizes, strict=True)):
        result[loads.names.index(row), axis] = size
    return result


def direct_displacement(
    solutions: UnitSolutions,
    wrenches: Mapping[str, FloatArray],
    coefficients: FloatArray,
    arcs: Sequence[float],
    solved: Collection[str] = (),
    lasting: Mapping[str, float] | None = None,
) -> FloatArray:
    """Displacement (3 n_nodes, n_arcs) at one position with cosine pressures on arcs, mm.

    wrenches      interface -> (6,) N, N mm
    coefficients  (n_basis,) of that position; used as they are for end faces, clamps, sliding
                  contacts, inertia, and the couples about x and y of pins that tilt
    arcs          rad, full angles of contact of every bore and journal
    solved        names of those whose pressure is solved: their columns are used as they are
    lasting       bore -> N of its even pressure that is no pin's, as of a bush pressed in
    """
    load = np.zeros((len(solutions.loads), len(arcs)))
    column = 0
    for unit in solutions.interfaces:
        columns = slice(column, column + len(unit.names))
        column = columns.stop
        assumed = _is_bearing(unit) and unit.interface.name not in solved
        kept = np.array([not assumed or name in _TILTING for name in unit.names])
        load += (solutions.loads[:, columns][:, kept] @ coefficients[columns][kept])[:, None]
        if assumed:
            planar = np.asarray(wrenches[unit.interface.name])[[0, 1, 5]]
            for k, arc in enumerate(arcs):
                load[:, k] += direct_bearing(solutions.elements, unit, planar, arc)
            even = solutions.loads[:, columns.start + unit.names.index(EVEN)]
            load += ((lasting or {}).get(unit.interface.name, 0.0) * even)[:, None]
    inertia = slice(column, column + len(ACCELERATIONS))
    load += (solutions.loads[:, inertia] @ coefficients[inertia])[:, None]
    return solutions.solve(load)


def even_columns(solutions: UnitSolutions) -> dict[str, int]:
    """Column of the basis that is the even pressure in each bore, by its name."""
    found, first = {}, 0
    for unit in solutions.interfaces:
        if unit.interface.kind == "bore":
            found[unit.interface.name] = first + unit.names.index(EVEN)
        first += len(unit.names)
    return found


def bore_openings(solutions: UnitSolutions, name: str) -> FloatArray:
    """Mean outward displacement of a bore over its radius (n_basis,), per unit of every load."""
    column = even_columns(solutions)[name]
    # the work of 1/(pi R L) on a displacement is twice its mean
    twice = solutions.loads[:, column] @ solutions.displacement / solutions.mesh.share
    return np.asarray(twice / (2 * solutions.mesh.interfaces[name].radius))


def tilting_columns(solutions: UnitSolutions) -> IntArray:
    """Columns (n,) of the basis that are couples about x and y of bores and journals."""
    named = [(_is_bearing(u), name) for u in solutions.interfaces for name in u.names]
    return np.flatnonzero([bearing and name in _TILTING for bearing, name in named])


def has_bearings(solutions: UnitSolutions, solved: Collection[str] = ()) -> bool:
    """Return True if any interface is a bore or a journal, and not one of those solved."""
    return any(
        _is_bearing(unit) and unit.interface.name not in solved for unit in solutions.interfaces
    )


def _is_bearing(unit: InterfaceLoads) -> bool:
    return unit.interface.kind in ("bore", "journal")
