"""A design's bodies as links of a frame: bars where their parts are, rigid bodies elsewhere."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, sin

import numpy as np

import loads
from checks.design.data import Design
from checks.part.placing import Placing, part_placing
from checks.strength.part_strength import elastic_of
from fem.frame_joints import Link, PlacedLinks, bar_frame
from geometry.bars import Bar
from geometry.mesh import FloatArray

_ASIDE = 1e-6  # of a bar's length: how far from its axis a point may be to be on it


@dataclass(frozen=True, eq=False)
class LinkModel:
    """The links of a linkage, one per moving body, in the linkage's order.

    linkage
    links     in the axes of their parts
    bars      number of the link -> its sections
    placings  of the links' axes in the bodies'
    """

    linkage: loads.Linkage
    links: tuple[Link, ...]
    bars: Mapping[int, Bar]
    placings: tuple[Placing, ...]

    @property
    def has_bars(self) -> bool:
        """True if any body can bend."""
        return bool(self.bars)

    def number(self, body: str) -> int | None:
        """Return the link of a body; None for the ground."""
        return self._numbers[body]

    @cached_property
    def _numbers(self) -> dict[str, int | None]:
        moving = enumerate(body.name for body in self.linkage.moving)
        return {loads.GROUND: None, **{name: number for number, name in moving}}

    def bending(self, number: int, plane: str) -> float:
        """E I in the middle of a bar's longest stretch, N mm2, "in plane" or out of it."""
        bar, frame = self.bars[number], self.links[number].frame
        assert frame is not None
        sections = bar.at(np.full((1, 6), sum(bar.main) / 2))
        inertia = sections.inertia_z if plane == "in plane" else sections.inertia_y
        return float(frame.material.youngs_modulus * np.ravel(inertia)[0])

    def own(self, link: int, places: FloatArray) -> FloatArray:
        """Places (..., 2) in a link's axes, for those in its body's."""
        placing = self.placings[link]
        c, s = cos(placing.angle), sin(placing.angle)
        return np.asarray((places - np.array(placing.origin)) @ np.array([[c, -s], [s, c]]))

    def placed(self, poses: FloatArray) -> PlacedLinks:
        """The links in a pose (bodies, 3) of the linkage, the ground first."""
        origins, angles = np.zeros((len(self.links), 2)), np.zeros(len(self.links))
        for k, placing in enumerate(self.placings):
            x, y, angle = poses[k + 1]
            c, s = cos(angle), sin(angle)
            origins[k] = np.array([x, y]) + np.array([[c, -s], [s, c]]) @ np.array(placing.origin)
            angles[k] = angle + placing.angle
        return PlacedLinks(self.links, origins, angles)

    def moved(
        self, placed: PlacedLinks, shape: FloatArray
    ) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
        """Places (n, 2) and displacements (n, 3) by body, ground axes, largest 1."""
        places, moves = {}, {}
        for k, link in enumerate(self.links):
            where = np.zeros((1, 2)) if link.frame is None else link.frame.nodes[:, :2]
            motions = [placed.motion(k, place) for place in where]
            places[link.name] = np.array([motion.place for motion in motions])
            moves[link.name] = np.array([motion.rows[:3] @ shape for motion in motions])
        largest = max(float(np.abs(move).max()) for move in moves.values())
        return places, {name: move / largest for name, move in moves.items()}


def link_model(design: Design, linkage: loads.Linkage, pieces: int) -> LinkModel:
    """Return the links of a design, bars in `pieces` per longest stretch."""
    parts = {part.body: part for part in design.parts.values() if part.body is not None}
    links, bars, placings = [], {}, []
    for k, body in enumerate(linkage.moving):
        part = parts.get(body.name)
        bar = None if part is None else part.geometry.link(part.material.poisson_ratio)
        placing = Placing((0.0, 0.0), 0.0) if part is None else part_placing(design, part)
        placings.append(placing)
        if part is None or bar is None:
            links.append(Link(body.name))
            continue
        bars[k] = bar
        places = _on_axis(placing, body, bar)
        links.append(Link(body.name, bar_frame(bar, elastic_of(part), pieces, places)))
    return LinkModel(linkage, tuple(links), bars, tuple(placings))


def _on_axis(placing: Placing, body: loads.Body, bar: Bar) -> Sequence[float]:
    """Where points of the body are on the bar's axis, mm along it."""
    c, s = cos(placing.angle), sin(placing.angle)
    found = []
    for point in body.points.values():
        x, y = np.array(point) - np.array(placing.origin)
        along, aside = c * x + s * y, -s * x + c * y
        length = bar.cuts[-1] - bar.cuts[0]
        if abs(aside) < _ASIDE * length and all(
            abs(along - cut) > _ASIDE * length for cut in bar.cuts
        ):
            found.append(float(along))
    return found
