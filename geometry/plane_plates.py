"""Plates and leaves as sheets: what they look like along z, and how thick they are where."""

from math import pi
from typing import Any

import numpy as np

from geometry.mesh import FloatArray, Interface
from geometry.meshing import Region
from geometry.parts import LeafPack, PlateLink, SlottedLever
from geometry.plane_drawing import (
    AROUND,
    bores,
    curves_in_box,
    curves_on_circle,
    disks,
    drawn,
    even,
    stadium,
)
from geometry.plane_outlines import Drawn, PlaneOutline


def plate_link(shape: PlateLink) -> PlaneOutline:
    """A flat link: even thickness, holes whose pins tilt."""
    second = shape.hole if shape.second_hole is None else shape.second_hole
    holes = [("first", 0.0, shape.hole), ("second", shape.length, second)]

    def draw(gmsh: Any) -> Drawn:
        half = shape.width / 2
        plate = stadium(gmsh, -half, shape.length + half, shape.width)
        gmsh.model.occ.cut([(2, plate)], disks(gmsh, holes))
        gmsh.model.occ.synchronize()
        return drawn(gmsh, holes, shape.width / 5)

    return PlaneOutline(
        draw, even(shape.thickness), bores(holes, [shape.thickness] * 2, tilts=True)
    )


def slotted_lever(shape: SlottedLever) -> PlaneOutline:
    """A slotted lever: thicker in the boss, and by its fillet in a ring about it."""
    holes = [("pivot", 0.0, shape.hole), ("tip", shape.length, shape.hole)]
    depths = [shape.thickness, shape.thickness + 2 * shape.boss_height]
    half = shape.slot_width / 2
    ends = (shape.slot_from + half, shape.slot_to - half)
    boss, foot = (shape.boss_diameter or 0.0) / 2, shape.boss_fillet

    def draw(gmsh: Any) -> Drawn:
        occ = gmsh.model.occ
        solid = [(2, _lever_plate(gmsh, shape))]
        if boss:
            radii = [boss, *([boss + foot] if foot else [])]
            rounds = [(2, occ.addDisk(shape.length, 0, 0, radius, radius)) for radius in radii]
            solid, _ = occ.fragment(solid, rounds)
        slot = stadium(gmsh, shape.slot_from, shape.slot_to, shape.slot_width)
        occ.cut([e for e in solid if e[0] == 2], [*disks(gmsh, holes), (2, slot)])
        occ.synchronize()
        flanks = {
            f"slot{sign}": curves_in_box(gmsh, ends, (side * half, side * half))
            for sign, side in (("+", 1.0), ("-", -1.0))
        }
        round_ends = [tag for x in ends for tag in curves_on_circle(gmsh, x, 0.0, half)]
        near = [
            Region([(1, tag) for tag in round_ends], 2 * pi * half / AROUND, half),
            Region(
                [(1, tag) for tags in flanks.values() for tag in tags],
                (shape.width - shape.slot_width) / 4,
                half,
            ),
        ]
        if boss:
            rings = [tag for r in radii for tag in curves_on_circle(gmsh, shape.length, 0.0, r)]
            near.append(Region([(1, tag) for tag in rings], boss / 5, boss))
        edges = {**flanks, "slot end": round_ends}
        return drawn(gmsh, holes, (shape.width - shape.slot_width) / 2, near, edges)

    def thickness(points: FloatArray) -> FloatArray:
        depth = np.full(len(points), shape.thickness)
        if not boss:
            return depth
        away = np.hypot(points[:, 0] - shape.length, points[:, 1])
        depth[away < boss] += 2 * shape.boss_height
        ring = (away >= boss) & (away < boss + foot)
        down = (boss + foot - away[ring]) / (foot or 1.0)
        depth[ring] += 2 * foot * (1 - np.sqrt(1 - down**2))
        return depth

    named = {interface.name: interface for interface in bores(holes, depths, tilts=True)}
    patch = (shape.slot_width if shape.contact_length is None else shape.contact_length) / 2
    low = ends[0] + patch if shape.travel_from is None else shape.travel_from
    high = ends[1] - patch if shape.travel_to is None else shape.travel_to
    slide = Interface(
        "slot", "slide", np.zeros(3), length=shape.thickness, travel=(low, high), patch=patch
    )
    return PlaneOutline(draw, thickness, [*named.values(), slide], seams="boss")


def _lever_plate(gmsh: Any, shape: SlottedLever) -> int:
    if shape.overhang is None:
        half = shape.width / 2
        return stadium(gmsh, -half, shape.length + half, shape.width)
    total = shape.length + 2 * shape.overhang
    return int(
        gmsh.model.occ.addRectangle(-shape.overhang, -shape.width / 2, 0, total, shape.width)
    )


def leaf_pack(shape: LeafPack) -> PlaneOutline:
    """A leaf pack from the side: as thick as the leaves are wide, each with its own nodes."""
    patch = shape.contact_length / 2
    spans = {
        "pivot": (-shape.clamp_length / 2, shape.clamp_length / 2),
        "rod": (shape.length - shape.rod_length / 2, shape.length + shape.rod_length / 2),
        "contact": (-shape.contact_to - patch, -shape.contact_from + patch),
    }
    levels = shape.thickness * (np.arange(shape.leaves + 1) - shape.leaves / 2)
    total = shape.arm + shape.length + shape.overhang

    def draw(gmsh: Any) -> Drawn:
        occ = gmsh.model.occ
        leaves = [
            (2, occ.addRectangle(-shape.arm, y, 0, total, shape.thickness)) for y in levels[:-1]
        ]
        marks = [
            (0, occ.addPoint(x, y, 0))
            for y in levels[[0, -1]]
            for span in spans.values()
            for x in span
        ]
        marks += [(0, occ.addPoint(0.0, y, 0)) for y in levels[1:-1]]
        occ.fragment(leaves, marks)
        occ.synchronize()
        bottom, top = ((float(y), float(y)) for y in levels[[0, -1]])
        named = {
            name: curves_in_box(gmsh, spans[name], bottom) + curves_in_box(gmsh, spans[name], top)
            for name in ("pivot", "rod")
        }
        named["contact+"] = curves_in_box(gmsh, spans["contact"], bottom)
        named["contact-"] = curves_in_box(gmsh, spans["contact"], top)
        near = Region([(1, tag) for tag in named["pivot"]], shape.thickness / 2, shape.thickness)
        return Drawn(named, shape.thickness, [near])

    interfaces = [
        Interface("pivot", "clamp", np.zeros(3), length=shape.width),
        Interface("rod", "clamp", np.array([shape.length, 0.0, 0.0]), length=shape.width),
        Interface(
            "contact",
            "slide",
            np.zeros(3),
            length=shape.width,
            travel=(-shape.contact_to, -shape.contact_from),
            patch=patch,
        ),
    ]
    return PlaneOutline(
        draw, even(shape.width), interfaces, 0.0, stacked=True, bolted_at=0.0, seams="leaf"
    )
