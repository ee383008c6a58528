"""Sections of a part's frame: what holes take from them, and those of a rod's eyes."""

from collections.abc import Callable, Sequence

import numpy as np

from fem.frame_sections import Sections, round_tube
from geometry.mesh import FloatArray
from geometry.parts import TubeRod

_ARCS = 8  # of half a bore's rim


def chord(x: FloatArray, holes: Sequence[tuple[float, float]]) -> FloatArray:
    """Height (mm) that holes (centre, radius) take away at places x, mm."""
    taken = np.zeros(np.shape(x))
    for centre, radius in holes:
        taken += 2 * np.sqrt(np.maximum(radius**2 - (x - centre) ** 2, 0.0))
    return taken


def bore_places(holes: Sequence[tuple[float, float]]) -> list[float]:
    """Where nodes stand within holes (centre, radius): at even angles of the rim."""
    cosines = np.cos(np.linspace(0.0, np.pi, _ARCS + 1))
    cosines[_ARCS // 2] = 0.0
    return [float(c + r * cosine) for c, r in holes for cosine in cosines]


def bored(
    sections: Sections,
    taken: FloatArray,
    height: FloatArray | float,
    depth: FloatArray | float,
    second: FloatArray | float,
) -> Sections:
    """Sections less a hole along z of chord `taken`.

    depth   mm, of what it goes through along z
    second  mm3, second moment of that depth about the part's middle
    """
    left = 1 - taken / height
    return Sections(
        sections.area - taken * depth,
        sections.inertia_y - taken * second,
        sections.inertia_z - depth * taken**3 / 12,
        sections.torsion * left,
        sections.shear_area_y * left,
        sections.shear_area_z * left,
    )


def shank_end(shape: TubeRod) -> float:
    """Distance from the pin axis to where the tube's fillet begins, mm."""
    radius, reach = shape.eye_diameter / 2, shape.tube_diameter / 2 + shape.fillet
    return float(np.sqrt((radius + shape.fillet) ** 2 - reach**2))


def outer_radius(shape: TubeRod, from_pin: FloatArray) -> FloatArray:
    """Outer radius of a rod at places beside a pin's axis: ball, fillet, tube; 0 beyond."""
    eye, tube, end = shape.eye_diameter / 2, shape.tube_diameter / 2, shank_end(shape)
    joint = end * eye / (eye + shape.fillet)
    ball = np.sqrt(np.maximum(eye**2 - from_pin**2, 0.0))
    below = np.maximum(shape.fillet**2 - (end - from_pin) ** 2, 0.0)
    fillet = tube + shape.fillet - np.sqrt(below)
    return np.where(from_pin < joint, ball, np.where(from_pin < end, fillet, tube))


def rod_sections(shape: TubeRod) -> Callable[[FloatArray], Sections]:
    """Sections of a rod at places x: discs cut at the eyes' flats, less the tube's bore.

    The areas of a cut disc are integrals over z, by Gauss.
    """
    eye = shape.eye_diameter / 2
    bore = 0.0 if shape.wall is None else shape.tube_diameter / 2 - shape.wall
    angles, weights = np.polynomial.legendre.leggauss(24)

    def at(x: FloatArray) -> Sections:
        from_pin = np.where(x > shape.length / 2, shape.length - x, x)
        outer = outer_radius(shape, from_pin)
        inside = np.maximum(bore**2 - np.maximum(eye + bore - from_pin, 0.0) ** 2, 0.0)
        inner = np.where(from_pin > eye, np.sqrt(inside), 0.0) if bore else np.zeros_like(outer)
        half = np.minimum(outer, shape.eye_width / 2)
        most = np.arcsin(np.minimum(half / outer, 1.0))[..., None]
        angle, weight = most * angles, most * weights
        width, z = outer[..., None] * np.cos(angle), outer[..., None] * np.sin(angle)
        strip = weight * width  # dz
        area = (2 * width * strip).sum(axis=-1) - np.pi * inner**2
        about_z = (2 / 3 * width**3 * strip).sum(axis=-1) - np.pi / 4 * inner**4
        about_y = (2 * width * z**2 * strip).sum(axis=-1) - np.pi / 4 * inner**4
        # Saint-Venant's of an ellipse, and so of a full disc or tube: 4 I_y I_z / (I_y + I_z)
        torsion = 4 * about_y * about_z / (about_y + about_z)
        round_one = round_tube(2 * outer, 2 * inner)
        shear = area * round_one.shear_area_y / round_one.area
        solid = Sections(area, about_y, about_z, torsion, shear, shear)
        taken = chord(x, ((0.0, shape.hole / 2), (shape.length, shape.hole / 2)))
        depth = 2 * half
        return bored(solid, taken, 2 * outer, depth, depth**3 / 12)

    return at
