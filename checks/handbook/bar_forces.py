"""Section forces along a free bar from the loads on one side of each section and its own inertia.

Force and couple that the part beyond a section (at larger x) exerts on the rest:

    N = sum F_x,  V = sum F_y,  T = sum M_x,  M_y = sum M_y,  M_z = sum (M_z + (x - x_0) F_y),

x_0 the section's place, so that sigma_x = N/A - M_z y/I_z + M_y z/I_y. There are no forces along
z. A mass m at x, d'Alembert, takes -m (a_x - omega2 x) along x and -m (a_y + alpha x) across, as
in fem.unit_loads.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.mesh import FloatArray


@dataclass(frozen=True, eq=False)
class BarForces:
    """Section forces (k, n) at k places over n positions: N, and N mm."""

    axial: FloatArray
    shear: FloatArray
    torque: FloatArray
    moment_y: FloatArray
    moment_z: FloatArray


@dataclass(frozen=True, eq=False)
class BarLoads:
    """All that acts on a free bar along x, in balance in its plane.

    points         (x, wrench): place, mm, as a number or (n,), and (n, 6) N, N mm on the bar
    mass_at        (m,) mm
    mass           (m,) t
    accelerations  (n, 4) a_x, a_y, alpha, omega2 of the origin, what balances foreign masses added
    added          (n, 3) of them: a_x, a_y, alpha
    """

    points: Sequence[tuple[float | FloatArray, FloatArray]]
    mass_at: FloatArray
    mass: FloatArray
    accelerations: FloatArray
    added: FloatArray

    def at(self, places: FloatArray) -> BarForces:
        """Section forces at places (k,) along the bar."""
        beyond = (self.mass_at > places[:, None]) * self.mass
        first, second = beyond @ self.mass_at, beyond @ self.mass_at**2
        total, none = beyond.sum(axis=1), np.zeros(len(places))
        field = self.accelerations.T
        arm = first - places * total
        axial = np.stack([-total, none, none, first], axis=1) @ field
        shear = np.stack([none, -total, -first, none], axis=1) @ field
        moment = np.stack([none, -arm, places * first - second, none], axis=1) @ field
        fixed = [(float(x), wrench) for x, wrench in self.points if np.ndim(x) == 0]
        at = np.array([x for x, _ in fixed])
        acting = np.zeros((len(at), 6, field.shape[1]))
        for row, (_, wrench) in zip(acting, fixed, strict=True):
            row[:] = wrench.T
        counts = (at > places[:, None]).astype(float)
        axial += counts @ acting[:, 0]
        shear += counts @ acting[:, 1]
        moment += counts @ acting[:, 5] + (counts * (at - places[:, None])) @ acting[:, 1]
        torque, moment_y = counts @ acting[:, 3], counts @ acting[:, 4]
        for x, wrench in self.points:
            if np.ndim(x) == 0:
                continue
            passed = (np.asarray(x) > places[:, None]).astype(float)
            axial += passed * wrench[:, 0]
            shear += passed * wrench[:, 1]
            torque += passed * wrench[:, 3]
            moment_y += passed * wrench[:, 4]
            moment += passed * (wrench[:, 5] + (x - places[:, None]) * wrench[:, 1])
        return BarForces(axial, shear, torque, moment_y, moment)


def balanced_bar(
    points: Sequence[tuple[float | FloatArray, FloatArray]],
    mass_at: FloatArray,
    mass: FloatArray,
    accelerations: FloatArray,
) -> BarLoads:
    """Balance a bar's loads: a rigid acceleration makes up for the rest that its own mass leaves.

    As a solid does it where the loads were computed with other masses than the bar's. Raises
    ValueError for a bar whose mass is nothing or all in one place.
    """
    total, first, second = (float((mass * mass_at**k).sum()) for k in range(3))
    if not total * second - first**2 > 0:
        raise ValueError("a bar's mass must be spread along it")
    a_x, a_y, alpha, omega2 = accelerations.T
    left = np.zeros((3, len(accelerations)))
    left[0] = -total * a_x + first * omega2
    left[1] = -total * a_y - first * alpha
    left[2] = -first * a_y - second * alpha
    for x, wrench in points:
        left[0] += wrench[:, 0]
        left[1] += wrench[:, 1]
        left[2] += wrench[:, 5] + np.asarray(x) * wrench[:, 1]
    added = np.empty_like(left)
    added[0] = left[0] / total
    added[1:] = np.linalg.solve(np.array([[total, first], [first, second]]), left[1:])
    whole = accelerations.copy()
    whole[:, :3] += added.T
    return BarLoads(points, mass_at, mass, whole, np.asarray(added.T))


def deflection(moment: FloatArray, stiffness: FloatArray, places: FloatArray) -> FloatArray:
    """Deflection (k, n) mm of a bar from the chord of its ends, by integrating its curvature.

    moment     (k, n) N mm about z, as `BarForces`: w'' = -sigma/(E y) = M/(E I)
    stiffness  (k,) E I, N mm2
    places     (k,) mm, rising; trapezoids between them
    """
    steps = np.diff(places)[:, None]
    curvature = moment / stiffness[:, None]
    zero = np.zeros((1, moment.shape[1]))
    slope = np.concatenate([zero, np.cumsum((curvature[1:] + curvature[:-1]) / 2 * steps, axis=0)])
    drop = np.concatenate([zero, np.cumsum((slope[1:] + slope[:-1]) / 2 * steps, axis=0)])
    share = (places - places[0]) / (places[-1] - places[0])
    return np.asarray(drop - share[:, None] * drop[-1])
