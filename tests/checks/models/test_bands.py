"""Bars of the rungs: from solids, and only for proportions that were compared."""

import json
from collections import defaultdict
from math import exp, inf, sqrt
from pathlib import Path

import pytest

from bench import rung_bands
from bench.rung_bands import Compared
from bench.rung_beyond import PULLED
from checks.models import bands
from checks.models.bands import (
    ARC,
    SHARE,
    Band,
    NoBand,
    band_of,
    known_band,
    of_buckling,
    thin_wall,
)
from checks.models.checked import BY_STRESS, MOST_BENT, MOST_FAR, MOST_PULLED, STOUT

CLOSE = bands._CLOSE
DATA = bands._data()
RUNGS = Path(rung_bands.__file__).parent / "rungs"
ENTRY = {
    "low": 0.9,
    "high": 1.2,
    "count": 20,
    "above": [0.01, 0.05],
    "below": [0.0, 0.1],
    "scales": {"hole / width": [0.3, 0.7]},
}


@pytest.fixture(autouse=True)
def one_band(monkeypatch):
    monkeypatch.setattr(bands, "_data", lambda: {"plate_link": {"formula": {"static": ENTRY}}})
    monkeypatch.setattr(bands, "_beyond_data", dict)


def test_a_part_within_the_proportions_compared_has_the_band():
    band = band_of("plate_link", "formula", "static", {"hole / width": 0.5})
    assert band == Band(0.9, 1.2, 20, (0.01, 0.05), (0.0, 0.1))


def test_proportions_may_leave_the_range_by_a_tenth_of_it():
    assert isinstance(band_of("plate_link", "formula", "static", {"hole / width": 0.73}), Band)
    beyond = band_of("plate_link", "formula", "static", {"hole / width": 0.75})
    told = "hole / width is 0.75, solids were compared from 0.3 to 0.7"
    assert beyond == NoBand(told, least=bands.LEAST)


def test_a_proportion_that_no_solid_had_has_no_band():
    """A pin without a step tells none of its fillet; one with a step must have been compared."""
    stepped = band_of("plate_link", "formula", "static", {"fillet / neck": 0.03})
    assert stepped == NoBand("fillet / neck is 0.03, no solid that has one was compared")
    assert isinstance(band_of("plate_link", "formula", "static", {}), Band)


BEYOND = {
    "lower": 0.5,
    "higher": 1.0,
    "furthest": 1.0,
    "count": 12,
    "above": 0.08,
    "below": 0.05,
    "scales": {"hole / width": [0.2, 1.5]},
}


@pytest.fixture
def grown(monkeypatch):
    monkeypatch.setattr(bands, "_beyond_data", lambda: {"plate_link": {"static": BEYOND}})


@pytest.mark.usefixtures("grown")
def test_a_band_grows_with_the_logarithm_of_how_far_a_part_is_beyond_the_range():
    """1.4 is twice the end of the range: d = ln 2, exp(d/2) = sqrt 2 down and exp(d) = 2 up."""
    band = band_of("plate_link", "formula", "static", {"hole / width": 1.4})
    assert (band.low, band.high) == pytest.approx((0.9 / sqrt(2), 1.2 * 2), rel=1e-12)
    assert (band.above, band.below) == ((0.01, 0.08), (0.0, 0.1))
    assert "2.00 times as high and 1.41 times as low, as 12 solids out there need" in band.wider
    inside = band_of("plate_link", "formula", "static", {"hole / width": 0.5})
    assert (inside.low, inside.wider) == (0.9, "")


@pytest.mark.usefixtures("grown")
def test_beyond_what_was_drawn_out_there_there_is_no_band():
    """Each proportion, to a tenth, the distance in all, and the rung: each has its end."""
    assert isinstance(band_of("plate_link", "formula", "static", {"hole / width": 1.6}), Band)
    assert isinstance(band_of("plate_link", "formula", "static", {"hole / width": 1.7}), NoBand)
    assert isinstance(band_of("plate_link", "formula", "static", {"hole / width": 0.1}), NoBand)
    nearer = BEYOND | {"furthest": 0.5}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bands, "_beyond_data", lambda: {"plate_link": {"static": nearer}})
        far = band_of("plate_link", "formula", "static", {"hole / width": 1.4})
        near = band_of("plate_link", "formula", "static", {"hole / width": 1.0})
    assert isinstance(far, NoBand)
    assert isinstance(near, Band)


@pytest.mark.usefixtures("grown")
def test_a_wider_arc_of_contact_than_was_compared_leaves_the_pin_less_room_and_has_the_band(
    monkeypatch,
):
    entry = ENTRY | {"scales": {ARC: [90.0, 90.0]}}
    monkeypatch.setattr(bands, "_data", lambda: {"plate_link": {"formula": {"static": entry}}})
    wider = band_of("plate_link", "formula", "static", {ARC: 150.0})
    assert (wider.low, wider.high, wider.wider) == (0.9, 1.2, "")
    assert isinstance(band_of("plate_link", "formula", "static", {ARC: 60.0}), NoBand)


def test_a_longer_bar_than_was_compared_buckles_as_these_did_and_a_shorter_one_has_no_band(
    monkeypatch,
):
    entry = ENTRY | {"scales": {"length / width": [2.0, 8.0]}}
    kinds = {"static": entry, "buckling": entry}
    monkeypatch.setattr(bands, "_data", lambda: {"plate_link": {"formula": kinds}})

    def found(kind, length):
        return band_of("plate_link", "formula", kind, {"length / width": length})

    assert found("buckling", 80.0) == found("buckling", 5.0) == found("static", 5.0)
    assert found("buckling", 1.5) == found("static", 1.5) == found("static", 5.0)
    assert isinstance(found("buckling", 1.0), NoBand)
    assert isinstance(found("static", 80.0), NoBand)


def test_buckling_depends_on_loads_over_the_largest_that_can_buckle(monkeypatch):
    """A rod pulled by twice its push is as those compared under the push alone."""
    pushed, across, pulled = SHARE + "pushed", SHARE + "across", SHARE + "pulled"
    entry = ENTRY | {"scales": {pushed: [1.0, 1.0], across: [0.0, 0.05]}}
    kinds = {"static": entry, "buckling": entry}
    monkeypatch.setattr(bands, "_data", lambda: {"plate_link": {"formula": kinds}})

    def found(kind, **loads):
        scales = {SHARE + name: value for name, value in loads.items()}
        return band_of("plate_link", "formula", kind, scales)

    assert isinstance(found("buckling", pushed=0.5, across=0.02, pulled=1.0), Band)
    assert isinstance(found("static", pushed=0.5, across=0.02), NoBand)
    assert isinstance(found("buckling", pushed=0.1, across=0.05, pulled=1.0), NoBand)
    assert of_buckling({pulled: 1.0, pushed: 0.0, across: 0.0}) == {}


def test_long_bars_beyond_the_range_lie_inside_the_band_of_those_within():
    """Solids of up to 2.8 times the length compared, none of them part of the band."""
    held = []
    for line in map(json.loads, (RUNGS / "beyond.jsonl").read_text().splitlines()):
        solid, rung = line["solid"].get("buckling"), line["rungs"].get("buckling")
        if not solid or not rung or 2 * solid[1] > solid[0]:
            continue  # a solid is known to half of its value
        family = line["families"].get("buckling")
        if not family or thin_wall(line["scales"]):
            continue  # walls that buckle by themselves have no band, however long the bar
        band = DATA[family]["formula"]["buckling"]
        stout = STOUT / BY_STRESS * line["by stress"]
        held += [
            band["low"] <= solid[0] / rung and solid[0] <= band["high"] * rung + stout
            for name, value in of_buckling(line["scales"]).items()
            if name.startswith("length / ") and value > band["scales"][name][1]
        ]
    assert len(held) >= 13
    assert all(held)


def test_without_a_band_a_stress_has_a_least_value_but_buckling_and_uncompared_shapes_have_none(
    monkeypatch,
):
    kinds = {"static": ENTRY, "buckling": ENTRY}
    monkeypatch.setattr(bands, "_data", lambda: {"plate_link": {"formula": kinds}})
    far = {"hole / width": 5.0}
    assert band_of("plate_link", "formula", "static", far).least == bands.LEAST
    assert band_of("plate_link", "formula", "buckling", far).least == -inf
    assert band_of("fork", "formula", "static", far).least == -inf


def test_the_least_value_holds_for_every_bar_that_was_ever_compared_with_a_formula():
    """Within the range and beyond it; pins, whose pressed edges no mesh resolves, have none."""
    ratios = [
        line["truth"] / line["value"]
        for line in map(json.loads, (RUNGS / "compared.jsonl").read_text().splitlines())
        if line["rung"] == "formula" and line["kind"] != "buckling" and line["family"] in CLOSE
    ]
    for line in map(json.loads, (RUNGS / "beyond.jsonl").read_text().splitlines()):
        for kind, family in line.get("families", {}).items():
            if kind != "buckling" and kind in line["solid"] and family in CLOSE:
                ratios.append(line["solid"][kind][0] / line["rungs"][kind])
    assert len(ratios) > 300
    assert min(ratios) > 1.25 * bands.LEAST


def test_solids_that_are_only_pulled_have_less_than_the_bound_on_their_buckling():
    """Ten times the share of what bends them and twelve times their peak stress over E."""
    seen = [
        (line["solid"]["buckling"][0], line["rungs"][PULLED], line["by stress"])
        for line in map(json.loads, (RUNGS / "beyond.jsonl").read_text().splitlines())
        if PULLED in line["rungs"] and "buckling" in line["solid"]
    ]
    assert len(seen) >= 5
    for solid, share, by_stress in seen:
        assert solid < MOST_PULLED * share + by_stress


def test_no_solid_has_nearly_twice_a_bar_s_share_and_what_its_stress_adds():
    """The bound beyond all proportions, asked of all that were solved, near and far."""
    found = defaultdict(list)
    for line in map(json.loads, (RUNGS / "compared.jsonl").read_text().splitlines()):
        if line["kind"] == "buckling":
            more = line["by_stress"] * BY_STRESS / STOUT
            found[line["family"]].append((line["truth"] - more) / line["value"])
    bent = found.pop("bent lever")
    assert len(bent) >= 16
    assert max(bent) < 0.55 * MOST_BENT
    left = [one for family in found.values() for one in family]
    left += [
        (line["solid"]["buckling"][0] - line["by stress"]) / line["rungs"]["buckling"]
        for line in map(json.loads, (RUNGS / "beyond.jsonl").read_text().splitlines())
        if "buckling" in line["rungs"]
        and "buckling" in line["solid"]
        and not thin_wall(line["scales"])  # these are not bounded so
    ]
    assert len(left) > 170
    assert max(left) < 0.56 * MOST_FAR


def test_a_shape_or_check_that_was_not_compared_has_no_band():
    assert isinstance(band_of("leaf_pack", "formula", "static", {}), NoBand)
    assert known_band("plate_link", "formula", "fatigue") is None


def row(truth, value, scale=0.5, above=0.0):
    return Compared(
        "plate_link", "s/p", "s/p/0", "formula", "static", truth, 0.0, above, 0.0, value, 1.0,
        {"hole / width": scale},
    )  # fmt: skip


def test_a_band_is_where_the_next_solid_lies_in_95_per_cent_of_all_cases():
    """Ratios e^-0.1, 1, e^0.1: mean 0, deviation 0.1, and t of 2 degrees of freedom is 4.303."""
    rows = [row(exp(x), 1.0) for x in (-0.1, 0.0, 0.1)]
    found = rung_bands.band_of(rows)
    reach = 4.3027 * 0.1 * sqrt(4 / 3)
    assert found["low"] == pytest.approx(exp(-reach), rel=1e-4)
    assert found["high"] == pytest.approx(exp(reach), rel=1e-4)
    assert found["count"] == 3


def test_solids_that_hardly_scatter_leave_two_per_cent_to_either_side():
    found = rung_bands.band_of([row(ratio, 1.0) for ratio in (1.0999, 1.1, 1.1001)])
    assert (found["low"], found["high"]) == pytest.approx((1.1 * 0.98, 1.1 * 1.02), rel=1e-4)


def test_shares_of_the_largest_force_may_leave_the_range_by_a_tenth_of_that_force(monkeypatch):
    name = SHARE + "pulled"
    entry = ENTRY | {"scales": {name: [0.0, 0.02]}}
    monkeypatch.setattr(bands, "_data", lambda: {"plate_link": {"formula": {"static": entry}}})
    assert isinstance(band_of("plate_link", "formula", "static", {name: 0.09}), Band)
    assert isinstance(band_of("plate_link", "formula", "static", {name: 0.13}), NoBand)


def test_a_biased_rung_keeps_its_bias_in_the_band():
    """Ratios 1.1 and 1.2: both ends of the band are above 1 if they scatter less than that."""
    rows = [row(ratio, 1.0) for ratio in (1.19, 1.2, 1.21)]
    assert 1.15 < rung_bands.band_of(rows)["low"] < 1.19


def test_a_band_knows_the_least_and_the_most_of_the_solids_own_model_bands():
    rows = [row(100.0, 100.0, above=a) for a in (2.0, 5.0)] + [row(101.0, 100.0)]
    assert rung_bands.band_of(rows)["above"] == pytest.approx([0.0, 0.05])


def test_too_few_solids_make_no_band():
    assert rung_bands.bands([row(1.0, 1.0), row(1.1, 1.0)]) == {}
    enough = [row(1.0 + 0.01 * k, sqrt(1.0)) for k in range(5)]
    assert "static" in rung_bands.bands(enough)["plate_link"]["formula"]
