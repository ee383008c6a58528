"""Reports printed to PDF: by which browser, and what is said where it does not print."""

import os
import shutil
import stat
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from ballesta import run
from reports import page
from reports.page import PrintError, find_browser, print_pdf

PRINTS = """
import pathlib, sys, urllib.parse
to = next(a.partition("=")[2] for a in sys.argv if a.startswith("--print-to-pdf="))
page = pathlib.Path(urllib.parse.unquote(sys.argv[-1].removeprefix("file://"))).read_text()
pathlib.Path(to).write_bytes(b"%PDF-1.4 " + page.encode())
"""
FAILS = 'import sys; print("no display", file=sys.stderr); sys.exit(7)'
HANGS = "import time; time.sleep(60)"


def program(folder, text):
    """A browser that does what a Python text says."""
    file = folder / "browser"
    file.write_text(f"#!{sys.executable}\n{text}\n")
    file.chmod(file.stat().st_mode | stat.S_IXUSR)
    return str(file)


@pytest.fixture
def report(tmp_path):
    file = tmp_path / "a report" / "report.html"
    file.parent.mkdir()
    file.write_text("pass")
    return file


def test_the_browser_that_is_stated_is_taken_and_one_that_is_none_is_named(tmp_path, monkeypatch):
    stated = program(tmp_path, PRINTS)
    monkeypatch.setenv("BALLESTA_BROWSER", stated)
    assert find_browser() == stated
    monkeypatch.setenv("BALLESTA_BROWSER", "netscape")
    with pytest.raises(PrintError, match="names 'netscape', which is no program"):
        find_browser()


def test_without_a_browser_the_cure_is_named(monkeypatch):
    monkeypatch.delenv("BALLESTA_BROWSER", raising=False)
    monkeypatch.setattr(page.shutil, "which", lambda name: None)
    with pytest.raises(PrintError, match=r"apt-get install -y chromium.*BALLESTA_BROWSER"):
        find_browser()


def test_a_pdf_replaces_the_one_that_was_there(report, tmp_path):
    made = report.with_suffix(".pdf")
    made.write_text("old")
    print_pdf(report, made, program(tmp_path, PRINTS))
    assert made.read_bytes() == b"%PDF-1.4 pass"
    assert sorted(os.listdir(made.parent)) == ["report.html", "report.pdf"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (FAILS, r"printed nothing \(exit code 7: no display\); open .*report\.html and print it"),
        ("pass", r"printed nothing \(exit code 0\)"),
        (HANGS, r"printed nothing within 0 s"),
    ],
)
def test_a_browser_that_prints_nothing_leaves_what_was_there(
    text, told, report, tmp_path, monkeypatch
):
    monkeypatch.setattr(page, "_LONGEST", 0.4)
    made = report.with_suffix(".pdf")
    made.write_text("old")
    with pytest.raises(PrintError, match=told):
        print_pdf(report, made, program(tmp_path, text))
    assert made.read_text() == "old"


def test_a_check_prints_its_report_and_says_at_once_that_it_cannot(tmp_path, monkeypatch, capsys):
    def checked(path, folder, *_, **__):
        folder.mkdir(parents=True)
        (folder / "report.html").write_text("undecided")
        return SimpleNamespace(exit_code=1)

    monkeypatch.setattr(run, "check_to_folder", checked)
    monkeypatch.setattr(run, "_printed", lambda *_, **__: "the answer")

    def code(browser, out):
        monkeypatch.setenv("BALLESTA_BROWSER", browser)
        return run.check_all([tmp_path / "press.toml"], out=tmp_path / out, pdf=True)

    assert code(program(tmp_path, PRINTS), "one") == 1
    assert (tmp_path / "one" / "press" / "report.pdf").read_bytes() == b"%PDF-1.4 undecided"
    assert code("netscape", "two") == 2
    assert not (tmp_path / "two").exists()
    assert "--pdf: browser: BALLESTA_BROWSER names 'netscape'" in capsys.readouterr().err
    assert code(program(tmp_path, FAILS), "three") == 2
    assert (tmp_path / "three" / "press" / "report.html").exists()
    told = capsys.readouterr()
    assert "the answer" in told.out
    assert "no display" in told.err


def test_chromium_prints_a_page(report):
    browser = shutil.which("chromium") or shutil.which("chromium-browser")
    if browser is None:
        pytest.skip("there is no chromium: apt-get install -y chromium")
    report.write_text("<!doctype html><title>x</title><h1>pass</h1>")
    made = Path(report.with_suffix(".pdf"))
    print_pdf(report, made, browser)
    assert made.read_bytes().startswith(b"%PDF-")
    assert b"/Type /Page" in made.read_bytes()
