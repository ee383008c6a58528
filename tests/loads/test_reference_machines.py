"""Four machines at states with independent solutions: toggle, slider-crank, hammer, quick return.

Free-body Newton-Euler and Lagrange multipliers, printed with eight digits (SI units); friction of
pins, guides and slots, weights, inertia and forces on the workpiece among them.
"""

import json
from math import radians
from pathlib import Path

import pytest

from .readings import READERS

REFERENCE = json.loads((Path(__file__).parent / "reference_machines.json").read_text())
STATES = [
    pytest.param(machine, case["parameters"], state, id=f"{machine}-{i}-{j}")
    for machine in READERS
    for i, case in enumerate(REFERENCE[machine])
    for j, state in enumerate(case["states"])
]


@pytest.mark.parametrize(("machine", "parameters", "state"), STATES)
def test_a_machine_agrees_with_the_independent_solution(machine, parameters, state, meets):
    position = state["x_m"] if machine == "toggle" else radians(state["crank_angle_deg"])
    values = READERS[machine](parameters, position)
    assert state["checks"]
    for check in state["checks"]:
        meets(machine, check, values[check["quantity"]][0])


def test_every_independent_state_is_there():
    """706 numbers at 52 states of 16 cases; a case that goes missing is not noticed otherwise."""
    counts = {
        machine: sum(
            len(state["checks"]) for case in REFERENCE[machine] for state in case["states"]
        )
        for machine in READERS
    }
    assert counts == {"toggle": 130, "slider_crank": 182, "hammer": 196, "quick_return": 198}
