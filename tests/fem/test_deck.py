"""Input decks of CalculiX: what stands in them, and that CalculiX finds what ballesta finds."""

import io
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from bench.frd_file import read_dat, read_frd
from fem.deck import set_names, write_deck
from fem.recovery import von_mises
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.meshing import mesh_shape

from .blocks import BAR, block, wrench
from .calculix import needs_calculix, run_calculix
from .stacks import clamped, stack

STEEL = Elastic(210e3, 0.3, 7.85e-9)
HOLD = np.array([0, 1, 2])


def text_of(mesh, hold=HOLD, loads=None, title="block", **options):
    stream = io.StringIO()
    loads = np.zeros(3 * len(mesh.nodes)) if loads is None else loads
    write_deck(stream, mesh, STEEL, hold, loads, title, **options)
    return stream.getvalue()


def rows_after(text, keyword):
    """The data lines of the first block that begins with a keyword."""
    lines = text.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(keyword))
    rows = []
    for line in lines[first + 1 :]:
        if line.startswith("*"):
            return rows
        rows.append(line)
    return rows


@pytest.fixture(scope="module")
def bar(tmp_path_factory):
    """A small lug bar under two bearing forces and inertia, in two load cases, and CalculiX's."""
    solutions = solve_unit_loads(mesh_shape(BAR, fineness=0.6), STEEL)
    wrenches = {
        "knee": np.concatenate([wrench(1e4, 2e3, 5e3), wrench(-4e3, 1e3, 0.0)]),
        "end": np.concatenate([wrench(-1e4, -3e3, 0.0), wrench(5e3, 2e3, -4e3)]),
    }
    accelerations = np.array([[0.0, 0.0, 0.0, 100.0], [1e4, 0.0, 50.0, 10.0]])
    coefficients, _ = solutions.coefficients(wrenches, accelerations)
    deck = tmp_path_factory.mktemp("calculix") / "bar.inp"
    loads = solutions.loads @ coefficients
    write_deck(
        deck, solutions.mesh, STEEL, solutions.held, loads, "lug bar", steps="ab", printed=True
    )
    return solutions, solutions.displacement @ coefficients, loads, deck


@pytest.fixture(scope="module")
def answer(bar):
    return run_calculix(bar[3])


@needs_calculix
@pytest.mark.parametrize("case", [0, 1])
def test_calculix_finds_the_same_displacement(bar, answer, case):
    """Same elements, same rule of four points, same loads: seven digits of the .dat file."""
    solutions, displacement, _, _ = bar
    table = read_dat(answer[1], "displacements")[case]
    assert_allclose(table[:, 0], np.arange(1, len(solutions.mesh.nodes) + 1))
    ours = displacement[:, case].reshape(-1, 3)
    assert_allclose(table[:, 1:], ours, rtol=0, atol=1e-6 * np.abs(ours).max())


@needs_calculix
@pytest.mark.parametrize("case", [0, 1])
def test_calculix_finds_the_same_stress_at_the_integration_points(bar, answer, case):
    """Its four points stand in another order, and zx before yz; seven digits."""
    solutions, displacement, _, _ = bar
    table = read_dat(answer[1], "stresses")[case]
    theirs = table[:, 2:].reshape(-1, 4, 6)[..., [0, 1, 2, 3, 5, 4]]
    recovery = solutions.recovery
    ours = recovery.quadrature_stress(displacement[:, [case]], slice(None))[..., 0]
    assert_allclose(ours[:, [1, 0, 3, 2]], theirs, rtol=0, atol=1e-6 * np.abs(ours).max())


@needs_calculix
def test_the_peaks_of_both_rules_are_within_three_percent_and_at_one_node(bar, answer):
    """CalculiX averages at nodes without weights, ballesta by volume: 0.1 % measured here."""
    solutions, displacement, _, _ = bar
    for case, step in enumerate(read_frd(answer[0])):
        points = solutions.recovery.points
        ours = von_mises(solutions.recovery.surface_stress(displacement[:, case])[..., 0])
        theirs = von_mises(step.fields["STRESS"][points])
        assert_allclose(ours.max(), theirs.max(), rtol=0.03)
        assert ours.argmax() == theirs.argmax()


@needs_calculix
def test_the_supports_of_calculix_carry_nothing(bar, answer):
    """The nodal forces of the .frd file hold loads and reactions: they are the loads alone.

    Within 1e-5 of the pin's force of 1e4 N: the mesh is not quite symmetric about z = 0, so the
    part's inertia leaves a couple of some 1e-6 of it.
    """
    _, _, loads, _ = bar
    for case, step in enumerate(read_frd(answer[0])):
        asked = loads[:, case].reshape(-1, 3)
        found = step.fields["FORC"]
        assert_allclose(found, asked, rtol=0, atol=1e-5 * 1e4)


@needs_calculix
def test_a_constant_strain_is_exact_with_the_order_of_mid_side_nodes_in_the_deck(tmp_path):
    """Tension of a distorted block, nu = 0: u_x = sigma x / E at every node, seven digits.

    A wrong order of mid-side nodes bends the sides, and the strain is no longer constant.
    """
    mesh = block((3, 2, 2), (12.0, 5.0, 4.0), distortion=0.25)
    foam = Elastic(210e3, 0.0, 7.85e-9)
    solutions = solve_unit_loads(mesh, foam)
    wrenches = {"start": wrench(-2100.0), "end": wrench(2100.0)}
    coefficients, _ = solutions.coefficients(wrenches, np.zeros((1, 4)))

    def node(x, y, z):
        return int(np.abs(mesh.nodes - [x, y, z]).sum(axis=1).argmin())

    face = np.flatnonzero(mesh.nodes[:, 0] == 0)
    corner, beside = node(0, 0, 0), node(0, 5, 0)
    hold = np.r_[3 * face, 3 * corner + 1, 3 * corner + 2, 3 * beside + 2]
    deck = tmp_path / "tension.inp"
    write_deck(deck, mesh, foam, hold, solutions.loads @ coefficients, "tension", printed=True)
    (table,) = read_dat(run_calculix(deck)[1], "displacements")
    exact = np.zeros_like(mesh.nodes)
    exact[:, 0] = 2100.0 / 20.0 / 210e3 * mesh.nodes[:, 0]
    assert_allclose(table[:, 1:], exact, rtol=0, atol=1e-6 * exact.max())


@needs_calculix
def test_calculix_ties_a_stack_as_ballesta_does(tmp_path):
    """Three leaves tied along y and bolted at x = 0, bent by clamps: seven digits."""
    mesh = stack(3, (8, 1, 1), (80.0, 2.0, 10.0), start=-40.0)
    for name, place in (("left", -30.0), ("middle", 0.0), ("right", 30.0)):
        mesh = clamped(mesh, name, place, 10.0)
    solutions = solve_unit_loads(mesh, STEEL)
    wrenches = {
        "left": wrench(fy=100.0),
        "middle": wrench(fy=-200.0),
        "right": wrench(fy=100.0),
    }
    coefficients, _ = solutions.coefficients(wrenches, np.zeros((1, 4)))
    deck = tmp_path / "stack.inp"
    loads = solutions.loads @ coefficients
    write_deck(deck, mesh, STEEL, solutions.held, loads, "stack", printed=True)
    (table,) = read_dat(run_calculix(deck)[1], "displacements")
    ours = (solutions.displacement @ coefficients).reshape(-1, 3)
    assert_allclose(table[:, 1:], ours, rtol=0, atol=1e-6 * np.abs(ours).max())


def test_a_held_unknown_of_a_tied_group_stays_and_the_others_follow_it():
    """Two leaves tied along y: whichever node of a pair is held, the equation frees the other."""
    mesh = stack(2, (1, 1, 1), (4.0, 2.0, 3.0), bolted=False)
    low, high = mesh.ties[0].pairs[0]
    for kept, other in ((low, high), (high, low)):
        text = text_of(mesh, hold=np.array([3 * kept + 1]))
        assert f"2\n{other + 1}, 2, 1., {kept + 1}, 2, -1.\n" in text
        assert rows_after(text, "*BOUNDARY") == [f"{kept + 1}, 2, 2"]
    both = text_of(mesh, hold=np.array([3 * low + 1, 3 * high + 1]))
    assert len(rows_after(both, "*BOUNDARY")) == 1
    dependent = [row for row in text.splitlines() if row.endswith("-1.")]
    assert len(dependent) == len(mesh.ties[0].pairs)


def test_a_deck_is_plain_ascii_and_tells_units_and_title():
    text = text_of(block((1, 1, 1), (1.0, 1.0, 1.0)), title="Bielle à œil – ½\nposition 3°")
    assert text.isascii()
    assert max(map(len, text.splitlines())) <= 132
    assert "** Units: mm, N, MPa (N/mm2), t (tonne), s" in text
    assert "** position 3" in text
    assert text.startswith("*HEADING\nBielle a")


def test_nodes_and_elements_are_those_of_the_mesh():
    mesh = block((2, 1, 1), (1.0, 1 / 3, 1.0), start=(-1e3, 0.0, 0.0))
    text = text_of(mesh)
    nodes = np.array([row.split(",") for row in rows_after(text, "*NODE,")], dtype=float)
    assert_allclose(nodes[:, 1:], mesh.nodes, rtol=1e-12)
    elements = np.array([row.split(",") for row in rows_after(text, "*ELEMENT")], dtype=int)
    assert np.array_equal(elements[:, 1:] - 1, mesh.elements)
    assert all(
        len(field.strip()) <= 20 for row in rows_after(text, "*NODE,") for field in row.split(",")
    )


def test_surfaces_become_node_sets_whose_names_differ_without_case():
    mesh = block((1, 1, 1), (1.0, 1.0, 1.0))
    facets = mesh.surfaces["start"]
    extra = {"slot+": facets, "slot-": facets, "Start": facets, "été": facets, "ete": facets}
    mesh = replace(mesh, surfaces={**mesh.surfaces, **extra})
    names = set_names(mesh)
    assert len({name.upper() for name in names.values()}) == len(mesh.surfaces)
    assert names["slot+"] == "S_SLOT_PLUS"
    numbers = ",".join(rows_after(text_of(mesh), f"*NSET, NSET={names['end']}")).split(",")
    nodes = sorted(int(number) - 1 for number in numbers if number.strip())
    assert nodes == sorted(set(mesh.surfaces["end"].ravel()))


def test_every_step_has_its_own_forces_only():
    mesh = block((1, 1, 1), (1.0, 1.0, 1.0))
    loads = np.zeros((3 * len(mesh.nodes), 3))
    loads[4, 0], loads[8, 1] = 1.5, -2.0
    text = text_of(mesh, loads=loads, steps=("first", "second", "none"))
    first, second, third = text.split("*STEP")[1:]
    assert rows_after(first, "*CLOAD") == ["2, 2, 1.500000000000E+00"]
    assert rows_after(second, "*CLOAD, OP=NEW") == ["3, 3, -2.000000000000E+00"]
    assert rows_after(third, "*CLOAD, OP=NEW") == []
    assert "** Load case 2: second" in first  # comments stand before the step


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"loads": np.zeros(5)}, "27 nodes need 81 nodal forces, got 5"),
        ({"loads": np.full(81, np.nan)}, "not finite"),
        ({"hold": np.array([81])}, "from 0 to 80"),
        ({"steps": ("a", "b")}, "1 load cases, but 2 names"),
    ],
)
def test_what_is_no_load_case_is_refused(change, says):
    with pytest.raises(ValueError, match=says):
        text_of(block((1, 1, 1), (1.0, 1.0, 1.0)), **change)


def test_a_file_without_results_is_refused(tmp_path):
    file = tmp_path / "empty.frd"
    file.write_text("    1C\n 9999\n")
    with pytest.raises(ValueError, match="no results"):
        read_frd(file)
