"""Buckling modes by formula: where they stand still, which way they go, and beside solids."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from checks.handbook.column_curves import lateral_share
from checks.models import shapes
from checks.models.bar_modes import half_wave, laid_straight, sideways
from checks.models.shapes.prismatic_tube import _walls_mode
from checks.models.shapes.toggle_bar import cheeks_alone
from checks.part.part_loads import PartLoads
from checks.strength.part_strength import elastic_of
from fem.buckling import part_buckling
from fem.unit_solutions import solve_unit_loads
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink, PrismaticTube, ToggleBar

DESIGNS = Path(__file__).parents[3] / "designs"
LEVER = read_design(DESIGNS / "quick_return.toml").parts["lever"]
ROD = read_design(DESIGNS / "slider_crank.toml").parts["rod"]
LINK = PlateLink(length=100.0, width=20.0, thickness=4.0, hole=10.0, second_hole=6.0)
BAR = ToggleBar(
    length=250.0,
    width=40.0,
    wall=2.0,
    hole=22.0,
    overhang=20.0,
    inner_radius=1.0,
    cutout_length=45.0,
    cutout_corner=3.0,
)
STATIONS, LENGTH = 65, 200.0
BENDING, TWISTING = np.full(STATIONS, 3e6), np.full(STATIONS, 2e6)


def loads(wrenches, reach=None):
    return PartLoads(
        {name: np.array([row], dtype=float) for name, row in wrenches.items()},
        np.zeros((1, 4)),
        {"turn": slice(0, 1)},
        ("k = 0",),
        ("turn",),
        {} if reach is None else {"slot": np.array([reach])},
        next(iter(wrenches)),
    )


def pushed(first, second, force):
    return loads({first: [force, 0, 0, 0, 0, 0], second: [-force, 0, 0, 0, 0, 0]})


def bent(force, across):
    """A link pushed by a force, and bent by another across at its second end."""
    length = LINK.length
    first = [force, -across, 0, 0, 0, -across * length]
    return loads({"first": first, "second": [-force, across, 0, 0, 0, 0]})


def on_axis(x, y=0.0, z=0.0):
    return np.stack(np.broadcast_arrays(np.asarray(x, dtype=float), y, z), axis=1)


def correlation(one, other):
    return np.vdot(one, other) ** 2 / np.vdot(one, one) / np.vdot(other, other)


def beside_a_solid(part, acting, fineness):
    """Correlation of the formula's mode with the lowest of a solid, on the solid's nodes."""
    solutions = solve_unit_loads(mesh_shape(part.geometry, fineness=fineness), elastic_of(part))
    state = solutions.coefficients(acting.wrenches, acting.accelerations, acting.reaches)[0][:, 0]
    solid = part_buckling(solutions, state, tilt_held=False, prove=False).modes[0].shape
    mode = shapes.model_of(part, acting).buckling.mode
    return correlation(mode(solutions.mesh.nodes), solid)


def test_a_bar_that_is_only_pushed_bows_between_where_it_is_pressed():
    """Half a sine from 20 mm on, tangents before it, and both pins stand still."""
    none, twisting = np.zeros(STATIONS), TWISTING
    both = BENDING, BENDING
    x = np.linspace(0.0, LENGTH, 33)
    found = sideways(0.1, none, both, twisting, LENGTH, (20.0, LENGTH - 20.0), False, on_axis(x))
    slope = np.pi / 160.0
    wave = np.sin(slope * np.clip(x - 20.0, 0.0, 160.0)) + 20.0 * slope
    wave -= slope * (np.maximum(20.0 - x, 0.0) + np.maximum(x - 180.0, 0.0))
    size = found[16, 2] / wave[16]
    assert_allclose(found[:, 2], size * wave, atol=2e-3 * abs(size))
    assert_allclose(found[[0, -1]], 0.0, atol=1e-9)


@pytest.mark.parametrize("push", [0.0, 0.05])
def test_a_bent_bar_s_mode_has_the_share_of_its_formula(push):
    """Energy over work of the mode, B w''^2 + C t'^2 over F w'^2 - 2 M t w'', is the load factor.

    Both exact where nothing pushes; as the column's wave is not quite the moment's, 2 % otherwise.
    """
    x = np.linspace(0.0, LENGTH, STATIONS)
    moment = 2e4 * (1 - x / LENGTH)
    share = lateral_share(np.array([push]), moment[:, None], BENDING, TWISTING, LENGTH)[0]
    both = BENDING, BENDING
    move = partial(sideways, push, moment, both, TWISTING, LENGTH, (0.0, LENGTH), False)
    aside, twist = move(on_axis(x))[:, 2], move(on_axis(x, 1.0))[:, 2] - move(on_axis(x))[:, 2]
    slope, rate = np.gradient(aside, x), np.gradient(twist, x)
    curved = np.gradient(slope, x)
    force = push * np.pi**2 * BENDING / LENGTH**2
    work = np.trapezoid(force * slope**2 - 2 * moment * twist * curved, x)
    energy = np.trapezoid(BENDING * curved**2 + TWISTING * rate**2, x)
    assert work > 0.0
    assert work / energy == pytest.approx(share, rel=0.02)


def test_a_column_along_bores_in_a_row_is_eulers_and_round_a_corner_keeps_its_length():
    nodes = np.random.default_rng(3).uniform(0.0, 90.0, (20, 3))
    row = laid_straight(np.array([0.0, 30.0, 90.0], dtype=complex))
    straight = half_wave(np.zeros(3), np.array([90.0, 0.0, 0.0]), "in plane")
    assert_allclose(row(nodes), straight(nodes), atol=2e-3)
    corners = np.array([0.0, 60.0, 60.0 + 60.0j])
    mode = laid_straight(corners)
    ends = mode(np.array([[0.0, 0, 0], [60.0, 60.0, 0]]))
    assert_allclose(ends[0], 0.0, atol=1e-12)
    assert ends[1, 0] == pytest.approx(ends[1, 1])  # along the line between the ends
    arm = mode(on_axis(np.linspace(5.0, 55.0, 9)))
    assert_allclose(arm[:, 0], 0.0, atol=0.02)  # a bar that bends keeps its length


def lever_loads():
    """A block that presses on the flank half-way: the lever is bent between its pins."""
    force, at, length = 300.0, 100.0, LEVER.geometry.length
    wrenches = {
        "pivot": [0, -force * (length - at) / length, 0, 0, 0, 0],
        "tip": [0, -force * at / length, 0, 0, 0, 0],
        "slot": [0, force, 0, 0, 0, at * force],
    }
    return loads(wrenches, at)


def test_a_slotted_lever_is_bent_aside_most_in_the_rail_that_is_pressed():
    """Its pins stand still and what is beyond goes the other way; no crack at the slot's ends."""
    acting, shape = lever_loads(), LEVER.geometry
    load = shapes.model_of(LEVER, acting).buckling
    assert load.words.startswith("out of plane")
    middle = shape.width / 2 - (shape.width - shape.slot_width) / 4
    x = np.linspace(shape.slot_from, shape.slot_to, 41)
    upper, lower = (load.mode(on_axis(x, y))[:, 2] for y in (middle, -middle))
    assert np.abs(lower).max() > 1.5 * np.abs(upper).max()  # y > 0 is pulled
    most, at = np.abs(lower).max(), x[np.abs(lower).argmax()]
    assert 0.35 < at / shape.length < 0.65
    pins = load.mode(on_axis([0.0, shape.length]))
    assert_allclose(pins, 0.0, atol=1e-9 * most)
    ends = load.mode(on_axis([-12.0, 12.0, shape.length - 5.0, shape.length + 12.0]))[:, 2]
    assert ends[0] * ends[1] < 0.0
    assert ends[2] * ends[3] < 0.0
    faces = load.mode(on_axis(np.full(2, 100.0), middle, np.array([-4.0, 4.0])))
    assert_allclose(faces[0, :2], -faces[1, :2], atol=1e-9)
    assert faces[0, 2] == pytest.approx(faces[1, 2])
    for cut in (shape.slot_from, shape.slot_to):
        for side in (-1.0, 1.0):
            y = side * np.array([middle - 2.0, middle, shape.width / 2])
            before, after = (load.mode(on_axis(np.full(3, cut + d), y)) for d in (-1e-6, 1e-6))
            assert_allclose(before, after, atol=1e-5 * most)


def test_a_rail_that_buckles_in_the_plane_is_clamped_and_the_other_one_stands_still():
    thin = replace(
        LEVER.geometry,
        thickness=30.0,
        slot_width=26.0,
        boss_diameter=None,
        boss_height=0.0,
        boss_fillet=0.0,
        contact_length=None,
        travel_from=None,
        travel_to=None,
    )
    acting = lever_loads()
    load = shapes.model_of(replace(LEVER, geometry=thin), acting).buckling
    assert load.words.startswith("in plane: a rail")
    x = np.linspace(thin.slot_from, thin.slot_to, 5)
    moved = [load.mode(on_axis(x, side * 14.0))[:, 1] for side in (1.0, -1.0)]
    wave = [0.0, 0.5, 1.0, 0.5, 0.0]
    sizes = [float(np.abs(one).max()) for one in moved]
    assert sorted(sizes) == pytest.approx([0.0, 1.0])
    assert_allclose(moved[int(np.argmax(sizes))], wave, atol=1e-12)
    assert np.argmax(sizes) == 1  # y > 0 is pulled


def test_cheeks_spread_apart_and_side_walls_lean_in_as_their_edges_turn():
    part = replace(ROD, geometry=BAR)
    load = shapes.model_of(part, pushed("knee", "end", 1000.0)).buckling
    assert load.words.startswith("a stretch by itself")
    half, free = (BAR.width - BAR.wall) / 2, BAR.cutout_length - BAR.overhang
    tip = load.mode(on_axis(np.full(2, -18.0), 0.0, half * np.array([1.0, -1.0])))
    assert tip[0, 2] == pytest.approx(-tip[1, 2])
    most = abs(tip[0, 2])
    behind = np.array([free + 8.0, free + 15.0])
    cheek, wall = load.mode(on_axis(behind, 0.0, half)), load.mode(on_axis(behind, half, 0.0))
    assert (cheek[:, 2] * wall[:, 1] < 0.0).all()  # outwards and inwards
    assert_allclose(load.mode(on_axis(behind, half, half))[:, 1:], 0.0, atol=1e-3 * most)
    assert_allclose(load.mode(on_axis([free + 80.0, 240.0], 0.0, half)), 0.0)
    x = np.linspace(-20.0, 100.0, 49)
    size = np.abs(load.mode(on_axis(x, 0.0, half))[:, 2])
    assert x[size.argmax()] == -20.0


def test_walls_at_a_free_pressed_end_bend_as_their_plate_s_equation_says():
    """f'' = nu f and f''' + (k - 2 + nu) f' = 0 at the end, lengths over b/pi; corners stand."""
    tube, ratio = PrismaticTube(length=400.0, width=40.0, wall=1.2, inner_radius=0.6), 0.3
    apart = tube.width - tube.wall
    unit = apart / np.pi
    step = 0.05
    x = step * np.arange(5)
    wall = on_axis(x * unit, 0.0, apart / 2)
    f = _walls_mode(tube, ratio, wall)[:, 2]
    first, second, third = (np.polynomial.Polynomial.fit(x, f, 4).deriv(n)(0.0) for n in (1, 2, 3))
    assert second == pytest.approx(ratio * f[0], rel=1e-3)
    assert third == pytest.approx(-((3 + ratio) * (1 - ratio) - 2 + ratio) * first, rel=0.01)
    sides = on_axis(np.zeros(3), [0.0, apart / 2, apart / 2], [apart / 2, 0.0, apart / 2])
    top, side, corner = _walls_mode(tube, ratio, sides)
    assert top[2] == pytest.approx(-side[1])
    assert_allclose(corner, 0.0, atol=1e-12)
    assert abs(_walls_mode(tube, ratio, on_axis([200.0], 0.0, apart / 2))[0, 2]) < 1e-3


def test_cheeks_by_themselves_are_hinged_in_the_plane_and_cantilevers_out_of_it():
    free, half = BAR.cutout_length - BAR.overhang, BAR.cheeks_at
    x = np.array([0.0, free / 2, free, free + 50.0])
    within = cheeks_alone(BAR, "in plane", on_axis(x, 0.0, half))
    assert_allclose(within[:, 1], [0.0, 1.0, 0.0, 0.0], atol=1e-12)
    upper, lower = (
        cheeks_alone(BAR, "out of plane", on_axis(x, 0.0, side * half))[:, 2] for side in (1, -1)
    )
    assert_allclose(upper, [1.0, 1 - np.sqrt(0.5), 0.0, 0.0], atol=1e-12)
    assert_allclose(lower, -upper)


def test_a_link_s_mode_by_formula_is_that_of_its_solid():
    """Pushed and bent: 0.9999; a twist of the wrong sign leaves 0.967."""
    part = replace(ROD, geometry=LINK)
    assert beside_a_solid(part, bent(1000.0, 100.0), 0.8) > 0.999


@pytest.mark.slow
def test_modes_by_formula_of_levers_and_bent_links_are_those_of_solids():
    assert beside_a_solid(LEVER, lever_loads(), 0.8) > 0.98
    assert beside_a_solid(replace(ROD, geometry=LINK), bent(0.0, 100.0), 0.6) > 0.995
