"""A shape that another package adds: the example of docs/extending.md, found by its entry points.

Schemas are made when they are imported, so the example runs in a process of its own.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ...small_machine import MACHINE, machine

ROOT = Path(__file__).parents[3]
EXAMPLES = ROOT / "docs" / "examples"
STRUT = """
[parts.rod]
body = "rod"
interfaces = { start = "A", end = "B" }
material = "S355"
shape = "round_strut"
diameter = "12 mm"
"""
CHECK = """
import json, sys
from pathlib import Path
from ballesta.pipeline import check_file
from checks.design.effort import Effort
result = check_file(Path(sys.argv[1]), effort=Effort(sys.argv[2]))
part, = result.parts
print("RESULT " + json.dumps({
    "mass": part.facts["mass [kg]"],
    "checks": [(c.kind, c.quantity, c.method, c.value) for c in part.checks],
    "hand": [(h.quantity, h.hand, h.model) for h in part.hand_checks],
}))
"""


@pytest.fixture
def site(tmp_path):
    """The example as pip installs it: two modules, and entry points in a folder of metadata."""
    site = tmp_path / "site"
    told = site / "round_strut-1.0.dist-info"
    told.mkdir(parents=True)
    for name in ("round_strut.py", "round_strut_model.py"):
        shutil.copy(EXAMPLES / name, site)
    (told / "METADATA").write_text("Name: round_strut\nVersion: 1.0\n", encoding="utf-8")
    (told / "entry_points.txt").write_text(
        "[ballesta.shapes]\nround_strut = round_strut:RoundStrut\n"
        "[ballesta.shape_models]\nround_strut = round_strut_model:MODEL\n",
        encoding="utf-8",
    )
    return site


def run(site, file, fidelity):
    paths = os.pathsep.join(map(str, (site, ROOT)))
    return subprocess.run(
        [sys.executable, "-c", CHECK, str(file), fidelity],
        cwd=ROOT, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True,
    )  # fmt: skip


def result_of(site, folder, fidelity):
    file = folder / "machine.toml"
    file.write_text(MACHINE + STRUT, encoding="utf-8")
    done = run(site, file, fidelity)
    lines = [line for line in done.stdout.splitlines() if line.startswith("RESULT ")]
    assert lines, done.stderr
    return json.loads(lines[0].removeprefix("RESULT "))


def test_a_shape_of_another_package_is_checked_by_formula_and_column(site, tmp_path):
    """12 mm round, 144 x 72 mm between its pins: its mass, and two shares of Euler's load.

    The part's and the column's formula have pi^2 E/slenderness^2, of the same largest push.
    """
    found = result_of(site, tmp_path, "formula")
    length = np.hypot(144, 72)
    assert_allclose(found["mass"], 7.85e-6 * np.pi * 36 * length, rtol=1e-4)
    by_kind = {quantity: (method, value) for _, quantity, method, value in found["checks"]}
    assert by_kind["peak von Mises stress"][0] == "formula"
    method, share = by_kind["elastic load share"]
    assert method == "formula"
    _, pressure = by_kind["column in plane"]
    euler = np.pi**2 * 210e3 / (length / 3) ** 2
    assert_allclose(share, pressure / euler, rtol=2e-3)


@pytest.mark.slow
def test_its_solid_has_the_stress_of_its_section_at_mid_length(site, tmp_path):
    found = result_of(site, tmp_path, "solid")
    (axial,) = ((hand, model) for q, hand, model in found["hand"] if q.startswith("axial"))
    assert_allclose(axial[1], axial[0], rtol=0.01)
    assert any(q == "peak von Mises stress by formula: bar" for q, _, _ in found["hand"])


def test_no_shape_of_another_package_is_known_where_it_is_not_installed(tmp_path):
    with pytest.raises(Exception, match="no shape is named 'round_strut'"):
        machine(tmp_path, STRUT)
