"""Section forces of a bar as columns of its points, against the section forces themselves."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.handbook.bar_forces import balanced_bar
from checks.models.formula_bars import SectionForces
from checks.models.formula_points import Points

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
