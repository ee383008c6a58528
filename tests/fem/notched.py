"""Plates with a sharp notch or step, pulled along x: as solids of gmsh, and as plane references.

A plate is 120 mm long and 40 mm deep. The notch of 10 mm opens to its lower side; the step halves
its depth. A "pressed" one is a step whose shoulder is pressed by 100 MPa instead.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from fem.notch_intensity import modes
from geometry.mesh import Interface
from geometry.shape import Body, Region

from ..validation.plane.domains import Fine, Outline, Piece, meshed
from ..validation.plane.model import PlaneModel

HALF, DEPTH, NOTCH = 60.0, 40.0, 10.0
_LEFT, _UPPER = ((-HALF, 0),), ((HALF, DEPTH), (-HALF, DEPTH))
PULL = 100.0  # MPa on the end at x = 60 mm


def corners(opening):
    """Outline from the lower left corner, the tip of the edge, and the turn of its bisector."""
    if opening in ("step", "pressed"):
        tip = (0.0, DEPTH / 2)
        return (*_LEFT, (0, 0), tip, (HALF, tip[1]), *_UPPER), tip, 3 / 4
    side = NOTCH * np.tan(np.radians(opening / 2))
    tip = (0.0, NOTCH)
    return (*_LEFT, (-side, 0), tip, (side, 0), (HALF, 0), *_UPPER), tip, 1 / 2


def interior(opening):
    """Interior angle at the tip, rad."""
    return np.radians(270 if isinstance(opening, str) else 360 - opening)


@dataclass(frozen=True)
class Plate:
    """A plate as a solid; elements of a size (mm) at the edge, 4 mm elsewhere."""

    opening: float | str
    thick: float
    fine: float

    def build(self, gmsh):
        """Draw it in gmsh's model."""
        outline, tip, _ = corners(self.opening)
        kernel = gmsh.model.occ
        points = [kernel.addPoint(x, y, -self.thick / 2) for x, y in outline]
        lines = [
            kernel.addLine(p, q) for p, q in zip(points, [*points[1:], points[0]], strict=True)
        ]
        face = kernel.addPlaneSurface([kernel.addCurveLoop(lines)])
        kernel.extrude([(2, face)], 0, 0, self.thick)
        kernel.synchronize()
        edges = [(1, tag) for _, tag in gmsh.model.getEntities(1) if _at(gmsh, 1, tag, tip)]
        ends = {
            name: [tag for _, tag in gmsh.model.getEntities(2) if _at(gmsh, 2, tag, (x, None))]
            for name, x in (("left", -HALF), ("right", HALF))
        }
        low = tip[1] if isinstance(self.opening, str) else 0.0
        interfaces = [
            Interface("left", "face", np.array([-HALF, DEPTH / 2, 0.0])),
            Interface("right", "face", np.array([HALF, (low + DEPTH) / 2, 0.0])),
        ]
        if self.opening == "pressed":
            faces = gmsh.model.getEntities(2)
            ends["shoulder"] = [tag for _, tag in faces if _at(gmsh, 2, tag, (0.0, None))]
            interfaces.append(Interface("shoulder", "face", np.array([0.0, tip[1] / 2, 0.0])))
        return Body(ends, interfaces, 4.0, [Region(edges, self.fine, 20 * self.fine)])

    def wrenches(self):
        """Loads by interface, N and N mm: the pull or the pressure, and what holds the left end."""
        low = DEPTH / 2 if isinstance(self.opening, str) else 0.0
        force = PULL * (DEPTH - low) * self.thick
        none = np.zeros((1, 6))
        if self.opening == "pressed":
            shoulder = np.array([[-force, 0, 0, 0, 0, 0.0]])
            left = np.array([[force, 0, 0, 0, 0, force * low / 2]])
            return {"left": left, "right": none, "shoulder": shoulder}
        left = np.array([[-force, 0, 0, 0, 0, force * low / 2]])
        return {"left": left, "right": np.array([[force, 0, 0, 0, 0, 0.0]])}


def _at(gmsh, dimension, tag, place):
    box = np.reshape(gmsh.model.getBoundingBox(dimension, tag), (2, 3))
    return all(
        abs(box[:, axis] - wanted).max() < 1e-3
        for axis, wanted in enumerate(place)
        if wanted is not None
    )


@cache
def reference(opening):
    """K1 and K2 of the plane plate, from the stress on the bisector next to the tip.

    Elements of 1e-3 mm at the tip; between 0.02 and 0.1 mm from it sqrt(2 pi) r^(1 - lambda) times
    the stress, which no fit of fields enters. K2 of a pressed step is None: not told by that.
    """
    outline, tip, turn = corners(opening)
    names = {-HALF: "left", HALF: "right", 0: "shoulder"}
    pieces = tuple(
        Piece(p, names[p[0]] if p[0] == q[0] else "side")
        for p, q in zip(outline, (*outline[1:], outline[0]), strict=True)
    )
    loaded, size = ("shoulder", -PULL) if opening == "pressed" else ("right", PULL)
    fines = tuple(Fine((tip,), size, 20 * size) for size in (2e-3, 8e-3, 0.03, 0.12, 0.5, 1.5))
    mesh = meshed(Outline((pieces,), 3.0, fines), 2.0)
    held = mesh.nearest_node(-HALF, DEPTH / 2)
    solution = PlaneModel(mesh, 210e3, 0.3).solve(
        dirichlet={"left": (0.0, None), held: (None, 0.0)},
        tractions={loaded: lambda _points, normals: size * normals},
    )
    away = solution.model.elements.points.reshape(-1, 2) - tip
    stress = solution.quadrature_stress.reshape(-1, 4)
    r, theta = np.hypot(*away.T), np.arctan2(away[:, 1], away[:, 0]) - turn * np.pi
    near = (r > 0.02) & (r < 0.1) & (np.abs(theta) < np.radians(4))
    r, theta, (xx, yy, _, xy) = r[near], theta[near] + turn * np.pi, stress[near].T
    sine, cosine = np.sin(theta), np.cos(theta)
    hoop = xx * sine**2 + yy * cosine**2 - 2 * xy * sine * cosine
    shear = (yy - xx) * sine * cosine + xy * (cosine**2 - sine**2)
    first, second = (mode.order.real for mode in modes(interior(opening), 2.0)[:2])
    scale = np.sqrt(2 * np.pi)
    if opening == "pressed":  # the pressure adds an even stress
        fields = np.column_stack([r ** (first - 1) / scale, np.ones(len(r))])
        return float(np.linalg.lstsq(fields, hoop)[0][0]), None
    return (
        float(np.mean(scale * hoop * r ** (1 - first))),
        float(np.mean(scale * shear * r ** (1 - second))),
    )
