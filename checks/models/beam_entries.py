"""Wrenches of a part's interfaces as loads on its frame, column by column."""

from collections.abc import Callable, Iterable

import numpy as np

from checks.models.beam_parts import Entry
from fem.frame import POINTS, WEIGHTS, Frame, FrameLoads
from fem.sliding import sliding_coefficients, stations
from fem.unit_loads import HARMONICS, bearing_coefficients
from geometry.mesh import FloatArray, IntArray, Interface

PLANAR = [0, 1, 5]
TILTS = [3, 4]
BEARING = (
    *(name for n in HARMONICS for name in ((f"cos {n}", f"sin {n}") if n else ("cos 0",))),
    "couple",
)
_COLUMNS = (*BEARING, "M_x", "M_y")


def tilting(frame: Frame, node: int) -> FrameLoads:
    """Two cases: unit couples about x and y at a node."""
    return at_node(frame, node).combined(np.eye(6)[:, TILTS])


def at_node(frame: Frame, node: int) -> FrameLoads:
    """Six cases: unit forces and couples at a node."""
    loads = frame.no_loads(6)
    loads.nodal[6 * node + np.arange(6), np.arange(6)] = 1.0
    return loads


def pressed(
    frame: Frame, spans: Iterable[tuple[float, float]], axis: int, centre: float
) -> FrameLoads:
    """Six cases, evenly over stretches along global `axis`; couples as a load that grows linearly.

    spans   where the load stands; nodes stand at their ends
    centre  about which the couples turn

    A couple about the axis itself is shared evenly by the nodes.
    """
    places = frame.points[..., axis]  # (m, 6)
    middle = places.mean(axis=1)
    inside = np.zeros(len(middle), dtype=bool)
    for low, high in spans:
        inside |= (middle > low) & (middle < high)
    if not inside.any():
        raise ValueError(f"no member of the frame stands between {list(spans)} mm")
    weight = np.where(inside[:, None], WEIGHTS * frame.lengths[:, None], 0.0)
    arm = places - centre
    total, second = float(weight.sum()), float((weight * arm**2).sum())
    loads = frame.no_loads(6)
    for k in range(3):
        loads.distributed[inside, :, k, k] = 1 / total
    # r x F about the axis' two neighbours: e_axis x e_j = e_k
    j, k = (axis + 1) % 3, (axis + 2) % 3
    loads.distributed[inside, :, j, 3 + k] = arm[inside] / second
    loads.distributed[inside, :, k, 3 + j] = -arm[inside] / second
    share = frame.lengths * inside / total / 2
    for end in (0, 1):
        np.add.at(loads.nodal[:, 3 + axis], 6 * frame.members[:, end] + 3 + axis, share)
    return loads


def journal_entry(interface: Interface, wrench: FrameLoads) -> Entry:
    """Columns of a journal as `bearing_coefficients` has them, then the tilting couples.

    wrench  six cases, how its forces and couples come into the frame
    """
    mix = np.zeros((6, len(BEARING) + 2))
    for row, name, value in (
        (0, "cos 1", -1.0),
        (1, "sin 1", -1.0),
        (5, "couple", 1.0),
        (3, "M_x", 1.0),
        (4, "M_y", 1.0),
    ):
        mix[row, _COLUMNS.index(name)] = value
    return Entry(interface, _COLUMNS, wrench.combined(mix))


def bore_entry(frame: Frame, interface: Interface, tilted: FrameLoads) -> Entry:
    """Columns of a bore across a bar along x, its pressure on the nodes that stand within it.

    tilted  two cases, how its couples about x and y come into the frame

    The rim is cut half-way between the nodes' angles, r cos(angle) = x - centre; each arc with its
    image about the bar's axis presses on its node with its force, and turns it with its couple.
    Nodes side by side share it.
    """
    radius, centre = interface.radius, float(interface.centre[0])
    x = frame.nodes[:, 0] - centre
    close = 1e-9 * radius
    on_axis = np.flatnonzero((np.abs(frame.nodes[:, 1]) < close) & (np.abs(x) <= radius + close))
    places = np.unique(np.round(x[on_axis] / close))[::-1] * close
    angles = np.arccos(np.clip(places / radius, -1.0, 1.0))
    edges = np.r_[0.0, (angles[1:] + angles[:-1]) / 2, np.pi]
    loads = frame.no_loads(len(BEARING))
    for place, low, high in zip(places, edges[:-1], edges[1:], strict=True):
        angle = low + (high - low) * POINTS
        weight = 2 * WEIGHTS * (high - low) * radius  # both arcs
        rim = radius * np.stack([np.cos(angle), np.sin(angle)])
        nodes = on_axis[np.abs(x[on_axis] - place) <= 2 * close]
        for column, (along, across) in enumerate(_tractions(angle, radius)):
            even = BEARING[column].startswith("cos")
            force = (weight @ along, 0.0) if even else (0.0, weight @ across)
            turn = 0.0 if even else weight @ ((rim[0] - place) * across - rim[1] * along)
            for node in nodes:
                share = np.array([*force, turn]) / len(nodes)
                loads.nodal[6 * node + np.array(PLANAR), column] += share
    both = FrameLoads(
        np.concatenate([loads.nodal, tilted.nodal], axis=-1),
        np.concatenate([loads.distributed, tilted.distributed], axis=-1),
    )
    return Entry(interface, _COLUMNS, both)


def _tractions(angle: FloatArray, radius: float) -> list[tuple[FloatArray, FloatArray]]:
    """Traction along x and y of each column at angles of a bore's rim, per mm of rim, 1/mm."""
    outward = np.cos(angle), np.sin(angle)
    found = []
    for name in BEARING[:-1]:
        wave, n = name.split()
        size = (np.cos if wave == "cos" else np.sin)(int(n) * angle) / (np.pi * radius)
        found.append((size * outward[0], size * outward[1]))
    turn = 1 / (2 * np.pi * radius**2)
    return [*found, (-turn * outward[1], turn * outward[0])]


def planar_entry(interface: Interface, wrench: FrameLoads) -> Entry:
    """Columns of a face or clamp: F_x, F_y, M_z."""
    return Entry(interface, ("F_x", "F_y", "M_z"), wrench.combined(np.eye(6)[:, PLANAR]))


def hat(frame: Frame, members: IntArray, place: float, spacing: float) -> FloatArray:
    """Load per length (m, 6) along x of 1 N on some members, as a hat of half-width `spacing`.

    Nodes stand at its top and at both its ends.
    """
    x = frame.points[members, :, 0]
    height = np.maximum(0.0, 1 - np.abs(x - place) / spacing)
    size = float((height * WEIGHTS * frame.lengths[members, None]).sum())
    result = np.zeros((len(frame.members), len(POINTS)))
    result[members] = height / size
    return result


def slide_entry(
    frame: Frame,
    interface: Interface,
    flanks: tuple[IntArray, IntArray],
    nodes: Callable[[float, int], int] | None = None,
    lever: float = 0.0,
) -> Entry:
    """Columns of a contact that moves along x, as `sliding_coefficients` has them.

    flanks  members that a force along +y presses on, and one along -y
    nodes   node of a flank (0, 1) at a station, where friction beside its axis turns it
    lever   mm, from that axis to the flank, towards the middle
    """
    places = stations(interface)
    spacing = float(places[1] - places[0])
    names, cases = [], frame.no_loads(3 * len(places))
    for i, place in enumerate(places):
        x = float(interface.centre[0] + place)
        hats = [hat(frame, members, x, spacing) for members in flanks]
        for k, (name, axis, sides) in enumerate(
            (("+", 1, ((0, 1.0),)), ("-", 1, ((1, -1.0),)), ("t", 0, ((0, 0.5), (1, 0.5))))
        ):
            names.append(f"{name} {i}")
            for side, size in sides:
                cases.distributed[:, :, axis, 3 * i + k] += size * hats[side]
        if nodes is not None:
            for side, turn in ((0, lever), (1, -lever)):
                cases.nodal[6 * nodes(x, side) + 5, 3 * i + 2] += turn / 2
    return Entry(interface, tuple(names), cases)


def entry_coefficients(entry: Entry, wrench: FloatArray, reach: FloatArray | None) -> FloatArray:
    """Coefficients (n, columns) of an interface's columns for its wrenches (n, 6)."""
    planar = wrench[:, PLANAR]
    match entry.interface.kind:
        case "bore" | "journal":
            inward = entry.interface.kind == "journal"
            return np.hstack([bearing_coefficients(planar, inward), wrench[:, TILTS]])
        case "slide":
            assert reach is not None
            return sliding_coefficients(entry.interface, planar, reach)
        case _:
            return np.asarray(planar)


def reached(entry: Entry) -> list[int]:
    """Which of a wrench's six parts come into the frame."""
    return [0, 1, 3, 4, 5] if entry.interface.kind in ("bore", "journal") else PLANAR
