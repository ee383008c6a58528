"""Changes that a check shows before anything is solved anew, against checks by solids with them."""

from dataclasses import replace
from pathlib import Path

import pytest

from ballesta.design.read import read_design
from ballesta.pipeline import check_design, check_with_cycles
from ballesta.sweeps.improve import with_changes
from checks.design.effort import Effort
from checks.result.verdict import Status
from checks.store.store import Store
from tests.small_machine import MACHINE, PLATE

SOLID = Effort("solid")
HAMMER = Path(__file__).parents[3] / "designs" / "spring_hammer.toml"
SHAPES = ((30, 8, 12), (26, 6, 12), (40, 10, 20), (24, 12, 8))  # mm: width, thickness, hole
SHORT = (1.04, 1.25, 1.8)  # required safety over that at the end of the bars


def _reserve(check):
    return check.limit / (check.upper * check.required)


def _checked(file: Path, store: Store, *overrides: str):
    design = read_design(file, overrides)
    return design, check_design(design, effort=SOLID, store=store)


@pytest.mark.slow
def test_changes_of_twelve_open_or_failing_checks_pass_and_keep_their_promise(tmp_path):
    """A link with a hole of four forms, short of three requirements: all 12 pass, 11 within 10 %.

    The arc is stated: else a check that is open is judged by contact, a failing one by arcs, whose
    stresses differ by more than the margin of a change.
    """
    store, kept, statuses = Store(tmp_path / "store"), [], []
    for width, thickness, hole in SHAPES:
        text = (
            PLATE.replace("hole =", 'bearing_arc = "150 deg"\nhole =')
            .replace('"30 mm"', f'"{width} mm"')
            .replace('"8 mm"', f'"{thickness} mm"')
            .replace('"12 mm"', f'"{hole} mm"')
        )
        file = tmp_path / f"link_{width}.toml"
        file.write_text(MACHINE.replace("400 N", "12 kN") + text, encoding="utf-8")
        _, before = _checked(file, store)
        (part,) = before.parts
        judged = [check for check in part.checks if check.kind in ("static", "fatigue")]
        has = min(check.limit / check.upper for check in judged)
        for short in SHORT:
            need = [f"require.{kind}={short * has:.6g}" for kind in ("static", "fatigue")]
            design, result = _checked(file, store, *need)
            statuses.append(result.status)
            best, *_ = with_changes(design, result).changes
            _, after = _checked(file, store, *need, best.override)
            (changed,) = after.parts
            assert all(check.status is Status.PASS for check in changed.checks), best
            named = [c for c in changed.checks if f"{c.part} {c.kind}" == best.governing]
            found = min(named, key=_reserve)
            kept.append(abs(best.safety / found.safety - 1.0))
    assert Status.PASS not in statuses
    assert len(kept) == 12
    assert sum(error < 0.10 for error in kept) >= 11, sorted(kept)


def hammer(*overrides: str):
    design = read_design(HAMMER, overrides)
    return replace(design, cycles={name: design.cycles[name] for name in ("at_5_work_10", "at_10")})


@pytest.mark.slow
def test_changes_of_the_hammers_leaves_hold_with_the_friction_that_they_then_have():
    """Of leaves 12.6 mm thick friction's share of fatigue is 2 % more than of those of 9.6 mm: with
    the share kept they had passed with 1.305 of 1.3, and a check has 1.297: UNDECIDED. So 12.5 mm
    is no way out, and 14 mm, where the formula has no bars, is none either.

    Of its cycles the duty's and the fastest: others decide nothing of the leaves.
    """
    formula = Effort("formula")
    design = hammer()
    checked = check_with_cycles(design, effort=formula)
    changes = with_changes(design, checked.result, checked.cycles, checked.rubbing).changes
    assert [change.key for change in changes] == ["parts.leaves.width"]
    for change in changes:
        after = check_design(hammer(change.override), effort=formula)
        (leaves,) = (part for part in after.parts if part.name == "leaves")
        assert all(check.status is Status.PASS for check in leaves.checks), change
        least = min(check.limit / check.upper for check in leaves.checks if check.kind == "fatigue")
        assert change.lower == pytest.approx(least, rel=0.01)


ORDINARY = (
    "air_compressor", "crank_rocker", "gripper", "push_pull_clamp", "riveting_press",
    "sickle_mower",
)  # fmt: skip
OVER = (1.05, 1.4)  # loads over those that the weakest part's bars just hold


@pytest.mark.slow
@pytest.mark.parametrize("name", ORDINARY)
def test_changes_of_ordinary_machines_under_more_load_pass_and_keep_their_promise(name):
    """Six machines of two loads: 12 open or failing checks, of each one or two with a change.

    What was shown before passes with all its parts, and the linkage is no worse. The promise is the
    formula's own, of the cycles that decide and with the sampling errors of the check before.
    """
    formula, file = Effort("formula"), HAMMER.parent / "gallery" / f"{name}.toml"
    base = check_design(read_design(file), effort=formula)
    known = {part.name: min(map(_reserve, part.checks)) for part in base.parts}
    weakest = min(reserve for reserve in known.values() if reserve)
    kept = 0
    for over in OVER:
        loads = f"load_factor={over * weakest:.6g}"
        stated = read_design(file, (loads,))
        checked = check_with_cycles(stated, effort=formula)
        assert checked.result.status is not Status.PASS
        shown = with_changes(stated, checked.result, checked.cycles, checked.rubbing)
        assert shown.changes or shown.unchanged
        if not shown.changes:
            continue
        best, *_ = shown.changes
        after = check_design(read_design(file, (loads, best.override)), effort=formula)
        own = [c for part in after.parts if part.name in best.parts for c in part.checks]
        assert all(check.status is Status.PASS for check in own), (over, best)
        named = [c for c in own if f"{c.part} {c.kind}" == best.governing]
        assert best.safety == pytest.approx(min(named, key=_reserve).safety, rel=0.1), (over, best)
        kept += 1
    assert kept >= 1
