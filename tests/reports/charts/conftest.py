"""The charts of the made-up press, and the lines that are drawn on them."""

import numpy as np
import pytest

from reports.charts import cycle_charts, part_charts
from reports.charts.chart import Plane

from .. import chart_results as made


@pytest.fixture(scope="module")
def charts():
    """Every chart of the made-up press, by its key."""
    result = made.design()
    found = [*part_charts(result.parts[0], result).charts]
    found += [chart for _, own in cycle_charts(result) for chart in own.charts]
    return {chart.key: chart for chart in found}


@pytest.fixture
def drawn(monkeypatch):
    """Return what draws a chart of a made-up part, and gives the lines (k, 2) on it."""
    lines, line = [], Plane.line

    def noted(self, points, **style):
        lines.append(np.asarray(points, dtype=float).reshape(-1, 2))
        return line(self, points, **style)

    monkeypatch.setattr(Plane, "line", noted)

    def draw(key, **data):
        result = made.design(**data)
        lines.clear()
        wanted = next(c for c in part_charts(result.parts[0], result).charts if c.key == key)
        assert wanted.svg
        return list(lines)

    return draw
