"""Expected time and memory of solids, against processor times that were measured."""

import pytest

from checks.stress import kept_models

# unknowns of two meshes, and processor time of the part's solid with one thread, s
MEASURED = {
    "bar_upper of the press": (68_688, 48_201, 23.6),
    "pin_B of the press": (60_573, 120_783, 24.2),
    "crank of the slider-crank": (18_165, 39_207, 14.8),
    "rod of the slider-crank": (19_566, 22_650, 7.1),
}


@pytest.mark.parametrize("name", MEASURED)
def test_expected_times_are_right_within_a_factor_of_two(name, monkeypatch):
    monkeypatch.setattr(kept_models, "slowness", lambda: 1.0)
    first, second, took = MEASURED[name]
    assert 0.5 < kept_models.solid_seconds(first, second) / took < 2.0


def test_a_machine_that_takes_three_times_as_long_is_told_so(monkeypatch):
    monkeypatch.setattr(kept_models, "_trial", lambda: 3 * kept_models._TRIAL)
    kept_models.slowness.cache_clear()
    slow = kept_models.solid_seconds(50_000, 90_000)
    monkeypatch.setattr(kept_models, "slowness", lambda: 1.0)
    assert slow == pytest.approx(3 * kept_models.solid_seconds(50_000, 90_000))


@pytest.fixture(autouse=True)
def _measured_again():
    yield
    getattr(kept_models.slowness, "cache_clear", lambda: None)()
