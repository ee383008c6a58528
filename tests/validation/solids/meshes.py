"""Meshes of the solid validation cases: mapped bricks of tetrahedra, and bodies meshed by gmsh."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.mesh import TET_EDGES, Mesh, boundary_facets
from geometry.meshing import mesh_shape
from geometry.shape import Body, Region, faces_where

from ...fem.blocks import block

SIDES = ("x0", "x1", "y0", "y1", "z0", "z1")


def mapped(counts, mapping, volume, *, distortion=0.0):
    """A unit cube of counts bricks, six tetrahedra each, mapped; its sides by name.

    All ten nodes of an element stand where `mapping` puts those of the cube, so curved sides
    are met at mid-sides too.

    mapping     (x, y, z) in 0 .. 1 to coordinates; keeps the hand
    volume      of the body
    distortion  how far inner corner nodes are moved at random, in bricks
    """
    cube = block(counts, (1.0, 1.0, 1.0), distortion=distortion)
    places = np.clip(cube.nodes, 0.0, 1.0)
    facets = boundary_facets(cube.elements)
    surfaces = {}
    for k, name in enumerate(SIDES):
        on = np.abs(places[facets][..., k // 2] - k % 2) < 1e-9
        surfaces[name] = facets[on.all(axis=1)]
    nodes = np.stack(np.broadcast_arrays(*mapping(*places.T)), axis=1).astype(float)
    return Mesh(nodes, cube.elements, surfaces, {}, volume)


def ring(counts, inner, outer, height, angle=np.pi / 2):
    """A sector of a thick cylinder about z from y = 0; counts radial, around, along."""

    def mapping(x, y, z):
        radius = inner * (outer / inner) ** x  # elements grow with the radius
        return radius * np.cos(angle * y), radius * np.sin(angle * y), height * z

    return mapped(counts, mapping, angle / 2 * (outer**2 - inner**2) * height)


def on(mesh, *names):
    """Nodes of some sides."""
    return np.unique(np.concatenate([mesh.surfaces[name].ravel() for name in names]))


def split_hexahedra(corners, hexahedra):
    """Six ten-node tetrahedra per hexahedron (8 corners, VTK order), faces matching.

    Every face is cut through its corner of lowest number; the six faces' triangles away from the
    lowest corner of all make the tetrahedra with it.
    """
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    linear = []
    for hexahedron in hexahedra:
        top = min(hexahedron)
        for face in faces:
            cycle = [hexahedron[k] for k in face]
            if top in cycle:
                continue
            first = cycle.index(min(cycle))
            a, b, c, d = cycle[first:] + cycle[:first]
            linear += [(a, b, c, top), (a, c, d, top)]
    linear = np.array(linear)
    edges = corners[linear]
    volume = np.linalg.det(edges[:, 1:] - edges[:, :1])
    linear[volume < 0] = linear[volume < 0][:, [1, 0, 2, 3]]
    nodes, middles, elements = list(corners), {}, []
    for tetrahedron in linear.tolist():
        own = []
        for i, j in TET_EDGES:
            edge = tuple(sorted((tetrahedron[i], tetrahedron[j])))
            if edge not in middles:
                middles[edge] = len(nodes)
                nodes.append((corners[edge[0]] + corners[edge[1]]) / 2)
            own.append(middles[edge])
        elements.append(tetrahedron + own)
    return np.array(nodes), np.array(elements)


@dataclass(frozen=True)
class Cad:
    """A body for `mesh_shape`: a solid, its named faces, and element sizes like a user's.

    make    of gmsh's module, builds the solid; gmsh synchronizes after it
    faces   name -> test of a face's bounding box (6,) and type
    size    general element size
    fine    (name of a face, size, reach) where elements are smaller
    """

    make: Callable
    faces: dict
    size: float
    fine: tuple = ()

    def build(self, gmsh):
        """Build it in gmsh's current model."""
        self.make(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        surfaces = {name: faces_where(gmsh, test) for name, test in self.faces.items()}
        regions = [
            Region([(2, t) for t in surfaces[name]], size, reach) for name, size, reach in self.fine
        ]
        return Body(surfaces=surfaces, interfaces=(), size=self.size, regions=regions)

    def mesh(self, fineness):
        """Mesh it; fineness divides every element size."""
        return mesh_shape(self, fineness=fineness)


def plane_at(axis, value):
    """Test of a face that lies in the plane where this coordinate has this value."""
    return lambda box, _: max(abs(box[axis] - value), abs(box[axis + 3] - value)) < 1e-4


def falls(errors):
    """Whether each error is smaller than the one before."""
    return all(abs(after) < abs(before) for before, after in pairwise(errors))
