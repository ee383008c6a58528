"""A leaf pack with friction between its leaves, and its hand checks."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.elastic_parts import compliances_of
from ballesta.machine.solved_cycles import solve_cycles
from checks.design.materials import known_materials
from checks.ladder import leaf_checks, leaf_friction
from checks.ladder.leaf_checks import gap_gate, with_leaf_checks
from checks.ladder.leaf_friction import rubbed
from checks.models.bands import SHARE, known_band, proportions_of
from checks.models.checked import rung_level
from checks.models.shapes import leaf_pack
from checks.part.loaded_part import FIRST, LoadedPart
from checks.part.part_loads import PartLoads, loads_on
from checks.result.verdict import Check, PartResult
from checks.strength.part_strength import elastic_of, endurance_of
from checks.stress.solid_mesh_level import Models, solve_level
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.meshing import mesh_shape
from geometry.parts import LeafPack
from loads import at_rows, moments_of_blows, run_at_positions

# a rocker that is pushed up at C, so that its other end presses the ram down; weightless
ROCKER = """
name = "Rocker"
gravity = "0, 0 m/s2"
ground = ["R"]
[points]
R = "0, 0 mm"
C = "160, 0 mm"
D = "-150, 0 mm"
[bodies.rocker]
pins = ["R", "C"]
mass = "1e-6 kg"
inertia = "1e-9 kg m2"
centre = "0, 0 mm"
ELASTIC
[bodies.ram]
pins = ["D"]
mass = "1e-6 kg"
guide = { along = "0, 1" }
[joints.slot]
kind = "slot"
on = "rocker"
through = "R"
along = "-1, 0"
body = "ram"
point = "D"
[forces.push]
body = "rocker"
at = "C"
direction = "0, 1"
[forces.workpiece]
body = "ram"
at = "D"
direction = "0, 1"
[cycles.press]
coordinate = "rocker.angle"
start = "0 deg"
pace = { coordinate = "rocker.angle", speed = "0.01 rad/s" }
positions = 9
phases = [{ name = "down", to = "1 deg", forces = { workpiece = LAW }, solve = "push" }]
[duty]
cycles = { press = 1e6 }
[parts.leaves]
body = "rocker"
shape = "leaf_pack"
interfaces = { pivot = "R", rod = "C", contact = "slot" }
material = "S275"
leaves = 3
width = "30 mm"
thickness = "6 mm"
arm = "170 mm"
overhang = "15 mm"
clamp_length = "30 mm"
rod_length = "20 mm"
contact_from = "145 mm"
contact_to = "155 mm"
contact_length = "10 mm"
mesh = { fineness = 0.5 }
"""
TOUCHES = '{ touches = "D.y", at = "-0.5 mm" }'


@pytest.fixture(scope="module")
def models():
    return Models()


def rocker(folder, models, law, elastic="", text=ROCKER):
    """Design, part, solved cycles and loads of the pack."""
    path = folder / "rocker.toml"
    path.write_text(text.replace("LAW", law).replace("ELASTIC", elastic), encoding="utf-8")
    design = read_design(path)
    cycles = solve_cycles(design, {}, compliances_of(design, models))
    part = design.parts["leaves"]
    return design, part, cycles, loads_on(design, part, cycles)


def level_of(part, loads, models):
    fineness = FIRST * part.fineness
    solutions = models.solutions(part.geometry, fineness, elastic_of(part))
    material = part.material
    return solve_level(
        solutions, fineness, loads, endurance_of(part).value, material.ultimate_stress, {}
    )


def found(kind, value=100.0):
    """A check of the solid, with a model band of its own."""
    return Check(
        "leaves", kind, "a stress", value, "MPa", 1.0, 2.0, 275.0, 1.5, "press", "", "", "solid",
        "", model_below=3.0,
    )  # fmt: skip


def widened(case, models):
    """The checks of a pack with their bands widened, by kind, and its result."""
    design, part, cycles, loads = case
    checks = [found("static"), found("fatigue"), found("buckling")]
    result = PartResult("leaves", "leaf_pack", "S275", checks, (), (), (), {}, {}, None)
    after = with_leaf_checks(LoadedPart(design, part, loads, cycles), result, models)
    return {check.kind: check for check in after.checks}, after


def test_a_pin_that_rubs_in_the_clamp_of_leaves_presses_no_bore_of_theirs(tmp_path, models):
    rubs = '[friction.pins]\ncoefficient = 0.1\ndiameter = "20 mm"\n'
    text = ROCKER.replace("[joints", rubs + "[joints")
    *_, loads = rocker(tmp_path, models, '"500 N"', text=text)
    assert np.abs(loads.wrenches["pivot"][:, 5]).max() > 0.0
    assert loads.rubs == (0.0, 0.0)


UNPRESSED = 'clamp_preload = "0 N"\nrod_preload = "0 N"\n'


def test_under_imposed_forces_friction_relieves_by_what_presses_the_leaves(tmp_path, models):
    """By hand: mu F t of the tip's couple, and as much of half the clamp's reaction of 1.94 F, on
    F x 150 mm: 0.8 % at 0.1 and 2.4 % at 0.3, on the outer leaf less by its axial force.
    """
    case = rocker(tmp_path, models, '"500 N"', text=ROCKER + UNPRESSED)
    checks, after = widened(case, models)
    for kind in ("static", "fatigue"):
        assert_allclose(checks[kind].model, 2.0)
        assert 1.0 < checks[kind].below - 3.0 < 2.4
        assert "friction 0.3, 0 kN on the clamp" in checks[kind].note
    assert checks["buckling"] == found("buckling")
    gates = {gate.name: gate for gate in after.gates}
    assert gates["leaves: contact between leaves"].holds
    assert "largest contact force" not in " ".join(after.facts)


@pytest.mark.parametrize("elastic", ['{ bending = "340 N m2" }', '{ stiffness = "fem" }'])
def test_under_an_imposed_deflection_friction_needs_more_force(tmp_path, models, elastic):
    """Friction stiffens by 1.5 mu t/L of either arm, here 0.6 % at 0.1 and 1.8 % at 0.3.

    Its couples take nearly as much off the moment again, so that stress stays within 1 %.
    """
    case = rocker(tmp_path, models, TOUCHES, f"elastic = {elastic}", ROCKER + UNPRESSED)
    checks, after = widened(case, models)
    for kind in ("static", "fatigue"):
        assert 0 <= checks[kind].model - 2.0 < 1.0
        assert 0 <= checks[kind].below - 3.0 < 1.0
    (told,) = (text for key, text in after.facts.items() if "contact force" in key)
    sliding, *rubbing = (float(part.split()[-1]) for part in told.split(";")[:3])
    ratios = np.array(rubbing) / sliding - 1
    assert 0.002 < ratios[0] < ratios[1] < 0.04


def test_a_pack_whose_preloads_are_not_stated_may_slip_or_not(tmp_path, models):
    """Held without slip in clamp and bracket it is stiffer, and its imposed stress larger."""
    case = rocker(tmp_path, models, TOUCHES, 'elastic = { bending = "340 N m2" }')
    checks, _ = widened(case, models)
    assert checks["static"].model > 2.0 + 20.0
    assert "a clamp without slip, a bracket without slip" in checks["static"].note


def test_friction_that_cannot_be_solved_leaves_the_band_open(tmp_path, models, monkeypatch):
    case = rocker(tmp_path, models, TOUCHES, 'elastic = { bending = "340 N m2" }')

    def refused(*_):
        raise leaf_friction.loads.LinkageError("it does not close")

    monkeypatch.setattr(leaf_friction.loads, "run_at_positions", refused)
    checks, _ = widened(case, models)
    assert np.isinf(checks["static"].model)
    assert checks["static"].status == "UNDECIDED"
    assert "cannot be solved: it does not close" in checks["static"].note


def test_friction_is_kept_for_one_loaded_part_and_solved_anew_for_any_other(tmp_path, models):
    """Whatever changes is another loaded part: the answer cannot depend on what is not in it.

    Each change here moves the ratios; a part that is equal in all has equal ones, solved again.
    """
    elastic = 'elastic = { bending = "340 N m2" }'
    design, part, cycles, loads = rocker(tmp_path, models, TOUCHES, elastic)
    loaded = LoadedPart(design, part, loads, cycles)
    first = rubbed(loaded)
    assert rubbed(loaded) is first
    again = rubbed(replace(loaded))
    assert again is not first
    assert again == first
    weaker = replace(part.material, youngs_modulus=0.9 * part.material.youngs_modulus)
    once = replace(design, load_factor=1.5)
    stiffer = rocker(tmp_path, models, TOUCHES, 'elastic = { bending = "400 N m2" }')
    changes = [
        {"part": replace(part, geometry=replace(part.geometry, thickness=7.0))},
        {"part": replace(part, geometry=replace(part.geometry, clamp_factor=1.8))},
        {"part": replace(part, geometry=replace(part.geometry, clamp_preload=5e3))},
        {"part": replace(part, material=weaker)},
        {"loads": loads_on(once, part, cycles), "design": once},
        {"runs": stiffer[2], "loads": stiffer[3]},
    ]
    found = [rubbed(replace(loaded, **change)) for change in changes]
    assert all(one != first for one in found)


def test_a_cycle_is_run_again_at_its_positions(tmp_path, models):
    """The same linkage has the same loads; one that gives way half as much, twice the force."""
    elastic = 'elastic = { bending = "340 N m2" }'
    design, _, cycles, _ = rocker(tmp_path, models, TOUCHES, elastic)
    known, cycle = cycles["press"], design.cycles["press"].run
    again = run_at_positions(known, known.linkage, cycle)
    assert_allclose(again.efforts["workpiece"], known.efforts["workpiece"], rtol=1e-12)
    (beam,) = known.linkage.compliance
    stiffer = replace(known.linkage, compliance=(replace(beam, bending=2 * beam.bending),))
    twice = run_at_positions(known, stiffer, cycle)
    assert_allclose(twice.efforts["workpiece"], 2 * known.efforts["workpiece"], rtol=1e-9)
    assert (twice.positions == known.positions).all()


def test_moments_of_a_blow_are_loads_that_are_given(tmp_path, models):
    """No deflection imposes the force of a blow, nor does it tell how the linkage gives way."""
    elastic = 'elastic = { bending = "340 N m2" }'
    design, part, cycles, _ = rocker(tmp_path, models, TOUCHES, elastic)
    known = cycles["press"]
    rows = np.array([0, 1, 2, 3, 4, 4, 4, 4, 5, 6, 7, 8])
    moments = np.isin(np.arange(12), [5, 6, 7])
    times = known.times[rows] + 1e-3 * np.array([0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0])
    struck = replace(at_rows(known, rows), times=times, moments=moments)
    efforts = {**struck.efforts, "workpiece": struck.efforts["workpiece"] * (1 + 50 * moments)}
    struck = replace(struck, efforts=efforts)
    assert (moments_of_blows(at_rows(struck, rows)) == moments[rows]).all()
    assert not moments_of_blows(known).any()
    plain, whole = (
        LoadedPart(design, part, loads_on(design, part, runs), runs)
        for runs in ({"press": known}, {"press": struck})
    )
    pack = leaf_friction._Pack(whole)
    in_blow = moments[pack.cycles["press"].at]
    assert in_blow.any()
    assert (pack.cycles["press"].force[in_blow] == 0.0).all()
    assert np.isnan(pack.imposed("press").deflection[in_blow]).all()
    (unit, share), (with_it, its) = (
        leaf_friction._per_force(loaded, "press", "workpiece", at)
        for loaded, at in ((plain, np.arange(5, 9)), (whole, np.arange(8, 12)))
    )
    assert_allclose(its, share, rtol=1e-9)
    for name, wrench in unit.items():
        assert_allclose(with_it[name], wrench, rtol=1e-9, atol=1e-9)


def test_a_single_leaf_needs_no_band(tmp_path, models):
    design, part, cycles, loads = rocker(tmp_path, models, '"500 N"')
    alone = replace(part, geometry=replace(part.geometry, leaves=1))
    result = PartResult("leaves", "", "", [found("static")], (), (), (), {}, {}, None)
    assert with_leaf_checks(LoadedPart(design, alone, loads, cycles), result, models) is result


def test_leaves_under_a_contact_are_pressed_and_hardly_pulled_apart(tmp_path, models):
    case = rocker(tmp_path, models, '"500 N"')
    _, result = widened(case, models)
    gate = next(gate for gate in result.gates if gate.name == "leaves: gaps between leaves")
    assert 0 < gate.value < 0.1 < gate.limit
    assert gate.holds
    assert not gate.binding


@pytest.mark.parametrize(("tension", "holds", "binding"), [(0.2, 1, 0), (0.3, 0, 0), (1.2, 0, 1)])
def test_leaves_that_are_pulled_apart_more_than_pressed_decide_the_verdict(
    tmp_path, models, monkeypatch, tension, holds, binding
):
    _, part, _, loads = rocker(tmp_path, models, '"500 N"')
    monkeypatch.setattr(leaf_checks, "tie_tension", lambda *_, **__: (2 * tension, 2.0))
    gate = gap_gate(part, part.geometry, level_of(part, loads, models))
    assert (gate.holds, gate.binding) == (holds, binding)
    assert_allclose(gate.value, tension)


def leaf_bending(shape, level, place):
    """Half of top less bottom of the stress along x at x = place, by straight lines beside it."""
    points, stress = level.history.points, level.history.at(0)[:, 0]
    near = np.abs(points[:, 0] - place) < shape.thickness
    near &= np.abs(points[:, 2]) < 0.45 * shape.width
    top, sides = shape.leaves * shape.thickness / 2, []
    for y in (-top, top):
        chosen = near & (np.abs(points[:, 1] - y) < 1e-6 * top)
        sides.append(np.polyfit(points[chosen, 0] - place, stress[chosen], 1)[1])
    return abs(sides[1] - sides[0]) / 2


def test_the_leaves_bend_as_a_beam_beside_the_clamp_and_less_in_it(tmp_path, models):
    """500 N x 150 mm on n b t^2 / 6 = 540 mm3: 138.9 MPa; 135 mm at the edge, 125 MPa.

    The clamp's force of 968.75 N, even over 30 mm, takes R L/8 = 3.63 N m off the middle: 132.2
    MPa. A mesh with half the usual fineness is within 1 %.
    """
    _, part, _, loads = rocker(tmp_path, models, '"500 N"')
    level, pivot = level_of(part, loads, models), 500 * (1 + 150 / 160)
    found = [leaf_bending(part.geometry, level, x) for x in (0.0, -15.0, 15.0)]
    expected = [500 * 150 - pivot * 30 / 8, 500 * 135, 500 * 150 / 160 * 145]
    assert_allclose(found, np.array(expected) / 540, rtol=0.01)


def test_a_couple_of_the_rod_bends_the_leaves_with_its_force(tmp_path, models):
    """Against 468.75 N on 145 mm, 68 N m, it turns by 20 N m more or less; 540 mm3 of section."""
    _, part, _, loads = rocker(tmp_path, models, '"500 N"')
    along = np.sign(loads.wrenches["rod"][0, 1])
    for couple in (20e3, -20e3):
        wrenches = {name: wrench.copy() for name, wrench in loads.wrenches.items()}
        wrenches["rod"][:, 5] += couple * along
        wrenches["pivot"][:, 5] -= couple * along
        turned = replace(loads, wrenches=wrenches)
        right = leaf_bending(part.geometry, level_of(part, turned, models), 15.0)
        assert_allclose(right, (500 * 150 / 160 * 145 + couple) / 540, rtol=0.02)


SHARES = {SHARE + name for name in ("pulled", "pushed", "across", "couple over its size")}


@pytest.mark.parametrize("way", ["rod and pivot", "couple at the pivot", "inertia"])
def test_the_formula_of_leaves_holds_however_their_bending_is_balanced(tmp_path, models, way):
    """Statics alone: the contact's force against a rod, a clamp's couple, or their own inertia.

    So shares of loads across it are no proportion of a pack that bends by its own inertia.
    """
    design, part, cycles, loads = rocker(tmp_path, models, '"500 N"')
    wrenches = {name: wrench.copy() for name, wrench in loads.wrenches.items()}
    force, moment = (wrenches["contact"][:, row].copy() for row in (1, 5))
    accelerations = loads.accelerations.copy()
    if way != "rod and pivot":
        wrenches["rod"][:] = 0.0
        wrenches["pivot"][:, 1] = -force
        wrenches["pivot"][:, 5] = -moment
    if way == "inertia":
        wrenches["pivot"][:] = 0.0
        accelerations[:] = 0.0  # balanced by what a rigid acceleration makes up for
    other = replace(loads, wrenches=wrenches, accelerations=accelerations)
    solid = level_of(part, other, models).peak.value
    formula = leaf_pack.stress(part, part.geometry, other)
    level = rung_level(LoadedPart(design, part, other, cycles), formula)
    band = known_band("leaf_pack", "formula", "static")
    assert {name for name in proportions_of(part, other) if name.startswith(SHARE)} == SHARES
    swung = replace(other, own_swing={0.0: np.zeros(len(force))})
    left = {name for name in proportions_of(part, swung) if name.startswith(SHARE)}
    assert left == {SHARE + "pulled", SHARE + "pushed"}
    assert band.low < solid / level.peak.value < band.high


@pytest.mark.slow
def test_the_hammers_leaves_have_60_mpa_at_their_pivot():
    """The brief: 390.53 N at 0.427 m on three leaves of 60 x 9.6 mm, 60.31 MPa less the clamp's."""
    shape = LeafPack(
        length=460, leaves=3, width=60, thickness=9.6, arm=453.5, overhang=26.5, clamp_length=80,
        rod_length=40, contact_from=425, contact_to=448.4, contact_length=10,
    )  # fmt: skip
    force, other = 390.53, 390.53 * 427 / 460
    wrenches = {name: np.zeros((1, 6)) for name in shape.interfaces}
    wrenches["contact"][0, [1, 5]] = -force, force * 427
    wrenches["rod"][0, 1] = -other
    wrenches["pivot"][0, 1] = force + other
    loads = PartLoads(
        wrenches,
        np.zeros((1, 4)),
        {"turn": slice(0, 1)},
        ("k = 0",),
        ("turn",),
        {"contact": np.array([-427.0])},
    )
    steel = known_materials()["S275"]
    elastic = Elastic(steel.youngs_modulus, steel.poisson_ratio, steel.density)
    solutions = solve_unit_loads(mesh_shape(shape, fineness=0.5), elastic)
    level = solve_level(solutions, 0.5, loads, 100.0, steel.ultimate_stress, {})
    relieved = (force * 427 - (force + other) * 80 / 8) / 2764.8
    assert_allclose(leaf_bending(shape, level, 0.0), relieved, rtol=0.01)
    assert_allclose(leaf_bending(shape, level, -40.0), force * 387 / 2764.8, rtol=0.01)


def test_a_pack_that_swings_by_blows_rubs_as_if_slowly(tmp_path, models):
    """The force of a contact as if slowly is what imposes its deflection, no force of a swing."""
    elastic = 'elastic = { bending = "340 N m2" }'
    design, part, cycles, _ = rocker(tmp_path, models, TOUCHES, elastic)
    known = cycles["press"]
    efforts = {**known.efforts, "workpiece": 7 * known.efforts["workpiece"]}
    swung = replace(known, efforts=efforts, swings=True, unstruck=known)
    assert (swung.slowly, known.slowly) == (known, known)
    slow, plain = (
        leaf_friction._Pack(LoadedPart(design, part, loads_on(design, part, runs), runs))
        for runs in ({"press": swung}, {"press": known})
    )
    assert_allclose(slow.cycles["press"].force, plain.cycles["press"].force)
    assert_allclose(slow.cycles["press"].stress, plain.cycles["press"].stress)
