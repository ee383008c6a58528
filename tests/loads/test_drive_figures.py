"""Work, mean and ripple of drives, the share of friction, and joints that slide slowly."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import (
    GROUND,
    Angle,
    Body,
    Contact,
    Cycle,
    Force,
    Friction,
    Linkage,
    Phase,
    PointCoordinate,
    Prismatic,
    Revolute,
    Slot,
    SteadyPace,
    StrokePace,
    run_cycle,
)

X = PointCoordinate("block", "P", (1.0, 0.0))
MASS, MU = 2e-3, 0.25
DRAG = MU * MASS * 9810.0  # N, of the block on its rail


def block(sign=1, load=X, load_sign=1, mu=MU):
    """A block on a level rail, pushed against ``load``; positive forces push by their sign."""
    return Linkage(
        bodies=(Body(GROUND, {"O": (0.0, 0.0)}), Body("block", {"P": (0.0, 0.0)}, MASS)),
        joints=(Prismatic("rail", GROUND, "block", "O", "P", (1.0, 0.0)),),
        forces=(Force("push", X, sign), Force("load", load, load_sign)),
        assembled={"block": (0.0, 0.0, 0.0)},
        friction={"rail": Friction(mu)},
        gravity=(0.0, -9810.0),
    )


def slid(linkage, *stops, load=0.0, pace=None):
    phases = tuple(Phase(f"to {stop:g}", stop, {"load": load}, "push") for stop in stops)
    return run_cycle(linkage, Cycle("slide", X, 0.0, pace or SteadyPace(X, 10.0), phases, 60))


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("stop", [50.0, -50.0])
def test_a_drive_does_the_work_of_friction_however_its_force_is_counted(sign, stop):
    """mu W times the way, mu W times the speed; the effort itself has the sign it is counted by."""
    drive = slid(block(sign), stop).drive("push")
    assert_allclose(drive.work, DRAG * 50.0, rtol=1e-9)
    assert_allclose(drive.mean_power, DRAG * 10.0, rtol=1e-9)
    assert_allclose(drive.peak_power, DRAG * 10.0, rtol=1e-9)
    assert_allclose(drive.mean_effort, sign * np.sign(stop) * DRAG, rtol=1e-9)
    assert_allclose(drive.smallest, drive.largest, rtol=1e-9)


@pytest.mark.parametrize(
    ("load", "pace", "share"),
    [
        (0.0, SteadyPace(X, 10.0), 1.0),  # all that is put in is rubbed away
        (-DRAG, SteadyPace(X, 10.0), 0.5),  # half of it is
        (DRAG, SteadyPace(X, 10.0), 1.0),  # the load itself overcomes the friction
        (2 * DRAG, SteadyPace(X, 10.0), 0.5),  # half its work is, the drive takes the rest
        (-3 * DRAG, StrokePace(X, "harmonic", 500.0), 0.25),  # so slow that nothing is inertia
    ],
)
def test_the_share_of_friction_is_its_work_over_what_is_turned_over(load, pace, share):
    """Work of friction over the work put in: constant forces over one way."""
    assert_allclose(slid(block(), 50.0, load=load, pace=pace).friction_share, share, rtol=1e-6)


def test_friction_that_takes_nothing_has_no_share():
    assert slid(block(mu=0.0), 50.0, load=-5.0).friction_share == 0.0


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("counted", [1, -1])
@pytest.mark.parametrize("side", [1, -1])
def test_a_contact_pushes_its_side_however_force_and_coordinate_are_counted(sign, counted, side):
    """Spring at x = 30 sensed by x or -x: k (x - 30) against the motion; the way back gives it."""
    coordinate = PointCoordinate("block", "P", (float(counted), 0.0))
    way = -counted * side  # a contact of side 1 is met where its coordinate falls
    linkage = block(load=coordinate, load_sign=sign, mu=0.0)
    spring = Contact(counted * way * 30.0, 50.0, side=side, stops=False)
    cycle = slid(linkage, way * 50.0, load=spring)
    pressed = 50.0 * np.maximum(np.abs(cycle.positions) - 30.0, 0.0)
    assert_allclose(cycle.efforts["load"], sign * side * pressed, atol=1e-9)
    assert_allclose(cycle.efforts["push"], way * pressed, atol=1e-9)


@pytest.mark.parametrize("turn", [2 * np.pi, -2 * np.pi])
@pytest.mark.parametrize("sign", [1, -1])
def test_ripple_is_about_the_mean_of_a_turn_in_either_direction(turn, sign):
    """Pendulum against a constant brake: T = +-B + m g r cos, ripple 2 m g r, mean +-B."""
    brake, weight, radius = 300.0, MASS * 9810.0, 30.0
    crank = Angle("crank", point="O")
    linkage = Linkage(
        bodies=(
            Body(GROUND, {"O": (0.0, 0.0)}),
            Body("crank", {"O": (0.0, 0.0)}, MASS, 50.0, (radius, 0.0)),
        ),
        joints=(Revolute("O", GROUND, "crank", "O"),),
        forces=(Force("drive", crank, sign), Force("brake", crank)),
        assembled={"crank": (0.0, 0.0, 0.0)},
        gravity=(0.0, -9810.0),
    )
    way = np.sign(turn)
    phase = Phase("turn", turn, {"brake": -way * brake}, "drive")
    pace = SteadyPace(crank, 7.0)
    drive = run_cycle(linkage, Cycle("run", crank, 0.0, pace, (phase,), 2000)).drive("drive")
    assert_allclose(drive.energy_ripple, 2 * weight * radius, rtol=1e-5)
    assert_allclose(drive.mean_effort, sign * way * brake, rtol=1e-5)
    assert_allclose(drive.work, brake * 2 * np.pi, rtol=1e-5)
    assert_allclose(drive.mean_power, brake * 7.0, rtol=1e-5)
    assert_allclose(drive.speed, 7.0, rtol=1e-9)


@pytest.mark.parametrize("slope", [1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("way", [1, -1])
def test_a_joint_that_slides_ever_so_slowly_keeps_its_friction(slope, way):
    """A wedge lifts a block that a side force Q presses on its guide: (W +- mu Q) tan.

    The block slides by the slope times the wedge's way; what it needs is no less for that.
    """
    side, weight = 400.0, MASS * 9810.0
    linkage = Linkage(
        bodies=(
            Body(GROUND, {"O": (0.0, 0.0)}),
            Body("wedge", {"P": (0.0, 0.0)}),
            Body("block", {"Q": (0.0, 0.0)}, MASS),
        ),
        joints=(
            Prismatic("floor", GROUND, "wedge", "O", "P", (1.0, 0.0)),
            Prismatic("guide", GROUND, "block", "O", "Q", (0.0, 1.0)),
            Slot("face", "wedge", "block", "P", "Q", (-1.0, slope)),
        ),
        forces=(
            Force("drive", PointCoordinate("wedge", "P", (1.0, 0.0))),
            Force("side", PointCoordinate("block", "Q", (1.0, 0.0))),
        ),
        assembled={"wedge": (0.0, 0.0, 0.0), "block": (0.0, 0.0, 0.0)},
        friction={"guide": Friction(0.2)},
        gravity=(0.0, -9810.0),
    )
    wedge = linkage.force("drive").coordinate
    phase = Phase("shift", way * 10.0, {"side": side}, "drive")
    cycle = run_cycle(linkage, Cycle("shift", wedge, 0.0, SteadyPace(wedge, 1.0), (phase,), 20))
    # the guide also takes the face's push along x: N slope
    normal = (weight + way * 0.2 * side) / (1.0 - way * 0.2 * slope)
    assert_allclose(cycle.efforts["drive"], normal * slope, rtol=1e-9)
