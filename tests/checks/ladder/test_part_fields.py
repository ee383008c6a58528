"""Fields of a part at every position for a page: the solver's fields, of the whole part."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.ladder import part_fields
from checks.ladder.levels import EVERYTHING, first_level
from checks.ladder.part_fields import solid_fields
from checks.ladder.solid import check_solid
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from checks.result.live_fields import von_mises
from checks.strength.part_strength import fatigue_use
from checks.stress.duty_verdict import NodalUse
from checks.stress.solid_mesh_level import DISPLACEMENT, INVERSE_SAFETY, Models
from fem.unit_solutions import rigid_modes

from ...small_machine import PLATE, machine, solved

SINGLE = 1e-5  # of the peak: unit fields are in single precision
LIVE = replace(EVERYTHING, live=True)
HARDER = (
    PLATE
    + """
[cycles.harder]
coordinate = "crank.angle"
start = "90 deg"
pace = { coordinate = "crank.angle", speed = "10 rad/s" }
positions = 25
phases = [{ name = "round", to = "450 deg", forces = { push = "900 N" }, solve = "drive" }]
"""
)


@pytest.fixture(scope="module")
def models():
    """Meshes and factors for all."""
    return Models()


def checked(folder, models, *overrides, text=PLATE):
    """The rod as a solid, on coarse meshes."""
    design = machine(folder, text, 'accuracy="50 %"', *overrides)
    part = design.parts["rod"]
    return check_solid(
        LoadedPart(design, part, loads_on(design, part, solved(design))), models, asked=LIVE
    )


@pytest.fixture(scope="module")
def result(tmp_path_factory, models):
    return checked(tmp_path_factory.mktemp("rod"), models)


def test_the_fields_at_the_peak_are_those_of_the_surface_that_is_drawn(result):
    live, surface = result.live, result.surface
    assert result.meshes[-1]["body"] == "half"
    assert_array_equal(live.nodes, surface.nodes)
    assert_array_equal(live.triangles, surface.triangles)
    stress = live.at(live.peak.cycle, live.peak.position)
    drawn = surface.fields["von Mises [MPa]"]
    assert_allclose(von_mises(stress), drawn, rtol=0, atol=SINGLE * drawn.max())
    assert live.peak.node == surface.peak
    assert von_mises(stress)[live.peak.node] == pytest.approx(live.peak.value, rel=SINGLE)
    assert_allclose(live.fatigue["utilisation"], surface.fields[INVERSE_SAFETY], rtol=1e-6)


def test_displacements_differ_from_the_solvers_by_a_rigid_motion_alone(result):
    live, surface = result.live, result.surface
    shown = live.moved(live.peak.cycle, live.peak.position)
    whole = surface.directed[DISPLACEMENT]
    modes = rigid_modes(live.nodes)
    apart = (whole - shown).ravel()
    share, *_ = np.linalg.lstsq(modes, apart, rcond=None)
    size = np.abs(whole).max()
    assert np.abs(apart - modes @ share).max() < SINGLE * size
    assert np.abs(modes.T @ shown.ravel() / len(modes)).max() < 1e-3 * size  # none is left
    assert np.linalg.norm(shown, axis=1).max() < np.linalg.norm(whole, axis=1).max()


def test_the_image_of_a_half_is_its_mirror_image(result):
    """What acts on a facet of the surface is mirrored with it, along z as along x and y."""
    live = result.live
    stress = live.at(live.peak.cycle, live.peak.position)
    tensor = stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    place = {tuple(np.round(node, 6) + 0.0): k for k, node in enumerate(live.nodes)}
    image = np.array([place[tuple(np.round(node * [1, 1, -1], 6) + 0.0)] for node in live.nodes])
    direction = np.array([0.3, -0.5, 0.8])
    there = tensor @ direction
    here = tensor[image] @ (direction * [1, 1, -1])
    assert_allclose(here, there * [1, 1, -1], rtol=0, atol=1e-9 * np.abs(there).max())
    assert np.abs(there[:, 2]).max() > 0.01 * np.abs(there).max()
    corner = live.nodes[live.triangles]
    volume = np.einsum("ti,ti->t", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])).sum() / 6
    assert volume > 0  # every triangle faces outwards, or the half would take the other away
    assert volume == pytest.approx(8 * (30 * 160 + np.pi * 15**2 - 2 * np.pi * 6**2), rel=0.03)


def test_peaks_of_every_position_are_the_solvers(result):
    live = result.live
    for name, peaks in live.peaks.items():
        assert_allclose(peaks, result.charts["peaks"][name], rtol=1e-9)
        shown = [von_mises(live.at(name, k)).max() for k in range(0, len(peaks), 6)]
        assert_allclose(shown, peaks[::6], rtol=0, atol=SINGLE * peaks.max())


def test_amplitude_and_mean_give_the_utilisation(result, tmp_path):
    """Goodman: amplitude over the endurance limit and mean over the ultimate strength."""
    fatigue = result.live.fatigue
    limit = result.facts["endurance limit [MPa]"]
    ultimate = machine(tmp_path, PLATE).parts["rod"].material.ultimate_stress
    goodman = fatigue["amplitude"] / limit + fatigue["mean"] / ultimate
    assert (fatigue["utilisation"] > goodman * (1 - 1e-5)).all()
    assert np.median(fatigue["utilisation"] / goodman) == pytest.approx(1.0, rel=1e-5)


def test_the_utilisation_times_the_required_safety_is_that_of_the_check(result):
    (check,) = (check for check in result.checks if check.kind == "fatigue")
    assert check.required > 1.1
    used = check.required * result.live.fatigue["utilisation"].max()
    assert used == pytest.approx(check.utilisation, rel=1e-6)
    assert result.live.judged


def test_the_fkm_chain_gives_its_own_utilisation_at_every_node(tmp_path, models):
    result = checked(tmp_path, models, "parts.rod.strength=fkm", "parts.rod.roughness=25 um")
    (check,) = (check for check in result.checks if check.kind == "fatigue")
    used = result.live.fatigue["utilisation"]
    assert used.max() == pytest.approx(check.value / check.limit, rel=1e-5)


@pytest.mark.parametrize("strength", ["marin", "fkm"])
def test_of_several_cycles_the_peak_is_told_in_its_own_and_each_node_has_its_worst_use(
    tmp_path, models, strength
):
    overrides = [f"parts.rod.strength={strength}", "duty.cycles={turn=1e6, harder=1e3}"]
    result = checked(tmp_path, models, *overrides, text=HARDER)
    live = result.live
    assert list(live.coefficients) == ["turn", "harder"]
    assert live.peak.cycle == "harder"
    assert 0 <= live.peak.position < 25
    stress = von_mises(live.at("harder", live.peak.position))
    assert stress[live.peak.node] == pytest.approx(live.peak.value, rel=SINGLE)
    (check,) = (check for check in result.checks if check.kind == "fatigue")
    used = check.required * live.fatigue["utilisation"].max()
    assert used == pytest.approx(check.utilisation, rel=SINGLE)


@pytest.mark.parametrize("strength", ["marin", "fkm"])
def test_no_node_is_used_less_by_two_cycles_than_by_one_of_them(tmp_path, models, strength):
    """On one mesh. The other cycle is the same at nine tenths of the speed, and a little gentler.

    Its bound without support is above what the first one uses, its use with support is not.
    """
    other = HARDER.replace("10 rad/s", "9 rad/s").replace("900 N", "400 N")
    used = []
    for cycles in ("turn=1e6", "harder=1e3", "turn=1e6, harder=1e3"):
        design = machine(
            tmp_path, other, f"parts.rod.strength={strength}", f"duty.cycles={{{cycles}}}"
        )
        part = design.parts["rod"]
        loads = loads_on(design, part, solved(design))
        level = first_level(LoadedPart(design, part, loads), models)
        fields = solid_fields(loads, level, fatigue_use(LoadedPart(design, part, loads)))
        used.append(fields.fatigue["utilisation"])
    first, second, both = used
    assert (both >= np.maximum(first, second) * (1 - 1e-5)).all()
    assert second.max() < 0.999 * first.max()


def test_amplitude_and_mean_of_the_fkm_chain_are_those_of_its_diagram(tmp_path, models):
    result = checked(tmp_path, models, "parts.rod.strength=fkm")
    fatigue, diagram = result.live.fatigue, result.charts["fkm"]
    worst = fatigue["utilisation"].argmax()
    for name in ("amplitude", "mean"):
        assert fatigue[name][worst] == pytest.approx(diagram[name], rel=1e-5)


def test_of_a_finite_life_the_utilisation_of_endless_life_is_drawn_and_said_to_be(tmp_path, models):
    result = checked(tmp_path, models, 'duty.life="finite"')
    assert "endless life" in result.live.notes[0]
    assert not result.live.judged


def test_that_some_nodes_have_goodman_s_use_alone_is_said():
    values = np.ones(3)
    for count in (0, 2):
        level = SimpleNamespace(duty=SimpleNamespace(everywhere=NodalUse(*[values] * 3, count)))
        _, missing, notes = part_fields._fatigue(level, SimpleNamespace())
        assert missing == {}
        assert any("Findley's may be higher" in note for note in notes) == (count > 0)


def test_without_a_duty_there_is_no_fatigue_and_a_reason(tmp_path, models):
    result = checked(tmp_path, models, "duty.cycles={}")
    assert result.live.fatigue == {}
    assert result.live.missing["utilisation"].startswith("fatigue was not judged")


def test_fields_are_made_when_a_page_asks_for_them(tmp_path):
    design = machine(tmp_path, PLATE)
    for fidelity, drawn in (("formula", False), ("solid", True)):
        effort = Effort(fidelity)
        (part,) = check_design(design, effort=effort).parts
        assert part.live is None
        (part,) = check_design(design, effort=effort, live=True).parts
        assert part.live.decides == drawn
        assert part.live.estimated != drawn


def test_a_part_without_a_mesh_is_estimated_on_its_bare_surface(tmp_path):
    (part,) = check_design(machine(tmp_path, PLATE), effort=Effort("formula"), live=True).parts
    assert_array_equal(part.live.nodes, part.surface.nodes)
    assert part.surface.is_bare
    assert part.live.estimated
