"""Close to dead centres and at small transmission angles: right to a stated tolerance, or refused.

The links are massless, so that virtual work gives the one effort for the other in closed form.
Errors grow as the rounding of lengths over the square of the angle that is left.
"""

from math import asin, cos, degrees, pi, radians, sin, sqrt, tan

import numpy as np
import pytest

from loads import Angle, LinkageError

from .machines import four_bar, slider_crank
from .readings import solved
from .test_textbook_linkages import slider_toggle

CRANK = Angle("crank")


def near(linkage, angle, given, solve, coordinate=CRANK, speed=1.0):
    return solved(linkage, coordinate, angle, speed, given, solve, margin=0.1 * abs(angle))


@pytest.mark.parametrize("angle", [1e-2, 1e-3, 1e-4, 1e-5, 3e-6])
def test_a_toggle_close_to_its_dead_centre_follows_the_closed_form(angle):
    """Q / (2 tan phi); measured 2e-16 down to 3e-6 rad: the angle itself is swept."""
    _, solution = near(slider_toggle(0.05), angle, {"knee": 100.0}, "hold", Angle("first"))
    assert solution.efforts["hold"][0] == pytest.approx(50.0 / tan(angle), rel=1e-14)


@pytest.mark.parametrize("angle", [1e-6, 1e-7])
def test_a_toggle_still_closer_is_refused_with_force_coordinate_and_position(angle):
    """The mould sees less than 1e-6 of the motion: what is left of a force is rounding."""
    with pytest.raises(
        LinkageError, match=rf"'hold' cannot balance .* {degrees(angle):.7g} deg.* -S\.x"
    ):
        near(slider_toggle(0.05), angle, {"knee": 100.0}, "hold", Angle("first"))


@pytest.mark.parametrize("angle", [1e-2, 1e-3, 1e-4, 1e-5])
def test_a_centred_slider_crank_close_to_in_line_follows_the_closed_form(angle):
    """Push = -torque / (dx / dth2), dx/dth2 = -R2 sin (1 + R2 cos / (R3 cos th3)).

    Measured 2e-16; from 1e-6 rad on refused, as is the toggle.
    """
    crank, rod = 0.1, 0.15
    level = cos(asin(crank * sin(angle) / rod))
    slope = -crank * sin(angle) * (1.0 + crank * cos(angle) / (rod * level))
    _, solution = near(slider_crank(crank, rod, at=angle), angle, {"drive": 1.0}, "push")
    assert solution.efforts["push"][0] == pytest.approx(-1.0 / slope, rel=1e-14)


@pytest.mark.parametrize("angle", [1e-6, 1e-7])
def test_a_slider_crank_still_closer_is_refused(angle):
    with pytest.raises(
        LinkageError, match=rf"'push' cannot .* {degrees(angle):.7g} deg: .*B\.x stands"
    ):
        near(slider_crank(0.1, 0.15, at=angle), angle, {"drive": 1.0}, "push")


@pytest.mark.parametrize("excess", [1e-2, 1e-4, 1e-6, 1e-8])
def test_a_rod_hardly_longer_than_its_crank_stands_nearly_upright(excess):
    """Crank at 90 deg: cos th3 = sqrt(1 - (R2/R3)**2), 1.4e-4 for an excess of 1e-8.

    Side thrust = -push tan th3, torque = -push R2 sin (at 90 deg), closed forms. A rounding of the
    lengths turns the rod by eps / cos th3, the thrust by eps / cos**2: measured 4.5e-9 at 1e-8.
    """
    crank = 0.1
    rod = crank * (1.0 + excess)
    level = sqrt(excess * (2.0 + excess)) / (1.0 + excess)
    linkage = slider_crank(crank, rod, at=pi / 2)
    _, solution = solved(linkage, CRANK, pi / 2, 1.0, {"push": -200.0}, "drive", margin=0.1 * level)
    rounding = 4e-16 / level**2 + 1e-14
    assert solution.efforts["drive"][0] == pytest.approx(-200.0 * crank, rel=rounding)
    thrust = abs(solution.joints["guide"].force[0, 1])
    assert thrust == pytest.approx(200.0 / (rod / crank * level), rel=rounding)


def nearly_straight_four_bar(transmission, at):
    """Crank-rocker position with a given transmission angle, coupler 0.9 and rocker 0.8 m."""
    crank, coupler, rocker = 0.3, 0.9, 0.8
    reach = sqrt(
        (coupler - rocker) ** 2 + 4.0 * coupler * rocker * sin(transmission / 2.0) ** 2
    )  # from the crank pin to the rocker's pivot, law of cosines without cancellation
    ground = crank * cos(at) + sqrt(reach**2 - (crank * sin(at)) ** 2)
    return four_bar(crank, coupler, rocker, ground, at=at), (crank, rocker, ground, reach)


@pytest.mark.parametrize("degrees", [10.0, 1.0, 0.3, 0.1, 0.01])
def test_a_four_bar_at_a_small_transmission_angle_follows_virtual_work(degrees):
    """Torque = -load R2 sin(th2 - th3) / (R4 sin(th4 - th3)).

    Measured 7e-13 at 0.1 and 2e-10 at 0.01 deg.
    """
    transmission, at = radians(degrees), radians(10.0)
    linkage, (crank, rocker, ground, reach) = nearly_straight_four_bar(transmission, at)
    _, solution = solved(
        linkage, CRANK, at, 1.0, {"load": 50.0}, "drive", margin=1e-2 * transmission**2
    )
    along = np.arctan2(-crank * sin(at), ground - crank * cos(at))
    lift = np.arcsin(rocker * sin(transmission) / reach)
    coupler_angle = along + lift
    ratio = crank * sin(at - coupler_angle) / (rocker * sin(transmission))
    rounding = 1e-16 / transmission**2 + 1e-12
    assert solution.efforts["drive"][0] == pytest.approx(-50.0 * ratio, rel=rounding)
