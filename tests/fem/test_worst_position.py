"""The position at which a part buckles first, which is not that of its largest compression."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fem.buckling
from fem.buckling import part_buckling, worst_buckling
from fem.mode_count import elastic_and_geometric_energy, geometric_forms
from fem.recovery import tensor
from fem.solvers import SolverError
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.meshing import mesh_shape
from geometry.parts import PlateLink

STEEL = Elastic(210e3, 0.3, 7.85e-9)
TURN = np.linspace(0.0, 2 * np.pi, 12, endpoint=False)


@pytest.fixture(scope="module")
def plate():
    """A slim crank, 40 x 2 mm: it is bent in its plane and buckles sideways."""
    shape = PlateLink(length=160.0, width=40.0, thickness=2.0, hole=10.0)
    return solve_unit_loads(mesh_shape(shape, fineness=0.25), STEEL)


def states(solutions, axial, sideways):
    """Coefficients of forces (n,) along and across at the second hole, held at the first."""
    length = 160.0
    wrench = np.zeros((2, len(axial), 6))
    wrench[1, :, 0], wrench[1, :, 1] = axial, sideways
    wrench[0, :, :2] = -wrench[1, :, :2]
    wrench[0, :, 5] = -length * np.asarray(sideways)
    names = [unit.interface.name for unit in solutions.interfaces]
    given = dict(zip(names, wrench, strict=True))
    return solutions.coefficients(given, np.zeros((len(axial), 4)))[0]


def lowest(solutions, coefficients):
    """Factor at every position, by itself."""
    found = [part_buckling(solutions, state, tilt_held=False).modes for state in coefficients.T]
    return np.array([modes[0].factor if modes else np.inf for modes in found])


def test_a_bent_plate_buckles_sideways_where_its_compression_is_not_largest(plate):
    coefficients = states(plate, -30 * np.cos(TURN) - 10, 300 * np.sin(TURN))
    each = lowest(plate, coefficients)
    position, found = worst_buckling(plate, coefficients, [0], tilt_held=False)
    assert each.argmin() != 0
    assert_allclose(found.modes[0].factor, each.min(), rtol=1e-6)
    assert each[position] == pytest.approx(each.min(), rel=1e-6)
    assert each.min() < 0.7 * each[0]


def test_a_plate_that_is_pulled_while_it_is_bent_is_asked_too(plate):
    coefficients = states(plate, np.full(4, 5.0), np.array([1.0, -200.0, 300.0, 20.0]))
    position, found = worst_buckling(plate, coefficients, [0], tilt_held=False)
    each = lowest(plate, coefficients)
    assert position == 2
    assert_allclose(found.modes[0].factor, each.min(), rtol=1e-6)


def test_a_plate_that_is_only_pulled_buckles_late_beside_its_holes(plate):
    """Where a hole draws in: 58 times the load that it would buckle at if pushed."""
    coefficients = states(plate, np.array([100.0, 300.0]), np.zeros(2))
    position, found = worst_buckling(plate, coefficients, [0, 1], tilt_held=False)
    assert position == 1
    assert found.modes[0].factor > 20 * found.reversed


def test_a_part_without_load_does_not_buckle(plate):
    coefficients = states(plate, np.zeros(3), np.zeros(3))
    assert worst_buckling(plate, coefficients, [0], tilt_held=False) is None


def test_forms_of_the_unit_loads_add_up_to_that_of_their_sum(plate):
    rng = np.random.default_rng(0)
    fields = rng.normal(size=(len(plate.displacement), 3))
    weights = rng.normal(size=plate.displacement.shape[1])
    stress = plate.recovery.quadrature_stress(plate.displacement, slice(None))
    forms = geometric_forms(plate.elements, stress, fields)
    _, expected = elastic_and_geometric_energy(
        plate.elements, STEEL, tensor(stress @ weights), fields
    )
    assert_allclose(np.tensordot(weights, forms, axes=1), expected, rtol=1e-9)


def test_modes_that_cannot_be_proven_are_told_without_proof_and_stop_nothing(plate, monkeypatch):
    """As of a pulled rod, whose modes lie far beyond its strength."""

    def unprovable(*given, prove=True, **named):
        if prove:
            raise SolverError("1 modes lie below 210000, but only 0 were found")
        return part_buckling(*given, prove=False, **named)

    monkeypatch.setattr(fem.buckling, "part_buckling", unprovable)
    coefficients = states(plate, np.array([-100.0, 20.0]), np.zeros(2))
    position, found = worst_buckling(plate, coefficients, [0, 1], tilt_held=False)
    assert position == 0
    assert found.proven == 0.0
    assert_allclose(found.modes[0].factor, lowest(plate, coefficients)[0], rtol=1e-6)
