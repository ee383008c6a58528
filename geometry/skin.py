"""The skin of solids as flat triangles, each seen from outside counter-clockwise."""

from typing import Any

import numpy as np

from geometry.mesh import FloatArray, IntArray


def skin_of(gmsh: Any) -> tuple[FloatArray, IntArray]:
    """Nodes (n, 3) mm and triangles (m, 3) of the solids' faces, which have been meshed.

    Building may leave faces that bound nothing, such as an outline that was revolved; and the
    kernel's faces look either way, so each solid's are turned by their neighbours.
    """
    tags, places, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    places = places.reshape(-1, 3)
    found = []
    for solid in gmsh.model.getEntities(3):
        faces = [tag for _, tag in gmsh.model.getBoundary([solid], oriented=False)]
        corners = [gmsh.model.mesh.getElementsByType(2, tag)[1] for tag in faces]
        rows = [order[np.searchsorted(tags[order], three)].reshape(-1, 3) for three in corners]
        found.append(outwards([three for three in rows if len(three)], places))
    used, triangles = np.unique(np.concatenate(found), return_inverse=True)
    return places[used], triangles.reshape(-1, 3).astype(np.int64)


def outwards(faces: list[IntArray], places: FloatArray) -> IntArray:
    """Return all triangles (m, 3) of the faces that bound one solid, turned to look outwards.

    faces  (k, 3) each, triangles that look the same way within a face

    Of several closed shells the one that holds most is the outer one, the others are cavities.
    """
    owner = np.repeat(np.arange(len(faces)), [len(three) for three in faces])
    triangles = np.concatenate(faces)
    turned = np.zeros(len(faces), dtype=bool)
    shell = np.full(len(faces), -1)
    neighbours = _neighbours(triangles, owner)
    for first in range(len(faces)):
        if shell[first] >= 0:
            continue
        shell[first], waiting = first, [first]
        while waiting:
            face = waiting.pop()
            for other, against in neighbours[neighbours[:, 0] == face, 1:]:
                if shell[other] < 0:
                    shell[other] = first
                    turned[other] = turned[face] ^ bool(against)
                    waiting.append(int(other))
    corners = places[triangles]
    volumes = np.einsum("ij,ij->i", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2]) / 6
    signed = np.where(turned[owner], -volumes, volumes)
    held = np.bincount(shell[owner], weights=signed, minlength=len(faces))
    outer = int(np.abs(held).argmax())
    inside_out = np.where(np.arange(len(faces)) == outer, held < 0, held > 0)
    turned ^= inside_out[shell]
    return np.asarray(np.where(turned[owner, None], triangles[:, ::-1], triangles))


def _neighbours(triangles: IntArray, owner: IntArray) -> IntArray:
    """Rows (face, other face, 1 if they look against each other), each pair both ways."""
    sides = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    of_side = np.repeat(owner, 3)
    low = np.sort(sides, axis=1)
    order = np.lexsort((low[:, 1], low[:, 0]))
    same = (low[order[1:]] == low[order[:-1]]).all(axis=1)
    one, two = order[:-1][same], order[1:][same]
    pairs = np.column_stack([of_side[one], of_side[two], sides[one, 0] == sides[two, 0]])
    pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    return np.concatenate([pairs, pairs[:, [1, 0, 2]]])
