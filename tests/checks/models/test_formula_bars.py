"""Section forces of a bar as columns of its points, and its buckling load beside a solid's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from checks.handbook.bar_forces import balanced_bar
from checks.models import shapes
from checks.models.checked import BY_STRESS, stress_share
from checks.models.formula_bars import PRESSED, SectionForces
from checks.models.formula_points import Points
from checks.part.part_loads import PartLoads
from checks.strength.part_strength import elastic_of
from fem.buckling import part_buckling
from fem.unit_solutions import solve_unit_loads
from geometry.closed_form import closed_body
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink

COUNT = 7  # positions
PLACES = np.array([10.0, 40.0, 55.0, 90.0])
KINDS = ("axial", "shear", "torque", "moment_y", "moment_z")


@pytest.mark.parametrize("slides", [False, True])
def test_section_forces_are_their_columns_times_what_acts(slides):
    """A contact that slides past a place is not in proportion, and has columns of its own.

    Round-off of a sum of 16.
    """
    random = np.random.default_rng(5)
    ends = [random.normal(size=(COUNT, 6)) for _ in range(2)]
    second = np.linspace(20.0, 80.0, COUNT) if slides else 100.0
    masses = np.linspace(0.0, 100.0, 9)
    field = random.normal(size=(COUNT, 4))
    bar = balanced_bar([(0.0, ends[0]), (second, ends[1])], masses, np.full(9, 1e-3), field)
    points = Points(COUNT)
    sections = SectionForces(points, bar)
    columns, forces = sections.at(PLACES)
    again, _ = sections.at(PLACES)
    assert (again == columns) is not slides
    stress = np.zeros((len(PLACES), 6, len(columns)))
    for component, kind in enumerate(KINDS):
        stress[:, component] = getattr(forces, kind)
    points.add_block("bar", np.zeros((len(PLACES), 3)), columns, stress)
    history = points.history()
    expected = bar.at(PLACES)
    for component, kind in enumerate(KINDS):
        found = history.basis[:, component] @ history.coefficients
        assert_allclose(found, getattr(expected, kind), rtol=0, atol=1e-11)


def test_columns_of_nothing_are_left_out_and_one_is_kept_of_nothing_at_all():
    names = [("nothing", "N"), ("something", "N mm")]
    points = Points(3)
    columns = points.columns(np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]), names)
    points.add_block("here", np.zeros((1, 3)), columns, np.ones((1, 6, 2)))
    assert points.history().coefficients.tolist() == [[1.0, 2.0, 3.0]]
    assert points.units == [("something", "N mm")]
    still = Points(3)
    none = still.columns(np.zeros((2, 3)), names)
    still.add_block("here", np.zeros((1, 3)), none, np.ones((1, 6, 2)))
    assert still.history().coefficients.tolist() == [[0.0, 0.0, 0.0]]
    assert still.units == [("nothing", "N")]


ROD = read_design(Path(__file__).parents[3] / "designs" / "slider_crank.toml").parts["rod"]
LINK = PlateLink(length=100.0, width=20.0, thickness=8.0, hole=10.0, second_hole=6.0)
PART = replace(ROD, geometry=LINK)


def pushed(first, second):
    """A push at both pins, N; where they differ the link's own mass takes the rest."""
    mass = closed_body(LINK).mass_properties(PART.material.density).mass
    rows = {"first": [first, 0, 0, 0, 0, 0], "second": [-second, 0, 0, 0, 0, 0]}
    speeding = np.array([[(first - second) / mass, 0, 0, 0]])
    return PartLoads(
        {name: np.array([row], dtype=float) for name, row in rows.items()},
        speeding,
        {"turn": slice(0, 1)},
        ("k = 0",),
        ("turn",),
        {},
        "first",
    )


def test_a_pushed_link_buckles_as_a_column_between_where_its_pins_press():
    """F l^2/(pi^2 E I), l = L - 8/(3 pi) (r_1 + r_2); the solid has it, its centres' column not.

    The half cosine's resultant: integral of cos^3 over that of cos^2. A stout solid has up to 2.1
    peak stresses over E more, for shear and what an Euler bar has not; from centre to centre the
    column has 15 % more.
    """
    force = 1000.0
    model = shapes.model_of(PART, pushed(force, force))
    apart = LINK.length - PRESSED * (LINK.hole + LINK.second_hole) / 2
    inertia = LINK.width * LINK.thickness**3 / 12
    share = force * apart**2 / (np.pi**2 * PART.material.youngs_modulus * inertia)
    assert model.buckling.share == pytest.approx(share, rel=1e-6)
    solutions = solve_unit_loads(mesh_shape(LINK, fineness=0.5), elastic_of(PART))
    wrenches = pushed(force, force).wrenches
    state = solutions.coefficients(wrenches, np.zeros((1, 4)))[0][:, 0]
    solid = 1 / part_buckling(solutions, state, tilt_held=False).modes[0].factor
    assert 0.0 < solid - share < 2.1 / BY_STRESS * stress_share(PART, model) < 0.1 * share
    assert share * (LINK.length / apart) ** 2 > 1.1 * solid


def test_a_push_that_falls_along_a_link_by_its_inertia_counts_with_its_mean():
    """By symmetry the mean of both ends, to the mass beyond the pins."""
    even = shapes.model_of(PART, pushed(1500.0, 1500.0)).buckling.share
    falling = pushed(2000.0, 1000.0)
    assert shapes.model_of(PART, falling).buckling.share == pytest.approx(even, rel=0.02)


def test_in_its_plane_a_link_buckles_from_pin_to_pin():
    """F L^2/(pi^2 E I_z): a pin's push goes through its axis, however far the bore turns about it.

    Thicker than wide, so that it gives way in the plane.
    """
    force, thick = 1000.0, replace(LINK, thickness=30.0)
    model = shapes.model_of(replace(PART, geometry=thick), pushed(force, force))
    inertia = thick.thickness * thick.width**3 / 12
    share = force * thick.length**2 / (np.pi**2 * PART.material.youngs_modulus * inertia)
    assert model.buckling.words.startswith("in plane")
    assert model.buckling.share == pytest.approx(share, rel=1e-6)
