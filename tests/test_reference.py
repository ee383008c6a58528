"""The pages of docs/reference say what the code says."""

import json
import re
import sys
from pathlib import Path
from typing import get_args

import pytest

from ballesta.pipeline import check_file
from checks.design.effort import Effort
from checks.design.model import DesignFile, Requirements, SafetyKey
from checks.ladder.part_ladder import known_kinds
from geometry.parts import SHAPES

ROOT = Path(__file__).parent.parent
SITE = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")


def _tool():
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        import reference
    finally:
        sys.path.pop(0)
    return reference


TOOL = _tool()


@pytest.mark.parametrize("file", TOOL.PAGES, ids=lambda file: file.name)
def test_a_page_of_the_reference_is_up_to_date(file):
    assert file.read_text(encoding="utf-8") == TOOL.PAGES[file](), f"run {TOOL.__file__}"


def test_every_key_of_the_schema_is_on_the_page():
    """Those of the shapes are on the page of the shapes."""
    page = TOOL.design_file_page()
    schema = DesignFile.model_json_schema()
    own = {shape.__name__ + "Part" for shape in SHAPES.values()}
    tables = [schema, *(one for name, one in schema["$defs"].items() if name not in own)]
    keys = {key for table in tables for key in table.get("properties", ())}
    assert len(keys) > 100
    assert {key for key in keys if f"| `{key}` |" not in page} == set()


def test_no_text_of_the_pages_is_taken_for_a_tag():
    for file in (ROOT / "docs" / "reference").glob("*.md"):
        text = re.sub(r"```.*?```", "", file.read_text(encoding="utf-8"), flags=re.DOTALL)
        plain = re.sub(r"`[^`\n]*`", "", text)
        assert re.findall(r"<\w+>", plain) == [], file.name


def matching(check):
    return [kind for kind in known_kinds() if kind.has(check)]


def test_every_check_of_the_designs_is_on_the_page_once():
    found = set()
    for file in sorted((ROOT / "designs").rglob("*.baseline.json")):
        parts = json.loads(file.read_text(encoding="utf-8"))["parts"]
        for quantity in (one for part in parts.values() for one in part["checks"]):
            (kind,) = matching(quantity)
            found.add(kind)
    assert len(found) > len(known_kinds()) / 2


@pytest.mark.parametrize("design", ["toggle_press", "gallery/yoke_actuator"])
def test_a_check_needs_the_safety_that_the_page_says(design):
    """With four safeties that no two keys share."""
    given = {key: field.default + 0.01 for key, field in Requirements.model_fields.items()}
    wanted = [f"require.{key}={value}" for key, value in given.items()]
    result = check_file(ROOT / "designs" / f"{design}.toml", wanted, effort=Effort("formula"))
    assert result.checks
    for check in result.checks:
        (one,) = matching(f"{check.kind}: {check.quantity}")
        assert check.required == given[one.require], check.quantity


def test_a_safety_is_named_by_a_key_of_the_design_file():
    assert set(get_args(SafetyKey)) == set(Requirements.model_fields)


def test_every_page_of_docs_is_in_the_navigation():
    """Which the build of the site asks for, too; here it needs none."""
    docs = ROOT / "docs"
    pages = {str(page.relative_to(docs).as_posix()) for page in docs.rglob("*.md")}
    assert pages | {"index.md"} == set(re.findall(r": ([\w/]+\.md)\b", SITE))
