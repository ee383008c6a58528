"""Cheeks of a tube that spread apart beside a pin: plates that its side walls hold at their edges.

Where the side walls are cut away a cheek's edges are free; behind them the edges stand still and
turn together with the side walls, which are plates, too. By symmetry half a cheek and half a side
wall, laid out in one plane, buckle as one. Their stress is the lug's (pin_loaded_hole); the
side wall has as much as the edge beside it. Deflections are products of cubics on a grid
(Bogner, Fox and Schmit 1965); points within the hole have no stiffness. Kirchhoff's plates, with
E t^3/(12 (1 - nu^2)) (Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 8.1).

The side walls' ends give way where they begin to hold the cheek. They count from half a wall behind
the cut-out's end, which is chosen: of solids of 18 bars the share is 0.87 to 1.10 of this.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from checks.handbook.lateral_buckling import cubics
from checks.handbook.lug_stress import Lug
from fem.unit_loads import bearing_coefficients
from geometry.bars import BESIDE
from geometry.mesh import FloatArray, IntArray
from geometry.parts import ToggleBar

_GIVES = 0.5  # of the wall: how far behind the cut-out's end the side walls hold
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_ACROSS, _WALL = 4, 2  # elements of half a cheek and of half a side wall
_ALONG = 5  # elements on a tube's width, beside hole and cut-out
_EMPTY = 1e-5  # of the stiffness, left to what is in the hole
_UNLOADED = 1e-9  # of the largest eigenvalue: round-off

Stress = Callable[[FloatArray, FloatArray], FloatArray]
"""Stress xx, yy and xy (k, 3) of a cheek at places (k,), MPa per N of the pin's push."""


@dataclass(frozen=True, eq=False)
class _Grid:
    """Lines of the plates laid out, mm.

    along   (m,) from the bar's end, 0 at the pin
    across  (k,) from the cheek's middle over its edge to the side wall's middle
    held    mm along, from where the side walls hold the edge
    """

    along: FloatArray
    across: FloatArray
    held: float

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of lines."""
        return len(self.along), len(self.across)

    def unknowns(self, i: int, j: int) -> IntArray:
        """Of node (i, j): w, its slopes across and along, and the mixed second one."""
        return np.asarray(4 * (i * len(self.across) + j) + np.arange(4))

    @property
    def free(self) -> IntArray:
        """Unknowns that may move; the far end is held."""
        count, lines = self.shape
        held = np.zeros((count, lines, 4), bool)
        held[:, [0, -1], 1] = held[:, [0, -1], 3] = True  # symmetric about both middles
        behind = self.along >= self.held
        held[behind, _ACROSS, 0] = held[behind, _ACROSS, 2] = True
        held[~behind, _ACROSS + 1 :] = True
        held[-1] = True
        return np.flatnonzero(~held)


def spreading(shape: ToggleBar, lug: Lug, young: float, poisson_ratio: float) -> float | None:
    """Share of their buckling load that 1 N of the pin's push is on the cheeks at the knee, 1/N.

    None where less than a wall is left between the hole and the side wall: no plate.

    lug  both cheeks about the knee's hole
    """
    beside = shape.width / 2 - shape.wall - shape.hole / 2
    if beside < shape.wall:
        return None
    grid = _grid(shape)
    push = np.array([[1.0, 0.0, 0.0]])
    own = bearing_coefficients(push, inward=False)[0]
    area = 4 * (shape.width - shape.wall) * shape.wall
    cut = solved_to(shape)
    edge = shape.width / 2 * (1 - 1e-3)

    def stress(x: FloatArray, y: FloatArray) -> FloatArray:
        scaled = np.minimum(y * shape.width / (shape.width - shape.wall), edge)
        found = lug.stress(np.minimum(x, cut) + 1j * scaled) @ own
        found[x > cut] = -1 / area, 0.0, 0.0
        return np.asarray(found)

    elastic, loaded = _matrices(shape, grid, stress, young, poisson_ratio)
    free = grid.free
    lower = np.linalg.cholesky(elastic[np.ix_(free, free)])
    half = np.linalg.solve(lower, loaded[np.ix_(free, free)])
    values = np.linalg.eigvalsh(-np.linalg.solve(lower, half.T))
    largest = float(values[-1])
    return largest if largest > _UNLOADED * float(np.abs(values).max()) else 0.0


def solved_to(shape: ToggleBar) -> float:
    """How far from a hole's axis the stress about it is solved, mm."""
    return max(min(BESIDE * shape.width, shape.length / 2), shape.hole)


def _grid(shape: ToggleBar) -> _Grid:
    size, radius = shape.width - shape.wall, shape.hole / 2
    held = shape.cutout_length - shape.overhang + _GIVES * shape.wall
    beside = max(held, radius)
    far = beside + size
    marks = {-radius, 0.0, radius, held, beside + size / 2}
    marks = {mark for mark in marks if -shape.overhang < mark < far}
    along = [-shape.overhang]
    for mark in sorted(marks):
        count = int(np.ceil((mark - along[-1]) * _ALONG / size - 1e-9))
        along += np.linspace(along[-1], mark, max(1, count) + 1)[1:].tolist()
    along += np.linspace(along[-1], far, 3)[1:].tolist()
    across = np.r_[
        np.linspace(0.0, size / 2, _ACROSS + 1), np.linspace(size / 2, size, _WALL + 1)[1:]
    ]
    return _Grid(np.array(along), across, held)


def _matrices(
    shape: ToggleBar,
    grid: _Grid,
    stress: Stress,
    young: float,
    poisson_ratio: float,
) -> tuple[FloatArray, FloatArray]:
    """Elastic stiffness, and the stress's own per N; both of all unknowns."""
    wall, radius = shape.wall, shape.hole / 2
    bending = young * wall**3 / 12 / (1 - poisson_ratio**2)
    count = 4 * grid.shape[0] * grid.shape[1]
    elastic, loaded = np.zeros((count, count)), np.zeros((count, count))
    rows = [_along_line(grid.along, i) for i in range(len(grid.along) - 1)]
    columns = [_along_line(grid.across, j) for j in range(len(grid.across) - 1)]
    for i, (x, x_weight, in_x) in enumerate(rows):
        for j, (y, y_weight, in_y) in enumerate(columns):
            cheek = j < _ACROSS
            if not cheek and grid.along[i + 1] <= grid.held:
                continue
            at_x, at_y = (one.ravel() for one in np.meshgrid(x, y, indexing="ij"))
            area = np.outer(x_weight, y_weight).ravel()
            solid = np.hypot(at_x, at_y) > radius
            if cheek:
                acting = stress(at_x, at_y)
            else:  # as much along as the edge beside it
                acting = np.zeros((len(at_x), 3))
                acting[:, 0] = stress(at_x, np.full_like(at_x, grid.across[_ACROSS]))[:, 0]
                solid = np.ones_like(solid)

            def field(
                a: int, b: int, in_x: list[FloatArray] = in_x, in_y: list[FloatArray] = in_y
            ) -> FloatArray:
                pair = np.einsum("ga,hb->ghab", in_x[a], in_y[b])
                return np.asarray(pair.reshape(len(in_x[a]) * len(in_y[b]), 16))

            bent_x, bent_y, twisted = field(2, 0), field(0, 2), field(1, 1)
            slope_x, slope_y = field(1, 0), field(0, 1)
            weight = area * bending * np.where(solid, 1.0, _EMPTY)
            both = (bent_x.T * weight) @ bent_y
            own = (bent_x.T * weight) @ bent_x + (bent_y.T * weight) @ bent_y
            own += poisson_ratio * (both + both.T)
            own += 2 * (1 - poisson_ratio) * (twisted.T * weight) @ twisted
            force = (area * solid * wall)[:, None] * acting
            crossed = (slope_x.T * force[:, 2]) @ slope_y
            work = (slope_x.T * force[:, 0]) @ slope_x + (slope_y.T * force[:, 1]) @ slope_y
            work += crossed + crossed.T
            # cubics along and across: (value, slope) at the start, then at the end
            index = np.concatenate(
                [
                    grid.unknowns(i + a, j + b)[2 * p + np.arange(2)]
                    for a in (0, 1)
                    for p in (0, 1)
                    for b in (0, 1)
                ]
            )
            place = np.ix_(index, index)
            elastic[place] += own
            loaded[place] += work
    return elastic, loaded


def _along_line(lines: FloatArray, k: int) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
    """Gauss points between two lines, their lengths, and the cubics there with their slopes."""
    size = float(lines[k + 1] - lines[k])
    shares = (1 + _POINTS) / 2
    sizes = np.full(len(shares), size)
    values = [cubics(shares, sizes, slopes) for slopes in range(3)]
    return lines[k] + size * shares, _WEIGHTS * size / 2, values
