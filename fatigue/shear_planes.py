"""Findley's shear-plane criterion: the critical plane of one stress path, with a proven bound.

    parameter    F(n) = tau_a + k sigma_n   of the plane with normal n; the largest over all planes
    tau_a        radius of the smallest circle around the path of the resolved shear stress
    sigma_n      largest normal stress of the cycle
    utilisation  F / f, linear in the load

Findley, J. Eng. Ind. 81 (1959) 301; with circle and calibration as in Papadopoulos et al., Int. J.
Fatigue 19 (1997) 219. k and f follow from the limits in reversed bending and in reversed torsion:

    k / sqrt(1 + k^2) = 2 t/b - 1,    f = t sqrt(1 + k^2) = b/2 (k + sqrt(1 + k^2))

so both reversed tests give 1. **Compression earns no credit**: the mean of the normal stress on a
plane counts as not less than 0, sigma_n = max(largest, half the range).

The search (proofs in docs/theory/multiaxial.md): along any great circle F is an upper envelope of
functions whose second derivative is at least -M, M = 4/sqrt(3) (R + k Q), R the radius of a ball
around the path and Q the largest stress, both von Mises. So on a triangle of planes with longest
edge e, F is at most its largest corner + M e^2/4. Triangles that cannot reach the best plane found
are dropped, the others divided; what is left encloses the critical plane, and no local maximum is
mistaken for the global one.

The shear amplitude on a plane is the radius of the smallest circle around the path of the resolved
shear stress (Bernasconi and Papadopoulos, Comput. Mater. Sci. 34 (2005) 355), not half its longest
chord: around an equilateral triangle the two differ by 2/sqrt(3) (Jung).

Method, exact up to round-off: 2 or 3 positions carry the circle. Whatever position lies farthest
outside the circle of the carriers joins them; the circle of the enlarged set, found by trying all
of its subsets, has a larger radius, so no set comes twice and the search ends (an LP-type problem:
Sharir and Welzl 1992). A candidate's worth is the distance of the farthest member of the set from
its centre; the smallest circle is the least of these, so degenerate candidates (equal or collinear
positions) lose without a test for them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from math import isfinite, sqrt

import numpy as np

from fatigue.stress_path import FloatArray, IntArray, deviatoric_basis

DUCTILE = 1.0 / sqrt(3.0)  # torsion limit over bending limit, distortion energy

_START = 2  # divisions of the first grid: 93 normals, edges of 18 to 18.7 degrees
_CERTIFIED = 1e-4  # of the scale of F: how far the best plane may lie below the bound
_MOST_CELLS = 4096  # circles of equally bad planes keep many; then the bound stays as it is
_BEAM = 16  # triangles kept when the certified search is over and the best plane is polished
_FINEST = 1e-6  # rad
_EYE = np.eye(3)
# A position farther out than this fraction of the radius joins the carriers; round-off is smaller.
_OUTSIDE = 1e-13
_MOST_STEPS = 1000  # reached by no path seen: 3 to 8 steps are usual


@dataclass(frozen=True)
class FindleyCriterion:
    """k and the limit of Findley's parameter as a fraction of the limit in reversed bending.

    k               weight of the normal stress
    limit_ratio     f / bending limit
    """

    k: float
    limit_ratio: float


def findley_criterion(torsion_ratio: float = DUCTILE) -> FindleyCriterion:
    """Return k and f/b from the reversed limits' ratio, torsion over bending, 0.5 up to below 1.

    >>> round(findley_criterion(196.2 / 313.9).k, 10)
    0.2582866314
    """
    if not (isfinite(torsion_ratio) and 0.5 <= torsion_ratio < 1.0):
        raise ValueError(
            "Findley's criterion needs a torsion limit of 0.5 to below 1 times the bending limit, "
            f"got {torsion_ratio:g}"
        )
    sine = 2.0 * torsion_ratio - 1.0
    k = sine / sqrt(1.0 - sine**2)
    return FindleyCriterion(k, torsion_ratio * sqrt(1.0 + k**2))


@dataclass(frozen=True, eq=False)
class CriticalPlane:
    """The worst plane of one stress path.

    value          MPa, tau_a + k sigma_n
    bound          MPa, proven: no plane of any direction has more
    normal         (3,)  unit vector
    normal_stress  MPa, sigma_n as the criterion counts it
    shear          (2, n_positions)  MPa, along two axes of the plane
    stress         (6, n_positions)  MPa, the path
    n_planes       planes evaluated

    Of most planes nothing but the value is asked, so the rest is found when it is.
    """

    value: float
    bound: float
    normal: FloatArray
    normal_stress: float
    shear: FloatArray
    stress: FloatArray
    n_planes: int

    @cached_property
    def _circle(self) -> tuple[float, IntArray]:
        """Radius of the smallest circle around the shear, and the positions that it rests on."""
        _, radius, carriers = smallest_circles(self.shear[None])
        return float(radius[0]), carriers[0]

    @property
    def shear_amplitude(self) -> float:
        """tau_a, MPa."""
        return self._circle[0]

    @property
    def pair(self) -> tuple[int, int]:
        """Two positions that the circle rests on, the farthest apart of these."""
        three = self._circle[1]
        corners = self.shear[:, three]
        apart = ((corners[:, :, None] - corners[:, None, :]) ** 2).sum(axis=0)
        first, second = np.unravel_index(apart.argmax(), apart.shape)
        ends = sorted((int(three[first]), int(three[second])))
        return ends[0], ends[1]


def critical_plane(stress: FloatArray, k: float, *, floor: float = -np.inf) -> CriticalPlane:
    """Return Findley's worst plane of a path, stress (6, n_positions).

    `floor`, MPa: planes below it are of no interest. Where the bound shows that none reaches it the
    search ends early, with a bound not above the floor and any plane as its value.
    """
    stress = np.asarray(stress, dtype=np.float64)
    if stress.ndim != 2 or stress.shape[0] != 6 or stress.shape[1] == 0:
        raise ValueError(f"a stress path must be (6, n_positions), got {stress.shape}")
    if not np.isfinite(stress).all():
        bad = np.flatnonzero(~np.isfinite(stress).all(axis=0))
        raise ValueError(f"the stress path is not finite at position {bad[0]}")
    if not (isfinite(k) and k >= 0.0):
        raise ValueError(f"the weight of the normal stress must not be below 0, got {k:g}")
    return _Search(stress, k, floor).result()


class _Search:
    """Normals evaluated so far, upper bounds of F at each, and the best plane among them."""

    def __init__(self, stress: FloatArray, k: float, floor: float) -> None:
        self.k, self.floor = k, floor
        path = deviatoric_basis(stress)
        away = ((path - path.mean(axis=1)[:, None]) ** 2).sum(axis=0)
        first = int(away.argmax())
        other = int(((path - path[:, [first]]) ** 2).sum(axis=0).argmax())
        middle = (path[:, first] + path[:, other]) / 2.0
        radius = float(np.sqrt(((path - middle[:, None]) ** 2).sum(axis=0).max()))
        largest = float(np.sqrt((path**2).sum(axis=0).max()))
        self.stress = stress
        self.swing = stress - (stress[:, first] + stress[:, other])[:, None] / 2.0
        self.scale = (radius + k * max(largest, radius)) / sqrt(3.0)  # M/4
        self.normals = np.empty((0, 3))
        self.rows = np.empty((0, 3, 6))
        self.upper = np.empty(0)
        self.exact = np.empty(0, dtype=bool)
        self.best, self.best_at = -np.inf, 0

    def result(self) -> CriticalPlane:
        normals, cells, rows, edges = _start()
        self._add(normals, rows)
        ceiling = -np.inf
        while True:
            self._sharpen(np.array([self.upper.argmax()]))
            slack = self.scale * edges**2  # M e^2/4
            tops = self.upper[cells].max(axis=1) + slack
            hopeful = tops > max(self.floor, self.best)
            corners = np.unique(cells[hopeful])
            doubtful = ~self.exact[corners] & (self.upper[corners] > self.best)
            if doubtful.any():  # their upper bounds may be all that keeps these triangles
                self._sharpen(corners[doubtful])
                tops = self.upper[cells].max(axis=1) + slack
                hopeful = tops > max(self.floor, self.best)
            ceiling = max(ceiling, float(tops[~hopeful].max(initial=-np.inf)))
            top = float(tops[hopeful].max(initial=-np.inf))
            cells = cells[hopeful]
            settled = top - self.best <= _CERTIFIED * self.scale
            if not len(cells) or settled or len(cells) > _MOST_CELLS:
                break
            cells = self._divide(cells)
            edges = longest_edges(self.normals, cells)
        bound = max(self.best, top, ceiling)
        if self.best > self.floor and len(cells):
            self._polish(cells)
            bound = max(bound, self.best)
        return self._plane(bound)

    def _polish(self, cells: IntArray) -> None:
        """Divide the most promising triangles down to _FINEST."""
        finest = np.inf
        while finest > _FINEST:
            cells = self._divide(cells[np.argsort(-self.upper[cells].max(axis=1))[:_BEAM]])
            new = np.unique(cells)
            self._sharpen(new[~self.exact[new] & (self.upper[new] > self.best)])
            finest = float(longest_edges(self.normals, cells).max())

    def _divide(self, cells: IntArray) -> IntArray:
        edges, four = divided(len(self.normals), cells)
        normals = middles(self.normals, edges)
        self._add(normals, plane_rows(normals))
        return four

    def _add(self, normals: FloatArray, rows: FloatArray) -> None:
        """Evaluate an upper bound of F: the circle around the middle of a long chord."""
        shear, normal = self._resolved(rows)
        shear *= shear
        radii = np.sqrt((shear[:, 0] + shear[:, 1]).max(axis=1))
        self.normals = np.concatenate([self.normals, normals])
        self.rows = np.concatenate([self.rows, rows])
        self.upper = np.concatenate([self.upper, radii + self.k * normal])
        self.exact = np.concatenate([self.exact, np.zeros(len(normals), dtype=bool)])

    def _sharpen(self, which: IntArray) -> None:
        """Replace upper bounds by F itself."""
        which = which[~self.exact[which]]
        if not len(which):
            return
        shear, normal = self._resolved(self.rows[which])
        values = smallest_circles(shear)[1] + self.k * normal
        self.upper[which], self.exact[which] = values, True
        most = int(values.argmax())
        if values[most] > self.best:
            self.best, self.best_at = float(values[most]), int(which[most])

    def _resolved(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the resolved shear path (n, 2, n_positions) and sigma_n (n,) of each plane."""
        shear = (rows[:, :2].reshape(-1, 6) @ self.swing).reshape(len(rows), 2, -1)
        normal = rows[:, 2] @ self.stress
        largest = normal.max(axis=1)
        return shear, np.maximum(largest, (largest - normal.min(axis=1)) / 2.0)

    def _plane(self, bound: float) -> CriticalPlane:
        normal = self.normals[self.best_at]
        shear, counted = self._resolved(self.rows[self.best_at : self.best_at + 1])
        return CriticalPlane(
            value=self.best,
            bound=bound,
            normal=normal,
            normal_stress=float(counted[0]),
            shear=shear[0],
            stress=self.stress,
            n_planes=len(self.normals),
        )


def resolved_shear(normals: FloatArray, stress: FloatArray) -> FloatArray:
    """Return the shear stress (n, 2, n_positions) in planes with normals (n, 3), in some axes."""
    rows = plane_rows(normals)[:, :2]
    return np.asarray((rows.reshape(-1, 6) @ stress).reshape(len(normals), 2, -1))


@cache
def _start() -> tuple[FloatArray, IntArray, FloatArray, FloatArray]:
    """Normals, triangles, rows and edges of the grid that every search begins with."""
    normals, cells = half_sphere(_START)
    return normals, cells, plane_rows(normals), longest_edges(normals, cells)


def plane_rows(normals: FloatArray) -> FloatArray:
    """Return rows (n, 3, 6) that take a stress to its shear along two axes of a plane, normal."""
    axes = np.array([*_plane_axes(normals), normals])
    return np.ascontiguousarray(_component(normals, axes).swapaxes(0, 1))


def _plane_axes(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors (n, 3) in each plane, at right angles to each other."""
    along = _crossed(normals, _EYE[np.abs(normals).argmin(axis=1)])
    along /= np.sqrt(_squared(along))[:, None]
    return along, _crossed(normals, along)


def _squared(vectors: FloatArray) -> FloatArray:
    """Return the squared lengths (...) of vectors (..., 3); NumPy's sum over three is slow."""
    squares = vectors * vectors
    return np.asarray(squares[..., 0] + squares[..., 1] + squares[..., 2])


def _crossed(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross products (n, 3); a tenth of the time of NumPy's for a few of them."""
    (x, y, z), (u, v, w) = a.T, b.T
    result = np.empty_like(a)
    result[:, 0], result[:, 1], result[:, 2] = y * w - z * v, z * u - x * w, x * v - y * u
    return result


def _component(n: FloatArray, m: FloatArray) -> FloatArray:
    """Return rows (..., 6) that give n . stress m of the six components; n, m (..., 3)."""
    (a, b, c), (x, y, z) = ([v[..., k] for k in range(3)] for v in (n, m))
    rows = (a * x, b * y, c * z, a * y + b * x, b * z + c * y, c * x + a * z)
    found = np.empty((*rows[0].shape, 6))
    for k, row in enumerate(rows):
        found[..., k] = row
    return found


# Triangles over all directions of planes, and their division in four.
#
# A plane is known by its normal n; n and -n are the same plane, so half of a sphere is enough: of
# each pair of opposite triangles of an icosahedron one is kept.

_GOLDEN = (1.0 + 5.0**0.5) / 2.0
_NEXT = np.array([1, 2, 0])
_FOUR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])  # of corners a, b, c, ab, bc, ca


def divided(n_normals: int, cells: IntArray) -> tuple[IntArray, IntArray]:
    """Return the edges whose middles become new normals, and four cells for each cell.

    cells (n_cells, 3) are indices of normals. The middle of edges[i] (n_edges, 2) gets the index
    n_normals + i; an edge that two cells share has one middle.
    """
    others = cells[:, _NEXT]
    # one number per edge, in the order of its ends: NumPy sorts rows ten times as slowly
    numbers = (np.minimum(cells, others) * n_normals + np.maximum(cells, others)).ravel()
    order = numbers.argsort()
    ascending = numbers[order]
    new = np.ones(len(numbers), dtype=bool)
    np.not_equal(ascending[1:], ascending[:-1], out=new[1:])
    middle = np.empty(len(numbers), dtype=np.int64)
    middle[order] = np.cumsum(new) + (n_normals - 1)
    edges = np.array(np.divmod(ascending[new], n_normals)).T
    corners = np.concatenate([cells, middle.reshape(-1, 3)], axis=1)
    return edges, corners[:, _FOUR].swapaxes(0, 1).reshape(-1, 3)


def middles(normals: FloatArray, edges: IntArray) -> FloatArray:
    """Return the unit vectors in the middle of each edge, (n_edges, 3)."""
    between = normals[edges[:, 0]] + normals[edges[:, 1]]
    return np.asarray(between / np.sqrt(_squared(between))[:, None])


def longest_edges(normals: FloatArray, cells: IntArray) -> FloatArray:
    """Return the length, rad, of each cell's longest edge, (n_cells,)."""
    corners = normals[cells]
    squares = _squared(corners - corners[:, _NEXT])
    chord = np.sqrt(np.maximum(np.maximum(squares[:, 0], squares[:, 1]), squares[:, 2]))
    return np.asarray(2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0)))


@cache
def half_sphere(n_divisions: int) -> tuple[FloatArray, IntArray]:
    """Return normals (n, 3) and cells (n_cells, 3) that cover every plane.

    10 * 4**n_divisions cells; their edges are 63.4 degrees long, halved (within 17 %) by each
    division. Do not write into the arrays: they are kept.
    """
    zero, one, gold = np.zeros(4), np.array([1, 1, -1, -1.0]), np.array([1, -1, 1, -1.0]) * _GOLDEN
    normals = np.concatenate(
        [np.roll(np.stack([zero, one, gold], axis=1), turn, axis=1) for turn in range(3)]
    )
    normals /= np.linalg.norm(normals[0])
    near = normals @ normals.T > 0.4  # neighbours: cos 63.4 deg = 0.447; the next: -0.447
    cells = np.array(
        [
            (i, j, k)
            for i in range(12)
            for j in range(i + 1, 12)
            for k in range(j + 1, 12)
            if near[i, j] and near[j, k] and near[i, k]
        ]
    )
    side = normals[cells].sum(axis=1) @ np.array([1.0, 0.1, 0.01])  # no triangle's middle is at 0
    cells = cells[side > 0.0]
    for _ in range(n_divisions):
        edges, cells = divided(len(normals), cells)
        normals = np.concatenate([normals, middles(normals, edges)])
    used, renamed = np.unique(cells, return_inverse=True)
    return normals[used], renamed.reshape(cells.shape)


def smallest_circles(paths: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return the smallest circles around plane paths (n_paths, 2, n_positions).

    Centres (n_paths, 2), radii (n_paths,) and the positions that carry them (n_paths, 3), of which
    some may be equal. The radius is the distance of the farthest position from the centre.

    >>> square = np.array([[[0.0, 60.0, 60.0, 0.0], [0.0, 0.0, 80.0, 80.0]]])
    >>> smallest_circles(square)[1].tolist()
    [50.0]
    """
    n_paths = len(paths)
    middle = (paths.max(axis=2) + paths.min(axis=2)) / 2.0
    first = _squared_distances(paths, middle).argmax(axis=1)
    rows = np.arange(n_paths)
    other = _squared_distances(paths, paths[rows, :, first]).argmax(axis=1)
    carriers = np.stack([first, other, other], axis=1)
    centre = (paths[rows, :, first] + paths[rows, :, other]) / 2.0
    within = ((paths[rows, :, first] - centre) ** 2).sum(axis=1)
    squared = np.empty(n_paths)
    active = rows
    for _ in range(_MOST_STEPS):
        some = paths[active] if len(active) < n_paths else paths
        distances = _squared_distances(some, centre[active])
        farthest = distances.argmax(axis=1)
        squared[active] = distances[np.arange(len(active)), farthest]
        outside = squared[active] > within[active] * (1.0 + 2.0 * _OUTSIDE)
        active, farthest = active[outside], farthest[outside]
        if not len(active):
            return centre, np.sqrt(squared), carriers
        members = np.concatenate([carriers[active], farthest[:, None]], axis=1)
        corners = np.swapaxes(paths[active[:, None], :, members], 1, 2)  # (n, 2, 4)
        found, worth, chosen = _circle_of_four(corners)
        grown = worth > within[active]  # else only round-off is left
        active, members, chosen = active[grown], members[grown], chosen[grown]
        centre[active], within[active] = found[grown], worth[grown]
        carriers[active] = members[np.arange(len(active))[:, None], chosen]
        if not len(active):
            return centre, np.sqrt(squared), carriers
    raise AssertionError("the smallest circle did not settle")


# The last of four members lies outside the circle of the others, so it carries the new one.
_PAIRS_OF_FOUR = np.array([[0, 3], [1, 3], [2, 3]])
_TRIPLES_OF_FOUR = np.array([[0, 1, 3], [0, 2, 3], [1, 2, 3]])
_SETS_OF_FOUR = np.vstack([np.pad(_PAIRS_OF_FOUR, ((0, 0), (0, 1)), mode="edge"), _TRIPLES_OF_FOUR])


def _circle_of_four(corners: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return centre (n, 2), squared radius (n,) and carriers (n, 3) of circles around (n, 2, 4)."""
    base = corners[:, :, 3:4]
    pairs = (corners[:, :, :3] + base) / 2.0
    a = corners[:, :, _TRIPLES_OF_FOUR[:, 0]] - base
    b = corners[:, :, _TRIPLES_OF_FOUR[:, 1]] - base
    twice_area = 2.0 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    aa, bb = (side[:, 0] ** 2 + side[:, 1] ** 2 for side in (a, b))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        x = (b[:, 1] * aa - a[:, 1] * bb) / twice_area
        y = (a[:, 0] * bb - b[:, 0] * aa) / twice_area
        triples = base + np.stack([x, y], axis=1)
        centres = np.concatenate([pairs, triples], axis=2)  # (n, 2, 6)
        away = (corners[:, :, None, :] - centres[:, :, :, None]) ** 2
        squared = (away[:, 0] + away[:, 1]).max(axis=2)
    worth = np.where(np.isfinite(squared), squared, np.inf)
    best = worth.argmin(axis=1)
    rows = np.arange(len(corners))
    return centres[rows, :, best], worth[rows, best], _SETS_OF_FOUR[best]


def _squared_distances(paths: FloatArray, points: FloatArray) -> FloatArray:
    away = paths[:, 0] - points[:, 0, None]
    away *= away
    across = paths[:, 1] - points[:, 1, None]
    across *= across
    away += across
    return away
