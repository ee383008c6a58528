import errno
import json
import os
import re
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ballesta.batches.job import FolderError, Job, run_job
from checks.design.errors import DesignError, NumericsError
from geometry.memory import TooLargeError

from ...small_machine import MACHINE, PLATE


@pytest.fixture
def job(tmp_path):
    (tmp_path / "machine.toml").write_text(MACHINE + PLATE)
    file, folder = str(tmp_path / "machine.toml"), str(tmp_path / "out" / "machine")
    return Job("machine", file, ("parts.rod.thickness=9 mm",), "formula", None, "7 %", folder)


def test_an_outcome_is_plain_data_with_what_was_set(job):
    outcome = run_job(job)
    assert json.loads(json.dumps(outcome, allow_nan=False)) == outcome
    assert outcome["inputs"]["parts.rod.thickness"] == "9 mm"
    assert outcome["inputs"]["accuracy"] == "7 %"
    assert list(outcome["sources"]) == [job.file]
    assert outcome["mass"] == outcome["masses"]["rod"] > 0
    assert [check["governing"] for check in outcome["checks"]].count(True) == 1


def test_the_thumbnail_of_a_part_that_a_formula_decided_shows_its_estimated_stress(job):
    run_job(replace(job, reports=True, overrides=("load_factor=20",)))
    folder = Path(job.folder)
    page = (folder / "report.html").read_text()
    assert re.search('alt="The whole part of rod, coloured by [^"]*, estimate"', page)
    assert "peaks at bores, fillets and pressed edges, which the checks count" in page
    pixels = np.asarray(Image.open(folder / "thumbnail.png").convert("RGB")).astype(int)
    part = pixels[:, : int(0.83 * pixels.shape[1])]
    assert (np.ptp(part, axis=2) > 12).mean() > 0.02


def test_a_full_disk_is_not_told_as_a_design_s_fault(job, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("reports.files.write_json", full)
    with pytest.raises(FolderError, match="No space left"):
        run_job(job)


def test_what_gave_up_tells_what_was_being_done(job, monkeypatch):
    def gives_up(design, *, say, **_):
        say("rod: solving")
        raise NumericsError("it does not converge", "rod", "change it")

    monkeypatch.setattr("ballesta.pipeline.check_design", gives_up)
    outcome = run_job(job)
    assert (outcome["status"], outcome["exit_code"]) == ("gave up", 3)
    assert "it does not converge" in outcome["error"]
    assert outcome["stage"] == "rod: solving"


def test_nothing_of_an_earlier_result_is_left_beside_a_new_verdict(job, tmp_path):
    run_job(job)
    folder = tmp_path / "out" / "machine"
    assert (folder / "result.json").is_file()
    (tmp_path / "machine.toml").write_text("name =")
    assert run_job(job)["status"] == "wrong input"
    assert list(folder.iterdir()) == []


def test_what_another_batch_has_found_is_taken_from_a_shared_store(job, tmp_path, monkeypatch):
    first = replace(job, store=str(tmp_path / "store"))
    before = run_job(first)

    def checks(*_, **__):
        raise AssertionError("a design was checked again")

    monkeypatch.setattr("ballesta.pipeline.check_design", checks)
    again = run_job(replace(first, folder=str(tmp_path / "other")))
    assert again["checks"] == before["checks"]
    assert again["result_sha256"] == before["result_sha256"]
    with pytest.raises(AssertionError, match="checked again"):
        run_job(replace(first, overrides=("parts.rod.thickness=9.1 mm",)))


def test_a_lack_of_memory_is_no_wrong_input_and_is_tried_again(job, monkeypatch):
    def too_large(design, **_):
        try:
            raise TooLargeError("2 GiB needed, 1 GiB is free")
        except TooLargeError as error:
            raise DesignError(design.file, "parts.rod", str(error)) from error

    monkeypatch.setattr("ballesta.pipeline.check_design", too_large)
    assert run_job(job)["status"] == "out of memory"


def test_a_failed_design_is_remembered_by_the_text_that_was_checked(job, monkeypatch, tmp_path):
    file = tmp_path / "machine.toml"
    checked = file.read_text()

    def mended(design, **_):
        file.write_text(checked + "# mended\n")
        raise NumericsError("it does not converge", "rod", "change it")

    monkeypatch.setattr("ballesta.pipeline.check_design", mended)
    assert run_job(job)["sources"] == {str(file): sha256(checked.encode()).hexdigest()}
