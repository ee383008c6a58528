"""Stills are drawn by a process that stands ready, beside the work of a check."""

from contextlib import nullcontext
from pathlib import Path

import pytest

import ballesta.pipeline
import reports.live.section
import reports.pictures
from ballesta.run import check_to_folder
from checks.design.effort import Effort
from checks.design.errors import DesignError
from reports.pictures import Pictures

from ..small_machine import MACHINE, PLATE


@pytest.fixture
def told(tmp_path, monkeypatch):
    """What is begun, in order."""
    monkeypatch.chdir(tmp_path)
    Path("machine.toml").write_text(MACHINE + PLATE, encoding="utf-8")
    found = []

    def telling(module, name):
        work = getattr(module, name)

        def told_of(*given, **options):
            found.append(name)
            return work(*given, **options)

        monkeypatch.setattr(module, name, told_of)

    def waits():
        found.append("wait")
        return Pictures()

    monkeypatch.setattr(reports.pictures, "prepare_drawing", lambda **_: None)
    monkeypatch.setattr(reports.pictures, "drawing", lambda result: nullcontext(waits))
    telling(reports.pictures, "prepare_drawing")
    telling(ballesta.pipeline, "check_with_cycles")
    telling(reports.pictures, "drawing")
    telling(reports.live.section, "with_encoded_fields")
    return found


def test_drawing_is_prepared_before_the_check_and_waited_for_when_all_else_is_done(told):
    check_to_folder(Path("machine.toml"), Path("out"), effort=Effort("formula"))
    order = ["prepare_drawing", "check_with_cycles", "drawing", "with_encoded_fields"]
    assert told[:4] == order
    assert told.index("wait") == len(told) - 2  # then they are asked whether all are there
    assert (Path("out") / "result.json").is_file()


def test_nothing_is_prepared_for_a_file_that_cannot_be_read(told):
    Path("machine.toml").write_text("name = 3", encoding="utf-8")
    with pytest.raises(DesignError):
        check_to_folder(Path("machine.toml"), Path("out"))
    assert told == []
