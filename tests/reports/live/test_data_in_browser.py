"""Rows and series as the page's script reads them, places and forces as it words them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reports.templating import joined, packed_json, series

NAMES = "rowIn, atRow, series, unzippedJson, placeText, forceText, cornersOver"


@pytest.fixture
def read(opened, tmp_path):
    """Return what evaluates an expression of the helpers."""
    script = joined("live/data.js", "live/numbers.js", "live/motion.js").replace(
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


def test_the_corners_of_a_moving_box_are_those_of_the_turned_and_moved_box(read):
    x, y, angle = [1.0, -20.0], [5.0, 7.0], [0.0, 0.5]
    low, high = [-1.0, -2.0, -3.0], [4.0, 2.0, 3.0]
    found = read(
        "([part, bounds]) => Array.from(cornersOver({ index: [0, 1], parts: [part] },"
        " [{ index: 0, bounds }]))",
        [{"x": x, "y": y, "angle": angle, "z": 10.0}, [low, high]],
    )
    box = np.array([[a, b, c] for a in (low[0], high[0]) for b in (low[1], high[1])
                    for c in (low[2], high[2])])  # fmt: skip
    wanted = []
    for k in (0, 1):
        c, s = np.cos(angle[k]), np.sin(angle[k])
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        wanted += (box @ turn.T + [x[k], y[k], 10.0]).tolist()
    assert_allclose(sorted(np.reshape(found, (-1, 3)).tolist()), sorted(wanted), atol=1e-12)
