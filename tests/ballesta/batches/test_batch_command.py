"""`ballesta batch` as a user runs it, on a crank and slider by formulas."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

import pytest

from ...conftest import Run
from ...small_machine import MACHINE, PLATE
from . import jobs

ROOT = Path(__file__).parents[3]
GOOD = MACHINE + PLATE
QUICK = ["--fidelity", "formula", "--no-reports", "--jobs", "2"]
TABLES = ("index.html", "results.csv", "results.parquet")


@pytest.fixture
def in_this_process(monkeypatch):
    """Designs are checked in this process: processes are the subject of `bad` and `swept`."""
    jobs.run_in_this_process(monkeypatch)


def rows(out):
    with (out / "results.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def statuses(out):
    return {row["design"]: row["design status"] for row in rows(out)}


@pytest.fixture(scope="module")
def bad(tmp_path_factory, command):
    """A batch of a folder with broken, empty, copied and non-UTF-8 files among good ones."""
    folder = tmp_path_factory.mktemp("bad")
    (folder / "a_good.toml").write_text(GOOD)
    (folder / "b_broken.toml").write_text("name =")
    (folder / "c_empty.toml").write_text("")
    (folder / "d_copy.toml").write_text(GOOD)
    (folder / "e_latin.toml").write_bytes(GOOD.replace("Crank", "Bärenkurbel").encode("latin-1"))
    (folder / "f_key.toml").write_text(GOOD.replace("\nwidth", "\nwidht"))
    (folder / "g_heavy.toml").write_text(GOOD.replace("400 N", "900 kN"))
    (folder / "h_folder.toml").mkdir()
    out = tmp_path_factory.mktemp("results") / "out"
    run = command("batch", str(folder), str(folder / "gone.toml"), "--out", str(out), *QUICK,
                  out=out)  # fmt: skip
    return folder, run


def test_bad_files_cost_themselves_alone_and_tell_their_cause(bad):
    _, run = bad
    found = {row["design"]: row for row in reversed(rows(run.out))}
    assert {name: row["design status"] for name, row in sorted(found.items())} == {
        "a_good": "UNDECIDED",
        "b_broken": "wrong input",
        "c_empty": "wrong input",
        "d_copy": "UNDECIDED",
        "e_latin": "wrong input",
        "f_key": "wrong input",
        "g_heavy": "FAIL",
        "gone": "wrong input",
        "h_folder": "wrong input",
    }
    for name, words in {
        "b_broken": "is not TOML",
        "c_empty": "the file is empty",
        "e_latin": "is not UTF-8 text",
        "f_key": "did you mean width",
        "gone": "there is no such file",
        "h_folder": "is a directory",
    }.items():
        assert words in found[name]["error"]
    assert found["d_copy"]["design note"].endswith("duplicate: the same text as a_good.toml")
    assert found["a_good"]["value"] == found["d_copy"]["value"] != ""


def test_the_exit_code_is_the_highest_and_every_design_is_a_line(bad):
    _, run = bad
    assert run.code == 2
    lines = [line for line in run.stdout.splitlines() if line.startswith("[")]
    assert len(lines) == 9
    assert any(
        re.search(r"g_heavy  FAIL  rod .*safety 0\.0\d+ \(\S+ required", line) for line in lines
    )
    assert "9 designs: 2 UNDECIDED, 1 FAIL, 6 wrong input" in run.stdout
    assert "\x1b" not in run.stdout + run.stderr


def test_every_check_of_every_part_is_in_the_tables_as_in_result_json(bad):
    _, run = bad
    result = json.loads((run.out / "a_good" / "result.json").read_text())
    checks = [check for part in result["parts"] for check in part["checks"]] + result["linkage"]
    mine = [row for row in rows(run.out) if row["design"] == "a_good"]
    assert [float(row["value"]) for row in mine] == [check["value"] for check in checks]
    assert [row["status"] for row in mine] == [check["status"] for check in checks]
    (governing,) = (row for row in mine if row["governing"] == "true")
    assert governing["part"] == result["decided_by"]["part"]
    assert governing["kind"] == result["decided_by"]["kind"]


def test_the_second_run_checks_nothing_that_has_a_result_and_ends_the_same(bad, command):
    folder, run = bad
    before = {name: (run.out / name).read_bytes() for name in TABLES}
    results = {path: path.stat().st_mtime_ns for path in run.out.glob("*/result.json")}
    again = command("batch", str(folder), str(folder / "gone.toml"), "--out", str(run.out), *QUICK,
                    out=run.out)  # fmt: skip
    assert again.code == 2
    assert "3 of 9 designs are done already" in again.stderr
    assert {path: path.stat().st_mtime_ns for path in results} == results
    assert {name: (run.out / name).read_bytes() for name in TABLES} == before


def test_another_batch_is_not_mixed_into_the_folder(bad, command):
    folder, run = bad
    before = {name: (run.out / name).read_bytes() for name in TABLES}
    other = command("batch", str(folder / "a_good.toml"), "--out", str(run.out), *QUICK,
                    out=run.out)  # fmt: skip
    assert other.code == 2
    assert "holds another batch (DESIGN:" in other.stderr
    assert "Traceback" not in other.stderr
    assert {name: (run.out / name).read_bytes() for name in TABLES} == before


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--jobs", "0"], "--jobs: must be at least 1"),
        (["--time-limit", "soon"], "--time-limit: must be a time such as"),
        (["--time-limit", "0 s"], "--time-limit: must be above 0 s"),
        (["--memory", "much"], "--memory: must be a size"),
        (["--sample", "8"], "--sample: needs a --sweep"),
        (["--accuracy", "3 %", "--sweep", "accuracy = 5 %, 10 %"], "--accuracy: is swept, too"),
        (["--fidelity", "sold"], "did you mean solid"),
        (["--fidelity", "plane"], "there are auto, formula, solid"),
        (["--sweep", "parts.rod.widht = 20..30 mm : 3"], "did you mean"),
    ],
)
def test_options_without_sense_are_refused_before_anything_is_made(
    tmp_path, command, options, words
):
    (tmp_path / "machine.toml").write_text(GOOD)
    out = tmp_path / "out"
    run = command("batch", str(tmp_path / "machine.toml"), "--out", str(out), *options, out=out)
    assert run.code == 2
    assert words in run.stderr
    assert "Traceback" not in run.stderr
    assert not out.exists()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_is_told(tmp_path, command):
    (tmp_path / "machine.toml").write_text(GOOD)
    (tmp_path / "locked").mkdir(mode=0o500)
    out = tmp_path / "locked" / "out"
    run = command("batch", str(tmp_path / "machine.toml"), "--out", str(out), *QUICK, out=out)
    assert run.code == 2
    assert "--out: cannot be written: Permission denied" in run.stderr


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Two variations with reports, begun in a folder that holds modules named like ours."""
    folder = tmp_path_factory.mktemp("swept")
    (folder / "machine.toml").write_text(GOOD)
    (folder / "loads.py").write_text("raise SystemExit('the wrong loads')")
    (folder / "ballesta").mkdir()
    (folder / "ballesta" / "__init__.py").write_text("raise SystemExit('the wrong ballesta')")
    done = subprocess.run(
        [sys.executable, "-P", "-m", "ballesta", "batch", "machine.toml", "--sweep",
         "parts.rod.thickness = 6..8 mm : 2", "--fidelity", "formula", "--out", "out"],
        cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    return Run(done.returncode, done.stdout, done.stderr, folder / "out")


def test_a_sweep_gives_a_column_of_the_varied_input(swept):
    assert swept.code == 1, swept.stderr
    varied = {row["design"]: row["input parts.rod.thickness [mm]"] for row in rows(swept.out)}
    assert varied == {"machine-1": "6.0", "machine-2": "8.0"}
    static = [float(r["value"]) for r in rows(swept.out) if r["kind"] == "bearing"]
    assert static == sorted(static, reverse=True)
    assert len(set(static)) == 2


def test_a_small_batch_has_reports_and_pictures_that_the_index_shows_and_links(swept):
    page = (swept.out / "index.html").read_text()
    links = {unquote(link) for link in re.findall(r'<a href="([^"#]+)"', page)}
    assert links == {f"machine-{k}/report.html" for k in (1, 2)}
    assert all((swept.out / link).is_file() for link in links)
    drawn = [(swept.out / f"machine-{k}" / "thumbnail.png").is_file() for k in (1, 2)]
    assert page.count('"picture":"iVBOR') == sum(drawn)
    missing = "pictures are missing" in (swept.out / "machine-1" / "report.html").read_text()
    assert all(drawn) or missing  # where there is no GL


@pytest.mark.usefixtures("in_this_process")
def test_an_edited_base_is_noticed_although_the_design_itself_is_as_it_was(tmp_path, command):
    """`like` takes from another file, which is not in the batch's folder."""
    base = tmp_path / "base.toml"
    base.write_text(GOOD)
    (tmp_path / "designs").mkdir()
    (tmp_path / "designs" / "child.toml").write_text('like = "../base.toml"\nname = "Child"\n')
    out = tmp_path / "out"
    arguments = ("batch", str(tmp_path / "designs"), "--out", str(out), *QUICK)
    command(*arguments, out=out)
    before = rows(out)
    base.write_text(GOOD.replace("400 N", "800 N"))
    again = command(*arguments, out=out)
    assert "done already" not in again.stderr
    assert float(rows(out)[0]["value"]) > 1.5 * float(before[0]["value"])
    base.unlink()
    command(*arguments, out=out)
    (row,) = rows(out)
    assert row["design status"] == "wrong input"
    assert not (out / "child" / "result.json").exists()  # no old result beside the new verdict


@pytest.mark.usefixtures("in_this_process")
def test_results_move_with_their_folder(tmp_path, command):
    (tmp_path / "machine.toml").write_text(GOOD)
    out, moved = tmp_path / "out", tmp_path / "moved"
    command("batch", str(tmp_path / "machine.toml"), "--out", str(out), *QUICK, out=out)
    shutil.move(out, moved)
    run = command("batch", str(tmp_path / "machine.toml"), "--out", str(moved), *QUICK, out=moved)
    assert "1 of 1 designs are done already" in run.stderr


def test_the_documentation_names_every_option_of_the_command(command):
    text = (ROOT / "docs" / "batch.md").read_text()
    run = command("batch", "--help", out=Path())
    options = set(re.findall(r"--[a-z][a-z-]+", run.stdout)) - {"--help"}
    assert {option for option in options if f"`{option}" not in text} == set()


@pytest.mark.usefixtures("in_this_process")
def test_a_link_that_leads_to_another_file_is_checked_again(command, tmp_path):
    (tmp_path / "one.toml").write_text(GOOD)
    (tmp_path / "two.toml").write_text(GOOD.replace("400 N", "900 kN"))
    folder, out = tmp_path / "designs", tmp_path / "out"
    folder.mkdir()
    for target, status in (("one.toml", "UNDECIDED"), ("two.toml", "FAIL")):
        (folder / "m.toml").unlink(missing_ok=True)
        (folder / "m.toml").symlink_to(tmp_path / target)
        command("batch", str(folder), "--out", str(out), *QUICK, out=out)
        assert statuses(out) == {"m": status}


@pytest.mark.usefixtures("in_this_process")
def test_no_design_writes_outside_of_its_own_folder(command, tmp_path):
    (tmp_path / "...toml").write_text(GOOD)
    (tmp_path / "report.html").write_text("the user's own")
    out = tmp_path / "out"
    command("batch", str(tmp_path / "...toml"), "--out", str(out), *QUICK, out=out)
    assert statuses(out) == {"design": "UNDECIDED"}
    assert (tmp_path / "report.html").read_text() == "the user's own"
    assert not (tmp_path / "result.json").exists()
