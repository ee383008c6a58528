"""Beams of a profile with pins along their middle line."""

from dataclasses import replace

import numpy as np
import pytest

from fem.frame_joints import bar_frame
from fem.unit_solutions import Elastic
from geometry.cad_body import cad_body
from geometry.meshing import mesh_shape
from geometry.parameters import ParameterError
from geometry.shape import Half, in_unit, sizes_of
from tests.fem.buckled_frames import frame_buckling

from .bars import HOLES, IPE_160, RHS_120, SHORT_I, SHORT_RHS
from .facets import area


def test_the_volume_of_a_hollow_beam_without_roundings_is_that_of_its_boxes_and_tubes():
    """450 mm of 120 x 60 x 5 mm; each sleeve stands 50 mm free and has its hole over 60 mm."""
    plain = replace(RHS_120, corner=0.0, fillet=0.0)
    walls = 450 * (120 * 60 - 110 * 50)
    sleeves = np.pi / 4 * (2 * 50**2 + 65**2) * 50
    holes = np.pi / 4 * (2 * 30**2 + 40**2) * 60
    assert cad_body(plain).volume == pytest.approx(walls + sleeves - holes, rel=1e-6)


def test_the_ring_of_a_fillet_adds_its_section_times_its_way():
    """Pappus: a spandrel of (1 - pi/4) f^2, its centroid 0.2234 f from the boss, at both webs."""
    with_fillet, plain = (cad_body(replace(RHS_120, fillet=f)).volume for f in (4.0, 0.0))
    rings = [2 * np.pi * (hole.boss / 2 + 0.2234 * 4) for hole in HOLES]
    added = 2 * (1 - np.pi / 4) * 4**2 * sum(rings)
    assert with_fillet - plain == pytest.approx(added, rel=1e-3)


@pytest.mark.parametrize("shape", [RHS_120, IPE_160], ids=["rhs", "i"])
def test_second_moments_are_those_of_the_strips_of_the_section(shape):
    """Both second moments and the area, from 20 000 strips.

    They lose some 5e-5 where the corners' arcs end square to them.
    """
    one, h, b = shape.form.section, shape.height / 2, shape.width / 2
    y = (np.arange(20_000) + 0.5) / 20_000 * h
    if shape is RHS_120:
        wide = b - 10 + np.sqrt(100 - np.maximum(y - h + 10, 0) ** 2)
        gap = b - 10 + np.sqrt(25 - np.minimum(np.maximum(y - h + 10, 0), 5) ** 2)
        gap = np.where(y < h - 5, gap, 0.0)
    else:
        into = np.clip(y - (h - 7.4 - 9), 0, 9)
        wide = np.where(y < h - 7.4, 2.5 + 9 - np.sqrt(81 - into**2), b)
        gap = np.zeros_like(y)
    step = 4 * h / 20_000
    assert one.area == pytest.approx(step * (wide - gap).sum(), rel=2e-4)
    assert one.inertia_in_plane == pytest.approx(step * (y**2 * (wide - gap)).sum(), rel=2e-4)
    assert one.inertia_out_of_plane == pytest.approx(
        step * ((wide**3 - gap**3) / 3).sum(), rel=2e-4
    )


def test_shear_in_the_middle_of_the_height_is_vs_over_it():
    """Of a hollow section by boxes, 1 N: S = 60 60^2/2 - 50 55^2/2 mm3 of the upper half."""
    plain = replace(RHS_120, corner=0.0).form
    first = 60 * 60**2 / 2 - 50 * 55**2 / 2
    inertia = (60 * 120**3 - 50 * 110**3) / 12
    assert plain.shear == pytest.approx(first / (10 * inertia), rel=1e-12)


def test_bores_have_the_area_of_their_holes():
    """Curved elements follow a cylinder of five elements along its radius to 1e-4."""
    for shape in (SHORT_RHS, SHORT_I):
        mesh = mesh_shape(Half(shape), fineness=0.5)
        for hole in shape.holes:
            half = np.pi * hole.diameter * shape.boss_length / 2
            assert area(mesh, mesh.surfaces[hole.name]) == pytest.approx(half, rel=1e-3)


def test_what_no_check_of_a_beam_sees_is_told():
    """Welds of its bosses; of one with a pin in between a column as well, which one of two has."""
    welds, column = RHS_120.told
    assert "their welds and root gaps are not judged" in welds
    assert "no column formula judged it" in column
    two = replace(RHS_120, holes=RHS_120.holes[:2])
    assert two.told == [welds]
    assert two.sections


def test_a_beam_keeps_its_holes_in_another_unit():
    in_metres = in_unit(RHS_120, 1000.0)
    assert [hole.at for hole in in_metres.holes] == [0.0, 0.33, 0.15]
    assert sizes_of(RHS_120)["holes.middle.boss"] == 65.0


def changed(name, **change):
    return tuple(replace(one, **change) if one.name == name else one for one in HOLES)


@pytest.mark.parametrize(
    ("shape", "change", "field", "says"),
    [
        (RHS_120, {"wall": 30.0}, "wall", "two walls fill 60 mm"),
        (RHS_120, {"corner": 30.0}, "corner", "half of a side"),
        (RHS_120, {"fillet": 25.0}, "fillet", "between the webs"),
        (RHS_120, {"overhang": 29.0}, "overhang", "must be above 29 mm"),
        (RHS_120, {"holes": HOLES[:1]}, "holes", "at least two holes"),
        (RHS_120, {"holes": changed("middle", boss=93.0)}, "holes.middle.boss", "below 92 mm"),
        (RHS_120, {"holes": changed("middle", boss=40.0)}, "holes.middle.boss", "above 40 mm"),
        (RHS_120, {"holes": changed("middle", at=64.0)}, "holes.middle.boss", "64 mm apart"),
        (IPE_160, {"flange": 71.0}, "flange", "takes 160 mm of the profile's 160 mm"),
        (IPE_160, {"root": 38.5}, "web", "takes 82 mm of the profile's 82 mm"),
        (IPE_160, {"boss_width": 13.0}, "boss_width", "must be above 13 mm"),
        (IPE_160, {"holes": changed("foot", boss=119.2)}, "holes.foot.boss", "below 119.2 mm"),
    ],
)
def test_what_cannot_be_built_is_refused(shape, change, field, says):
    with pytest.raises(ParameterError, match=says) as caught:
        replace(shape, **change)
    assert caught.value.field == field


@pytest.mark.parametrize("shape", [RHS_120, IPE_160], ids=["rhs", "i"])
def test_a_linkages_beam_buckles_as_eulers_column_that_shears(shape):
    """Engesser: 1/(1/P + 1/(G A_s)), P = pi^2 E I/L^2, L = 2 m; in the plane and, lower, out of it.

    Untwisted; sixteen members are 1e-4 above.
    """
    far = tuple(replace(one, at=2000.0) if one.at == 330.0 else one for one in HOLES)
    steel, long = Elastic(210e3, 0.3, 7.85e-9), replace(shape, holes=far)
    bar, one = long.link(0.3), long.form
    frame = bar_frame(bar, steel, 16)
    last = 6 * (len(frame.nodes) - 1)
    for still, inertia, sheared in (
        (2, one.section.inertia_in_plane, one.sections.shear_area_y),
        (1, one.section.inertia_out_of_plane, one.sections.shear_area_z),
    ):
        ends = [0, 1, 2, 3, last + 1, last + 2, last + 3]
        held = np.unique([*ends, *range(still, last + 6, 6), *range(3, last + 6, 6)])
        found = frame_buckling(frame, np.full(len(frame.members), -1.0), held).factors[0]
        euler = np.pi**2 * 210e3 * inertia / 2000**2
        assert found == pytest.approx(1 / (1 / euler + 2.6 / (210e3 * float(sheared))), rel=3e-4)
