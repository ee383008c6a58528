"""Readings from a solved plane problem, at a point or over an edge."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geometry.mesh import FloatArray

from .model import PlaneSolution
from .recovery import largest_principal, von_mises_plane


@dataclass(frozen=True)
class Reading:
    """A recovered quantity, the elements' scatter where it was read, and their size there."""

    value: float
    scatter: float
    size: float


Measure = Callable[[FloatArray, FloatArray], FloatArray]  # stress (n, 4), points (n, 2) -> (n,)


def along(degrees: float) -> Measure:
    """Normal stress in a direction."""
    return lambda stress, points: _normal(
        stress, np.full(len(points), np.cos(np.radians(degrees))), np.sin(np.radians(degrees))
    )


def hoop(stress: FloatArray, points: FloatArray) -> FloatArray:
    """Normal stress around the origin."""
    x, y = (points / np.linalg.norm(points, axis=1, keepdims=True)).T
    return _normal(stress, -y, x)


def radial(stress: FloatArray, points: FloatArray) -> FloatArray:
    """Normal stress away from the origin."""
    x, y = (points / np.linalg.norm(points, axis=1, keepdims=True)).T
    return _normal(stress, x, y)


def shear(stress: FloatArray, _points: FloatArray) -> FloatArray:
    """Shear stress xy."""
    return stress[:, 3]


def out_of_plane(stress: FloatArray, _points: FloatArray) -> FloatArray:
    """Stress zz: the hoop stress of an axisymmetric model."""
    return stress[:, 2]


def von_mises(stress: FloatArray, _points: FloatArray) -> FloatArray:
    return von_mises_plane(stress)


def principal(stress: FloatArray, _points: FloatArray) -> FloatArray:
    return largest_principal(stress)


def _normal(stress, x, y):
    return stress[:, 0] * x**2 + stress[:, 1] * y**2 + 2 * stress[:, 3] * x * y


def node_at(solution: PlaneSolution, x: float, y: float) -> int:
    """The node at a point; it must be there."""
    mesh = solution.model.mesh
    node = mesh.nearest_node(x, y)
    assert np.hypot(*(mesh.nodes[node] - [x, y])) < 1e-7 * np.ptp(mesh.nodes)
    return node


def read(solution: PlaneSolution, place: tuple[float, float], measure: Measure) -> float:
    """A measure of the recovered stress at a node."""
    node = node_at(solution, *place)
    at = slice(node, node + 1)
    return float(measure(solution.stress[at], solution.model.mesh.nodes[at])[0])


def read_unaveraged(
    solution: PlaneSolution, place: tuple[float, float], measure: Measure
) -> FloatArray:
    """The same of each element that meets there."""
    node = node_at(solution, *place)
    own = solution.element_stress[solution.model.mesh.elements == node]
    return measure(own, np.tile(solution.model.mesh.nodes[node], (len(own), 1)))


def peak(solution: PlaneSolution, edge: str, measure: Measure) -> tuple[float, int]:
    """Largest of a measure over the nodes of an edge, and the node."""
    nodes = solution.model.mesh.edge_nodes(edge)
    values = measure(solution.stress[nodes], solution.model.mesh.nodes[nodes])
    return float(values.max()), int(nodes[values.argmax()])
