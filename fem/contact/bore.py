"""Flexibility of a part's bore to a pin: long waves by its elements, short ones as in a sheet.

The part is asked for the harmonics n <= LONG of radial displacement under unit harmonics of
pressure, even along the pin, as far as its elements are a sixth of a wave. Shorter waves do not
feel where the part ends: they give way as the hole of an infinite sheet does, times what the part's
shortest long waves are to a sheet's, between plane strain and plane stress
(docs/theory/contact.md). Elements give the stress of long waves; a shorter one of pressure p makes
-p across the edge of the bore and -p along it, as in a sheet whatever n.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.contact.hats import Hats, sheet_flexibility
from fem.unit_loads import InterfaceLoads, harmonic_vectors
from fem.unit_solutions import UnitSolutions
from geometry.mesh import SYMMETRY, BoolArray, FloatArray, IntArray, Interface, MeshError

LONG = 12  # waves around a bore that the part's own elements answer for, at most
_FEWEST_LONG = 4
_ALONG = 1e-3  # rad: sides that turn by less go along the axis
_PER_WAVE = 6  # quadratic elements, with which a wave gives way by 2 or 3 % too little


@dataclass(frozen=True, eq=False)
class BoreHarmonics:
    """Unit harmonics of pressure in one bore, and how all loads move it.

    The columns are the mean pressure, then cosine and sine of 1 to `last`: 1 N each, spread as
    1/(2 pi R L) and cos(n angle)/(pi R L). Displacements are the harmonics of the same.

    loads         the unit loads of the bore
    vectors       (3 n_nodes, 2 last + 1) N, nodal forces of the harmonics
    displacement  (3 n_nodes, 2 last + 1) mm/N
    flexibility   (2 last + 1, 2 last + 1) mm/N, outward harmonics of displacement
    """

    solutions: UnitSolutions
    loads: InterfaceLoads
    vectors: FloatArray
    displacement: FloatArray
    flexibility: FloatArray

    @property
    def last(self) -> int:
        """Number of the shortest wave."""
        return len(self.flexibility) // 2

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        waves = [f"contact {wave} {n}" for n in range(1, self.last + 1) for wave in ("cos", "sin")]
        return ("contact cos 0", *waves)

    @cached_property
    def stress(self) -> FloatArray:
        """Stress (n_points, 6, 2 last + 1) at the surface nodes, MPa/N."""
        return self.solutions.recovery.surface_stress(self.displacement)

    @cached_property
    def points(self) -> IntArray:
        """Surface points (n,) of the part in the bore, indices of `solutions.recovery.points`."""
        mesh = self.solutions.mesh
        names = self.loads.interface.surfaces
        nodes = np.unique(np.concatenate([mesh.surfaces[name].ravel() for name in names]))
        return np.searchsorted(self.solutions.recovery.points, nodes)

    @cached_property
    def angles(self) -> FloatArray:
        """Angles (n,) of `points` around the bore, rad."""
        nodes = self.solutions.recovery.points[self.points]
        arm = self.solutions.mesh.nodes[nodes] - self.loads.interface.centre
        return np.arctan2(arm[:, 1], arm[:, 0])

    @cached_property
    def sides(self) -> tuple[IntArray, FloatArray]:
        """Neighbours (n, 2) among `points` along the elements' sides, and turns (n,), rad.

        From the first to the second; sides along the axis, which turn nowhere, are left out.
        """
        mesh = self.solutions.mesh
        facets = np.concatenate([mesh.surfaces[name] for name in self.loads.interface.surfaces])
        both = facets[:, [[0, 3], [3, 1], [1, 4], [4, 2], [2, 5], [5, 0]]].reshape(-1, 2)
        nodes = self.solutions.recovery.points[self.points]
        found = np.searchsorted(nodes, np.unique(np.sort(both, axis=1), axis=0))
        turns = np.diff(self.angles[found], axis=1)[:, 0]
        turns = (turns + np.pi) % (2 * np.pi) - np.pi
        around = np.abs(turns) > _ALONG
        return found[around], turns[around]

    def short_waves(self, hats: Hats, forces: FloatArray) -> FloatArray:
        """Pressure (n, m), MPa, of forces (n_hats, m) N at `points`, without its long waves."""
        interface = self.loads.interface
        area = interface.radius * interface.length
        values = self.once("values", hats, lambda: hats.values(self.angles))
        whole = values @ (forces / (hats.extents * area)[:, None])
        return np.asarray(whole - self._unit_pressures @ (self.waves(hats).T @ forces))

    @cached_property
    def _unit_pressures(self) -> FloatArray:
        """Pressures (n, 2 last + 1), MPa/N, of the columns at `points`."""
        return self.unit_pressures(self.angles)

    def unit_pressures(self, angles: FloatArray) -> FloatArray:
        """Pressures (..., 2 last + 1), MPa/N, of the columns at angles (...), rad."""
        interface = self.loads.interface
        turned = np.arange(1, self.last + 1) * angles[..., None]
        both = np.stack([np.cos(turned), np.sin(turned)], axis=-1).reshape(*angles.shape, -1)
        unit = np.concatenate([np.full((*angles.shape, 1), 0.5), both], axis=-1)
        return np.asarray(unit / (np.pi * (interface.radius * interface.length)))

    @cached_property
    def short_wave_stress(self) -> FloatArray:
        """Stress (n, 6) at `points` per pressure of a short wave: xx, yy, zz, xy, yz, zx.

        At the bore's ends nothing holds the material along the axis.
        """
        poisson = self.solutions.material.poisson_ratio
        strain = (1 - self.to_sheet) / poisson**2 if poisson else 0.0  # 1 in plane strain
        found = np.tile([-1.0, -1.0, -2 * poisson * strain, 0.0, 0.0, 0.0], (len(self.points), 1))
        found[self._at_ends, 2] = 0.0
        return found

    @property
    def _at_ends(self) -> BoolArray:
        """True for each of `points` where the bore meets another surface of the part."""
        mesh = self.solutions.mesh
        names = [*self.loads.interface.surfaces, *([SYMMETRY] if mesh.half else [])]
        own = np.concatenate([mesh.surfaces[name] for name in names])
        corners = {tuple(sorted(facet)) for facet in own[:, :3].tolist()}
        other = [tuple(sorted(facet)) not in corners for facet in mesh.facets[:, :3].tolist()]
        nodes = self.solutions.recovery.points[self.points]
        return np.isin(nodes, mesh.facets[other])

    @property
    def share(self) -> float:
        """Share of the part that the mesh is."""
        return self.solutions.mesh.share

    @cached_property
    def _found(self) -> dict[tuple[str, object], FloatArray]:
        return {}

    def once(self, name: str, of: object, work: Callable[[], FloatArray]) -> FloatArray:
        """Result of some work for hats or another bore, done once for every clearance of a pin."""
        if (name, of) not in self._found:
            self._found[name, of] = work()
        return self._found[name, of]

    @cached_property
    def moved_by_loads(self) -> FloatArray:
        """Outward harmonics (2 last + 1, n_basis) mm of the bore by each unit load of the part."""
        return self._moved_by(self.solutions.displacement)

    def moved_by(self, other: "BoreHarmonics") -> FloatArray:
        """Outward harmonics (2 last + 1, m) mm/N of the bore by those of another bore."""
        return self.once("moved", other, lambda: self._moved_by(other.displacement))

    def _moved_by(self, displacement: FloatArray) -> FloatArray:
        return np.asarray(self.vectors.T @ displacement / self.share)

    @cached_property
    def first(self) -> int:
        """First column of the bore's own unit loads among all of the part."""
        before = 0
        for loads in self.solutions.interfaces:
            if loads is self.loads:
                break
            before += len(loads.names)
        return before

    @property
    def pressing(self) -> dict[str, int]:
        """Columns, by name, of the unit loads of the pressure assumed in the bore."""
        waves = ("cos ", "sin ")
        return {
            name: self.first + k
            for k, name in enumerate(self.loads.names)
            if name.startswith(waves)
        }

    @cached_property
    def to_sheet(self) -> float:
        """Flexibility to the shortest long waves over a sheet's in plane stress."""
        last = self.flexibility.diagonal()[-2:].mean()
        material, number = self.solutions.material, float(self.last)
        sheet = (2 * number + 1 - material.poisson_ratio) / (number**2 - 1) / np.pi
        sheet /= material.youngs_modulus * self.loads.interface.length
        return float(np.clip(last / sheet, 1 - material.poisson_ratio**2, 1.0))

    def waves(self, hats: Hats) -> FloatArray:
        """Harmonics (n, 2 last + 1) of unit forces on the hats."""
        return self.once("waves", hats, lambda: self._waves(hats))

    def _waves(self, hats: Hats) -> FloatArray:
        waves = hats.waves(np.arange(1.0, self.last + 1))
        both = np.stack([waves.real, waves.imag], axis=2).reshape(len(waves), -1)
        return np.column_stack([np.ones(len(waves)), both])

    def hat_flexibility(self, hats: Hats) -> FloatArray:
        """Mean outward displacement (n, n) mm/N of each hat per force on each hat."""
        return self.once("flexibility", hats, lambda: self._hat_flexibility(hats))

    def _hat_flexibility(self, hats: Hats) -> FloatArray:
        material, length = self.solutions.material, self.loads.interface.length
        young, poisson = material.youngs_modulus / self.to_sheet, material.poisson_ratio
        waves = self.waves(hats)
        n = np.repeat(np.arange(1.0, self.last + 1), 2)
        with np.errstate(divide="ignore"):
            sheet = np.r_[(1 + poisson) / 2, (2 * n + 1 - poisson) / (n * n - 1)]
        sheet[1:3] = 0.0
        beyond = self.flexibility - np.diag(sheet / (np.pi * young * length))
        whole = sheet_flexibility(hats, length, young, poisson) + waves @ beyond @ waves.T
        return np.asarray((whole + whole.T) / 2)


def bore_harmonics(solutions: UnitSolutions, name: str) -> BoreHarmonics:
    """Solve the unit harmonics of a bore on the factor of the part, once.

    Raises MeshError for an interface that is no bore or whose mesh is too coarse for its waves,
    KeyError for an unknown one.
    """
    if name not in solutions.bore_waves:
        solutions.bore_waves[name] = _solved_harmonics(solutions, name)
    found: BoreHarmonics = solutions.bore_waves[name]
    return found


def _solved_harmonics(solutions: UnitSolutions, name: str) -> BoreHarmonics:
    known = {loads.interface.name: loads for loads in solutions.interfaces}
    loads = known[name]
    interface = loads.interface
    if interface.kind != "bore":
        raise MeshError(
            f"interface {name!r} is a {interface.kind!r}: contact is solved in round bores only"
        )
    vectors = harmonic_vectors(solutions.elements, interface, _resolved(solutions, interface))
    displacement = solutions.solve(vectors)
    flexibility = vectors.T @ displacement / solutions.mesh.share
    uneven = np.abs(flexibility - flexibility.T).max() / np.abs(flexibility).max()
    if uneven > 1e-9:
        raise MeshError(f"the flexibility of bore {name!r} is not reciprocal: {uneven:.1e}")
    return BoreHarmonics(solutions, loads, vectors, displacement, flexibility)


def _resolved(solutions: UnitSolutions, interface: Interface) -> int:
    """Number of the shortest wave that has _PER_WAVE elements."""
    surface = solutions.elements.surface(interface.name)
    side = np.sqrt(4 / np.sqrt(3) * surface.weights.sum() / len(surface.nodes))
    around = 2 * np.pi * interface.radius / side
    return int(np.clip(around / _PER_WAVE, _FEWEST_LONG, LONG))
