"""Sparse matrices of elasticity, assembled by node pairs.

All matrices of a part share one pattern: the upper triangle of node pairs that some element joins,
each with a 3 x 3 block. The pattern is sorted once; a matrix is then a sum over equal pairs. Nodes
of an element are taken in the order of their numbers, so every block belongs to the upper triangle
as it is.

Elements are second-order tetrahedra: scikit-fem's shape functions and quadrature on a mesh's
arrays.

Bodies of a stack may be tied to each other. A tie makes the displacements of two nodes equal along
one axis: u = T q, with the independent unknowns q and a matrix T of zeros and ones. Stiffness and
loads become T' K T and T' f. Ties along y alone let the leaves of a spring slide on each other;
along x and z something must hold them together in at least one place (a centre bolt), or the stack
is a mechanism, which is refused.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from geometry.mesh import FloatArray, IntArray, Mesh, MeshError

_UPPER = np.triu_indices(10)
_CHUNK = 500  # elements at a time: their dense matrices stay in the cache


@dataclass(frozen=True, eq=False)
class FacetQuadrature:
    """Quadrature over one named surface of six-node facets.

    shape    (6, n_q)           shape functions of a facet's nodes
    nodes    (n_facets, 6)      node indices
    points   (n_facets, n_q, 3) mm
    weights  (n_facets, n_q)    mm2
    """

    shape: FloatArray
    nodes: IntArray
    points: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class Elements:
    """A mesh with its shape-function gradients at four points per element.

    Four points integrate the stiffness of a straight-sided quadratic tetrahedron exactly; it is
    the rule of CalculiX's C3D10 too.
    """

    mesh: Mesh

    @cached_property
    def _rule(self) -> tuple[FloatArray, FloatArray]:
        import skfem

        points, weights = skfem.quadrature.get_quadrature(skfem.refdom.RefTet, 2)
        if points.shape != (3, 4):
            raise AssertionError("the four-point rule is expected")
        return points, weights

    @cached_property
    def _shape(self) -> tuple[FloatArray, FloatArray]:
        """Shape functions (n_q, 10) and their slopes (n_q, 10, 3) in the reference element."""
        import skfem

        element = skfem.ElementTetP2()  # numbers its nodes as the mesh does
        both = [element.lbasis(self._rule[0], node) for node in range(10)]
        values = np.stack([value for value, _ in both], axis=1)
        return values, np.ascontiguousarray(np.stack([slope.T for _, slope in both], axis=1))

    @cached_property
    def _mapping(self) -> tuple[FloatArray, FloatArray]:
        """Inverse Jacobian matrices (n_elements, n_q, 3, 3), dr_k/dx_i at [k, i], and det J."""
        slopes = self._shape[1]
        n_elements, n_q = len(self.mesh.elements), len(slopes)
        sides = slopes.transpose(1, 0, 2).reshape(10, -1)  # (10, n_q 3)
        corners = self.mesh.nodes[self.mesh.elements].transpose(0, 2, 1)
        jacobian = corners.reshape(-1, 10) @ sides
        # [i][k] is dx_i/dr_k, (n_elements, n_q)
        j = jacobian.reshape(n_elements, 3, n_q, 3).transpose(1, 3, 0, 2)
        inverse = np.empty((n_elements, n_q, 3, 3))
        for k in range(3):
            for i in range(3):
                (p, q), (r, s) = ((i + 1) % 3, (i + 2) % 3), ((k + 1) % 3, (k + 2) % 3)
                inverse[:, :, k, i] = j[p, r] * j[q, s] - j[p, s] * j[q, r]
        determinant = np.einsum("keq,eqk->eq", j[0], inverse[:, :, :, 0])
        inverse /= determinant[:, :, None, None]
        return inverse, np.ascontiguousarray(determinant)

    @cached_property
    def gradients(self) -> FloatArray:
        """(n_elements, n_q, 10, 3), 1/mm."""
        return np.asarray(np.matmul(self._shape[1], self._mapping[0]))

    @property
    def values(self) -> FloatArray:
        """Shape functions at the quadrature points, (n_q, 10)."""
        return self._shape[0]

    @cached_property
    def weights(self) -> FloatArray:
        """(n_elements, n_q), mm3."""
        return np.asarray(np.abs(self._mapping[1]) * self._rule[1])

    @cached_property
    def points(self) -> FloatArray:
        """Quadrature points, (n_elements, n_q, 3), mm."""
        nodes = self.mesh.nodes[self.mesh.elements]
        return np.asarray(np.einsum("qa,eax->eqx", self.values, nodes))

    @property
    def local_points(self) -> FloatArray:
        """Quadrature points in the reference tetrahedron, (n_q, 3)."""
        return np.asarray(self._rule[0].T)

    @cached_property
    def _surfaces(self) -> dict[tuple[str, int], FacetQuadrature]:
        return {}

    def surface(self, name: str, *, degree: int = 8) -> FacetQuadrature:
        """Quadrature over a named surface of the mesh."""
        if (name, degree) not in self._surfaces:
            self._surfaces[name, degree] = self._surface(name, degree)
        return self._surfaces[name, degree]

    def _surface(self, name: str, degree: int) -> FacetQuadrature:
        import skfem

        rule, weights = skfem.quadrature.get_quadrature(skfem.refdom.RefTri, degree)
        facets = self.mesh.surfaces[name]
        corners = self.mesh.nodes[facets]  # (f, 6, 3)
        r, s = rule
        t = 1 - r - s
        shape = np.stack(
            [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * r * t, 4 * r * s, 4 * s * t]
        )
        zero = np.zeros_like(r)
        by_r = np.stack([1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s])
        by_s = np.stack([1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
        tangents = (np.einsum("aq,fax->fqx", slope, corners) for slope in (by_r, by_s))
        areas = np.linalg.norm(np.cross(*tangents), axis=-1)
        return FacetQuadrature(
            shape=shape,
            nodes=facets,
            points=np.einsum("aq,fax->fqx", shape, corners),
            weights=areas * weights,
        )


def _upper_places() -> tuple[IntArray, IntArray]:
    """Where entry (i, j) and entry (j, i) of every block of a <= b stand in a 30 x 30 matrix."""
    a, b = (3 * index[:, None, None] for index in _UPPER)
    i, j = np.arange(3)[:, None], np.arange(3)
    straight, crossed = 30 * (a + i) + (b + j), 30 * (a + j) + (b + i)
    return straight.ravel().astype(np.int64), crossed.ravel().astype(np.int64)


_STRAIGHT, _CROSSED = _upper_places()


@dataclass(frozen=True, eq=False)
class Pattern:
    """Where the blocks of an elasticity matrix stand.

    Unknown 3 n + i is component i of node n.
    """

    elements: Elements

    @cached_property
    def order(self) -> IntArray:
        """The nodes of each element by ascending number, (n_elements, 10) local numbers."""
        return np.argsort(self.elements.mesh.elements, axis=1).astype(np.int64)

    @cached_property
    def _pairs(self) -> tuple[IntArray, "scipy.sparse.csr_array"]:
        """Node pairs (low n_nodes + high, ascending), and the matrix that sums blocks to them."""
        n = len(self.elements.mesh.nodes)
        nodes = np.take_along_axis(self.elements.mesh.elements, self.order, axis=1)
        key = (nodes[:, _UPPER[0]] * n + nodes[:, _UPPER[1]]).ravel()
        by_pair = np.argsort(key, kind="stable")
        sorted_key = key[by_pair]
        starts = np.flatnonzero(np.r_[True, sorted_key[1:] > sorted_key[:-1]])
        summing = scipy.sparse.csr_array(
            (np.ones(len(key)), by_pair.astype(np.int32), np.r_[starts, len(key)].astype(np.int32)),
            shape=(len(starts), len(key)),
        )
        return sorted_key[starts], summing

    def upper(self, blocks: FloatArray) -> "scipy.sparse.csr_array":
        """Sum element blocks (n_elements, 55, 3, 3) of node pairs to the upper triangle.

        The pairs i <= j are those of the element's nodes in `order`.
        """
        pairs, summing = self._pairs
        n = len(self.elements.mesh.nodes)
        summed = summing @ blocks.reshape(-1, 9)
        rows, columns = pairs // n, pairs % n
        pointers = np.searchsorted(rows, np.arange(n + 1))
        return _from_blocks(summed, rows, columns, pointers)

    def upper_scalar(self, values: FloatArray) -> "scipy.sparse.csr_array":
        """Sum multiples of the 3 x 3 identity, values (n_elements, 55), in the same way."""
        return self.upper(values[:, :, None, None] * np.eye(3))


def stiffness(
    pattern: Pattern,
    youngs_modulus: float,
    poisson_ratio: float,
    softened: FloatArray | None = None,
) -> "scipy.sparse.csr_array":
    """Upper triangle of the stiffness matrix of isotropic elasticity, N/mm.

    softened  (n_elements,) of Young's modulus, that each element has; None: all of it

    With G_ai the gradient of shape function a, the block of nodes a and b is
    sum_q w (lambda G_ai G_bj + mu G_aj G_bi + mu delta_ij G_a . G_b).
    """
    lame = youngs_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    shear = youngs_modulus / (2 * (1 + poisson_ratio))
    count = len(pattern.elements.mesh.elements)
    weights = pattern.elements.weights
    if softened is not None:
        weights = weights * softened[:, None]
    blocks = np.empty((count, 55, 9))
    for start in range(0, count, _CHUNK):
        part = slice(start, min(start + _CHUNK, count))
        flat = _ordered_gradients(pattern, part).reshape(part.stop - start, -1, 30)
        weighted = flat * weights[part, :, None]
        products = np.matmul(weighted.swapaxes(1, 2), flat).reshape(-1, 900)
        straight = products[:, _STRAIGHT]
        block = blocks[part].reshape(-1, 495)
        np.multiply(products[:, _CROSSED], shear, out=block)
        trace = straight.reshape(-1, 55, 9)[:, :, ::4].sum(axis=2)
        straight *= lame
        block += straight
        blocks[part, :, ::4] += shear * trace[:, :, None]
    return pattern.upper(blocks)


def geometric_stiffness(pattern: Pattern, stress: FloatArray) -> "scipy.sparse.csr_array":
    """Upper triangle of the geometric stiffness of a stress state, N/mm.

    stress (n_elements, n_q, 3, 3), MPa. The block of nodes a and b is
    delta_ij sum_q w G_a . sigma G_b (Bathe, Finite Element Procedures, 2nd ed., section 6.8.1).
    """
    elements = pattern.elements
    count = len(elements.mesh.elements)
    values = np.empty((count, 55))
    for start in range(0, count, _CHUNK):
        part = slice(start, min(start + _CHUNK, count))
        gradients = _ordered_gradients(pattern, part)
        pushed = np.matmul(gradients, stress[part] * elements.weights[part][:, :, None, None])
        products = np.matmul(pushed, gradients.swapaxes(2, 3)).sum(axis=1)
        values[part] = products[:, _UPPER[0], _UPPER[1]]
    return pattern.upper_scalar(values)


def full(upper: "scipy.sparse.csr_array") -> "scipy.sparse.csr_array":
    """Return the symmetric matrix whose upper triangle is given."""
    return (upper + scipy.sparse.triu(upper, k=1).T).tocsr()


def _ordered_gradients(pattern: Pattern, part: slice) -> FloatArray:
    """Gradients (n, n_q, 10, 3) of some elements' shape functions by ascending node number."""
    order = pattern.order[part]
    each = np.arange(len(order))[:, None, None]
    at = np.arange(pattern.elements.gradients.shape[1])[:, None]
    return np.asarray(pattern.elements.gradients[part][each, at, order[:, None, :]])


def _from_blocks(
    blocks: FloatArray, rows: IntArray, columns: IntArray, pointers: IntArray
) -> "scipy.sparse.csr_array":
    """Upper triangle of a matrix of 3 x 3 blocks, each row of blocks beginning on the diagonal.

    Three entries are left out per diagonal block, whatever their value, so the pattern depends on
    the mesh alone. blocks (n, 9) and their columns (n,) of blocks, by rows.
    """
    n = len(pointers) - 1
    inside = 3 * (
        np.arange(len(blocks)) - pointers[:-1][rows]
    )  # of the row, where the block begins
    wide = 3 * np.diff(pointers)
    # a row of blocks is three rows of `wide`, `wide` - 1 and `wide` - 2 entries
    starts = 9 * pointers[:-1, None] + wide[:, None] * np.arange(3) - 3 * np.arange(n)[:, None]
    starts[:, 2] -= 1
    size = 9 * len(blocks) - 3 * n
    data, indices = np.empty(size), np.empty(size, dtype=np.int32)
    on_diagonal = inside == 0
    for i in range(3):
        begin = starts[rows, i] + inside - i
        for j in range(3):
            kept = slice(None) if j >= i else ~on_diagonal
            at = (begin + j)[kept]
            data[at] = blocks[kept, 3 * i + j]
            indices[at] = 3 * columns[kept] + j
    ends = np.append(starts.ravel(), size).astype(np.int32)
    return scipy.sparse.csr_array((data, indices, ends), shape=(3 * n, 3 * n))


@dataclass(frozen=True, eq=False)
class Ties:
    """The independent unknowns of a tied mesh.

    number  (3 n_nodes,)  the independent unknown that each unknown is
    first   (n,)          the first unknown of each independent one
    """

    number: IntArray
    first: IntArray

    def expand(self, values: FloatArray) -> FloatArray:
        """Values (3 n_nodes, ...) of all unknowns from those of the independent ones (n, ...)."""
        return np.asarray(values[self.number])

    def collect(self, loads: FloatArray) -> FloatArray:
        """Loads (n, m) on the independent unknowns from those on all (3 n_nodes, m)."""
        return np.asarray(self._matrix.T @ loads)

    def collect_upper(self, upper: "scipy.sparse.csr_array") -> "scipy.sparse.csr_array":
        """Upper triangle of T' K T from the upper triangle of K."""
        entries = upper.tocoo()
        rows, columns = self.number[entries.row], self.number[entries.col]
        # an entry above the diagonal stands for two, which may fall on the diagonal together
        met = (rows == columns) & (entries.row != entries.col)
        values = np.where(met, 2 * entries.data, entries.data)
        low, high = np.minimum(rows, columns), np.maximum(rows, columns)
        n = len(self.first)
        return scipy.sparse.coo_array((values, (low, high)), shape=(n, n)).tocsr()

    @cached_property
    def _matrix(self) -> "scipy.sparse.csr_array":
        count = len(self.number)
        return scipy.sparse.csr_array(
            (np.ones(count), self.number, np.arange(count + 1)), shape=(count, len(self.first))
        )


def ties_of(mesh: Mesh) -> Ties | None:
    """Return the independent unknowns of a mesh, or None if nothing is tied.

    Raises MeshError if tied nodes are apart or the ties let the bodies move against each other.
    """
    if not any(len(tie.pairs) for tie in mesh.ties):
        return None
    _check_places(mesh)
    _check_rigidity(mesh)
    count = 3 * len(mesh.nodes)
    joined = np.concatenate([3 * tie.pairs + tie.axis for tie in mesh.ties])
    graph = scipy.sparse.coo_array((np.ones(len(joined)), tuple(joined.T)), shape=(count, count))
    _, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    _, first, number = np.unique(label, return_index=True, return_inverse=True)
    order = np.argsort(first)  # in the order of the nodes, which ordering methods like
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return Ties(place[number].astype(np.int64), first[order].astype(np.int64))


def bodies_of(mesh: Mesh) -> IntArray:
    """Number (n_nodes,) of the body that each node belongs to, counted from 0."""
    n = len(mesh.nodes)
    first = np.repeat(mesh.elements[:, 0], 9)
    others = mesh.elements[:, 1:].ravel()
    graph = scipy.sparse.coo_array((np.ones(len(first)), (first, others)), shape=(n, n))
    return np.asarray(
        scipy.sparse.csgraph.connected_components(graph, directed=False)[1], dtype=np.int64
    )


def _check_places(mesh: Mesh) -> None:
    size = float(np.ptp(mesh.nodes, axis=0).max())
    for tie in mesh.ties:
        apart = np.linalg.norm(mesh.nodes[tie.pairs[:, 0]] - mesh.nodes[tie.pairs[:, 1]], axis=1)
        if apart.max(initial=0.0) > 1e-7 * size:
            raise MeshError(
                f"nodes tied along {'xyz'[tie.axis]} must be at the same place, they are up to "
                f"{apart.max():.3g} mm apart"
            )


def _check_rigidity(mesh: Mesh) -> None:
    """MeshError unless the only rigid motions that the ties allow are the six of the whole."""
    body = bodies_of(mesh)
    count = int(body.max()) + 1
    middle = mesh.nodes.mean(axis=0)
    size = np.abs(mesh.nodes - middle).max()
    squares = np.zeros((6 * count, 6 * count))
    for tie in mesh.ties:
        rows = np.zeros((len(tie.pairs), count, 6))
        for side, sign in ((0, 1.0), (1, -1.0)):
            nodes = tie.pairs[:, side]
            arm = (mesh.nodes[nodes] - middle) / size
            turns = np.cross(np.eye(3), arm[:, None])[..., tie.axis]  # of unit turns about x, y, z
            shifts = np.broadcast_to(np.eye(3)[tie.axis], turns.shape)
            motion = np.concatenate([shifts, turns], axis=1)
            rows[np.arange(len(nodes)), body[nodes]] += sign * motion
        flat = rows.reshape(len(rows), -1)
        squares += flat.T @ flat / max(len(flat), 1)
    values = np.linalg.eigvalsh(squares)
    loose = int(np.count_nonzero(values < 1e-9 * max(values[-1], 1e-300))) - 6
    if loose > 0:
        raise MeshError(
            f"the {count} bodies of the stack can still move against each other in {loose} "
            "independent ways without deforming: they need ties along x and z in one place at "
            "least, such as a bolt through all of them"
        )
