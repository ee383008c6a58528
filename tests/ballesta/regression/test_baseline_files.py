"""Baseline files: small, read back as written, refused in words where they are broken."""

import json

import pytest

from ballesta.regression.compare import compare
from ballesta.regression.file import (
    ELASTIC_SHARE,
    BaselineError,
    baseline_path,
    baseline_text,
    design_path,
    read_baseline,
    record_of,
    rungs_of,
    write_record,
)
from checks.columns import stability

from .records import STATIC, record


def written(folder, bands=None, **values):
    path = folder / "press.baseline.json"
    write_record(path, record(**values), bands or {})
    return path


def test_the_check_that_a_rung_decides_is_known_by_the_name_that_it_has():
    """The constant is written twice: a record is read without the solvers."""
    assert ELASTIC_SHARE == stability.ELASTIC_SHARE


def test_a_baseline_stands_beside_its_design(tmp_path):
    path = baseline_path(tmp_path / "press.v2.toml")
    assert path == tmp_path / "press.v2.baseline.json"
    assert design_path(path) == tmp_path / "press.v2.toml"


def test_a_record_is_inside_the_baseline_it_was_written_to(tmp_path):
    """10 digits are written, so that a third is 5e-11 off at most."""
    baseline = read_baseline(written(tmp_path, static=1000 / 3))
    assert compare(baseline, record(static=1000 / 3)).holds
    assert baseline.rungs["bar"] == {"static": "formula", "buckling": "formula"}
    assert [path.name for path in tmp_path.iterdir()] == ["press.baseline.json"]


def test_a_check_takes_one_line_with_value_safety_status_and_rung():
    lines = baseline_text(record(), {}).splitlines()
    (line,) = (
        line.strip() for line in lines if STATIC in line and "355" not in line and "100" in line
    )
    assert line == (
        f'"{STATIC}": {{"value": 100.0, "unit": "MPa", "safety": 6.5, "status": "pass", '
        '"rung": "formula"}'
    )
    assert len(lines) < 40


def test_bands_that_a_file_states_are_kept_as_written(tmp_path):
    stated = {"static": "2 %", "bar: buckling": 0.01, "mass": "0.1 %"}
    baseline = read_baseline(written(tmp_path, stated))
    assert baseline.bands == stated
    assert baseline.shares == {
        "static": pytest.approx(0.02, rel=1e-15),
        "bar: buckling": 0.01,
        "mass": pytest.approx(0.001, rel=1e-15),
    }


@pytest.mark.parametrize(
    ("bands", "said"),
    [
        ({"statik": "2 %"}, "no kind of check is named 'statik', did you mean static"),
        ({"pin: buckling": "2 %"}, "no kind of check is named 'pin: buckling'"),
        ({"static": "two"}, "bands.static: must be a share such as \"2 %\" or 0.02, got 'two'"),
        ({"static": "x %"}, "must be a share"),
        ({"static": True}, "must be a share"),
        ({"static": 0}, "must be above 0 % and below 100 %, got 0"),
        ({"static": "100 %"}, "must be above 0 % and below 100 %"),
    ],
)
def test_a_band_that_means_nothing_is_refused(tmp_path, bands, said):
    with pytest.raises(BaselineError) as error:
        read_baseline(written(tmp_path, bands))
    assert said in str(error.value)
    assert str(error.value).startswith("press.baseline.json: bands")


def test_a_list_of_bands_is_refused(tmp_path):
    path = written(tmp_path)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"bands": [2]}), encoding="utf-8")
    with pytest.raises(BaselineError, match="bands: must be a table"):
        read_baseline(path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"", "is no JSON text in UTF-8"),
        (b"\xff\xfe", "is no JSON text in UTF-8"),
        (b"<<<<<<< HEAD\n{}", "is no JSON text in UTF-8"),
        (b"[" * 100_000, "is no JSON text in UTF-8"),
        (b'{"format": NaN}', "NaN is no number of JSON"),
        (b"[]", "format: must be 'ballesta-baseline/2', got []"),
        (
            b'{"format": "ballesta-baseline/1"}',
            "got 'ballesta-baseline/1'; delete it and write anew",
        ),
        (b'{"format": "ballesta-baseline/2"}', "parts: must be a table, got None"),
    ],
)
def test_a_broken_baseline_is_refused_in_words(tmp_path, text, said):
    path = tmp_path / "press.baseline.json"
    path.write_bytes(text)
    with pytest.raises(BaselineError) as error:
        read_baseline(path)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("way", "value"),
    [
        (("status",), None),
        (("stages",), []),
        (("stages", "loads"), 1),
        (("linkage",), None),
        (("parts", "bar"), "x"),
        (("parts", "bar", "mass [kg]"), "4 kg"),
        (("parts", "bar", "rungs", "static"), 3),
        (("parts", "bar", "rungs", "static"), "formual"),
        (("parts", "bar", "checks", STATIC), []),
        (("parts", "bar", "checks", STATIC, "value"), True),
        (("parts", "bar", "checks", STATIC, "safety"), "much"),
        (("parts", "bar", "checks", STATIC, "status"), None),
    ],
)
def test_an_entry_of_the_wrong_kind_is_refused_with_its_place(tmp_path, way, value):
    path = written(tmp_path)
    data = here = json.loads(path.read_text(encoding="utf-8"))
    for step in way[:-1]:
        here = here[step]
    here[way[-1]] = value
    path.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(BaselineError) as error:
        read_baseline(path)
    assert ".".join(way) in str(error.value)


def test_a_kind_that_no_rung_decides_is_pinned_by_nobody(tmp_path):
    path = written(tmp_path)
    text = path.read_text(encoding="utf-8").replace('{"static": "formula"}', '{"bush": "formula"}')
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BaselineError, match=r"parts\.pin\.rungs: no kind of check is named 'bush'"):
        read_baseline(path)


def test_a_baseline_that_cannot_be_written_leaves_the_old_one_and_no_scraps(tmp_path):
    path = written(tmp_path)
    before = path.read_bytes()
    with pytest.raises(ValueError, match="Out of range float"):
        write_record(path, record(status=float("nan")), {})
    assert path.read_bytes() == before
    assert [other.name for other in tmp_path.iterdir()] == [path.name]


def plain_check(kind, quantity, method, value=1.0):
    return {
        "kind": kind, "quantity": quantity, "method": method, "value": value, "unit": "MPa",
        "safety": 2.0, "status": "pass", "numerical": 0.0, "model": 0.0, "model_below": 0.0,
        "limit": 2.0, "required": 1.5,
    }  # fmt: skip


def plain_part(*checks, solved=()):
    rungs = [{"rung": rung, "unknowns": 9} for rung in solved]
    return {"name": "bar", "facts": {"mass [kg]": 1.0}, "checks": list(checks), "rungs": rungs}


def test_each_kind_is_pinned_to_the_rung_that_decided_it():
    part = plain_part(
        plain_check("static", "peak", "formula"),
        plain_check("fatigue", "Goodman", "formula"),
        plain_check("buckling", "column in plane", "formula"),
        plain_check("buckling", "elastic load share", "solid"),
        plain_check("bush", "bush of bar", "formula"),
    )
    assert rungs_of(part) == {"static": "formula", "fatigue": "formula", "buckling": "solid"}


def test_columns_by_formula_pin_no_buckling():
    part = plain_part(
        plain_check("static", "peak", "formula"), plain_check("buckling", "column", "formula")
    )
    assert rungs_of(part) == {"static": "formula"}


def test_what_a_solid_was_asked_for_without_an_answer_stays_the_solids():
    part = plain_part(plain_check("static", "peak", "solid"), solved=["solid"])
    assert rungs_of(part) == {"static": "solid", "fatigue": "solid", "buckling": "solid"}


def test_checks_of_one_name_are_all_kept():
    part = plain_part(*(plain_check("bush", "bush of bar", "formula", k) for k in (1.0, 2.0, 3.0)))
    found = {"name": "Press", "status": "pass", "parts": [part], "linkage": []}
    checks = record_of(found, {"loads": "0" * 64}, 0.03)["parts"]["bar"]["checks"]
    assert [check["value"] for check in checks.values()] == [1.0, 2.0, 3.0]
    assert list(checks)[2] == "bush: bush of bar (3)"
