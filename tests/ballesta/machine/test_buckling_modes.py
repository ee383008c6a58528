"""Buckling modes of the live view: of a bar's frame, and of all bodies of a linkage together."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.motion import _of_part
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.ladder.part_fields import with_mode
from checks.models.bar_modes import half_wave, moved_with
from checks.result.live_fields import grey
from reports.live.section import live_section
from reports.page_words import shown_of

DESIGNS = Path(__file__).parents[3] / "designs"


ARMS = ("lower_left", "lower_right", "upper_left", "upper_right")


def checked(name, *overrides):
    design = read_design(DESIGNS / f"{name}.toml", overrides)
    return check_design(design, effort=Effort("formula"), live=True)


@pytest.fixture(scope="module")
def jack():
    return checked("gallery/scissors_jack", *(f"parts.{name}.bearing_arc=90 deg" for name in ARMS))


def test_a_column_longer_than_the_part_has_the_mode_of_both_bars_whose_knee_moves_most():
    """500 mm out of the plane, of two bars of 250 mm: half a sine wave over both, 1 at the knee.

    The bars meet at an angle at the knee, which twists both: walls differ by 0.04 from the axis.
    """
    result = checked("toggle_press_30x30")
    design = read_design(DESIGNS / "toggle_press_30x30.toml")
    assert result.deciding.quantity == "column out of plane"
    for part in result.parts:
        nodes, mode, own = part.live.nodes, part.live.mode, design.parts[part.name]
        (knee,) = (i for i in own.geometry.placed_interfaces if own.interfaces[i.name] == "B")
        far = np.abs(nodes[:, 0] - knee.centre[0])
        assert_allclose(np.abs(mode[:, 2]), np.cos(np.pi * far / 500.0), atol=0.06)
        assert np.abs(mode[:, 1]).max() < 0.06
        alone = replace(part, live=replace(part.live, mode=None, notes=()))
        told = _of_part(design, alone).live  # without the linkage's mode: a quarter of a wave
        assert_allclose(np.abs(told.mode[:, 2]), np.abs(np.cos(np.pi * far / 500.0)), atol=0.02)
        assert "of 500 mm, of which this is a part" in told.notes[-1]
        held = [replace(check, span=125.0) for check in part.checks]
        shorter = _of_part(design, replace(alone, checks=held)).live
        assert shorter.mode is None
        assert "not how its ends are held" in shorter.notes[-1]
        unknown = [one for one in part.checks if one.quantity == "elastic load share"]
        told = _of_part(design, replace(alone, checks=unknown)).live  # what no shape has a mode for
        assert told.mode is None
        assert "gives a load alone" in told.notes[-1]
    assert shown_of(result.deciding, result)["mode"]


@pytest.mark.parametrize(
    ("plane", "across", "sign"), [("in plane", 1, -1), ("out of plane", 2, -1)]
)
def test_a_hinged_bar_buckles_in_half_a_sine_wave_and_its_sections_turn_with_it(
    plane, across, sign
):
    """Euler: w = sin(pi x/L); a point c beside the axis moves by -c w' along it."""
    mode = half_wave(np.array([10.0, 0.0, 0.0]), np.array([210.0, 0, 0]), plane)
    x = np.array([10.0, 60.0, 110.0, 210.0])
    nodes = np.zeros((4, 3))
    nodes[:, 0], nodes[:, across] = x, 8.0
    found = mode(nodes)
    assert_allclose(found[:, across], np.sin(np.pi * (x - 10) / 200), atol=2e-3)
    slope = np.pi / 200 * np.cos(np.pi * (x - 10) / 200)
    assert_allclose(found[:, 0], sign * 8.0 * slope, atol=2e-4)


def result_of_pins():
    design = read_design(DESIGNS / "gallery" / "steam_engine.toml")
    return design.parts["rod"].geometry.placed_interfaces


def test_a_part_that_buckles_between_its_own_pins_has_its_half_wave():
    result = checked("gallery/steam_engine", "require.buckling=6")  # else fatigue decides
    assert result.deciding.plane == "in plane"
    (rod,) = result.parts
    first, second = (one.centre[0] for one in result_of_pins())
    x = rod.live.nodes[:, 0]
    between = (x > first) & (x < second)
    wave = np.sin(np.pi * (x - first) / (second - first))
    assert_allclose(rod.live.mode[between, 1], wave[between], atol=5e-3)
    assert np.abs(rod.live.mode[:, 2]).max() == 0.0


def test_all_parts_have_the_mode_of_a_linkage_that_decides_and_meet_at_their_pins(jack):
    """Out of the plane: both bars at a pin of soft forks move aside alike, by the same size."""
    assert jack.deciding.place == "out of plane mode"
    modes = {part.name: part.live.mode for part in jack.parts}
    assert max(np.linalg.norm(mode, axis=1).max() for mode in modes.values()) == pytest.approx(1)

    def aside(name, where):  # at the bore that is there, in the middle plane
        (part,) = (part for part in jack.parts if part.name == name)
        motion = jack.motion["lift"]
        row = int(np.flatnonzero(np.asarray(motion.index) == 0)[0])
        x, y, angle = motion.parts[name][row]
        c, s = np.cos(angle), np.sin(angle)
        ground = part.live.nodes[:, :2] @ [[c, s], [-s, c]] + [x, y]
        return float(part.live.mode[np.linalg.norm(ground - where, axis=1) < 10.0, 2].mean())

    motion = jack.motion["lift"]
    pins = {pin.point: pin.place[0] for pin in motion.pins.values()}
    on = {point: [p.on for p in motion.pins.values() if p.point == point] for point in pins}
    assert any(len(names) == 2 for names in on.values())
    for point, names in on.items():
        if len(names) == 2:
            first, second = (aside(name, pins[point]) for name in names)
            assert first == pytest.approx(second, abs=0.06)


def test_the_page_of_a_linkage_that_decides_begins_with_all_parts(jack):
    shown = shown_of(jack.deciding, jack)
    assert (shown["part"], shown["mode"], shown["position"]) == (-1, True, [0, 0])
    assert '"first":-1' in live_section(jack)


def test_a_crooked_bar_that_governs_bows_as_its_column_and_says_that_it_is_no_mode():
    """Yield of the edge has no shape of its own; a bow of 60 mm makes it decide."""
    result = checked("gallery/steam_engine", "parts.rod.column.crookedness=60 mm")
    (rod,) = result.parts
    assert result.deciding.quantity.startswith("crooked bar")
    assert result.deciding.span == pytest.approx(1600.0)
    assert "a crooked bar bows" in rod.live.notes[-1]
    across = 1 if result.deciding.plane == "in plane" else 2
    assert np.abs(rod.live.mode[:, across]).max() > 0.99


@pytest.mark.parametrize(
    "name", [pytest.param("quick_return", marks=pytest.mark.slow), "gallery/gripper"]
)
def test_a_part_whose_elastic_load_governs_has_the_mode_of_its_formula(name):
    """A slotted lever, and a link that is bent: both were "not drawn"."""
    result = checked(name, "require.buckling=1000")
    part = next(part for part in result.parts if part.name == result.deciding.part)
    assert (result.deciding.quantity, result.deciding.method) == ("elastic load share", "formula")
    assert np.linalg.norm(part.live.mode, axis=1).max() == pytest.approx(1)
    assert "not drawn" not in " ".join(part.live.notes)
    assert np.abs(part.live.mode[:, 2]).max() > 0.9


def test_nodes_of_a_rigid_body_turn_about_its_place():
    """A turn of 0.01 about z at (10, 0, 0), and a shift along z."""
    nodes = np.array([[10.0, 0.0, 0.0], [30.0, 0.0, 5.0], [10.0, 4.0, 0.0]])
    found = moved_with(nodes, np.array([[10.0, 0, 0]]), np.array([[0, 0, 0.5, 0, 0, 0.01]]))
    assert_allclose(found, [[0, 0, 0.5], [0, 0.2, 0.5], [-0.04, 0, 0.5]], atol=1e-12)


def test_a_plate_that_is_bent_aside_and_twists_moves_so_where_that_decides():
    """Held sideways at its saddle and the pin nearest to that; beyond, it goes on as it turns."""
    result = checked("gallery/pumpjack", "require.buckling=25")
    assert (result.deciding.part, result.deciding.kind) == ("beam", "buckling")
    (beam,) = (part for part in result.parts if part.name == "beam")
    nodes, mode = beam.live.nodes, beam.live.mode
    assert np.linalg.norm(mode, axis=1).max() == pytest.approx(1)
    middle = np.abs(nodes[:, 2]) < 1e-6
    assert np.abs(mode[middle][:, :2]).max(initial=0.0) < 1e-9
    part = read_design(DESIGNS / "gallery" / "pumpjack.toml").parts["beam"]
    aside = {}
    for pin in part.geometry.placed_interfaces:
        bore = np.linalg.norm(nodes[:, :2] - pin.centre[:2], axis=1) < 60.0
        aside[pin.name] = abs(mode[bore, 2].mean())
    assert max(aside["S"], aside["T"]) < 0.05 < 0.5 < aside["H"]
    assert "the bar is bent aside and twists" in beam.live.notes[-1]
    assert shown_of(result.deciding, result)["mode"]


@pytest.mark.slow
def test_a_plate_s_mode_by_formula_is_that_of_its_solid():
    """Their correlation (x.y)^2/(x.x y.y): 0.9977 on a coarse mesh, at 278 and 251 deg."""
    design = read_design(DESIGNS / "gallery" / "pumpjack.toml", ("accuracy=0.3",))
    solid = check_design(design, effort=Effort("solid"), live=True).parts[0].live
    by_formula = checked("gallery/pumpjack", "require.buckling=25").parts[0].live
    x = by_formula.mode.ravel()
    y = with_mode(by_formula, (solid.nodes, solid.mode)).mode.ravel()
    assert (x @ y) ** 2 / (x @ x) / (y @ y) > 0.996


def test_a_solid_s_mode_is_taken_to_another_mesh_and_back_to_its_own_as_it_is():
    """A bow of w = 1 - x^2 on 41 nodes a side: on its own nodes exact, between them to a step."""
    x, y = (each.ravel() for each in np.meshgrid(*2 * [np.linspace(-1, 1, 41)], indexing="ij"))
    nodes, bow = np.stack([x, y, 0 * x], axis=1), np.stack([0 * x, 0 * x, 1 - x**2], axis=1)
    own = with_mode(grey(nodes, np.array([[0, 1, 42]]), "by formula"), (nodes, 5 * bow))
    assert_allclose(own.mode, bow, atol=1e-6)
    inner = 0.9 * nodes
    other = with_mode(grey(inner, np.array([[0, 1, 42]]), "by formula"), (nodes, bow))
    assert_allclose(other.mode[:, 2], 1 - inner[:, 0] ** 2, atol=0.05)
    assert with_mode(own, None) is own
