import subprocess
import sys
from types import SimpleNamespace

import pytest

import ballesta.pipeline
from ballesta.cli import main
from ballesta.commands import show
from ballesta.commands.show import Wanted, run_show
from checks.design.errors import DesignError
from reports.window import try_window

from ...small_machine import MACHINE, PLATE


@pytest.fixture
def design(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE + PLATE, encoding="utf-8")
    return path


@pytest.fixture
def shown(monkeypatch):
    """What would be shown, by scenes and parts; the window itself stays closed."""
    seen = []

    def window(*found):
        seen.append(found)
        return SimpleNamespace(plotter=SimpleNamespace(show=lambda: None))

    monkeypatch.setattr(show, "try_window", lambda **_: None)
    monkeypatch.setattr(show, "Window", window)
    return seen


FORMULA = {"fidelity": "formula"}


def test_a_design_is_checked_and_its_parts_shown(design, shown, capsys):
    assert run_show(design, Wanted("rod", **FORMULA)) == 0
    ((scene, part),) = shown
    assert part == "rod"
    assert list(scene.parts) == ["rod"]
    assert scene.places
    said = capsys.readouterr()
    assert "decided by rod" in said.out or "nearest to its limit is rod" in said.out
    assert "rod: estimate: stress of the section forces" in said.err


def test_a_part_that_is_not_there_is_told_before_anything_is_checked(design, shown, capsys):
    assert run_show(design, Wanted("rood", **FORMULA)) == 2
    assert "no part is named 'rood', did you mean rod?" in capsys.readouterr().err
    assert shown == []


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere DISPLAY says nothing")
def test_without_a_display_nothing_is_checked_and_the_cure_is_named(design, monkeypatch, capsys):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(ballesta.pipeline, "check_design", None)  # it would fail
    assert main(["show", str(design)]) == 2
    said = capsys.readouterr().err
    assert "there is no display" in said
    assert "--off-screen FILE.png" in said


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "signal SIGSEGV"),
        ("import time; time.sleep(60)", "took longer than 2 s and was stopped"),
    ],
)
def test_missing_graphics_libraries_end_it_with_words_and_their_cure(
    design, monkeypatch, capsys, code, words
):
    worker = (sys.executable, "-c", code)
    monkeypatch.setattr(
        show, "try_window", lambda **how: try_window(worker=worker, timeout=2.0, **how)
    )
    monkeypatch.setattr(ballesta.pipeline, "check_design", None)
    assert run_show(design, Wanted(picture=design.with_suffix(".png"), **FORMULA)) == 3
    said = capsys.readouterr().err
    assert words in said
    assert "apt-get install libgl1 libegl1" in said
    assert not design.with_suffix(".png").exists()


def test_the_picture_of_the_window_is_written(design, capsys):
    picture = design.with_name("window.png")
    code = main(["show", str(design), "rod", "--off-screen", str(picture), "--fidelity", "formula"])
    assert code == 0, capsys.readouterr().err
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_picture_that_cannot_be_written_is_a_wrong_input(design, monkeypatch, capsys):
    def refused(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(show, "try_window", lambda **_: None)
    monkeypatch.setattr(show, "write_picture", refused)
    assert run_show(design, Wanted(picture=design.with_suffix(".png"), **FORMULA)) == 2
    assert "--off-screen: cannot be written: Permission denied" in capsys.readouterr().err


def test_a_picture_that_could_not_be_written_is_refused_before_the_check(
    design, monkeypatch, capsys
):
    monkeypatch.setattr(show, "try_window", None)  # it would fail
    folder = design.with_name("folder.png")
    folder.mkdir()
    for picture, said in (
        (folder, f"is a folder, name a file in it such as {folder / 'window.png'}"),
        (design / "a" / "window.png", f"cannot be written: {design} is no folder"),
    ):
        assert run_show(design, Wanted(picture=picture, **FORMULA)) == 2
        assert f"{picture}: --off-screen: {said}" in capsys.readouterr().err


def test_it_is_told_where_the_picture_was_written(design, monkeypatch, capsys):
    monkeypatch.setattr(show, "try_window", lambda **_: None)
    monkeypatch.setattr(show, "write_picture", lambda *_: None)
    picture = design.with_name("new") / "window.png"
    assert run_show(design, Wanted(picture=picture, **FORMULA)) == 0
    assert f"written: {picture}\n" in capsys.readouterr().out


def test_a_result_is_refused_with_what_is_needed(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(show, "try_window", None)  # it would fail
    (tmp_path / "result.json").write_text("{}", encoding="utf-8")
    for target in (tmp_path, tmp_path / "result.json"):
        assert run_show(target, Wanted(**FORMULA)) == 2
        assert "show needs the design file (.toml)" in capsys.readouterr().err


def test_its_words_advise_its_own_option(design, shown, capsys):
    assert run_show(design, Wanted("rod", **FORMULA)) == 0
    said = capsys.readouterr().err
    assert "ballesta show --fields meshes the part" in said
    ((scene, _),) = shown
    (live,) = scene.parts.values()
    assert not any("ballesta check" in words for words in (said, *live.missing.values()))


@pytest.mark.parametrize("name", ["window.jpg", "window", "window.png.svg"])
def test_only_a_png_is_drawn_in_place_of_a_window(design, monkeypatch, capsys, name):
    monkeypatch.setattr(show, "try_window", None)  # it would fail
    assert run_show(design, Wanted(picture=design.with_name(name), **FORMULA)) == 2
    assert f'--off-screen: must be named .png, got "{name}"' in capsys.readouterr().err


def test_that_no_part_is_meshed_is_told_before_the_check(design, shown, monkeypatch, capsys):
    def stopped(*_, **__):
        raise DesignError(design, "part", "stopped here")

    monkeypatch.setattr(ballesta.pipeline, "check_design", stopped)
    for fidelity in ("formula", "solid"):
        assert run_show(design, Wanted(fidelity=fidelity)) == 2
        said = capsys.readouterr().err
        assert "stopped here" in said
        assert ("makes no mesh" in said) == (fidelity != "solid")
    assert shown == []


def test_the_solvers_are_imported_after_the_trial_of_a_window():
    code = (
        "import sys, ballesta.commands.show; "
        "sys.exit(', '.join({'skfem', 'gmsh', 'ballesta.pipeline'} & set(sys.modules)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
