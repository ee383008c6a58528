"""Numbers that leave a baseline, their words, and the cause that is named."""

import copy

import pytest

from ballesta.regression import file
from ballesta.regression.compare import compare
from ballesta.regression.file import MASS, band_of

from .records import SHARE, STAGES, STATIC, baseline, check, record


@pytest.fixture
def noise(monkeypatch):
    """Set the measured re-mesh noise: (rung, kind, accuracy, worst scatter)."""

    def put(*entries):
        keys = ("rung", "kind", "accuracy", "worst")
        found = [dict(zip(keys, entry, strict=True)) for entry in entries]
        monkeypatch.setattr(file, "_noise", lambda: found)

    return put


def quantities(found):
    return [row.quantity for row in found.left]


def test_a_record_is_inside_its_own_baseline():
    found = compare(baseline(), record())
    assert found.holds
    assert found.causes == []


@pytest.mark.parametrize("change", [1 - 2e-6, 1 + 2e-6, 0.95, 1.05])
def test_a_formula_that_moves_by_more_than_round_off_is_told_with_its_safety(change):
    found = compare(baseline(), record(200.0 * change))
    assert set(quantities(found)) == {f"bar: {STATIC} [MPa]", f"bar: {STATIC}, safety"}


@pytest.mark.parametrize("change", [1 - 5e-7, 1 + 5e-7])
def test_round_off_of_another_processor_raises_no_alarm(change):
    assert compare(baseline(), record(200.0 * change, mass=4.0 * change)).holds


def test_a_mass_and_a_buckling_factor_are_watched():
    found = compare(baseline(), record(mass=4.01, share=0.021))
    assert quantities(found) == [
        f"bar: {SHARE}",
        f"bar: {SHARE}, buckling factor",
        f"bar: {MASS}",
    ]


def test_stress_of_a_part_without_load_may_differ_by_round_off():
    before, now = record(1e-13), record(3e-12)
    assert compare(baseline(static=1e-13), now).holds
    before["parts"]["bar"]["checks"][STATIC] = check(0.0, 355.0)
    assert compare(baseline(parts=before["parts"]), now).holds


def test_a_limit_that_changes_alone_is_told_as_a_safety():
    now = record()
    now["parts"]["bar"]["checks"][STATIC] = check(200.0, 275.0)
    assert quantities(compare(baseline(), now)) == [f"bar: {STATIC}, safety"]


def test_verdicts_parts_checks_and_rungs_that_change_come_first():
    now = record(300.0, status="FAIL")
    now["parts"]["rod"] = now["parts"].pop("pin")
    bar = now["parts"]["bar"]["checks"]
    bar["fatigue: Goodman"] = check(1.0, 2.0)
    bar[STATIC]["status"] = "FAIL"
    bar[SHARE]["rung"] = "solid"
    found = compare(baseline(), now)
    assert quantities(found)[:6] == [
        "the design, verdict",
        f"bar: {STATIC}, verdict",
        f"bar: {SHARE}, rung and unit",
        "bar: fatigue: Goodman",
        "pin",
        "rod",
    ]
    assert found.left[4].cells == ("pin", "present", "absent", "", "")


def test_the_table_shows_quantity_baseline_now_change_band_and_cause():
    now = record(210.0, stages=STAGES | {"bar: geometry": "f" * 12, "code": "e" * 12})
    lines = compare(baseline(), now).text().splitlines()
    assert lines[0].split() == ["quantity", "baseline", "now", "change", "band"]
    assert lines[1].split()[-7:] == ["[MPa]", "200", "210", "+5", "%", "±0.0001", "%"]
    assert lines[-1] == "likely cause: the geometry of bar; the code of ballesta"


def test_a_small_change_is_shown_with_digits_enough_to_see_it():
    (value, _) = compare(baseline(), record(200.001)).left
    assert value.cells[1:3] == ("200", "200.001")


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"loads": "f"}, ["the loads (linkage, cycles, friction or stated masses)"]),
        ({"bar: mesh": "f", "pin: mesh": "f"}, ["the mesh of all parts"]),
        ({"pin: mesh": "f"}, ["the mesh of pin"]),
        ({"libraries": "f"}, ["the libraries, Python or the processor"]),
        ({}, []),
    ],
)
def test_the_likely_cause_is_what_the_numbers_were_made_from(changed, told):
    assert compare(baseline(), record(stages=STAGES | changed)).causes == told


def test_without_a_changed_input_the_cause_is_said_to_be_unknown():
    assert "likely cause: unknown: design, code" in compare(baseline(), record(210.0)).text()


def test_a_solid_has_the_band_of_measured_noise(noise):
    noise(("solid", "static", 0.05, 0.01))
    before = baseline(rung="solid")
    assert compare(before, record(202.9, rung="solid")).holds
    found = compare(before, record(203.1, rung="solid"))
    assert found.left[0].band == "±1.5 %"


def test_noise_that_would_hide_five_per_cent_is_refused_and_a_finer_accuracy_named(noise):
    noise(("solid", "static", 0.05, 0.03), ("solid", "static", 0.03, 0.01))
    found = compare(baseline(rung="solid"), record(rung="solid"))
    ((quantity, why),) = found.bandless
    assert quantity == f"bar: {STATIC}"
    assert "moves it by more than 4 % at this accuracy" in why
    assert 'set accuracy = "3 %" or finer' in why
    assert not found.holds
    assert compare(baseline(rung="solid"), record(rung="solid", accuracy=0.03)).holds


def test_noise_that_was_not_measured_is_refused_until_a_band_is_stated(noise):
    noise()
    found = compare(baseline(rung="solid"), record(rung="solid"))
    assert "is not measured at 5 %" in found.bandless[0][1]
    assert compare(baseline({"bar: static": 0.02}, rung="solid"), record(203.9, rung="solid")).holds


def test_a_solid_that_missed_the_accuracy_is_refused(noise):
    noise(("solid", "static", 0.05, 0.01))
    now = record(rung="solid")
    now["parts"]["bar"]["checks"][STATIC]["numerical"] = 0.12
    ((_, why),) = compare(baseline(rung="solid"), now).bandless
    assert "numerical error is 12 %, where 5 % is asked for" in why
    assert "mesh.most_unknowns" in why


@pytest.mark.parametrize("factor", [0.95, 1.05])
def test_every_measured_band_sees_a_peak_stress_that_changes_by_five_per_cent(factor):
    """No stated band: whatever was measured, a change of 5 % is seen or the band refused."""
    for rung in ("formula", "solid"):
        for accuracy in (0.01, 0.03, 0.05, 0.1):
            now = record(200.0 * factor, rung=rung, accuracy=accuracy)
            found = compare(baseline(rung=rung), now)
            assert f"bar: {STATIC} [MPa]" in quantities(found) or found.bandless, (rung, accuracy)


def near_its_limit(status, *, value=234.0, above=0.0, rung="solid"):
    """A record whose bar is at 0.989 of 355 MPa over 1.5, with bars as its verdict has them."""
    now = record(rung=rung, status=status)
    bars = {"numerical": 0.02 if status == "UNDECIDED" else 0.0, "above": above}
    now["parts"]["bar"]["checks"][STATIC] = check(value, 355.0, status, rung) | bars
    return now


def test_a_verdict_that_another_mesh_turns_raises_no_alarm(noise):
    """Within its numerical bars the check passes or stays open; no number has left its band."""
    noise(("solid", "static", 0.05, 0.01))
    for before, after in (("pass", "UNDECIDED"), ("UNDECIDED", "pass")):
        old, new = near_its_limit(before), near_its_limit(after, value=235.0)
        found = compare(baseline(parts=old["parts"], status=before), new)
        assert found.holds, found.text()


@pytest.mark.parametrize(
    ("status", "above", "rung"),
    [
        ("UNDECIDED", 20.0, "solid"),  # a wider model band
        ("FAIL", 20.0, "solid"),
        ("UNDECIDED", 0.0, "formula"),  # has no mesh
    ],
)
def test_a_verdict_that_no_other_mesh_explains_is_told_with_the_designs(noise, status, above, rung):
    noise(("solid", "static", 0.05, 0.01))
    old, new = near_its_limit("pass", rung=rung), near_its_limit(status, above=above, rung=rung)
    found = compare(baseline(parts=old["parts"], status="pass"), new)
    assert sorted(quantities(found)) == [f"bar: {STATIC}, verdict", "the design, verdict"]


def test_a_verdict_that_its_own_numbers_do_not_give_is_told(noise):
    """At 235 of 236.7 MPa without a bar the check passes, whatever the record says."""
    noise(("solid", "static", 0.05, 0.01))
    old, new = near_its_limit("pass"), near_its_limit("FAIL", value=235.0)
    found = compare(baseline(parts=old["parts"], status="pass"), new)
    assert sorted(quantities(found)) == [f"bar: {STATIC}, verdict", "the design, verdict"]


def test_a_band_at_a_coarser_accuracy_holds_what_finer_meshes_scatter(noise):
    noise(("solid", "static", 0.03, 0.02), ("solid", "static", 0.05, 0.01))
    meshed = check(200.0, 355.0, "pass", "solid") | {"numerical": 0.01}
    for accuracy in (0.03, 0.04, 0.05):
        band = band_of("bar", STATIC, meshed, accuracy, {})
        assert band.width == pytest.approx(0.03)
    assert band_of("bar", STATIC, meshed, 0.06, {}).width is None


def test_comparing_leaves_both_records_alone():
    before, now = baseline(), record(210.0)
    copies = copy.deepcopy((before.record, now))
    compare(before, now)
    assert (before.record, now) == copies


def test_an_edit_that_turns_a_verdict_is_told_however_near_the_limit_is(noise):
    noise(("solid", "static", 0.05, 0.01))
    old, new = near_its_limit("pass"), near_its_limit("UNDECIDED", value=235.0)
    new["stages"] = new["stages"] | {"bar: judgement": "edited"}
    found = compare(baseline(parts=old["parts"], status="pass"), new)
    assert f"bar: {STATIC}, verdict" in quantities(found)
