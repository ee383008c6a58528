"""Matplotlib figures as SVG text that follows the page's colours and is the same on every run."""

import re
import warnings
from collections.abc import Callable
from html import escape
from io import StringIO
from typing import Any

from reports.words import clean

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
    "axes.facecolor": "none",
    "figure.facecolor": "none",
    "grid.color": colour("faint"),
    **dict.fromkeys(
        ["text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"],
        colour("ink"),
    ),
}


def draw(plot: Callable[[Any], None], size: tuple[float, float], label: str) -> str:
    """SVG element of what `plot` draws on the figure it is given; `size` in inches."""
    import matplotlib.style
    from matplotlib.figure import Figure

    out = StringIO()
    with warnings.catch_warnings(), matplotlib.style.context(["default", _STYLE]):
        # The browser draws the letters, so what matplotlib's own font lacks is not missing.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        figure = Figure(figsize=size, layout="constrained")
        plot(figure)
        figure.savefig(out, format="svg", metadata={"Date": None})
    return _adapted(out.getvalue(), label)


def _adapted(text: str, label: str) -> str:
    """Bare element with the page's colours and font, and ids that no other chart has."""
    text = text[text.index("<svg") :]
    text = re.sub(r"\s*<metadata>.*?</metadata>", "", text, count=1, flags=re.DOTALL)
    text = re.sub(r"(font: [^;\"]*?[\d.]+px) [^;\"]*", r"\1 var(--font, sans-serif)", text)
    text = re.sub(r"font-family: [^;\"]*", "font-family: var(--font, sans-serif)", text)
    for name, (mark, light, _) in COLOURS.items():
        text = text.replace(mark, f"var(--chart-{name}, {light})")
    prefix = re.sub(r"[^a-z0-9]+", "-", clean(label).lower())[:40].strip("-")
    text = re.sub(r'(\bid="|url\(#|href="#)', rf"\g<1>{prefix}-", text)
    return text.replace("<svg", f'<svg role="img" aria-label="{escape(clean(label))}"', 1).strip()
