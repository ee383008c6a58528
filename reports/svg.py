"""Charts as SVG text that follows the page's colours and is the same on every run.

Lengths are points, from the upper left corner of a drawing.
"""

from collections.abc import Callable, Mapping, Sequence
from hashlib import sha256
from html import escape
from math import ceil, floor, log10
from typing import Any

import numpy as np
import numpy.typing as npt

from checks.result.words import clean
from geometry.mesh import FloatArray

Ticks = Sequence[tuple[float, str]]

# name: (light, dark). Series colours are those of Okabe and Ito (jfly, 2008), told apart with every
# kind of colour blindness; on dark ground the dim ones are lightened.
COLOURS = {
    "ink": ("#22262b", "#dfe3e8"),
    "faint": ("#c9ced6", "#474e58"),
    "ground": ("#ffffff", "#171a1f"),
    "pass": ("#2f8f6b", "#3fb68b"),
    "fail": ("#c8452c", "#f0745a"),
    "undecided": ("#c98a00", "#e6b13c"),
    "series0": ("#0072b2", "#56a8e0"),
    "series1": ("#d55e00", "#f08a3c"),
    "series2": ("#008f6b", "#2fc79b"),
    "series3": ("#b4568f", "#dd8fbd"),
    "series4": ("#3d93c9", "#8ccaf0"),
    "series5": ("#b58900", "#e0b84a"),
    "series6": ("#5b5f66", "#a4abb5"),
}


def colour(name: str) -> str:
    """A colour of the page's style sheet; the light one where there is none."""
    return f"var(--chart-{name},{COLOURS[name][0]})"


SERIES = [colour(name) for name in COLOURS if name.startswith("series")]
INK = colour("ink")
_DASHES = {"-": "", "--": "3.7 1.6", ":": "1 1.65", "-.": "6.4 1.6 1 1.6"}  # in widths of the line
_STYLE = f"stroke-linejoin:round;font-family:var(--font,sans-serif);font-size:10px;fill:{INK}"
_INSIDE = 0.5  # by which a line may reach beyond its frame and need no clipping
_LETTER = 0.56  # of the font's size
_MARK = "\0"  # stands for what makes an id one of this drawing; no text holds it
# Outlines for a size of 1, y downwards; those of strokes are not closed.
_OUTLINES = {
    "s": ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)),
    "D": ((0.0, -0.7), (0.7, 0.0), (0.0, 0.7), (-0.7, 0.0)),
    "^": ((0.0, -0.5), (0.5, 0.5), (-0.5, 0.5)),
    "v": ((0.0, 0.5), (0.5, -0.5), (-0.5, -0.5)),
    "<": ((-0.5, 0.0), (0.5, -0.5), (0.5, 0.5)),
    ">": ((0.5, 0.0), (-0.5, -0.5), (-0.5, 0.5)),
    "P": (
        (-0.2, -0.5), (0.2, -0.5), (0.2, -0.2), (0.5, -0.2), (0.5, 0.2), (0.2, 0.2),
        (0.2, 0.5), (-0.2, 0.5), (-0.2, 0.2), (-0.5, 0.2), (-0.5, -0.2), (-0.2, -0.2),
    ),
}  # fmt: skip
_STROKES = {
    "_": ((-0.5, 0.0), (0.5, 0.0)),
    "|": ((0.0, -0.5), (0.0, 0.5)),
    "x": ((-0.5, -0.5), (0.5, 0.5), (np.nan, np.nan), (-0.5, 0.5), (0.5, -0.5)),
}


def colour_variables(dark: bool) -> str:
    """Colours as declarations for a style sheet."""
    return " ".join(f"--chart-{name}: {pair[dark]};" for name, pair in COLOURS.items())


def draw(
    plot: Callable[["Drawing"], Mapping[str, str] | None], size: tuple[float, float], label: str
) -> str:
    """SVG element of what `plot` draws, which may return further attributes of the element."""
    drawing = Drawing(*size)
    return drawing.svg(label, plot(drawing))


class Drawing:
    """A picture under way, of frames and of texts outside of them."""

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self._frames: list[Frame] = []
        self._texts: list[str] = []

    def frame(self, box: tuple[float, float, float, float], *ends: Any, **options: Any) -> "Frame":
        """Axes in a box: left, top, width, height; see `Frame`."""
        made = Frame(box, *ends, **options)
        self._frames.append(made)
        return made

    def text(self, x: float, y: float, text: str, **style: Any) -> None:
        """Write a text on a line; see `_text`."""
        self._texts.append(_text(x, y, text, **style))

    def svg(self, label: str, attributes: Mapping[str, str] | None = None) -> str:
        """The element, with its name for who cannot see it, and further attributes."""
        framed = [part for frame in self._frames for part in frame.drawn()]
        inside = "".join([*framed, *self._texts])
        mark = "c" + sha256(f"{label}{inside}{attributes}".encode()).hexdigest()[:8]
        whole = {
            "viewBox": f"0 0 {_short(self.width)} {_short(self.height)}", "role": "img",
            "aria-label": clean(label), **(attributes or {}), "style": _STYLE,
        }  # fmt: skip
        if self._frames:
            whole["data-frames"] = ";".join(frame.scales for frame in self._frames)
        told = " ".join(f'{key}="{escape(value)}"' for key, value in whole.items())
        return f'<svg xmlns="http://www.w3.org/2000/svg" {told}>{inside.replace(_MARK, mark)}</svg>'


class Frame:
    """Axes: what is drawn in them, a grid, numbers on the left and below.

    box          left, top, width, height in the drawing
    across, up   what the axes run over
    logarithmic  "x", "y" or "xy"
    grid         which axes have lines across the frame at their numbers
    """

    def __init__(
        self,
        box: tuple[float, float, float, float],
        across: tuple[float, float],
        up: tuple[float, float],
        *,
        logarithmic: str = "",
        grid: str = "xy",
    ) -> None:
        self.box, self.across, self.up = box, across, up
        self._logarithmic, self._grid = logarithmic, grid
        self.x_ticks: Ticks | None = None  # None for round numbers
        self.y_ticks: Ticks | None = None
        self.inside: list[str] = []
        self._areas: list[str] = []
        self._texts: list[str] = []

    @property
    def scales(self) -> str:
        """Box, both axes' ends and the logarithmic axes, for a script that reads values off."""
        numbers = (*self.box, *self.across, *self.up)
        return " ".join([*(f"{number:.5g}" for number in numbers), self._logarithmic or "-"])

    def places(self, points: npt.ArrayLike) -> FloatArray:
        """Where points (k, 2) are in the drawing."""
        given = np.asarray(points, dtype=float).reshape(-1, 2)
        left, top, width, height = self.box
        x = self._share(given[:, 0], self.across, "x")
        y = self._share(given[:, 1], self.up, "y")
        return np.stack([left + width * x, top + height * (1 - y)], axis=1)

    def _share(self, values: FloatArray, ends: tuple[float, float], axis: str) -> FloatArray:
        low, high = ends
        if axis in self._logarithmic:
            values = np.log10(np.maximum(values, 1e-300))
            low, high = log10(low), log10(high)
        return np.asarray((values - low) / (high - low))

    def line(
        self,
        points: npt.ArrayLike,
        *,
        color: str,
        linewidth: float = 1.6,
        linestyle: str | tuple[float, Sequence[float]] = "-",
        marker: str = "",
        markersize: float = 6.0,
        markerfacecolor: str = "",
        markeredgewidth: float = 1.0,
    ) -> None:
        """Draw a polyline (k, 2), and a mark at each of its points if one is named."""
        given = np.asarray(points, dtype=float).reshape(-1, 2)
        if not len(given):
            return
        places = self.places(given)
        clip = self._clip(places)
        if linestyle and len(places) > 1:
            style = f"fill:none;stroke:{color};stroke-width:{linewidth:g}"
            dashes = _dashes(linestyle)
            if dashes:
                gaps = " ".join(_short(linewidth * float(part)) for part in dashes.split())
                style += f";stroke-dasharray:{gaps}"
            self.inside.append(f'<path d="{_path(places)}" style="{style}"{clip}/>')
        if marker:
            filling = "none" if marker in _STROKES else markerfacecolor or color
            style = f"fill:{filling};stroke:{color}"
            size = markersize / 2 if marker == "." else markersize
            way = "".join(_mark(marker, x, y, size) for x, y in places)
            style += f";stroke-width:{markeredgewidth:g}"
            self.inside.append(f'<path d="{way}" style="{style}"{clip}/>')

    def dots(self, points: npt.ArrayLike, color: str, size: float) -> None:
        """Many round dots (k, 2), as one path."""
        places = self.places(points)
        way = "".join(f"M{_short(x)} {_short(y)}h0" for x, y in places)
        style = f"fill:none;stroke:{color};stroke-width:{size:g};stroke-linecap:round"
        self.inside.append(f'<path d="{way}" style="{style}"{self._clip(places)}/>')

    def area(
        self, across: tuple[float, float], up: tuple[float, float], color: str, opacity: float
    ) -> None:
        """Fill a rectangle below all lines."""
        (x0, y1), (x1, y0) = self.places([[across[0], up[0]], [across[1], up[1]]])
        box = f"M{_short(x0)} {_short(y0)}H{_short(x1)}V{_short(y1)}H{_short(x0)}z"
        clip = self._clip(np.array([[x0, y0], [x1, y1]]))
        self._areas.append(f'<path d="{box}" style="fill:{color};opacity:{opacity:g}"{clip}/>')

    def text(self, x: float, y: float, text: str, **style: Any) -> None:
        """Write a text centred at a place of the drawing, above all lines."""
        size = style.get("size", 10.0)
        self._texts.append(_text(x, y + 0.36 * size, text, **style))

    def drawn(self) -> list[str]:
        """Elements, from below to above."""
        left, top, width, height = self.box
        bottom = top + height
        numbers, grid = [], ""
        for value, told in self.x_ticks if self.x_ticks is not None else self._round("x"):
            x = self.places([[value, self.up[0]]])[0, 0]
            if left - _INSIDE <= x <= left + width + _INSIDE:
                numbers.append(_text(x, bottom + 13.0, told))
                grid += f"M{_short(x)} {_short(bottom)}V{_short(top)}" * ("x" in self._grid)
        for value, told in self.y_ticks if self.y_ticks is not None else self._round("y"):
            y = self.places([[self.across[0], value]])[0, 1]
            if top - _INSIDE <= y <= bottom + _INSIDE:
                numbers.append(_text(left - 4.0, y + 3.6, told, anchor="end"))
                grid += f"M{_short(left)} {_short(y)}H{_short(left + width)}" * ("y" in self._grid)
        lines = f'<path d="{grid}" style="fill:none;stroke:{colour("faint")};stroke-width:.6"/>'
        edges = f"M{_short(left)} {_short(top)}V{_short(bottom)}H{_short(left + width)}"
        edge = f'<path d="{edges}" style="fill:none;stroke:{INK};stroke-width:.8"/>'
        inside = [*self._areas, *self.inside]
        if any("clip-path" in element for element in inside):
            box = " ".join(
                f'{key}="{_short(value)}"'
                for key, value in zip(("x", "y", "width", "height"), self.box, strict=True)
            )
            inside.insert(0, f'<clipPath id="{self._own}"><rect {box}/></clipPath>')
        return [lines * bool(grid), *numbers, *inside, edge, *self._texts]

    @property
    def _own(self) -> str:
        return _MARK + "".join(f"-{part:.0f}" for part in self.box[:2])

    def _clip(self, places: FloatArray) -> str:
        """An attribute where some places are beyond the frame."""
        low = np.array(self.box[:2])
        past = low + self.box[2:] + _INSIDE
        inside = (places >= low - _INSIDE) & (places <= past)
        return "" if inside.all() else f' clip-path="url(#{self._own})"'

    def _round(self, axis: str) -> Ticks:
        """Round numbers of an axis: about five, or powers of ten."""
        low, high = self.across if axis == "x" else self.up
        if axis in self._logarithmic:
            tens = range(ceil(log10(low) - 1e-9), floor(log10(high) + 1e-9) + 1)
            return [(10.0**k, f"{10.0**k:g}") for k in tens]
        return round_ticks(low, high)


def round_ticks(low: float, high: float, most: int = 5) -> list[tuple[float, str]]:
    """Round numbers over a range, and their texts, with a true minus.

    >>> round_ticks(-0.4, 0.4, 4)
    [(-0.4, '−0.4'), (-0.2, '−0.2'), (0.0, '0.0'), (0.2, '0.2'), (0.4, '0.4')]
    """
    values = round_steps(low, high, most)
    step = (high - low) / most if len(values) < 2 else values[1] - values[0]
    digits = max(0, -floor(log10(step) + 1e-9))
    digits += abs(round(step, digits) - step) > 1e-9 * step
    return [(value, f"{value + 0.0:.{digits}f}".replace("-", "−")) for value in values]


def round_steps(low: float, high: float, most: int) -> list[float]:
    """At most so many round numbers, or one more, that cover a range evenly.

    >>> round_steps(2.0, 200.0, 4)
    [50.0, 100.0, 150.0, 200.0]
    """
    rough = (high - low) / max(most, 1)
    power = 10.0 ** np.floor(np.log10(rough))
    step = float(power * next(k for k in (1.0, 2.0, 2.5, 5.0, 10.0) if k * power >= rough * 0.999))
    first = int(np.ceil(low / step - 1e-9))
    last = int(np.floor(high / step + 1e-9))
    return [k * step for k in range(first, last + 1)]


def _text(
    x: float,
    y: float,
    text: str,
    *,
    size: float = 10.0,
    color: str = INK,
    anchor: str = "middle",
    weight: str = "",
    slant: str = "",
) -> str:
    """A text whose baseline runs through a place; anchor is "start", "middle" or "end"."""
    style = f"text-anchor:{anchor}" * (anchor != "start")
    for key, value in (
        ("font-size", f"{size:g}px" * (size != 10.0)), ("fill", color * (color != INK)),
        ("font-weight", weight), ("font-style", slant),
    ):  # fmt: skip
        style += f";{key}:{value}" * bool(value)
    told = f' style="{style.removeprefix(";")}"' * bool(style)
    return f'<text x="{_short(x)}" y="{_short(y)}"{told}>{escape(clean(text), quote=False)}</text>'


def _dashes(style: str | tuple[float, Sequence[float]]) -> str:
    return _DASHES[style] if isinstance(style, str) else " ".join(f"{d:g}" for d in style[1])


def _path(places: FloatArray) -> str:
    """A polyline (k, 2) as a path, to a hundredth of a point; places that are none part it."""
    way, letter, last = "", "M", ""
    for x, y in places:
        if not (np.isfinite(x) and np.isfinite(y)):
            letter, last = "M", ""
            continue
        text = f"{_short(x)} {_short(y)}"
        if text != last:
            way += letter + text
            letter, last = ("L" if letter == "M" else " "), text
    return way


def _mark(marker: str, x: float, y: float, size: float) -> str:
    """A mark as a path around a place."""
    if marker in "o.":
        radius, wide = _short(size / 2), _short(size)
        arc = f"a{radius} {radius} 0 1 0 "
        return f"M{_short(x - size / 2)} {_short(y)}{arc}{wide} 0{arc}-{wide} 0z"
    shape = _STROKES.get(marker) or _OUTLINES[marker]
    return _path(size * np.array(shape) + (x, y)) + "z" * (marker in _OUTLINES)


def _short(value: float) -> str:
    return f"{round(value, 2) + 0.0:.2f}".rstrip("0").rstrip(".")
