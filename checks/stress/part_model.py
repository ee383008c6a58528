"""Stress of a part over the cycle by a rung below the solid, in the same history as a solid's.

A rung's points are the places where such a part can be stressed most: bores all round, fibres of
its sections, fillets. Its basis need not be one of unit loads of an elastic body: coefficients may
be any function of the link loads, as long as basis times coefficients is the stress.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from checks.result.derivation import Item
from checks.stress.stress_result import Stressed
from fem.stress_history import StressHistory
from geometry.mesh import FloatArray

# Of a unit load: its name with where it acts, and the unit of its coefficient.
UnitName = tuple[str, str]


@dataclass(frozen=True)
class ElasticLoad:
    """The largest share that a position's load is of the part's elastic buckling load.

    share     0 where nothing presses or bends; 1 is buckling
    position  at which it is largest
    words     how it buckles, and by which formula
    explain   the items of a derivation of the share, whose symbol is `share`, made when asked for
    unproved  why no formula gives the share, in words; "" for one that is a formula's
    pulled    True if no position presses the part, or hardly: the share is without what pulls
    """

    share: float
    position: int
    words: str
    explain: Callable[[], Sequence[Item]] = field(compare=False, repr=False)
    unproved: str = ""
    pulled: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class RungModel:
    """A part's stress by a rung, before it is judged.

    rung        "formula" or "beam"
    history     of the stress at the rung's points; their places in the part's frame, mm
    places      (n_points,) what stands at each point, such as "bore knee" or "tube, mid-length"
    fretting    (n_points,) factor by which fretting lowers the endurance limit, 1 elsewhere
    numerical   largest numerical error of the rung's own solution, as a share of its peak; 0 of a
                formula
    residual    what is left of the part's balance, or did not reach it, over the largest force
    deflection  mm, largest displacement over the cycles, estimated; infinite if unknown
    buckling    largest share of the elastic buckling load, None where the rung has no answer
    neglects    what the rung leaves out, in words
    unknowns    number of unknowns that were solved, 0 of a formula
    ring        number of points at even angles around each section of a pin, section by section; 0
                where the points lie otherwise
    units       (n_basis,) names of what the history's coefficients are sizes of
    """

    rung: str
    history: StressHistory
    places: Sequence[str]
    fretting: FloatArray
    numerical: float
    residual: float
    deflection: float
    buckling: ElasticLoad | None
    neglects: str
    unknowns: int = 0
    ring: int = 0
    units: Sequence[UnitName]

    def __post_init__(self) -> None:
        if len(self.units) != len(self.history.coefficients):
            raise ValueError(
                f"the rung {self.rung} has {len(self.history.coefficients)} unit loads, "
                f"but {len(self.units)} names"
            )


@dataclass(frozen=True, eq=False, kw_only=True)
class RungLevel(Stressed):
    """A rung's stress, judged."""

    model: RungModel = field()

    def named(self, point: int) -> str:
        """Name of the place at a point."""
        return self.model.places[point]

    def depth(self, point: int) -> tuple[float, float] | None:
        """None: a rung's points are on lines, not on surfaces."""
        return None
