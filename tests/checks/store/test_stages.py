"""Loads, bodies, meshes and solutions from a store: the same numbers, and nothing done twice."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import fem.mode_count
import fem.unit_solutions
import loads
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.pipeline import check_design
from checks.columns import linkage_store
from checks.columns.linkage_store import stored_mode
from checks.design.effort import Effort
from checks.store import solutions as solutions_module
from checks.store.fingerprints import digest
from checks.store.solutions import StoredSolutions
from checks.store.store import Store
from checks.strength.part_strength import elastic_of
from checks.stress import kept_models
from checks.stress.solid_mesh_level import Models
from fem.solvers import chosen_solver
from geometry.sizing import SizeField

from ...small_machine import PLATE, machine

pytestmark = pytest.mark.usefixtures("unshared")
PRESS = Path(__file__).parents[3] / "designs" / "toggle_press.toml"
ROD = ["accuracy=30 %", "parts.rod.mesh.fineness=0.4"]
LIGHT = (1e-3, (100.0, 0.0), 10.0)  # t, mm, t mm2
SOLID, FORMULA = Effort("solid"), Effort("formula")


def numbers(result):
    """Everything that a result says but for times and what it was asked, and its surfaces."""
    plain = result.to_dict()
    for asked in ("timings", "command", "overrides", "inputs", "sha256", "ways_out"):
        del plain[asked]
    for part in plain["parts"]:
        for rung in part["rungs"]:
            del rung["seconds"]
    return digest(plain, [(part.surface, part.mode) for part in result.parts])


class Calls(Counter):
    """How often the work was done that a store is to spare."""

    WORK = (
        (loads, "run_cycle"),
        (kept_models, "cad_skin"),
        (kept_models, "mesh_shape"),
        (solutions_module, "solve_unit_loads"),
        (fem.unit_solutions, "factorize"),
        (fem.mode_count, "factorize"),
    )

    def count(self, patch):
        for module, name in self.WORK:
            if hasattr(module, name):
                patch.setattr(module, name, self._counted(name, getattr(module, name)))

    def _counted(self, name, work):
        def counted(*args, **options):
            self[name] += 1
            return work(*args, **options)

        return counted

    def told(self):
        """What was done since the last time."""
        found = dict(self)
        self.clear()
        return found


@pytest.fixture
def calls(monkeypatch):
    found = Calls()
    found.count(monkeypatch)
    return found


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    """A store that has seen the rod as a solid, its numbers without a store, and what was said."""
    folder, said = tmp_path_factory.mktemp("filled"), []
    store = Store(folder / "store", say=said.append)
    design = machine(folder, PLATE, *ROD)
    plain = numbers(check_design(design, effort=SOLID))
    first = numbers(check_design(design, effort=SOLID, store=store))
    return folder, plain, first, said


def again(filled, *overrides, store=True):
    """The rod, checked with what the store has."""
    folder, *_, said = filled
    design = machine(folder, PLATE, *ROD, *overrides)
    kept = Store(folder / "store", say=said.append) if store else None
    return numbers(check_design(design, effort=SOLID, store=kept))


@pytest.mark.slow
def test_a_solid_has_the_same_numbers_without_a_store_into_one_and_out_of_one(filled, calls):
    _, plain, first, said = filled
    assert first == plain
    assert again(filled) == plain
    assert calls.told() == {}
    assert said == []


def test_a_changed_reliability_neither_meshes_nor_solves_nor_factorises(filled, calls):
    _, plain, *_ = filled
    changed = again(filled, "parts.rod.reliability=99.9 %")
    assert calls.told() == {}
    assert changed != plain
    assert changed == again(filled, "parts.rod.reliability=99.9 %", store=False)


def test_a_changed_speed_neither_meshes_nor_solves_the_unit_loads(filled, calls):
    """Load states that are new need the factor: bearing pressures as they are, and buckling."""
    _, plain, *_ = filled
    changed = again(filled, "cycles.turn.pace.speed=10.5 rad/s")
    done = calls.told()
    assert done.pop("run_cycle") == 1
    assert set(done) <= {"factorize"}
    assert changed != plain
    assert changed == again(filled, "cycles.turn.pace.speed=10.5 rad/s", store=False)


def test_a_changed_thickness_is_meshed_and_solved(filled, calls):
    again(filled, "parts.rod.thickness=8.5 mm")
    done = calls.told()
    assert done["mesh_shape"] == done["solve_unit_loads"] == 2
    assert "cad_skin" not in done


def test_formulas_have_the_same_numbers_out_of_a_store(tmp_path):
    store = Store(tmp_path)
    design = read_design(PRESS, ["cycles.press.positions=31"])
    plain = numbers(check_design(design, effort=FORMULA))
    assert numbers(check_design(design, effort=FORMULA, store=store)) == plain
    assert (store.hits, store.misses) == ({}, {"skin": 2, "loads": 2, "linkage_mode": 1})
    assert numbers(check_design(design, effort=FORMULA, store=store)) == plain
    assert store.hits == store.misses == {"skin": 2, "loads": 2, "linkage_mode": 1}


@pytest.mark.parametrize(
    ("override", "found"),
    [
        ("parts.bar_upper.reliability=99.9 %", True),
        ("require.static=1.4", True),
        ("parts.pin_B.surface=ground", True),
        ("parts.bar_upper.wall=4.5 mm", False),
        ("cycles.press.positions=60", False),
    ],
)
def test_the_mode_of_a_linkage_is_found_again_unless_it_may_be_another(tmp_path, override, found):
    """The slow search is replaced by its inputs: what is told must follow them."""
    coarse = "cycles.press.positions=31"
    store, asked = Store(tmp_path), []

    def mode(design, solved):
        asked.append(design)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(linkage_store, "worst_mode", mode)
        for overrides in ([coarse], [coarse, override]):
            design = read_design(PRESS, overrides)
            solved = solve_cycles(design, {"lower": LIGHT, "upper": LIGHT})
            stored_mode(store, design, solved)
    assert len(asked) == (1 if found else 2)


@pytest.fixture(scope="module")
def solutions(tmp_path_factory):
    """Unit solutions of the rod: solved, and out of a store."""
    folder = tmp_path_factory.mktemp("solutions")
    part = machine(folder, PLATE).parts["rod"]

    def solved(store):
        return Models(store).solutions(part.geometry, 0.3, elastic_of(part))

    solved(Store(folder / "store"))
    return solved(None), solved(Store(folder / "store"))


def test_solutions_out_of_a_store_do_all_that_solved_ones_do(solutions):
    solved, kept = solutions
    assert isinstance(kept, StoredSolutions)
    state = np.random.default_rng(3).standard_normal((solved.loads.shape[1], 2))
    load = solved.loads @ state
    for ask in (
        lambda s: s.displacement,
        lambda s: s.basis,
        lambda s: s.recovery.scatter(s.displacement @ state[:, 0]),
        lambda s: s.unit_resultants,
        lambda s: s.reactions(state),
        lambda s: s.raw_deviation,
        lambda s: s.residual,
        lambda s: s.factor.solver,
        lambda s: s.supports,
        lambda s: s.stiffness.data,
        lambda s: s.solve(load),
        lambda s: s.factor.apply(np.ones(len(s.loads) - len(s.held))),
        lambda s: s.factor.solve(np.ones(len(s.loads) - len(s.held)))[0],
        lambda s: [unit.vectors for unit in s.interfaces],
    ):
        assert digest(ask(kept)) == digest(ask(solved))


def test_the_factor_is_made_when_it_is_first_used_and_once(solutions, tmp_path, calls):
    part = machine(tmp_path, PLATE).parts["rod"]
    Models(Store(tmp_path)).solutions(part.geometry, 0.3, elastic_of(part))
    calls.clear()
    kept = Models(Store(tmp_path)).solutions(part.geometry, 0.3, elastic_of(part))
    assert kept.factor.solver == chosen_solver()
    assert calls.told() == {}
    load = np.zeros((len(kept.loads), 1))
    load[-3:] = 1.0
    kept.solve(load)
    kept.factor.apply(np.ones(len(kept.loads) - len(kept.held)))
    assert calls.told() == {"factorize": 1}


def test_models_without_a_store_solve_as_ever(solutions):
    assert type(solutions[0]) is fem.unit_solutions.UnitSolutions


def test_a_mesh_of_other_wanted_sizes_is_another_mesh(tmp_path, monkeypatch):
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    fields = [SizeField(corners, np.array([[0, 1, 2, 3]]), np.full(4, size)) for size in (1.0, 2.0)]
    made = []

    def mesh_shape(shape, *, fineness, sizes, most_unknowns):
        made.append((fineness, sizes))
        return len(made)

    monkeypatch.setattr(kept_models, "mesh_shape", mesh_shape)
    store = Store(tmp_path / "store")
    wanted = [(1.0, None), (1.0, fields[0]), (1.0, fields[1]), (2.0, None)]
    first = [kept_models.stored_mesh(store, "shape", *each) for each in wanted]
    again = [kept_models.stored_mesh(store, "shape", *each) for each in wanted]
    assert first == again == [1, 2, 3, 4]
