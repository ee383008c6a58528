"""Forces against the motion: their size by hand, their side at a reversal, the work they take."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import loads

CRANK, ROD = 60.0, 200.0  # mm
SPEED = 5.0  # rad/s


def slider_crank(law, start=0.5, turns=1.0, **body):
    """A massless in-line slider-crank, its slider rubbed along x, and a cycle of its crank."""
    ground = loads.Body("ground", {"O": (0.0, 0.0)})
    crank = loads.Body("crank", {"O": (0.0, 0.0), "A": (CRANK, 0.0)})
    rod = loads.Body("rod", {"A": (0.0, 0.0), "B": (ROD, 0.0)})
    slider = loads.Body("slider", {"B": (0.0, 0.0)}, **body)
    turn = np.arcsin(-CRANK * np.sin(start) / ROD)
    end = CRANK * np.cos(start) + ROD * np.cos(turn)
    linkage = loads.Linkage(
        (ground, crank, rod, slider),
        (
            loads.Revolute("O", "ground", "crank", "O"),
            loads.Revolute("A", "crank", "rod", "A"),
            loads.Revolute("B", "rod", "slider", "B"),
            loads.Prismatic("guide", "ground", "slider", "O", "B", (1.0, 0.0)),
        ),
        (
            loads.Force("drive", loads.Angle("crank")),
            loads.Force("rub", loads.PointCoordinate("slider", "B", (1.0, 0.0))),
        ),
        {
            "crank": (0.0, 0.0, start),
            "rod": (CRANK * np.cos(start), CRANK * np.sin(start), turn),
            "slider": (end, 0.0, 0.0),
        },
        gravity=(0.0, 0.0),
    )
    angle = loads.Angle("crank")
    phase = loads.Phase("turn", start + 2 * np.pi * turns, {"rub": law}, "drive")
    cycle = loads.Cycle("cycle", angle, start, loads.SteadyPace(angle, SPEED), (phase,), 181)
    return linkage, cycle


def slope(angle):
    """d x / d angle of the slider, by hand."""
    lean = np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    return -CRANK * np.sin(angle) - CRANK**2 * np.sin(angle) * np.cos(angle) / lean


def test_dry_friction_on_a_slider_takes_its_force_times_the_way_and_jumps_at_the_dead_centres():
    """By virtual work T = F |dx/dangle|: the crank always pushes; a turn takes F times 4 r."""
    linkage, cycle = slider_crank(loads.Opposing(dry=30.0))
    cycle, origin = loads.split_cycle(linkage, cycle)
    assert [phase.name for phase in cycle.phases] == ["turn-1", "turn-2", "turn-3"]
    assert origin == (0, 0, 0)
    assert_allclose([p.stop for p in cycle.phases][:2], [np.pi, 2 * np.pi], rtol=1e-9)
    run = loads.run_cycle(linkage, cycle)
    assert_allclose(run.efforts["drive"], 30.0 * np.abs(slope(run.positions)), atol=1e-6)
    assert_allclose(np.abs(run.efforts["rub"]), 30.0, rtol=1e-12)
    at_jump = np.flatnonzero(np.diff(run.phase_of))
    for k in at_jump:  # both sides of the jump stand at the dead centre itself
        assert run.efforts["rub"][k] == -run.efforts["rub"][k + 1]
    work = np.trapezoid(run.efforts["drive"], run.positions)
    assert work == pytest.approx(30.0 * 4 * CRANK, rel=2e-3)
    assert run.power_balance_error < 1e-9


def test_viscous_force_and_a_table_over_the_speed_follow_the_speed():
    speeds, forces = (0.0, 100.0, 400.0), (20.0, 5.0, 11.0)  # falling at first, as Stribeck's curve
    for law, size in (
        (loads.Opposing(dry=2.0, viscous=0.05), lambda v: 2.0 + 0.05 * v),
        (loads.Opposing(speeds=speeds, forces=forces), lambda v: np.interp(v, speeds, forces)),
    ):
        linkage, cycle = slider_crank(law)
        cycle, _ = loads.split_cycle(linkage, cycle)
        run = loads.run_cycle(linkage, cycle)
        speed = SPEED * slope(run.positions)
        assert_allclose(np.abs(run.efforts["rub"]), size(np.abs(speed)), rtol=1e-6)
        moving = np.abs(speed) > 1e-3
        assert (run.efforts["rub"] * speed < 0)[moving].all()
        if law.speeds:  # the corner of the table has positions of its own
            assert np.abs(np.abs(speed) - 100.0).min() < 1e-6


def test_the_other_way_round_the_forces_are_the_same():
    """Run backwards, at every place the rubbing force turns over and the torque with it."""
    linkage, cycle = slider_crank(loads.Opposing(dry=30.0), start=0.5)
    forward = loads.run_cycle(linkage, loads.split_cycle(linkage, cycle)[0])
    (phase,) = cycle.phases
    back = replace(cycle, start=phase.stop, phases=(replace(phase, stop=cycle.start),))
    backward = loads.run_cycle(linkage, loads.split_cycle(linkage, back)[0])
    for place in (1.0, 2.0, 4.0, 6.0):
        there, here = (
            np.interp(place, *(part[np.argsort(run.positions)] for part in
                               (run.positions, run.efforts["drive"])))
            for run in (forward, backward)
        )  # fmt: skip
        assert here == pytest.approx(-there, rel=1e-3)


def test_a_heavy_slider_is_slowed_by_the_force_and_its_reactions_balance():
    """The rod carries inertia and friction: m a - F along x, from the crank's own kinematics."""
    linkage, cycle = slider_crank(loads.Opposing(dry=30.0), mass=2e-3)
    run = loads.run_cycle(linkage, loads.split_cycle(linkage, cycle)[0])
    acceleration = run.accelerations[:, linkage.body_names.index("slider"), 0]
    pull = run.reactions["B"].force[:, 0]
    assert_allclose(pull + run.efforts["rub"], 2e-3 * acceleration, atol=1e-6)


def test_a_table_that_does_not_cover_the_speed_is_refused_with_the_place():
    linkage, cycle = slider_crank(loads.Opposing(speeds=(0.0, 200.0), forces=(1.0, 2.0)))
    with pytest.raises(loads.LinkageError, match=r"goes up to 0\.2 m/s and does not cover 0\.\d+"):
        loads.run_cycle(linkage, loads.split_cycle(linkage, cycle)[0])


def test_without_forces_against_the_motion_no_phase_is_split():
    linkage, cycle = slider_crank(12.0)
    assert loads.split_cycle(linkage, cycle) == (cycle, (0,))


def test_parts_of_a_phase_take_no_name_that_is_there():
    linkage, cycle = slider_crank(loads.Opposing(dry=1.0), turns=0.5)
    (phase,) = cycle.phases
    rest = replace(phase, name="turn-1", stop=phase.stop + 1.0)
    split, origin = loads.split_cycle(linkage, replace(cycle, phases=(phase, rest)))
    assert [p.name for p in split.phases] == ["turn--1", "turn--2", "turn-1"]
    assert origin == (0, 0, 1)


@pytest.mark.parametrize(
    ("stated", "told"),
    [
        ({"dry": -1.0}, "must be 0 or above"),
        ({"viscous": float("inf")}, "must be 0 or above"),
        ({"dry": 1.0, "speeds": (0.0, 1.0), "forces": (1.0, 1.0)}, "stands alone"),
        ({"speeds": (0.0,), "forces": (1.0,)}, "at least two"),
        ({"speeds": (1.0, 2.0), "forces": (1.0, 1.0)}, "begin at 0"),
        ({"speeds": (0.0, 2.0, 2.0), "forces": (1.0, 1.0, 1.0)}, "must rise"),
    ],
)
def test_a_law_that_cannot_be_is_refused(stated, told):
    with pytest.raises(loads.LinkageError, match=told):
        loads.Opposing(**stated)
