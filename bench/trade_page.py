"""Write docs/trade.md: what every rung costs and how far it is from a converged solid.

    python -m bench.trade_page   from bench/rungs/*.jsonl

`make trade` makes all of these, hours of solids included; they are kept, and resume.
"""

import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench import auto_cost, contact_truth
from bench.rung_bands import Compared, ends_of
from bench.rung_truth import ACCURACY, LESS_ACCURATE, with_buckling
from bench.rung_variations import SCENES, SEED
from bench.swept import CAMPAIGNS, told
from bench.swept import Compared as Pair
from checks.handbook.fits import DEFAULT
from checks.models.bands import known_band

HERE = Path(__file__).parent / "rungs"
DOCS = Path(__file__).parents[1] / "docs"
PAGE, PICTURE = DOCS / "trade.md", DOCS / "trade" / "pareto.svg"
LIMITED = PICTURE.with_name("within.svg")
RUNGS = ("formula",)
STRESSES = ("static", "fatigue")
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


def key_of(check: Mapping[str, Any]) -> tuple[str, str, str]:
    """Part, kind and quantity of a check, whichever criterion of fatigue decides it."""
    return check["part"], check["kind"], re.sub(r"^\w+ (?=amplitude)", "", check["quantity"])


@dataclass(frozen=True)
class Best:
    """The best verdict that is known of a check: by contact to 2 %, else by `--fidelity solid`."""

    status: str
    utilisation: float

    def turned(self, status: str) -> bool:
        """True if a verdict is PASS where this is FAIL, or the other way round."""
        return {status, self.status} == {"pass", "FAIL"}

    def exceeded(self, status: str) -> bool:
        """True if a verdict is PASS though the value alone is above its limit."""
        return status == "pass" and self.utilisation > 1


def best_of(name: str) -> dict[tuple[str, str, str], Best]:
    """The best verdicts of a machine, by check."""
    machines = auto_cost.known()
    found = {
        key_of(check): Best(check["status"], check["utilisation"])
        for asked in ("auto", "solid")
        for check in machines[name, asked]["checks"]
    }
    for row in contacts():
        machine, _, part = row["part"].rpartition("/")
        if machine != name:
            continue
        for key in [key for key in found if key[0] == part]:
            known = row["checks"]["truth"].get(key[1])
            if known is not None and key[2].startswith(("peak", "amplitude")):
                found[key] = Best(known["status"], known["utilisation"])
    return found


@dataclass(frozen=True)
class Decided:
    """Checks of all machines by one way of asking.

    machines  that have a verdict; late: those of which nothing was finished
    wrong     PASS against FAIL, or the other way round; exceeded: PASS against the value alone
    stresses  static and fatigue among them, and how many of these are decided
    """

    machines: int
    late: int
    checks: int
    decided: int
    stresses: int
    stresses_decided: int
    wrong: int
    exceeded: int
    seconds: Sequence[float]
    processor: Sequence[float]


def decided(asked: str) -> Decided:
    """Count the verdicts of all machines by one way of asking."""
    known, counts = auto_cost.known(), Counter[str]()
    seconds, processor = [], []
    for name in auto_cost.MACHINES:
        row, best = known[name, asked], best_of(name)
        seconds.append(row["seconds"])
        processor.append(row["processor"])
        status = {key_of(check): check["status"] for check in row.get("checks", ())}
        settled = [status.get(key) in ("pass", "FAIL") for key in best]
        counts["machines"] += all(settled) or "FAIL" in status.values()
        counts["late"] += not status
        counts["checks"] += len(best)
        counts["decided"] += sum(settled)
        for key, one in zip(best, settled, strict=True):
            counts["stresses"] += key[1] in STRESSES
            counts["stresses_decided"] += key[1] in STRESSES and one
            counts["wrong"] += best[key].turned(status.get(key, ""))
            counts["exceeded"] += best[key].exceeded(status.get(key, ""))
    return Decided(
        **{name: counts[name] for name in _COUNTED}, seconds=seconds, processor=processor
    )


_COUNTED = ("machines", "late", "checks", "decided", "stresses", "stresses_decided", "wrong",
            "exceeded")  # fmt: skip


def limits() -> list[str]:
    """Verdicts within time limits, and without."""
    count = len(auto_cost.MACHINES)
    rows = []
    for asked in auto_cost.ASKED:
        one = decided(asked)
        rows.append(
            [
                _COMMANDS[asked],
                f"{np.median(one.seconds):.1f} s, {max(one.seconds):.1f} s",
                f"{one.machines} of {count}",
                str(one.late),
                f"{one.decided} of {one.checks}",
                f"{one.stresses_decided} of {one.stresses}",
                str(one.wrong),
                str(one.exceeded),
            ]
        )
    head = ("Command", "Median, longest", "Machines decided", "Nothing finished",
            "Checks decided", "of stress", "Wrong", "PASS above the limit")  # fmt: skip
    return _table(head, rows)


_COMMANDS = {
    asked: " ".join(("`check", *options)) + "`" for asked, options in auto_cost.ASKED.items()
}


def cost() -> list[str]:
    """Cost of `auto` over the machines."""
    known = auto_cost.known()
    pairs = {name: (known[name, "auto"], known[name, "solid"]) for name in auto_cost.MACHINES}
    shares = [
        f"{100 * _share(pairs, names, clock):.0f} %"
        for names in (auto_cost.FOUR, auto_cost.MACHINES)
        for clock in ("seconds", "processor")
    ]
    rows = [
        [
            name,
            f"{auto['seconds']:.1f} s",
            f"{solid['seconds']:.1f} s",
            f"{100 * auto['processor'] / solid['processor']:.0f} %",
            f"{auto['loads']:.1f} s",
            *(f"{_settled(row)} of {len(row['checks'])}" for row in (auto, solid)),
            "; ".join(f"{part}: {', '.join(tried)}" for part, tried in auto["rungs"].items()),
        ]
        for name, (auto, solid) in pairs.items()
    ]
    head = ("Machine", "auto", "solid", "Share", "of it loads", "auto decides", "solid decides",
            "Rungs by part")  # fmt: skip
    return [
        f"All {len(pairs)} machines: **{shares[2]}** of the time of solids by the clock,",
        f"{shares[3]} of the processor's time; the first four: {shares[0]} and {shares[1]} (at",
        "most 30 % was asked for). Whole commands with report and suggestions, which take both",
        "alike. The table's share is one of processor time.",
        "",
        *_table(head, rows),
    ]


def _settled(row: Mapping[str, Any]) -> int:
    return sum(check["status"] != "UNDECIDED" for check in row["checks"])


def _share(
    pairs: Mapping[str, tuple[Mapping[str, Any], Mapping[str, Any]]],
    names: Iterable[str],
    clock: str,
) -> float:
    auto, solid = (sum(pairs[name][k][clock] for name in names) for k in (0, 1))
    return float(auto / solid)


def contacts() -> list[dict[str, Any]]:
    """Parts whose contact was solved to 2 %."""
    return [row for row in rows_of("contact.jsonl") if "truth" in row.get("checks", {})]


def told_contacts() -> list[str]:
    """Models of parts whose pins' arcs are not stated, beside contact to 2 %."""
    rows, models = contacts(), []
    finer = [row for row in rows if row["unknowns"]["contact"] != row["unknowns"]["truth"]]
    for name, title in _MODELS.items():
        some = [row for row in rows if name in row["checks"]]
        if name == "contact":
            some = finer
        pairs = [
            (check, row["checks"]["truth"][kind])
            for row in some
            for kind, check in row["checks"][name].items()
        ]
        errors = [abs(check["value"] / truth["value"] - 1) for check, truth in pairs]
        barred = [pair for pair in pairs if None not in pair[0].values()]
        inside = sum(c["lower"] <= t["value"] <= c["upper"] for c, t in barred)
        bars = [(c["upper"] - c["lower"]) / 2 / t["value"] for c, t in barred]
        turned = sum({c["status"], t["status"]} == {"pass", "FAIL"} for c, t in pairs)
        seconds = [row["seconds"][name] for row in some]
        models.append(
            [
                title,
                f"{len(some)}",
                f"{np.median(seconds):.2g} s, {max(seconds):.2g} s",
                f"{100 * np.median(errors):.1f} %, {100 * max(errors):.1f} %",
                f"{inside} of {len(barred)}",
                f"{100 * np.median(bars):.1f} %",
                f"{sum(c['status'] != 'UNDECIDED' for c, _ in pairs)} of {len(pairs)}",
                str(turned),
            ]
        )
    parts = [
        [
            row["part"],
            kind,
            f"{truth['value']:.4g} MPa ± {100 * truth['numerical'] / truth['value']:.1f} %",
            *(
                f"{100 * (row['checks'][name][kind]['value'] / truth['value'] - 1):+.1f} % in "
                f"{row['seconds'][name]:.2g} s"
                if name in row["checks"]
                else "–"
                for name in ("formula", "arcs", "contact")
            ),
            f"{row['seconds']['truth']:.0f} s",
        ]
        for row in rows
        for kind, truth in row["checks"]["truth"].items()
    ]
    truths = [truth for row in rows for truth in row["checks"]["truth"].values()]
    names = list(_MODELS.values())
    known = {row["part"] for row in rows}
    floats = [row["part"] for row in rows_of("contact.jsonl") if "left out" in row]
    every = (f"{m}/{part}" for m in auto_cost.MACHINES for part in contact_truth.pinned(m))
    rest = [part for part in every if part not in known and part not in floats]
    return [
        *_table(
            ("Model", "Parts", "Seconds, median and most", "Error, median and most", "Inside bars",
             "Median bar", "Decided", "Turned round"),
            models,
        ),
        *_table(("Part", "Check", "Contact, finest", *names[:3], "Finest took"), parts),
        f"Of {len(rows) - len(finer)} parts the meshes for 5 % do for 2 %: contact's row is of the",
        f"other {len(finer)}. What no mesh takes away of a loose pin stays in its bar: "
        f"{sum(_exact(truth) for truth in truths)} of {len(truths)} checks have 2 %.",
        "",
        *_missed(rows),
        "",
        f"Without contact, as a pin there never presses or edges are sharp: {', '.join(floats)}.",
        f"Not measured, as time was short: {', '.join(rest)}.",
        "",
    ]  # fmt: skip


def _exact(truth: Mapping[str, Any]) -> bool:
    return bool(truth["numerical"] <= contact_truth.ACCURACY * truth["value"])


def _missed(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """Checks whose finest contact lies above the bars of a formula or of assumed arcs, as lines.

    A pin as loose as H7/f7 leaves it is in both.
    """
    found = []
    for row in rows:
        for kind, truth in row["checks"]["truth"].items():
            ends = [row["checks"][name][kind]["upper"] for name in ("formula", "arcs")]
            if any(end is not None and end < truth["value"] for end in ends):
                by_formula, by_arcs = (f"{end:.3g}" if end else "none" for end in ends)
                found.append(
                    f"- {row['part']}, {kind}: {truth['value']:.3g} MPa, "
                    f"{truth['utilisation']:.2f} of its limit, upper ends "
                    f"{by_formula} and {by_arcs} MPa"
                )
    if not found:
        return ["All values lie below the upper ends of the bars of formulas and of assumed arcs."]
    return ["Above the bars of a formula or of assumed arcs:", "", *found]


_MODELS = {
    "formula": "formula",
    "arcs": "solid, assumed arcs",
    "contact": "solid, contact solved",
}


def _busy() -> float:
    """Share of a processor that commands with a time limit had."""
    rows = [row for (_, asked), row in auto_cost.known().items() if asked.startswith("within")]
    return float(sum(row["processor"] for row in rows) / sum(row["seconds"] for row in rows))


def draw_limits() -> None:
    """Share of the checks decided against the time limit."""
    figure, axes = _figure()
    at = [*auto_cost.LIMITS, float(np.max(decided("auto").seconds))]
    found = [decided(asked) for asked in (*(f"within {one} s" for one in auto_cost.LIMITS), "auto")]
    for label, marker, shares in (
        ("checks", "o", [one.decided / one.checks for one in found]),
        ("checks of stress", "s", [one.stresses_decided / one.stresses for one in found]),
        ("machines", "D", [one.machines / len(auto_cost.MACHINES) for one in found]),
        ("checks that are wrong", "x", [one.wrong / one.checks for one in found]),
    ):
        axes.plot(at, [100 * share for share in shares], marker=marker, label=label)
    axes.set(xscale="log", xlabel="time limit, s; last the longest of `auto` without one")
    axes.set(ylabel="decided, %", ylim=(-3, 103))
    _save(figure, axes, LIMITED)


def _figure() -> tuple[Any, Any]:
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "ballesta"
    from matplotlib import pyplot as plt

    return plt.subplots(figsize=(7.0, 4.2))


def _save(figure: Any, axes: Any, file: Path) -> None:
    from matplotlib import pyplot as plt

    axes.grid(visible=True, alpha=0.3)
    axes.legend(frameon=False)
    figure.tight_layout()
    file.parent.mkdir(exist_ok=True)
    figure.savefig(file, metadata={"Date": None})
    plt.close(figure)


def draw(rows: Sequence[Compared]) -> None:
    """Seconds against true error of the fatigue stress, a point for each part of the machines."""
    figure, axes = _figure()
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
    _save(figure, axes, PICTURE)


def swept() -> Iterable[str]:
    """Lines about solids on carried meshes, shape by shape."""
    for name, campaign in CAMPAIGNS.items():
        lines = told(HERE / f"swept_{name}.jsonl").splitlines()
        yield from (f"**{campaign.told}**", "", *(f"- {line}" for line in lines), "")


def choice(rows: Sequence[Compared]) -> list[str]:
    """The model to take for a purpose, its cost and what it decides, from all records."""
    known = {asked: decided(asked) for asked in auto_cost.ASKED}
    inside, total, _, error = coverage(rows)["formula"]
    fitted = [
        abs(check["value"] / row["checks"]["truth"][kind]["value"] - 1)
        for row in contacts()
        for kind, check in row["checks"]["formula"].items()
    ]
    carried = [row for name in CAMPAIGNS for row in rows_of(f"swept_{name}.jsonl")]
    solved = [row for row in carried if "checks" in row]
    pairs = [Pair(**one) for row in solved for one in row["checks"].values()]
    within = sum(pair.missed <= 1 for pair in pairs)
    off = np.median([abs(pair.swept[0] / pair.full[0] - 1) for pair in pairs])
    truths = contacts()
    bars = [
        check["numerical"] / check["value"]
        for row in truths
        for check in row["checks"]["contact"].values()
    ]
    short = [
        row["checks"]["truth"][kind]["value"] / check["value"]
        for row in truths
        for kind, check in row["checks"]["arcs"].items()
    ]

    def of(asked: str) -> list[str]:
        one = known[asked]
        shown = f"{one.decided} of {one.checks} checks, {one.wrong} wrong"
        return [f"{np.median(one.seconds):.0f} s a machine", shown]

    table = [
        [
            "a first look at thousands of variations",
            "`ballesta batch --fidelity formula`",
            f"{np.median([row.seconds for row in rows]):.2g} s a part",
            f"median error {100 * error:.1f} %, {100 * np.median(fitted):.0f} % with pins of "
            f"{DEFAULT}; {100 * inside / total:.0f} % inside its bars",
        ],
        [
            "an answer at once",
            "`ballesta check --within 10s`",
            *of("within 10 s"),
        ],
        [
            "verdicts of tens of designs",
            "`ballesta check`, `ballesta batch`: `auto`",
            *of("auto"),
        ],
        [
            "stress of hundreds of variations and more of the same parts",
            "`ballesta batch --fidelity swept`",
            f"{np.median([row['seconds'] for row in solved]):.2g} s a part",
            f"median error {100 * off:.1f} %; {within} of {len(pairs)} inside its bars; "
            f"{len(solved)} of {len(carried)} carried over",
        ],
        [
            "a verdict that hangs on where pins press",
            "`fits` stated, `--fidelity solid`",
            f"{np.median([row['seconds']['contact'] for row in truths]):.2g} s a part",
            f"median numerical bar {100 * np.median(bars):.1f} %; assumed arcs: up to "
            f"{max(short):.1f} times too low",
        ],
        [
            "the variation that is built",
            "`ballesta check --fidelity solid`",
            *of("solid"),
        ],
    ]
    return _table(("For", "take", "Seconds, median", "Accuracy, or what it decides"), table)


def page() -> str:
    """Return docs/trade.md."""
    rows = compared()
    held, unseen = coverage(rows), left_out(rows)
    count = len({row.variation for row in rows})
    known = auto_cost.known()
    spent = [known[name, "auto"]["loads"] for name in auto_cost.MACHINES]
    least, most = min(spent), max(spent)
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
        "## Contact solved",
        "",
        f"Parts whose design states neither fit nor arc, {len(contacts())} of the machines as",
        f"they are, beside contact on meshes for {100 * contact_truth.ACCURACY:g} %, at the middle",
        f"of all clearances up to {DEFAULT} (`python -m bench.contact_truth`). Seconds are",
        "of a processor, contact's with those on assumed arcs before it. Inside are values of the",
        "finest contact within a model's bars, loads known. Solids are refined to 5 % here,",
        "whatever the verdict; `auto` solves contact only where arcs leave a verdict open.",
        "",
        *told_contacts(),
        "## What `auto` costs",
        "",
        *cost(),
        "## Within a time limit",
        "",
        "All machines, each command on its own beside other work: the processor was theirs for",
        f"{100 * _busy():.0f} % of the time, so a quiet machine decides more. Loads alone take",
        f"{least:.1f} to {most:.1f} s. Wrong is PASS where the best",
        "that is known says FAIL, or the other way round: contact of the table above, else",
        "`--fidelity solid`, bars included. The last column is of its value alone, bars left out.",
        "A check that was not reached counts as not decided. Without a limit `check` seeks single",
        "changes besides.",
        "",
        *limits(),
        "![Verdicts decided against the time limit](trade/within.svg)",
        "",
        "## What to take",
        "",
        *choice(rows),
    ]
    return "\n".join(lines).rstrip() + "\n"


def main() -> None:
    """Write the page and its picture."""
    draw(compared())
    draw_limits()
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
