"""Number of elements of a mesh, estimated from the CAD body before it is meshed."""

from math import inf, pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.mesh import FloatArray, TooFineError

if TYPE_CHECKING:
    from geometry.meshing import Body, Region

_TRIANGLE = sqrt(3.0) / 4.0  # area of an equilateral triangle over its edge squared
_TETRAHEDRON = 1.0 / (6.0 * sqrt(2.0))  # volume of a regular one over its edge cubed
_MOST_TRIANGLES = 150_000  # of a skin: half a minute
_MOST_ELEMENTS = 1_000_000  # of a solid before any error is known
_SAMPLES = 5  # along each parameter of a face, at which its curvature is asked
_CLOSE = 0.1  # of a region's reach, within which elements have its size


def check_skin(gmsh: Any, sizes: tuple[float, float], per_turn: float) -> None:
    """Raise TooFineError where the faces of gmsh's model would take too many triangles."""
    count = skin_triangles(gmsh, sizes, per_turn)
    if not count <= _MOST_TRIANGLES:
        raise TooFineError(
            f"its faces would need about {count:.1e} triangles, more than {_MOST_TRIANGLES:.1e}: "
            f"elements of {sizes[1]:.2g} mm where it is thinnest, smaller ones on its curves"
        )


def check_elements(count: float, size: float) -> None:
    """Raise TooFineError where a solid would take too many elements, of a size in mm."""
    if not count <= _MOST_ELEMENTS:
        raise TooFineError(
            f"would need about {count:.1e} elements of {size:.3g} mm or less, more than "
            f"{_MOST_ELEMENTS:.1e}; its walls or holes are too small for a solid, or mesh.fineness "
            "too high"
        )


def skin_triangles(gmsh: Any, sizes: tuple[float, float], per_turn: float) -> float:
    """Triangles on the faces of gmsh's model, of edges between two sizes, mm.

    per_turn  how many of them go round a full turn of a curved face
    """
    found = 0.0
    for _, face in gmsh.model.getEntities(2):
        bend = _largest_curvature(gmsh, face)
        edge = float(np.clip(2 * pi / (per_turn * bend) if bend else inf, *sizes))
        found += gmsh.model.occ.getMass(2, face) / (_TRIANGLE * edge**2)
    return found


def _largest_curvature(gmsh: Any, face: int) -> float:
    """Largest curvature that a face has at some of its points, 1/mm."""
    if gmsh.model.getType(2, face) == "Plane":
        return 0.0
    low, high = gmsh.model.getParametrizationBounds(2, face)
    u, v = (np.linspace(low[k], high[k], _SAMPLES + 2)[1:-1] for k in (0, 1))
    places = np.stack(np.meshgrid(u, v), axis=-1).ravel()
    largest, smallest, _, _ = gmsh.model.getPrincipalCurvatures(face, places)
    return float(np.abs([*largest, *smallest]).max(initial=0.0))


def solid_elements(gmsh: Any, body: "Body", fineness: float) -> float:
    """Tetrahedra of a body, its regions included.

    A region's elements grow evenly from its size to the general one over its reach: of a face with
    the area A, the integral of A dx / (0.118 h(x)^3); of a curve A = pi x times its length.
    """
    general = body.size / fineness
    volume = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))
    found = volume / (_TETRAHEDRON * general**3)
    for region in body.regions:
        small = region.size / fineness
        if small < general:
            found += _region_elements(gmsh, region, small, general)
    return float(found)


def _region_elements(gmsh: Any, region: "Region", small: float, general: float) -> float:
    depth = np.geomspace(1e-3 * _CLOSE, 1.0, 200) * region.reach
    grown = (depth / region.reach - _CLOSE) / (1.0 - _CLOSE)
    edge = small + (general - small) * np.clip(grown, 0.0, 1.0)
    found = 0.0
    for dimension, tag in region.entities:
        extent = gmsh.model.occ.getMass(dimension, tag)
        area: FloatArray = extent * (np.ones_like(depth) if dimension == 2 else pi * depth)
        found += float(np.trapezoid(area / (_TETRAHEDRON * edge**3), depth))
    return found
