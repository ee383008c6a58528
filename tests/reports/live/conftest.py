"""The page of the small design, written once, and what tests of it share."""

from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from . import sections


@pytest.fixture(scope="session")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Page of the small design."""
    path = tmp_path_factory.mktemp("live") / "live.html"
    path.write_text(sections.page(sections.design()), encoding="utf-8")
    return path


@pytest.fixture
def viewed(opened: Callable[..., Any], written: Path) -> Callable[..., Any]:
    """Return what opens that page, or another one, and waits until it is ready."""

    def view(
        path: Path | None = None, *, state: str = "ready", field: str = "mises", **how: Any
    ) -> Any:
        found = opened(path or written, **{"width": 900, "height": 900} | how)
        found.page.locator(f"html[data-live={state}]").wait_for(state="attached")
        settle(found.page)
        if state == "ready":
            found.page.evaluate("document.querySelector('.live-colours').open = true")
            wanted = role(found.page, "field").locator(f"option[value={field}]")
            if role(found.page, "field").is_enabled() and wanted.is_enabled():
                role(found.page, "field").select_option(field)
                settle(found.page)
        return found

    return view


def pixels(page: Any) -> Any:
    """The picture as it is on the screen, (rows, columns, 3) of 0 to 255."""
    settle(page)
    shot = page.locator("[data-role=canvas]").screenshot()
    whole = np.asarray(Image.open(BytesIO(shot)).convert("RGB")).astype(int)
    return whole[: whole.shape[0] // 10 * 10, : whole.shape[1] // 10 * 10]  # not half a pixel more


def settle(page: Any) -> None:
    """Wait until the chosen tab is open and what changed is drawn."""
    page.evaluate(
        """async () => {
          await ballesta.live.opened;
          for (let k = 0; k < 2; k++) await new Promise(requestAnimationFrame);
        }"""
    )


def role(page: Any, name: str) -> Any:
    """The element of the live view that plays a role."""
    return page.locator(f"#live [data-role={name}]")
