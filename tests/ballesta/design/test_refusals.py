"""Every refusal of the door, by its wording: the message is part of the interface."""

# ruff: noqa: E501 - one refusal a line: the change of the file, then the wording

import pickle
from pathlib import Path

import pytest

from ballesta.design.authoring import new_design
from ballesta.design.read import read_design
from checks.design.errors import DesignError, DesignErrors

from ...small_machine import PLATE, machine

TEXT = new_design("toggle_press")


def read(tmp_path, *changes, overrides=()):
    """Read the toggle press with pieces of its text exchanged."""
    text = TEXT
    for old, new in changes:
        assert text.count(old) >= 1, old
        text = text.replace(old, new, 1)
    file = tmp_path / "press.toml"
    file.write_text(text)
    return read_design(file, overrides)


UPPER = 'body = "upper"\nshape'
FITS = 'fits = { knee = "H7/f7", end = "H7/f7" }'
EDGES = 'bore_edges = { knee = "run_in" }'
REFUSED = {
    "unknown key": (('width = "80 mm"', 'widht = "80 mm"'), r"parts\.bar_upper\.widht: unknown key, did you mean width\?"),
    "missing unit": (('wall = "6.3 mm"', "wall = 6.3"), r'press\.toml: parts\.bar_upper\.wall: must be a length such as "6\.3 mm", got 6\.3 without a unit'),
    "wrong dimension": (('width = "80 mm"', 'width = "250 kg"'), r'parts\.bar_upper\.width: must be a length such as "6\.3 mm", got "250 kg", which is a mass'),
    "decimal comma": (('wall = "6.3 mm"', 'wall = "6,3 mm"'), r"decimals are written with a point"),
    "infinite": (('mass = "10 kg"', "mass = inf"), r"bodies\.mould\.mass: .*not finite"),
    "not a number": (('mass = "10 kg"', "mass = nan"), r"bodies\.mould\.mass: .*not finite"),
    "unit of several sizes": (('mass = "10 kg"', 'mass = "2 ton"'), r'unit "ton" is 1000 kg to some, 907 or 1016 kg to others: write t'),
    "unknown unit": (('width = "80 mm"', 'width = "80 milimeter"'), r'unit "milimeter" is unknown'),
    "negative mass": (('mass = "10 kg"', 'mass = "-10 kg"'), r'bodies\.mould\.mass: must be at least 0 kg, got "-10 kg"'),
    "hole beyond width": (('hole = "44 mm"', 'hole = "90 mm"'), r"parts\.bar_upper\.hole: 90 mm is larger than the bar's width of 80 mm"),
    "hole beyond cheek": (('hole = "44 mm"', 'hole = "65 mm"'), r"bar_upper\.hole: 65 mm cuts into the side walls; it must be below 61\.4 mm"),
    "hole beyond overhang": (('overhang = "40 mm"', 'overhang = "20 mm"'), r"bar_upper\.overhang: 20 mm does not hold the hole of 44 mm"),
    "wall too thick": (('wall = "6.3 mm"', 'wall = "40 mm"'), r"bar_upper\.wall: 40 mm is too thick"),
    "corner radius": (('cutout_corner = "5 mm"', 'cutout_corner = "34 mm"'), r"cutout_corner: 34 mm is too large .* below 33\.7 mm"),
    "inner radius": (('inner_radius = "3 mm"', 'inner_radius = "34 mm"'), r"inner_radius: 34 mm is too large"),
    "long cut-out": (('cutout_length = "56 mm"', 'cutout_length = "330 mm"'), r"cutout_length: 330 mm is longer than the bar, which is 330 mm"),
    "stated length": (('width = "80 mm"', 'width = "80 mm"\nlength = "250 mm"'), r"bar_upper\.length: must not be stated: .* follows from the points"),
    "no body": ((UPPER, "shape"), r"parts\.bar_upper\.body: must be stated: the body that this part is"),
    "unknown body": ((UPPER, 'body = "uper"\nshape'), r"parts\.bar_upper\.body: no body is named 'uper', did you mean upper\? There are lower, upper, mould"),
    "two parts": (('body = "lower"\ninterfaces = { knee = "B", end = "C"', 'body = "upper"\ninterfaces = { knee = "B", end = "A"'), r"bar_lower\.body: bar_upper is already the part of body upper"),
    "unknown joint": (('joint = "B"', 'joint = "E"'), r"pin_B\.joint: no joint is named 'E'"),
    "unknown shape": (('shape = "toggle_bar"', 'shape = "togle_bar"'), r"parts\.bar_upper: no shape is named 'togle_bar', did you mean toggle_bar\? There are i_beam, leaf_pack, pin, plate_link"),
    "unknown material": (('material = "S355"', 'material = "S335"'), r"bar_upper\.material: no material is named 'S335', did you mean S355\?"),
    "unknown interface": (('{ knee = "B", end = "A" }', '{ kne = "B", end = "A" }'), r"interfaces\.kne: no interface of toggle_bar is named 'kne', did you mean knee\?"),
    "unknown point": (('pins = ["B", "A"]', 'pins = ["B", "E"]'), r"bodies\.upper\.pins\[1\]: no point is named 'E'"),
    "idle point": (('[bodies.lower]', 'E = "1, 2 mm"\n[bodies.lower]'), r"points\.E: no body has it"),
    "lonely point": (('pins = ["B", "A"]', 'pins = ["B", "A", "E"]\n[points.x]'), r"points\.x: must be two numbers"),
    "unknown force": (('solve = "process" ', 'solve = "proces" '), r"phases\[1\]\.solve: no force is named 'proces', did you mean process\?"),
    "given and solved": (('forces = { cylinder = "11 kN" }', 'forces = { cylinder = "11 kN", process = "1 kN" }'), r"phases\[1\]\.solve: phase 'press' both gives and solves process"),
    "neither": (('forces = { process = "0 N" }\n', ""), r"phases\[0\]\.forces: phase 'approach' leaves process neither given nor solved"),
    "angle for a height": (('to = "493 mm"', 'to = "49 deg"'), r"phases\[0\]\.to: must be a length .*, got an angle"),
    "bad coordinate": (('coordinate = "A.y"', 'coordinate = "A.z"'), r"cycles\.press\.coordinate: must be <point>\.x"),
    "duty of no cycle": (("{ press = 1.1e7 }", "{ pres = 1.1e7 }"), r"duty\.cycles\.pres: no cycle is named 'pres', did you mean press\?"),
    "no runs": (("{ press = 1.1e7 }", "{ press = 0 }"), r"duty\.cycles\.press: must be above 0, got 0"),
    "turns per minute": (('rate = "20 1/min"', 'rate = "20 rpm"'), r"duty\.rate: .*which is an angular speed"),
    "negative tolerance": (('tolerance = "1 mm"', 'tolerance = "-1 mm"'), r"cycles\.press\.stop\.tolerance: must be at least 0: it counts to either side"),
    "all energy lost": (("[duty]", "[dynamics]\ndamping = 1\n[duty]"), r"dynamics\.damping: must be below 1, got 1$"),
    "no safety": (("static = 1.5", "static = 0"), r"require\.static: must be above 0, got 0"),
    "unknown like": (('like = "bar_upper"', 'like = "bar_uper"'), r"bar_lower\.like: no table in parts is named 'bar_uper', did you mean bar_upper\?"),
    "circle": (('[parts.bar_upper]', '[parts.bar_upper]\nlike = "bar_lower"'), r"like: goes round in a circle: bar_upper is like bar_lower is like bar_upper"),
    "thick pin": (('diameter = "40 mm"', 'diameter = "50 mm"'), r"pin_B\.diameter: a pin of 50 mm cannot pass bar_upper, which has 44 mm"),
    "overlapping lugs": (('at = "32.65 mm"', 'at = "40 mm"'), r"pin_B\.stack: 'upper' and 'lower' overlap by 3\.35 mm"),
    "lug left out": (('{ body = "upper", at', '{ force = "cylinder", at'), r"pin_B\.stack: joint B also has upper"),
    "on": (('on = "lower"', 'on = "mould"'), r"forces\.cylinder\.on: body mould has neither D nor B"),
    "massless": (('mass = "10 kg"\n', ""), r"bodies\.mould\.mass: must be stated"),
    "assumed key": (('"duty.cycles.press" =', '"duty.cycle.press" ='), r"assumed\.duty\.cycle\.press: the design has no such key, did you mean duty\.cycles\.press\?"),
    "Poisson": (('[points] ', '[materials.odd]\nyoungs_modulus = "1 GPa"\npoisson_ratio = 0.5\ndensity = "1 t/m3"\nyield_stress = "1 MPa"\nultimate_stress = "2 MPa"\n[points] '), r"materials\.odd\.poisson_ratio: must be above -1 and below 0\.5, got 0\.5"),
    "fit of no bore": ((FITS, 'fits = { kne = "H7/f7" }'), r"bar_upper\.fits\.kne: no bore of the part is named 'kne', did you mean knee\?"),
    "edges of no bore": ((EDGES, 'bore_edges = { kne = "run_in" }'), r"bar_upper\.bore_edges\.kne: no bore of the part is named 'kne', did you mean knee\?"),
    "edges unknown": ((EDGES, 'bore_edges = { knee = "runin" }'), r"bar_upper\.bore_edges\.knee: must be 'run_in', got \"runin\", did you mean run_in\?"),
    "fit unknown": ((FITS, 'fits = { knee = "H7/p6" }'), r"bar_upper\.fits\.knee: fits with clearance are known for bores D to H and pins d to h, not p"),
    "clearance below 0": ((FITS, 'fits = { knee = "-0.01 .. 0.02 mm" }'), r"bar_upper\.fits\.knee: must be a clearance of at least 0 mm"),
    "survival of all": ((FITS, 'reliability = "99.99999 %"'), r"bar_upper\.reliability: must be at most 99\.9999 %, got"),
    "survival of few": ((FITS, 'reliability = "1 %"'), r"bar_upper\.reliability: must be at least 50 %, got"),
    "clearance of a tenth": ((FITS, 'fits = { knee = "6 mm" }'), r"fits\.knee: a clearance of 6 mm is more than a tenth of the bore's diameter of 44 mm"),
    "clearance without unit": ((FITS, 'fits = { knee = "0.02 .. 0.06" }'), r'fits\.knee: must be a fit such as "H7/f7", or a clearance'),
    "not TOML": (('name = "Toggle press"', "name = Toggle press"), r"press\.toml: line 4, column \d+: is not TOML: Invalid value"),
    "braces over two lines": (('width = "43 mm", diameter', 'width = "43 mm",\ndiameter'), r"line \d+, column \d+: is not TOML: .*: a table in braces must end on the line that it begins on"),
    "brace on the next line": (('diameter = "35 mm" }', 'diameter = "35 mm"  # stepped\n}'), r"is not TOML: .*: a table in braces must end on the line"),
    "table twice": (("[parts.bar_lower]", "[parts.bar_upper]"), r"line \d+, column \d+: is not TOML: Cannot declare"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_design_that_cannot_be_meant_is_refused_at_its_key(case, tmp_path):
    change, message = REFUSED[case]
    with pytest.raises(DesignError, match=message):
        read(tmp_path, change)


def test_a_part_may_have_the_name_of_a_shape(tmp_path):
    with pytest.raises(
        DesignError, match=r"parts\.pin\.diametr: unknown key, did you mean diameter"
    ):
        read(tmp_path, ("[parts.pin_B]", "[parts.pin]\ndiametr = '1 mm'"))


def test_a_point_on_one_body_that_nothing_needs_is_refused(tmp_path):
    with pytest.raises(DesignError, match=r"points\.E: is on body upper only, and neither ground"):
        read(
            tmp_path,
            ("[bodies.lower]", 'E = "1, 2 mm"\n[bodies.lower]'),
            ('pins = ["B", "A"]', 'pins = ["B", "A", "E"]'),
        )


def test_a_point_of_the_ground_that_no_body_has_is_refused_with_what_to_do(tmp_path):
    changes = (
        ("[bodies.lower]", 'E = "1, 2 mm"\n[bodies.lower]'),
        ('ground = ["C", "D"]', 'ground = ["C", "D", "E"]'),
    )
    told = r"points\.E: no body has it .*, though it stands in ground; remove it, or add it to a"
    with pytest.raises(DesignError, match=told):
        read(tmp_path, *changes)


def test_a_decimal_comma_in_a_point_is_named(tmp_path):
    with pytest.raises(DesignError, match=r"points\.B: .*; decimals are written with a point"):
        read(tmp_path, ('B = "200, 150 mm"', 'B = "200,5, 150 mm"'))


@pytest.mark.parametrize(("speed", "told"), [("-0.1 m/s", True), ("0 m/s", False)])
def test_a_negative_speed_is_told_where_the_direction_comes_from(tmp_path, speed, told):
    with pytest.raises(DesignError, match=r"pace\.speed: must be above 0") as caught:
        read(tmp_path, ('speed = "0.1 m/s"', f'speed = "{speed}"'))
    assert ("the direction comes from `to`" in str(caught.value)) is told


def test_several_problems_are_all_told_and_an_inherited_one_once(tmp_path):
    with pytest.raises(DesignErrors) as caught:
        read(tmp_path, ('wall = "6.3 mm"', "wall = 6.3"), ('mass = "10 kg"', 'mass = "-10 kg"'))
    assert [error.key for error in caught.value.errors] == [
        "bodies.mould.mass",
        "parts.bar_upper.wall",
    ]
    assert len(str(caught.value).splitlines()) == 2


def test_a_misspelt_key_that_must_be_stated_is_told_once(tmp_path):
    with pytest.raises(DesignError) as caught:
        read(tmp_path, ('material = "S355"', 'materiel = "S355"'))
    assert str(caught.value).endswith("bar_upper.materiel: unknown key, did you mean material?")


def test_a_misspelt_force_is_told_without_what_follows_from_it(tmp_path):
    """The force that is meant stands nowhere, so it was told as neither given nor solved, too."""
    with pytest.raises(DesignErrors) as caught:
        read(
            tmp_path,
            ('forces = { process = "0 N" }', 'forces = { proces = "0 N" }'),
            ('solve = "process" ', 'solve = "proces" '),
        )
    assert all("did you mean process?" in str(error) for error in caught.value.errors)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", r"cannot be read: the file is empty"),
        (b"name = 'x'\n\xff", r"line 2: is not UTF-8"),
        (None, r"cannot be read: there is no such file"),
    ],
)
def test_a_file_that_is_no_design_is_refused(content, message, tmp_path):
    file = tmp_path / "x.toml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(DesignError, match=message):
        read_design(file)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "linkage",
            r"press\.toml: parts\.linkage: stands for the linkage as a whole; give the part another name",
        ),
        ("x" * 201, r"press\.toml: parts\.x{39}…: a part's name .* at most 200 letters, got 201"),
    ],
)
def test_a_part_may_not_have_the_name_of_the_whole_or_one_that_no_file_can_have(
    name, message, tmp_path
):
    with pytest.raises(DesignError, match=message):
        read(tmp_path, ("[parts.pin_B]", f"[parts.{name}]"))


@pytest.mark.parametrize("name", ["Linkage", "x" * 200])
def test_a_part_may_have_any_other_name(name, tmp_path):
    assert name in machine(tmp_path, PLATE.replace("parts.rod", f"parts.{name}")).parts


def test_an_error_is_one_line_also_where_a_name_is_not(tmp_path):
    with pytest.raises(DesignError) as caught:
        read(tmp_path, ("[parts.pin_B]", '[parts."pin\\nB\\u001b[31m"]'))
    assert len(str(caught.value).splitlines()) == 1
    assert "\x1b" not in str(caught.value)
    assert "parts.pin B" in str(caught.value)


def test_a_directory_is_refused(tmp_path):
    with pytest.raises(DesignError, match="is a directory"):
        read_design(tmp_path)


def test_errors_survive_the_way_between_processes():
    one = DesignError(Path("a.toml"), "key", "problem")
    many = DesignErrors((one, DesignError(Path("a.toml"), "other", "worse")))
    assert str(pickle.loads(pickle.dumps(one))) == "a.toml: key: problem"
    assert str(pickle.loads(pickle.dumps(many))) == str(many)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("parts.bar_uper.wall=5mm", r"nothing is named 'bar_uper', did you mean bar_upper\?"),
        (
            "parts.bar_upper.wal=5mm",
            r"bar_upper\.wal: unknown key, did you mean wall\? \(from --set\)",
        ),
        ("parts.bar_upper.wall=5", r"got 5 without a unit \(from --set\)"),
        ("cycles.press.phases[7].to=1 mm", r"cycles\.press\.phases is a list of 3"),
        ("nonsense", "must be written key=value"),
    ],
)
def test_an_override_that_leads_nowhere_is_refused(override, message, tmp_path):
    with pytest.raises(DesignError, match=message):
        read(tmp_path, overrides=[override])
