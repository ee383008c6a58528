"""Conclusions of docs/extremes_chain.md on a machine checked from its file to its verdict.

The crank and slider of chain.py by the rung `formula`, slow tests by `auto`; the toggle press.
"""

import json
import os
import subprocess
import sys
from dataclasses import replace
from functools import cache
from math import isfinite, isnan
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.machine.validity_checks import load_gates
from ballesta.pipeline import check_file
from checks.design.errors import DesignError, NumericsError
from checks.ladder.part_ladder import Effort
from checks.result.verdict import Status
from checks.result.words import reason, verdict_sentence
from fem.threads import ONE_THREAD

from . import chain
from .chain import PLAIN, apart, check_of, statuses, values

ROOT = Path(__file__).resolve().parents[3]
FEW = replace(PLAIN, positions=91)
# nothing but the push: every stress is proportional to it
PUSHED = replace(FEW, masses=0.0, gravity=0.0, speed=1e-6)
LINEAR = ("peak von Mises stress", "elastic load share", "mean pressure of the pin F/(d t)")
SHAPES = {
    "sheet of 0.2 mm": {"thickness": 0.2},
    "foil of 0.02 mm": {"thickness": 0.02},
    "block of 100 mm": {"thickness": 100.0},
    "hole of 28 in 30 mm": {"hole": 28.0},
    "ligament of 0.05 mm": {"hole": 29.9},
    "hole of 0.5 mm": {"hole": 0.5},
    "bar of 100 to 1": {"width": 1.5, "thickness": 1.2, "hole": 1.0},
    "wire of 500 to 1": {"width": 0.3, "thickness": 0.2, "hole": 0.2},
    "wider than long": {"width": 150.0},
}
NO_FORMULA = {"hole of 28 in 30 mm", "ligament of 0.05 mm"}  # beyond the charts of lugs


checked = cache(chain.checked)  # many guises are compared with the same one


def plain():
    """The machine as it is, 91 positions."""
    return checked(FEW)


def assert_all_are_numbers(result):
    for check in result.checks:
        assert isfinite(check.value), check
        assert isfinite(check.limit), check
        assert not any(isnan(bar) for bar in (check.numerical, check.model, check.below)), check
    assert not [gate for gate in result.all_gates if isnan(gate.value)]


class TestPositions:
    @pytest.mark.parametrize("speed", [10.0, 300.0])
    def test_every_number_is_right_to_its_gate_where_the_gate_holds(self, speed):
        """Against 1000 positions, which leave 2e-5. The gate is 1 % of the largest load."""
        exact = values(checked(replace(PLAIN, speed=speed, positions=1000)))
        told = []
        for count in (8, 32, 128):
            guise = replace(PLAIN, speed=speed, positions=count)
            found, missed = values(checked(guise)), chain.unresolved(guise)
            wrong = max(abs(found[key] / exact[key] - 1) for key in exact)
            told.append(missed < 0.01)
            # a column's force is missed by up to 1.2 times what is told of the largest load
            assert wrong < max(1.5 * missed, 1e-4), count
        assert not told[0]
        assert told[-1]

    def test_peaks_converge_with_the_square_of_the_count(self):
        """30 times more positions: 900 times less is missed; 100 leaves room for how they fall."""
        coarse, fine = (chain.unresolved(chain.with_count(n)) for n in (16, 480))
        assert fine < coarse / 100

    def test_a_count_that_is_too_coarse_leaves_the_verdict_undecided_and_names_a_better_one(self):
        design = read_design(ROOT / "designs/slider_crank.toml", ["cycles.at_300.positions=8"])
        cycle = {"at_300": solve_cycles(design, {})["at_300"]}
        (gate,) = (g for g in load_gates(design, cycle) if "between the positions" in g.name)
        assert not gate.holds
        assert gate.binding
        assert "20 positions are too few, peaks are missed (most: y of the force" in gate.meaning
        assert gate.cure == "State positions = 60 or more, or leave it out"
        better = read_design(ROOT / "designs/slider_crank.toml", ["cycles.at_300.positions=60"])
        gates = load_gates(better, {"at_300": solve_cycles(better, {})["at_300"]})
        assert all(g.holds for g in gates if "between the positions" in g.name)

    def test_the_count_that_is_asked_for_is_the_count_of_positions(self):
        """Round-off made it one more in some units, at some angles, and moved all of them."""
        for guise in (FEW, replace(FEW, units=chain.IMPERIAL), replace(FEW, turned=37.0)):
            result = checked(guise)
            assert len(result.cycles["turn"]["position"]) == 91

    @pytest.mark.slow
    def test_the_press_peaks_at_its_ends_whatever_the_count(self):
        """Every phase holds both its ends, and the press is loaded most where it stops."""
        found = []
        for count in (8, 2000):
            cycles = [f"cycles.{name}.positions={count}" for name in ("press", "capacity")]
            result = check_file(
                chain.DESIGNS / "toggle_press.toml", cycles, effort=Effort("formula")
            )
            found.append(
                {(c.part, c.quantity): c.value for c in result.checks if c.kind == "static"}
            )
        assert found[0] == pytest.approx(found[1], rel=1e-9)

    @pytest.mark.slow
    def test_ten_thousand_positions_tell_what_a_thousand_tell(self):
        """A hundred thousand take minutes: tools/study_chain_extremes.py asks for them."""
        few, many = (checked(chain.with_count(n)) for n in (1000, 10_000))
        assert len(many.cycles["turn"]["position"]) == 10_000
        assert apart(few, many) < 1e-5
        assert statuses(few) == statuses(many)


class TestTheSameMachine:
    @pytest.mark.parametrize(
        "guise",
        [
            replace(FEW, units=chain.IMPERIAL),
            *(replace(FEW, turned=angle) for angle in (37.0, 90.0, -60.0)),
            replace(FEW, mirrored=True),
            replace(FEW, mirrored=True, turned=123.0),
        ],
        ids=["inch, lbf, psi", "37 deg", "90 deg", "-60 deg", "mirrored", "mirrored and turned"],
    )
    def test_units_and_place_change_no_digit(self, guise):
        """Gravity turns with it. Measured 3e-12, round-off of the linkage's closure."""
        result = checked(guise)
        assert apart(plain(), result) < 1e-9
        assert statuses(plain()) == statuses(result)

    def test_a_part_the_other_way_round_is_the_same_part(self):
        """2e-7 is left of the buckling of the bent bar, which is integrated from one end."""
        result = checked(replace(FEW, flipped=True))
        assert apart(plain(), result) < 1e-6
        assert statuses(plain()) == statuses(result)

    @pytest.mark.parametrize("start", [37.0, 200.0])
    def test_the_crank_may_start_anywhere(self, start):
        """Other positions of the same cycle: as far apart as 361 of them leave peaks, 3e-5."""
        fine = replace(PLAIN, positions=361)
        one, other = checked(fine), checked(replace(fine, start=start))
        assert apart(one, other) < 1e-4
        assert statuses(one) == statuses(other)

    @pytest.mark.slow
    def test_a_second_thread_changes_no_verdict(self):
        """Sums in another order: round-off, times the condition of the solid."""
        program = (
            "import json; from tests.validation.extremes import chain\n"
            "from dataclasses import replace\n"
            "result = chain.checked(replace(chain.PLAIN, positions=61, hole=24.0), 'auto')\n"
            "print(json.dumps([[[*k, v] for k, v in chain.values(result).items()],"
            "chain.statuses(result)]))"
        )
        found = []
        for threads in ("1", "2"):
            done = subprocess.run(
                [sys.executable, "-c", program],
                cwd=ROOT,
                env=os.environ | dict.fromkeys(ONE_THREAD, threads) | {"PYTHONPATH": str(ROOT)},
                capture_output=True,
                text=True,
                check=True,
            )
            found.append(json.loads(done.stdout.splitlines()[-1]))
        (one, first), (two, second) = found
        assert first == second
        assert [row[:3] for row in one] == [row[:3] for row in two]
        assert_allclose([row[3] for row in one], [row[3] for row in two], rtol=1e-6)


class TestSizes:
    @pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
    def test_stress_follows_the_load_over_twelve_decades(self, factor):
        """Round-off, and 1e-9 of the rod's own inertia at a crawl."""
        one, other = values(checked(PUSHED)), values(checked(replace(PUSHED, push=400.0 * factor)))
        for key in one:
            if key[0] == "rod" and key[2] in LINEAR:
                assert_allclose(other[key] / factor, one[key], rtol=1e-8, err_msg=str(key))

    def test_a_force_that_no_computer_can_square_is_refused(self):
        with pytest.raises(
            DesignError, match=r'got "1e\+200 N", which is not finite or beyond any machine'
        ):
            checked(replace(PUSHED, push=1e200))

    @pytest.mark.parametrize("speed", chain.SPEEDS)
    def test_any_speed_gives_numbers(self, speed):
        result = checked(replace(FEW, speed=speed))
        assert_all_are_numbers(result)
        verdict_sentence(result)

    def test_inertia_grows_with_the_square_of_the_speed(self):
        """At 1000 rad/s the push and the weight of some 500 N are 1 % of what inertia asks."""
        slow, fast = (
            check_of(checked(replace(FEW, push=0.0, speed=s)), "static").value
            for s in (1000.0, 3000.0)
        )
        assert_allclose(fast / slow, 9.0, rtol=1e-3)

    @pytest.mark.parametrize("name", sorted(SHAPES.keys() - NO_FORMULA))
    def test_a_part_beyond_the_calibration_passes_nothing_and_says_why(self, name):
        """Where half of the estimate is over the limit, it fails; no solid has less."""
        result = checked(replace(FEW, **SHAPES[name]))
        assert_all_are_numbers(result)
        assert result.status is not Status.PASS
        for kind in ("static", "fatigue"):
            check = check_of(result, kind)
            far_over = check.value / 2 * check.required > check.limit
            assert check.status is (Status.FAIL if far_over else Status.UNDECIDED)
            assert "solids were compared from" in check.note
            if not far_over:
                assert "its model error bar is unknown (" in reason(check)
                assert "solids were compared from" in reason(check)

    def test_a_hole_that_no_formula_knows_is_left_to_the_solid(self):
        result = checked(replace(FEW, **SHAPES["hole of 28 in 30 mm"]))
        assert_all_are_numbers(result)
        assert {check_of(result, kind).method for kind in ("static", "fatigue")} == {"solid"}

    def test_a_ligament_that_no_formula_knows_and_no_mesh_holds_is_refused_in_words(self):
        with pytest.raises(NumericsError, match="a wall or a ligament may be far thinner"):
            checked(replace(FEW, **SHAPES["ligament of 0.05 mm"]))

    @pytest.mark.slow
    @pytest.mark.parametrize("name", ["sheet of 0.2 mm", "hole of 28 in 30 mm", "bar of 100 to 1"])
    def test_beyond_the_calibration_auto_climbs_until_something_knows(self, name):
        result = checked(replace(FEW, **SHAPES[name]), "auto")
        assert_all_are_numbers(result)
        assert result.parts[0].rungs[-1].rung == "solid"
        assert all(isfinite(c.model) and isfinite(c.numerical) for c in result.checks)
        assert not any(c.settled_by_mesh for c in result.checks)

    @pytest.mark.slow
    def test_a_ligament_of_nothing_is_refused_in_words(self):
        with pytest.raises(Exception, match="a wall or a ligament may be far thinner"):
            checked(replace(FEW, hole=29.999), "auto")
