"""Room for names beside the lines of a chart."""

import numpy as np
from numpy.testing import assert_allclose

from reports.charts.chart import cut


def test_a_line_that_goes_on_for_miles_is_cut_where_it_leaves_the_space():
    """A ray of slope 1 through (0, 50): in a space of 400 x 300 up to (250, 300)."""
    (inside,) = cut(np.array([[0.0, 50.0], [1e12, 1e12 + 50.0]]), 400.0, 300.0)
    assert len(inside) < 1000
    assert_allclose(inside[0], [0, 50], atol=1e-3)
    assert_allclose(inside[-1], [250, 300], atol=5)
    assert_allclose(inside[:, 1] - inside[:, 0], 50, atol=1e-3)


def test_a_line_that_comes_back_is_not_led_across_the_space():
    """It passes below, turns far away, and comes back above: it is never inside."""
    line = [[-50.0, -20.0], [1e9, -20.0], [1e9, 320.0], [-50.0, 320.0]]
    assert cut(np.array(line), 400.0, 300.0) == []
