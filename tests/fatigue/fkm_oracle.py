"""pyLife's FKM functions (Bosch, Apache-2.0) for one material group, as an oracle."""

import numpy as np
import pylife._fkm_linear_functions as functions
from pylife.strength.fkm_linear.constants import consts_fkm, fw_t

GROUPS = {
    "steel": "Steel",
    "forged_steel": "Forg_Steel",
    "case_hardened_steel": "CaseHard_Steel",
    "stainless_steel": "Stainless_Steel",
    "cast_steel": "GS",
    "nodular_iron": "GJS",
    "malleable_iron": "GJM",
    "grey_iron": "GJL",
    "wrought_aluminium": "Al_wrought",
    "cast_aluminium": "Al_cast",
}


def numbers(group, stress):
    """Its constants, and the shear ratio or 1."""
    return consts_fkm[GROUPS[group]], float(fw_t[GROUPS[group]][stress])


def _many(value, count):
    return np.full(count, float(value))


def pylife_stieler(group, stress, gradients, ultimate):
    """Support numbers (n,)."""
    own, ratio = numbers(group, stress)
    count = len(gradients)
    return functions.stieler_support(
        _many(ratio, count), _many(own.aG, count), _many(own.bG, count), gradients,
        _many(ultimate, count),
    )  # fmt: skip


def pylife_roughness(group, stress, roughness, ultimate):
    """Roughness factor."""
    own, ratio = numbers(group, stress)
    finish = np.array(["None"], dtype=object)
    rest = (_many(value, 1) for value in (ratio, own.aR_s, own.RmNmin))
    return float(functions.rough_factor(_many(ultimate, 1), _many(roughness, 1), *rest, finish)[0])
