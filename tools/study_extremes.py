"""Sweep parts and solvers to their extremes; write docs/extremes.md and its plots.

    python tools/study_extremes.py            # some four minutes, and 5 GiB for the largest solve

The studies themselves stand in tests/validation/extremes, where tests hold the conclusions.
"""

import argparse
import importlib
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
PAGE, PICTURES = ROOT / "docs" / "extremes.md", ROOT / "docs" / "extremes"
EXPECTED = [1e-16, 1.0]  # of a relative error on a plot
GIBIBYTE = 2.0**30


def study(name: str) -> Any:
    """One of the modules with studies."""
    return importlib.import_module(f"tests.validation.extremes.{name}")


HEAD = """# Extremes

Written by `python tools/study_extremes.py`; the studies stand in `tests/validation/extremes`, and
`test_extremes.py` there holds what is concluded. Errors are relative. "Round-off" is what
lies below 1e-10. From the design file to the verdict: [extremes_chain.md](extremes_chain.md).

| What | Range | What holds | Where it warns or refuses |
| --- | --- | --- | --- |
| [Poisson's ratio](#poissons-ratio) | 0 to 0.4999 | displacement and von Mises stress, to the \
mesh's error | above 0.45 the validity check `compressible material` breaks: direct stresses are \
inexact; \
0.5 and more, -1 and less: refused |
| [Slenderness](#slenderness) L/h | 1 to 1000 | frames to 1e-9; solids lose digits as (L/h)^4: \
2e-8 at 100, 2e-4 at 1000 | the validity check `support reactions` breaks from about 200 |
| [Wall thickness](#thin-walls) over the radius | 1 to 1/10000 | hoop stress to 0.25 % with \
elements up to 2000 times as long as thick | a body of more than a million elements is refused |
| [Stretched elements](#stretched-elements) | 1 to 1000 | an even stress to round-off | |
| [Hole](#holes) over width | 0.01 to 0.99 | published concentration to 0.3 %, from 3 to 2 | |
| [Ligaments](#ligaments) | 1 mm to nothing | meshed down to a hundredth of the hole and less | a \
rim of no thickness is refused with its place or its likely cause |
| [Size of loads](#invariance) | 18 decades | stress and safety to round-off | |
| [Units](#invariance) | mm or m | to 1e-12 | |
| [Place](#invariance) from the origin | 1 to 1e7 sizes | to 1e-14 of the distance over the size | \
more than 1e7 sizes: refused |
| [Rounding](#invariance) of coordinates | 1e-9 to 1e-3 mm | stress to the step over 1 mm | |
| [Memory](#memory) | 27 000 to 540 000 unknowns | told to 30 % | more than there is: refused \
before it is meshed, and again before it is solved |

Every run measures its own validity besides: the smallest scaled det J of its elements (a folded one
is refused), mesh against CAD volume (1e-3), resultants of unit loads before they are normalised
(1e-3), loads on the mesh and support reactions (1e-6), the backward error of the solves (1e-12).
An element's aspect ratio is not limited: see stretched elements.
"""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """A table, its lines."""
    marks = ["---"] * len(head)
    return [f"| {' | '.join(row)} |" for row in (head, marks, *rows)] + [""]


def size(value: float) -> str:
    """A relative error, in words that do not change with the last bits."""
    if abs(value) < 1e-10:
        return "round-off"
    if abs(value) < 1e-3:
        return f"{value:.0e}"
    return f"{100 * value:.2g} %" if abs(value) < 1 else f"{100 * value:.0f} %"


def poisson() -> list[str]:
    """Errors of a pressed cylinder by Poisson's ratio."""
    module = study("incompressible")
    lines = [
        "## Poisson's ratio",
        "",
        "Thick cylinder, radii 3 and 9, 1 MPa inside, plane strain, against Lamé. Largest errors "
        "at the surface: displacement of the bore, direct stresses (around and along) and von "
        "Mises stress over their largest values. Quadratic tetrahedra do not lock; what grows is "
        "the mean stress, first on free meshes. The scatter of the elements, by which an error bar "
        "sees its mesh, does not see it.",
        "",
    ]
    curves = {}
    for name, mesh in (module.mapped_meshes() | module.free_meshes()).items():
        found = {nu: module.errors(mesh, nu) for nu in module.RATIOS}
        if len(mesh.nodes) > 1000:
            lines += [f"{name[0].upper()}{name[1:]}, {len(mesh.nodes)} nodes:", ""]
            rows = [[f"{nu:g}", *map(size, errors)] for nu, errors in found.items()]
            lines += table(["nu", "displacement", "direct", "von Mises", "scatter"], rows)
        curves[name] = {nu: (e.direct, e.von_mises) for nu, e in found.items()}
    draw_poisson(curves, PICTURES / "poisson.svg")
    return [*lines, "![errors by Poisson's ratio](extremes/poisson.svg)", ""]


def slender() -> list[str]:
    """Frames and solids from stocky to a thousand times as long as high."""
    module = study("slender")
    rows, points = [], {}
    for ratio in module.RATIOS:
        frame, bent = module.framed(ratio), module.bent(ratio)
        tip = module.cantilever(ratio, max(8, ratio // 25))
        rows.append(
            [
                f"{ratio}",
                size(frame.error),
                size(bent.stress),
                size(bent.gate),
                f"{tip.aspect:.2g}",
                size(tip.error),
            ]
        )
        points[ratio] = (abs(frame.error), bent.stress, bent.gate, abs(tip.error))
    draw_slender(points, PICTURES / "slender.svg")
    return [
        "## Slenderness",
        "",
        "Square bars 10 mm high. A frame against Timoshenko's tip deflection; a solid bar under "
        "two couples, whose field its elements hold, so that round-off is all that is left; the "
        "largest support reaction of a bar that is clamped and pushed across its tip, over the "
        "force, as the validity check measures it (limit 1e-6); the tip of a solid cantilever of 2 "
        "bricks over its height, against the exact field. The condition of the matrix grows like "
        "(L/h)^4, so a bar of 1000 keeps 4 digits of its stress. The aim of 1e-8 for the balance "
        "is met to L/h = 30 and nearly at 100; beyond 200 the validity check breaks and the "
        "result stays undecided.",
        "",
        *table(
            [
                "L/h",
                "frame",
                "solid: stress",
                "solid: reaction",
                "longest side over height of a brick",
                "tip deflection",
            ],
            rows,
        ),
        "![errors by slenderness](extremes/slender.svg)",
        "",
    ]


def walls() -> list[str]:
    """Thin cylinders and stretched elements."""
    module = study("thin")
    rows = []
    for ratio in module.WALLS:
        found = module.walls(ratio)
        rows.append([f"{ratio:g}", f"{found.aspect:.4g}", *map(size, found[:1] + found[2:])])
    stretched = [
        [f"{aspect}", *(size(module.stretched_patch(aspect, axis)) for axis in range(3))]
        for aspect in module.ASPECTS
    ]
    return [
        "## Thin walls",
        "",
        "A quarter of a cylinder of radius 100 mm with 16 elements around it and two through its "
        "wall (eight where it is as thick as its radius) under inner pressure; hoop stress at the "
        "bore against Lamé. `apart` is the bore's displacement in the plane model against the "
        "axisymmetric one.",
        "",
        *table(
            ["wall / radius", "longest / shortest side", "solid", "plane", "axisymmetric", "apart"],
            rows,
        ),
        "## Stretched elements",
        "",
        "The patch of MacNeal and Harder, stretched along an axis, under an even stress.",
        "",
        *table(["stretched", "along x", "along y", "along z"], stretched),
    ]


def holes() -> list[str]:
    """Holes in strips and links, and ligaments down to nothing."""
    module = study("holes")
    rows = []
    for ratio in sorted((*module.RATIOS, *module.OUTER)):
        value, published = module.strip(ratio), module.PUBLISHED.get(ratio)
        told = [f"{published:.4f}", size(value / published - 1)] if published else ["", ""]
        link = module.link(ratio) if ratio in module.RATIOS else None
        own = [f"{link.peak:.3g}", f"{link.quality:.1f}"] if link else ["", ""]
        rows.append([f"{ratio:g}", f"{value:.3f}", *told, *own])
    thin = []
    for gap in module.LIGAMENTS:
        between, beside = (
            "meshed" if isinstance(said, float) else f"refused: {said}"
            for said, _ in (module.between_holes(gap), module.beside_a_hole(gap))
        )
        thin.append([f"{gap:g}", between, beside])
    return [
        "## Holes",
        "",
        "Peak over net stress of a pulled strip (plane stress), where known against the "
        "published value; and of a plate link 24 mm wide and 8 mm thick on its pins: largest von "
        "Mises stress over net stress on the mesh of fineness 0.6, and smallest scaled det J.",
        "",
        *table(["hole / width", "strip", "published", "error", "link", "scaled det J"], rows),
        "## Ligaments",
        "",
        "A link whose holes of 12 mm are so far apart, and one with a rim so thick beside its "
        "hole: whether it is meshed, or what is said. A thin ligament takes a minute to mesh, and "
        "from 0.001 mm on its worst scaled det J is between 0 and 0.3, another in each run.",
        "",
        *table(["mm", "between holes", "beside a hole"], thin),
        "From CAD: a hole tangent to an edge or 1e-7 mm from it, one that runs into a pin's hole, "
        "crossing faces, several solids, no solid and missing holes are refused with their place; "
        "holes of 12 mm that are 0.01 mm apart are meshed with the ridges they leave "
        "(`tests/ballesta/test_parts_at_the_extremes.py`, `tests/geometry/test_step_file.py`).",
        "",
    ]


def invariance() -> list[str]:
    """Loads of any size, other units, turned, far away, rounded and renumbered."""
    module = study("invariance")
    loads = [max(map(abs, module.load_scale(factor))) for factor in module.LOADS]
    metres = module.in_metres()
    rows = [
        ["loads times 1e-9 to 1e9: stress, peak, Goodman utilisation", size(max(loads))],
        ["in m, N, Pa and kg: stress, strain energy, utilisation", size(max(map(abs, metres)))],
        ["turned by 37, 90, 123 deg about (1, 2, 3)", size(max(map(module.turned, (37, 90, 123))))],
        ["nodes and elements shuffled", size(module.renumbered())],
    ]
    rows += [[f"{away:g} sizes from the origin", size(module.moved(away))] for away in module.AWAY]
    for step in module.ROUNDED:
        stress, peak = module.rounded(step)
        rows.append(
            [f"coordinates rounded to {step:g} mm: stress, peak", f"{size(stress)}, {size(peak)}"]
        )
    return [
        "## Invariance",
        "",
        *table(["What changes", "Deviation"], rows),
        "The same part gives the same mesh to the last bit, but for curved elements that gmsh has "
        "to mend, as at the link's hole of a tenth of its width: there nodes repeat to 0.001 mm "
        "and the peak to 1e-6.",
        "",
    ]


def memory() -> list[str]:
    """Memory of solves, predicted and measured."""
    module = study("memory")
    rows = []
    for counts in (*module.SMALL, *module.LARGE):
        found = module.measured(counts)
        rows.append(
            [
                " x ".join(map(str, counts)),
                f"{found.unknowns}",
                f"{found.compactness:.2f}",
                f"{found.predicted / GIBIBYTE:.2f}",
                f"{found.measured / GIBIBYTE:.2f}",
                f"{found.predicted / found.measured:.2f}",
            ]
        )
    return [
        "## Memory",
        "",
        "Blocks of cubic bricks with 10 unit loads, CHOLMOD, each solved in a process of its own; "
        "GiB at the peak above what was taken before the solve (`geometry/memory.py`). It does not "
        "count the mesher's own memory, nor that of a cycle's stresses.",
        "",
        *table(["bricks", "unknowns", "compactness", "predicted", "measured", "ratio"], rows),
    ]


def page() -> str:
    """The text of docs/extremes.md."""
    parts = (poisson(), slender(), walls(), holes(), invariance(), memory())
    return "\n".join([HEAD, *(line for part in parts for line in part)]).rstrip() + "\n"


def draw_poisson(curves: dict[str, dict[float, tuple[float, float]]], path: Path) -> None:
    """Errors over the distance from 0.5, mesh by mesh."""

    def plot(axes: Any) -> None:
        for k, (name, found) in enumerate(curves.items()):
            left = [0.5 - nu for nu in found]
            direct, mises = zip(*found.values(), strict=True)
            axes.loglog(left, direct, "o-", color=f"C{k}", label=name, markersize=3)
            axes.loglog(left, mises, ":", color=f"C{k}")
        axes.axvline(0.05, color="#888888", lw=0.8)
        axes.invert_xaxis()
        axes.set_xlabel("0.5 less Poisson's ratio; the line is where the validity check breaks")
        axes.set_ylabel("largest error: direct (line), von Mises (dots)")

    draw(plot, path)


def draw_slender(points: dict[int, tuple[float, ...]], path: Path) -> None:
    """Errors over L/h."""

    def plot(axes: Any) -> None:
        names = (
            "frame, tip",
            "solid, stress",
            "solid, support reaction",
            "solid, tip on 8 to 40 bricks",
        )
        for k, name in enumerate(names):
            found = [max(point[k], 1e-16) for point in points.values()]
            axes.loglog(list(points), found, "o-", label=name, markersize=3)
        axes.axhline(1e-6, color="#888888", lw=0.8)
        axes.set_ylim(*EXPECTED)
        axes.set_xlabel("length over height; the line is the limit of the support reactions")
        axes.set_ylabel("relative error")

    draw(plot, path)


def draw(plot: Any, path: Path) -> None:
    """Write a plot as SVG; the same numbers give the same file."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot as plt

    with mpl.rc_context({"svg.hashsalt": "ballesta", "svg.fonttype": "none", "font.size": 9}):
        figure, axes = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
        plot(axes)
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, fontsize=8)
        path.parent.mkdir(exist_ok=True)
        figure.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(figure)
    text = path.read_text(encoding="utf-8")
    path.write_text("\n".join(line.rstrip() for line in text.splitlines()) + "\n", "utf-8")


def main() -> int:
    """Write the page and its plots."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
