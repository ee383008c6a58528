"""Multiaxial fatigue criteria against tests: a table and a plot of predicted over measured.

`python -m bench.multiaxial` prints the tables in Markdown; `--write` also draws
docs/validation/multiaxial.svg, as `python -m bench.error_bars --write` does for the page that shows
both. The verdict is the worse of the columns Goodman and Findley, which here have the limits of the
tests.
"""

import sys
from pathlib import Path

import numpy as np

from fatigue import critical_plane, findley_criterion, goodman
from tests.fatigue.multiaxial_cases import (
    BENDING_LIMIT,
    NISHIHARA_KAWAMOTO,
    TORSION_LIMIT,
    BendingTorsion,
    bending_and_torsion,
)

PLOT = Path(__file__).parent.parent / "docs" / "validation" / "multiaxial.svg"
COLUMNS = ("Goodman", "Findley")


def predicted(test: BendingTorsion) -> tuple[float, float]:
    """Each criterion of COLUMNS over its limit at the stated amplitudes; above 1 is safe.

    The stated amplitudes are at the measured limit, so the predicted limit over the measured one is
    the reciprocal.
    """
    stress = bending_and_torsion(test.bending, test.torsion, test.phase)
    ratio = TORSION_LIMIT / BENDING_LIMIT
    findley = findley_criterion(ratio)
    plane = critical_plane(stress, findley.k).value / (findley.limit_ratio * BENDING_LIMIT)
    # no mean in these tests: any ultimate strength gives the same, as long as it is finite
    chord = goodman(np.eye(6)[None], stress, BENDING_LIMIT, 1e12).utilisation[0]
    return float(chord), plane


def table() -> str:
    head = ["Bending, MPa", "Torsion, MPa", "Phase, deg", *COLUMNS]
    lines = ["| " + " | ".join(head) + " |", "| --- " * len(head) + "|"]
    for test in NISHIHARA_KAWAMOTO:
        values = [f"{value:.3f}" for value in predicted(test)]
        stated = [f"{test.bending:g}", f"{test.torsion:g}", f"{test.phase:g}"]
        lines.append("| " + " | ".join(stated + values) + " |")
    return "\n".join(lines)


def ranges() -> str:
    """Return the limit that each criterion predicts over the measured one, in and out of phase."""
    lines = [
        "| Predicted limit over measured limit | Tests | " + " | ".join(COLUMNS) + " |",
        "| --- " * (len(COLUMNS) + 2) + "|",
    ]
    for words, phased in (("in phase", False), ("60° out of phase", True)):
        tests = [test for test in NISHIHARA_KAWAMOTO if (test.phase != 0.0) == phased]
        limits = 1.0 / np.array([predicted(test) for test in tests])
        cells = [f"{low:.3f} … {high:.3f}" for low, high in zip(*_ends(limits), strict=True)]
        lines.append("| " + " | ".join([words, str(len(tests)), *cells]) + " |")
    return "\n".join(lines)


def _ends(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return values.min(axis=0), values.max(axis=0)


def draw(path: Path) -> None:
    """One group of marks per test; the axis says that the tests' amplitudes are unconfirmed."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    settings = {"svg.hashsalt": "ballesta", "svg.fonttype": "none", "font.size": 9}
    with mpl.rc_context(settings):
        figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
        places = np.arange(len(NISHIHARA_KAWAMOTO))
        values = np.array([predicted(test) for test in NISHIHARA_KAWAMOTO])
        for number, (name, mark) in enumerate(zip(COLUMNS, "xo", strict=True)):
            shift = 0.12 * (number - 0.5)
            hollow = {} if mark == "x" else {"markerfacecolor": "none"}
            axes.plot(places + shift, values[:, number], mark, label=name, **hollow)
        axes.axhline(1.0, color="0.4", linewidth=0.8)
        labels = [f"{t.bending:g}/{t.torsion:g}\n{t.phase:g}°" for t in NISHIHARA_KAWAMOTO]
        axes.set_xticks(places, labels)
        axes.set_xlabel("bending/torsion, MPa, and phase; amplitudes unconfirmed")
        axes.set_ylabel("criterion over its limit where the\ntest failed (below 1: unsafe)")
        axes.legend(ncols=3, fontsize=8, loc="lower left")
        axes.set_ylim(0.82, 1.1)
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(figure)


if __name__ == "__main__":
    print(table(), ranges(), sep="\n\n")
    if "--write" in sys.argv[1:]:
        draw(PLOT)
