"""Points that cannot be the worst of two states are left out of Goodman's, no others."""

from unittest.mock import patch

import numpy as np
import pytest

import fatigue
from checks.strength.fatigue_assessment import FatigueUse

ULTIMATE = 500.0


def test_the_worst_of_two_states_is_that_of_all_points_from_few_of_them():
    """Random stresses, among them pure pressure and equal states, and two limits."""
    random = np.random.default_rng(3)
    judged = []

    def counted(stress):
        judged.append(len(stress))
        return real(stress)

    real = fatigue.principal_stresses
    use = FatigueUse(loads=None, limit=200.0, ultimate=ULTIMATE)
    for _ in range(40):
        stress = random.normal(size=(300, 6, 2)) * random.uniform(1, 100, size=(300, 1, 1))
        stress[:20, :3] += random.normal(size=(20, 1, 2)) * 200
        stress[20:40, :, 1] = stress[20:40, :, 0]
        limits = np.where(random.random(300) < 0.2, 90.0, 200.0)
        wanted = fatigue.goodman(stress, np.eye(2), limits, ULTIMATE).utilisation.max() * 200.0
        with patch.object(fatigue, "principal_stresses", counted):
            assert use._of_pair(stress, limits) == pytest.approx(wanted, rel=1e-14)
    assert np.mean(judged) < 60
