"""`import ballesta`: light, complete, described, and its results at home in a notebook."""

import ast
import os
import re
import subprocess
import sys
from html import unescape
from pathlib import Path

import pytest

import ballesta
import ballesta.api
from ballesta.api import answer_html
from checks.design.effort import Effort
from reports.answer_facts import answer_of

ROOT = Path(__file__).parents[2]
YOKE = ROOT / "designs" / "gallery" / "yoke_actuator.toml"


def python(*arguments, cwd=ROOT):
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_importing_the_package_imports_nothing_else_of_it_and_no_library():
    """So it takes no time, which cannot be measured on a machine with other work."""
    code = """
import importlib, sys, typing
before = set(sys.modules)
import ballesta
dir(ballesta), ballesta.__doc__
print(*sorted(set(sys.modules) - before))
"""
    assert python("-P", "-c", code).split() == ["ballesta"]


def test_the_names_that_editors_see_are_those_that_there_are():
    tree = ast.parse((ROOT / "ballesta" / "__init__.py").read_text(encoding="utf-8"))
    (seen,) = (node for node in tree.body if isinstance(node, ast.If))
    (imported,) = (node for node in seen.body if isinstance(node, ast.ImportFrom))
    names = [name.name for name in imported.names]
    assert sorted(names) == sorted(ballesta.__all__) == sorted(ballesta.api.__all__)
    assert set(ballesta.__all__) <= set(dir(ballesta))
    with pytest.raises(AttributeError, match="no attribute 'chek'"):
        _ = ballesta.chek


@pytest.mark.parametrize("name", ballesta.__all__)
def test_every_name_has_a_docstring_of_its_own(name):
    found = getattr(ballesta, name)
    assert found is getattr(ballesta.api, name)
    assert len(found.__doc__) > 30
    assert not found.__doc__.startswith(f"{name}(")  # which dataclass writes where there is none


@pytest.mark.parametrize("name", ["check", "loads", "batch"])
def test_no_module_takes_the_name_of_a_function(name):
    """An imported submodule becomes an attribute of its package, in place of the function."""
    assert not list((ROOT / "ballesta").glob(f"{name}.py")) + list((ROOT / "ballesta").glob(name))
    assert callable(getattr(ballesta, name))


@pytest.fixture(scope="module")
def yoke():
    return ballesta.check(YOKE, fidelity="formula")


def test_a_check_from_python_is_that_of_the_command(yoke):
    from ballesta.pipeline import check_file

    there = check_file(YOKE, effort=Effort("formula"))
    assert isinstance(yoke, type(there))
    assert [check.to_dict() for check in yoke.checks] == [c.to_dict() for c in there.checks]


def test_a_design_that_was_read_before_is_checked_as_its_file(yoke):
    design = ballesta.read_design(YOKE)
    found = ballesta.check(design, fidelity="formula")
    assert found.deciding.value == yoke.deciding.value
    with pytest.raises(ballesta.DesignError, match="overrides: are of a design file"):
        ballesta.check(design, ["parts.yoke.thickness = 40 mm"])


def cells(html):
    rows = re.findall(r"<tr>(.*?)</tr>", html)
    found = [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row) for row in rows]
    return [[unescape(cell) for cell in row] for row in found]


def test_a_notebook_shows_the_answer_of_the_terminal_with_a_row_for_each_part(yoke):
    answer, html = answer_of(yoke), yoke._repr_html_()
    first = unescape(html.splitlines()[0])
    assert ": PASS" in first
    assert f"safety {answer.safety}, {answer.required} required" in first
    rows = cells(html)
    assert answer.rows[0].parts == "yoke"
    for row in answer.rows:
        assert list(row.cells) in rows
    for fact in (*answer.headline, *answer.beside):
        assert [fact.label, fact.line] in rows


def test_a_name_with_signs_of_html_is_text(yoke):
    from dataclasses import replace

    html = answer_html(replace(yoke, name="<script>alert(1)</script> & Co"))
    assert "<script>" not in html
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; Co" in html


def test_loads_in_a_notebook_are_the_text_of_the_command():
    html = ballesta.loads(YOKE)._repr_html_()
    assert html.startswith("<pre>")
    assert "guide:piston" in html


@pytest.mark.slow
def test_a_script_without_a_main_guard_runs_a_batch(tmp_path):
    """Its workers do not import it: were it so, each would start a batch."""
    script = tmp_path / "sweep.py"
    script.write_text(f"""
import ballesta
print("once")
result = ballesta.batch(
    {str(YOKE)!r}, "heights", fidelity="formula", reports=False,
    sweeps=["parts.yoke.thickness = 36, 44 mm"],
)
print(result.exit_code, *(outcome["status"] for outcome in result.outcomes))
print(result._repr_html_())
""")
    said = python("-P", str(script), cwd=tmp_path)
    assert said.count("once") == 1
    assert "0 pass pass" in said
    names = [row[0] for row in cells(said)]
    assert names == ["design", "yoke_actuator-1", "yoke_actuator-2"]
    assert (tmp_path / "heights" / "index.html").is_file()
