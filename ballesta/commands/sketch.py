"""A linkage drawn with letters, for a terminal."""

from itertools import pairwise

import loads
from checks.design.data import Design


def sketch(design: Design, width: int = 60, height: int = 22) -> str:
    """Return the assembled linkage: points by name, bodies as dots, pulling forces as dashes.

    The line that a point slides on is drawn with colons.

    A point on the ground carries an underscore, one that slides on a line a colon.
    """
    points = design.points
    left, right = min(x for x, _ in points.values()), max(x for x, _ in points.values())
    low, high = min(y for _, y in points.values()), max(y for _, y in points.values())
    # a letter is about twice as high as wide
    scale = min((width - 4) / max(right - left, 1e-9), 2 * (height - 1) / max(high - low, 1e-9))

    def cell(point: tuple[float, float]) -> tuple[int, int]:
        return round((point[0] - left) * scale), round((high - point[1]) * scale / 2)

    canvas: dict[tuple[int, int], str] = {}

    def line(first: str, second: str, mark: str) -> None:
        (x0, y0), (x1, y1) = cell(points[first]), cell(points[second])
        steps = max(abs(x1 - x0), abs(y1 - y0), 1)
        for k in range(steps + 1):
            place = (round(x0 + (x1 - x0) * k / steps), round(y0 + (y1 - y0) * k / steps))
            canvas.setdefault(place, mark)

    for body in design.bodies.values():
        for first, second in pairwise(body.points):
            line(first, second, ".")
    for force in design.forces.values():
        if isinstance(force.coordinate, loads.Distance):
            line(force.coordinate.point_a, force.coordinate.point_b, "-")
    for slide in design.slides.values():
        if slide.point_a in points:
            line(slide.point_a, slide.point_b, ":")
    guided = {slide.point_b for slide in design.slides.values()}
    for name, place in points.items():
        column, row = cell(place)
        label = name + ("_" if name in design.ground.points else ":" if name in guided else "")
        for offset, letter in enumerate(label):
            canvas[column + offset, row] = letter
    rows = max(row for _, row in canvas) + 1
    columns = max(column for column, _ in canvas) + 1
    drawn = ("".join(canvas.get((c, r), " ") for c in range(columns)) for r in range(rows))
    return "\n".join(row.rstrip() for row in drawn)


def joints_in_words(design: Design) -> list[str]:
    """Each joint as a line."""
    lines = [
        f"{point}: pin of {', '.join(map(_named, bodies))}" for point, bodies in design.pins.items()
    ]
    guides = []
    for name, joints in design.joints.items():
        for joint in joints:
            bodies = _named(joint.body_a), _named(joint.body_b)
            if isinstance(joint, loads.Fixed):
                lines.append(f"{name}: weld of {' and '.join(bodies)} at {joint.point}")
            elif not isinstance(joint, loads.Revolute):
                x, y = joint.direction
                between = f", from {joint.ends[0]:g} to {joint.ends[1]:g} mm" if joint.ends else ""
                if joint.point_a not in design.points:
                    guides.append(f"guide of {joint.body_b}{between}")
                    continue
                kind = "slot" if isinstance(joint, loads.Slot) else "guide"
                lines.append(
                    f"{name}: {kind} of {joint.body_b} at {joint.point_b} on {bodies[0]}, "
                    f"through {joint.point_a} along {x:.4g}, {y:.4g}{between}"
                )
    return [*lines, *guides]


def _named(body: str) -> str:
    return "the ground" if body == loads.GROUND else body
