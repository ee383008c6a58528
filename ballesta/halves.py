"""Where half of a part stands for all of it, and what a half shows of the whole."""

import numpy as np
import numpy.typing as npt

from ballesta.design_data import Part
from ballesta.levels import Level
from ballesta.part_loads import PartLoads
from fem.recovery import von_mises
from geometry.halves import Half, has_middle_plane
from geometry.mesh import FloatArray, IntArray, Mesh
from reports.verdict import Surface

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
    """Stress at the worst position and utilisation, on six-node facets split in four.

    Of the whole part, also where a half was solved.
    """
    nodes = level.history.nodes
    triangles = _triangles(level.solutions.mesh, nodes)
    state = level.coefficients[:, level.peak.position]
    displacement = (level.solutions.displacement @ state).reshape(-1, 3)[nodes]
    fields = {"von Mises [MPa]": von_mises(level.history.at(level.peak.position))}
    if level.duty is not None:
        fields["fatigue utilisation"] = level.duty.utilisation_at(np.arange(len(nodes)))
    for axis, name in enumerate("xyz"):
        fields[f"displacement {name} [mm]"] = displacement[:, axis]
    surface = Surface(level.history.points, triangles, fields, level.peak.point)
    if not level.half:
        return surface
    return _mirrored(surface, np.isin(nodes, level.solutions.mesh.cut_nodes))


def mode_surface(mesh: Mesh, nodes: IntArray, moved: FloatArray, size: FloatArray) -> Surface:
    """The surface of a whole part as a mode displaces it.

    nodes (n,) on the surface; moved (n_nodes, 3) mm and size (n_nodes,) of the whole mesh
    """
    places = mesh.nodes[nodes] + moved[nodes]
    fields = {"buckling mode": size[nodes]}
    return Surface(places, _triangles(mesh, nodes), fields, int(size[nodes].argmax()))


def _triangles(mesh: Mesh, nodes: IntArray) -> IntArray:
    """Six-node facets of the boundary split in four, (n, 3) indices of the surface nodes."""
    split = mesh.boundary[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)
    return np.searchsorted(nodes, split)


def _mirrored(surface: Surface, on_cut: npt.NDArray[np.bool_]) -> Surface:
    """Return a half's surface with its mirror image; points on the cut belong to both."""
    count, beside = len(surface.nodes), np.flatnonzero(~on_cut)
    image = np.arange(count)
    image[beside] = count + np.arange(len(beside))
    signs = {"displacement z [mm]": -1.0}
    return Surface(
        np.concatenate([surface.nodes, surface.nodes[beside] * [1, 1, -1]]),
        np.concatenate([surface.triangles, image[surface.triangles[:, ::-1]]]),
        {
            name: np.concatenate([values, signs.get(name, 1.0) * values[beside]])
            for name, values in surface.fields.items()
        },
        surface.peak,
    )
