"""A round bar under pressures around it, by a Fourier series of axisymmetric elements.

Nothing here is shared with the ten-node tetrahedra but the loads: biquadratic elements in the plane
(r, z), displacement u_r, u_z ~ cos n theta, u_theta ~ sin n theta, graded to the edges where a
pressure ends.
"""

from itertools import pairwise

import numpy as np
import scipy.sparse as sp
import skfem
from scipy.sparse.linalg import splu

COARSE, GROWTH = 1 / 6, 1.35  # of the radius; of one element to the next


def graded(places, fine, coarse):
    """Nodes from the first place to the last, `fine` beside each of them."""
    found = []
    for low, high in pairwise(places):
        half, steps, size = (high - low) / 2, [0.0], fine
        while steps[-1] + 1.5 * size < half:
            steps.append(steps[-1] + size)
            size = min(GROWTH * size, coarse)
        ramp = np.array([*steps, half])
        found += [*(low + ramp), *(high - ramp)]
    return np.unique(np.round(found, 12))


class FourierBar:
    """A bar of some radius between two ends, with lugs name -> (lower, upper) in z, mm."""

    def __init__(self, radius, ends, lugs, youngs_modulus, poisson_ratio, fine):
        self.radius, self.lugs = radius, lugs
        places = sorted({*ends, *(z for lug in lugs.values() for z in lug)})
        z = graded(places, fine, COARSE * radius)
        r = np.unique(np.abs(graded([-radius, radius], fine, COARSE * radius)).round(12))
        r[0] = 0.0
        self.mesh = skfem.MeshQuad.init_tensor(r, z)
        element = skfem.ElementVector(skfem.ElementQuad2(), 3)
        self.basis = skfem.Basis(self.mesh, element, intorder=5)
        outside = self.mesh.facets_satisfying(lambda x: np.abs(x[0] - radius) < 1e-9)
        self.edge = skfem.FacetBasis(self.mesh, element, facets=outside, intorder=5)
        self.shear = youngs_modulus / (2 * (1 + poisson_ratio))
        self.lame = 2 * self.shear * poisson_ratio / (1 - 2 * poisson_ratio)
        self._factors = {}

    @staticmethod
    def _strain(values, slopes, r, n):
        (u, v, w), d = values, slopes
        return {
            "rr": d[0, 0],
            "zz": d[2, 1],
            "tt": (u + n * v) / r,
            "rz": d[0, 1] + d[2, 0],
            "rt": d[1, 0] - (v + n * u) / r,
            "zt": d[1, 1] - n * w / r,
        }

    def load(self, lug, n, along):
        """Pressure cos(n theta) inwards on a lug, 1 MPa; `along` it times mm."""
        low, high = self.lugs[lug]

        @skfem.LinearForm
        def form(v, w):
            r, z = w.x
            size = (z - (low + high) / 2) if along else 1.0
            return -r * size * ((z > low) & (z < high)) * v[0]

        return form.assemble(self.edge)

    def solve(self, n, load):
        """Displacement under loads that balance; n > 0."""
        if n not in self._factors:
            self._factors[n] = self._factor(n)
        ties, factor = self._factors[n]
        return ties @ factor.solve(ties.T @ load)

    def _factor(self, n):
        @skfem.BilinearForm
        def form(u, v, w):
            r = w.x[0]
            e, d = (self._strain(each, each.grad, r, n) for each in (u, v))
            volume = (e["rr"] + e["zz"] + e["tt"]) * (d["rr"] + d["zz"] + d["tt"])
            normal = sum(e[k] * d[k] for k in ("rr", "zz", "tt"))
            sliding = sum(e[k] * d[k] for k in ("rz", "rt", "zt"))
            return r * (self.lame * volume + 2 * self.shear * normal + self.shear * sliding)

        stiffness = form.assemble(self.basis)
        x, count = self.basis.doflocs, stiffness.shape[0]
        on_axis = x[0] < 1e-9
        of = [np.zeros(count, dtype=bool) for _ in range(3)]
        for k, name in enumerate(("u^1", "u^2", "u^3")):
            of[k][self.basis.get_dofs(elements=True).all([name])] = True
        ties = sp.identity(count, format="lil")
        fixed = on_axis.copy()
        if n == 1:  # the axis moves across itself; two of its points are held
            u, v = (np.flatnonzero(on_axis & of[k]) for k in (0, 1))
            u, v = u[np.argsort(x[1, u])], v[np.argsort(x[1, v])]
            fixed[u[1:-1]] = False
            for one, other in zip(v, u, strict=True):
                ties[one, one], ties[one, other] = 0.0, -1.0
        ties = ties.tocsc()[:, ~fixed]
        return ties, splu((ties.T @ stiffness @ ties).tocsc())

    def surface_stress(self, n, displacement, z):
        """Amplitudes of the stress at the radius: component -> (len(z),) MPa."""
        places = np.vstack([np.full(len(z), self.radius * (1 - 1e-12)), z])
        cells = self.mesh.element_finder()(*places)
        mapping = self.mesh.mapping()
        local = mapping.invF(places[:, :, None], cells)
        values, slopes = np.zeros((3, len(z))), np.zeros((3, 2, len(z)))
        for k in range(self.basis.Nbfun):
            shape = self.basis.elem.gbasis(mapping, local, k, tind=cells)[0]
            size = displacement[self.basis.element_dofs[k, cells]]
            values += size * np.asarray(shape)[:, :, 0]
            slopes += size * shape.grad[:, :, :, 0]
        e = self._strain(values, slopes, self.radius, n)
        volume = self.lame * (e["rr"] + e["zz"] + e["tt"])
        stress = {k: volume + 2 * self.shear * e[k] for k in ("rr", "tt", "zz")}
        return stress | {k: self.shear * e[k] for k in ("rz", "rt", "zt")}
