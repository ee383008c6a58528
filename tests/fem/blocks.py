"""Rectangular blocks of straight-sided ten-node tetrahedra, and the parts other tests share."""

from itertools import permutations

import numpy as np

from geometry.mesh import TET_EDGES, Interface, Mesh, boundary_facets
from geometry.parts import Pin, PrismaticTube, Seat, ToggleBar

BAR = ToggleBar(
    length=60,
    width=40,
    wall=6,
    hole=16,
    overhang=16,
    inner_radius=2,
    cutout_length=22,
    cutout_corner=3,
)
TUBE = PrismaticTube(length=250, width=13, wall=1.6)
PIN = Pin(seats=(Seat("lug", at=20, width=6), Seat("eye", width=20)), diameter=20)


def block(counts, sizes, *, start=(0.0, 0.0, 0.0), distortion=0.0):
    """Six tetrahedra per brick; end faces "start" and "end" normal to x.

    distortion  how far inner corner nodes are moved at random, in bricks
    """
    counts, sizes, start = np.array(counts), np.array(sizes, dtype=float), np.array(start)
    lattice = counts * 2 + 1
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in lattice), indexing="ij"), axis=-1)
    grid = grid.reshape(-1, 3)

    def index(place):
        return (place[..., 0] * lattice[1] + place[..., 1]) * lattice[2] + place[..., 2]

    bricks = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1)
    bricks = 2 * bricks.reshape(-1, 3)
    elements = []
    for order in permutations(range(3)):
        corners = [np.zeros(3, dtype=int)]
        for axis in order:
            corners.append(corners[-1] + 2 * np.eye(3, dtype=int)[axis])
        if np.linalg.det(np.diff(corners, axis=0)) < 0:
            corners[1], corners[2] = corners[2], corners[1]
        middles = [(corners[i] + corners[j]) // 2 for i, j in TET_EDGES]
        elements.append(np.stack([index(bricks + c) for c in (*corners, *middles)], axis=1))
    elements = np.concatenate(elements)

    places = grid / 2
    if distortion:
        inner = ((grid > 0) & (grid < lattice - 1)).all(axis=1) & (grid % 2 == 0).all(axis=1)
        moves = np.random.default_rng(7).uniform(-distortion, distortion, (inner.sum(), 3))
        places[inner] += moves
    nodes = start + places * sizes / counts
    for k, (i, j) in enumerate(TET_EDGES):
        nodes[elements[:, 4 + k]] = (nodes[elements[:, i]] + nodes[elements[:, j]]) / 2
    facets = boundary_facets(elements)
    surfaces, interfaces = {}, {}
    for name, x in (("start", start[0]), ("end", start[0] + sizes[0])):
        on = np.isclose(nodes[facets][..., 0], x).all(axis=1)
        surfaces[name] = facets[on]
        centre = start + sizes / 2
        centre[0] = x
        interfaces[name] = Interface(name, "face", centre)
    return Mesh(nodes, elements, surfaces, interfaces, float(np.prod(sizes)))


def wrench(fx=0.0, fy=0.0, mz=0.0):
    """One position of an interface's wrench, (1, 6)."""
    return np.array([[fx, fy, 0.0, 0.0, 0.0, mz]])
