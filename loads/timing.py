"""Times and speeds of a cycle from its pace, phase by phase."""

from itertools import groupby
from typing import Final

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.joints import in_words
from loads.motion import Geometry, Motion
from loads.pace import MotorPace, Pace, RunPace, SteadyPace, StrokePace, stroke_law, stroke_time
from loads.path import Path
from loads.running import SolvedPace


class Timing:
    """The pace of a cycle over its phases; way is how far the pace coordinate has gone.

    solved  the run of the motor of a MotorPace, or a RunPace; None: at the stated speed
    """

    def __init__(
        self,
        path: Path,
        pace: Pace,
        spans: tuple[tuple[float, float], ...],
        solved: SolvedPace | None = None,
    ) -> None:
        self._pace: Final = pace.steady if isinstance(pace, MotorPace) else pace
        self.solved: Final = pace if isinstance(pace, RunPace) else solved
        kinematics = path.kinematics
        kinematics.linkage.check_coordinate(pace.coordinate, "pace")
        ends = np.array(spans)
        before, after = (
            kinematics.value(pace.coordinate, path.at(end).poses)
            for end in (ends[:, 0], ends[:, 1])
        )
        self._values: Final = before
        ways = np.abs(after - before)
        rising = [stop > start for start, stop in spans]
        self._stroke_of: Final = np.zeros(len(spans), dtype=int)
        self._before: Final = np.zeros(len(spans))  # way before the phase, in its stroke or in all
        self._strokes: list[float] = []
        phase = 0
        for number, (_, group) in enumerate(groupby(rising)):
            first = phase
            for _ in group:
                start = first if isinstance(pace, StrokePace) else 0
                self._before[phase] = ways[start:phase].sum()
                self._stroke_of[phase] = number
                phase += 1
            self._strokes.append(float(ways[first:phase].sum()))

    def way(self, k: int, geometry: Geometry | Motion) -> FloatArray:
        """Return how far the pace coordinate has gone (n,) at positions of phase k."""
        values = geometry.kinematics.value(self._pace.coordinate, geometry.poses)
        way: FloatArray = self._before[k] + np.abs(values - self._values[k])
        return way

    def rates(self, k: int, geometry: Geometry) -> tuple[FloatArray, FloatArray]:
        """Return speed and acceleration of the pace (n,) at positions of phase k."""
        pace = self._pace
        way = self.way(k, geometry)
        if self.solved is not None:
            return self.solved.rates(k, way)
        assert not isinstance(pace, RunPace)
        if isinstance(pace, SteadyPace):
            square = pace.speed**2 + 2.0 * pace.acceleration * way
            if (square <= 0.0).any():
                at = geometry.place(int(np.argmax(square <= 0.0)))
                slowing = in_words(pace.coordinate, -pace.acceleration)
                raise LinkageError(
                    f"{pace.coordinate.label} slows down by {slowing}/s2 and stands still before "
                    f"{at}"
                )
            return np.sqrt(square), np.full(len(way), pace.acceleration)
        length = self._length(k)
        _, rate, change = stroke_law(pace.law, stroke_time(pace.law, way / length))
        return rate * length / pace.time, change * length / pace.time**2

    def times(self, k: int, motion: Motion) -> FloatArray:
        """Return the time since the start of the cycle (n,) [s] at positions of phase k."""
        pace = self._pace
        way = self.way(k, motion)
        if self.solved is not None:
            return self.solved.times(k, way)
        assert not isinstance(pace, RunPace)
        if isinstance(pace, SteadyPace):
            # way = v t + a t2 / 2, solved without losing digits where a is small
            root = np.sqrt(pace.speed**2 + 2.0 * pace.acceleration * way)
            steady: FloatArray = 2.0 * way / (pace.speed + root)
            return steady
        share = stroke_time(pace.law, way / self._length(k))
        result: FloatArray = (self._stroke_of[k] + share) * pace.time
        return result

    def _length(self, k: int) -> float:
        length = self._strokes[int(self._stroke_of[k])]
        if length <= 0.0:
            raise LinkageError(
                f"{self._pace.coordinate.label} sets the pace but does not move in phase {k + 1}"
            )
        return length
