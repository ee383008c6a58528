"""Bars and rods that are tubes as sheets: their material along z, all walls together."""

from typing import Any

import numpy as np

from geometry.mesh import FloatArray, Interface
from geometry.meshing import Region
from geometry.parts import PrismaticTube, ToggleBar, TubeRod
from geometry.plane_drawing import bores, curves_in_box, curves_on_circle, disks, drawn, line
from geometry.plane_outlines import Drawn, PlaneOutline


def toggle_bar(shape: ToggleBar) -> PlaneOutline:
    """A toggle bar: two cheeks, and the whole tube beyond the cut-out."""
    holes = [("knee", 0.0, shape.hole), ("end", shape.length, shape.hole)]
    start, stop = -shape.overhang, shape.length + shape.overhang
    half, inner = shape.width / 2, shape.width / 2 - shape.wall
    cut_end = shape.cutout_length - shape.overhang

    def draw(gmsh: Any) -> Drawn:
        occ = gmsh.model.occ
        plate = occ.addRectangle(start, -half, 0, stop - start, shape.width)
        lines = [line(gmsh, cut_end, side * inner, stop, side * inner) for side in (-1, 1)]
        lines += [line(gmsh, cut_end, side * inner, cut_end, side * half) for side in (-1, 1)]
        pieces, _ = occ.fragment([(2, plate)], lines)
        occ.cut([entity for entity in pieces if entity[0] == 2], disks(gmsh, holes))
        occ.synchronize()
        seams = curves_in_box(gmsh, (cut_end, cut_end), (-half, half))
        fine = min(shape.cutout_corner / 2, shape.width / 8)
        near = [Region([(1, tag) for tag in seams], fine, 2 * shape.cutout_corner)]
        return drawn(gmsh, holes, shape.width / 6, near)

    def thickness(points: FloatArray) -> FloatArray:
        x, y = points[:, 0], np.abs(points[:, 1])
        tube = _square_tube_depth(y, shape.width, shape.wall, shape.inner_radius)
        corner = shape.cutout_corner
        into = np.clip((x - (cut_end - corner)) / corner, 0.0, 1.0)
        ramp = 2 * shape.wall + 2 * corner * (1 - np.sqrt(1 - into**2))
        return np.where(x < cut_end, np.minimum(ramp, tube), tube)

    on_pins = bores(holes, [2 * shape.wall] * 2)
    return PlaneOutline(draw, thickness, on_pins, half, seams="cut-out or wall")


def tube_rod(shape: TubeRod) -> PlaneOutline:
    """A round rod with eyes: the chords along z of its tube, balls and bore."""
    holes = [("first", 0.0, shape.hole), ("second", shape.length, shape.hole)]
    eye, tube, fillet = shape.eye_diameter / 2, shape.tube_diameter / 2, shape.fillet
    bore = 0.0 if shape.wall is None else tube - shape.wall
    centre = (float(np.sqrt((eye + fillet) ** 2 - (tube + fillet) ** 2)), tube + fillet)
    joint = tuple(place * eye / (eye + fillet) for place in centre)

    def draw(gmsh: Any) -> Drawn:
        occ = gmsh.model.occ
        eyes = [occ.addPoint(x, 0, 0) for x in (0.0, shape.length)]
        tips = [occ.addPoint(x, 0, 0) for x in (-eye, shape.length + eye)]

        def flank(side: float) -> list[int]:
            """The curves from tip to tip on one side of the rod, in their order."""
            ends, shank = [], []
            for k, (x, way) in enumerate(((0.0, 1.0), (shape.length, -1.0))):
                on_eye = on_tube = occ.addPoint(x + way * joint[0], side * joint[1], 0)
                ends.append([occ.addCircleArc(tips[k], eyes[k], on_eye)])
                if fillet:
                    on_tube = occ.addPoint(x + way * centre[0], side * tube, 0)
                    middle = occ.addPoint(x + way * centre[0], side * centre[1], 0)
                    ends[k].append(occ.addCircleArc(on_eye, middle, on_tube))
                shank.append(on_tube)
            return [*ends[0], occ.addLine(*shank), *ends[1][::-1]]

        face = occ.addPlaneSurface([occ.addCurveLoop([*flank(1.0), *flank(-1.0)[::-1]])])
        occ.cut([(2, face)], disks(gmsh, holes))
        occ.synchronize()
        around = [
            tag
            for x, way in ((0.0, 1.0), (shape.length, -1.0))
            for side in (1.0, -1.0)
            if fillet
            for tag in curves_on_circle(gmsh, x + way * centre[0], side * centre[1], fillet)
        ]
        near = [Region([(1, tag) for tag in around], fillet / 3, tube)] if around else []
        return drawn(gmsh, holes, tube / 2, near)

    def thickness(points: FloatArray) -> FloatArray:
        x, y = np.minimum(points[:, 0], shape.length - points[:, 0]), points[:, 1]
        radius = np.full(len(points), tube)
        if fillet:
            beside = np.clip(centre[0] - x, 0.0, fillet)
            radius = tube + fillet - np.sqrt(fillet**2 - beside**2)
        ball = np.sqrt(np.maximum(eye**2 - x**2, 0.0))
        radius = np.where(x <= joint[0], np.maximum(ball, 0.0), radius)
        outside = np.minimum(2 * np.sqrt(np.maximum(radius**2 - y**2, 0.0)), shape.eye_width)
        into = np.clip(x - eye, 0.0, bore)
        hollow = np.where(x > eye, 2 * bore * into - into**2, 0.0)  # radius^2 of the bore there
        return np.asarray(outside - 2 * np.sqrt(np.maximum(hollow - y**2, 0.0)))

    return PlaneOutline(draw, thickness, bores(holes, [shape.eye_width] * 2), 0.0)


def prismatic_tube(shape: PrismaticTube) -> PlaneOutline:
    """A square tube: two walls in the middle, side walls seen edgewise."""
    half, inner = shape.width / 2, shape.width / 2 - shape.wall

    def draw(gmsh: Any) -> Drawn:
        occ = gmsh.model.occ
        plate = occ.addRectangle(0, -half, 0, shape.length, shape.width)
        lines = [line(gmsh, 0, side * inner, shape.length, side * inner) for side in (-1, 1)]
        occ.fragment([(2, plate)], lines)
        occ.synchronize()
        ends = {"start": 0.0, "end": shape.length}
        named = {name: curves_in_box(gmsh, (x, x), (-half, half)) for name, x in ends.items()}
        return Drawn(named, shape.width / 5, [])

    def thickness(points: FloatArray) -> FloatArray:
        return _square_tube_depth(np.abs(points[:, 1]), shape.width, shape.wall, shape.inner_radius)

    faces = [
        Interface(name, "face", np.array([x, 0.0, 0.0]))
        for name, x in (("start", 0.0), ("end", shape.length))
    ]
    return PlaneOutline(draw, thickness, faces, half, seams="wall")


def _square_tube_depth(y: FloatArray, width: float, wall: float, radius: float) -> FloatArray:
    """Material along z of a square tube at the distance y >= 0 from its middle, mm."""
    inner = width / 2 - wall
    into = np.clip((y - (inner - radius)) / radius, 0.0, 1.0) if radius else np.zeros_like(y)
    between = 2 * wall + 2 * radius * (1 - np.sqrt(1 - into**2))
    return np.where(y > inner, width, between)
