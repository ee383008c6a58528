"""The bar of a solid's buckling load by its mesh: what finer meshes of the same part have.

From meshes far coarser than a check takes to as fine as it takes; parts that buckle as a whole,
and thin ones whose walls buckle by themselves on few elements (docs/theory/buckling.md).
"""

import numpy as np
import pytest

from fem.buckling import buckling_at, mesh_bar
from fem.unit_solutions import solve_unit_loads
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink, PrismaticTube, ToggleBar, TubeRod

from ...fem.blocks import wrench
from .solids import steel

TOGGLE = ToggleBar(
    length=120, width=40, wall=3, hole=16, overhang=16, inner_radius=2, cutout_length=22,
    cutout_corner=3,
)  # fmt: skip
ROD = TubeRod(
    length=160, tube_diameter=14, wall=None, eye_diameter=40, eye_width=30, hole=20, fillet=2
)
SLOW = pytest.mark.slow
PARTS = [
    pytest.param(PlateLink(length=160, width=40, thickness=2, hole=10), (0.15, 0.25, 0.5, 0.9)),
    pytest.param(
        PlateLink(length=160, width=20, thickness=8, hole=10), (0.3, 0.5, 0.8), marks=SLOW
    ),
    pytest.param(PrismaticTube(length=250, width=13, wall=1.6), (0.2, 0.3, 0.6), marks=SLOW),
    pytest.param(PrismaticTube(length=150, width=30, wall=1.2), (0.35, 0.6, 1.0), marks=SLOW),
    pytest.param(PlateLink(length=120, width=20, thickness=30, hole=14), (0.4, 0.6), marks=SLOW),
    pytest.param(TOGGLE, (0.3, 0.5, 0.8), marks=SLOW),
    pytest.param(ROD, (0.6, 0.8), marks=SLOW),
]


def share_of(shape, fineness):
    """Share of the buckling load of 1 N, and its bar over it."""
    solutions = solve_unit_loads(mesh_shape(shape, fineness=fineness), steel())
    names = [loads.interface.name for loads in solutions.interfaces]
    ends = dict(zip(names, (wrench(1.0), wrench(-1.0)), strict=True))
    state = solutions.coefficients(ends, np.zeros((1, 4)))[0][:, 0]
    modes = buckling_at(solutions, state, tilt_held=False).modes
    return 1 / modes[0].factor, mesh_bar(solutions, state, modes)


@pytest.mark.parametrize(("shape", "finenesses"), PARTS)
def test_the_bar_of_a_coarse_mesh_holds_what_a_finer_one_has(shape, finenesses):
    """Each bar reaches to the finest share and what that one's own bar leaves; it falls."""
    found = [share_of(shape, fineness) for fineness in finenesses]
    finest, left = found[-1]
    for share, bar in found[:-1]:
        assert share * (1 - bar) < finest < share * (1 + bar)
        assert bar > left
    bars = [bar for _, bar in found]
    assert bars == sorted(bars, reverse=True)
    assert left < 0.1
