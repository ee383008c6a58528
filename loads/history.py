"""Load history of one part over a cycle, in its own axes: the loads of the part's models."""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from loads.bodies import FloatArray, IntArray, Vector

_NOWHERE: FloatArray = np.zeros(0)


@dataclass(frozen=True, eq=False)
class LoadHistory:
    """Loads on one part over the cycle, in the part's own axes and in equilibrium.

    positions      (n,)       swept coordinate, mm or rad
    times          (n,)       s
    phases, phase_of          names of the phases, and the phase of each position (n,)
    locations      (m, 2)     mm, of the interfaces, in the body frame
    wrenches       (n, m, 6)  N, N mm: force and moment (Fx, Fy, Fz, Mx, My, Mz) ON the part
    accelerations  (n, 4)     mm/s2, mm/s2, rad/s2, rad2/s2: of the frame origin minus gravity,
                              angular, and omega**2
    reaches        (n, m, 2)  mm, in the body frame: from an interface's location, where its wrench
                              is stated, to where its force acts; not zero where a contact slides

    A material point (x, y) has the acceleration minus gravity
    (a_x - alpha y - omega2 x, a_y + alpha x - omega2 y).
    """

    part: str
    interfaces: tuple[str, ...]
    positions: FloatArray
    times: FloatArray
    phases: tuple[str, ...]
    phase_of: IntArray
    locations: FloatArray
    wrenches: FloatArray
    accelerations: FloatArray
    reaches: FloatArray = field(default_factory=lambda: _NOWHERE)

    def __post_init__(self) -> None:
        n, m = len(self.positions), len(self.interfaces)
        if self.reaches is _NOWHERE:
            object.__setattr__(self, "reaches", np.zeros((n, m, 2)))
        for name, expected in (
            ("positions", (n,)),
            ("times", (n,)),
            ("phase_of", (n,)),
            ("locations", (m, 2)),
            ("wrenches", (n, m, 6)),
            ("accelerations", (n, 4)),
            ("reaches", (n, m, 2)),
        ):
            values = np.asarray(getattr(self, name))
            if values.shape != expected:
                raise ValueError(
                    f"loads on {self.part!r}: {n} positions and {m} interfaces need {name} "
                    f"of shape {expected}, got {values.shape}"
                )
            if not np.isfinite(values).all():
                raise ValueError(f"loads on {self.part!r}: {name} are not all finite numbers")
        if n and not (np.min(self.phase_of) >= 0 and np.max(self.phase_of) < len(self.phases)):
            raise ValueError(f"loads on {self.part!r}: phase_of points outside {self.phases}")

    def scaled(self, factor: float) -> Self:
        """Return the same history with all loads and accelerations times a factor."""
        return replace(
            self, wrenches=factor * self.wrenches, accelerations=factor * self.accelerations
        )

    def equilibrium_residual(self, mass: float, centre: Vector, inertia: float) -> FloatArray:
        """Return residual forces and moment about the origin, d'Alembert's included (n, 3).

        mass, centre (in the body frame) and inertia about the centre belong to the part's model;
        the units are N and N mm. Zero where they agree with the linkage's body.
        """
        x, y = self.locations[:, 0], self.locations[:, 1]
        force_x, force_y = self.wrenches[:, :, 0], self.wrenches[:, :, 1]
        moment = np.sum(self.wrenches[:, :, 5] + x * force_y - y * force_x, axis=1)
        a_x, a_y, alpha, omega2 = self.accelerations.T
        c_x, c_y = centre
        centre_x = a_x - alpha * c_y - omega2 * c_x
        centre_y = a_y + alpha * c_x - omega2 * c_y
        return np.stack(
            [
                force_x.sum(axis=1) - mass * centre_x,
                force_y.sum(axis=1) - mass * centre_y,
                moment - inertia * alpha - mass * (c_x * centre_y - c_y * centre_x),
            ],
            axis=1,
        )
