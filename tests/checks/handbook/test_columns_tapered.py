"""Columns with steps, tapers, springs and shear against BK-01, BK-02, BK-04 and BK-05."""

from math import inf, pi, tan

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from bench.closed_forms import engesser_force
from checks.handbook.tapered_columns import (
    CLAMPED,
    FREE,
    GAUSS,
    HINGED,
    ColumnEnd,
    ColumnShape,
    _counter,
    critical_force,
    least_critical_force,
)

EXACT = 1e-9  # ten digits are printed; the force is bracketed to 1e-13


def even(bending=1.0, length=1.0, shear=inf):
    return ColumnShape.stepped([length], [bending], [shear])


@pytest.mark.parametrize(
    ("start", "end", "force"),
    [
        (HINGED, HINGED, 20726.16924),
        (CLAMPED, FREE, 5181.542311),
        (CLAMPED, CLAMPED, 82904.67697),
        (CLAMPED, HINGED, 42400.52997),
    ],
)
def test_an_even_column_buckles_at_eulers_force(start, end, force):
    """BK-01: E = 210000 MPa, I = 10000 mm4, L = 1000 mm; either way round."""
    shape = even(2.1e9, 1000.0)
    assert_allclose(critical_force(shape, start, end), force, rtol=EXACT)
    assert_allclose(critical_force(shape, end, start), force, rtol=EXACT)


def test_a_clamped_end_is_the_limit_of_a_stiff_spring_and_a_hinge_of_a_soft_one():
    """In between: with springs c at both ends, tan(u) = -2 u B/(c L), u = sqrt(F/B) L/2."""
    for stiffness in (1e-3, 1.0, 30.0, 1e4):
        u = brentq(lambda u, c=stiffness: tan(u) + 2 * u / c, pi / 2 + 1e-9, pi)
        spring = ColumnEnd(stiffness)
        assert_allclose(critical_force(even(), spring, spring), (2 * u) ** 2, rtol=EXACT)
    assert_allclose(critical_force(even(), ColumnEnd(1e12), ColumnEnd(1e12)), 4 * pi**2, rtol=1e-9)


def test_a_shear_flexible_column_buckles_at_engessers_force():
    """BK-02, and a column whose shear stiffness is a twentieth of its Euler force."""
    shear = 5 / 6 * 200 * 210e3 / 2.6
    shape = even(210e3 * 10 * 20**3 / 12, 100.0, shear)
    assert_allclose(critical_force(shape), 1253119.556, rtol=EXACT)
    assert_allclose(critical_force(even(shear=0.5)), engesser_force(pi**2, 0.5), rtol=EXACT)


def test_stepped_columns_have_the_published_force():
    """BK-04, roots of the matching equations."""
    found = critical_force(ColumnShape.stepped([0.5, 0.5], [1, 0.5]), CLAMPED, FREE)
    assert_allclose(found, 2.067232897, rtol=EXACT)
    found = critical_force(ColumnShape.stepped([0.25, 0.5, 0.25], [0.4, 1, 0.4]))
    assert_allclose(found, 7.605976316, rtol=EXACT)


@pytest.mark.parametrize(("power", "force"), [(2, 1.591198665), (3, 1.533986952), (4, 1.505084814)])
def test_tapered_columns_have_the_published_force_and_converge_by_fourth_order(power, force):
    """BK-05: cantilever, load at the thin end, I1/I2 = 0.2. 1e-6 with 16 stretches."""
    thin = 0.2 ** (1 / power)

    def error(stretches):
        size = 1 / stretches
        middle = (np.arange(stretches) + 0.5) * size
        places = np.stack([middle - GAUSS * size, middle + GAUSS * size], axis=-1)
        bending = (thin + (1 - thin) * places) ** power
        shape = ColumnShape(np.full(stretches, size), bending, np.full(stretches, inf))
        return abs(critical_force(shape, FREE, CLAMPED) / force - 1)

    assert error(16) < 1e-6
    assert_allclose(np.log2(error(8) / error(16)), 4, atol=0.3)
    assert error(64) < 5e-9


def count_below(shape, force, start=HINGED, end=HINGED):
    counter = _counter(shape, start, end)
    return counter.below(force / counter.unit)


@pytest.mark.parametrize("pieces", [1, 3, 10])
def test_every_critical_force_is_counted_however_the_column_is_cut(pieces):
    """n^2 pi^2 hinged; (2 n - 1)^2 pi^2/4 for a cantilever; 4 n^2 pi^2 and tan u = u clamped."""
    shape = ColumnShape.stepped([1 / pieces] * pieces, [1.0] * pieces)
    for n in range(1, 8):
        for nudge, expected in ((1 - 1e-6, n - 1), (1 + 1e-6, n)):
            assert count_below(shape, nudge * (n * pi) ** 2) == expected
            tip = nudge * ((2 * n - 1) * pi / 2) ** 2
            assert count_below(shape, tip, CLAMPED, FREE) == expected
    roots = sorted(
        [(2 * n * pi) ** 2 for n in (1, 2, 3)]
        + [(2 * brentq(lambda u: tan(u) - u, n * pi, (n + 0.4999) * pi)) ** 2 for n in (1, 2, 3)]
    )
    for k, root in enumerate(roots):
        for nudge, expected in ((1 - 1e-6, k), (1 + 1e-6, k + 1)):
            assert count_below(shape, nudge * root, CLAMPED, CLAMPED) == expected


def test_a_step_that_changes_nothing_changes_nothing():
    one, many = even(), ColumnShape.stepped([0.3, 0.01, 0.69], [1, 1, 1])
    assert_allclose(critical_force(many), critical_force(one), rtol=EXACT)


def test_the_least_of_several_columns_is_found_in_any_order():
    """Also of one that gives way by shear at 0.5, below the others' pi^2."""
    columns = [even(2.0), even(1.0), even(3.0), even(1.5, shear=8.0)]
    weakest = min(map(critical_force, columns))
    assert least_critical_force(columns) == weakest
    assert least_critical_force(columns[::-1]) == weakest
    stiff_in_bending = even(1e6, shear=0.5)
    for both in ([even(), stiff_in_bending], [stiff_in_bending, even()]):
        assert_allclose(least_critical_force(both), 0.5, rtol=1e-5)


def test_a_very_soft_stretch_is_a_hinge_with_a_spring():
    """Two stiff halves on a spring B/l at mid-length: F = 4 c/L."""
    soft = 1e-5
    shape = ColumnShape.stepped([0.4995, 0.001, 0.4995], [1, soft, 1])
    assert_allclose(critical_force(shape), 4 * soft / 0.001, rtol=0.01)


def test_the_lowest_force_is_found_where_many_lie_close_above():
    """Twenty soft pieces between stiff ones bend as one column of their mean flexibility.

    1/B = 0.8 + 0.2/0.01: 0.4745 B/L^2, to 1 % with pieces of a twentieth of the length.
    """
    lengths, bending = [0.04, 0.01] * 20, [1.0, 1e-2] * 20
    shape = ColumnShape.stepped(lengths, bending)
    found = critical_force(shape)
    assert_allclose(found, pi**2 / (0.8 + 0.2 / 1e-2), rtol=0.01)
    finer = ColumnShape.stepped(
        np.repeat(np.array(lengths) / 7, 7).tolist(), np.repeat(bending, 7).tolist()
    )
    assert_allclose(critical_force(finer), found, rtol=1e-6)


def test_a_stretch_that_gives_way_by_shear_bounds_the_force():
    """Rigid in bending, the column fails at its shear stiffness; less is carried by both."""
    shape = ColumnShape.stepped([0.45, 0.1, 0.45], [1e3, 1e3, 1e3], [inf, 7.0, inf])
    found = critical_force(shape)
    assert 0.99 * 7.0 < found <= 7.0


def test_size_and_units_do_not_matter():
    """Force goes with B/L^2 over 24 decades."""
    for factor in (1e-12, 1e12):
        shape = ColumnShape.stepped([1e-3, 2e-3], [factor, 3 * factor])
        wanted = critical_force(ColumnShape.stepped([1.0, 2.0], [1.0, 3.0])) * factor * 1e6
        assert_allclose(critical_force(shape), wanted, rtol=1e-11)


def test_a_column_is_the_same_from_its_other_end_and_longer_with_another_one():
    shape = ColumnShape.stepped([1.0, 2.0], [1.0, 3.0])
    assert_allclose(
        critical_force(shape.turned(), HINGED, CLAMPED), critical_force(shape, CLAMPED, HINGED)
    )
    # the mirrored half of a hinged column is one whose middle does not turn
    twice = shape.followed_by(shape.turned())
    clamped_free = critical_force(shape.turned(), CLAMPED, FREE)
    assert_allclose(critical_force(twice), clamped_free, rtol=1e-10)
    assert_allclose(critical_force(shape.over(6.0)), critical_force(shape) / 4, rtol=1e-10)


@pytest.mark.parametrize(("start", "end"), [(HINGED, FREE), (FREE, FREE), (CLAMPED, FREE)])
def test_a_column_that_moves_without_bending_is_refused(start, end):
    if start is CLAMPED:
        assert critical_force(even(), start, end) > 0
        return
    with pytest.raises(ValueError, match="moves without bending: hold both ends sideways"):
        critical_force(even(), start, end)


@pytest.mark.parametrize(
    ("lengths", "bending", "shear", "words"),
    [
        ([1.0, 0.0], [1.0, 1.0], None, "lengths must be above 0"),
        ([1.0], [-1.0], None, "bending must be above 0"),
        ([1.0], [1.0], [0.0], "shear stiffness must be above 0"),
        ([], [], None, "n > 0"),
        ([1.0, 1.0], [1.0], None, "needs lengths"),
    ],
)
def test_what_is_no_column_is_refused(lengths, bending, shear, words):
    with pytest.raises(ValueError, match=words):
        ColumnShape.stepped(lengths, bending, shear)
