"""What a design's own material must state."""

import pytest

from ballesta.materials import Material
from geometry.parameters import ParameterError

ALLOY = {
    "name": "alloy",
    "youngs_modulus": 70e3,
    "poisson_ratio": 0.33,
    "density": 2.7e-9,
    "yield_stress": 240.0,
    "ultimate_stress": 290.0,
    "ductile": True,
    "source": "a test",
}


def test_what_is_not_steel_must_state_its_endurance_ratio():
    with pytest.raises(ParameterError, match="70 GPa is not steel's"):
        Material(**ALLOY)
    assert Material(**ALLOY, endurance_ratio=0.4).endurance_ratio == 0.4
    assert Material(**{**ALLOY, "youngs_modulus": 210e3}).endurance_ratio is None


@pytest.mark.parametrize("ratio", [0.0, 1.0, -0.4, float("nan")])
def test_an_endurance_ratio_is_a_share_of_the_strength(ratio):
    with pytest.raises(ParameterError, match="between 0 and 1"):
        Material(**ALLOY, endurance_ratio=ratio)
