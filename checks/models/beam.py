"""The rung `beam`: buckling of a part as a Timoshenko frame of its profile.

Its stress is the rung `formula`'s: over all kinds of checks that lies nearer to solids than a
frame's, which settled 19 of 512 recorded verdicts on stress, all as the solid does.
"""

from dataclasses import replace

from checks.design.data import Part
from checks.models import formula
from checks.models.beam_buckling import buckling_of
from checks.models.beam_solution import solve_frame
from checks.part.part_loads import PartLoads
from checks.stress.part_model import RungModel


def model_of(part: Part, loads: PartLoads) -> RungModel | None:
    """A part's stress by formula, its buckling by its frame; None where there is none of both."""
    solved = solve_frame(part)
    base = None if solved is None else formula.model_of(part, loads)
    if solved is None or base is None:
        return None
    coefficients = solved.coefficients(loads)
    return replace(
        base,
        rung="beam",
        residual=max(base.residual, solved.residual(loads, coefficients)),
        buckling=buckling_of(part, loads, solved, coefficients),
        unknowns=6 * len(solved.frame.nodes),
    )
