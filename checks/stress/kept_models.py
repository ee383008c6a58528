"""Bodies, meshes and unit solutions of a run, from the store where they are in it.

Nothing that solves is imported before it is needed.
"""

from collections.abc import Iterable, Set
from concurrent.futures import Future, ThreadPoolExecutor
from math import inf
from time import perf_counter
from typing import TYPE_CHECKING

from checks.store.store import Store
from checks.stress.cost import SECOND_MESH, solve_seconds
from geometry.cad_body import Skin, SolidBody, cad_body, cad_skin
from geometry.closed_form import closed_body
from geometry.mesh import Mesh
from geometry.meshing import Buildable, mesh_shape
from geometry.progress import expect
from geometry.sizing import SizeField
from geometry.symmetry import Half

if TYPE_CHECKING:
    from fem.unit_solutions import Elastic, UnitSolutions

_PACKAGES = ("geometry",)


class Models:
    """Meshes and unit solutions of a run, so that equal parts are meshed and solved once.

    store  what earlier runs have left, and where this one's are kept
    """

    def __init__(self, store: Store | None = None) -> None:
        self.store = store
        self._meshes: dict[tuple[Buildable, float, SizeField | None], Mesh] = {}
        self._solutions: dict[
            tuple[Buildable, float, SizeField | None, Elastic], UnitSolutions
        ] = {}
        self._bodies: dict[Buildable, SolidBody] = {}
        self._skins: dict[Buildable, Skin] = {}
        self._begun: dict[Buildable, Future[Skin]] = {}
        self._mesh_seconds: dict[Buildable, float] = {}  # expected of a finer mesh
        self.seconds: dict[str, float] = {"mesh": 0.0, "solve": 0.0}

    def body(self, shape: Buildable) -> SolidBody:
        """Return what is known of a shape without a mesh, in closed form or by the CAD kernel.

        Raises MeshError.
        """
        if shape not in self._bodies:
            start = perf_counter()
            self._bodies[shape] = closed_body(shape) or stored_body(self.store, shape)
            self.seconds["mesh"] += perf_counter() - start
        return self._bodies[shape]

    def skin(self, shape: Buildable) -> Skin:
        """Return a coarse surface of a shape, to draw it; raises MeshError."""
        if shape not in self._skins:
            start = perf_counter()
            begun = self._begun.pop(shape, None)
            self._skins[shape] = begun.result() if begun else stored_skin(self.store, shape)
            self.seconds["mesh"] += perf_counter() - start
        return self._skins[shape]

    def begin_skins(self, shapes: Iterable[Buildable]) -> None:
        """Have the surfaces of shapes known in closed form made beside other work, but for a store.

        gmsh holds no lock of Python's, so a thread of its own is enough.
        """
        if self.store is not None:
            return
        closed = [shape for shape in dict.fromkeys(shapes) if closed_body(shape)]
        with_gmsh = ThreadPoolExecutor(max_workers=1)
        self._begun |= {shape: with_gmsh.submit(stored_skin, None, shape) for shape in closed}
        with_gmsh.shutdown(wait=False)

    def mesh(
        self,
        shape: Buildable,
        fineness: float,
        sizes: SizeField | None = None,
        most_unknowns: float = inf,
    ) -> Mesh:
        """Return the mesh of a shape; `sizes` asks for smaller elements in places.

        Raises MeshError, and TooManyUnknownsError where it would surely have more than the most.
        """
        key = (shape, fineness, sizes)
        if key not in self._meshes:
            start = perf_counter()
            expect("meshing", self._mesh_seconds.get(_whole(shape), 0.0))
            self._meshes[key] = stored_mesh(self.store, shape, fineness, sizes, most_unknowns)
            took = perf_counter() - start
            self._mesh_seconds.setdefault(_whole(shape), SECOND_MESH * took)
            self.seconds["mesh"] += took
        return self._meshes[key]

    def solutions(
        self, shape: Buildable, fineness: float, material: "Elastic", sizes: SizeField | None = None
    ) -> "UnitSolutions":
        """Return the solved unit loads of a shape."""
        key = (shape, fineness, sizes, material)
        if key not in self._solutions:
            from checks.store.solutions import stored_solutions
            from fem.unit_solutions import solve_unit_loads

            mesh = self.mesh(shape, fineness, sizes)
            start = perf_counter()
            unknowns = 3 * len(mesh.nodes)
            expect(f"solving {unknowns} unknowns", solve_seconds(unknowns))
            self._solutions[key] = (
                solve_unit_loads(mesh, material)
                if self.store is None
                else stored_solutions(self.store, mesh, material)
            )
            _ = self._solutions[key].basis
            self.seconds["solve"] += perf_counter() - start
        return self._solutions[key]

    def keep_only(self, shapes: Set[Buildable]) -> None:
        """Let go of the meshes and factors of all other shapes: a factor takes up to a GiB."""
        self._meshes = {k: mesh for k, mesh in self._meshes.items() if _whole(k[0]) in shapes}
        self._solutions = {k: done for k, done in self._solutions.items() if _whole(k[0]) in shapes}


def _whole(shape: Buildable) -> Buildable:
    """The shape itself, or the one whose half it is."""
    return shape.whole if isinstance(shape, Half) else shape


def stored_body(store: Store | None, shape: Buildable) -> SolidBody:
    """Return what the CAD kernel knows of a shape; raises MeshError."""
    if store is None:
        return cad_body(shape)
    return store.remember("body", _PACKAGES, shape, lambda: cad_body(shape))


def stored_skin(store: Store | None, shape: Buildable) -> Skin:
    """Return a coarse surface of a shape, to draw it; raises MeshError."""
    if store is None:
        return cad_skin(shape)
    return store.remember("skin", _PACKAGES, shape, lambda: cad_skin(shape))


def stored_mesh(
    store: Store | None,
    shape: Buildable,
    fineness: float,
    sizes: SizeField | None,
    most_unknowns: float = inf,
) -> Mesh:
    """Return the mesh of a shape, as mesh_shape does; raises MeshError."""

    def mesh() -> Mesh:
        return mesh_shape(shape, fineness=fineness, sizes=sizes, most_unknowns=most_unknowns)

    if store is None:
        return mesh()
    return store.remember("mesh", _PACKAGES, (shape, fineness, sizes), mesh)
