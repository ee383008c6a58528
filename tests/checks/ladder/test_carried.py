"""Places and errors of a neighbour whose mesh is carried over."""

from types import SimpleNamespace

import numpy as np
import pytest

from checks.ladder import carried


def test_a_place_errs_by_its_step_to_the_finest_mesh_a_third_more_and_what_is_left(monkeypatch):
    """Two places of 100 and 80 MPa, one of 60 that no peak moves to; the finest has 6 % more."""
    places = np.array([[0.0, 0, 0], [50.0, 0, 0], [90.0, 0, 0]])
    level = SimpleNamespace(
        history=SimpleNamespace(nodes=np.array([7, 8, 9]), points=places),
        left_out=np.array([], dtype=int),
        size_at=lambda _: 2.0,
    )
    values = np.array([100.0, 80.0, 60.0])
    what = SimpleNamespace(bound=lambda *_: values.copy(), point=lambda _: 0, value=lambda _: 100.0)
    finest = object()
    monkeypatch.setattr(carried, "_largest", lambda _what, on, *_: 106.0 if on is finest else 100.0)
    found = carried._places(what, level, finest, 0.01)
    assert [(place.node, place.reach) for place in found] == [(7, 4.0), (8, 4.0)]
    assert [place.error for place in found] == pytest.approx([0.01 + 4 / 3 * 0.06] * 2)
