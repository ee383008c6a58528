"""A contact that slides along a cantilever: its resultants, and what it bends, at many places."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.assembly import Elements
from fem.sliding import cut_along_x, sliding_coefficients, sliding_loads, stations
from fem.unit_loads import interface_loads, resultants
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.mesh import Interface, MeshError

from .blocks import block, wrench
from .stacks import POISSON, YOUNG, sliding

STEEL = Elastic(YOUNG, POISSON, 7.85e-9)
LENGTH, HEIGHT, WIDTH = 200.0, 10.0, 6.0
INERTIA, AREA = WIDTH * HEIGHT**3 / 12, WIDTH * HEIGHT
TRAVEL, PATCH = (20.0, 170.0), 12.0
PLACES = np.linspace(*TRAVEL, 17)
RAIL = Interface("rail", "slide", np.zeros(3), travel=TRAVEL, patch=PATCH)


@pytest.fixture(scope="module")
def beam():
    """Cantilever from x = 0; mesh lines every 5 mm, stations every 11.54 mm."""
    mesh = block((40, 2, 2), (LENGTH, HEIGHT, WIDTH), start=(0.0, -HEIGHT / 2, -WIDTH / 2))
    return solve_unit_loads(sliding(mesh, "rail", TRAVEL, PATCH), STEEL)


def pushed(beam, force_x=0.0, force_y=0.0, couple=0.0, at=PLACES):
    """Coefficients of a force and couple at each of several places, carried by the face x = 0."""
    one = np.ones(len(at))
    on_rail, on_face = np.zeros((len(at), 6)), np.zeros((len(at), 6))
    on_rail[:, 0], on_rail[:, 1], on_rail[:, 5] = force_x, force_y, couple + at * force_y
    on_face[:, [0, 1, 5]] = -on_rail[:, [0, 1, 5]]
    wrenches = {"rail": on_rail, "start": on_face, "end": 0 * on_face}
    coefficients, added = beam.coefficients(wrenches, np.zeros((len(one), 4)), {"rail": at})
    assert np.abs(added).max() < 1e-6
    return coefficients


def probe(beam, end):
    """Nodal forces of a unit load at the end x = L, carried by the face x = 0."""
    start = -end - wrench(mz=LENGTH * end[0, 1])
    wrenches = {"rail": wrench(), "start": start, "end": end}
    coefficients, _ = beam.coefficients(wrenches, np.zeros((1, 4)), {"rail": np.array([50.0])})
    return beam.loads @ coefficients[:, 0]


def spread(at):
    """Places of the two hats that stand for a force, their shares, and a hat's mean square."""
    places = stations(RAIL)
    spacing = places[1] - places[0]
    k = np.clip(((at - places[0]) / spacing).astype(int), 0, len(places) - 2)
    share = (at - places[k]) / spacing
    return np.stack([places[k], places[k + 1]]), np.stack([1 - share, share]), spacing**2 / 6


@pytest.mark.parametrize(
    ("travel", "half_length", "expected"),
    [
        ((0.0, 100.0), 10.0, np.linspace(0, 100, 11)),
        ((-8.0, 17.0), 10.0, [-8, 1 / 3, 26 / 3, 17]),
        ((4.0, 14.0), 10.0, [4, 14]),
        ((4.0, 8.0), 10.0, [2, 10]),
        ((4.0, 4.0), 9.0, [1, 7]),
    ],
)
def test_stations_are_at_most_a_patch_apart_and_end_where_the_surface_does(
    travel, half_length, expected
):
    """Even over the way; on a short one two whose hats end `patch` beyond it at most."""
    interface = Interface("rail", "slide", np.zeros(3), travel=travel, patch=half_length)
    places = stations(interface)
    assert_allclose(places, expected, rtol=1e-12)
    spacing = places[1] - places[0]
    assert spacing <= half_length * (1 + 1e-12)
    assert places[0] - spacing >= travel[0] - half_length - 1e-12
    assert places[0] <= travel[0] <= travel[1] <= places[-1]


@pytest.mark.parametrize(("travel", "half_length"), [((0.0, 10.0), 0.0), ((10.0, 0.0), 2.0)])
def test_a_contact_without_a_patch_or_with_its_travel_turned_round_is_refused(travel, half_length):
    interface = Interface("rail", "slide", np.zeros(3), travel=travel, patch=half_length)
    with pytest.raises(MeshError, match="'rail': a sliding contact needs a patch above 0 mm and a"):
        stations(interface)


def test_every_station_has_the_force_and_the_moment_of_a_force_at_its_place(beam):
    """All six resultants to 1e-12, of 1 N and 1 N times the distance from the station."""
    unit = next(u for u in beam.interfaces if u.interface.name == "rail")
    places = stations(unit.interface)
    assert len(unit.names) == 3 * len(places) == 42
    got = resultants(beam.elements, unit.vectors, unit.interface.centre)
    expected = np.zeros_like(got)
    for i, x in enumerate(places):
        for kind, axis, size in (("+", 1, 1.0), ("-", 1, -1.0), ("t", 0, 1.0)):
            column = unit.names.index(f"{kind} {i}")
            expected[axis, column] = size
            expected[5, column] = x * size if axis == 1 else 0.0
    assert_allclose(got[:3], expected[:3], rtol=0, atol=1e-12)
    assert_allclose(got[3:], expected[3:], rtol=0, atol=1e-12 * LENGTH)
    # hats are cut where they have kinks: nothing is left to correct on flat straight facets
    assert unit.raw_deviation < 1e-12


def test_a_force_along_y_presses_on_its_own_side_only(beam):
    unit = next(u for u in beam.interfaces if u.interface.name == "rail")
    y = beam.mesh.nodes[:, 1]
    for kind, side in (("+", -HEIGHT / 2), ("-", HEIGHT / 2)):
        columns = [name.startswith(kind) for name in unit.names]
        loaded = np.abs(unit.vectors[:, columns]).max(axis=1).reshape(-1, 3) > 0
        assert loaded[:, 1].any()
        assert not loaded[:, [0, 2]].any()
        assert_allclose(y[loaded[:, 1]], side)
    rubbed = unit.vectors[:, unit.names.index("t 5")].reshape(-1, 3, order="C")[:, 0]
    assert_allclose(rubbed[y > 4.9].sum(), 0.5, rtol=1e-12)
    assert_allclose(rubbed[y < -4.9].sum(), 0.5, rtol=1e-12)


def test_all_hats_together_press_evenly_on_the_whole_way(beam):
    """A partition of unity: between the end stations the pressure is 1 N over spacing and width."""
    unit = next(u for u in beam.interfaces if u.interface.name == "rail")
    places = stations(unit.interface)
    total = unit.vectors[:, [name.startswith("+") for name in unit.names]].sum(axis=1)
    even = Interface("even", "face", np.zeros(3))
    mesh = replace(
        beam.mesh,
        surfaces={**beam.mesh.surfaces, "even": beam.mesh.surfaces["rail+"]},
        interfaces={"even": even},
    )
    elements = Elements(mesh)
    surface = elements.surface("even")
    nodal = np.zeros(len(mesh.nodes))
    pressure = 1 / ((places[1] - places[0]) * WIDTH)
    np.add.at(
        nodal, surface.nodes, pressure * np.einsum("aq,fq->fa", surface.shape, surface.weights)
    )
    x = mesh.nodes[:, 0]
    inner = (x > places[0] + 5.1) & (x < places[-1] - 5.1)
    assert_allclose(total.reshape(-1, 3)[inner, 1], nodal[inner], rtol=0, atol=1e-12)
    assert np.abs(nodal[inner]).max() > 0.05


def test_cut_facets_have_the_area_of_their_surface(beam):
    strips = cut_along_x(beam.mesh, "rail+", np.array([-3.0, 11.1, 12.0, 15.0, 99.99, 300.0]))
    assert_allclose(strips.weights.sum(), LENGTH * WIDTH, rtol=1e-13)
    assert_allclose(strips.shape.sum(axis=2), 1.0, rtol=1e-13)
    for line in (11.1, 12.0, 99.99):  # no triangle has points on both sides
        side = strips.points[..., 0] > line
        assert (side.all(axis=1) | ~side.any(axis=1)).all()


@pytest.mark.parametrize("force", [1000.0, -1000.0])
def test_the_contact_carries_its_force_and_moment_exactly_at_and_between_stations(beam, force):
    rail = pushed(beam, force_x=0.1 * force, force_y=force, couple=700.0)
    unit = next(u for u in beam.interfaces if u.interface.name == "rail")
    column = sum(len(u.names) for u in beam.interfaces[: beam.interfaces.index(unit)])
    rows = slice(column, column + len(unit.names))
    got = resultants(beam.elements, unit.vectors @ rail[rows], np.zeros(3))
    assert_allclose(got[0], 0.1 * force, rtol=1e-11)
    assert_allclose(got[1], force, rtol=1e-11)
    assert_allclose(got[5], 700.0 + PLACES * force, rtol=1e-11)
    assert np.abs(got[2:5]).max() < 1e-10 * abs(force)


@pytest.mark.parametrize("force", [1000.0, -1000.0])
def test_a_force_at_17_places_bends_the_beam_as_the_textbook_says(beam, force):
    """Tip of a cantilever under F at s: F s^2 (3 L - s) / 6 E I + F s / (k G A), k = 0.85.

    The two hats spread the force by 5 to 8 mm, as a patch of 24 mm does (7 mm), which moves the tip
    by 0.2 % of its largest deflection; the face that is pressed also arches (nu). With both in the
    formula the mesh leaves 0.02 % at every place, between stations too.
    """
    u = beam.displacement @ pushed(beam, force_y=force)
    tip = probe(beam, wrench(fy=1.0)) @ u
    at, shares, square = spread(PLACES)
    moved = at**2 * (3 * LENGTH - at) / 6 + square / 2 * (LENGTH - at)
    face, middle = HEIGHT**2 / 4 - WIDTH**2 / 12, HEIGHT**2 / 12 - WIDTH**2 / 12
    arched = POISSON / 2 * ((LENGTH - PLACES) * face - LENGTH * middle)
    shear = PLACES / (0.85 * YOUNG / 2.6 * AREA)
    expected = force * (((shares * moved).sum(axis=0) + arched) / (YOUNG * INERTIA) + shear)
    assert_allclose(tip, expected, rtol=2e-4)
    point = force * (PLACES**2 * (3 * LENGTH - PLACES) / 6 / (YOUNG * INERTIA) + shear)
    assert_allclose(tip, point, rtol=0, atol=0.003 * np.abs(point).max())


def test_a_force_at_17_places_turns_the_tip_exactly(beam):
    """By reciprocity with pure bending, which the elements hold exactly: u_y of a couple M is
    M / (2 E I) (x^2 + nu (y^2 - z^2)), averaged over the hats below and the face x = 0.
    """
    u = beam.displacement @ pushed(beam, force_y=1000.0)
    at, shares, square = spread(PLACES)
    squares = (shares * (at**2 + square)).sum(axis=0)
    sides = POISSON * (HEIGHT**2 / 4 - HEIGHT**2 / 12)
    expected = 1000.0 * (squares + sides) / (2 * YOUNG * INERTIA)
    assert_allclose(probe(beam, wrench(mz=1.0)) @ u, expected, rtol=1e-8)


def test_a_couple_at_17_places_turns_the_tip_by_its_distance(beam):
    """M s / E I exactly, however the stations share the couple; half a spacing from the ends of the
    way it stays on the last pair.
    """
    u = beam.displacement @ pushed(beam, couple=5e4)
    places = stations(RAIL)
    at = np.clip(PLACES, places[:2].mean(), places[-2:].mean())
    expected = 5e4 * at / (YOUNG * INERTIA)
    assert_allclose(probe(beam, wrench(mz=1.0)) @ u, expected, rtol=1e-8)


def test_friction_at_17_places_stretches_the_beam_up_to_there(beam):
    """F s / E A, exactly: uniform tension is in the elements, both faces rub evenly."""
    u = beam.displacement @ pushed(beam, force_x=-400.0)
    expected = -400.0 * PLACES / (YOUNG * AREA)
    assert_allclose(probe(beam, wrench(fx=1.0)) @ u, expected, rtol=1e-8)


def test_behind_the_contact_the_beam_has_naviers_stress(beam):
    """F (s - x) y / I at x = 50 on the faces, for places from 80 on.

    Two elements over the height recover it with 4 MPa too little everywhere, a quarter of the mean
    shear stress.
    """
    at = PLACES[PLACES >= 80]
    stress = beam.basis @ pushed(beam, force_y=1000.0, at=at)
    x, y, _ = beam.mesh.nodes[beam.recovery.points].T
    for side in (-1, 1):
        here = (x == 50.0) & (y == side * HEIGHT / 2)
        expected = -1000.0 * (at - 50) * side * HEIGHT / 2 / INERTIA
        mean = stress[here, 0].mean(axis=0)
        assert_allclose(mean, expected, rtol=0, atol=5)


def test_the_coefficients_of_a_contact_are_those_of_a_lever():
    """Stations 0, 5, 10: a force 8 at x = 6 is 6.4 and 1.6 on the last two. A couple 3 there is a
    pair of 0.6, of which 0.3 press about x = 2.5 and 0.7 about x = 7.5: 0.18 and 0.42.
    """
    interface = Interface("rail", "slide", np.zeros(3), travel=(0.0, 10.0), patch=5.0)
    both = sliding_coefficients(
        interface, np.array([[4.0, 8.0, 51.0], [4.0, -8.0, -51.0]]), np.array([6.0, 6.0])
    )
    assert_allclose(both[0], [0, 0.18, 0, 6.16, 0, 3.2, 2.02, 0, 0.8], atol=1e-12)
    assert_allclose(both[1], [0.18, 0, 0, 0, 6.16, 3.2, 0, 2.02, 0.8], atol=1e-12)
    couple = sliding_coefficients(interface, np.array([[0.0, 0.0, 10.0]]), np.array([10.0]))
    assert_allclose(couple[0], [0, 0, 0, 0, 2, 0, 2, 0, 0], atol=1e-12)


@pytest.mark.parametrize("place", [19.99, 170.01, np.nan])
def test_a_contact_that_leaves_its_way_is_refused(beam, place):
    at = np.array([50.0, place, 60.0])
    with pytest.raises(
        ValueError, match=r"'rail': at position 2 of 3 the contact is at x = .* mm "
    ):
        pushed(beam, force_y=1.0, at=at)


def test_a_contact_at_the_end_of_its_way_may_be_beside_it_by_round_off(beam):
    assert np.isfinite(pushed(beam, force_y=1.0, at=np.array([20 - 1e-5, 170 + 1e-5]))).all()


def test_a_contact_without_its_place_is_refused(beam):
    wrenches = dict.fromkeys(("rail", "start", "end"), wrench())
    with pytest.raises(ValueError, match="'rail' slides: its loads need the place of the contact"):
        beam.coefficients(wrenches, np.zeros((1, 4)))
    with pytest.raises(ValueError, match=r"1 positions need as many places .* shape \(2,\)"):
        beam.coefficients(wrenches, np.zeros((1, 4)), {"rail": np.array([50.0, 60.0])})


@pytest.mark.parametrize("x", [(15.0, 200.0), (0.0, 178.0)])
def test_a_surface_that_ends_before_the_contact_does_is_refused(x):
    mesh = block((40, 2, 2), (LENGTH, HEIGHT, WIDTH), start=(0.0, -HEIGHT / 2, -WIDTH / 2))
    mesh = sliding(mesh, "rail", TRAVEL, PATCH, x=x)
    with pytest.raises(
        MeshError, match=r"surface 'rail\+' reaches from x = .* the contact presses"
    ):
        sliding_loads(Elements(mesh), mesh.interfaces["rail"])


def test_a_surface_with_a_gap_in_it_is_refused():
    mesh = block((40, 2, 2), (LENGTH, HEIGHT, WIDTH), start=(0.0, -HEIGHT / 2, -WIDTH / 2))
    mesh = sliding(mesh, "rail", TRAVEL, PATCH)
    facets = mesh.surfaces["rail+"]
    x = mesh.nodes[facets[:, :3], 0].mean(axis=1)
    holed = replace(mesh, surfaces={**mesh.surfaces, "rail+": facets[(x < 80) | (x > 84)]})
    with pytest.raises(MeshError, match="loads on 'rail' miss their resultant"):
        sliding_loads(Elements(holed), holed.interfaces["rail"])


def test_a_surface_that_is_not_flat_or_not_about_its_centre_is_refused(beam):
    mesh = beam.mesh
    tilted = replace(mesh, surfaces={**mesh.surfaces, "rail+": mesh.surfaces["end"]})
    with pytest.raises(MeshError, match=r"surface 'rail\+' must be flat and normal to y"):
        sliding_loads(Elements(tilted), mesh.interfaces["rail"])
    aside = replace(mesh.interfaces["rail"], centre=np.array([0.0, 6.0, 0.0]))
    with pytest.raises(MeshError, match="'rail': its centre must be between its surfaces"):
        sliding_loads(beam.elements, aside)


def test_a_sliding_contact_is_not_among_the_loads_that_stay(beam):
    with pytest.raises(MeshError, match="interface 'rail' is a 'slide'"):
        interface_loads(beam.elements, beam.mesh.interfaces["rail"])
