"""Welds on beams and on arms of levers by nominal stress, against calculations by hand."""

# ruff: noqa: E501 - one refusal a line

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from checks import by_formula
from checks.by_formula import weld
from checks.design.data import Weld
from checks.design.errors import DesignError
from checks.models.formula_bars import bar_loads
from checks.models.shapes import beams
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartDoubt, loads_on
from checks.stress.solid_mesh_level import Models
from fatigue.life import AT_KNEE, SHEAR_CUT_OFF
from geometry.bars import Section, Walls
from geometry.outlines import Contour, PlateOutline
from geometry.parameters import ParameterError
from geometry.parts.plate import Plate, PlateBore

from ...ballesta.design.test_plate_parts import LEVER, MACHINE
from ...small_machine import loads_of
from ..models.test_formula_beams import I_BEAM, WALKING_BEAM
from .test_weld_checks import shear_flow

CRANK = (
    MACHINE.replace('"-80, 0 mm"', '"-200, 0 mm"')
    .replace('"0, 60 mm"', '"0, 160 mm"')
    .replace("SHAPE", LEVER)
    .replace("cycles.push", "cycles.turn")
    .replace("push = 1000", "turn = 1000")
)
ON_TUBE = 'detail = "attachment on tube", length = "60 mm"'
ON_PLATE = 'detail = "tube on plate by fillet", throat = "4 mm"'
ACROSS = 'detail = "attachment across bar", length = "10 mm"'


def read(folder, text, welds):
    """The design of a beam or a lever with welds."""
    file = folder / "machine.toml"
    holes = "[parts.arm.holes]" if "parts.arm" in text else "[parts.crank.holes]"
    file.write_text(text.replace(holes, f"welds = [{{ {welds} }}]\n{holes}"))
    return read_design(file)


def checked(design, loads):
    """The checks of the welds of a design's one part, and the forces at the first weld."""
    (part,) = design.parts.values()
    loaded = LoadedPart(design, part, loads)
    return [*weld.checks(loaded)], weld._forces(loaded, part.welds[0])


def bent(force=6000.0):
    """The walking beam of 700 mm: nothing, then a force down at its head, 400 mm from the saddle."""
    at = {"foot": -force * 4 / 3, "saddle": force * 7 / 3, "head": -force}
    return loads_of({name: [(0, 0, 0), (0, up, 0)] for name, up in at.items()})


def cranked(force=4000.0):
    """The bell crank: nothing, then a force along the first arm at the end of the second one."""
    up = force * 160 / 200
    rows = {"A": (0, -up, 0), "O": (-force, up, 0), "B": (force, 0, 0)}
    return loads_of({name: [(0, 0, 0), row] for name, row in rows.items()})


def assert_reached(check, normal, shear, category):
    """(n S/S_D)^3 + (n T/T_L)^5 = 1 of a life without end."""
    n = check.safety
    first, second = n * normal / (AT_KNEE * category), n * shear / (SHEAR_CUT_OFF * 80.0)
    assert_allclose(first**3 + second**5, 1.0, rtol=1e-6)
    assert check.limit == category


def rounded_line(height, width, corner, pieces=2000):
    """Points (y, z) and lengths of a thin line round a rectangle, from the middle of its top."""
    share, rest = (np.arange(pieces) + 0.5) / pieces, np.ones(pieces)
    up, out = height / 2 - corner, width / 2 - corner
    turn = share * pi / 2
    points = np.concatenate(
        [
            np.column_stack([rest * height / 2, out * share]),
            np.column_stack([up + corner * np.cos(turn), out + corner * np.sin(turn)]),
            np.column_stack([up * (1 - share), rest * width / 2]),
        ]
    )
    lengths = np.concatenate([rest * out, rest * corner * pi / 2, rest * up]) / pieces
    for mirror in ([-1, 1], [1, -1]):
        points = np.concatenate([points, points[::-1] * mirror])
        lengths = np.concatenate([lengths, lengths[::-1]])
    return points, lengths


def test_an_attachment_on_a_hollow_beam_by_hand(tmp_path):
    """6 kN 200 mm beyond the weld: 1.2 kN m on 120 x 60 x 5 mm, 1.2e6 60/2 869 745 = 25.09 MPa.

    Of the walls' middle line, 115 by 55 mm with corners of 7.5 mm, a quarter has 3045 mm2 and all
    572 810 mm3: 6000 3045/(572 810 5) = 6.38 MPa of shear.
    """
    (toe,), forces = checked(read(tmp_path, WALKING_BEAM, f'at = "500 mm", {ON_TUBE}'), bent())
    assert_allclose([forces["M_z"][1], forces["V"][1]], [-1.2e6, -6000.0], rtol=1e-9)
    assert_allclose(toe.derivation.number("S"), 1.2e6 * 60 / 2_869_745, rtol=1e-6)
    assert_allclose(toe.derivation.number("T_r"), 6.380, atol=5e-4)
    assert_reached(toe, 1.2e6 * 60 / 2_869_745, toe.derivation.number("T_r"), 71.0)
    assert toe.place == "weld at 500 mm from foot, rectangular 120 x 60 x 5 mm"


def test_top_and_bottom_fibre_of_a_beam_are_judged(tmp_path):
    """A pull of 30 kN in step with the bending adds on one side; turned about, on the other."""
    design = read(tmp_path, I_BEAM, f'at = "500 mm", {ACROSS}')
    area = design.parts["arm"].geometry.form.section.area
    sides = []
    for force in (6000.0, -6000.0):
        loads = bent(force)
        loads.wrenches["head"][1, 0], loads.wrenches["saddle"][1, 0] = 30000.0, -30000.0
        ((toe,), _) = checked(design, loads)
        assert_allclose(
            toe.derivation.number("S"), 30000 / area + 1.2e6 * 60 / 3_481_994, rtol=1e-6
        )
        sides.append(toe.derivation.number("y"))
    assert sides == [60.0, -60.0]


def test_a_cross_weld_on_the_flange_of_an_i_beam_by_hand(tmp_path):
    """1.2e6 60/3 481 994 = 20.68 MPa; S = 60 7.4 56.3 + 5 105.2^2/8 + roots 1759 = 33 673 mm3."""
    (toe,), _ = checked(read(tmp_path, I_BEAM, f'at = "500 mm", {ACROSS}'), bent())
    assert_reached(toe, 1.2e6 * 60 / 3_481_994, 6000 * 33_672.9 / (5 * 3_481_994), 80.0)


def test_the_root_of_a_hollow_beam_by_hand(tmp_path):
    """A throat of 4 mm round 120 x 60 mm with corners of 10 mm: lines summed piece by piece."""
    design = read(tmp_path, WALKING_BEAM, f'at = "500 mm", {ON_PLATE}')
    (toe, root, throat), _ = checked(design, bent())
    points, lengths = rounded_line(120.0, 60.0, 10.0)
    second = 4.0 * float((points[:, 0] ** 2 * lengths).sum())
    normal, shear = 1.2e6 * 60 / second, 6000 * shear_flow(points, lengths, 4.0)
    assert_allclose(root.derivation.number("S"), normal, rtol=1e-6)
    assert_allclose(root.derivation.number("T_r"), shear, rtol=1e-3)
    assert_reached(root, normal, root.derivation.number("T_r"), 36.0)
    assert_allclose(throat.value, 4.0 * sqrt(normal**2 + shear**2), rtol=1e-4)
    scope = {}
    for item in weld._throat(design.parts["arm"].welds[0]):
        scope[item.symbol] = weld.value_of(item, scope)
    assert_allclose(scope["A"], 4.0 * lengths.sum(), rtol=1e-9)
    assert_allclose(scope["I_y"], 4.0 * (points[:, 1] ** 2 * lengths).sum(), rtol=1e-6)
    enclosed = 120 * 60 - (4 - pi) * 10**2
    assert_allclose(scope["q_T"], 1 / (2 * enclosed * 4.0), rtol=1e-12)  # Bredt
    assert toe.limit == 36.0


@pytest.mark.parametrize(
    ("outline", "height", "width", "load", "arm", "allowed", "printed"),
    [
        ("flat", 400.0, 300.0, 50e3, 300.0, 70.0, 2.198406),
        ("rectangular", 150.0, 100.0, 25e3, 500.0, 75.0, 3.763189),
        ("round", 50.0, 50.0, 10e3, 200.0, 100.0, 5.132593),
    ],
)
def test_printed_throats_under_a_bending_force(outline, height, width, load, arm, allowed, printed):
    """Public collection FOSSEE/Scilab-TBC-Uploads, 764/CH8, examples 8.13 to 8.15 of a textbook, pages 292 and 293.

    They ask for the throat at which sqrt((s/2)^2 + (P/A)^2) is allowed. Welds along a line have a
    second moment of their own throat in 8.14, l t^3/12 with t = 1 mm, 1e-5 of all.
    """
    scope = unit_throat(outline, height, width)
    bent, sheared = load * arm * height / 2 / scope["I_z"], load / scope["A"]
    assert_allclose(sqrt((bent / 2) ** 2 + sheared**2) / allowed, printed, rtol=1e-5)


def test_the_printed_throat_of_a_twisted_shaft():
    """The same, example 8.16, page 294: 2500 N m on 50 mm, 140 MPa allowed."""
    scope = unit_throat("round", 50.0, 50.0)
    assert_allclose(2500e3 * scope["q_T"] / 140.0, 4.547284, atol=5e-7)


def unit_throat(outline, height, width):
    """The section of a throat of 1 mm round or along an outline."""
    section = Section("", 1.0, 1.0, 1.0, depth_in_plane=height, depth_out_of_plane=width)
    walls = Walls(outline, height, width, (0.0, 1.0), section)
    scope = {}
    for item in weld._throat(Weld(0.5, walls, 36.0, "", 1.0, 1.35, "")):
        scope[item.symbol] = weld.value_of(item, scope)
    return scope


def test_a_torque_on_a_hollow_beam_by_hand(tmp_path):
    """1 kN m within the walls' middle line, 115 x 55 mm less (4 - pi) 7.5^2: Bredt's T/(2 A_m t)."""
    design = read(tmp_path, WALKING_BEAM, f'at = "500 mm", {ON_TUBE}')
    loads = bent(0.0)
    loads.wrenches["saddle"][1, 3], loads.wrenches["head"][1, 3] = -1e6, 1e6
    (toe,), forces = checked(design, loads)
    assert "B" not in forces
    by_hand = 1e6 / (2 * (115 * 55 - (4 - pi) * 7.5**2) * 5)
    assert_allclose(toe.derivation.number("T_r"), by_hand, rtol=1e-9)
    assert_reached(toe, 0.0, by_hand, 71.0)


def test_a_torque_on_an_i_beam_bends_its_flanges(tmp_path):
    """Couples about x at saddle, foot and head: E I_w v'' - G J v = M in steps of 0.5 mm, v = 0 at the ends.

    M > 0 pushes the upper flange towards z > 0 between supports: tension at y > 0, z > 0, where a
    moment M_y > 0 pulls as well.
    """
    design = read(tmp_path, I_BEAM, f'at = "470 mm", {ACROSS}')
    shape = design.parts["arm"].geometry
    loads = loads_of({name: [(0, 0, 0)] * 2 for name in shape.interfaces})
    couples = {"foot": -4 / 7, "saddle": 1.0, "head": -3 / 7}
    for name, share in couples.items():
        loads.wrenches[name][1, 3] = share * 50e3
    loads.wrenches["saddle"][1, 4], loads.wrenches["head"][1, 4] = -20e3, 20e3
    (toe,), forces = checked(design, loads)
    step, places = 0.5, {hole.name: hole.at for hole in shape.holes}
    x = np.arange(-60.0, 760.0 + step / 2, step)
    k2 = float(shape.form.sections.torsion) / (2 * 1.3 * shape.form.warping)
    jumps = np.zeros(len(x))
    for name, share in couples.items():
        jumps[int(np.argmin(np.abs(x - places[name])))] += share * 50e3 / step
    matrix = np.diag(np.full(len(x) - 2, -2 / step**2 - k2))
    matrix += np.diag(np.full(len(x) - 3, 1 / step**2), 1) + np.diag(
        np.full(len(x) - 3, 1 / step**2), -1
    )
    beside = np.zeros(len(x))
    beside[1:-1] = np.linalg.solve(matrix, -jumps[1:-1])  # -E I_w v = B
    here = float(beside[int(np.argmin(np.abs(x - 470.0)))])
    assert here > 0.0
    assert_allclose(forces["B"][1], here, rtol=1e-4)
    stress = (
        here * 60 * 30 / shape.form.warping + 20e3 * 30 / shape.form.section.inertia_out_of_plane
    )
    assert_allclose(toe.derivation.number("S"), stress, rtol=1e-4)
    torque = 50e3 * 3 / 7 * 7.4 / float(shape.form.sections.torsion)
    assert_allclose(toe.derivation.number("T_r"), torque, rtol=1e-9)


@pytest.mark.parametrize("text", [WALKING_BEAM, I_BEAM], ids=["hollow", "I"])
def test_forces_at_a_weld_of_a_beam_are_those_of_its_formula(tmp_path, text):
    """Thrown and turned as well, so that its own mass with bosses and holes counts."""
    design = read(tmp_path, text, 'at = "500 mm", category = "56 MPa"')
    part = design.parts["arm"]
    loads = loads_on(design, part, solve_cycles(design, part_masses(design, Models())))
    turned = np.tile([3e6, 5e6, 2e4, 4e4], (len(loads.accelerations), 1))
    loads = replace(loads, accelerations=turned)
    own = weld._forces(LoadedPart(design, part, loads), part.welds[0])
    places = {hole.name: hole.at for hole in part.geometry.holes}
    beside = bar_loads(part, loads, places, beams._stretches(part.geometry)).at(np.array([500.0]))
    for name, of in (("N", beside.axial), ("V", beside.shear), ("M_z", beside.moment_z)):
        assert_allclose(own[name], of[0], rtol=2e-3)  # a cell of the mass


@pytest.mark.parametrize(
    ("where", "lever", "sine", "shear"),
    [
        ('at = "100 mm", between = ["A", "O"]', 3200.0 * 100, 8 / 200, 3200.0),
        ('at = "100 mm", between = ["O", "A"]', 3200.0 * 100, 8 / 200, 3200.0),
        ('at = "80 mm", between = ["B", "O"]', 4000.0 * 80, 8 / 160, 4000.0),
    ],
)
def test_arms_of_a_bell_crank_by_hand(tmp_path, where, lever, sine, shear):
    """Eyes of 30 and 46 mm, 200 and 160 mm apart: half-way (15 + 4)/cos on either side, 12 mm thick.

    4 kN at B on 160 mm is 3.2 kN at A on 200 mm: 0.32 kN m in either section, 110.6 and 110.5 MPa.
    """
    (toe,), _ = checked(read(tmp_path, CRANK, f"{where}, {ACROSS}"), cranked())
    height = 2 * 19.0 / sqrt(1 - sine**2)
    assert_reached(toe, lever * 6 / (12 * height**2), 1.5 * shear / (12 * height), 80.0)


def test_a_couple_out_of_the_plane_turns_with_the_arm(tmp_path):
    """1 N m about the first arm is bending of the second one across itself, not torque."""
    found = {}
    for where in ('at = "100 mm", between = ["A", "O"]', 'at = "80 mm", between = ["B", "O"]'):
        design = read(tmp_path, CRANK, f"{where}, {ACROSS}")
        loads = cranked(0.0)
        far = "A" if '"A"' in where else "B"
        loads.wrenches[far][1, 3], loads.wrenches["O"][1, 3] = 1000.0, -1000.0
        _, forces = checked(design, loads)
        found[far] = (abs(forces["T"][1]), abs(forces["M_y"][1]))
    assert_allclose(found["A"], (1000.0, 0.0), atol=1e-9)
    assert_allclose(found["B"], (0.0, 1000.0), atol=1e-9)


def test_the_mass_of_an_arm_bends_it(tmp_path):
    """A plate of 300 x 40 x 10 mm thrown across and turned by a force at O, 90 mm from its middle.

    At 100 mm from A the force at O less m a of the 160 mm beyond, and its own m (160^2 + 40^2)/12.
    """
    design = read(tmp_path, CRANK, f'at = "100 mm", between = ["A", "O"], {ACROSS}')
    (part,) = design.parts.values()
    corners = [-40 - 20j, 260 - 20j, 260 + 20j, -40 + 20j]
    holes = tuple(Contour.round(complex(x), 1e-3) for x in (0.0, 200.0))
    bores = (PlateBore("A", 2e-3, (0.0, 0.0)), PlateBore("O", 2e-3, (200.0, 0.0)))
    bar = Plate(PlateOutline(Contour.of(corners, [0.0] * 4), holes), bores, 10.0)
    mass, across = part.material.density * 300 * 40 * 10, 1e6
    walls = bar.walls_across(100.0, ())
    part = replace(part, geometry=bar, welds=(replace(part.welds[0], walls=walls, between=()),))
    alpha = across * (200 - 110) / ((300**2 + 40**2) / 12)
    loads = loads_of({"A": [(0, 0, 0)], "O": [(0, mass * across, 0)]})
    loads = replace(loads, accelerations=np.array([[0.0, across - alpha * 110.0, alpha, 0.0]]))
    forces = weld._forces(LoadedPart(design, part, loads), part.welds[0])
    beyond = mass * 160 / 300
    shear = mass * across - beyond * (across + alpha * (180.0 - 110.0))
    assert_allclose(forces["V"], shear, rtol=1e-6)
    inertia = beyond * (160**2 + 40**2) / 12
    moment = mass * across * 100.0 - beyond * (across + alpha * 70.0) * 80.0 - alpha * inertia
    assert_allclose(forces["M_z"], moment, rtol=1e-6)


def test_what_is_not_known_of_the_loads_is_in_the_bars(tmp_path):
    """Loads of 0.8 and 1.1 times: the value of an endless life is in proportion to them."""
    for text, where, loads in (
        (WALKING_BEAM, f'at = "500 mm", {ON_TUBE}', bent()),
        (CRANK, f'at = "100 mm", between = ["A", "O"], {ACROSS}', cranked()),
    ):
        design = read(tmp_path, text, where)
        (part,) = design.parts.values()
        ends = tuple(
            {name: k * wrench for name, wrench in loads.wrenches.items()} for k in (0.8, 1.1)
        )
        doubt = PartDoubt("its load", tuple(replace(loads, wrenches=one) for one in ends))
        (toe,) = by_formula._sampled(
            weld, LoadedPart(design, part, replace(loads, doubts=(doubt,)))
        )
        assert_allclose([toe.loads, toe.loads_below], [0.1 * toe.value, 0.2 * toe.value], rtol=1e-6)


@pytest.mark.parametrize(
    ("text", "welds", "wording"),
    [
        (WALKING_BEAM, f'at = "300 mm", {ON_TUBE}', r"welds\[0\]\.at: at 300 mm the stress is not that of even walls; it is from 450 to 550 mm"),
        (WALKING_BEAM, f'at = "900 mm", {ON_TUBE}', r"welds\[0\]\.at: at 900 mm the stress is not that of even walls"),
        (WALKING_BEAM, f'at = "500 mm", between = ["foot", "head"], {ON_TUBE}', r"welds\[0\]\.between: is of levers and drawn plates"),
        (WALKING_BEAM, f'at = "500 mm", {ACROSS}', r"has it for no rectangular tube, .* there are attachment on tube; tube end to end by butt"),
        (WALKING_BEAM.replace('wall = "5 mm"', 'wall = "14.2 mm"').replace('corner = "10 mm"', 'corner = "15 mm"'), f'at = "500 mm", {ON_TUBE}', r"is for walls up to 12\.5 mm, the part has 14\.2 mm there, or a stated category"),
        (I_BEAM, f'at = "500 mm", {ON_PLATE}', r"throat: of an I section's welds is not judged"),
        (I_BEAM, f'at = "500 mm", {ON_TUBE}', r"has it for no I section, .* there are attachment across bar; .*stiffener from flange to flange"),
        (CRANK, f'at = "100 mm", {ACROSS}', r"welds\[0\]\.between: must be two neighbouring holes: A and O, O and B; so state it"),
        (CRANK, f'at = "100 mm", between = ["A", "B"], {ACROSS}', r"between: must be two neighbouring holes: .*; got A and B"),
        (CRANK, f'at = "201 mm", between = ["A", "O"], {ACROSS}', r"at: 201 mm lies beyond O, which is 200 mm from A"),
        (CRANK, f'at = "-1 mm", between = ["A", "O"], {ACROSS}', r"at: -1 mm lies before A"),
        (CRANK, f'at = "0 mm", between = ["A", "O"], {ACROSS}', r"at: at 0 mm .*: the section is at a hole; the nearest place where it is: \d+ mm"),
        (CRANK, f'at = "30 mm", between = ["A", "O"], {ACROSS}', r"at: at 30 mm the stress is not that of a bar: a hole is 30 mm away; it must be at least 1\.25 heights, 40\.\d+ mm"),
    ],
)  # fmt: skip
def test_refusals(tmp_path, text, welds, wording):
    with pytest.raises(DesignError, match=wording):
        read(tmp_path, text, welds)


@pytest.mark.parametrize(
    ("corners", "window", "at", "wording"),
    [
        ([-30 - 20j, 130 - 20j, 130 - 35j, 330 - 35j, 330 + 35j, 130 + 35j, 130 + 20j, -30 + 20j], None, 100.0, "an edge within its height of 40 mm is steeper than 1 to 4; the nearest place where it is: 90 mm"),
        ([-30 - 20j, 120 - 20j, 122 - 8j, 124 - 20j, 330 - 20j, 330 + 20j, -30 + 20j], None, 100.0, "an edge within its height of 40 mm"),
        ([-30 - 20j, 330 - 20j, 330 + 20j, -30 + 20j], (150.0, 8.0), 110.0, "a hole is 40 mm away"),
        ([-30 - 20j, 330 - 20j, 330 + 20j, -30 + 20j], (150.0, 8.0), 145.0, "the section is at a hole; the nearest place where it is: 99 mm"),
        ([-99 - 90j, 399 - 90j, 399 + 90j, -99 + 90j], None, 150.0, "at least 1\\.25 heights, 225 mm; it is nowhere from A to B"),
        ([-30 - 20j, 100 - 20j, 100 - 90j, 200 - 90j, 200 - 20j, 330 - 20j, 330 + 20j, 199 + 20j, 199 - 50j, 101 - 50j, 101 + 20j, -30 + 20j], None, 150.0, "the section is beside the plate"),
    ],
)  # fmt: skip
def test_sections_without_the_stress_of_a_bar_are_refused(corners, window, at, wording):
    holes = [Contour.round(complex(x), 6.0) for x in (0.0, 300.0)]
    if window:
        holes.append(Contour.round(complex(window[0]), window[1]))
    bores = (PlateBore("A", 12.0, (0.0, 0.0)), PlateBore("B", 12.0, (300.0, 0.0)))
    plate = Plate(PlateOutline(Contour.of(corners, [0.0] * len(corners)), tuple(holes)), bores, 8.0)
    with pytest.raises(ParameterError, match=wording):
        plate.walls_across(at, ())


def test_an_even_plate_of_two_holes_needs_no_arm():
    """320 x 40 x 8 mm: from either hole 1.25 heights, 50 mm."""
    holes = tuple(Contour.round(complex(x), 6.0) for x in (0.0, 300.0))
    bores = (PlateBore("A", 12.0, (0.0, 0.0)), PlateBore("B", 12.0, (300.0, 0.0)))
    corners = [-30 - 25j, 330 - 25j, 330 + 15j, -30 + 15j]
    plate = Plate(PlateOutline(Contour.of(corners, [0.0] * 4), holes), bores, 8.0)
    for at in (50.1, 150.0, 249.9):
        walls = plate.walls_across(at, ())
        assert_allclose([walls.size, walls.section.inertia_in_plane], [40, 8 * 40**3 / 12])
    for at in (49.9, 250.1):
        with pytest.raises(ParameterError, match="a hole is"):
            plate.walls_across(at, ())
