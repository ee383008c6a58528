"""Assumptions, models and errors behind a check's error bars, one by one."""

from dataclasses import replace
from math import inf

import pytest

from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.result.derivation import BarSymbols, Derivation, Given, Section, Step
from checks.result.verdict import Check, Status
from checks.strength.load_doubts import with_doubts
from reports.gauge import shares
from reports.page import report_html, sorted_assumptions

from . import results

# 355/1.5 = 236.7 MPa is allowed: the model's +20 passes it, the mesh's 4 and the loads' 6 do not
CHECK = results.check(
    value=225.0, numerical=5.0, sampling=1.0, model=20.0, model_below=10.0, loads=6.0,
    loads_below=0.0,
)  # fmt: skip


def test_bars_are_ranked_and_those_that_change_the_status_alone_are_told_apart():
    found = [(share.name.split()[0], share.ends, share.decides) for share in shares(CHECK)]
    assert CHECK.status is Status.UNDECIDED
    assert found == [
        ("model", "1.485 to 1.66", True),  # 355/239, 355/215
        ("mesh", "1.550 to 1.61", False),  # 355/229, 355/221
        ("loads", "1.536 to 1.58", False),  # 355/231, 355/225: no bar below
        ("between", "1.570 to 1.59", False),  # 355/226, 355/224
    ]


def test_a_bar_without_an_end_reaches_any_safety():
    (mesh,) = shares(replace(CHECK, numerical=inf, sampling=0.0, model=0.0, model_below=0.0,
                             loads=0.0))  # fmt: skip
    assert (mesh.ends, mesh.decides) == ("0 to any", True)


def test_the_page_folds_the_bars_that_change_nothing_alone():
    page = report_html(results.design(results.part(checks=[CHECK])))
    shown, _, folded = (
        page.partition('<div id="shares">')[2]
        .partition("</div>")[0]
        .partition("<summary>3 that change nothing alone</summary>")
    )
    assert "safety 1.485 to 1.66" in shown
    assert "safety 1.550 to 1.61" in folded


def test_each_doubt_about_the_loads_has_its_own_safeties():
    """Of 225 MPa the first may make 250 and 220, the second 235: 25 and 10 above, 5 below."""
    bare = results.check(value=225.0, numerical=0.0, model=0.0)
    check = with_doubts(bare, {"speed": (250.0, 220.0), "stop": (225.0, 235.0), "rest": (225.0,)})
    assert check.doubts == (("speed", 25.0, 5.0), ("stop", 10.0, 0.0))
    assert (check.loads, check.loads_below) == (35.0, 5.0)
    assert [(share.name, share.ends) for share in shares(check)] == [
        ("speed", "1.42 to 1.62"),  # 355/250, 355/220
        ("stop", "1.510 to 1.58"),  # 355/235, 355/225
    ]
    assert Check.from_dict(check.to_dict()) == check


def test_pins_that_bend_have_a_share_of_their_own():
    """Of +26 MPa clearances make 6, bent pins 20; clearances alone reach below."""
    items = (
        Given("v", "stress", 150.0, "MPa"),
        Given("fit_1", "the value at the least clearance of the pins", 147.0, "MPa"),
        Given("fit_2", "the value at the middle clearance of the pins", 150.0, "MPa"),
        Given("fit_3", "the value at the largest clearance of the pins", 156.0, "MPa"),
        Given("q_1", "the value where pins press evenly along", 150.0, "MPa"),
        Given("q_2", "the value where bent pins press unevenly", 170.0, "MPa"),
        Step("b_up", "model band above", "fit_3 - fit_2 + max(q_2 - q_1, 0)", "MPa"),
        Step("b_lo", "model band below", "fit_2 - fit_1 + max(q_1 - q_2, 0)", "MPa"),
    )
    bars = BarSymbols(above="b_up", below="b_lo", words="model: pins")
    check = results.check(value=150.0, numerical=0.0, model=26.0, model_below=3.0)
    told = replace(check, derivation=Derivation((), (Section("all", items),), "v", "v", bars))
    assert [(share.name.partition(",")[0], share.ends) for share in shares(told)] == [
        ("pins that bend", "2.08 to 2.37"),  # 355/170, 355/150
        ("clearance of pins", "2.27 to 2.42"),  # 355/156, 355/147
    ]


@pytest.fixture(scope="module")
def hammer():
    return check_design(read_design("designs/spring_hammer.toml"), effort=Effort("formula"))


@pytest.mark.slow
def test_what_a_model_band_is_made_of_adds_up_to_it(hammer):
    """Friction of leaves, formula against solids, drive's speed; forks of columns and linkage."""
    names = set()
    for check in hammer.checks:
        sizes = shares(check)
        names |= {share.name.partition(":")[0] for share in sizes}
        ends = [check.limit / check.upper, check.limit / check.value]
        assert ends[0] <= ends[1]
        low = [float(share.ends.partition(" ")[0]) for share in sizes]
        left = sum(check.limit / safety - check.value for safety in low if safety < ends[1])
        # safeties are rounded in the third digit: each may tell 1 % more than there is
        assert 0.97 * (check.upper - check.value) <= left + 1e-9
        assert left <= check.upper - check.value + 0.012 * len(low) * check.value
    assert names >= {
        "friction and preload between the leaves", "formula in place of a solid", "stiff forks",
        "the forks are between hinged and clamped",
        "changes of speed between its slowest and fastest",
    }  # fmt: skip


def test_assumptions_of_other_parts_are_told_apart():
    """The deciding part's, what it is like, and the machine's come first."""
    assumed = [
        ("duty.cycles.press", "one shift"), ("parts.bar_upper.hole", "bush"),
        ("parts.pin_B.stack", "4 mm of space"), ("bodies.upper.elastic", "all for vibration only"),
    ]  # fmt: skip
    inputs = [("parts.bar_lower.like", "bar_upper")]
    lower = results.part("bar_lower", [results.check("bar_lower", value=200.0)])
    upper = results.part(checks=[results.PASSING])
    pin = results.part("pin_B", [results.check("pin_B", value=1.0)], assumed=["short"])
    result = results.design(upper, lower, pin, assumed=assumed, inputs=inputs)
    assert result.deciding.part == "bar_lower"
    found = sorted_assumptions(result)
    near = [what for _, what in (*found.design, *found.tool)]
    assert near == ["one shift", "bush", "bearing arc 120 deg"]
    assert [what for _, what in found.elsewhere] == [
        "4 mm of space", "all for vibration only", "short",
    ]  # fmt: skip
