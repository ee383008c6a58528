"""Which models a check may use, and how long it may take."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from checks.design.errors import DesignError, no_such

AUTO, FORMULA, SOLID, SWEPT = "auto", "formula", "solid", "swept"
FIDELITIES = (AUTO, FORMULA, SOLID)


@dataclass(frozen=True)
class Effort:
    """Which models a check may use, and how long it may take.

    fidelity  "auto", "formula" or "solid"; in a batch "swept", a solid by a carried mesh
    within    s from the start of the check; nothing is begun that is expected to end later, its
              report included; None for no limit
    pinned    part -> kind of check -> the rung that must decide it; other parts as `fidelity` says
    fields    whether parts whose checks need no mesh get one, for a page or a window to draw
    """

    fidelity: str = AUTO
    within: float | None = None
    pinned: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    fields: bool = False

    @property
    def shows_stress(self) -> bool:
        """True if fields of stress are likely: closed formulas have none."""
        return self.fields or self.fidelity != FORMULA

    @property
    def options(self) -> list[str]:
        """The options of a check that ask for it; of a swept solid, for meshes of its own."""
        fidelity = SOLID if self.fidelity == SWEPT else self.fidelity
        found = [] if fidelity == AUTO else [f"--fidelity {fidelity}"]
        found += [] if self.within is None else [f"--within {self.within:g}s"]
        return [*found, "--fields"] if self.fields else found


DEFAULT_EFFORT = Effort()


def effort_of(
    fidelity: str, within: str | None, *, fields: bool = False, of_batch: bool = False
) -> Effort:
    """Return the effort that options of the command line ask for; raises DesignError.

    of_batch  whether a batch asks, in which solids may be swept
    """
    here = Path("command line")
    known = (*FIDELITIES, SWEPT) if of_batch else FIDELITIES
    if fidelity not in known:
        raise DesignError(here, "--fidelity", no_such("rung", fidelity, known))
    if fidelity == SWEPT and within is not None:
        raise DesignError(here, "--within", f"is not for --fidelity {SWEPT}")
    if within is None:
        return Effort(fidelity, fields=fields)
    from checks.design.units import measure

    try:
        seconds = measure(within, "time").value
    except ValueError as error:
        raise DesignError(here, "--within", str(error)) from error
    if not seconds > 0:
        raise DesignError(here, "--within", f'must be above 0 s, got "{within}"')
    return Effort(fidelity, seconds, fields=fields)
