"""Bores whose arc of contact is not stated: how far a rung's stress there may be exceeded.

Contacts exceed the assumed arcs by a share that solids have in their model band. The bands of the
rungs were compared with solids on the arcs alone, so they do not have it.
"""

import numpy as np

from checks.design.data import Part
from checks.handbook.pin_loaded_hole import BEYOND_ARCS
from checks.part.part_loads import PartLoads
from checks.strength.fatigue_assessment import FatigueUse
from checks.stress.part_model import RungLevel
from fem.stress_history import StressHistory

WORDS = f"model band: {100 * BEYOND_ARCS:g} % more in bores, whose arc is not stated"
_PRESSURE = " cos 0"  # the unit load that only an interface with a bearing pressure has
_ACROSS = ("M_x", "M_y", "torque")  # in names of unit loads: couples out of the linkage's plane
_NEAR = 0.8  # of the largest fatigue use in bores: points that are asked again


def raised_in_bores(
    part: Part, loads: PartLoads, level: RungLevel, use: FatigueUse | None = None
) -> float:
    """Return the largest stress in such bores with more of the forces in the plane, MPa.

    0 without such a bore. As in a solid (checks/stress/error_bars.py), the stress of couples out of
    the plane stays.

    use  how fatigue is judged; None for von Mises stress
    """
    model, history = level.model, level.history
    if part.arc_stated or part.body is None or loads.is_nothing:
        return 0.0
    units = [name for name, _ in model.units]
    bores = {name.removesuffix(_PRESSURE) for name in units if name.endswith(_PRESSURE)}
    points = np.flatnonzero([place in bores for place in model.places])
    if not len(points):
        return 0.0
    across = np.array([any(word in name for word in _ACROSS) for name in units])
    raised = np.where(across, 1.0, 1.0 + BEYOND_ARCS)[:, None] * history.coefficients
    if use is None:
        own = history.nodes[points], history.points[points], history.basis[points]
        return float(StressHistory(*own, raised).peaks_by_position()[0].max())
    assert level.duty is not None
    used = level.duty.bound[points]
    return use.over(level, points[used >= _NEAR * used.max()], raised, loads.cycles)
