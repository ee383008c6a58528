"""Holes from small to nearly as wide as what they are in, and ligaments down to nothing."""

from functools import cache
from time import perf_counter
from typing import NamedTuple

import numpy as np

from fem.recovery import von_mises
from fem.unit_solutions import solve_unit_loads
from geometry.mesh import MeshError
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink

from ..plane import problems
from ..plane.readings import hoop, read
from ..solids.problems import STEEL

RATIOS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
OUTER = (0.01, 0.95, 0.99)
PUBLISHED = {0.1: 2.732517, 0.2: 2.522053, 0.4: 2.248293, 0.5: 2.1738, 0.8: 2.069981}
LIGAMENTS = (1.0, 0.1, 1e-3, 1e-5)  # mm
WIDTH, FORCE, THICKNESS = 24.0, 1000.0, 8.0


class Link(NamedTuple):
    """A plate link pulled by its pins.

    peak       largest von Mises stress at the hole over force / (net section), MPa
    quality    smallest scaled det J
    raw        how far the unit loads missed their resultant before they were normalised
    reaction   largest support reaction over the force
    """

    peak: float
    quality: float
    raw: float
    reaction: float


def strip(ratio):
    """Stress concentration over the net section of a pulled strip with a hole, plane stress.

    Where half the ligament sets the size of elements they are fine enough as they are.
    """
    fineness = 4.0 if ratio <= 0.9 else 1.0
    return float(read(problems.strip(ratio, fineness), (0, 1), hoop))


@cache
def link(ratio, thickness=THICKNESS, fineness=0.6):
    """A plate link whose first hole is `ratio` of its width, the second half the width."""
    shape = PlateLink(
        length=60, width=WIDTH, thickness=thickness, hole=ratio * WIDTH, second_hole=WIDTH / 2
    )
    mesh = mesh_shape(shape, fineness=fineness)
    solved = solve_unit_loads(mesh, STEEL)
    pull = np.zeros((1, 6))
    pull[0, 0] = FORCE
    coefficients, _ = solved.coefficients({"first": -pull, "second": pull}, np.zeros((1, 4)))
    hole = np.isin(solved.recovery.points, mesh.surfaces["first"])
    stress = von_mises(solved.basis[hole] @ coefficients[:, 0])
    return Link(
        float(stress.max()) * (1 - ratio) * WIDTH * thickness / FORCE,
        mesh.jacobian_minimum,
        solved.raw_deviation,
        float(np.abs(solved.reactions(coefficients)).max() / FORCE),
    )


def between_holes(gap):
    """What becomes of a link whose holes are `gap` mm apart: smallest scaled det J, or words."""
    return _tried(PlateLink(length=12 + gap, width=WIDTH, thickness=THICKNESS, hole=12))


def beside_a_hole(gap):
    """The same of a link whose hole is `gap` mm from its sides and its end."""
    hole = WIDTH - 2 * gap
    return _tried(
        PlateLink(length=60, width=WIDTH, thickness=THICKNESS, hole=hole, second_hole=8.0)
    )


def _tried(shape):
    start = perf_counter()
    try:
        return mesh_shape(shape, fineness=0.6).jacobian_minimum, perf_counter() - start
    except MeshError as refused:
        return str(refused), perf_counter() - start
