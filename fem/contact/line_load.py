"""The line load q(z) along a round pin in its stack of lugs, where pin and bores give way.

The pin is a Timoshenko beam; in each lug it presses on the bore as far as both give way there
(fem/contact/beds.py). Lugs move freely along their force and may tilt. No pull: where the pin lifts
off, it presses nothing. Forces of all lugs and the moments about the pin balance exactly. The
condensed contact of fem/contact/condensed.py, with hats of line load along the lugs.
docs/theory/contact.md, "Along the pin", derives it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fem.contact.beds import Along, Lug, RoundBar, wave_bed
from fem.contact.condensed import CondensedContact
from fem.contact.cylinder_waves import shear_of_bar
from geometry.mesh import FloatArray

_PATCHES = 12  # along a lug, graded to its edges
_GAUSS = np.polynomial.legendre.leggauss(4)  # exact for squares of cubics
_LEVEL = 1e-6  # rad: forces that lie in one plane

# Flexibility (n, n), mm/N, of a bore and the pin in it to the hats of its lug.
Bed = Callable[[RoundBar, Lug, Along], FloatArray]


@dataclass(frozen=True, eq=False)
class LineLoad:
    """Forces of hats along a pin.

    bar    the pin
    lugs   that it presses on; `hats` and `forces` (n,), N, of the hats, one of each lug
    """

    bar: RoundBar
    lugs: Sequence[Lug]
    hats: Sequence[Along]
    forces: Sequence[FloatArray]

    def intensity(self, lug: int) -> FloatArray:
        """Line load (n,), N/mm, at the nodes of a lug's hats."""
        return np.asarray(self.forces[lug] / self.hats[lug].lengths)


def line_load(
    bar: RoundBar,
    lugs: Sequence[Lug],
    bed: Bed | None = None,
    patches: int = _PATCHES,
    *,
    bends: bool = True,
) -> LineLoad:
    """Solve what presses along a pin.

    lugs     that carry a force
    bed      flexibility of bore and pin in a lug, where waves do not make it
    patches  along a lug
    bends    False: the pin stays straight, lugs do not tilt; its surface gives way all the same

    Raises ContactError where no pressure balances the forces.
    """
    hats = [Along.graded(lug, patches) for lug in lugs]
    places = np.concatenate([h.places for h in hats])
    count = [len(h.nodes) for h in hats]
    owner = np.repeat(np.arange(len(lugs)), count)
    directions = np.array([lug.force for lug in lugs]) / np.array([[lug.size] for lug in lugs])
    along = directions[owner]
    flexibility = bends * _beam(bar, hats) * (along @ along.T)
    for k, (lug, own) in enumerate(zip(lugs, hats, strict=True)):
        at = np.flatnonzero(owner == k)
        block = (bed or wave_bed)(bar, lug, own)
        arm = own.places - (lug.low + lug.high) / 2
        flexibility[np.ix_(at, at)] += block + bends * lug.tilt * np.outer(arm, arm)
    flexibility = (flexibility + flexibility.T) / 2
    # the pin turns; each lug moves along its force
    _, sizes, axes = np.linalg.svd(directions)
    planes = axes[: np.count_nonzero(sizes > _LEVEL)]  # one where all forces lie in it
    turning = (along @ planes.T) * places[:, None]
    moves = (owner[:, None] == np.arange(len(lugs))).astype(float)
    load = np.r_[np.zeros(turning.shape[1]), [lug.size for lug in lugs]]
    problem = CondensedContact(flexibility, np.column_stack([turning, moves]))
    state = problem.solve(np.zeros(len(places)), load)
    return LineLoad(bar, lugs, hats, np.split(state.forces, np.cumsum(count)[:-1]))


def _beam(bar: RoundBar, hats: Sequence[Along]) -> FloatArray:
    """Flexibility (n, n), mm/N, of the pin as a beam held at its lowest hat."""
    nodes = np.concatenate([h.nodes for h in hats])
    start, stop = nodes.min(), nodes.max()
    inner = [c for c in bar.cuts if start < c < stop]
    cuts = np.unique(np.r_[nodes, inner])
    steps = np.diff(cuts)
    x = (cuts[:-1, None] + steps[:, None] * (1 + _GAUSS[0]) / 2).ravel()
    weight = (steps[:, None] * _GAUSS[1] / 2).ravel() / bar.youngs_modulus
    area = np.pi * bar.diameter(x) ** 2 / 4
    bent = np.concatenate([h.beyond(x, 1) for h in hats])
    sheared = np.concatenate([h.beyond(x, 0) for h in hats])
    found = (bent * (weight * 4 * np.pi / area**2)) @ bent.T
    found += (sheared * (weight * shear_of_bar(bar.poisson_ratio) / area)) @ sheared.T
    return np.asarray(found)
