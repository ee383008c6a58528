"""Mutated designs end as the contract says: no traceback, no warning, in time and memory."""

import json
from collections import Counter

import pytest

import bench.fuzz
from bench.fuzz import Found, fuzz, mutant, recorded, replayed


def test_a_mutant_is_the_same_whenever_it_is_asked_for():
    assert mutant(1, 7) == mutant(1, 7)
    assert len({mutant(1, number)[1] for number in range(50)}) > 45


@pytest.mark.slow
def test_two_hundred_mutants_end_with_an_exit_code_of_the_contract():
    """By seed 1, as the first of `make fuzz`."""
    found = fuzz(range(200), seed=1, workers=2)
    assert sum(found.counts.values()) == 200
    assert found.findings == []


def test_a_run_that_was_stopped_goes_on_where_its_record_stops(monkeypatch, tmp_path):
    """Of the same seed and code; else it begins anew. Each chunk is recorded when it is done."""
    ran, out = [], tmp_path / "fuzz.json"

    def chunk(numbers, seed, workers):
        if len(ran) == 3:
            raise KeyboardInterrupt
        ran.append((seed, numbers[0], len(numbers)))
        return Found(Counter({"exit code 2": len(numbers)}), {}, [{"mutant": numbers[0]}])

    monkeypatch.setattr(bench.fuzz, "fuzz", chunk)
    with pytest.raises(KeyboardInterrupt):
        recorded(out, 5, 1000, 1, 3600.0)
    assert json.loads(out.read_text())["ran"] == 600
    ran.clear()
    record = recorded(out, 5, 1000, 1, 3600.0)
    assert ran == [(5, 600, 200), (5, 800, 200)]
    assert (record["ran"], record["ended"]) == (1000, {"exit code 2": 1000})
    assert [one["mutant"] for one in record["findings"]] == [0, 200, 400, 600, 800]
    ran.clear()
    assert recorded(out, 6, 300, 1, 3600.0)["ran"] == 300
    assert ran == [(6, 0, 200), (6, 200, 100)]
    monkeypatch.setattr(bench.fuzz, "code_digest", lambda: "another")
    ran.clear()
    assert recorded(out, 6, 100, 1, 3600.0)["ran"] == 100
    assert ran == [(6, 0, 100)]


def test_a_finding_that_ends_well_now_is_recorded_as_mended(monkeypatch):
    """Of two findings the second is still one; one that is another mutant now is not judged."""
    changed = [bench.fuzz._changed(*mutant(3, number)) for number in (101, 441)]
    old = [
        {"mutant": number, "ended": "crashed", "changed": lines}
        for number, lines in zip((101, 441), changed, strict=True)
    ]
    still = {"mutant": 441, "ended": "out of time"}
    ended = {101: "exit code 2", 441: "out of time"}
    found = Found(ended=ended, findings=[still])
    monkeypatch.setattr(bench.fuzz, "fuzz", lambda numbers, seed, workers: found)
    record = replayed({"seed": 3, "ran": 7309, "findings": old}, 1)
    assert record["findings"] == [still]
    assert record["mended"] == [{**old[0], "ends now": "exit code 2"}]
    assert record["ran"] == 7309
    with pytest.raises(ValueError, match="mutant 101 of seed 3 is another one now"):
        replayed({"seed": 3, "findings": [{**old[0], "changed": ["width = 1"]}]}, 1)


@pytest.mark.parametrize(("limit", "told"), [(1e-9, "out of time"), (120.0, "exit code 2")])
def test_the_limit_of_a_mutant_is_processor_time(monkeypatch, limit, told):
    """Of a mutant that ends well, and within any time by the clock."""
    monkeypatch.setattr(bench.fuzz, "SECONDS", limit)
    monkeypatch.setattr(bench.fuzz, "_HANGS", 1e4 / limit)
    found = fuzz([1], seed=1, workers=1)
    assert found.counts == {told: 1}
    assert [one["ended"] for one in found.findings] == [told] * (told == "out of time")
