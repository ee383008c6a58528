"""Stress at surface nodes by one rule, and the scatter of the elements that meet there.

The rule: in each element the stress at the four integration points, where quadratic elements are
most accurate, is continued linearly to its ten nodes; at a node the elements that share it are
averaged with their volumes as weights. Elements at an edge where a pressure ends
(`singularity.pressed_edges`) say nothing: their points take the stress of the nearest point of
other elements only. Components are ordered xx, yy, zz, xy, yz, zx everywhere.

From the scatter come the local error of a solution, and the element sizes that would make it small
enough. The estimate of Zienkiewicz and Zhu (Int. J. Num. Meth. Eng. 24 (1987) 337) compares the
stress of each element with the smoother one that averaging at the nodes recovers. It steers the
mesh; the error bar itself is taken from the change of the stress from mesh to mesh (`convergence`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from fem.assembly import Elements
from fem.singularity import pressed_edges
from geometry.mesh import BoolArray, FloatArray, IntArray, MeshError
from geometry.sizing import SizeField, element_sizes, size_field

_HOT = 0.8  # share of the peak from which on an element is taken to decide it
_HOT_EDGE = 0.5  # the same on a sharp re-entrant edge
_NEAR = 0.5  # of the accuracy asked for that the estimate may reach in such an element
_FAR = 2.0  # and in all others, as a share of the peak too
_STEP = 1.6  # how much smaller deciding elements become at least, so that two meshes tell something
_STEEPEST = 3.0  # and any element at most
_ORDER = 2.0  # of stress with quadratic elements
_NODES = np.array(
    [
        [0, 0, 0],
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
        [0.5, 0, 0],
        [0.5, 0.5, 0],
        [0, 0.5, 0],
        [0, 0, 0.5],
        [0.5, 0, 0.5],
        [0, 0.5, 0.5],
    ]
)
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")
_TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
_CHUNK = 4000  # elements at a time: bounds memory
LARGEST_RATIO = 0.45  # the mean stress is as exact as the von Mises stress, to a factor of 2
MEANING = (
    "Poisson's ratio: nearer to 0.5 von Mises stress and displacement hold, but the mean stress is "
    "inexact (measured 4 % at 0.48, 8 % at 0.49, 40 % at 0.499) and with it principal stresses and "
    "the mean stress of fatigue; error bars do not see it"
)


@dataclass(frozen=True, eq=False)
class StressError:
    """Stress and its estimated error in every element, under one load state, MPa.

    stress, error  (n_elements,) von Mises, largest and root mean square over the element
    """

    stress: FloatArray
    error: FloatArray


@dataclass(frozen=True, eq=False)
class Recovery:
    """Stress recovery at the surface nodes of a mesh.

    elements        the finite elements
    youngs_modulus  MPa
    poisson_ratio   1
    softened        (n_elements,) of Young's modulus, that each element has; None: all of it
    """

    elements: Elements
    youngs_modulus: float
    poisson_ratio: float
    softened: FloatArray | None = None

    @cached_property
    def points(self) -> IntArray:
        """The surface nodes, (n_points,)."""
        return self.elements.mesh.surface_nodes

    @cached_property
    def _place(self) -> IntArray:
        """Index of each node among `points`, -1 inside the part."""
        place = np.full(len(self.elements.mesh.nodes), -1)
        place[self.points] = np.arange(len(self.points))
        return place

    @cached_property
    def at_pressed_edges(self) -> BoolArray:
        """True for each element that meets an edge where a pressure ends, (n_elements,)."""
        mesh = self.elements.mesh
        return np.asarray(np.isin(mesh.elements, pressed_edges(mesh)).any(axis=1))

    @cached_property
    def _touching(self) -> IntArray:
        at_surface = (self._place[self.elements.mesh.elements] >= 0).any(axis=1)
        return np.flatnonzero(at_surface & ~self.at_pressed_edges)

    @cached_property
    def stands_for(self) -> IntArray:
        """Index of the point whose stress each point has: mostly its own, (n_points,)."""
        mesh, places = self.elements.mesh, np.arange(len(self.points))
        known = ~np.isin(self.points, mesh.elements[self.at_pressed_edges])
        if known.all():
            return places
        if not known.any():
            raise MeshError(
                "all elements at the surface meet an edge where a pressure ends: they are too large"
            )
        from scipy.spatial import cKDTree

        tree = cKDTree(mesh.nodes[self.points[known]])
        _, nearest = tree.query(mesh.nodes[self.points[~known]])
        places[~known] = places[known][nearest]
        return places

    @cached_property
    def _continuation(self) -> FloatArray:
        """(10, n_q): linear continuation from the integration points to the nodes."""
        local = self.elements.local_points
        design = np.column_stack([np.ones(len(local)), local])
        at_nodes = np.column_stack([np.ones(10), _NODES])
        return np.asarray(at_nodes @ np.linalg.inv(design))

    def quadrature_stress(self, displacement: FloatArray, part: IntArray | slice) -> FloatArray:
        """Stress (n_elements, n_q, 6, m) at the integration points of some elements, MPa.

        displacement (3 n_nodes, m), mm
        """
        nodes = self.elements.mesh.elements[part]
        columns = displacement.reshape(len(self.elements.mesh.nodes), -1)
        local = columns[nodes]  # (e, 10, 3 m)
        gradients = self.elements.gradients[part].swapaxes(2, 3)  # (e, q, 3, 10)
        slope = np.matmul(gradients.reshape(len(nodes), -1, 10), local)
        slope = slope.reshape(*gradients.shape[:3], 3, -1)  # d u_j / d x_i at [i, j]
        lame = self.youngs_modulus * self.poisson_ratio
        lame /= (1 + self.poisson_ratio) * (1 - 2 * self.poisson_ratio)
        shear = self.youngs_modulus / (2 * (1 + self.poisson_ratio))
        stress = np.empty((*slope.shape[:2], 6, slope.shape[-1]))
        volume = slope[:, :, 0, 0] + slope[:, :, 1, 1]
        volume += slope[:, :, 2, 2]
        volume *= lame / shear
        for k, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
            np.add(slope[:, :, i, j], slope[:, :, j, i] if k > 2 else volume, out=stress[:, :, k])
            if k < 3:
                stress[:, :, k] += slope[:, :, i, j]
        stress *= shear
        if self.softened is not None:
            stress *= self.softened[part][:, None, None, None]
        return stress

    def surface_stress(
        self, displacement: FloatArray, at: IntArray | slice = slice(None)
    ) -> FloatArray:
        """Stress (n_points, 6, m) at the surface nodes, or those of some indices `at`, MPa."""
        columns = displacement.reshape(len(displacement), -1)
        total = np.zeros((len(self.points), 6 * columns.shape[1]))
        for part in _chunks(self._meeting(at), _CHUNK):
            stress = self.quadrature_stress(columns, part)
            total += self._averaging(part) @ stress.reshape(-1, total.shape[1])
        total /= self._weight[:, None]
        stress = total.reshape(len(self.points), 6, -1)[self.stands_for]
        stress[np.isin(self.points, self.elements.mesh.cut_nodes), 4:] = 0.0  # the mirror's cancel
        return np.asarray(stress[at])

    def node_stress(self, displacement: FloatArray) -> FloatArray:
        """Stress (n_nodes, 6, m) at all nodes, MPa: averaged inside, at the surface as it counts.

        displacement (3 n_nodes, m), mm
        """
        mesh = self.elements.mesh
        columns = displacement.reshape(len(displacement), -1)
        total = np.zeros((len(mesh.nodes), 6 * columns.shape[1]))
        weight = np.zeros(len(mesh.nodes))
        for part in _chunks(np.arange(len(mesh.elements)), _CHUNK):
            stress = self.quadrature_stress(columns, part)
            at_nodes = np.einsum("kq,eqcm->ekcm", self._continuation, stress)
            at_nodes *= self._volumes[part][:, None, None, None]
            nodes = mesh.elements[part].ravel()
            np.add.at(total, nodes, at_nodes.reshape(len(nodes), -1))
            weight += np.bincount(nodes, np.repeat(self._volumes[part], 10), len(weight))
        stress = (total / weight[:, None]).reshape(len(mesh.nodes), 6, -1)
        stress[self.points] = self.surface_stress(columns)
        return np.asarray(stress)

    def scatter(self, displacement: FloatArray, at: IntArray | slice = slice(None)) -> FloatArray:
        """Von Mises size (n_points,) of the elements' scatter about the recovered stress, MPa.

        displacement (3 n_nodes,): the weighted root mean square over the elements at each node,
        or at the surface nodes of some indices `at`. A single element agrees with itself whatever
        its error, and with its mirror where the part is halved: a node with no other takes the
        largest scatter of that element's nodes.
        """
        stands = self.stands_for[at]
        element, _, place = self._meetings(self._touching)
        single = stands[np.bincount(place, minlength=len(self.points))[stands] == 1]
        beside = np.isin(element, element[np.isin(place, single)])
        found = self._own_scatter(displacement, np.union1d(stands, place[beside]))
        largest = np.zeros(len(self._touching))
        np.maximum.at(largest, element[beside], found[place[beside]])
        lone = beside & np.isin(place, single)
        found[place[lone]] = largest[element[lone]]
        return np.asarray(found[stands])

    def _own_scatter(self, displacement: FloatArray, stands: IntArray) -> FloatArray:
        """Scatter (n_points,) of the elements at some surface points, as `scatter`; 0 elsewhere."""
        mean, total = np.zeros((len(self.points), 6)), np.zeros(len(self.points))
        mean[stands] = self.surface_stress(displacement, stands)[:, :, 0]
        wanted = np.zeros(len(self.points), dtype=bool)
        wanted[stands] = True
        for part in _chunks(self._meeting(stands), 10 * _CHUNK):
            stress = self.quadrature_stress(displacement, part)[..., 0]
            element, node, place = self._meetings(part)
            away = np.matmul(self._continuation, stress)[element, node] - mean[place]
            squares = von_mises(away) ** 2 * self._volumes[part[element]]
            total += np.bincount(place, squares, minlength=len(total))
        return np.where(wanted, np.sqrt(total / self._weight), 0.0)

    def _meeting(self, at: IntArray | slice) -> IntArray:
        """Elements that make the stress at surface nodes, of the indices `at` among `points`."""
        if isinstance(at, slice) and at == slice(None):
            return self._touching
        nodes = self.points[self.stands_for[at]]
        wanted = np.isin(self.elements.mesh.elements[self._touching], nodes).any(axis=1)
        return np.asarray(self._touching[wanted])

    @cached_property
    def _volumes(self) -> FloatArray:
        return np.asarray(self.elements.weights.sum(axis=1))

    @cached_property
    def _weight(self) -> FloatArray:
        """Volume (n_points,) of the elements averaged at each surface node, mm3; 1 for none."""
        element, _, place = self._meetings(self._touching)
        volumes = self._volumes[self._touching[element]]
        weight = np.bincount(place, volumes, minlength=len(self.points))
        return np.where(weight > 0, weight, 1.0)

    def _meetings(self, part: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Where some elements touch the surface: index in `part`, local node, surface point."""
        place = self._place[self.elements.mesh.elements[part]]
        element, node = np.nonzero(place >= 0)
        return element, node, place[element, node]

    def _averaging(self, part: IntArray) -> "scipy.sparse.csr_array":
        """Matrix (n_points, n_elements n_q): continuation times volume, summed at surface nodes."""
        element, node, place = self._meetings(part)
        n_q = self._continuation.shape[1]
        shares = self._continuation[node] * self._volumes[part[element], None]
        columns = n_q * element[:, None] + np.arange(n_q)
        return scipy.sparse.coo_array(
            (shares.ravel(), (np.repeat(place, n_q), columns.ravel())),
            shape=(len(self.points), n_q * len(part)),
        ).tocsr()


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises stress of components (..., 6) ordered xx, yy, zz, xy, yz, zx."""
    xx, yy, zz, xy, yz, zx = np.moveaxis(stress, -1, 0)
    normal = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
    return np.asarray(np.sqrt(normal + 3 * (xy**2 + yz**2 + zx**2)))


def tensor(stress: FloatArray) -> FloatArray:
    """Tensors (..., 3, 3) of components (..., 6)."""
    return np.asarray(stress[..., _TENSOR])


def _chunks(indices: IntArray, size: int) -> list[IntArray]:
    return [indices[start : start + size] for start in range(0, len(indices), size)]


# Accuracy of quadratic tetrahedra near incompressibility: only the mean stress suffers.
#
# The mean stress is the bulk modulus E / (3 (1 - 2 nu)) times a change of volume that the
# elements have to make small: its error grows like 1 / (1 - 2 nu), and it differs from element to
# element. The deviatoric stress is not touched (Hughes, The Finite Element Method, 2000, section
# 4.4). Measured on a pressed thick cylinder in plane strain (docs/extremes.md): on a mesh with a
# von Mises stress right to 1 %, direct stresses are wrong by 1 % at 0.3, 2 % at 0.45, 4 % at
# 0.48, 8 % at 0.49 and 40 % at 0.499; displacements stay within 0.2 % and von Mises stress within
# 2 %. On a regular mesh nothing of it is seen up to 0.49.


def stress_error(recovery: Recovery, displacement: FloatArray) -> StressError:
    """Estimate the error of the stress in every element; displacement (3 n_nodes,) mm."""
    elements = recovery.elements
    raw = recovery.quadrature_stress(displacement[:, None], slice(None))[..., 0]  # (e, q, 6)
    smooth = _smoothed(elements, raw)
    volumes = elements.weights.sum(axis=1)
    away = von_mises(smooth - raw) ** 2
    away[recovery.at_pressed_edges] = 0.0  # smaller ones would be as wrong, and none is judged
    error = np.sqrt((away * elements.weights).sum(axis=1) / volumes)
    return StressError(np.asarray(von_mises(raw).max(axis=1)), np.asarray(error))


def energy_error(recovery: Recovery, displacement: FloatArray) -> float:
    """Share of a field's strain energy that the estimated error of its stress has.

    displacement (3 n_nodes,). After Zienkiewicz and Zhu, as `stress_error`: the smoother stress
    less the elements' own, by the compliance. Of quadratic elements it is some 0.3 to 0.6 of the
    error's energy (docs/theory/buckling.md).
    """
    raw = recovery.quadrature_stress(displacement[:, None], slice(None))[..., 0]
    away = _smoothed(recovery.elements, raw) - raw
    return _energy(recovery, away) / _energy(recovery, raw)


def _energy(recovery: Recovery, stress: FloatArray) -> float:
    """Twice the strain energy of a stress (e, q, 6), times Young's modulus."""
    ratio, weights = recovery.poisson_ratio, recovery.elements.weights
    if recovery.softened is not None:
        weights = weights / recovery.softened[:, None]
    squares = (stress[..., :3] ** 2).sum(axis=-1) + 2 * (stress[..., 3:] ** 2).sum(axis=-1)
    mean = stress[..., :3].sum(axis=-1) ** 2
    return float((((1 + ratio) * squares - ratio * mean) * weights).sum())


def _smoothed(elements: Elements, raw: FloatArray) -> FloatArray:
    """Stress (e, q, 6) of the mean at the nodes, weighed with volumes, of stress (e, q, 6)."""
    local = elements.local_points
    design = np.column_stack([np.ones(len(local)), local])
    continuation = np.column_stack([np.ones(len(_NODES)), _NODES]) @ np.linalg.inv(design)
    volumes = elements.weights.sum(axis=1)
    nodes = elements.mesh.elements
    total, weight = np.zeros((len(elements.mesh.nodes), 6)), np.zeros(len(elements.mesh.nodes))
    at_nodes = np.matmul(continuation, raw) * volumes[:, None, None]
    np.add.at(total, nodes, at_nodes)
    np.add.at(weight, nodes, volumes[:, None])
    total[elements.mesh.cut_nodes, 4:] = 0.0  # as with the mirrored elements of the other half
    return np.asarray(np.matmul(elements.values, (total / weight[:, None])[nodes]))


def refined_sizes(
    recovery: Recovery,
    states: Sequence[StressError],
    accuracy: float,
    most_elements: float,
    sharp: IntArray | None = None,
    missed: FloatArray | None = None,
) -> tuple[SizeField, float]:
    """Return the sizes that bring every state's peak to an accuracy, and how far they go.

    accuracy       1, wanted error of the peak over the peak
    most_elements  what the mesh may have at most, as estimated: sizes are raised to fit
    sharp          nodes on sharp re-entrant edges: their stress may grow past today's peak
    missed         (n_elements,) share by which the stress of each is too low in a notch

    The elements that decide a peak become smaller in any case. The second value is the least by
    which those of any state do: below _STEP the limit on the elements was in the way.
    """
    mesh = recovery.elements.mesh
    now = element_sizes(mesh)
    factor, deciding = np.ones(len(now)), np.zeros(len(now), dtype=bool)
    too_low = np.zeros(len(now)) if missed is None else missed
    at_edge = np.isin(mesh.elements, [] if sharp is None else sharp).any(axis=1)
    for state in states:
        peak = float(state.stress.max())
        if not peak > 0:
            continue
        hot = state.stress * (1 + too_low) >= np.where(at_edge, _HOT_EDGE, _HOT) * peak
        allowed = np.where(hot, _NEAR, _FAR) * accuracy * peak
        with np.errstate(divide="ignore"):
            wanted = (allowed / state.error) ** (1 / _ORDER)
            resolved = np.sqrt(_NEAR * accuracy / too_low)
        wanted = np.where(hot, np.minimum(wanted, resolved), wanted)
        wanted = np.clip(wanted, 1 / _STEEPEST, np.where(hot, 1 / _STEP, 1.0))
        factor = np.minimum(factor, wanted)
        deciding |= hot
    relax = 1.0
    while (np.minimum(factor * relax, 1.0) ** -3.0).sum() > most_elements and relax < 1e3:
        relax *= 1.05
    factor = np.minimum(factor * relax, 1.0)
    refinement = float(1 / factor[deciding].max()) if deciding.any() else 1.0
    return size_field(mesh, now * factor), refinement
