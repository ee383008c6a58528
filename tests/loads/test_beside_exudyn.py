"""A motor turns a slider-crank as an independent multibody program has it, where that is there."""

import pytest


def test_a_motor_turns_a_slider_crank_as_exudyn_integrates_it():
    """Speed, time and forces of the pins over the turn that repeats, to 1e-5 of their largest."""
    exudyn = pytest.importorskip(
        "exudyn", reason="exudyn is not installed (pip install exudyn==1.13.6): not compared"
    )
    from bench.motor_beside_exudyn import ASKED, differences

    _, found = differences(exudyn)
    assert len(found) == 5
    for words, apart, half_step in found:
        assert apart <= ASKED, words
        assert half_step <= ASKED, words
