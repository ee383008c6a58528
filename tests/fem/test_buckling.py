"""Buckling of solids against columns with shear, and the handbook's column strength."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fem.buckling
import fem.lowest_modes
from checks.handbook.column_curves import column_strength
from fem.buckling import (
    Buckling,
    BucklingMode,
    buckling_modes,
    mesh_bar,
    part_buckling,
)
from fem.mode_count import holding
from fem.unit_loads import InterfaceLoads
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.mesh import Interface
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink

from .blocks import TUBE, block, wrench

STEEL = Elastic(210e3, 0.3, 7.85e-9)
FORCE = 61400.0


@pytest.fixture(scope="module")
def tube():
    return solve_unit_loads(mesh_shape(TUBE, fineness=0.3), STEEL)


def state(tube, force):
    """Coefficients of a tube compressed by a force; negative pulls."""
    wrenches = {"start": wrench(force), "end": wrench(-force)}
    return tube.coefficients(wrenches, np.zeros((1, 4)))[0][:, 0]


def engesser(euler_factor, shear_share):
    """Buckling load with shear: P = Pe / (1 + Pe/(k G A)) (Timoshenko and Gere, 2nd ed., 2.17)."""
    area, inertia = 72.96, 1611.443
    euler = euler_factor * np.pi**2 * 210e3 * inertia / 250**2
    return euler / (1 + euler / (shear_share * 210e3 / 2.6 * area))


def test_a_pinned_tube_buckles_at_eulers_load_with_shear(tube):
    """k = 0.43 to 0.5 for the webs of a square tube moves the load by 0.2 %; elements of this
    size are stiff by 0.2 %: within 1 %. Without shear the load would be 1.4 % higher.
    """
    modes = buckling_modes(tube, state(tube, FORCE), tilt_held=False)
    assert {mode.plane for mode in modes} == {"in plane", "out of plane"}
    for mode in modes[:2]:
        assert_allclose(mode.factor * FORCE, engesser(1, 0.44), rtol=0.01)


def test_forks_that_hold_the_ends_against_tilting_make_the_tube_four_times_as_strong(tube):
    """Out of plane a clamped column: four times Euler's load, less the shear that then counts.

    The in-plane mode stays. k and the mesh leave 3 %.
    """
    free = buckling_modes(tube, state(tube, FORCE), tilt_held=False)
    held = buckling_modes(tube, state(tube, FORCE), tilt_held=True)
    assert held[0].plane == "in plane"
    assert_allclose(held[0].factor, free[0].factor, rtol=1e-3)
    assert_allclose(held[1].factor * FORCE, engesser(4, 0.44), rtol=0.03)
    assert 3.6 < held[1].factor / free[0].factor < 4


@pytest.mark.parametrize("tilt_held", [False, True])
def test_a_bar_buckles_alike_when_its_ends_have_each_other_s_names(tilt_held):
    """A link with a couple in one bore, held against turning where that bends it or where not.

    Both differ by 6 %, as the couple turns with the bore. The mesh is not quite its own mirror
    image: 1 %. Stiff forks hold both ends, whatever the name.
    """
    link = PlateLink(length=120.0, width=16.0, thickness=3.0, hole=8.0)
    strip = solve_unit_loads(mesh_shape(link, fineness=0.5), STEEL)
    bent_at_end = {"first": wrench(0.0, 1.0, 0.0), "second": wrench(0.0, -1.0, link.length)}
    bent_at_start = {"second": wrench(0.0, 1.0, 0.0), "first": wrench(0.0, -1.0, -link.length)}

    def share(wrenches, held):
        acting = strip.coefficients(wrenches, np.zeros((1, 4)))[0][:, 0]
        found = part_buckling(strip, acting, tilt_held=tilt_held, twist_held_at=held)
        return 1 / found.modes[0].factor

    ends = [share(bent_at_end, "second"), share(bent_at_start, "first")]
    others = [share(bent_at_end, "first"), share(bent_at_start, "second")]
    assert_allclose(ends[0], ends[1], rtol=1e-2)
    assert_allclose(others[0], others[1], rtol=1e-2)
    if tilt_held:
        assert_allclose(others, ends, rtol=1e-6)
    else:
        assert abs(others[0] / ends[0] - 1) > 0.04


def test_of_several_interfaces_the_nearest_holds_too_whatever_their_order():
    at = {"A": (0.0, 0.0), "B": (90.0, 10.0), "C": (-80.0, 0.0), "rail": (5.0, 0.0)}
    faces = [
        Interface(name, "slide" if name == "rail" else "bore", np.array([*place, 0.0]))
        for name, place in at.items()
    ]
    for order in (faces, faces[::-1]):
        loads = [InterfaceLoads(face, (), np.zeros((0, 0)), 0.0) for face in order]
        names = {name: [one.name for one in holding(loads, name)] for name in "ABC"}
        assert names == {"A": ["A", "C"], "B": ["B", "A"], "C": ["C", "A"]}


@pytest.mark.parametrize("sign", [1, -1])
def test_the_load_at_which_a_tube_buckles_does_not_depend_on_the_load_applied(tube, sign):
    """Factor times load over twelve decades and more, pushed or turned round: to 1e-10."""
    base = sign * state(tube, FORCE)
    loads = []
    for size in (1e-9, 1e-6, 1.0, 3e3, 1e6, 1e9):
        found = part_buckling(tube, base * size, tilt_held=False)
        factors = [mode.factor for mode in found.modes] if sign > 0 else [found.reversed]
        loads.append([factor * size for factor in factors])
    assert_allclose(loads, np.broadcast_to(loads[2], np.shape(loads)), rtol=1e-10)


def test_modes_are_found_again_with_any_start(tube, monkeypatch):
    """Another random start, another block: the values agree to 1e-9, pairs among them."""
    coefficients = state(tube, FORCE)
    first = part_buckling(tube, coefficients, tilt_held=False, count=4)
    monkeypatch.setattr(fem.lowest_modes, "_BLOCK", 3)
    other = part_buckling(tube, coefficients, tilt_held=False, count=4)
    factors = [[mode.factor for mode in found.modes] for found in (first, other)]
    assert_allclose(*factors, rtol=1e-9)


def test_a_tube_in_tension_does_not_buckle_and_says_when_it_would_turned_round(tube):
    """No factor up to the limit, which the count proves; the reversed one is that of the push."""
    for tilt_held in (False, True):
        pushed = part_buckling(tube, state(tube, FORCE), tilt_held=tilt_held)
        pulled = part_buckling(tube, state(tube, -FORCE), tilt_held=tilt_held)
        assert pulled.modes == ()
        assert pulled.proven == pulled.limit
        assert_allclose(pulled.reversed, pushed.modes[0].factor, rtol=1e-8)
        assert pushed.reversed is None
        assert buckling_modes(tube, state(tube, -FORCE), tilt_held=tilt_held) == []


def test_the_count_covers_the_modes_and_a_little_more(tube):
    """Both of a pair are below `proven`, the next ones are not."""
    found = part_buckling(tube, state(tube, FORCE), tilt_held=False, count=2)
    assert found.modes[1].factor < found.proven < 1.05 * found.modes[1].factor
    quick = part_buckling(tube, state(tube, FORCE), tilt_held=False, count=2, prove=False)
    assert quick.proven == 0.0
    assert [m.factor for m in quick.modes] == [m.factor for m in found.modes]


def test_one_mode_of_a_pair_is_proven_with_its_twin(tube):
    """The twin 3e-5 above is below what is proven: the field says that it equals the last."""
    found = part_buckling(tube, state(tube, FORCE), tilt_held=False, count=1)
    pair = part_buckling(tube, state(tube, FORCE), tilt_held=False, count=2)
    assert len(found.modes) == 1
    assert_allclose(found.modes[0].factor, pair.modes[0].factor, rtol=1e-9)
    assert found.proven > pair.modes[1].factor


def test_a_tube_without_load_has_no_factor(tube):
    found = part_buckling(tube, 0 * state(tube, FORCE), tilt_held=False)
    assert (found.modes, found.reversed, found.proven) == ((), None, np.inf)


@pytest.mark.parametrize(
    ("area", "inertia", "safety", "governs"),
    [
        (181.76, 24510.94, 1.030055, "Johnson"),
        (72.96, 1611.443, 0.3707291, "Johnson"),
        (1857.24, 1693611, 10.70678, "Johnson"),
    ],
)
def test_short_columns_have_the_strength_of_johnsons_parabola(area, inertia, safety, governs):
    """Tubes 30x30x1.6, 13x13x1.6, 80x80x6.3 of S355 over 250 mm at 61 398.94 N; an independent
    calculation, seven printed digits.
    """
    strength = column_strength(area, inertia, 250.0, 355.0, 210e3)
    assert_allclose(strength.critical * area / 61398.94, safety, rtol=5e-7)
    assert strength.governs == governs


def test_slender_columns_have_eulers_strength():
    """L / i = 200: pi^2 E / 200^2."""
    strength = column_strength(100.0, 100.0, 200.0, 355.0, 210e3)
    assert strength.governs == "Euler"
    assert_allclose(strength.critical, np.pi**2 * 210e3 / 200**2, rtol=1e-12)


def test_johnson_and_euler_meet_at_half_the_yield_stress():
    """At slenderness pi sqrt(2 E / R_e), with the same value on both sides."""
    at = np.pi * np.sqrt(2 * 210e3 / 355)
    below, above = (column_strength(1.0, 1.0, at * k, 355.0, 210e3) for k in (1 - 1e-9, 1 + 1e-9))
    assert (below.governs, above.governs) == ("Johnson", "Euler")
    assert_allclose([below.critical, above.critical], 355 / 2, rtol=1e-8)


def test_a_column_without_length_yields():
    strength = column_strength(100.0, 100.0, 0.0, 355.0, 210e3)
    assert strength.governs == "yield"
    assert strength.critical == 355.0


@pytest.mark.parametrize("bad", [(0, 1, 1), (1, -1, 1), (1, 1, 0)])
def test_a_column_without_section_or_strength_is_refused(bad):
    area, inertia, yield_stress = bad
    with pytest.raises(ValueError, match="must be above 0"):
        column_strength(area, inertia, 250.0, yield_stress, 210e3)


def test_a_slender_column_has_the_same_factors_from_any_start(monkeypatch):
    """Slenderness 500: 3e-14 is left; 6e-9 if the energy is x' K x by matrix."""
    column = solve_unit_loads(block((60, 2, 2), (1443.0, 10.0, 10.0)), STEEL)
    ends = {"start": wrench(1.0), "end": wrench(-1.0)}
    coefficients = column.coefficients(ends, np.zeros((1, 4)))[0][:, 0]
    found = []
    for block_size in (4, 3, 5):
        monkeypatch.setattr(fem.lowest_modes, "_BLOCK", block_size)
        modes = part_buckling(column, coefficients, tilt_held=False, count=4).modes
        found.append([mode.factor for mode in modes])
    assert_allclose(found, np.broadcast_to(found[0], np.shape(found)), rtol=1e-10)


BAR = 0.01 + 3 * 0.1 / 0.9**3  # 1 % + 3 e/(1 - e)^3 of e = 0.1


@pytest.mark.parametrize(
    ("errors", "next_factor", "bar"),
    [
        ((0.1, 0.0), 20.0, BAR),  # of the lowest mode itself
        ((0.0, 0.1), 6.0, 5.0 / 6.0 * (1 + 2 * BAR) - 1),  # one beyond those seen
        ((0.1,), None, BAR),
    ],
)
def test_a_mesh_has_the_bar_of_its_modes_errors(monkeypatch, tube, errors, next_factor, bar):
    """Of a lowest factor 5; modes beyond those seen may have twice the largest bar."""
    modes = tuple(
        BucklingMode(factor, "in plane", np.full((1, 3), error))
        for factor, error in zip((5.0, next_factor), errors, strict=False)
    )
    monkeypatch.setattr(fem.buckling, "energy_error", lambda _, shape: shape[0])
    seen = Buckling(modes, 0.0, None, 1.0)
    monkeypatch.setattr(fem.buckling, "part_buckling", lambda *_, **__: seen)
    assert_allclose(mesh_bar(tube, np.zeros(1), modes), bar, rtol=1e-12)
