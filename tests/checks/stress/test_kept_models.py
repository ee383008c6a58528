"""Surfaces that are made beside other work."""

import threading

import numpy as np

from checks.stress import kept_models
from checks.stress.kept_models import Models
from geometry.cad_body import cad_skin
from geometry.meshing import gmsh_session, mesh_shape
from geometry.parts import PlateLink

LINK = PlateLink(length=100.0, width=20.0, thickness=10.0, hole=10.0)


def test_surfaces_are_made_beside_other_work_each_once_and_as_they_would_be_in_turn(monkeypatch):
    made = []

    def noted(store, shape):
        made.append(threading.current_thread())
        return cad_skin(shape)

    monkeypatch.setattr(kept_models, "stored_skin", noted)
    models = Models()
    models.store = None  # which the tests give to all
    models.begin_skins([LINK, LINK])
    mesh = mesh_shape(LINK, fineness=0.5)  # gmsh is asked by both
    skin, again = models.skin(LINK), models.skin(LINK)
    expected = cad_skin(LINK)
    assert again is skin
    assert np.array_equal(skin.nodes, expected.nodes)
    assert np.array_equal(skin.triangles, expected.triangles)
    assert np.array_equal(mesh.nodes, mesh_shape(LINK, fineness=0.5).nodes)
    assert [thread is threading.main_thread() for thread in made] == [False]


def test_gmsh_is_asked_by_one_thread_at_a_time():
    entered = threading.Event()

    def enter():
        with gmsh_session():
            entered.set()

    other = threading.Thread(target=enter)
    with gmsh_session():
        other.start()
        assert not entered.wait(0.3)
    other.join()
    assert entered.is_set()
