"""docs/documents.md is what its command writes, and holds every published value of the documents.

published_values.json has the documents' numbers with what an independent solution finds for the
same quantity, and what the documents' own formulae give, computed independently too.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

ROOT = Path(__file__).parent.parent.parent
VALUES = json.loads((Path(__file__).parent / "published_values.json").read_text(encoding="utf-8"))
PUBLISHED = [
    pytest.param(machine, value, id=f"{machine}: {value['table']}: {value['quantity']}")
    for machine in ("hammer", "slider_crank", "toggle")
    for value in VALUES[machine]
]


@pytest.fixture(scope="module")
def tool():
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        import compare_documents
    finally:
        sys.path.pop(0)
    return compare_documents


@pytest.fixture(scope="module")
def page(tool):
    return tool.page()


@pytest.fixture(scope="module")
def rows(tool):
    """The rows of published values by machine, table and quantity."""
    return {
        (machine, row.table, row.quantity): row
        for machine, stated in tool.read_data().items()
        for table in stated["tables"]
        if not table.get("over_a_turn")
        for row in tool.rows_of(machine, table)
    }


def test_the_page_is_up_to_date(page):
    """Whole text: numbers have four digits, rounding of another machine is far below."""
    assert page == (ROOT / "docs" / "documents.md").read_text(encoding="utf-8"), (
        "run make documents"
    )


def test_check_refuses_a_page_that_would_change(tool, page, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(tool, "page", lambda: page)
    monkeypatch.setattr(tool, "ROOT", tmp_path)
    monkeypatch.setattr(tool, "PAGE", tmp_path / "documents.md")
    assert tool.main(["--check"]) == 1
    assert "make documents" in capsys.readouterr().err
    assert tool.main([]) == 0
    assert tool.main(["--check"]) == 0
    tool.PAGE.write_text(page.replace("54.57", "54.58"), encoding="utf-8")
    assert tool.main(["--check"]) == 1


@pytest.mark.parametrize(("machine", "value"), PUBLISHED)
def test_a_published_value_stands_beside_what_an_independent_solution_finds(
    tool, rows, page, machine, value
):
    """Tolerance: rounding of the reference, 2e-6 where it has seven digits."""
    row = rows[machine, value["table"], value["quantity"]]
    assert row.document == value["document"]
    within = {"atol": value["tolerance"], "rtol": 0.0} if "tolerance" in value else {"rtol": 2e-6}
    assert_allclose(row.found, value["independent"], **within)
    line = f"| {tool.published(row.document, row.joint)} |"
    assert any(line in text and row.quantity in text for text in page.splitlines())


@pytest.mark.parametrize(
    ("machine", "value"), [case for case in PUBLISHED if "formula" in case.values[1]]
)
def test_a_document_s_own_formula_gives_what_an_independent_replica_gives(rows, machine, value):
    """The named errors and nothing else: rounding of the replica's print, 1e-7 where it has all."""
    row = rows[machine, value["table"], value["quantity"]]
    assert_allclose(
        row.formula, value["formula"], rtol=1e-6, atol=value.get("formula_tolerance", 0)
    )


@pytest.mark.parametrize(
    "replica",
    VALUES["hammer_script"],
    ids=lambda value: f"{value['omega']} rad/s, {value['work']:g} mm, {value['leaves']} leaves",
)
def test_the_hammer_s_scripts_computed_anew_give_what_an_independent_replica_gives(tool, replica):
    """At speeds and leaves that the page does not show, too; the replica prints 4 to 5 digits."""
    module, speed, work = tool.documents_hammer, replica["omega"], replica["work"]
    if not work:
        assert_allclose(module.torque_formula(speed), replica["drive_torque"], atol=1e-3)
        return
    force = module.force_formula(speed, work, replica["leaves"])
    mean = module.mean_torque_formula(speed, work, replica["leaves"])
    assert force == pytest.approx(replica["F_max"], abs=0.06)
    assert mean == pytest.approx(replica["mean_torque"], abs=0.005)


def test_the_spreadsheet_computed_anew_meets_every_press_force_to_1_n(rows):
    """So its errors, and no others, are the reason of the differences (thesis, Tables 5.3-5.8)."""
    tables = [row for key, row in rows.items() if key[1].startswith("Press force for a pull of")]
    assert len(tables) == 37
    assert_allclose([row.formula for row in tables], [row.document for row in tables], atol=1.0)
    apart = np.subtract([row.found for row in tables], [row.document for row in tables])
    assert apart.min() > 13.0  # and no difference is as small


@pytest.mark.parametrize("value", VALUES["quick_return"], ids=lambda value: value["where"])
def test_formulae_of_the_quick_return_are_as_far_off_as_an_independent_check_found(tool, value):
    (table,) = tool.read_data()["quick_return"]["tables"]
    found = {row.where: row for row in tool.comparisons_of("quick_return", table)}
    assert found[value["where"]].deviation == pytest.approx(
        value["deviation"], abs=value["tolerance"]
    )


def test_every_row_says_why_in_words(tool):
    for stated in tool.read_data().values():
        for table in stated["tables"]:
            for row in table["rows"]:
                reason = row.get("reason", table.get("reason_of_all", ""))
                assert tool.ERROR.sub("", reason).strip("() ,.") != "", row["quantity"]


def test_an_error_that_no_reason_names_is_refused(tool):
    with pytest.raises(SystemExit, match="Q-E9"):
        tool._errors("quick_return", {"Q-E2": "signs", "Q-E9": "speed"}, "a reason (Q-E2)")
