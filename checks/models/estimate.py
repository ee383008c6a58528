"""A check by any model, and whether its bars leave the verdict open."""

from dataclasses import dataclass, replace
from math import inf

from checks.result.verdict import Check, Status

GUARD = 1.5  # times the bars of a rung: what climbing stops at must not flip by a solid


@dataclass(frozen=True)
class Estimate:
    """A check, and which part of its model band a better model can take away.

    check         with its bars, all of them
    above, below  of the model band: how far the rung's own error reaches, in the check's unit
    guard         times the rung's bars that must leave the verdict as it is
    """

    check: Check
    above: float = 0.0
    below: float = 0.0
    guard: float = GUARD

    @property
    def spread(self) -> float:
        """All that a better model can take away, over the value."""
        value = self.check.value
        return (self.above + self.below + 2 * self.check.numerical) / value if value else 0.0

    @property
    def settled(self) -> bool:
        """True if a better model cannot be expected to change the verdict, guard included."""
        if self.check.status is Status.UNDECIDED:
            return False
        return self._widened(self.guard).status is self.check.status

    @property
    def open_for_good(self) -> bool:
        """True if no better model would settle it: the bars that all models share leave it open."""
        if self.check.status is not Status.UNDECIDED:
            return False
        low = self._moved(-self.below - self.check.numerical)
        high = self._moved(self.above + self.check.numerical)
        return low is Status.UNDECIDED and high is Status.UNDECIDED

    def agrees(self, other: "Estimate") -> bool:
        """True if the bars of two models of one check overlap."""
        (low, high), (lowest, highest) = self._ends, other._ends
        return low <= highest and lowest <= high

    @property
    def _ends(self) -> tuple[float, float]:
        """Where the bars end."""
        check = self.check
        return (
            check.value - check.numerical - check.below,
            check.value + check.numerical + check.model,
        )

    def would_settle(self, low: float, high: float) -> bool:
        """True if a model whose band is from `low` to `high` times its value may settle it."""
        value = self.check.value
        other = Estimate(
            replace(
                self.check,
                numerical=0.0,
                model=self._shared_above + max(0.0, high - 1) * value,
                model_below=self._shared_below + max(0.0, 1 - low) * value,
            ),
            max(0.0, high - 1) * value,
            max(0.0, 1 - low) * value,
            self.guard,
        )
        return other.settled

    @property
    def _shared_above(self) -> float:
        return max(0.0, self.check.model - self.above) if self.check.model < inf else 0.0

    @property
    def _shared_below(self) -> float:
        return max(0.0, self.check.below - self.below) if self.check.below < inf else 0.0

    def _widened(self, guard: float) -> Check:
        check = self.check
        return replace(
            check,
            numerical=guard * check.numerical,
            model=check.model + (guard - 1) * self.above,
            model_below=check.below + (guard - 1) * self.below,
        )

    def _moved(self, by: float) -> Status:
        """Status of a better model's check with the value moved and only the shared band left."""
        if not abs(by) < inf:
            return Status.PASS  # unknown: a better model may say anything
        return replace(
            self.check,
            value=max(0.0, self.check.value + by),
            numerical=0.0,
            model=self._shared_above,
            model_below=self._shared_below,
        ).status
