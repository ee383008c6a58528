"""docs/report.md shows the screens that tools/screens.py makes."""

import os
import sys
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def tool():
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        import screens
    finally:
        sys.path.pop(0)
    return screens


def test_places_of_a_text_get_the_screens_they_name(tool):
    text = "a\n<!-- screens toggle_press-verdict -->\nold\n<!-- end of screens -->\nb"
    filled = tool.filled(text, "docs/screens", tool.screens())
    assert filled == (
        "a\n<!-- screens toggle_press-verdict -->\n"
        "![toggle press: the verdict and what to know first]"
        "(docs/screens/toggle_press-verdict.webp)\n<!-- end of screens -->\nb"
    )
    assert tool.filled(filled, "docs/screens", tool.screens()) == filled
    with pytest.raises(SystemExit, match="no screen is named 'toggle'"):
        tool.filled("<!-- screens toggle -->\n<!-- end of screens -->", "", tool.screens())


def test_every_machine_has_a_light_and_a_dark_screen_and_one_is_a_phone_s(tool):
    found = tool.screens()
    for machine in tool.MACHINES:
        assert {"light", "dark"} <= {s.scheme for s in found if s.machine == machine}
        assert (ROOT / "designs" / f"{machine}.toml").is_file()
    assert len({screen.file for screen in found}) == len(found)
    assert any(screen.width < 420 for screen in found)


def test_a_picture_is_packed_until_it_is_small_enough(tool, monkeypatch):
    noise = np.random.default_rng(1).integers(0, 255, (300, 400, 3), dtype=np.uint8)
    png = BytesIO()
    Image.fromarray(noise).save(png, format="PNG")
    loose = tool.small(png.getvalue())
    monkeypatch.setattr(tool, "MOST_BYTES", 3 * len(loose) // 4)
    packed = tool.small(png.getvalue())
    assert len(packed) <= 3 * len(loose) // 4
    with Image.open(BytesIO(packed)) as image:
        assert image.size == (400, 300)
    monkeypatch.setattr(tool, "MOST_BYTES", 100)
    with pytest.raises(SystemExit, match="even at the lowest quality"):
        tool.small(png.getvalue())


def test_the_text_shows_screens_that_are_there_and_small(tool):
    text = (ROOT / "docs" / "report.md").read_text(encoding="utf-8")
    assert tool.filled(text, "screens", tool.screens()) == text, "run make screens"
    files = [*tool.SCREENS.glob("*.webp")]
    assert {file.name for file in files} == {screen.file for screen in tool.screens()}
    sizes = [os.path.getsize(file) for file in files]
    assert max(sizes) <= tool.MOST_BYTES
    assert sum(sizes) <= tool.MOST_TOGETHER
