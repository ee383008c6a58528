import pytest

from ballesta.batches.plan import Request, claim_folder, planned
from ballesta.batches.processes import parse_memory
from checks.design.errors import DesignError

from ...small_machine import MACHINE, PLATE

SWEEP = ("parts.rod.thickness = 6..8 mm : 3",)


@pytest.fixture
def design(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(MACHINE + PLATE)
    return path


def names(plan):
    return [job.name for job in plan.jobs]


def test_a_folder_stands_for_its_design_files_by_name(design, tmp_path):
    for name in ("b.toml", "a.toml", ".hidden.toml", "notes.txt"):
        (tmp_path / name).write_text(name)
    plan = planned(Request((str(tmp_path),)), tmp_path / "out", None)
    assert names(plan) == ["a", "b", "machine"]


def test_files_of_one_name_get_their_folder_s_and_never_one_place(tmp_path):
    for folder in ("x", "X", "y"):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "a.toml").write_text(folder)
    (tmp_path / "journal.jsonl.toml").write_text("")
    files = [str(tmp_path / name) for name in ("x/a.toml", "X/a.toml", "y/a.toml")]
    plan = planned(Request((*files, str(tmp_path / "journal.jsonl.toml"))), tmp_path / "o", None)
    assert names(plan) == ["x_a", "X_a_2", "y_a", "journal.jsonl_2"]
    assert [job.folder for job in plan.jobs] == [str(tmp_path / "o" / name) for name in names(plan)]


def test_the_same_file_is_checked_once_and_a_copy_is_named_as_one(design, tmp_path):
    (tmp_path / "copy.toml").write_bytes(design.read_bytes())
    (tmp_path / "empty.toml").write_text("")
    (tmp_path / "void.toml").write_text("")
    plan = planned(Request((str(design), str(tmp_path))), tmp_path / "out", None)
    assert names(plan) == ["machine", "copy", "empty", "void"]
    assert plan.notes == {
        "machine": "given more than once, checked once",
        "copy": "duplicate: the same text as machine.toml",
    }


def test_a_sweep_makes_a_job_of_each_variation(design, tmp_path):
    plan = planned(Request((str(design),), sweeps=SWEEP), tmp_path / "out", None)
    assert names(plan) == ["machine-1", "machine-2", "machine-3"]
    assert [job.overrides for job in plan.jobs] == [
        ("parts.rod.thickness=6 mm",),
        ("parts.rod.thickness=7 mm",),
        ("parts.rod.thickness=8 mm",),
    ]


def test_a_design_that_cannot_be_varied_so_is_a_row_beside_others_that_can(design, tmp_path):
    (tmp_path / "broken.toml").write_text("name =")
    other = (MACHINE + PLATE).replace("parts.rod", "parts.bar")
    (tmp_path / "other.toml").write_text(other)
    plan = planned(Request((str(tmp_path),), sweeps=SWEEP), tmp_path / "out", None)
    assert names(plan) == ["broken", "machine-1", "machine-2", "machine-3", "other"]
    assert list(plan.refused) == ["other"]
    assert "parts.rod" in plan.refused["other"]


@pytest.mark.parametrize(
    ("sweep", "words"),
    [
        ("parts.rod.thicknes = 6..8 mm : 3", "did you mean"),
        ("parts.rod.thickness = 6..8 kg : 3", "parts.rod.thickness"),
        ("parts.rod.thickness", "--sweep"),
    ],
)
def test_a_sweep_that_no_design_can_take_is_refused_at_once(design, tmp_path, sweep, words):
    with pytest.raises(DesignError, match=words):
        planned(Request((str(design),), sweeps=(sweep,)), tmp_path / "out", None)


@pytest.mark.parametrize(("count", "expected"), [(50, True), (51, False)])
def test_reports_are_written_for_up_to_50_designs_unless_asked(tmp_path, count, expected):
    for index in range(count):
        (tmp_path / f"d{index}.toml").write_text(str(index))
    request = Request((str(tmp_path),))
    for reports, wanted in ((None, expected), (True, True), (False, False)):
        plan = planned(request, tmp_path / "out", reports)
        assert {job.reports for job in plan.jobs} == {wanted}


def test_a_folder_without_designs_is_refused(tmp_path):
    with pytest.raises(DesignError, match="holds no design file"):
        planned(Request((str(tmp_path),)), tmp_path / "out", None)


def test_a_batch_finds_its_own_folder_again(tmp_path):
    request = Request(("a.toml",), sweeps=SWEEP, within="60s")
    claim_folder(tmp_path / "out", request)
    (tmp_path / "out" / "journal.jsonl").touch()
    claim_folder(tmp_path / "out", request)


def test_the_folder_of_another_batch_is_refused_with_what_differs(tmp_path):
    claim_folder(tmp_path / "out", Request(("a.toml",), fidelity="formula"))
    with pytest.raises(DesignError, match=r"another batch \(--fidelity: formula there, solid now"):
        claim_folder(tmp_path / "out", Request(("a.toml",), fidelity="solid"))
    with pytest.raises(DesignError, match=r"another batch \(DESIGN: a.toml there, b.toml now"):
        claim_folder(tmp_path / "out", Request(("b.toml",), fidelity="formula"))


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b"\xff", b'{"format": "another/9"}'])
def test_a_record_that_is_none_of_ours_is_refused(tmp_path, content):
    (tmp_path / "batch.json").write_bytes(content)
    with pytest.raises(DesignError, match="not one of this version"):
        claim_folder(tmp_path, Request(("a.toml",)))


def test_a_folder_that_holds_other_things_is_refused_and_left_alone(tmp_path):
    (tmp_path / "thesis.docx").write_text("years of work")
    with pytest.raises(DesignError, match=r"not empty and no batch \(thesis.docx\)"):
        claim_folder(tmp_path, Request(("a.toml",)))
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.docx"]


@pytest.mark.parametrize("name", ["a file", "a file/below"])
def test_a_place_that_cannot_be_a_folder_is_told(tmp_path, name):
    (tmp_path / "a file").touch()
    with pytest.raises(DesignError, match="--out: cannot be written"):
        claim_folder(tmp_path / name, Request(("a.toml",)))


@pytest.mark.parametrize("text", ["4", "GB", "1 KB", "100 MB", "-4 GB", "4 GB or so", ""])
def test_a_memory_size_without_sense_is_refused(text):
    with pytest.raises(ValueError, match="must be"):
        parse_memory(text)
