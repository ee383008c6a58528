"""Matplotlib figures as SVG text that follows the page's colours and is the same on every run."""

import re
import warnings
from collections.abc import Callable, Mapping
from io import StringIO
from typing import Any, Literal

from checks.result.words import clean
from reports.svg_compact import compact

# name: (what matplotlib is told, light, dark). The first is only a mark, swapped for a variable
# of the page's style sheet. Series colours are those of Okabe and Ito (jfly, 2008), told apart
# with every kind of colour blindness; on dark ground the dim ones are lightened.
COLOURS = {
    "ink": ("#0a0b01", "#22262b", "#dfe3e8"),
    "faint": ("#0a0b02", "#c9ced6", "#474e58"),
    "ground": ("#0a0b03", "#ffffff", "#171a1f"),
    "pass": ("#0a0b04", "#2f8f6b", "#3fb68b"),
    "fail": ("#0a0b05", "#c8452c", "#f0745a"),
    "undecided": ("#0a0b06", "#c98a00", "#e6b13c"),
    "series0": ("#0a0b10", "#0072b2", "#56a8e0"),
    "series1": ("#0a0b11", "#d55e00", "#f08a3c"),
    "series2": ("#0a0b12", "#008f6b", "#2fc79b"),
    "series3": ("#0a0b13", "#b4568f", "#dd8fbd"),
    "series4": ("#0a0b14", "#3d93c9", "#8ccaf0"),
    "series5": ("#0a0b15", "#b58900", "#e0b84a"),
    "series6": ("#0a0b16", "#5b5f66", "#a4abb5"),
}
SERIES = [mark for name, (mark, _, _) in COLOURS.items() if name.startswith("series")]


def colour(name: str) -> str:
    """Mark that stands for a colour of the page while a figure is drawn."""
    return COLOURS[name][0]


def colour_variables(dark: bool) -> str:
    """Colours as declarations for a style sheet."""
    return " ".join(f"--chart-{name}: {pair[1 + dark]};" for name, pair in COLOURS.items())


_FAMILY = "var(--font,sans-serif)"
_STYLE = {
    "svg.fonttype": "none",  # text stays text: it can be searched, and the page's font draws it
    "svg.hashsalt": "ballesta",
    "text.parse_math": False,  # a $ in a name is a $
    "font.size": 10,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "butt",
    "axes.facecolor": "none",
    "figure.facecolor": "none",
    "grid.color": colour("faint"),
    **dict.fromkeys(
        ["text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"],
        colour("ink"),
    ),
}


Marks = Mapping[str, Mapping[str, str]]
Plot = Callable[[Any], Callable[[], Marks] | None]


def draw(
    plot: Plot,
    size: tuple[float, float],
    label: str,
    layout: Literal["constrained"] | None = "constrained",
) -> str:
    """SVG element of what `plot` draws on the figure it is given; `size` in inches.

    plot    may return what to call when all is laid out: it tells attributes by the gid of an
            artist, or "" of the whole drawing; places come from `place`
    layout  of matplotlib; None for axes that stand where they were put
    """
    import matplotlib.style
    from matplotlib.figure import Figure

    out = StringIO()
    with warnings.catch_warnings(), matplotlib.style.context(["default", _STYLE]):
        # The browser draws the letters, so what matplotlib's own font lacks is not missing.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        figure = Figure(figsize=size, layout=layout)
        marks = plot(figure)
        figure.savefig(out, format="svg", metadata={"Date": None})
        named = marks() if marks else {}
    return _adapted(out.getvalue(), label, named)


def place(axes: Any, x: float, y: float) -> tuple[float, float]:
    """Where a point of some axes is in the drawing, in units of its view box."""
    figure = axes.figure
    scale = 72.0 / figure.dpi
    across, up = axes.transData.transform((x, y)) * scale
    return float(across), float(figure.get_figheight() * 72.0 - up)


def _adapted(text: str, label: str, named: Marks) -> str:
    """Bare element with the page's colours and font, and ids that no other chart has."""
    text = text[text.index("<svg") :]
    text = re.sub(r"font: ([^;\"]*?)([\d.]+px) [^;\"]*", _font_of, text)
    text = re.sub(r"font-family: [^;\"]*", f"font-family: {_FAMILY}", text)
    whole = {"role": "img", "aria-label": clean(label), **named.get("", {})}
    common = {"font-family": _FAMILY, "font-size": "10px", "fill": colour("ink")}
    text = compact(text, {**named, "": whole}, common)
    for name, (mark, light, _) in COLOURS.items():
        text = text.replace(mark, f"var(--chart-{name},{light})")
    return text


def _font_of(found: re.Match[str]) -> str:
    """A font in short form, with the page's family."""
    weight = "font-weight: bold; " if "bold" in found[1] or "700" in found[1] else ""
    slant = "font-style: italic; " if "italic" in found[1] else ""
    return f"{weight}{slant}font-size: {found[2]}; font-family: {_FAMILY}"
