"""Encoded fields of a part: as exact as the page says, whatever they are."""

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from checks.result.live_fields import LiveFields, grey, von_mises
from reports.live.encode import TOLERANCE, Writer, encode

from .decode import decode, read_planes
from .surfaces import live, peak_of, principal_range, smooth, torus, turning, usual

CYCLES = ["work", "idle"]
SINGLE = 1e-6  # unit fields are in single precision


@pytest.fixture(scope="module")
def fields():
    return usual()


@pytest.fixture(scope="module")
def written(fields):
    return encode(fields, CYCLES)


def order_of(fields, part):
    """Which node of the page each node of the part has become."""
    apart = np.linalg.norm(fields.nodes[:, None] - part.nodes[None], axis=2)
    return apart.argmin(axis=1)


def largest_error(fields, head, text, cycles):
    """Of the von Mises stress over all nodes and positions, over each cycle's peak."""
    part = decode(head, text)
    order = order_of(fields, part)
    worst = 0.0
    for number, name in enumerate(cycles):
        if name not in fields.coefficients:
            continue
        size = max(fields.peaks[name].max(), 1e-4 * max(p.max() for p in fields.peaks.values()))
        for position in range(fields.coefficients[name].shape[1]):
            exact = von_mises(fields.at(name, position))
            off = np.abs(von_mises(part.stress(number, position))[order] - exact)
            worst = max(worst, float(off.max()) / size)
    return worst


def test_stress_is_within_the_measured_error_at_every_node_and_position(fields, written):
    share = written.head["accuracy"]["share"]
    assert share <= TOLERANCE
    found = largest_error(fields, written.head, written.text, CYCLES)
    assert found <= share + SINGLE
    assert found > share / 2  # the bound is no more careful than that, and steps are used


def test_displacement_is_within_its_measured_error(fields, written):
    part = decode(written.head, written.text)
    order = order_of(fields, part)
    for number, name in enumerate(CYCLES):
        count = fields.coefficients[name].shape[1]
        exact = [fields.moved(name, k) for k in range(count)]
        size = max(np.linalg.norm(one, axis=1).max() for one in exact)
        off = [part.displacement(number, k)[order] - one for k, one in enumerate(exact)]
        share = written.head["accuracy"]["displacement"]
        assert share <= TOLERANCE
        assert np.linalg.norm(off, axis=2).max() <= 1.05 * share * size  # size: of some positions


def test_fields_over_the_duty_and_the_geometry_come_back(fields, written):
    part = decode(written.head, written.text)
    order = order_of(fields, part)
    for name, values in fields.fatigue.items():
        assert_allclose(part.fatigue[name][order], values, rtol=0, atol=values.max() / 8000)
        assert written.head["scale"][name]["to"] == pytest.approx(values.max())
    assert np.abs(part.nodes[order] - fields.nodes).max() <= 0.51 * 260 / 65535
    first = {tuple(np.roll(t, -np.argmin(t))) for t in order[fields.triangles]}
    assert first == {tuple(t) for t in part.triangles}


def test_between_positions_the_loads_are_interpolated_and_not_the_stresses(fields, written):
    part = decode(written.head, written.text)
    half = part.stress(0, 10.5)
    assert_allclose(half, (part.stress(0, 10) + part.stress(0, 11)) / 2, rtol=0, atol=1e-9)
    assert not np.allclose(
        von_mises(half), (von_mises(part.stress(0, 10)) + von_mises(part.stress(0, 11))) / 2
    )


def test_the_reported_peak_has_its_node_and_its_position(fields, written):
    peak = written.head["peak"]
    part = decode(written.head, written.text)
    assert order_of(fields, part)[fields.peak.node] == peak["node"]
    assert peak["position"] in written.head["cycles"][peak["cycle"]]["positions"]
    shown = von_mises(part.stress(peak["cycle"], peak["position"]))
    assert shown.max() == pytest.approx(peak["value"], rel=TOLERANCE)
    assert shown[peak["node"]] == pytest.approx(peak["value"], rel=TOLERANCE)


def test_the_same_fields_give_the_same_text(fields, written):
    again = encode(usual(), CYCLES)
    assert again.text == written.text
    assert json.dumps(again.head) == json.dumps(written.head)


def hot_node(nodes):
    stress = smooth(nodes, 3) * 1e-3
    stress[1, 17] = [900.0, -300.0, 20.0, 80.0, 0.0, 5.0]
    return stress, {"work": turning(3, 30)}


def random_numbers(nodes):
    return np.random.default_rng(3).normal(size=(5, len(nodes), 6)), {"work": turning(5, 30)}


def huge_coefficient(nodes):
    coefficients = turning(4, 30)
    coefficients[2] *= 1e9
    return smooth(nodes, 4), {"work": coefficients}


def huge_and_cancelling(nodes):
    stress = smooth(nodes, 2)
    stress = np.concatenate([stress, stress[:1] + 1e-3 * stress[1:]])
    coefficients = turning(1, 30)
    return stress, {
        "work": np.concatenate([1e3 * coefficients, 0 * coefficients, -1e3 * coefficients])
    }


def small_cycle(nodes):
    return smooth(nodes, 4), {"work": turning(4, 30), "idle": 2e-4 * turning(4, 20, seed=5)}


def units_apart(nodes):
    sizes = np.array([1e-7, 1.0, 1e5])[:, None]
    return smooth(nodes, 3) / sizes[:, None], {"work": sizes * turning(3, 30)}


def pressure(nodes):
    """Almost the same stress in all directions: the von Mises stress is a small difference."""
    stress = 1e-2 * smooth(nodes, 2)
    stress[:, :, :3] += 100 * smooth(nodes, 2, seed=9)[:, :, :1]
    return stress, {"work": turning(2, 30)}


def one_position(nodes):
    return smooth(nodes, 3), {"work": turning(3, 1)}


def jumps(nodes):
    random = np.random.default_rng(11)
    return smooth(nodes, 6), {"work": random.normal(size=(6, 200)) * random.integers(2, size=200)}


@pytest.mark.parametrize(
    "case",
    [hot_node, random_numbers, huge_coefficient, huge_and_cancelling, small_cycle, units_apart,
     pressure, one_position, jumps],
)  # fmt: skip
def test_the_error_is_measured_for_fields_of_any_kind(case):
    surface = torus(24, 12)
    stress, coefficients = case(surface[0])
    fields = live(stress, coefficients, surface)
    done = encode(fields, CYCLES)
    share = done.head["accuracy"]["share"]
    assert share <= TOLERANCE
    # what single precision of unit fields costs grows with how much they cancel
    sums = sum(
        np.abs(fields.stress[j]).max() * np.abs(c[j]).max()
        for c in coefficients.values()
        for j in range(len(stress))
    )
    left = 3e-7 * sums / max(p.max() for p in fields.peaks.values())
    assert largest_error(fields, done.head, done.text, CYCLES) <= share + left
    assert not any("cancel" in note for note in done.head["notes"])


def largest_principal_error(fields, head, text):
    """Of any principal stress over all nodes and kept positions of the first cycle, MPa."""
    part = decode(head, text)
    order = order_of(fields, part)
    worst = 0.0
    for position in head["cycles"][0]["positions"]:
        pair = fields.at("work", position), part.stress(0, position)[order]
        values = [np.linalg.eigvalsh(one[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3))
                  for one in pair]  # fmt: skip
        worst = max(worst, float(np.abs(values[0] - values[1]).max()))
    return worst


@pytest.mark.parametrize("case", [random_numbers, pressure])
def test_what_weights_in_whole_steps_cost_is_in_the_error_tolds(case, monkeypatch):
    """Of 8 bits they cost more than the fields; of a pressure most of it is mean stress."""
    monkeypatch.setattr("reports.live.fitting._WEIGHT_BITS", 8)
    surface = torus(24, 12)
    stress, coefficients = case(surface[0])
    fields = live(stress, coefficients, surface)
    done = encode(fields, CYCLES)
    accuracy = done.head["accuracy"]
    assert accuracy["share"] > 1.5 * TOLERANCE
    assert largest_error(fields, done.head, done.text, CYCLES) <= accuracy["share"]
    off = largest_principal_error(fields, done.head, done.text)
    assert off <= accuracy["principal"][0]
    if case is pressure:
        assert off > 5 * accuracy["mises"][0]


@pytest.mark.parametrize("large", [1e4, 1e5, 1e7])
def test_what_single_precision_costs_is_in_the_error_told(large):
    """Two unit loads of opposite sign, so large that their sum is what single precision loses."""
    surface = torus(24, 12)
    first, second = smooth(surface[0], 1)[0], smooth(surface[0], 1, seed=3)[0]
    turn = turning(1, 30)
    coefficients = {"work": np.concatenate([-large * turn, large * turn])}
    fields = live(np.stack([first, first + second / large]), coefficients, surface)
    done = encode(fields, CYCLES)
    part = decode(done.head, done.text)
    order = order_of(fields, part)
    off = [
        np.abs(von_mises(part.stress(0, k))[order] - von_mises(second * turn[0, k])).max()
        for k in range(30)
    ]
    share = done.head["accuracy"]["share"]
    assert max(off) <= share * fields.peaks["work"].max()
    told = [note for note in done.head["notes"] if "nearly cancel each other" in note]
    assert len(told) == (share > TOLERANCE)
    if large >= 1e5:
        assert share > TOLERANCE


def test_peaks_that_the_fields_do_not_have_are_refused(fields):
    wrong = fields.peaks["idle"].copy()
    wrong[wrong.argmax()] *= 1.001
    with pytest.raises(ValueError, match=r"peak at position \d+ of 'idle' is .* but the fields"):
        encode(replace(fields, peaks={**fields.peaks, "idle": wrong}), CYCLES)


def test_of_a_cycle_below_the_floor_the_page_says_what_its_error_is_of(fields):
    assert "largest cycle's" not in encode(fields, CYCLES).head["accuracy"]["words"]
    surface = torus(24, 12)
    coefficients = {"work": turning(4, 30), "idle": 1e-7 * turning(4, 20, seed=5)}
    tiny = live(smooth(surface[0], 4), coefficients, surface)
    accuracy = encode(tiny, CYCLES).head["accuracy"]
    assert "(or of 0.01 % of the largest cycle's, if that is more)" in accuracy["words"]
    large, small = accuracy["mises"]
    assert large == pytest.approx(accuracy["share"] * tiny.peaks["work"].max())
    assert small == pytest.approx(1e-4 * large)


def test_no_value_at_any_position_is_beyond_the_ends_of_the_scale():
    """A short hydrostatic push between the sampled positions, which no peak tells of."""
    surface = torus(16, 10)
    plain = np.zeros((2, len(surface[0]), 6))
    plain[0, :, 0] = 1.0
    plain[1, :, :3] = 1.0
    at = np.arange(361)
    push = 400 * np.exp(-(((at - 53) / 3.0) ** 2)) - 300 * np.exp(-(((at - 157) / 3.0) ** 2))
    moved = np.zeros((2, len(surface[0]), 3))
    moved[0, :, 1], moved[1, :, 2] = 1e-4, 1e-3 * np.cos(np.arange(len(surface[0])))
    fields = live(
        plain, {"work": np.stack([100 * np.cos(at / 60) ** 2 + 1, push])}, surface,
        displacement=moved,
    )  # fmt: skip
    scale = encode(fields, CYCLES).head["scale"]
    values = [principal_range(fields.at("work", k)) for k in at]
    most = max(max(-low, high) for low, high in values)
    assert scale["principal"]["from"] == -scale["principal"]["to"]
    assert scale["principal"]["to"] == pytest.approx(most, rel=1e-6)
    lengths = [np.linalg.norm(fields.moved("work", k), axis=1).max() for k in at]
    assert scale["displacement"]["to"] == pytest.approx(max(lengths), rel=1e-6)


def test_a_tolerance_that_is_asked_for_is_used(fields):
    loose = encode(fields, CYCLES, 5e-3)
    assert TOLERANCE < loose.head["accuracy"]["share"] <= 5e-3
    assert len(loose.text) < 0.8 * len(encode(fields, CYCLES).text)


def test_of_a_long_cycle_some_positions_are_carried_with_its_peak_and_the_page_says_so():
    surface = torus(16, 8)
    random = np.random.default_rng(4)
    rough = turning(4, 3650) + 0.2 * random.normal(size=(4, 3650))
    fields = live(smooth(surface[0], 4), {"work": rough}, surface)
    done = encode(fields, CYCLES)
    told = done.head["cycles"][0]
    assert len(told["positions"]) == 3601
    assert int(fields.peaks["work"].argmax()) in told["positions"]
    assert [told["positions"][0], told["positions"][-1]] == [0, 3649]
    assert "3601 of 3650 of work" in " ".join(done.head["notes"])
    accuracy = done.head["accuracy"]
    between = accuracy["between"]
    found = largest_error(fields, done.head, done.text, CYCLES)
    assert accuracy["share"] < found <= between
    assert "at any node and position that the page keeps, and by at most" in accuracy["words"]
    assert accuracy["mises"][0] == pytest.approx(between * fields.peaks["work"].max())
    assert done.head["cycles"][1] is None


def test_at_positions_left_out_no_principal_stress_is_off_by_more_than_is_told():
    """Of a pressure the straight lines miss much more than of its von Mises stress."""
    surface = torus(16, 8)
    stress = 0.02 * smooth(surface[0], 2)
    stress[:, :, :3] += smooth(surface[0], 2, seed=9)[:, :, :1]
    rough = turning(2, 3700) + 0.2 * np.random.default_rng(4).normal(size=(2, 3700))
    fields = live(stress, {"work": rough}, surface)
    done = encode(fields, CYCLES)
    part = decode(done.head, done.text)
    order = order_of(fields, part)
    left = sorted({*range(3700)} - {*done.head["cycles"][0]["positions"]})
    assert len(left) == 99
    worst = 0.0
    for position in left:
        pair = fields.at("work", position), part.stress(0, position)[order]
        values = [np.linalg.eigvalsh(one[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3))
                  for one in pair]  # fmt: skip
        worst = max(worst, float(np.abs(values[0] - values[1]).max()))
    told = done.head["accuracy"]
    assert 5 * told["mises"][0] < worst <= told["principal"][0]


def test_the_reported_peak_is_carried_also_where_an_equal_one_is_the_largest():
    surface = torus(16, 8)
    rough = turning(3, 4200) + 0.2 * np.random.default_rng(4).normal(size=(3, 4200))
    fields = live(smooth(surface[0], 3), {"work": rough}, surface)
    kept = encode(fields, CYCLES).head["cycles"][0]["positions"]
    other = min({*range(4200)} - {*kept})
    peak = replace(peak_of(fields), position=other)
    assert other in encode(replace(fields, peak=peak), CYCLES).head["cycles"][0]["positions"]


def test_displacements_and_fields_over_the_duty_tell_what_they_may_be_off_by(fields, written):
    part = decode(written.head, written.text)
    order = order_of(fields, part)
    for number, name in enumerate(CYCLES):
        told = written.head["accuracy"]["moved"][number]
        for position in range(fields.coefficients[name].shape[1]):
            off = part.displacement(number, position)[order] - fields.moved(name, position)
            assert np.linalg.norm(off, axis=1).max() <= told


def test_of_a_cycle_of_some_thousand_positions_all_are_carried():
    surface = torus(16, 8)
    fields = live(smooth(surface[0], 4), {"work": turning(4, 1500)}, surface)
    done = encode(fields, CYCLES)
    assert done.head["cycles"][0]["positions"] == list(range(1500))
    assert "that the page keeps" not in done.head["accuracy"]["words"]
    found = largest_error(fields, done.head, done.text, CYCLES)
    assert found <= done.head["accuracy"]["share"]


def test_a_part_that_nothing_loads_says_so():
    surface = torus(16, 8)
    fields = live(smooth(surface[0], 3), {"work": np.zeros((3, 20))}, surface)
    head = encode(fields, CYCLES).head
    assert head["fields"] == 0
    assert head["missing"]["mises"].startswith("nothing loads this part")
    zero = live(np.zeros((2, len(surface[0]), 6)), {"work": turning(2, 20)}, surface)
    assert encode(zero, CYCLES).head["fields"] == 0


def test_a_buckling_mode_comes_back_within_half_a_step_also_of_a_surface_without_fields(fields):
    nodes, triangles = torus(16, 8)
    mode = np.cos(nodes / 40.0) * [0.1, -0.3, 1.0]
    mode /= np.linalg.norm(mode, axis=1).max()
    bare = replace(grey(nodes, triangles, "by formula"), mode=mode)
    for given in (bare, replace(fields, mode=np.resize(mode, fields.nodes.shape))):
        done = encode(given, CYCLES)
        part = decode(done.head, done.text)
        assert_allclose(part.mode[order_of(given, part)], given.mode, atol=0.5 / 127 + 1e-6)
    done = encode(fields, CYCLES)
    assert decode(done.head, done.text).mode is None


def test_a_surface_without_fields_has_its_reason():
    nodes, triangles = torus(16, 8)
    done = encode(grey(nodes, triangles, "decided by formula"), CYCLES)
    assert done.head["fields"] == 0
    assert done.head["notes"] == ["decided by formula"]
    assert set(done.head["missing"].values()) == {"decided by formula"}
    assert decode(done.head, done.text).nodes.shape == nodes.shape


def test_a_single_triangle_is_a_surface():
    fields = live(
        np.ones((1, 3, 6)) * np.arange(1, 7),
        {"work": np.ones((1, 1))},
        (np.eye(3), np.array([[0, 1, 2]])),
    )
    done = encode(fields, ["work"])
    assert_allclose(decode(done.head, done.text).stress(0, 0), fields.at("work", 0), atol=0.05)


@pytest.mark.parametrize(
    "what", ["stress", "displacement", "coefficients", "nodes", "utilisation", "mode"]
)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_no_number_is_refused(fields, what, bad):
    changes = {}
    fields = replace(fields, mode=fields.displacement[0])
    if what == "coefficients":
        spoilt = fields.coefficients["idle"].copy()
        spoilt[2, 5] = bad
        changes["coefficients"] = {**fields.coefficients, "idle": spoilt}
    elif what == "utilisation":
        spoilt = fields.fatigue[what].copy()
        spoilt[5] = bad
        changes["fatigue"] = {**fields.fatigue, what: spoilt}
    else:
        spoilt = getattr(fields, what).copy()
        spoilt.flat[5] = bad
        changes[what] = spoilt
    with pytest.raises(ValueError, match=rf"live fields: {what}.* holds {bad}"):
        replace(fields, **changes)


def test_arrays_that_do_not_fit_are_refused(fields):
    with pytest.raises(ValueError, match=r"stress must have shape \(8, 720, 6\)"):
        replace(fields, stress=fields.stress[:, :, :5])
    with pytest.raises(ValueError, match="triangles name nodes 0 to 720 of 720"):
        replace(fields, triangles=np.array([[0, 1, 720]]))
    with pytest.raises(ValueError, match="needs nodes"):
        LiveFields(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 0, 6)), None, {}, {})


@pytest.mark.parametrize("planes", [[3], [0, 2, 1], []])
def test_numbers_of_any_size_come_back_from_their_planes(planes):
    random = np.random.default_rng(1)
    arrays = [
        random.integers(-(256**p) // 2, 256**p // 2, 50) if p else np.zeros(50) for p in planes
    ]
    arrays = [a.astype(np.int64) for a in arrays]
    writer = Writer()
    writer.add("some", arrays)
    writer.add("other", [np.array([-(2**31), 2**31 - 1])])
    found = read_planes(writer.text(), writer.layout)
    assert len(found["some"]) == len(arrays)
    for one, other in zip(found["some"], arrays, strict=True):
        assert_array_equal(one, other)
    assert_array_equal(found["other"][0], [-(2**31), 2**31 - 1])
    with pytest.raises(ValueError, match="more than 32 bits"):
        writer.add("large", [np.array([2**31])])


def test_a_text_that_is_not_its_headers_is_refused(written):
    head = json.loads(json.dumps(written.head))
    head["coding"]["layout"][0]["length"] -= 1
    with pytest.raises(ValueError, match="its header tells of"):
        decode(head, written.text)
