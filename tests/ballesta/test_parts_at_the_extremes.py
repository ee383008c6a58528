"""Messages on a part that is too large, nearly incompressible or cannot be built."""

import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.commands.plan import plan
from ballesta.run import check_all
from checks.design.errors import DesignError
from checks.ladder.solid import check_solid
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import loads_on
from checks.stress.solid_mesh_level import Models
from geometry import memory
from geometry.mesh import MeshError
from geometry.meshing import mesh_shape

from ..geometry.step_files import hole, plate_with, write_step
from ..small_machine import MACHINE, PLATE, machine, solved


@pytest.fixture
def small_memory(tmp_path, monkeypatch):
    """A machine with 64 MiB to spare."""
    file = tmp_path / "meminfo"
    file.write_text("MemAvailable: 65536 kB\n")
    monkeypatch.setattr(memory, "_MEMINFO", file)
    monkeypatch.setattr(memory, "_CGROUPS", tmp_path / "none")


def checked(folder, text, capsys):
    """Exit code and standard error of a check, without its progress."""
    path = folder / "machine.toml"
    path.write_text(MACHINE + text)
    code = check_all([path], out=folder / "out", fidelity="solid")
    said = capsys.readouterr().err
    assert not (folder / "out" / "machine" / "report.html").exists()
    return code, "\n".join(line for line in said.splitlines() if line.startswith("ballesta:"))


def test_a_part_too_large_for_the_memory_ends_with_exit_code_2_and_both_numbers(
    tmp_path, capsys, small_memory
):
    """160 x 30 x 8 mm of elements of 8 / 0.7 mm, refined at the holes, take some 100 MiB."""
    code, said = checked(tmp_path, PLATE.replace("fineness = 0.5", "fineness = 1"), capsys)
    assert code == 2
    found = re.search(
        r"machine.toml: parts.rod: solving about (\S+) unknowns with 2\d loads would need "
        r"(\S+) GiB of memory and 0\.0625 GiB are free; lower mesh\.fineness",
        said,
    )
    assert found, said
    unknowns, needed = map(float, found.groups())
    assert 5e3 < unknowns < 5e4
    assert 0.0625 < needed < 0.5


def test_a_plan_of_a_part_too_large_for_the_memory_is_refused_as_its_check(tmp_path, small_memory):
    mesh = "parts.rod.mesh={ fineness = 4, most_unknowns = 3_000_000 }"
    with pytest.raises(DesignError, match=r"0\.0625 GiB are free"):
        plan(machine(tmp_path, PLATE, mesh))


def test_a_nearly_incompressible_part_breaks_a_binding_gate_and_others_do_not(tmp_path):
    design = machine(tmp_path, PLATE, "accuracy=30 %", "parts.rod.mesh.fineness=0.4")
    part = design.parts["rod"]
    loads, models = loads_on(design, part, solved(design)), Models()
    result = check_solid(LoadedPart(design, part, loads), models)
    assert all(gate.holds for gate in result.gates)
    gate = next(g for g in result.gates if g.name == "rod: compressible material")
    assert (gate.value, gate.limit, gate.binding) == (0.3, 0.45, True)
    soft = replace(part, material=replace(part.material, poisson_ratio=0.4501))
    result = check_solid(LoadedPart(design, soft, loads), models)
    assert [g.name for g in result.gates if not g.holds] == ["rod: compressible material"]
    assert "mean stress is inexact" in gate.meaning


STEP = """
[parts.rod]
body = "rod"
shape = { step = "rod.step" }
holes.first = { diameter = "12 mm", at = "0, 0, 0 mm" }
holes.second = { diameter = "12 mm", at = "160.9969 mm, 0 mm, 0 mm" }
interfaces = { first = "A", second = "B" }
material = "S275"
mesh = { fineness = 0.5 }
"""
COARSE = STEP.replace("fineness = 0.5", "fineness = 0.3")
LENGTH = float(np.hypot(144, 72))  # mm, from A to B


PINS = [hole(0, 0, 12), hole(LENGTH, 0, 12)]
SIZE = (LENGTH + 40, 40, 8)
TOUCHES = (
    r"machine\.toml: parts\.rod: the body touches itself along a line, at \(80, 20, 4\) mm: a wall "
    r"or a ligament has no thickness there"
)


@pytest.mark.parametrize(
    ("holes", "text", "code", "said"),
    [
        pytest.param(
            PINS,
            STEP.replace(', second = "B"', ""),
            2,
            r"parts\.rod\.interfaces: must say at which point second sits",
            id="an interface that is missing",
        ),
        pytest.param(
            PINS[:1],
            STEP,
            2,
            r"parts\.rod\.holes\.second: no bore of 12 mm through \(160\.997, 0, 0\) mm is in",
            id="a hole that is missing",
        ),
        pytest.param(
            PINS,
            STEP.replace("160.9969 mm", "0 mm"),
            2,
            r"parts\.rod\.holes\.second: is the same hole as first",
            id="two interfaces in one hole",
        ),
        pytest.param(
            [*PINS, hole(LENGTH + 8, 0, 8)],
            STEP,
            2,
            r"parts\.rod\.holes\.second: no bore of 12 mm .* only a bore .* goes 302 deg",
            id="a hole that runs into another",
        ),
        pytest.param(
            [*PINS, hole(80, 14, 12)], COARSE, 3, TOUCHES, id="a hole tangent to the edge"
        ),
        pytest.param(
            [*PINS, hole(80, 14 - 1e-7, 12)], COARSE, 3, TOUCHES, id="a sliver of 1e-7 mm"
        ),
    ],
)
def test_a_part_from_cad_that_cannot_be_meant_is_refused_with_its_place(
    tmp_path, capsys, holes, text, code, said
):
    write_step(tmp_path / "rod.step", plate_with(*holes, size=SIZE))
    found, words = checked(tmp_path, text, capsys)
    assert re.search(said, words), words
    assert found == code


def test_nearly_coincident_holes_are_meshed_with_their_ridges(tmp_path):
    """Two holes of 12 mm, 0.01 mm apart, meet in ridges 2e-6 mm high; they take 12 x 0.01 mm2 more.

    Facets of the holes leave 1e-4 of the volume.
    """
    near = [hole(80, 0, 12), hole(80.01, 0, 12)]
    write_step(tmp_path / "rod.step", plate_with(*PINS, *near, size=SIZE))
    part = machine(tmp_path, STEP).parts["rod"]
    mesh = mesh_shape(part.geometry, fineness=0.35)
    assert_allclose(mesh.volume_cad, 8 * (SIZE[0] * 40 - 3 * 36 * np.pi - 0.12), rtol=1e-7)
    assert_allclose(mesh.volume, mesh.volume_cad, rtol=1e-4)
    assert mesh.jacobian_minimum > 0.05


def test_a_refined_mesh_that_is_not_usable_is_made_again_with_finer_general_elements(
    tmp_path, monkeypatch
):
    """Sizes between two places may leave a round face too coarse; the next mesh is finer there."""
    design = machine(tmp_path, PLATE)
    part = design.parts["rod"]
    loads = loads_on(design, part, solved(design))
    models, asked = Models(), []
    solutions = models.solutions

    def refuses_once(shape, fineness, material, sizes=None):
        asked.append(fineness)
        if len(asked) == 2:
            raise MeshError("the mesh has 1 mm3 and the body 2 mm3")
        return solutions(shape, fineness, material, sizes)

    monkeypatch.setattr(models, "solutions", refuses_once)
    result = check_solid(LoadedPart(design, part, loads), models)
    assert asked[0] == asked[1] < asked[2]
    assert len(result.meshes) == len(asked) - 1
