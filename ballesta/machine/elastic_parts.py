"""Bodies that give way as their parts do: the compliance of a meshed part in a linkage."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin

import numpy as np
import scipy

import loads
from ballesta.machine.solved_cycles import parts_that_give
from checks.design.data import Design, Pair, Part
from checks.part.loaded_part import FIRST
from checks.part.part_loads import interface_heights, part_placing
from checks.strength.part_strength import elastic_of
from checks.stress.kept_models import told_of_part
from checks.stress.solid_mesh_level import Models
from fem.sliding import stations
from fem.unit_solutions import UnitSolutions, compliance
from geometry.mesh import FloatArray

Say = Callable[[str], None]

_ASKEW = 1e-6  # of a line's length: how far it may leave the part's x axis


def compliances_of(
    design: Design, models: Models, say: Say = lambda _: None
) -> dict[str, loads.MatrixCompliance]:
    """Compliance of every body that gives way as its part does; none where nothing is touched.

    The part is solved on the first mesh of its check. Raises DesignError for a part whose
    compliance is not known, NumericsError where it cannot be meshed or solved.
    """
    found: dict[str, loads.MatrixCompliance] = {}
    if not any(cycle.has_contact for cycle in design.cycles.values()):
        return found
    for part in parts_that_give(design):
        assert part.body is not None
        say(f"{part.name}: solving how it gives way")
        with told_of_part(design, part):
            solutions = models.solutions(part.geometry, FIRST * part.fineness, elastic_of(part))
            found[part.body] = body_compliance(design, part, solutions)
    return found


def body_compliance(design: Design, part: Part, solutions: UnitSolutions) -> loads.MatrixCompliance:
    """Compliance of a body from the solved unit loads of its part.

    Forces act in the linkage's points, which a hole of a part from CAD may miss by its tolerance;
    a rigid arm leads from one to the other. Raises loads.LinkageError where forces act beside the
    part's middle plane, or a contact does not run along its x axis.
    """
    assert part.body is not None
    if part.beside or any(part.offsets.values()) or any(interface_heights(part).values()):
        raise loads.LinkageError(
            'stiffness = "fem" needs forces in the part\'s middle plane: beside it they also twist '
            "and bend it out of the plane, which the linkage does not know; state bending or axial"
        )
    in_part = _InPart(design, part)
    points: list[str] = []
    lines: dict[str, tuple[float, ...]] = {}
    fixed: list[_Place] = []
    sliding: list[_Place] = []
    for name, at in part.interfaces.items():
        interface = solutions.mesh.interfaces[name]
        if interface.kind != "slide":
            points.append(at)
            fixed.append(_Place(name, in_part.arm(at, interface.centre)))
            continue
        slide = design.slides[at]
        start, way = in_part.line(slide.point_a, slide.direction, name)
        low, high = interface.travel
        along = np.linspace(low, high, len(stations(interface)))[:: int(way)]
        lines[at] = tuple(float(way * (x + interface.centre[0] - start[0])) for x in along)
        aside = start[1] - float(interface.centre[1])
        sliding += [_Place((name, float(x)), (0.0, aside)) for x in along]
    places = [*fixed, *sliding]
    arms = scipy.linalg.block_diag(*(in_part.wrench_there(place.arm) for place in places))
    matrix = compliance(solutions, [place.what for place in places])
    turned = arms.T @ matrix @ arms
    return loads.MatrixCompliance(part.body, tuple(points), (turned + turned.T) / 2, lines)


@dataclass(frozen=True)
class _Place:
    """A place of `fem.unit_solutions`, and the arm, mm, from it to where the body's load acts."""

    what: str | tuple[str, float]
    arm: Pair


class _InPart:
    """A body's points, lines and loads in the frame of its part."""

    def __init__(self, design: Design, part: Part) -> None:
        assert part.body is not None
        placing = part_placing(design, part)
        self._origin = np.array(placing.origin)
        c, s = cos(placing.angle), sin(placing.angle)
        self._turn = np.array([[c, s], [-s, c]])  # from the body's axes to the part's
        self._points = design.bodies[part.body].points

    def point(self, name: str) -> FloatArray:
        return np.asarray(self._turn @ (np.array(self._points[name]) - self._origin))

    def arm(self, point: str, centre: FloatArray) -> Pair:
        x, y = self.point(point) - centre[:2]
        return float(x), float(y)

    def line(self, through: str, direction: Pair, interface: str) -> tuple[FloatArray, float]:
        """Start of a line, and its sense: 1 along x, -1 against it."""
        x, y = self._turn @ np.array(direction)
        if abs(y) > _ASKEW:
            raise loads.LinkageError(
                f"the contact at {interface!r} does not run along the part's x axis: it leaves it "
                f"by {np.degrees(np.arcsin(abs(y))):.3g} deg"
            )
        return self.point(through), float(np.sign(x))

    def wrench_there(self, arm: Pair) -> FloatArray:
        """Wrench (3, 3) at the foot of an arm, in the part's axes, for unit ones at its end."""
        result = np.eye(3)
        result[:2, :2] = self._turn
        result[2, :2] = np.array([-arm[1], arm[0]]) @ self._turn
        return result
