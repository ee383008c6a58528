"""The section of the live view as text: what the page's script and its readers are given."""

import gzip
import json
import re
from base64 import b64decode
from dataclasses import replace
from html.parser import HTMLParser
from importlib.resources import files

import numpy as np
import pytest
from markupsafe import Markup
from matplotlib import colormaps

from checks.result.verdict import Status
from reports.live.section import (
    FIELDS,
    MAPS,
    cycles_data,
    first_part,
    live_payload,
    live_section,
    motion_text,
    peak_tables,
    rows_of,
)
from reports.plain_still import colour_maps
from reports.templating import LIVE, series

from .. import results
from . import sections


def block(body, name):
    return re.search(rf'<script type="[a-z/]+" id="{name}">(.*?)</script>', body, re.DOTALL)[1]


def test_the_same_result_gives_the_same_section():
    one, two = (live_section(sections.design()) for _ in range(2))
    assert one == two


def test_the_section_is_balanced_and_its_ids_are_single():
    class Reader(HTMLParser):
        def __init__(self):
            super().__init__()
            self.open, self.ids = [], []

        def handle_starttag(self, tag, attrs):
            self.ids += [value for name, value in attrs if name == "id"]
            if tag not in ("img", "input", "br"):
                self.open.append(tag)

        def handle_endtag(self, tag):
            assert self.open.pop() == tag

    design = sections.design()
    reader = Reader()
    reader.feed(live_section(design))
    assert reader.open == []
    assert len(reader.ids) == len(set(reader.ids))
    assert {"live", "live-panel", "live-cycles", "live-header", "live-motion"} < set(reader.ids)


def test_data_blocks_cannot_be_ended_by_a_name():
    design = sections.design()
    name = f"</script>{results.HOSTILE}"
    parts = [replace(design.parts[0], name=name), *design.parts[1:]]
    body = live_section(replace(design, parts=parts, motion={}))
    for data in ("live-section", "live-header"):
        assert "</script>" in json.dumps(json.loads(block(body, data)))
        assert not set("<>&") & set(block(body, data))


def test_the_curve_behind_the_slider_has_every_peak_also_of_a_long_cycle():
    """180 points tell of 5000 positions: each has the largest of its stretch."""
    design = sections.design()
    turn = design.cycles["turn"]
    name = design.parts[0].name
    peaks = np.full(5000, 10.0)
    peaks[[17, 2503]] = 80.0, 100.0
    long = {**turn, "position": np.arange(5000.0), "time": np.arange(5000.0),
            "phase": ["round"] * 5000, "peaks": {name: peaks}}  # fmt: skip
    changed = replace(design, cycles={**design.cycles, "turn": long}, motion={})
    curve = json.loads(block(live_section(changed), "live-section"))["curves"][0][0]
    heights = np.frombuffer(b64decode(curve["heights"]), dtype=np.uint8)
    assert len(heights) == 180
    assert (curve["most"], curve["at"]) == (100.0, 2503)
    assert sorted(heights.tolist())[-3:] == [26, 204, 255]
    assert heights.argmax() == 2503 * 180 // 5000


def test_a_page_without_a_deciding_place_begins_at_the_largest_stress_of_all_cycles():
    design = sections.design()
    name = design.parts[0].name
    cycles = {
        key: {**cycle, "peaks": {name: np.linspace(1.0, most, len(cycle["position"]))}}
        for (key, cycle), most in zip(design.cycles.items(), (50.0, 90.0), strict=True)
    }
    part = replace(design.parts[0], checks=[], live=replace(design.parts[0].live, peak=None))
    body = live_section(replace(design, cycles=cycles, parts=[part], motion={}))
    last = len(list(design.cycles.values())[1]["position"]) - 1
    assert json.loads(block(body, "live-section"))["start"] == [1, last]


def test_a_table_of_a_model_that_is_not_drawn_does_not_call_its_stress_the_surface_s():
    design = sections.design()
    heads = [dict(head) for head in live_payload(design).header["parts"]]
    (own, *_) = peak_tables(design.parts[0], heads[0], design)
    assert own["kind"].startswith("largest von Mises stress on the surface")
    (other, *_) = peak_tables(design.parts[0], heads[0] | {"decides": False}, design)
    assert (
        other["kind"]
        == "largest stress of the model that decides, which is not the one that is drawn"
    )


def test_cycles_tell_positions_moments_and_phases():
    design = sections.design()
    turn, hold = cycles_data(design)
    assert [turn["name"], hold["name"]] == list(sections.CYCLES)
    np.testing.assert_allclose(turn["position"], design.cycles["turn"]["position"], rtol=1e-6)
    phases = [turn["phase"][k] for k in turn["phase_of"]]
    assert phases == design.cycles["turn"]["phase"]
    assert turn["phase"] == ["out", "back"]


@pytest.mark.parametrize("values", [[5.0, 5.0], [0.0, 1e3, -250.0, 0.125], [1e-9, 3e-9]])
def test_a_series_is_right_to_half_a_step_of_its_range(values):
    """Half of range / 60 000, and the six digits to which the step is written."""
    made = series(np.array(values))
    read = made["from"] + made["step"] * np.cumsum(made["d"])
    tolerance = np.ptp(values) * (0.51 / 60_000 + 1e-6) + 1e-9 * np.abs(values).max()
    np.testing.assert_allclose(read, values, rtol=0, atol=tolerance)


def test_motion_tells_poses_of_parts_and_forces_at_pins():
    design = sections.design()
    turn, hold = json.loads(gzip.decompress(b64decode(motion_text(design))))
    assert hold is None
    assert turn["index"] == list(range(0, sections.POSITIONS, 2))
    assert [part["z"] for part in turn["parts"]] == [0.0, 15.0, 30.0]
    pin = turn["pins"][1]
    assert (pin["on"], pin["minor"], pin["z"]) == (1, False, 12.0)
    force = pin["fx"]["from"] + pin["fx"]["step"] * np.cumsum(pin["fx"]["d"])
    true = design.motion["turn"].pins["shaft eye"].force[:, 0]
    np.testing.assert_allclose(force, true, rtol=0, atol=1e-5 * np.ptp(true))
    assert motion_text(replace(design, motion={})) == ""


def test_tables_tell_the_worst_and_at_least_eight_positions_of_each_cycle():
    design = sections.design()
    heads = live_payload(design).header["parts"]
    tables = peak_tables(design.parts[0], heads[0], design)
    assert [table["cycle"] for table in tables] == list(sections.CYCLES)
    for table in tables:
        assert len(table["rows"]) >= 8
        (worst,) = [row for row in table["rows"] if row["worst"]]
        values = [float(row["value"]) for row in table["rows"]]
        assert float(worst["value"]) == max(values)
        peak = design.parts[0].live.peaks[table["cycle"]].max()
        assert max(values) == pytest.approx(peak, rel=5e-4)  # four digits
    assert sum("hot spot" in table["kind"] for table in tables) == 1
    assert peak_tables(design.parts[2], heads[2], design) == []


def test_a_short_cycle_is_told_whole():
    assert rows_of(np.array([1.0, 3.0, 2.0])) == [0, 1, 2]


def test_the_deciding_part_is_shown_first_if_its_stress_is_known():
    design = sections.design()
    heads = live_payload(design).header["parts"]
    assert design.deciding.part == design.parts[first_part(design, heads)].name
    hard = replace(design.parts[1].checks[0], value=400.0)
    parts = [design.parts[0], replace(design.parts[1], checks=[hard]), design.parts[2]]
    assert first_part(replace(design, parts=parts), heads) == 1
    worst = replace(design.parts[2].checks[0], value=900.0)  # of the plate, which has no field
    parts = [*design.parts[:2], replace(design.parts[2], checks=[worst])]
    changed = replace(design, parts=parts)
    assert changed.deciding.status is Status.FAIL
    assert first_part(changed, heads) == 0
    assert first_part(replace(design, parts=[]), []) == -1


def test_colour_maps_are_tables_and_the_safe_ones_grow_lighter():
    """Relative luminance of W3C's WCAG 2.1 grows along viridis and cividis."""
    for name, _ in MAPS.values():
        table = np.frombuffer(b64decode(colour_maps()[name]), np.uint8).reshape(256, 3) / 255
        if name in ("viridis", "cividis"):
            linear = np.where(table <= 0.04045, table / 12.92, ((table + 0.055) / 1.055) ** 2.4)
            assert (np.diff((linear @ [0.2126, 0.7152, 0.0722])[::8]) > 0).all()


def test_colour_maps_are_those_of_matplotlib():
    for name, _ in MAPS.values():
        colours = colormaps[name](np.linspace(0.0, 1.0, 256))[:, :3]
        table = np.frombuffer(b64decode(colour_maps()[name]), np.uint8).reshape(256, 3)
        assert (table == np.rint(255 * colours)).all()


def test_the_scripts_are_there_and_name_every_field():
    folder = files("reports.live")
    texts = {name: folder.joinpath(f"{name}.js").read_text(encoding="utf-8") for name in LIVE}
    assert all(texts.values())
    told = re.search(r"FIELDS = (\[.*?\])", texts["fields"], re.DOTALL)[1]
    assert re.findall(r'"(\w+)"', told) == list(FIELDS)
    for text in texts.values():
        assert not re.search(r"innerHTML|eval\(|https?:|setAttribute\(.on", text)


def test_fields_over_the_life_are_called_what_they_are():
    body = live_section(sections.design())
    assert "Mean stress as Goodman takes it (tension only)" in body
    assert "Fatigue utilisation over the duty" in body
    assert "Mean stress over the cycle" not in body


@pytest.mark.parametrize(("meshes", "command"), [([], True), ([{"body": "whole"}], False)])
def test_the_lead_promises_stress_only_where_a_part_has_a_field(meshes, command):
    design = sections.design()
    assert "recomputed in this page" in live_section(design)
    grey = [replace(part, live=design.parts[2].live, meshes=meshes) for part in design.parts]
    body = live_section(replace(design, parts=grey))
    assert "recomputed in this page" not in body
    assert "No part has a field of stress" in body
    assert ("--fidelity solid" in body) is command


@pytest.mark.parametrize("marked", [True, False])
def test_the_mechanism_stands_with_the_readings(marked):
    figure = Markup('<figure id="mechanism"></figure>') if marked else None
    body = live_section(sections.design(), mechanism=figure)
    places = [
        body.find(f'id="{name}"')
        for name in ("live-panel", "live-transport", "live-more", "mechanism")
    ]
    assert (places == sorted(places) and min(places) > 0) is marked
