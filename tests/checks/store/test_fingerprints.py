"""Digests of inputs, code and libraries."""

from collections import OrderedDict
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel

from ballesta.design.read import read_design
from checks.design.data import Design, Part
from checks.store import fingerprints
from checks.store.fingerprints import PACKAGES, code_digest, digest, libraries, stages_of

DESIGNS = Path(__file__).parents[3] / "designs"
PRESS = DESIGNS / "toggle_press.toml"


class Colour(Enum):
    RED = 1


@dataclass(frozen=True)
class Bar:
    length: float
    note: str = field(default="", compare=False)


class Table(BaseModel):
    value: float


DIFFERENT = [
    None,
    True,
    1,
    1.0,
    np.nextafter(1.0, 2.0),
    "1",
    "",
    Path("1"),
    (),
    (1,),
    ((1,),),
    (1, 2),
    ("ab", "c"),
    ("a", "bc"),
    {"a": 1},
    {"a": 1, "b": 2},
    {1, 2},
    Colour.RED,
    Bar(1.0),
    Bar(2.0),
    Table(value=1.0),
    np.array([1.0, 2.0]),
    np.array([1, 2]),
    np.array([[1.0, 2.0]]),
    np.array([1.0, 2.0], dtype=np.float32),
    0.0,
    -0.0,
    float("nan"),
]


def test_things_that_differ_have_digests_that_differ():
    found = [digest(thing) for thing in DIFFERENT]
    assert len(set(found)) == len(DIFFERENT)
    assert all(len(each) == 64 for each in found)


def test_the_digest_is_the_same_in_every_process():
    """Written down once: sha256 of the canonical form, which baselines keep."""
    assert digest("bar", 1.5, (None, True)) == (
        "c76fe00138ee681fcb6ebfabdc2421898838a548d9116e578c2680f82ea5fcef"
    )


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({1, 2, 3}, frozenset({3, 2, 1})),
        ([1, 2], (1, 2)),
        (Bar(1.0, "left out of comparison"), Bar(1.0)),
        (np.arange(6.0).reshape(2, 3), np.asfortranarray(np.arange(6.0).reshape(2, 3))),
        (np.array([1.0], dtype=">f8"), np.array([1.0])),
        ({"a": 1}, OrderedDict(a=1)),
    ],
)
def test_equal_data_has_one_digest(one, other):
    assert digest(one) == digest(other)


def test_the_order_of_a_mapping_counts_for_sums_follow_it():
    assert digest({"a": 1, "b": 2}) != digest({"b": 2, "a": 1})


@pytest.mark.parametrize("thing", [object(), lambda: 1, b"bytes", Bar, np.array([None]), 1j])
def test_what_has_no_canonical_form_is_refused(thing):
    with pytest.raises(TypeError, match="no canonical form"):
        digest({"inside": [thing]})


def test_code_digests_see_every_file_of_their_packages(tmp_path, monkeypatch):
    for package in PACKAGES:
        (tmp_path / package / "inner").mkdir(parents=True)
        (tmp_path / package / "inner" / "code.py").write_text("1")
    monkeypatch.setattr(fingerprints, "__file__", str(tmp_path / "checks" / "store" / "x.py"))
    fresh = code_digest.__wrapped__
    everything, geometry, fem = fresh(), fresh("geometry"), fresh("fem")
    (tmp_path / "fem" / "inner" / "table.json").write_text("{}")
    assert fresh() != everything
    assert fresh("fem") != fem
    assert fresh("geometry") == geometry
    (tmp_path / "geometry" / "__pycache__").mkdir()
    (tmp_path / "geometry" / "__pycache__" / "code.cpython-311.pyc").write_bytes(b"1")
    assert fresh("geometry") == geometry
    with pytest.raises(FileNotFoundError, match="no package reportz"):
        fresh("reportz")


def test_every_part_of_the_code_has_a_digest_of_its_own():
    assert len({code_digest(package) for package in PACKAGES} | {code_digest()}) == 8


def test_libraries_name_what_numbers_depend_on():
    assert {"numpy", "scipy", "gmsh", "scikit-sparse", "python", "processor", "threads"} <= {
        *libraries()
    }


def changed(*overrides):
    """The stages of the toggle press that an override changes."""
    before, after = stages_of(read_design(PRESS)), stages_of(read_design(PRESS, overrides))
    assert list(before) == list(after)
    return [stage for stage in before if before[stage] != after[stage]]


@pytest.mark.parametrize(
    ("override", "stages"),
    [
        ("cycles.press.pace.speed=0.2 m/s", ["loads"]),
        ("bodies.mould.mass=11 kg", ["loads"]),
        ("parts.bar_upper.reliability=99.9 %", ["bar_upper: judgement"]),
        ("parts.pin_B.surface=ground", ["pin_B: judgement"]),
        ("parts.pin_B.material=S355", ["pin_B: material"]),
        ("parts.bar_upper.mesh.fineness=1.1", ["bar_upper: mesh"]),
    ],
)
def test_a_change_shows_in_its_stage_alone(override, stages):
    found = changed(override)
    assert [stage for stage in found if stage in stages] == stages
    like = {"bar_lower"}  # it is like bar_upper
    assert all(stage in stages or stage.partition(":")[0] in like for stage in found)


def test_a_dimension_changes_the_geometry():
    assert "bar_upper: geometry" in changed("parts.bar_upper.wall=3.5 mm")


def test_the_accuracy_changes_the_mesh_of_every_part():
    assert changed("accuracy=4 %") == ["bar_upper: mesh", "bar_lower: mesh", "pin_B: mesh"]


def test_required_safeties_and_duty_change_the_judgement_of_every_part():
    found = changed("require.static=1.6")
    assert found == [f"{part}: judgement" for part in ("bar_upper", "bar_lower", "pin_B")]


@pytest.mark.parametrize("path", sorted(DESIGNS.glob("*.toml")), ids=lambda path: path.stem)
def test_every_design_has_the_digest_of_every_stage(path):
    design = read_design(path)
    stages = stages_of(design)
    assert stages == stages_of(read_design(path))
    parts = ("geometry", "mesh", "material", "judgement")
    assert {*stages} == {
        "loads",
        "code",
        "libraries",
        *(f"{part}: {stage}" for part in design.parts for stage in parts),
    }


def test_no_field_of_a_design_or_a_part_is_left_out():
    """Fields that no stage has are told by text: the file, and what is derived of the others."""
    known = fingerprints._NOT_LOADS
    told = {"name", "file", "source", "sources", "sha256", "inputs", "overrides", "materials",
            "defaults_used", "assumed"}  # fmt: skip
    assert known - told == {"accuracy", "require", "duty", "parts"}
    assert known <= {each.name for each in fields(Design)}
    design = read_design(PRESS)
    part = design.parts["pin_B"]
    before = stages_of(design)
    for each in fields(Part):
        if each.name == "name":
            continue
        other = replace(part, **{each.name: "something else"})
        after = stages_of(replace(design, parts={**design.parts, "pin_B": other}))
        assert before != after, each.name
