"""Linkages and cycles that cannot work are refused, and the message says where."""

import pickle
import re
from dataclasses import replace
from math import pi, radians, sqrt

import pytest

from loads import (
    GROUND,
    Angle,
    Body,
    Cycle,
    Force,
    Friction,
    Linkage,
    LinkageError,
    Phase,
    PointCoordinate,
    Prismatic,
    Revolute,
    Slot,
    SteadyPace,
    run_cycle,
    trace,
)

from .machines import (
    four_bar,
    press_cycle,
    quick_return,
    slider_crank,
    toggle,
    toggle_height,
)
from .readings import solved
from .test_cycle_invariants import turn


def test_a_height_that_the_bars_do_not_reach_is_refused_with_its_gap():
    """Bars of 250 mm reach 500 mm: at 510 mm, 10 mm are missing."""
    with pytest.raises(
        LinkageError,
        match=r"A\.y = 510 mm cannot be reached: joint '\w+' stays open by (10|9\.99)"
        r".* last value that can be reached is 500 mm",
    ):
        trace(toggle(), toggle_height(toggle()), 300.0, 510.0)


def test_a_sweep_up_to_its_dead_centre_is_refused():
    with pytest.raises(LinkageError, match=r"A\.y .*stands still at 500 .*dead centre"):
        trace(toggle(), toggle_height(toggle()), 300.0, 500.0)


def test_a_crank_that_cannot_turn_round_is_refused():
    """40 + 120 > 100 + 30: no crank by Grashof's rule."""
    with pytest.raises(LinkageError, match=r"crank\.angle = .* cannot be reached: joint"):
        trace(four_bar(40.0, 120.0, 30.0, 100.0, at=2.5), Angle("crank"), 2.5, 2 * pi)


def test_an_angle_a_full_turn_beside_the_drawn_one_is_asked_about():
    """Drawn at 143.24 deg: 497 and 500 deg are 137 and 140 deg, the way there does not close."""
    linkage = four_bar(40.0, 120.0, 30.0, 100.0, at=2.5)
    with pytest.raises(LinkageError, match=r"; as drawn it is 143\.2394 deg: is 140 deg meant\?$"):
        trace(linkage, Angle("crank"), radians(500.0), radians(497.0))
    with pytest.raises(LinkageError) as refused:
        trace(linkage, Angle("crank"), 2.5, 2 * pi)
    assert "meant" not in str(refused.value)


def test_an_effort_that_passes_a_dead_centre_between_positions_is_refused():
    linkage = slider_crank(50.0, 200.0, slider_mass=1e-3, at=1.0)
    cycle = Cycle(
        "turn",
        Angle("crank"),
        1.0,
        SteadyPace(Angle("crank"), 10.0),
        (Phase("all", 7.0, {"drive": 1000.0}, "push"),),
    )
    with pytest.raises(LinkageError, match=r"'turn', phase 'all': force 'push' cannot balance"):
        run_cycle(linkage, cycle)


def test_a_pace_that_stands_still_is_refused():
    linkage = slider_crank(50.0, 200.0, slider_mass=1e-3, at=1.0)
    pace = linkage.force("push").coordinate
    cycle = Cycle(
        "turn",
        Angle("crank"),
        1.0,
        SteadyPace(pace, 10.0),
        (Phase("all", 7.0, {"push": 0.0}, "drive"),),
    )
    with pytest.raises(LinkageError, match=r"B\.x sets the pace but stands still"):
        run_cycle(linkage, cycle)


def wedge(coefficient):
    """A block in a guide at 45 degrees, pushed level by ``push``, held upright by ``hold``."""
    return Linkage(
        bodies=(Body(GROUND, {"O": (0.0, 0.0)}), Body("block", {"P": (0.0, 0.0)})),
        joints=(Prismatic("ramp", GROUND, "block", "O", "P", (1.0, 1.0)),),
        forces=(
            Force("push", PointCoordinate("block", "P", (1.0, 0.0))),
            Force("hold", PointCoordinate("block", "P", (0.0, -1.0))),
        ),
        assembled={"block": (0.0, 0.0, 0.0)},
        friction={"ramp": Friction(coefficient)},
        gravity=(0.0, 0.0),
    )


def wedge_cycle(linkage):
    x = linkage.force("push").coordinate
    return Cycle(
        "up", x, 0.0, SteadyPace(x, 10.0), (Phase("up", 10.0, {"hold": 100.0}, "push"),), 20
    )


@pytest.mark.parametrize("coefficient", [0.0, 0.3, 0.9])
def test_a_block_on_a_ramp_needs_the_force_of_the_friction_angle(coefficient):
    """Push = W tan(45 deg + phi) = W (1 + mu) / (1 - mu), closed form."""
    loads = run_cycle(wedge(coefficient), wedge_cycle(wedge(0.0)))
    expected = 100.0 * (1 + coefficient) / (1 - coefficient)
    assert loads.efforts["push"] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("coefficient", [1.0, 1.2])
def test_a_ramp_that_locks_itself_is_refused(coefficient):
    """From mu = 1 on, no level push moves the block up 45 degrees."""
    with pytest.raises(LinkageError, match=r"friction locks the linkage .* joint 'ramp'"):
        run_cycle(wedge(coefficient), wedge_cycle(wedge(0.0)))


def test_too_many_and_too_few_degrees_of_freedom_are_counted():
    linkage = toggle()
    with pytest.raises(LinkageError, match=r"has 3 degrees of freedom \(3 x 3 bodies - 6 .* 2 too"):
        replace(linkage, joints=linkage.joints[:-1], friction={})
    free = tuple(j for j in linkage.joints if GROUND not in (j.body_a, j.body_b))
    with pytest.raises(LinkageError, match="no pin is on the ground: are its points stated"):
        replace(linkage, joints=free, friction={})
    second = Prismatic("guide 2", GROUND, "mould", "C", "A", (0.0, 1.0))
    with pytest.raises(LinkageError, match=r"has -1 degrees of freedom .* 2 too few"):
        replace(linkage, joints=(*linkage.joints, second))


def test_an_open_assembly_is_refused_with_its_gap_and_a_rounded_one_is_closed():
    linkage = toggle()
    x, y, angle = linkage.assembled["mould"]
    loose = replace(linkage, assembled={**linkage.assembled, "mould": (x, y + 8.0, angle)})
    with pytest.raises(LinkageError, match=r"assembled pose leaves joint 'A' open by 8 mm"):
        trace(loose, toggle_height(linkage), 300.0, 400.0)
    rounded = replace(linkage, assembled={**linkage.assembled, "mould": (x, y + 0.01, angle)})
    cycle = replace(press_cycle(linkage), n_positions=60)
    assert run_cycle(rounded, cycle).constraint_residual < 1e-9


def test_names_are_checked_with_the_nearest_right_one():
    linkage = toggle()
    with pytest.raises(LinkageError, match=r"joint 'B': body 'lower' has no point 'knee'; known"):
        replace(linkage, joints=(Revolute("B", "lower", "upper", "knee"),), friction={})
    with pytest.raises(LinkageError, match=r"joint 'B': no body is named 'uper'; did you mean 'up"):
        replace(linkage, joints=(Revolute("B", "lower", "uper", "B"),), friction={})
    with pytest.raises(LinkageError, match=r"no joint is named 'gide'; did you mean 'guide'"):
        replace(linkage, friction={"gide": Friction(0.1)})
    cycle = replace(press_cycle(linkage), phases=(Phase("p", 400.0, {"proces": 0.0}, "cylinder"),))
    with pytest.raises(LinkageError, match=r"no force is named 'proces'; did you mean 'process'"):
        run_cycle(linkage, cycle)


def test_a_negative_mass_is_refused_and_the_error_survives_pickling():
    with pytest.raises(LinkageError, match="body 'bar': mass must be 0 or above, got -1") as info:
        Body("bar", {}, mass=-1.0)
    assert str(pickle.loads(pickle.dumps(info.value))) == str(info.value)


def test_every_force_is_given_or_solved_for():
    linkage = toggle()
    cycle = replace(press_cycle(linkage), phases=(Phase("p", 400.0, {}, "cylinder"),))
    with pytest.raises(LinkageError, match="'process' is neither given nor solved for"):
        run_cycle(linkage, cycle)


def test_a_parallelogram_is_refused_at_its_change_point():
    """All bars in line at 180 deg: from there it can go on as a parallelogram or cross its bars."""
    linkage = four_bar(40.0, 100.0, 40.0, 100.0, at=pi / 3)
    assert len(trace(linkage, Angle("crank"), 0.1, pi - 0.01).values) > 2
    with pytest.raises(
        LinkageError,
        match=r"at 180 deg the linkage can go on in two ways \(change point of joints (O2|O4|A|B),",
    ):
        trace(linkage, Angle("crank"), pi / 3, 2 * pi - 0.1)
    with pytest.raises(LinkageError, match=r"joints O2, A, B, O4 .* move on in two ways"):
        trace(four_bar(40.0, 100.0, 40.0, 100.0, at=pi), Angle("crank"), 3.0, 3.3)


def test_a_guide_that_is_there_twice_is_named():
    """The count of freedoms is right, as another body has a joint too few."""
    linkage = toggle()
    twice = replace(
        linkage,
        bodies=(*linkage.bodies, Body("plate", {"E": (0.0, 0.0)})),
        joints=(
            *linkage.joints,
            Prismatic("second guide", GROUND, "mould", "C", "A", (0.0, 1.0)),
            Slot("rail", GROUND, "plate", "C", "E", (0.0, 1.0)),
        ),
        assembled={**linkage.assembled, "plate": (0.0, 10.0, 0.0)},
    )
    with pytest.raises(LinkageError, match="joints guide, second guide hold the same motion twice"):
        trace(twice, toggle_height(linkage), 300.0, 400.0)


def test_a_body_without_a_joint_is_named():
    linkage = toggle()
    with pytest.raises(LinkageError, match=r"3 too many, .*'plate' \(no joint\)"):
        replace(
            linkage,
            bodies=(*linkage.bodies, Body("plate", {"E": (0.0, 0.0)})),
            assembled={**linkage.assembled, "plate": (0.0, 10.0, 0.0)},
        )


@pytest.mark.parametrize(
    ("ends", "angle", "way"),
    [((0.041, 0.19), 180.0, 0.0400), ((0.03, 0.179), 360.0, 0.18)],
)
def test_a_block_that_leaves_its_slot_is_refused(ends, angle, way):
    """It slides from 40 to 180 mm of the lever: how far beyond the end is named, and where."""
    linkage = quick_return(ends=ends, at=0.3)
    with pytest.raises(
        LinkageError,
        match=rf"joint 'slot': its point 'a' slides beyond the end of {ends[0]} .* up to {way}\d*",
    ) as info:
        run_cycle(linkage, turn(linkage))
    place = float(re.search(r"([\d.]+) deg", str(info.value))[1])
    assert abs(place - angle) < 1.0
    whole = quick_return(ends=(0.03, 0.19), at=0.3)
    assert run_cycle(whole, turn(whole)).slot_margin["slot"] == pytest.approx(0.01, rel=1e-5)


@pytest.mark.parametrize(("coefficient", "locks"), [(0.66, False), (0.67, True)])
def test_a_crank_locks_on_a_steep_rod(coefficient, locks):
    """Crank 100, rod 150, offset 25 mm at 270 deg: rod at 56.44 deg, locked from mu = 0.663 on.

    Below, torque = load x crank / (1 - mu tan), closed form; the rod's speed is the slider's.
    """
    at = 1.5 * pi
    linkage = slider_crank(100.0, 150.0, 25.0, mu_slider=coefficient, at=at)
    if locks:
        with pytest.raises(
            LinkageError, match=r"friction locks .* joint 'guide', coefficient 0\.67"
        ):
            solved(linkage, Angle("crank"), at, 1.0, {"push": -10.0}, "drive")
        return
    _, solution = solved(linkage, Angle("crank"), at, 1.0, {"push": -10.0}, "drive")
    steep = 125.0 / sqrt(150.0**2 - 125.0**2)
    expected = 10.0 * 100.0 / (1.0 - coefficient * steep)
    assert solution.efforts["drive"][0] == pytest.approx(expected, rel=1e-9)
