"""Pages opened as a reader opens them: from a file, without a network, in Debian's Chromium."""

import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

REQUIRED = os.environ.get("BALLESTA_BROWSER") == "required"  # as .ci/run sets it
SLOWED = float(os.environ.get("BALLESTA_BROWSER_SLOWED", 1))  # times; finds tests that race a page
SOFTWARE_GL = ("--disable-gpu", "--enable-unsafe-swiftshader", "--use-angle=swiftshader")
NO_GL = ("--disable-gpu", "--disable-3d-apis")
# Said of every picture that goes from WebGL to a screen without a graphics card.
_SOFTWARE_GL_SLOW = "GL Driver Message (OpenGL, Performance"
_QUIET = (
    "--disable-dev-shm-usage", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--disable-extensions",
    "--process-per-site",
)  # fmt: skip


@dataclass
class Opened:
    """A page in the browser, what it said on the console, and what it asked for elsewhere."""

    page: Any
    told: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def assert_quiet(self) -> None:
        """Assert that nothing was told on the console and nothing asked for from a network."""
        assert self.told == []
        assert [url for url in self.asked if not url.startswith(("file:", "data:", "blob:"))] == []


@pytest.fixture(scope="session")
def launch() -> Iterator[Callable[..., Any]]:
    """Return what starts a browser with some flags; equal flags give the same browser."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _missing("the package playwright is not installed: make test installs it")
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        _missing("there is no chromium: apt-get install -y chromium")
    browsers: dict[tuple[str, ...], Any] = {}
    with sync_playwright() as playwright:

        def start(*flags: str) -> Any:
            flags = flags or SOFTWARE_GL
            if flags not in browsers:
                browsers[flags] = playwright.chromium.launch(
                    executable_path=program, args=[*_QUIET, *flags], chromium_sandbox=False
                )
            return browsers[flags]

        yield start
        for browser in browsers.values():
            browser.close()


@pytest.fixture(scope="session")
def offline(
    launch: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory
) -> Callable[..., Any]:
    """Return what makes an offline context of a browser; equal keywords give the same context.

    A new context costs as much of a processor as a page, and so does the process of a page: a bare
    one stays open, which keeps that of the others. Pages keep nothing in a browser's storage
    (test_page_browser.py), so those of one context know nothing of each other.
    """
    bare = tmp_path_factory.mktemp("bare") / "bare.html"
    bare.write_text("<!DOCTYPE html><title>bare</title>", encoding="utf-8")
    contexts: dict[str, Any] = {}

    def context(flags: tuple[str, ...], **how: Any) -> Any:
        key = repr((flags, sorted(how.items())))
        if key not in contexts:
            contexts[key] = launch(*flags).new_context(**how)
            contexts[key].set_offline(True)
            contexts[key].new_page().goto(bare.as_uri())
        return contexts[key]

    return context


@pytest.fixture
def opened(offline: Callable[..., Any]) -> Iterator[Callable[..., Opened]]:
    """Return what opens a file in a fresh, offline page: `opened(path, width=..., flags=...)`.

    Other keywords go to the browser's context: color_scheme, java_script_enabled, reduced_motion.
    """
    pages = []

    def open_page(
        path: Path,
        *,
        width: int = 1200,
        height: int = 800,
        flags: tuple[str, ...] = (),
        **context: Any,
    ) -> Opened:
        made = offline(flags, **context)
        page = made.new_page()
        pages.append(page)
        page.set_viewport_size({"width": width, "height": height})
        if SLOWED > 1:
            throttle = made.new_cdp_session(page)
            throttle.send("Emulation.setCPUThrottlingRate", {"rate": SLOWED})
        result = Opened(page)
        page.on(
            "console",
            lambda message: (
                result.told.append(message.text)
                if message.type in ("error", "warning") and _SOFTWARE_GL_SLOW not in message.text
                else None
            ),
        )
        page.on("pageerror", lambda error: result.told.append(str(error)))
        page.on("request", lambda request: result.asked.append(request.url))
        page.goto(Path(path).resolve().as_uri())
        return result

    yield open_page
    for page in pages:
        page.close()


@pytest.fixture(scope="session")
def axe() -> Callable[[Any], list[str]]:
    """Return what tells a page's findings by axe; its context must have bypass_csp."""
    try:
        script = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")
    except ImportError:
        _missing("the package axe-playwright-python is not installed: make test installs it")

    def findings(page: Any) -> list[str]:
        page.add_script_tag(content=script)
        found = page.evaluate("axe.run().then((told) => told.violations)")
        return [f"{one['id']}: {node['html'][:120]}" for one in found for node in one["nodes"]]

    return findings


def until(page: Any, condition: str) -> None:
    """Wait until an expression of the page is true, at most 2000 pictures.

    `wait_for_function` builds its function from text, which the policy of the pages forbids.
    """
    page.evaluate(
        """async () => {
          for (let k = 0; !(CONDITION); k++) {
            if (k === 2000) throw new Error("never: " + `CONDITION`);
            await new Promise(requestAnimationFrame);
          }
        }""".replace("CONDITION", condition)
    )


def _missing(why: str) -> None:
    if REQUIRED:
        pytest.fail(why)
    pytest.skip(why)
