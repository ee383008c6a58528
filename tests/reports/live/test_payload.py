"""The live view's data of a whole design, and what becomes of parts that are too large."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from checks.result.live_fields import EncodedPart, grey
from checks.result.verdict import Surface
from reports.live.section import (
    Budget,
    has_fields,
    live_payload,
    with_encoded_fields,
    without_fields,
)

from ..results import HOSTILE, mixed
from .decode import decode
from .surfaces import live, smooth, torus, turning, usual


def design(**fields):
    """The made-up design; its cycles are those of the fields, its parts as many."""
    whole = mixed()
    cycle = next(iter(whole.cycles.values()))
    first = whole.parts[0]
    parts = [replace(first, name=name, live=live) for name, live in fields.items()]
    return replace(whole, parts=parts, cycles={"work": cycle, "idle": cycle})


@pytest.fixture(scope="module")
def fields():
    return usual(count=4)


def test_every_part_has_a_block_and_plain_data_in_the_header(fields):
    nodes, triangles = torus(16, 8)
    payload = live_payload(design(one=fields, two=grey(nodes, triangles, "by formula")))
    header = json.loads(json.dumps(payload.header, allow_nan=False))
    assert header["format"] == "ballesta-live/1"
    assert [part["name"] for part in header["parts"]] == ["one", "two"]
    assert [part["block"] for part in header["parts"]] == ["live-part-0", "live-part-1"]
    assert [name for name, _ in payload.blocks] == ["live-part-0", "live-part-1"]
    assert all(re.fullmatch(r"[A-Za-z0-9+/]+=*", text) for _, text in payload.blocks)
    assert header["parts"][1]["notes"] == ["by formula"]
    for part, (_, text) in zip(header["parts"], payload.blocks, strict=True):
        assert len(decode(part, text).nodes) == part["nodes"]


def test_the_limits_of_the_checks_stand_beside_the_fields(fields):
    made = design(one=fields)
    check = replace(made.parts[0].checks[0], kind="static", limit=300.0, required=1.5)
    part = replace(made.parts[0], checks=[check])
    [head] = live_payload(replace(made, parts=[part])).header["parts"]
    assert head["limits"] == {"yield": 300.0, "allowed": 200.0, "column": None, "fatigue": None}
    assert head["scale"]["static"]["to"] == pytest.approx(head["scale"]["mises"]["to"] / 200)
    assert "column" not in head["scale"]
    column = replace(check, kind="buckling", limit=120.0, required=3.0, unit="MPa")
    part = replace(part, checks=[check, column])
    [head] = live_payload(replace(made, parts=[part])).header["parts"]
    assert head["scale"]["column"]["to"] == pytest.approx(head["scale"]["mises"]["to"] / 40)
    [head] = live_payload(replace(made, parts=[replace(part, checks=[])])).header["parts"]
    assert head["limits"] == {"yield": None, "allowed": None, "column": None, "fatigue": None}


@pytest.mark.parametrize(("judged", "limit"), [(True, 1.0), (False, None)])
def test_the_utilisation_is_that_of_the_check_with_its_required_safety(fields, judged, limit):
    fields = replace(fields, judged=judged)
    made = design(one=fields)
    used = float(fields.fatigue["utilisation"].max())
    check = replace(
        made.parts[0].checks[0], kind="fatigue", value=200 * used, limit=200.0, required=1.3
    )
    made = replace(made, parts=[replace(made.parts[0], checks=[check])])
    payload = live_payload(made)
    [head] = payload.header["parts"]
    assert head["scale"]["utilisation"]["to"] == pytest.approx(check.utilisation)
    drawn = decode(head, payload.blocks[0][1]).fatigue["utilisation"]
    assert drawn.max() == pytest.approx(check.utilisation)
    assert head["limits"]["fatigue"] == limit
    assert head["scale"]["amplitude"]["to"] == pytest.approx(fields.fatigue["amplitude"].max())
    without = replace(made, parts=[replace(made.parts[0], checks=[])])
    assert live_payload(without).header["parts"][0]["limits"]["fatigue"] is None


def test_names_are_handed_on_as_they_are(fields):
    [part] = live_payload(design(**{HOSTILE: fields})).header["parts"]
    assert part["name"] == HOSTILE


def test_an_encoded_result_gives_the_same_payload_and_a_hundredth_of_the_numbers(fields):
    made = design(one=fields)
    encoded = with_encoded_fields(made)
    assert isinstance(encoded.parts[0].live, EncodedPart)
    assert with_encoded_fields(encoded) is encoded
    one, other = live_payload(made), live_payload(encoded)
    assert (one.header, one.blocks) == (other.header, other.blocks)
    assert has_fields(encoded)
    assert not has_fields(without_fields(encoded))


@pytest.mark.parametrize(
    ("shown", "words"),
    [("not meshed", "without a mesh"), ("von Mises [MPa]", "was not kept")],
)
def test_a_part_whose_fields_nobody_asked_for_is_its_bare_surface(shown, words):
    nodes, triangles = torus(16, 8)
    made = design(one=None)
    surface = Surface(nodes, triangles, {shown: np.zeros(len(nodes))}, 0)
    made = replace(made, parts=[replace(made.parts[0], surface=surface)])
    payload = live_payload(made)
    [head] = payload.header["parts"]
    assert head["fields"] == 0
    assert words in head["missing"]["mises"]
    assert words in payload.header["parts"][0]["notes"][0]


def test_a_large_page_raises_the_tolerance_first_and_says_so(fields):
    made = design(one=fields, two=fields)
    usual_size = sum(len(text) for _, text in live_payload(made).blocks)
    payload = live_payload(made, Budget(coarse=usual_size - 1, most=usual_size))
    assert sum(len(text) for _, text in payload.blocks) < usual_size
    for part in payload.header["parts"]:
        assert 1e-3 < part["accuracy"]["share"] <= 5e-3
        assert "0.5 % of the cycle's peak, not to 0.1 %" in part["notes"][-1]
    assert all(len(part["notes"]) == 1 for part in payload.header["parts"])


def test_a_part_that_cannot_be_drawn_that_exactly_is_not_said_to_be():
    """Its unit loads cancel: single precision costs more than the raised tolerance."""
    surface = torus(24, 12)
    first, second = smooth(surface[0], 1)[0], smooth(surface[0], 1, seed=3)[0]
    turn = 1e5 * turning(1, 30)
    made = live(
        np.stack([first, first + 1e-5 * second]), {"work": np.concatenate([-turn, turn])}, surface
    )
    (head,) = live_payload(design(one=made), Budget(coarse=0)).header["parts"]
    assert head["accuracy"]["share"] > 5e-3
    assert not any("the page would be larger" in note for note in head["notes"])
    assert any("nearly cancel each other" in note for note in head["notes"])


def test_beyond_the_budget_the_largest_parts_lose_their_fields_and_the_page_says_so(fields):
    surface = torus(16, 8)
    small = live(smooth(surface[0], 2), {"work": turning(2, 20)}, surface)
    made = design(large=fields, small=small)
    coarse = live_payload(made, Budget(coarse=0))
    room = sum(len(text) for _, text in coarse.blocks) - 1
    large, other = live_payload(made, Budget(coarse=0, most=room)).header["parts"]
    assert large["fields"] == 0
    assert large["nodes"] == len(fields.nodes)
    assert "left out of the live view" in large["missing"]["mises"]
    assert other["fields"] == 2
    nothing = live_payload(made, Budget(coarse=0, most=1)).header["parts"]
    assert [part["fields"] for part in nothing] == [0, 0]
