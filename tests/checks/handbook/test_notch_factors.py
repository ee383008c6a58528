"""Handbook factors at notches against other handbooks' numbers and their limits."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from checks.handbook.lug_stress import bent_plate_hole, curved_bar, stepped_bar, stepped_shaft


@pytest.mark.parametrize(
    ("kind", "wide", "a", "b"),
    [
        ("tension", 1.5, 0.99957, -0.28221),
        ("bending", 1.5, 0.93836, -0.25759),
        ("torsion", 2.0, 0.86331, -0.23865),
    ],
)
def test_a_shafts_fillet_has_the_factor_of_another_fit_of_petersons_chart(kind, wide, a, b):
    """Norton, Machine Design, appendix G (Shigley has the charts): K = a (r/d)^b; within 6 %."""
    for radius in (0.15, 0.2):
        assert_allclose(stepped_shaft(kind, wide, 1.0, radius), a * radius**b, rtol=0.06)


@pytest.mark.parametrize("kind", ["tension", "bending", "torsion"])
def test_a_smaller_fillet_never_has_a_smaller_factor(kind):
    """Over all the fit and both its ends, steps of a percent; a jump where fits join is 3 %."""
    radii = np.geomspace(0.003, 4.0, 400)
    found = np.array([stepped_shaft(kind, 1.4, 1.0, r) for r in radii])
    assert (found >= 1).all()
    assert (np.diff(found) < 0.03 * found[1:]).all()


def test_no_step_has_no_peak():
    for kind in ("tension", "bending"):
        assert stepped_shaft(kind, 10.0, 10.0, 1.0) == 1.0
        assert stepped_bar(kind, 10.0, 10.0, 1.0) == 1.0


def test_a_flat_bars_shoulder_has_more_in_tension_than_in_bending():
    """Peterson's charts 3.1 and 3.7, D/d = 2, r/d = 0.1: about 2.25 and 1.85; read to 5 %."""
    assert_allclose(stepped_bar("tension", 20.0, 10.0, 1.0), 2.25, rtol=0.05)
    assert_allclose(stepped_bar("bending", 20.0, 10.0, 1.0), 1.85, rtol=0.05)


def test_a_bent_plates_hole_is_between_the_thick_and_the_thin_plate():
    """3 and (5 + 3 nu)/(3 + nu) = 1.788 at nu = 0.3 (Goodier 1936); falls all the way."""
    found = [bent_plate_hole(d, 1.0) for d in np.geomspace(1e-3, 1e3, 60)]
    assert_allclose(found[0], 3.0, rtol=0.01)
    assert_allclose(found[-1], (5 + 3 * 0.3) / (3 + 0.3), rtol=0.002)
    assert (np.diff(found) < 0).all()


def test_a_curved_bar_has_winklers_factor():
    """Rectangle, R/c = 2: 1.52 (Shigley and Mischke, table of curved beams)."""
    assert_allclose(curved_bar(10.0, 5.0), 1.52, atol=0.005)
