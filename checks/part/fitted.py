"""Arcs on which pins may press, from stated fits, for models that do not solve the contact.

With p = E* dR t/F of the largest clearance and force, cosine pressures on arcs from
129 deg/sqrt(p) to the half circle hold the stress of frictionless contact; below p = 1.2 those from
120 deg do, or lie above it. Where the arc comes out below 90 deg, the band of an arc that is not
stated holds it: 90 deg, and a share more in bores (docs/validation.md, Pins in holes).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf, radians, sqrt

from checks.design.data import Part
from checks.part.part_loads import PartLoads
from geometry.mesh import Interface

_ARC, _WIDEST, _COMPARED = radians(129), radians(120), radians(90)


def with_fits(
    part: Part, loads: PartLoads, interfaces: Sequence[Interface], pins: Mapping[str, Part]
) -> Part:
    """Return the part with the narrowest arc of contact of all its bores, by their stated fits.

    pins  point -> the part that is the pin of its joint; where there is none, the pin is of the
          part's own material

    A bore without a stated fit keeps the part's arc.
    """
    if not part.clearances:
        return part
    arcs, known = [], True
    for face in interfaces:
        if face.kind != "bore":
            continue
        if face.name not in part.clearances:
            arcs.append(part.bearing_arc)
            known = known and part.arc_stated
            continue
        pin = pins.get(part.interfaces[face.name])
        arc = _WIDEST
        if p := _parameter(part, pin or part, face, loads):
            arc = min(_ARC / sqrt(p), _WIDEST)
        known = known and arc >= _COMPARED
        arcs.append(max(arc, _COMPARED))
    return replace(part, bearing_arc=min(arcs), arc_stated=known)


def _parameter(part: Part, pin: Part, face: Interface, loads: PartLoads) -> float:
    """E* dR t/F under the largest force, in plane strain."""
    clearance = part.clearances[face.name][1]
    if not clearance:
        return 0.0
    materials = part.material, pin.material
    softness = sum((1 - m.poisson_ratio**2) / m.youngs_modulus for m in materials)
    force = float(loads.resultant(face.name).max())
    return clearance / 2 / softness * face.length / force if force else inf
