"""Meshes of the parts: repeatable, of the CAD body's volume, with the surfaces they claim."""

import hashlib
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from signal import SIGPIPE
from threading import Thread

import numpy as np
import pytest
from numpy.testing import assert_allclose

from geometry import meshing
from geometry.curving import moved
from geometry.mesh import Interface, Mesh, MeshError, boundary_facets
from geometry.meshing import gmsh_session, mesh_shape
from geometry.parts import Pin, PlateLink, PrismaticTube, Seat, ToggleBar
from geometry.shape import Body

from .facets import area

ROOT = Path(__file__).parents[2]
STEEL = 7.85e-9
BAR = ToggleBar(
    length=250,
    width=80,
    wall=6.3,
    hole=44,
    overhang=40,
    inner_radius=3,
    cutout_length=56,
    cutout_corner=5,
)
TUBE = PrismaticTube(length=60, width=13, wall=1.6)
PIN = Pin(
    seats=(Seat("lug", at=20, width=6), Seat("eye", width=20, diameter=16)),
    diameter=20,
    step_fillet=1.2,
)


@pytest.fixture(scope="module")
def bar():
    return mesh_shape(BAR, fineness=0.4)


@pytest.fixture(scope="module")
def pin():
    return mesh_shape(PIN, fineness=0.5)


@pytest.fixture(scope="module")
def tube():
    return mesh_shape(TUBE, fineness=0.7)


def test_the_same_part_gives_the_same_mesh_to_the_last_bit(pin):
    again = mesh_shape(PIN, fineness=0.5)
    assert np.array_equal(pin.nodes, again.nodes)
    assert np.array_equal(pin.elements, again.elements)
    for name, facets in pin.surfaces.items():
        assert np.array_equal(facets, again.surfaces[name])


def test_a_finer_mesh_has_more_elements(tube):
    assert len(tube.elements) > 1.5 * len(mesh_shape(TUBE, fineness=0.5).elements)


def test_the_toggle_bar_weighs_what_its_plates_add_up_to(bar):
    """Tube less holes and cut-out, in closed form for sharp corners: 4.137 kg; the rounded inner
    corners add 0.4 %. The mesh's volume differs from the CAD body's by up to 1e-3, measured 2e-4.
    """
    area_tube, sides = 80**2 - 67.4**2, 2 * 67.4 * 6.3
    sharp = (area_tube * 330 - sides * 56 - 4 * np.pi * 22**2 * 6.3) * STEEL * 1e3
    assert_allclose(sharp, 4.137, atol=5e-4)
    properties = bar.mass_properties(STEEL)
    assert_allclose(properties.mass * 1e3, 4.155, atol=0.0045)
    assert 1.003 < properties.mass * 1e3 / sharp < 1.006


def test_the_toggle_bar_balances_behind_its_middle(bar):
    """The cut-out takes 0.37 kg at the knee: the centre moves 12.4 mm to the other end.

    The sides removed: 56 mm long, their middle 137 mm from mid-length.
    """
    properties = bar.mass_properties(STEEL)
    assert_allclose(properties.centre, [125 + 12.4, 0, 0], atol=0.05)
    assert 0.0350 < properties.inertia * 1e-3 < 0.0352


def test_a_tube_has_the_mass_properties_of_its_formula(tube):
    """Plane faces: nothing but round-off, 1e-12."""
    area_, inertia = 72.96, (13**4 - 9.8**4) / 12
    properties = tube.mass_properties(STEEL)
    assert_allclose(properties.mass, STEEL * area_ * 60, rtol=1e-12)
    assert_allclose(properties.centre, [30, 0, 0], atol=1e-10)
    expected = STEEL * (60 * inertia + area_ * 60**3 / 12)
    assert_allclose(properties.inertia, expected, rtol=1e-12)


@pytest.mark.parametrize("name", ["bar", "pin", "tube"])
def test_a_mesh_fills_its_cad_body_and_no_element_is_folded(name, request):
    """Facets on round faces leave out up to 1e-3 of the volume, the limit of Mesh itself."""
    mesh = request.getfixturevalue(name)
    assert_allclose(mesh.volume, mesh.volume_cad, rtol=1e-3)
    assert mesh.jacobian_minimum > 0


def test_bores_have_the_area_of_their_cylinders(bar):
    """Pi d t, both cheeks. Quadratic facets around a circle: 1e-4 at this size."""
    for name in ("knee", "end"):
        assert_allclose(area(bar, bar.surfaces[name]), np.pi * 44 * 2 * 6.3, rtol=1e-4)
        facets = bar.nodes[bar.surfaces[name]] - bar.interfaces[name].centre
        assert_allclose(np.hypot(facets[..., 0], facets[..., 1]), 22, rtol=1e-2)


def test_journals_of_a_pin_have_the_area_of_their_cylinders(pin):
    """A pair of lugs counts twice, a neck with its own diameter. Coarser than a bore: 1e-3."""
    assert_allclose(area(pin, pin.surfaces["lug"]), np.pi * 20 * 2 * 6, rtol=1e-3)
    assert_allclose(area(pin, pin.surfaces["eye"]), np.pi * 16 * 20, rtol=1e-3)
    assert pin.interfaces["lug"].length == 12
    assert pin.interfaces["eye"].radius == 8


def test_end_faces_of_a_tube_have_the_area_of_its_section(tube):
    """Plane faces: round-off."""
    for name, x in (("start", 0.0), ("end", 60.0)):
        assert_allclose(area(tube, tube.surfaces[name]), 72.96, rtol=1e-10)
        assert_allclose(tube.nodes[tube.surfaces[name]][..., 0], x, atol=1e-9)


def test_the_boundary_is_closed(tube):
    """Outer and inner walls and both ends: 4 x 60 x (13 + 9.8) + 2 x 72.96."""
    facets = boundary_facets(tube.elements)
    assert_allclose(area(tube, facets), 4 * 60 * 22.8 + 2 * 72.96, rtol=1e-10)
    assert_allclose(np.sort(tube.surface_nodes), np.unique(facets))


@pytest.mark.parametrize("fillet", [0.0, 1.2], ids=["sharp", "filleted"])
def test_a_stepped_pin_has_the_profile_of_its_stack(fillet):
    """Cylinders: pi/4 (20^2 x 36 + 16^2 x 20). A fillet stands in the shoulder of the thick part,
    beyond the lug, so that the neck keeps its length: it takes a ring off at both shoulders, less
    what stays under its arc.
    """
    shape = replace(PIN, step_fillet=fillet)
    with gmsh_session() as gmsh:
        shape.build(gmsh)
        volume = sum(gmsh.model.occ.getMass(*solid) for solid in gmsh.model.getEntities(3))
    sharp = np.pi / 4 * (400 * (shape.length - 20) + 256 * 20)
    if fillet:
        ring = 2 * np.pi / 4 * (400 - 256) * fillet
        spandrel, centroid = (1 - np.pi / 4) * fillet**2, 8 + 0.2234 * fillet
        kept = 2 * 2 * np.pi * centroid * spandrel  # Pappus; 0.2234 has four digits
        assert_allclose(volume, sharp - ring + kept, rtol=1e-5)
    else:
        assert_allclose(volume, sharp, rtol=1e-6)


def one_element(**changes):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    pairs = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
    nodes = np.vstack([corners, [(corners[i] + corners[j]) / 2 for i, j in pairs]])
    given = {
        "nodes": nodes,
        "elements": np.arange(10)[None],
        "surfaces": {},
        "interfaces": {},
        "volume_cad": 1 / 6,
    }
    return Mesh(**(given | changes))


def test_one_element_is_a_mesh():
    """The unit tetrahedron: 1/6, exact for the degree-4 rule."""
    assert_allclose(one_element().volume, 1 / 6, rtol=1e-14)


def test_a_folded_element_is_refused():
    nodes = one_element().nodes.copy()
    nodes[4] = [0.9, 0.0, 0.0]  # a mid-side node beyond the quarter point folds the edge
    with pytest.raises(MeshError, match="folded"):
        one_element(nodes=nodes)


def test_an_inside_out_element_is_refused():
    with pytest.raises(MeshError, match="folded"):
        one_element(elements=np.array([[0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"nodes": np.zeros((10, 2))}, r"shape \(n, 3\)"),
        ({"elements": np.zeros((0, 10), dtype=int)}, "n > 0"),
        (
            {"interfaces": {"bore": Interface("bore", "bore", np.zeros(3))}},
            "without a surface: bore",
        ),
        ({"volume_cad": 0.2}, "limit 1e-3"),
    ],
)
def test_a_mesh_that_contradicts_itself_is_refused(changes, says):
    with pytest.raises(MeshError, match=says):
        one_element(**changes)


def test_a_node_that_no_element_uses_is_refused():
    with pytest.raises(MeshError, match="1 nodes belong to no element"):
        one_element(nodes=np.vstack([one_element().nodes, [[9.0, 9.0, 9.0]]]))


class Boxes:
    """Boxes of 10 mm, 15 mm apart, whose surface "face" is a face or nothing."""

    def __init__(self, count, faces=()):
        self.count, self.faces = count, faces

    def build(self, gmsh):
        for k in range(self.count):
            gmsh.model.occ.addBox(15 * k, 0, 0, 10, 10, 10)
        gmsh.model.occ.synchronize()
        return Body({"face": list(self.faces)}, [], 5.0, [])


def test_two_solids_are_refused():
    with pytest.raises(MeshError, match="one solid, the CAD kernel built 2"):
        mesh_shape(Boxes(2, [1]))


def test_a_surface_without_a_face_is_refused():
    with pytest.raises(MeshError, match="no face of the body was found for surface 'face'"):
        mesh_shape(Boxes(1))


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc tells it")
def test_a_pipe_without_a_reader_stays_an_error_in_every_thread():
    """gmsh lets SIGPIPE end the process: without a word, once a process that draws has died."""
    ignored = []

    def look():
        with gmsh_session():
            status = Path("/proc/self/status").read_text()
        ignored.append(int(re.search(r"SigIgn:\s*(\w+)", status)[1], 16) >> SIGPIPE - 1 & 1)

    look()
    thread = Thread(target=look)
    thread.start()
    thread.join()
    assert ignored == [1, 1]


def test_a_shape_that_gmsh_cannot_build_is_a_mesh_error():
    class Broken:
        def build(self, gmsh):
            gmsh.model.occ.addBox(0, 0, 0, 0, 0, 0)
            raise AssertionError("gmsh accepted a box of no size")

    with pytest.raises(MeshError, match="gmsh could not mesh the part"):
        mesh_shape(Broken())


def test_a_mesh_that_hxt_folds_is_made_by_the_other_mesher_and_says_so(monkeypatch):
    """Without the repair of curved elements HXT folds this pin at its fillets."""
    made = []

    def without_repair_by_hxt(*given):
        mesher = given[-2]
        made.append(mesher)
        repair = (lambda _: None) if mesher == "HXT" else mend
        monkeypatch.setattr(meshing, "_mend", repair)
        return mesh_with(*given)

    mesh_with, mend = meshing._mesh_with, meshing._mend
    monkeypatch.setattr(meshing, "_mesh_with", without_repair_by_hxt)
    mesh = mesh_shape(replace(PIN, step_fillet=1.0), fineness=0.5)
    assert made == ["HXT", "Delaunay, because HXT folded an element"]
    assert mesh.mesher == made[1]
    assert mesh.jacobian_minimum > 0


CROWDED = PlateLink(length=50.0, width=30.0, thickness=8.0, hole=14.0, second_hole=8.0)


def test_a_mesh_for_which_hxt_would_leave_its_memory_is_made_by_the_other_mesher(monkeypatch):
    """9053 tetrahedra and a batch of 8182 free ones, where HXT has reserved 17 102.

    Such a mesh depends on what stood in the memory, or the process ends (gmsh 4.15.2).
    """
    optimised = []
    generate = meshing._generate

    def watched(gmsh, *, hxt):
        optimised.append(hxt)
        generate(gmsh, hxt=hxt)

    monkeypatch.setattr(meshing, "_generate", watched)
    mesh = mesh_shape(CROWDED, fineness=0.7)
    assert mesh.mesher == "Delaunay, because HXT would write outside of its memory"
    assert optimised == [False]


def test_a_mesh_that_hxt_fills_with_flat_elements_is_made_by_the_other_mesher(monkeypatch):
    """The pin of the press at a third of its fineness, whose fillets are 1 mm on elements of 20 mm.

    HXT's optimisation would take 26 s for a mesh with 42 % of flat elements, the other mesher 0.7 s
    for one with 0.1 %.
    """
    optimised, flat = [], []
    generate = meshing._generate

    def watched(gmsh, *, hxt):
        optimised.append(hxt)
        generate(gmsh, hxt=hxt)
        tags, _ = gmsh.model.mesh.getElementsByType(11)
        flat.append(np.mean(np.asarray(gmsh.model.mesh.getElementQualities(tags, "gamma")) < 0.1))

    monkeypatch.setattr(meshing, "_generate", watched)
    seats = Seat("upper", at=42.95, width=6.3), Seat("lower", at=32.65, width=6.3)
    pin = Pin(
        seats=(*seats, Seat("cylinder", width=43, diameter=35)),
        diameter=40,
        step_fillet=1.0,
        overhang=5,
    )
    mesh = mesh_shape(pin, fineness=0.38)
    assert mesh.mesher == "Delaunay, because HXT leaves 64% of the elements flat"
    assert optimised == [False]
    assert flat[0] < 0.01


MESHED_AGAIN = """
import hashlib
from dataclasses import replace
from geometry.meshing import mesh_shape
from tests.geometry.test_meshes import PIN

held = [bytes(977 * k) for k in range(5000)]  # so that what follows has other addresses
nodes = mesh_shape(replace(PIN, step_fillet=1.0), fineness=0.7).nodes
print(len(nodes), hashlib.sha256(nodes.tobytes()).hexdigest())
"""


@pytest.fixture(scope="module")
def mended():
    """A mesh in whose fillets elements fold unless nodes on the surface move, and those moved."""
    moves = []

    def watched(nodes, elements, gliding):
        found = moved(nodes, elements, gliding)
        moves.append(np.flatnonzero((found != nodes).any(axis=1)))
        assert set(moves[-1]) <= set(gliding.moving)
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(meshing, "moved", watched)
        return mesh_shape(replace(PIN, step_fillet=1.0), fineness=0.7), moves


@pytest.mark.slow
def test_a_mesh_with_mended_elements_is_the_same_in_every_process(mended):
    """Here beside all that this process has done, there in a new one with other addresses."""
    told = subprocess.run(
        [sys.executable, "-c", MESHED_AGAIN],
        capture_output=True, text=True, check=True, cwd=ROOT,
    ).stdout  # fmt: skip
    nodes = mended[0].nodes
    assert told.split() == [str(len(nodes)), hashlib.sha256(nodes.tobytes()).hexdigest()]


def test_mended_elements_leave_the_surface_where_it_is(mended):
    """Nodes on the pin's cylinders keep their radius, those on its fillets their torus."""
    mesh, moves = mended
    assert sum(len(some) for some in moves) > 0
    assert mesh.jacobian_minimum > 0.1
    x, y, z = mesh.nodes[np.unique(mesh.facets)].T
    radius = np.hypot(x, y)
    ends = np.isclose(z, z.min(), atol=1e-9) | np.isclose(z, z.max(), atol=1e-9)
    steps = np.isclose(np.abs(z), 11, atol=1e-9)
    small, large = np.isclose(radius, 8, atol=1e-8), np.isclose(radius, 10, atol=1e-8)
    fillets = np.isclose(np.hypot(radius - 9, np.abs(z) - 10), 1, atol=1e-8)
    assert (ends | steps | small | large | fillets).all()
    assert fillets.any()


@pytest.mark.parametrize("fineness", [0.0, -1.0, float("nan")])
def test_a_fineness_that_is_not_above_zero_is_refused(fineness):
    with pytest.raises(ValueError, match="fineness must be above 0"):
        mesh_shape(TUBE, fineness=fineness)
