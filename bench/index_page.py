"""Time and memory of a large batch's index in a browser without a GPU.

python -m bench.index_page   prints JSON, exits with 1 if a limit is broken; some seconds

2 000 designs of 20 checks each, and 5 000 of 2; all of them in the table; best of three openings,
sorts and drawings of reserve against mass with its Pareto front.
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

from checks.result.verdict import Check
from reports.index_page import IndexDesign, index_html

LIMITS = {"open ms": 2000.0, "sort ms": 1000.0, "front ms": 1000.0}
PAGES, TRIES = ((2000, 20), (5000, 2)), 3  # designs and checks of each
_SORT = """() => {
  const view = document.getElementById("view");
  view.value = "all";
  view.dispatchEvent(new Event("change"));
  const heads = [...document.querySelectorAll("th button")];
  const head = heads.find((button) => button.textContent === "value");
  const start = performance.now();
  head.click();
  document.body.offsetHeight; // laid out
  return performance.now() - start;
}"""
_FRONT = """() => {
  const start = performance.now();
  document.getElementById("y").dispatchEvent(new Event("change"));
  document.body.offsetHeight;
  const taken = performance.now() - start;
  const steps = document.querySelector("path.front").getAttribute("d").match(/H/g).length;
  if (steps < 10) throw new Error(`the front has ${steps} steps only`);
  return taken;
}"""


def index(count: int, each: int) -> str:
    """The page of a made-up batch of so many designs with so many checks each."""
    designs = []
    for k in range(count):
        checks = []
        for n in range(each):
            made = Check(
                part="bar", kind="static", quantity="von Mises stress", unit="MPa", numerical=1.0,
                value=1.0 + (37 * (each * k + n)) % (count * each), model=0.0, limit=355.0,
                required=1.5, cycle="press", position="x = 2 mm", place="knee", method="solid",
                basis="",
            )  # fmt: skip
            checks.append(made.to_dict() | {"check": "static", "governing": n == 0})
        name = f"d{k:04d}"
        designs.append(
            IndexDesign(
                name=name,
                title=name,
                file=f"{name}.toml",
                status="pass",
                error="",
                stage="",
                note="",
                broken_gates=[],
                mass=2.0 - (37 * k % count) / count + 0.1 * (389 * k % count) / count,
                checks=checks,
                link=f"{name}/report.html",
                thumbnail=b"",
            )
        )
    return index_html("batch", designs, {"wall [mm]": [float(k) for k in range(count)]})


async def browsed(file: Path) -> dict[str, Any]:
    """Open the page, draw its front, and sort it by value."""
    from playwright.async_api import async_playwright

    opened, sorted_, drawn = [], [], []
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--disable-gpu"], chromium_sandbox=False
        )
        for _ in range(TRIES):
            page = await browser.new_page(viewport={"width": 1180, "height": 815})
            start = perf_counter()
            await page.goto(file.as_uri())
            opened.append(1e3 * (perf_counter() - start))
            drawn.append(await page.evaluate(_FRONT))
            sorted_.append(await page.evaluate(_SORT))
            await page.close()
        version = browser.version
        await browser.close()
    return {
        "browser": f"Chromium {version}",
        "open ms": min(opened),
        "sort ms": min(sorted_),
        "front ms": min(drawn),
    }


def main() -> int:
    """Measure, print, and compare with the limits."""
    machine = f"{os.cpu_count()} cores, {platform.machine()}, no GPU"
    pages, broken = {}, []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "index.html"
        for count, each in PAGES:
            file.write_text(index(count, each), encoding="utf-8")
            found = asyncio.run(browsed(file.resolve()))
            name = f"{count} designs of {each} checks"
            pages[name] = {"page, MB": file.stat().st_size / 1e6, **found}
            broken += [f"{name}: {what}" for what, most in LIMITS.items() if found[what] > most]
    print(json.dumps({"machine": machine, **pages, "broken": broken}, indent=1))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
