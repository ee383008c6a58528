"""The rung of frames: buckling of parts as Timoshenko beams, against formulas and other routes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import brentq

from ballesta.design.read import read_design
from checks.handbook.pin_loaded_hole import PATTERNS
from checks.models import shapes
from checks.models.beam import model_of, solve_frame
from checks.part.part_loads import PartLoads
from geometry.cad_body import cad_body
from geometry.parts import PrismaticTube, TubeRod

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


FRAMED = ("tube", "link", "rod")


@pytest.mark.parametrize("name", FRAMED)
def test_loads_in_balance_leave_the_frames_support_nothing(parts, name):
    """Forces askew, and a couple that balances them: round-off is what is left."""
    part = parts[name]
    first, second = part.geometry.interfaces
    wrench = np.array([[300.0, 70.0, 0, 0, 0, 0], [-200.0, 40.0, 0, 0, 0, 0]])
    back = -wrench
    back[:, 5] = -part.geometry.length * wrench[:, 1]
    model = model_of(part, loads_of({first: back, second: wrench}))
    assert model.residual < 1e-9
    assert 0 < model.buckling.share < np.inf


@pytest.mark.parametrize("name", FRAMED)
def test_twice_the_loads_are_twice_the_share_of_buckling(parts, name):
    one, two = (model_of(parts[name], pushed(parts[name], size)) for size in (500.0, 1000.0))
    assert_allclose(two.buckling.share, 2 * one.buckling.share, rtol=1e-6)


@pytest.mark.parametrize("name", FRAMED)
def test_stress_is_the_formulas(parts, name):
    part, loads = parts[name], pushed(parts[name], 1000.0)
    by_frame, by_formula = model_of(part, loads), shapes.model_of(part, loads)
    assert_array_equal(by_frame.history.basis, by_formula.history.basis)
    assert by_frame.rung == "beam"
    assert by_frame.unknowns > by_formula.unknowns == 0


@pytest.mark.parametrize("name", ["bar", "knee pin", "pin", "lever", "leaves"])
def test_parts_that_are_no_straight_bar_have_no_frame(parts, name):
    assert solve_frame(parts[name]) is None


@pytest.mark.parametrize("name", FRAMED)
def test_a_frame_has_the_mass_of_its_part(parts, name):
    part = parts[name]
    frame = solve_frame(part).frame
    mass = -frame.resultants(frame.planar_inertia())[0, 0]
    assert_allclose(mass, part.material.density * cad_body(part.geometry).volume, rtol=2e-3)


def test_pressure_of_the_higher_harmonics_reaches_no_section_beside_the_bore(parts):
    solved = solve_frame(parts["link"])
    quiet = [PATTERNS.index(name) for name in ("cos 0", "cos 2", "sin 2", "cos 4", "sin 4")]
    x, radius = solved.frame.points[..., 0], parts["link"].geometry.hole / 2
    beside = (x.min(axis=1) > radius) & (x.max(axis=1) < parts["link"].geometry.length - radius)
    forces = solved.at_points[beside]
    loud = np.abs(forces[:, :, 0, PATTERNS.index("cos 1")]).max()
    assert np.abs(forces[:, :, 0, quiet]).max() < 1e-9 * loud
    assert np.abs(forces[:, :, 5, quiet]).max() < 1e-8  # Gauss over arcs: 1e-10 of N times radius


def test_a_slender_rod_buckles_at_eulers_load(parts):
    """6845 N hinged over 1275 mm as an even tube (docs/theory/linkage_frames.md).

    Its eyes are stiffer, 2 x 14 of 1275 mm, and hardly bend: 1 %. Round, it gives way in the plane,
    where the push goes through the pins; out of it the column ends where they press.
    """
    model = model_of(parts["rod"], pushed(parts["rod"], 1000.0))
    assert_allclose(1000 / model.buckling.share, 6845, rtol=0.01)
    assert model.buckling.words.startswith("in plane")


def test_a_rod_with_stout_eyes_buckles_in_the_plane_from_pin_to_pin(parts):
    """Rigid up to b, where the tube meets the balls: cot(k (L/2 - b)) = k b; 1 %.

    A push that turned with the eyes would stand 8/(3 pi) r beside the axis: 34 % more, as it is
    out of the plane (tests/fem/test_pins_turning.py).
    """
    shape = TubeRod(
        length=160, tube_diameter=10, wall=2, eye_diameter=60, eye_width=40, hole=30, fillet=2
    )
    stout = replace(parts["rod"], geometry=shape)
    share = model_of(stout, pushed(stout, 1000.0)).buckling
    young, inertia, rigid = 210e3, np.pi / 64 * (10.0**4 - 6.0**4), np.sqrt(30**2 - 5**2)
    free = 80.0 - rigid
    x = brentq(lambda x: np.cos(x) - np.sin(x) * x * rigid / free, 0.1, 1.5)
    assert stout.material.youngs_modulus == young
    assert_allclose(1000 / share.share, young * inertia * (x / free) ** 2, rtol=0.01)
    assert share.words.startswith("in plane")


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
