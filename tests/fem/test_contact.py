"""Condensed contact: closed forms of a pin in a sheet, optimality, and what is refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.contact.condensed import ALLOWED, CondensedContact, ContactError
from fem.contact.hats import Hats, disc_flexibility, sheet_flexibility
from fem.contact.persson import persson_half_arc, persson_pressure
from tests.validation.plane.domains import geometric, mapped
from tests.validation.plane.model import PlaneModel

YOUNG, POISSON, RADIUS, LENGTH, FORCE = 210e3, 0.3, 10.0, 5.0, 2e4
ALONG_X = np.array([FORCE, 0.0])


def pin_in_sheet(count, within=np.pi):
    """Hats, and the contact of a disc in a hole of an infinite sheet, both of steel.

    Half of `count` hats lie within an angle of 0, the others are as even beyond.
    """
    hats = Hats.even(count)
    if within < np.pi:
        near = np.linspace(0, within, count // 4 + 1)
        beyond = np.linspace(within, np.pi, count // 4 + 1)[1:]
        half = np.r_[near, beyond]
        hats = Hats(np.r_[half, 2 * np.pi - half[-2:0:-1]])
    flexibility = disc_flexibility(hats, LENGTH, YOUNG, POISSON)
    flexibility += sheet_flexibility(hats, LENGTH, YOUNG, POISSON)
    return hats, CondensedContact(flexibility, hats.directions)


def clearance(parameter):
    """Difference of the radii, mm, of E* dR t/F."""
    return 2 * parameter * FORCE / (YOUNG * LENGTH)


def pressures(hats, state):
    return state.forces / (hats.extents * RADIUS * LENGTH)


@pytest.mark.parametrize(
    ("parameter", "within"), [(0, np.pi), (0.25, np.pi), (1, 1.2), (3, 1.0), (10, 0.6), (100, 0.2)]
)
def test_a_pin_in_a_sheet_presses_as_persson_says(parameter, within):
    """Peak to 0.2 %; to 0.5 % of it up to four hats from the arc's end; the arc to a hat's width.

    At the end pressure falls as a root, which hats miss by 3 % of the peak, in turn above and below
    and a third as much from hat to hat inwards.
    """
    hats, problem = pin_in_sheet(72, within)
    state = problem.solve(np.full(72, clearance(parameter)), ALONG_X)
    half = persson_half_arc(parameter)
    unit = FORCE / RADIUS / LENGTH
    assert_allclose(pressures(hats, state)[0], persson_pressure(half) * unit, rtol=2e-3)
    inside = np.flatnonzero(np.cos(hats.angles) > np.cos(max(half - 4 * hats.widths[0], 0)))
    wanted = [persson_pressure(half, hats.angles[i]) for i in inside if hats.angles[i] < np.pi]
    found = pressures(hats, state)[inside[hats.angles[inside] < np.pi]] / unit
    assert_allclose(found, wanted, atol=0.005 * persson_pressure(half))
    assert abs(hats.arc(state.forces) - 2 * half) < hats.widths[0]
    assert state.unbalanced < ALLOWED
    assert state.not_complementary < ALLOWED


def test_a_loose_pin_presses_as_hertz_says():
    """p = 1000: peak sqrt(p/pi) F/(R t), half an ellipse; the arc is 4.1 degrees."""
    hats, problem = pin_in_sheet(100, 0.05)
    state = problem.solve(np.full(100, clearance(1e3)), ALONG_X)
    peak = np.sqrt(1e3 / np.pi) * FORCE / RADIUS / LENGTH
    half = np.sqrt(4 / (np.pi * 1e3))
    near = np.arange(14)
    ellipse = peak * np.sqrt(1 - (hats.angles[near] / half) ** 2)
    assert_allclose(pressures(hats, state)[near], ellipse, rtol=2e-3)


def test_a_neat_pin_touches_the_same_arc_at_every_force():
    """Nothing but the force has a size, so ten times the force presses ten times as much."""
    _, problem = pin_in_sheet(72)
    one = problem.solve(np.zeros(72), ALONG_X)
    ten = problem.solve(np.zeros(72), 10 * ALONG_X)
    assert_allclose(ten.forces, 10 * one.forces, atol=1e-9 * FORCE)
    assert_allclose(ten.motion, 10 * one.motion, atol=1e-12)


def test_a_pressed_in_pin_presses_as_lame_says():
    """Interference d of a disc in a sheet of its material, without force: p = E d/(2 R)."""
    hats, problem = pin_in_sheet(24)
    state = problem.solve(np.full(24, -0.01), np.zeros(2))
    assert_allclose(pressures(hats, state), YOUNG * 0.01 / (2 * RADIUS), rtol=1e-9)
    assert hats.arc(state.forces) == 2 * np.pi


def test_turning_the_force_turns_the_pressure_and_order_does_not_matter():
    hats, problem = pin_in_sheet(72)
    opening, angle = np.full(72, clearance(1.0)), 7 * hats.widths[0]
    straight = problem.solve(opening, ALONG_X)
    turned = problem.solve(opening, FORCE * np.array([np.cos(angle), np.sin(angle)]))
    assert_allclose(turned.forces, np.roll(straight.forces, 7), atol=1e-9 * FORCE)
    order = np.random.default_rng(3).permutation(72)
    mixed = CondensedContact(
        problem.flexibility[np.ix_(order, order)], problem.directions[order]
    ).solve(opening, ALONG_X)
    assert_allclose(mixed.forces, straight.forces[order], atol=1e-9 * FORCE)


@pytest.mark.parametrize("seed", range(8))
def test_every_start_and_both_methods_find_the_one_solution(seed):
    """Flexibilities without any structure, on which Newton's method may cycle."""
    random = np.random.default_rng(seed)
    root = random.normal(size=(30, 30))
    flexibility = root @ root.T / 30 + 0.02 * np.eye(30)
    angles = 2 * np.pi * np.arange(30) / 30
    problem = CondensedContact(flexibility, np.column_stack([np.cos(angles), np.sin(angles)]))
    openings, force = random.uniform(-0.5, 1, 30), np.array([3.0, 1.0])
    every = np.ones(30, dtype=bool)
    first = problem._primal(openings, force, every)
    for start in (None, random.random(30) > 0.5, every):
        states = [problem.solve(openings, force, start)]
        if start is not None:
            states.append(problem._primal(openings, force, start))
        for state in states:
            assert_allclose(state.forces, first.forces, atol=1e-9)
            assert state.unbalanced < ALLOWED
            assert state.not_complementary < ALLOWED
    assert first.forces.min() >= 0
    assert first.gaps.min() > -1e-9


def test_a_result_that_is_no_contact_shows_it():
    """Forces of another clearance close no gap: complementarity says so."""
    _, problem = pin_in_sheet(72)
    state = problem.solve(np.zeros(72), ALONG_X)
    other = type(state)(
        problem, np.full(72, 1e-3), 1.01 * ALONG_X, state.forces, state.motion, state.touching, 1
    )
    assert other.not_complementary > 1e-2
    assert other.unbalanced > 5e-3


def test_a_pin_that_floats_is_refused():
    _, problem = pin_in_sheet(24)
    with pytest.raises(ContactError, match="the pin floats"):
        problem.solve(np.full(24, 0.01), np.zeros(2))


def test_a_couple_that_tips_the_pin_out_is_refused():
    """Two strips 10 mm apart carry 10 mm F/2 at most."""
    hats, problem = pin_in_sheet(24)
    empty = np.zeros((24, 24))
    both = np.block([[problem.flexibility, empty], [empty, problem.flexibility]])
    arms = np.vstack([hats.directions, hats.directions])
    place = np.repeat([-5.0, 5.0], 24)[:, None] * arms[:, :1]
    two = CondensedContact(both, np.hstack([arms, place]))
    held = two.solve(np.zeros(48), np.array([FORCE, 0.0, 4 * FORCE]))
    assert held.forces[24:] @ arms[24:, 0] == pytest.approx(0.9 * FORCE)
    one_way = CondensedContact(both[:13, :13], np.hstack([arms, place])[:13])
    with pytest.raises(ContactError, match="tips the pin"):
        one_way.solve(np.zeros(13), np.array([FORCE, 0.0, 4 * FORCE]))


def test_an_uneven_flexibility_is_refused():
    with pytest.raises(ValueError, match="not symmetric"):
        CondensedContact(np.array([[1.0, 0.1], [0.2, 1.0]]), np.ones((2, 1)))


def test_even_hats_give_way_as_the_sum_over_their_waves_says():
    """Their flexibility is taken from the first hat alone; here each pair is summed up."""
    hats = Hats.even(15)
    numbers = np.arange(2.0, 92.0)  # six waves in a hat, rounded up
    waves = hats.waves(numbers)
    size = (2 * numbers - 1 + POISSON) / (numbers**2 - 1) / np.pi
    wanted = (waves * size @ waves.conj().T).real + (1 - POISSON) / (2 * np.pi)
    found = disc_flexibility(hats, LENGTH, YOUNG, POISSON) * YOUNG * LENGTH
    assert_allclose(found, wanted, rtol=1e-11, atol=1e-12)
    assert np.array_equal(found, found.T)


@pytest.mark.parametrize("strain", [False, True])
def test_discs_and_holes_give_way_as_finite_elements_do(strain):
    """A ring 1:40 stands for the sheet and, loaded outside, for the disc; harmonics 0, 2, 3, 5.

    The far edge moves the hole by its own share of some (1/40)**2; the mesh gives 0.2 %.
    """
    hats = Hats.even(36)
    columns = geometric(40, 1.1)
    rows = np.linspace(0, 1, 61)

    def ring(s, t):
        radius = 1 + 39 * s
        return radius * np.cos(np.pi * t), radius * np.sin(np.pi * t)

    kind = "strain" if strain else "stress"
    for edge, outer, made in (("left", 40.0, sheet_flexibility), ("right", 1.0, disc_flexibility)):
        mesh = mapped(columns if edge == "left" else 1 - columns[::-1], rows, ring)
        model = PlaneModel(mesh, YOUNG, POISSON, kind)
        radius = 40.0 / outer
        axis = {"bottom": (None, 0.0), "top": (None, 0.0)}
        nearest = mesh.nearest_node(40.0, 0.0) if edge == "left" else mesh.nearest_node(1.0, 0.0)
        held = model.held({**axis, int(nearest): (0.0, None)})
        nodes = mesh.edge_nodes(edge)
        angle = np.arctan2(*mesh.nodes[nodes].T[::-1])
        outward = mesh.nodes[nodes] / np.linalg.norm(mesh.nodes[nodes], axis=1)[:, None]
        flexible = made(hats, 1.0, YOUNG, POISSON, strain=strain)
        for number in (0, 2, 3, 5):

            def pressed(points, normals, number=number):
                turn = np.arctan2(points[..., 1], points[..., 0])
                return -normals * np.cos(number * turn)[..., None]

            moved = held.solve(model.loads({edge: pressed})).displacement[nodes]
            radial = (moved * outward).sum(axis=1) * (1 if edge == "left" else -1)
            order = np.argsort(angle)
            wave = np.cos(number * angle[order])
            norm = np.pi / 2 if number else np.pi
            found = np.trapezoid(radial[order] * wave, angle[order]) / norm
            inner = 1.0 if edge == "left" else 40.0
            forces = np.cos(number * hats.angles) * hats.extents * inner
            size = hats.waves(np.array([float(number or 1)]))[0].real[0] if number else 1.0
            expected = (flexible @ forces)[0] / size**2
            assert_allclose(found, expected, rtol=6e-3, err_msg=f"{edge} {number} {radius}")


@pytest.mark.filterwarnings("error")
def test_a_start_that_does_not_hold_the_pin_is_left_without_a_warning():
    """Equations of two opposite hats are singular, and one hat alone balances the force."""
    hats, problem = pin_in_sheet(24)
    opposite = np.zeros(24, dtype=bool)
    opposite[[0, 12]] = True
    assert abs(hats.directions[[0, 12], 1]).max() < 1e-12
    state = problem.solve(np.zeros(24), np.array([0.0, FORCE]), opposite)
    assert_allclose(
        state.forces, problem.solve(np.zeros(24), np.array([0.0, FORCE])).forces, atol=1e-9 * FORCE
    )
    assert state.not_complementary < ALLOWED
    assert state.unbalanced < ALLOWED
