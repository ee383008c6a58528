"""The frame of a leaf pack."""

import numpy as np

from checks.columns.link_sections import bar_of
from checks.design.data import Part
from checks.models.beam_entries import planar_entry, pressed, slide_entry
from checks.models.beam_frames import extended, node_at, sites_along
from checks.models.beam_parts import PartFrame, Site
from fem.frame_fibres import Fibres, rectangle_fibres
from fem.sliding import stations
from geometry.mesh import Interface
from geometry.parts import LeafPack

_PIECES = 24  # of the longest stretch


def leaf_pack(part: Part, shape: LeafPack) -> PartFrame:
    """Equal leaves that slide on each other: as they bend alike, one bar of n times a leaf.

    Leaves that are tied along y everywhere have one deflection and so one curvature; none has an
    axial force but by friction on the outer faces, which the two outer leaves take halves of.
    """
    bar = bar_of(part)
    assert bar is not None
    clamp, rod = shape.clamp_length / 2, shape.rod_length / 2
    end = shape.length + shape.overhang
    contact = Interface(
        "contact",
        "slide",
        np.zeros(3),
        length=shape.width,
        travel=(-shape.contact_to, -shape.contact_from),
        patch=shape.contact_length / 2,
    )
    places = stations(contact)
    spacing = float(places[1] - places[0])
    hats = [places[0] - spacing, *places, places[-1] + spacing]
    spans = {"pivot": (-clamp, clamp), "rod": (shape.length - rod, shape.length + rod)}
    marks = [x for span in spans.values() for x in span]
    frame = extended(bar, -shape.arm, end).frame(_PIECES, [*hats, *marks, shape.length])
    entries = [
        planar_entry(
            Interface(name, "clamp", np.array([x, 0.0, 0.0]), length=shape.width),
            pressed(frame, [spans[name]], 0, x),
        )
        for name, x in (("pivot", 0.0), ("rod", shape.length))
    ]
    members = np.arange(len(frame.members))
    entries.append(slide_entry(frame, contact, (members, members)))
    fibres = _leaf_fibres(shape)

    def at(x: float) -> tuple[Fibres, str]:
        return fibres, "pivot" if abs(x) < clamp else "leaf"

    sites = [
        Site(site.member, site.at, site.fibres, site.name, _fretting(shape, site.name))
        for site in sites_along(frame, at)
    ]
    neglects = "pressure of the clamps and of the contact across the leaves, their shear"
    return PartFrame(frame, node_at(frame, 0.0), entries, sites, neglects)


def _fretting(shape: LeafPack, name: str) -> float:
    return shape.clamp_factor if name == "pivot" else 1.0


def _leaf_fibres(shape: LeafPack) -> Fibres:
    """Faces of the outer leaves: n leaves share the moment, the two outer ones the axial force."""
    one = rectangle_fibres(shape.thickness, shape.width)
    faces = one.chosen(one.places[:, 0] != 0)
    unit = faces.unit / shape.leaves
    unit[:, 0, 0] *= shape.leaves / min(shape.leaves, 2)
    beside = (shape.leaves - 1) / 2 * shape.thickness
    places = faces.places + np.sign(faces.places[:, :1]) * np.array([beside, 0.0])
    return Fibres(places, unit)
