"""The list of materials, and all values of one."""

import re

import pytest

from ballesta.cli import main
from checks.design.materials import known_materials


def test_the_list_has_every_material_with_its_strengths(capsys):
    assert main(["materials"]) == 0
    head, *rows = capsys.readouterr().out.splitlines()
    assert head.split() == [
        "material",
        "yield,",
        "MPa",
        "ultimate,",
        "MPa",
        "E,",
        "GPa",
        "up",
        "to",
    ]
    assert [row.split()[0] for row in rows] == list(known_materials())
    (steel,) = (row for row in rows if row.split()[0] == "S355")
    assert "355 .. 275" in steel
    assert "470 .. 450" in steel
    assert steel.endswith("250 mm")


@pytest.mark.parametrize("name", known_materials())
def test_one_material_has_all_of_its_values_and_its_source(name, capsys):
    material = known_materials()[name]
    assert main(["materials", name]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 100
    said = " ".join(" ".join(lines).split())
    assert f"E {material.youngs_modulus / 1e3:g} GPa" in said
    for grade in material.grades:
        assert f"yield {grade.yield_stress:g} MPa" in said
    assert said.count("strength yield") == len(material.grades)
    assert "source " + " ".join(material.source.split()) in said
    assert ("brittle" in said) is (not material.ductile)
    if material.endurance_ratio:
        cycles = f"of the ultimate strength at {material.endurance_cycles:g} cycles"
        assert f"{material.endurance_ratio:g} {cycles}" in said


@pytest.mark.parametrize(
    ("name", "nearest"),
    [
        ("S335", "S355"),
        ("S460", "S460N"),
        ("X5CrNi1810", "X5CrNi18-10"),
        ("X20Cr13", "X20Cr13_QT[78]00"),
        ("GJS-500-7", "EN-GJS-500-7"),
        ("7075-T6", "7075-T651"),
    ],
)
def test_a_name_that_is_none_gets_the_nearest(name, nearest, capsys):
    assert main(["materials", name]) == 2
    assert re.search(f"did you mean {nearest}\\b", capsys.readouterr().err)
