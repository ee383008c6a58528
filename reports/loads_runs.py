"""Measured run as data for people: the extremes of the loads on each body at each of its points.

No linkage is solved for it, so that there are neither reactions of joints nor drives.
"""

from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np

from loads import MeasuredLoads
from reports.loads_figures import Extremes, FloatArray, PointSummary, plain_fields


@dataclass(frozen=True, eq=False)
class ShownRun:
    """A measured run as people see it.

    file   where its loads stand
    shown  (n,) position, in `unit` ("mm", "deg" or "s"), called `shown_name`
    duty   how often it runs in the life; 0 for a run in no duty
    """

    loads: MeasuredLoads
    file: str
    shown_name: str
    unit: str
    shown: FloatArray
    duty: float

    @property
    def name(self) -> str:
        """The run's name."""
        return self.loads.name

    @property
    def duration(self) -> float | None:
        """Time from the first row to the last, s; None where no times were measured."""
        return None if self.loads.times is None else float(self.loads.times[-1])

    @property
    def points(self) -> list[PointSummary]:
        """Extremes of the load on every body at every point, axes of the ground."""
        return [
            PointSummary(
                body,
                str(load.point),
                tuple(
                    self._extremes(quantity, values, angular)
                    for quantity, values, angular in (
                        ("Fx", load.force[:, 0], False),
                        ("Fy", load.force[:, 1], False),
                        ("|F|", np.hypot(load.force[:, 0], load.force[:, 1]), False),
                        ("M", load.moment, True),
                    )
                    if not angular or np.any(values)
                ),
            )
            for body in self.loads.bodies
            for load in self.loads.body_loads(body)
        ]

    def _extremes(self, quantity: str, values: FloatArray, angular: bool) -> Extremes:
        low, high = int(values.argmin()), int(values.argmax())
        times, (phase,) = self.loads.times, self.loads.phases
        mean = nan
        if times is not None and times[-1] > 0.0:
            mean = float(np.trapezoid(values, times) / times[-1])
        return Extremes(
            quantity,
            angular,
            float(values[low]) + 0.0,
            float(self.shown[low]),
            phase,
            float(values[high]) + 0.0,
            float(self.shown[high]),
            phase,
            mean,
        )

    def to_dict(self) -> dict[str, Any]:
        """The run as plain data: N, N mm, mm, s; without the history, which is the CSV's."""
        return {
            "name": self.name,
            "file": self.file,
            "shown_name": self.shown_name,
            "unit": self.unit,
            "n_positions": len(self.shown),
            "duration": self.duration,
            "duty": self.duty,
            "points": [plain_fields(point) for point in self.points],
        }
