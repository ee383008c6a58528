"""Result.json is as its schema says, and page, terminal, CSV and Python show its numbers."""

import copy
import csv
import json
import re
from html import unescape
from io import StringIO
from pathlib import Path

import meshio
import numpy as np
import pytest
from jsonschema import Draft202012Validator

from ballesta.api import DesignResult
from ballesta.batches.job import Job, judged
from ballesta.batches.results import csv_text, result_rows
from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.result.verdict import NOT_MESHED, Check, check_ids
from checks.result.words import need_text, number, safety_text, utilisation_text, value_and_bars
from reports.files import result_schema, write_json, write_vtu
from reports.page import write_report
from reports.terminal import verdict_text
from tests.small_machine import PLATE, machine

from . import results

DESIGNS = Path(__file__).parents[2] / "designs"
ROW = re.compile(r'<tr role="row" id="check-\d+".*?</tr>', re.DOTALL)
CELL = re.compile(r"<t[hd] role.*?</t[hd]>", re.DOTALL)
WIDE = 400  # columns: no cell of the table is wrapped
NUMBERS = ("value", "limit", "required", "safety", "utilisation")


@pytest.fixture(scope="module", name="schema")
def schema_of_results():
    """Return what validates the data of a result.json."""
    Draft202012Validator.check_schema(result_schema())
    return Draft202012Validator(result_schema())


def valid(schema, data):
    found = [(list(error.absolute_path), error.message) for error in schema.iter_errors(data)]
    assert found == []


def shown(data):
    """Texts of a check as every reader sees them, from its plain data."""
    check = Check.from_dict(data)
    value = f"{value_and_bars(check)[0]} {check.unit}".strip()
    safety = f"{safety_text(check.safety, check.required)} ({need_text(check.required)})"
    return value, number(check.limit), safety, utilisation_text(check.utilisation)


def on_page(html):
    """The same texts of each row of the parts' tables."""
    for row in ROW.findall(html):
        cells = [unescape(re.sub(r"<[^>]*>", " ", cell)).split("\n") for cell in CELL.findall(row)]
        value, limit, safety, use = (" ".join(" ".join(cells[k]).split()) for k in range(1, 5))
        yield value, limit, safety, use


def all_checks(data):
    return [*(check for part in data["parts"] for check in part["checks"]), *data["linkage"]]


def test_a_design_has_the_same_numbers_wherever_they_are_read(tmp_path, schema):
    """By formula, so that it is cheap; each other shipped design in test_first_screen.py."""
    design = DESIGNS / "gallery" / "yoke_actuator.toml"
    result = check_design(read_design(design, ()), effort=Effort("formula"))
    write_report(result, None, tmp_path / "report.html")
    assert_same_everywhere(result, tmp_path, schema)


def assert_same_everywhere(result, folder, schema):
    """Assert that every reader of a result, its page report.html in a folder, has its numbers."""
    write_json(result, folder / "result.json")
    data = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    valid(schema, data)
    checks = all_checks(data)
    assert len({check["id"] for check in checks}) == len(checks) == len(result.checks)
    texts = [shown(check) for check in checks]

    pages = list(on_page((folder / "report.html").read_text(encoding="utf-8")))
    assert len(pages) == len(texts)
    for value, limit, safety, use in texts:
        assert any(
            v.startswith(value) and lim.split()[0] == limit and s == safety and u.split()[0] == use
            for v, lim, s, u in pages
        ), (value, limit, safety, use)

    lines = verdict_text(result, WIDE).splitlines()
    for check, (value, limit, safety, use) in zip(checks, texts, strict=True):
        said = [value.split()[0], f"{limit} ", safety, use]
        assert any(all(text in line for text in said) for line in lines), (check["id"], said)

    job = Job(result.name, "design.toml", (), "formula", None, None, str(folder))
    table = csv_text(*result_rows([judged(job, result)], {}))
    for row, check in zip(csv.DictReader(StringIO(table)), checks, strict=True):
        for name in NUMBERS:  # every digit: ==
            assert float(row[name]) == (float("inf") if check[name] is None else check[name])
    for part in result.parts:
        assert_peaks_of_vtu(part, folder / "part.vtu")


def assert_peaks_of_vtu(part, file):
    """The fields of a part's .vtu are largest where its checks say, or it has none: round-off."""
    write_vtu(part, file)
    found = {name: np.abs(values).max() for name, values in meshio.read(file).point_data.items()}
    checks = {check.kind: check for check in reversed(part.checks)}  # the first of each kind
    if NOT_MESHED in found:
        assert found == {NOT_MESHED: 0.0}
        return 0
    static, fatigue = checks["static"], checks["fatigue"]
    assert found["von Mises [MPa]"] == pytest.approx(static.value, rel=1e-12)
    assert found["1 / fatigue safety"] == pytest.approx(1 / fatigue.safety, rel=1e-12)
    return len(found)


def test_a_vtu_of_a_solid_has_the_values_of_its_checks(tmp_path):
    """The small machine's link: stress of one mesh, by the solid that judges."""
    design = machine(tmp_path, PLATE.replace("fineness = 0.5", "fineness = 0.4"), "accuracy=0.2")
    (part,) = check_design(design, effort=Effort("solid")).parts
    assert assert_peaks_of_vtu(part, tmp_path / "rod.vtu") >= 4


@pytest.mark.parametrize(
    "change",
    [
        lambda check: check.update(value="141"),
        lambda check: check.update(novel=1.0),
        lambda check: check.pop("id"),
        lambda check: check.update(numerical=-1.0),
        lambda check: check.update(status="passed"),
    ],
    ids=["text for a number", "a key of its own", "no id", "a bar below 0", "another status"],
)
def test_the_schema_refuses_what_is_no_result(change, schema):
    data = copy.deepcopy(results.design(cycles={}).to_dict())
    valid(schema, data)
    change(data["parts"][0]["checks"][0])
    assert not schema.is_valid(data)


def test_checks_are_identified_by_part_kind_and_where_needed_quantity():
    """A check of another kind changes no identifier."""
    pair = [results.check(kind="buckling", quantity=name) for name in ("in plane", "out of plane")]
    same = [results.check(kind="bush", quantity="pressure")] * 2
    assert check_ids([results.check(), *pair]) == [
        "bar_upper/static", "bar_upper/buckling/in plane", "bar_upper/buckling/out of plane",
    ]  # fmt: skip
    assert check_ids([*pair, results.check()])[:2] == check_ids(pair)
    assert check_ids(same) == ["bar_upper/bush/pressure", "bar_upper/bush/pressure (2)"]


def test_a_frame_has_a_row_for_each_check():
    pytest.importorskip("pandas")
    made = results.design()
    result = DesignResult(**{name: getattr(made, name) for name in made.__dataclass_fields__})
    frame = result.frame()
    (check,) = (check for check in made.checks)
    assert list(frame.index) == ["bar_upper/static"]
    assert frame.loc["bar_upper/static", "safety"] == check.safety
    assert frame["value"].dtype == float
