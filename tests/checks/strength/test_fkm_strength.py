"""FKM's chain on a part: utilisation by hand, support from the mesh, and no worst point missed."""

from math import sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ballesta.machine.solved_cycles import solve_cycles
from checks.design.strength import FkmStrength
from checks.part.part_loads import loads_on
from checks.strength import fatigue_assessment
from checks.strength.fatigue_assessment import FkmUse
from checks.strength.fkm_strength import fkm_judgement, fkm_points, slopes_of
from checks.strength.part_strength import elastic_of, endurance_of
from checks.stress.duty_verdict import JOINED, duty_runs, duty_verdict
from checks.stress.solid_mesh_level import Models, solve_level
from fatigue import FkmMaterial, findley_criterion
from fem.gradient import SurfaceSlopes
from fem.unit_solutions import Elastic, determinate_hold
from geometry.shape import Half

from ...boundary_value import SolidProblem, traction_load
from ...fem.blocks import block
from ...small_machine import PLATE, machine
from ...validation.plane.fields import kirsch_stress
from ...validation.solids.meshes import mapped
from ...validation.solids.problems import held

# S275 as rolled, Rz 200 um, by hand: sigma_W = 0.45 410 = 184.5 MPa,
# K_R = 1 - 0.22 lg 200 lg(820/400) = 0.8422, K_WK = 1 + (1/0.8422 - 1)/2 = 1.0937
S275 = FkmStrength(FkmMaterial(410.0), 200.0)
EVEN = 168.69  # MPa, sigma_WK without support
REACH = 10 ** -(0.5 + 410 / 2700)  # of Stieler's support number
M = 0.35 * 0.41 - 0.1
STEEL = Elastic(210e3, 0.3, 7.85e-9)


def tension(*points):
    """Basis and slopes of points in tension: (MPa per unit, 1/mm)."""
    basis, slope = np.zeros((2, len(points), 6, 1))
    for row, (stress, gradient) in enumerate(points):
        basis[row, 0], slope[row, 0] = stress, -gradient * stress
    return basis, slope


def judged(basis, slope, coefficients, strength=S275, runs=None, slopes=None):
    coefficients = np.atleast_2d(np.asarray(coefficients, dtype=float))
    runs = runs or {"a": np.arange(coefficients.shape[1])}
    return fkm_judgement(strength, basis, coefficients, runs, slopes or (lambda rows: slope[rows]))


def counted(slopes):
    """The same slopes, and the points that they were asked for."""
    asked = []
    return lambda rows: asked.extend(rows) or slopes(rows), asked


@pytest.mark.parametrize(
    ("history", "factor"),
    [
        ([-100.0, 100.0], 1.0),
        ([-50.0, 150.0], 1 / (1 + M / 2)),
        ([0.0, 200.0], 1 / (1 + M)),
        ([100.0, 300.0], (1 + M / 3) / (1 + M) / (1 + 2 * M / 3)),
        ([400.0, 600.0], (3 + M) / (3 * (1 + M) ** 2)),
        ([-300.0, -100.0], 1.0),
    ],
)
def test_a_point_in_tension_by_hand(history, factor):
    """Amplitude 100 MPa, G = 0.25/mm; R = -1, -1/3, 0, 1/3, 2/3 and compression."""
    found = judged(*tension((1.0, 0.25)), [history])
    support = 1 + REACH * sqrt(0.25)
    assert found.amplitude == pytest.approx(100.0)
    assert found.gradient == pytest.approx(0.25)
    assert float(found.limit.support) == pytest.approx(support)
    assert found.mean_factor == pytest.approx(factor)
    assert found.utilisation == pytest.approx(100 / (factor * EVEN * support), rel=1e-4)
    assert found.demand == pytest.approx(100 / (factor * support), rel=1e-12)
    assert found.pair == (0, 1)


def test_compression_has_no_credit():
    found = judged(*tension((1.0, 0.0)), [[-150.0, 50.0]])
    assert (found.mean, found.mean_factor) == (0.0, 1.0)
    reversed_ = judged(*tension((1.0, 0.0)), [[-100.0, 100.0]])
    assert found.utilisation == pytest.approx(reversed_.utilisation)


def test_a_smaller_stress_without_support_is_worse_than_a_larger_one_with_it():
    """100 MPa at G = 1/mm, n = 1.223, against 90 MPa that is even."""
    found = judged(*tension((100.0, 1.0), (90.0, 0.0)), [[-1.0, 1.0]])
    assert found.point == 1
    assert found.utilisation == pytest.approx(90 / EVEN, rel=1e-4)


def test_stress_that_rises_inwards_has_no_support():
    found = judged(*tension((100.0, -3.0)), [[-1.0, 1.0]])
    assert float(found.limit.support) == 1.0


def test_reversed_torsion_endures_less_by_the_square_root_of_three():
    basis = np.zeros((1, 6, 1))
    basis[0, 3] = 100.0
    found = judged(basis, -basis / 10.0, [[-1.0, 1.0]])
    assert found.amplitude == pytest.approx(100 * sqrt(3))
    assert found.mean == pytest.approx(0.0, abs=1e-9)
    assert found.gradient == pytest.approx(0.1)


def test_aluminium_endures_for_ever_what_its_curve_reaches_at_1e8_cycles():
    """Slope 15 over two decades: 100**(-1/15) = 0.7356 of the strength at 1e6 cycles."""
    alloy = FkmStrength(FkmMaterial(295.0, "wrought_aluminium"), 25.0)
    found = judged(*tension((1.0, 0.0)), [[-50.0, 50.0]], alloy)
    assert alloy.endurance_share == pytest.approx(100 ** (-1 / 15))
    assert found.utilisation == pytest.approx(50 / (float(alloy.plain.limit) * 100 ** (-1 / 15)))
    assert "1e8" in found.facts()["FKM endurance"]
    assert S275.endurance_share == 1.0


def test_a_stress_that_never_changes_uses_nothing():
    found = judged(*tension((300.0, 0.1)), [[1.0, 1.0, 1.0]])
    assert found.utilisation == 0.0
    assert found.safety == float("inf")


def test_a_duty_without_cycles_is_refused():
    with pytest.raises(ValueError, match="at least one cycle"):
        fkm_judgement(S275, *np.zeros((2, 1, 6, 1)), {}, lambda rows: rows)


def random_part(seed, points=300, positions=30, unit_loads=4):
    """Out-of-phase paths of very different size, and slopes of G up to some 1/mm."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.2, 1.0, points)[:, None, None]
    basis = 20.0 * size * rng.normal(size=(points, 6, unit_loads))
    slope = -basis * rng.uniform(-0.2, 1.5, points)[:, None, None]
    slope += rng.normal(size=slope.shape)
    return basis, slope, rng.normal(size=(unit_loads, positions)).cumsum(axis=1)


@pytest.mark.parametrize("seed", range(6))
def test_the_worst_point_is_found_without_judging_all(seed):
    """Brute force: all points on all paths of a duty of two cycles and their joint path."""
    basis, slope, coefficients = random_part(seed)
    runs = duty_runs({"a": slice(0, 12), "b": slice(12, 30)}, {"a": 1.0, "b": 1.0})
    slopes, asked = counted(lambda rows: slope[rows])
    found = judged(basis, slope, coefficients, runs=runs, slopes=slopes)
    each = {
        name: fkm_points(
            S275, basis, coefficients[:, run], np.arange(300), lambda rows: slope[rows]
        )
        for name, run in runs.items()
    }
    worst = max(each, key=lambda name: each[name].utilisation.max())
    point = each[worst].utilisation.argmax()
    assert found.utilisation == pytest.approx(each[worst].utilisation[point], rel=1e-12)
    assert (found.run, found.point) == (worst, point)
    assert found.pair == tuple(sorted(runs[worst][each[worst].pair[point]]))
    assert len(asked) < 300


def test_the_paths_of_brute_force_hold_points_that_support_puts_in_another_order():
    """Else the test above could not tell a bound from a guess."""
    moved = 0
    for seed in range(6):
        basis, slope, coefficients = random_part(seed)
        rows = np.arange(300)
        own = fkm_points(S275, basis, coefficients, rows, lambda rows, s=slope: s[rows])
        even = fkm_points(S275, basis, coefficients, rows, lambda rows, s=slope: 0.0 * s[rows])
        assert (own.utilisation <= even.utilisation).all()
        moved += own.utilisation.argmax() != even.utilisation.argmax()
    assert moved >= 2


@pytest.mark.parametrize("seed", range(3))
def test_all_loads_times_the_safety_use_the_strength_up(seed):
    basis, slope, coefficients = random_part(seed)
    found = judged(basis, slope, coefficients)
    again = judged(basis, slope, found.safety * coefficients)
    assert again.utilisation == pytest.approx(1.0, rel=1e-9)
    assert again.point == found.point
    assert again.gradient == pytest.approx(found.gradient)


def test_the_range_between_two_cycles_decides_and_is_told_by_its_positions():
    history = [[0.0, 100.0, 200.0, 300.0]]
    runs = duty_runs({"a": slice(0, 2), "b": slice(2, 4)}, {"a": 1.0, "b": 1.0})
    found = judged(*tension((1.0, 0.0)), history, runs=runs)
    assert (found.run, found.pair, found.amplitude) == (JOINED, (0, 3), 150.0)


def test_positions_are_counted_over_all_cycles_also_where_the_duty_leaves_one_out():
    runs = duty_runs({"a": slice(0, 2), "b": slice(2, 5)}, {"b": 1.0})
    found = judged(*tension((1.0, 0.0)), [[0.0, 900.0, 50.0, 0.0, 200.0]], runs=runs)
    assert (found.run, found.pair, found.amplitude) == ("b", (3, 4), 100.0)


def test_two_states_of_stress_are_judged_with_the_support_of_the_point():
    found = judged(*tension((1.0, 0.25)), [[0.0, 200.0]])
    stress = np.zeros((2, 6, 2))
    stress[:, 0] = [[0.0, 200.0], [0.0, 100.0]]
    used = found.utilisation_between(stress)
    assert_allclose(used, [found.utilisation, found.utilisation / 2], rtol=1e-12)


def test_a_path_that_is_not_proportional_is_told():
    basis = np.zeros((1, 6, 2))
    basis[0, 0, 0] = basis[0, 3, 1] = 100.0
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    found = judged(basis, 0 * basis, [np.cos(angle), np.sin(angle)])
    assert "no critical plane" in found.facts()["FKM stress path"]
    assert "FKM stress path" not in judged(*tension((1.0, 0.0)), [[0, 9.0]]).facts()


def test_a_beam_in_bending_has_the_support_of_2_over_its_height():
    """Height 8 mm, 100 MPa at its skin: G = 0.25/mm there, over sqrt(3) at the corners.

    Quadratic elements hold the field exactly. The corners have the least support (the mean of
    three normals) and decide: 100/(168.69 (1 + 0.2229 sqrt(0.1443))) = 0.547.
    """
    mesh = block((6, 3, 2), (30.0, 8.0, 5.0), start=(0.0, -4.0, 0.0), distortion=0.2)

    def traction(points, normals):
        return np.stack([points[..., 1] * normals[..., 0], *2 * [0 * points[..., 0]]], axis=-1)

    problem = SolidProblem(mesh, STEEL, determinate_hold(mesh.nodes))
    load = sum(traction_load(problem.elements, name, traction) for name in ("start", "end"))
    solution = problem.solve(load)
    basis, recovery = solution.stress[:, :, None], problem.recovery
    reverse = np.array([[-25.0, 25.0]])

    def slopes(rows):
        return SurfaceSlopes(recovery, rows).of(solution.displacement)

    x, y, z = mesh.nodes[recovery.points].T
    inside = (x > 1e-9) & (x < 30 - 1e-9) & (z > 1e-9) & (z < 5 - 1e-9)
    top = np.flatnonzero((y > 4 - 1e-9) & inside)
    found = fkm_points(S275, basis, reverse, top, slopes)
    assert len(top) > 20
    assert_allclose(found.utilisation, 100 / (EVEN * (1 + REACH * 0.5)), rtol=1e-4)
    worst = fkm_judgement(S275, basis, reverse, {"a": np.arange(2)}, slopes)
    support = 1 + REACH * sqrt(0.25 / sqrt(3))
    assert worst.utilisation == pytest.approx(100 / (EVEN * support), rel=1e-4)


def test_beside_a_hole_the_support_is_that_of_the_hoop_s_gradient():
    """Kirsch, r = 10 mm: G = 7/(3 r), n = 1.108; elements of 0.25 r find 0.84 of G, n = 1.099.

    The mesh costs 1 % of the strength, on the safe side (docs/theory/strength.md).
    """
    radius, outer, count = 10.0, 60.0, 8

    def mapping(x, y, z):
        r, angle = radius * (outer / radius) ** x, np.pi / 2 * y
        return r * np.cos(angle), r * np.sin(angle), outer / count * z

    def traction(points, normals):
        xx, yy, xy = np.moveaxis(kirsch_stress(points[..., :2], radius, 100.0), -1, 0)
        x, y = normals[..., 0], normals[..., 1]
        return np.stack([xx * x + xy * y, xy * x + yy * y, 0 * x], axis=-1)

    volume = np.pi / 4 * (outer**2 - radius**2) * outer / count
    mesh = mapped((count, count, 2), mapping, volume)
    supports = held(mesh, ("y0", "y"), ("y1", "x"), ("z0", "z"), ("z1", "z"))
    problem = SolidProblem(mesh, STEEL, supports)
    solution = problem.solve(traction_load(problem.elements, "x1", traction))
    recovery = problem.recovery
    row = np.searchsorted(recovery.points, [solution.node_at((0.0, radius, 0.0))])
    into = np.array([[0.0, 1.0, 0.0]])

    def slopes(rows):
        return SurfaceSlopes(recovery, rows, into).of(solution.displacement)

    reverse = np.array([[-1.0, 1.0]])
    found = fkm_points(S275, solution.stress[:, :, None], reverse, row, slopes)
    exact = 1 + REACH * sqrt(7 / (3 * radius))
    assert exact - 0.012 < found.support[0] < exact
    plane_strain = 300 * sqrt(1 - 0.3 + 0.3**2)  # von Mises of 300 MPa hoop, 90 MPa along z
    assert found.amplitude[0] == pytest.approx(plane_strain, rel=0.05)


@pytest.fixture(scope="module")
def rods(tmp_path_factory):
    """The rod of the crank and slider, its whole and its half, on coarse meshes."""
    folder = tmp_path_factory.mktemp("rod")
    design = machine(folder, PLATE, "parts.rod.strength=fkm", "parts.rod.roughness=25 um")
    part = design.parts["rod"]
    loads = loads_on(design, part, solve_cycles(design, {}))
    levels = []
    for shape in (part.geometry, Half(part.geometry)):
        solutions = Models().solutions(shape, part.fineness, elastic_of(part))
        levels.append(
            solve_level(
                solutions,
                part.fineness,
                loads,
                endurance_of(part).value,
                part.material.ultimate_stress,
                design.duty.cycles,
            )
        )
    return part.fkm, levels, loads


def level_judged(strength, level, slopes=None):
    duty = level.duty
    return fkm_judgement(
        strength, duty.basis, duty.coefficients, duty.runs, slopes or slopes_of(level.solutions)
    )


def test_a_part_of_a_design_is_judged_like_all_of_its_points_one_by_one(rods):
    strength, levels, _ = rods
    for level in levels:
        slopes, asked = counted(slopes_of(level.solutions))
        found = level_judged(strength, level, slopes)
        each = fkm_points(
            strength,
            level.duty.basis,
            level.duty.path,
            np.arange(len(level.history.nodes)),
            slopes_of(level.solutions),
        )
        assert found.point == each.utilisation.argmax()
        assert found.utilisation == pytest.approx(each.utilisation.max(), rel=1e-12)
        assert len(asked) < len(level.history.nodes) / 10


def test_no_points_have_no_use(rods):
    """Error bars ask for the points that a mesh leaves unresolved, of which there may be none."""
    strength, (level, _), loads = rods
    use = FkmUse(loads, strength.reference, level.judged_duty.ultimate, strength)
    none = np.zeros(0, dtype=int)
    assert use.bound(level, none).shape == use.at(level, none).shape == (0,)


def test_a_history_by_its_stress_at_each_position_has_the_support_of_the_unit_loads(rods):
    """As solved contact gives it: with pressure beside the unit loads, or by its states alone."""
    strength, (level, _), loads = rods
    use = FkmUse(loads, strength.reference, level.judged_duty.ultimate, strength)
    basis, coefficients = level.history.basis, level.coefficients
    points = np.array([use.point(level)])
    beside = np.zeros((1, 6, 2)), np.zeros((2, coefficients.shape[1]))
    wider = use.anew(
        level,
        points,
        np.concatenate([basis[points], beside[0]], axis=2),
        np.concatenate([coefficients, beside[1]]),
    )
    stress, whole = basis[points] @ coefficients, np.eye(coefficients.shape[1])
    by_states = use.anew(level, points, stress, whole, states=coefficients)
    assert_allclose([wider, by_states], use.value(level), rtol=1e-9)


def test_the_half_of_a_part_is_used_like_the_whole(rods):
    """Two coarse meshes of about 0.4 r at the holes: within 5 %."""
    strength, levels, _ = rods
    whole, half = (level_judged(strength, level).utilisation for level in levels)
    assert half == pytest.approx(whole, rel=0.05)


def test_the_facts_of_a_part_follow_by_hand_from_its_stress_and_its_gradient(rods):
    """S275, Rz 25 um: K_R = 1 - 0.22 lg 25 lg 2.05 = 0.9041, K_WK n = 1.0530."""
    strength, levels, _ = rods
    found = level_judged(strength, levels[0])
    facts = found.facts()
    history = levels[0].history
    swing = [history.at(k)[found.point] for k in found.pair]
    xx, yy, zz, xy, yz, zx = (swing[0] - swing[1]) / 2
    amplitude = sqrt(
        ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + yz**2 + zx**2)
    )
    assert facts["fatigue amplitude [MPa]"] == pytest.approx(amplitude)
    gradient = facts["FKM related stress gradient [1/mm]"]
    assert 0.05 < gradient < 0.4  # an edge of a hole of r = 6 mm: 7/(3 r) over sqrt(2) is 0.275
    support = 1 + REACH * (sqrt(gradient) if gradient > 0.1 else gradient * sqrt(10))
    assert facts["FKM support number (Stieler)"] == pytest.approx(support)
    limit = 184.5 * support / 1.0530
    assert facts["FKM component strength, fully reversed [MPa]"] == pytest.approx(limit, rel=1e-4)
    ratio = min(facts["fatigue mean stress [MPa]"] / amplitude, 3.0)
    assert ratio > 1
    growth = (1 + M) / (1 + M / 3) * (1 + M / 3 * ratio)
    assert found.utilisation == pytest.approx(amplitude * growth / limit, rel=1e-4)
    assert facts["FKM group, survival"] == "steel, 97.5 %"


def test_the_band_has_the_point_that_is_worst_by_planes(monkeypatch):
    """A reversed pull of 100 MPa, and one of 95 MPa with torsion a quarter of a cycle later.

    Both have one chord, the second one's shorter; its plane across the pull has 95/sqrt 3 of shear
    and k 95 of normal stress, against (sqrt(1 + k^2) + k)/2 of the limit of a pull alone.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, 65)
    coefficients = np.stack([np.cos(turn), np.sin(turn)])
    basis = np.zeros((2, 6, 2))
    basis[0, 0, 0] = 100.0
    basis[1, 0, 0], basis[1, 3, 1] = 95.0, 95.0 / sqrt(3.0)
    limits = np.full(2, S275.reference)
    duty = duty_verdict(basis, coefficients, limits, S275.reference, 430.0, {"a": np.arange(65)})

    class Even:
        judged_duty, solutions = duty, None

    level = Even()
    monkeypatch.setattr(fatigue_assessment, "_solid", lambda level: level)
    monkeypatch.setattr(
        fatigue_assessment, "slopes_of", lambda _: lambda points: np.zeros((len(points), 6, 2))
    )
    use = FkmUse(None, S275.reference, 430.0, S275)
    demand = use.found(level).demand
    k = findley_criterion().k
    by_hand = 95.0 * (1.0 / sqrt(3.0) + k) / ((sqrt(1.0 + k**2) + k) / 2.0)
    more, said = use.band(level)
    assert use.found(level).point == 0
    assert (demand + more) / demand >= by_hand / 100.0 > 1.1
    assert "Findley" in said
