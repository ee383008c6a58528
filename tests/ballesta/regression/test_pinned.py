"""A pinned rung decides again, whatever `auto` would choose; none stands in for it unsaid."""

import pytest

from ballesta.pipeline import check_design
from ballesta.regression.file import rungs_of
from ballesta.regression.worker import measured
from checks.design.effort import Effort
from checks.design.errors import DesignError, NumericsError
from checks.models import shapes
from geometry.mesh import MeshError

from ...small_machine import PLATE, machine

PINS = [
    {"static": "formula", "fatigue": "formula", "buckling": "formula"},
    {"static": "solid", "fatigue": "formula", "buckling": "formula"},
    {"static": "solid", "fatigue": "solid", "buckling": "solid"},
]


def part_of(design, pins, fidelity="auto"):
    (part,) = check_design(design, effort=Effort(fidelity, pinned={"rod": pins})).parts
    return part


@pytest.mark.parametrize("pins", PINS)
def test_each_kind_is_decided_by_the_rung_it_is_pinned_to(tmp_path, pins):
    part = part_of(machine(tmp_path), pins, "solid" if pins is PINS[0] else "auto").to_dict()
    found = rungs_of(part)
    assert {kind: found[kind] for kind in pins} == pins


def test_a_solid_is_refined_to_the_accuracy_also_where_its_verdict_is_settled(tmp_path):
    """`auto` stops at two meshes; a number to be repeated may not depend on its verdict."""
    design = machine(tmp_path, PLATE, "accuracy=2 %")
    part = part_of(design, PINS[2])
    stress = [check for check in part.checks if check.kind in ("static", "fatigue")]
    assert len(stress) == 2
    for check in stress:
        assert "settled" not in check.note
        assert check.numerical <= 2 * 0.02 * check.value


def test_a_record_by_a_solid_is_that_of_the_rungs_it_pins(tmp_path):
    """The first check chooses, the second measures: both are one process' work."""
    design = machine(tmp_path)
    first = measured(design.file, "solid", {})
    again = measured(design.file, "auto", {"rod": first["parts"]["rod"]["rungs"]})
    assert again["parts"] == first["parts"]


def test_a_kind_that_is_newly_asked_for_is_answered_by_the_cheapest_rung(tmp_path):
    part = part_of(machine(tmp_path), {"buckling": "formula"})
    rungs = rungs_of(part.to_dict())
    assert rungs == {"static": "formula", "fatigue": "formula", "buckling": "formula"}


def test_a_rung_that_has_no_model_of_the_part_is_refused_not_replaced(tmp_path, monkeypatch):
    monkeypatch.setattr(shapes, "model_of", lambda *_: None)
    told = r"fatigue, buckling are pinned to the rung formula, but there is no formula"
    with pytest.raises(DesignError, match=told):
        part_of(machine(tmp_path), PINS[1])


def test_a_rung_that_gives_up_is_told_as_numerics(tmp_path, monkeypatch):
    def gives_up(*_):
        raise MeshError("an element is folded")

    monkeypatch.setattr(shapes, "model_of", gives_up)
    with pytest.raises(NumericsError, match="formula, which gave up: an element is folded"):
        part_of(machine(tmp_path), PINS[1])
