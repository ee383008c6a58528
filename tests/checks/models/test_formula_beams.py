"""Beams of a profile by formula and from a design file, beside hand calculations."""

from dataclasses import replace
from functools import partial
from itertools import islice
from math import perm

import numpy as np
import pytest
from numpy.polynomial import Legendre
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from bench.rung_truth import known
from bench.rung_variations import SCENES, Machines
from checks.by_formula import lug_shear_out
from checks.design.errors import DesignError
from checks.models import shapes
from checks.models.bands import Band, NoBand, band_of, proportions_of
from checks.models.checked import BUCKLING, FATIGUE, STATIC, rung_estimates, rung_level
from checks.models.formula_bars import as_plate
from checks.models.shapes import beams
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from checks.stress.solid_mesh_level import Models
from fem.recovery import von_mises

WALKING_BEAM = """\
name = "Walking beam"
ground = ["O"]
gravity = "0, 0 m/s2"
points = { A = "-300, 0 mm", O = "0, 0 mm", B = "400, 0 mm" }
bodies = { arm = { pins = ["A", "O", "B"] } }
[forces]
drive = { body = "arm", at = "A", direction = "0, 1", follows = "arm" }
work = { body = "arm", at = "B", direction = "0, -1", follows = "arm" }
[cycles.turn]
coordinate = "arm.angle"
start = "0 deg"
pace = { coordinate = "arm.angle", speed = "0.001 rad/s" }
positions = 3
phases = [
  { name = "there", to = "2 deg", solve = "drive", forces = { work = "6000 N" } },
  { name = "back", to = "0 deg", solve = "drive", forces = { work = "6000 N" } },
]
[duty]
cycles = { turn = 1e6 }
[parts.arm]
body = "arm"
shape = "rhs_beam"
interfaces = { foot = "A", saddle = "O", head = "B" }
height = "120 mm"
width = "60 mm"
wall = "5 mm"
corner = "10 mm"
fillet = "4 mm"
overhang = "60 mm"
material = "S355"
[parts.arm.holes]
foot = { diameter = "30 mm", boss = "50 mm" }
saddle = { diameter = "40 mm", boss = "65 mm" }
head = { diameter = "30 mm", boss = "50 mm" }
"""
I_BEAM = (
    WALKING_BEAM.replace("rhs_beam", "i_beam")
    .replace('wall = "5 mm"', 'web = "5 mm"\nflange = "7.4 mm"\nroot = "9 mm"')
    .replace('corner = "10 mm"', 'boss_width = "50 mm"')
)


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    folder = tmp_path_factory.mktemp("beams")

    def of(text):
        file = folder / "beam.toml"
        file.write_text(text)
        return read_design(file)

    return of


def modelled(design):
    cycles = solve_cycles(design, part_masses(design, Models()))
    part = design.parts["arm"]
    loads = loads_on(design, part, cycles)
    return loads, shapes.model_of(part, loads)


@pytest.mark.parametrize(
    ("text", "inertia"),
    [(WALKING_BEAM, 2_869_745.0), (I_BEAM, 3_303_842.0 + 4 * 44_538.0)],
    ids=["hollow", "I"],
)
def test_a_walking_beam_is_bent_most_at_its_saddle(read, text, inertia):
    """6 kN over 400 mm against 300 mm: 8 kN at the foot, 14 kN at the saddle, 2.4 kN m.

    Second moments: (60 120^3 - 50 110^3)/12 less corners of 10 and 5 mm; (60 120^3 - 55 105.2^3)/12
    and four roots of 17.38 mm2, 50.6 mm from the middle. Outermost fibre 60 mm.
    """
    design = read(text)
    loads, model = modelled(design)
    assert abs(loads.wrenches["foot"][0, 1]) == pytest.approx(8000, rel=1e-6)
    assert abs(loads.wrenches["saddle"][0, 1]) == pytest.approx(14000, rel=1e-6)
    section = design.parts["arm"].geometry.form.section
    assert section.inertia_in_plane == pytest.approx(inertia, rel=1e-6)
    points = model.history.points
    (at,) = np.flatnonzero(np.isclose(points, [300, 60, 0], atol=1e-3).all(axis=1))[:1]
    stress = model.history.basis[at] @ model.history.coefficients[:, 0]
    assert abs(stress[0]) == pytest.approx(2.4e6 * 60 / inertia, rel=1e-4)


def test_the_webs_carry_the_shear_from_pin_to_pin(read):
    """6 kN between saddle and head: V S/(I 2 t) with S of half the hollow section, its walls' 60
    by 60 less 50 by 55 mm, corners left out (1 %).
    """
    _, model = modelled(read(WALKING_BEAM))
    history = model.history
    near = np.isclose(history.points[:, :2], [500.0, 0.0], atol=60.0).all(axis=1)
    between = near & (np.array(model.places) == "saddle to head") & (history.points[:, 1] == 0.0)
    stress = np.einsum("psb,b->ps", history.basis[between], history.coefficients[:, 0])
    first = 60 * 60**2 / 2 - 50 * 55**2 / 2
    assert len(stress)
    assert np.abs(stress[:, 3]) == pytest.approx(6000 * first / (2_869_745 * 10), rel=0.02)


def test_the_stress_across_a_boss_s_fillet_is_raised_as_at_a_shoulder(read, monkeypatch):
    """Heywood's factor of a bar 60 on 10 mm with 4 mm: across the fillet that, along it nothing."""
    design = read(WALKING_BEAM)

    def largest():
        _, model = modelled(design)
        own = np.array(model.places) == "foot of saddle"
        history = model.history
        stress = np.einsum("psb,b->ps", history.basis[own], history.coefficients[:, 0])
        arms = history.points[own, :2] - [300.0, 0.0]
        (c, s) = (arms / np.hypot(*arms.T)[:, None]).T
        radial = stress[:, 0] * c**2 + stress[:, 1] * s**2 + 2 * stress[:, 3] * s * c
        around = stress[:, 0] * s**2 + stress[:, 1] * c**2 - 2 * stress[:, 3] * s * c
        return np.abs(radial).max(), np.abs(around).max()

    raised = largest()
    monkeypatch.setattr(beams, "_across", lambda stress, _: stress)
    plain = largest()
    factor = 1 + (25 / 4 / (2.8 * 6 - 2)) ** 0.65
    assert raised[0] / plain[0] == pytest.approx(factor, rel=1e-6)
    assert raised[1] == pytest.approx(plain[1], rel=1e-9)


def test_a_hollow_beam_by_formula_is_its_solid(read):
    """Outermost fibre 50.2 MPa; a solid of 150 000 unknowns has 49.8 there, the part's peak."""
    _, model = modelled(read(WALKING_BEAM))
    history = model.history
    stress = np.einsum("psb,b->ps", history.basis, history.coefficients[:, 0])
    values = von_mises(stress)
    largest = {
        name: max(value for value, own in zip(values, model.places, strict=True) if own == name)
        for name in model.places
    }
    assert max(largest.values()) == pytest.approx(50.2, rel=0.03)
    assert largest["saddle"] < largest["foot of saddle"] < 50.2


def test_a_pin_tears_out_of_the_ring_of_its_boss_whatever_way_it_pulls(read):
    """14 kN across the beam at the saddle, on two planes of (65 - 40)/2 times 60 mm: 9.33 MPa."""
    design = read(WALKING_BEAM)
    loads, _ = modelled(design)
    (check,) = lug_shear_out.checks(LoadedPart(design, design.parts["arm"], loads))
    assert check.value == pytest.approx(14000 / (2 * 12.5 * 60), rel=1e-6)


def test_sharp_bosses_are_left_to_solids(read):
    _, none = modelled(read(WALKING_BEAM.replace('fillet = "4 mm"\n', "")))
    assert none is None


def pushed(design, force):
    """A beam with its two outer pins that push it together; per position."""
    loads, _ = modelled(design)
    part = design.parts["arm"]
    pins = part.geometry.holes[:2]
    wrench = np.zeros_like(loads.wrenches["foot"])
    wrench[:, 0] = force
    part = replace(part, geometry=replace(part.geometry, holes=pins))
    still = np.zeros_like(loads.accelerations)
    wrenches = {"foot": wrench, "head": -wrench}
    return part, replace(loads, wrenches=wrenches, accelerations=still, tilt_held_at=None)


@pytest.mark.parametrize("text", [WALKING_BEAM, I_BEAM])
def test_beams_of_three_pins_have_bars_as_solids_had(read, text):
    """Of two pins there were none."""
    design = read(text)
    cycles = solve_cycles(design, part_masses(design, Models()))
    part = design.parts["arm"]
    loads = loads_on(design, part, cycles)
    two = replace(part, geometry=replace(part.geometry, holes=part.geometry.holes[:2]))
    known = proportions_of(part, loads)
    for kind in (STATIC, FATIGUE):
        band, none = (
            band_of(shapes.family_of(one, loads, kind), "formula", kind, known)
            for one in (part, two)
        )
        assert isinstance(band, Band)
        assert isinstance(none, NoBand)


@pytest.mark.parametrize("text", [WALKING_BEAM, I_BEAM])
def test_a_beam_that_two_pins_push_together_is_eulers_column(read, text):
    """Out of the plane, between the resultants of both pins' pressure: 700 - 2 * 8/(3 pi) 15 mm."""
    part, loads = pushed(read(text), 10e3)
    load = shapes.model_of(part, loads).buckling
    section = part.geometry.form.section
    critical = np.pi**2 * 210e3 * section.inertia_out_of_plane / (700 - 80 / np.pi) ** 2
    assert load.share == pytest.approx(10e3 / critical, rel=1e-3)
    assert load.words.startswith("out of plane")


def test_a_wide_beam_gives_way_in_the_plane_or_twists(read):
    """Held against twisting at one end alone an open section twists evenly, t = x/L: F r^2 = G J.

    The pin's pressure keeps its direction, 4/(3 pi) 15 F across the beam: it takes L times that
    off F r^2.
    """
    hollow, loads = pushed(read(WALKING_BEAM), 10e3)
    wide = replace(hollow, geometry=replace(hollow.geometry, width=300.0))
    load = shapes.model_of(wide, loads).buckling
    form = wide.geometry.form
    critical = np.pi**2 * 210e3 * form.section.inertia_in_plane / 700**2
    slides = 210e3 / 2.6 * float(form.sections.shear_area_y)  # Engesser
    assert load.words.startswith("in plane")
    assert load.share == pytest.approx(10e3 * (1 / critical + 1 / slides), rel=1e-6)
    open_, loads = pushed(read(I_BEAM), 10e3)
    wide = replace(open_, geometry=replace(open_.geometry, width=300.0))
    load, form = shapes.model_of(wide, loads).buckling, wide.geometry.form
    polar = form.section.inertia_in_plane + form.section.inertia_out_of_plane
    twisting = 210e3 / 2.6 * float(form.sections.torsion)
    assert load.words.startswith("out of plane")
    arm = polar / form.section.area - 4 / (3 * np.pi) * 15 * 700
    assert load.share == pytest.approx(10e3 * arm / twisting, rel=1e-3)


def test_a_beam_that_is_pressed_beyond_two_pins_sways_in_the_plane(read):
    """Of 1500 mm the last 1350 are free: k b tan(k b) = 3 b/a, F = k2 E I, beside shear.

    A solid of 60 x 140 x 5 mm has 3.8 times Euler's column from end to end.
    """
    design = read(
        WALKING_BEAM.replace("-300, 0 mm", "-150, 0 mm").replace("400, 0 mm", "1350, 0 mm")
    )
    part, loads = pushed(design, 10e3)
    push = np.array([[-10e3, 0.0, 0.0, 0.0, 0.0, 0.0]])
    part = replace(part, geometry=replace(design.parts["arm"].geometry, width=300.0))
    count = len(loads.accelerations)
    wrenches = {"foot": 0 * push, "saddle": -push, "head": push}
    wrenches = {name: np.repeat(wrench, count, axis=0) for name, wrench in wrenches.items()}
    loads = replace(loads, wrenches=wrenches, tilt_held_at="saddle")
    load, form = shapes.model_of(part, loads).buckling, part.geometry.form
    wave = brentq(lambda turn: turn * np.tan(turn) - 3 * 1350 / 150, 1.0, 1.57) / 1350
    critical = wave**2 * 210e3 * form.section.inertia_in_plane
    slides = 210e3 / 2.6 * float(form.sections.shear_area_y)
    assert load.words == "in plane: hinged at two pins, free beyond them"
    assert load.share == pytest.approx(10e3 * (1 / critical + 1 / slides), rel=1e-3)
    assert load.weakest == load.share
    tip, root = load.mode(np.array([[1500.0, 0.0, 0.0], [150.0, 0.0, 0.0]]))
    assert abs(tip[1]) > 1e3 * np.abs([*root, tip[0], tip[2]]).max()


def test_a_bent_beam_gives_way_sideways_as_by_ritz(read):
    """The work of moments is the integral of M w'' t, without shear; powers, with kinks at 300 mm.

    Nothing presses along it, so what pins press counts as nothing.
    """
    design = read(I_BEAM)
    _, model = modelled(design)
    form = design.parts["arm"].geometry.form
    (points, weights), length = np.polynomial.legendre.leggauss(30), 700.0
    x = np.concatenate([150 + 150 * points, 500 + 200 * points])
    weight = np.concatenate([150 * weights, 200 * weights])[:, None]

    def rows(at, slopes):
        powers = [Legendre.basis(n, [0, length]).deriv(slopes)(at) for n in range(14)]
        kinks = [
            np.where(at > 300, perm(n, slopes) * ((at - 300) / length) ** (n - slopes), 0.0)
            for n in (2, 3, 4, 5)
        ]
        return np.stack([*powers, *(kink / length**slopes for kink in kinks)], axis=1)

    def both(at, slopes):
        own = rows(np.asarray(at), slopes)
        return np.hstack([length * own, 0 * own]), np.hstack([0 * own, own])

    (_, twist), (_, rate), (bent, warped) = (both(x, slopes) for slopes in range(3))
    young, inertia = 210e3, form.section.inertia_out_of_plane
    energy = bent.T @ (weight * young * inertia * bent)
    energy += rate.T @ (weight * young / 2.6 * float(form.sections.torsion) * rate)
    energy += warped.T @ (weight * young * form.warping * warped)
    moment = np.where(x < 300, 8000 * x, 6000 * (700 - x))[:, None]
    work = bent.T @ (weight * moment * twist)
    held = np.vstack([both([0.0, 300.0], 0)[0], both([300.0], 0)[1]])
    free = null_space(held)
    shares = eigh(free.T @ (work + work.T) @ free, free.T @ energy @ free, eigvals_only=True)
    assert model.buckling.share == pytest.approx(shares[-1], rel=1e-3)


def test_a_section_that_warps_resists_twisting_and_slender_walls_are_bounded(read):
    """Flanges 112.6 mm apart: I_y h^2/4; web 105.2 x 5 and halves of flanges 29.5 x 7.4 mm."""
    part = read(I_BEAM).parts["arm"]
    form = part.geometry.form
    assert form.warping == pytest.approx(form.section.inertia_out_of_plane * 112.6**2 / 4)
    slender = [as_plate(b, t, free=free) for b, t, free in part.geometry.plates]
    assert slender == pytest.approx([0.28 * (105.2 / 5) ** 2, 2.6 * (27.5 / 7.4) ** 2])


def test_a_sleeve_that_is_long_beside_its_own_boss_has_no_bar(read):
    """Of 120 x 73 x 5 mm with bosses of 20 mm at the ends a solid has 59.6 MPa, the formula 28.1.

    In the middle the boss is 65 mm; sleeves of 1.9 times the least boss were compared.
    """
    text = WALKING_BEAM.replace('width = "60 mm"', 'width = "73 mm"')
    text = text.replace("-300, 0 mm", "-200, 0 mm").replace("400, 0 mm", "215, 0 mm")
    text = text.replace('fillet = "4 mm"', 'fillet = "4 mm"\nbearing_arc = "90 deg"')

    def static(hole, boss):
        old = '{ diameter = "30 mm", boss = "50 mm" }'
        design = read(text.replace(old, f'{{ diameter = "{hole} mm", boss = "{boss} mm" }}'))
        loads, model = modelled(design)
        loaded = LoadedPart(design, design.parts["arm"], loads)
        again = partial(shapes.model_of, loaded.part)
        return rung_estimates(loaded, rung_level(loaded, model), None, again, [STATIC])[STATIC]

    slender = static(13, 20).check
    assert slender.value == pytest.approx(28.1, abs=0.1)
    assert slender.upper == np.inf
    assert "boss length / boss is 3.65" in slender.note
    assert static(30, 50).check.upper < 50


def test_flanges_thinner_than_those_compared_have_no_bar(read):
    """Of rolled sections they are 1.3 to 2.1 times the web, of the solids 1.3 to 2.0 times."""
    text = I_BEAM.replace('material = "S355"', 'material = "S355"\nbearing_arc = "90 deg"')
    known = {}
    for flange in (2.5, 7.4):
        design = read(text.replace("7.4 mm", f"{flange} mm").replace('"4 mm"', '"3 mm"', 1))
        scales = proportions_of(design.parts["arm"], modelled(design)[0])
        known[flange] = band_of("i_beam", "formula", "static", scales)
    assert isinstance(known[7.4], Band)
    assert isinstance(known[2.5], NoBand)
    assert "flange / web is 0.5" in known[2.5].why


def test_the_bound_on_buckling_holds_the_solids():
    """Of drawn beams every second one was solved; of all of them the least is 2.57 times it."""
    machines, found = Machines(), []
    lines = known()
    for scene in (scene for scene in SCENES if scene.design in ("rhs_beam", "i_beam")):
        for each in islice(machines.variations(scene), 5):
            checks = lines[each.name].get("checks", {}).values()
            solid = [check["value"] for check in checks if check["kind"] == "buckling"]
            if not solid:
                continue
            loaded = LoadedPart(each.design, each.part, each.loads)
            level = rung_level(loaded, shapes.model_of(each.part, each.loads))
            estimate = rung_estimates(loaded, level, None, lambda _: None, [BUCKLING])[BUCKLING]
            found.append(estimate.check.upper / solid[0])
            assert estimate.check.lower == 0.0
    assert len(found) >= 4
    assert min(found) > 2.5


def test_the_outermost_pins_come_first_whatever_the_order_of_the_table(read):
    shape = read(WALKING_BEAM).parts["arm"].geometry
    assert [(hole.name, hole.at) for hole in shape.holes] == [
        ("foot", 0.0), ("head", 700.0), ("saddle", 300.0)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('O = "0, 0 mm"', 'O = "0, 1 mm"', "interfaces.saddle: sits 1 mm beside the line"),
        ('boss = "65 mm"', 'boss = "95 mm"', "holes.saddle.boss: 95 mm with its fillet meets"),
        ("saddle = { diameter", "sadle = { diameter", "did you mean saddle|must say at which"),
    ],
)
def test_what_is_no_beam_is_told_with_its_key(read, old, new, says):
    with pytest.raises(DesignError, match=says):
        read(WALKING_BEAM.replace(old, new))
