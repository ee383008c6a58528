"""Bounds of a column's effective length, the other plane's part in yielding, and meshes' bars."""

from dataclasses import replace
from math import cos, pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from checks.by_formula import crooked_column
from checks.columns import stability
from checks.columns.column_limits import cases_of, planes_of, whole_force
from checks.columns.column_moments import crooked_columns, first_order
from checks.columns.stability import eigenvalue_check
from checks.part.loaded_part import LoadedPart
from fem.buckling import Buckling, BucklingMode
from tests.checks.columns.test_stability import (
    LENGTH,
    check_of,
    column_checks,
    press,
    pushed,
    rod,
)
from tests.small_machine import loads_of

AREA, WITHIN, ACROSS = (
    240.0,
    8 * 30**2 / 6,
    30 * 8**2 / 6,
)  # mm2 and both section moduli, mm3
THIN, WIDE = 30 * 8**3 / 12, 8 * 30**3 / 12  # mm4, out of the plane and in it
STRAIGHT = 'parts.rod.column.crookedness="1e-9 mm"'


def euler(part, inertia, length):
    return pi**2 * part.material.youngs_modulus * inertia / length**2


def johnson(part, radius, length):
    """Parabola of short columns, MPa."""
    strength = part.material.yield_stress
    slenderness = length / radius
    return strength - (strength * slenderness / 2 / pi) ** 2 / part.material.youngs_modulus


def with_sections(part, *sections):
    """The part with other sections between its two pins."""
    shape = SimpleNamespace(interfaces=part.geometry.interfaces, sections=sections)
    return replace(part, geometry=shape)


# bounds of the effective length ------------------------------------------------------------------


def test_a_length_in_the_plane_beyond_the_pins_is_bounded_by_that_between_them(
    tmp_path,
):
    """400 mm stated of a part of 161 mm: at best it is hinged at its own pins."""
    design, part = rod(tmp_path, 'parts.rod.column.in_plane="400 mm"')
    check = check_of(column_checks(LoadedPart(design, part, pushed(1e4))), "column in plane")
    radius = 30 / sqrt(12)
    assert_allclose(check.limit, johnson(part, radius, 400.0), rtol=1e-9)
    best = check.limit / (check.value - check.below)
    assert_allclose(best, johnson(part, radius, LENGTH) * AREA / 1e4, rtol=1e-9)


def test_a_length_in_the_plane_within_the_pins_has_no_stiffer_bound(tmp_path):
    """80 mm stated, such as of a rod that is held at its middle: hinges there, nothing better."""
    design, part = rod(tmp_path, 'parts.rod.column.in_plane="80 mm"')
    plane, section = planes_of(design, part)[0], part.geometry.sections[0]
    for stiffest in (False, True):
        force = whole_force(part, plane, section, stiffest)
        assert_allclose(force, euler(part, WIDE, 80.0), rtol=1e-9)
    assert (
        check_of(column_checks(LoadedPart(design, part, pushed(1e4))), "column in plane").below == 0
    )


@pytest.mark.parametrize(("stated", "clamped"), [(400.0, LENGTH / 2), (80.0, 40.0)])
def test_forks_at_best_clamp_the_shorter_of_the_part_and_its_stated_length(
    tmp_path, stated, clamped
):
    """A clamped column is as one of half its length with hinges."""
    design, part = rod(tmp_path, f'parts.rod.column.out_of_plane="{stated} mm"')
    plane, section = planes_of(design, part)[1], part.geometry.sections[0]
    soft, stiff = (whole_force(part, plane, section, stiffest) for stiffest in (False, True))
    assert_allclose(soft, euler(part, THIN, stated), rtol=1e-9)
    assert_allclose(stiff, euler(part, THIN, clamped), rtol=1e-9)
    check = check_of(column_checks(LoadedPart(design, part, pushed(1e4))), "column out of plane")
    best = check.limit / (check.value - check.below)
    assert_allclose(best, johnson(part, 8 / sqrt(12), clamped) * AREA / 1e4, rtol=1e-9)


def test_a_stated_fork_stiffness_holds_the_whole_stated_length_either_way(tmp_path):
    """Two parts in a row, 322 mm: what is known of the forks leaves no band."""
    column = 'parts.rod.column={out_of_plane="322 mm", fork_stiffness="2 N m/rad"}'
    design, part = rod(tmp_path, column)
    plane, section = planes_of(design, part)[1], part.geometry.sections[0]
    soft, stiff = (whole_force(part, plane, section, stiffest) for stiffest in (False, True))
    assert_allclose(soft, euler(part, THIN, 322.0), rtol=0.01)  # 2 N m/rad are next to nothing
    assert stiff == soft
    assert (
        check_of(column_checks(LoadedPart(design, part, pushed(1e4))), "column out of plane").below
        == 0
    )


def test_a_section_s_own_free_length_is_at_best_that_between_the_pins(tmp_path):
    """Own lengths of 100 and 300 mm in a part of 161 mm: the first stays, the second ends there."""
    design, part = rod(tmp_path)
    (plate,) = part.geometry.sections
    short, long = (replace(plate, length_out_of_plane=length) for length in (100.0, 300.0))
    plane = planes_of(design, part)[1]
    both = with_sections(part, short, long)
    assert [case.length for case in cases_of(both, plane)] == [100.0, 300.0]
    stiffest = [case.length for case in cases_of(both, plane, stiffest=True)]
    assert_allclose(stiffest, [100.0, LENGTH], rtol=1e-12)


# steps -------------------------------------------------------------------------------------------


def test_two_bars_with_their_weak_ends_at_the_knee_are_weaker_than_with_them_outside():
    """In the plane nothing racks: cheeks of 0.54 over a tube of 1.70 x 1e6 mm4, 32 of 500 mm.

    The half wave's curvature over the cheeks gives by Rayleigh 1/F = 1/F_tube (1 + (1.70/0.54 - 1)
    x 2/L x integral of sin^2), above the truth by its second order.
    """
    design, part, _ = press("toggle_press", 'parts.bar_upper.column.in_plane="500 mm"')
    tube, cheeks = part.geometry.sections
    plane = planes_of(design, part)[0]
    even = euler(part, tube.inertia_in_plane, 500.0)
    bent = 32 / 500 + np.sin(pi * 32 / 500) / pi  # both cheeks at mid-length
    weaker = 1 + (tube.inertia_in_plane / cheeks.inertia_in_plane - 1) * bent
    assert_allclose(whole_force(part, plane, tube), even / weaker, rtol=0.02)
    assert 1 / weaker < 0.8  # with the cheeks outside, 0.998


def test_a_part_weak_beside_its_middle_is_weakest_as_one_column_of_its_shape(tmp_path):
    """Second quarter of 1/4 the stiffness over 2 L: 1 + 3 x 0.409 in one, 0.343 at best in two."""
    design, part = rod(tmp_path, f'parts.rod.column.out_of_plane="{2 * LENGTH} mm"')
    (plate,) = part.geometry.sections
    cuts = np.array([0, 0.25, 0.5, 1]) * LENGTH
    sections = [
        replace(
            plate,
            name=f"{k}",
            stretch=(cuts[k], cuts[k + 1]),
            inertia_out_of_plane=THIN / (4 if k == 1 else 1),
        )
        for k in range(3)
    ]
    plane = planes_of(design, part)[1]
    force = whole_force(with_sections(part, *sections), plane, plate)
    even = euler(part, THIN, 2 * LENGTH)
    share = 0.25 + 1 / (2 * pi)  # 2 x integral of sin^2 from 1/4 to 1/2
    assert 0.93 < force * (1 + 3 * share) / even < 1  # Rayleigh's is above
    as_two = 2 * (0.125 + (1 - sqrt(0.5)) / (2 * pi))
    assert force < 0.95 * even / (1 + 3 * as_two)


def test_of_sections_that_tell_no_stretch_the_weakest_is_the_crooked_column(tmp_path):
    design, part = rod(tmp_path)
    (plate,) = part.geometry.sections
    weak = replace(plate, name="weak", inertia_out_of_plane=THIN / 2)
    planes = planes_of(design, part)
    _, across = crooked_columns(with_sections(part, plate, weak), pushed(1.0), planes)
    assert_allclose(across.critical[0], euler(part, THIN / 2, LENGTH), rtol=1e-9)


def test_inertia_of_a_stepped_bar_is_where_its_area_is(tmp_path):
    """w over the first half and 3 w over the second: (2 w + 3 w) L^2/32 at the first quarter,
    (w + 6 w) L^2/32 at the last. The step lies on one of 129 places: 1 %.
    """
    _, part = rod(tmp_path)
    (plate,) = part.geometry.sections
    swing, half = 3e5, LENGTH / 2
    line = part.material.density * AREA * swing
    stepped = with_sections(
        part,
        replace(plate, stretch=(0.0, half)),
        replace(plate, stretch=(half, LENGTH), area=3 * AREA),
    )
    ends = [(0, 6 * line * LENGTH / 8, 0)], [(0, 10 * line * LENGTH / 8, 0)]
    loads = loads_of(dict(zip(("first", "second"), ends, strict=True)))
    loads.accelerations[:, 1] = swing
    moment = np.abs(first_order(stepped, loads, LENGTH)[0].moments[0])
    assert_allclose(moment[[32, 96]] / (line * LENGTH**2 / 32), [5, 7], rtol=0.02)


# the other plane ---------------------------------------------------------------------------------


def test_a_bar_crooked_in_the_plane_yields_by_couples_out_of_it_as_these_grow_there(
    tmp_path,
):
    """Straight, half of Euler's force out of the plane, equal couples about y: F/A +
    M/W sec(pi/2 sqrt(F/F_out)) = S_y. In the plane F is 1/28 of Euler's force.
    """
    design, part = rod(tmp_path, STRAIGHT, 'parts.rod.material="42CrMo4"')
    out = euler(part, THIN, LENGTH)
    force, couple = 0.4 * out, 2e4
    loads = pushed(force)
    loads.wrenches["first"][:, 4], loads.wrenches["second"][:, 4] = -couple, couple

    def over(factor):
        secant = 1 / cos(pi / 2 * sqrt(factor * force / out))
        stress = factor * (force / AREA + couple / ACROSS * secant)
        return stress - part.material.yield_stress

    expected = brentq(over, 0, out / force * (1 - 1e-9))
    for plane in ("in plane", "out of plane"):
        check = check_of(
            crooked_column.checks(LoadedPart(design, part, loads)), f"crooked bar {plane}"
        )
        assert_allclose(check.safety, expected, rtol=1e-3)
        own = out if plane == "out of plane" else euler(part, WIDE, LENGTH)
        assert f"F/F_cr {force / own:.3g}," in check.note


# eigenvalues -------------------------------------------------------------------------------------


def asked(monkeypatch, folder, first, finer=None, turned=None, held=None, bar=0.3):
    """The check of a rod whose lowest factors are given: first mesh, finer mesh, stiff forks."""

    def buckling(factor, turned=None, proven=np.inf):
        modes = () if factor is None else (BucklingMode(factor, "in plane", np.zeros((1, 3))),)
        return Buckling(modes, proven, turned, np.inf)

    def at(solutions, state, *, tilt_held, twist_held_at):
        return buckling(held if tilt_held else finer)

    def worst(*given, **named):
        return 0, buckling(first, turned)

    monkeypatch.setattr(stability, "worst_buckling", worst)
    monkeypatch.setattr(stability, "buckling_at", at)
    monkeypatch.setattr(stability, "mesh_bar", lambda *given, **named: bars.pop(0))
    bars = list(np.atleast_1d(bar))
    bars += bars
    design, part = rod(folder)
    level = SimpleNamespace(ties=None, interfaces=("first", "second")), np.zeros((1, 1))
    levels = [level] if finer is None else [level, level]
    check, mode = eigenvalue_check(LoadedPart(design, part, pushed(1e3)), levels, 0)
    return check, mode, design.require.buckling


@pytest.mark.parametrize(("finer", "bar"), [(0.02, 0.05), (0.08, 0.08)])
def test_two_meshes_have_the_change_between_them_as_bar_or_the_finer_ones_own(
    tmp_path, monkeypatch, finer, bar
):
    """5 % less on the finer mesh: its factor decides, 5 % either way, or what it has itself."""
    check, mode, required = asked(monkeypatch, tmp_path, 3.0, 3.0 * 0.95, bar=[0.3, finer])
    assert required == 3.0  # what makes the first mesh's bar of 0.3 leave it open
    assert check.method == "solid (two meshes)"
    assert check.value == pytest.approx(1 / 2.85)
    assert check.numerical == pytest.approx(bar / 2.85)
    assert mode.factor == 3.0 * 0.95


def test_a_mesh_alone_has_the_bar_of_its_modes_error(tmp_path, monkeypatch):
    check, mode, _ = asked(monkeypatch, tmp_path, 100.0, bar=0.6)
    assert check.method == "solid (one mesh)"
    assert check.numerical == pytest.approx(0.6 / 100)
    assert mode.factor == 100.0


def test_forks_that_hold_the_ends_are_a_band_below_the_load_share(tmp_path, monkeypatch):
    """1/3 with ends free to tilt, 1/12 with forks that hold them, alike on two meshes."""
    check, *_ = asked(monkeypatch, tmp_path, 3.0, 3.0, held=12.0, bar=[0.3, 0.0])
    assert check.value - check.below == pytest.approx(1 / 12)
    assert "against tilting 12" in check.note
    far, *_ = asked(monkeypatch, tmp_path, 100.0, held=400.0)
    assert far.below == 0
    assert "against tilting not asked" in far.note


def test_loads_turned_round_are_told_only_where_they_would_buckle_it_earlier(tmp_path, monkeypatch):
    words = "with all loads turned round it would buckle at"
    pulled, *_ = asked(monkeypatch, tmp_path, 40.0, turned=2.5)
    assert f"{words} 2.5 of them" in pulled.note
    for turned in (None, 400.0):
        pushed_rod, *_ = asked(monkeypatch, tmp_path, 40.0, turned=turned)
        assert "turned round" not in pushed_rod.note
