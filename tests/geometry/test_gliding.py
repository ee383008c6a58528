"""Nodes that move along the faces and edges of a CAD body, and no others."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry import meshing
from geometry.curving import Gliding
from geometry.meshing import gmsh_session


@pytest.fixture
def cylinder():
    """A cylinder of radius 5, meshed coarsely: all nodes, and how those move that may."""
    with gmsh_session() as gmsh:
        gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 12, 5)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 4)
        gmsh.model.mesh.generate(3)
        _, nodes, index = meshing._nodes(gmsh)
        gliding = Gliding(gmsh, nodes, index, np.arange(len(nodes)))
        random = np.random.default_rng(1)
        moves = random.normal(scale=0.1, size=(len(gliding.moving), 3))
        yield nodes, gliding, moves


def test_all_but_corners_of_the_body_may_move(cylinder):
    nodes, gliding, _ = cylinder
    left = np.setdiff1d(np.arange(len(nodes)), gliding.moving)
    assert_allclose(sorted(nodes[left].tolist()), [[5, 0, 0], [5, 0, 12]], atol=1e-9)


def test_nodes_on_the_surface_stay_on_it_and_go_as_far_as_asked(cylinder):
    nodes, gliding, moves = cylinder
    before, after = nodes[gliding.moving], gliding.places(moves)[0]
    round_, flat = np.isclose(np.hypot(*before[:, :2].T), 5), np.isclose(before[:, 2] % 12, 0)
    assert_allclose(np.hypot(*after[round_, :2].T), 5, rtol=1e-12)
    assert_allclose(after[flat, 2], before[flat, 2], atol=1e-12)
    inside = ~round_ & ~flat
    assert_allclose(after[inside], (before + moves)[inside])
    way = np.linalg.norm(after - before, axis=1)
    face = flat & ~round_
    assert_allclose(way[face], np.linalg.norm(moves[face, :2], axis=1), rtol=1e-9)
    seam = np.isclose(before[:, 0], 5)  # an edge of the face
    bent = round_ & ~flat & ~seam
    assert_allclose(way[bent], np.linalg.norm(moves[bent, :2], axis=1), rtol=1e-2)
    assert_allclose(way[round_ & flat], np.abs(moves[round_ & flat, 0]), rtol=1e-2)


def test_slopes_are_those_of_the_places(cylinder):
    _, gliding, moves = cylinder
    step = 1e-6
    _, slopes = gliding.places(moves)
    for k in range(3):
        aside = np.zeros(3)
        aside[k] = step
        change = gliding.places(moves + aside)[0] - gliding.places(moves - aside)[0]
        assert_allclose(slopes[:, :, k], change / (2 * step), atol=1e-8)


def test_nodes_of_a_face_that_gmsh_cannot_follow_stay():
    class Lost:
        def __init__(self, gmsh):
            self.mesh, self.getEntities = gmsh.model.mesh, gmsh.model.getEntities

        def getParametrization(self, dimension, tag, places):
            raise Exception("no")

    with gmsh_session() as gmsh:
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
        gmsh.model.mesh.generate(3)
        _, nodes, index = meshing._nodes(gmsh)
        lost = type("Gmsh", (), {"model": Lost(gmsh)})()
        moving = Gliding(lost, nodes, index, np.arange(len(nodes))).moving
    assert len(moving) > 0
    assert ((nodes[moving] > 1e-9) & (nodes[moving] < 1 - 1e-9)).all()
