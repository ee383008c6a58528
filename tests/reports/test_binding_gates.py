"""A gate that is not binding is told, but leaves the verdict as it is."""

from checks.result.verdict import Gate, Status
from reports.page import report_html
from reports.terminal import verdict_text

from . import results
from .test_page import Page

SLOW = Gate("press: time of a cycle", 1.24, 1.0, "one cycle takes 3.73 s", binding=False)
UNEVEN = Gate("press: speed irregularity", 5.0, 0.1, "constant speed does not count")


def test_the_verdict_passes_and_tells_what_does_not_hold():
    result = results.design(gates=[SLOW])
    assert result.status is Status.PASS
    text = verdict_text(result, 160)
    assert "DOES NOT HOLD  loads: press: time of a cycle: 1.24 > 1.00; one cycle takes" in text
    assert "PASS" in text
    assert "NOT VALID" not in text
    page = Page(report_html(result)).text
    assert "Does not hold press: time of a cycle: 1.24 > 1.00" in page
    assert "NOT VALID" not in page


def test_a_binding_gate_still_leaves_it_undecided():
    result = results.design(gates=[SLOW, UNEVEN])
    assert result.status is Status.UNDECIDED
    text = verdict_text(result, 200)
    assert "NOT VALID  loads: press: speed irregularity" in text
    assert "these validity checks do not hold: loads press: speed irregularity;" in text
    assert result.to_dict()["gates"][0]["binding"] is False
