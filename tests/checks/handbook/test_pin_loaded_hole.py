"""Stress beside a pin's hole by series, and of what stands around it."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from checks.handbook.lug_stress import Lug, cartesian, polar, strip_outline
from checks.handbook.pin_loaded_hole import PATTERNS, LugOutline, pin_loaded_hole
from fem.solvers import SolverError
from fem.unit_loads import HARMONICS, OF_ARCS, bearing_coefficients, harmonics_of

NU = 0.3
RIM = np.radians(np.arange(3.0, 360.0, 15.0))


def lug_of(half_width=25.0, radius=10.0, end=None, cut=62.5, **how):
    return pin_loaded_hole(radius, strip_outline(half_width, end, cut, **how), NU)


def coefficients(force_x, force_y=0.0, couple=0.0):
    return bearing_coefficients(np.array([[force_x, force_y, couple]]), inward=False)[0]


def hoop_of(hole, wanted):
    rim = hole.radius * np.exp(1j * RIM)
    return polar(hole.at(rim) @ wanted, RIM)


def test_in_a_wide_plate_the_hoop_stress_of_each_pressure_is_bickleys():
    """Even pressure p: +p; p cos(n t), n = 2 and 4: -p cos(n t).

    The plate is 40 times as wide as the hole: (1/40)^2 times some 10 of a free edge's effect, 1 %.
    """
    hole = lug_of(half_width=40.0, radius=1.0, end=40.0, cut=40.0)
    unit = 1 / np.pi
    found = hole.at(np.exp(1j * RIM))
    for name, wanted in (
        ("cos 0", np.ones(len(RIM))),
        ("cos 2", -np.cos(2 * RIM)),
        ("sin 4", -np.sin(4 * RIM)),
    ):
        hoop, _, _ = polar(found[:, :, PATTERNS.index(name)], RIM)
        assert_allclose(hoop, unit * wanted, rtol=0, atol=0.01 * unit)


def test_more_harmonics_leave_those_of_the_half_circle_as_they_are():
    """Mirrored lugs, too: what narrower arcs take of the first patterns, exactly."""
    outline, rim = strip_outline(25.0, 30.0, 62.5), 10 * np.exp(1j * RIM)
    few, many = (pin_loaded_hole(10.0, outline, NU, which) for which in (HARMONICS, OF_ARCS))
    same = [many.patterns.index(name) for name in PATTERNS]
    for turned in (False, True):
        found, wanted = (Lug(one, 6.0, mirrored=turned).stress(rim) for one in (many, few))
        assert_array_equal(found[:, :, same], wanted)


def test_a_narrower_arc_of_a_neat_plate_strains_it_more_beside_the_contact():
    """Gripper's link (hole over width 0.364) pulled; its solids have 59.9, 65.4 and 69.1 MPa.

    Times that of the half circle: 1.092 and 1.153; without pressure off the arc, by the series.
    """
    outline, rim = strip_outline(11.0, None, 27.5), 4 * np.exp(1j * np.radians(np.arange(360.0)))
    found = []
    for arc in np.radians([180.0, 135.0, 90.0]):
        hole = pin_loaded_hole(4.0, outline, NU, harmonics_of(arc))
        own = bearing_coefficients(np.array([[-1.0, 0.0, 0.0]]), False, arc)[0]
        xx, yy, xy = (Lug(hole, 6.0).stress(rim) @ own).T
        found.append(np.sqrt(xx**2 + yy**2 - xx * yy + 3 * xy**2).max())
    assert_allclose(np.array(found[1:]) / found[0], [1.092, 1.153], rtol=0.02)


def test_in_a_wide_plate_the_hoop_stress_of_a_force_is_that_of_the_point_force():
    """(1 - nu)/(2 pi r) sin(t) of a force along y held far away by bending, which is odd in y.

    P = -(X + iY)/(2 pi (1 + kappa) z) leaves sigma_r + sigma_t = -2 cos/(pi (1 + kappa) r). The
    shear that passes, 1/(2 * 2 h) on either side, adds 4 of it: 4/(4 * 40) = 0.1 pi of 1/pi: so
    only the part that turns once around is compared, which it does not have.
    """
    hole = lug_of(half_width=40.0, radius=1.0, end=40.0, cut=40.0)
    angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    found = hole.at(np.exp(1j * angles))[:, :, PATTERNS.index("sin 1")]
    hoop, _, _ = polar(found, angles)
    once = 2 * (hoop * np.sin(angles)).mean()
    assert_allclose(once, (1 - NU) / (2 * np.pi), rtol=0.05)


@pytest.mark.parametrize("end", [None, 25.0, 40.0])
def test_the_rim_bears_the_pins_pressure_between_the_collocated_points_too(end):
    """2e-3 of the pressure's peak: what least squares leave in a square corner."""
    wanted = coefficients(300.0, 400.0, 500.0)
    hole = lug_of(end=end)
    _, radial, shear = hoop_of(hole, wanted)
    waves = [np.ones(len(RIM))]
    waves += [wave(n * RIM) for n in (1, 2, 4) for wave in (np.cos, np.sin)]
    pressure = np.array(waves).T @ wanted[:-1] / (np.pi * hole.radius)
    assert_allclose(radial, -pressure, rtol=0, atol=2e-3 * pressure.max())
    even = -500.0 / (2 * np.pi * hole.radius**2)  # the rim's outward normal is inward
    assert_allclose(shear, even, rtol=0, atol=2e-3 * pressure.max())


def test_a_section_beyond_the_hole_carries_force_and_moment_of_the_pin():
    """x = 30: -F_x, -F_y, and 30 F_y - M about its own middle; Gauss quadrature, 1e-3 of either."""
    hole = lug_of()
    y, weights = np.polynomial.legendre.leggauss(24)
    y, weights = 25 * y, 25 * weights
    xx, _, xy = (hole.at(30 + 1j * y) @ coefficients(300.0, 400.0, 500.0)).T
    assert_allclose(weights @ xx, -300.0, rtol=1e-3)
    assert_allclose(weights @ xy, -400.0, rtol=1e-3)
    assert_allclose(-weights @ (y * xx), 30 * 400.0 - 500.0, rtol=2e-3)


def test_stringers_carry_their_share_of_a_section():
    """The lug's stress and the stringers', A (sigma_x - nu sigma_y), sum up to the force: 1 %."""
    hole = lug_of(end=30.0, stringer=20.0)
    y, weights = np.polynomial.legendre.leggauss(24)
    y, weights = 25 * y, 25 * weights
    wanted = coefficients(1000.0)
    xx = (hole.at(40 + 1j * y) @ wanted)[:, 0]
    edge = (hole.at(np.array([40 + 25j])) @ wanted)[0]
    assert_allclose(weights @ xx + 2 * 20 * (edge[0] - NU * edge[1]), -1000.0, rtol=0.01)
    assert weights @ xx > -700.0


def test_a_pulled_lug_that_is_round_about_its_pin_peaks_beside_it():
    """d/W = 0.4 under a cosine pressure: 3.35 by a solid (`lug_factor`), which has 3 to

    5 % more in its middle plane than plane stress; 4 % below and 6 % above are left.
    """
    hoop, _, _ = hoop_of(lug_of(), coefficients(-1.0))
    factor = hoop.max() * 30.0
    assert 3.35 / 1.06 < factor < 3.35 * 1.04
    assert abs(np.degrees(RIM[hoop.argmax()]) % 180 - 90) < 16


def test_a_mirrored_lug_is_stressed_as_the_lug_in_a_mirror():
    hole = lug_of(end=30.0)
    lug, other = Lug(hole, 8.0), Lug(hole, 8.0, mirrored=True)
    arms = 14.0 * np.exp(1j * RIM)
    one = lug.stress(arms) @ coefficients(300.0, 400.0, 500.0)
    two = other.stress(-arms.conj()) @ coefficients(-300.0, 400.0, -500.0)
    assert_allclose(two, one * [1, 1, -1], rtol=0, atol=1e-9 * np.abs(one).max())


def test_a_couple_that_bends_a_thick_lug_presses_its_faces_as_that_many_forces():
    """t = 1000 d: the relief of a bent plate's hole is none, 2.99/3; M_y = 1 is 6/t per mm."""
    lug = Lug(lug_of(), 20_000.0)
    bent = lug.tilted(RIM)[:, :, 1]
    plane = lug.stress(10 * np.exp(1j * RIM))[:, :, PATTERNS.index("cos 1")] * 6 / 20_000
    assert_allclose(bent, plane, rtol=0, atol=0.01 * np.abs(plane).max())
    assert 0.77 < lug.relief < 0.771


def test_a_lug_that_is_twisted_has_the_bars_shear_around_its_hole_as_a_hole_in_shear():
    """Its bar at +x turns against M_x: tau_xy = +M_x/W at z > 0, half on either side of the hole.

    -4 S sin(2 t) around a hole under shear S (Kirsch), all of it where the plate is thick.
    """
    thick = 2e4
    lug = Lug(lug_of(), thick, twist_modulus=50.0)
    other = Lug(lug_of(), thick, mirrored=True, twist_modulus=50.0)
    for one, sign in ((lug, 1.0), (other, -1.0)):
        hoop, _, _ = polar(one.tilted(RIM)[:, :, 0], RIM)
        twice = 2 * (hoop * np.sin(2 * RIM)).mean()
        assert_allclose(twice, sign * -4 * 0.5 / 50.0, rtol=0.01)


def test_polar_and_cartesian_stress_are_each_others_inverse():
    plane = np.random.default_rng(1).normal(size=(len(RIM), 3))
    assert_allclose(cartesian(*polar(plane, RIM), RIM), plane, rtol=0, atol=1e-14)


@pytest.mark.parametrize("ratio", [0.3, 0.6, 0.75, 0.84])
def test_more_powers_than_a_ring_is_given_change_its_stress_by_less_than_a_per_cent(
    ratio, monkeypatch
):
    rim = ratio * 10 * np.exp(1j * np.radians(np.arange(0, 360, 5.0)))
    edge = 10 * np.exp(1j * np.radians(np.arange(90, 181, 10.0)))

    def largest():
        hole = pin_loaded_hole(ratio * 10, strip_outline(10.0, None, 25.0), NU)
        return np.array([np.abs(hole.at(at)).max(axis=(0, 1)) for at in (rim, edge)]), hole.order

    found, few = largest()
    monkeypatch.setattr("checks.handbook.pin_loaded_hole._LEFT", 3e-4)
    monkeypatch.setattr("checks.handbook.lug_stress._POINTS", 360)
    better, more = largest()
    assert more > few or ratio < 0.4
    assert_allclose(found, better, rtol=0.01, atol=5e-3 * better.max())


def test_a_ring_too_thin_for_the_series_is_refused():
    with pytest.raises(SolverError, match=r"takes 0\.86 of its lug, at most 0\.85"):
        pin_loaded_hole(8.6, strip_outline(10.0, None, 25.0), NU)


@pytest.mark.parametrize("other", ["radius", "nu", *LugOutline.__dataclass_fields__])
def test_a_lug_that_differs_in_any_number_is_solved_anew(other):
    """Each number of it changed by a tenth moves some coefficient by far more than round-off."""
    radius, nu, outline = 10.0, NU, strip_outline(25.0, 30.0, 62.5, stringer=8.0)
    known = pin_loaded_hole(radius, outline, nu)
    again = pin_loaded_hole(radius, strip_outline(25.0, 30.0, 62.5, stringer=8.0), nu)
    assert_array_equal(again.even, known.even)
    assert_array_equal(again.odd, known.odd)
    if other == "radius":
        radius *= 1.1
    elif other == "nu":
        nu *= 1.1
    else:
        outline = replace(outline, **{other: 1.1 * getattr(outline, other)})
    changed = pin_loaded_hole(radius, outline, nu)
    assert np.abs(changed.even - known.even).max() > 1e-6 * np.abs(known.even).max()
