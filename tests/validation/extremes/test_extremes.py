"""Conclusions of docs/extremes.md, with the tolerances it states."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.recovery import LARGEST_RATIO
from fem.unit_solutions import Elastic
from geometry.mesh import MeshError

from . import holes, incompressible, invariance, memory, slender, thin

EPS = np.finfo(float).eps


@cache
def by_ratio():
    """Errors on a mesh as a user's part has it, by Poisson's ratio."""
    mesh = incompressible.free_meshes()["gmsh, fineness 1"]
    return {nu: incompressible.errors(mesh, nu) for nu in incompressible.RATIOS}


class TestPoissonsRatio:
    def test_quadratic_tetrahedra_do_not_lock(self):
        """A locked model is too stiff by tens of per cent at 0.4999; a fifth of one is left."""
        for nu, errors in by_ratio().items():
            assert errors.displacement < 3e-3, nu

    def test_von_mises_stress_holds_at_any_ratio(self):
        assert (
            max(errors.von_mises for errors in by_ratio().values()) < 2 * by_ratio()[0.0].von_mises
        )

    def test_direct_stress_holds_up_to_where_a_gate_warns_and_not_beyond(self):
        assert LARGEST_RATIO in by_ratio()
        for nu, errors in by_ratio().items():
            assert (errors.direct < 2 * errors.von_mises) == (nu <= LARGEST_RATIO), nu
        assert by_ratio()[0.499].direct > 0.2

    def test_the_scatter_does_not_see_the_error_of_the_mean_stress(self):
        assert by_ratio()[0.499].scatter < 0.1 * by_ratio()[0.499].direct

    def test_a_regular_mesh_converges_at_every_ratio_to_0_499(self):
        coarse, middle, fine = incompressible.mapped_meshes().values()
        for nu in (0.3, 0.49, 0.499):
            direct = [incompressible.errors(m, nu).direct for m in (coarse, middle, fine)]
            assert direct[0] > 2.9 * direct[1] > 2.9 * 2.9 * direct[2], nu

    @pytest.mark.parametrize("nu", [0.5, 0.51, -1.0, float("nan")])
    def test_one_half_and_beyond_is_refused(self, nu):
        with pytest.raises(ValueError, match=r"Poisson's ratio must be in \(-1, 0.5\)"):
            Elastic(210e3, nu, 0.0)


@pytest.mark.parametrize("ratio", slender.RATIOS)
class TestSlenderness:
    def test_a_frame_is_exact_at_any_slenderness(self, ratio):
        found = slender.framed(ratio)
        assert abs(found.error) < 1e-9
        assert found.residual < 1e-15

    def test_a_solid_loses_the_fourth_power_of_its_slenderness_in_digits(self, ratio):
        """The bent bar's field is in the elements' space: eps times cond(K), up to (L/h)^4."""
        found = slender.bent(ratio)
        lost = EPS * (200 + 5 * ratio**4)
        assert found.stress < lost
        assert abs(found.turn) < lost
        assert found.reaction < EPS * (200 + 20 * ratio**3)
        assert found.residual < 1e-15

    def test_a_solid_cantilever_is_within_half_a_percent_of_theory(self, ratio):
        """Of two bricks over the height and eight along, none longer than 50 times its height."""
        found = slender.cantilever(ratio, max(8, ratio // 25))
        assert found.aspect <= 50
        assert -5e-3 < found.error < 0
        assert found.balance < EPS * (2e3 + 100 * ratio**3)


def test_a_part_too_slender_for_its_digits_breaks_the_gate_of_its_support_reactions():
    """1e-6 of the largest force (part_facts)."""
    found = {ratio: slender.bent(ratio).gate for ratio in slender.RATIOS}
    assert all(gate < 1e-6 for ratio, gate in found.items() if ratio <= 100)
    assert found[1000] > 1e-6


@pytest.mark.parametrize("aspect", thin.ASPECTS)
def test_an_even_stress_does_not_feel_stretched_elements(aspect):
    for axis in range(3):
        assert thin.stretched_patch(aspect, axis) < 20 * EPS * aspect + 1e-13


@pytest.mark.parametrize("wall", thin.WALLS)
def test_a_thin_cylinders_hoop_stress_holds(wall):
    """0.25 % on 16 elements around a quarter; models agree until the wall is a thousandth thick."""
    found = thin.walls(wall)
    assert found.solid < 2.5e-3
    assert found.ring < 5e-4
    if 1e-3 <= wall <= 0.1:
        assert abs(found.apart) < 2e-6


@pytest.mark.parametrize("factor", invariance.LOADS)
def test_stress_is_proportional_to_the_load_over_eighteen_decades(factor):
    stress, peak, utilisation = invariance.load_scale(factor)
    assert stress < 50 * EPS
    assert max(abs(peak), abs(utilisation)) < 10 * EPS


def test_metres_tell_what_millimetres_tell():
    stress, energy, utilisation = invariance.in_metres()
    assert stress < 1e-11
    assert energy < 1e-12
    assert abs(utilisation) < 1e-12


@pytest.mark.parametrize("degrees", [37, 90, 123])
def test_a_turned_part_has_the_stress_of_the_part(degrees):
    assert invariance.turned(degrees) < 1e-13


@pytest.mark.parametrize("sizes", invariance.AWAY)
def test_a_part_far_from_its_origin_loses_digits_as_its_coordinates_do(sizes):
    """eps times how far it is, times 100; 1e-6 at the farthest that is taken."""
    assert invariance.moved(sizes) < 100 * EPS * (10 + sizes)
    assert invariance.moved(sizes) < 1e-6


def test_a_part_farther_than_ten_million_sizes_is_refused():
    with pytest.raises(MeshError, match="its coordinates lose their digits; move it closer"):
        invariance.moved(2e7)


@pytest.mark.parametrize("step", invariance.ROUNDED)
def test_rounded_coordinates_change_the_stress_as_much_as_the_elements(step):
    """Elements are about 1 mm: a step of 1e-6 mm changes a strain by 1e-6."""
    stress, peak = invariance.rounded(step)
    assert stress < 2 * step
    assert abs(peak) < step


def test_shuffled_nodes_and_elements_tell_the_same():
    assert invariance.renumbered() < 1e-13


class TestHoles:
    def test_a_strip_with_a_hole_has_the_published_concentration(self):
        for ratio, published in holes.PUBLISHED.items():
            assert_allclose(holes.strip(ratio), published, rtol=3e-3)

    @pytest.mark.slow
    def test_its_concentration_falls_from_three_to_two(self):
        ratios = sorted((*holes.RATIOS, *holes.OUTER))
        found = [holes.strip(ratio) for ratio in ratios]
        assert np.all(np.diff(found) < 0)
        assert_allclose(found[0], 3, atol=0.015)
        assert_allclose(found[-1], 2, atol=0.01)

    @pytest.mark.slow
    def test_a_link_is_meshed_with_any_hole_and_its_loads_arrive(self):
        for ratio in holes.RATIOS:
            link = holes.link(ratio)
            assert link.quality > 0.1, ratio
            assert link.raw < 1e-4, ratio
            assert link.reaction < 1e-11, ratio

    @pytest.mark.slow
    def test_a_mesh_with_mended_elements_has_the_same_peak_again(self):
        """Gmsh moves some nodes by up to 5e-4 mm differently each time; elsewhere by nothing."""
        assert_allclose(holes.link.__wrapped__(0.1).peak, holes.link(0.1).peak, rtol=1e-6)
        assert holes.link.__wrapped__(0.5).peak == holes.link(0.5).peak

    @pytest.mark.slow
    def test_a_links_peak_rises_when_its_ligaments_shrink(self):
        """Over the pressure F / (d t) of its pin."""
        pressed = [holes.link(r).peak * r / (1 - r) for r in holes.RATIOS[1:]]
        assert np.all(np.diff(pressed) > 0)

    @pytest.mark.slow
    @pytest.mark.parametrize("gap", [1.0, 0.1])
    def test_a_ligament_of_a_hundredth_of_the_hole_is_meshed(self, gap):
        quality, _ = holes.between_holes(gap)
        assert quality > 0.2

    @pytest.mark.slow
    @pytest.mark.parametrize("gap", [1e-3, 1e-5])
    def test_a_rim_without_thickness_is_refused_with_its_likely_cause(self, gap):
        said, _ = holes.beside_a_hole(gap)
        assert "a wall or a ligament may be far thinner than the elements beside it" in str(said)


@pytest.mark.slow
@pytest.mark.parametrize("counts", memory.SMALL, ids=("cube", "plate", "rod"))
def test_the_memory_of_a_solve_is_told_to_30_percent(counts):
    """The largest of five: the allocator returns 5 MB of a plate's 181 early in one of three."""
    found = max((memory.measured(counts) for _ in range(5)), key=lambda taken: taken.measured)
    assert 0.7 < found.predicted / found.measured < 1.3
