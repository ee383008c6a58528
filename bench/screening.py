"""Many variations of a design by formula, over processes: for benchmarks and tests."""

from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from math import ceil

from ballesta.sweeps.screen import Screened, Screening, Variation, overrides_of
from checks.design.data import Design
from fem.threads import one_thread

_SHARES = 8  # of the variations for each process, so that none is left with the slow ones


@one_thread()
def screen(
    design: Design, variations: Iterable[Variation], *, processes: int = 1
) -> list[Screened]:
    """Check variations of a design by formula, in their order.

    variations  key -> value, as in the design file ("parts.bar_upper.wall": "5 mm"), or the same
                as "key=value"
    processes   that share the variations; each solves the design's own cycles first

    A variation's `problem` says what is wrong with it. Raises DesignError and NumericsError
    for the design itself.
    """
    screening = Screening(design)  # what is wrong with the design itself is raised here
    if processes == 1:
        return [screening.of(variation) for variation in variations]
    wanted = [overrides_of(variation) for variation in variations]
    size = max(1, ceil(len(wanted) / (_SHARES * processes)))
    shares = [wanted[start : start + size] for start in range(0, len(wanted), size)]
    with ProcessPoolExecutor(processes, initializer=_begin, initargs=(design,)) as pool:
        return [one for found in pool.map(_share_screened, shares) for one in found]


_begun: list[Screening] = []  # in a process of a pool: the design that it screens by


def _begin(design: Design) -> None:
    _begun.append(Screening(design))


def _share_screened(share: list[tuple[str, ...]]) -> list[Screened]:
    return [_begun[-1].of(overrides) for overrides in share]
