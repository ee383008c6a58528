"""How the page's script reads rows and series, and how it tells places and forces."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reports.packed import packed_json, series
from reports.page_script import joined

NAMES = "rowIn, atRow, series, unzippedJson, placeText, forceText"


@pytest.fixture
def read(opened, tmp_path):
    """Return what evaluates an expression of the helpers."""
    script = joined("live/data.js", "live/numbers.js").replace(
        "})();", f"Object.assign(window, {{ {NAMES} }}); }})();"
    )
    path = tmp_path / "data.html"
    path.write_text(f'<!DOCTYPE html><meta charset="utf-8"><title>data</title><script>{script}'
                    "</script>", encoding="utf-8")  # fmt: skip
    return opened(path).page.evaluate


@pytest.mark.parametrize("kept", [[0, 3, 4, 9, 10], [2], [2, 7], [0, 0.5, 1, 1]])
def test_rows_are_those_of_interpolation_and_stop_at_the_ends(read, kept):
    values = np.cos(kept).tolist()
    asked = [-1, 0, 0.25, 1, 2, 3, 3.75, 4, 8.5, 9, 9.99, 10, 11]
    rows, found = read(
        "([kept, values, asked]) => { const rows = asked.map((each) => rowIn(kept, each));"
        " return [rows, rows.map((row) => atRow(values, row))]; }",
        [kept, values, asked],
    )
    if len(set(kept)) == len(kept):
        assert_allclose(rows, np.interp(asked, kept, np.arange(len(kept))), rtol=1e-14)
        assert_allclose(found, np.interp(asked, kept, values), rtol=1e-13, atol=1e-15)
    assert min(rows) >= 0
    assert max(rows) <= len(kept) - 1


def test_a_series_is_read_to_half_a_step(read):
    values = 300 * np.sin(np.linspace(0, 7, 200))
    found = read(
        "async (text) => Array.from(series(await unzippedJson(text, 'it')))",
        packed_json(series(values)),
    )
    assert_allclose(found, values, rtol=0, atol=0.51 * np.ptp(values) / 60_000)


def test_places_and_forces_are_told_in_one_way(read):
    assert read("placeText([1.25, -0.04, -30])") == "x 1.3, y 0.0, z −30.0 mm"
    told = [read(f"forceText({newton})") for newton in (0, 4.567, 9999, 12345, 2e6)]
    assert told == ["0 N", "4.57 N", "9999 N", "12.3 kN", "2000 kN"]
