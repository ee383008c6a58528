"""A bar with a long slot: two rails joined at both ends only, bent in their plane."""

from dataclasses import dataclass

import numpy as np

from geometry.mesh import FloatArray


@dataclass(frozen=True, eq=False)
class RailForces:
    """Forces of the upper and lower rail (y > 0, y < 0) at k places over n positions.

    axial   (2, n)     N, even along the rails but for half of the bar's own
    moment  (2, k, n)  N mm, each rail's own, about its own axis
    """

    axial: FloatArray
    moment: FloatArray


def rail_forces(
    places: FloatArray,
    moment: FloatArray,
    pressed: FloatArray,
    reach: FloatArray,
    *,
    area: float,
    inertia: float,
    apart: float,
) -> RailForces:
    """Forces of two equal rails that nothing joins between their clamped ends.

    places   (k,) mm, even, from the rails' first clamped end to their second
    moment   (k, n) N mm about z, of the whole bar
    pressed  (n,) N, size of a force that presses one rail away from the other
    reach    (n,) mm, where; outside the rails it presses none
    area     mm2 and `inertia` mm4 of one rail, `apart` mm between their middles

    The rails push and pull by P, the same all along as they are joined at the ends only, and each
    bends by (M - P apart)/2. Their ends turn alike by bending, integral of (M - P apart)/(2 E I),
    and by lengthening, 2 P L/(E A apart): so P apart = mean(M) A apart^2/2 / (2 I + A apart^2/2).
    Half of the contact's force bends both rails alike, which is in M. The other half spreads them:
    both are clamped bars under a point load Q at a, L = a + b, with Q a b^2/L^2 at the first end,
    Q a^2 b/L^2 at the second and -2 Q a^2 b^2/L^3 at the load (Young and Budynas, Roark's Formulas
    for Stress and Strain, 7th ed., table 8.1, 1d).
    """
    start, length = places[0], places[-1] - places[0]
    steiner = area * apart**2 / 2
    weights = np.full(len(places), 1.0)
    weights[[0, -1]] = 0.5
    mean = weights @ moment / weights.sum()
    couple = mean / apart * steiner / (2 * inertia + steiner)
    own = (moment - couple * apart) / 2
    a = np.clip(reach - start, 0.0, length)
    b = length - a
    force = pressed / 2
    first, second = force * a * b**2 / length**2, force * a**2 * b / length**2
    x = (places - start)[:, None]
    straight = first + (second - first) * x / length
    triangle = np.minimum(x * b, (length - x) * a) / length  # of a hinged bar under 1 N
    spread = straight - force * triangle
    return RailForces(np.stack([-couple, couple]), np.stack([own + spread, own - spread]))
