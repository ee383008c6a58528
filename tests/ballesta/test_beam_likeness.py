"""Which bodies bend as beams in vibration: all that loads them stands on their axis, to 1 %."""

from types import SimpleNamespace

import pytest

from ballesta.machine.quasi_static import _beam_like
from loads import GROUND, Angle, Body, Distance, Force, PointCoordinate, Revolute, Slot


def linkage(points, joints=(), forces=()):
    bar = Body("bar", points)
    return SimpleNamespace(body={"bar": bar}.get, joints=joints, forces=forces)


def pinned(size):
    """Pins at both ends, `size` mm apart, and a force at P."""
    return (
        (
            Revolute("A", GROUND, "bar", "A"),
            Revolute("B", "bar", "slider", "B"),
        ),
        (Force("pull", PointCoordinate("bar", "P", (0.0, 1.0))),),
    )


@pytest.mark.parametrize("size", [0.1, 100.0, 1e4])
@pytest.mark.parametrize(("aside", "beam"), [(0.0, True), (0.009, True), (0.011, False)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_force_beside_the_axis_by_more_than_1_per_cent_of_the_length_makes_no_beam(
    size, aside, beam, side
):
    points = {"A": (0.0, 0.0), "B": (size, 0.0), "P": (0.3 * size, side * aside * size)}
    assert _beam_like(linkage(points, *pinned(size)), "bar") is beam


def test_a_length_counts_between_what_loads_the_bar_wherever_its_origin_is():
    """From -900 to -800 mm: 100 mm; 1.1 mm aside are too much of it, 0.9 mm are not."""
    for aside, beam in ((1.1, False), (0.9, True)):
        points = {"A": (-900.0, 0.0), "B": (-800.0, 0.0), "P": (-850.0, aside)}
        assert _beam_like(linkage(points, *pinned(100.0)), "bar") is beam


@pytest.mark.parametrize(("slope", "beam"), [(0.0, True), (1e-3, False), (-1e-3, False)])
def test_a_slot_that_does_not_run_along_the_axis_makes_no_beam(slope, beam):
    points = {"A": (0.0, 0.0), "B": (100.0, 0.0)}
    joints = (
        Revolute("A", GROUND, "bar", "A"),
        Slot("slot", "bar", "block", "B", "B", (1.0, slope)),
    )
    assert _beam_like(linkage(points, joints), "bar") is beam


def test_forces_between_two_points_and_couples_count_where_they_act():
    """A spring at P, 20 mm beside a bar of 100 mm, on either end; a couple at no point of it."""
    points = {"A": (0.0, 0.0), "B": (100.0, 0.0), "P": (50.0, 20.0)}
    joints, _ = pinned(100.0)
    ground = (GROUND, "O")
    for ends, beam in (((*ground, "bar", "P"), False), (("bar", "P", *ground), False),
                       ((*ground, "bar", "B"), True)):  # fmt: skip
        forces = (Force("spring", Distance(*ends)),)
        assert _beam_like(linkage(points, joints, forces), "bar") is beam
    for at, beam in (("A", True), ("P", False), (None, False)):
        forces = (Force("drive", Angle("bar", GROUND, at)),)
        assert _beam_like(linkage(points, joints, forces), "bar") is beam
