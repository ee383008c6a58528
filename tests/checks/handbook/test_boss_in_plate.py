"""A thick ring in a plate against Kirsch, Bickley, a rigid disc, and its own conditions."""

import numpy as np
import pytest

from checks.handbook.boss_in_plate import FIELDS, boss_in_plate
from checks.handbook.lug_stress import polar
from checks.handbook.pin_loaded_hole import PATTERNS, open_hole
from fem.unit_loads import OF_ARCS, bearing_coefficients

NU, HOLE, BOSS = 0.3, 10.0, 16.0
ANGLES = np.radians(np.arange(0.0, 360.0, 15.0))
RIM, OUTSIDE = (radius * np.exp(1j * ANGLES) for radius in (HOLE, BOSS))
COLUMNS = range(len(PATTERNS) + len(FIELDS))


def around(found, arms, column, *, ring):
    return polar(found.at(arms, ring=ring)[:, :, column], np.angle(arms))


@pytest.mark.parametrize("field", range(3), ids=FIELDS)
def test_a_boss_as_thick_as_the_plate_is_an_open_hole(field):
    """Kirsch, and the bent plate, in a wide plate; the rate counts per radius of the hole."""
    found = boss_in_plate(HOLE, BOSS, 8.0, 8.0, NU)
    hoop, radial, shear = around(found, RIM, len(PATTERNS) + field, ring=True)
    per = HOLE if field == 1 else 1.0
    np.testing.assert_allclose(hoop, per * open_hole(ANGLES, 0.0)[:, field], atol=1e-9 * per)
    np.testing.assert_allclose([radial, shear], 0.0, atol=1e-9 * per)


def test_a_force_by_a_cosine_all_round_is_bickleys():
    """Hoop (1 - nu)/(2 pi a) cos t... of 1 N on 1 mm: radial -cos t/(pi a) at the hole's edge.

    Far away it is a force at a point: sigma_r = -(3 + nu) cos t/(4 pi r).
    """
    found = boss_in_plate(HOLE, BOSS, 1.0, 1.0, NU)
    _, radial, _ = around(found, RIM, PATTERNS.index("cos 1"), ring=True)
    np.testing.assert_allclose(radial, -np.cos(ANGLES) / (np.pi * HOLE), atol=1e-12)
    far = 1e4 * RIM
    _, radial, shear = around(found, far, PATTERNS.index("cos 1"), ring=False)
    whole = 4 * np.pi * np.abs(far)
    np.testing.assert_allclose(radial * whole, -(3 + NU) * np.cos(ANGLES), atol=1e-6)
    np.testing.assert_allclose(shear * whole, (1 - NU) * np.sin(ANGLES), atol=1e-6)


def test_a_rigid_disc_raises_the_pull_across_it_by_half():
    """Muskhelishvili 59: with kappa = (3 - nu)/(1 + nu), radial S ((kappa + 1)/2 (1/2 + 1/kappa)).

    Of plane stress in steel 1.51 S.
    """
    kappa = (3 - NU) / (1 + NU)
    found = boss_in_plate(1e-3, BOSS, 1e7, 1.0, NU)
    _, radial, _ = around(found, OUTSIDE, len(PATTERNS), ring=False)
    mean, wave = (kappa + 1) / 4, (kappa + 1) / (2 * kappa)
    np.testing.assert_allclose(radial, mean + wave * np.cos(2 * ANGLES), rtol=1e-5)


@pytest.mark.parametrize("column", COLUMNS)
def test_forces_and_strains_go_on_from_the_ring_to_the_plate(column):
    """Thickness times radial stress and shear, and the strain around, on both sides."""
    thick, thin = 40.0, 6.0
    found = boss_in_plate(HOLE, BOSS, thick, thin, NU)
    (hoop, radial, shear), (hoop_out, radial_out, shear_out) = (
        around(found, OUTSIDE, column, ring=ring) for ring in (True, False)
    )
    size = max(np.abs([radial_out, shear_out]).max(), 1e-9)
    np.testing.assert_allclose(thick * radial, thin * radial_out, atol=1e-8 * size * thin)
    np.testing.assert_allclose(thick * shear, thin * shear_out, atol=1e-8 * size * thin)
    np.testing.assert_allclose(
        hoop - NU * radial, hoop_out - NU * radial_out, atol=1e-7 * size, rtol=1e-7
    )


def test_a_pin_on_a_narrow_arc_presses_there_alone():
    """1 N on 90 degrees: radial -p0 cos 2t at the rim, p0 = 3/(2 sqrt 2 a thick)."""
    thick, thin, force = 40.0, 6.0, [[1.0, 0.0, 0.0]]
    found = boss_in_plate(HOLE, BOSS, thick, thin, NU, OF_ARCS)
    (own,) = bearing_coefficients(np.array(force), inward=False, arc=np.pi / 2)
    _, radial, shear = polar(found.at(RIM, ring=True)[:, :, : len(own)] @ own, ANGLES)
    pressed = np.cos(2 * ANGLES) * (np.cos(ANGLES) > np.cos(np.pi / 4))
    peak = 3 / (2 * np.sqrt(2)) / (HOLE * thick)
    np.testing.assert_allclose(radial, -peak * pressed, atol=0.04 * peak)  # in its kink
    np.testing.assert_allclose(shear, 0.0, atol=1e-9 * peak)
    few = boss_in_plate(HOLE, BOSS, thick, thin, NU)
    same = [found.patterns.index(name) for name in PATTERNS]
    for ring in (True, False):
        wanted = few.at(OUTSIDE, ring=ring)[:, :, : len(PATTERNS)]
        size = np.abs(wanted).max()
        np.testing.assert_allclose(
            found.at(OUTSIDE, ring=ring)[:, :, same], wanted, atol=1e-9 * size
        )


def test_a_boss_that_holds_no_hole_is_refused():
    with pytest.raises(ValueError, match="holds no hole of 16 mm"):
        boss_in_plate(16.0, 16.0, 1.0, 1.0, NU)
