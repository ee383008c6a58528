"""Time and memory of a whole report with its live view in a browser without a GPU.

python -m bench.live_page   prints JSON, exits with 1 if a limit is broken; about half a minute
python -m bench.live_page out/toggle_press/report.html ...   the same of reports that are there

Without paths: five parts of 33 600 surface nodes with 12 fields each (bench.live_view), in one
report. A step is all that a move of the slider does: fields, words, mechanism, charts, picture,
until its last pixel is drawn. It goes through the cycle that the page begins with.
"""

import asyncio
import json
import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.live_view import PARTS, POSITIONS, part_of, solved
from checks.result.verdict import Check, DesignResult, PartResult, Surface
from reports.page import report_html

LIMITS = {"ready ms": 1000.0, "step ms": 50.0}
TRIES, STEPS = 3, 40
_WATCH = """new MutationObserver(() => {
  if (document.documentElement.dataset.live === "ready") window.readyAt ??= performance.now();
}).observe(document, { attributes: true, subtree: true, attributeFilter: ["data-live"] });"""
_STEP = """(steps) => {
  const gl = ballesta.live.context(), pixel = new Uint8Array(4), taken = [];
  const { cycle } = ballesta.current, positions = ballesta.cycles[cycle].position.length;
  for (let k = 0; k < steps; k++) {
    const start = performance.now();
    ballesta.setPosition(cycle, (k * 7) % positions);
    ballesta.live.draw();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); // waits for the picture
    taken.push(performance.now() - start);
  }
  const { width, height } = ballesta.live.camera;
  return { taken, canvas: `${width} x ${height}` };
}"""


def report() -> str:
    """The page of a made-up design of five really solved parts."""
    surface, parts = solved(), []
    for number in range(PARTS):
        live, name = part_of(surface, number, 12, moved=False), f"part {number}"
        check = Check(
            part=name, kind="static", quantity="von Mises stress", unit="MPa", numerical=1.0,
            value=float(live.peaks["cycle"].max()), model=0.0, limit=1e4, required=1.5,
            cycle="cycle", position="", place="", method="solid", basis="",
        )  # fmt: skip
        shown = Surface(live.nodes, live.triangles, {}, 0)
        parts.append(PartResult(name, "", "", [check], [], [], [], {}, {}, shown, live=live))
    moments = np.linspace(0.0, 1.0, POSITIONS).tolist()
    cycle = {
        "shown_name": "angle", "unit": "deg", "position": [360 * t for t in moments],
        "time": moments, "phase": ["turn"] * POSITIONS, "efforts": {}, "torques": {}, "links": {},
        "peaks": {part.name: part.live.peaks["cycle"].tolist() for part in parts}, "duty": 0.0,
    }  # fmt: skip
    result = DesignResult(
        name="Five parts", file="five.toml", sha256="", overrides=[], parts=parts,
        cycles={"cycle": cycle}, gates=[], warnings=[], not_checked=[], assumed=[], defaults=[],
        inputs=[], source="", versions={}, command="",
    )  # fmt: skip
    return report_html(result)


async def browsed(file: Path) -> dict[str, Any]:
    """Moment at which a page is ready, and the median step, of the best of some tries."""
    from playwright.async_api import async_playwright

    tries: list[dict[str, Any]] = []
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--disable-gpu"], chromium_sandbox=False
        )
        for _ in range(TRIES):
            page = await browser.new_page(viewport={"width": 1180, "height": 815})
            await page.add_init_script(_WATCH)
            await page.goto(file.resolve().as_uri())
            await page.locator("html[data-live=ready]").wait_for(state="attached")
            await page.wait_for_timeout(500)
            tried = await page.evaluate(_STEP, STEPS)
            tries.append(tried | {"ready": await page.evaluate("readyAt")})
            await page.close()
        version = browser.version
        await browser.close()
    return {
        "browser": f"Chromium {version}",
        "canvas": tries[0]["canvas"],
        "ready ms": min(tried["ready"] for tried in tries),
        "step ms": min(float(np.median(tried["taken"])) for tried in tries),
    }


def measured(file: Path) -> dict[str, Any]:
    """Measurements of a report, and the limits that it breaks."""
    found = asyncio.run(browsed(file))
    broken = [name for name, limit in LIMITS.items() if found[name] > limit]
    return {"page, MB": file.stat().st_size / 1e6, **found, "broken": broken}


def main(paths: Sequence[str]) -> int:
    """Measure, print, and compare with the limits."""
    machine = f"{os.cpu_count()} cores, {platform.machine()}, no GPU"
    if paths:
        each = {path: measured(Path(path)) for path in paths}
        print(json.dumps({"machine": machine, **each}, indent=1))
        return 1 if any(found["broken"] for found in each.values()) else 0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "report.html"
        file.write_text(report(), encoding="utf-8")
        found = measured(file)
    print(json.dumps({"machine": machine, **found}, indent=1))
    return 1 if found["broken"] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
