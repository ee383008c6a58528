"""Mutated designs end as the contract says: no traceback, no warning, in time and memory."""

import pytest

from bench.fuzz import fuzz, mutant


def test_a_mutant_is_the_same_whenever_it_is_asked_for():
    assert mutant(1, 7) == mutant(1, 7)
    assert len({mutant(1, number)[1] for number in range(50)}) > 45


@pytest.mark.slow
def test_two_hundred_mutants_end_with_an_exit_code_of_the_contract():
    """By seed 1, as the first of `make fuzz`."""
    found = fuzz(range(200), seed=1, workers=2)
    assert sum(found.counts.values()) == 200
    assert found.findings == []
