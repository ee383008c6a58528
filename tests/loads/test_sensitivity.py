"""General tolerances and loads: by hand, and against loads of linkages built otherwise."""

from math import sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from loads import (
    GROUND,
    Angle,
    Body,
    Cycle,
    Force,
    Linkage,
    Phase,
    PointCoordinate,
    Revolute,
    SteadyPace,
    run_cycle,
    with_places_off,
    worst_shifts,
)
from loads.sensitivity import _on_bodies

from .machines import press_cycle, toggle

SHIFT = 0.5 + 0.5 + 0.4  # mm: both bars of 250 mm, and C on the frame, 430 mm from D


def press(x):
    linkage = toggle()
    return run_cycle(linkage, press_cycle(linkage, last=x))


def largest(cycle):
    return float(np.abs(cycle.efforts["process"]).max())


def test_lengths_shift_the_dead_centre_of_a_toggle_whose_slider_is_held():
    """F goes with 1/sqrt(x): to first order dx / 2x, all lengths at their worst."""
    found = press(2.0).sensitivity
    assert found.most == pytest.approx(SHIFT / (2.0 * 2.0), rel=0.02)
    assert found.at == pytest.approx(498.0)


def test_by_its_shape_a_toggle_is_as_sensitive_as_its_bars_are_in_line():
    """0.5 mm of the knee is 2 mrad of 89 mrad, and the knee's own place about as much again."""
    far, near = press(2.0).shape_sensitivity, press(0.5).shape_sensitivity
    assert 0.5 / 250.0 / sqrt(2.0 / 250.0) < far.most < 3.0 * 0.5 / 250.0 / sqrt(2.0 / 250.0)
    assert near.most / far.most == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_places_off_at_their_worst_move_the_dead_centre_by_all_lengths(way):
    known = press(5.0)
    shifts = worst_shifts(known, known.sensitivity.row)
    off = {place: (way * x, way * y) for place, (x, y) in shifts.items()}
    linkage = with_places_off(known.linkage, off)
    built = run_cycle(linkage, press_cycle(known.linkage, last=5.0))
    expected = sqrt(5.0 / (5.0 - way * SHIFT))
    assert largest(built) / largest(known) == pytest.approx(expected, rel=0.01)


def test_a_high_ratio_alone_is_not_sensitive():
    """948 mm over 4 mm: the short arm is off by 0.1 mm in all, a fortieth; the ratio is 237."""
    lever = Body("lever", {"O": (0.0, 0.0), "S": (4.0, 0.0), "H": (948.0, 0.0)})
    linkage = Linkage(
        bodies=(Body(GROUND, {"O": (0.0, 0.0)}), lever),
        joints=(Revolute("O", GROUND, "lever", "O"),),
        forces=(
            Force("hand", PointCoordinate("lever", "H", (0.0, -1.0))),
            Force("jaw", PointCoordinate("lever", "S", (0.0, 1.0))),
        ),
        assembled={"lever": (0.0, 0.0, 0.0)},
        gravity=(0.0, 0.0),
    )
    turn = Angle("lever")
    phases = (Phase("cut", -0.05, {"hand": 120.0}, "jaw"),)
    cycle = run_cycle(linkage, Cycle("cut", turn, 0.05, SteadyPace(turn, 1.0), phases))
    assert np.abs(cycle.efforts["jaw"]).max() == pytest.approx(120.0 * 237.0)
    assert cycle.sensitivity.most == pytest.approx(0.1 / 4.0, rel=0.05)


def test_which_joints_pair_the_bodies_of_a_pin_does_not_count():
    """Forces of 30, -50 and 20 N on three bodies; with an idle third one as of two, sqrt(2) R."""

    def size(pairs, forces):
        joints = tuple(Revolute(f"A{k}", one, two, "A") for k, (one, two) in enumerate(pairs))
        linkage = SimpleNamespace(joints=joints)
        rows = {joint.name: slice(2 * k, 2 * k + 2) for k, joint in enumerate(joints)}
        stub = SimpleNamespace(linkage=linkage, n_constraints=4, rows=rows)
        return np.linalg.norm(_on_bodies(stub) @ [*np.outer(forces, [0.6, 0.8]).ravel(), 7.0])

    for pairs, forces in (
        ((("a", "b"), ("a", "c")), (-50.0, 20.0)),
        ((("b", "a"), ("b", "c")), (30.0, 20.0)),
        ((("c", "a"), ("b", "c")), (30.0, 50.0)),
    ):
        wanted = np.sqrt(30.0**2 + 50.0**2 + 20.0**2 + 2 * 7.0**2)
        assert size(pairs, forces) == pytest.approx(wanted)
    idle = size((("a", "b"), ("a", "c")), (30.0, 0.0))
    assert idle == pytest.approx(np.sqrt(2.0 * (30.0**2 + 7.0**2)))
