"""Plane problems with exact or converged answers, meshed by gmsh as a user would.

Each is solved once per fineness, which divides every element size; the catalogue tells the sizes.
"""

from functools import cache

import numpy as np

from .domains import Fine, Outline, Piece, meshed
from .fields import kirsch_stress, ring_end_traction, tractions_of
from .model import PlaneModel, PlaneSolution

E, NU = 210e3, 0.3


@cache
def kirsch(fineness: float) -> PlaneSolution:
    """FE-05: quarter of a square of half-side 40 with a hole of radius 10, 100 MPa along x."""
    loop = (
        Piece((10, 0), "bottom"),
        Piece((40, 0), "right"),
        Piece((40, 40), "top"),
        Piece((0, 40), "left"),
        Piece((0, 20), "left"),
        Piece((0, 10), "hole", centre=(0, 0)),
    )
    mesh = meshed(Outline((loop,), 10.0, (Fine(("hole",), 2.5, 20.0),)), fineness)
    far = tractions_of(lambda points: kirsch_stress(points, 10.0, 100.0))
    return PlaneModel(mesh, E, NU).solve(
        dirichlet={"bottom": (None, 0.0), "left": (0.0, None)},
        tractions={"right": far, "top": far},
    )


@cache
def strip(ratio: float, fineness: float) -> PlaneSolution:
    """FE-06: quarter of a strip with a hole of diameter 2 = ratio * width, 1 MPa net stress."""
    half, length = 1 / ratio, 6 / ratio
    loop = (
        Piece((1, 0), "bottom"),
        Piece((length, 0), "end"),
        Piece((length, half), "top"),
        Piece((0, half), "left"),
        Piece((0, 1), "hole", centre=(0, 0)),
    )
    near = Fine(("hole", "left"), strip_size(ratio), 2.0)
    mesh = meshed(Outline((loop,), half / 2, (near,)), fineness)
    return PlaneModel(mesh, E, NU).solve(
        dirichlet={"bottom": (None, 0.0), "left": (0.0, None)},
        tractions={"end": lambda _points, normals: (1 - ratio) * normals},
    )


def strip_size(ratio: float) -> float:
    """A quarter of the radius, or half the ligament where that is smaller."""
    return min(0.25, (1 / ratio - 1) / 2)


@cache
def ellipse(fineness: float) -> PlaneSolution:
    """FE-07, NAFEMS LE1, in mm: the tip of the inner ellipse has a radius of 1/2 m."""
    loop = (
        Piece((2000, 0), "bottom"),
        Piece((3250, 0), "outer", centre=(0, 0), major=(3250, 0)),
        Piece((0, 2750), "left"),
        Piece((0, 1000), "inner", centre=(0, 0), major=(2000, 0)),
    )
    near = Fine(((2000.0, 0.0),), 200.0, 1000.0)
    mesh = meshed(Outline((loop,), 400.0, (near,)), fineness)
    return PlaneModel(mesh, E, NU, thickness=100.0).solve(
        dirichlet={"bottom": (None, 0.0), "left": (0.0, None)},
        tractions={"outer": lambda _points, normals: 10.0 * normals},
    )


@cache
def ring_with_end_force(fineness: float) -> PlaneSolution:
    """FE-10: radii 30 and 50, 10 thick, 1000 N to the centre of curvature on the end y = 0."""
    loop = (
        Piece((30, 0), "end"),
        Piece((50, 0), "outer", centre=(0, 0)),
        Piece((0, 50), "root"),
        Piece((0, 30), "inner", centre=(0, 0)),
    )
    mesh = meshed(Outline((loop,), 5.0), fineness)
    return PlaneModel(mesh, E, NU, thickness=10.0).solve(
        dirichlet={"root": (0.0, None), mesh.nearest_node(0, 30): (None, 0.0)},
        tractions={"end": ring_end_traction(30.0, 50.0, 100.0)},
    )


@cache
def fillet(load: str, fineness: float) -> PlaneSolution:
    """FE-15: half of a bar 60 to 40 wide, fillet 4; "tension", "bending" or "round" tension.

    The bar lies along x, y is across; a round one stands along y, with its radius along x.
    """
    outline = [
        ((-150, 0), "axis", None),
        ((150, 0), "narrow_end", None),
        ((150, 20), "narrow", None),
        ((4, 20), "fillet", (4, 24)),
        ((0, 24), "shoulder", None),
        ((0, 30), "wide", None),
        ((-150, 30), "wide_end", None),
    ]
    if load == "round":  # mirrored at x = y, so it goes around the other way
        names = [name for _, name, _ in outline]
        arcs = [centre for _, _, centre in outline]
        starts = [start for start, _, _ in outline]
        backwards = [
            (starts[(k + 1) % len(starts)], names[k], arcs[k]) for k in range(len(outline))
        ][::-1]
        outline = [
            (start[::-1], name, centre and centre[::-1]) for start, name, centre in backwards
        ]
    loop = tuple(Piece(start, name, centre) for start, name, centre in outline)
    mesh = meshed(Outline((loop,), 10.0, (Fine(("fillet",), 1.0, 12.0),)), fineness)
    if load == "round":
        return PlaneModel(mesh, E, NU, "axisymmetric").solve(
            dirichlet={"wide_end": (None, 0.0)},
            tractions={"narrow_end": lambda _points, normals: normals},
        )
    if load == "tension":
        return PlaneModel(mesh, E, NU).solve(
            dirichlet={"axis": (None, 0.0), "wide_end": (0.0, None)},
            tractions={"narrow_end": lambda _points, normals: normals},
        )
    return PlaneModel(
        mesh, E, NU
    ).solve(  # bending: antisymmetric about y = 0
        dirichlet={
            "axis": (0.0, None),
            "wide_end": (0.0, None),
            mesh.nearest_node(-150, 0): (None, 0.0),
        },
        tractions={"narrow_end": lambda points, normals: normals * points[..., 1:] / 20},
    )


@cache
def lug(fineness: float) -> PlaneSolution:
    """FE-16: half of a round-ended lug, hole radius 10, pressed by 10 kN along x as a cosine."""
    loop = (
        Piece((10, 0), "bottom"),
        Piece((25, 0), "round", centre=(0, 0)),
        Piece((0, 25), "side"),
        Piece((-75, 25), "end"),
        Piece((-75, 0), "bottom"),
        Piece((-10, 0), "free", centre=(0, 0)),
        Piece((-10 * 0.5**0.5, 10 * 0.5**0.5), "free", centre=(0, 0)),
        Piece((0, 10), "pressed", centre=(0, 0)),
        Piece((10 * 0.5**0.5, 10 * 0.5**0.5), "pressed", centre=(0, 0)),
    )
    mesh = meshed(Outline((loop,), 8.0, (Fine(("free", "pressed"), 2.5, 20.0),)), fineness)
    pressure = 2 * 10e3 / (np.pi * 10 * 10)
    return PlaneModel(mesh, E, NU, thickness=10.0).solve(
        dirichlet={"bottom": (None, 0.0), "end": (0.0, None)},
        tractions={"pressed": lambda points, _normals: pressure * points[..., :1] * points / 100},
    )


@cache
def disc(hole: float, fineness: float) -> PlaneSolution:
    """FE-17: quarter of a steel disc of radius 200 at 1000 rad/s, with a hole of a radius or 0."""
    rim = (Piece((200, 0), "rim", centre=(0, 0)), Piece((0, 200), "left"))
    if hole:
        inside = (Piece((0, 100), "left"), Piece((0, hole), "hole", centre=(0, 0)))
        loop = (Piece((hole, 0), "bottom"), *rim, *inside)
        fines = (Fine(("hole",), hole / 4, 150.0),)
    else:
        loop, fines = (Piece((0, 0), "bottom"), *rim), ()
    mesh = meshed(Outline((loop,), 30.0, fines), fineness)
    return PlaneModel(mesh, E, NU, thickness=5.0).solve(
        dirichlet={"bottom": (None, 0.0), "left": (0.0, None)},
        body=lambda points: 7.85e-9 * 1e6 * points,
    )


@cache
def pressed_cylinder(kind: str, fineness: float) -> PlaneSolution:
    """FE-04: radii 50 and 100, 100 MPa inside; a quarter, or an axisymmetric slice 50 high."""
    if kind == "axisymmetric":
        loop = (
            Piece((50, 0), "ends"),
            Piece((100, 0), "outer"),
            Piece((100, 50), "ends"),
            Piece((50, 50), "inner"),
        )
        supports = {"ends": (None, 0.0)}
    else:
        loop = (
            Piece((50, 0), "bottom"),
            Piece((100, 0), "outer", centre=(0, 0)),
            Piece((0, 100), "left"),
            Piece((0, 50), "inner", centre=(0, 0)),
        )
        supports = {"bottom": (None, 0.0), "left": (0.0, None)}
    mesh = meshed(Outline((loop,), 20.0, (Fine(("inner",), 10.0, 50.0),)), fineness)
    return PlaneModel(mesh, E, NU, kind).solve(
        dirichlet=supports, tractions={"inner": lambda _points, normals: -100.0 * normals}
    )
