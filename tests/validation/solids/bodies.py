"""CAD bodies of the catalogue, meshed by gmsh as a user's part would be.

Elements at the hot spot are about a quarter of its radius; sides have the names of
`meshes.mapped`: "x0" the inner face, "x1" the outer, "y0", "y1", "z0", "z1" the cuts.
"""

import numpy as np

from .meshes import Cad, plane_at

QUARTER = np.pi / 2


def near_axis(low, high):
    """Test of a face around z between two radii, by its bounding box in the first quadrant."""

    def test(box, kind):
        reach = max(box[3], box[4])
        return kind != "Plane" and low < reach < high

    return test


def ring_body(inner, outer, height, size, near):
    """A quarter ring about z; elements of `near` at the bore."""

    def make(occ):
        whole = occ.addCylinder(0, 0, 0, 0, 0, height, outer, angle=QUARTER)
        bore = occ.addCylinder(0, 0, 0, 0, 0, height, inner, angle=QUARTER)
        occ.cut([(3, whole)], [(3, bore)])

    faces = {
        "x0": near_axis(0.9 * inner, 1.1 * inner),
        "x1": near_axis(0.9 * outer, 1.1 * outer),
        "y0": plane_at(1, 0.0),
        "y1": plane_at(0, 0.0),
        "z0": plane_at(2, 0.0),
        "z1": plane_at(2, height),
    }
    return Cad(make, faces, size, (("x0", near, 2 * inner),))


def shell_body(inner, outer, size, near):
    """An eighth of a spherical shell."""

    def make(occ):
        whole = occ.addSphere(0, 0, 0, outer)
        bore = occ.addSphere(0, 0, 0, inner)
        box = occ.addBox(0, 0, 0, outer, outer, outer)
        shell, _ = occ.cut([(3, whole)], [(3, bore)])
        occ.intersect(shell, [(3, box)])

    faces = {
        "x0": near_axis(0.9 * inner, 1.1 * inner),
        "x1": near_axis(0.9 * outer, 1.1 * outer),
        "y0": plane_at(1, 0.0),
        "y1": plane_at(0, 0.0),
        "z0": plane_at(2, 0.0),
    }
    return Cad(make, faces, size, (("x0", near, 2 * inner),))


def cavity_body(radius, half, size, near):
    """An eighth of a cube with a spherical cavity; "x1", "y1", "z1" its outer sides."""

    def make(occ):
        ball = occ.addSphere(0, 0, 0, radius)
        box = occ.addBox(0, 0, 0, half, half, half)
        occ.cut([(3, box)], [(3, ball)])

    faces = {"skin": near_axis(0.9 * radius, 1.1 * radius)}
    for axis, name in enumerate("xyz"):
        faces |= {f"{name}0": plane_at(axis, 0.0), f"{name}1": plane_at(axis, half)}
    return Cad(make, faces, size, (("skin", near, 2 * radius),))


def hole_body(radius, half, height, size, near):
    """A quarter of a square slab with a round hole along z."""

    def make(occ):
        hole = occ.addCylinder(0, 0, 0, 0, 0, height, radius)
        box = occ.addBox(0, 0, 0, half, half, height)
        occ.cut([(3, box)], [(3, hole)])

    faces = {"skin": near_axis(0.9 * radius, 1.1 * radius)}
    for axis, name in enumerate("xyz"):
        end = height if axis == 2 else half
        faces |= {f"{name}0": plane_at(axis, 0.0), f"{name}1": plane_at(axis, end)}
    return Cad(make, faces, size, (("skin", near, 2 * radius),))


def bar_body(length, width, height, size, place=None):
    """A bar along x from 0, centred in y and z; a vertex at `place` on its skin."""

    def make(occ):
        box = occ.addBox(0, -width / 2, -height / 2, length, width, height)
        if place is not None:
            occ.fragment([(3, box)], [(0, occ.addPoint(*place))])

    faces = {}
    for axis, (name, low, high) in enumerate(
        (("x", 0, length), ("y", -width / 2, width / 2), ("z", -height / 2, height / 2))
    ):
        faces |= {f"{name}0": plane_at(axis, low), f"{name}1": plane_at(axis, high)}
    return Cad(make, faces, size)


def shaft_body(radius, length, size):
    """A round bar along x from 0, with a vertex half way along at y = radius."""

    def make(occ):
        bar = occ.addCylinder(0, 0, 0, length, 0, 0, radius)
        occ.fragment([(3, bar)], [(0, occ.addPoint(length / 2, radius, 0))])

    return Cad(make, {"x0": plane_at(0, 0.0), "x1": plane_at(0, length)}, size)


def plate_body(size):
    """LE10's quarter plate, mm, its rim cut along the middle line that is held."""

    def make(occ):
        corners = [occ.addPoint(*xy, 0) for xy in ((2000, 0), (3250, 0), (0, 2750), (0, 1000))]
        centre = occ.addPoint(0, 0, 0)
        inner = occ.addEllipseArc(corners[0], centre, corners[0], corners[3])
        outer = occ.addEllipseArc(corners[1], centre, corners[1], corners[2])
        sides = [occ.addLine(corners[0], corners[1]), occ.addLine(corners[2], corners[3])]
        plan = occ.addPlaneSurface([occ.addCurveLoop([sides[0], outer, sides[1], inner])])
        solid = [entity for entity in occ.extrude([(2, plan)], 0, 0, 600) if entity[0] == 3]
        middle = occ.copy([(1, outer)])
        occ.translate(middle, 0, 0, 300)
        occ.fragment(solid, middle)

    def rim(box, kind):
        return kind != "Plane" and box[3] > 3000

    faces = {"x1": rim, "y0": plane_at(1, 0.0), "y1": plane_at(0, 0.0), "z1": plane_at(2, 600.0)}
    return Cad(make, faces, size)
