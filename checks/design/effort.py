"""Which models a check may use, and how long it may take."""

from collections.abc import Mapping
from dataclasses import dataclass, field

AUTO, SOLID = "auto", "solid"
FIDELITIES = (AUTO, "formula", "beam", SOLID)


@dataclass(frozen=True)
class Effort:
    """Which models a check may use, and how long it may take.

    fidelity  "auto", "formula", "beam" or "solid"
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
        """Whether fields of stress are likely: closed formulas and beams have none."""
        return self.fields or self.fidelity not in ("formula", "beam")

    @property
    def options(self) -> list[str]:
        """The options of the command line that ask for it."""
        found = [] if self.fidelity == AUTO else [f"--fidelity {self.fidelity}"]
        found += [] if self.within is None else [f"--within {self.within:g}s"]
        return [*found, "--fields"] if self.fields else found


DEFAULT_EFFORT = Effort()
