"""Every check over a cycle tells in its bars what its positions miss of peaks between them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ballesta.pipeline import check_file
from checks.design.effort import Effort
from checks.part.part_loads import loads_on
from checks.result.verdict import Check
from checks.strength.sampling import MARGIN, PIECES, finer, sampled

from ..small_machine import PLATE, loads_of, machine, solved

MACHINES = Path(__file__).parents[2] / "designs"
COARSE, FINE = 49, 385  # positions of a turn; every coarse one is a fine one, but for corners
_RESOLVED = 1e-3  # of a value, its bar on the fine cycle


def checks_at(positions):
    """All checks of the quick return by formula, by part, kind and quantity."""
    result = check_file(
        MACHINES / "quick_return.toml",
        [f"cycles.at_4.positions={positions}"],
        effort=Effort(fidelity="formula"),
    )
    checks = [*result.linkage, *(check for part in result.parts for check in part.checks)]
    return {(check.part, check.kind, check.quantity): check for check in checks}


@pytest.fixture(scope="module")
def both():
    """The checks on a coarse and on a fine cycle."""
    return checks_at(COARSE), checks_at(FINE)


def along(values, **more):
    """Loads whose axial force is `values`, at even positions."""
    rows = np.zeros((len(values), 3))
    rows[:, 0] = values
    path = np.linspace(0.0, 1.0, len(values))
    return replace(loads_of({"first": rows}), path=path, **more)


def largest(loads):
    """A check of the largest force, as those that are formulas are made."""
    value = float(loads.wrenches["first"][:, 0].max())
    return [
        Check("rod", "bearing", "force", value, "N", 0.0, 0.0, 1e3, 1.0, "turn", "", "", "", "")
    ]


def rubbed(folder, positions, end="first", row=1, *overrides):
    """The largest of a force or couple at an end of the rod of the crank and slider: pins rub."""
    rubbing = 'friction.pins={ coefficient = 0.2, diameter = "12 mm" }'
    design = machine(folder, PLATE, rubbing, f"cycles.turn.positions={positions}", *overrides)

    def made(loads):
        value = float(np.abs(loads.wrenches[end][:, row]).max())
        return [replace(check, value=value) for check in largest(loads)]

    (check,) = sampled(made, loads_on(design, design.parts["rod"], solved(design)))
    return check


def test_friction_that_reverses_between_two_positions_does_not_ring(tmp_path):
    """As the rod swings back, couples of its pins jump: a spline through them rings."""
    coarse, fine = rubbed(tmp_path, 91), rubbed(tmp_path, 721)
    assert coarse.value + coarse.sampling >= fine.value
    assert coarse.sampling < 0.05 * coarse.value
    assert fine.sampling < 1e-3 * fine.value


def test_friction_that_rests_at_a_position_does_not_ring(tmp_path):
    """In line, the rod turns back as the turn begins: there its pins do not rub."""
    check = rubbed(tmp_path, 91, "second", 5, 'points.B="150, 0 mm"')
    assert check.sampling < 0.01 * check.value


class TestACoarseCycle:
    def test_holds_the_fine_values_of_every_kind_in_its_bars(self, both):
        coarse, fine = both
        assert coarse.keys() == fine.keys()
        kinds = {kind for _, kind, _ in coarse}
        assert kinds >= {"static", "fatigue", "buckling", "bearing", "shear-out", "contact"}
        assert kinds >= {"pin bending", "pin shear"}
        for name, check in coarse.items():
            if check.value:
                rise = check.value * (fine[name].utilisation / check.utilisation - 1)
                assert rise <= check.sampling + 2e-5 * check.value, name

    def test_misses_peaks(self, both):
        """Else the other test has nothing to hold."""
        coarse, fine = both
        rises = {
            kind: max(
                fine[name].utilisation / check.utilisation - 1
                for name, check in coarse.items()
                if name[1] == kind and check.value
            )
            for kind in ("static", "fatigue", "buckling", "shear-out")
        }
        assert min(rises.values()) > 5e-4

    def test_has_small_bars_where_it_is_resolved(self, both):
        for name, check in both[1].items():
            assert check.sampling <= _RESOLVED * check.value, name
            assert check.numerical >= check.sampling

    def test_is_told_in_the_derivation(self, both):
        for check in both[0].values():
            assert "e_pos" in check.derivation.bars.numerical.split() or not check.sampling
            assert "formulas give" not in check.derivation.unproved


class TestThePlacesBetween:
    def test_find_a_smooth_peak(self):
        x = np.linspace(0.0, 1.0, 12)
        (check,) = sampled(largest, along(np.sin(np.pi * x) + 1.0))
        assert check.sampling == pytest.approx(MARGIN * (2.0 - check.value), rel=0.02)

    def test_find_nothing_on_a_line_or_in_measured_rows(self):
        values = np.linspace(1.0, 2.0, 9)
        (line,) = sampled(largest, along(values))
        rows = replace(along(np.sin(values)), path=np.full(9, np.nan))
        assert line.sampling == 0.0
        assert sampled(largest, rows)[0].sampling == 0.0

    def test_go_on_to_both_sides_of_a_jump(self):
        """The load falls to 6 N by 1 N a step when it jumps: at the jump it was up to 7 N."""
        values = np.array([0.0, 0.0, 0.0, 6.0, 5.0, 4.0])
        loads = along(values, stretch_of=np.array([0, 0, 0, 1, 1, 1]))
        (check,) = sampled(largest, loads)
        assert check.sampling == pytest.approx(MARGIN * 1.0)
        places = finer(loads)
        assert np.count_nonzero(places.before == 2) == 1 + PIECES
        assert places.of(values).min() == pytest.approx(0.0, abs=1e-12)

    def test_are_asked_only_where_they_may_matter(self):
        """Of 900 positions on a bump: all once more in rows, its top finely; on a line none.

        Everywhere these would be 9 times the positions.
        """
        x = np.linspace(0.0, 1.0, 900)
        bump = along(np.exp(-((x - 0.5003) ** 2) / 0.02))
        line = along(np.linspace(1.0, 2.0, 900))
        asked = []

        def make(loads):
            asked.append(len(loads.labels))
            return largest(loads)

        (check,) = sampled(make, bump)
        everywhere = largest(finer(bump).between)[0].value
        assert check.sampling == pytest.approx(MARGIN * (everywhere - check.value), rel=1e-6)
        assert check.sampling > 0.0
        assert sum(asked) < 4 * 900
        asked.clear()
        (check,) = sampled(make, line)
        assert asked == [900]
        assert check.sampling == 0.0

    def test_are_asked_where_a_contact_slides_under_loads_that_go_straight(self):
        """Force times reach bends where neither does: (1 - x) x is 1/4 at 1/2, 12/49 beside it."""
        x = np.linspace(0.0, 1.0, 8)
        sliding = along(1.0 - x, reaches={"first": x})

        def moment(loads):
            value = float((loads.wrenches["first"][:, 0] * loads.reaches["first"]).max())
            return [replace(largest(loads)[0], value=value)]

        (check,) = sampled(moment, sliding)
        assert check.sampling == pytest.approx(MARGIN * (1 / 4 - 12 / 49), rel=1e-6)
