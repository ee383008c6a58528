"""Verdicts without a number to stand on are named: no load, no limit, no end to a bar."""

from dataclasses import replace
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from ballesta.machine.warnings_of import unloaded_warnings
from ballesta.pipeline import check_file
from checks.design.errors import DesignError
from checks.ladder.climb import climb_cheap, start_climb
from checks.ladder.part_ladder import Effort
from checks.ladder.result import solid_result
from checks.models import shapes
from checks.models.checked import NOTHING, Estimate, rung_estimates, rung_level
from checks.part.loaded_part import LoadedPart
from checks.result.verdict import Check, Status
from checks.result.words import reason, safety_text, utilisation_text
from checks.stress.solid_mesh_level import Models
from geometry.mesh import MeshError

from ...small_machine import MACHINE, PLATE, loads_of, machine

CHECK = Check(
    "rod", "static", "peak von Mises stress", 10.0, "MPa", 0.0, 0.0, 275.0, 1.5,
    "turn", "k = 0", "plate", "formula", "yield stress",
)  # fmt: skip
NEVER = {"first": [[0.0, 0.0, 0.0]] * 4, "second": [[0.0, 0.0, 0.0]] * 4}
RUN = """
[measured.run]
loads = "run.csv"
position = { column = "phi", unit = "deg", name = "crank angle" }
time = { column = "t", unit = "s" }
[measured.run.bodies.rod]
angle = { column = "o", unit = "deg" }
acceleration = { columns = ["o", "p"], unit = "m/s2" }
angular_velocity = { column = "o", unit = "rad/s" }
angular_acceleration = { column = "o", unit = "rad/s2" }
[measured.run.bodies.rod.at.A]
force = { columns = ["F", "o"], unit = "N", sign = -1 }
[measured.run.bodies.rod.at.B]
force = { columns = ["F", "o"], unit = "N" }
[duty]
cycles = { run = 1e6 }
"""


def pulled(folder, forces):
    """A file with the rod at rest, pulled at its ends along x by these forces, N."""
    rows = [f"{10 * k},{k},0,0,{force!r}" for k, force in enumerate(forces)]
    (folder / "run.csv").write_text("\n".join(["phi,t,o,p,F", *rows]) + "\n")
    bodies = MACHINE[: MACHINE.index("[forces.drive]")]
    still = bodies.replace("ground =", 'gravity = "0, 0 m/s2"\nground =', 1)
    file = folder / "rod.toml"
    file.write_text(still + RUN + PLATE)
    return file


class TestNothingLoadsThePart:
    def test_no_stress_needs_no_error_bar(self, tmp_path):
        """Linear in the loads, a formula finds exactly 0, calibrated for the part or not."""
        design = machine(tmp_path, PLATE, "parts.rod.thickness=60 mm")
        loads, part = loads_of(NEVER), design.parts["rod"]
        model = shapes.model_of(part, loads)
        climb = start_climb(LoadedPart(design, part, loads))
        level = rung_level(LoadedPart(design, part, loads), model)
        found = rung_estimates(LoadedPart(design, part, loads), level, climb.use, lambda _: model)
        assert sorted(found) == ["fatigue", "static"]  # nothing is pressed, nothing buckles
        for estimate in found.values():
            check = estimate.check
            assert (check.value, check.numerical, check.model, check.below) == (0, 0, 0, 0)
            assert check.status is Status.PASS
            assert check.note.endswith(NOTHING)
            assert estimate.settled

    def test_auto_stops_at_the_first_rung(self, tmp_path):
        design = machine(tmp_path, PLATE, "parts.rod.thickness=60 mm")
        climb = start_climb(LoadedPart(design, design.parts["rod"], loads_of(NEVER)))
        assert not climb_cheap(climb, "auto")
        assert [tried.rung for tried in climb.tried] == ["formula"]

    @pytest.mark.parametrize("fidelity", ["auto", "solid"])
    def test_a_part_at_rest_passes_with_a_warning_and_no_safety(self, tmp_path, fidelity):
        result = check_file(pulled(tmp_path, [0.0] * 5), effort=Effort(fidelity))
        assert result.status is Status.PASS
        assert [w for w in result.warnings if w.startswith("rod: nothing loads it in any cycle")]
        assert all(check.value == 0 for check in result.checks)
        assert {check.to_dict()["safety"] for check in result.checks} == {None}
        assert not [gate for gate in result.all_gates if not gate.holds]

    def test_one_newton_is_a_load(self, tmp_path):
        result = check_file(pulled(tmp_path, [0.0, 1.0, 0.0, 0.0]), effort=Effort("formula"))
        assert not [w for w in result.warnings if "nothing loads" in w]

    def test_a_warning_names_only_parts_of_which_nothing_is_asked(self):
        idle = SimpleNamespace(name="idle", checks=[replace(CHECK, value=0.0)])
        half = SimpleNamespace(name="half", checks=[replace(CHECK, value=0.0), CHECK])
        empty = SimpleNamespace(name="empty", checks=[])
        (warning,) = unloaded_warnings([idle, half, empty])
        assert warning.startswith("idle: ")


class TestOneHeavyPosition:
    @pytest.mark.parametrize("where", [0, 1, 9, 18, 19])
    def test_the_heavy_one_decides_wherever_it_stands(self, tmp_path, where):
        """1 N, and once 1000 N: 1000 times the peak, and the fatigue of just these two."""
        forces = [1.0] * 20
        light = check_file(pulled(tmp_path, forces), effort=Effort("formula"))
        forces[where] = 1000.0
        heavy = check_file(pulled(tmp_path, forces), effort=Effort("formula"))
        pair = check_file(pulled(tmp_path, [1.0, 1000.0]), effort=Effort("formula"))
        one, other = light.parts[0].checks[0], heavy.parts[0].checks[0]
        assert other.value == pytest.approx(1000 * one.value, rel=1e-9)
        assert f"= {10 * where} deg" in other.position
        found, alone = (
            next(check for check in result.checks if check.kind == "fatigue")
            for result in (heavy, pair)
        )
        assert f"= {10 * where} deg" in found.position
        assert found.value == pytest.approx(alone.value, rel=1e-9)


class TestWords:
    def test_no_load_has_no_safety(self):
        """275 MPa over 0 MPa is no number."""
        idle = replace(CHECK, value=0.0)
        assert idle.safety == inf
        assert safety_text(idle.safety) == "not loaded"
        assert reason(idle) == "not loaded: a value of 0 has no safety (1.5 required)"

    def test_no_load_with_a_bar_says_what_the_bar_leaves(self):
        """275 / 11 = 25."""
        said = reason(replace(CHECK, value=0.0, model=11.0))
        assert said == (
            "not loaded: a value of 0 has no safety (1.5 required); 25.0 at the upper end of its "
            "error bars"
        )

    def test_a_passing_value_inside_its_own_bar_is_called_a_bound(self):
        """10 + 30 MPa of 275: 6.87 at least."""
        said = reason(replace(CHECK, numerical=30.0))
        assert "6.87 at the upper end of its error bars" in said
        assert "its numerical bar is wider than the value: ±30 on 10.0 MPa" in said
        assert said.endswith("so the value is a bound, not an estimate")

    def test_an_undecided_value_inside_its_own_bar_is_called_a_bound(self):
        """10 + 300 MPa times 1.5 is beyond 275, 10 - 300 is not: 275 / 310 = 0.887, and no end."""
        check = replace(CHECK, model=300.0)
        assert check.status is Status.UNDECIDED
        said = reason(check)
        assert "between 0.887 and no end within its error bars" in said
        assert "its model bar is wider than the value: ±300 on 10.0 MPa" in said

    def test_a_bar_as_wide_as_the_value_is_an_estimate_still(self):
        assert "wider" not in reason(replace(CHECK, numerical=10.0))

    def test_an_unknown_bar_says_why_and_what_helps(self):
        check = replace(
            CHECK, model=inf, note="no error bar: hole / width is 0.97, solids were compared from "
            "0.2 to 0.6",
        )  # fmt: skip
        assert reason(check) == (
            "safety 27.5, 1.5 required; its model error bar is unknown (hole / width is 0.97, "
            "solids were compared from 0.2 to 0.6): a better model may settle it"
        )

    def test_a_utilisation_of_any_size_is_written(self):
        """Decimals to 0.01 of more than 1e26 are more digits than a decimal number has."""
        assert utilisation_text(1.234) == "1.24"
        assert utilisation_text(1.2341e30) == "1.24e+30"

    def test_a_limit_of_zero_is_refused(self):
        with pytest.raises(ValueError, match="rod static: limit and required safety must be above"):
            replace(CHECK, limit=0.0)

    @pytest.mark.parametrize("key", ["yield_stress", "ultimate_stress", "youngs_modulus"])
    def test_a_strength_of_zero_is_refused_at_the_door(self, tmp_path, key):
        values = {"yield_stress": 275, "ultimate_stress": 430, "youngs_modulus": 210000, key: 0}
        material = (
            "[materials.wax]\n"
            + "".join(f'{name} = "{value} MPa"\n' for name, value in values.items())
            + 'poisson_ratio = 0.3\ndensity = "900 kg/m3"\nsource = "a candle"\n'
        )
        with pytest.raises(DesignError, match=rf"materials.wax.{key}: .*got 0 MPa"):
            machine(tmp_path, material + PLATE.replace("S275", "wax"))


def test_a_solid_that_is_asked_for_buckling_alone_tells_of_no_stress(tmp_path):
    """One mesh is enough for it, and a stress on one mesh has no error bar: the rungs' stand."""
    design = machine(tmp_path)
    part = design.parts["rod"]
    loads = loads_of({"first": [[400.0, 0.0, 0.0]] * 2, "second": [[-400.0, 0.0, 0.0]] * 2})
    climb = start_climb(LoadedPart(design, part, loads))
    climb.by_formula()
    for kind in ("static", "fatigue"):
        climb.best[kind] = Estimate(replace(climb.best[kind].check, model=0.0, model_below=0.0))
    climb.best["buckling"] = Estimate(replace(climb.best["buckling"].check, model=inf), inf, inf)
    assert climb.open == ["buckling"]
    result = solid_result(climb, Models(), lambda _: None, everything=False)
    told = {(check.kind, check.method.split()[0]) for check in result.checks}
    assert {("static", "formula"), ("fatigue", "formula"), ("buckling", "solid")} <= told
    assert ("static", "solid") not in told


def test_a_rung_that_gives_up_is_passed_over(tmp_path, monkeypatch):
    def gives_up(part, loads):
        raise MeshError("an element is folded")

    monkeypatch.setattr(shapes, "model_of", gives_up)
    design = machine(tmp_path)
    climb = start_climb(LoadedPart(design, design.parts["rod"], loads_of(NEVER)))
    assert not climb.by_formula()
    assert climb.tried[-1].why == "gave up: an element is folded"


def test_a_peak_of_zero_is_at_a_position_all_the_same(tmp_path):
    """The first of equals."""
    design = machine(tmp_path)
    loads, part = loads_of(NEVER), design.parts["rod"]
    level = rung_level(LoadedPart(design, part, loads), shapes.model_of(part, loads))
    assert (level.peak.value, level.peak.position) == (0.0, 0)
    assert np.array_equal(level.peaks_by_position, np.zeros(4))
