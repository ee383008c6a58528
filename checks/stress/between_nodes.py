"""A judged stress in bores whose contact is solved, between the nodes of the mesh.

Pressure under a loose pin rises and falls within an arc that may be narrower than the elements, and
what swings at its ends is narrower still. What else the bore's surface has of stress is as even as
the elements: it goes straight from node to node, and pressure is added where it is.
"""

import numpy as np

from checks.stress.clearances import POSITIONS, some_positions, that_swing
from checks.stress.judged import Judged, StaticPeak
from checks.stress.pins_in_bores import MIDDLE
from checks.stress.solid_mesh_level import Level
from fem.contact.bore import BoreHarmonics
from fem.contact.cycle import BorePressure
from fem.recovery import von_mises
from geometry.mesh import FloatArray, IntArray

_FINER = 2  # times as many hats of pressure
_MOST = 24  # places from one node to the next
_TOGETHER = 4000
_LEAST = 0.9  # of the value: what does not reach it there is not sought


def missed_between_nodes(judged: Judged, level: Level) -> float:
    """How far the quantity is off, MPa, by what pressure does between nodes, and by its hats.

    Sought at the middle of the clearances, over some positions of every cycle, with twice as many
    hats. Where it is judged in a bore it may be off either way.
    """
    contact = level.contact
    if contact is None:
        return 0.0
    value, own = judged.value(level), judged.point(level)
    positions, cycles = some_positions(judged.loads, level, [judged], POSITIONS)
    finer = contact.finer(positions, _FINER)
    coarse = contact.over(positions, MIDDLE)
    in_bore = any(own in bore.points for bore in contact.pins.harmonics)
    best = _LEAST * value if in_bore else value
    states, whole = level.coefficients[:, positions], np.eye(len(positions))
    for bore, missed in zip(contact.pins.harmonics, contact.missed, strict=True):
        name = bore.loads.interface.name
        nodes = level.history.basis[bore.points] @ states
        known = coarse.bores[name].at(bore.angles) - missed[:, positions]
        places = _Places(bore, nodes, known, finer.bores[name])
        if isinstance(judged, StaticPeak):
            bound = von_mises(np.moveaxis(nodes, 1, -1)).max(axis=1)
            rise = np.abs(places.more).max(axis=1)
        else:
            duty = level.judged_duty
            bound = judged.bound(level, bore.points)
            rise = np.ptp(places.more, axis=1) / 2
            rise += np.abs(places.more).max(axis=1) * duty.limit / duty.ultimate
        most = bound[places.ends].max(axis=1) + rise
        order = np.argsort(-most, kind="stable")
        order = order[~np.isin(bore.points[places.nearer[order]], level.left_out)]
        for first in range(0, len(order), _TOGETHER):
            some = order[first : first + _TOGETHER]
            some = some[most[some] > best]
            if not len(some):
                break
            stress, points = places.stress(some), bore.points[places.nearer[some]]
            if not isinstance(judged, StaticPeak):
                kept = that_swing(level, points, stress, best)
                stress, points = stress[kept], points[kept]
            if len(points):
                best = max(best, judged.anew(level, points, stress, whole, cycles))
    return abs(best - value)


class _Places:
    """Places on the sides of a bore's elements, from each node towards its neighbours.

    ends    (n, 2) nodes, of the bore's points, that each is between; nearer: (n,) the nearer one
    more    (n, m) MPa, pressure there less what the stress at the nodes has of it
    """

    def __init__(
        self, bore: BoreHarmonics, nodes: FloatArray, known: FloatArray, pressure: BorePressure
    ) -> None:
        """Place them; nodes (n_points, 6, m) MPa, of which `known` (n_points, m) is pressure."""
        sides, turns = bore.sides
        widest = float(np.abs(turns).max(initial=0.0))
        count = int(np.clip(np.ceil(widest / pressure.hats.widths.min()), 2, _MOST))
        shares = np.arange(count) / count
        self.ends: IntArray = np.repeat(sides, count, axis=0)
        self._share: FloatArray = np.tile(shares, len(sides))
        angles = (bore.angles[sides[:, :1]] + turns[:, None] * shares).ravel()
        self.nearer = np.where(self._share < 0.5, *self.ends.T)
        self._bore, self._nodes = bore, nodes
        self.more = pressure.at(angles) - self._between(known, slice(None))

    def _between(self, at_nodes: FloatArray, some: IntArray | slice) -> FloatArray:
        share = self._share[some].reshape(-1, *[1] * (at_nodes.ndim - 1))
        left, right = self.ends[some].T
        return np.asarray((1 - share) * at_nodes[left] + share * at_nodes[right])

    def stress(self, some: IntArray) -> FloatArray:
        """Stress (n, 6, m), MPa, at some of the places (n,)."""
        own = self._bore.short_wave_stress[self.nearer[some]][:, :, None]
        return self._between(self._nodes, some) + own * self.more[some][:, None, :]
