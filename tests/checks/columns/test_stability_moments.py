"""Crooked columns with first-order moments, against closed forms worked out beside them."""

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from checks.by_formula import crooked_column
from checks.columns.column_limits import planes_of
from checks.columns.column_moments import crooked_columns, first_order
from checks.handbook.column_curves import perry_robertson
from checks.part.loaded_part import LoadedPart
from checks.result.verdict import Status
from tests.checks.columns.test_stability import LENGTH, check_of, of_design, pushed, rod
from tests.small_machine import loads_of

AREA, WITHIN, ACROSS = 240.0, 8 * 30**2 / 6, 30 * 8**2 / 6  # mm2 and both section moduli, mm3
STRAIGHT = 'parts.rod.column.crookedness="1e-9 mm"'


def euler_of(part, inertia):
    return pi**2 * part.material.youngs_modulus * inertia / LENGTH**2


def crooked(design, part, loads, plane):
    return check_of(crooked_column.checks(LoadedPart(design, part, loads)), f"crooked bar {plane}")


@pytest.mark.parametrize("force", [1.0, 1e4, 4e4, 1e7])
def test_a_crooked_column_without_moments_is_perry_and_robertsons(tmp_path, force):
    """Its load factor times F/A is their stress with eta = e A/W, at any load, e = L/1000."""
    design, part = rod(tmp_path)
    check = crooked(design, part, pushed(force), "out of plane")
    bow = LENGTH / 1000
    euler = euler_of(part, 30 * 8**3 / 12) / AREA
    expected = perry_robertson(euler, part.material.yield_stress, bow * AREA / ACROSS)
    assert_allclose(check.safety * force / AREA, expected, rtol=1e-9)
    assert check.required == design.require.static
    assert f"crooked by {bow:.3g} mm (L/1000, assumed)" in check.note


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_an_eccentric_column_is_bent_as_the_secant_formula_says(tmp_path, share):
    """s (1 + e A/W sec(pi/2 sqrt(F/F_E))) = S_y; nine sines leave 1e-3 of the moment that grows."""
    design, part = rod(tmp_path, STRAIGHT, 'parts.rod.column.eccentricity="0.3 mm"')
    euler = euler_of(part, 30 * 8**3 / 12)
    strength = replace(part.material, yield_stress=share * euler / AREA * 2, ultimate_stress=1e4)
    part = replace(part, material=strength)
    force = 1e3

    def over(factor):
        ratio = factor * force / euler
        secant = 1 / cos(pi / 2 * sqrt(ratio))
        return factor * force * (1 / AREA + 0.3 / ACROSS * secant) - strength.yield_stress

    expected = brentq(over, 0, euler / force * (1 - 1e-9))
    check = crooked(design, part, pushed(force), "out of plane")
    assert_allclose(check.safety, expected, rtol=1e-3)


def test_couples_at_the_pins_bend_the_column_as_the_same_eccentricity_does(tmp_path):
    """A couple of F e at each end, both to one side; friction mu F r is such a couple."""
    design, part = rod(tmp_path, STRAIGHT)
    force, arm = 2e4, 1.5
    loads = loads_of({"first": [(force, 0, -force * arm)], "second": [(-force, 0, force * arm)]})
    by_couple = crooked(design, part, loads, "in plane")
    design, part = rod(tmp_path, STRAIGHT, f'parts.rod.column.eccentricity="{arm} mm"')
    by_arm = crooked(design, part, pushed(force), "in plane")
    assert_allclose(by_couple.safety, by_arm.safety, rtol=1e-3)
    plain = force / AREA + force * arm / WITHIN
    assert plain < part.material.yield_stress / by_couple.safety < 1.1 * plain


def test_the_press_with_friction_has_its_pins_couples():
    """mu F r = 0.1 x F x 20 mm: 2 mm beside the pin. In the cheeks 52.25 kN/1008 mm2 = 51.83 MPa,
    and 2 mm x F/13440 mm3 = 7.78 MPa at the knee, where nothing grows: 59.61 MPa.
    """
    masses = [
        f"bodies.{body}.{key}"
        for body in ("lower", "upper")
        for key in ('mass="4.14134 kg"', 'inertia="0.0215695 kg m2"', 'centre="125, 0 mm"')
    ]
    found = of_design("toggle_press_friction", "bar_upper", "cycles.press.positions=61", *masses)
    check = check_of(crooked_column.checks(LoadedPart(*found)), "crooked bar in plane")
    assert check.place == "cheeks at 0 mm"
    assert_allclose(check.value, 59.61, rtol=2e-3)
    assert check.status is Status.PASS


def test_inertia_bends_a_bar_that_is_swung_sideways(tmp_path):
    """rho A a L^2/8 at mid-length, ends pushed by half of m a each; parabola, 129 places."""
    _, part = rod(tmp_path)
    swing, line = 3e5, part.material.density * AREA
    half = line * swing * LENGTH / 2
    loads = loads_of({"first": [(0, half, 0)], "second": [(0, half, 0)]})
    loads.accelerations[:, 1] = swing
    about_z, about_y = (one.moments for one in first_order(part, loads, LENGTH))
    assert_allclose(np.abs(about_z[0, 64]), line * swing * LENGTH**2 / 8, rtol=1e-3)
    assert_allclose(about_z[0, [0, -1]], 0, atol=1e-9 * half * LENGTH)
    assert not about_y.any()


def test_an_eye_that_is_swung_along_bends_nothing(tmp_path):
    """Its inertia is carried by its own pin: 2 kg at one end and 0.5 kg at the other add nothing.

    Taken with levers, these forces had bent the bar by a quarter of the length at mid-length.
    """
    _, part = rod(tmp_path)
    swing, line = 3e5, part.material.density * AREA
    half = line * swing * LENGTH / 2
    loads = loads_of(
        {"first": [(0, half + 2e-3 * swing, 0)], "second": [(0, half + 5e-4 * swing, 0)]}
    )
    loads.accelerations[:, 1] = swing
    about_z = first_order(part, loads, LENGTH)[0].moments
    assert_allclose(np.abs(about_z[0, 64]), line * swing * LENGTH**2 / 8, rtol=1e-3)


def test_angular_acceleration_bends_a_bar_as_a_triangular_load(tmp_path):
    """rho A alpha x between two pins: w L^2/(9 sqrt 3) at L/sqrt 3, w at the far end."""
    _, part = rod(tmp_path)
    turn = 1e3
    most = part.material.density * AREA * turn * LENGTH
    loads = loads_of({"first": [(0, most * LENGTH / 6, 0)], "second": [(0, most * LENGTH / 3, 0)]})
    loads.accelerations[:, 2] = turn
    moment = np.abs(first_order(part, loads, LENGTH)[0].moments[0])
    assert_allclose(moment.max(), most * LENGTH**2 / (9 * sqrt(3)), rtol=1e-3)
    assert_allclose(np.argmax(moment) / 128, 1 / sqrt(3), atol=0.01)


def test_force_beside_the_middle_plane_bends_the_part_out_of_it(tmp_path):
    """F at z = 5 mm of one end: F z there, a straight line to nothing at the other."""
    design, part = rod(tmp_path)
    loads = pushed(1e3)
    loads.wrenches["first"][:, 4] = 5e3
    loads.wrenches["first"][:, 2] = 5e3 / LENGTH
    loads.wrenches["second"][:, 2] = -5e3 / LENGTH
    about_y = first_order(part, loads, LENGTH)[1].moments
    assert_allclose(np.abs(about_y[0]), 5e3 * np.linspace(1, 0, 129), atol=1e-9 * 5e3)
    check = crooked(design, part, loads, "out of plane")
    stress = 1e3 / AREA + 5e3 / ACROSS
    assert_allclose(part.material.yield_stress / check.safety, stress, rtol=0.02)


def test_bending_and_compression_have_their_own_worst_positions(tmp_path):
    """The largest force at k = 0 says nothing of the edge, which a couple bends most at k = 2."""
    design, part = rod(tmp_path)
    rows = [(3e4, 0), (2e4, 4e4), (1e4, 1.5e5), (-5e4, 9e5)]
    loads = loads_of(
        {"first": [(f, 0, -m) for f, m in rows], "second": [(-f, 0, m) for f, m in rows]}
    )
    check = crooked(design, part, loads, "in plane")
    assert check.position == "k = 2"
    assert check.value > 1e4 / AREA + 1.5e5 / WITHIN


def test_no_position_and_no_place_is_worse_than_the_one_that_is_named(tmp_path):
    """Each of 40 loads by itself, brute force; forces up to 1.5 times what the column carries."""
    design, part = rod(tmp_path)
    random = np.random.default_rng(6)
    forces = random.uniform(0, 1.5, 40) * euler_of(part, 30 * 8**3 / 12)
    couples = random.normal(0, 2e5, (2, 40))
    loads = loads_of(
        {
            "first": list(zip(forces, 0 * forces, couples[0], strict=True)),
            "second": list(zip(-forces, 0 * forces, couples[1], strict=True)),
        }
    )
    alone = []
    for k in range(40):
        one = loads_of({n: w[k : k + 1][:, [0, 1, 5]] for n, w in loads.wrenches.items()})
        alone.append(
            [check.safety for check in crooked_column.checks(LoadedPart(design, part, one))]
        )
    for k, worst in enumerate(crooked_column.checks(LoadedPart(design, part, loads))):
        assert_allclose(worst.safety, min(both[k] for both in alone), rtol=1e-8)
        assert worst.position == f"k = {int(np.argmin([both[k] for both in alone]))}"


def test_a_straight_column_beyond_its_force_is_worse_than_a_bent_one_that_yields(tmp_path):
    """1.2 times Euler's force over 3 m and nothing else: 1/1.2. The other position bends to 271 MPa
    and yields under 1.01 times its load.
    """
    design, part = rod(tmp_path, STRAIGHT, 'parts.rod.column.out_of_plane="3 m"')
    euler = pi**2 * part.material.youngs_modulus * 30 * 8**3 / 12 / 3000**2
    rows = [(1.2 * euler, 0.0), (0.1 * euler, 271 * WITHIN)]
    loads = loads_of(
        {"first": [(f, 0, -m) for f, m in rows], "second": [(-f, 0, m) for f, m in rows]}
    )
    check = crooked(design, part, loads, "out of plane")
    assert_allclose(check.safety, 1 / 1.2, rtol=1e-6)
    assert check.position == "k = 0"


def passing(shares):
    """Loads that go from a push of 20 kN to a pull of 20 kN, bent the more the less they push."""
    rows = [(2e4 * (1 - 2 * s), 1e6 * s) for s in shares]
    return loads_of(
        {"first": [(f, 0, -m) for f, m in rows], "second": [(-f, 0, m) for f, m in rows]}
    )


@pytest.mark.parametrize("shares", [(0, 1), (0, 0.3, 0.6, 1), (1, 0.51, 0.49, 0)])
def test_a_bar_is_judged_up_to_where_its_compression_ends(tmp_path, shares):
    """At half of the way nothing pushes and 500 N m bend it: 500 N m over W at any count.

    The positions that push alone had left out what lies behind the last one of them: 3.9 % of the
    quick return's crank at 73 positions.
    """
    design, part = rod(tmp_path, STRAIGHT)
    check = crooked(design, part, passing(shares), "in plane")
    assert_allclose(check.value, 5e5 / WITHIN, rtol=1e-9)
    nearest = [s for s in shares if s < 0.5]
    assert check.position == f"k = {shares.index(max(nearest))}"


def test_compression_does_not_end_between_phases_or_cycles(tmp_path):
    """There the loads jump: nothing lies between a push without and a pull with moments."""
    design, part = rod(tmp_path, STRAIGHT)
    loads = replace(passing((0, 1)), stretch_of=np.array([0, 1]))
    check = crooked(design, part, loads, "in plane")
    assert_allclose(check.value, 2e4 / AREA, rtol=1e-3)
    assert len(passing((0, 1)).steps) == 1
    assert not len(loads.steps)
    assert not len(replace(passing((0, 1)), cycle_names=("turn", "other")).steps)


@pytest.mark.parametrize("beside", ["", 'parts.rod.column.eccentricity="0.3 mm"'])
def test_stress_under_the_named_factor_is_the_yield_stress_and_nowhere_more(tmp_path, beside):
    """The formulas give it at the worst position and place, to round-off of the search."""
    design, part = rod(tmp_path, *([beside] if beside else []))
    turns = np.linspace(0, 2 * pi, 60)
    turning = [(2e4 * cos(a), 50 * sin(3 * a), 1e5 * sin(a + 1)) for a in turns]
    loads = loads_of({"first": turning, "second": [(-2e4, 0, 3e4)] * 60})
    checks = list(crooked_column.checks(LoadedPart(design, part, loads)))
    columns = crooked_columns(part, loads, planes_of(design, part))
    for column, check in zip(columns, checks, strict=True):
        strength = part.material.yield_stress
        factor, row, place = column.load_factor(strength)
        stress = column.stress(factor)
        assert_allclose(stress[row, place], strength, rtol=1e-9)
        assert stress.max() <= strength * (1 + 1e-9)
        assert_allclose(check.value, strength / factor, rtol=1e-12)
        assert_allclose(check.derivation.number("S_n"), stress[row, place], rtol=1e-12)
        assert check.derivation.equal == (("S_n", "S_y"),)


def test_the_crookedness_is_eurocodes_where_a_curve_is_stated(tmp_path):
    """EN 1993-1-1, table 5.1: L/250 for curve b, and what is stated goes first."""
    design, part = rod(tmp_path, 'parts.rod.column.curve="b"')
    assert f"crooked by {LENGTH / 250:.3g} mm (Eurocode 3, curve b)" in (
        crooked(design, part, pushed(1e3), "in plane").note
    )
    stated = 'parts.rod.column.crookedness="0.4 mm"'
    design, part = rod(tmp_path, 'parts.rod.column.curve="b"', stated)
    note = crooked(design, part, pushed(1e3), "in plane").note
    assert "crooked by 0.4 mm (stated)" in note


def test_a_more_crooked_or_eccentric_column_is_never_safer(tmp_path):
    for key in ("crookedness", "eccentricity"):
        safeties = []
        for size in (0.01, 0.1, 1, 10):
            design, part = rod(tmp_path, f'parts.rod.column.{key}="{size} mm"')
            safeties.append(crooked(design, part, pushed(2e4), "out of plane").safety)
        assert safeties == sorted(safeties, reverse=True)
        assert safeties[-1] < 0.5 * safeties[0]


def test_what_is_stated_of_a_column_must_make_sense(tmp_path):
    for key, value, words in (
        ("curve", "e", "curve"),
        ("crookedness", "0 mm", "above 0 mm"),
        ("eccentricity", "-1 mm", "at least 0 mm"),
        ("fork_stiffness", "3 N", "a stiffness against turning such as"),
    ):
        with pytest.raises(Exception, match=words):
            rod(tmp_path, f'parts.rod.column.{key}="{value}"')


def test_the_crooked_columns_check_takes_the_bodys_stated_mass(tmp_path):
    """m a L/8 at mid-length of a bar that is swung sideways, of its own and of 20 kg.

    At the load factor at which the light one yields its force is 4 % of the critical one.
    """
    heavy = [
        f"bodies.rod.{key}"
        for key in ('mass="20 kg"', 'inertia="0.05 kg m2"', 'centre="80.5, 0 mm"')
    ]
    for stated in ([], heavy):
        design, part = rod(tmp_path, STRAIGHT, *stated)
        mass = 20e-3 if stated else part.material.density * AREA * LENGTH
        swing = 1e5
        half = mass * swing / 2
        loads = loads_of({"first": [(1e3, half, 0)], "second": [(-1e3, half, 0)]})
        loads.accelerations[:, 1] = swing
        check = crooked(design, part, loads, "in plane")
        alone = 1e3 / AREA + mass * swing * LENGTH / 8 / WITHIN
        assert_allclose(part.material.yield_stress / check.safety, alone, rtol=0.05)
