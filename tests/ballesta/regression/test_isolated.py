"""The isolated process: same numbers again, the same code, and what killed it."""

import json
import signal
import subprocess
import sys

import pytest

from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from ballesta.regression import file
from ballesta.regression.file import (
    WORKER,
    CheckError,
    baseline_path,
    measure,
    read_baseline,
    write_baseline,
)
from checks.design.effort import Effort
from checks.design.errors import DesignError

from ...small_machine import machine
from .conftest import DESIGN, ROOT


def numbers(record):
    """All values and safeties of a record, by part and check."""
    found = {}
    for name, part in record["parts"].items():
        found[name, "mass"] = part["mass [kg]"]
        for key, check in part["checks"].items():
            found[name, key, "value"] = check["value"]
            found[name, key, "safety"] = check["safety"]
    return found


def test_the_same_versions_and_threads_repeat_to_1e_9(tmp_path, small_record):
    """Measured: bit for bit. 1e-9 is what is promised."""
    (tmp_path / "other.toml").write_text(DESIGN, encoding="utf-8")
    again = measure(tmp_path / "other.toml", rungs=pins(small_record))
    assert numbers(again) == pytest.approx(numbers(small_record), rel=1e-9, abs=0)
    stages = small_record["stages"] | {"code": again["stages"]["code"]}  # may be edited meanwhile
    assert again["stages"] == stages


def pins(record):
    return {name: part["rungs"] for name, part in record["parts"].items()}


def test_the_isolated_process_runs_the_code_that_started_it(tmp_path):
    """Also where another ballesta is installed, and modules of our names stand in the way."""
    (tmp_path / "loads.py").write_text("raise AssertionError", encoding="utf-8")
    code = WORKER.read_text(encoding="utf-8").partition("    sys.exit(main())")[0]
    shown = "    import ballesta, loads\n    print(ballesta.__file__, loads.__file__)\n"
    folder = tmp_path / "ballesta" / "regression"
    folder.mkdir(parents=True)
    (folder / "worker.py").write_text(code + shown, encoding="utf-8")
    (tmp_path / "ballesta" / "__init__.py").touch()
    (tmp_path / "loads.py").write_text("", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-I", folder / "worker.py"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.split() == [
        str(tmp_path / "ballesta" / "__init__.py"),
        str(tmp_path / "loads.py"),
    ]


@pytest.mark.parametrize(
    ("code", "answer", "said"),
    [
        (-signal.SIGKILL, "", "the check was killed by SIGKILL; it said last:\nreading\nmeshing"),
        (-signal.SIGSEGV, '{"record": {}}', "the check was killed by SIGSEGV"),
        (1, "", "the check died with exit code 1"),
        (0, "gmsh says hello", "the check died with exit code 0"),
    ],
)
def test_a_process_that_dies_is_told_with_its_last_words(code, answer, said):
    with pytest.raises(CheckError) as error:
        file._record(code, answer, "reading\nmeshing\n")
    assert str(error.value).startswith(said)
    assert error.value.exit_code is None


def test_a_process_that_takes_too_long_is_stopped(tmp_path):
    (tmp_path / "machine.toml").write_text(DESIGN, encoding="utf-8")
    with pytest.raises(CheckError, match=r"took longer than 0\.02 s"):
        measure(tmp_path / "machine.toml", timeout=0.02)


def test_write_baseline_pins_the_rungs_of_the_result_and_keeps_stated_bands(tmp_path):
    design = machine(tmp_path)
    path = write_baseline(check_design(design, effort=Effort("formula")))
    assert path == baseline_path(design.file)
    first = read_baseline(path)
    assert first.rungs == {
        "rod": {"static": "formula", "fatigue": "formula", "buckling": "formula"}
    }
    text = path.read_text(encoding="utf-8").replace('"bands": {}', '"bands": {"mass": "1 %"}')
    path.write_text(text, encoding="utf-8")
    write_baseline(check_design(design, effort=Effort("formula")))
    second = read_baseline(path)
    assert second.bands == {"mass": "1 %"}
    assert set(second.rungs["rod"].values()) == {"formula"}
    assert json.loads(path.read_text(encoding="utf-8"))["format"] == "ballesta-baseline/2"


def test_no_baseline_is_written_of_what_the_file_does_not_say(tmp_path):
    design = machine(tmp_path)
    result = check_design(
        read_design(design.file, ["parts.rod.width=25 mm"]), effort=Effort("formula")
    )
    with pytest.raises(DesignError, match=r"leave out parts\.rod\.width=25 mm"):
        write_baseline(result)
    assert not baseline_path(design.file).exists()
