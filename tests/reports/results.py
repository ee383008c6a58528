"""A made-up result of two box-shaped parts, in which every kind of outcome occurs."""

from dataclasses import replace
from math import inf

import numpy as np

from checks.result.derivation import HandComparison
from checks.result.verdict import Check, DesignResult, Gate, PartResult, Surface

HOSTILE = "<script>alert('x')</script>\"&$\\frac{1}{0}$ \x1b[31m\u202e😀"


def box(size=(250.0, 80.0, 60.0), n=12):
    """A closed box with shared nodes and a stress that peaks at the corner of the first axis."""
    grid = [np.linspace(0, length, n + 1) for length in size]
    nodes, triangles = [], []
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, 1):
            u, v = np.meshgrid(grid[one], grid[two], indexing="ij")
            points = np.zeros((u.size, 3))
            points[:, one], points[:, two] = u.ravel(), v.ravel()
            points[:, axis] = end * size[axis]
            index = np.arange(u.size).reshape(u.shape) + sum(map(len, nodes))
            a, b, c, d = (
                index[:-1, :-1].ravel(), index[1:, :-1].ravel(),
                index[1:, 1:].ravel(), index[:-1, 1:].ravel(),
            )  # fmt: skip
            faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
            triangles.append(faces if end else faces[:, ::-1])
            nodes.append(points)
    nodes = np.concatenate(nodes)
    stress = 140 * np.exp(-np.linalg.norm(nodes - [size[0], 0, size[2]], axis=1) / 60)
    return Surface(
        nodes=nodes,
        triangles=np.concatenate(triangles),
        fields={"von Mises [MPa]": stress, "displacement x": nodes[:, 0] * 1e-4},
        peak=int(stress.argmax()),
    )


def check(part="bar_upper", kind="static", **changes):
    values = {
        "part": part, "kind": kind, "quantity": "von Mises stress", "value": 141.0, "unit": "MPa",
        "numerical": 4.0, "model": 20.0, "limit": 355.0, "required": 1.5, "cycle": "press",
        "position": "x = 2 mm", "place": "hole B", "method": "solid elements",
        "basis": "yield strength, 95 % survive", "note": "",
    } | changes  # fmt: skip
    return Check(**values)


PASSING = check()
FAILING = check(kind="fatigue", value=180.0, limit=150.0, required=1.3, quantity="Goodman")
UNDECIDED = check(value=225.0, note="the model's bar holds the limit")
SINGULAR = check(kind="edge", numerical=inf, note="sharp inner corner", place="cut-out")


def haigh():
    cloud = np.column_stack([np.linspace(0, 40, 30), np.linspace(5, 33, 30)])
    return {
        "cycle": "press", "mean": 40.0, "amplitude": 35.0,
        "endurance": 150.0, "ultimate": 470.0, "yield": 355.0, "cloud": cloud.tolist(),
    }  # fmt: skip


def cycle(n=61):
    position = np.concatenate(
        [np.linspace(200, 7, n), np.linspace(7, 2, n), np.linspace(2, 200, n)]
    )
    pressing = np.r_[np.zeros(n), np.ones(n), np.zeros(n)]
    knee = 600 + 78000 * pressing * 2 / position
    return {
        "shown_name": "x",
        "unit": "mm",
        "position": position,
        "time": np.linspace(0, 4.2, 3 * n),
        "phase": ["approach"] * n + ["press"] * n + ["return"] * n,
        "efforts": {"cylinder": 500 + 10500 * pressing, "process": knee * pressing},
        "links": {"bar_upper knee": knee, "bar_lower knee": knee * 1.05},
        "peaks": {"bar_upper": knee / 550, "pin_B": knee / 900},
        "duty": 1.1e7,
    }


def part(name="bar_upper", checks=(PASSING,), **changes):
    values = {
        "name": name, "shape": "toggle_bar", "material": "S355", "checks": list(checks),
        "gates": [Gate("reaction residual", 1e-9, 1e-6, "unbalanced share of the loads")],
        "hand_checks": [HandComparison("axial stress", 40.0, 42.0, "MPa", "F / A")],
        "meshes": [
            {"fineness": 1.0, "unknowns": 30123, "elements": 7000, "peak": 138.2, "seconds": 1.2},
            {"fineness": 0.7, "unknowns": 81234, "elements": 20000, "peak": 141.0, "seconds": 4.0},
        ],
        "facts": {"mass [kg]": 4.14134, "section": "tube 80 x 80 x 6.3"},
        "charts": {"haigh": haigh()}, "surface": box(), "assumed": ["bearing arc 120 deg"],
    }  # fmt: skip
    return PartResult(**(values | changes))


def design(*parts, **changes):
    values = {
        "name": "Toggle press", "file": "toggle_press.toml", "sha256": "ab" * 32, "overrides": [],
        "parts": list(parts or (part(),)), "cycles": {"press": cycle()},
        "gates": [Gate("loop closure", 1e-12, 1e-9, "largest gap of a joint over the cycle, mm")],
        "warnings": ["stroke takes 4.2 s, duty allows 3.0 s"],
        "not_checked": ["contact fatigue", "wear", "frame"],
        "assumed": [("cycles.press.stop", "x = 2 mm, nothing mechanical ends the stroke")],
        "defaults": [("gravity", "0, -9.81 m/s2")],
        "inputs": [("name", "Toggle press"), ("parts.bar_upper.wall", "6.3 mm")],
        "source": 'name = "Toggle press"\naccuracy = "5 %"\n',
        "versions": {"ballesta": "0.1.0", "numpy": "2.4"},
        "command": "ballesta check toggle_press.toml", "timings": {"mesh": 6.0, "solve": 19.25},
    }  # fmt: skip
    return DesignResult(**(values | changes))


def mixed():
    """Four outcomes on two parts; fatigue of bar_upper decides."""
    pin = part(
        "pin_B",
        [check("pin_B", value=56.0, limit=650.0), replace(SINGULAR, part="pin_B")],
        charts={},
        surface=box((160.0, 40.0, 40.0)),
    )
    return design(part(checks=[PASSING, UNDECIDED, FAILING]), pin)


def hostile():
    """A name of 10 000 characters, one with markup, an escape sequence and a turned direction."""
    long = "W" * 10_000
    bad = part(HOSTILE, [check(HOSTILE, place=HOSTILE, note=HOSTILE, method=long)])
    wide = part(long, [check(long, quantity=long)])
    shown = cycle() | {"links": {HOSTILE: cycle()["links"]["bar_upper knee"]}}
    return design(
        bad, wide, name=long + HOSTILE, warnings=[HOSTILE, long], file=HOSTILE, source=HOSTILE,
        cycles={HOSTILE: shown, "press": cycle()}, inputs=[(HOSTILE, long), (long, HOSTILE)],
        overrides=[HOSTILE], command=HOSTILE, not_checked=[long], assumed=[(long, HOSTILE)],
        gates=[Gate(HOSTILE, 2.0, 1.0, long)],
    )  # fmt: skip
