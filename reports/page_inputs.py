"""Inputs of a result: stated by the design, set on the command line, by default, or assumed."""

from collections.abc import Sequence
from dataclasses import dataclass

from checks.result.verdict import DesignResult
from checks.result.words import assumptions

Pairs = Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Inputs:
    """Inputs by where they come from, each (key, value).

    design    stated by the design file and the files that it takes from
    command   set on the command line, as the design file would state them
    unread    what the command line set as it was written, where no input has its key
    defaults  not stated anywhere
    """

    design: Pairs
    command: Pairs
    unread: Sequence[str]
    defaults: Pairs


@dataclass(frozen=True)
class Assumed:
    """Assumptions (keys, what): those that the design marks, and the tool's own."""

    design: Pairs
    tool: Pairs

    @property
    def count(self) -> int:
        """Number of all of them."""
        return len(self.design) + len(self.tool)


def sorted_inputs(result: DesignResult) -> Inputs:
    """Keep apart what the design file states and what the command line set."""
    ways = {text: text.partition("=")[0].strip() for text in result.overrides}
    design: list[tuple[str, str]] = []
    command: list[tuple[str, str]] = []
    used: set[str] = set()
    for key, value in result.inputs:
        found = [text for text, way in ways.items() if _is_within(key, way)]
        used |= set(found)
        (command if found else design).append((key, value))
    return Inputs(
        design, command, [text for text in ways if text not in used], list(result.defaults)
    )


def _is_within(key: str, way: str) -> bool:
    """Return True if a dotted key is `way` itself or lies below it."""
    return key == way or key.startswith((f"{way}.", f"{way}["))


def sorted_assumptions(result: DesignResult) -> Assumed:
    """Keep apart what the design marks as assumed and what was assumed where it is silent."""
    marked = set(result.assumed_by_design)
    mine = {what for key, what in result.assumed if key in marked}
    pairs = assumptions(result)
    return Assumed(
        [pair for pair in pairs if pair[1] in mine], [pair for pair in pairs if pair[1] not in mine]
    )
