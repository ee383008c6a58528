"""The deformation of a linkage as a list of numbers whose squares add up to its elastic energy.

Of loads in equilibrium every joint, beam and matrix gives rows s = sqrt(C) w, so that the work of
one system of loads on the deformations of another is s . s' (`loads.elasticity.deflection`).
"""

import numpy as np

from loads.bodies import FloatArray, LinkageError
from loads.compliance import BeamCompliance, JointCompliance, MatrixCompliance
from loads.elasticity import LoadState, beam_loads, section_forces, wrenches_on
from loads.forces import ForceSolution
from loads.kinematics import Kinematics
from loads.lumped_masses import Lumps

_GAUSS = 0.5 / np.sqrt(3.0)  # two points integrate the product of two linear moments exactly
_ROUNDING = 1e-6  # of the largest eigenvalue of a compliance: what may be below zero


def joint_strains(
    kinematics: Kinematics, poses: FloatArray, solution: ForceSolution, lumps: Lumps
) -> FloatArray:
    """Return the rows (n, rows) of joints and forces, without loads on the lumps."""
    state = LoadState(solution, None)
    parts = []
    for compliance in kinematics.linkage.compliance:
        match compliance:
            case JointCompliance(joint=joint, stiffness=stiffness):
                parts.append(solution.joints[joint].force / np.sqrt(stiffness))
            case MatrixCompliance():
                parts.append(wrenches_on(kinematics, poses, compliance, state) @ _root(compliance))
            case BeamCompliance():
                places, loads = _on_beam(kinematics, poses, compliance, state, lumps)
                parts.append(_beam_rows(compliance, places, loads))
    return np.concatenate(parts, axis=1)


def lump_strains(
    kinematics: Kinematics, poses: FloatArray, solution: ForceSolution, lumps: Lumps
) -> FloatArray:
    """Return the rows (n, rows, d) of unit loads on the lumps alone, where they enter a beam.

    Of a body with a matrix, inertia is spread as its mass; that is in the matrix already.
    solution  any, for where the loads of beams are
    """
    state = LoadState(solution, None)
    parts = []
    for compliance in kinematics.linkage.compliance:
        match compliance:
            case JointCompliance():
                parts.append(np.zeros((len(poses), 2, len(lumps.way))))
            case MatrixCompliance():
                rows = 3 * compliance.n_places
                parts.append(np.zeros((len(poses), rows, len(lumps.way))))
            case BeamCompliance():
                places, loads = _on_beam(kinematics, poses, compliance, state, lumps)
                own = lumps.of(kinematics.index[compliance.body])
                rows = _n_rows(compliance, places.shape[1])
                part = np.zeros((len(poses), rows, len(lumps.way)))  # other bodies' lumps: none
                for at, d in enumerate(own, start=loads.shape[1] - len(own)):
                    acting = np.zeros_like(loads)
                    acting[:, at, lumps.way[d]] = 1.0
                    if lumps.way[d] == 0:  # a force along x beside the axis
                        acting[:, at, 2] = -lumps.places[d, 1]
                    part[:, :, d] = _beam_rows(compliance, places, acting)
                parts.append(part)
    return np.concatenate(parts, axis=1)


def _root(compliance: MatrixCompliance) -> FloatArray:
    """Return the matrix (m, m) that makes rows of wrenches."""
    matrix = np.asarray(compliance.matrix, dtype=float)
    sizes, vectors = np.linalg.eigh((matrix + matrix.T) / 2.0)
    # lengths and angles differ by orders: a negative value counts against the largest
    if sizes[0] < -_ROUNDING * sizes[-1]:
        raise LinkageError(
            f"body {compliance.body!r}: its compliance gives energy back for some loads (lowest "
            f"eigenvalue {sizes[0]:.3g}, highest {sizes[-1]:.3g}); it cannot vibrate"
        )
    result: FloatArray = vectors * np.sqrt(np.maximum(sizes, 0.0))
    return result


def _on_beam(
    kinematics: Kinematics,
    poses: FloatArray,
    beam: BeamCompliance,
    state: LoadState,
    lumps: Lumps,
) -> tuple[FloatArray, FloatArray]:
    """Return places (n, k) and loads (n, k, 3) on a beam: joints and forces, then its lumps."""
    places, loads = beam_loads(kinematics, poses, beam.body, state)
    own = lumps.of(kinematics.index[beam.body])
    at = np.broadcast_to(lumps.places[own, 0], (len(poses), len(own)))
    none = np.zeros((len(poses), len(own), 3))
    return (
        np.concatenate([places[:, :-1], at], axis=1),  # without the weight at the centre of mass
        np.concatenate([loads[:, :-1], none], axis=1),
    )


def _n_rows(beam: BeamCompliance, n_places: int) -> int:
    """Number of rows of `_beam_rows` for a number of loads."""
    return (n_places - 1) * (2 * (beam.bending is not None) + (beam.axial is not None))


def _beam_rows(beam: BeamCompliance, places: FloatArray, loads: FloatArray) -> FloatArray:
    """Return two rows of bending and one of stretching for every stretch between two loads."""
    order = np.argsort(places, axis=1, kind="stable")
    lengths = np.diff(np.take_along_axis(places, order, axis=1), axis=1)
    normal, start, end = section_forces(loads, order, lengths)
    rows = []
    if beam.bending is not None:
        weight = np.sqrt(lengths / (2.0 * beam.bending))
        middle, rise = (start + end) / 2.0, end - start
        rows += [weight * (middle - _GAUSS * rise), weight * (middle + _GAUSS * rise)]
    if beam.axial is not None:
        rows.append(np.sqrt(lengths / beam.axial) * normal)
    return np.concatenate(rows, axis=1)
