"""Checks of parts that are formulas of their loads: every module here is one, or some of a kind.

A module has a function `checks` that takes a `LoadedPart` and yields its checks, each made by
`LoadedPart.worst` or `LoadedPart.derived`, so that their numbers are those of the formulas that are
shown. It may have a function `not_checked` that says what of a part it leaves out. A module is
found by being here, or by the entry point group `ballesta.checks` of another package
(docs/extending.md). Own modules come in the order of their names, then those of others.
"""

from collections.abc import Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from types import ModuleType

from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.result.verdict import Check
from checks.strength.sampling import sampled

GROUP = "ballesta.checks"


@cache
def registered() -> Sequence[ModuleType]:
    """Every module that has checks of a part; raises ImportError for one that is not there."""
    own = sorted(module.name for module in iter_modules(__path__))
    others = sorted(entry_points(group=GROUP))
    return (
        *(import_module(f"{__name__}.{name}") for name in own),
        *(point.load() for point in others),
    )


def formula_checks(loaded: LoadedPart) -> list[Check]:
    """All checks of a part by formula, with what the positions miss of them in their bars."""
    return [check for module in registered() for check in _sampled(module, loaded)]


def not_checked(loaded: LoadedPart) -> list[str]:
    """Subjects that the checks of a part by formula leave out, in words."""
    told = [getattr(module, "not_checked", None) for module in registered()]
    return [text for say in told if say is not None for text in say(loaded)]


def _sampled(module: ModuleType, loaded: LoadedPart) -> list[Check]:
    def under(some: PartLoads) -> list[Check]:
        return list(module.checks(loaded if some is loaded.loads else loaded.between(some)))

    return sampled(under, loaded.loads)
