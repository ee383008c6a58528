"""From a CAD body in gmsh to a Mesh: pinned options, named surfaces, no file in between.

Nodes, elements and groups are read from gmsh's API straight into arrays: a detour through a mesh
file loses the names of surfaces on second-order meshes.

Bodies that touch without being one have nodes of their own on the shared faces, and ties.

Where elements are far larger than the fillets beside them HXT fills a body with flat tetrahedra,
and its optimisation seeks long for better ones that are not there: 26 s for 3624 tetrahedra of a
pin, 64 % of them flat, of which 42 % were flat afterwards. The other mesher leaves 0.1 % flat in
0.7 s.
"""

import math
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from threading import RLock
from typing import Any

import numpy as np

from geometry import INSTALL
from geometry.curving import ENOUGH, Gliding, around, bent, least_coefficients, moved, nearly_folded
from geometry.memory import check_memory, compactness_of, within_memory
from geometry.mesh import (
    FloatArray,
    FoldedElementError,
    IntArray,
    Mesh,
    MeshError,
    Tie,
    TooManyUnknownsError,
    UnsafeMesherError,
)
from geometry.shape import Body, Buildable, in_unit, unit_of
from geometry.sizing import SURE, SizeField, check_elements, solid_elements, solid_unknowns

_NORMAL = 1  # a stack's faces are normal to y
# Every option that changes a mesh is set here, so that the same part gives the same mesh.
_ALONE = RLock()  # gmsh has one model at a time
_OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,  # two threads gave three different meshes in three runs
    "Mesh.RandomSeed": 1,
    "Mesh.Algorithm": 6,  # frontal-Delaunay on surfaces
    "Mesh.Optimize": 1,
    "Mesh.ElementOrder": 2,
    "Mesh.SecondOrderLinear": 0,
    "Mesh.HighOrderOptimize": 0,  # it goes by addresses in memory: see _mend
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Geometry.OCCParallel": 0,
    "Geometry.Tolerance": 1e-8,
}
# Algorithms of the volume mesh, the faster one first; what the other one does where it cannot.
_HXT, _DELAUNAY = ("HXT", 10), ("Delaunay", 1)
# Unknowns of a mesh whose arrays in HXT stand among other data of the heap, less than 128 KiB each:
# there a stray write ends the process, so HXT is tried without its optimisation before.
_SMALL = 50_000
_TELLING = {"General.Verbosity": 6.0}  # of HXT's memory
# The curves' mesh is kept, with the numbers on whose order that of the faces depends.
_FILLING = {"Mesh.Optimize": 0.0, "Mesh.ElementOrder": 1.0, "Mesh.Renumber": 0.0}
_FLAT = 0.1  # quality by gmsh, 1 at best: inscribed radius over circumscribed radius, thrice
_STRAIGHT = 4  # number by gmsh of tetrahedra with four nodes
_MOST_FLAT = 0.25  # of the tetrahedra; others at 0.35 to 0.7 of the fineness of designs: 0.16
_LAYERS = (0, 1, 2, 3)  # of elements around those that fold whose nodes move
_LOADS = 8  # unit loads of a pin
_SIGACTION = 1024  # bytes, more than any system's struct sigaction: 152 of Linux, 16 of macOS
_IN_PLANE = 1e-7  # units: how far the nodes of a half may be beside its cut, by gmsh's round-off
_FROM_GMSH_TO_VTK = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]


@dataclass(frozen=True, eq=False)
class Split:
    """A conformal mesh of several bodies, taken apart.

    nodes     (n_nodes, 3) mm: the given ones, then a copy for each further body on a shared face
    copies    per body: the index of its own node for every given one, (n_given,)
    pairs     (n, 2) node indices at one place: of a body, then of the next one there
    """

    nodes: FloatArray
    copies: tuple[IntArray, ...]
    pairs: IntArray


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """Open a gmsh session with pinned options, closed whatever happens; one at a time.

    Raises MeshError that names the system library if gmsh cannot be loaded.
    """
    try:
        import gmsh
    except OSError as error:
        raise MeshError(
            f"gmsh cannot be loaded ({error}); on Debian and Ubuntu: {INSTALL}"
        ) from error
    with _ALONE:
        with _broken_pipes_as_before():
            gmsh.initialize(readConfigFiles=False, interruptible=False)
        try:
            for name, value in _OPTIONS.items():
                gmsh.option.setNumber(name, value)
            gmsh.model.add("part")
            yield gmsh
        finally:
            gmsh.finalize()


@contextmanager
def _broken_pipes_as_before() -> Iterator[None]:
    """Undo what gmsh does to SIGPIPE: writing to a pipe without a reader would end the process.

    Python ignores the signal and raises BrokenPipeError, once a helper process has died. sigaction
    of C serves any thread, signal.signal the main thread only.
    """
    if sys.platform == "win32":  # has no such signal
        yield
        return
    import ctypes

    before = ctypes.create_string_buffer(_SIGACTION)
    sigaction = ctypes.CDLL(None).sigaction
    sigaction(signal.SIGPIPE, None, before)
    try:
        yield
    finally:
        sigaction(signal.SIGPIPE, before, None)


def mesh_shape(
    shape: Buildable,
    *,
    fineness: float = 1.0,
    sizes: SizeField | None = None,
    most_unknowns: float = math.inf,
) -> Mesh:
    """Mesh a shape; `fineness` divides every element size, and `sizes` may ask for smaller ones.

    Raises MeshError if the body is not one solid, gmsh gives up, or the mesh is not usable, and
    TooManyUnknownsError where it would surely have more unknowns than `most_unknowns`. The mesh's
    `mesher` says so where the second algorithm had to be taken. Very small and very large shapes
    are meshed in another unit than mm (geometry/shape.py): 1000 times as large a shape has a
    mesh 1000 times as large.
    """
    if not fineness > 0:
        raise ValueError(f"fineness must be above 0, got {fineness}")
    try:
        return _mesh_with(shape, fineness, sizes, most_unknowns, *_HXT)
    except FoldedElementError:
        why = "HXT folded an element"
    except UnsafeMesherError as error:
        why = str(error)
    mesher, algorithm = _DELAUNAY
    return _mesh_with(shape, fineness, sizes, most_unknowns, f"{mesher}, because {why}", algorithm)


def _mesh_with(
    shape: Buildable,
    fineness: float,
    sizes: SizeField | None,
    most_unknowns: float,
    mesher: str,
    algorithm: int,
) -> Mesh:
    unit = unit_of(shape)
    with gmsh_session() as gmsh:
        gmsh.option.setNumber("Mesh.Algorithm3D", algorithm)
        try:
            body = in_unit(shape, unit).build(gmsh)
            unknowns = _check_count(gmsh, body, fineness, most_unknowns, unit)
            _set_sizes(gmsh, body, fineness, sizes and sizes.in_unit(unit))
            hxt = algorithm == _HXT[1]
            if hxt and unknowns < _SMALL:
                _try_hxt(gmsh)
            _generate(gmsh, hxt=hxt)
        except MeshError:
            raise
        except Exception as error:  # gmsh raises bare Exception only
            raise MeshError(f"gmsh could not mesh the part: {error}") from error
        return _read_mesh(gmsh, body, mesher, unit)


def _check_count(
    gmsh: Any, body: Body, fineness: float, most_unknowns: float, unit: float
) -> float:
    """Return a body's unknowns, estimated before it is meshed in a unit of so many mm.

    Refuses a body that would take more unknowns than allowed, or more memory than there is. What a
    field of sizes makes finer is not counted: the solve counts again on the mesh.
    """
    unknowns = solid_unknowns(gmsh, body, fineness)
    if unknowns > SURE * most_unknowns:
        raise TooManyUnknownsError(unknowns)
    check_elements(solid_elements(gmsh, body, fineness), unit * body.size / fineness)
    volume = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
    box = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
    check_memory(int(unknowns), _LOADS * len(body.interfaces) + 4, compactness_of(box, volume))
    return unknowns


@contextmanager
def _told(gmsh: Any, **options: float) -> Iterator[list[str]]:
    """Messages of gmsh, filled in at the end, with options "group.name" that hold so long.

    An error of gmsh may be thrown where no one can catch it and end the process. So gmsh must not
    throw here: its messages are read instead.
    """
    messages: list[str] = []
    wanted = {"General.AbortOnError": 0.0, **options}
    before = {name: gmsh.option.getNumber(name) for name in wanted}
    gmsh.logger.start()
    try:
        for name, value in wanted.items():
            gmsh.option.setNumber(name, value)
        yield messages
        messages += gmsh.logger.get()
    finally:
        for name, value in before.items():
            gmsh.option.setNumber(name, value)
        gmsh.logger.stop()


def _try_hxt(gmsh: Any) -> None:
    """Raise UnsafeMesherError where HXT's optimisation is of no use.

    It would leave its memory, or the mesh has too many flat tetrahedra. Faces are meshed again
    afterwards: gmsh turns some of their triangles round, on which HXT's next mesh would depend.
    Edges, most of the time, are not.
    """
    with _told(gmsh, **_TELLING, **_FILLING) as messages:
        gmsh.model.mesh.generate(3)
    tags, _ = gmsh.model.mesh.getElementsByType(_STRAIGHT)
    qualities = np.asarray(gmsh.model.mesh.getElementQualities(tags, "gamma"))
    if any(message.startswith("Error") for message in messages):
        gmsh.model.mesh.clear()
        return
    gmsh.model.mesh.clear([*gmsh.model.getEntities(3), *gmsh.model.getEntities(2)])
    _check_memory_of_hxt(messages)
    flat = np.count_nonzero(qualities < _FLAT)
    if flat > _MOST_FLAT * len(qualities):
        raise UnsafeMesherError(f"HXT leaves {flat / len(qualities):.0%} of the elements flat")


def _check_memory_of_hxt(messages: Sequence[str]) -> None:
    if not within_memory(messages):
        raise UnsafeMesherError("HXT would write outside of its memory")


def _generate(gmsh: Any, *, hxt: bool) -> None:
    """Mesh the body in gmsh's model; raises MeshError with gmsh's own words."""
    with _told(gmsh, **_TELLING) as messages:
        gmsh.model.mesh.generate(3)
        _mend(gmsh)
    errors = [m.removeprefix("Error: ") for m in messages if m.startswith("Error")]
    if errors:
        hint = ""
        if any("3D mesh failed" in m or "ntersect" in m for m in errors):
            hint = "; a wall or a ligament may be far thinner than the elements beside it"
        raise MeshError(f"gmsh could not mesh the part: {'; '.join(errors[:3])}{hint}")
    if hxt:
        _check_memory_of_hxt(messages)


def _mend(gmsh: Any) -> None:
    """Mend curved elements that fold in gmsh's model.

    Inner edges are bent first. Where that is not enough, nodes of more and more elements around
    those that fold move, those on the surface along it. gmsh's own optimiser is not used: it goes
    by addresses in memory, so it gives another mesh each time.
    """
    volumes = [tag for _, tag in gmsh.model.getEntities(3)]
    tags, nodes, index = _nodes(gmsh)
    if not len(tags):
        return  # gmsh has told why
    elements = np.concatenate([_solids(gmsh, index, tag) for tag in volumes])
    inside = np.concatenate([index[gmsh.model.mesh.getNodes(3, tag)[0]] for tag in volumes])
    found = bent(nodes, elements, inside)
    if least_coefficients(found, elements).min(initial=1.0) < ENOUGH:
        for layers in _LAYERS:
            low = nearly_folded(found, elements)
            if not low.any():
                break
            gliding = Gliding(gmsh, found, index, around(elements, low, layers))
            found = moved(found, elements, gliding)
    _place(gmsh, tags, nodes, found)


def _nodes(gmsh: Any) -> tuple[IntArray, FloatArray, IntArray]:
    """Tags (n,) and places (n, 3) of the nodes in gmsh's model, and the index of each tag."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max(initial=0)) + 1, -1, dtype=np.int64)
    index[tags] = np.arange(len(tags))
    return tags, np.array(coordinates, dtype=float).reshape(-1, 3), index


def _place(gmsh: Any, tags: IntArray, now: FloatArray, wanted: FloatArray) -> None:
    for node in np.flatnonzero((now != wanted).any(axis=1)):
        gmsh.model.mesh.setNode(int(tags[node]), wanted[node].tolist(), [])


def _set_sizes(gmsh: Any, body: Body, fineness: float, sizes: SizeField | None) -> None:
    field = gmsh.model.mesh.field
    thresholds = []
    alike: dict[tuple[float, float], list[tuple[int, int]]] = {}  # one search for all of them
    for region in body.regions:
        alike.setdefault((region.size, region.reach), []).extend(region.entities)
    for (size, reach), entities in alike.items():
        distance = field.add("Distance")
        for dimension, key in ((1, "CurvesList"), (2, "SurfacesList")):
            tags = [tag for d, tag in entities if d == dimension]
            if tags:
                field.setNumbers(distance, key, tags)
        field.setNumber(distance, "Sampling", 40)
        threshold = field.add("Threshold")
        field.setNumber(threshold, "InField", distance)
        field.setNumber(threshold, "SizeMin", size / fineness)
        field.setNumber(threshold, "SizeMax", body.size / fineness)
        field.setNumber(threshold, "DistMin", 0.1 * reach)
        field.setNumber(threshold, "DistMax", reach)
        thresholds.append(threshold)
    if sizes is not None:
        thresholds.append(sizes.to_gmsh(gmsh))
    smallest = field.add("Min")
    field.setNumbers(smallest, "FieldsList", thresholds)
    field.setAsBackgroundMesh(smallest)
    gmsh.option.setNumber("Mesh.MeshSizeMax", body.size / fineness)


def rounded(nodes: FloatArray) -> FloatArray:
    """Nodes to 1e-10 of the part's size: the last bits of moved ones depend on the processor."""
    digits = 10 - math.ceil(math.log10(float(np.ptp(nodes, axis=0).max())))
    return np.asarray(np.round(nodes, digits))


def _read_mesh(gmsh: Any, body: Body, mesher: str, unit: float) -> Mesh:
    """The mesh in gmsh's model, which stands there in a unit of so many mm."""
    volumes = [tag for _, tag in gmsh.model.getEntities(3)]
    if len(volumes) != 1 and not (body.stacked and volumes):
        raise MeshError(f"the part must be one solid, the CAD kernel built {len(volumes)}")
    _, places, index = _nodes(gmsh)
    nodes = rounded(places)

    solids = [_solids(gmsh, index, tag) for tag in volumes]
    split = split_bodies(nodes, solids)
    elements = np.concatenate([own[solid] for own, solid in zip(split.copies, solids, strict=True)])

    surfaces = {}
    for name, faces in body.surfaces.items():
        if not faces:
            raise MeshError(f"no face of the body was found for surface {name!r}")
        parts = []
        for tag in faces:
            solid = int(gmsh.model.getAdjacencies(2, tag)[0][0])
            own = split.copies[volumes.index(solid)]
            parts.append(own[_elements(gmsh, index, 9, tag, 6)])
        surfaces[name] = np.concatenate(parts)

    used = np.unique(elements)
    renumber = np.full(len(split.nodes), -1, dtype=np.int64)
    renumber[used] = np.arange(len(used))
    placed = split.nodes[used]
    if body.half:
        placed[np.abs(placed[:, 2]) <= _IN_PLANE, 2] = 0.0
    return Mesh(
        nodes=unit * placed,
        elements=renumber[elements],
        surfaces={name: renumber[facets] for name, facets in surfaces.items()},
        interfaces={one.name: one.in_mm(unit) for one in body.interfaces},
        volume_cad=unit**3 * float(sum(gmsh.model.occ.getMass(3, tag) for tag in volumes)),
        mesher=mesher,
        ties=ties_of(placed, renumber[split.pairs], body.bolted_at),
        half=body.half,
        unit=unit,
        entities=_entities(gmsh, index)[used] if len(volumes) == 1 else None,
    )


def _entities(gmsh: Any, index: IntArray) -> IntArray:
    """Dimension and tag of the CAD entity that each node is on, (n, 2)."""
    found = np.zeros((int(index.max()) + 1, 2), dtype=np.int64)
    for entity in gmsh.model.getEntities():
        tags = gmsh.model.mesh.getNodes(*entity, returnParametricCoord=False)[0]
        found[index[np.asarray(tags, dtype=np.int64)]] = entity
    return found


def _solids(gmsh: Any, index: IntArray, tag: int) -> IntArray:
    """Node indices of the elements of one CAD solid, (n, 10), VTK order."""
    return _elements(gmsh, index, 11, tag, 10)[:, _FROM_GMSH_TO_VTK]


def _elements(gmsh: Any, index: IntArray, kind: int, tag: int, width: int) -> IntArray:
    """Node indices of the elements of one of gmsh's types on a CAD face or solid, (n, width)."""
    _, connectivity = gmsh.model.mesh.getElementsByType(kind, tag)
    return np.asarray(index[np.asarray(connectivity, dtype=np.int64).reshape(-1, width)])


def split_bodies(nodes: FloatArray, bodies: Sequence[IntArray]) -> Split:
    """Give every body of a conformal mesh nodes of its own.

    bodies  per body: elements (n, 10), indices into `nodes`

    Raises MeshError if a body touches none of the others.
    """
    owner = np.full(len(nodes), -1)
    latest = np.arange(len(nodes))
    grown, copies, pairs = [nodes], [], []
    touching = []
    count = len(nodes)
    for body, elements in enumerate(bodies):
        used = np.unique(elements)
        shared = used[owner[used] >= 0]
        own = np.arange(len(nodes))
        own[shared] = count + np.arange(len(shared))
        count += len(shared)
        grown.append(nodes[shared])
        pairs.append(np.column_stack([latest[shared], own[shared]]))
        touching += [(int(other), body) for other in np.unique(owner[shared])]
        latest[shared] = own[shared]
        owner[used] = body
        copies.append(own)
    _check_that_all_touch(len(bodies), touching)
    return Split(np.concatenate(grown), tuple(copies), np.concatenate(pairs))


def _check_that_all_touch(count: int, touching: Sequence[tuple[int, int]]) -> None:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    first, second = np.array(touching, dtype=int).reshape(-1, 2).T
    links = coo_matrix((np.ones(len(first)), (first, second)), shape=(count, count))
    heaps, _ = connected_components(links, directed=False)
    if heaps > 1:
        raise MeshError(f"the {count} bodies of the stack fall into {heaps} that do not touch")


def ties_of(nodes: FloatArray, pairs: IntArray, bolted_at: float | None) -> tuple[Tie, ...]:
    """Return the ties of a stack: all pairs along y; those of the bolt at x, mm, along x too.

    Along z one pair of each two bodies is tied, the nearest to their middle: bent bodies widen
    where they are pressed and narrow where they are pulled, so two faces that meet must be free to
    slide across; a line tied along z carried a shear without a finite stress.
    Raises MeshError if there is a bolt and no pair in its plane.
    """
    if not len(pairs):
        return ()
    ties = (Tie(_NORMAL, pairs),)
    if bolted_at is None:
        return ties
    bolt = pairs[np.abs(nodes[pairs[:, 0], 0] - bolted_at) <= 1e-6]
    if not len(bolt):
        raise MeshError(f"no nodes of the stack lie at the bolt's x = {bolted_at:g} mm")
    heights = np.round(nodes[bolt[:, 0], 1], 6)
    middle = np.abs(nodes[bolt[:, 0], 2])
    order = np.lexsort((middle, heights))
    _, first = np.unique(heights[order], return_index=True)
    return (Tie(0, bolt), *ties, Tie(2, bolt[order[first]]))
