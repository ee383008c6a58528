"""Mass, interfaces and skin of parts that are not meshed."""

from math import pi

import numpy as np
import pytest

from geometry.cad_body import cad_body, cad_skin
from geometry.mesh import TooFineError
from geometry.meshing import mesh_shape
from geometry.parts import LeafPack, PlateLink, TubeRod

from .bars import PRESS_BAR, RHS_120

LINK = PlateLink(length=100.0, width=20.0, thickness=10.0, hole=10.0)
PACK = LeafPack(
    length=460.0,
    leaves=3,
    width=60.0,
    thickness=9.6,
    arm=453.5,
    overhang=26.5,
    clamp_length=80.0,
    rod_length=40.0,
    contact_from=426.0,
    contact_to=448.5,
    contact_length=10.0,
)
ROD = TubeRod(
    length=300.0,
    tube_diameter=20.0,
    wall=3.0,
    eye_diameter=36.0,
    eye_width=24.0,
    hole=16.0,
    fillet=10.0,
)


@pytest.fixture(scope="module")
def link():
    return cad_body(LINK)


def test_the_volume_of_a_link_is_its_outline_less_its_holes(link):
    by_hand = (100.0 * 20.0 + pi * 10.0**2 - 2 * pi * 5.0**2) * 10.0
    assert link.volume == pytest.approx(by_hand, rel=1e-5)
    assert link.centre == pytest.approx([50.0, 0.0, 0.0], abs=1e-4)


def test_the_second_moment_of_a_link_is_that_of_its_pieces(link):
    bar = 100.0 * 20.0 * (100.0**2 + 20.0**2) / 12
    arm = 4 * 10.0 / (3 * pi)  # centre of a half disc from its diameter
    half = pi * 10.0**2 / 2
    ends = 2 * (half * 10.0**2 / 2 - half * arm**2 + half * (50.0 + arm) ** 2)
    holes = 2 * pi * 5.0**2 * (5.0**2 / 2 + 50.0**2)
    assert link.second == pytest.approx((bar + ends - holes) * 10.0, rel=1e-5)


@pytest.mark.parametrize("shape", [PRESS_BAR, PACK], ids=["bar", "leaves"])
def test_mass_properties_are_those_of_a_mesh(shape):
    known = cad_body(shape).mass_properties(7.85e-9)
    meshed = mesh_shape(shape, fineness=0.7).mass_properties(7.85e-9)
    # the coarse mesh cuts the bar's inner corners: 2.1e-4 of it, 1e-5 at fineness 2.5
    assert known.mass == pytest.approx(meshed.mass, rel=4e-4)
    assert known.centre == pytest.approx(meshed.centre, abs=0.05)
    assert known.inertia == pytest.approx(meshed.inertia, rel=4e-4)


def test_interfaces_are_those_of_a_mesh(link):
    meshed = mesh_shape(LINK, fineness=0.5).interfaces
    assert list(link.interfaces) == list(meshed)
    assert link.interfaces["second"].radius == meshed["second"].radius


def test_the_skin_is_closed():
    skin = cad_skin(LINK)
    sides = np.sort(skin.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, counts = np.unique(sides, axis=0, return_counts=True)
    assert (counts == 2).all()
    assert np.abs(skin.nodes[:, 0]).max() == pytest.approx(110.0, rel=1e-6)


@pytest.mark.parametrize(
    "shape", [LINK, PRESS_BAR, PACK, ROD], ids=["link", "bar", "leaves", "rod"]
)
def test_the_skin_looks_outwards_and_holds_the_volume(shape):
    """By Gauss: a third of the flux of the place vector. The rod's bore is a cavity of its own."""
    body, skin = cad_body(shape), cad_skin(shape)
    corners = skin.nodes[skin.triangles]
    held = np.einsum("ij,ij->", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2]) / 6
    # the chords of 20 facets on a turn cut off 2 pi^2 / (3 n^2)
    assert held == pytest.approx(body.volume, rel=2 * pi**2 / (3 * 20**2))


def test_the_skin_has_only_the_faces_of_the_solid():
    """The rod is revolved about z and turned into x; its outline stays behind, and is no skin."""
    nodes = cad_skin(ROD).nodes
    assert np.abs(nodes[:, 2]).max() == pytest.approx(12.0)
    assert nodes[:, 0].min() == pytest.approx(-18.0, abs=0.3)
    assert nodes[:, 0].max() == pytest.approx(318.0, abs=0.3)


@pytest.mark.parametrize(
    "shape", [LINK, PRESS_BAR, PACK, ROD], ids=["link", "bar", "leaves", "rod"]
)
def test_the_size_is_that_of_the_skin(shape):
    """Chords of 20 facets on a turn end short of an eye by 1 - cos(pi / 20) of its radius."""
    drawn = np.ptp(cad_skin(shape).nodes, axis=0).max()
    assert drawn <= cad_body(shape).size * (1 + 1e-6)
    assert drawn == pytest.approx(cad_body(shape).size, rel=5e-3)


def test_small_rounded_corners_take_few_triangles():
    """The bar's corners of 3 mm along 330 mm took three quarters of 22 600 triangles."""
    assert len(cad_skin(PRESS_BAR).triangles) < 8000


def test_corners_along_a_slender_part_take_longer_facets_before_its_picture_is_refused(monkeypatch):
    """An arm of 50 x 30 x 2.6 mm, 1900 mm long, was refused whatever model it was checked by."""
    finest = len(cad_skin(RHS_120).triangles)
    for module in ("geometry.cad_body", "geometry.sizing"):
        monkeypatch.setattr(f"{module}.MOST_TRIANGLES", 12000)
    drawn = cad_skin(RHS_120)
    assert len(drawn.triangles) < 0.8 * finest
    x, y = drawn.nodes[:, 0], drawn.nodes[:, 1]
    assert (np.abs(np.hypot(x, y) - 15.0) < 1e-6).sum() >= 20  # the bore is as round as it was
    with pytest.raises(TooFineError, match="faces would need about"):
        cad_skin(RHS_120, 32)  # sections are cut from it
