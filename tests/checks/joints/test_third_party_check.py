"""A check that another package adds: the example of docs/extending.md, found by its entry point."""

import json
import shutil
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from ballesta.pipeline import check_file
from checks import by_formula
from checks.design.effort import Effort

from ...small_machine import machine
from .test_bush_checks import PIN

EXAMPLE = Path(__file__).parents[3] / "docs" / "examples" / "bearing_contact.py"


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """The example as pip installs it: a module, and its entry point in a folder of metadata."""
    site = tmp_path / "site"
    told = site / "bearing_contact-1.0.dist-info"
    told.mkdir(parents=True)
    shutil.copy(EXAMPLE, site)
    (told / "METADATA").write_text("Name: bearing_contact\nVersion: 1.0\n", encoding="utf-8")
    (told / "entry_points.txt").write_text(
        f"[{by_formula.GROUP}]\nbearing_contact = bearing_contact\n", encoding="utf-8"
    )
    monkeypatch.syspath_prepend(site)
    by_formula.registered.cache_clear()
    yield
    by_formula.registered.cache_clear()


def result_of(folder):
    text = PIN.replace("BEARS", 'allowable = "40 MPa", pv = "1 MPa m/s"')
    design = machine(folder, text)
    found = check_file(design.file, effort=Effort("formula"))
    return next(part for part in found.parts if part.name == "pin_A")


def test_a_check_of_another_package_is_found_made_and_derived(installed, tmp_path):
    """Its p v is that of the built-in check."""
    part = result_of(tmp_path)
    (own,) = [check for check in part.checks if check.kind == "bearing contact"]
    (known,) = [check for check in part.checks if check.quantity == "p v of the bush of rod"]
    assert (own.model, own.below) == pytest.approx((known.model, known.below), rel=1e-12)
    assert_allclose([own.value, own.limit], [known.value, known.limit], rtol=1e-12)
    assert (own.cycle, own.position) == (known.cycle, known.position)
    assert_allclose(own.sampling, known.sampling)
    values = own.derivation.values
    assert_allclose(own.value, values["F"] / 100 * abs(values["omega"]) * 5e-3)
    assert not own.derivation.unproved
    assert json.dumps(own.to_dict())
    assert [kind for kind in by_formula.kinds() if kind.has("bearing contact: p v of rod")]


def test_no_check_of_another_package_is_made_where_it_is_not_installed(tmp_path):
    assert not [check for check in result_of(tmp_path).checks if check.kind == "bearing contact"]


def test_the_report_tells_what_a_check_of_another_package_leaves_out(
    installed, tmp_path, monkeypatch
):
    (own,) = [m for m in by_formula.registered() if m.__name__ == "bearing_contact"]
    monkeypatch.setattr(own, "not_checked", lambda loaded: [f"NOT CHECKED: {loaded.name}"])
    assert "NOT CHECKED: pin_A" in result_of(tmp_path).assumed
