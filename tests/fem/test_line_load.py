"""Line load along a pin: waves of bores and bars, and beams on beds, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ive, kve

from fem.contact.beds import Along, Lug, RoundBar
from fem.contact.condensed import ContactError
from fem.contact.cylinder_waves import (
    _decaying,
    _growing,
    bar_waves,
    bore_waves,
    local_bar_waves,
    shear_of_bar,
)
from fem.contact.line_load import LineLoad, line_load
from tests.line_loads import largest_moment, moment, shift, unevenness

YOUNG, POISSON = 210e3, 0.3


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
def test_long_waves_are_those_of_the_plane_in_plane_strain(nu):
    """n = 2 to 5 at k R = 0.01: (2n + 1 - nu')/(n^2 - 1) of a hole, 2n - 1 + nu' of a disc, times
    1 - nu^2, nu' = nu/(1 - nu). What is left falls as (k R)^2 log(k R): 2e-3 at 0.02 for n = 2.
    """
    n, strain = np.arange(2.0, 6.0), nu / (1 - nu)
    x = np.array([0.01])
    for found, wanted in (
        (bore_waves(5, x, nu), (2 * n + 1 - strain) / (n**2 - 1)),
        (bar_waves(5, x, nu), (2 * n - 1 + strain) / (n**2 - 1)),
    ):
        assert_allclose(found[2:, 0], (1 - nu**2) * wanted, rtol=1e-3)
    assert_allclose(bore_waves(0, x, nu)[0], 1 + nu, rtol=1e-3)  # Lame's
    assert_allclose(bar_waves(0, x, nu)[0], 1 - nu, rtol=1e-3)  # a long bar is free along itself


def test_short_waves_are_those_of_a_half_space():
    """2 (1 - nu^2)/(E |k|), |k|^2 = k^2 + (n/R)^2, whatever their direction; curvature's share
    is below 1/(|k| R).
    """
    x = np.array([40.0, 80.0])
    for waves in (bore_waves, bar_waves):
        for n in (0, 1, 20, 60):
            plane = 2 * (1 - POISSON**2) / np.hypot(n, x)
            off = waves(60, x, POISSON)[n] / plane - 1
            assert (np.abs(off) < 1 / np.hypot(n, x)).all()


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.3, 0.4])
def test_a_long_wave_bends_a_bar_as_a_timoshenko_beam(nu):
    """(k R)^2 times what is beside 4/(k R)^4; what is local is left, 0.4 to 0.7 of it."""
    x = np.array([0.1])
    beam = (bar_waves(1, x, nu)[1] - 4 / x**4) * x**2
    local = local_bar_waves(1, x, nu)[1]
    assert_allclose(beam, shear_of_bar(nu) + local * x**2, rtol=1e-9)
    assert 0.4 < local[0] < 0.7
    assert_allclose(local_bar_waves(1, x / 2, nu)[1], local, rtol=1e-3)


def test_waves_of_all_lengths_rise_as_bessel_functions_do():
    """x I'/I and x K'/K by scipy; beside 40, where the series takes over, it leaves 1e-12."""
    x = np.array([0.01, 1.0, 20.0, 39.9, 40.1, 60.0, 300.0, 3000.0])
    for last in (3, 48):
        n = np.arange(last + 2)[:, None]
        assert_allclose(_growing(last, x), n + x * ive(n + 1, x) / ive(n, x), rtol=1e-12)
        assert_allclose(_decaying(last, x), n - x * kve(n + 1, x) / kve(n, x), rtol=1e-12)


def winkler(modulus):
    """A bed of springs, `modulus` MPa: mean of q/modulus over each hat."""

    def bed(_bar, _lug, hats):
        steps, n = np.diff(hats.nodes), len(hats.nodes)
        mass = np.zeros((n, n))
        for k, step in enumerate(steps):
            mass[k : k + 2, k : k + 2] += step / 6 * (np.eye(2) + 1)
        return mass / np.outer(hats.lengths, hats.lengths) / modulus

    return bed


def fork(
    diameter=20.0, eye=20.0, young=YOUNG, tilt=0.0, clearance=0.0, cheek=None, bed=None, patches=12
):
    """40 kN on an eye between two cheeks, 1 mm apart."""
    cheek = eye / 2 if cheek is None else cheek
    faces = eye / 2 + 1, eye / 2 + 1 + cheek
    bar = RoundBar((-faces[1] - 5, faces[1] + 5), (diameter,), young, POISSON)
    lugs = [
        Lug(-faces[1], -faces[0], (-20e3, 0.0), YOUNG, POISSON, tilt, clearance),
        Lug(-eye / 2, eye / 2, (40e3, 0.0), YOUNG, POISSON, 0.0, clearance),
        Lug(faces[0], faces[1], (-20e3, 0.0), YOUNG, POISSON, tilt, clearance),
    ]
    return line_load(bar, lugs, bed, patches)


def even_moment(eye=20.0):
    """F/8 (2a + 4c + b) of the fork."""
    return 40e3 / 8 * (2 * eye / 2 + 4 + eye)


def test_a_rigid_pin_presses_evenly_on_springs():
    """A pin a million times as stiff: 1 to 1e-4 in each lug, and the moment of even pressure.

    What is left is the pin's own bending, of the order k L^4/(E I) = 6e-6.
    """
    found = fork(young=1e6 * YOUNG, bed=winkler(0.3 * YOUNG))
    for lug in range(3):
        assert_allclose(found.intensity(lug) * found.lugs[lug].width / found.lugs[lug].size, 1,
                        rtol=1e-4)  # fmt: skip
    assert_allclose(largest_moment(found), even_moment(), rtol=1e-4)


@pytest.mark.parametrize("u", [0.3, 0.8, 1.3])
def test_a_soft_pin_is_a_beam_on_an_elastic_foundation(u):
    """Free ends loaded by P each, at the faces of its lug, u = beta L/2, beta^4 = k/(4 E I).

    EI y'''' = -k y, even: y = A C(x) + B S(x), C = cosh cos, S = sinh sin of beta x. No moment at
    the ends: -A sinh sin + B cosh cos = 0 (u), so B = A tanh u tan u. The mean of y is 2 P/(k L).
    A slender pin, so that shear is nothing, s (beta d)^2/4 < 2e-3; hats to 1 %.
    """
    diameter, length = 5.0, 200.0
    inertia = np.pi * diameter**4 / 64
    modulus = 4 * YOUNG * inertia * (2 * u / length) ** 4
    faces = length / 2 + 1e-3, length / 2 + 0.2
    bar = RoundBar((-faces[1], faces[1]), (diameter,), YOUNG, POISSON)
    lugs = [
        Lug(-faces[1], -faces[0], (-1e3, 0.0), YOUNG, POISSON),
        Lug(-length / 2, length / 2, (2e3, 0.0), YOUNG, POISSON),
        Lug(faces[0], faces[1], (-1e3, 0.0), YOUNG, POISSON),
    ]
    found = line_load(bar, lugs, winkler(modulus), 24)

    def shape(x):
        bx = 2 * u / length * x
        return np.cosh(bx) * np.cos(bx) + np.tanh(u) * np.tan(u) * np.sinh(bx) * np.sin(bx)

    x = np.linspace(-length / 2, length / 2, 4001)
    wanted = shape(found.hats[1].nodes) / np.trapezoid(shape(x), x) * length
    assert_allclose(found.intensity(1) * length / 2e3, wanted, atol=0.01 * wanted.max())
    assert wanted.max() > 1.004


def test_forces_and_moments_balance_and_the_moment_is_less_than_with_even_pressure():
    """1e-9 of the forces and of the moment; a pin with lugs in two planes, too."""
    found = fork(tilt=7e-8)
    for lug, forces in zip(found.lugs, found.forces, strict=True):
        assert_allclose(forces.sum(), lug.size, rtol=1e-9)
        assert forces.min() >= 0
    ends = np.array([found.bar.cuts[0], found.bar.cuts[-1]])
    assert np.abs(moment(found, ends)).max() < 1e-9 * largest_moment(found)
    assert 0.7 * even_moment() < largest_moment(found) < 0.95 * even_moment()
    across = [
        replace(found.lugs[0], low=-40.0, high=-30.0, force=(0.0, -10e3)),
        replace(found.lugs[2], low=30.0, high=40.0, force=(0.0, -10e3)),
        replace(found.lugs[0], force=(-20e3, 10e3)),
        replace(found.lugs[2], force=(-20e3, 10e3)),
        found.lugs[1],
    ]
    both = line_load(replace(found.bar, cuts=(-45.0, 45.0)), across)
    assert np.abs(moment(both, np.array([-45.0, 45.0]))).max() < 1e-9 * largest_moment(both)
    assert np.abs(moment(both, np.array([0.0]))).min() > 1e3  # bent in both planes


def test_forces_in_one_plane_press_alike_whatever_its_direction():
    """To 1e-9: only the plane turns."""
    found = fork()
    turned = [replace(lug, force=(0.8 * lug.force[0], -0.6 * lug.force[0])) for lug in found.lugs]
    skew = line_load(found.bar, turned)
    for one, other in zip(found.forces, skew.forces, strict=True):
        assert_allclose(one, other, rtol=0, atol=1e-9 * found.lugs[1].size)


def test_tendencies():
    """Stiffer pins, looser bores, cheeks that tilt: more even; the inner faces are pressed most."""

    def uneven(**given: float) -> float:
        return unevenness(fork(**given), 1, 1.0)

    assert uneven(diameter=30.0) < uneven() < uneven(diameter=15.0)
    assert uneven(clearance=0.1) < uneven()
    held, free = fork(), fork(tilt=1e-3)
    assert shift(held, 2) < shift(free, 2) < 1e-6 < 0.5 < -shift(held, 2)
    assert largest_moment(held) < largest_moment(free) < even_moment()


def test_a_finer_line_load_is_the_same_away_from_the_edges():
    """12 and 24 patches: 2 % three millimetres inside; the edge's own value is of no use."""
    some, finer = fork(), fork(patches=24)
    places = np.linspace(-7.0, 7.0, 9)
    coarse = np.interp(places, some.hats[1].nodes, some.intensity(1))
    fine = np.interp(places, finer.hats[1].nodes, finer.intensity(1))
    assert_allclose(coarse, fine, rtol=0.02)
    assert_allclose(largest_moment(some), largest_moment(finer), rtol=2e-3)


def test_stepped_pins_bend_more_in_their_necks():
    """A neck between eye and cheeks of half the diameter: 16 times as soft there."""
    whole = fork()
    cuts = (-26.0, -11.0, -10.0, 10.0, 11.0, 26.0)
    necked = replace(whole.bar, cuts=cuts, diameters=(20.0, 10.0, 20.0, 10.0, 20.0))
    found = line_load(necked, whole.lugs)
    assert largest_moment(found) < largest_moment(whole)


def test_forces_that_no_pressure_balances_are_refused():
    """A couple between two lugs side by side that both lie on one side of it."""
    bar = RoundBar((0.0, 100.0), (20.0,), YOUNG, POISSON)
    lugs = [
        Lug(0.0, 10.0, (-10e3, 0.0), YOUNG, POISSON),
        Lug(80.0, 90.0, (10e3, 0.0), YOUNG, POISSON),
    ]
    with pytest.raises(ContactError, match="no pressure balances the load"):
        line_load(bar, lugs)


def test_the_line_load_of_a_lug_is_read_inside_its_faces():
    found = LineLoad(
        RoundBar((0.0, 10.0), (5.0,), YOUNG, POISSON),
        [Lug(0.0, 10.0, (100.0, 0.0), YOUNG, POISSON)],
        [Along(np.array([0.0, 5.0, 10.0]))],
        [np.array([50.0, 50.0, 0.0])],
    )
    assert_allclose(found.intensity(0), [20.0, 10.0, 0.0])
    assert_allclose(unevenness(found, 0), 2.0)
    assert_allclose(unevenness(found, 0, 2.5), 1.5)
    assert_allclose(unevenness(found, 0, 50.0), 1.0)
    assert_allclose(shift(found, 0), 50 * (5 / 3) / 100 + 2.5 - 5.0)


def of_even_pressure(found):
    """The largest moment of the same lugs that press evenly."""
    places = np.linspace(found.bar.cuts[0], found.bar.cuts[-1], 2001)
    even = [
        hats.lengths * lug.size / lug.width
        for hats, lug in zip(found.hats, found.lugs, strict=True)
    ]
    moments = moment(replace(found, forces=even), places)
    return np.hypot(*moments.T).max()


@pytest.mark.parametrize("tilt", [0.0, 1e4])
def test_even_pressure_bends_a_pin_most(tilt):
    """Three or five lugs of any width, distance and force, held or free to tilt: 0.3 to 0.99.

    Neighbours that press against each other do so where they face each other, closer than middles.
    """
    random, d = np.random.default_rng(3), 20.0
    found = []
    for pairs in (1, 2) * 6:
        half = d * random.uniform(0.15, 1.25)
        lugs, top = [Lug(-half, half, (40e3, 0.0), YOUNG, POISSON)], half
        shares = random.uniform(-1, 1, pairs)
        shares[-1] -= shares.sum() + 1
        for share in shares:
            low = top + d * random.uniform(0.02, 0.4)
            top = low + d * random.uniform(0.15, 1.2)
            held = (20e3 * share, 0.0), YOUNG, POISSON, tilt * 12 / (YOUNG * (top - low) ** 3)
            lugs += [Lug(low, top, *held), Lug(-top, -low, *held)]
        pressed = line_load(RoundBar((-top - 5, top + 5), (d,), YOUNG, POISSON), lugs)
        found.append(largest_moment(pressed) / of_even_pressure(pressed))
    assert 0.25 < min(found) < max(found) < 1.0
    assert max(found) > 0.8 if tilt else min(found) < 0.5
