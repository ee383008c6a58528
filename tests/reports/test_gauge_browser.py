"""The index draws a check's utilisation twice: in Python, and in its script. Both are the same."""

from math import inf

import pytest

from reports.index_page import index_html

from .test_index_page import check, design

# name -> value, numerical, model, model_below; the limit is 355 MPa, the required safety 1.5
CHECKS = {
    "pass": (141.0, 4.0, 20.0, None),
    "fail": (280.0, 1.5, 10.0, 30.0),
    "not loaded": (0.0, 0.0, 0.0, None),
    "without bars": (141.0, 0.0, 0.0, None),
    "bars that cannot be seen": (141.0, 0.0, 0.1, None),
    "without a numerical bar": (141.0, 0.0, 55.0, 3.0),
    "value beyond the end": (500.0, 1.0, 2.0, None),
    "bars beyond either end": (220.0, 3.0, 230.0, None),
    "upper bar beyond the end": (220.0, 0.0, 200.0, 5.0),
    "numerical bar beyond the end": (220.0, 300.0, 1.0, None),
    "endless above": (220.0, 4.0, inf, 30.0),
    "endless below": (220.0, 4.0, 30.0, inf),
    "endless both ways": (220.0, 4.0, inf, None),
    "endless beyond the end": (500.0, 4.0, inf, None),
    "numerically endless": (220.0, inf, 30.0, None),
}
GAUGES = """() => {
  const attributes = (element) =>
    Object.fromEntries([...element.attributes].map(({ name, value }) => [name, value]));
  const told = (element) =>
    [element.tagName, attributes(element), [...element.children].map(told)];
  return Object.fromEntries([...document.querySelectorAll("#table tbody tr")].map(
    (row) => [row.querySelector("th").textContent, told(row.querySelector("svg.gauge"))]));
}"""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    designs = [
        design(name, check(value, numerical=numerical, model=model, model_below=below))
        for name, (value, numerical, model, below) in CHECKS.items()
    ]
    path = tmp_path_factory.mktemp("gauges") / "index.html"
    path.write_text(index_html("gauges", designs, {}), encoding="utf-8")
    return path


@pytest.fixture
def gauges(opened, written):
    """Gauges by the name of their design, as Python and as the script draw them."""
    still = opened(written, java_script_enabled=False).page
    assert still.locator("#controls").is_hidden()
    moving = opened(written).page
    moving.locator("#controls").wait_for()
    return still.evaluate(GAUGES), moving.evaluate(GAUGES)


def test_the_script_draws_the_gauges_that_python_draws(gauges):
    python, script = gauges
    assert list(python) == list(CHECKS)
    for name in CHECKS:
        assert script[name] == python[name], name


def test_the_checks_are_of_all_kinds(gauges):
    kinds = {name: {part[1]["class"] for part in parts[2]} for name, parts in gauges[0].items()}
    assert {name for name, found in kinds.items() if "beyond" in found} == {
        name for name in CHECKS if "beyond" in name
    }
    assert {name for name, found in kinds.items() if "endless" in found} == {
        "endless above", "endless both ways", "endless beyond the end", "numerically endless"
    }  # fmt: skip
    assert {"gauge pass", "gauge FAIL", "gauge UNDECIDED"} <= {
        parts[1]["class"] for parts in gauges[0].values()
    }
