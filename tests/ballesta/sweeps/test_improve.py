"""Single changes that make a plate pass, against what its check says of them."""

import json
import shlex
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from ballesta.cli import main
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import part_masses, solve_cycles
from ballesta.pipeline import check_design, check_file
from ballesta.sweeps.estimates import Estimates
from ballesta.sweeps.improve import MOST, improve, with_changes
from ballesta.sweeps.screen import Screening
from checks.columns.linkage_frame import linkage_check, worst_mode
from checks.design.effort import Effort
from checks.design.materials import known_materials
from checks.result.verdict import Status
from checks.stress.solid_mesh_level import Models
from reports.answer_facts import answer_text
from tests.small_machine import PLATE, machine

FORMULA = Effort("formula")
NEED = "require={{ static = {0}, fatigue = {0} }}"


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The rod of 30 x 10 mm with a hole of 12 mm, asked for 1.2 times the safety that it has.

    Its arc is stated: what a loose pin presses more goes by no size in proportion.
    """
    folder = tmp_path_factory.mktemp("improve")
    text = PLATE.replace('"8 mm"', '"10 mm"') + 'bearing_arc = "90 deg"\n'
    return machine(folder, text).file


def rod(file, *overrides):
    (part,) = check_file(file, overrides, effort=FORMULA).parts
    return min(part.checks, key=lambda check: check.limit / (check.upper * check.required))


@pytest.fixture(scope="module")
def need(file):
    """Requirement of 1.2 times the safety that the rod has."""
    check = rod(file)
    return NEED.format(1.2 * check.limit / check.upper)


@pytest.fixture(scope="module")
def improved(file, need):
    return improve(file, [need], effort=FORMULA)


def test_a_material_that_is_found_is_the_weakest_that_passes(file, need, improved):
    """Those whose yield stress is surely too low are not asked: a check of each says the same."""
    change = next(change for change in improved.changes if change.key == "parts.rod.material")
    materials = known_materials()
    old, new = materials[change.was], materials[change.value]
    weaker = [m for m in materials.values() if m.ductile and m.fkm_group == old.fkm_group
              and old.ultimate_stress < m.ultimate_stress <= new.ultimate_stress
              and m.name != new.name]  # fmt: skip
    assert weaker
    passing = [rod(file, need, f"parts.rod.material={m.name}").status for m in [*weaker, new]]
    assert [status is Status.PASS for status in passing] == [False] * len(weaker) + [True]


def test_a_thickness_that_is_found_is_the_least_size_that_passes(file, need, improved):
    """Stress goes with 1/thickness, the rod's own inertia aside: 1.2 times the thickness, so of
    R20 12.5 mm, and not 11.2.
    """
    found = improved
    assert found.result.status is not Status.PASS
    assert found.open == ("rod",)
    change = next(change for change in found.changes if change.key == "parts.rod.thickness")
    assert change.value == "12.5 mm"
    assert change.saved < 0
    after = rod(file, need, change.override)
    assert after.status is Status.PASS
    assert after.safety == pytest.approx(change.safety, rel=1e-9)
    assert rod(file, need, "parts.rod.thickness=11.2 mm").status is not Status.PASS


def test_a_wall_is_the_least_size_that_passes_where_a_wider_bar_lies_beyond_it():
    """From 12 mm on the press' bars have those of thicker walls, and pass by less than at 11.2."""
    stated = read_design(Path("designs/toggle_press.toml"), ("parts.bar_upper.bore_edges={}",))
    changes = with_changes(stated, check_design(stated, effort=FORMULA)).changes
    assert [c.value for c in changes if c.key == "parts.bar_upper.wall"] == ["11.2 mm"]


def test_no_size_beyond_the_largest_change_is_asked(file, monkeypatch):
    """Twice the thickness is short of 2.5 times the safety: nothing thicker is looked at."""
    asked = []

    def noted(known, variation, *rest, of=Screening.of, **options):
        asked.extend(v for key, v in dict(variation).items() if key == "parts.rod.thickness")
        return of(known, variation, *rest, **options)

    monkeypatch.setattr(Screening, "of", noted)
    check = rod(file)
    improve(file, [NEED.format(2.5 * check.limit / check.upper)], effort=FORMULA)
    assert max(float(text.removesuffix(" mm")) for text in asked) == MOST * 10.0


def test_what_no_formula_judges_is_no_way_out(file):
    """A hole of 29 mm leaves half a millimetre beside it in 30 mm: the formula gives up on it."""
    design = read_design(file)
    known = Estimates(design, check_design(design, effort=FORMULA))
    one = known.screened("parts.rod.hole", 29.0, "mm", ("rod",))
    assert "gave up" in one.open["rod"]
    assert not one.problem
    assert known.reserve(known.base, ("rod",)) > 0.0
    assert known.reserve(one, ("rod",)) == 0.0


def test_where_all_pass_the_mass_that_can_be_saved_is_found(file):
    check = rod(file)
    need = NEED.format(0.8 * check.limit / check.upper)
    found = improve(file, [need, "require.buckling=0.01"], effort=FORMULA)
    assert found.open == ()
    assert found.exit_code == 0
    change = next(change for change in found.changes if change.key == "parts.rod.thickness")
    assert change.saved > 0
    assert rod(file, need, change.override).status is Status.PASS
    assert change.value == "8 mm"  # 0.8 of 10
    assert rod(file, need, "parts.rod.thickness=7.1 mm").status is not Status.PASS


def test_the_command_verifies_a_change_and_writes_it_into_the_file(file, tmp_path, capsys):
    check = rod(file)
    need = f"\n[require]\nstatic = {1.2 * check.limit / check.upper}\n"
    design = tmp_path / "plate.toml"
    text = file.read_text(encoding="utf-8") + need
    design.write_text(text, encoding="utf-8")
    assert rod(design).status is not Status.PASS
    code = main(["improve", str(design), "--fidelity", "formula", "--apply", "--json"])
    (best, *_) = json.loads(capsys.readouterr().out)["changes"]
    assert code == 0
    assert best["verified"] == "pass"
    changed = design.read_text(encoding="utf-8")
    name = best["key"].rpartition(".")[2]
    assert changed == text.replace(f'{name} = "{best["was"]}"', f'{name} = "{best["value"]}"')
    assert rod(design).status is Status.PASS


def test_the_command_that_comes_next_checks_what_was_improved(file, need, capsys):
    """With the overrides that were given: without them it is another design."""
    width = ["--set", "parts.rod.width=29.5 mm"]
    main(["improve", str(file), "--fidelity", "formula", "--set", need, *width, "--json"])
    (best, *_) = json.loads(capsys.readouterr().out)["changes"]
    words = shlex.split(best["command"])
    assert words[:3] == ["ballesta", "check", str(file)]
    told = [one for flag, one in pairwise(words) if flag == "--set"]
    assert told == [need, width[1], f"{best['key']}={best['value']}"]


def test_a_line_that_the_file_does_not_have_is_not_written(file, need, capsys):
    text = file.read_text(encoding="utf-8")
    arguments = ["--fidelity", "formula", "--apply", "--set", need]
    arguments += ["--set", "parts.rod.thickness=9.9 mm", "--set", "parts.rod.width=29.5 mm"]
    assert main(["improve", str(file), *arguments]) == 2
    assert "write it by hand" in capsys.readouterr().err
    assert file.read_text(encoding="utf-8") == text


def test_a_part_of_whose_buckling_no_formula_tells_is_made_no_lighter(file):
    """As beams, whose formula has no buckling: a solid's check of it says nothing of thin walls."""
    design = read_design(file)
    result = check_design(design, effort=FORMULA)
    assert Estimates(design, result).lightened == ("rod",)
    (part,) = result.parts
    share = next(check for check in part.checks if check.kind == "buckling")
    by_solid = replace(share, quantity="share that no formula has")
    more = replace(result, parts=[replace(part, checks=[*part.checks, by_solid])])
    assert Estimates(design, more).lightened == ()


@pytest.mark.slow
def test_a_saving_with_which_the_linkage_would_buckle_goes_only_as_far_as_it_holds():
    """Links of 22 mm would do with 14 mm, but the jack as a whole has 6.61 of 5.7.

    Out of the plane its stiffness goes with the width: 6.61 * 20 / 22 = 6.01 is left, and
    6.61 * 18 / 22 = 5.41 would not do.
    """
    file, asked = Path("designs/gallery/scissors_jack.toml"), "require.buckling=5.7"
    links = [f"{level}_{side}" for level in ("lower", "upper") for side in ("left", "right")]
    # what a loose pin presses more hardly depends on the width
    arcs = [f'parts.{link}.bearing_arc="90 deg"' for link in links]
    design = read_design(file, (asked, *arcs))
    changes = with_changes(design, check_design(design, effort=FORMULA)).changes
    (width,) = (change for change in changes if change.key.endswith(".width"))
    assert width.value == "20 mm"
    (linkage,) = check_file(file, (asked, width.override), effort=FORMULA).linkage
    assert linkage.status is Status.PASS
    assert linkage.safety == pytest.approx(6.01, rel=0.02)
    smaller = read_design(file, (asked, f"{width.key}=18 mm"))
    mode = worst_mode(smaller, solve_cycles(smaller, part_masses(smaller, Models())))
    assert linkage_check(smaller, mode).status is not Status.PASS


def test_a_part_without_an_error_bar_is_no_hindrance_for_the_change_of_another():
    """With such fillets the pitman's bars are infinite by formula, whatever the pin's material."""
    far = ("require.static=3", "parts.pitman.fillet=150 mm")
    stated = read_design(Path("designs/gallery/punching_press.toml"), far)
    result = check_design(stated, effort=FORMULA)
    assert {part.name: min(c.limit / c.upper for c in part.checks) for part in result.parts}[
        "pitman"
    ] == 0
    (change,) = with_changes(stated, result).changes
    assert change.parts == ("pin_B",)
    assert change.key == "parts.pin_B.material"


def _as_by_solids(result):
    """The result, as if a solid had found the same numbers."""
    parts = [
        replace(part, checks=[replace(check, method="solid") for check in part.checks])
        for part in result.parts
    ]
    return replace(result, parts=parts)


def test_a_part_that_fails_anyway_and_keeps_its_shape_is_no_hindrance(tmp_path):
    """Both plates fail; the margin for a part's own shape is not asked of the other one.

    The arm is bent, and as strong as the rod with 40 mm.
    """
    arm = PLATE.replace("[parts.rod]", "[parts.arm]").replace('body = "rod"', 'body = "crank"')
    arm = arm.replace('first = "A", second = "B"', 'first = "O", second = "A"')
    arm = arm.replace('"8 mm"', '"40 mm"')
    stated = machine(tmp_path, PLATE + arm)
    safeties = [
        check.limit / check.upper
        for part in check_design(stated, effort=FORMULA).parts
        for check in part.checks
        if check.kind == "static"
    ]
    stated = read_design(stated.file, (f"require.static={1.2 * max(safeties)}",))
    result = _as_by_solids(check_design(stated, effort=FORMULA))
    failing = [p.name for p in result.parts if any(c.status is not Status.PASS for c in p.checks)]
    assert failing == ["rod", "arm"]
    found = with_changes(stated, result)
    assert {change.parts for change in found.changes} == {(result.deciding.part,)}
    assert found.unchanged == ""


def test_where_no_change_is_found_the_result_tells_so(file):
    """Ten times the safety is no matter of a factor of two in one dimension."""
    check = rod(file)
    design = read_design(file, [NEED.format(10 * check.limit / check.upper)])
    result = with_changes(design, check_design(design, effort=FORMULA))
    assert result.changes == []
    assert result.unchanged.startswith("no single dimension of rod within a factor of 2")
    told = answer_text(result)
    assert result.unchanged in " ".join(told.split())
    assert "ballesta improve" not in told


def test_of_twins_a_change_names_the_first(file, need, monkeypatch):
    """A reserve that differs by round-off tells nothing of which part governs."""
    design = read_design(file, [need])
    known = Estimates(design, check_design(design, effort=FORMULA))
    one = known.screened("parts.rod.width", 33.0, "mm", ("rod",))
    (reserve, safety, least, check), *_ = known.reserves(one, ("rod",))
    twins = [
        (reserve * (1 - round_off), safety, least, replace(check, part=name))
        for name, round_off in (("left", 0.0), ("right", 1e-15), ("stronger", -0.1))
    ]
    monkeypatch.setattr(known, "reserves", lambda *_: twins)
    change = known.told("parts.rod.width", "30 mm", "33 mm", ("rod",), one)
    assert change.governing == f"left {check.kind}"
