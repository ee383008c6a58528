"""Result of `ballesta ladder`: every rung of every part, and the choice of `auto` among them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from checks.result.verdict import Check, RungTried


@dataclass(frozen=True, eq=False)
class LadderPart:
    """The rungs of one part.

    kinds   of checks that a model decides: "static", "fatigue", "buckling"
    rungs   every rung by itself, solids of several finenesses last
    tried   what `auto` tried or passed over, in that order
    chosen  the checks as `auto` reports them
    """

    name: str
    shape: str
    material: str
    kinds: Sequence[str]
    rungs: Sequence[RungTried]
    tried: Sequence[RungTried]
    chosen: Sequence[Check]

    @property
    def seconds(self) -> float:
        """Time that `auto` takes for the part, s."""
        return sum(rung.seconds for rung in self.tried)

    def to_dict(self) -> dict[str, Any]:
        """The part as plain data."""
        return {
            "name": self.name,
            "shape": self.shape,
            "material": self.material,
            "kinds": list(self.kinds),
            "rungs": [rung.to_dict() for rung in self.rungs],
            "auto": {
                "seconds": self.seconds,
                "rungs": [rung.to_dict() for rung in self.tried],
                "checks": [check.to_dict() for check in self.chosen],
            },
        }


@dataclass(frozen=True, eq=False)
class LadderResult:
    """The ladder of a design.

    solids  what the rows of solids mean, in words
    """

    name: str
    file: str
    sha256: str
    overrides: Sequence[str]
    parts: Sequence[LadderPart]
    solids: str
    command: str

    def to_dict(self) -> dict[str, Any]:
        """The ladder as plain data."""
        return {
            "format": "ballesta-ladder/1",
            "name": self.name,
            "file": self.file,
            "sha256": self.sha256,
            "overrides": list(self.overrides),
            "solids": self.solids,
            "parts": [part.to_dict() for part in self.parts],
            "command": self.command,
        }
