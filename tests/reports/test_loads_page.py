import json
import re
from base64 import b64encode
from hashlib import sha256

import numpy as np
import pytest

from checks.result.verdict import Gate
from reports.loads_page import loads_html, write_loads_page
from reports.mechanism_panel import mechanism_data, mechanism_svg

from . import loads_results
from .test_page import Page


@pytest.fixture(scope="module")
def press():
    return loads_results.press()


@pytest.fixture(scope="module")
def page(press):
    return loads_html(loads_results.result(press, gates=loads_results.GATES))


@pytest.mark.parametrize("kind", ["press", "hostile"])
def test_the_page_is_well_formed_and_stands_alone(kind, page):
    text = page if kind == "press" else loads_html(loads_results.hostile())
    parsed = Page(text)
    assert not {tag for tag, _ in parsed.tags} & {"link", "iframe", "object", "embed", "form"}
    assert not [a for tag, a in parsed.tags if tag == "script" and "src" in a]
    for _, attributes in parsed.tags:
        assert not [name for name in attributes if name.startswith("on")]
        for name in ("href", "src", "xlink:href", "srcset"):
            assert attributes.get(name, "#").startswith("#")
    assert "@import" not in text
    # the names of XML's own namespaces, which matplotlib writes, are never fetched
    outside = re.sub(r'xmlns(:xlink)?="http://www\.w3\.org/[^"]*"', "", text)
    assert not re.search(r"https?://", outside)


def test_the_policy_lets_only_the_page_s_own_script_run(page):
    (policy,) = [a["content"] for _, a in Page(page).tags if a.get("http-equiv")]
    (script,) = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    digest = b64encode(sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy


def test_hostile_names_are_shown_as_text():
    text = loads_html(loads_results.hostile())
    assert "<script>alert" not in text
    assert "<script>alert('x')</script>" in Page(text).text
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', text, re.DOTALL)
    assert any("<script>alert" in reading for reading in json.loads(data)["readings"])


def test_ids_occur_once(press):
    text = loads_html(loads_results.result(press, press))
    ids = [a["id"] for _, a in Page(text).tags if "id" in a]
    ids = [each for each in ids if not re.match("c[0-9a-f]{8}-", each)]  # of equal charts
    assert sorted(ids) == sorted(set(ids))


def test_without_a_script_the_picture_is_the_assembled_linkage(press):
    """Assembled at x = 200 mm: A is at (0, 300) mm, which SVG draws at y = -300."""
    parsed = Page(mechanism_svg(press, "c0"))
    places = {a["id"]: a["transform"] for _, a in parsed.tags if a.get("id", "").startswith("c0-p")}
    assert places["c0-point-2"] == "translate(0 -300)"
    arrows = [a for _, a in parsed.tags if a.get("class", "").startswith("arrow")]
    assert len(arrows) == 6
    assert not any("d" in arrow for arrow in arrows)


def test_the_picture_s_numbers_are_the_solution_s(press):
    data = mechanism_data(press, "c0")
    frame = int(np.argmin([abs(t - 1.8) for t in data["times"]]))
    index = int(np.argmin(np.abs(press.loads.times - data["times"][frame])))
    x, y, angle = press.loads.poses[index, press.loads.body_index("upper")]
    assert data["bodies"][frame][3:6] == pytest.approx([x, -y, -np.degrees(angle)], abs=1e-3)
    assert "cylinder 11.0 kN" in data["readings"][frame]
    # arrows end within the picture, at every position
    left, top, width, height = map(
        float, re.search(r'viewBox="([^"]*)"', mechanism_svg(press, "c0"))[1].split()
    )
    ends = np.array(data["arrows"]).reshape(-1, 2)
    assert (ends >= [left, top]).all()
    assert (ends <= [left + width, top + height]).all()


def test_extremes_gates_and_warnings_are_on_the_page(page):
    text = Page(page).text
    for words in (
        "61.18", "2, press", "NOT VALID press: speed irregularity", "the stop is ASSUMED",
        "Does not hold press: time of a cycle", "11.31 kN available", "impact",
    ):  # fmt: skip
        assert words in text, words


def test_the_controls_wait_for_the_script_and_are_labelled(page):
    tags = Page(page).tags
    assert [a for _, a in tags if a.get("class") == "controls" and "hidden" in a]
    (slider,) = [a for tag, a in tags if tag == "input"]
    assert "press" in slider["aria-label"]
    assert "prefers-reduced-motion" in page


def test_the_file_holds_the_page(tmp_path, press):
    result = loads_results.result(press)
    write_loads_page(result, tmp_path / "out" / "loads.html")
    assert (tmp_path / "out" / "loads.html").read_text(encoding="utf-8") == loads_html(result)


def test_every_point_of_a_force_has_its_name_in_the_picture(press):
    """The cylinder's rear pivot D has no joint."""
    labels = re.findall(r"<text [^>]*>([^<]*)</text>", mechanism_svg(press, "c0"))
    assert sorted(labels) == ["A", "B", "C", "D"]


def test_a_name_keeps_clear_of_the_arc_of_a_torque():
    """The arc about the pivot has a radius of 7 % of the picture; the name begins outside it."""
    data = mechanism_data(loads_results.crank(), "c0")
    pivot, crank_pin, *_ = data["lifts"]
    assert np.hypot(pivot, pivot) > 5 * data["tip"]
    assert np.hypot(crank_pin, crank_pin) < 5 * data["tip"]


def test_gates_of_one_kind_are_one_box(press):
    gates = [Gate(f"at_{k}: speed irregularity", 0.2, 0.1, f"flywheel {k}") for k in range(5)]
    text = loads_html(loads_results.result(press, gates=gates))
    assert text.count("<b>NOT VALID</b>") == 1
    assert "at_0 0.200, at_1 0.200" in text
