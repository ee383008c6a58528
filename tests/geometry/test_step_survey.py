"""Damaged STEP files cost the process that reads them, not ours."""

import pytest
from numpy.testing import assert_array_equal

from geometry import step_file
from geometry.parameters import ParameterError
from geometry.parts.step_part import NamedHole, StepPart
from geometry.step_file import file_hash, survey_step, surveyed

from .step_files import link_file


@pytest.fixture(scope="module")
def link(tmp_path_factory):
    return link_file(tmp_path_factory.mktemp("step"))


@pytest.fixture(autouse=True)
def forgotten(monkeypatch):
    monkeypatch.setattr(step_file, "_kept", {})


def asked(path):
    return surveyed(path, file_hash(path))


def test_a_survey_from_another_process_is_that_of_ours_to_the_last_bit(link):
    ours, other = survey_step(link), asked(link)
    for name in ("volume", "area", "tag", "partial", "told"):
        assert getattr(ours, name) == getattr(other, name)
    for name in ("centre", "outline"):
        assert_array_equal(getattr(ours, name), getattr(other, name))
    assert [str(hole) for hole in ours.holes] == [str(hole) for hole in other.holes]
    for here, there in zip(ours.holes, other.holes, strict=True):
        assert_array_equal(here.direction, there.direction)
        assert (here.faces, here.plain, here.diameter) == (there.faces, there.plain, there.diameter)
    assert [(c.face, c.radius, c.concave) for c in ours.curved] == [
        (c.face, c.radius, c.concave) for c in other.curved
    ]


@pytest.mark.parametrize(
    ("sound", "damaged", "told"),
    [
        ("VECTOR('',#", "VECTOR('',$", "crashed|cannot be read"),
        ("DIRECTION('',(", "DIRECTI_N('',(", "crashed|cannot be read"),
        ("ORIENTED_EDGE('',*,*,", "ORIeNTED_EDGE('',*,*,", "cannot be measured"),
    ],
)
def test_a_bit_that_has_flipped_is_told_whatever_the_kernel_does(
    link, tmp_path, sound, damaged, told
):
    """The first two end the process that reads them (a segmentation fault of OpenCASCADE 7.8)."""
    text = link.read_text()
    assert sound in text
    path = tmp_path / "link.step"
    path.write_text(text.replace(sound, damaged, 5))
    part = {"holes": (NamedHole("first", 20.0), NamedHole("second", 20.0))}
    with pytest.raises(ParameterError, match=told):
        StepPart(path, **part)


@pytest.mark.parametrize(
    ("limit", "value", "told"),
    [("SECONDS", 0.01, "more than 0.01 s"), ("MEMORY", 2**20, "GiB of memory")],
)
def test_a_file_that_holds_the_kernel_is_let_go(link, monkeypatch, limit, value, told):
    monkeypatch.setattr(step_file, limit, value)
    with pytest.raises(ParameterError, match=told):
        asked(link)


def test_a_file_is_surveyed_once(link, monkeypatch):
    found = asked(link)
    monkeypatch.setattr(step_file.sys, "executable", "/no/such/python")
    assert asked(link) is found
    with pytest.raises(ParameterError, match="no process starts"):
        surveyed(link, "another digest")


def test_a_file_that_is_written_while_it_is_read_is_refused(link):
    with pytest.raises(ParameterError, match="was written while it was read"):
        surveyed(link, "the digest before")
