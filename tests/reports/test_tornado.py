"""Error bars of a check one by one."""

from dataclasses import replace
from math import inf

from checks.result.verdict import Status
from reports import report_html
from reports.gauge import shares

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
        ("model", "1.485 to 1.65", True),  # 355/239, 355/215
        ("mesh", "1.550 to 1.60", False),  # 355/229, 355/221
        ("loads", "1.536 to 1.57", False),  # 355/231, 355/225: no bar below
        ("between", "1.570 to 1.58", False),  # 355/226, 355/224
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
    assert "safety 1.485 to 1.65" in shown
    assert "safety 1.550 to 1.60" in folded
