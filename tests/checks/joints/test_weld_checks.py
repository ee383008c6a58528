"""Welds by nominal stress: toe, root and throat against calculations by hand, and refusals."""

# ruff: noqa: E501 - one refusal a line

import json
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.cli import main
from ballesta.pipeline import check_file
from ballesta.sweeps.improve import improve
from checks import by_formula
from checks.by_formula import weld
from checks.design.effort import Effort
from checks.design.errors import DesignError
from checks.handbook.weld_details import ROWS, category_of
from checks.models.formula_bars import bar_loads
from checks.models.shapes import plate_link, toggle_bar, tube_rod
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from fatigue.life import AT_KNEE, SHEAR_CUT_OFF
from geometry.bars import rectangle_torsion
from reports.what_if import what_if

from ...small_machine import PLATE, loads_of, machine, solved
from .test_slot_checks import lever

BAR = 'welds = [{ at = "40 mm", detail = "bar on plate by fillet", throat = "3 mm", length = "20 mm" }]'
ROD = """
[parts.rod]
body = "rod"
shape = "tube_rod"
interfaces = { first = "A", second = "B" }
material = "S275"
tube_diameter = "20 mm"
wall = "2.5 mm"
eye_diameter = "30 mm"
eye_width = "22 mm"
hole = "12 mm"
fillet = "5 mm"
"""
TUBE = 'welds = [{ at = "40 mm", detail = "tube on plate by fillet", throat = "2 mm" }]\n'
TOGGLE = """
[parts.rod]
body = "rod"
shape = "toggle_bar"
interfaces = { knee = "A", end = "B" }
material = "S355"
width = "30 mm"
wall = "3 mm"
hole = "12 mm"
overhang = "15 mm"
inner_radius = "2 mm"
cutout_length = "25 mm"
cutout_corner = "3 mm"
welds = [{ at = "80 mm", detail = "tube on plate by fillet", throat = "2 mm" }]
"""
LENGTH = sqrt(144.0**2 + 72.0**2)
ROUND = pi / 4 * (20.0**2 - 15.0**2)


def flat(folder, *overrides, welds=BAR):
    return machine(folder, PLATE + welds + "\n", *overrides)


def pulled(design, forces, across=None, **more):
    """The checks of the rod under forces along it, and across it at both ends, at two positions."""
    shear = np.zeros(len(forces)) if across is None else np.asarray(across)
    shape = design.parts["rod"].geometry.interfaces
    rows = {
        shape[0]: [(-f, -v, -v * LENGTH) for f, v in zip(forces, shear, strict=True)],
        shape[1]: [(f, v, 0.0) for f, v in zip(forces, shear, strict=True)],
    }
    loads = replace(loads_of(rows), **more)
    found = weld.checks(LoadedPart(design, design.parts["rod"], loads))
    return {check.quantity.removeprefix("fatigue of the ").split()[0]: check for check in found}


def test_a_pull_on_a_flat_bar_by_hand(tmp_path):
    """0 to 4.8 kN on 30 x 8 mm: 20 MPa at the toe, category 80; 4800/(2 x 30 x 3) in the throat."""
    found = pulled(flat(tmp_path), [0.0, 4800.0])
    toe, root = found["toe"], found["root"]
    assert_allclose(toe.safety, AT_KNEE * 80.0 / 20.0, rtol=1e-9)
    assert_allclose(root.safety, AT_KNEE * 36.0 / (4800.0 / 180.0), rtol=1e-9)
    assert (toe.limit, root.limit) == (80.0, 36.0)
    assert_allclose(found["throat"].value, 4800.0 / 60.0, rtol=1e-12)  # N/mm on each of two welds
    strength = 3.0 * found["throat"].derivation.number("S_u") / (sqrt(3) * 1.25)
    assert_allclose(found["throat"].limit, strength, rtol=1e-12)


def test_only_the_range_counts(tmp_path):
    """A pull that stays on, a push, and another strength change nothing of the fatigue."""
    zero = pulled(flat(tmp_path), [0.0, 4800.0])
    for forces in ([40000.0, 44800.0], [-4800.0, 0.0], [-2400.0, 2400.0]):
        other = pulled(flat(tmp_path, 'parts.rod.material="S355"'), forces)
        for place in ("toe", "root"):
            assert_allclose(other[place].safety, zero[place].safety, rtol=1e-9)


def test_the_partial_factor_is_the_least_safety(tmp_path):
    assert pulled(flat(tmp_path), [0.0, 100.0])["toe"].required == 1.35
    own = flat(tmp_path, "parts.rod.welds[0].partial_factor=1.15")
    assert pulled(own, [0.0, 100.0])["toe"].required == 1.3  # require.fatigue
    assert pulled(flat(tmp_path, "require.fatigue=2"), [0.0, 100.0])["root"].required == 2.0
    assert pulled(own, [0.0, 100.0])["throat"].required == 1.5


def test_bending_and_shear_of_a_flat_bar_by_hand(tmp_path):
    """V = 100 N at the far end: M_z = V (L - 40 mm), and 1.5 V over the section or the throat."""
    found = pulled(flat(tmp_path), [0.0, 0.0], [0.0, 100.0])
    moment = 100.0 * (LENGTH - 40.0)
    bent, sheared = moment * 15.0 / (8.0 * 30.0**3 / 12), 1.5 * 100.0 / 240.0
    n = found["toe"].safety
    limits = AT_KNEE * 80.0, SHEAR_CUT_OFF * 80.0
    assert_allclose((n * bent / limits[0]) ** 3 + (n * sheared / limits[1]) ** 5, 1.0, rtol=1e-9)
    bent, sheared = moment * 15.0 / (3.0 * 30.0**3 / 6), 1.5 * 100.0 / 180.0
    n = found["root"].safety
    limits = AT_KNEE * 36.0, SHEAR_CUT_OFF * 80.0
    assert_allclose((n * bent / limits[0]) ** 3 + (n * sheared / limits[1]) ** 5, 1.0, rtol=1e-9)
    assert_allclose(found["throat"].value, 3.0 * sqrt(bent**2 + sheared**2), rtol=1e-9)


def test_moments_out_of_the_plane_and_torque_of_a_flat_bar_by_hand(tmp_path):
    """M_y = 3 N m and T = 2 N m on 30 x 8 mm, throats of 3 mm: a torque is a couple of both welds."""
    design = flat(tmp_path)
    loads = loads_of({name: [(0, 0, 0)] * 2 for name in ("first", "second")})
    for name, sign in (("first", -1.0), ("second", 1.0)):
        loads.wrenches[name][1, 3:5] = sign * 2000.0, sign * 3000.0
    found = list(weld.checks(LoadedPart(design, design.parts["rod"], loads)))
    modulus = float(rectangle_torsion(30.0, 8.0)[1])
    toe = 3000.0 / (30.0 * 8.0**2 / 6), 2000.0 / modulus
    root = 3000.0 / 8.0 / (30.0 * 3.0), 2000.0 / 8.0 / (30.0 * 3.0)
    for check, category, (bent, sheared) in zip(found, (80.0, 36.0), (toe, root), strict=False):
        n = check.safety
        first, second = n * bent / (AT_KNEE * category), n * sheared / (SHEAR_CUT_OFF * 80.0)
        assert_allclose(first**3 + second**5, 1.0, rtol=1e-9)
    assert_allclose(found[2].value, 3.0 * sqrt(root[0] ** 2 + root[1] ** 2), rtol=1e-9)


def test_inertia_bends_the_bar_at_its_weld(tmp_path):
    """A bar thrown along and across: N = m a x/L, M_z = m a x (L - x)/(2 L) at x = 40 mm."""
    tube = (
        ROD.replace("tube_rod", "prismatic_tube").replace("first", "start").replace("second", "end")
    )
    sizes = ("tube_diameter", "wall", "eye_diameter", "eye_width", "hole", "fillet")
    kept = [one for one in tube.splitlines() if one.split(" ")[0] not in sizes]
    tube = "\n".join([*kept, 'width = "30 mm"', 'wall = "3 mm"', ""])
    part = machine(tmp_path, tube + TUBE).parts["rod"]
    area = 30.0**2 - 24.0**2
    along, across = 4e6, 7e6  # mm/s2
    mass = part.material.density * area * LENGTH
    half = mass * across / 2
    loads = loads_of({"start": [(0.0, half, 0.0)], "end": [(mass * along, half, 0.0)]})
    loads = replace(loads, accelerations=np.array([[along, across, 0.0, 0.0]]))
    found = weld._forces(LoadedPart(machine(tmp_path, tube + TUBE), part, loads), part.welds[0])
    x, cell = 40.0, 1 / 256  # of the mass, whose middle is on one side of the weld
    assert_allclose(found["N"], mass * along * x / LENGTH, atol=mass * along * cell / 2)
    assert_allclose(found["V"], half * (2 * x / LENGTH - 1), atol=half * cell)
    assert_allclose(found["M_z"], half * x * (LENGTH - x) / LENGTH, rtol=1e-3)


def test_a_throat_is_no_stronger_than_of_the_strongest_steel_of_the_code(tmp_path):
    """S460: 540/(sqrt(3) x 1.25) = 249.4 MPa, as steelcalculator.app prints it: 249; 42CrMo4 has 900."""
    design = flat(tmp_path, 'parts.rod.material="42CrMo4"')
    assert design.parts["rod"].material.ultimate_stress > 800.0
    assert_allclose(pulled(design, [0.0, 4800.0])["throat"].limit / 3.0, 249.4, atol=0.05)


def test_a_round_tube_by_hand(tmp_path):
    found = pulled(machine(tmp_path, ROD + TUBE), [0.0, 3000.0], [0.0, 50.0])
    moment = 50.0 * (LENGTH - 40.0)
    toe = 3000.0 / ROUND + moment * 10.0 / (pi / 64 * (20.0**4 - 15.0**4))
    root = 3000.0 / (pi * 20.0 * 2.0) + moment * 10.0 / (pi * 20.0**3 * 2.0 / 8)
    for place, stress, category in (("toe", toe, 40.0), ("root", root, 36.0)):
        shear = 2 * 50.0 / (ROUND if place == "toe" else pi * 20.0 * 2.0)
        n = found[place].safety
        first, second = n * stress / (AT_KNEE * category), n * shear / (SHEAR_CUT_OFF * 80.0)
        assert_allclose(first**3 + second**5, 1.0, rtol=1e-9)
        assert found[place].place.startswith("weld at 40 mm from first, round 20 x 2.5 mm")
        assert found[place].derivation.number("sigma") == found[place].value


def test_a_finite_life_by_hand(tmp_path):
    """1e5 runs of 0 to 24 kN, half of which may be used up: 100 MPa on category 80, 133 on 36.

    n^3 = 0.5 x 20 (80/100)^3 at the toe; 2e6 (36/133.3)^3 = 39 366 runs, n^3 = 0.197 in the throat.
    """
    design = flat(tmp_path, 'duty.life="finite"', "duty.cycles.turn=1e5")
    found = pulled(design, [0.0, 24000.0])
    assert_allclose(found["toe"].safety, (10 * 0.8**3) ** (1 / 3), rtol=1e-9)
    assert_allclose(found["root"].safety, (10 * (36.0 * 180 / 24000) ** 3) ** (1 / 3), rtol=1e-9)
    derivation = found["root"].derivation
    assert derivation.equal == (("D", "D_a"),)
    assert_allclose(derivation.number("D"), 0.5, rtol=1e-9)
    worn = flat(
        tmp_path, 'duty.life="finite"', "duty.cycles.turn=1e5", "duty.damage_so_far=0.2",
    )  # fmt: skip
    again = pulled(worn, [0.0, 24000.0])["root"]
    assert_allclose(again.safety / found["root"].safety, 0.6 ** (1 / 3), rtol=1e-9)


def test_earlier_use_that_leaves_nothing_is_refused(tmp_path):
    worn = ['duty.life="finite"', "duty.allowed_damage=1", "duty.damage_so_far=0.6"]
    with pytest.raises(
        DesignError, match=r"duty\.damage_so_far: 0\.6 leaves a weld nothing of its Miner"
    ):
        pulled(flat(tmp_path, *worn), [0.0, 24000.0])


def test_the_strength_of_a_throat_is_the_printed_one(tmp_path):
    """FrameAI, Fillet Weld Sizing Calculator: S355, f_u = 510 MPa, beta_w 0.9: 261.73 MPa, 785.2 N/mm.

    Here beta_w is 1, the largest of all steels.
    """
    found = pulled(flat(tmp_path), [0.0, 4800.0])["throat"]
    printed = found.limit * 510.0 / found.derivation.number("S_u") / 0.9
    assert_allclose(printed, 785.2, atol=0.05)
    assert_allclose(printed / 3.0, 261.73, atol=0.005)


def test_no_range_above_one_and_a_half_times_yield(tmp_path):
    """EN 1993-1-9, (8.1): one run of any range does less damage than that."""
    design = flat(tmp_path, 'duty.life="finite"', "duty.cycles.turn=1")
    toe = pulled(design, [0.0, 24000.0])["toe"]
    assert_allclose(toe.safety, 1.5 * 275.0 / 100.0, rtol=1e-9)
    assert toe.derivation.equal == (("n", "n_y"),)


def test_two_cycles_meet_in_the_duty(tmp_path):
    """A pull in one cycle and a push in another are one range, as often as both run."""
    design = flat(tmp_path)
    whole = pulled(design, [-2000.0, 2000.0])["root"]
    cycles = {"turn": slice(0, 1), "back": slice(1, 2)}
    duty = replace(design.duty, cycles={"turn": 1e6, "back": 1e6})
    split = pulled(
        replace(design, duty=duty), [-2000.0, 2000.0], cycles=cycles, cycle_names=("turn", "back")
    )["root"]
    assert_allclose(split.safety, whole.safety, rtol=1e-12)
    assert (split.cycle, split.position) == ("the whole duty", "turn k = 0 to back k = 1")


@pytest.mark.parametrize(
    ("text", "stretches"),
    [
        (PLATE + BAR, lambda s: plate_link._stretches(s, {"first": (0, s.hole), "second": (s.length, s.hole)})),
        (ROD + TUBE, tube_rod._stretches),
        (TOGGLE, lambda s: toggle_bar._stretches(s, s.cutout_length - s.overhang, *toggle_bar._sections(s))),
    ],
)  # fmt: skip
def test_forces_at_a_weld_are_those_of_the_formula_model(tmp_path, text, stretches):
    design = machine(tmp_path, text + "\n")
    part = design.parts["rod"]
    loads = loads_on(design, part, solved(design))
    own = weld._forces(LoadedPart(design, part, loads), part.welds[0])
    places = {one.name: float(one.centre[0]) for one in part.geometry.placed_interfaces}
    bar = bar_loads(part, loads, places, stretches(part.geometry))
    beside = bar.at(np.array([part.welds[0].at]))
    largest = loads.largest_force
    assert_allclose(own["N"], beside.axial[0], atol=2e-3 * largest)
    assert_allclose(own["V"], beside.shear[0], atol=2e-3 * largest)
    assert_allclose(own["M_z"], beside.moment_z[0], atol=2e-3 * largest * LENGTH)


def test_a_weld_of_a_toggle_bar_moves_the_mass_beyond_the_pin(tmp_path):
    """Pulled by its far end along itself at a: N is all mass on the knee's side of the weld, times a.

    Two cheeks of 30 x 3 mm from 15 mm before the pin to 10 mm behind it, less holes of 12 mm, then
    the tube. Without what is beyond the pins, N was 1.04 of it.
    """
    design = machine(tmp_path, TOGGLE)
    part, across = design.parts["rod"], 1e6
    tube = 30.0**2 - 24.0**2 + (4 - pi) * 2.0**2
    near = 25.0 * 180.0 - 6 * pi / 4 * 12.0**2 + 70.0 * tube
    far = (LENGTH + 15.0 - 80.0) * tube - 6 * pi / 4 * 12.0**2
    near, far = part.material.density * near, part.material.density * far
    loads = loads_of({"knee": [(0.0, 0.0, 0.0)], "end": [((near + far) * across, 0.0, 0.0)]})
    loads = replace(loads, accelerations=np.array([[across, 0.0, 0.0, 0.0]]))
    force = weld._forces(LoadedPart(design, part, loads), part.welds[0])["N"]
    assert_allclose(force, near * across, rtol=5e-3)  # a cell of the mass


def test_a_weld_at_an_end_carries_the_force_there(tmp_path):
    tube = """
[parts.rod]
body = "rod"
shape = "prismatic_tube"
interfaces = { start = "A", end = "B" }
material = "S355"
width = "30 mm"
wall = "3 mm"
"""
    for at in ("0 mm", "160.9968 mm"):
        welds = f'welds = [{{ at = "{at}", detail = "tube on plate by butt" }}]\n'
        found = pulled(machine(tmp_path, tube + welds), [0.0, 10000.0])
        assert list(found) == ["toe"]
        stress = 10000.0 / (30.0**2 - 24.0**2)
        assert_allclose(found["toe"].safety, AT_KNEE * 45.0 / stress, rtol=1e-3)


def throat(tmp_path, text, of=weld._throat):
    design = machine(tmp_path, text)
    scope = {}
    for item in of(design.parts["rod"].welds[0]):
        scope[item.symbol] = weld.value_of(item, scope)
    return scope


def shear_flow(points, lengths, thickness):
    """Largest stress of 1 N along y on closed thin walls (points (k, 2), even pieces), by q = V Q/I.

    Symmetric about y: the flow vanishes at the first point, which lies on that axis.
    """
    y = points[:, 0]
    second = float((y**2 * lengths).sum()) * thickness
    flow = np.cumsum(y * lengths) * thickness / second
    return float(np.abs(flow).max()) / thickness


def test_the_square_throat_is_that_of_thin_walls(tmp_path):
    """Area, second moment and largest shear of four lines of 30 mm, summed over 4000 pieces."""
    scope = throat(tmp_path, TOGGLE)
    n = 1000
    t = (np.arange(n) + 0.5) / n
    half, side = 15.0 * np.ones(n), 30.0 * t - 15.0
    top = np.column_stack([half, np.abs(side)])
    rows = [
        top[n // 2 :],  # from the middle of the top
        np.column_stack([-side, half]),
        np.column_stack([-half, -side]),
        np.column_stack([side, -half]),
        top[: n // 2],
    ]
    points = np.concatenate(rows)
    lengths = np.full(len(points), 30.0 / n)
    assert_allclose(scope["A"], 2.0 * lengths.sum(), rtol=1e-9)
    assert_allclose(scope["I_z"], 2.0 * (points[:, 0] ** 2 * lengths).sum(), rtol=1e-5)
    assert_allclose(scope["q_V"], shear_flow(points, lengths, 2.0), rtol=1e-3)
    assert_allclose(scope["q_T"], 1.0 / (2 * 30.0**2 * 2.0), rtol=1e-12)  # Bredt
    walls = throat(tmp_path, TOGGLE, weld._walls)  # 3 mm thick, 27 mm between their middles
    assert_allclose(walls["q_V"], shear_flow(0.9 * points, 0.9 * lengths, 3.0), rtol=1e-3)
    assert_allclose(walls["q_T"], 1.0 / (2 * 27.0**2 * 3.0), rtol=1e-12)


def test_the_round_throat_is_that_of_thin_walls(tmp_path):
    scope = throat(tmp_path, ROD + TUBE)
    angle = 2 * pi * (np.arange(4000) + 0.5) / 4000
    points = 10.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    lengths = np.full(4000, 2 * pi * 10.0 / 4000)
    assert_allclose(scope["A"], 2.0 * lengths.sum(), rtol=1e-9)
    assert_allclose(scope["I_z"], 2.0 * (points[:, 0] ** 2 * lengths).sum(), rtol=1e-9)
    assert_allclose(scope["q_V"], shear_flow(points, lengths, 2.0), rtol=1e-3)
    assert_allclose(scope["q_T"], 1.0 / (2 * pi * 10.0**2 * 2.0), rtol=1e-12)
    walls = throat(tmp_path, ROD + TUBE, weld._walls)
    assert_allclose(walls["q_T"], 10.0 / (pi / 32 * (20.0**4 - 15.0**4)), rtol=1e-12)
    assert_allclose(walls["q_V"], 2.0 / ROUND, rtol=1e-12)


def test_a_torque_is_counted_on_the_side_where_it_adds(tmp_path):
    """T = 1 N m with V = 200 N; a flat bar by its torsion modulus, both signs alike."""
    design = flat(tmp_path)
    modulus = float(rectangle_torsion(30.0, 8.0)[1])
    found = []
    for torque in (1000.0, -1000.0):
        rows = {
            "first": [(0, 0, 0), (0, -200.0, -200.0 * LENGTH)],
            "second": [(0, 0, 0), (0, 200.0, 0)],
        }
        loads = loads_of(rows)
        loads.wrenches["first"][1, 3], loads.wrenches["second"][1, 3] = -torque, torque
        part = design.parts["rod"]
        toe = next(weld.checks(LoadedPart(design, part, loads)))
        found.append(toe.derivation.number("T_r"))
    assert_allclose(found, 1.5 * 200.0 / 240.0 + 1000.0 / modulus, rtol=1e-9)


def test_ranges_between_positions_widen_the_bar(tmp_path):
    """A sine with peaks between 6 positions: the range that they miss is in the bar, doubled."""
    design = flat(tmp_path)
    n, part = 6, flat(tmp_path).parts["rod"]
    path = np.linspace(0.0, 2 * pi, n)
    force = 5000.0 * np.sin(path)
    rows = {"first": [(-f, 0, 0) for f in force], "second": [(f, 0, 0) for f in force]}
    loads = replace(loads_of(rows), path=path)
    found = by_formula._sampled(weld, LoadedPart(design, part, loads))
    toe = found[0]
    missed = 1.0 / np.sin(2 * pi / 5) - 1.0  # 5 %
    assert missed < toe.numerical / toe.value < 3 * missed


def test_a_part_without_welds_has_no_check(tmp_path):
    design = machine(tmp_path, PLATE)
    loaded = LoadedPart(
        design, design.parts["rod"], loads_of({"first": [(1, 0, 0)], "second": [(-1, 0, 0)]})
    )
    assert [*weld.checks(loaded), *weld.not_checked(loaded)] == []


def test_categories_as_the_tables_have_them():
    """UNI EN 1993-1-9:2005, pages 23 to 27; table 8.5, detail 1, over l and t."""
    for name, outline, wall, length, category in (
        ("tube on plate by fillet", "round", 8.0, None, 40.0),
        ("tube on plate by fillet", "rectangular", 3.0, None, 36.0),
        ("tube on plate by butt", "round", 12.5, None, 50.0),
        ("tube on plate by butt", "rectangular", 3.0, None, 45.0),
        ("tube end to end by butt", "round", 3.0, None, 71.0),
        ("tube end to end by butt", "rectangular", 3.0, None, 56.0),
        ("tube in socket by fillet", "round", 20.0, None, 40.0),
        ("attachment on tube", "rectangular", 3.0, 100.0, 71.0),
        ("attachment along bar", "flat", 8.0, 50.0, 80.0),
        ("attachment along bar", "flat", 8.0, 101.0, 56.0),
        ("attachment across bar", "flat", 8.0, 80.0, 71.0),
        ("bar end to end from one side", "flat", 40.0, None, 36.0),
        ("bar end to end from one side tested", "flat", 25.0, None, 71.0),
        ("bar end to end from one side tested", "flat", 50.0, None, 71.0 * 0.5**0.2),
        ("attachment on tube", "round", 3.0, 101.0, 56.0),
        ("attachment across bar", "I", 8.0, 50.0, 80.0),
        ("attachment along bar", "I", 8.0, 100.0, 63.0),
        ("attachment on edge", "flat", 8.0, None, 40.0),
        ("attachment on edge", "I", 8.0, None, 40.0),
        ("stiffener from flange to flange", "I", 8.0, 51.0, 71.0),
        ("end to end by butt from both sides", "I", 40.0, None, 63.0),
        ("end to end by butt from both sides tested", "I", 25.0, None, 80.0),
        ("end to end by butt from both sides tested", "flat", 50.0, None, 80.0 * 0.5**0.2),
    ):
        assert_allclose(category_of(name, outline, wall, length)[0], category, rtol=1e-12)
    for length, wall, category in (
        (40, 10, 80), (50, 10, 71), (60, 10, 71), (90, 10, 63), (110, 10, 56), (150, 15, 56), (150, 25, 50),
        (250, 25, 50), (250, 40, 45), (400, 40, 45), (400, 60, 40), (150, 40, 50), (250, 60, 45),
    ):  # fmt: skip
        for name in ("bar on plate by fillet", "bar on plate penetrated"):
            assert category_of(name, "flat", wall, length)[0] == category


def test_rows_cover_each_wall_once():
    for row in ROWS:
        others = [one for one in ROWS if (one.name, one.outline) == (row.name, row.outline)]
        assert not any(
            one is not row and max(one.walls[0], row.walls[0]) < min(one.walls[1], row.walls[1])
            for one in others
        )
        lengths = [most for most, _ in row.by_length]
        assert lengths == sorted(lengths)


@pytest.mark.parametrize(
    ("welds", "wording"),
    [
        ('at = "3 mm", detail = "bar on plate penetrated", length = "9 mm"', r"welds\[0\]\.at: at 3 mm the stress is not that of even walls; it is from 37\.5 to 123\.5 mm"),
        ('at = "40 mm", detail = "bar on plate by fillet", throat = "9 mm", length = "9 mm"', r"welds\[0\]\.throat: 9 mm is more than the wall of 8 mm; it must be at most 8 mm"),
        ('at = "40 mm", detail = "bar on plate by filet", throat = "3 mm"', r"welds\[0\]\.detail: must be .* got \"bar on plate by filet\", did you mean bar on plate by fillet\?"),
        ('at = "40 mm", detail = "tube on plate by fillet", throat = "3 mm"', r"has it for no flat bar, .* there are attachment across bar; .*bar on plate by fillet"),
        ('at = "40 mm", detail = "bar on plate by fillet", length = "9 mm"', r"welds\[0\]\.throat: must be stated"),
        ('at = "40 mm", detail = "bar on plate penetrated", throat = "3 mm", length = "9 mm"', r"throat: 'bar on plate penetrated' has no root that carries load"),
        ('at = "40 mm", detail = "bar on plate penetrated"', r"detail: .* table 8.5, detail 1, depends on l of the table's drawing: state length"),
        ('at = "40 mm", detail = "attachment across bar", length = "90 mm"', r"table 8.4, detail 6, is for l up to 80 mm, got 90 mm"),
        ('at = "40 mm", detail = "bar end to end from one side", length = "9 mm"', r"asks for no length"),
        ('at = "40 mm"', r"welds\[0\]\.detail: needs either detail or category"),
        ('at = "40 mm", category = "170 MPa"', r"welds\[0\]\.category: 170 MPa is above 160 MPa"),
        ('at = "40 mm", category = "36 MPa", partial_factor = 0.9', r"partial_factor: must be at least 1"),
        ('at = "40 mm", category = "36 MPa" }, { at = "4 cm", category = "36 MPa"', r"welds\[1\]\.at: another weld of the part stands at 40 mm"),
        ('at = "40 mm", category = "36 MPa" }, { at = "40.0000001 mm", category = "36 MPa"', r"welds\[1\]\.at: another weld of the part stands at 40 mm"),
    ],
)  # fmt: skip
def test_refusals(tmp_path, welds, wording):
    with pytest.raises(DesignError, match=wording):
        flat(tmp_path, welds=f"welds = [{{ {welds} }}]")


def test_a_link_whose_holes_are_near_has_no_walls(tmp_path):
    with pytest.raises(DesignError, match=r"no stretch with even walls, away from holes"):
        flat(tmp_path, 'parts.rod.width="70 mm"')


def test_walls_that_no_table_has_are_refused(tmp_path):
    with pytest.raises(DesignError, match=r"is for walls up to 8 mm, the part has 9 mm there; for "
                       r"such a wall there are attachment on tube; tube end to end by butt"):  # fmt: skip
        machine(tmp_path, ROD + TUBE, 'parts.rod.wall="9 mm"')


def test_details_of_tubes_are_none_of_solid_rods(tmp_path):
    with pytest.raises(DesignError, match=r"the part is a solid rod there; state a category"):
        machine(tmp_path, ROD.replace('wall = "2.5 mm"\n', "") + TUBE)


def test_only_steel_is_judged(tmp_path):
    with pytest.raises(
        DesignError,
        match=r"parts\.rod\.welds: welds are judged by EN 1993-1-9:2005, which is of steel",
    ):
        flat(tmp_path, 'parts.rod.material="6082-T6"')


def test_a_shape_without_walls_is_refused(tmp_path):
    told = (
        r"welds\[0\]\.at: no weld is judged on this shape, "
        r"but on i_beam, plate_link, prismatic_tube, rhs_beam, toggle_bar, tube_rod, levers and "
        r"drawn plates"
    )
    with pytest.raises(DesignError, match=told):
        lever(tmp_path, 'welds = [{ at = "40 mm", category = "36 MPa" }]')


def test_a_stated_category_has_no_table(tmp_path):
    design = flat(tmp_path, welds='welds = [{ at = "40 mm", category = "63 MPa" }]')
    found = pulled(design, [0.0, 4800.0])
    assert list(found) == ["toe"]
    assert_allclose(found["toe"].safety, AT_KNEE * 63.0 / 20.0, rtol=1e-9)
    assert "stated in the design" in found["toe"].basis


def test_json_page_and_why_show_welds(tmp_path, capsys):
    flat(tmp_path)
    path, out = tmp_path / "machine.toml", str(tmp_path / "out")
    main(["check", str(path), "--fidelity", "formula", "--json", "--out", out])
    result = json.loads(capsys.readouterr().out)[0]
    (rod,) = result["parts"]
    shown = {one["quantity"]: one for one in rod["checks"] if one["kind"] == "weld"}
    at = "at 40 mm"
    assert set(shown) == {f"fatigue of the toe {at}", f"fatigue of the root {at}", f"throat {at}"}
    assert any("welds that no part states" in text for text in result["not_checked"])
    assert any("welds by nominal stress" in text for text in rod["assumed"])
    page = (tmp_path / "out" / "machine" / "report.html").read_text()
    assert "root at 40 mm" in page
    main(["why", f"{out}/machine", "rod", "root at"])
    said = " ".join(capsys.readouterr().out.split())
    assert "table 8.5" in said
    assert "D = (n·S/S_D)³ + (n·T_r/T_L)⁵" in said


def test_a_thicker_throat_is_a_way_out(tmp_path):
    """A push of 5 kN on half of the turn: 28 to 31 MPa in the throat of 3 mm, 26.5 over 1.35 allowed."""
    flat(tmp_path)
    path = tmp_path / "machine.toml"
    whole = 'name = "round", to = "450 deg", forces = { push = "400 N" }, solve = "drive"'
    halves = (
        'name = "out", to = "270 deg", forces = { push = "5 kN" }, solve = "drive" }, '
        '{ name = "back", to = "450 deg", forces = { push = "0 N" }, solve = "drive"'
    )
    text = path.read_text()
    assert whole in text
    path.write_text(text.replace(whole, halves).replace("positions = 25\n", ""))
    found = improve(path, effort=Effort("formula"))
    change = next(one for one in found.changes if one.key == "parts.rod.welds[0].throat")
    throat = float(change.value.split()[0])
    assert 3.0 * 1.35 * 5000 / 180 / (AT_KNEE * 36.0) < throat < 6.0
    again = check_file(path, [change.override], effort=Effort("formula"))
    assert all(str(one.status) == "pass" for one in again.checks if one.kind == "weld")


@pytest.mark.parametrize("life", ["infinite", "finite"])
def test_the_page_follows_no_other_runs_of_a_weld(tmp_path, life):
    """Other runs of a finite life are sought by a check alone; of an endless one they are nothing."""
    flat(tmp_path)
    path = tmp_path / "machine.toml"
    result = check_file(path, [f'duty.life="{life}"'], effort=Effort("formula"))
    data = json.loads(what_if(result))
    (root,) = [one for one in data["checks"] if "fatigue of the root" in one["name"]]
    followed = [data["levers"][k]["sets"][0] for k in root["levers"]]
    assert ["duty.cycles.turn" in one for one in followed] == ([True] if life == "finite" else [])
    assert sum(one is not None for one in root["safety"]) == 1
    assert root["fixed"]
    assert root["load"] == 1.0
