"""Screens of the machines' reports, as docs/report.md and README.md show them: make screens.

Checks every machine, opens its page in Chromium and writes docs/screens/*.webp; then fills the
places between `<!-- screens NAME ... -->` and `<!-- end of screens -->` in both texts. With
--reports DIR it takes DIR/MACHINE/report.html as they are.
"""

import argparse
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
SCREENS = ROOT / "docs" / "screens"
TEXTS = (ROOT / "docs" / "report.md", ROOT / "README.md")
MACHINES = {
    "toggle_press": "toggle press",
    "slider_crank": "slider-crank",
    "quick_return": "quick return",
    "spring_hammer": "spring hammer",
}
MOST_BYTES, MOST_TOGETHER = 250_000, 2_500_000
PLACE = re.compile(r"(<!-- screens ([^>]*?) -->\n).*?(<!-- end of screens -->)", re.DOTALL)
_FLAGS = (
    "--disable-gpu", "--enable-unsafe-swiftshader", "--use-angle=swiftshader", "--hide-scrollbars",
    "--disable-dev-shm-usage", "--disable-background-networking", "--disable-component-update",
)  # fmt: skip
_DRAWN = 1500  # ms until software has drawn what was asked for


@dataclass(frozen=True)
class Screen:
    """A picture of a page: at an element (its top; "" is the page's), after clicks on others.

    width, height  CSS px of the window; density its pixels per CSS px
    """

    machine: str
    name: str
    said: str
    at: str = ""
    clicks: tuple[str, ...] = ()
    scheme: str = "light"
    width: int = 1280
    height: int = 860
    density: int = 1

    @property
    def file(self) -> str:
        """Name of its file."""
        return f"{self.machine}-{self.name}.webp"


def screens() -> list[Screen]:
    """All screens: of every machine the verdict and the live view, of the press some more."""
    linkage = ("#live-tab-linkage",)
    found = []
    for machine, called in MACHINES.items():
        found += [
            Screen(machine, "verdict", f"{called}: the verdict and what to know first"),
            Screen(machine, "live", f"{called}: the live view", "#live", (), "dark", height=920),
        ]
    found += [
        Screen("toggle_press", "linkage", "toggle press: the whole linkage", "#live", linkage),
        Screen("toggle_press", "mechanism", "toggle press: forces at pins", "#mechanism", linkage),
        Screen(
            "toggle_press", "phone", "toggle press: on a phone", "#live", scheme="dark",
            width=390, height=844, density=2,
        ),
    ]  # fmt: skip
    return found


def check(machines: Sequence[str], folder: Path, fidelity: str) -> None:
    """Check machines into a folder; raises SystemExit where one could not be checked."""
    for machine in machines:
        print(f"checking {machine}", flush=True)
        done = subprocess.run(
            [
                sys.executable, "-m", "ballesta", "check", f"designs/{machine}.toml",
                "--fidelity", fidelity, "--fields", "--out", str(folder),
            ],
            cwd=ROOT, stdout=subprocess.DEVNULL, check=False,
        )  # fmt: skip
        if done.returncode > 1:
            raise SystemExit(f"{machine} could not be checked: exit code {done.returncode}")


@contextmanager
def browser() -> Iterator[Any]:
    """Yield a headless Chromium; raises SystemExit with the cure where there is none."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise SystemExit("the package playwright is missing: make test installs it") from None
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        raise SystemExit("there is no chromium: apt-get install -y chromium")
    with sync_playwright() as playwright:
        yield playwright.chromium.launch(
            executable_path=program, args=[*_FLAGS], chromium_sandbox=False
        )


def taken(chromium: Any, screen: Screen, report: Path) -> bytes:
    """A screen of a report as WebP; raises SystemExit where the page does not come alive."""
    context = chromium.new_context(
        viewport={"width": screen.width, "height": screen.height},
        device_scale_factor=screen.density, color_scheme=screen.scheme,
    )  # fmt: skip
    try:
        context.set_offline(True)
        page = context.new_page()
        page.goto(report.resolve().as_uri())
        page.locator("html[data-live]").wait_for(state="attached")
        if page.locator("html").get_attribute("data-live") == "failed":
            raise SystemExit(f"{report}: the live view has failed in this browser")
        for selector in screen.clicks:
            page.locator(selector).click()
        if screen.at:
            block = "start" if screen.at == "#live" else "center"
            page.locator(screen.at).evaluate(f"it => it.scrollIntoView({{ block: '{block}' }})")
        page.wait_for_timeout(_DRAWN)
        return small(page.screenshot())
    finally:
        context.close()


def small(png: bytes) -> bytes:
    """A picture as WebP of at most MOST_BYTES, as good as that allows; else raises SystemExit."""
    with Image.open(BytesIO(png)) as image:
        colours = image.convert("RGB")
    for quality in range(88, 30, -6):
        out = BytesIO()
        colours.save(out, format="WEBP", quality=quality, method=6)
        if out.tell() <= MOST_BYTES:
            return out.getvalue()
    raise SystemExit(
        f"a screen takes {out.tell() / 1000:.0f} kB even at the lowest quality, at most "
        f"{MOST_BYTES / 1000:.0f} kB are allowed: take a smaller window"
    )


def filled(text: str, folder: str, known: Sequence[Screen]) -> str:
    """The text with its places filled; `folder` holds the screens as the text sees it.

    Raises SystemExit for a place that names a screen that there is not.
    """
    by_name = {screen.file.removesuffix(".webp"): screen for screen in known}

    def images(found: re.Match[str]) -> str:
        lines = []
        for name in found[2].split():
            if name not in by_name:
                raise SystemExit(f"no screen is named {name!r}; there are {', '.join(by_name)}")
            lines.append(f"![{by_name[name].said}]({folder}/{name}.webp)\n")
        return found[1] + "".join(lines) + found[3]

    return PLACE.sub(images, text)


def main(arguments: Sequence[str] | None = None) -> None:
    """Write all screens and fill the texts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--reports", type=Path, help="folder of reports that are there already")
    parser.add_argument("--fidelity", default="auto", help="of the checks")
    parser.add_argument("--out", type=Path, default=SCREENS, help="folder of the screens")
    wanted = parser.parse_args(arguments)
    found = screens()
    wanted.out.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(prefix="ballesta-") as temporary, browser() as chromium:
        folder = wanted.reports or Path(temporary)
        if wanted.reports is None:
            check(list(MACHINES), folder, wanted.fidelity)
        for screen in found:
            content = taken(chromium, screen, folder / screen.machine / "report.html")
            (wanted.out / screen.file).write_bytes(content)
            print(f"{screen.file}: {len(content) / 1000:.0f} kB", flush=True)
    for old in {*wanted.out.glob("*.webp")} - {wanted.out / screen.file for screen in found}:
        old.unlink()
    together = sum(file.stat().st_size for file in wanted.out.glob("*.webp"))
    if together > MOST_TOGETHER:
        raise SystemExit(f"the screens take {together / 1e6:.1f} MB, at most 2.5 MB are allowed")
    for text in TEXTS:
        if text.is_file() and wanted.out.resolve() == SCREENS:
            before = text.read_text(encoding="utf-8")
            after = filled(before, SCREENS.relative_to(text.parent).as_posix(), found)
            if after != before:
                text.write_text(after, encoding="utf-8")


if __name__ == "__main__":
    main()
