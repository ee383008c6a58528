"""Finite-element structural and fatigue checks of machine parts, from Python.

    import ballesta

    result = ballesta.check("press.toml")             # a DesignResult; a notebook shows the verdict
    loads = ballesta.loads("press.toml")              # reactions and drives alone
    table = ballesta.batch("press.toml", "out", sweeps=["parts.bar.wall = 5..8 mm : 7"])

The command line does the same: `ballesta check`, `loads`, `batch`. Names are imported when they are
first used, so that `import ballesta` takes no time.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ballesta.api import (
        BatchResult,
        Check,
        Design,
        DesignError,
        DesignResult,
        Gate,
        LoadsResult,
        NumericsError,
        PartResult,
        Status,
        batch,
        check,
        loads,
        read_design,
    )

__all__ = [
    "BatchResult",
    "Check",
    "Design",
    "DesignError",
    "DesignResult",
    "Gate",
    "LoadsResult",
    "NumericsError",
    "PartResult",
    "Status",
    "batch",
    "check",
    "loads",
    "read_design",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name in __all__:
        return getattr(import_module("ballesta.api"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
