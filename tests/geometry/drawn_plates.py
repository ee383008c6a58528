"""Drawings of plates that tests make themselves."""

from pathlib import Path

import ezdxf


def drawing(file: Path, units: int = 4, **layers: dict):
    """A new DXF document, its model space, and how it is saved."""
    document = ezdxf.new("R2010", units=units)
    for name, values in layers.items():
        document.layers.add(name, **values)
    space = document.modelspace()

    def saved() -> Path:
        document.saveas(file)
        return file

    return document, space, saved


def stadium_with_holes(file: Path, *, scale: float = 1.0, units: int = 4) -> Path:
    """A flat link of 100 mm between two bores of 12 and 16 mm, 40 mm wide, as a bulged polyline."""
    _, space, saved = drawing(file, units)
    corners = [(0, -20, 0), (100, -20, 1), (100, 20, 0), (0, 20, 1)]
    space.add_lwpolyline(
        [(x / scale, y / scale, b) for x, y, b in corners], format="xyb", close=True
    )
    space.add_circle((0, 0), 6 / scale)
    space.add_circle((100 / scale, 0), 8 / scale)
    return saved()
