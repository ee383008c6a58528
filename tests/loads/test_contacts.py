"""Contacts and tables that positions must not step over, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from loads import (
    GROUND,
    Angle,
    BeamCompliance,
    Body,
    Contact,
    Cycle,
    Distance,
    Force,
    JointCompliance,
    LinkageError,
    MatrixCompliance,
    Phase,
    PointCoordinate,
    SteadyPace,
    Table,
    pull_through,
    run_cycle,
)

from .elastic_machines import (
    elastic,
    pressed,
    weightless,
)
from .machines import slider_crank


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


def test_a_contact_begins_at_its_touch_on_whichever_side_of_it_round_off_lies():
    """The last free position before a blow has its speed: its own at the stop."""
    linkage = slider_crank(50.0, 200.0, at=0.3)
    linkage = replace(
        linkage,
        forces=(linkage.forces[0], Force("push", PointCoordinate("slider", "B", (-1.0, 0.0)))),
    )
    crank = Angle("crank")
    for at in np.linspace(160.0, 245.0, 12):
        phase = Phase("turn", 0.3 + 2 * np.pi, {"push": Contact(-at, 5e3)}, "drive")
        cycle = run_cycle(linkage, Cycle("turn", crank, 0.3, SteadyPace(crank, 5.0), (phase,), 361))
        begins = cycle.contacts["push"].begins
        assert_allclose(cycle.point("slider", "B")[begins, 0], at, atol=1e-9)


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


@pytest.mark.parametrize("stiffness", [0.0, -1.0, float("inf"), float("nan")])
def test_a_contact_without_a_finite_stiffness_above_0_is_refused(stiffness):
    with pytest.raises(LinkageError, match="stiffness of a contact must be above 0"):
        Contact(0.0, stiffness)
