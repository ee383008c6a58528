"""Where half of a part stands for all of it, and what a half shows of the whole."""

import numpy as np
import numpy.typing as npt

from checks.design.data import Part
from checks.part.part_loads import PartLoads
from checks.result.verdict import Surface
from checks.stress.solid_mesh_level import Level
from fem.recovery import von_mises
from geometry.mesh import FloatArray, IntArray, Mesh
from geometry.shape import Half, has_middle_plane

DISPLACEMENT = "displacement [mm]"
STRESS = "stress [MPa]"
INVERSE_SAFETY = "1 / fatigue safety"
_MIRRORED = {3: (1, 1, -1), 6: (1, 1, 1, 1, -1, -1)}  # x, y, z; xx, yy, zz, xy, yz, zx
_NOTHING = 1e-12  # of the largest force, and of force times length
MEANING = (
    "half of the part, mirrored at its middle plane: its loads have no part out of it; what is "
    "told at z > 0 has its mirror image. The first mesh is of the whole part"
)


def half_of(part: Part, loads: PartLoads) -> Half | None:
    """Return the half that answers for a part, if its shape and its loads over all cycles allow it.

    A part moves in its plane: its accelerations have no part out of it. Wrenches may not have any.
    """
    shape = part.geometry
    if not has_middle_plane(shape):
        return None
    largest = max(float(np.abs(wrench[:, :3]).max()) for wrench in loads.wrenches.values())
    for wrench in loads.wrenches.values():
        force = float(np.abs(wrench[:, 2]).max())
        couple = float(np.abs(wrench[:, 3:5]).max())
        if force > _NOTHING * largest or couple > _NOTHING * largest * shape.length:
            return None
    return Half(shape)


def shown_surface(loads: PartLoads, level: Level) -> Surface:
    """Stress at the worst position and 1 over the fatigue safety, on six-node facets split in four.

    The safety is for an endless life by Goodman and Findley, over all cycles of the duty.
    Of the whole part, also where a half was solved.
    """
    nodes = level.history.nodes
    triangles = surface_triangles(level.solutions.mesh, nodes)
    state = level.coefficients[:, level.peak.position]
    displacement = level.solutions.moved(state).reshape(-1, 3)[nodes]
    stress = level.history.at(level.peak.position)
    fields = {"von Mises [MPa]": von_mises(stress)}
    if level.duty is not None:
        fields[INVERSE_SAFETY] = level.duty.everywhere.utilisation
    directed = {DISPLACEMENT: displacement, STRESS: stress}
    surface = Surface(level.history.points, triangles, fields, level.peak.point, directed)
    if not level.half:
        return surface
    return _mirrored(surface, np.isin(nodes, level.solutions.mesh.cut_nodes))


def mode_surface(mesh: Mesh, nodes: IntArray, moved: FloatArray, size: FloatArray) -> Surface:
    """The surface of a whole part as a mode displaces it.

    nodes (n,) on the surface; moved (n_nodes, 3) mm and size (n_nodes,) of the whole mesh
    """
    places = mesh.nodes[nodes] + moved[nodes]
    fields = {"buckling mode": size[nodes]}
    return Surface(places, surface_triangles(mesh, nodes), fields, int(size[nodes].argmax()))


def surface_triangles(mesh: Mesh, nodes: IntArray) -> IntArray:
    """Six-node facets of the boundary split in four, (n, 3) indices of the surface nodes."""
    split = mesh.boundary[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)
    return np.searchsorted(nodes, split)


def _mirrored(surface: Surface, on_cut: npt.NDArray[np.bool_]) -> Surface:
    """Return a half's surface with its mirror image; points on the cut belong to both."""
    nodes, triangles, beside = mirrored(surface.nodes, surface.triangles, on_cut)
    return Surface(
        nodes,
        triangles,
        {name: both_sides(values, beside) for name, values in surface.fields.items()},
        surface.peak,
        {name: both_sides(values, beside) for name, values in surface.directed.items()},
    )


def both_sides(values: FloatArray, beside: IntArray) -> FloatArray:
    """Values (n,), vectors (n, 3) or stress (n, 6) at the nodes, then at the mirror image.

    beside  nodes that the image is of, as `mirrored` tells them
    """
    signs = _MIRRORED[values.shape[1]] if values.ndim > 1 else 1.0
    return np.concatenate([values, values[beside] * signs])


def mirrored(
    nodes: FloatArray, triangles: IntArray, on_cut: npt.NDArray[np.bool_]
) -> tuple[FloatArray, IntArray, IntArray]:
    """Nodes and triangles of a half with its mirror image, and which nodes the image is of.

    on_cut  (n,) whether a node is on the cut, and so in both
    """
    count, beside = len(nodes), np.flatnonzero(~on_cut)
    image = np.arange(count)
    image[beside] = count + np.arange(len(beside))
    return (
        np.concatenate([nodes, nodes[beside] * [1, 1, -1]]),
        np.concatenate([triangles, image[triangles[:, ::-1]]]),
        beside,
    )
