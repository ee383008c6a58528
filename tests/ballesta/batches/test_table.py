import csv
import io

import pyarrow.parquet as pq
import pytest

from ballesta.batches.job import Job, ended, judged
from ballesta.batches.results import csv_text, parquet_bytes, result_rows, varied_inputs

from ...reports import results


def job(name, *overrides):
    return Job(name, f"{name}.toml", overrides, "auto", None, None, f"out/{name}")


def outcome(name, result=None, **inputs):
    result = results.mixed() if result is None else result
    return judged(job(name), result) | {"inputs": inputs}


def varied(*inputs):
    return varied_inputs([outcome(f"d{k}", **each) for k, each in enumerate(inputs)])


def test_only_what_differs_is_a_column_and_numbers_carry_their_unit_in_its_name():
    columns, left = varied(
        {"a": "4 mm", "b": "same", "c": "S275"}, {"a": "5.5mm", "b": "same", "c": "S355"}
    )
    assert columns == {"a [mm]": [4.0, 5.5], "c": ["S275", "S355"]}
    assert left == 0


def test_values_in_different_units_stay_text_that_says_so():
    columns, _ = varied({"a": "4 mm"}, {"a": "0.5 cm"})
    assert columns == {"a": ["4 mm", "0.5 cm"]}


def test_a_design_that_was_not_read_tells_what_was_set():
    bad = ended(job("bad", "a=9 mm"), "wrong input", "no", "")
    columns, _ = varied_inputs([outcome("x", a="4 mm"), outcome("y", a="5 mm"), bad])
    assert columns == {"a [mm]": [4.0, 5.0, 9.0]}


def test_what_few_designs_state_is_left_out_and_counted():
    columns, left = varied({"a": "1", "rare": "x"}, {"a": "2"}, {"a": "3"}, {"a": "4"})
    assert list(columns) == ["a"]
    assert left == 1


@pytest.fixture
def rows():
    outcomes = [
        outcome("one", results.mixed(), wall="4 mm"),
        ended(job("two", "wall=5 mm"), "crashed", "its process was killed", "meshing"),
        outcome("=three", results.hostile(), wall="6 mm"),
    ]
    return result_rows(outcomes, {"two": "duplicate"})


def test_every_check_is_a_row_and_one_of_a_design_governs(rows):
    names, table = rows
    assert [row["design"] for row in table if row["governing"]] == ["one", "=three"]
    assert sum(row["design"] == "one" for row in table) == len(results.mixed().checks)
    (crashed,) = (row for row in table if row["design"] == "two")
    assert (crashed["design status"], crashed["error"], crashed["stage"]) == (
        "crashed",
        "its process was killed",
        "meshing",
    )
    assert crashed["status"] is None
    assert crashed["design note"] == "duplicate"
    assert crashed["input wall [mm]"] == 5.0
    assert set(names) == set(crashed)


def test_csv_and_parquet_hold_the_same_and_to_the_last_bit(rows):
    names, table = rows
    read = list(csv.DictReader(io.StringIO(csv_text(names, table))))
    stored = pq.read_table(io.BytesIO(parquet_bytes(names, table))).to_pylist()
    assert len(read) == len(stored) == len(table)
    for row, text, kept in zip(table, read, stored, strict=True):
        assert list(text) == list(kept) == names
        assert kept["value"] == row["value"]
        assert text["value"] == ("" if row["value"] is None else repr(row["value"]))
        assert kept["governing"] is row["governing"]


def test_a_name_is_no_formula_of_a_spreadsheet(rows):
    assert "\n'=three," in csv_text(*rows)


def test_an_unknown_error_bar_is_infinite_not_missing():
    unknown = results.design(results.part(checks=[results.check(numerical=float("inf"))]))
    _, (row,) = result_rows([outcome("one", unknown)], {})
    assert row["numerical"] == float("inf")
