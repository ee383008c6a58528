"""Arrows that a page's script draws: those of Python, also on the page of the loads."""

import re

import numpy as np
import pytest

from reports.loads_page import loads_html
from reports.mechanism_layout import arrow_path, bent_path
from reports.templating import joined

from . import loads_results

ENDS = [(0, 0, 30, 0), (5, -3, 5, 40), (1, 2, -17, -22), (0, 0, 0.7, 0), (0, 0, 0.9, 0)]
SHARES = [1.0, -1.0, 0.4, -0.63, 0.021, 0.019, 0.0]


def numbers(path):
    return [float(value) for value in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", path)]


@pytest.fixture
def drawn(opened, tmp_path):
    """Return what evaluates an expression of the functions that draw arrows."""
    script = joined("scripts/arrows.js").replace(
        "})();", "Object.assign(window, { arrowPath, torquePath }); })();"
    )
    path = tmp_path / "arrows.html"
    path.write_text(f"<!DOCTYPE html><title>Arrows</title><script>{script}</script>")
    return opened(path).page.evaluate


@pytest.mark.parametrize("ends", ENDS)
def test_an_arrow_is_pythons(drawn, ends):
    python, script = arrow_path(np.array(ends), 2.0), drawn(f"arrowPath({str(ends)[1:-1]}, 2)")
    assert re.sub(r"[^A-Z]", "", script) == re.sub(r"[^A-Z]", "", python)
    assert numbers(script) == pytest.approx(numbers(python), rel=1e-4, abs=1e-4)  # five digits


@pytest.mark.parametrize("share", SHARES)
def test_an_arc_is_pythons(drawn, share):
    python, script = bent_path(share, 2.0), drawn(f"torquePath({share}, 2)")
    assert re.sub(r"[^A-Z]", "", script) == re.sub(r"[^A-Z]", "", python)
    assert numbers(script) == pytest.approx(numbers(python), rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("kind", ["press", "crank"])
def test_on_the_page_of_the_loads_the_mechanism_and_its_arrows_move(opened, tmp_path, kind):
    path = tmp_path / "loads.html"
    text = loads_html(loads_results.result(getattr(loads_results, kind)()))
    path.write_text(text, encoding="utf-8")
    found = opened(path)
    page = found.page
    shown = "[...document.querySelectorAll('.motion .arrow')].map((a) => a.getAttribute('d'))"
    page.locator(".motion .controls").first.wait_for()
    first = page.evaluate(shown)
    page.locator(".motion input").first.evaluate(
        "each => { each.value = each.max / 2; each.dispatchEvent(new Event('input')); }"
    )
    later = page.evaluate(shown)
    assert any(later)
    assert later != first
    found.assert_quiet()
