"""Halves of parts: chosen where shape and loads allow it, and as good as the whole."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.commands.plan import plan
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from checks.ladder.solid import check_solid
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from checks.stress.solid_mesh_level import DISPLACEMENT, STRESS, Models, half_of
from fem.recovery import tensor, von_mises
from geometry.shape import Half

from ...small_machine import PLATE, machine

PRESS = Path(__file__).parents[3] / "designs" / "toggle_press.toml"
COARSE = ["parts.bar_upper.mesh.fineness=0.4", "cycles.press.positions=31"]
UNDECIDED = "require.buckling=45"  # the first mesh has a factor of 47, and a bar of a quarter


def checked(*overrides):
    design = read_design(PRESS, [*COARSE, *overrides])
    models = Models()
    part = design.parts["bar_upper"]
    loads = loads_on(design, part, solve_cycles(design, part_masses(design, models)))
    return check_solid(LoadedPart(design, part, loads), models)


def solved(folder):
    design = machine(folder, PLATE, "parts.rod.thickness=20 mm")
    part = design.parts["rod"]
    loads = loads_on(design, part, solve_cycles(design, {}))
    return check_solid(LoadedPart(design, part, loads), Models())


@pytest.fixture(scope="module")
def half(tmp_path_factory):
    """A rod of one plate; the bars of the press are halved in its regression test."""
    return solved(tmp_path_factory.mktemp("half"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("checks.ladder.levels.half_of", lambda part, loads: None)
        return solved(tmp_path_factory.mktemp("whole"))


def check_of(result, kind, words=""):
    [found] = [c for c in result.checks if c.kind == kind and words in c.quantity]
    return found


def rod_and_loads(tmp_path, *overrides):
    design = machine(tmp_path, PLATE, *overrides)
    part = design.parts["rod"]
    return part, loads_on(design, part, solve_cycles(design, {}))


@pytest.mark.slow
def test_the_finer_meshes_of_the_rod_are_halves_with_fewer_unknowns(half, whole):
    assert [mesh["body"] for mesh in half.meshes] == ["whole", *["half"] * (len(half.meshes) - 1)]
    assert {mesh["body"] for mesh in whole.meshes} == {"whole"}
    assert half.meshes[0]["peak"] == whole.meshes[0]["peak"]
    # 0.59 to 0.72 of them for plates of 18 to 28 mm: each refines where its own first mesh says
    assert half.meshes[1]["unknowns"] < 0.75 * whole.meshes[1]["unknowns"]


@pytest.mark.slow
def test_half_of_the_rod_has_the_peaks_of_the_whole_within_the_bars(half, whole):
    for kind in ("static", "fatigue"):
        one, other = check_of(half, kind), check_of(whole, kind)
        assert abs(one.value - other.value) <= np.hypot(one.numerical, other.numerical)
        assert one.numerical < 2 * other.numerical + 1e-3 * one.value


@pytest.mark.slow
def test_the_arc_of_contact_tells_a_half_what_it_tells_the_whole(half, whole):
    one, other = check_of(half, "static"), check_of(whole, "static")
    assert_allclose(one.below, other.below, rtol=0.1, atol=0.005 * one.value)


@pytest.mark.slow
def test_buckling_is_asked_of_the_whole_rod(half, whole):
    one, other = (check_of(r, "buckling", "elastic") for r in (half, whole))
    assert (one.value, one.numerical, one.place) == (other.value, other.numerical, other.place)


@pytest.mark.slow
def test_buckling_that_one_mesh_leaves_open_is_asked_of_a_finer_whole():
    found = check_of(checked(UNDECIDED), "buckling", "elastic")
    assert found.method == "solid (two meshes)"
    assert 0 < found.numerical < 0.1 * found.value


def test_mass_and_gates_of_a_half_are_those_of_the_whole(half, whole):
    for name in ("mass [kg]", "inertia about the centre [kg m2]"):
        assert_allclose(half.facts[name], whole.facts[name], rtol=1e-3)
    assert_allclose(half.facts["centre of mass x [mm]"], whole.facts["centre of mass x [mm]"], 1e-3)
    assert [gate.name for gate in half.gates] == [gate.name for gate in whole.gates]
    assert all(gate.holds for gate in half.gates)
    loads = [g.value for g in half.gates if g.name.endswith(("on the mesh", "reactions"))]
    assert max(loads) < 1e-7


def test_the_result_says_that_half_was_solved(half, whole):
    said = "half of the part, mirrored at its middle plane: its loads have no part out of it"
    assert any(text.startswith(said) for text in half.assumed)
    assert not any("half of the part" in text for text in whole.assumed)


def test_a_half_shows_the_surface_of_the_whole(half, whole):
    """The triangles enclose the bar's volume, seen from outside; facets split in four: 1 %."""
    enclosed = []
    for surface in (half.surface, whole.surface):
        a, b, c = np.moveaxis(np.asarray(surface.nodes)[surface.triangles], 1, 0)
        enclosed.append(np.einsum("nx,nx->", a, np.cross(b, c)) / 6)
        assert all(len(values) == len(surface.nodes) for values in surface.fields.values())
    assert_allclose(*enclosed, rtol=0.01)
    nodes = np.asarray(half.surface.nodes)
    assert_allclose(nodes[:, 2].min(), -nodes[:, 2].max())
    assert len(np.unique(np.round(nodes, 7), axis=0)) == len(nodes)


def test_the_mirror_image_moves_the_other_way_along_z(half):
    """Shear stress with one z turns its sign, too, and mirrored stress is as severe."""
    nodes, surface = np.asarray(half.surface.nodes), half.surface
    count = (len(nodes) + (nodes[:, 2] == 0).sum()) // 2
    beside = np.flatnonzero(nodes[:count, 2] > 0)
    assert_allclose(nodes[count:], nodes[beside] * [1, 1, -1])
    for values in surface.fields.values():
        assert_allclose(values[count:], values[beside])
    moved, stress = surface.directed[DISPLACEMENT], surface.directed[STRESS]
    assert_allclose(moved[count:], moved[beside] * [1, 1, -1])
    assert np.abs(moved[:, 2]).max() > 0
    mirror = np.diag([1, 1, -1])
    assert_allclose(tensor(stress[count:]), mirror @ tensor(stress[beside]) @ mirror)
    assert_allclose(von_mises(stress), surface.fields["von Mises [MPa]"])


def test_a_plate_in_the_plane_of_its_loads_is_halved(tmp_path):
    part, loads = rod_and_loads(tmp_path)
    assert half_of(part, loads) == Half(part.geometry)


def test_a_plate_beside_its_loads_is_not_halved(tmp_path):
    part, loads = rod_and_loads(tmp_path, 'parts.rod.offsets={second="7 mm"}')
    assert np.abs(loads.wrenches["second"][:, 3:5]).max() > 100
    assert half_of(part, loads) is None


@pytest.mark.parametrize("component", [2, 3, 4])
def test_one_load_out_of_the_plane_at_one_position_keeps_the_whole(tmp_path, component):
    part, loads = rod_and_loads(tmp_path)
    arm = 1.0 if component == 2 else part.geometry.length
    for size, halved in ((1e-14, True), (1e-11, False)):
        wrenches = {name: wrench.copy() for name, wrench in loads.wrenches.items()}
        wrenches["second"][7, component] = size * loads.largest_force * arm
        assert (half_of(part, replace(loads, wrenches=wrenches)) is not None) is halved


def test_a_pin_is_not_halved():
    design = read_design(PRESS, COARSE)
    part = design.parts["pin_B"]
    masses = part_masses(design, Models())
    assert half_of(part, loads_on(design, part, solve_cycles(design, masses))) is None


def test_the_plan_counts_the_unknowns_of_halves():
    planned = {entry.part.name: entry for entry in plan(read_design(PRESS, COARSE))}
    assert (planned["bar_upper"].halved, planned["pin_B"].halved) == (True, False)
    first, second = planned["bar_upper"].unknowns
    assert second < first
    first, second = planned["pin_B"].unknowns
    assert second > 1.5 * first


def test_a_half_is_kept_as_long_as_its_shape(tmp_path):
    part, _ = rod_and_loads(tmp_path)
    models = Models()
    mesh = models.mesh(Half(part.geometry), 0.4)
    models.keep_only({part.geometry})
    assert models.mesh(Half(part.geometry), 0.4) is mesh
    models.keep_only(set())
    assert models.mesh(Half(part.geometry), 0.4) is not mesh
