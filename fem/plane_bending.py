"""Bending of a sheet out of its plane: Mindlin plates on six-node triangles.

R. D. Mindlin, J. Appl. Mech. 18 (1951) 31; E. Reissner, J. Appl. Mech. 12 (1945) A69, has the same
shear factor of 5/6. Lines across the sheet stay straight but not normal to it: u_x = z b_x,
u_y = z b_y, and w along z. Curvature and shear strain

    k = (b_x,x  b_y,y  b_x,y + b_y,x),    g = (w,x + b_x,  w,y + b_y)

give the energy 1/2 integral (t^3/12 k' C k + 5/6 G t g' g) dA, C of plane stress. Unlike thin-plate
theory it has three conditions on a free edge, so that the stress beside a hole whose radius is of
the order of the thickness is right: Reissner's own example, from 3 (thick) down to
(5 + 3 nu) / (3 + nu) = 1.79 (thin) times that of the plate in bending.

Three points integrate curvature exactly and shear in a reduced way: elements do not lock while they
are not much larger than the thickness. Unknown 3 n + i of node n: w, b_x, b_y.

A pressure on a bore that grows along its pin as z is, per length of the edge, a couple: it works on
b_x, b_y as the same pressure without z does on u_x, u_y. So unit couples on a bore are the nodal
forces of unit forces in the plane, acting on the rotations: M_y those of F_x, -M_x those of F_y.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from fem.plane import PlaneModel
from fem.solvers import factorize
from geometry.mesh import FloatArray, IntArray

_SHEAR_FACTOR = 5 / 6


@dataclass(frozen=True, eq=False)
class BentSheet:
    """A plane-stress model as a plate in bending.

    Its thickness is the model's at the integration points.
    """

    model: PlaneModel

    @property
    def thickness(self) -> FloatArray:
        """At the integration points, (n_elements, n_q) mm."""
        return self.model.depths

    @cached_property
    def curvatures(self) -> FloatArray:
        """Curvature xx, yy and twice xy of an element's unknowns, (e, q, 3, 18), 1/mm."""
        gradients = self.model.elements.gradients
        rows = np.zeros((*gradients.shape[:2], 3, 6, 3))
        rows[:, :, 0, :, 1] = rows[:, :, 2, :, 2] = gradients[..., 0]
        rows[:, :, 1, :, 2] = rows[:, :, 2, :, 1] = gradients[..., 1]
        return rows.reshape(*gradients.shape[:2], 3, 18)

    @cached_property
    def shears(self) -> FloatArray:
        """Shear strain zx, yz of an element's unknowns, (e, q, 2, 18)."""
        elements = self.model.elements
        rows = np.zeros((*elements.gradients.shape[:2], 2, 6, 3))
        for axis in range(2):
            rows[:, :, axis, :, 0] = elements.gradients[..., axis]
            rows[:, :, axis, :, 1 + axis] = elements.values
        return rows.reshape(*rows.shape[:3], 18)

    @cached_property
    def stiffness(self) -> sp.csr_array:
        """Stiffness matrix, N/mm, N, N mm."""
        plane = self.model.moduli[np.ix_([0, 1, 3], [0, 1, 3])]
        areas = self.model.elements.areas
        bending = areas * self.thickness**3 / 12
        shear = areas * _SHEAR_FACTOR * plane[2, 2] * self.thickness
        blocks = _products(self.curvatures, plane @ self.curvatures, bending)
        blocks += _products(self.shears, self.shears, shear)
        count = len(blocks)
        unknowns = (3 * self.model.mesh.elements[:, :, None] + np.arange(3)).reshape(count, 18)
        rows = np.broadcast_to(unknowns[:, :, None], blocks.shape)
        columns = np.broadcast_to(unknowns[:, None, :], blocks.shape)
        size = 3 * len(self.model.mesh.nodes)
        matrix = sp.coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), (size, size))
        return matrix.tocsr()

    @cached_property
    def rigid_modes(self) -> FloatArray:
        """Motions without strain, (3 n_nodes, 3): along z, about x and about y."""
        nodes = self.model.mesh.nodes - self.model.mesh.nodes.mean(axis=0)
        modes = np.zeros((len(nodes), 3, 3))
        modes[:, 0, 0] = 1.0
        modes[:, 0, 1:] = nodes
        modes[:, 1, 1] = modes[:, 2, 2] = -1.0
        return modes.reshape(-1, 3)

    @cached_property
    def held(self) -> IntArray:
        """Three displacements along z that just stop the sheet from moving."""
        modes = self.rigid_modes[0::3].copy()
        modes[:, 1:] /= np.abs(modes[:, 1:]).max()
        *_, order = scipy.linalg.qr(modes.T, mode="economic", pivoting=True)
        return np.sort(3 * order[:3])

    def couples(self, forces: FloatArray) -> FloatArray:
        """Loads (3 n_nodes, m) of couples, from the nodal forces (2 n_nodes, m) in the plane."""
        loads = np.zeros((len(forces) // 2, 3, forces.shape[1]))
        loads[:, 1:] = forces.reshape(-1, 2, forces.shape[1])
        return loads.reshape(-1, forces.shape[1])

    def solve(self, loads: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Displacement (3 n_nodes, m) of loads, and the reactions (3, m) N of the support."""
        free = np.setdiff1d(np.arange(len(loads)), self.held)
        factor = factorize(sp.triu(self.stiffness[free][:, free], format="csr"))
        moved = np.zeros_like(loads)
        moved[free], _ = factor.solve(loads[free])
        return moved, np.asarray((self.stiffness @ moved - loads)[self.held])

    def face_stress(self, displacement: FloatArray) -> FloatArray:
        """Stress xx, yy, xy at the integration points, (e, q, 3, m) MPa, on the face z = +t/2."""
        columns = displacement.reshape(len(self.model.mesh.nodes), 3, -1)
        nodes = self.model.mesh.elements
        local = columns[nodes].reshape(len(nodes), 1, 18, -1)
        plane = self.model.moduli[np.ix_([0, 1, 3], [0, 1, 3])]
        outer = (self.thickness / 2)[:, :, None, None]
        return np.asarray(outer * np.matmul(plane @ self.curvatures, local))


def _products(left: FloatArray, right: FloatArray, weights: FloatArray) -> FloatArray:
    """Element matrices (e, n, n), sums over the integration points of weight left' right."""
    count, size = len(left), left.shape[-1]
    weighted = (right * weights[:, :, None, None]).reshape(count, -1, size)
    return np.asarray(np.matmul(np.swapaxes(left.reshape(count, -1, size), 1, 2), weighted))
