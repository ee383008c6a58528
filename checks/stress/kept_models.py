"""Bodies, meshes and unit solutions of a run, from the store where they are in it.

Nothing that solves is imported before it is needed.

Errors of a mesher or a solver name the part and the size that they are about.
"""

from collections.abc import Iterable, Iterator, Set
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from math import inf
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

import loads
from checks.design.data import Design, Part
from checks.design.errors import DesignError, NumericsError
from checks.store.store import Store
from fem.threads import one_thread
from geometry.cad_body import Skin, SolidBody, cad_body, cad_skin
from geometry.closed_form import closed_body
from geometry.mesh import Mesh, MeshError, TooFineError, TooManyElementsError, TooManyUnknownsError
from geometry.meshing import mesh_shape
from geometry.parts.pin import as_pin
from geometry.progress import expect
from geometry.shape import Buildable, Half, far_apart, key_of, sizes_of
from geometry.sizing import SizeField

if TYPE_CHECKING:
    from fem.unit_solutions import Elastic, UnitSolutions
    from geometry.carrying import Carrier

_PACKAGES = ("geometry",)
_BY_WIDTH = 3  # power of a narrow lug's width by which unknowns fall


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
        self._carried: dict[tuple[Buildable, str, Elastic], UnitSolutions] = {}
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

    def carried(self, carrier: "Carrier", shape: Buildable, material: "Elastic") -> "UnitSolutions":
        """Return the solved unit loads of a shape on a mesh that is carried over to it.

        Raises MeshError where it cannot be.
        """
        key = (shape, carrier.digest, material)
        if key not in self._carried:
            from fem.unit_solutions import solve_unit_loads

            start = perf_counter()
            mesh = carrier.to(shape)
            self.seconds["mesh"] += perf_counter() - start
            start = perf_counter()
            self._carried[key] = solve_unit_loads(mesh, material)
            _ = self._carried[key].basis
            self.seconds["solve"] += perf_counter() - start
        return self._carried[key]

    def measured(self, shape: Buildable, fineness: float) -> Mesh:
        """Return a mesh of a shape to measure it on: one carried over to it, if there is one.

        Raises MeshError.
        """
        carried = (done.mesh for (one, *_), done in self._carried.items() if one == shape)
        return next(carried, None) or self.mesh(shape, fineness)

    def keep_only(self, shapes: Set[Buildable]) -> None:
        """Let go of the meshes and factors of all other shapes: a factor takes up to a GiB."""
        self._meshes = {k: mesh for k, mesh in self._meshes.items() if _whole(k[0]) in shapes}
        self._solutions = {k: done for k, done in self._solutions.items() if _whole(k[0]) in shapes}
        self._carried = {k: done for k, done in self._carried.items() if _whole(k[0]) in shapes}


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


# Expected time and memory of a part's solids, before they are paid for.

# Memory, measured with CHOLMOD (bench/results.json): 137 628 unknowns with 20 unit loads.
_UNKNOWNS, _GIBIBYTES, _MEMORY_EXPONENT = 137_628, 1.3, 1.2

# Processor time, s, of 100 000 unknowns with one thread on a core of 2.3 GHz on which `_trial`
# takes `_TRIAL`: the solids of the press and of the slider-crank, 8 000 to 120 000 unknowns
# (python -m bench.plan_times compares them with a check). `_JUDGE_STRESS`: static stress and
# fatigue alone, as `auto` asks for them, of the press, a crank-rocker and a tail lift.
_HUNDRED_THOUSAND = 100_000
_MESH, _SOLVE, _SOLVE_EXPONENT, _JUDGE, _JUDGE_STRESS = 5.0, 4.0, 1.4, 22.0, 6.0
_TRIAL = 0.0022
_REPORT, _REPORT_OF_A_PART = 2.0, 1.0  # encoding, pictures and page
SECOND_MESH = 1.8  # times the unknowns of the first, as parts of the press need them


def mesh_seconds(unknowns: int) -> float:
    """Estimated time to mesh a part, s."""
    return slowness() * _MESH * unknowns / _HUNDRED_THOUSAND


def solve_seconds(unknowns: int) -> float:
    """Estimated time from a mesh to the stress basis of a part's unit loads, s."""
    return slowness() * _SOLVE * float((unknowns / _HUNDRED_THOUSAND) ** _SOLVE_EXPONENT)


def judging_seconds(unknowns: int, *, stress: bool = False) -> float:
    """Estimated time of what follows the solves on the last mesh, s: fatigue, buckling, fields.

    stress  whether it is judged alone
    """
    each = _JUDGE_STRESS if stress else _JUDGE
    return slowness() * each * unknowns / _HUNDRED_THOUSAND


def solve_gibibytes(unknowns: int) -> float:
    """Estimated memory to solve a part's unit loads, GiB."""
    return float(_GIBIBYTES * (unknowns / _UNKNOWNS) ** _MEMORY_EXPONENT)


def solid_seconds(first: int, second: int, *, stress: bool = False) -> float:
    """Estimated time of a part's check on two meshes of so many unknowns, s."""
    each = (mesh_seconds(n) + solve_seconds(n) for n in (first, second))
    return sum(each) + judging_seconds(second, stress=stress)


def check_seconds(first: int, *, stress: bool = False) -> float:
    """Estimated time of a part's check once its first mesh is made, of so many unknowns, s."""
    second = int(SECOND_MESH * first)
    return solid_seconds(first, second, stress=stress) - mesh_seconds(first)


def report_seconds(parts: int) -> float:
    """Estimated time of the pictures and the page of a check of so many parts, s."""
    return slowness() * (_REPORT + _REPORT_OF_A_PART * parts)


@cache
def slowness() -> float:
    """How many times longer this machine takes now than the one of the constants, from a trial.

    The best of four rounds of products, sums and sorts, of 2 ms each.
    """
    with one_thread():
        return min(_trial() for _ in range(4)) / _TRIAL


def _trial() -> float:
    """Time, s, of work such as a solid takes: dense products, gathering, sorting."""
    random = np.random.default_rng(0)
    dense, places = random.random((200, 200)), random.integers(0, 20_000, 50_000)
    values = random.random(20_000)
    start = perf_counter()
    _ = dense @ dense @ dense
    np.bincount(places, values[places], 20_000)
    np.argsort(places)
    values[places].sum()
    return perf_counter() - start


def told_of_size(design: Design, part: Part, error: Exception) -> DesignError:
    """The error of a mesher, with the key of the size that is farthest from the part's others."""
    key, sizes = f"parts.{part.name}", sizes_of(part.geometry)
    pin, many = as_pin(part.geometry), error.__cause__
    if pin is not None and isinstance(many, TooManyUnknownsError) and pin.narrow:
        index = min(range(len(pin.seats)), key=lambda k: pin.seats[k].width)
        width = pin.seats[index].width
        least = width * (many.unknowns / part.most_unknowns) ** (1 / _BY_WIDTH)
        return DesignError(
            design.file,
            f"{key}.stack[{index}].width",
            f"a lug of {width:g} mm on a pin of {pin.diameter:g} mm takes about "
            f"{many.unknowns:.1g} unknowns, where mesh.most_unknowns is {part.most_unknowns:g}; it "
            f"must be at least about {least:.2g} mm for a solid (--fidelity formula takes none)",
        )
    if not isinstance(error, TooFineError) or not sizes:
        return DesignError(design.file, key, str(error))
    odd, other = far_apart(sizes)
    stated = key_of(part.geometry, odd)
    pins, apart = ("pins that are ", " apart") if stated == "interfaces" else ("", "")
    told = f"{pins}{sizes[odd]:.4g} mm{apart} beside {other} = {sizes[other]:.4g} mm"
    return DesignError(
        design.file, f"{key}.{stated}", f"{told} are too far from each other: {error}"
    )


def gave_up(design: Design, part: Part, error: Exception) -> NumericsError:
    """The error of a mesher or a solver, with the part that it is about."""
    return NumericsError(
        str(error),
        f"{design.file}: parts.{part.name}",
        "check the part's dimensions, or change mesh.fineness",
    )


@contextmanager
def told_of_part(design: Design, part: Part) -> Iterator[None]:
    """Turn what goes wrong with a part into an error that names it."""
    try:
        yield
    except (loads.LinkageError, TooManyElementsError) as error:
        raise told_of_size(design, part, error) from error
    except _no_answer() as error:
        raise gave_up(design, part, error) from error


def _no_answer() -> tuple[type[Exception], ...]:
    """Errors of a mesher and a solver; asked for once there is an error."""
    from fem.solvers import SolverError

    return MeshError, SolverError
