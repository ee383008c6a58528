"""Forces solved again on a motion that is known, against cycles run from the beginning."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import loads.cycle
from loads import Contact, CycleError, Friction, Table, forces_again, moves_alike, run_cycle

from .machines import press_cycle, toggle

# Two ways through the same linear systems: cond * eps, about 1e-11 beside the dead centre.
TOLERANCE = 1e-9


def heavier(linkage, factor=3.0):
    """Bars of other masses, centres and inertias, and another mould."""
    bars = {"lower": (0.02, (90.0, 5.0), 700.0), "upper": (0.006, (140.0, 0.0), 50.0)}
    return linkage.with_mass_properties({**bars, "mould": (factor * 0.01, (0.0, 20.0), 0.0)})


def fixed_positions(monkeypatch, known):
    """Let run_cycle place its positions where those of a known cycle are."""
    grids = [known.positions[known.phase_of == k] for k in range(len(known.phases))]
    monkeypatch.setattr(loads.cycle, "_placed", lambda *_: grids)


def is_same(found, expected):
    assert_allclose(found.positions, expected.positions, rtol=1e-13)
    assert found.efforts.keys() == expected.efforts.keys()
    for name, effort in expected.efforts.items():
        assert_allclose(found.efforts[name], effort, atol=TOLERANCE * np.abs(effort).max() + 1e-9)
    for name, reaction in expected.reactions.items():
        for part in ("force", "moment", "friction_couple", "friction_force"):
            wanted = getattr(reaction, part)
            size = TOLERANCE * max(1.0, float(np.abs(wanted).max(initial=0.0)))
            assert_allclose(getattr(found.reactions[name], part), wanted, atol=size)


@pytest.mark.parametrize("rough", [{}, {"mu_pin": 0.1, "mu_guide": 0.1}], ids=["smooth", "rough"])
def test_forces_again_are_those_of_the_whole_run_at_the_same_positions(monkeypatch, rough):
    first = toggle(**rough)
    cycle, other = press_cycle(first), press_cycle(first, pull=7000.0)
    known, second = run_cycle(first, cycle), heavier(first)
    assert moves_alike(first, cycle, second, other)
    again = forces_again(known, second, other)
    fixed_positions(monkeypatch, known)
    is_same(again, run_cycle(second, other))
    # and they are not those that were known
    assert np.abs(again.efforts["process"]).max() < 0.7 * np.abs(known.efforts["process"]).max()


def test_the_ends_of_the_phases_have_the_loads_of_a_run_with_its_own_positions():
    first = toggle()
    cycle = press_cycle(first)
    second = heavier(first)
    again, afresh = forces_again(run_cycle(first, cycle), second, cycle), run_cycle(second, cycle)
    assert not np.array_equal(again.positions, afresh.positions)
    for k in range(len(cycle.phases)):
        ends = [np.flatnonzero(run.phase_of == k)[[0, -1]] for run in (again, afresh)]
        for name, effort in afresh.efforts.items():
            scale = np.abs(effort).max() or 1.0
            found = again.efforts[name][ends[0]]
            assert_allclose(found, effort[ends[1]], rtol=0, atol=TOLERANCE * scale)


def test_bodies_stay_in_equilibrium_with_their_new_masses():
    first = toggle()
    cycle, second = press_cycle(first), heavier(first)
    again = forces_again(run_cycle(first, cycle), second, cycle)
    assert max(again.equilibrium_residual.values()) < TOLERANCE
    assert again.power_balance_error < TOLERANCE


def test_friction_that_was_not_there_before_is_solved_for():
    first = toggle()
    cycle = press_cycle(first)
    rough = replace(first, friction={"B": Friction(0.1, 20.0)})
    again = forces_again(run_cycle(first, cycle), rough, cycle)
    assert np.abs(again.reactions["B"].friction_couple).max() > 0


def test_friction_that_locks_the_linkage_names_the_phase():
    first = toggle()
    cycle = press_cycle(first)
    locked = replace(first, friction={n: Friction(8.0, 20.0) for n in ("A", "B", "C")})
    with pytest.raises(CycleError, match=r"phase '\w+': friction locks the linkage"):
        forces_again(run_cycle(first, cycle), locked, cycle)


def test_another_shape_pace_or_table_does_not_move_alike():
    linkage = toggle()
    cycle = press_cycle(linkage)
    assert not moves_alike(linkage, cycle, toggle(base=360.0), cycle)
    assert not moves_alike(linkage, cycle, linkage, press_cycle(linkage, speed=90.0))
    assert not moves_alike(linkage, cycle, linkage, press_cycle(linkage, last=3.0))

    def tabled(peak):
        laws = {"process": Table(cycle.coordinate, (0.0, 400.0, 500.0), (0.0, peak, 0.0))}
        return replace(cycle, phases=(replace(cycle.phases[0], given=laws), *cycle.phases[1:]))

    assert moves_alike(linkage, tabled(1.0), heavier(linkage), tabled(1.0))
    assert not moves_alike(linkage, tabled(1.0), linkage, tabled(2.0))


def test_a_contact_is_never_taken_to_move_alike():
    """It holds bodies still by an amount that depends on the forces."""
    linkage = toggle()
    cycle = press_cycle(linkage)
    first = replace(cycle.phases[0], given={"process": Contact(-495.0, 1e4)})
    touching = replace(cycle, phases=(first, *cycle.phases[1:]))
    assert not moves_alike(linkage, touching, linkage, touching)
