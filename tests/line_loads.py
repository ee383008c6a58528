"""Numbers of a line load along a pin that its references state."""

import numpy as np


def unevenness(found, lug, inside=0.0):
    """Largest line load of a lug over its mean, at least `inside` mm from its faces.

    In the middle of a lug that is less than twice as wide.
    """
    one = found.lugs[lug]
    inside = min(inside, one.width / 2)
    nodes, values = found.hats[lug].nodes, found.intensity(lug)
    ends = np.array([one.low + inside, one.high - inside])
    kept = values[(nodes > ends[0]) & (nodes < ends[1])]
    most = max(kept.max(initial=0.0), *np.interp(ends, nodes, values))
    return most * one.width / one.size


def shift(found, lug):
    """Place of the resultant of a lug, mm from its middle."""
    one = found.lugs[lug]
    at = found.forces[lug] @ found.hats[lug].places / found.forces[lug].sum()
    return at - (one.low + one.high) / 2


def moment(found, places):
    """Bending moment (m, 2) at places along the pin, N mm: forces times their distance."""
    total = np.zeros((len(places), 2))
    for lug, hats, forces in zip(found.lugs, found.hats, found.forces, strict=True):
        direction = np.array(lug.force) / lug.size
        total += np.outer(forces @ hats.beyond(places, 1), direction)
    return total


def largest_moment(found):
    """Largest bending moment of the pin, N mm."""
    low, high = found.bar.cuts[0], found.bar.cuts[-1]
    places = np.unique(np.r_[np.linspace(low, high, 201), *(h.nodes for h in found.hats)])
    return np.hypot(*moment(found, places).T).max()
