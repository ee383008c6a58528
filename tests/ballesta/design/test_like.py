"""A design file that is like another: what is taken over, and where its errors are told."""

import hashlib
from pathlib import Path

import jsonschema
import pytest

from ballesta.design.authoring import design_schema
from ballesta.design.read import read_design
from checks.design.errors import DesignError, DesignErrors

DESIGNS = Path(__file__).parents[3] / "designs"
PRESS = DESIGNS / "toggle_press.toml"


def derived(tmp_path, text, name="derived.toml"):
    (tmp_path / "press.toml").write_text(PRESS.read_text())
    file = tmp_path / name
    file.write_text(text)
    return file


def test_tables_merge_key_by_key_and_values_and_lists_replace(tmp_path):
    file = derived(
        tmp_path,
        'like = "press.toml"\nname = "Thin"\nparts.bar_upper.wall = "5 mm"\n'
        'require = { buckling = 2.0 }\nground = ["D", "C"]\n',
    )
    design, base = read_design(file), read_design(PRESS)
    assert design.name == "Thin"
    assert design.parts["bar_upper"].geometry.wall == 5.0
    assert design.parts["bar_lower"].geometry.wall == 5.0, "like bar_upper, in the base"
    assert design.parts["bar_upper"].geometry.hole == base.parts["bar_upper"].geometry.hole
    assert (design.require.buckling, design.require.static) == (2.0, 1.5)
    assert tuple(design.ground.points) == ("D", "C", "guide:mould")
    assert design.cycles == base.cycles
    bears = {f"parts.pin_B.stack[{k}].width" for k in (0, 1)}  # on 5 mm, where 6.3 are stated
    told = dict(design.assumed)
    assert {key: told.pop(key) for key in bears}.keys() == bears
    assert told == dict(base.assumed), "the reasons of the base hold on"


def test_a_chain_of_files_is_followed_and_all_of_them_are_kept(tmp_path):
    derived(tmp_path, 'like = "press.toml"\nbodies.mould.mass = "12 kg"\n', "heavy.toml")
    file = derived(tmp_path, 'like = "heavy.toml"\naccuracy = "3 %"\n')
    design = read_design(file)
    assert (design.bodies["mould"].mass, design.accuracy) == (12e-3, 0.03)
    assert [Path(path).name for path, _ in design.sources] == [
        "press.toml",
        "heavy.toml",
        "derived.toml",
    ]
    assert design.source == file.read_text()
    texts = "".join(text for _, text in design.sources)
    assert design.sha256 == hashlib.sha256(texts.encode()).hexdigest()
    assert dict(design.inputs)["bodies.mould.mass"] == "12 kg"
    assert dict(design.inputs)["accuracy"] == "3 %"


def test_a_single_file_has_the_checksum_of_its_text():
    design = read_design(PRESS)
    assert design.sha256 == hashlib.sha256(PRESS.read_bytes()).hexdigest()
    assert design.sources == ((str(PRESS), PRESS.read_text()),)


def test_an_override_reaches_what_the_base_states(tmp_path):
    file = derived(tmp_path, 'like = "press.toml"\n')
    design = read_design(file, ["parts.bar_upper.wall=5mm", "cycles.press.phases[1].to=497 mm"])
    assert design.parts["bar_lower"].geometry.wall == 5.0
    assert design.cycles["press"].run.phases[1].stop == 497.0
    assert dict(design.inputs)["parts.bar_upper.wall"] == "5mm"
    with pytest.raises(DesignError, match=r"derived\.toml: parts\.bar_upper\.wal: unknown key"):
        read_design(file, ["parts.bar_upper.wal=5 mm"])


def test_a_reason_lapses_with_the_key_that_a_later_file_or_an_override_replaces(tmp_path):
    phases = '[{ name = "up", to = "498 mm", forces = { process = "0 N" }, solve = "cylinder" }]'
    file = derived(tmp_path, f'like = "press.toml"\ncycles.press = {{ phases = {phases} }}\n')
    base = tmp_path / "press.toml"
    base.write_text(
        base.read_text().replace('"cycles.press.phases[0].to"', '"cycles.press.phases[2].to"')
    )
    assert "cycles.press.phases[2].to" in dict(read_design(base).assumed)
    assert "cycles.press.phases[2].to" not in dict(read_design(file).assumed)
    replaced = read_design(base, [f"cycles.press.phases={phases}"])
    assert "cycles.press.phases[2].to" not in dict(replaced.assumed)


def test_a_table_of_a_force_is_looked_for_beside_the_file_that_names_it(tmp_path):
    text = (DESIGNS / "slider_crank.toml").read_text()
    table = 'push = { over = "B.x", table = "work.csv", units = ["mm", "N"] }'
    (tmp_path / "base").mkdir()
    (tmp_path / "base" / "crank.toml").write_text(text.replace('push = "0 N"', table))
    (tmp_path / "base" / "work.csv").write_text("0,1\n300,2\n")
    file = tmp_path / "derived.toml"
    file.write_text('like = "base/crank.toml"\n')
    law = read_design(file).cycles["bench"].run.phases[0].given["push"]
    assert law.forces == (1.0, 2.0)


def test_an_error_names_the_file_that_its_key_stands_in(tmp_path):
    file = derived(
        tmp_path, 'like = "press.toml"\nparts.bar_upper.wall = 6.3\nbodies.mould.guide.alng = "x"\n'
    )
    base = tmp_path / "press.toml"
    base.write_text(PRESS.read_text().replace('mass = "10 kg"', 'mass = "10 m"'))
    with pytest.raises(DesignErrors) as caught:
        read_design(file)
    assert {(error.key, error.file.name) for error in caught.value.errors} == {
        ("parts.bar_upper.wall", "derived.toml"),
        ("bodies.mould.guide.alng", "derived.toml"),
        ("bodies.mould.mass", "press.toml"),
    }


@pytest.mark.parametrize(
    ("like", "message"),
    [
        ('"pres.toml"', r"derived\.toml: like: 'pres\.toml' cannot be read: there is no such file, "
                        r"did you mean press\.toml\?"),
        ('"nowhere/press.toml"', r"like: 'nowhere/press\.toml' cannot be read: there is no such"),
        ('"derived.toml"', r"like: goes round in a circle: derived\.toml is like derived\.toml"),
        ('"."', r"like: '\.' cannot be read: is a directory, not a file"),
        ("3", r'like: must be another design file such as "press\.toml", got 3'),
        ('""', r"like: must be another design file"),
        ('"empty.toml"', r"like: 'empty\.toml' cannot be read: the file is empty"),
        ('"broken.toml"', r"broken\.toml: line 1, column \d+: is not TOML"),
        ('"binary.toml"', r"like: 'binary\.toml' cannot be read: is not UTF-8 text"),
        (r'"a\u0000b.toml"', r"like: .* cannot be read: embedded null"),
    ],
)  # fmt: skip
def test_a_base_that_cannot_be_taken_is_refused(like, message, tmp_path):
    (tmp_path / "empty.toml").write_text("\n")
    (tmp_path / "broken.toml").write_text("name = x\n")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\n")
    with pytest.raises(DesignError, match=message):
        read_design(derived(tmp_path, f"like = {like}\n"))


def test_a_circle_of_files_is_told_with_its_way(tmp_path):
    derived(tmp_path, 'like = "derived.toml"\n', "other.toml")
    with pytest.raises(DesignError) as caught:
        read_design(derived(tmp_path, 'like = "./other.toml"\n'))
    assert "derived.toml is like other.toml is like derived.toml" in str(caught.value)


def test_the_schema_takes_a_part_of_a_design_only_where_it_is_like_another():
    schema = jsonschema.Draft202012Validator(design_schema())
    piece = {"parts": {"bar_upper": {"wall": "5 mm"}}, "bodies": {"mould": {"mass": "12 kg"}}}
    assert not schema.is_valid(piece)
    assert schema.is_valid({"like": "press.toml", **piece})
    assert not schema.is_valid({"like": "press.toml", "parts": {"bar_upper": {"wall": 5}}})
    assert not schema.is_valid({"like": "press.toml", "bodies": {"mould": {"mas": "12 kg"}}})
