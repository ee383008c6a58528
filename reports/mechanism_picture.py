"""The elements of a mechanism's picture: bodies, pivots, guides, slots, forces and names.

Every moving thing has an id that begins with the picture's prefix, for a script.
"""

from collections.abc import Iterator
from html import escape
from math import degrees, hypot

import numpy as np

from checks.result.words import brief
from loads import GROUND, Distance, Fixed, Prismatic, Revolute
from reports.mechanism_layout import Layout, arrow_path, bent_path, both_ends, entry, hull, same

_TINTS = 7  # colours of series that the page has
_BY_POINT = 2.4  # where a name stands beside its point, in shares (%) of the picture's size
_BY_TORQUE = 5.6
TIP = 1.4  # half the width of an arrow's tip, likewise


class Picture:
    """The elements, with the bodies as they are assembled or at one frame of the layout."""

    def __init__(self, layout: Layout, prefix: str, frame: int | None = None) -> None:
        self.layout, self.prefix, self.frame = layout, prefix, frame
        self.unit, self.joints, self.marks = layout.unit, layout.joints, layout.marks
        self.drawn = layout.poses_at(frame)

    def svg(self, label: str) -> str:
        """The whole picture as an SVG element."""
        x, y, width, height = self.layout.box
        parts = [
            f'<svg class="mechanism" role="img" aria-label="{escape(label)}" '
            f'viewBox="{x:.6g} {y:.6g} {width:.6g} {height:.6g}" '
            f'style="--u: {self.unit:.6g}px">',
            *self.paths(),
            *self.ground(),
            *self.bodies(),
            *self.spans(),
            *self.pins(),
            *self.arrows(),
            *self.labels(),
            "</svg>",
        ]
        return "\n".join(parts)

    def _point(self, body: str, point: str) -> tuple[float, float]:
        """Where a point of a body is drawn."""
        x, y = self.layout.linkage.body(body).place(point)
        x0, y0, angle = self.drawn[body]
        c, s = float(np.cos(angle)), float(np.sin(angle))
        return x0 + c * x - s * y, -(y0 + s * x + c * y)

    def paths(self) -> Iterator[str]:
        """The ways of the points, once where cycles have the same."""
        layout, told = self.layout, set()
        for (_, name), place in zip(self.marks, layout.places, strict=True):
            for stretch in layout.stretches:
                way = place[stretch]
                if np.ptp(way, axis=0).max() < 1e-6 * layout.size:
                    continue
                points = " ".join(f"{x:.5g},{-y:.5g}" for x, y in way[:: max(1, len(way) // 180)])
                if points not in told:
                    told.add(points)
                    title = f"<title>way of {escape(brief(name, 30))}</title>"
                    yield f'<polyline class="way" points="{points}">{title}</polyline>'

    def ground(self) -> Iterator[str]:
        """Pivots on the ground, and the guides and slots that it has."""
        u = self.unit
        yield from self._rails(GROUND)
        for joint in self.joints:
            if isinstance(joint, Revolute | Fixed) and GROUND in (joint.body_a, joint.body_b):
                x, y = self._point(GROUND, joint.point)
                yield (
                    f'<path class="pivot" d="M{x:.5g} {y:.5g}l{-3 * u:.5g} {5 * u:.5g}'
                    f'h{6 * u:.5g}z"/><path class="hatch" d="M{x - 4.4 * u:.5g} {y + 5 * u:.5g}'
                    f'h{8.8 * u:.5g}"/>'
                )
        for force in self.layout.reaching:
            span = force.coordinate
            assert isinstance(span, Distance)
            for body, point in ((span.body_a, span.point_a), (span.body_b, span.point_b)):
                if body == GROUND:
                    x, y = self._point(body, point)
                    yield (
                        f'<path class="pivot" d="M{x:.5g} {y:.5g}l{-3 * u:.5g} {5 * u:.5g}'
                        f'h{6 * u:.5g}z"/>'
                    )

    def _rails(self, body: str) -> Iterator[str]:
        """Guides and slots whose line this body has, in its frame."""
        for k in self.layout.lines:
            joint = self.joints[k]
            if joint.body_a != body:
                continue
            (x0, y0), (x1, y1) = self.layout.line(k)
            kind = "rail" if self.layout.is_rail(k) else "slot"
            over = 5 * self.unit / max(hypot(x1 - x0, y1 - y0), 1e-9)
            if kind == "rail":  # a guide is drawn as long as the body that slides on it needs
                x0, y0, x1, y1 = (
                    x0 - over * (x1 - x0), y0 - over * (y1 - y0),
                    x1 + over * (x1 - x0), y1 + over * (y1 - y0),
                )  # fmt: skip
            line = f'x1="{x0:.5g}" y1="{-y0:.5g}" x2="{x1:.5g}" y2="{-y1:.5g}"'
            yield f'<line class="{kind}" {line}/>'
            if kind == "slot":
                yield f'<line class="slot inner" {line}/>'

    def bodies(self) -> Iterator[str]:
        """Every moving body in its own frame, behind a transform."""
        for index, body in enumerate(self.layout.linkage.moving):
            x, y, angle = self.drawn[body.name]
            tint = index % _TINTS
            yield (
                f'<g id="{self.prefix}-body-{index}" class="body tint{tint}" '
                f'transform="translate({x:.6g} {-y:.6g}) rotate({-degrees(angle):.6g})">'
                f"<title>{escape(brief(body.name, 60))}</title>"
            )
            yield from self._rails(body.name)
            # a body reaches at least as far as the lines that it has
            own = [k for k in self.layout.lines if self.joints[k].body_a == body.name]
            lines = [self.layout.line(k) for k in own]
            places = [np.array(list(body.points.values()), dtype=float).reshape(-1, 2), *lines]
            outline = hull(np.concatenate(places) * [1.0, -1.0])
            if len(outline) > 1:
                shape = "M" + "L".join(f"{px:.5g} {py:.5g}" for px, py in outline)
                yield f'<path class="link" d="{shape}{"z" if len(outline) > 2 else ""}"/>'
            yield from self._sliders(body.name)
            yield "</g>"

    def _sliders(self, body: str) -> Iterator[str]:
        """A block where a body is guided."""
        u = self.unit
        for joint in self.joints:
            if not isinstance(joint, Prismatic) or joint.body_b != body:
                continue
            x, y = self.layout.linkage.body(body).place(joint.point_b)
            along = np.degrees(np.arctan2(joint.direction[1], joint.direction[0]))
            turned = self.drawn[body][2] - self.drawn[joint.body_a][2]
            angle = -along + np.degrees(turned)
            yield (
                f'<rect class="block" x="{x - 5 * u:.5g}" y="{-y - 3 * u:.5g}" '
                f'width="{10 * u:.5g}" height="{6 * u:.5g}" rx="{0.8 * u:.5g}" '
                f'transform="rotate({angle:.6g} {x:.5g} {-y:.5g})"/>'
            )

    def spans(self) -> Iterator[str]:
        """Forces between two points, drawn as the cylinder that gives them."""
        for index, force in enumerate(self.layout.reaching):
            span = force.coordinate
            assert isinstance(span, Distance)
            (x0, y0), (x1, y1) = (
                self._point(span.body_a, span.point_a),
                self._point(span.body_b, span.point_b),
            )
            share = float(self.layout.barrels[index]) / max(hypot(x1 - x0, y1 - y0), 1e-9)
            middle = (x0 + share * (x1 - x0), y0 + share * (y1 - y0))
            yield (
                f'<g class="span"><title>{escape(brief(force.name, 60))}</title>'
                f'<line id="{self.prefix}-span-{index}" class="rod" '
                f'x1="{x0:.5g}" y1="{y0:.5g}" x2="{x1:.5g}" y2="{y1:.5g}"/>'
                f'<line id="{self.prefix}-barrel-{index}" class="barrel" '
                f'x1="{x0:.5g}" y1="{y0:.5g}" x2="{middle[0]:.5g}" y2="{middle[1]:.5g}"/></g>'
            )

    def pins(self) -> Iterator[str]:
        """The joints' points and those of forces: circles for pins, squares for welds."""
        for index, (body, point) in enumerate(self.marks):
            x, y = self._point(body, point)
            u = 1.5 * self.unit
            joint = self.joints[index] if index < len(self.joints) else None
            shape = (
                f'<rect x="{-u:.5g}" y="{-u:.5g}" width="{2 * u:.5g}" height="{2 * u:.5g}"/>'
                if isinstance(joint, Fixed)
                else f'<circle r="{u:.5g}"/>'
            )
            spanned = any((body, point) in both_ends(force) for force in self.layout.reaching)
            bare = isinstance(joint, Prismatic) or (joint is None and not spanned)
            hidden = ' visibility="hidden"' if bare else ""
            name = point if joint is None else joint.name
            yield (
                f'<g id="{self.prefix}-point-{index}" class="pin"{hidden} '
                f'transform="translate({x:.6g} {y:.6g})">'
                f"<title>{escape(brief(name, 60))}</title>{shape}</g>"
            )

    def arrows(self) -> Iterator[str]:
        """Arrows of reactions and forces; empty ones, for a script, of the assembled linkage."""
        layout, tip = self.layout, TIP * self.unit
        names = [f"reaction of {joint.name} on {joint.body_b}" for joint in self.joints]
        names += [force.name for force in layout.efforts]
        for index, name in enumerate(names):
            kind = "reaction" if index < len(self.joints) else "effort"
            shape = ""
            if self.frame is not None:
                shape = f' d="{arrow_path(layout.arrow_ends[self.frame, index], tip)}"'
            yield (
                f'<path id="{self.prefix}-arrow-{index}" class="arrow {kind}"{shape}>'
                f"<title>{escape(brief(name, 80))}</title></path>"
            )
        for index, force in enumerate(layout.turning):
            x, y = self._point(*entry(layout.linkage, force.coordinate))
            shape = ""
            if self.frame is not None:
                share = layout.torques[self.frame, index] * layout.scaled(layout.turned)[self.frame]
                shape = f' d="{bent_path(float(share), tip)}"'
            yield (
                f'<path id="{self.prefix}-torque-{index}" class="arrow effort" '
                f'transform="translate({x:.6g} {y:.6g})"{shape}>'
                f"<title>{escape(brief(force.name, 60))}</title></path>"
            )

    @property
    def lifts(self) -> list[float]:
        """Offset of each point's name to the right of the point, and above it [mm].

        Names keep clear of the arc that shows a torque.
        """
        linkage = self.layout.linkage
        turned = [self._point(*entry(linkage, f.coordinate)) for f in self.layout.turning]
        return [
            (_BY_TORQUE if any(same(self._point(*mark), at) for at in turned) else _BY_POINT)
            * self.unit
            for mark in self.marks
        ]

    def labels(self) -> Iterator[str]:
        """Names of the points, one for each place."""
        told: set[tuple[float, float]] = set()
        for index, ((body, point), lift) in enumerate(zip(self.marks, self.lifts, strict=True)):
            x, y = self._point(body, point)
            if (round(x, 6), round(y, 6)) in told:
                continue
            told.add((round(x, 6), round(y, 6)))
            yield (
                f'<text id="{self.prefix}-label-{index}" x="{x + lift:.6g}" '
                f'y="{y - lift:.6g}">{escape(brief(point, 16))}</text>'
            )
