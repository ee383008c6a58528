"""The rung of formulas on parts from CAD: a bar of the sections that planes cut."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.cli import main
from checks.design.effort import AUTO
from checks.ladder.climb import climb_cheap, start_climb
from checks.models.bands import NoBand, band_of
from checks.models.shapes import family_of, model_of
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads, loads_on
from checks.strength.part_strength import elastic_of
from checks.stress.solid_mesh_level import Models
from fem.recovery import von_mises
from geometry.parts.step_part import NamedHole, StepPart

from ...geometry.step_files import hole, plate_with, write_step
from ...small_machine import machine, solved
from ...undrawn import draw_nothing

SLICED = Path(__file__).parents[3] / "bench" / "rungs" / "sliced.jsonl"
LENGTH, HEIGHT, THICKNESS = 100.0, 10.0, 8.0
MODULUS = THICKNESS * HEIGHT**2 / 6
BAR = """
[parts.crank]
body = "crank"
shape = { step = "bar.step" }
holes.shaft = { diameter = "4 mm", at = "0, -15, 4 mm" }
holes.pin = { diameter = "4 mm", at = "60, -15, 4 mm" }
interfaces = { shaft = "O", pin = "A" }
material = "S355"
mesh = { fineness = 0.4 }
"""


def bar_file(folder, *more):
    """A plain bar of 100 x 10 x 8 mm, its holes 60 mm apart and 20 mm from its ends."""
    tools = [hole(0, -15, 4), hole(60, -15, 4), *more]
    return write_step(folder / "bar.step", plate_with(*tools, size=(LENGTH, HEIGHT, THICKNESS)))


@pytest.fixture(scope="module")
def part(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bar")
    bar_file(folder)
    return machine(folder, BAR).parts["crank"]


@pytest.fixture(scope="module")
def three_holes(tmp_path_factory):
    """The bar with a third hole 20 mm from the first, 0.03 mm aside, its middle 0.05 mm lower."""
    folder = tmp_path_factory.mktemp("three")
    pocket = (20, -14.97, 7.9, 0, 0, 1, 3)
    return bar_file(folder, hole(20, -14.97, 4), pocket)


def loads_of(wrenches, accelerations=(0, 0, 0, 0)):
    """Loads at one position: six numbers by interface."""
    return PartLoads(
        {name: np.array([wrench], dtype=float) for name, wrench in wrenches.items()},
        np.array([accelerations], dtype=float),
        {"turn": slice(0, 1)},
        ("k = 0",),
        ("turn",),
        tilt_held_at="shaft",
    )


def pulled(force):
    return loads_of({"shaft": [-force, 0, 0, 0, 0, 0], "pin": [force, 0, 0, 0, 0, 0]})


def lifted(part, acceleration):
    """Both pins lift the bar evenly: half of its mass times the acceleration each."""
    half = part.material.density * part.geometry.solid.volume * acceleration / 2
    wrench = [0, half, 0, 0, 0, 0]
    return loads_of({"shaft": wrench, "pin": wrench}, (0, acceleration, 0, 0))


def stress_at(model, x):
    """Points and stress of the model's section at x."""
    near = np.abs(model.history.points[:, 0] - x) < 1e-9
    assert near.any()
    return model.history.points[near], model.history.at(0)[near]


def peak(model):
    return von_mises(model.history.at(0)).max()


@pytest.fixture(scope="module")
def solid(part):
    """The bar as a solid, all unit loads solved."""
    return Models().solutions(part.geometry, 0.35, elastic_of(part))


def solid_xx(solid, loads):
    """Stress xx within 2 mm of mid-length on the edges at y > 0 and y < 0."""
    coefficients, _ = solid.coefficients(
        loads.wrenches, loads.accelerations, loads.reaches, loads.tilt_held_at
    )
    points = solid.mesh.nodes[solid.recovery.points]
    xx = (solid.basis @ coefficients)[:, 0, 0]
    edge = (np.abs(points[:, 0] - 30) < 2) & (np.abs(points[:, 1]) > HEIGHT / 2 - 1e-6)
    return xx[edge & (points[:, 1] > 0)].mean(), xx[edge & (points[:, 1] < 0)].mean()


def test_a_pulled_bar_has_its_force_over_its_section_and_the_solid_too(part, solid):
    """Round-off by formula; the solid's holes are three heights away: 1 % (Saint-Venant)."""
    model = model_of(part, pulled(1000.0))
    _, stress = stress_at(model, 30.0)
    assert_allclose(stress[:, 0], 1000.0 / (HEIGHT * THICKNESS), rtol=1e-9)
    assert_allclose(solid_xx(solid, pulled(1000.0)), stress[0, 0], rtol=0.01)


def test_a_bar_that_is_lifted_is_bent_by_its_own_mass_and_the_solid_too(part, solid):
    """M = m a/4 (l - L/2), m without holes, l between them, L of the bar, at its middle; M/W.

    Holes take as much from a pin's half as from the mass about it. To the curves' facets. An even
    load q on a bar so short adds 2 q c^3/(15 I), 1.3 % (Timoshenko and Goodier, 3rd ed., section
    22; there as a pressure). The coarse mesh has 2.7 % less than that, a finer one 1 %.
    """
    loads = lifted(part, 1e7)
    mass = part.material.density * LENGTH * HEIGHT * THICKNESS
    bent = mass * 1e7 / 4 * (60 - LENGTH / 2) / MODULUS
    model = model_of(part, loads)
    points, stress = stress_at(model, 30.0)
    assert_allclose(stress[:, 0], -bent * points[:, 1] / (HEIGHT / 2), rtol=2e-3, atol=1e-9 * bent)
    assert model.residual == 0
    assert_allclose(solid_xx(solid, loads), [-1.013 * bent, 1.013 * bent], rtol=0.035)


def test_a_bar_that_turns_is_pulled_by_its_own_mass(part):
    """N of what lies beyond mid-length, from x = 30 to 80 mm less a hole at 60, about the shaft.

    To what cells of 1.6 mm make of holes of 4 mm.
    """
    density, bore = part.material.density, np.pi * 2**2 * THICKNESS
    beyond = density * 1e6 * (HEIGHT * THICKNESS * (80**2 - 30**2) / 2 - bore * 60)
    whole = density * 1e6 * (HEIGHT * THICKNESS * (80**2 - 20**2) / 2 - bore * 60)
    loads = loads_of({"shaft": [-whole, 0, 0, 0, 0, 0], "pin": [0] * 6}, (0, 0, 0, 1e6))
    _, stress = stress_at(model_of(part, loads), 30.0)
    assert_allclose(stress[:, 0], beyond / (HEIGHT * THICKNESS), rtol=0.01)


def test_holes_at_the_ends_of_the_line_have_sections_on_both_sides(part):
    """A friction couple on the pin bends all that is between the pins, and nothing beyond."""
    loads = loads_of({"shaft": [0, 0, 0, 0, 0, -5e3], "pin": [0, 0, 0, 0, 0, 5e3]})
    model = model_of(part, loads)
    x, xx = model.history.points[:, 0], np.abs(model.history.at(0)[:, 0])
    bored = THICKNESS * (HEIGHT**3 - 4**3) / 12 / (HEIGHT / 2)
    for at, inward in ((0.0, 1), (60.0, -1)):
        near = np.abs(x - at) < 1e-3
        inner = inward * (x - at) > 0
        assert_allclose(xx[near & inner].max(), 5e3 / bored, rtol=2e-3)
        assert_allclose(xx[near & ~inner], 0, atol=1e-9 * 5e3 / bored)


def test_height_lies_in_the_linkage_s_plane_and_thickness_along_the_pins(part):
    """M_z over t h^2/6, M_y over h t^2/6."""
    for column, modulus in ((5, MODULUS), (4, HEIGHT * THICKNESS**2 / 6)):
        wrench = np.zeros(6)
        wrench[column] = 4e3
        _, stress = stress_at(model_of(part, loads_of({"shaft": -wrench, "pin": wrench})), 30.0)
        assert_allclose(np.abs(stress[:, 0]).max(), 4e3 / modulus, rtol=1e-9)


def test_a_bar_beside_the_line_of_its_holes_is_bent_by_its_pull(part, tmp_path):
    """A rib on one side: N/A - N e_z/I_y (z - e_z), e_z its centroid's height over the holes."""
    path = write_step(tmp_path / "bar.step", ribbed_bar)
    shape = StepPart(path, part.geometry.holes)
    points, stress = stress_at(model_of(replace(part, geometry=shape), pulled(1000.0)), 30.0)
    plate, rib = HEIGHT * THICKNESS, 2 * 6
    beside = rib * (THICKNESS / 2 + 3) / (plate + rib)
    across = HEIGHT * THICKNESS**3 / 12 + plate * beside**2
    across += 2 * 6**3 / 12 + rib * (THICKNESS / 2 + 3 - beside) ** 2
    wanted = 1000 / (plate + rib) - 1000 * beside * (points[:, 2] - beside) / across
    assert_allclose(stress[:, 0], wanted, rtol=1e-6)


def ribbed_bar(gmsh):
    """The bar with a rib of 2 x 6 mm along its middle, between the holes."""
    plate_with(hole(0, -15, 4), hole(60, -15, 4), size=(LENGTH, HEIGHT, THICKNESS))(gmsh)
    ((_, tag),) = gmsh.model.occ.getEntities(3)
    rib = gmsh.model.occ.addBox(5, -16, THICKNESS, 50, 2, 6)
    gmsh.model.occ.fuse([(3, tag)], [(3, rib)])


def test_a_pressed_bar_buckles_as_euler_s_column_between_its_holes(part):
    """Out of its plane, where it is thinner: pi^2 E I/l^2, of the weakest section with Engesser.

    The bar's own is as long as from 8/(3 pi) of a radius beyond one hole to the other, and a little
    softer where it is bored.
    """
    model = model_of(part, pulled(-1000.0))
    young, nu = part.material.youngs_modulus, part.material.poisson_ratio
    force = np.pi**2 * young * HEIGHT * THICKNESS**3 / 12 / 60**2
    sheared = 0.4 * HEIGHT * THICKNESS * young / 2.6
    assert nu == 0.3
    assert_allclose(model.buckling.weakest, 1000.0 * (1 / force + 1 / sheared), rtol=1e-3)
    nearer = 60 - 2 * 8 / (3 * np.pi) * 2
    assert_allclose(model.buckling.share, 1000.0 / force * (nearer / 60) ** 2, rtol=0.02)
    assert model_of(part, pulled(1000.0)).buckling.share == 0


def test_the_bound_of_a_bar_s_buckling_has_its_weakest_section_and_its_thinnest_wall(part):
    """A rectangle is a plate with a free edge: 2.6 (b/t)^2, b its diagonal's widest, t 8 mm."""
    model = model_of(part, pulled(-1000.0))
    widest = max(HEIGHT * np.cos(a) + THICKNESS * np.sin(a) for a in np.arange(5) * np.pi / 8)
    assert model.buckling.local == pytest.approx(4 * max(1, 2.6 * (widest / THICKNESS) ** 2 / 12))


@pytest.mark.parametrize("kind", ["truth", "odd"])
def test_no_solid_of_a_part_from_cad_has_more_than_its_bound(kind):
    """Shapes exported to STEP and read again, and shapes that only CAD draws (bench/sliced.py)."""
    lines = [json.loads(line) for line in SLICED.read_text().splitlines()]
    rows = [line for line in lines if (line["shape"] == "odd") == (kind == "odd")]
    bounded = [line for line in rows if line["most"] is not None]
    assert len(bounded) >= (5 if kind == "odd" else 40)
    assert max(line["solid"] / line["most"] for line in bounded) < 0.7


def test_a_contact_that_slides_has_no_formula(part):
    assert model_of(replace(part, geometry=replace(part.geometry, section=(16, 8))), pulled(1.0))
    assert model_of(part, replace(pulled(1.0), reaches={"pin": np.zeros(1)})) is None


def test_holes_that_stand_on_no_line_have_no_formula(part, tmp_path):
    """1 mm of 60 mm; 0.03 mm are none, as below."""
    path = bar_file(tmp_path, hole(20, -14, 4))
    third = NamedHole("third", 4, (20, -14, 4))
    shape = StepPart(path, (*part.geometry.holes, third))
    nothing = {"third": [0, 0, 0, 0, 0, 0]}
    loads = pulled(1.0)
    loads = loads_of({name: w[0] for name, w in loads.wrenches.items()} | nothing)
    assert model_of(replace(part, geometry=shape), loads) is None


def on_three(part, path, *order):
    """The part with its holes named in another order."""
    at = {"shaft": (0, -15, 4), "third": (20, -14.97, 4), "pin": (60, -15, 4)}
    holes = tuple(NamedHole(name, 4, at[name]) for name in order)
    return replace(part, geometry=StepPart(path, holes))


def test_a_force_beside_the_line_bends_the_bar_in_and_out_of_its_plane(part, three_holes):
    """100 N along x at (20, 0.03, -0.05): M_z = -y F and M_y = z F about the line, held at 0."""
    loads = loads_of(
        {"shaft": [-100, 0, 0, 0, 5, 3], "third": [100, 0, 0, 0, 0, 0], "pin": [0, 0, 0, 0, 0, 0]}
    )
    model = model_of(on_three(part, three_holes, "shaft", "pin", "third"), loads)
    points, stress = stress_at(model, 10.0)
    _, y, z = points.T
    wanted = 100 / 80 + 3 * y / (8 * 10**3 / 12) - 5 * z / (10 * 8**3 / 12)
    assert_allclose(stress[:, 0], wanted, rtol=1e-5)  # the CAD kernel's middle of the hole
    assert model.residual < 1e-8
    assert model.buckling is None
    across = {"shaft": [0, -50, 0, -2.5, 0, -1e3], "third": [0, 50, 0, 0, 0, 0], "pin": [0] * 6}
    shape = on_three(part, three_holes, "shaft", "pin", "third")
    assert model_of(shape, loads_of(across)).residual < 1e-8


def test_the_order_in_which_holes_are_named_changes_no_stress(part, three_holes):
    """A frame with its origin in the middle hole, whose accelerations are those of that point."""
    force = {"shaft": [30, 40, 0, 0, 0, 0], "third": [-50, -90, 0, 0, 0, 0]}
    force["pin"] = [20, 50, 0, 0, 0, 7]
    a_x, a_y, alpha, omega2 = 1e4, 2e4, 3e3, 4e3
    ends = on_three(part, three_holes, "shaft", "pin", "third")
    middle = on_three(part, three_holes, "third", "pin", "shaft")
    arm = ends.geometry.centre("third")
    one = model_of(ends, loads_of(force, (a_x, a_y, alpha, omega2)))
    moved = (a_x - omega2 * arm[0], a_y + alpha * arm[0], alpha, omega2)
    other = model_of(middle, loads_of(force, moved))
    # the other frame is turned by 0.03/40 about z, and moved by 0.03 and 0.05 mm
    assert_allclose(peak(one), peak(other), rtol=5e-3)
    x = other.history.points[:, 0]
    assert_allclose([x.min(), x.max()], [-arm[0], 60 - arm[0]], atol=1e-2)
    assert_allclose(one.deflection, other.deflection, rtol=5e-3)


def test_a_file_that_is_named_as_a_shape_has_no_bars_of_that_shape(part):
    named = SimpleNamespace(geometry=part.geometry, shape="plate_link")
    for kind in ("static", "buckling"):
        family = family_of(named, pulled(1.0), kind)
        assert isinstance(band_of(family, "formula", kind, {}), NoBand)


@pytest.fixture
def started(tmp_path):
    """A climb on the bar as the crank of a small machine, with other values."""
    bar_file(tmp_path)

    def start(*overrides):
        design = machine(tmp_path, BAR, *overrides)
        cycles = solved(design)
        own = design.parts["crank"]
        return start_climb(LoadedPart(design, own, loads_on(design, own, cycles), cycles))

    return start


def test_auto_tries_the_formula_tells_that_it_has_no_bar_and_goes_on_to_the_solid(started):
    state = started()
    assert climb_cheap(state, AUTO)
    (formula,) = state.tried
    assert formula.why.startswith("goes on: static has no error bar")
    assert {check.kind for check in formula.checks} == {"static", "fatigue", "buckling"}
    assert state.open == ["static", "fatigue"]


@pytest.mark.slow
def test_by_formula_alone_values_that_pass_leave_the_verdict_open(tmp_path, capsys, monkeypatch):
    """No bar is known, so they are no pass; no solid is taken instead."""
    draw_nothing(monkeypatch)
    bar_file(tmp_path)
    machine(tmp_path, BAR)
    file, folder = tmp_path / "machine.toml", tmp_path / "out"
    file.write_text(file.read_text().replace("400 N", "40 N"))
    capsys.readouterr()
    assert main(["check", str(file), "--fidelity", "formula", "--out", str(folder)]) == 1
    printed = " ".join(capsys.readouterr().out.split())
    assert "UNDECIDED" in printed
    assert "its model error bar is unknown" in printed
    (result,) = json.loads((folder / "machine" / "result.json").read_text())["parts"]
    by_bar = {c["kind"]: c for c in result["checks"] if c["kind"] in ("static", "fatigue")}
    assert len(by_bar) == 2
    for check in by_bar.values():
        assert (check["method"], check["status"]) == ("formula", "UNDECIDED")
        assert "no error bar: no solids of the family 'CAD part'" in check["note"]
        assert 0 < check["utilisation"] < 1
    assert any("that the bar is not straight" in text for text in result["assumed"])
    assert result["meshes"] == []
    assert [gate["name"] for gate in result["gates"] if not gate["holds"]] == []
