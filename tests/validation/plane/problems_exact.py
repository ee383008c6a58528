"""More plane problems with closed answers, meshed by gmsh as a user would."""

from functools import cache

import numpy as np

from .domains import Fine, Outline, Piece, meshed
from .fields import Cantilever, elliptic_hole_stress, tractions_of
from .model import PlaneModel, PlaneSolution
from .torsion import SectionTorsion

E, NU = 210e3, 0.3


@cache
def cantilever(fineness: float) -> PlaneSolution:
    """FE-03 with four elements over the depth."""
    loop = (
        Piece((0, -6), "bottom"),
        Piece((48, -6), "end"),
        Piece((48, 6), "top"),
        Piece((0, 6), "root"),
        Piece((0, 0), "root"),
    )
    mesh = meshed(Outline((loop,), 3.0), fineness)
    return PlaneModel(mesh, Cantilever.young, Cantilever.poisson).solve(
        dirichlet={"root": Cantilever.root()},
        tractions={"end": tractions_of(Cantilever.stress)},
    )


@cache
def elliptic_hole(along: float, across: float, fineness: float) -> PlaneSolution:
    """Quarter of a square around an elliptic hole, 100 MPa along y; elements of a quarter of the
    smaller tip radius at both tips.
    """
    side = 4 * max(along, across)
    loop = (
        Piece((along, 0), "bottom"),
        Piece((side, 0), "right"),
        Piece((side, side), "top"),
        Piece((0, side), "left"),
        Piece((0, across), "hole", (0, 0), (along, 0) if along > across else (0, across)),
    )
    near = Fine(("hole",), tip_size(along, across), side / 2)
    mesh = meshed(Outline((loop,), side / 5, (near,)), fineness)
    far = tractions_of(lambda points: elliptic_hole_stress(points, along, across, 100.0))
    return PlaneModel(mesh, E, NU).solve(
        dirichlet={"bottom": (None, 0.0), "left": (0.0, None)},
        tractions={"right": far, "top": far},
    )


@cache
def hole_under_cosines(fineness: float) -> PlaneSolution:
    """Upper half of a sheet with a hole of radius 10 under pressures 100 |cos(angle)| MPa.

    Two half cosines, whose arcs end at 90 degrees. Every pattern p cos(n angle), n > 1, makes a
    hoop stress of -p cos(n angle) at the hole of an infinite sheet (Airy's r^-n and r^(2-n)), the
    even one +p: 400/pi - p in sum. The sheet ends at 100 radii, which changes its mean by 2e-4.
    """
    loop = (
        Piece((10, 0), "cut"),
        Piece((1000, 0), "outer", centre=(0, 0)),
        Piece((0, 1000), "outer", centre=(0, 0)),
        Piece((-1000, 0), "cut"),
        Piece((-10, 0), "hole", centre=(0, 0)),
        Piece((0, 10), "hole", centre=(0, 0)),
    )
    mesh = meshed(Outline((loop,), 150.0, (Fine(("hole",), 2.5, 400.0),)), fineness)
    middle = mesh.nearest_node(0.0, 10.0)

    def traction(points, normals):
        angle = np.arctan2(points[..., 1], points[..., 0])
        return -100.0 * np.abs(np.cos(angle))[..., None] * normals

    return PlaneModel(mesh, E, NU).solve(
        dirichlet={"cut": (None, 0.0), middle: (0.0, None)}, tractions={"hole": traction}
    )


def tip_size(along: float, across: float) -> float:
    """A quarter of the smaller radius of curvature of an ellipse."""
    return min(along, across) ** 2 / max(along, across) / 4


@cache
def spherical_cavity(fineness: float) -> PlaneSolution:
    """A cavity of radius 1 in a cylinder of radius and half-length 20 under 1 MPa along its axis.

    It disturbs the far field like r^-3: 1/8000 at the surface of the cylinder.
    """
    loop = (
        Piece((1, 0), "middle"),
        Piece((20, 0), "side"),
        Piece((20, 20), "end"),
        Piece((0, 20), "axis"),
        Piece((0, 1), "cavity", centre=(0, 0)),
    )
    mesh = meshed(Outline((loop,), 4.0, (Fine(("cavity",), 0.25, 8.0),)), fineness)
    return PlaneModel(mesh, E, NU, "axisymmetric").solve(
        dirichlet={"middle": (None, 0.0)},
        tractions={"end": lambda _points, normals: normals},
    )


@cache
def spherical_shell(fineness: float) -> PlaneSolution:
    """Half a shell of radii 50 and 100 mm under 100 MPa inside."""
    loop = (
        Piece((50, 0), "middle"),
        Piece((100, 0), "outer", centre=(0, 0)),
        Piece((0, 100), "axis"),
        Piece((0, 50), "inner", centre=(0, 0)),
    )
    mesh = meshed(Outline((loop,), 20.0, (Fine(("inner",), 10.0, 50.0),)), fineness)
    return PlaneModel(mesh, E, NU, "axisymmetric").solve(
        dirichlet={"middle": (None, 0.0)},
        tractions={"inner": lambda _points, normals: -100.0 * normals},
    )


@cache
def twisted_rectangle(breadth: float, fineness: float) -> SectionTorsion:
    """FE-14: breadth x 1, four elements through the thickness."""
    loop = (
        Piece((-breadth / 2, -0.5), "long"),
        Piece((0, -0.5), "long"),
        Piece((breadth / 2, -0.5), "short"),
        Piece((breadth / 2, 0.5), "long"),
        Piece((-breadth / 2, 0.5), "short"),
    )
    return SectionTorsion(meshed(Outline((loop,), 0.25), fineness))


@cache
def twisted_ellipse(fineness: float) -> SectionTorsion:
    """Semi-axes 2 along x and 1 along y."""
    starts = ((2, 0), (0, 1), (-2, 0), (0, -1))
    loop = tuple(Piece(start, "rim", (0, 0), (2, 0)) for start in starts)
    return SectionTorsion(meshed(Outline((loop,), 0.4), fineness))


@cache
def twisted_triangle(fineness: float) -> SectionTorsion:
    """Equal sides of 1, one of them along x with its middle at the origin."""
    starts = ((-0.5, 0), (0, 0), (0.5, 0), (0, 3**0.5 / 2))
    loop = tuple(Piece(start, "rim") for start in starts)
    return SectionTorsion(meshed(Outline((loop,), 0.2), fineness))
