"""Reads the coordinates that a design file names, such as A.y or cylinder.length."""

from collections.abc import Mapping

import loads
from checks.design.errors import Problems, listed, nearest, no_such
from checks.design.model import DesignFile


def coordinate_of(
    key: str,
    text: str,
    file: DesignFile,
    forces: Mapping[str, loads.Force],
    problems: Problems,
) -> loads.Coordinate | None:
    """Return the coordinate that a text names, None where a problem was told."""
    name, _, what = text.rpartition(".")
    pins = dict.fromkeys(pin for body in file.bodies.values() for pin in body.pins)
    pulling = [force for force, entry in file.forces.items() if entry.between is not None]
    kinds = {
        "x": ("point on a body", list(pins)),
        "y": ("point on a body", list(pins)),
        "angle": ("body", list(file.bodies)),
        "length": ("force between two points", pulling),
    }
    if what not in kinds or not name:
        guess = nearest(what, kinds) if name else None
        hint = f", did you mean {name}.{guess}?" if guess else ""
        problems.add(
            key,
            "must be <point>.x, <point>.y, <body>.angle or <force>.length, "
            f'got "{text}"{hint}; points {listed(pins)}; bodies {listed(file.bodies)}; '
            f"forces {listed(pulling)}",
        )
        return None
    kind, known = kinds[what]
    if name not in known:
        problems.add(key, no_such(kind, name, known))
        return None
    if what == "length":
        return forces[name].coordinate if name in forces else None
    if what == "angle":
        return loads.Angle(name)
    owner = next(body for body, entry in file.bodies.items() if name in entry.pins)
    return loads.PointCoordinate(owner, name, (1.0, 0.0) if what == "x" else (0.0, 1.0))


def dimension_along(coordinate: loads.Coordinate) -> str:
    """Dimension of a coordinate's values: "angle" or "length"."""
    return "angle" if coordinate.angular else "length"
