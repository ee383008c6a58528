"""The frame of a pin: a stepped round bar along z, pressed by its lugs."""

from itertools import pairwise

import numpy as np

from checks.design.data import Part
from checks.handbook.notch_factors import stepped_shaft
from checks.handbook.pin_stress import cylinder_stress
from checks.models.beam_entries import BEARING, journal_entry, pressed
from checks.models.beam_frames import elastic
from checks.models.beam_parts import Entry, PartFrame, Site
from fem.frame import Frame, gauss_points
from fem.frame_fibres import Fibres, round_fibres
from fem.frame_joints import chain
from fem.frame_sections import round_tube
from geometry.mesh import FloatArray, Interface
from geometry.parts import Pin, Seat

_LUG_PIECES = 4  # of a lug's width
_COUNT = 24  # fibres around
_UP = np.array([0.0, 1.0, 0.0])


def pin(part: Part, shape: Pin) -> PartFrame | None:
    """A stepped round bar along z; every lug presses evenly over its width, as on the solid.

    None for a sharp step, where the elastic stress has no bound.
    """
    if not shape.step_fillet and any(
        (seat.diameter or shape.diameter) < shape.diameter for seat in shape.seats
    ):
        return None
    low, high = shape.ends
    seated = shape.seated()
    marks = {low, high}
    for _, lower, upper in seated:
        marks |= set(np.linspace(lower, upper, _LUG_PIECES + 1).tolist())
    for seat, lower, upper in seated:
        if (seat.diameter or shape.diameter) < shape.diameter and shape.step_fillet:
            marks |= {lower - shape.step_fillet, upper + shape.step_fillet}
    stretches = _merged(sorted(marks), 1e-9 * shape.diameter)
    nodes = np.zeros((len(stretches), 3))
    nodes[:, 2] = stretches
    members = chain(len(nodes))
    z = gauss_points(nodes, members)[..., 2]
    frame = Frame(nodes, members, _UP, round_tube(pin_diameter(shape, z)), elastic(part))
    tilts = any(seat.single for seat in shape.seats)
    entries: list[Entry] = []
    for seat in shape.seats:
        centre = seat.at if seat.single else 0.0
        interface = Interface(
            seat.name,
            "journal",
            np.array([0.0, 0.0, centre]),
            (seat.diameter or shape.diameter) / 2,
            seat.width * len(seat.places),
            tilts=tilts,
        )
        spans = [(place - seat.width / 2, place + seat.width / 2) for place in seat.places]
        entries.append(journal_entry(interface, pressed(frame, spans, 2, centre)))

    neglects = "that lugs press more at their edges, that a short pin is no slender bar"
    return PartFrame(frame, 0, entries, _sites(part, shape, frame), neglects)


def _sites(part: Part, shape: Pin, frame: Frame) -> list[Site]:
    """Both ends of every member but those that stand free beyond the last lug."""
    seated, found = shape.seated(), []
    nu = part.material.poisson_ratio
    for number, (start, end) in enumerate(frame.nodes[frame.members][:, :, 2]):
        middle = (start + end) / 2
        if not seated[0][1] < middle < seated[-1][2]:
            continue
        own = next((one for one in seated if one[1] < middle < one[2]), None)
        for at, place in ((0.0, float(start)), (1.0, float(end))):
            inside = place + 1e-6 * (middle - place)
            diameter = float(pin_diameter(shape, np.array(inside)))
            fibres = round_fibres(diameter, poisson_ratio=nu, count=_COUNT)
            if own is None:
                found.append(Site(number, at, fibres, "between lugs"))
                continue
            seat, lower, upper = own
            if diameter < shape.diameter and min(place - lower, upper - place) < 1e-6 * seat.width:
                sizes = shape.diameter, diameter, shape.step_fillet
                factors = [
                    stepped_shaft(kind, *sizes) for kind in ("tension", "bending", "torsion")
                ]
                fibres = fibres.notched(*factors)
            pressure = _pressure(shape, seat, place, fibres)
            found.append(Site(number, at, fibres, seat.name, pressed=seat.name, pressure=pressure))
    return found


def _pressure(shape: Pin, seat: Seat, place: float, fibres: Fibres) -> FloatArray:
    """Stress (f, 6, columns) of a lug's own pressure: half a cosine, and growing along z.

    Where the lug ends the pressure jumps; a section's stress there is the mean of both sides.
    The fibres stand at local y = y and z = -x (fem/frame.py, members along z).
    """
    angles = np.arctan2(fibres.places[:, 0], -fibres.places[:, 1])
    radius = (seat.diameter or shape.diameter) / 2
    length = seat.width * len(seat.places)
    ends = np.array([[z - seat.width / 2, z + seat.width / 2] for z in seat.places])
    share = 0.5 if np.abs(place - ends).min() < 1e-6 * seat.width else 1.0
    even = share / (np.pi * radius * length)
    centre = seat.at if seat.single else 0.0
    second = sum(seat.width**3 / 12 + seat.width * (z - centre) ** 2 for z in seat.places)
    grown = share * (place - centre) / second / (np.pi * radius)
    waves = []
    for name in BEARING[:-1]:
        wave, n = name.split()
        waves.append(even * (np.cos if wave == "cos" else np.sin)(int(n) * angles))
    none = np.zeros(len(angles))
    waves += [none, grown * np.sin(angles), -grown * np.cos(angles)]
    stress = [cylinder_stress(angles, pressure, none, none) for pressure in waves]
    return np.stack(stress, axis=2)


def pin_diameter(shape: Pin, z: FloatArray) -> FloatArray:
    """Diameter of a pin at places along it, its fillets included."""
    result = np.full(np.shape(z), float(shape.diameter))
    fillet = shape.step_fillet
    for seat, lower, upper in shape.seated():
        neck = seat.diameter or shape.diameter
        beside = np.maximum(np.maximum(lower - z, z - upper), 0.0)
        rounded = neck + 2 * (fillet - np.sqrt(np.maximum(fillet**2 - beside**2, 0.0)))
        own = np.where(beside <= fillet, rounded, shape.diameter)
        result = np.minimum(result, own)
    return result


def _merged(places: list[float], least: float) -> list[float]:
    """Places without those that stand closer than `least` to the one before."""
    kept = [places[0]]
    for before, place in pairwise(places):
        if place - before > least:
            kept.append(place)
    return kept
