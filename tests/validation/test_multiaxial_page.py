"""docs/validation.md shows what bench/multiaxial.py computes, and says what it is.

Nothing here asserts how a criterion agrees with the tests: their amplitudes are unconfirmed.
"""

import numpy as np
from numpy.testing import assert_allclose

from bench import error_bars, multiaxial
from tests.fatigue.multiaxial_cases import BENDING_LIMIT, NISHIHARA_KAWAMOTO

PAGE = error_bars.PAGE.read_text(encoding="utf-8")


def test_the_page_has_both_tables_and_the_picture():
    assert multiaxial.table() in PAGE
    assert multiaxial.ranges() in PAGE
    picture = multiaxial.PLOT.relative_to(error_bars.PAGE.parent)
    assert f"]({picture})" in PAGE
    drawn = multiaxial.PLOT.read_text(encoding="utf-8")
    assert all(name in drawn for name in ("unconfirmed", *multiaxial.COLUMNS))


def test_the_page_calls_the_amplitudes_unconfirmed_where_it_shows_them():
    section = PAGE[PAGE.index("## Multiaxial fatigue") : PAGE.index("## Error bars")]
    assert section.index("unconfirmed") < section.index("| Bending, MPa")


def test_the_columns_are_the_criterias_values_at_the_stated_inputs():
    """Public case FT-11, 1e-4; Goodman's chord by hand from the two axes of the path.

    In the plane of sigma and sqrt(3) tau the path is an ellipse; half its longest chord is the
    larger semi-axis, a^2 = (s^2 + q^2 + sqrt((s^2 - q^2)^2 + (2 s q cos)^2)) / 2, q = sqrt(3) tau.
    The 1440 positions miss it by (pi / 1440)^2 / 2 at the most.
    """
    for test in NISHIHARA_KAWAMOTO:
        chord, plane = multiaxial.predicted(test)
        assert_allclose(plane, test.expected, rtol=1e-4)
        s, q = test.bending, np.sqrt(3.0) * test.torsion
        mixed = 2.0 * s * q * np.cos(np.radians(test.phase))
        axis = np.sqrt((s**2 + q**2 + np.hypot(s**2 - q**2, mixed)) / 2.0)
        assert_allclose(chord, axis / BENDING_LIMIT, rtol=3e-6)


def test_the_ranges_are_the_reciprocals_of_the_table():
    rows = [
        [float(cell) for cell in line.strip("|").split("|")]
        for line in multiaxial.table().split("\n")[2:]
    ]
    for line in multiaxial.ranges().split("\n")[2:]:
        words, count, *cells = (cell.strip() for cell in line.strip("|").split("|"))
        chosen = [row[3:] for row in rows if (row[2] == 0.0) == (words == "in phase")]
        assert int(count) == len(chosen) > 0
        for k, cell in enumerate(cells):
            shown = [float(part) for part in cell.split("…")]
            limits = [1.0 / row[k] for row in chosen]
            assert_allclose(shown, (min(limits), max(limits)), rtol=0, atol=1.2e-3)


def test_one_command_writes_page_and_picture(monkeypatch, tmp_path):
    monkeypatch.setattr(error_bars, "PAGE", tmp_path / "validation.md")
    monkeypatch.setattr(multiaxial, "PLOT", tmp_path / "multiaxial.svg")
    monkeypatch.setattr(error_bars, "readings", lambda pair, done: [])
    monkeypatch.setattr(error_bars, "summary", lambda pairs: "SUMMARY")
    monkeypatch.setattr("sys.argv", ["error_bars", "--write"])
    error_bars.main()
    text = (tmp_path / "validation.md").read_text(encoding="utf-8")
    assert "{{" not in text
    assert "SUMMARY" in text
    assert multiaxial.table() in text
    assert (tmp_path / "multiaxial.svg").exists()
