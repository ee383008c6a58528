"""A part by the rungs that decided it before, so that a check can be repeated."""

from collections.abc import Callable, Mapping

from checks.design.errors import DesignError, NumericsError
from checks.ladder.climb import ANSWERS, BUILDERS, FKM_NEEDS_SOLID, GAVE_UP, SOLID, Climb, complete

_ANEW = "--update-baselines --baseline-fidelity auto chooses the rungs anew"


def climb_pinned(
    climb: Climb, rungs: Mapping[str, str], say: Callable[[str], None]
) -> frozenset[str]:
    """Take each kind of check by its rung; returns the kinds that are the solid's.

    rungs  kind of check -> rung; kinds that are asked for without a rung of theirs go to the solid
           if another does, else to the cheapest rung that answers them

    Raises DesignError where a rung has no model of the part any more, and NumericsError where one
    gave up: no other rung may stand for it unsaid.
    """
    for rung in BUILDERS:
        kinds = [kind for kind in climb.asked if rungs.get(kind) == rung]
        if not kinds:
            continue
        if climb.part.fkm is not None:
            _refuse(climb, rung, kinds, FKM_NEEDS_SOLID)
        say(f"{climb.part.name}: {rung}")
        if others := [kind for kind in kinds if kind not in ANSWERS[rung]]:
            _refuse(climb, rung, others, f"it answers {' and '.join(ANSWERS[rung])} only")
        if not climb.take(rung, kinds):
            _refuse(climb, rung, kinds, climb.tried[-1].why)
    solids = frozenset(kind for kind in climb.asked if rungs.get(kind) == SOLID)
    free = frozenset(climb.asked) - rungs.keys()
    if solids or climb.part.fkm is not None:
        return solids | free
    complete(climb)
    return frozenset() if climb.levels else free


def _refuse(climb: Climb, rung: str, kinds: list[str], why: str) -> None:
    where, file = f"parts.{climb.part.name}", climb.loaded.design.file
    said = f"{', '.join(kinds)} {'is' if len(kinds) == 1 else 'are'} pinned to the rung {rung}"
    if why.startswith(GAVE_UP):
        raise NumericsError(f"{said}, which {why}", f"{file}: {where}", _ANEW)
    raise DesignError(file, where, f"{said}, but {why}; {_ANEW}")
