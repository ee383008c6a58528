"""Change points are found between the positions, too, whatever the sign of a determinant does."""

from math import pi, radians

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import Angle, Cycle, LinkageError, Phase, SteadyPace, run_cycle, trace

from .machines import four_bar, parallel_four_bars, slider_crank, toggle, toggle_height

CRANK = Angle("C0")


def led(linkage, start, stop):
    """The linkage led by its first crank at 1 rad/s."""
    phases = (Phase("all", stop, {}, "drive"),)
    return run_cycle(linkage, Cycle("led", CRANK, start, SteadyPace(CRANK, 1.0), phases, 73))


@pytest.mark.parametrize("n", range(1, 7))
@pytest.mark.parametrize(
    ("start", "stop", "place"),
    [(60.0, -300.0, "0"), (90.0, -95.0, "0"), (90.0, 200.0, "180"), (68.0, -57.0, "0")],
)
def test_parallel_four_bars_are_refused_where_they_fold(n, start, stop, place):
    """N loops fold at once: for an even N the determinant keeps its sign.

    Four of them led from 60 to -300 degrees had passed, with 784 N m instead of 63.8 N m and 5e8 N
    in a joint. All joints on the ground take part; every loop could go on as a crossed four-bar.
    """
    linkage = parallel_four_bars(n, radians(start))
    with pytest.raises(
        LinkageError, match=rf" at {place} deg the linkage can go on in two ways"
    ) as info:
        led(linkage, radians(start), radians(stop))
    named = str(info.value).partition("change point of joints ")[2].partition(")")[0].split(", ")
    assert {f"A{k}" for k in range(n + 1)} <= set(named)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_parallel_four_bars_are_led_up_to_where_they_fold(n):
    """The torque lifts n couplers whole and n + 1 cranks by half: closed form, 34.3 N m for two.

    Couplers move along, so that the turning speed adds no torque. At one degree from the change
    point a factor of 1 / sin(1 deg) of the digits is lost.
    """
    loads = led(parallel_four_bars(n, pi / 2), pi / 2, radians(1.0))
    expected = 1e-3 * 9810.0 * 1000.0 * (n + (n + 1) / 2) * np.cos(loads.positions)
    assert_allclose(loads.efforts["drive"], expected, rtol=0, atol=1e-10 * expected.max())


@pytest.mark.parametrize("off", [1e-9, 1e-8])
def test_a_parallelogram_that_round_off_spoils_has_its_change_point(off):
    """Bars off by 1e-9 mm stay 5e-6 rad apart in the fold: no pin is made like that."""
    linkage = four_bar(40.0 - off, 100.0, 40.0, 100.0, at=pi / 3)
    with pytest.raises(LinkageError, match=r" at (180|179\.99\d*|180\.00\d*) deg .* in two ways"):
        trace(linkage, Angle("crank"), 0.1, 6.2)


def test_a_four_bar_beside_its_change_point_is_not_refused():
    """With a crank short of 0.1 mm it is a crank-rocker, which turns all the way."""
    assert len(
        trace(four_bar(39.9, 100.0, 40.0, 100.0, at=pi / 3), Angle("crank"), 0.1, 6.2).values
    )


def test_a_dead_centre_is_no_change_point():
    """A crank leads through its slider's dead centres, and a toggle comes next to its own."""
    crank = slider_crank(50.0, 200.0, slider_mass=1e-3, at=1.0)
    assert len(trace(crank, Angle("crank"), 1.0, 1.0 + 2 * pi).values) > 2
    press = toggle()
    assert len(trace(press, toggle_height(press), 300.0, 500.0 - 1e-6).values) > 2


def test_a_small_eccentric_in_a_large_linkage_is_not_taken_for_a_change_point():
    """A crank of 0.1 mm with a rod of 1 m: small singular values, but the same all round."""
    linkage = slider_crank(0.1, 1000.0, slider_mass=1e-3, at=1.0)
    path = trace(linkage, Angle("crank"), 1.0, 1.0 + 2 * pi)
    way = np.ptp(path.at(np.linspace(1.0, 1.0 + 2 * pi, 361)).poses[:, 3, 0])
    assert way == pytest.approx(0.2, rel=1e-4)


def test_a_linkage_that_no_number_of_steps_tells_from_a_change_point_is_refused(monkeypatch):
    """A pin 629 km away (a mistyped minus 629 mm) halved steps until 4 GiB of memory were gone."""
    monkeypatch.setattr("loads.path._MOST", 5)
    with pytest.raises(LinkageError, match=r"cannot be told from one that can go on in two ways"):
        trace(four_bar(39.87, 100.0, 40.0, 100.0, at=pi / 3), Angle("crank"), 0.1, 6.2)


def test_a_cycle_beyond_a_change_point_says_where_its_points_are_drawn():
    """Drawn at 90 degrees, every way to 182 degrees leads through 180: to begin there is no way."""
    with pytest.raises(
        LinkageError,
        match=r"as drawn it is 90 deg, and is led from there: draw the points within the cycle$",
    ):
        led(parallel_four_bars(1, pi / 2), radians(182.0), radians(358.0))
