"""The smallest circle around a plane path.

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

import numpy as np

from fatigue.stress_path import FloatArray, IntArray

# A position farther out than this fraction of the radius joins the carriers; round-off is smaller.
_OUTSIDE = 1e-13
_MOST_STEPS = 1000  # reached by no path seen: 3 to 8 steps are usual


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
