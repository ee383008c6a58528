"""Batches of solids on carried meshes."""

import gc
import json
import os
import signal
import subprocess
import sys
import time
import weakref
from pathlib import Path

import pytest

import ballesta.sweeps.sweep as neighbours
import checks.stress.kept_models as kept_models
from ballesta.batches.job import Job, run_job
from ballesta.commands.batch_command import Wanted, outcomes_of
from checks.design.errors import DesignError
from geometry.parts import PlateLink

from ...geometry.step_files import write_step
from ...small_machine import MACHINE, PLATE

ROOT = Path(__file__).parents[3]


def checked(
    folder: Path,
    thickness: str,
    fidelity: str = "swept",
    store: str | None = None,
    part: str = PLATE,
):
    """Result of a variation, as its file has it, without what depends on the day and the clock."""
    (folder / "machine.toml").write_text(MACHINE + part)
    out = folder / fidelity / thickness.replace(" ", "_")
    out.mkdir(parents=True, exist_ok=True)
    override = f"parts.rod.thickness={thickness}"
    outcome = run_job(Job("machine", str(folder / "machine.toml"), (override,), fidelity, None,
                          "10 %", str(out), False, store))  # fmt: skip
    assert outcome["status"] in ("pass", "FAIL", "UNDECIDED"), outcome
    result = json.loads((out / "result.json").read_text())
    (part,) = result["parts"]
    for rung in part["rungs"]:
        del rung["seconds"]
    return part


def stresses(part):
    return {c["kind"]: c for c in part["checks"] if c["kind"] in ("static", "fatigue")}


@pytest.fixture
def none_known(monkeypatch):
    monkeypatch.setattr(neighbours, "_found", type(neighbours._found)())


@pytest.mark.slow
def test_a_swept_stress_is_that_of_a_solid_within_its_bar(tmp_path, none_known):
    """Both have a mesh of their own only in the second case, whose bar is of its own meshes."""
    swept, solid = checked(tmp_path, "9.3 mm"), checked(tmp_path, "9.3 mm", "solid")
    assert swept["meshes"][0]["mesher"].endswith("carried over")
    for kind, check in stresses(swept).items():
        other = stresses(solid)[kind]
        assert check["method"] == "solid, mesh carried over"
        assert 0 < check["numerical"] < 0.1 * check["value"]
        away = abs(check["value"] - other["value"])
        assert away <= check["numerical"] + other["numerical"]


@pytest.mark.slow
def test_a_swept_result_depends_on_no_other_variation(tmp_path, none_known, monkeypatch):
    """First, after another one, and with the neighbour from a store: the same to the last bit."""
    first = checked(tmp_path, "9.3 mm")
    monkeypatch.setattr(neighbours, "_found", type(neighbours._found)())
    store = str(tmp_path / "store")
    checked(tmp_path, "9.7 mm", store=store)
    assert checked(tmp_path, "9.3 mm", store=store) == first
    monkeypatch.setattr(neighbours, "_found", type(neighbours._found)())
    (tmp_path / "swept").rename(tmp_path / "before")
    assert checked(tmp_path, "9.3 mm", store=store) == first


@pytest.mark.slow
@pytest.mark.parametrize(
    "change", ["thickness=2.4 mm", "thickness=24 mm", "hole=6 mm", "hole=21.6 mm"]
)
def test_dimensions_far_from_the_file_s_have_neighbours_there(tmp_path, none_known, change):
    """0.3 and 3 times the thickness, 0.5 and 1.8 times the hole: their grid reaches there."""
    name, _, size = change.partition("=")
    text = MACHINE + PLATE
    (tmp_path / "machine.toml").write_text(text)
    out = tmp_path / "out"
    out.mkdir()
    job = Job("machine", str(tmp_path / "machine.toml"), (f"parts.rod.{name}={size}",), "swept",
              None, "10 %", str(out), False)  # fmt: skip
    assert run_job(job)["status"] in ("pass", "FAIL", "UNDECIDED")
    (part,) = json.loads((out / "result.json").read_text())["parts"]
    assert all(mesh["smallest scaled det J"] > 0 for mesh in part["meshes"])
    carried = part["meshes"][0]["mesher"].endswith("carried over")
    assert carried != any("meshes of its own" in said for said in part["assumed"])


STEP = """
[parts.rod]
body = "rod"
shape = { step = "rod.step" }
interfaces = { first = "A", second = "B" }
holes.first = { diameter = "12 mm", at = "0, 0, 0 mm" }
holes.second = { diameter = "12 mm", at = "161, 0, 0 mm" }
material = "S275"
mesh = { fineness = 0.5 }
"""


@pytest.mark.slow
def test_the_thickness_of_a_part_from_cad_is_swept(tmp_path, none_known):
    """Its neighbour on the grid about the file's 8 mm, which the design does not state."""
    write_step(tmp_path / "rod.step", PlateLink(length=161, width=30, thickness=8, hole=12).build)
    swept = checked(tmp_path, "9.3 mm", part=STEP)
    solid = checked(tmp_path, "9.3 mm", "solid", part=STEP)
    assert [key[2] for key in neighbours._found] == ["parts.rod.thickness=9.6 mm"]
    assert swept["meshes"][0]["mesher"].endswith("carried over")
    for kind, check in stresses(swept).items():
        other = stresses(solid)[kind]
        assert check["method"] == "solid, mesh carried over"
        assert abs(check["value"] - other["value"]) <= check["numerical"] + other["numerical"]


@pytest.mark.slow
def test_a_carried_mesh_is_all_that_a_part_from_cad_is_meshed_for(
    tmp_path, none_known, monkeypatch
):
    """Its ligaments are measured on that mesh, once the neighbour is known."""
    write_step(tmp_path / "rod.step", PlateLink(length=161, width=30, thickness=8, hole=12).build)
    checked(tmp_path, "9.3 mm", part=STEP)
    monkeypatch.setattr(kept_models, "mesh_shape", None)
    assert checked(tmp_path, "9.5 mm", part=STEP)["meshes"][0]["mesher"].endswith("carried over")


PIN = """
[parts.pin_A]
joint = "A"
shape = "pin"
fixed_to = "crank"
material = "C45"
surface = "machined"
diameter = "12 mm"
stack = [
  { body = "rod", at = "0 mm", width = "8 mm", single = true },
  { body = "crank", at = "8.5 mm", width = "8 mm", single = true },
]
"""


@pytest.mark.parametrize(
    ("push", "method"),
    [
        ("400 N", "formula"),
        pytest.param("3.8 kN", "solid, mesh carried over", marks=pytest.mark.slow),
    ],
)
def test_a_pin_has_a_solid_where_its_formula_leaves_it_open_only(
    tmp_path, none_known, push, method
):
    (tmp_path / "machine.toml").write_text((MACHINE + PIN).replace("400 N", push))
    out = tmp_path / "out"
    out.mkdir()
    job = Job("machine", str(tmp_path / "machine.toml"), (), "swept", None, "30 %", str(out), False)
    assert run_job(job)["status"] in ("pass", "FAIL", "UNDECIDED")
    (part,) = json.loads((out / "result.json").read_text())["parts"]
    kinds = [check["kind"] for check in part["checks"]]
    assert kinds.count("static") == kinds.count("fatigue") == 1
    assert stresses(part)["static"]["method"] == method


def test_a_part_without_a_neighbour_has_meshes_of_its_own(tmp_path, none_known, monkeypatch):
    monkeypatch.setattr(neighbours, "neighbour_of", lambda *_: "it has sharp edges")
    part = checked(tmp_path, "9.3 mm")
    assert "meshes of its own: it has sharp edges" in part["assumed"]
    assert {check["method"] for check in stresses(part).values()} == {"solid"}


@pytest.mark.parametrize(
    ("wish", "key"), [({"reports": True}, "--reports"), ({"within": "9s"}, "--within")]
)
def test_what_swept_solids_do_not_have_is_refused(tmp_path, wish, key):
    with pytest.raises(DesignError, match=f"{key}: is not for --fidelity swept"):
        outcomes_of([tmp_path / "machine.toml"], Wanted(tmp_path / "out", fidelity="swept", **wish))


def test_a_neighbour_s_solid_is_gone_before_the_next_is_solved(tmp_path, none_known, monkeypatch):
    """It refers to itself in circles, which the collector may leave for long: 0.4 GB of a bar."""
    solids = []

    class Solid:
        def __init__(self):
            self.own = self
            assert not [solid for solid in solids if solid() is not None]
            solids.append(weakref.ref(self))

    monkeypatch.setattr(neighbours, "neighbour_of", lambda *_: Solid() and "it is a double")
    (tmp_path / "machine.toml").write_text(MACHINE + PLATE)
    gc.disable()
    try:
        for sizes in ("8 mm", "9.6 mm"):
            override = f"parts.rod.thickness={sizes}"
            found = neighbours.Neighbours(tmp_path / "machine.toml", [override]).of("rod")
            assert found == "it is a double"
    finally:
        gc.enable()
    assert len(solids) == 2


@pytest.mark.slow
def test_a_killed_sweep_of_two_workers_goes_on_to_the_same_tables(tmp_path):
    """SIGKILL of the whole group after two of six, some of which share a neighbour."""
    (tmp_path / "machine.toml").write_text(
        MACHINE + PLATE.replace("fineness = 0.5", "fineness = 1")
    )
    with sweep(tmp_path, "out") as process:
        journal = tmp_path / "out" / "journal.jsonl"
        while not journal.exists() or journal.read_bytes().count(b"\n") < 2:
            assert process.poll() is None
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGKILL)
    kept = journal.read_text().splitlines()
    assert 2 <= len(kept) < 6
    for out in ("out", "other"):
        with sweep(tmp_path, out) as process:
            assert process.wait() in (0, 1)
    assert journal.read_text().splitlines()[: len(kept)] == kept  # these were not done again
    for table in ("results.csv", "results.parquet"):
        resumed, undisturbed = (tmp_path / out / table for out in ("out", "other"))
        assert resumed.read_bytes() == undisturbed.read_bytes()
    assert (tmp_path / "out" / "results.csv").read_text().count("mesh carried over") == 12


def sweep(folder, out):
    return subprocess.Popen(
        [sys.executable, "-m", "ballesta", "batch", "machine.toml", "--out", out, "--jobs", "2",
         "--fidelity", "swept", "--accuracy", "10 %", "--sweep",
         "parts.rod.thickness = 7..9 mm : 3", "--sweep", "parts.rod.width = 29, 31 mm"],
        cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
