"""A forging force that follows from leaf springs: touch, stop, impact, weld, friction."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import (
    Angle,
    BeamCompliance,
    Body,
    Contact,
    Cycle,
    Fixed,
    Force,
    LinkageError,
    Phase,
    PointCoordinate,
    SteadyPace,
    run_cycle,
    solve_forces,
)

from .elastic_machines import (
    FLOOR,
    PACK,
    elastic,
    forged,
    pressed,
    tip_stiffness,
)
from .machine_hammer import HAMMER, hammer
from .machines import slider_crank


def test_a_stopped_ram_takes_the_leafs_bending_and_its_weight():
    """K cos2 (height - gap) + m g = 806 N at the lowest position, without the arm's own inertia.

    K of an overhanging beam, cos2 because the slot's force is normal to the leaf.
    """
    light = HAMMER | {"m3": 0.0, "I3R": 0.0}
    cycle = forged(parameters=light)
    force = cycle.efforts["work"]
    k = int(force.argmax())
    x = cycle.travel("slot")[k]
    cosine = 0.427 / x
    pressed = FLOOR + 0.01 - cycle.point("ram", "D")[k, 1]
    assert_allclose(force[k], tip_stiffness(x) * cosine**2 * pressed + 39.85 * 9.8, rtol=1e-9)
    assert 805.0 < force[k] < 808.0


def test_the_arms_inertia_bends_it_too():
    """Couple I alpha at the pivot turns the beam there by M l3 / 3 E I: 10 N more at 5 rad/s."""
    plain, heavy = forged(parameters=HAMMER | {"I3R": 0.0}), forged()
    k = int(heavy.efforts["work"].argmax())
    alpha, x = heavy.accelerations[k, 3, 2], heavy.travel("slot")[k]
    drop = HAMMER["I3R"] * alpha * 0.46 / (3 * PACK) * x / (0.427 / x)
    more = abs(drop) * tip_stiffness(x) * (0.427 / x) ** 2
    assert_allclose(heavy.efforts["work"].max() - plain.efforts["work"].max(), more, rtol=3e-3)
    assert 9.0 < more < 11.0


def test_a_ram_that_keeps_its_acceleration_is_pressed_harder():
    """K (height - gap) + m (a + g), as if the workpiece did not stop it: about 170 N more."""
    light = HAMMER | {"m3": 0.0, "I3R": 0.0}
    stopped, running = forged(parameters=light), forged(parameters=light, stops=False)
    k = int(running.efforts["work"].argmax())
    acceleration = running.accelerations[k, 4, 1]
    assert_allclose(
        running.efforts["work"][k]
        - np.interp(running.positions[k], stopped.positions, stopped.efforts["work"]),
        39.85 * acceleration,
        rtol=2e-3,  # the stopped force is interpolated
    )


def test_the_force_grows_from_zero_at_the_touch_of_the_drooping_leaf():
    """The ram's weight bends the leaf by 7.6 mm before it touches, so it touches earlier."""
    cycle = forged()
    force, touching = cycle.efforts["work"], cycle.contacts["work"].touching
    edges = np.flatnonzero(touching[1:] != touching[:-1])
    assert len(edges) == 2
    assert force[edges].max() < 1e-3 * force.max()
    assert force[edges + 1].max() < 0.05 * force.max()
    assert (force[~touching] == 0.0).all()
    droop = 39.85 * 9.8 / 51.7e3
    assert abs(cycle.touches["work"].deflection[0] + droop) < 2e-4
    window = np.degrees(cycle.positions[touching])
    assert window[0] < 60.0 < 100.0 < window[-1]


def test_an_elastic_contact_neither_loses_nor_makes_energy():
    """The spring gives back what it took; the power balance holds at every position."""
    cycle = forged(stops=False)
    drive = cycle.drive("drive")
    assert cycle.power_balance_error < 1e-12
    assert abs(drive.mean_effort) < 2e-3 * drive.largest


def test_impact_is_told_as_speed_and_energy_of_the_ram():
    cycle = forged(speed=5.0)
    contact = cycle.contacts["work"]
    first = int(np.argmax(contact.touching))
    assert_allclose(contact.approach_speed, abs(cycle.velocities[first - 1, 4, 1]), rtol=1e-9)
    assert_allclose(contact.impacts, 0.5 * 39.85 * contact.approach_speed**2, rtol=1e-9)


def test_friction_and_contact_are_solved_together():
    """The ram's guide force grows with the forging force: the deflection follows both."""
    rough = HAMMER | {"mu_guide": 0.15, "mu_slot": 0.1}
    cycle = forged(parameters=rough, positions=181)
    contact = cycle.contacts["work"]
    depth = FLOOR + 0.01 - cycle.point("ram", "D")[:, 1]
    pushed = cycle.efforts["work"] > 0.0
    assert pushed.sum() > 20
    assert_allclose(contact.deflection[pushed], depth[pushed], atol=1e-12)
    assert cycle.efforts["work"].max() != pytest.approx(
        forged(positions=181).efforts["work"].max(), rel=1e-3
    )


# -- the documents' forging force: K = 3 n E I / 2 x3, ram not stopped, at first touch


@pytest.mark.parametrize(
    ("speed", "height", "leaves", "force", "top", "bottom"),
    [
        (3.0, 0.01, 3, 917.093, 79.1333, -75.0375),
        (6.0, 0.01, 3, 1102.25, 79.1333, -103.335),
        (5.0, 0.02, 3, 1490.82, 158.121, -87.3388),
        (10.0, 0.02, 3, 2005.54, 158.121, -154.97),
        (10.0, 0.02, 4, 2315.02, 158.121, -116.227),
        (5.0, 0.01, 5, 1336.70, 79.1333, -55.0838),
    ],
)
def test_forging_force_and_leaf_stress_agree_with_the_independent_cycle(
    speed, height, leaves, force, top, bottom
):
    """Stress at the pivot keeps its sign: + where the ram is pushed up (independent solution).

    Tolerances of the reference: 0.2 % of force and largest stress, 2 % of the smallest.
    """
    from loads import move, trace

    crank = Angle("crank")
    linkage = hammer()
    angles = np.linspace(0.0, 2 * np.pi, 2881)
    motion = move(trace(linkage, crank, 0.0, 2 * np.pi).at(angles), crank, speed, 1)
    ram = motion.poses[:, 4, 1]
    x = motion.kinematics.travel(motion.poses, linkage.joint("slot"))
    stiffness = 3 * PACK / 3 * leaves / (2 * x**3)
    pressed = FLOOR + height - ram
    weight = 39.85 * (motion.accelerations[:, 4, 1] + 9.8)
    work = np.where(pressed > 0.0, stiffness * pressed + weight, 0.0)
    solution = solve_forces(motion, {"work": work}, "drive")
    slot = -solution.joints["slot"].force  # of the ram on the leaf
    cosine = 0.427 / x
    normal = slot[:, 1] / cosine  # the slot's force is normal to the leaf
    stress = normal * x * 0.0048 / (leaves * 0.06 * 0.0096**3 / 12) * 1e-6
    assert_allclose(work.max(), force, rtol=2e-3)
    assert_allclose(stress.max(), top, rtol=2e-3)
    assert_allclose(stress.min(), bottom, rtol=2e-2)


# what follows the contact, and what does not


def test_a_ram_that_compresses_a_spring_keeps_its_acceleration():
    """Eccentric 20 mm, rod 200 mm, ram 60 kg on 500 N/mm: at the bottom m (g + a) - k depth.

    A rigid linkage moves the ram through the spring, which cannot stop it.
    """
    linkage = slider_crank(
        20.0, 200.0, slider_mass=60e-3, gravity=(-9810.0, 0.0), at=0.1
    )  # gravity against the slider's way out
    crank, speed = Angle("crank"), 4 * np.pi
    spring = Contact(-210.0, 500.0)
    linkage = replace(
        linkage,
        forces=(linkage.forces[0], Force("push", PointCoordinate("slider", "B", (-1.0, 0.0)))),
    )
    phase = Phase("turn", 2 * np.pi + 0.1, {"push": spring}, "drive")
    cycle = run_cycle(linkage, Cycle("turn", crank, 0.1, SteadyPace(crank, speed), (phase,), 721))
    out = int(np.argmax(cycle.poses[:, 3, 0]))
    acceleration = -(speed**2) * 20.0 * (1.0 + 20.0 / 200.0)
    expected = 500.0 * 10.0 + 60e-3 * (acceleration + 9810.0)
    assert_allclose(cycle.reactions["B"].force[out, 0], expected, rtol=1e-3)
    assert cycle.contacts["push"].held.max() == 0.0
    assert (cycle.contacts["push"].impacts == 0.0).all()
    assert cycle.contacts["push"].approach_speed > 100.0


def test_a_die_welded_to_the_ram_is_stopped_with_it():
    """Ram of 39.85 kg in one piece, or as 20 kg with a die of 19.85 kg: the same blow."""
    whole = forged(speed=10.0)
    base = replace(hammer(), compliance=(BeamCompliance("rocker", bending=PACK),))
    light = base.body("ram").with_mass_properties(20.0, (0.0, 0.0), 0.0)
    split = replace(
        base,
        bodies=(
            *(light if body.name == "ram" else body for body in base.bodies),
            Body("die", {"D": (0.0, 0.0)}, 19.85),
        ),
        joints=(*base.joints, Fixed("weld", "ram", "die", "D")),
        forces=(base.forces[0], Force("work", PointCoordinate("die", "D", (0.0, 1.0)))),
        assembled={**base.assembled, "die": base.assembled["ram"]},
    )
    crank = Angle("crank")
    phase = Phase("turn", 2 * np.pi, {"work": Contact(FLOOR + 0.01)}, "drive")
    cycle = run_cycle(split, Cycle("turn", crank, 0.0, SteadyPace(crank, 10.0), (phase,), 721))
    assert_allclose(cycle.efforts["work"].max(), whole.efforts["work"].max(), rtol=1e-6)
    assert_allclose(cycle.contacts["work"].impacts, whole.contacts["work"].impacts, rtol=1e-3)


def test_a_contact_softer_than_the_linkage_stops_the_ram_in_part():
    """Its surface moves by its share of the deflection: k of the leaf over k of both."""
    cycle = forged()
    x = cycle.travel("slot")
    leaf = tip_stiffness(x) * (0.427 / x) ** 2
    linkage = replace(hammer(), compliance=(BeamCompliance("rocker", bending=PACK),))
    crank = Angle("crank")
    phase = Phase("turn", 2 * np.pi, {"work": Contact(FLOOR + 0.01, 50e3)}, "drive")
    soft = run_cycle(linkage, Cycle("turn", crank, 0.0, SteadyPace(crank, 5.0), (phase,), 721))
    touching = soft.contacts["work"].touching
    x = soft.travel("slot")
    leaf = tip_stiffness(x) * (0.427 / x) ** 2
    assert_allclose(
        soft.contacts["work"].held[touching], (50e3 / (50e3 + leaf))[touching], rtol=1e-9
    )


def test_a_body_that_turns_cannot_be_stopped_by_a_contact():
    linkage = replace(elastic(), forces=(
        elastic().forces[0], Force("process", PointCoordinate("upper", "A", (0.0, -1.0)))
    ))  # fmt: skip
    with pytest.raises(LinkageError, match=r"body 'upper' turns, .*stops = false"):
        pressed(linkage, Contact(-498.0, 80e3))
