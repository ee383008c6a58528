"""A toggle at its dead centre, limited by softness, and how far small deflections hold."""

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
    Force,
    JointCompliance,
    MatrixCompliance,
    Phase,
    PointCoordinate,
    Prismatic,
    Revolute,
    SteadyPace,
    pull_through,
    run_cycle,
)

from .elastic_machines import (
    FLOOR,
    PACK,
    STEEL,
    elastic,
    forged,
    pressed,
    weightless,
)
from .machine_hammer import hammer
from .machines import toggle


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
