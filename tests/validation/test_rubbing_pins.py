"""Stress of a pin that rubs where it presses, beside an even shear with the same couple."""

import numpy as np
import pytest

from checks.strength.load_doubts import _GROWTH, _MOST_SWING, _ON_NARROW, _STEADY, _SWING

from .plane.domains import Fine, Outline, Piece, meshed
from .plane.model import PlaneModel

R, HALF, LENGTH = 8.0, 20.0, 80.0  # mm: hole, half width, pin to the clamped end
RUBS = 0.1


def strip(half, size=0.4):
    """A strip with a round end about the hole, held at its other end; elements there, mm."""
    outer = (
        Piece((-LENGTH, -half), "side"),
        Piece((0.0, -half), "end", (0.0, 0.0)),
        Piece((half, 0.0), "end", (0.0, 0.0)),
        Piece((0.0, half), "side"),
        Piece((-LENGTH, half), "held"),
    )
    ways = ((1, 0), (0, -1), (-1, 0), (0, 1))
    hole = tuple(Piece((R * x, R * y), "hole", (0.0, 0.0)) for x, y in ways)
    outline = Outline((outer, hole), 8.0, (Fine(("hole",), size, 12.0),))
    return PlaneModel(meshed(outline), 210e3, 0.3).held({"held": (0.0, 0.0)})


@pytest.fixture(scope="module")
def held():
    return strip(HALF)


def stresses(held, towards, arc, rubs, *, even):
    """Stress (n, 4) on the hole under 1 N and the friction's couple, and that couple over R.

    towards, arc  rad, of the force and of the cosine
    even          the couple is an even shear, else shear is `rubs` times the pressure, which moves
                  round by the angle of friction and keeps the force
    """
    turned = towards if even else towards - np.arctan(rubs)
    t = np.linspace(-arc / 2, arc / 2, 4001)
    around = np.cos(np.pi * t / arc)
    peak = 1 / (R * np.trapezoid(around * np.cos(t), t))
    peak /= 1.0 if even else np.hypot(1.0, rubs)
    couple = rubs * np.trapezoid(around, t) * R * peak / (np.hypot(1.0, rubs) if even else 1.0)

    def traction(points, _normals):
        angle = np.arctan2(points[..., 1], points[..., 0])
        away = (angle - turned + np.pi) % (2 * np.pi) - np.pi
        radial = points / np.linalg.norm(points, axis=-1)[..., None]
        tangent = np.stack([-radial[..., 1], radial[..., 0]], axis=-1)
        pressed = peak * np.where(np.abs(away) < arc / 2, np.cos(np.pi * away / arc), 0.0)
        shear = couple / (2 * np.pi * R) if even else rubs * pressed
        return radial * pressed[..., None] + tangent * np.asarray(shear)[..., None]

    model = held.model
    load = model.loads({"hole": traction})
    want = np.array([np.cos(towards), np.sin(towards)])
    assert np.abs(load.reshape(-1, 2).sum(axis=0) - want).max() < 5e-3
    return held.solve(load).stress[model.mesh.edge_nodes("hole")], abs(couple)


def mises(stress):
    xx, yy, _, xy = stress.T
    return np.sqrt(xx**2 - xx * yy + yy**2 + 3 * xy**2)


def amplitude(one, other):
    """Goodman amplitude of equal safety, with a quarter of the ultimate stress as endurance."""
    xx, yy, _, xy = ((one + other) / 2).T
    mean = (xx + yy) / 2 + np.hypot((xx - yy) / 2, xy)
    return (mises((one - other) / 2) + 0.25 * np.maximum(mean, 0.0)).max()


def added(held, arc, rubs):
    """Largest of a peak, of a swing to and fro, and of one from 0: over m and the even peak; m."""
    steady = swing = coming = 0.0
    for towards in np.radians(range(0, 181, 30)):
        found = {}
        for even in (True, False):
            plus, couple = stresses(held, towards, np.radians(arc), rubs, even=even)
            minus, _ = stresses(held, towards, np.radians(arc), -rubs, even=even)
            found[even] = (
                max(mises(plus).max(), mises(minus).max()),
                amplitude(plus, minus),
                max(amplitude(plus, 0 * plus), amplitude(minus, 0 * plus)),
            )
        share = couple * found[True][0]
        more = [(a - b) / share for a, b in zip(found[False], found[True], strict=True)]
        steady, swing, coming = max(steady, more[0]), max(swing, more[1]), max(coming, more[2])
    return steady, swing, coming, couple


@pytest.mark.parametrize("arc", [180, 90])
def test_bands_hold_what_rubbing_adds(held, arc):
    """Over all directions of the force, beside the series: 0.5 m of a peak, 1.1 of a swing."""
    steady, swing, coming, _ = added(held, arc, RUBS)
    assert 0.25 * _STEADY < steady < _STEADY
    assert 0.6 < swing < 1.2 < _SWING
    assert coming < _SWING / 2  # half of the couple's range is half of it


@pytest.fixture(scope="module")
def finely():
    return strip(HALF, 0.15)


@pytest.mark.parametrize(("arc", "rubs"), [(60, 0.1), (30, 0.05), (20, 0.3)])
def test_bands_on_narrow_arcs_hold_what_rubbing_adds(finely, arc, rubs):
    """The angle of friction moves the pressure by much of its arc: 2, 4.2 and 1.8 m of a swing."""
    steady, swing, coming, m = added(finely, arc, rubs)
    most = min(_SWING * (90 / arc) ** _GROWTH, _MOST_SWING / m)
    assert 0.2 < steady < _ON_NARROW
    assert 0.8 * most < swing < most
    assert coming < most / 2


def test_a_steady_force_that_turns_in_its_bore_has_zero_in_the_range_of_its_friction():
    """The couple does not change, but what a rubbing pin adds comes and goes at every point.

    Wide plate, arc of 90 degrees: a turn of the force by 220 degrees has 0.64 m of the peak more.
    """
    held, amplitudes = strip(60.0), {}
    for even in (True, False):
        one, two = (
            stresses(held, np.radians(way), np.pi / 2, RUBS, even=even) for way in (60, 280)
        )
        amplitudes[even] = amplitude(one[0], two[0])
        share = one[1] * max(mises(one[0]).max(), mises(two[0]).max())
    assert 0.6 < (amplitudes[False] - amplitudes[True]) / share < _SWING / 2
