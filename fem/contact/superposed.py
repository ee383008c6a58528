"""Unit solutions of a part with the pressure of solved contacts among its unit loads.

A bore's pressure is the sum of its long waves, which are unit loads of the part's elements like any
other, and of short ones, which no element could follow: these have no nodal forces, only the stress
that they make at the bore itself. They are reduced to few patterns (singular values); what patterns
miss of the pressure counts as an error.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
import scipy

from fem.contact.bore import BoreHarmonics
from fem.contact.cycle import ContactCycle
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray

PATTERNS = 48  # of short waves of all bores of a part, at most
LEFT = 1e-4  # of the largest pressure, that patterns may miss
_ROUND_OFF = 1e-9  # of the largest singular value


class ContactSolutions(UnitSolutions):
    """Unit solutions with more columns at some bores: long waves, then patterns of short ones."""

    def __init__(
        self, of: UnitSolutions, harmonics: Sequence[BoreHarmonics], patterns: Sequence[FloatArray]
    ) -> None:
        """Take the fields of the part, and those of its bores.

        harmonics  of the bores that are solved; `of` may be the same mesh with other stiffness
        patterns   for each bore (n_points of the bore, k) MPa, pressures of short waves
        """
        bores = {one.loads.interface.name: k for k, one in enumerate(harmonics)}
        same = [bore.solutions is of for bore in harmonics]
        moved = [
            bore.displacement if one else of.solve(bore.vectors)
            for bore, one in zip(harmonics, same, strict=True)
        ]
        interfaces, basis, first = [], [], 0
        parts: list[slice | tuple[int, int]] = []
        for unit in of.interfaces:
            columns = slice(first, first + len(unit.names))
            first = columns.stop
            basis.append(of.basis[:, :, columns])
            parts.append(columns)
            k = bores.get(unit.interface.name)
            if k is not None:
                bore, own = harmonics[k], patterns[k]
                none = np.zeros((len(of.loads), own.shape[1]))
                local = np.zeros((len(of.basis), 6, own.shape[1]))
                local[bore.points] = bore.short_wave_stress[:, :, None] * own[:, None]
                basis += [bore.stress if same[k] else of.recovery.surface_stress(moved[k]), local]
                names = [f"short wave {m}" for m in range(1, own.shape[1] + 1)]
                unit = replace(
                    unit,
                    names=(*unit.names, *bore.names, *names),
                    vectors=np.concatenate([unit.vectors, bore.vectors, none], axis=1),
                )
                parts.append((k, own.shape[1]))
            interfaces.append(unit)
        rest = slice(first, of.loads.shape[1])
        self.__dict__.update(
            {
                name: getattr(of, name)
                for name in ("elements", "pattern", "material", "held", "factor", "residual",
                             "ties", "softened", "recovery")
            },
            interfaces=tuple(interfaces),
            basis=np.concatenate([*basis, of.basis[:, :, rest]], axis=2),
            _of=of,
            _added=(harmonics, patterns),
            _moved=moved,
            _parts=[*parts, rest],
        )  # fmt: skip

    @cached_property
    def loads(self) -> FloatArray:
        """Unit loads (3 n_nodes, n_basis), N; short waves have none."""
        harmonics, _ = self.__dict__["_added"]
        return self._joined(self.__dict__["_of"].loads, [bore.vectors for bore in harmonics])

    @cached_property
    def displacement(self) -> FloatArray:
        """Displacements (3 n_nodes, n_basis), mm; short waves have none."""
        return self._joined(self.__dict__["_of"].displacement, self.__dict__["_moved"])

    def _joined(self, of: FloatArray, waves: Sequence[FloatArray]) -> FloatArray:
        blocks: list[FloatArray] = []
        for part in self.__dict__["_parts"]:
            if isinstance(part, slice):
                blocks.append(of[:, part])
            else:
                blocks += [waves[part[0]], np.zeros((len(of), part[1]))]
        return np.concatenate(blocks, axis=1)

    def moved(self, coefficients: FloatArray) -> FloatArray:
        """Displacement (3 n_nodes, ...), mm, of coefficients (n_basis, ...)."""
        of, first, own = self.__dict__["_of"].displacement, 0, []
        waves = np.zeros((len(of), *coefficients.shape[1:]))
        for part in self.__dict__["_parts"]:
            if isinstance(part, slice):
                count = part.stop - part.start
                own.append(coefficients[first : first + count])
            else:
                wave = self.__dict__["_moved"][part[0]]
                waves += wave @ coefficients[first : first + wave.shape[1]]
                count = wave.shape[1] + part[1]
            first += count
        return np.asarray(of @ np.concatenate(own) + waves)

    def on(self, of: UnitSolutions) -> "ContactSolutions":
        """The same columns on another stiffness of the same mesh."""
        return ContactSolutions(of, *self.__dict__["_added"])

    @cached_property
    def stiffness(self) -> "scipy.sparse.csr_array":
        """Upper triangle of the whole stiffness matrix, without ties."""
        of: UnitSolutions = self.__dict__["_of"]
        return of.stiffness

    def solve(self, loads: FloatArray) -> FloatArray:
        """Displacement (3 n_nodes, m) of other nodal forces under the same hold."""
        of: UnitSolutions = self.__dict__["_of"]
        return of.solve(loads)

    def state(self, cycle: ContactCycle) -> FloatArray:
        """Coefficients (n_basis, n_positions) of a contact of these bores, short waves left out."""
        harmonics, patterns = self.__dict__["_added"]
        count = cycle.others.shape[1]
        return _coefficients(
            harmonics, cycle, [np.zeros((one.shape[1], count)) for one in patterns]
        )


def superposed(
    harmonics: Sequence[BoreHarmonics], cycle: ContactCycle, patterns: int = PATTERNS
) -> tuple[ContactSolutions, FloatArray, list[FloatArray]]:
    """Superpose the contact of a part over a cycle.

    patterns  of short waves of all bores, at most; forces that turn all around need many of them

    Returns the unit loads, the coefficients (n_basis, n_positions), and for each bore the pressure
    of short waves that patterns miss (n_points of the bore, n_positions), MPa.
    """
    own: list[FloatArray] = []
    amounts: list[FloatArray] = []
    missed: list[FloatArray] = []
    for bore in harmonics:
        found = cycle.bores[bore.loads.interface.name]
        # forces of few hats are the sum of fewer shapes than there are positions
        shapes, sizes, share = np.linalg.svd(found.forces, full_matrices=False)
        count = int(np.count_nonzero(sizes > _ROUND_OFF * sizes[0]))
        kept, amount, left = _reduced(
            bore.short_waves(found.hats, shapes[:, :count] * sizes[:count]),
            share[:count],
            LEFT * float(found.pressures.max(initial=0.0)),
            patterns // len(harmonics),
        )
        own.append(kept)
        amounts.append(amount)
        missed.append(left)
    solutions = ContactSolutions(harmonics[0].solutions, harmonics, own)
    return solutions, _coefficients(harmonics, cycle, amounts), missed


def _coefficients(
    harmonics: Sequence[BoreHarmonics], cycle: ContactCycle, amounts: Sequence[FloatArray]
) -> FloatArray:
    """Coefficients (n_basis, n_positions), of the patterns of each bore by their amounts."""
    bores = {one.loads.interface.name: k for k, one in enumerate(harmonics)}
    rows, first = [], 0
    for unit in harmonics[0].solutions.interfaces:
        name = unit.interface.name
        rows.append(cycle.others[first : first + len(unit.names)])
        first += len(unit.names)
        if name in bores:
            pressed = cycle.bores[name]
            waves = harmonics[bores[name]].waves(pressed.hats)
            rows += [waves.T @ pressed.forces, amounts[bores[name]]]
    return np.concatenate([*rows, cycle.others[first:]])


def _reduced(
    pressures: FloatArray, share: FloatArray, enough: float, most: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Patterns (n, k), their amounts (k, m), and the pressure (n, m) that they miss.

    pressures  (n, r), of which each position has its share (r, m)
    """
    shapes, sizes, parts = np.linalg.svd(pressures, full_matrices=False)
    amounts = sizes[:, None] * parts @ share
    missed = pressures @ share
    kept = 0
    while True:
        left = float(np.abs(missed).max(initial=0.0))
        if left <= enough or kept == min(most, len(sizes)):
            return shapes[:, :kept], amounts[:kept], missed
        missed -= np.outer(shapes[:, kept], amounts[kept])
        kept += 1
