"""Write docs/trade.md: what every rung costs and how far it is from a converged solid.

    python -m bench.trade_page   from bench/rungs/{truth,compared,verdicts}.jsonl and cost.json

`make trade` makes all of these, hours of solids included; they are kept, and resume.
"""

import json
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.rung_bands import Compared, ends_of
from bench.rung_truth import ACCURACY, LESS_ACCURATE, with_buckling
from bench.rung_variations import SCENES, SEED
from bench.swept import CAMPAIGNS, told
from checks.models.bands import known_band

HERE = Path(__file__).parent / "rungs"
DOCS = Path(__file__).parents[1] / "docs"
PAGE, PICTURE = DOCS / "trade.md", DOCS / "trade" / "pareto.svg"
RUNGS = ("formula",)
KINDS = ("static", "fatigue", "buckling")
MARGIN = 0.05  # of the limit: within it a verdict may stay open


def rows_of(name: str) -> list[dict[str, Any]]:
    """The lines of a file in bench/rungs."""
    return [json.loads(line) for line in (HERE / name).read_text().splitlines()]


def compared() -> list[Compared]:
    """Values of the rungs for every variation, beside the solid's."""
    return [Compared(**row) for row in rows_of("compared.jsonl")]


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    left = f"| {' | '.join(head)} |"
    line = f"| {' | '.join('---' if k == 0 else '---:' for k in range(len(head)))} |"
    return [left, line, *(f"| {' | '.join(row)} |" for row in rows), ""]


def machines_table(rows: Sequence[Compared]) -> list[str]:
    """Every part of the machines as it is: seconds and error of every rung."""
    truths = with_buckling()
    lines = []
    for scene in SCENES:
        own = [row for row in rows if row.variation == f"{scene.name}/0"]
        if not own:
            continue
        solid = truths[f"{scene.name}/0"]["seconds"]
        for kind in KINDS:
            found = {row.rung: row for row in own if row.kind == kind}
            if not found:
                continue
            truth = next(iter(found.values()))
            told = [
                f"{100 * (found[r].value / found[r].truth - 1):+.1f} % in {found[r].seconds:.2g} s"
                if r in found
                else "–"
                for r in RUNGS
            ]
            unit = "" if kind == "buckling" else " MPa"
            lines.append(
                [
                    scene.name,
                    kind,
                    f"{truth.truth:.4g}{unit} ± {100 * truth.bar / truth.truth:.1f} %",
                    *told,
                    f"{solid:.0f} s",
                ]
            )
    return _table(("Part", "Check", "Solid", *RUNGS, "Solid took"), lines)


def bands_table(rows: Sequence[Compared]) -> list[str]:
    """The calibrated bars and what they hold, by family."""
    groups: dict[tuple[str, str, str], list[Compared]] = defaultdict(list)
    for row in rows:
        groups[row.family, row.kind, row.rung].append(row)
    lines = []
    for (family, kind, rung), some in sorted(groups.items()):
        band = known_band(family, rung, kind)
        if band is None:
            continue
        ratios = np.array([row.ratio for row in some])
        left = np.array([row.left for row in some])
        inside = int(((left >= band.low) & (left <= band.high)).sum())
        lines.append(
            [
                family,
                kind,
                rung,
                str(len(some)),
                f"{np.median(ratios):.3f}",
                f"{ratios.min():.3f} to {ratios.max():.3f}",
                f"{100 * (band.low - 1):+.1f} to {100 * (band.high - 1):+.1f} %",
                f"{inside} of {len(some)}",
            ]
        )
    head = ("Family", "Check", "Rung", "n", "Median", "Solid / rung", "Bar", "Inside")
    return _table(head, lines)


def left_out(rows: Sequence[Compared]) -> dict[str, tuple[int, int]]:
    """Solids inside the band that all others of their family make, and all, by rung."""
    groups: dict[tuple[str, str, str], list[Compared]] = defaultdict(list)
    for row in rows:
        if known_band(row.family, row.rung, row.kind) is not None:
            groups[row.family, row.rung, row.kind].append(row)
    found = dict.fromkeys((*RUNGS, "all"), (0, 0))
    for (_, rung, _), some in groups.items():
        inside = 0
        for k, row in enumerate(some):
            low, high = ends_of(some[:k] + some[k + 1 :])
            inside += row.inside(low, high)
        for name in (rung, "all"):
            found[name] = found[name][0] + inside, found[name][1] + len(some)
    return found


def coverage(rows: Sequence[Compared]) -> dict[str, tuple[int, int, float, float]]:
    """Inside, all, median bar and median error (shares of the solid) by rung, and of all.

    A bar is to hold every arc of contact, so a check is inside where it is on all of them, and its
    error is the largest.
    """
    found = {}
    for rung in (*RUNGS, "all"):
        inside, bars, errors = 0, [], []
        for row in rows:
            band = known_band(row.family, row.rung, row.kind)
            if band is None or rung not in (row.rung, "all"):
                continue
            inside += row.inside(band.low, band.high)
            above, below = max(0.0, band.high - 1), max(0.0, 1 - band.low)
            bars.append(((above + below) * row.value + row.by_stress) / 2 / row.truth)
            errors.append(row.error)
        found[rung] = inside, len(bars), float(np.median(bars)), float(np.median(errors))
    return found


def verdicts() -> list[str]:
    """Verdicts of `auto` against the solid's, as lines of the page."""
    rows = rows_of("verdicts.jsonl")
    near = {row["variation"] for row in rows if row["drawn"] == "near"}
    all_of_them = {(row["variation"], row["drawn"]) for row in rows}
    opposite = {("pass", "FAIL"), ("FAIL", "pass")}
    flips = [row for row in rows if (row["solid with bars"], row["auto"]) in opposite]
    by_value = [row for row in rows if (row["solid"], row["auto"]) in opposite]
    far = [row for row in rows if abs(row["utilisation"] - 1) > MARGIN]
    left = [row for row in far if row["auto"] == "UNDECIDED"]
    by_bars = [row for row in left if row["solid with bars"] == "UNDECIDED"]
    meshed = {(r["variation"], r["drawn"]) for r in rows if "solid" in r["rungs"]}
    framed = [row for row in rows if row["method"] == "beam"]
    lines = [
        f"`auto` judged {len(all_of_them)} loadings of {len({r['variation'] for r in rows})} "
        f"variations, {len(near)} of them drawn within 15 % of the limit: {len(rows)} checks of "
        "yield, fatigue and elastic buckling.",
        "",
        f"- PASS against FAIL of the finest solid: **{len(flips)} of {len(rows)}**; of its value "
        f"alone, whatever its bars: {len(by_value)}.",
        f"- UNDECIDED where the solid is more than {100 * MARGIN:g} % from the limit: {len(left)} "
        f"of {len(far)} ({100 * len(left) / max(1, len(far)):.1f} %); in {len(by_bars)} of them "
        "the finest solid is UNDECIDED too, by what every model assumes (arc of contact).",
        f"- {len(meshed)} of {len(all_of_them)} loadings were meshed at all.",
        f"- {len(framed)} checks of buckling were settled by a beam frame when this was recorded, "
        "a rung that is gone: by the formula, whose bars are narrower now, all but one settle as "
        "their solids do; that one, a FAIL, is UNDECIDED, as a solid is now that it has the band "
        "of fixity, which the frame had not (`tests/validation/test_trade.py`).",
        "",
    ]
    for row in by_value:
        solid = (
            f"solid {row['utilisation']:.3f} of the limit, {row['solid with bars']} with its bars"
        )
        lines.append(
            f"  - {row['variation']} ({row['drawn']}), {row['kind']}: {solid}; auto {row['auto']} "
            f"by {row['method']}"
        )
    return lines


def cost() -> list[str]:
    """Cost of `auto` over the machines."""
    data = json.loads((HERE / "cost.json").read_text())
    rows = [
        [
            row["design"],
            f"{row['auto']:.1f} s",
            f"{row['solid']:.1f} s",
            f"{100 * row['auto'] / row['solid']:.0f} %",
            f"{row['auto loads']:.1f} s",
            "; ".join(f"{part}: {', '.join(tried)}" for part, tried in row["rungs"].items()),
        ]
        for row in data["rows"]
    ]
    share, busy = (100 * data[f"auto over solid{clock}"] for clock in ("", ", processor"))
    return [
        f"All four: **{share:.0f} %** of the time of solids in the same run by the clock, "
        f"{busy:.0f} % of the processor's time (asked for: at most 30 %), loads and reading "
        "included.",
        "",
        *_table(("Machine", "auto", "solid", "Share", "of it loads", "Rungs by part"), rows),
    ]


def draw(rows: Sequence[Compared]) -> None:
    """Seconds against true error of the fatigue stress, a point for each part of the machines."""
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "ballesta"
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(7.0, 4.2))
    stress = [row for row in rows if row.kind in ("static", "fatigue")]
    errors = [100 * max(abs(row.value / row.truth - 1), 1e-4) for row in stress]
    seconds = [row.seconds for row in stress]
    axes.scatter(seconds, errors, s=14, marker="o", label="formula", alpha=0.6)
    truths = with_buckling()
    solid = [
        (truths[row.variation]["seconds"], 100 * max(row.bar / row.truth, 1e-4)) for row in stress
    ]
    axes.scatter(*zip(*solid, strict=True), s=14, marker="D", label="solid (its bar)", alpha=0.6)
    axes.set(xscale="log", yscale="log", xlabel="s", ylabel="error of the stress, %")
    axes.grid(visible=True, alpha=0.3)
    axes.legend(frameon=False)
    figure.tight_layout()
    PICTURE.parent.mkdir(exist_ok=True)
    figure.savefig(PICTURE, metadata={"Date": None})
    plt.close(figure)


def swept() -> Iterable[str]:
    """Lines about solids on carried meshes, shape by shape."""
    for name, campaign in CAMPAIGNS.items():
        lines = told(HERE / f"swept_{name}.jsonl").splitlines()
        yield from (f"**{campaign.told}**", "", *(f"- {line}" for line in lines), "")


def page() -> str:
    """Return docs/trade.md."""
    rows = compared()
    held, unseen = coverage(rows), left_out(rows)
    count = len({row.variation for row in rows})
    lines = [
        "# The trade: time for accuracy",
        "",
        "Written by `python -m bench.trade_page` (`make trade` makes its data too).",
        "",
        "A part is checked by the cheapest model whose error bars leave its verdict alone:",
        "`formula` or `solid`. This page measures them on the parts of",
        f"the four machines under their own loads, and on variations of their dimensions ({count}",
        f"variations; Sobol, seed {SEED}; bounds in `bench/rung_variations.py`). Truth is a solid",
        f"refined to {100 * ACCURACY:g} % ({100 * LESS_ACCURATE:g} % for pins and beams).",
        "",
        "## The parts as they are",
        "",
        "Error of every rung against the solid, and the seconds it took beside the solid's, all on",
        "one machine of 2 cores with other work on it: compare columns, not decimals. A bar of",
        "± 30 % of buckling is from before meshes told their own, today a few per cent",
        "([why](theory/buckling.md#the-bar-of-the-mesh)).",
        "",
        *machines_table(rows),
        "![Seconds against error](trade/pareto.svg)",
        "",
        "## The bars",
        "",
        "A bar is where the next solid lies in 95 % of all cases if the logarithm of solid over",
        "rung scatters normally (prediction interval, `checks/models/bands.json`), and no less",
        "than holds 95 % of those compared. Inside is what lies so on the half circle and on the",
        "arcs where both are largest and least; the error is that of the arc where it is largest.",
        "*Left out* is the share inside bars that were made without the solid in question.",
        "Outside the proportions that were compared a rung has no bar, and `auto` climbs. It stops",
        "where 1.5 times the bars leave the verdict alone. Here pins press on the assumed arcs;",
        "where the file states none, every rung's bar reaches 7 % higher in bores: not in these",
        "tables.",
        "",
        *_table(
            ("Rung", "Inside the bars", "Share", "Left out", "Median bar", "Median error", "Ratio"),
            (
                [
                    rung,
                    f"{inside} of {total}",
                    f"{100 * inside / total:.1f} %",
                    f"{100 * unseen[rung][0] / unseen[rung][1]:.1f} %",
                    f"{100 * bar:.2f} %",
                    f"{100 * error:.2f} %",
                    f"{bar / error:.2f}",
                ]
                for rung, (inside, total, bar, error) in held.items()
            ),
        ),
        *bands_table(rows),
        "## Verdicts of `auto`",
        "",
        *verdicts(),
        "",
        "## Solids on carried meshes",
        "",
        "`ballesta batch --fidelity swept` ([batch.md](batch.md)) beside solids with meshes of",
        "their own, three of ten at corners between neighbours (`python -m bench.swept`).",
        "Processor time is one part's with other work on the machine: compare the two. A verdict",
        "is turned round if the ranges of both, each value with all of its bars, have nothing in",
        "common. Stress is compared. In a batch a part is carried over where its formula settles",
        "its buckling, or a bound does: all but the yoke.",
        "",
        *swept(),
        "| For | take |",
        "| --- | --- |",
        "| a first look at thousands of variations | `ballesta batch --fidelity formula` |",
        "| verdicts of tens of designs | `ballesta batch`, `auto` |",
        "| stress of hundreds of variations and more of the same parts | `--fidelity swept` |",
        "| the variation that is built | `ballesta check --fidelity solid` |",
        "",
        "## What `auto` costs",
        "",
        *cost(),
    ]
    return "\n".join(lines).rstrip() + "\n"


def main() -> None:
    """Write the page and its picture."""
    draw(compared())
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
