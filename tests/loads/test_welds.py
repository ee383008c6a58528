"""A fixed joint makes one body of two, and tells what goes through it."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import Angle, Body, Fixed, Force, Friction, LinkageError, PointCoordinate, run_cycle

from .machines import slider_crank
from .readings import solved
from .test_cycle_invariants import SLIDER_CRANK, turn

CRANK = Angle("crank")


def with_bracket(linkage, height, mass=0.0):
    """The slider with an upright bracket welded to it at B, pushed at the bracket's end E."""
    pose = linkage.assembled["slider"]
    bracket = Body(
        "bracket",
        {"B": (0.0, 0.0), "E": (height, 0.0)},
        mass,
        mass * height**2 / 12,
        (height / 2, 0.0),
    )
    push = Force("push", PointCoordinate("bracket", "E", (1.0, 0.0)))
    return replace(
        linkage,
        bodies=(*linkage.bodies, bracket),
        joints=(*linkage.joints, Fixed("weld", "slider", "bracket", "B")),
        forces=(linkage.force("drive"), push),
        assembled={**linkage.assembled, "bracket": (*pose[:2], pi / 2)},
    )


def test_a_weld_carries_the_force_and_the_moment_of_what_it_holds():
    """Massless bracket of 80 mm, 200 N to the left at its end: force 200 N, moment 16 N m."""
    linkage = with_bracket(slider_crank(0.1, 0.15, 0.025, at=1.0), 0.08)
    _, solution = solved(linkage, CRANK, np.linspace(1.0, 1.5, 5), 5.0, {"push": -200.0}, "drive")
    weld = solution.joints["weld"]
    assert_allclose(weld.force, np.tile([200.0, 0.0], (5, 1)), atol=1e-10)
    assert_allclose(weld.moment, -200.0 * 0.08, rtol=1e-12)
    # the guide takes the same couple: the slider carries it on
    assert_allclose(solution.joints["guide"].moment, -200.0 * 0.08, rtol=1e-12)


def test_two_welded_bodies_move_and_load_the_others_as_one():
    """Slider of m + M with the common centre, against slider m and bracket M welded to it."""
    height, mass = 0.08, 0.05
    welded = with_bracket(slider_crank(**SLIDER_CRANK, at=0.3), height, mass)
    whole = run_cycle(welded, turn(welded))
    slider = SLIDER_CRANK["slider_mass"]
    one = slider_crank(**SLIDER_CRANK, at=0.3)
    centre = (0.0, height / 2 * mass / (slider + mass))
    one = one.with_mass_properties({"slider": (slider + mass, centre, 0.0)})
    alone = run_cycle(one, turn(one))
    at = np.linspace(0.31, 6.5, 50)
    for name in "OAB":
        for axis in (0, 1):
            both = [
                np.interp(at, loads.positions, loads.reactions[name].force[:, axis])
                for loads in (whole, alone)
            ]
            # positions lie elsewhere in the two cycles: linear interpolation between 721 of them
            assert_allclose(both[0], both[1], atol=2e-5 * np.abs(both[1]).max())
    assert max(whole.equilibrium_residual.values()) < 1e-13
    assert whole.power_balance_error < 1e-13
    history = whole.part_history("bracket", {"foot": "B", "end": "E"})
    assert np.abs(history.wrenches[:, 0, 5]).max() > 150.0 * height


def paired(linkage, joint, **bodies):
    """A linkage of which one joint pairs others of the bodies at its point."""
    joints = [replace(one, **bodies) if one.name == joint else one for one in linkage.joints]
    return replace(linkage, joints=tuple(joints))


@pytest.mark.parametrize(
    ("joint", "bodies"),
    [("B", {"body_b": "bracket"}), ("second", {"body_a": "bracket"})],
    ids=["the pin holds the bracket in place of the slider", "a third body is welded to another"],
)
def test_positions_do_not_ask_which_of_the_bodies_at_a_weld_a_joint_pairs(joint, bodies):
    """They lay up to 0.24 degrees elsewhere, and with them the largest loads found."""
    linkage = with_bracket(slider_crank(**SLIDER_CRANK, at=0.3), 0.08, 0.05)
    weight = Body("weight", {"B": (0.0, 0.0)}, 0.03, 0.0, (0.0, 0.02))
    linkage = replace(
        linkage,
        bodies=(*linkage.bodies, weight),
        joints=(*linkage.joints, Fixed("second", "slider", "weight", "B")),
        assembled={**linkage.assembled, "weight": linkage.assembled["slider"]},
    )
    whole, other = (
        run_cycle(one, turn(one)) for one in (linkage, paired(linkage, joint, **bodies))
    )
    assert_allclose(other.positions, whole.positions, atol=1e-9)


def test_friction_of_a_weld_is_refused():
    linkage = with_bracket(slider_crank(0.1, 0.15, 0.025, at=1.0), 0.08)
    with pytest.raises(LinkageError, match="joint 'weld' is fixed, nothing slides in it"):
        replace(linkage, friction={"weld": Friction(0.1)})
