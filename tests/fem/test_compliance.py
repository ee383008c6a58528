"""Compliance of a part at its interfaces against the formulas of beams."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.unit_solutions import Elastic, compliance, solve_unit_loads
from geometry.meshing import mesh_shape

from .blocks import BAR, PIN, block
from .stacks import POISSON, YOUNG, clamped, sliding

STEEL = Elastic(YOUNG, POISSON, 7.85e-9)
LENGTH, HEIGHT, WIDTH = 200.0, 10.0, 6.0
AREA, INERTIA = HEIGHT * WIDTH, WIDTH * HEIGHT**3 / 12


def beam(counts):
    """Beam with end faces, a clamp about x = 100 and a contact that slides from 20 to 180."""
    mesh = block(counts, (LENGTH, HEIGHT, WIDTH), start=(0.0, -HEIGHT / 2, -WIDTH / 2))
    mesh = sliding(clamped(mesh, "clamp", 100.0, 10.0), "rail", (20.0, 180.0), 10.0)
    return solve_unit_loads(mesh, STEEL)


@pytest.fixture(scope="module")
def solved():
    return beam((40, 2, 2))


def held_at_the_first(matrix, distance):
    """Compliance (3, 3) of the second of two places, the first held: loads and reactions."""
    reaction = np.array([[-1.0, 0, 0], [0, -1, 0], [0, -distance, -1]])
    loads = np.vstack([reaction, np.eye(3)])
    return loads.T @ matrix @ loads


def test_a_cantilevers_end_gives_way_as_the_textbook_says(solved):
    """L / E A, L / E I and L^2 / 2 E I exactly, which quadratic elements hold; L^3 / 3 E I with
    shear L / (k G A), k = 0.85, within 0.1 %.
    """
    tip = held_at_the_first(compliance(solved, ("start", "end")), LENGTH)
    assert_allclose(tip[0, 0], LENGTH / (YOUNG * AREA), rtol=1e-8)
    assert_allclose(tip[2, 2], LENGTH / (YOUNG * INERTIA), rtol=1e-8)
    assert_allclose(tip[1, 2], LENGTH**2 / (2 * YOUNG * INERTIA), rtol=1e-8)
    shear = LENGTH / (0.85 * YOUNG / 2.6 * AREA)
    assert_allclose(tip[1, 1], LENGTH**3 / (3 * YOUNG * INERTIA) + shear, rtol=0.001)
    assert np.abs(tip[0, 1:] * [1, LENGTH]).max() < 1e-8 * tip[1, 1]


@pytest.mark.parametrize("place", [50.0, 77.0, 140.0])
def test_a_cantilever_gives_way_where_its_contact_is(solved, place):
    """s^3 / 3 E I + s / (k G A) at the place s of the contact, and M s / E I.

    The contact is 20 to 30 mm wide: the load is spread and the place moves as the mean of that
    length. At 50 mm that is 2 %, beyond 1 %; for the turn, as if the beam were 2 to 6 mm shorter.
    """
    tip = held_at_the_first(compliance(solved, ("start", ("rail", place))), place)
    bent = place**3 / (3 * YOUNG * INERTIA) + place / (0.85 * YOUNG / 2.6 * AREA)
    assert_allclose(tip[1, 1], bent, rtol=0.01 if place > 70 else 0.02)
    assert_allclose(tip[0, 0], place / (YOUNG * AREA), rtol=0.1)
    assert_allclose(tip[1, 2], place**2 / (2 * YOUNG * INERTIA), rtol=0.02)
    assert 2 < place - tip[2, 2] * YOUNG * INERTIA < 6
    # pressed from one side alone, it would become nu / 4 F / (E b) longer
    assert abs(tip[0, 1]) * YOUNG * WIDTH < 0.005


def test_the_matrix_is_symmetric_and_never_gives_energy(solved):
    """Betti to 1e-9; three rigid motions of the loads' balance cost nothing, none is negative."""
    places = ("start", "end", "clamp", ("rail", 60.0), ("rail", 63.0))
    matrix = compliance(solved, places)
    assert matrix.shape == (15, 15)
    scale = np.tile([1.0, 1.0, LENGTH], 5)
    even = matrix / np.outer(1 / scale, 1 / scale) / scale[:, None] ** 2 / scale**2
    assert np.abs(even - even.T).max() < 1e-9 * np.abs(even).max()
    values = np.linalg.eigvalsh((even + even.T) / 2)
    assert values.min() > -1e-9 * values.max()


def test_the_hold_does_not_matter_to_loads_that_balance_each_other(solved):
    """The work of balanced loads, straight from the solutions that are held at six unknowns."""
    matrix = compliance(solved, ("start", "clamp", "end"))
    loads = np.array([[0, -3.0, -500.0], [7.0, 5.0, 0.0], [-7.0, -2.0, 400.0]])
    assert_allclose(5 * 100 - 2 * 200 - 500 + 400, 0)
    wrenches = {name: np.zeros((1, 6)) for name in ("start", "end", "clamp", "rail")}
    for name, load in zip(("start", "clamp", "end"), loads, strict=True):
        wrenches[name][0, [0, 1, 5]] = load
    coefficients, _ = solved.coefficients(wrenches, np.zeros((1, 4)), {"rail": np.array([50.0])})
    work = (solved.loads @ coefficients).T @ (solved.displacement @ coefficients)
    assert_allclose(loads.ravel() @ matrix @ loads.ravel(), work.item(), rtol=1e-7)


def test_the_compliance_of_a_beam_does_not_depend_on_the_mesh(solved):
    """Every diagonal entry within 0.5 % of one with twice the elements along and across."""
    places = ("start", "end", "clamp", ("rail", 60.0))
    fine = compliance(beam((80, 4, 2)), places)
    assert_allclose(np.diag(compliance(solved, places)), np.diag(fine), rtol=0.005)


@pytest.mark.slow
def test_the_compliance_of_journals_grows_to_a_limit_as_the_mesh_is_refined():
    """No load and no support is a point: every diagonal entry grows less with each refinement, as
    the energy of a displacement method does, the last time (1 to 1.4) by less than 0.5 %.
    """
    coarse, middle, fine = (
        np.diag(compliance(solve_unit_loads(mesh_shape(PIN, fineness=f), STEEL), ("lug", "eye")))
        for f in (0.5, 1.0, 1.4)
    )
    assert (coarse < middle).all()
    assert (middle < fine).all()
    assert (fine - middle < middle - coarse).all()
    assert_allclose(middle, fine, rtol=0.005)


def test_pins_that_pull_a_bar_lengthen_it_more_than_its_two_walls_alone():
    """F L / E A of the shank is most of it; the eyes add their own, between 10 % and 100 %."""
    solutions = solve_unit_loads(mesh_shape(BAR, fineness=0.5), STEEL)
    matrix = compliance(solutions, ("knee", "end"))
    pull = np.array([-1.0, 0, 0, 1, 0, 0])
    section = 2 * BAR.width * BAR.wall + 2 * (BAR.width - 2 * BAR.wall) * BAR.wall
    plain = BAR.length / (YOUNG * section)
    assert 1.1 * plain < pull @ matrix @ pull < 4 * plain


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("rail", "'rail' needs place along x"),
        (("end", 3.0), "'end' does not slide, so it takes no place along x"),
        ("stop", "the part has no interface 'stop'; it has start, end, clamp, rail"),
        (("rail", 10.0), "the contact is at x = 10 mm from its centre, outside its travel"),
    ],
)
def test_a_place_that_the_part_does_not_have_is_refused(solved, place, words):
    with pytest.raises(ValueError, match=words):
        compliance(solved, ("start", place))


def test_a_part_without_mass_is_refused(solved):
    light = replace(solved, material=replace(STEEL, density=0.0))
    with pytest.raises(ValueError, match="a compliance needs a density above 0"):
        compliance(light, ("start", "end"))
