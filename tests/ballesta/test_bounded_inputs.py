"""Inputs without an end, or of a size beyond all machines, are refused at once and in few words."""

import os

import pytest

from ballesta.design.read import read_design
from checks.design.errors import DesignError
from geometry import parameters
from geometry.parameters import read_bounded

from ..small_machine import MACHINE, PLATE

TABLE = 'phases = [{ name = "round", to = "450 deg", forces = { push = %s }, solve = "drive" }]'
BY_TABLE = TABLE % '{ over = "B.x", table = "push.csv", units = ["mm", "N"] }'
ODD = """
[materials.odd]
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
density = "7850 kg/m3"
yield_stress = "300 MPa"
ultimate_stress = "500 MPa"
"""
LONG = "x" * 100_000


def refused(folder, *overrides, text=MACHINE + PLATE):
    """The problem that a design is refused for."""
    file = folder / "machine.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(DesignError) as found:
        read_design(file, overrides)
    return str(found.value)


def by_table(folder, table):
    (folder / "push.csv").write_text(table)
    old = TABLE % '"400 N"'
    assert old in MACHINE
    return refused(folder, text=MACHINE.replace(old, BY_TABLE) + PLATE)


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="a device of POSIX systems")
def test_a_device_without_an_end_is_not_read(tmp_path):
    told = refused(tmp_path, text='like = "/dev/zero"\n')
    assert "like: '/dev/zero' cannot be read: is a device or a pipe, not a file" in told


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes with names")
def test_a_pipe_that_nobody_writes_to_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    assert "is a device or a pipe" in refused(tmp_path, text='like = "pipe.toml"\n')
    with pytest.raises(DesignError, match="is a device or a pipe"):
        read_design(tmp_path / "pipe.toml")


def test_a_file_that_is_too_large_is_not_read_to_its_end(tmp_path, monkeypatch):
    monkeypatch.setattr(parameters, "MEBIBYTE", 1)
    (tmp_path / "large").write_bytes(b"x" * 100)
    assert len(read_bounded(tmp_path / "large", 100)) == 100
    with pytest.raises(OSError, match="has more than 99 MiB, the most that is read"):
        read_bounded(tmp_path / "large", 99)


def test_a_table_has_no_more_rows_than_a_cycle_has_positions(tmp_path):
    rows = "".join(f"{k},1\n" for k in range(20_002))
    assert "push.csv: has more than 20000 rows; resample it" in by_table(tmp_path, rows)


def test_a_number_in_a_table_that_would_overflow_is_refused(tmp_path):
    told = by_table(tmp_path, "0,1\n100,1e308\n")
    assert 'got "1e308 N"' in told
    assert "beyond any machine" in told


@pytest.mark.parametrize("digits", ["9" * 400, "9" * 5000, "0x" + "f" * 5000])
def test_a_whole_number_of_many_digits_is_refused_wherever_it_stands(tmp_path, digits):
    told = "a whole number that TOML does not have|cannot be read as a value"
    here = refused(tmp_path, text=MACHINE.replace("positions = 25", f"positions = {digits}"))
    assert any(words in here for words in told.split("|"))
    assert any(words in refused(tmp_path, f"accuracy={digits}") for words in told.split("|"))
    assert len(here) < 1000


@pytest.mark.parametrize("value", ["1e308 m", "-1e21 mm", "1e400 mm"])
def test_a_size_beyond_any_machine_is_refused(tmp_path, value):
    assert "beyond any machine" in refused(tmp_path, f"parts.rod.width={value}")


def test_a_length_has_a_bound_of_its_own(tmp_path):
    """5e14 mm between what holds a bar ended in a traceback, 1e14 mm in stresses of 6e19 MPa."""
    told = refused(tmp_path, "parts.rod.column.out_of_plane=5e14 mm")
    assert told.count("at most 1e+09 mm is taken") == 1
    assert "at most 1e+09 mm is taken" in refused(tmp_path, "points.B=1e14, 0 mm")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("ultimate_stress=2.9e32 MPa", "beyond any machine"),
        ("ultimate_stress=2.9e12 MPa", "must be between 1e-06 and 100000 MPa, as of any material"),
        ("youngs_modulus=1e12 MPa", "must be between 0.0001 and 1e+07 MPa, as of any material"),
        ("density=1e3 t/mm3", "must be between 1e-13 and 1e-07 t/mm3, as of any material"),
    ],
)
def test_a_material_that_there_cannot_be_is_refused_at_its_key(tmp_path, change, told):
    found = refused(tmp_path, f"materials.odd.{change}", text=MACHINE + ODD + PLATE)
    assert f"materials.odd.{change.partition('=')[0]}: " in found
    assert told in found


@pytest.mark.parametrize(
    "change",
    [f"parts.rod.width={LONG}", f"parts.rod.material={LONG}", f"parts.rod.{LONG}=1",
     f"parts.{LONG}.width=1 mm", f"gravity={LONG}", f"cycles.turn.pace.law={LONG}",
     f"name=[{LONG!r}]"],
)  # fmt: skip
def test_a_long_text_is_told_by_its_beginning_and_end(tmp_path, change):
    assert len(refused(tmp_path, change)) < 7000


def test_of_very_many_problems_the_first_are_told(tmp_path):
    unknown = "".join(f"key_{k} = 1\n" for k in range(1000))
    told = refused(
        tmp_path, text=MACHINE + PLATE.replace("[parts.rod]\n", f"[parts.rod]\n{unknown}")
    )
    assert told.endswith("and 960 more problems")
