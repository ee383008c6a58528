"""Forces that softness limits: a leaf-spring hammer, and a toggle at its dead centre."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import fsolve

from loads import (
    GROUND,
    Angle,
    BeamCompliance,
    Body,
    Contact,
    Cycle,
    Distance,
    Fixed,
    Force,
    JointCompliance,
    LinkageError,
    MatrixCompliance,
    Phase,
    PointCoordinate,
    Prismatic,
    Revolute,
    SteadyPace,
    Table,
    pull_through,
    run_cycle,
    solve_forces,
)

from .machine_hammer import HAMMER, hammer
from .machines import slider_crank, toggle

PACK = 3 * 210e9 * 0.06 * 0.0096**3 / 12  # N m2, three free leaves of 60 x 9.6 mm
FLOOR = 1.1135  # m, height of the ram's pin on the bare anvil


def forged(speed=5.0, height=0.01, pack=PACK, parameters=HAMMER, stops=True, positions=721):
    linkage = replace(hammer(parameters), compliance=(BeamCompliance("rocker", bending=pack),))
    crank = Angle("crank")
    work = Contact(FLOOR + height, stops=stops)
    phase = Phase("turn", 2 * np.pi, {"work": work}, "drive")
    return run_cycle(
        linkage, Cycle("turn", crank, 0.0, SteadyPace(crank, speed), (phase,), positions)
    )


def tip_stiffness(x):
    """N/m at a distance x from the pivot of a beam on two supports 0.46 m apart (E I = PACK)."""
    return 3 * PACK / (x**2 * (x + 0.46))


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


# -- the toggle near its dead centre


def weightless():
    return toggle(m_bar=0.0, m_mould=0.0, i_bar=0.0)


@pytest.mark.parametrize(
    ("touch", "stiffness", "reached"), [(1.0, 225.8, 226.0), (2.0, 79.8, 160.0), (5.0, 20.2, 101.0)]
)
def test_the_knee_is_pulled_through_below_a_stiffness_and_jams_above(touch, stiffness, reached):
    """Contact at x = 1, 2, 5 mm under 11 kN; kN/mm and kN by an independent solution.

    Near the dead centre F = 2 k (c - x) sqrt(2 x / h), largest at x = c / 3.
    """
    found = pull_through(weightless(), "cylinder", 11e3, "process", -(500.0 - touch))
    assert_allclose(found.stiffness / 1e3, stiffness, atol=0.051)
    assert_allclose(found.force / 1e3, reached, rtol=5e-3)
    for factor, jams in ((0.999, False), (1.001, True)):
        cycle = pressed(weightless(), Contact(-(500.0 - touch), factor * found.stiffness))
        assert (cycle.efforts["cylinder"].max() > 11e3) == jams
        assert_allclose(cycle.efforts["process"].max(), factor * found.stiffness * touch, rtol=1e-4)


def pressed(linkage, contact, to=95.0, positions=400):
    """Knee from 10 degrees before its dead centre through it, led by the lower bar's angle."""
    knee = Angle("lower")
    phase = Phase("close", np.radians(to), {"process": contact}, "cylinder")
    return run_cycle(
        linkage,
        Cycle("press", knee, np.radians(80.0), SteadyPace(knee, 0.01), (phase,), positions),
    )


STEEL = {"axial": 210e3 * 1857.0}  # E A of a tube 80 x 80 x 6.3


def elastic(**changes):
    return replace(
        toggle(m_bar=0.0, m_mould=0.0, i_bar=0.0, **changes),
        compliance=(
            BeamCompliance("lower", **STEEL),
            BeamCompliance("upper", **STEEL),
            JointCompliance("C", 400e3),
        ),
    )


def test_bars_pivot_and_mould_give_way_in_series():
    """Every stiffness in the force's way: 1/k = 2 L / E A + 1/400 + 1/80, over cos2 of the knee."""
    cycle = pressed(elastic(), Contact(-498.0, 80e3), to=90.0)
    soft = (2 * 250.0 / STEEL["axial"] + 1 / 400e3) + 1 / 80e3
    assert_allclose(cycle.efforts["process"][-1], 2.0 / soft, rtol=1e-9)


def test_force_and_cylinder_stay_finite_through_the_dead_centre():
    """Process force rises to the dead centre and falls behind it; the cylinder's has its maximum
    before and is zero there, where it holds nothing."""
    cycle = pressed(elastic(), Contact(-498.0))
    knee = np.degrees(cycle.positions) - 90.0
    process, cylinder = cycle.efforts["process"], cycle.efforts["cylinder"]
    before = knee <= 0.0
    assert (np.diff(process[before]) >= 0.0).all()
    assert (np.diff(process[knee >= 0.0]) <= 0.0).all()
    top = int(cylinder.argmax())
    assert -10.0 < knee[top] < -1.0
    assert abs(np.interp(0.0, knee, cylinder)) < 1e-3 * cylinder.max()
    assert np.isfinite(process).all()


@pytest.mark.parametrize("knee", [10.0, 3.0, 0.5, np.degrees(1e-6), 0.0])
def test_first_order_is_within_the_strain_of_the_full_solution(knee):
    """Lengths, equilibrium and contact of the deformed press solved without small displacements.

    Contact before the knee is reached, so that it presses everywhere. The strain is 2e-4 to 1e-3.
    """
    linkage = elastic()
    touch = 500.0 * np.cos(np.radians(max(knee, 3.0))) - 0.6
    phase = Phase("hold", np.radians(90.0 - knee) + 1e-9, {"process": Contact(-touch)}, "cylinder")
    angle = Angle("lower")
    start = np.radians(90.0 - knee)
    cycle = run_cycle(linkage, Cycle("hold", angle, start, SteadyPace(angle, 1.0), (phase,), 2))
    force, pull = cycle.efforts["process"][0], cycle.efforts["cylinder"][0]
    place = cycle.point("lower", "B")[0]
    rear = np.array([-350.0, 250.0])
    reach = np.hypot(*(place - rear))

    def left(unknown):
        lower, upper, cylinder = unknown[2:] * 1e5
        knee_point = place + unknown[:2]
        foot = np.array([0.0, 0.0]) - lower * (knee_point / np.hypot(*knee_point)) / 400e3
        top = np.array([0.0, touch])
        first, second = knee_point - foot, top - knee_point
        along, across = first / np.hypot(*first), second / np.hypot(*second)
        back = (rear - knee_point) / np.hypot(*(rear - knee_point))
        balance = lower * along - upper * across + cylinder * back
        return [
            np.hypot(*first) - 250.0 * (1 - lower / STEEL["axial"]),
            np.hypot(*second) - 250.0 * (1 - upper / STEEL["axial"]),
            np.hypot(*(rear - knee_point)) - reach,
            balance[0] / 1e5,
            balance[1] / 1e5,
        ]

    solved, _, flag, message = fsolve(
        left, [0.0, 0.0, force / 1e5, force / 1e5, pull / 1e5], full_output=True, xtol=1e-12
    )
    assert flag == 1, message
    upper = solved[3] * 1e5
    knee_point = place + solved[:2]
    second = np.array([0.0, touch]) - knee_point
    expected = upper * second[1] / np.hypot(*second)
    strain = upper / STEEL["axial"]
    assert abs(force / expected - 1.0) < 5 * strain
    assert abs(pull - solved[4] * 1e5) < 5 * strain * expected


def test_a_matrix_of_a_bar_does_what_its_tube_does():
    """Compliance of a bar of length 250 held at its first end: L / E A along it."""
    matrix = np.zeros((6, 6))
    matrix[3, 3] = 250.0 / STEEL["axial"]
    linkage = replace(
        weightless(),
        compliance=tuple(
            MatrixCompliance(bar, points, matrix)
            for bar, points in (("lower", ("C", "B")), ("upper", ("B", "A")))
        ),
    )
    tubes = replace(
        linkage, compliance=(BeamCompliance("lower", **STEEL), BeamCompliance("upper", **STEEL))
    )
    one, other = (pressed(given, Contact(-498.0, 80e3)) for given in (linkage, tubes))
    assert_allclose(one.efforts["process"].max(), other.efforts["process"].max(), rtol=1e-12)


def test_metres_and_millimetres_agree():
    """The hammer in t, mm, N is the hammer in kg, m, N."""
    metres = forged(positions=200)
    linkage = hammer()

    def place(pair):
        return (1e3 * pair[0], 1e3 * pair[1])

    def body(old):
        points = {name: place(point) for name, point in old.points.items()}
        return Body(old.name, points, 1e-3 * old.mass, 1e3 * old.inertia, place(old.centre))

    scaled = replace(
        linkage,
        bodies=tuple(body(old) for old in linkage.bodies),
        assembled={
            name: (1e3 * x, 1e3 * y, turn) for name, (x, y, turn) in linkage.assembled.items()
        },
        gravity=place(linkage.gravity),
        compliance=(BeamCompliance("rocker", bending=1e6 * PACK),),
    )
    crank = Angle("crank")
    phase = Phase("turn", 2 * np.pi, {"work": Contact(1e3 * (FLOOR + 0.01))}, "drive")
    cycle = run_cycle(scaled, Cycle("turn", crank, 0.0, SteadyPace(crank, 5.0), (phase,), 200))
    assert_allclose(cycle.efforts["work"].max(), metres.efforts["work"].max(), rtol=1e-9)
    assert_allclose(cycle.efforts["drive"].max(), 1e3 * metres.efforts["drive"].max(), rtol=1e-9)


# what the deflected shape changes


def softly_held(stiffness, axial):
    """A knee pushed straight by a rod of 300 mm from a slider that gives way along its guide."""
    bar, start = 250.0, 20.0
    knee = (np.sqrt(bar**2 - ((500.0 - start) / 2) ** 2), (500.0 - start) / 2)
    slider = (knee[0] + np.sqrt(300.0**2 - (250.0 - knee[1]) ** 2), 250.0)
    base = toggle(m_bar=0.0, m_mould=0.0, i_bar=0.0, opening=start)
    ground = Body(GROUND, {"C": (0.0, 0.0), "O": (0.0, 0.0), "rail": (0.0, 250.0)})
    return replace(
        base,
        bodies=(
            ground,
            *base.bodies[1:],
            Body("rod", {"B": (0.0, 0.0), "S": (300.0, 0.0)}),
            Body("slider", {"S": (0.0, 0.0)}),
        ),
        joints=(
            *base.joints,
            Revolute("B:rod", "lower", "rod", "B"),
            Revolute("S", "rod", "slider", "S"),
            Prismatic("rail", GROUND, "slider", "rail", "S", (1.0, 0.0)),
        ),
        forces=(
            Force("push", PointCoordinate("slider", "S", (1.0, 0.0)), -1),
            base.forces[1],
        ),
        assembled={
            **base.assembled,
            "rod": (*knee, np.arctan2(250.0 - knee[1], slider[0] - knee[0])),
            "slider": (*slider, 0.0),
        },
        friction={},
        compliance=(
            BeamCompliance("lower", axial=axial),
            BeamCompliance("upper", axial=axial),
            JointCompliance("S", stiffness),
        ),
    )


def in_full(slider, stiffness, axial, knee, touch=498.0):
    """Push and process force of the same knee with all lengths and angles as they become."""
    for share in np.linspace(0.02, 1.0, 60):  # the contact is driven in, so that Newton follows
        place = 500.0 - share * (500.0 - touch)

        def left(at, place=place):
            lower, upper = np.hypot(*at), np.hypot(at[0], place - at[1])
            rod = np.hypot(slider - at[0], 250.0 - at[1])
            first, second = (axial / 250.0 * (250.0 - length) for length in (lower, upper))
            pull = stiffness * (rod - 300.0)
            return (
                first * at / lower
                + second * np.array([at[0], at[1] - place]) / upper
                + pull * np.array([slider - at[0], 250.0 - at[1]]) / rod
            ) / 1e4

        knee, _, flag, message = fsolve(left, knee, full_output=True, xtol=1e-13)
        assert flag == 1, message
    rod = np.array([slider - knee[0], 250.0 - knee[1]])
    push = stiffness * (np.hypot(*rod) - 300.0) * rod[0] / np.hypot(*rod)
    return -push


@pytest.mark.parametrize("stiffness", [1e6, 1e5, 2e4, 5e3, 2e3])
def test_the_gate_tells_how_far_a_softly_held_knee_is_from_small_deflections(stiffness):
    """Against statics with the deformed shape: the push is off by 0.5 to 29 %, the gate says so.

    The knee folds under 2 F / k L, which no strain shows (4e-3 at most here).
    """
    axial, angle = 2e7, np.radians(1.0)
    knee = 250.0 * np.array([np.sin(angle), np.cos(angle)])
    start = knee[0] + np.sqrt(300.0**2 - (250.0 - knee[1]) ** 2)
    slider = PointCoordinate("slider", "S", (1.0, 0.0))
    phase = Phase("hold", start - 1e-3, {"process": Contact(-498.0)}, "push")
    cycle = run_cycle(
        softly_held(stiffness, axial),
        Cycle("hold", slider, start, SteadyPace(slider, 1.0), (phase,), 2),
    )
    expected = in_full(start, stiffness, axial, knee)
    off = abs(cycle.efforts["push"][0] / expected - 1.0)
    assert 0.9 * off < cycle.second_order < 1.3 * off + 1e-3


@pytest.mark.parametrize(("pack", "low", "high"), [(PACK, 0.005, 0.02), (PACK / 30, 0.15, 0.4)])
def test_a_leaf_that_swings_as_far_as_its_arm_is_told(pack, low, high):
    assert low < forged(pack=pack).second_order < high


def test_a_rigid_linkage_has_no_second_order():
    assert pressed(weightless(), Contact(-498.0, 80e3)).second_order == 0.0


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


# -- what the positions must not step over


@pytest.mark.parametrize("depth", [5e-4, 2e-3])
@pytest.mark.parametrize("start", [0.3, 1.7, 3.1, 4.4])
def test_a_contact_much_shorter_than_a_step_is_found(depth, start):
    """A slider that touches a stiff stop by a micrometre at its outer dead centre: k depth."""
    linkage = slider_crank(50.0, 200.0, at=start)
    linkage = replace(
        linkage,
        forces=(linkage.forces[0], Force("push", PointCoordinate("slider", "B", (-1.0, 0.0)))),
    )
    crank = Angle("crank")
    phase = Phase("turn", start + 2 * np.pi, {"push": Contact(-(250.0 - depth), 5e5)}, "drive")
    cycle = run_cycle(linkage, Cycle("turn", crank, start, SteadyPace(crank, 5.0), (phase,), 361))
    assert_allclose(cycle.efforts["push"].max(), 5e5 * depth, rtol=1e-6)


@pytest.mark.parametrize("width", [0.1, 1e-3, 1e-4])
def test_a_narrow_table_over_another_coordinate_is_not_missed(width):
    """A triangle of -1000 N over the slider's place; its work over a turn is nothing."""
    linkage = slider_crank(50.0, 200.0, at=0.4)
    slider = PointCoordinate("slider", "B", (1.0, 0.0))
    table = Table(
        slider, (100.0, 210.0, 210.0 + width / 2, 210.0 + width, 300.0), (0, 0, -1000.0, 0, 0)
    )
    crank = Angle("crank")
    phase = Phase("turn", 0.4 + 2 * np.pi, {"push": table}, "drive")
    cycle = run_cycle(linkage, Cycle("turn", crank, 0.4, SteadyPace(crank, 5.0), (phase,), 361))
    assert_allclose(cycle.efforts["push"].min(), -1000.0, rtol=1e-6)


# -- refusals


def test_rigid_on_rigid_is_refused():
    with pytest.raises(LinkageError, match="nothing gives way between a rigid contact"):
        pressed(weightless(), Contact(-498.0))


def test_the_process_cannot_lead_through_its_own_dead_centre():
    linkage = elastic()
    height = linkage.force("process").coordinate
    phase = Phase("close", -500.0, {"process": Contact(-498.0)}, "cylinder")
    with pytest.raises(LinkageError, match="dead centre"):
        run_cycle(linkage, Cycle("press", height, -300.0, SteadyPace(height, 1.0), (phase,), 40))


@pytest.mark.parametrize(
    ("compliance", "words"),
    [
        ((JointCompliance("X", 1.0),), "no joint is named 'X'"),
        ((BeamCompliance("upperr", axial=1.0),), "did you mean 'upper'"),
        ((BeamCompliance("upper", axial=1.0),) * 2, "stated twice"),
        ((MatrixCompliance("upper", ("B",), np.eye(3)),), "acts at point 'A', for which"),
    ],
)
def test_a_compliance_that_fits_nothing_is_refused(compliance, words):
    with pytest.raises(LinkageError, match=words):
        pressed(replace(weightless(), compliance=compliance), Contact(-498.0, 80e3))


def test_two_contacts_at_once_are_refused():
    linkage = weightless()
    knee = Angle("lower")
    phase = Phase(
        "close", 1.5, {"process": Contact(-498.0, 1e3), "cylinder": Contact(350.0, 1e3)}, "spare"
    )
    with pytest.raises(LinkageError, match=r"contacts of one phase"):
        run_cycle(linkage, Cycle("press", knee, 1.4, SteadyPace(knee, 0.01), (phase,), 40))


def test_a_beam_loaded_beside_its_axis_is_refused():
    """A bell crank is no straight beam: its other arm would be taken as rigid."""
    base = weightless()
    bent = replace(base.body("lower"), points={"C": (0.0, 0.0), "B": (200.0, 150.0)})
    linkage = replace(
        base,
        bodies=tuple(bent if body.name == "lower" else body for body in base.bodies),
        assembled={**base.assembled, "lower": (0.0, 0.0, 0.0)},
        compliance=(BeamCompliance("lower", bending=1e9),),
    )
    with pytest.raises(LinkageError, match=r"'lower': .* acts 150 mm beside the axis"):
        pressed(linkage, Contact(-350.0, 80e3), to=5.0)


def test_a_force_along_a_distance_that_vanishes_is_refused():
    linkage = slider_crank(50.0, 200.0, at=1.0)
    linkage = replace(
        linkage,
        bodies=tuple(
            Body(GROUND, {**body.points, "end": (250.0, 0.0)}) if body.name == GROUND else body
            for body in linkage.bodies
        ),
        forces=(linkage.forces[0], Force("push", Distance(GROUND, "end", "slider", "B"))),
    )
    crank = Angle("crank")
    phase = Phase("turn", 0.0, {"push": 1.0}, "drive")
    with pytest.raises(LinkageError, match=r"distance end-B shrinks to nothing"):
        run_cycle(linkage, Cycle("turn", crank, 1.0, SteadyPace(crank, 1.0), (phase,), 20))


def test_pull_through_refuses_what_it_cannot_mean():
    linkage = weightless()
    with pytest.raises(LinkageError, match="drive and process at once"):
        pull_through(linkage, "process", 11e3, "process", -498.0)
    with pytest.raises(LinkageError, match="must be finite"):
        pull_through(linkage, "cylinder", float("nan"), "process", -498.0)
    assert pull_through(linkage, "cylinder", -11e3, "process", -498.0) is None
    assert pull_through(linkage, "cylinder", 11e3, "process", -500.0) is None
