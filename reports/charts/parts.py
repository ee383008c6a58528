"""The charts of a part."""

import pickle
from dataclasses import replace

from checks.result.verdict import DesignResult, PartResult
from reports.charts.buckling import buckling_chart
from reports.charts.chart import Charts, Known, gathered, once, without_peaks
from reports.charts.convergence import convergence_chart
from reports.charts.haigh import haigh_chart
from reports.charts.ladder import ladder_chart
from reports.charts.sn import sn_chart


def part_charts(part: PartResult, result: DesignResult, known: Known | None = None) -> Charts:
    """Haigh's diagram, S-N line, column curves, ladder and convergence of a part of a result.

    known  charts that were drawn before; those that were not join them
    """
    own = {name: without_peaks(cycle) for name, cycle in result.cycles.items()}
    alone = replace(result, parts=(), cycles=own)
    given = b"" if known is None else pickle.dumps((part, own))
    makers = {
        "haigh": lambda: haigh_chart(part, alone),
        "sn": lambda: sn_chart(part, alone),
        "buckling": lambda: buckling_chart(part, alone),
        "ladder": lambda: ladder_chart(part),
        "convergence": lambda: convergence_chart(part),
    }
    return gathered([once(known, name.encode() + given, make) for name, make in makers.items()])
