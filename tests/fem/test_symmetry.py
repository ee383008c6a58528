"""Half of a part under loads in its plane is half of the whole, to round-off.

The whole mesh is the half and its mirror image, so that the discrete problems are the same one.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem.buckling import buckling_modes
from fem.deck import write_deck
from fem.recovery import stress_error
from fem.unit_loads import resultants
from fem.unit_solutions import Elastic, compliance, rigid_modes, solve_unit_loads
from geometry.mesh import SYMMETRY, MeshError
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink, PrismaticTube, SlottedLever
from geometry.shape import Half

from .blocks import BAR
from .direct_stress import direct_stress
from .mirrors import whole_of

STEEL = Elastic(210e3, 0.3, 7.85e-9)
N_POSITIONS = 8
LEVER = SlottedLever(
    length=100,
    width=30,
    thickness=8,
    hole=12,
    slot_width=12,
    slot_from=20,
    slot_to=80,
    contact_length=12,
)
SHAPES = {
    "toggle_bar": BAR,
    "plate_link": PlateLink(length=50, width=20, thickness=8, hole=8, second_hole=12),
    "prismatic_tube": PrismaticTube(length=60, width=20, wall=4, inner_radius=1),
    "slotted_lever": LEVER,
}
FINENESS = {"toggle_bar": 0.4, "slotted_lever": 0.45}


class Pair:
    """A half and its mirrored whole, solved, under the same loads."""

    def __init__(self, name):
        mesh = mesh_shape(Half(SHAPES[name]), fineness=FINENESS.get(name, 0.5))
        self.half = solve_unit_loads(mesh, STEEL)
        self.whole = solve_unit_loads(whole_of(mesh), STEEL)
        self.wrenches, self.accelerations, self.reaches = _cycle(self.whole.mesh)
        self.of_half, self.of_whole = (
            s.coefficients(self.wrenches, self.accelerations, self.reaches)[0]
            for s in (self.half, self.whole)
        )


def _cycle(mesh):
    """Random motion and pin forces; the second interface takes what Newton and Euler leave."""
    random = np.random.default_rng(11)
    a = random.uniform(-1, 1, (N_POSITIONS, 4)) * [2e5, 2e5, 1e3, 2e3]
    a[:, 3] = np.abs(a[:, 3])
    names = list(mesh.interfaces)
    wrenches = {name: np.zeros((N_POSITIONS, 6)) for name in names}
    reaches = {}
    for name in names:
        if name == names[1]:
            continue
        wrenches[name][:, :2] = random.uniform(-2e3, 2e3, (N_POSITIONS, 2))
        face = mesh.interfaces[name]
        if face.kind == "slide":
            reaches[name] = random.uniform(*face.travel, N_POSITIONS)
            wrenches[name][:, 5] = reaches[name] * wrenches[name][:, 1]
        else:
            wrenches[name][:, 5] = random.uniform(-1e3, 1e3, N_POSITIONS)
    mass = mesh.mass_properties(STEEL.density)
    (cx, cy, _), m = mass.centre, mass.mass
    force = m * np.stack(
        [
            a[:, 0] - a[:, 2] * cy - a[:, 3] * cx,
            a[:, 1] + a[:, 2] * cx - a[:, 3] * cy,
        ],
        axis=1,
    )
    moment = mass.inertia * a[:, 2] + cx * force[:, 1] - cy * force[:, 0]
    for name in names:
        if name != names[1]:
            arm, wrench = mesh.interfaces[name].centre, wrenches[name]
            force -= wrench[:, :2]
            moment -= wrench[:, 5] + arm[0] * wrench[:, 1] - arm[1] * wrench[:, 0]
    last, arm = wrenches[names[1]], mesh.interfaces[names[1]].centre
    last[:, :2] = force
    last[:, 5] = moment - arm[0] * force[:, 1] + arm[1] * force[:, 0]
    return wrenches, a, reaches


@pytest.fixture(scope="module", params=SHAPES)
def pair(request):
    return Pair(request.param)


@pytest.fixture(scope="module")
def bar():
    return Pair("toggle_bar")


def test_a_half_has_the_stress_of_the_whole_at_every_point_and_position(pair):
    """Round-off only: cond(K) * eps is about 1e7 * 2e-16."""
    nodes, points = pair.whole.recovery.points, pair.half.recovery.points
    assert np.isin(points, nodes).all()
    whole = (pair.whole.basis @ pair.of_whole)[np.searchsorted(nodes, points)]
    half = pair.half.basis @ pair.of_half
    assert np.abs(whole).max() > 1.0
    assert_allclose(half, whole, rtol=0, atol=1e-8 * np.abs(whole).max())


def test_a_half_moves_as_the_whole_but_for_a_rigid_motion_in_its_plane(pair):
    count = len(pair.half.mesh.nodes)
    whole = (pair.whole.displacement @ pair.of_whole)[: 3 * count]
    away = pair.half.displacement @ pair.of_half - whole
    modes = rigid_modes(pair.half.mesh.nodes)
    motion = np.linalg.lstsq(modes, away, rcond=None)[0]
    size = np.abs(whole - modes @ np.linalg.lstsq(modes, whole, rcond=None)[0]).max()
    assert_allclose(modes @ motion, away, rtol=0, atol=1e-8 * size)


def test_the_loads_of_a_half_are_half_of_those_of_the_whole(pair):
    """F_x, F_y and M_z of every unit load that is even in z; those of inertia in the same way."""
    for half, whole in zip(pair.half.interfaces, pair.whole.interfaces, strict=True):
        assert half.names == whole.names
        centre = half.interface.centre
        got = resultants(pair.half.elements, half.vectors, centre)[[0, 1, 5]]
        wanted = resultants(pair.whole.elements, whole.vectors, centre)[[0, 1, 5]] / 2
        assert_allclose(got, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())
    assert_allclose(
        pair.half.unit_resultants[[0, 1, 5], -4:],
        pair.whole.unit_resultants[[0, 1, 5], -4:] / 2,
        rtol=1e-9,
        atol=1e-12,
    )


def test_a_half_needs_no_support_in_its_plane(pair):
    assert len(pair.half.supports) == 3
    assert set(pair.half.supports % 3) == {0, 1}
    force = max(np.abs(wrench[:, :2]).max() for wrench in pair.wrenches.values())
    assert np.abs(pair.half.reactions(pair.of_half)).max() < 1e-8 * force


def test_error_estimate_and_scatter_of_a_half_are_those_of_the_whole(pair):
    states = pair.half.displacement @ pair.of_half, pair.whole.displacement @ pair.of_whole
    half = stress_error(pair.half.recovery, states[0][:, 0])
    whole = stress_error(pair.whole.recovery, states[1][:, 0])
    count, most = len(half.error), whole.error.max()
    assert_allclose(half.error, whole.error[:count], rtol=0, atol=1e-7 * most)
    scatter = pair.half.recovery.scatter(states[0][:, 0])
    other = pair.whole.recovery.scatter(states[1][:, 0])
    other = other[np.searchsorted(pair.whole.recovery.points, pair.half.recovery.points)]
    meet = np.bincount(pair.half.mesh.elements.ravel(), minlength=len(pair.half.mesh.nodes))
    points = pair.half.recovery.points
    # an element and its own mirror agree by construction: the half looks around, the whole cannot
    twin = np.isin(points, pair.half.mesh.cut_nodes) & (meet[points] == 1)
    assert_allclose(scatter[~twin], other[~twin], rtol=0, atol=1e-7 * other.max())
    assert np.all(scatter[twin] >= other[twin] * (1 - 1e-7))
    some = np.argsort(scatter)[[-1, -50, 50]]
    alone = pair.half.recovery.scatter(states[0][:, 0], some)
    assert_allclose(alone, scatter[some], rtol=1e-12)


def test_a_pressure_on_an_arc_gives_a_half_the_stress_of_the_whole(bar):
    wrenches = {name: wrench[2] for name, wrench in bar.wrenches.items()}
    half = direct_stress(bar.half, wrenches, bar.of_half[:, 2], [2.0])[..., 0]
    whole = direct_stress(bar.whole, wrenches, bar.of_whole[:, 2], [2.0])[..., 0]
    whole = whole[np.searchsorted(bar.whole.recovery.points, bar.half.recovery.points)]
    assert_allclose(half, whole, rtol=0, atol=1e-8 * np.abs(whole).max())


def test_arcs_that_are_solved_together_have_each_its_own_stress(bar):
    wrenches = {name: wrench[2] for name, wrench in bar.wrenches.items()}
    arcs = [np.pi, 2.5, 2.0]
    together = direct_stress(bar.half, wrenches, bar.of_half[:, 2], arcs)
    for k, arc in enumerate(arcs):
        alone = direct_stress(bar.half, wrenches, bar.of_half[:, 2], [arc])[..., 0]
        assert_allclose(together[..., k], alone, rtol=0, atol=1e-9 * np.abs(alone).max())
    assert np.abs(together[..., 0] - together[..., 2]).max() > 0.01 * np.abs(together).max()


def test_the_cut_of_a_half_is_none_of_its_surface(bar):
    mesh = bar.half.mesh
    inner = np.setdiff1d(mesh.cut_nodes, whole_of(mesh).surface_nodes)
    assert len(inner) > 10
    assert not np.isin(inner, bar.half.recovery.points).any()


@pytest.mark.parametrize("component", [2, 3, 4])
def test_loads_out_of_the_plane_are_refused_on_a_half(bar, component):
    wrenches = {name: wrench.copy() for name, wrench in bar.wrenches.items()}
    for wrench, sign in zip(wrenches.values(), (1, -1), strict=True):
        wrench[3, component] = sign * 12.5
    with pytest.raises(ValueError, match=r"'knee' carries .* up to 12\.5; .* half of the part"):
        bar.half.coefficients(wrenches, bar.accelerations)


def test_a_half_of_a_link_takes_no_couples_of_its_tilting_pins():
    pair = Pair("plate_link")
    tilting = solve_unit_loads(whole_of(pair.half.mesh, tilts=True), STEEL)
    assert "M_x" in tilting.interfaces[0].names
    assert "M_x" not in pair.half.interfaces[0].names
    wrenches = {name: wrench.copy() for name, wrench in pair.wrenches.items()}
    for wrench, sign in zip(wrenches.values(), (1, -1), strict=True):
        wrench[:, 3] = sign * 40.0
    tilting.coefficients(wrenches, pair.accelerations)
    with pytest.raises(ValueError, match="half of the part"):
        pair.half.coefficients(wrenches, pair.accelerations)


def test_what_needs_the_whole_part_refuses_a_half(bar, tmp_path):
    with pytest.raises(MeshError, match=r"buckling.* needs the whole part"):
        buckling_modes(bar.half, bar.of_half[:, 0], tilt_held=False)
    with pytest.raises(MeshError, match="compliance needs the whole part"):
        compliance(bar.half, ["knee"])
    mesh, load = bar.half.mesh, bar.half.loads[:, 0]
    with pytest.raises(MeshError, match="deck needs the whole part"):
        write_deck(tmp_path / "half.inp", mesh, STEEL, bar.half.held, load, "half")


def test_mass_properties_of_a_half_are_those_of_the_whole(pair):
    half, whole = (s.mesh.mass_properties(7.85e-9) for s in (pair.half, pair.whole))
    assert_allclose(half.mass, whole.mass, rtol=1e-12)
    assert_allclose(half.inertia, whole.inertia, rtol=1e-12)
    assert_allclose(half.centre, whole.centre, rtol=0, atol=1e-10)


def test_a_half_that_is_not_cut_at_its_plane_is_refused(bar):
    mesh = bar.half.mesh
    with pytest.raises(MeshError, match="must end at z = 0"):
        replace(mesh, nodes=mesh.nodes - [0, 0, 1e-3])
    with pytest.raises(MeshError, match="needs the surface 'symmetry'"):
        replace(mesh, surfaces={k: v for k, v in mesh.surfaces.items() if k != SYMMETRY})
