"""Mutated designs end as the contract says: no traceback, no warning, in time and memory."""

import pytest

import bench.fuzz
from bench.fuzz import Found, fuzz, mutant, replayed


def test_a_mutant_is_the_same_whenever_it_is_asked_for():
    assert mutant(1, 7) == mutant(1, 7)
    assert len({mutant(1, number)[1] for number in range(50)}) > 45


@pytest.mark.slow
def test_two_hundred_mutants_end_with_an_exit_code_of_the_contract():
    """By seed 1, as the first of `make fuzz`."""
    found = fuzz(range(200), seed=1, workers=2)
    assert sum(found.counts.values()) == 200
    assert found.findings == []


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
