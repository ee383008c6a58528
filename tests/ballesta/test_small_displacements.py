"""Error of linear theory where a part gives way as much as the gate allows."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from checks.ladder.part_facts import SMALL_DISPLACEMENT


def elastica(load):
    """Deflection w/L and clamp moment M/(P L) of a cantilever under P L^2/(E I) at its end."""

    def bent(curvature):
        def along(_, state):
            angle, bending = state[:2]
            return [bending, -load * np.cos(angle), np.cos(angle), np.sin(angle)]

        start = [0.0, curvature, 0.0, 0.0]
        return solve_ivp(along, (0, 1), start, rtol=1e-10, atol=1e-13).y[:, -1]

    root = brentq(lambda curvature: bent(curvature)[1], 0.5 * load, 1.5 * load, xtol=1e-14)
    return bent(root)[3], root / load


@pytest.mark.parametrize("deflection", [0.0147, 0.03, 0.06])
def test_a_cantilevers_moment_falls_short_by_six_tenths_of_the_square_of_its_deflection(deflection):
    """u = int theta^2 / 2 ds with theta = (P L^2/E I)(s - s^2/2): u/L = (3 w/L)^2 / 15."""
    found, moment = elastica(3 * deflection)
    assert_allclose(found, deflection, rtol=5e-3)
    assert_allclose(1 - moment, 0.6 * deflection**2, rtol=0.01)


def test_at_the_gates_limit_a_beam_between_two_supports_is_bent_0_2_percent_less():
    """Its half is a cantilever with the same deflection on half the length."""
    _, moment = elastica(3 * 2 * SMALL_DISPLACEMENT)
    assert 1.5e-3 < 1 - moment < 2.5e-3
