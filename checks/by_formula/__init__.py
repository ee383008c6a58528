"""Checks of parts that are formulas of their loads: every module here is one, or some of a kind.

A module has a function `checks` that takes a `LoadedPart` and yields its checks, each made by
`LoadedPart.worst`, `at` or `derived`, so that their numbers are those of the formulas that are
shown, and `KINDS`, what they compare, for the reference of all checks. It may have functions of a
`LoadedPart` besides: `not_checked` yields sentences on what it leaves out, `facts` returns numbers
that stand beside the checks by name, `charts` plain data of charts by name. One whose checks are
of ranges over the cycles says so by `OVER_CYCLES = True`. A module is found by
being here, or by the entry point group `ballesta.checks` of another package (docs/extending.md).
Own modules come in the order of their names, then those of others.
"""

from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from types import ModuleType
from typing import Any

from checks.part.derived import Kind
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


def kinds() -> list[Kind]:
    """Kinds of checks by formula, in the order in which they are made."""
    return [kind for module in registered() for kind in getattr(module, "KINDS", ())]


def formula_checks(loaded: LoadedPart) -> list[Check]:
    """All checks of a part by formula, with what the positions miss of them in their bars."""
    return [check for module in registered() for check in _sampled(module, loaded)]


def not_checked(loaded: LoadedPart) -> list[str]:
    """Subjects that the checks of a part by formula leave out, in words."""
    return [text for say in _functions("not_checked") for text in say(loaded)]


def facts(loaded: LoadedPart) -> dict[str, float | str]:
    """Numbers and texts beside the checks of a part by formula, by name."""
    return {name: one for tell in _functions("facts") for name, one in tell(loaded).items()}


def charts(loaded: LoadedPart) -> dict[str, Any]:
    """Plain data of the charts of a part's checks by formula, by name."""
    return {name: one for draw in _functions("charts") for name, one in draw(loaded).items()}


def _functions(name: str) -> list[Callable[[LoadedPart], Any]]:
    """The functions of a name of all modules that have one."""
    return [vars(module)[name] for module in registered() if name in vars(module)]


def _sampled(module: ModuleType, loaded: LoadedPart) -> list[Check]:
    def under(some: PartLoads) -> list[Check]:
        return list(module.checks(loaded if some is loaded.loads else loaded.between(some)))

    return sampled(under, loaded.loads, whole=getattr(module, "OVER_CYCLES", False))
