"""Decoding of a part's text in the browser, against Python's and against the solver's fields."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import reports.live
from checks.result.live_fields import grey, von_mises
from reports.live.encode import TOLERANCE, encode

from .decode import decode
from .surfaces import live, smooth, torus, turning, usual

CYCLES = ["work", "idle"]
SCRIPTS = ("data", "viewer", "fields")
PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>fields</title>
<script type="application/json" id="live-header">{header}</script>
<script type="text/plain" id="live-part-0">{text}</script>
<script>
{script}
globalThis.api = {{
  jsonOf, decodePart, FIELDS, isConstant, hasField, whyNot, fieldValues, displacementAt,
  stressAt, misesOf, principalsOf,
}};
</script></html>"""
DECODED = """async () => {
  const head = api.jsonOf("live-header").parts[0];
  const part = await api.decodePart(document.getElementById("live-part-0").textContent, head);
  globalThis.part = part;
  return Object.fromEntries(["node", "positions", "normals", "triangles", "edges"].map(
    (name) => [name, Array.from(part[name])]));
}"""
VALUES = """([cycle, index, field]) => {
  const out = new Float32Array(part.n);
  const found = api.fieldValues(part, cycle, index, field, out);
  return { found, out: Array.from(out) };
}"""


@pytest.fixture
def shown(opened, tmp_path):
    """Return what opens a page with a part, decodes it, and gives the page and its geometry."""

    def show(fields, text=None, name="part"):
        done = encode(fields, CYCLES)
        header = json.dumps({"parts": [{"name": name, **done.head}]}).replace("<", "\\u003c")
        folder = Path(reports.live.__file__).parent
        script = "".join((folder / f"{name}.js").read_text() for name in SCRIPTS)
        file = tmp_path / "fields.html"
        file.write_text(PAGE.format(header=header, text=text or done.text, script=script))
        page = opened(file)
        return page, page.page.evaluate(DECODED), decode(done.head, done.text)

    return show


@pytest.fixture(scope="module")
def fields():
    return usual(positions=361)


def nodal(page, *asked):
    """Values at the nodes, and what is told of them."""
    answer = page.page.evaluate(VALUES, list(asked))
    return np.array(answer["out"]), answer["found"]


def test_the_peak_of_25_positions_is_the_solvers(shown, fields):
    """0.2 % of the cycle's peak is what the page promises; 0.1 % is what is written."""
    page, _, _ = shown(fields)
    for number, name in enumerate(CYCLES):
        exact = fields.peaks[name]
        for index in np.linspace(0, len(exact) - 1, 25).astype(int).tolist():
            values, found = nodal(page, number, index, "mises")
            assert abs(found["peak"] - exact[index]) <= TOLERANCE * exact.max()
            assert values[found["node"]] == pytest.approx(found["peak"])
            assert found["to"] == pytest.approx(max(p.max() for p in fields.peaks.values()))
    page.assert_quiet()


def test_python_and_the_browser_read_the_same(shown, fields):
    """To single precision, which the browser's values have."""
    page, geometry, part = shown(fields)
    positions = np.array(geometry["positions"]).reshape(-1, 3)
    node = np.array(geometry["node"])
    assert_allclose(positions, part.nodes[node], rtol=1e-6, atol=1e-5)
    assert np.array_equal(node[np.array(geometry["triangles"]).reshape(-1, 3)], part.triangles)
    for cycle, index in itertools.product((0, 1), (0, 7.25, 36)):
        stress = part.stress(cycle, index)
        mises, _ = nodal(page, cycle, index, "mises")
        assert_allclose(mises, von_mises(stress), rtol=1e-6, atol=1e-5)
        tensor = stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
        values = np.linalg.eigvalsh(tensor)
        largest = np.where(values[:, 2] >= -values[:, 0], values[:, 2], values[:, 0])
        principal, found = nodal(page, cycle, index, "principal")
        assert_allclose(np.abs(principal), np.abs(largest), rtol=1e-5, atol=1e-4)
        alike = np.abs(values[:, 2] + values[:, 0]) < 1e-3 * np.abs(largest)
        assert_allclose(principal[~alike], largest[~alike], rtol=1e-5, atol=1e-4)
        assert found["peak"] == pytest.approx(principal[np.abs(principal).argmax()])
        moved, _ = nodal(page, cycle, index, "displacement")
        assert_allclose(moved, np.linalg.norm(part.displacement(cycle, index), axis=1), rtol=1e-6)
    for name, values in part.fatigue.items():
        assert_allclose(nodal(page, 0, 0, name)[0], values, rtol=1e-6)
    page.assert_quiet()


def test_the_probe_reads_the_stress_of_one_node(shown, fields):
    page, _, part = shown(fields)
    found = page.page.evaluate(
        """() => {
          const stress = api.stressAt(part, 1, 12.5, 99);
          const moved = new Float32Array(3 * part.n);
          const largest = api.displacementAt(part, 1, 12.5, moved);
          return { stress: Array.from(stress), mises: api.misesOf(stress), largest,
            principals: api.principalsOf(stress), moved: Array.from(moved),
            alone: api.principalsOf([3, 3, 3, 0, 0, 0]) };
        }"""
    )
    stress = part.stress(1, 12.5)[99]
    assert_allclose(found["stress"], stress, rtol=1e-9)
    assert found["mises"] == pytest.approx(float(von_mises(stress)))
    tensor = stress[[0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(3, 3)
    assert_allclose(found["principals"], np.linalg.eigvalsh(tensor)[::-1], rtol=1e-9)
    assert found["alone"] == [3, 3, 3]
    moved = part.displacement(1, 12.5)
    assert_allclose(np.reshape(found["moved"], (-1, 3)), moved, rtol=1e-5, atol=1e-9)
    assert found["largest"] == pytest.approx(np.linalg.norm(moved, axis=1).max(), rel=1e-6)


def test_of_equal_principal_stresses_of_two_signs_the_one_in_tension_is_told(shown):
    """Pure shear in all directions of a plane: round-off makes either one the larger."""
    nodes, triangles = torus(24, 12)
    angle = np.linspace(0, np.pi, len(nodes))
    stress = np.zeros((1, len(nodes), 6))
    stress[0, :, 0], stress[0, :, 3] = 100 * np.cos(2 * angle), 100 * np.sin(2 * angle)
    stress[0, :, 1] = -stress[0, :, 0]
    page, _, _ = shown(live(stress, {"work": np.ones((1, 1))}, (nodes, triangles)))
    found = page.page.evaluate(
        """() => [-1e-7, -1e-9, 0, 1e-9].map((more) => {
          const one = [100, -100 + 100 * more, 0, 0, 0, 0];
          const fields = one.map((value) => Float64Array.of(value));
          const part = { n: 1, head: { cycles: [{ positions: [0] }],
            scale: { principal: { from: 0, to: 1 } } }, over: {},
            stress: { fields, worth: Array(6).fill(1), components: 6,
              weights: [[Float64Array.of(1)]] } };
          return api.fieldValues(part, 0, 0, "principal", new Float32Array(1)).peak;
        })"""
    )
    assert_allclose(found, 100, rtol=1e-6)


def test_what_a_part_has_not_is_told_in_words(shown):
    surface = torus(16, 8)
    fields = live(
        smooth(surface[0], 2), {"idle": turning(2, 9)}, surface,
        missing={"displacement": "not kept", "utilisation": "no duty"},
    )  # fmt: skip
    page, _, _ = shown(fields)
    ask = page.page.evaluate
    assert ask("api.hasField(part, 'mises')")
    assert ask("api.whyNot(part, 'mises')") == ""
    assert ask("api.FIELDS.filter((field) => api.hasField(part, field))") == ["mises", "principal"]
    assert ask("api.whyNot(part, 'displacement')") == "not kept"
    assert ask("api.whyNot(part, 'utilisation')") == "no duty"
    assert "fatigue was not judged" in ask("api.whyNot(part, 'mean')")
    assert ask("api.displacementAt(part, 1, 0, new Float32Array(3 * part.n))") is None
    assert ask("api.stressAt(part, 0, 0, 5)") is None  # the first cycle does not load it
    values, found = nodal(page, 0, 0, "mises")
    assert found is None
    assert not values.any()
    assert nodal(page, 1, 0, "utilisation")[1] is None
    page.assert_quiet()


def test_sharp_edges_are_drawn_and_shaded_as_sharp_and_round_faces_as_round(shown):
    corner = np.array(list(itertools.product((0.0, 10.0), repeat=3)))
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    cube = np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])
    _, geometry, _ = shown(grey(corner, cube, "a cube"))
    assert len(geometry["node"]) == 24
    assert len(geometry["edges"]) == 2 * 12
    normals = np.array(geometry["normals"]).reshape(-1, 3)
    positions = np.array(geometry["positions"]).reshape(-1, 3)
    assert_allclose(np.abs(normals).max(axis=1), 1.0)
    assert ((positions - 5) * normals).sum(axis=1).min() > 4.9  # outwards


def test_a_round_surface_has_no_edges_and_a_sheet_has_its_outline(shown):
    nodes, triangles = torus(48, 24)
    _, geometry, _ = shown(grey(nodes, triangles, "round"))
    assert len(geometry["node"]) == len(nodes)
    assert geometry["edges"] == []
    normals = np.array(geometry["normals"]).reshape(-1, 3)
    positions = np.array(geometry["positions"]).reshape(-1, 3)
    middle = positions * [1, 1, 0] * (100 / np.linalg.norm(positions[:, :2], axis=1))[:, None]
    outwards = (positions - middle) / 30
    assert (normals * outwards).sum(axis=1).min() > 0.99
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    _, sheet, _ = shown(grey(square, np.array([[0, 1, 2], [0, 2, 3]]), "a sheet"))
    assert len(sheet["edges"]) == 2 * 4


@pytest.mark.parametrize("text", ["no base64!", "AAAA"])
def test_damaged_data_are_told_in_words(shown, fields, text):
    with pytest.raises(Exception, match="the stress in this page is damaged"):
        shown(fields, text=text)


def test_data_that_are_not_the_headers_are_told_in_words(shown, fields):
    other = encode(usual(count=2), CYCLES).text
    with pytest.raises(Exception, match=r"the stress in this page is damaged: \d+ bytes, not \d+"):
        shown(fields, text=other)
