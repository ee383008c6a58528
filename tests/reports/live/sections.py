"""A small design whose live view tests look at, made without a solver, and a page of it alone."""

from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from types import SimpleNamespace
from typing import Any

import numpy as np

from checks.result.live_fields import LiveFields, LivePeak, grey, von_mises
from checks.result.verdict import Check, DesignResult, PartResult, Surface
from reports.live.section import live_section, style_text
from reports.templating import LIVE, joined

POSITIONS = 73
CYCLES = ("turn", "hold")


def tube(inner=18.0, outer=30.0, height=40.0, around=48, along=10):
    """Nodes (n, 3) and triangles of a closed ring about z, seen from outside against the clock."""
    angles = 2 * np.pi * np.arange(around) / around
    levels = np.linspace(-height / 2, height / 2, along + 1)
    thick = [outer, (inner + outer) / 2, inner]
    section = [(outer, z) for z in levels]
    section += [(r, height / 2) for r in thick[1:]]
    section += [(inner, z) for z in levels[::-1][1:]]
    section += [(thick[1], -height / 2)]
    return _swept(section, angles)


def _swept(section, angles):
    count, around = len(section), len(angles)
    r, z = np.array(section).T
    nodes = np.stack(
        [
            np.outer(np.cos(angles), r).ravel(),
            np.outer(np.sin(angles), r).ravel(),
            np.tile(z, around),
        ],
        axis=1,
    )
    i, k = (grid.ravel() for grid in np.meshgrid(np.arange(around), np.arange(count)))
    a, b = i * count + k, (i + 1) % around * count + k
    c, d = (i + 1) % around * count + (k + 1) % count, i * count + (k + 1) % count
    return nodes, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def bar(length=160.0, radius=12.0, around=40, along=60):
    """Nodes and triangles of a round bar along x with closed ends."""
    section = [
        (1e-3, -length / 2),
        *((radius, z) for z in np.linspace(-length / 2, length / 2, along)),
    ]
    section += [(1e-3, length / 2)]
    nodes, triangles = _swept(section, 2 * np.pi * np.arange(around) / around)
    return nodes[:, [2, 0, 1]], triangles


def sheet(length=120.0, height=60.0, n=24):
    """Nodes and triangles of a flat sheet, which has a rim."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, n), np.linspace(-0.5, 0.5, n), indexing="ij")
    nodes = np.stack([length * u.ravel(), height * v.ravel(), 0 * u.ravel()], axis=1)
    k = np.arange(n * n).reshape(n, n)
    a, b, c, d = (x.ravel() for x in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    return nodes, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def coefficients(count=4, positions=POSITIONS, rate=1.0):
    """Smooth, closed coefficients (count, positions)."""
    t = np.linspace(0.0, 2 * np.pi, positions)
    return np.stack([np.cos(rate * (k + 1) * t / 2 + k) * (3 - 0.5 * k) for k in range(count)])


def live(nodes, triangles, *, hot, count=4, moved=True, fatigue=True):
    """Fields with a hot spot near the place `hot` (3,), mm."""
    size = np.ptp(nodes, axis=0).max()
    spot = np.exp(-((nodes - hot) ** 2).sum(axis=1) / (0.15 * size) ** 2)
    stress = np.zeros((count, len(nodes), 6))
    for j in range(count):
        wave = np.sin((j + 1) * nodes / size * 3 + j)
        stress[j, :, :3] = 4 * wave + 20 * spot[:, None] * [1.0, 0.3 * j, -0.4]
        stress[j, :, 3:] = 2 * wave[:, ::-1] + 6 * spot[:, None] * [0.5, 0.1, 0.2 * j]
    shape = np.stack(
        [0 * nodes[:, 0], (nodes[:, 0] / size) ** 2, np.sin(nodes[:, 0] / size)], axis=1
    )
    given = {"turn": coefficients(count), "hold": 0.5 * coefficients(count, 25, 0.5)}
    peaks = {name: _peaks(stress, weights) for name, weights in given.items()}
    cycle = max(peaks, key=lambda name: max(value for value, _ in peaks[name]))
    position = int(np.argmax([value for value, _ in peaks[cycle]]))
    value, node = peaks[cycle][position]
    use = {
        "utilisation": 0.2 + 0.7 * spot,
        "amplitude": 30 * spot + 1,
        "mean": 20 * spot - 15 * nodes[:, 0] / size,
    }
    return LiveFields(
        nodes=nodes,
        triangles=triangles,
        stress=stress,
        displacement=0.01 * np.stack([(j + 1) * shape for j in range(count)]) if moved else None,
        coefficients=given,
        peaks={name: np.array([v for v, _ in found]) for name, found in peaks.items()},
        fatigue=use if fatigue else {},
        missing={
            **({} if moved else {"displacement": "rigid motion is unknown"}),
            **({} if fatigue else dict.fromkeys(use, "no cycle is in the duty")),
        },
        peak=LivePeak(node, cycle, position, value, "hot spot"),
    )


def _peaks(stress, weights):
    found = []
    for column in weights.T:
        mises = von_mises(np.einsum("jnc,j->nc", stress, column))
        found.append((float(mises.max()), int(mises.argmax())))
    return found


def part(name, fields, shape="ring"):
    """A part with such fields and one check."""
    peak = fields.peak.value if fields.peak else 10.0
    check = Check(
        part=name, kind="static", quantity="peak von Mises stress", value=peak, unit="MPa",
        numerical=0.5, model=0.0, limit=355.0, required=1.5, cycle="turn", position="x = 1 deg",
        place="rim", method="solid" if fields.peak else "formula", basis="yield",
    )  # fmt: skip
    surface = Surface(
        fields.nodes, fields.triangles, {"von Mises [MPa]": np.zeros(len(fields.nodes))}, 0
    )
    return PartResult(
        name=name, shape=shape, material="S355", checks=[check], gates=[], hand_checks=[],
        meshes=[], facts={}, charts={}, surface=surface, live=fields,
    )  # fmt: skip


def motion(names, positions=POSITIONS):
    """A motion of the parts round a circle, with a turning force on each."""
    index = np.arange(0, positions, 2)
    t = 2 * np.pi * index / (positions - 1)
    parts, pins = {}, {}
    for k, name in enumerate(names):
        place = np.stack([60 * k + 20 * np.cos(t), 20 * np.sin(t + k), 0.3 * np.sin(t)], axis=1)
        parts[name] = place
        pins[f"{name} eye"] = SimpleNamespace(
            halves=(),
            on=name, interface="eye", place=place[:, :2], z=12.0,
            force=1e4 * (k + 1) * np.stack([np.cos(2 * t), np.sin(t)], axis=1),
        )  # fmt: skip
    return SimpleNamespace(
        index=index, times=t, parts=parts, layer={name: 15.0 * k for k, name in enumerate(names)},
        layers_told="Layers are spread for the picture.", pins=pins, bodies={},
    )  # fmt: skip


def design(**changes) -> DesignResult:
    """A ring with stress, a bar with less known of it, a grey plate; two cycles, one in motion."""
    ring = live(*tube(), hot=[18.0, 0.0, -14.0])
    shaft = live(*bar(), hot=[40.0, 12.0, 0.0], moved=False, fatigue=False)
    plain = grey(*tube(6.0, 20.0, 8.0, 24, 2), "not meshed: decided by a formula")
    parts = [part("ring", ring), part("shaft", shaft), part("plate", plain)]
    cycles = {}
    for name, n in zip(CYCLES, (POSITIONS, 25), strict=True):
        peaks = {each.name: each.live.peaks[name].tolist() for each in parts[:2]}
        cycles[name] = {
            "shown_name": "crank", "unit": "deg", "position": np.linspace(0, 360, n).tolist(),
            "time": np.linspace(0, 2.0, n).tolist(), "efforts": {}, "torques": {}, "links": {},
            "phase": ["out"] * (n // 2) + ["back"] * (n - n // 2), "peaks": peaks, "duty": 1e6,
        }  # fmt: skip
    result = DesignResult(
        name="Ring on a shaft", file="ring.toml", sha256="0" * 64, overrides=[], parts=parts,
        cycles=cycles, gates=[], warnings=[], not_checked=[], assumed=[], defaults=[], inputs=[],
        source="", versions={}, command="", motion={"turn": motion([p.name for p in parts])},
    )  # fmt: skip
    return replace(result, **changes)


def page(result: DesignResult, **section: Any) -> str:
    """A page with nothing but the live view, under the report's content security policy."""
    made = live_section(result, **section)
    script = joined(*(f"live/{name}.js" for name in LIVE))
    digest = b64encode(sha256(script.encode()).digest()).decode()
    policy = (
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    return (
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><title>Live</title>'
        f"<style>{report_style()}\n{style_text()}</style></head><body><main>{made}</main>"
        f"<script>{script}</script></body></html>"
    )


def report_style() -> str:
    """Style of the report, whose tokens the live view uses."""
    from reports.svg import colour_variables
    from reports.templating import environment

    return (
        environment()
        .get_template("report.css")
        .render(light=colour_variables(dark=False), dark=colour_variables(dark=True))
    )
