"""Unit loads on sheets, and plates in bending."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.plane import PlaneModel
from fem.plane_bending import BentSheet
from fem.plane_bores import acceleration_vectors, direct_bore, plane_loads, plane_resultants
from fem.plane_unit_solutions import solve_plane_loads
from fem.unit_solutions import Elastic
from geometry.mesh import Interface, MeshError
from geometry.meshing import Region
from geometry.parts import LeafPack, PlateLink, PrismaticTube, SlottedLever
from geometry.plane_drawing import curves_in_box, curves_on_circle
from geometry.plane_mesh import PlaneMesh, directed
from geometry.plane_outlines import Drawn, PlaneOutline, mesh_outline
from geometry.plane_shapes import outline_of

STEEL = Elastic(210e3, 0.3, 7.85e-9)
LINK = PlateLink(length=60.0, width=30.0, thickness=8.0, hole=12.0)
LEVER = SlottedLever(
    length=120.0,
    width=30.0,
    thickness=8.0,
    hole=8.0,
    slot_width=12.0,
    slot_from=20.0,
    slot_to=100.0,
)
PACK = LeafPack(
    length=300.0,
    leaves=3,
    width=60.0,
    thickness=10.0,
    arm=250.0,
    overhang=30.0,
    clamp_length=80.0,
    rod_length=40.0,
    contact_from=180.0,
    contact_to=220.0,
    contact_length=10.0,
)
TUBE = PrismaticTube(length=100.0, width=30.0, wall=3.0, inner_radius=2.0)


def model_on(sheet):
    return PlaneModel(sheet.mesh, 210e3, 0.3, "stress", thickness=sheet.thickness)


def loads_on(shape):
    outline = outline_of(shape)
    model = model_on(mesh_outline(outline))
    return model, [plane_loads(model, interface) for interface in outline.interfaces]


def rectangle(n, m, length, width):
    """A sheet of n by m squares halved, over 0 .. length and -width/2 .. width/2."""
    x, y = np.linspace(0, length, 2 * n + 1), np.linspace(-width / 2, width / 2, 2 * m + 1)
    nodes = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(nodes)).reshape(2 * n + 1, 2 * m + 1)
    a, b = number[:-2:2, :-2:2], number[2::2, :-2:2]
    c, d = number[2::2, 2::2], number[:-2:2, 2::2]
    middle = number[1::2, 1::2]
    low, right, top, left = (
        number[1::2, :-2:2],
        number[2::2, 1::2],
        number[1::2, 2::2],
        number[:-2:2, 1::2],
    )
    lower = np.stack([a, b, c, low, right, middle], axis=-1).reshape(-1, 6)
    upper = np.stack([a, c, d, middle, top, left], axis=-1).reshape(-1, 6)
    elements = np.concatenate([lower, upper])
    ends = {}
    for name, row in (("left", number[0]), ("right", number[-1])):
        ends[name] = directed(elements, np.stack([row[:-2:2], row[2::2], row[1::2]], axis=1))
    return PlaneMesh(nodes, elements, ends)


@pytest.mark.parametrize("shape", [LINK, LEVER, TUBE, PACK], ids=lambda s: type(s).__name__)
def test_every_unit_load_has_the_resultant_that_it_stands_for(shape):
    """From the names: cosine and sine are 1 N along x and y, what slides acts at its station.

    Round-off only: sums of some hundred forces of 1 N on arms of up to 300 mm.
    """
    model, units = loads_on(shape)
    for unit in units:
        centre = unit.interface.centre[:2]
        found = plane_resultants(model.mesh.nodes, unit.vectors, centre)
        places = iter(np.linspace(*unit.interface.travel, len(unit.names) // 3).repeat(3))
        for name, resultant in zip(unit.names, found.T, strict=True):
            kind = name.split()[0]
            if unit.interface.kind == "slide":
                place = next(places)
                wanted = {"+": (0, 1, place), "-": (0, -1, -place), "t": (1, 0, 0)}[kind]
            else:
                wanted = {
                    "cos 1": (1, 0, 0),
                    "F_x": (1, 0, 0),
                    "sin 1": (0, 1, 0),
                    "F_y": (0, 1, 0),
                    "couple": (0, 0, 1),
                    "M_z": (0, 0, 1),
                }.get(name, (0, 0, 0))
            assert_allclose(resultant, wanted, rtol=0, atol=1e-10, err_msg=name)


def test_a_contact_between_stations_has_its_force_its_moment_and_its_couple():
    """At a place, force and size that no unit load has; about the slot's centre by hand."""
    model, units = loads_on(LEVER)
    slot = units[2]
    planar, reach = np.array([[30.0, -200.0, -200.0 * 47.3 + 55.0]]), np.array([47.3])
    load = slot.vectors @ slot.coefficients(planar, reach).T
    found = plane_resultants(model.mesh.nodes, load, slot.interface.centre[:2])[:, 0]
    assert_allclose(found, planar[0], rtol=1e-11)


def test_a_sliding_contact_without_its_place_is_refused():
    _, units = loads_on(LEVER)
    with pytest.raises(ValueError, match="'slot' slides: its loads need the place"):
        units[2].coefficients(np.zeros((1, 3)))


def test_a_journal_has_no_loads_in_the_plane():
    model, _ = loads_on(LINK)
    with pytest.raises(MeshError, match="'first' is a 'journal'"):
        plane_loads(model, Interface("first", "journal", np.zeros(3), 6.0, 8.0))


def test_the_series_of_a_bearing_is_near_the_pressure_itself():
    """Both have the same force; what the series misses after n = 4 is at most 0.045 of p0.

    Compared by the nodal forces' pressures: p0 = 2 F / (pi r L), each node has its share of edge.
    """
    model, units = loads_on(LINK)
    unit, force = units[0], np.array([300.0, -400.0])
    direct = direct_bore(model, unit.interface, force)
    series = unit.vectors @ unit.coefficients(np.array([[*force, 0.0]]))[0]
    assert_allclose(
        plane_resultants(model.mesh.nodes, direct[:, None], np.zeros(2))[:, 0],
        [*force, 0.0],
        atol=1e-9,
    )
    pressure = 2 * 500 / (np.pi * 6 * 8)
    largest = 8.0 * (2 / 3) * 2 * np.pi * 6 / 36  # of a node's share of the edge, times thickness
    gap = np.linalg.norm((direct - series).reshape(-1, 2), axis=1).max()
    assert 0.01 * pressure * largest < gap < 0.06 * pressure * largest


def test_a_bore_under_even_pressure_is_stressed_as_lame_has_it():
    """Ring of radii a, b: hoop stress p (b^2 + a^2) / (b^2 - a^2) at the bore (Timoshenko).

    A link whose holes are 60 mm apart is no ring; one with a hole of 4 mm in a plate of 60 mm is,
    within (a/b)^2 = 0.4 %; the mesh has 36 elements around the hole: 1 %.
    """
    outline = outline_of(PlateLink(length=200.0, width=60.0, thickness=8.0, hole=4.0))
    solved = solve_plane_loads(mesh_outline(outline, fineness=2), outline.interfaces, STEEL)
    sheet = solved.sheet
    places = np.searchsorted(sheet.sides[0], sheet.mesh.edge_nodes("first"))
    stress = solved.stress_basis(places, flat=True)[:, :, 0]
    pressure = 1 / (np.pi * 2.0 * 8.0)
    angle = np.arctan2(*sheet.mesh.nodes[sheet.mesh.edge_nodes("first")].T[::-1])
    s, c = np.sin(angle), np.cos(angle)
    hoop = stress[:, 0] * s**2 + stress[:, 1] * c**2 - 2 * s * c * stress[:, 2]
    assert_allclose(hoop, pressure, rtol=0.015)


def test_inertia_is_mass_times_acceleration():
    """A link's mass, and its moment of inertia about the middle of the first bore, by hand.

    m = rho t A; of a stadium about its centre: a rectangle, and two half discs by Steiner.
    """
    model, _ = loads_on(LINK)
    found = plane_resultants(
        model.mesh.nodes, acceleration_vectors(model, STEEL.density), np.zeros(2)
    )
    r, hole, length, unit = 15.0, 6.0, 60.0, STEEL.density * 8.0
    mass = unit * (length * 2 * r + np.pi * r**2 - 2 * np.pi * hole**2)
    half, away = np.pi * r**2 / 2, 4 * r / (3 * np.pi)
    rounds = 2 * (half * r**2 / 2 - half * away**2 + half * (length / 2 + away) ** 2)
    flat = length * 2 * r * (length**2 + 4 * r**2) / 12
    holes = 2 * (np.pi * hole**4 / 2 + np.pi * hole**2 * (length / 2) ** 2)
    inertia = unit * (flat + rounds - holes) + mass * (length / 2) ** 2
    wanted = [
        [-mass, 0, 0, mass * length / 2],
        [0, -mass, -mass * length / 2, 0],
        [0, -mass * length / 2, -inertia, 0],
    ]
    # quadratic sides follow the outer circles of 16 pieces to some 1e-4 of their area
    assert_allclose(found, wanted, rtol=1e-4, atol=1e-9 * inertia)


def test_loads_in_balance_need_no_support():
    """A link pulled at both ends: the six reactions are round-off of 1000 N."""
    outline = outline_of(LINK)
    solved = solve_plane_loads(mesh_outline(outline), outline.interfaces, STEEL)
    pull = np.array([[-1000.0, 50, 0, 0, 0, 0]])
    other = np.array([[1000.0, -50, 0, 0, 0, 50.0 * 60]])
    coefficients, added = solved.coefficients(
        {"first": pull, "second": other}, np.zeros((1, 4)), {}, "first", flat=True
    )
    assert np.abs(solved.reactions(coefficients)).max() < 1e-8
    assert np.abs(added).max() * 1e-4 < 1e-8  # the link weighs 1e-4 t


# plates in bending --------------------------------------------------------------------------------


def bent(mesh, thickness, tractions, poisson=0.3):
    model = PlaneModel(mesh, 210e3, poisson, "stress", thickness=thickness)
    plate = BentSheet(model)
    moved, reactions = plate.solve(plate.couples(model.loads(tractions)[:, None]))
    return plate, moved, reactions


def test_a_strip_in_pure_bending_has_the_stress_and_deflection_of_beams():
    """M = 1000 N mm: 6 M / (b t^2) all over, w = M x (L - x) / (2 E I) along the middle.

    Curvature is constant, so quadratic elements hold it exactly; the conditioning of shear against
    bending, (L/t)^2 = 400, leaves 1e-9.
    """
    width, thickness, length = 20.0, 5.0, 100.0
    even = 1000 / (width * thickness)
    ends = {
        "left": lambda p, n: even * n,
        "right": lambda p, n: even * n,
    }
    plate, moved, reactions = bent(rectangle(10, 2, length, width), thickness, ends)
    stress = plate.face_stress(moved)[..., 0]
    assert_allclose(stress[..., 0], 6 * 1000 / (width * thickness**2), rtol=1e-8)
    assert_allclose(stress[..., 1:], 0.0, atol=1e-7)
    assert np.abs(reactions).max() < 1e-9
    mesh = plate.model.mesh
    at = [mesh.nearest_node(x, 0.0) for x in (0.0, length / 2, length)]
    lifted = moved[[3 * node for node in at], 0]
    sagitta = abs(lifted[1] - (lifted[0] + lifted[2]) / 2)
    inertia = width * thickness**3 / 12
    assert_allclose(sagitta, 1000 * length**2 / (8 * 210e3 * inertia), rtol=1e-8)


def test_a_strip_in_torsion_is_stressed_as_a_rectangle():
    """Timoshenko and Goodier, art. 109, b/t = 4: T / (0.282 b t^2) in the middle of the wide face.

    The plate's shear follows the sides' stress only as a straight line does: 2 %.
    """
    width, thickness, torque = 40.0, 10.0, 1000.0
    second = width * thickness  # of the couples along y: T = integral of m dy
    ends = {
        "left": lambda p, n: np.stack([0 * p[..., 0], -torque / second + 0 * p[..., 0]], -1),
        "right": lambda p, n: np.stack([0 * p[..., 0], torque / second + 0 * p[..., 0]], -1),
    }
    plate, moved, _ = bent(rectangle(30, 16, 200.0, width), thickness, ends)
    points = plate.model.elements.points
    middle = (np.abs(points[..., 0] - 100) < 10) & (np.abs(points[..., 1]) < 2)
    shear = np.abs(plate.face_stress(moved)[..., 2, 0][middle])
    assert_allclose(shear, torque / (0.282 * width * thickness**2), rtol=0.02)


def pierced(gmsh):
    """A plate of 160 x 160 mm about a hole of 16 mm."""
    occ = gmsh.model.occ
    plate = occ.addRectangle(-80, -80, 0, 160, 160)
    occ.cut([(2, plate)], [(2, occ.addDisk(0, 0, 0, 8, 8))])
    occ.synchronize()
    hole = curves_on_circle(gmsh, 0, 0, 8)
    named = {
        "hole": hole,
        "left": curves_in_box(gmsh, (-80, -80), (-80, 80)),
        "right": curves_in_box(gmsh, (80, 80), (-80, 80)),
    }
    return Drawn(named, 12.0, [Region([(1, tag) for tag in hole], 0.8, 30.0)])


@pytest.mark.parametrize(("thickness", "factor"), [(0.4, 1.788), (160.0, 3.0)])
def test_a_hole_in_a_bent_plate_has_reissners_factor(thickness, factor):
    """Reissner (1945): (5 + 3 nu) / (3 + nu) in a thin plate, 3 in one far thicker than the hole.

    A plate ten times as wide as the hole adds 1 %, the approach from either end like t / d some
    2 %, the mesh 1 %: 4 %.
    """
    sheet = mesh_outline(PlaneOutline(pierced, lambda p: np.full(len(p), thickness), []))
    ends = {"left": lambda p, n: n, "right": lambda p, n: n}
    plate, moved, _ = bent(sheet.mesh, thickness, ends)
    elements = plate.model.elements
    stress = np.einsum("aq,eqk->eak", elements.continuation, plate.face_stress(moved)[..., 0])
    at = sheet.mesh.elements == sheet.mesh.nearest_node(0.0, 8.0)
    assert_allclose(stress[at][:, 0].mean() / (6 / thickness), factor, rtol=0.04)
