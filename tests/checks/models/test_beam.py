"""The rung of frames: parts as Timoshenko beams, against statics, formulas and other routes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from checks.joints.pin_diagrams import pin_diagram
from checks.models.beam import frame_of, model_of
from checks.models.beam_solution import solve_frame
from checks.part.part_loads import PartLoads
from fem.recovery import von_mises
from geometry.parts import PlateLink, PrismaticTube

DESIGNS = Path(__file__).parents[3] / "designs"
PARTS = {
    "bar": ("toggle_press", "bar_upper"),
    "knee pin": ("toggle_press", "pin_B"),
    "tube": ("toggle_press_30x30", "bar_upper"),
    "link": ("slider_crank", "rod"),
    "pin": ("slider_crank", "pin_A"),
    "lever": ("quick_return", "lever"),
    "rod": ("spring_hammer", "rod"),
    "leaves": ("spring_hammer", "leaves"),
}


@pytest.fixture(scope="module")
def parts():
    every = {name: read_design(DESIGNS / f"{name}.toml").parts for name, _ in PARTS.values()}
    return {key: every[design][part] for key, (design, part) in PARTS.items()}


def loads_of(wrenches, reaches=None, accelerations=None):
    """Loads of n positions; wrenches (n, 6) by interface."""
    wrenches = {name: np.array(rows, dtype=float) for name, rows in wrenches.items()}
    n = len(next(iter(wrenches.values())))
    return PartLoads(
        wrenches,
        np.zeros((n, 4)) if accelerations is None else np.array(accelerations, dtype=float),
        {"turn": slice(0, n)},
        tuple(f"k = {k}" for k in range(n)),
        ("turn",) * n,
        {name: np.array(values, dtype=float) for name, values in (reaches or {}).items()},
    )


def pushed(part, force):
    first, second = part.geometry.interfaces[:2]
    return loads_of({first: [[force, 0, 0, 0, 0, 0]], second: [[-force, 0, 0, 0, 0, 0]]})


def balanced(part):
    """Forces on every interface of a part, and couples, that balance one another."""
    shape, rng = part.geometry, np.random.default_rng(3)
    if part.body is None:
        names = [seat.name for seat in shape.seats]
        heights = [seat.at if seat.single else 0.0 for seat in shape.seats]
        forces = 100 * rng.normal(size=(len(names), 4, 2))
        forces[-1] = -forces[:-1].sum(axis=0)
        wrenches = {name: np.zeros((4, 6)) for name in names}
        for name, height, force in zip(names, heights, forces, strict=True):
            wrenches[name][:, :2] = force
            wrenches[names[0]][:, 3] += height * force[:, 1]
            wrenches[names[0]][:, 4] -= height * force[:, 0]
        return loads_of(wrenches)
    first, second = shape.interfaces[:2]
    force = 100 * rng.normal(size=(4, 2))
    wrenches = {first: np.zeros((4, 6)), second: np.zeros((4, 6))}
    reaches = {}
    wrenches[second][:, :2] = force
    wrenches[first][:, :2] = -force
    wrenches[first][:, 5] = -shape.length * force[:, 1]
    for name in shape.interfaces[2:]:
        reach = {"slot": 100.0, "contact": -440.0}[name]
        wrenches[name] = np.zeros((4, 6))
        wrenches[name][:, 1] = 50.0
        wrenches[name][:, 5] = reach * 50.0
        wrenches[first][:, 1] -= 50.0
        wrenches[first][:, 5] -= reach * 50.0
        reaches[name] = np.full(4, reach)
    return loads_of(wrenches, reaches)


@pytest.mark.parametrize("name", PARTS)
def test_every_part_of_the_machines_is_finite_and_leaves_its_support_nothing(parts, name):
    """Round-off of the stiffest members over the softest: 1e4 over the lever's rails."""
    part = parts[name]
    model = model_of(part, balanced(part))
    assert np.isfinite(model.history.basis).all()
    assert np.isfinite(model.history.coefficients).all()
    assert model.history.peaks_by_position()[0].min() > 0
    assert model.residual < 1e-6
    assert 0 < model.deflection < np.inf
    assert len(model.places) == len(model.history.points) == len(model.fretting)


@pytest.mark.parametrize("name", PARTS)
def test_twice_the_loads_are_twice_the_stress_and_twice_the_share_of_buckling(parts, name):
    part = parts[name]
    loads = balanced(part)
    twice = replace(loads, wrenches={name: 2 * w for name, w in loads.wrenches.items()})
    one, two = model_of(part, loads), model_of(part, twice)
    assert_allclose(
        two.history.peaks_by_position()[0], 2 * one.history.peaks_by_position()[0], rtol=1e-9
    )
    if one.buckling is None:
        assert name in ("knee pin", "pin", "leaves")
    else:
        assert_allclose(two.buckling.share, 2 * one.buckling.share, rtol=1e-6)


def test_loads_that_do_not_balance_are_balanced_by_the_parts_own_inertia(parts):
    """A pull at one end only: half-way along a link half of it is left, less what is beyond."""
    link = parts["link"]
    model = model_of(link, loads_of({"first": [[0.0] * 6], "second": [[1000.0, 0, 0, 0, 0, 0]]}))
    shape = link.geometry
    middle = np.abs(model.history.points[:, 0] - shape.length / 2) < 1e-6
    middle &= np.array(model.places) == "plate"
    stress = model.history.at(0)[middle, 0]
    assert_allclose(stress, 500 / (shape.width * shape.thickness), rtol=1e-6)


def test_a_part_that_moves_as_a_whole_under_no_force_has_no_stress(parts):
    link = parts["link"]
    none = {"first": [[0.0] * 6], "second": [[0.0] * 6]}
    model = model_of(link, loads_of(none, accelerations=[[3e4, 2e4, 50.0, 0.0]]))
    turning = model_of(link, loads_of(none, accelerations=[[0.0, 0.0, 0.0, 100.0**2]]))
    centrifugal = turning.history.peaks_by_position()[0].max()
    # rho omega^2 L^2 / 8 in the middle of a bar of the plate's density
    expected = link.material.density * 100.0**2 * 170.0**2 / 8
    assert_allclose(centrifugal, expected, rtol=0.15)  # holes and round ends are lighter
    assert model.history.peaks_by_position()[0].max() < 1e-9 * centrifugal
    assert turning.buckling.share == 0.0


def test_frames_have_the_mass_of_their_parts(parts):
    """By hand: plate less slot and holes, and two bosses; two cheeks, tube, holes, cut-out.

    A sixtieth of a rail's length is its taper; the toggle's corner fillets are left out by hand.
    """
    bar = parts["bar"].geometry
    slot = 12 * (164 - 12) + np.pi * 36
    plate = 8 * (30 * 230 - slot - 2 * np.pi * 16)
    boss = 2 * 9.75 * np.pi * (11**2 - 4**2)
    total = bar.length + 2 * bar.overhang
    inner = bar.width - 2 * bar.wall
    tube = total * (bar.width**2 - inner**2) - 2 * bar.cutout_length * bar.wall * inner
    tube -= 4 * bar.wall * np.pi * bar.hole**2 / 4
    for name, volume in (("lever", plate + boss), ("bar", tube)):
        framed = frame_of(parts[name])
        inertia = framed.frame.planar_inertia()
        inertia.distributed[list(framed.massless)] = 0.0
        mass = -framed.frame.resultants(inertia)[0, 0]
        assert_allclose(mass, parts[name].material.density * volume, rtol=0.02)


def test_pressure_of_the_higher_harmonics_reaches_no_section_beside_the_bore(parts):
    link = parts["link"]
    framed = frame_of(link)
    solved = solve_frame(framed)
    names = framed.entries[0].names
    quiet = [names.index(name) for name in ("cos 0", "cos 2", "sin 2", "cos 4", "sin 4")]
    loud = names.index("cos 1")
    outside = [k for k, site in enumerate(framed.sites) if site.name == "plate"]
    forces = solved.at_sites[outside]
    assert np.abs(forces[:, 0, quiet]).max() < 1e-9 * np.abs(forces[:, 0, loud]).max()
    assert np.abs(forces[:, 5, quiet]).max() < 1e-8  # Gauss over arcs: 1e-10 of N times radius


def test_a_slender_rod_buckles_at_eulers_load(parts):
    """6845 N hinged over 1275 mm as an even tube (docs/theory/linkage_frames.md).

    Its eyes are stiffer, 2 x 14 of 1275 mm, and hardly bend; the force enters at the bore's near
    side, which takes it off some 2 x 7/1275 where the slope is largest: 2 %.
    """
    model = model_of(parts["rod"], pushed(parts["rod"], 1000.0))
    assert_allclose(1000 / model.buckling.share, 6845, rtol=0.03)
    assert "out of plane" in model.buckling.words or "in plane" in model.buckling.words


def test_a_pulled_part_has_no_share_of_a_buckling_load(parts):
    model = model_of(parts["rod"], pushed(parts["rod"], -1000.0))
    assert model.buckling.share < 1e-6


def test_the_worst_position_for_buckling_is_that_of_the_largest_push(parts):
    rod = parts["rod"]
    sizes = np.array([10.0, -5000.0, 900.0, 1000.0, 400.0])
    rows = np.zeros((5, 6))
    rows[:, 0] = sizes
    model = model_of(rod, loads_of({"first": rows, "second": -rows}))
    assert model.buckling.position == 3


def test_the_walls_of_a_thin_tube_buckle_at_its_pressed_end_before_it_does(parts):
    """(3 + nu)(1 - nu) pi^2 E/(12 (1 - nu^2)) (t/b)^2 = 1.30e-3 E for t/b = 1/27.5."""
    tube = parts["tube"]
    thin = replace(tube, geometry=PrismaticTube(length=250.0, width=28.5, wall=1.0))
    model = model_of(thin, pushed(thin, 1000.0))
    area = 28.5**2 - 26.5**2
    nu, young = thin.material.poisson_ratio, thin.material.youngs_modulus
    limit = (3 + nu) * (1 - nu) * np.pi**2 * young / (12 * (1 - nu**2)) / 27.5**2
    assert_allclose(model.buckling.share, 1000 / area / limit, rtol=1e-12)
    assert model.buckling.words.startswith("walls")


def test_a_pin_is_bent_and_sheared_as_its_diagram_with_even_lugs(parts):
    """By another route: sums of forces below each section (checks/joints/pin_diagrams.py)."""
    pin = parts["pin"]
    loads = balanced(pin)
    diagram = pin_diagram(pin.geometry, dict(loads.wrenches), spread=True)
    framed = frame_of(pin)
    solved = solve_frame(framed)
    forces = solved.at_sites @ solved.coefficients(loads)
    size = np.abs(diagram.moment).max()
    for site, found in zip(framed.sites, forces, strict=True):
        start, end = framed.frame.nodes[framed.frame.members[site.member], 2]
        place = start + site.at * (end - start)
        near = np.interp(place, diagram.places, np.hypot(*np.moveaxis(diagram.moment[0], -1, 0)))
        # the diagram's own sections are 1/16 of a stretch apart: (1/16)^2/8 of a curved stretch
        assert_allclose(np.hypot(found[4, 0], found[5, 0]), near, atol=2e-3 * size)


def test_a_pin_with_a_sharp_step_has_no_answer(parts):
    pin = parts["knee pin"]
    sharp = replace(pin, geometry=replace(pin.geometry, step_fillet=0.0))
    assert frame_of(pin) is not None
    assert model_of(sharp, balanced(pin)) is None


def test_leaves_share_the_moment_of_the_contact_at_the_pivot(parts):
    """M t/(2 n I) of leaves that slide freely, away from the pivot's clamp."""
    leaves = parts["leaves"]
    shape = leaves.geometry
    reach, force = -440.0, 1000.0
    moment = -reach * force
    wrenches = {
        "contact": [[0, force, 0, 0, 0, reach * force]],
        "rod": [[0, force * 440 / shape.length, 0, 0, 0, 0]],
        "pivot": [[0, -force * (1 + 440 / shape.length), 0, 0, 0, 0]],
    }
    model = model_of(leaves, loads_of(wrenches, {"contact": [reach]}))
    edge = shape.clamp_length / 2
    at_edge = np.abs(model.history.points[:, 0] + edge) < 1e-6
    found = np.abs(model.history.at(0)[at_edge, 0]).max()
    modulus = shape.leaves * shape.width * shape.thickness**2 / 6
    assert_allclose(found, (moment - force * edge) / modulus, rtol=1e-9)
    assert set(model.fretting) == {1.0, shape.clamp_factor}


def test_the_rails_of_a_lever_carry_together_what_statics_says(parts):
    """Half-way between block and slot's end: N of both apart and both own moments are M."""
    lever = parts["lever"]
    shape = lever.geometry
    force = 100.0
    reach = 60.0
    tip = -force * reach / shape.length
    wrenches = {
        "slot": [[0, force, 0, 0, 0, reach * force]],
        "tip": [[0, tip, 0, 0, 0, 0]],
        "pivot": [[0, -force - tip, 0, 0, 0, 0]],
    }
    loads = loads_of(wrenches, {"slot": [reach]})
    framed = frame_of(lever)
    solved = solve_frame(framed)
    forces = solved.at_sites @ solved.coefficients(loads)
    nodes, members = framed.frame.nodes, framed.frame.members
    places = np.array([nodes[members[site.member], :2][round(site.at)] for site in framed.sites])
    rails = np.array([site.name == "rail" and site.at == 0.0 for site in framed.sites])
    beyond = rails & (places[:, 0] > 80) & (places[:, 0] < 180)
    for x in np.unique(places[beyond, 0].round(6)):
        here = beyond & (np.abs(places[:, 0] - x) < 1e-5)
        assert here.sum() == 2
        moment = (forces[here, 5, 0] - places[here, 1] * forces[here, 0, 0]).sum()
        assert_allclose(moment, tip * (shape.length - x), rtol=1e-6)
        assert_allclose(forces[here, 0, 0].sum(), 0, atol=1e-6 * force)


def test_a_pulled_link_has_its_peak_beside_the_hole_as_a_handbook_lug(parts):
    """Peterson's chart for a pulled lug, 2.852 at d/H = 0.4; a round end has 20 to 30 % more."""
    link = replace(
        parts["link"], geometry=PlateLink(length=150.0, width=50.0, thickness=6.0, hole=20.0)
    )
    model = model_of(link, pushed(link, -1000.0))
    stress = von_mises(model.history.at(0))
    net = 1000 / (30 * 6)
    assert 2.852 * 1.1 < stress.max() / net < 2.852 * 1.35
    assert model.places[int(stress.argmax())] in ("first", "second")


def test_a_part_of_a_cad_file_has_no_frame(parts):
    assert frame_of(replace(parts["link"], geometry=object())) is None
