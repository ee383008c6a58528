"""Whole results from a store: an unchanged design is not checked again."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import ballesta.pipeline
import reports.pictures
from ballesta.design.read import read_design
from ballesta.run import check_all, check_to_folder, store_at
from checks.design.effort import DEFAULT_EFFORT, Effort
from checks.design.errors import DesignError
from checks.store.fingerprints import code_digest, digest
from checks.store.store import Store, keep_result, recalled_result
from reports.charts.chart import Charts

from ...small_machine import MACHINE, PLATE
from ...undrawn import draw_nothing

FORMULA = Effort("formula")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A design, and nothing drawn: pictures and charts take seconds."""
    monkeypatch.chdir(tmp_path)
    Path("machine.toml").write_text(MACHINE + PLATE, encoding="utf-8")
    draw_nothing(monkeypatch)
    for module in ("reports.charts", "reports.charts.cycles"):
        monkeypatch.setattr(f"{module}.gathered", lambda makers: Charts((), ()))
    return tmp_path


@pytest.fixture(scope="module")
def known():
    """Results of what was checked, by all that a check is told of."""
    return {}


@pytest.fixture
def checks(monkeypatch, known):
    """What was checked; what was checked before is counted and not computed again."""
    done, work = [], ballesta.pipeline.check_with_cycles

    def counted(design, *, effort=DEFAULT_EFFORT, live=False, **options):
        done.append(design.name)
        asked = digest(design, repr(effort), live)
        if asked not in known:
            known[asked] = work(design, effort=effort, live=live, **options)
        return known[asked]

    monkeypatch.setattr(ballesta.pipeline, "check_with_cycles", counted)
    return done


def run(out, *overrides, effort=FORMULA, path="machine.toml"):
    said = []
    store = Store(Path("store"), say=said.append)
    result = check_to_folder(Path(path), Path(out), overrides, effort=effort, store=store)
    assert not [text for text in said if "versions" not in text]
    return result


def files(out):
    return {path.name: path.read_bytes() for path in Path(out).iterdir()}


def test_an_unchanged_design_is_answered_from_the_store_with_the_same_files(folder, checks):
    first = run("one")
    second = run("two")
    assert checks == ["Crank and slider"]
    assert files("one") == files("two")
    assert {*files("one")} == {"rod.vtu", "report.html", "result.json"}
    assert digest(first) == digest(second)
    assert second.exit_code == first.exit_code
    assert second.status is first.status


@pytest.mark.parametrize(
    "change",
    [
        {"overrides": ["parts.rod.thickness=9 mm"]},
        {"effort": Effort("auto")},
        {"effort": Effort("formula", pinned={"rod": {"static": "formula"}})},
    ],
    ids=["override", "fidelity", "pinned"],
)
def test_what_is_asked_otherwise_is_checked_again(folder, checks, change):
    run("one")
    run("two", *change.get("overrides", ()), effort=change.get("effort", FORMULA))
    assert len(checks) == 2


def test_a_changed_text_is_checked_again_and_a_restored_one_is_not(folder, checks):
    run("one")
    file = Path("machine.toml")
    text = file.read_text()
    file.write_text(text + "\n# a note\n")
    run("two")
    assert len(checks) == 2
    file.write_text(text)
    run("three")
    assert len(checks) == 2
    assert files("three") == files("one")


def test_a_change_in_a_file_that_the_design_is_like_is_seen(folder, checks):
    base = Path("machine.toml")
    Path("heavy.toml").write_text('like = "machine.toml"\n[bodies.slider]\nmass = "0.6 kg"\n')
    run("one", path="heavy.toml")
    run("two", path="heavy.toml")
    assert len(checks) == 1
    base.write_text(base.read_text().replace("0.2 kg", "0.3 kg"))
    run("three", path="heavy.toml")
    assert len(checks) == 2
    base.unlink()
    with pytest.raises(DesignError, match="no such file"):
        run("four", path="heavy.toml")


def test_a_result_under_a_time_limit_is_not_kept(folder, checks):
    for out in ("one", "two"):
        run(out, effort=Effort("formula", within=1000.0))
    assert len(checks) == 2


def test_a_result_that_a_lack_of_memory_cut_short_is_not_kept(folder):
    result = run("one")
    design = read_design("machine.toml", ["parts.rod.thickness=9 mm"])
    short = replace(result.parts[0].checks[0], note="a finer mesh was not solved: 3 GiB of memory")
    cut = replace(result, parts=[replace(result.parts[0], checks=[short])])
    store = Store(Path("store"))
    keep_result(store, design, FORMULA, cut, {})
    assert recalled_result(store, design.file, design.overrides, FORMULA) is None
    keep_result(store, design, FORMULA, result, {})
    assert recalled_result(store, design.file, design.overrides, FORMULA) is not None


def test_a_report_without_its_pictures_is_written_anew(folder, checks, monkeypatch):
    draw_nothing(monkeypatch, "no GL here")
    run("one")
    assert b"no GL here" in files("one")["report.html"]
    draw_nothing(monkeypatch)
    run("two")
    assert len(checks) == 1
    assert b"no GL here" not in files("two")["report.html"]
    assert files("one")["result.json"] == files("two")["result.json"]
    monkeypatch.setattr(reports.pictures, "drawing", None)  # not drawn again
    run("three")
    assert files("three") == files("two")


def test_a_result_without_live_fields_is_checked_again_where_a_report_is_written(folder, checks):
    """As a batch without reports keeps it: its page would have no live view."""
    design = read_design("machine.toml", [])
    bare = ballesta.pipeline.check_design(design, effort=FORMULA)
    keep_result(Store(Path("store")), design, FORMULA, bare, {})
    assert {part.live for part in bare.parts} == {None}
    run("one")
    assert len(checks) == 2
    run("two")
    assert len(checks) == 2
    assert files("two") == files("one")


def test_kept_results_do_not_hold_fields_that_their_files_show(folder, monkeypatch):
    assert {part.live for part in run("one").parts} == {None}
    kept = recalled_result(Store(Path("store")), Path("machine.toml"), [], FORMULA)
    assert {part.live for part in kept.result.parts} == {None}
    draw_nothing(monkeypatch, "no GL here")
    override = ["parts.rod.thickness=9 mm"]
    run("two", *override)
    kept = recalled_result(Store(Path("store")), Path("machine.toml"), override, FORMULA)
    assert {type(part.live).__name__ for part in kept.result.parts} == {"EncodedPart"}


def test_a_damaged_result_is_said_and_checked_again(folder, checks, capsys):
    run("one")
    [file] = Path("store/result").glob("*/*.entry")
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)
    assert check_all([Path("machine.toml")], out=Path("two"), fidelity="formula",
                     store=Path("store")) in (0, 1)  # fmt: skip
    assert len(checks) == 2
    told = capsys.readouterr().err
    assert "is damaged" in told
    assert "computed again" in told


def test_an_unwritable_store_does_not_cost_the_check(folder, checks, capsys):
    Path("store").write_text("a file")
    code = check_all([Path("machine.toml")], out=Path("out"), fidelity="formula",
                     store=Path("store"))  # fmt: skip
    assert code in (0, 1)
    assert Path("out/machine/result.json").is_file()
    assert capsys.readouterr().err.count("cannot be written") == 1


@pytest.mark.parametrize("limit", ["ten", "0", "-1", "inf", "nan"])
def test_a_wrong_limit_is_told(folder, monkeypatch, capsys, limit):
    monkeypatch.setenv("BALLESTA_STORE_LIMIT", limit)
    assert check_all([Path("machine.toml")], out=Path("out"), store=Path("store")) == 2
    assert capsys.readouterr().err == (
        "ballesta: environment: BALLESTA_STORE_LIMIT: must be a number of GiB above 0 such as "
        f'"20", got "{limit}"\n'
    )


def test_a_limit_is_in_gibibytes(monkeypatch):
    assert store_at(Path("store")).limit == 10 * 2**30
    monkeypatch.setenv("BALLESTA_STORE_LIMIT", "0.5")
    assert store_at(Path("store")).limit == 2**29
    assert store_at(None) is None


def test_an_unchanged_design_needs_neither_mesher_nor_solver(folder):
    code_digest.cache_clear()  # the other process takes it anew
    run("one")
    program = (
        "import sys\n"
        "from pathlib import Path\n"
        "from ballesta.run import check_all\n"
        "check_all([Path('machine.toml')], out=Path('two'), fidelity='formula', "
        "store=Path('store'))\n"
        "heavy = {'gmsh', 'scipy', 'skfem', 'pydantic', 'pint', 'meshio', 'pyvista'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert "unchanged: taken from the store" in done.stderr
    assert done.stderr.endswith("[]\n")
    assert Path("two/machine/report.html").read_bytes() == files("one")["report.html"]


def test_the_command_line_takes_the_store_from_its_option_or_the_environment(monkeypatch):
    from ballesta.cli import main

    asked = []
    monkeypatch.setattr("ballesta.run.check_all", lambda *_, **options: asked.append(options) or 0)
    monkeypatch.delenv("BALLESTA_STORE", raising=False)
    for arguments in ([], ["--store", "here"]):
        main(["check", "a.toml", *arguments])
    monkeypatch.setenv("BALLESTA_STORE", "there")
    for arguments in ([], ["--store", "here"], ["--no-store"]):
        main(["check", "a.toml", *arguments])
    stores = [options["store"] for options in asked]
    assert stores == [None, Path("here"), Path("there"), Path("here"), None]
