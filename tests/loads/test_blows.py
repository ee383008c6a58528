"""Blows against closed forms: masses, a rod at its centre of percussion, a slider-crank."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import loads
from loads import blow

SPEED = 700.0  # mm/s


def one_mass(mass=2e-3, drop=(0.0, 1.0)):
    """A mass in a vertical guide, with a contact below it."""
    linkage = loads.Linkage(
        (loads.Body("ground", {"O": (0.0, 0.0)}), loads.Body("ram", {"P": (0.0, 0.0)}, mass, 1.0)),
        (loads.Prismatic("guide", "ground", "ram", "O", "P", (0.0, 1.0)),),
        (loads.Force("work", loads.PointCoordinate("ram", "P", drop)),),
        {"ram": (0.0, 50.0, 0.0)},
    )
    return linkage, np.array([[0.0, 0, 0], [0, 50.0, 0]]), np.array([[0.0, 0, 0], [0, -SPEED, 0]])


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_a_falling_mass_gives_its_momentum_and_keeps_the_square_of_the_restitution(e):
    found = blow(one_mass()[0], "work", *one_mass()[1:])
    assert found.speed == pytest.approx(SPEED)
    assert found.mass == pytest.approx(2e-3)
    assert found.impulse(e) == pytest.approx((1 + e) * 2e-3 * SPEED)
    assert found.energy(e) == pytest.approx(0.5 * 2e-3 * SPEED**2 * (1 - e**2))
    assert_allclose(found.joints["guide"].force, 0.0, atol=1e-12)


def test_along_the_axis_or_against_it_a_blow_is_the_same():
    linkage, pose, rates = one_mass(drop=(0.0, -1.0))
    assert blow(linkage, "work", pose, rates).impulse(0.0) == pytest.approx(2e-3 * SPEED)


def test_a_blow_beside_the_guide_has_the_couple_of_its_arm():
    linkage, pose, rates = one_mass()
    wide = loads.Body("ram", {"P": (0.0, 0.0), "Q": (30.0, 0.0)}, 2e-3, 1.0)
    linkage = loads.Linkage(
        (linkage.bodies[0], wide),
        linkage.joints,
        (loads.Force("work", loads.PointCoordinate("ram", "Q", (0.0, 1.0))),),
        linkage.assembled,
    )
    found = blow(linkage, "work", pose, rates)
    assert found.joints["guide"].couple == pytest.approx(-30.0 * 2e-3 * SPEED)


def two_masses(m1, m2, compliance):
    """Two sliders on one line, joined by links that something soft separates, and their contact."""
    linkage = loads.Linkage(
        (
            loads.Body("ground", {"O": (0.0, 0.0)}),
            loads.Body("one", {"P": (0.0, 0.0)}, m1),
            loads.Body("other", {"Q": (0.0, 0.0)}, m2),
            loads.Body("link", {"P": (0.0, 0.0), "Q": (100.0, 0.0)}),
        ),
        (
            loads.Prismatic("guide_1", "ground", "one", "O", "P", (1.0, 0.0)),
            loads.Slot("guide_2", "ground", "other", "O", "Q", (1.0, 0.0)),
            loads.Revolute("P", "one", "link", "P"),
            loads.Fixed("Q", "link", "other", "Q"),
        ),
        (loads.Force("buffer", loads.Distance("one", "P", "other", "Q")),),
        {"one": (0.0, 0, 0), "other": (100.0, 0, 0), "link": (0.0, 0, 0)},
        compliance=compliance,
    )
    pose = np.array([[0.0, 0, 0], [0, 0, 0], [100.0, 0, 0], [0, 0, 0]])
    rates = np.array([[0.0, 0, 0], [SPEED, 0, 0], [-200.0, 0, 0], [SPEED, 0, 0]])
    return linkage, pose, rates


@pytest.mark.parametrize(("m1", "m2"), [(1e-3, 1e-3), (1e-3, 5e-3), (2.0, 1e-6)])
def test_two_masses_meet_with_the_product_over_the_sum(m1, m2):
    """m1 m2 / (m1 + m2); the soft pin between them carries nothing in the moment."""
    linkage, pose, rates = two_masses(m1, m2, (loads.JointCompliance("P", 100.0),))
    found = blow(linkage, "buffer", pose, rates)
    assert found.open == ("P",)
    assert found.speed == pytest.approx(SPEED + 200.0)
    assert found.mass == pytest.approx(m1 * m2 / (m1 + m2), rel=1e-9)
    assert_allclose(found.joints["P"].force, 0.0)


def rod(b, centre=150.0, mass=1.2e-3, inertia=1.2e-3 * 300.0**2 / 12):
    """A rod 300 mm long, hinged at its end, struck across at a distance b."""
    linkage = loads.Linkage(
        (
            loads.Body("ground", {"O": (0.0, 0.0)}),
            loads.Body("rod", {"O": (0.0, 0.0), "S": (b, 0.0)}, mass, inertia, (centre, 0.0)),
        ),
        (loads.Revolute("O", "ground", "rod", "O"),),
        (loads.Force("stop", loads.PointCoordinate("rod", "S", (0.0, 1.0))),),
        {"rod": (0.0, 0.0, 0.0)},
    )
    spin = 3.0
    return linkage, np.zeros((2, 3)), np.array([[0.0, 0, 0], [0, 0, -spin]]), spin


def test_a_rod_struck_at_its_centre_of_percussion_gives_its_hinge_nothing():
    """At 2/3 of its length; elsewhere P (1 - b m c / I_O) across, against the blow or with it."""
    about_hinge = 1.2e-3 * 300.0**2 / 3
    for b in (200.0, 120.0, 290.0):
        linkage, pose, rates, spin = rod(b)
        found = blow(linkage, "stop", pose, rates)
        impulse = about_hinge * spin / b
        assert found.impulse(0.0) == pytest.approx(impulse)
        assert found.energy(0.0) == pytest.approx(0.5 * about_hinge * spin**2)
        hinge = -impulse * (1 - b * 1.2e-3 * 150.0 / about_hinge)
        assert_allclose(found.joints["O"].force, [0.0, hinge], atol=1e-12)
    assert hinge != pytest.approx(0.0, abs=1e-3)


CRANK, ROD = 60.0, 200.0


def slider_crank(angle=2.1, spin=8.0, compliance=(), masses=(1e-3, 1.5e-3, 2e-3)):
    lean = np.arcsin(CRANK * np.sin(angle) / ROD)
    linkage = loads.Linkage(
        (
            loads.Body("ground", {"O": (0.0, 0.0)}),
            loads.Body("crank", {"O": (0.0, 0), "A": (CRANK, 0.0)}, masses[0], 1.0, (20.0, 5.0)),
            loads.Body("rod", {"A": (0.0, 0), "B": (ROD, 0.0)}, masses[1], 6.0, (90.0, -3.0)),
            loads.Body("slider", {"B": (0.0, 0.0)}, masses[2]),
        ),
        (
            loads.Revolute("O", "ground", "crank", "O"),
            loads.Revolute("A", "crank", "rod", "A"),
            loads.Revolute("B", "rod", "slider", "B"),
            loads.Prismatic("guide", "ground", "slider", "O", "B", (1.0, 0.0)),
        ),
        (
            loads.Force("drive", loads.Angle("crank")),
            loads.Force("work", loads.PointCoordinate("slider", "B", (1.0, 0.0))),
        ),
        {
            "crank": (0.0, 0.0, angle),
            "rod": (CRANK * np.cos(angle), CRANK * np.sin(angle), -lean),
            "slider": (CRANK * np.cos(angle) + ROD * np.cos(lean), 0.0, 0.0),
        },
        compliance=compliance,
    )
    crank = loads.Angle("crank")
    geometry = loads.trace(linkage, crank, angle - 0.1, angle + 0.1).at(np.array([angle]))
    motion = loads.move(geometry, crank, spin, 1)
    return linkage, motion.poses[0], motion.velocities[0]


def energy(linkage, pose, rates):
    total = 0.0
    for body, (_, _, turn), (u, v, spin) in zip(linkage.moving, pose[1:], rates[1:], strict=True):
        c, s = np.cos(turn), np.sin(turn)
        x, y = body.centre
        arm = np.array([c * x - s * y, s * x + c * y])
        speed = np.array([u - spin * arm[1], v + spin * arm[0]])
        total += 0.5 * (body.mass * speed @ speed + body.inertia * spin**2)
    return total


def test_a_slider_crank_that_is_stopped_loses_all_its_energy_and_the_flywheels():
    """One degree of freedom, so without rebound nothing moves on: the loss is all there was."""
    linkage, pose, rates = slider_crank()
    found = blow(linkage, "work", pose, rates)
    assert found.energy(0.0) == pytest.approx(energy(linkage, pose, rates), rel=1e-10)
    heavy = blow(linkage, "work", pose, rates, loads.Angle("crank"), 50.0)
    own = energy(linkage, pose, rates) + 0.5 * 50.0 * 8.0**2
    assert heavy.energy(0.0) == pytest.approx(own, rel=1e-10)
    assert heavy.speed == pytest.approx(abs(rates[3, 0]))


def test_in_a_blow_every_body_keeps_the_law_of_momentum_about_every_point():
    """With all bodies stopped: joints and contact give each body minus the momentum it had."""
    linkage, pose, rates = slider_crank()
    found = blow(linkage, "work", pose, rates)
    kinematics = loads.Kinematics(linkage)
    for body, row in zip(linkage.moving, range(1, 4), strict=True):
        arm = kinematics.point(pose[None], body.name, next(iter(body.points)))[0]
        x, y = body.centre
        c, s = np.cos(pose[row, 2]), np.sin(pose[row, 2])
        centre = pose[row, :2] + np.array([c * x - s * y, s * x + c * y])
        spin = rates[row, 2]
        off = centre - arm
        momentum = body.mass * (rates[row, :2] + spin * np.array([-off[1], off[0]]))
        about = body.inertia * spin + centre[0] * momentum[1] - centre[1] * momentum[0]
        force, moment = np.zeros(2), 0.0
        for joint in linkage.joints:
            for end, sign in ((joint.body_b, 1.0), (joint.body_a, -1.0)):
                if end == body.name:
                    own = sign * found.joints[joint.name].force
                    at = kinematics.point(pose[None], joint.body_b, joint.point_b)[0]
                    force += own
                    moment += at[0] * own[1] - at[1] * own[0]
                    moment += sign * found.joints[joint.name].couple
        if body.name == "slider":
            push = -np.sign(rates[row, 0]) * found.impulse(0.0)
            force[0] += push
            moment -= pose[row, 1] * push
        assert_allclose(force, -momentum, atol=1e-12 * found.impulse(0.0))
        assert_allclose(moment, -about, atol=1e-9 * found.impulse(0.0))


def test_without_mass_but_the_sliders_a_blow_goes_along_the_rod_to_the_crank():
    """Only the flywheel behind: the rod carries J w / (arm of its line about O), by hand."""
    linkage, pose, rates = slider_crank(masses=(0.0, 0.0, 0.0))
    bodies = tuple(
        loads.Body(body.name, body.points) if body.name != "slider" else body
        for body in linkage.bodies
    )
    linkage = loads.Linkage(bodies, linkage.joints, linkage.forces, linkage.assembled)
    found = blow(linkage, "work", pose, rates, loads.Angle("crank"), 50.0)
    lean = np.arcsin(CRANK * np.sin(2.1) / ROD)
    arm = CRANK * np.sin(2.1 + lean)
    assert np.hypot(*found.joints["B"].force) == pytest.approx(50.0 * 8.0 / arm)
    assert found.impulse(0.0) == pytest.approx(50.0 * 8.0 / arm * np.cos(lean))


def test_what_gives_way_passes_nothing_on():
    """An elastic rod leaves the slider alone; as if rigid, all the linkage strikes."""
    linkage, pose, rates = slider_crank(compliance=(loads.BeamCompliance("rod", None, 1e6),))
    found = blow(linkage, "work", pose, rates, loads.Angle("crank"), np.inf)
    assert found.mass == pytest.approx(2e-3)
    assert found.open == ("A", "B")
    rigid = blow(linkage, "work", pose, rates, rigid=True)
    assert rigid.mass > 2.5e-3
    assert rigid.open == ()


def test_behind_a_drive_that_holds_its_speed_a_blow_has_no_bound():
    linkage, pose, rates = slider_crank()
    found = blow(linkage, "work", pose, rates, loads.Angle("crank"), np.inf)
    assert found.impulse(0.0) == np.inf
    assert found.joints == {}


def test_nothing_that_has_a_mass_gives_no_blow():
    linkage, pose, rates = one_mass(mass=0.0)
    found = blow(linkage, "work", pose, rates)
    assert (found.mass, found.impulse(1.0), found.energy(0.0)) == (0.0, 0.0, 0.0)


def test_a_restitution_beyond_one_is_refused():
    with pytest.raises(loads.LinkageError, match=r"goes from 0 to 1, got 1\.2"):
        loads.Contact(0.0, 1.0, restitution=1.2)
