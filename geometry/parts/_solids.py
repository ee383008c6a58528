"""Solids that several parts share."""

from typing import Any


def square_tube(
    gmsh: Any, start: float, stop: float, width: float, wall: float, radius: float
) -> int:
    """Tag of a square tube along x from `start` to `stop`; `radius` rounds its inside, mm."""
    occ = gmsh.model.occ
    outer = occ.addBox(start, -width / 2, -width / 2, stop - start, width, width)
    inner = width - 2 * wall
    if radius:
        face = occ.addRectangle(-inner / 2, -inner / 2, start, inner, inner, roundedRadius=radius)
        occ.rotate([(2, face)], 0, 0, start, 0, 1, 0, 1.5707963267948966)
        occ.translate([(2, face)], start, 0, -start)
        bore = [entity for entity in occ.extrude([(2, face)], stop - start, 0, 0) if entity[0] == 3]
        occ.remove([(2, face)])
    else:
        bore = [(3, occ.addBox(start, -inner / 2, -inner / 2, stop - start, inner, inner))]
    solids, _ = occ.cut([(3, outer)], bore)
    return int(solids[0][1])
