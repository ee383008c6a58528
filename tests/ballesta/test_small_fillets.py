"""Error bars of peaks in small fillets and at shallow sharp edges, where a first mesh is blind.

A bar of 6 mm plate, 36 mm high at its holes and 12 mm high between them, under 10 kN and 60 N m.
The references are ballesta's own peaks at an accuracy of 1 % with at least four meshes.
"""

from math import pi, radians, tan
from types import SimpleNamespace

import numpy as np
import pytest

from checks.ladder.levels import solve_levels
from checks.part.loaded_part import LoadedPart
from checks.part.part_loads import PartLoads
from checks.stress.error_bars import bars_of
from checks.stress.judged import StaticPeak
from checks.stress.solid_mesh_level import Models
from fem.singularity import singular_exponent
from geometry.meshing import gmsh_session
from geometry.parts.step_part import NamedHole, StepPart

HOLES = (NamedHole("a", 12), NamedHole("b", 12.4))
LOADS = PartLoads(
    {"a": np.array([[-1e4, 0, 0, 0, 0, -60e3]]), "b": np.array([[1e4, 0, 0, 0, 0, 60e3]])},
    np.zeros((1, 4)),
    {"pull": slice(0, 1)},
    ("pulled",),
    ("pull",),
)
PEAKS = {2.0: 998.5, 0.5: 1631.0, 0.15: 2673.0}  # radius, mm: MPa, to 1 %
pytestmark = pytest.mark.slow


def bar(file, outline):
    """A STEP file with the bar of which `outline` draws the plate in gmsh."""
    with gmsh_session() as gmsh:
        outline(gmsh)
        kernel = gmsh.model.occ
        holes = [
            (3, kernel.addCylinder(x, 0, -6, 0, 0, 12, d / 2)) for x, d in ((0, 12), (120, 12.4))
        ]
        kernel.cut(kernel.getEntities(3)[:1], holes)
        kernel.synchronize()
        gmsh.write(str(file))
    return StepPart(file, HOLES)


def with_fillets(radius):
    def outline(gmsh):
        kernel = gmsh.model.occ
        boxes = [(-22, 18, 47), (25, 6, 70), (95, 18, 47)]
        solids = [(3, kernel.addBox(x, -h, -3, length, 2 * h, 6)) for x, h, length in boxes]
        fused, _ = kernel.fuse(solids[:1], solids[1:])
        kernel.synchronize()
        corners = []
        for _, edge in gmsh.model.getEntities(1):
            box = np.reshape(gmsh.model.getBoundingBox(1, edge), (2, 3))
            x, y = box.mean(axis=0)[:2]
            upright = np.ptp(box[:, :2], axis=0).max() < 1e-3
            if upright and min(abs(x - 25), abs(x - 95)) < 1e-3 and abs(abs(y) - 6) < 1e-3:
                corners.append(edge)
        assert len(corners) == 4
        kernel.fillet([fused[0][1]], corners, [radius])

    return outline


def with_ramps(turn):
    def outline(gmsh):
        kernel = gmsh.model.occ
        run = 12 / tan(radians(turn))
        upper = [(-22, 18), (25, 18), (25 + run, 6), (95 - run, 6), (95, 18), (142, 18)]
        corners = [*upper, *((x, -y) for x, y in reversed(upper))]
        points = [kernel.addPoint(x, y, -3) for x, y in corners]
        lines = [
            kernel.addLine(p, q) for p, q in zip(points, [*points[1:], points[0]], strict=True)
        ]
        face = kernel.addPlaneSurface([kernel.addCurveLoop(lines)])
        kernel.extrude([(2, face)], 0, 0, 6)

    return outline


def judged(shape, accuracy):
    material = SimpleNamespace(
        youngs_modulus=210e3, poisson_ratio=0.3, density=7.85e-9, ultimate_stress=500.0
    )
    part = SimpleNamespace(
        name="bar",
        geometry=shape,
        fineness=1.0,
        most_unknowns=250_000,
        material=material,
        bearing_arc=pi,
        arc_stated=True,
        clearances={},
    )
    design = SimpleNamespace(duty=SimpleNamespace(cycles={}), accuracy=accuracy)
    peak = StaticPeak(LOADS)
    levels, _, _ = solve_levels(
        LoadedPart(design, part, LOADS), Models(), [peak], 200.0, lambda _: None
    )
    return peak.value(levels[-1]), bars_of(peak, part, levels, accuracy)


@pytest.mark.parametrize(("radius", "accuracy"), [(2.0, 0.05), (0.5, 0.2)])
def test_the_peak_in_a_fillet_lies_inside_its_bar(tmp_path, radius, accuracy):
    value, bars = judged(bar(tmp_path / "bar.step", with_fillets(radius)), accuracy)
    reach = bars.numerical.value + 0.01 * value
    assert abs(value - PEAKS[radius]) < reach
    assert reach < 0.25 * value


def test_a_fillet_far_smaller_than_the_first_elements_is_found(tmp_path):
    """Two meshes agreed on 2000 MPa to 4 %: neither saw the radius of 0.15 mm.

    At an accuracy of 20 %, which ends first: what finds it there is refined further by 5 %.
    """
    value, bars = judged(bar(tmp_path / "bar.step", with_fillets(0.15)), 0.2)
    assert abs(value - PEAKS[0.15]) < bars.numerical.value + 0.01 * value


@pytest.mark.parametrize(("turn", "accuracy"), [(20, 0.05), (34, 0.2)])
def test_a_shallow_sharp_edge_is_never_judged(tmp_path, turn, accuracy):
    _, bars = judged(bar(tmp_path / "bar.step", with_ramps(turn)), accuracy)
    exponent = singular_exponent(radians(180 + turn))
    assert bars.numerical.singular == pytest.approx(exponent, abs=0.01)
    assert "singular: a sharp re-entrant edge" in bars.note
