"""Sweeps: what they say, what a design has against them, their grid and their sample."""

from pathlib import Path

import pytest

from ballesta.design.read import read_design
from ballesta.sweeps.sweep import MOST, design_variations, parse_sweep, variations
from checks.design.errors import DesignError

from ...small_machine import MACHINE, PLATE

PRESS = Path(__file__).parents[3] / "designs" / "toggle_press.toml"
WALL = "parts.bar_upper.wall"
LIKE = '\n[parts.other]\nlike = "rod"\nbody = "crank"\ninterfaces = { first = "O", second = "A" }\n'


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE + PLATE + LIKE, encoding="utf-8")
    return path


def values(text):
    return [override.partition("=")[2] for (override,) in variations([text])]


def test_a_range_with_a_count_has_both_its_ends():
    assert values("wall = 4..8 mm : 9") == [
        "4 mm", "4.5 mm", "5 mm", "5.5 mm", "6 mm", "6.5 mm", "7 mm", "7.5 mm", "8 mm",
    ]  # fmt: skip


def test_a_range_with_a_step_is_the_same_range_with_its_count():
    assert values("wall=4..8mm:step 0.5 mm") == values("wall = 4 mm .. 8 mm : 9")
    assert values("wall = 0..0.3 mm : step 0.1") == ["0 mm", "0.1 mm", "0.2 mm", "0.3 mm"]


def test_counts_and_shares_are_ranges_too():
    assert values("leaves = 2..4 : 3") == ["2", "3", "4"]
    assert values("accuracy = 2..6 % : 3") == ["2 %", "4 %", "6 %"]
    assert values("x = -1.5..1.5 kN : 3") == ["-1.5 kN", "0 kN", "1.5 kN"]


def test_the_unit_of_the_last_number_is_that_of_those_without_one():
    assert values("wall = 4, 5, 6.3 mm") == ["4 mm", "5 mm", "6.3 mm"]
    assert values("wall = 4 cm, 50 mm") == ["4 cm", "50 mm"]
    assert values("material = S275, S355") == ["S275", "S355"]


def test_quotes_hold_a_value_together_that_has_commas():
    assert values('points.D = "-350, 250 mm", "-340, 250 mm"') == ["-350, 250 mm", "-340, 250 mm"]


def test_keys_that_are_joined_change_together():
    assert variations(["a.b & c.d = 1 & 2 mm, 3 & 4 mm"]) == [
        ("a.b=1", "c.d=2 mm"), ("a.b=3", "c.d=4 mm"),
    ]  # fmt: skip
    assert variations(["a.b & c.d = 1..2 mm : 2"]) == [
        ("a.b=1 mm", "c.d=1 mm"), ("a.b=2 mm", "c.d=2 mm"),
    ]  # fmt: skip


def test_several_sweeps_make_every_combination_and_the_last_runs_fastest():
    assert variations(["a.b = 1, 2", "c.d = x, y, z"]) == [
        (f"a.b={a}", f"c.d={c}") for a in "12" for c in "xyz"
    ]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("wall", "write it such as parts.bar.wall = 4..8 mm : 9"),
        ("= 4..8 mm : 9", "write it such as"),
        ("wall =", "write it such as"),
        ("wall = 4..4 mm : 9", "the range is empty"),
        ("wall = 8..4 mm : 9", "from the smaller to the larger: 4..8 mm"),
        ("wall = 4..8 mm : 1", "how many values, 2 to"),
        ("wall = 4..8 mm :", "how many values, 2 to"),
        ("wall = 4..8 mm : 2.5", "how many values, 2 to"),
        ("wall = 4..8 mm : step 0.7 mm", "do not end at 8 mm; nearest is 7.5 mm"),
        ("wall = 4..8 mm : step 5 mm", "do not end at 8 mm"),
        ("wall = 4..8 mm : step 0 mm", "the step must be above 0"),
        ("wall = 4..8 mm : step 0.5 N", "the step must be above 0 in the range's unit"),
        ("wall = 4..8 mm : step 1e-9 mm", "more than 100000 steps"),
        ("wall = 4..8 mm", "say how many values"),
        ("wall = a..b mm : 3", "a range stands alone and has two numbers"),
        ("wall = 4..thick mm : 3", "must be a number, got 'thick mm'"),
        ("wall = nan..8 mm : 3", "a range stands alone and has two numbers"),
        ("wall = 4..1e999 mm : 3", "must be finite"),
        ("wall = 4 cm..8 mm : 3", "one unit, got 'cm' and 'mm'"),
        ("wall = 4..8 mm, 9 mm", "a range stands alone"),
        ("wall = 4 mm", "is one value"),
        ("wall = 4,, 5 mm", "an item of the list is empty"),
        ("wall = 4, 5, 5 mm", "5 mm stands twice"),
        ('wall = "4 mm, 5 mm', "quotes must hold whole items"),
        ("a.b & c.d = 1 & 2 & 3, 4 & 5 & 6", "has 3 values for 2 keys"),
        ("a.b & a.b = 1, 2", "names a key twice"),
    ],
)
def test_a_sweep_that_is_not_understood_is_refused_with_what_to_write(text, told):
    with pytest.raises(DesignError) as info:
        variations([text])
    assert told in info.value.problem
    assert str(info.value.file) == "--sweep"
    assert info.value.key == text.strip()


def test_a_key_stands_in_one_sweep_only_and_not_in_set_as_well(file):
    with pytest.raises(DesignError, match=r"a\.b is varied by 'a\.b = 1, 2', too"):
        variations(["a.b = 1, 2", "a.b = 3, 4"])
    with pytest.raises(DesignError, match=r"parts\.rod\.material is varied by"):
        design_variations(file, ["material = S275, S355", "parts.rod.material = S275, C45"])
    with pytest.raises(DesignError, match="set by --set, too"):
        design_variations(file, ["material = S275, S355"], overrides=["parts.rod.material=C45"])


def test_a_grid_that_no_batch_could_run_is_refused():
    with pytest.raises(DesignError, match="makes 1000000 variations, more than 100000"):
        variations(["a.b = 1..1000 : 1000", "c.d = 1..1000 : 1000"])
    assert len(variations([f"a.b = 1..{MOST} : {MOST}"])) == MOST


def test_a_single_word_means_that_key_of_every_part_that_has_it(file):
    assert design_variations(file, ["material = S275, S355"]) == [
        (f"parts.rod.material={steel}", f"parts.other.material={steel}")
        for steel in ("S275", "S355")
    ]
    (first, _) = design_variations(PRESS, ["wall = 5, 8 mm"])
    assert first == ("parts.bar_upper.wall=5 mm", "parts.bar_lower.wall=5 mm")


def test_a_single_word_that_the_design_file_has_is_the_file_s(file):
    assert design_variations(file, ["accuracy = 3, 5 %"]) == [("accuracy=3 %",), ("accuracy=5 %",)]


@pytest.mark.parametrize(
    ("text", "key", "told"),
    [
        ("parts.rood.width = 20..30 mm : 3", "parts.rood.width", "did you mean rod?"),
        ("parts.rod.widht = 20..30 mm : 3", "parts.rod.widht", "did you mean width?"),
        ("materail = S275, S355", "materail", "did you mean material?"),
        ("material = S275, S335", "parts.rod.material", "did you mean S355?"),
        ("parts.rod.width = 20..30 N : 3", "parts.rod.width", "which is a force"),
        ("parts.rod.width = 20..30 : 3", "parts.rod.width", "without a unit"),
        ("parts.rod.width = -20..30 mm : 3", "parts.rod.width", "must be above 0 mm"),
    ],
)
def test_what_the_design_does_not_take_is_told_before_anything_is_checked(file, text, key, told):
    with pytest.raises(DesignError) as info:
        design_variations(file, [text])
    assert (info.value.file, info.value.key) == (file, key)
    assert told in info.value.problem
    assert "--set" not in info.value.problem


def test_a_sample_of_whole_numbers_is_refused_before_anything_is_checked(file):
    """Ends alone would pass: 9 and 33 positions are whole."""
    with pytest.raises(DesignError, match="must be a whole number, got 18"):
        design_variations(file, ["cycles.turn.positions = 9..33"], sample=4)
    assert len(design_variations(file, ["cycles.turn.positions = 9..33 : 25"], sample=4)) == 4


def test_a_value_that_is_right_with_another_sweep_s_value_only_is_no_error(file):
    """Holes of 40 mm do not fit in the plate of 30 mm; in one of 60 mm they do."""
    found = design_variations(file, ["parts.rod.width = 30, 60 mm", "parts.rod.hole = 12, 40 mm"])
    assert len(found) == 4
    read_design(file, found[-1])


def test_every_variation_of_a_sample_lies_within_the_ranges_and_reads(file):
    sweeps = ["parts.rod.width = 20..30 mm", "material = S275, S355", "accuracy = 2..4 % : 3"]
    found = design_variations(file, sweeps, sample=64)
    widths = [float(v[0].partition("=")[2].removesuffix(" mm")) for v in found]
    assert len(found) == 64
    assert 20 <= min(widths) < 20.5
    assert 29.5 < max(widths) <= 30
    assert {v[-1] for v in found} == {"accuracy=2 %", "accuracy=3 %", "accuracy=4 %"}
    assert {v[1] for v in found} == {"parts.rod.material=S275", "parts.rod.material=S355"}
    assert read_design(file, found[0]).parts["rod"].geometry.width == widths[0]


def test_a_sample_fills_the_space_evenly():
    """Any 64 first points of a Sobol sequence hit each of 8 x 8 cells once (a (0, 6, 2)-net)."""
    found = variations(["a.x = 0..1", "a.y = 0..1"], 64)
    cells = {tuple(int(float(text.partition("=")[2]) * 8) for text in v) for v in found}
    assert len(cells) == 64


def test_a_seed_gives_the_same_sample_and_a_larger_sample_begins_with_a_smaller():
    sweeps = ["a.x = 0..1 mm", "a.y = 2, 3"]
    assert variations(sweeps, 200, 7) == variations(sweeps, 200, 7)
    assert variations(sweeps, 200, 7)[:50] == variations(sweeps, 50, 7)
    assert variations(sweeps, 200, 7) != variations(sweeps, 200, 8)
    assert len(variations(sweeps, 200, 7)) == 200


def test_variations_of_a_sample_that_come_out_alike_stand_there_once():
    assert sorted(variations(["a.b = 1, 2, 3"], 64)) == [("a.b=1",), ("a.b=2",), ("a.b=3",)]


@pytest.mark.parametrize(("sample", "seed", "key"), [(1, 0, "--sample"), (8, -1, "--seed")])
def test_a_sample_of_one_and_a_seed_below_zero_are_refused(sample, seed, key):
    with pytest.raises(DesignError) as info:
        variations(["a.b = 1..2 mm"], sample, seed)
    assert info.value.key == key


def test_a_sample_needs_a_sweep():
    with pytest.raises(DesignError, match="needs a --sweep"):
        variations([], 8)
    assert variations([]) == [()]


def test_a_sweep_keeps_what_the_user_wrote():
    assert parse_sweep(" wall = 4, 5 mm ").text.strip() == "wall = 4, 5 mm"
