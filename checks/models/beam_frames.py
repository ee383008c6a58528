"""The frames of links that are one straight bar."""

from collections.abc import Callable, Sequence

import numpy as np

from checks.columns.link_sections import Bar, bar_of
from checks.design.data import Part
from checks.handbook.lugs import ball_ligament
from checks.handbook.notch_factors import stepped_shaft
from checks.models.beam_bores import EyeLug, StripLug, bore_patch
from checks.models.beam_entries import at_node, bore_entry, planar_entry, tilting
from checks.models.beam_parts import Entry, PartFrame, Patch, Site
from checks.models.beam_sections import (
    bore_places,
    bored,
    chord,
    outer_radius,
    rod_sections,
    shank_end,
)
from fem.frame import Frame
from fem.frame_fibres import Fibres, rectangle_fibres, round_fibres, square_tube_fibres
from fem.frame_sections import Sections, rectangle
from fem.unit_solutions import Elastic
from geometry.mesh import FloatArray, Interface
from geometry.parts import PlateLink, PrismaticTube, TubeRod
from geometry.sections import square_tube_section

_PIECES = 12  # of the longest stretch
At = Callable[[float], tuple[Fibres, str] | None]


def elastic(part: Part) -> Elastic:
    """The part's material as the frame takes it."""
    steel = part.material
    return Elastic(steel.youngs_modulus, steel.poisson_ratio, steel.density)


def extended(bar: Bar, start: float, stop: float) -> Bar:
    """A bar that goes on beyond the axes of its pins, its sections as beside them."""
    cuts = tuple(sorted({start, *bar.cuts, stop}))
    return Bar(bar.material, cuts, int(np.argmax(np.diff(cuts))), bar.at)


def node_at(frame: Frame, x: float, axis: int = 0) -> int:
    """The node at a place along the frame."""
    away = np.abs(frame.nodes[:, axis] - x)
    found = int(away.argmin())
    assert away[found] <= 1e-9 * np.ptp(frame.nodes[:, axis])
    return found


def sites_along(frame: Frame, fibres: At, axis: int = 0) -> list[Site]:
    """Sites at both ends of every member, with the fibres that stand there.

    A section that changes at a node counts on both its sides: fibres are asked a little inside.
    """
    sites = []
    for number, (start, end) in enumerate(frame.nodes[frame.members][:, :, axis]):
        for at, place in ((0.0, start + 1e-6 * (end - start)), (1.0, end - 1e-6 * (end - start))):
            found = fibres(float(place))
            if found is not None:
                sites.append(Site(number, at, *found))
    return sites


def _pins(frame: Frame, length: float) -> tuple[list[int], list[int]]:
    return [node_at(frame, 0.0)], [node_at(frame, length)]


def _rims(
    part: Part, entries: Sequence[Entry], lug: StripLug | EyeLug, thickness: float
) -> list[Patch]:
    """Both bores of a link, on both its faces."""
    faces = (-thickness / 2, thickness / 2)
    nu = part.material.poisson_ratio
    return [
        bore_patch(entry, lug, thickness, faces, nu, mirrored=entry is entries[-1], tilts=True)
        for entry in entries
    ]


def bores(frame: Frame, part: Part, radii: Sequence[float], depth: float) -> list[Entry]:
    """Entries of two bores at the ends of a link, at x = 0 and its length."""
    shape = part.geometry
    assert isinstance(shape, PlateLink | TubeRod)
    entries = []
    for name, x, radius in zip(shape.interfaces, (0.0, shape.length), radii, strict=True):
        interface = Interface(name, "bore", np.array([x, 0.0, 0.0]), radius, depth, tilts=True)
        entries.append(bore_entry(frame, interface, tilting(frame, node_at(frame, x))))
    return entries


def prismatic_tube(part: Part, shape: PrismaticTube) -> PartFrame:
    """A plain square tube, loaded on its end faces."""
    bar = bar_of(part)
    assert bar is not None
    frame = bar.frame(_PIECES)
    tube = square_tube_section("tube", shape.width, shape.wall, shape.inner_radius)
    whole = square_tube_fibres(shape.width, shape.wall, tube.area, tube.inertia_in_plane)
    entries = [
        planar_entry(
            Interface(name, "face", np.array([x, 0.0, 0.0])), at_node(frame, node_at(frame, x))
        )
        for name, x in zip(shape.interfaces, (0.0, shape.length), strict=True)
    ]
    sites = sites_along(frame, lambda _: (whole, "tube"))
    return PartFrame(
        frame, 0, entries, sites, "how the ends' forces spread", _pins(frame, shape.length)
    )


def plate_link(part: Part, shape: PlateLink) -> PartFrame:
    """A flat plate between two pins."""
    half = shape.width / 2
    second = shape.hole if shape.second_hole is None else shape.second_hole
    radii = (shape.hole / 2, second / 2)
    holes = ((0.0, radii[0]), (shape.length, radii[1]))

    def sections(x: FloatArray) -> Sections:
        ends = np.maximum(np.maximum(-x, x - shape.length), 0.0)
        height = 2 * np.sqrt(half**2 - ends**2)
        thick = shape.thickness
        return bored(rectangle(height, thick), chord(x, holes), height, thick, thick**3 / 12)

    cuts = (-half, 0.0, shape.length, shape.length + half)
    frame = Bar(elastic(part), cuts, 1, sections).frame(_PIECES, bore_places(holes))
    plate = rectangle_fibres(shape.width, shape.thickness)

    def fibres(x: float) -> tuple[Fibres, str] | None:
        return (plate, "plate") if radii[0] < x < shape.length - radii[1] else None

    entries = bores(frame, part, radii, shape.thickness)
    lug = StripLug(shape.width, None, shape.length / 2, bar=shape.thickness)
    return PartFrame(
        frame,
        node_at(frame, 0.0),
        entries,
        sites_along(frame, fibres),
        "that its round ends and holes upset the stress beside them",
        _pins(frame, shape.length),
        _rims(part, entries, lug, shape.thickness),
    )


def tube_rod(part: Part, shape: TubeRod) -> PartFrame:
    """A round tube or bar between two eyes."""
    eye = shape.eye_diameter / 2
    bore = 0.0 if shape.wall is None else shape.tube_diameter - 2 * shape.wall
    end = shank_end(shape)
    joint = end * eye / (eye + shape.fillet)
    hollow = eye + bore / 2 if bore else end
    marks = {0.0, joint, end, *((eye, hollow) if bore else ())}
    holes = ((0.0, shape.hole / 2), (shape.length, shape.hole / 2))
    cuts = sorted({-eye, shape.length + eye, *marks, *(shape.length - x for x in marks)})
    bar = Bar(elastic(part), tuple(cuts), int(np.argmax(np.diff(cuts))), rod_sections(shape))
    frame = bar.frame(_PIECES, bore_places(holes))

    def fibres(x: float) -> tuple[Fibres, str] | None:
        from_pin = min(x, shape.length - x)
        if from_pin < max(joint, hollow if bore else 0.0):
            return None
        nominal = round_fibres(
            2 * float(outer_radius(shape, np.array(from_pin))),
            bore,
            poisson_ratio=part.material.poisson_ratio,
        )
        if shape.fillet and abs(from_pin - end) < 1e-5 * shape.length:
            sizes = shape.eye_diameter, shape.tube_diameter, shape.fillet
            factors = (stepped_shaft(kind, *sizes) for kind in ("tension", "bending", "torsion"))
            return nominal.notched(*factors), "fillet"
        return nominal, "fillet" if from_pin < end else "tube"

    entries = bores(frame, part, (shape.hole / 2, shape.hole / 2), shape.eye_width)
    ligament = ball_ligament(shape.eye_diameter, shape.eye_width, shape.hole) / shape.eye_width
    lug = EyeLug(shape.hole + 2 * ligament, shape.tube_diameter)
    return PartFrame(
        frame,
        node_at(frame, 0.0),
        entries,
        sites_along(frame, fibres),
        "that the hole upsets the stress in the eye and beside it",
        _pins(frame, shape.length),
        _rims(part, entries, lug, shape.eye_width),
    )
