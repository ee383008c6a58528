"""A part exported for CalculiX, solved there, and what is refused."""

import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.commands.export import export_cycle, export_part, run_export
from bench.frd_file import read_frd
from checks.design.errors import DesignError
from fem.recovery import von_mises

PRESS = Path(__file__).parents[3] / "designs" / "toggle_press.toml"
COARSE = [
    "parts.bar_upper.mesh.fineness=0.4",
    "cycles.press.positions=31",
    "cycles.capacity.positions=31",
]


@pytest.fixture(scope="module")
def worst(tmp_path_factory):
    out = tmp_path_factory.mktemp("export") / "bar.inp"
    return export_part(PRESS, "bar_upper", out=out, overrides=COARSE)


def forces_of(deck):
    """Node coordinates and nodal forces of a deck's only step."""
    text = deck.read_text(encoding="ascii")
    nodes = re.search(r"\*NODE, NSET=ALL\n(.*?)\n\*", text, re.S)[1]
    nodes = np.array([row.split(",") for row in nodes.splitlines()], dtype=float)[:, 1:]
    loads = re.search(r"\*CLOAD\n(.*?)\n\*", text, re.S)[1]
    forces = np.zeros_like(nodes)
    for row in loads.splitlines():
        node, axis, size = row.split(",")
        forces[int(node) - 1, int(axis) - 1] += float(size)
    return nodes, forces


def test_the_worst_position_is_where_the_press_pushes_hardest(worst):
    """x = 2 mm, the end of the stroke: some 62 kN along the bar, 206.9 MPa on this mesh."""
    assert worst.position.startswith("x = 2 mm")
    assert_allclose(worst.peak, 206.9, rtol=0.01)
    assert worst.place.startswith("knee")
    assert_allclose(worst.resultants["knee"][0], 61568, rtol=1e-3)


@pytest.mark.slow
def test_a_volume_over_the_cycle_has_the_peak_of_the_deck_at_its_position(worst, tmp_path):
    """Stress in single precision, 1e-6; displacement is continuous, stress a tensor of six."""
    (file,) = export_cycle(PRESS, "bar_upper", cycle="press", out=tmp_path, overrides=COARSE)
    steps = ElementTree.parse(file).getroot().findall("Collection/DataSet")
    times = [float(step.get("timestep")) for step in steps]
    assert len(steps) >= 31
    assert times == sorted(times)
    peaks = []
    for step in steps:
        mesh = meshio.read(tmp_path / step.get("file"))
        assert mesh.cells[0].type == "tetra10"
        assert mesh.point_data["displacement [mm]"].shape == mesh.points.shape
        peaks.append(von_mises(mesh.point_data["stress [MPa]"].astype(float)).max())
    assert_allclose(max(peaks), worst.peak, rtol=1e-5)


def test_the_forces_in_the_deck_balance_and_hold_the_pin_forces(worst):
    """Forces and moments of everything, inertia included; of the knee's half what is told."""
    nodes, forces = forces_of(worst.file)
    largest = worst.resultants["knee"][0]
    assert_allclose(forces.sum(axis=0), 0, atol=1e-8 * largest)
    moments = np.cross(nodes, forces).sum(axis=0)
    assert_allclose(moments, 0, atol=1e-6 * largest * 250)
    left = forces[nodes[:, 0] < 125].sum(axis=0)  # the knee's and half the weight, some 20 N
    assert_allclose(left[:2], worst.resultants["knee"][:2], atol=50)


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_calculix_finds_the_peak_within_three_percent_and_no_reaction(worst):
    """Averaging by volume or not is all that is different; 0.1 % measured on this mesh."""
    deck = worst.file
    done = subprocess.run(
        ["ccx", deck.stem], cwd=deck.parent, capture_output=True, text=True, timeout=120
    )
    assert "Job finished" in done.stdout, done.stdout[-2000:]
    (step,) = read_frd(deck.with_suffix(".frd"))
    assert_allclose(von_mises(step.fields["STRESS"]).max(), worst.peak, rtol=0.03)
    _, forces = forces_of(deck)
    largest = worst.resultants["knee"][0]
    assert_allclose(step.fields["FORC"], forces, rtol=0, atol=1e-5 * largest)


def test_the_header_tells_part_design_position_and_units(worst):
    head = worst.file.read_text(encoding="ascii")[:1500]
    assert "Toggle press: bar_upper at x = 2 mm" in head
    assert "Design file toggle_press.toml, sha256 " in head
    assert "Units: mm, N, MPa" in head
    assert f"{worst.peak:.6g} MPa" in head


def test_a_position_is_the_nearest_one_of_its_cycle(tmp_path):
    """31 positions over the stroke and less force further open: x = 3.1 mm takes a neighbour."""
    out = tmp_path / "deep" / "bar.inp"
    done = export_part(PRESS, "bar_upper", "3.1", cycle="press", out=out, overrides=COARSE)
    shown = float(re.match(r"x = (\S+) mm", done.position)[1])
    assert abs(shown - 3.1) < 1.0
    assert done.peak < 200
    assert out.exists()


def test_a_position_of_a_later_cycle_is_that_cycle_s(tmp_path):
    """Both cycles pass x = 2 mm; the second one's positions are counted from its own start."""
    out = tmp_path / "bar.inp"
    done = export_part(PRESS, "bar_upper", "2", cycle="capacity", out=out, overrides=COARSE)
    assert done.position == "x = 2 mm full_pull (cycle capacity)"
    assert done.peak > 200


@pytest.mark.parametrize(
    ("at", "phase"),
    [("x = 7 mm return", "return"), ("7 mm return", "return"), ("x=7mm approach", "approach")],
)
def test_a_position_can_be_copied_from_a_report(tmp_path, at, phase):
    """The press passes x = 7 mm in three phases; only the word chooses one of them."""
    done = export_part(PRESS, "bar_upper", at, out=tmp_path / "bar.inp", overrides=COARSE)
    shown = re.fullmatch(rf"x = (\S+) mm {phase} \(cycle press\)", done.position)
    assert shown, done.position
    assert abs(float(shown[1]) - 7) < 10


def test_the_short_forms_of_a_position_mean_the_same(tmp_path):
    told = {
        export_part(
            PRESS, "bar_upper", at, cycle="capacity", out=tmp_path / "bar.inp", overrides=COARSE
        ).position
        for at in ("x = 4 mm full_pull", "x = 4 mm", "4 mm", "4", " 4.0 full_pull ")
    }
    assert len(told) == 1


def test_a_position_that_cannot_be_read_is_exit_code_2_with_an_example(tmp_path, capsys):
    out = tmp_path / "no.inp"
    code = run_export(
        PRESS, "bar_upper", "x = 2 mm retrun", cycle="press", out=out, overrides=COARSE
    )
    assert code == 2
    told = " ".join(capsys.readouterr().err.split())
    example = re.search(
        r"such as (\S+), in mm, from 2 to 200; phases: approach, press, return; got", told
    )
    assert example, told
    assert 2 <= float(example[1]) <= 200
    assert not out.exists()


def test_the_command_tells_what_it_wrote(tmp_path, capsys):
    out = tmp_path / "bar.inp"
    code = run_export(PRESS, "bar_upper", cycle="press", out=out, overrides=COARSE)
    told = capsys.readouterr()
    assert code == 0
    assert str(out) in told.out
    assert "(von Mises)" in told.out
    assert "bar_upper: meshing and solving" in told.err
    assert out.read_text(encoding="ascii").startswith("*HEADING")


@pytest.mark.parametrize(
    ("part", "options", "says"),
    [
        ("bar_uper", {}, "--part: no part is named 'bar_uper', did you mean bar_upper?"),
        ("bar_upper", {"at": "wurst"}, "--at: must be 'worst' or a position"),
        ("bar_upper", {"at": "nan"}, "--at: must be 'worst' or a position"),
        (
            "bar_upper",
            {"at": "3"},
            "--at: say with --cycle of which cycle 3 is a position: press, ",
        ),
        (
            "bar_upper",
            {"at": "2 deg", "cycle": "press"},
            "in mm, from 2 to 200; phases: approach, ",
        ),
        ("bar_upper", {"at": "y = 2 mm", "cycle": "press"}, "--at: must be 'worst' or a position"),
        ("bar_upper", {"at": "150 mm press"}, " mm in phase 'press' of cycle 'press', got 150 mm"),
        ("bar_upper", {"at": "1,5"}, "; phases: full_pull (cycle capacity); got '1,5'"),
        ("bar_upper", {"at": "900", "cycle": "press"}, "x runs from 2 to 200 mm in cycle 'press'"),
        ("bar_upper", {"cycle": "pres"}, "is named 'pres', did you mean press?"),
    ],
)
def test_what_cannot_be_exported_is_refused(tmp_path, part, options, says):
    out = tmp_path / "no.inp"
    with pytest.raises(DesignError, match=re.escape(says)):
        export_part(PRESS, part, **options, out=out, overrides=COARSE)
    assert not out.exists()


def test_a_place_that_cannot_be_written_is_exit_code_2(tmp_path, capsys):
    taken = tmp_path / "file"
    taken.write_text("")
    code = run_export(PRESS, "bar_upper", out=taken / "bar.inp", overrides=COARSE)
    assert code == 2
    assert "--out: cannot be written" in capsys.readouterr().err
