"""Kinds of checks: their names, what they compare, and the safety that they must show."""

import re
from dataclasses import dataclass

from checks.design.model import Requirements, SafetyKey


@dataclass(frozen=True)
class Kind:
    """A kind of check; docs/reference/checks.md lists all of them.

    name      of the kind, such as "bush"
    quantity  name of the value; {} stands for the interface, body or plane that it is of
    demand    the value, in words
    limit     where the limit comes from, in words
    require   key of `require` whose safety it must show
    source    literature and pages of the documentation, in Markdown
    """

    name: str
    quantity: str
    demand: str
    limit: str
    require: SafetyKey
    source: str

    def safety(self, required: Requirements) -> float:
        """The safety that its checks must show."""
        value: float = getattr(required, self.require)
        return value

    def has(self, check: str) -> bool:
        """True for the kind and quantity, "kind: quantity", of one of its checks."""
        pieces = map(re.escape, f"{self.name}: {self.quantity}".split("{}"))
        return re.fullmatch(".+".join(pieces), check) is not None
