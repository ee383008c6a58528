"""Stress at a link's bores, by the lugs of the rung `formula`, in the columns of the frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from checks.handbook.lug_outlines import round_outline, strip_outline
from checks.handbook.lug_stress import Lug
from checks.handbook.pin_loaded_hole import PATTERNS, LugOutline, pin_loaded_hole
from checks.models.beam_entries import BEARING
from checks.models.beam_parts import Entry, Patch
from fem.frame_sections import rectangle_torsion

_ANGLES = np.radians(np.arange(0.0, 360.0, 10.0))
_SHANK = 0.95  # of an eye: a wider shank is no shank
_CUT = 1.25  # widths from a hole to where the lug is a bar again


@dataclass(frozen=True)
class StripLug:
    """A lug that goes on as a flat bar of its own width; lengths in mm.

    end            from the hole's middle to its square end; None: round about the middle
    longest        from the hole to where it is no strip any more
    stringer       area of a wall along either edge, over the lug's thickness
    stringer_from  from the hole to where these walls begin
    bar            thickness of the bar by which the lug is twisted; None: it is not
    """

    width: float
    end: float | None
    longest: float
    stringer: float = 0.0
    stringer_from: float = -np.inf
    bar: float | None = None

    def outline(self, radius: float) -> LugOutline:
        """Its outline about a hole."""
        cut = max(min(_CUT * self.width, self.longest), 1.5 * radius)
        return strip_outline(self.width / 2, self.end, cut, self.stringer, self.stringer_from)


@dataclass(frozen=True)
class EyeLug:
    """A round eye on a shank; diameters in mm. A ball cut flat is the eye with its ligament."""

    diameter: float
    shank: float

    def outline(self, radius: float) -> LugOutline:
        """Its outline about a hole."""
        assert radius < self.diameter / 2
        return round_outline(self.diameter / 2, min(self.shank, _SHANK * self.diameter) / 2)


def bore_patch(
    entry: Entry,
    shape: StripLug | EyeLug,
    thickness: float,
    faces: Sequence[float],
    poisson_ratio: float,
    *,
    mirrored: bool,
    tilts: bool,
) -> Patch:
    """Points round a bore on faces at z = `faces`, by the columns of its entry.

    thickness  mm, of all that the pin presses on
    mirrored   whether the free end is at +x
    tilts      whether its couples out of the plane bend the lug; else they push the faces' plates
    """
    interface = entry.interface
    assert PATTERNS == BEARING
    outline = shape.outline(interface.radius)
    hole = pin_loaded_hole(interface.radius, outline, poisson_ratio)
    twist = np.inf
    if isinstance(shape, StripLug) and shape.bar is not None:
        twist = float(rectangle_torsion(shape.width, shape.bar)[1])
    lug = Lug(hole, thickness, mirrored=mirrored, twist_modulus=twist)
    rim = interface.radius * np.exp(1j * _ANGLES)
    plane, tilt = lug.stress(rim), lug.tilted(_ANGLES)
    points, unit = [], []
    for z in faces:
        stress = np.zeros((len(rim), 6, len(entry.names)))
        stress[:, [0, 1, 3], : len(BEARING)] = plane
        if tilts:
            stress[:, [0, 1, 3], len(BEARING) :] = np.sign(z) * tilt
        else:  # of plates side by side one is pulled, the other pushed: M_y = z F_x, M_x = -z F_y
            beside = abs(z) - thickness / 4
            for column, name, sign in ((0, "sin 1", -1.0), (1, "cos 1", 1.0)):
                force = sign * np.sign(z) / beside
                own = force * plane[:, :, BEARING.index(name)]
                stress[:, [0, 1, 3], len(BEARING) + column] = own
        at = np.column_stack([rim.real, rim.imag, np.full(len(rim), float(z))])
        points.append(at + interface.centre * np.array([1.0, 1.0, 0.0]))
        unit.append(stress)
    return Patch(interface.name, np.concatenate(points), np.concatenate(unit), interface.name)
