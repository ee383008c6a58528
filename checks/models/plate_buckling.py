"""Elastic buckling and deflection of a plate with pins, as a bar along its bores laid straight."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from checks.design.data import Part
from checks.handbook.bar_forces import deflection
from checks.handbook.lateral_buckling import column_force, lateral_share
from checks.models.formula_bars import HARDLY, PRESSED
from checks.models.formula_buckling import column_items
from checks.models.plate_forces import FlatSection, PlateForces
from checks.part.part_loads import first_largest
from checks.result.derivation import Item
from checks.stress.part_model import ElasticLoad
from geometry.bars import rectangle_torsion
from geometry.mesh import FloatArray

_STATIONS = 33
_IN_PLANE = "in plane: Euler's column along its bores, under the largest compression of its arms"
_SIDEWAYS = "out of plane: Euler's column and lateral buckling of the arms, laid straight"


def elastic_load(part: Part, forces: PlateForces) -> ElasticLoad | None:
    """Largest share of the elastic buckling load over the positions.

    The plate is a bar along the longest way from bore to bore, laid straight, hinged at both ends;
    what holds it at bores between is left out, and its largest compression acts all along it.
    """
    way = _along(forces)
    if way is None:
        return None
    length = way.length
    young, ratio = part.material.youngs_modulus, part.material.poisson_ratio
    flat, across = young * way.flat, young * way.across
    twisting = young / (2 * (1 + ratio)) * way.torsion
    force = (-(way.axial @ forces.acting)).max(axis=0)
    moments = way.moment @ forces.acting
    largest = forces.loads.largest_force
    pulled = bool(force.max() <= HARDLY * largest)
    force = np.maximum(force, 0.0)
    shares = {
        _IN_PLANE: force / column_force(flat, np.inf, way.pressed),
        _SIDEWAYS: lateral_share(
            force / column_force(across, np.inf, way.pressed), moments, across, twisting, length
        ),
    }
    words = max(shares, key=lambda name: float(shares[name].max()))
    share = np.maximum(shares[words], 0.0)
    (position,) = first_largest(share)
    pressed = float(force[position])
    explain: Callable[[], Sequence[Item]]
    if words == _IN_PLANE:
        explain = partial(column_items, pressed, flat, np.inf, way.pressed)
    else:
        bent = moments[:, [position]]
        alone = float(lateral_share(np.zeros(1), bent, across, twisting, length)[0])
        explain = partial(column_items, pressed, across, np.inf, way.pressed, alone)
    return ElasticLoad(float(share[position]), position, words, explain, pulled=pulled)


def deflected(part: Part, forces: PlateForces) -> float:
    """Largest displacement in the plane, mm: off the chord of the ends of the bores' way."""
    way = _along(forces)
    if way is None:
        return np.inf
    young = part.material.youngs_modulus
    places = np.linspace(0.0, way.length, _STATIONS)
    moments = way.moment @ forces.acting
    chosen = np.unique(np.abs(moments).argmax(axis=1))
    off = deflection(moments[:, chosen], young * way.flat, places)
    along = np.abs(way.axial @ forces.acting) / way.area[:, None] / young
    return float(max(np.abs(off).max(), along.mean(axis=0).max() * way.length))


@dataclass(frozen=True, eq=False)
class _Way:
    """The bar along the bores' longest way, at even places (k,).

    length          mm
    pressed         mm, between where the pins at both ends press as they push
    area            (k,) mm2
    flat, across    (k,) mm4, bending in the plane and out of it
    torsion         (k,) mm4, Saint-Venant's
    axial, moment   (k, columns) N and N mm per unit of what acts
    """

    length: float
    pressed: float
    area: FloatArray
    flat: FloatArray
    across: FloatArray
    torsion: FloatArray
    axial: FloatArray
    moment: FloatArray


def _along(forces: PlateForces) -> _Way | None:
    """The bar; None where the way leaves the plate."""
    shape = forces.shape
    way = [shape.bores[k] for k in shape.longest_way]
    corners = np.array([bore.centre for bore in way])
    reached = np.r_[0.0, np.cumsum(np.abs(np.diff(corners)))]
    rows = []
    for place in np.linspace(0.0, reached[-1], _STATIONS):
        k = int(np.clip(np.searchsorted(reached, place) - 1, 0, len(way) - 2))
        low, high, arm = way[k], way[k + 1], float(reached[k + 1] - reached[k])
        along = complex(corners[k + 1] - corners[k]) / arm
        inside = np.clip(place - reached[k], low.diameter / 2, arm - high.diameter / 2)
        cut = shape.outline.cut(low.centre + along * float(inside), along)
        if cut is None:
            return None
        section = FlatSection(cut, shape.thickness).filled()
        ahead = {shape.bores[n].name: 1.0 for n in shape.beyond(low, high)}
        axial, _, moment = forces.across(section, ahead)
        height = cut.ends[1] - cut.ends[0]
        torsion = float(rectangle_torsion(height, shape.thickness)[0])
        across = height * shape.thickness**3 / 12
        rows.append((section.area, section.inertia, across, torsion, axial, moment))
    columns = (np.array(column) for column in zip(*rows, strict=True))
    length = float(reached[-1])
    pressed = length - PRESSED * (way[0].diameter + way[-1].diameter) / 2
    return _Way(length, pressed, *columns)
