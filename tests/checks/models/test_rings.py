"""The largest stress around a pin is sought between the angles of a model's points."""

import numpy as np
import pytest

from checks.models.checked import static_values, with_peaks
from checks.stress.stress_result import RungModel
from fem.stress_history import StressHistory

COUNT = 24


def bent(direction):
    """A pin of two sections bent about one direction (rad), the second a tenth more."""
    angles = np.tile(2 * np.pi * np.arange(COUNT) / COUNT, 2)
    basis = np.zeros((2 * COUNT, 6, 1))
    basis[:, 2, 0] = np.cos(angles - direction) * np.repeat([100.0, 110.0], COUNT)
    points = np.column_stack([5 * np.cos(angles), 5 * np.sin(angles), np.repeat([0, 9.0], COUNT)])
    return RungModel(
        history=StressHistory(np.arange(2 * COUNT), points, basis, np.array([[1.0, -0.4]])),
        places=["first"] * COUNT + ["second"] * COUNT,
        fretting=np.ones(2 * COUNT),
        residual=0.0,
        deflection=0.0,
        neglects="",
        ring=COUNT,
        units=[("moment", "N mm")],
    )


@pytest.mark.parametrize("degrees", [0.0, 7.5, 37.0, 123.4])
def test_the_peak_does_not_depend_on_the_direction_of_the_force(degrees):
    """At 7.5 degrees from the points they alone have 1 - cos(7.5 degrees), 0.86 %, less."""
    direction = np.radians(degrees)
    found = with_peaks(bent(direction), static_values)
    values, _ = static_values(found.history, found.fretting)
    worst = int(values.argmax())
    assert values.max() == pytest.approx(110.0, rel=1e-7)
    assert found.places[worst] == "second"
    assert len(found.places) == len(values) == len(found.fretting)
    place = found.history.points[worst]
    assert place[2] == pytest.approx(9.0)
    along = place[0] * np.cos(direction) + place[1] * np.sin(direction)
    assert abs(along) == pytest.approx(5.0, rel=1e-6)


def test_no_angle_is_asked_twice_and_few_in_all():
    """Stress of degree 1: a round follows the angles beside the largest, not what a step holds."""
    asked = []

    def judged(history, fretting):
        asked.append(history.points)
        return static_values(history, fretting)

    with_peaks(bent(np.radians(37.0)), judged)
    for points in asked:
        assert len(np.unique(np.round(points, 9), axis=0)) == len(points)
    assert sum(map(len, asked[1:])) < 200
