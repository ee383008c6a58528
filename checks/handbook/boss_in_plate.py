"""Stress about a round boss with a pin's hole in a plate that is thinner: plane stress, by series.

A ring of one thickness within an infinite plate of another one, fused at the ring's outside. Both
have Kolosov's and Muskhelishvili's potentials (`checks.handbook.pin_loaded_hole`) in whole powers
of z = x + i y, the hole's middle at 0:

    2 G (u + i v) = kappa phi - z conj(phi') - conj(psi)
    sigma_r - i tau = phi' + conj(phi') - z/conj(z) (conj(z) phi'' + psi')   (tau around)

Displacements and forces per length, stress times thickness, are the same on both sides of the
ring's outside; the hole's edge has the pin's pressure, and far away the plate has what it has
without a boss. For each wave around the boss a few powers solve this exactly.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import pi

import numpy as np

from checks.handbook.pin_loaded_hole import ComplexArray, patterns_of
from fem.unit_loads import HARMONICS
from geometry.mesh import FloatArray

FIELDS = ("sigma_x", "rate of sigma_x along y", "tau_xy")  # of the plate without the boss
_BEYOND = 2  # powers more than the highest wave, which is 3 of the fields
_POINTS = 8  # on each circle, for each of these powers


@dataclass(frozen=True, eq=False)
class BossInPlate:
    """Stress per unit of a pin's patterns (8 or more), and of the plate's fields (3): m columns.

    The patterns are those of `fem.unit_loads.bearing_coefficients`, in N and N mm; the fields are
    1 MPa, 1 MPa/mm and 1 MPa.

    phi, psi    potentials' coefficients (2, powers, m): of the ring and of the plate
    """

    poisson_ratio: float
    thicknesses: tuple[float, float]
    patterns: tuple[str, ...]
    phi: ComplexArray
    psi: ComplexArray

    def at(self, points: ComplexArray, *, ring: bool) -> FloatArray:
        """Stress xx, yy, xy (k, 3, m) at points x + i y, of the ring or of the plate."""
        side = 0 if ring else 1
        logs = _logs(self.poisson_ratio, self.thicknesses[side], self.patterns)
        _, first, second = _powers(points, len(self.phi[side]) // 2)
        slope = first @ self.phi[side] + logs[0] / points[:, None]
        bend = second @ self.phi[side] - logs[0] / points[:, None] ** 2
        own = first @ self.psi[side] + logs[1] / points[:, None]
        skew = points.conj()[:, None] * bend + own
        half = 2 * slope.real
        return np.stack([half - skew.real, half + skew.real, skew.imag], axis=1)


@lru_cache(maxsize=64)
def boss_in_plate(
    hole: float,
    boss: float,
    thick: float,
    thin: float,
    poisson_ratio: float,
    harmonics: tuple[int, ...] = HARMONICS,
) -> BossInPlate:
    """Solve a boss of radius `boss` with a hole of radius `hole`, mm.

    thick, thin  mm, of the boss and of the plate about it
    harmonics    of the pin's pressure

    Raises ValueError for a boss that holds no hole.
    """
    if not 0 < hole < boss:
        raise ValueError(f"a boss of radius {boss:g} mm holds no hole of {hole:g} mm")
    patterns, most = patterns_of(harmonics), max(harmonics) + _BEYOND
    count = _POINTS * most
    around = np.exp(2j * pi * (np.arange(count) + 0.5) / count)
    inner, outer = hole * around, boss * around
    kappa = (3 - poisson_ratio) / (1 + poisson_ratio)
    orders = _orders(most)
    powers = len(orders)
    far = orders >= 0  # of the plate: given, but for a motion as a whole
    far_phi, far_psi = _fields(most, len(patterns))
    unknown = 4 * powers
    rows, goals = [], []

    def tractions(points: ComplexArray, unit: complex) -> ComplexArray:
        """sigma_r - i tau (k, 2 powers) of unit coefficients of phi, then of psi."""
        _, first, second = _powers(points, most)
        turn = (points / points.conj())[:, None]
        of_phi = unit * first + np.conj(unit * first)
        of_phi = of_phi - turn * points.conj()[:, None] * unit * second
        return np.concatenate([of_phi, -turn * unit * first], axis=1)

    def moved(points: ComplexArray, unit: complex) -> ComplexArray:
        """2 G (u + i v) (k, 2 powers) of the same."""
        value, first, _ = _powers(points, most)
        of_phi = kappa * unit * value - points[:, None] * np.conj(unit * first)
        return np.concatenate([of_phi, -np.conj(unit * value)], axis=1)

    def of_logs(points: ComplexArray, thickness: float) -> tuple[ComplexArray, ComplexArray]:
        """Tractions and displacements (k, m) of what a force adds."""
        p, q = _logs(poisson_ratio, thickness, patterns)
        z = points[:, None]
        turn, size = z / z.conj(), np.log(np.abs(z))
        pulled = p / z + np.conj(p / z) - turn * (-z.conj() * p / z**2 + q / z)
        return pulled, kappa * p * size - z * np.conj(p / z) - np.conj(q) * size

    pressed = np.zeros((count, len(patterns) + len(FIELDS)), dtype=complex)
    for column, name in enumerate(patterns):
        if name == "couple":
            pressed[:, column] = 1j / (2 * pi * hole**2 * thick)
            continue
        wave, n = name.split()
        size = (np.cos if wave == "cos" else np.sin)(int(n) * np.angle(around))
        pressed[:, column] = -size / (pi * hole * thick)
    units = (1.0, 1j)
    kept = np.concatenate([np.ones(2 * powers, bool), ~np.tile(far, 2)])
    plate = np.concatenate([far_phi, far_psi])  # (2 powers, m)
    logs_in, logs_out = of_logs(outer, thick), of_logs(outer, thin)
    blank = np.zeros((count, 2 * powers))
    edge = [np.concatenate([tractions(inner, u), blank], axis=1) for u in units]
    force = [
        np.concatenate([thick * tractions(outer, u), -thin * tractions(outer, u)], axis=1)
        for u in units
    ]
    motion = [np.concatenate([moved(outer, u), -moved(outer, u)], axis=1) for u in units]
    far_pull = tractions(outer, 1.0) @ plate.real + tractions(outer, 1j) @ plate.imag
    far_motion = moved(outer, 1.0) @ plate.real + moved(outer, 1j) @ plate.imag
    size = 1 / boss  # of displacements against stress
    for table, goal in (
        (edge, pressed - of_logs(inner, thick)[0]),
        (force, thin * (logs_out[0] + far_pull) - thick * logs_in[0]),
        ([size * one for one in motion], size * (logs_out[1] + far_motion - logs_in[1])),
    ):
        both = np.concatenate([one[:, kept] for one in table], axis=1)
        for part in (np.real, np.imag):
            rows.append(part(both))
            goals.append(part(goal))
    matrix, right = np.concatenate(rows), np.concatenate(goals)
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    solved, *_ = np.linalg.lstsq(matrix / scale, right, rcond=1e-12)
    solved /= scale[:, None]
    found = np.zeros((unknown, right.shape[1]), dtype=complex)
    found[kept] = solved[: kept.sum()] + 1j * solved[kept.sum() :]
    found[2 * powers :] += plate
    ring_phi, ring_psi, plate_phi, plate_psi = np.split(found, 4)
    return BossInPlate(
        poisson_ratio,
        (thick, thin),
        patterns,
        np.stack([ring_phi, plate_phi]),
        np.stack([ring_psi, plate_psi]),
    )


def _orders(most: int) -> FloatArray:
    return np.arange(-most, most + 1.0)


def _powers(points: ComplexArray, most: int) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Powers (k, 2 most + 1) of z, and their first and second derivatives."""
    n, z = _orders(most), points[:, None]
    return z**n, n * z ** (n - 1), n * (n - 1) * z ** (n - 2)


def _fields(most: int, patterns: int) -> tuple[ComplexArray, ComplexArray]:
    """Coefficients (powers, m) of phi and psi of the plate's fields."""
    phi, psi = np.zeros((2, len(_orders(most)), patterns + len(FIELDS)), dtype=complex)
    first, second = most + 1, most + 2
    pulled, bent, sheared = range(patterns, patterns + len(FIELDS))
    phi[first, pulled], psi[first, pulled] = 1 / 4, -1 / 2
    phi[second, bent], psi[second, bent] = -1j / 8, 1j / 8
    psi[first, sheared] = 1j
    return phi, psi


def _logs(
    poisson_ratio: float, thickness: float, patterns: tuple[str, ...]
) -> tuple[ComplexArray, ComplexArray]:
    """Coefficients (1, m) of log z in phi and psi: of a force on the hole's edge."""
    kappa = (3 - poisson_ratio) / (1 + poisson_ratio)
    forces: ComplexArray = np.zeros((1, len(patterns) + len(FIELDS)), dtype=complex)
    forces[0, patterns.index("cos 1")], forces[0, patterns.index("sin 1")] = 1.0, 1j
    whole = 2 * pi * (1 + kappa) * thickness
    return np.asarray(-forces / whole), np.asarray(kappa * forces.conj() / whole)
