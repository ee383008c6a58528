"""Bars that are bent aside and twist, against closed forms."""

from math import atan2, pi, sin, sqrt, tan

import numpy as np
import pytest

from checks.handbook.lateral_buckling import (
    Acting,
    Chain,
    LateralBar,
    Pressed,
    Stiffness,
    bore_pressure,
    interpolated,
)
from geometry.roots import root

BENDING, TWISTING, LENGTH = 3e6, 2e6, 200.0


def even(x):
    ones = np.ones_like(x)
    return Stiffness(BENDING * ones, TWISTING * ones, 0.0 * ones, 0.0 * ones)


def bar(held=(0.0, LENGTH), nodes=9, **changed):
    chain = Chain(np.linspace(0.0, LENGTH, nodes), even)
    return LateralBar([chain], [(0, place) for place in held], **changed)


def loaded(one, axial=0.0, moment=0.0, shear=0.0):
    """The same at two positions, the second one with twice the loads."""
    x = one.chains[0].points[:, None]
    twice = np.array([1.0, 2.0])
    parts = ((part(x) if callable(part) else part + 0 * x) for part in (axial, moment, shear))
    return [Acting(*(part * twice for part in parts))]


def test_a_pushed_bar_is_eulers_column():
    """And the position with twice the push is the worst."""
    share, position = bar().worst(loaded(bar(), axial=-10.0), [])
    assert position == 1
    assert share == pytest.approx(20.0 * LENGTH**2 / pi**2 / BENDING, rel=1e-4)


def test_a_pulled_bar_does_not_buckle():
    assert bar().worst(loaded(bar(), axial=10.0), []) == (0.0, 0)


def test_an_end_beyond_its_support_sways():
    """Hinged at 0, held at a, pushed at its free end: cot ka + cot kb = 1/(k a), b beyond a."""
    a, b = 120.0, LENGTH - 120.0
    k = root(lambda k: 1 / tan(k * a) + 1 / tan(k * b) - 1 / (k * a), 0.5 / a, 0.9 * pi / a, 1e-13)
    one = bar(held=(0.0, a), nodes=21)
    share, _ = one.worst(loaded(one, axial=-10.0), [])
    assert share == pytest.approx(20.0 / (k**2 * BENDING), rel=1e-4)


@pytest.mark.parametrize(
    ("couple", "angle"),
    [("along x", pi), ("all round", None)],
)
def test_a_couple_at_the_end_that_twists(couple, angle):
    """E I w'''' + M t'' = 0, G J t' = M w' + C; w = 0 at both ends, t = 0 at the first only.

    Forces along x leave G J t' = M w' at the end, so sin(c) = 0 with c = M L/sqrt(E I G J). Half of
    them across (friction all round a bore) leave half of it: tan(c) = -c/3.
    """
    one = bar(nodes=17)
    pressed = []
    if couple == "all round":
        angle = root(lambda c: sin(c) + c / 3 * np.cos(c), 2.0, 3.0, 1e-13)
        wrench = np.zeros((2, 6))
        wrench[:, 5] = -7.0, -14.0  # of the end, under M = -7 all along
        start = Pressed(0, 0.0, bore_pressure(0.0, -wrench))
        pressed = [start, Pressed(0, LENGTH, bore_pressure(0.0, wrench))]
    share, _ = one.worst(loaded(one, moment=-7.0), pressed)
    assert share == pytest.approx(14.0 * LENGTH / angle / sqrt(BENDING * TWISTING), rel=2e-4)


def test_a_cantilever_under_a_force_at_its_tip():
    """4.013 sqrt(B C)/l^2: Timoshenko and Gere, 2nd ed., 6.3. Clamped by a stiff stretch before."""
    clamp = 50.0

    def clamped(x):
        own, factor = even(x), np.where(x < clamp, 1e6, 1.0)
        return Stiffness(own.bending * factor, own.twisting * factor, own.warping, own.gyration)

    nodes = np.r_[0.0, clamp / 2, np.geomspace(0.02, LENGTH - clamp, 25) + clamp, clamp]
    nodes.sort()  # cubics of t do not jump in slope, as it does at the clamp
    one = LateralBar([Chain(nodes, clamped)], [(0, 0.0), (0, clamp)])
    x = one.chains[0].points[:, None]
    moment = np.where(x > clamp, LENGTH - x, (LENGTH - clamp) / clamp * x)
    shear = np.where(x > clamp, 1.0, -(LENGTH - clamp) / clamp)
    share, _ = one.worst([Acting(0 * x, moment, shear)], [])
    assert share == pytest.approx(
        (LENGTH - clamp) ** 2 / 4.013 / sqrt(BENDING * TWISTING), rel=1e-3
    )


def test_a_half_cosine_hangs_its_bore_on_the_pin():
    """A twist lifts what presses outwards: 8/(3 pi) F r along the force, 4/(3 pi) F r across it."""
    sums = bore_pressure(6.0, np.array([[0.0, -pi, 0.0, 0.0, 0.0, 2.0], [3.0, 4.0, 0, 0, 0, 0]]))
    assert sums[:, 0] == pytest.approx([8.0, 1.0, 16.0])
    xx, xy, yy = sums[:, 1]
    assert xx + yy == pytest.approx(4 / pi * 5.0 * 6.0)
    assert atan2(2 * xy, xx - yy) / 2 == pytest.approx(atan2(4, 3))


def test_two_values_at_one_place_count_on_their_own_sides():
    places, values = np.array([0.0, 1.0, 1.0, 2.0]), np.array([[0.0], [2.0], [5.0], [7.0]])
    found = interpolated(places, values, np.array([-1.0, 0.5, 1 - 1e-9, 1 + 1e-9, 3.0]))
    assert found[:, 0] == pytest.approx([0.0, 1.0, 2.0, 5.0, 7.0])


def test_rails_that_stand_apart_twist_as_a_pair():
    """Two rails joined at stiff ends: their axial pair M/a works on w' t' as the moment does.

    Nothing joins them between, so that their own torsion does not hold the pair: they have none.
    """
    apart, middle = 20.0, np.linspace(50.0, 150.0, 9)
    ends = (np.linspace(0.0, 50.0, 5), np.linspace(150.0, LENGTH, 5))

    def stiff(x):
        ones = np.ones_like(x)
        return Stiffness(1e3 * BENDING * ones, 1e3 * TWISTING * ones, 1e9 * ones, 0.0 * ones)

    def half(x):
        own = even(x)
        return Stiffness(own.bending / 2, 1e-6 * own.twisting, own.warping, own.gyration)

    chains = [Chain(ends[0], stiff), Chain(ends[1], stiff)]
    chains += [Chain(middle, half, side * apart / 2) for side in (1.0, -1.0)]
    pair = LateralBar(
        chains,
        [(0, 0.0), (1, LENGTH)],
        [(k, at, branch) for k, at in ((0, 50.0), (1, 150.0)) for branch in (2, 3)],
    )
    acting = []
    for k, chain in enumerate(chains):
        ones = np.ones((len(chain.points), 1))
        if k < 2:
            acting.append(Acting(0 * ones, 100.0 * ones, 0 * ones))
        else:
            acting.append(Acting((-1.0 if k == 2 else 1.0) * 100.0 / apart * ones, 0 * ones,
                                 0 * ones))  # fmt: skip
    share, _ = pair.worst(acting, [])

    def between(x):
        """The same as one bar, whose rails' bending apart is its warping, B (a/2)^2."""
        own, inside = even(x), (x > 50.0) & (x < 150.0)
        rails = np.where(inside, BENDING * apart**2 / 4, 1e9)
        twisting = own.twisting * np.where(inside, 2e-6, 1e3)
        return Stiffness(own.bending * np.where(inside, 1.0, 1e3), twisting, rails, own.gyration)

    whole = Chain(np.unique(np.r_[ends[0], middle, ends[1]]), between)
    one = LateralBar([whole], [(0, 0.0), (0, LENGTH)])
    ones = np.ones((len(whole.points), 1))
    wanted, _ = one.worst([Acting(0 * ones, 100.0 * ones, 0 * ones)], [])
    assert share == pytest.approx(wanted, rel=1e-3)
