"""Leaves that press and rub on each other, against beams, the elastica and CalculiX."""

import shutil

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_bvp

from bench.leaf_contact import Pack, beams, calculix
from fem.contact.condensed import ALLOWED, ContactError
from fem.contact.leaves import Driven, LeafContact
from fem.leaf_stack import LeafStack

WIDTH, THICK, ARM = 60.0, 9.6, 427.0
MODULUS = WIDTH * THICK**2 / 6


def stack(count=3, spacing=20.0):
    half = 440.0
    places = np.linspace(-half, half, 2 * round(half / spacing) + 1)
    return LeafStack(places, count, WIDTH, THICK, 210e3, 0.3, bolted=len(places) // 2)


def bent(leaves, force=1190.0, clamp=40.0):
    """Loads of equal forces that lift both ends, and of the clamp that holds the middle."""
    tips = force * (leaves.at(ARM) + leaves.at(-ARM))
    middle = leaves.spread((-clamp, clamp), -2 * force, 0.0)
    return leaves.on_faces(tips) + leaves.on_faces(middle)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_leaves_without_friction_share_the_moment(count):
    """At the clamp's edge each has M/n: unilateral contact needs no tie where all bend alike.

    Round-off: the pack's stiffness has a condition of 1e8.
    """
    leaves = stack(count)
    history = LeafContact(leaves).history(leaves.balanced(bent(leaves))[None], 0.0, once=True)
    at = np.flatnonzero(leaves.stress_places == 60)
    expected = 1190 * (ARM - 60) / (count * MODULUS)
    for leaf in range(count):
        assert_allclose(history.stress[0, leaf, 0, at], expected, rtol=1e-7)
        assert_allclose(history.stress[0, leaf, 1, at], -expected, rtol=1e-7)
    assert history.not_complementary < ALLOWED
    assert history.unbalanced < ALLOWED


def test_leaves_that_never_slip_are_the_bonded_pack():
    """Pressed so hard that nothing slips, the same beams as with all gaps and slips tied."""
    leaves = stack()
    contact = LeafContact(leaves)
    loads = leaves.balanced(bent(leaves))
    pressed = leaves.squeezed((-440.0, 440.0), 1e7)
    history = contact.history((loads + pressed)[None], 0.3, once=True)
    bonded = leaves.stress(contact.tied(loads[None], bonded=True))
    assert_allclose(history.stress, bonded, rtol=0, atol=1e-6 * np.abs(bonded).max())


def test_the_bonded_pack_is_one_bar_of_its_whole_height():
    """M/W of 3 t, away from loads; faces are tied at places only: 0.5 % at 20 mm."""
    leaves = stack()
    bonded = LeafContact(leaves).tied(leaves.balanced(bent(leaves))[None], bonded=True)
    stress = leaves.stress(bonded)[0]
    at = np.flatnonzero(leaves.stress_places == 200)
    assert_allclose(stress[0, 0, at].mean(), 1190 * (ARM - 200) / (9 * MODULUS), rtol=5e-3)


def test_friction_at_tip_and_clamp_relieves_the_middle_as_by_hand():
    """Interfaces press 2/3 and 1/3 of the tip's force: friction's couple is mu F t there, and as
    much of the reaction of half the clamp, less an eighth: the bolted middle has that and is still.
    """
    leaves = stack(spacing=10.0)
    loads = leaves.balanced(bent(leaves))
    path = np.array([[0.5], [1.0]]) * loads
    free = LeafContact(leaves).history(path, 0.0, once=True).stress[1]
    rubbed = LeafContact(leaves).history(path, 0.2, once=True).stress[1]
    at = np.flatnonzero(leaves.stress_places == 0)

    def moment(stress):
        return (stress[:, 0, at] - stress[:, 1, at]).mean(axis=1).sum() / 2 * MODULUS

    assert_allclose(moment(free) - moment(rubbed), (1 + 7 / 8) * 0.2 * 1190 * THICK, rtol=0.01)


def test_a_turn_of_loads_repeats_itself_with_a_loop_that_costs_work():
    leaves = stack()
    loads = leaves.balanced(bent(leaves))
    phase = 0.6 + 0.4 * np.sin(np.linspace(0, 2 * np.pi, 16, endpoint=False))
    contact = LeafContact(leaves)
    history = contact.history(phase[:, None] * loads, 0.3)
    assert history.turns == 2
    assert history.not_complementary < ALLOWED

    def work(history):
        steps = history.slips - np.roll(history.slips, 1, axis=0)
        rubbing = np.arange(len(leaves.places)) != leaves.bolted
        return -(history.shears * steps)[..., rubbing].sum()

    assert work(history) > 0
    assert abs(work(contact.history(phase[:, None] * loads, 0.0))) < 1e-6 * work(history)


def test_an_imposed_deflection_finds_the_force_that_had_made_it():
    """Of sliding leaves exactly; friction and what grips need more force for the same."""
    leaves = stack()
    contact = LeafContact(leaves)
    unit = leaves.balanced(bent(leaves, 1.0))
    moved = contact.tied(1190 * unit[None])
    soft = np.array([2e-3])
    driven = Driven(unit[None], moved @ unit + 1190 * soft, soft)
    nothing = np.zeros((1, leaves.n_dofs))
    assert_allclose(contact.history(nothing, 0.0, driven, once=True).force, 1190.0, rtol=1e-7)
    rubbed = contact.history(nothing, 0.3, driven, once=True)
    assert 1190 * 1.001 < rubbed.force[0] < 1190 * 1.02
    gripped = contact.history(leaves.squeezed((-40.0, 40.0), 1e6)[None], 0.3, driven, once=True)
    assert rubbed.force[0] < gripped.force[0]
    assert gripped.not_complementary < ALLOWED


def test_leaves_that_are_bent_apart_open_a_gap():
    """A force that lifts the highest leaf by its own lower face cannot pull the others along."""
    leaves = stack(2)
    loads = np.zeros(leaves.n_dofs)
    loads[leaves.dof(1, 1)] = 50 * (leaves.at(ARM) + leaves.at(-ARM))
    loads[leaves.dof(1, 1)] -= leaves.spread((-40.0, 40.0), 100.0, 0.0)
    loads += leaves.squeezed((-40.0, 40.0), 1e5)
    found = LeafContact(leaves).history(leaves.balanced(loads)[None], 0.2, once=True)
    assert found.gaps[0, 0, 0] > 0.1
    assert_allclose(found.pressures[0, 0, 0], 0.0, atol=1e-6)
    assert found.gaps.min() > -1e-9


def test_impossible_stacks_and_friction_are_refused():
    with pytest.raises(ValueError, match="needs two leaves"):
        LeafStack(np.arange(3.0), 1, 60, 9.6, 210e3, 0.3)
    with pytest.raises(ValueError, match="friction must be at least 0"):
        LeafContact(stack()).history(np.zeros((1, stack().n_dofs)), -0.1)
    assert issubclass(ContactError, ValueError)
    with pytest.raises(ContactError, match="3 leaves that can touch at 601 places are more than"):
        LeafContact(stack(spacing=880 / 600))


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_leaves_on_two_supports_agree_with_calculix():
    """Stiffness within 3 %, stress within 5 %, loaded and relieved (bench/leaf_contact.py).

    Of three, whose middle one rubs on both faces.
    """
    pack = Pack(3, 0.3, 100.0)
    ours, theirs = beams(pack), calculix(pack)
    assert_allclose(ours.deflection, theirs.deflection, rtol=0.03)
    assert_allclose(ours.stress, theirs.stress, rtol=0.05)


def test_large_deflections_change_force_and_moment_of_a_leaf_as_told():
    """Elastica of a cantilever whose tip is pushed square to its root and slides: y'' of the exact
    curvature. At w/L = 0.06 (26 mm of 427) the moment per deflection differs by less than 2.4 w^2.
    """
    share = 0.06

    def turning(s, y):  # angle, curvature, x, y of a length of 1 with a tip force p along y
        return np.stack([y[1], -y[4] * np.cos(y[0]), np.cos(y[0]), np.sin(y[0]), 0 * s])

    def ends(a, b):
        return np.array([a[0], a[2], a[3], b[1], b[3] - share])

    s = np.linspace(0, 1, 41)
    first = np.stack([share * 1.5 * s, 3 * share * (1 - s), s, share * s, 0 * s + 3 * share])
    found = solve_bvp(turning, ends, s, first, tol=1e-10)
    assert found.success
    moment = found.y[1, 0] / (3 * share)
    assert abs(moment - 1) < 2.4 * share**2
