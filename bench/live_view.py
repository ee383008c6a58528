"""Cost of the live view: its size, its encoder, and its steps in a browser without a GPU.

python -m bench.live_view   prints JSON, exits with 1 if a limit is broken; about a minute

Five parts of 33 600 surface nodes with fields of a really solved part: the slider-crank's crank, as
half and mirrored; and these fields again, times a wave along the part, since unit loads that
balance each other are alike away from the bores. Each part takes others of them, driven by
harmonics of the cycle that nothing relates to each other, so that none can be left out.
"""

import asyncio
import json
import os
import platform
import shutil
import sys
import tempfile
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from ballesta.design.read import read_design
from checks.ladder.part_fields import without_rigid_motion
from checks.result.live_fields import EncodedPart, LiveFields
from checks.strength.part_strength import elastic_of
from checks.stress.solid_mesh_level import Models, mirrored, surface_triangles
from fem.stress_history import StressHistory
from geometry.shape import Half
from reports.live.encode import encode

PARTS, POSITIONS, TRIES = 5, 361, 3
FINENESS = 1.96  # the next coarser mesh has 29 000 surface nodes
LIMITS = {
    "12 fields, MB": 9.0,
    "12 fields, encoding s": 7.0,
    "18 fields and displacement, MB": 16.0,
    "18 fields and displacement, encoding s": 7.0,
    "decode ms": 400.0,
    "step ms": 10.0,
    "peak off, % of the cycle's": 0.2,
}
_IMAGE = np.array([1, 1, 1, 1, -1, -1])
_FOLDER = Path(__file__).parents[1] / "reports" / "live"
_SCRIPTS = ("data", "viewer", "fields")
_PAGE = """<!doctype html><meta charset="utf-8"><title>bench</title>
<script type="text/plain" id="text">{text}</script>
<script type="application/json" id="head">{head}</script>
<script>{script}; globalThis.api = {{ decodePart, fieldValues }};</script>"""
_MEASURE = """async ([positions]) => {
  const head = JSON.parse(document.getElementById("head").textContent);
  const text = document.getElementById("text").textContent;
  let start = performance.now();
  const part = await api.decodePart(text, head);
  const decode = performance.now() - start;
  const out = new Float32Array(part.n);
  const peaks = positions.map((index) => api.fieldValues(part, 0, index, "mises", out).max);
  start = performance.now();
  for (const index of positions) api.fieldValues(part, 0, index + 0.5, "mises", out);
  return { decode, peaks, step: (performance.now() - start) / positions.length };
}"""


def solved() -> dict[str, Any]:
    """The surface of the solved part, and its unit stresses and displacements."""
    part = read_design(Path(__file__).parents[1] / "designs" / "slider_crank.toml").parts["crank"]
    solutions = Models().solutions(Half(part.geometry), FINENESS, elastic_of(part))
    mesh, nodes = solutions.mesh, solutions.recovery.points
    on_cut = np.isin(nodes, mesh.cut_nodes)
    points, triangles, beside = mirrored(mesh.nodes[nodes], surface_triangles(mesh, nodes), on_cut)
    stress = np.moveaxis(solutions.basis, 2, 0)
    moved = np.moveaxis(solutions.displacement.reshape(len(mesh.nodes), 3, -1)[nodes], 2, 0)
    moved = np.concatenate([moved, moved[:, beside] * [1, 1, -1]], axis=1)
    stress = np.concatenate([stress, stress[:, beside] * _IMAGE], axis=1)
    wave = np.cos(8 * np.pi * points[:, 0] / np.ptp(points[:, 0]))[:, None]
    return {
        "nodes": points,
        "triangles": triangles,
        "stress": np.concatenate([stress, stress * wave]),
        "displacement": without_rigid_motion(points, np.concatenate([moved, moved * wave])),
    }


def part_of(surface: dict[str, Any], number: int, count: int, *, moved: bool) -> LiveFields:
    """Some of the unit loads, driven by harmonics that do not depend on each other."""
    random = np.random.default_rng(number)
    chosen = np.sort(random.permutation(len(surface["stress"]))[:count])
    stress = surface["stress"][chosen]
    angle = np.linspace(0, 2 * np.pi, POSITIONS)
    waves = np.array([wave(k * angle) for k in range(1, 11) for wave in (np.cos, np.sin)])
    mixed = random.normal(size=(count, len(waves))) / (1 + np.arange(len(waves)) // 2)
    sizes = np.abs(stress).max(axis=(1, 2))
    coefficients = mixed @ waves / sizes[:, None] * 100
    coefficients += random.normal(size=(count, 1)) * 50 / sizes[:, None]
    history = StressHistory(
        np.arange(len(surface["nodes"])), surface["nodes"], np.moveaxis(stress, 0, 2), coefficients
    )
    return LiveFields(
        nodes=surface["nodes"],
        triangles=surface["triangles"],
        stress=stress,
        displacement=surface["displacement"][chosen] if moved else None,
        coefficients={"cycle": coefficients},
        peaks={"cycle": history.peaks_by_position()[0]},
    )


def encoded(parts: list[LiveFields]) -> tuple[list[EncodedPart], float]:
    """The parts as text, and how long that took, s: the best of some tries."""
    taken = []
    for _ in range(TRIES):
        start = perf_counter()
        done = [encode(part, ["cycle"]) for part in parts]
        taken.append(perf_counter() - start)
    return done, min(taken)


async def browsed(part: EncodedPart, positions: list[int]) -> dict[str, Any]:
    """Times of decoding and stepping in Chromium, best of three pages, and the peaks it finds."""
    from playwright.async_api import async_playwright

    script = "".join((_FOLDER / f"{name}.js").read_text() for name in _SCRIPTS)
    head = json.dumps({**part.head, "name": "part"}).replace("<", "\\u003c")
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--disable-gpu"], chromium_sandbox=False
        )
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "page.html"
            file.write_text(_PAGE.format(text=part.text, head=head, script=script))
            tries: list[dict[str, Any]] = []
            for _ in range(3):
                page = await browser.new_page()
                await page.goto(file.as_uri())
                tries.append(await page.evaluate(_MEASURE, [positions]))
                await page.close()
        told = {"browser": browser.version, "peaks": tries[0]["peaks"]}
        await browser.close()
    return told | {name: min(one[name] for one in tries) for name in ("decode", "step")}


def main() -> int:
    """Measure, print, and compare with the limits."""
    surface = solved()
    plain = [part_of(surface, number, 12, moved=False) for number in range(PARTS)]
    full = [part_of(surface, number, 18, moved=True) for number in range(PARTS)]
    small, small_seconds = encoded(plain)
    large, large_seconds = encoded(full)
    positions = list(range(0, POSITIONS, POSITIONS // 36))
    found = asyncio.run(browsed(small[0], positions))
    exact = plain[0].peaks["cycle"]
    off = np.abs(np.array(found["peaks"]) - exact[positions]).max() / exact.max()
    rows = {
        "12 fields, MB": sum(len(part.text) for part in small) / 1e6,
        "12 fields, encoding s": small_seconds,
        "18 fields and displacement, MB": sum(len(part.text) for part in large) / 1e6,
        "18 fields and displacement, encoding s": large_seconds,
        "decode ms": found["decode"],
        "step ms": found["step"],
        "peak off, % of the cycle's": 100 * float(off),
    }
    told = {
        "machine": f"{os.cpu_count()} cores, {platform.machine()}, no GPU",
        "browser": f"Chromium {found['browser']}",
        "nodes": len(surface["nodes"]),
        "fields written": [part.head["fields"] for part in small + large],
        "measured error, % of the peak": [100 * part.head["accuracy"]["share"] for part in small],
        **rows,
    }
    broken = [name for name, limit in LIMITS.items() if rows[name] > limit]
    print(json.dumps(told | {"broken": broken}, indent=1))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
