"""docs/parts.md says what the code of the parts says."""

import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from geometry.meshing import mesh_shape
from geometry.parameters import GIVEN_BY_DESIGN, GIVEN_BY_LINKAGE
from geometry.parts import SHAPES

ROOT = Path(__file__).parent.parent.parent


@pytest.fixture(scope="module")
def tool():
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        import describe_parts
    finally:
        sys.path.pop(0)
    return describe_parts


@pytest.fixture(scope="module")
def page(tool):
    return tool.page()


@pytest.mark.parametrize("name", SHAPES)
def test_every_parameter_of_every_shape_is_on_the_page(page, name):
    section = page.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
    for parameter in fields(SHAPES[name]):
        if parameter.metadata:
            assert f"| `{parameter.name}` | {parameter.metadata['meaning']} |" in section
    for interface in SHAPES[name].fixed_interfaces():
        assert f"| {interface} | " in section


@pytest.mark.parametrize("name", SHAPES)
def test_every_shape_has_a_small_picture(name):
    picture = (ROOT / "docs" / "parts" / f"{name}.svg").read_text(encoding="utf-8")
    assert 2_000 < len(picture) < 60_000
    assert "<svg" in picture


def test_a_picture_is_drawn_the_same_each_time(tool, tmp_path):
    mesh = mesh_shape(tool.DRAWN["prismatic_tube"][0], fineness=0.5)
    for name in ("a", "b"):
        tool.parts_pictures.draw(mesh, tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_drawing_shows_the_near_edges_of_a_box_and_hides_the_far_ones(tool):
    """A solid bar of 20 x 6 x 4 mm seen from in front, above and the right: nine of twelve."""
    drawing = tool.parts_pictures

    class Bar:
        def build(self, gmsh):
            from geometry.shape import Body

            gmsh.model.occ.addBox(0, 0, 0, 20, 6, 4)
            gmsh.model.occ.synchronize()
            return Body({}, [], 2.0, [])

    view = drawing.view_of(mesh_shape(Bar()))
    pieces = drawing.creases_of(view)
    lengths = np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1)
    shown = lengths[view.visible(pieces.mean(axis=1), 0.08)].sum()
    assert shown == pytest.approx(3 * (20 + 6 + 4), rel=1e-6)
    assert len(drawing.outlines_of(view)) == 0


@pytest.mark.parametrize("name", SHAPES)
def test_every_shape_states_what_a_check_needs_of_it(tool, name):
    shape, _ = tool.DRAWN[name]
    assert isinstance(shape, SHAPES[name])
    assert isinstance(shape.stressed_evenly, bool)
    assert all(size > 0 for size in shape.stressed_section)
    assert isinstance(shape.sections, tuple)
    for factor in shape.notch_factors.values():
        assert factor >= 1
    for parameter in fields(shape):
        assert parameter.metadata.get("given_by") in (GIVEN_BY_DESIGN, GIVEN_BY_LINKAGE, None)
