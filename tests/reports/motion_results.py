"""Results whose parts move: the toggle press' two bars and its pin, a crank, and hostile names."""

from dataclasses import replace

import numpy as np

from checks.result.motion import PartsMotion, PinForce
from geometry.mesh import FloatArray
from loads import GROUND, JointLoad

from . import loads_results, results


def between(rows: FloatArray, row: float) -> FloatArray:
    """Values at a fractional row of an array, linear between its rows; outside the nearest."""
    row = min(max(row, 0.0), len(rows) - 1.0)
    low = min(int(row), max(len(rows) - 2, 0))
    high = min(low + 1, len(rows) - 1)
    share = row - low
    return np.asarray((1.0 - share) * rows[low] + share * rows[high])


def rows_of(load, rows):
    fields = ("force", "moment", "friction_couple", "friction_force")
    return JointLoad(**{name: getattr(load, name)[rows] for name in fields})


def motion(shown, parts, forces, every=1, layer=None):
    """Motion of a cycle: parts name -> body; forces (part, interface, body, point, (n, 2) N)."""
    loads = shown.loads
    rows = np.arange(0, len(loads.times), every)
    names = loads.linkage.body_names
    return PartsMotion(
        index=rows,
        times=loads.times[rows],
        parts={part: loads.poses[rows, names.index(body)] for part, body in parts.items()},
        layer=layer or {part: 10.0 * k for k, part in enumerate(parts)},
        layers_told="Nothing states where the parts stand across the plane.",
        pins={
            f"{part} {interface}": PinForce(
                part, interface, point, loads.point(body, point)[rows], force[rows]
            )
            for part, interface, body, point, force in forces
        },
        bodies=parts,
        linkage=loads.linkage,
        poses=loads.poses[rows],
        reactions={name: rows_of(load, rows) for name, load in loads.reactions.items()},
        efforts={name: effort[rows] for name, effort in loads.efforts.items()},
    )


def placed(motion, part, nodes, row):
    """Nodes (n, 3) of a part's frame, in the machine's frame at a row (fractional), mm."""
    x, y, angle = between(motion.parts[part], row)
    c, s = np.cos(angle), np.sin(angle)
    across, up, height = np.asarray(nodes).T
    return np.column_stack(
        [x + c * across - s * up, y + s * across + c * up, height + motion.layer[part]]
    )


def cycle_of(shown, **peaks):
    loads = shown.loads
    return results.cycle() | {
        "shown_name": shown.shown_name, "unit": shown.unit, "position": shown.shown.tolist(),
        "time": loads.times.tolist(), "phase": [shown.phase_at(k) for k in range(len(loads.times))],
        "peaks": {name: np.asarray(peak).tolist() for name, peak in peaks.items()},
    }  # fmt: skip


def press(every=2):
    """The press with a bar, another, and the pin of the knee; a run that was measured beside it."""
    shown = loads_results.press()
    reactions = shown.loads.reactions
    at_a, at_b = reactions["A"].force, reactions["B"].force
    moved = motion(
        shown,
        {"bar_upper": "upper", "bar_lower": "lower"},
        [
            ("bar_upper", "end", "upper", "A", at_a),
            ("bar_upper", "knee", "upper", "B", at_b),
            ("bar_lower", "knee", "lower", "B", -at_b),
        ],
        every,
    )
    n, k = len(shown.loads.times), len(moved.index)
    pin = PinForce(
        "pin_B", "upper", "B", shown.loads.point("upper", "B")[moved.index], np.ones((k, 2))
    )
    frame = np.column_stack([pin.place, np.zeros(k)])
    moved = replace(
        moved,
        parts={**moved.parts, "pin_B": frame},
        layer={**moved.layer, "pin_B": 0.0},
        bodies={**moved.bodies, "pin_B": "lower"},
        pins={**moved.pins, "pin_B upper": pin},
    )
    peak = np.exp(-(((np.arange(n) - n // 2) / 20) ** 2))
    parts = [
        results.part(name, [results.check(name, utilisation)])
        for name, utilisation in (
            ("bar_upper", "static"),
            ("bar_lower", "static"),
            ("pin_B", "static"),
        )
    ]
    return results.design(
        *parts,
        cycles={"press": cycle_of(shown, bar_upper=peak), "rig": results.cycle()},
        motion={"press": moved},
    )


def crank():
    """A crank with a torque, and a part whose contact slides along it."""
    shown = loads_results.crank()
    n = len(shown.loads.times)
    moved = motion(shown, {"crank": "crank"}, [])
    slid = np.column_stack([np.linspace(0, 40, n), np.zeros(n)])
    pins = {
        "crank contact": PinForce("crank", "contact", "slot", slid, np.full((n, 2), 50.0)),
        "crank pin": PinForce(
            "crank", "pin", "O", shown.loads.point(GROUND, "O"), np.full((n, 2), -50.0)
        ),
    }
    return results.design(
        results.part("crank", [results.check("crank", cycle="run")]),
        cycles={"run": cycle_of(shown, crank=np.arange(n))},
        motion={"run": replace(moved, pins=pins)},
    )


def hostile():
    """A pendulum in which every name is markup."""
    (shown,) = loads_results.hostile().cycles
    name = results.HOSTILE
    force = np.column_stack([np.arange(30.0), np.ones(30)])
    moved = motion(shown, {name: name}, [(name, name, name, name, force)])
    return results.design(
        results.part(name, [results.check(name, cycle=name)]),
        name=name,
        cycles={name: cycle_of(shown), name + "2": results.cycle()},
        motion={name: moved},
    )
