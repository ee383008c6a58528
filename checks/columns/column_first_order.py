"""First-order moments of a part as a column: those of the undeformed part between its two pins.

They are linear in what acts on the part, so each is a shape along the part times a size per
position: what follows from the shapes is computed once and not at every position.
"""

from dataclasses import dataclass

import numpy as np

from checks.columns.column_limits import is_stepped
from checks.design.data import Part
from checks.part.part_loads import PartLoads
from geometry.mesh import FloatArray

GRID = 129  # even places along the part at which moments are computed


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """Moments of a part in one plane, (n, m) N mm: acting @ shapes.

    acting  (n, r) couples and forces across at both pins, N mm and N; accelerations
    shapes  (r, 129) moment per unit, at even places between the pins
    """

    acting: FloatArray
    shapes: FloatArray

    @property
    def moments(self) -> FloatArray:
        """The moments (n, 129), N mm."""
        return self.acting @ self.shapes

    def at(self, places: FloatArray) -> FloatArray:
        """Moments (n, k), N mm, at places (k,), shares of the length: straight between the 129."""
        grid = np.linspace(0.0, 1.0, GRID)
        shapes = np.stack([np.interp(places, grid, shape) for shape in self.shapes])
        return np.asarray(self.acting @ shapes)

    def over(self, rows: FloatArray) -> FloatArray:
        """Weighted sums (n, m) of the moments, N mm, by rows (m, 129) of weights."""
        return self.acting @ (self.shapes @ rows.T)


def first_order(
    part: Part, loads: PartLoads, length: float, mass: float | None = None
) -> tuple[FirstOrder, FirstOrder]:
    """Moments about z and about y of the undeformed part.

    From both ends towards the other, each in its share: what the part has beyond its pins, which
    the sections do not know, leaves no step. A stated `mass` of the body, t, is spread as the
    sections' is.
    """
    first, second = (loads.wrenches[name] for name in part.geometry.interfaces[:2])
    x = np.linspace(0.0, length, GRID)
    share = x / length
    own = _own_shapes(part, x, mass)
    found = []
    # about z a force along y has a lever, about y one along -z; inertia bends about z only
    for couple, across, sign in ((5, 1, 1.0), (4, 2, -1.0)):
        ends = [first[:, couple], first[:, across], second[:, couple], second[:, across]]
        turned, pushed = (1 - share), sign * (1 - share) * x
        shapes = [-turned, pushed, share, sign * share * (length - x)]
        if couple == 5:
            ends += [loads.accelerations[:, 1], loads.accelerations[:, 2]]
            shapes += own
        found.append(FirstOrder(np.stack(ends, axis=1), np.stack(shapes)))
    return found[0], found[1]


def first_order_moments(
    part: Part, loads: PartLoads, length: float, mass: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Moments about z and y (n, 129), N mm, as `first_order` has them."""
    about_z, about_y = first_order(part, loads, length, mass)
    return about_z.moments, about_y.moments


def _own_shapes(part: Part, x: FloatArray, mass: float | None) -> list[FloatArray]:
    """Moment about z, (m,) each, of the part's own mass per unit of a_y and of alpha."""
    areas = _areas(part, x)
    volumes = _cumulated(areas * np.stack([x**0, x, x**2]), x)
    density = part.material.density if mass is None else mass / float(volumes[0, -1])
    share = x / x[-1]
    shapes = []
    for order in (0, 1):
        force, lever = -density * volumes[order], -density * volumes[order + 1]
        from_start = x * force - lever
        from_end = (lever[-1] - lever) - x * (force[-1] - force)
        shapes.append((1 - share) * from_start + share * from_end)
    return shapes


def _areas(part: Part, x: FloatArray) -> FloatArray:
    """Area of the section at each place, mm2; the largest where stretches are not told."""
    sections = part.geometry.sections
    if not is_stepped(part):
        return np.full(len(x), max(section.area for section in sections))
    areas = np.zeros(len(x))
    for section in sections:
        assert section.stretch is not None
        areas[(x >= section.stretch[0]) & (x <= section.stretch[1])] = section.area
    return areas


def _cumulated(values: FloatArray, x: FloatArray) -> FloatArray:
    """Integral (n, k) from the first place to each, by trapezoids."""
    pieces = (values[:, 1:] + values[:, :-1]) / 2 * np.diff(x)
    return np.concatenate([np.zeros((len(values), 1)), np.cumsum(pieces, axis=1)], axis=1)
