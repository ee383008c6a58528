"""Line drawings of parts: what is visible of the edges of a mesh, with its interfaces in colour."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.mesh import FloatArray, IntArray, Mesh, boundary_facets

COLOURS = ("#d95f02", "#1b7a6b", "#7570b3", "#c4307a")
CREASE = np.cos(np.radians(30))  # facets that meet at more than 30 degrees make an edge
_QUARTERS = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])
_SIDES = ((0, 3, 1), (1, 4, 2), (2, 5, 0))  # corner, mid-side, corner of a facet's sides


@dataclass(frozen=True, eq=False)
class View:
    """The boundary of a mesh as it is seen: columns are right, up and towards us.

    points   (n, 3)     mm, the mesh's nodes
    facets   (k, 6)     node indices of the boundary's facets
    normals  (k, 6, 3)  unit normals of the curved facets at their nodes, outwards
    """

    points: FloatArray
    facets: IntArray
    normals: FloatArray

    def visible(self, places: FloatArray, clearance: float) -> FloatArray:
        """True (p,) where no facet stands in front of a place by more than the clearance."""
        corners = self.points[self.facets[:, _QUARTERS].reshape(-1, 3)]
        a, b, c = (corners[:, k] for k in range(3))
        area = _cross(b - a, c - a)
        solid = np.abs(area) > 1e-9 * np.abs(area).max()
        a, b, c, area = a[solid], b[solid], c[solid], area[solid]
        seen = np.ones(len(places), dtype=bool)
        for k, place in enumerate(places):
            s = _cross(place - a, c - a) / area
            t = _cross(b - a, place - a) / area
            inside = (s > 1e-6) & (t > 1e-6) & (s + t < 1 - 1e-6)
            depth = a[:, 2] + s * (b - a)[:, 2] + t * (c - a)[:, 2]
            seen[k] = not np.any(inside & (depth > place[2] + clearance))
        return seen

    def shown(self, facets: IntArray, clearance: float) -> IntArray:
        """Those of the facets (k, 6) that we see from their outside."""
        front = self.facets[self.normals[:, :3, 2].mean(axis=1) > 0.02]
        known = {tuple(corners) for corners in np.sort(front[:, :3], axis=1).tolist()}
        towards = [tuple(corners) in known for corners in np.sort(facets[:, :3], axis=1).tolist()]
        near = facets[towards]
        return near[self.visible(self.points[near[:, :3]].mean(axis=1), clearance)]


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def view_of(mesh: Mesh) -> View:
    """Look at a mesh: x to the right, y up, z towards us, turned so that three sides are seen."""
    turn, tilt = np.radians(-32), np.radians(24)
    about_y = np.array(
        [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    )
    about_x = np.array(
        [[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]]
    )
    points = mesh.nodes @ (about_x @ about_y).T
    facets = boundary_facets(mesh.elements)
    r, s = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]]).T
    t, zero = 1 - r - s, np.zeros(6)
    by_r = np.array([1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s])
    by_s = np.array([1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)])
    along = [np.einsum("aq,kax->kqx", by, points[facets]) for by in (by_r, by_s)]
    normals = np.cross(*along)
    return View(points, facets, normals / np.linalg.norm(normals, axis=2, keepdims=True))


def creases_of(view: View) -> FloatArray:
    """Pieces of the edges at which facets meet at an angle, (n, 2, 3) mm; two to a facet's side."""
    sides: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for index, facet in enumerate(view.facets):
        for first, middle, last in _SIDES:
            low, high = sorted((int(facet[first]), int(facet[last])))
            sides.setdefault((low, high), []).append((index, middle))
    found = []
    for (low, high), here in sorted(sides.items()):
        normals = np.array([view.normals[index, middle] for index, middle in here])
        if normals[:, 2].max() > 0 and (len(here) != 2 or normals[0] @ normals[1] < CREASE):
            middle = int(view.facets[here[0][0], here[0][1]])
            found += [(low, middle), (middle, high)]
    return view.points[np.array(found, dtype=int).reshape(-1, 2)]


def outlines_of(view: View) -> FloatArray:
    """Pieces of the lines at which curved facets turn away from us, (n, 2, 3) mm."""
    found = []
    for facet, normals in zip(view.facets, view.normals[..., 2], strict=True):
        if normals.min() >= 0 or normals.max() <= 0:
            continue
        for corners in _QUARTERS:
            here, towards = view.points[facet[corners]], normals[corners]
            ends = []
            for i, j in ((0, 1), (1, 2), (2, 0)):
                if towards[i] * towards[j] < 0:
                    share = towards[i] / (towards[i] - towards[j])
                    ends.append(here[i] + share * (here[j] - here[i]))
            if len(ends) == 2:
                found.append(ends)
    return np.array(found).reshape(-1, 2, 3)


def chained(pieces: FloatArray) -> list[FloatArray]:
    """Join pieces (n, 2, 2) that share an end into chains, going on greedily."""
    _, ends = np.unique(np.round(pieces, 3).reshape(-1, 2), axis=0, return_inverse=True)
    places = dict(zip(ends.tolist(), pieces.reshape(-1, 2), strict=True))
    neighbours: dict[int, list[int]] = {end: [] for end in places}
    for first, last in ends.reshape(-1, 2).tolist():
        if first != last:
            neighbours[first].append(last)
            neighbours[last].append(first)
    chains = []
    for start in sorted(neighbours, key=lambda end: (len(neighbours[end]) % 2 == 0, end)):
        while neighbours[start]:
            chain = [start]
            while neighbours[chain[-1]]:
                here = chain[-1]
                chain.append(neighbours[here].pop(0))
                neighbours[chain[-1]].remove(here)
            chains.append(np.array([places[end] for end in chain]))
    return chains


def draw(mesh: Mesh, path: Path) -> None:
    """Write the picture of a mesh as SVG; the same mesh gives the same file."""
    import matplotlib as mpl

    mpl.use("svg")
    from matplotlib import pyplot as plt
    from matplotlib.collections import LineCollection
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    view = view_of(mesh)
    size = np.ptp(view.points, axis=0).max()
    pieces = []
    # an outline lies on facets that are seen edge on: there depth means little
    for found, clearance in ((creases_of(view), 4e-3 * size), (outlines_of(view), 2.5e-2 * size)):
        pieces.append(found[view.visible(found.mean(axis=1), clearance)])
    lines = chained(np.concatenate(pieces)[..., :2])
    # without a salt matplotlib draws the names of its elements anew each time
    with mpl.rc_context({"svg.hashsalt": "ballesta", "svg.fonttype": "none"}):
        figure, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
        for colour, interface in zip(COLOURS, mesh.interfaces.values(), strict=False):
            corners = np.concatenate([mesh.surfaces[name] for name in interface.surfaces])
            near = view.shown(corners, 2e-2 * size)
            shown = view.points[near if len(near) else corners][:, :3]
            if len(near):
                patch = Outline.make_compound_path(*(Outline(p[[0, 1, 2, 0], :2]) for p in shown))
                axes.add_patch(PathPatch(patch, facecolor=colour, edgecolor="none", alpha=0.55))
            top = shown.reshape(-1, 3)[shown[..., 1].argmax()]
            axes.annotate(
                interface.name,
                top[:2],
                (top[0], 1.04),
                textcoords=axes.get_xaxis_transform(),
                ha="center",
                color=colour,
                arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.6},
            )
        axes.add_collection(LineCollection(lines, colors="#222222", linewidths=0.8))
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.set_axis_off()
        figure.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(figure)
    _shorten(path)


def _shorten(path: Path) -> None:
    """Round the picture's coordinates to a hundredth of a point and end every line without blanks.

    Six decimals of a point would be most of the file.
    """
    text = path.read_text(encoding="utf-8")
    text = re.sub(r"(\d+\.\d\d)\d+", r"\1", text)
    path.write_text("\n".join(line.rstrip() for line in text.splitlines()) + "\n", encoding="utf-8")
