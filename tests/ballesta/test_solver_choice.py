"""One check by each of the solvers: the same numbers, and what the result says of the choice."""

import sys
from pathlib import Path

import numpy as np
import pytest

from ballesta.pipeline import check_design, check_file
from checks.design.effort import Effort

from ..small_machine import PLATE, machine

PRESS = Path(__file__).parents[2] / "designs" / "toggle_press.toml"
HIDDEN = {"CHOLMOD": (), "PARDISO": ("sksparse",), "SuperLU": ("sksparse", "pypardiso")}
ROD = ["accuracy=30 %", "parts.rod.mesh.fineness=0.4"]
COARSE = [
    "accuracy=30 %",
    "parts.bar_upper.mesh.fineness=0.4",
    "parts.pin_B.mesh.fineness=0.45",
    "cycles.press.positions=91",
]
SAME, SAME_MODE = 1e-9, 1e-6  # relative: stresses and forces; eigenvalues and what follows of them
ROUND_OFF = 1e-12  # of the largest number of its kind
pytestmark = pytest.mark.usefixtures("unshared")  # what one solver found is no other's


def checked(name, check):
    """What a check says with one solver and none that comes before it."""
    with pytest.MonkeyPatch.context() as patch:
        for package in HIDDEN[name]:
            patch.setitem(sys.modules, package, None)
        if name != "SuperLU":
            pytest.importorskip({"CHOLMOD": "sksparse", "PARDISO": "pypardiso"}[name])
        return check().to_dict()


@pytest.fixture(scope="module")
def rods(unshared, tmp_path_factory):
    """The rod as a solid, with its buckling and vibration, by each solver."""
    folder = tmp_path_factory.mktemp("rod")
    design = machine(folder, PLATE, *ROD)
    return {name: checked(name, lambda: check_design(design, effort=Effort("solid")))
            for name in HIDDEN}  # fmt: skip


def compared(a, b, path=()):
    """Yields path and both values of all numbers of two results; texts must be equal."""
    if isinstance(a, dict):
        assert a.keys() == b.keys(), path
        for key in a:
            if key not in (
                "timings",
                "seconds",
                "versions",
                "solver",
                "gates",
                "warnings",
                "ways_out",
            ):
                yield from compared(a[key], b[key], (*path, key))
    elif isinstance(a, list):
        assert len(a) == len(b), path
        for number, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from compared(x, y, (*path, number))
    elif isinstance(a, float) and isinstance(b, float):
        yield path, a, b
    else:
        assert a == b, path


def differing(a, b):
    """Checks' numbers and all others that are not the same, with their paths."""
    found = list(compared(a, b))
    assert len(found) > 300
    sizes = dict()
    for path, x, _ in found:
        kind = next(key for key in reversed(path) if isinstance(key, str))
        sizes[kind] = max(sizes.get(kind, 0.0), abs(x) if np.isfinite(x) else 0.0)
    wrong = []
    for path, x, y in found:
        kind = next(key for key in reversed(path) if isinstance(key, str))
        same = SAME_MODE if is_mode(a, path) else SAME
        size = max(abs(x), bar_of(a, path))
        if not (x == y or abs(x - y) <= same * size + ROUND_OFF * sizes[kind]):
            wrong.append((path, x, y))
    return wrong


def is_mode(result, path):
    """Whether a number stands in a check that is an eigenvalue."""
    if path[:1] != ("parts",) or path[2:3] != ("checks",):
        return False
    return "buckling" in result["parts"][path[1]]["checks"][path[3]]["kind"]


def bar_of(result, path):
    """The value whose numerical bar a number is: a difference of two meshes' values; else 0."""
    if path[-1] != "numerical":
        return 0.0
    for key in path[:-1]:
        result = result[key]
    return abs(result["value"])


@pytest.mark.parametrize("name", ["PARDISO", "SuperLU"])
def test_a_check_has_the_same_numbers_by_each_solver(rods, name):
    assert differing(rods["CHOLMOD"], rods[name]) == []


def test_the_result_names_its_solver(rods):
    for name, result in rods.items():
        assert result["versions"]["solver"] == name
        assert {mesh["solver"] for mesh in result["parts"][0]["meshes"]} == {name}


def test_superlu_is_warned_of_with_cost_and_cure(rods):
    told = {n: [w for w in r["warnings"] if "SuperLU" in w] for n, r in rods.items()}
    assert told["CHOLMOD"] == told["PARDISO"] == []
    (warning,) = told["SuperLU"]
    assert warning.startswith("rod: solved by SciPy's SuperLU")
    assert "4 to 11 times the time" in warning
    assert 'pip install "ballesta[pardiso]"' in warning


def test_a_check_by_formula_names_no_solver(tmp_path):
    design = machine(tmp_path, PLATE)
    result = checked("SuperLU", lambda: check_design(design, effort=Effort("formula")))
    assert not [w for w in result["warnings"] if "SuperLU" in w]
    assert "solver" not in result["versions"]


@pytest.mark.slow
def test_the_press_has_the_same_numbers_by_each_solver():
    """Contact in bores and columns, beside the rod's stresses; meshes are coarser than a user's."""
    found = {name: checked(name, lambda: check_file(PRESS, COARSE)) for name in HIDDEN}
    assert differing(found["CHOLMOD"], found["PARDISO"]) == []
    assert differing(found["CHOLMOD"], found["SuperLU"]) == []
