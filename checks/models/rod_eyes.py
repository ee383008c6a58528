"""Stress at the eyes of round rods, by solids of eyes of many proportions.

An eye is solved as half a rod under every pattern of a pin's pressure (`bench.rod_eyes`), the shank
in balance. Made free of size, the stress at places in the bore, along the fillet and inside the
tube's bore is

    sigma = s v,   v = v_0 + sum_k a_k(q) w_k

with the main modes w_k of all solids' v (singular value decomposition) and factors a_k that are
smooth functions of five proportions q, which meet those of the solids but for their numerical
scatter: sums of Gaussians about the solids' q and a linear part, whose lengths are those of the
largest likelihood (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, sections
2.2, 2.7 and 5.4). The scales s carry what is known: the bore's stress goes with the
ligament L behind the hole, the fillet's with the stepped shaft's factor.

Proportions beyond those of the solids count as the nearest of these (docs/theory/rungs.md).
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from math import log, pi, sqrt
from typing import Any

import numpy as np

from checks.handbook.lug_stress import stepped_shaft
from checks.handbook.pin_loaded_hole import PATTERNS
from geometry.mesh import FloatArray
from geometry.parts import TubeRod

FULLEST = 0.97  # largest `fullness` of the solids
BORE, FILLET, INSIDE = "bore", "fillet", "inside"
ANGLES = np.radians(np.arange(0.0, 181.0, 15.0))  # in the bore, from the shank on
HEIGHTS = np.array([0.0, 0.55, 0.98])  # in the bore, of half the eye's width
ARC = np.array([0.0, 0.15, 0.3, 0.45, 0.6, 0.8])  # of the fillet's arc, from the shank on
WITHIN = np.array([0.22, 0.07])  # rad of the hemisphere, from the cylinder on
AROUND = np.radians([0.0, 45.0, 90.0])  # about the rod's axis, from +y towards +z
ROWS = {BORE: len(HEIGHTS), FILLET: len(ARC), INSIDE: len(WITHIN)}
ALONG = {BORE: len(ANGLES), FILLET: len(AROUND), INSIDE: len(AROUND)}
PARITY = np.array([-1.0 if name[:3] in ("sin", "cou") else 1.0 for name in PATTERNS])  # about y = 0
_COS, _SIN, _COUPLE = (PATTERNS.index(name) for name in ("cos 1", "sin 1", "couple"))


@dataclass(frozen=True, eq=False)
class Fitted:
    """Fit of v of some patterns at the places of one kind.

    middle, spread  (5,) of the solids' proportions
    lengths         (5,) of the Gaussians, over the spread
    slope           weight of the linear part
    solids          (n, 5) proportions less their middle, over the spread
    weights         (n, k) of the solids in each mode's factor
    mean, modes     (m,) and (k, m) v: rows, places along them, two components, patterns
    """

    place: str
    patterns: Sequence[int]
    middle: FloatArray
    spread: FloatArray
    lengths: FloatArray
    slope: float
    solids: FloatArray
    weights: FloatArray
    mean: FloatArray
    modes: FloatArray

    def at(self, proportions: FloatArray) -> FloatArray:
        """Return v (rows, along, 2, patterns) at proportions (5,)."""
        near = (proportions - self.middle) / self.spread
        near = np.clip(near, self.solids.min(axis=0), self.solids.max(axis=0))
        factors = kernel(near[None], self.solids, self.lengths, self.slope)[0] @ self.weights
        found = self.mean + factors @ self.modes
        return np.asarray(found.reshape(ROWS[self.place], ALONG[self.place], 2, -1))


def kernel(first: FloatArray, second: FloatArray, lengths: FloatArray, slope: float) -> FloatArray:
    """Covariance (n, m) of the factors at proportions (n, 5) and (m, 5): Gaussian and linear."""
    away = ((first[:, None] - second) / lengths) ** 2
    return np.asarray(np.exp(-away.sum(axis=2) / 2) + slope * (1 + first @ second.T))


def fullness(rod: TubeRod) -> float:
    """Eye's width over the width at which its flats end at the hole's edge."""
    return rod.eye_width / sqrt(rod.eye_diameter**2 - rod.hole**2)


def proportions(rod: TubeRod, place: str) -> FloatArray:
    """Proportions (5,) in which the fit of a kind of place is smooth, as logarithms."""
    eye, tube = rod.eye_diameter, rod.tube_diameter
    wall = (tube - rod.bore) / 2
    across = rod.sections[0].area / rod.ligament if place == FILLET else wall / tube
    numbers = (1 - rod.hole / eye, fullness(rod), tube / eye, across, rod.fillet / tube)
    return np.array([log(number) for number in numbers])


def section_place(rod: TubeRod, place: str) -> float:
    """Distance of the section whose forces a fillet or a bore's end has, from the pin, mm."""
    return rod.shank_end if place == FILLET else (rod.eye_diameter + rod.bore) / 2


def scales(rod: TubeRod, place: str) -> FloatArray:
    """Stress (8,) that v = 1 stands for, MPa per N and N mm of the patterns."""
    ligament, area = rod.ligament, rod.sections[0].area
    found = np.full(len(PATTERNS), 1 / ligament)
    if place == BORE:
        found[_COUPLE] = 2 / (ligament * rod.hole)
        return found
    pulled, bent, full = 1.0, 1.0, area
    if place == FILLET:
        sizes = (rod.eye_diameter, rod.tube_diameter, rod.fillet)
        pulled, bent = (stepped_shaft(kind, *sizes) for kind in ("tension", "bending"))
        full = pi / 4 * rod.tube_diameter**2
    modulus = rod.sections[0].inertia_in_plane / (rod.tube_diameter / 2)
    found *= sqrt(pulled)
    found[_COS] = pulled / sqrt(area * full)
    found[_SIN] = bent * section_place(rod, place) / modulus
    found[_COUPLE] = bent / modulus
    return found


def eye_stress(rod: TubeRod, place: str) -> FloatArray:
    """Stress (rows, along, 2, 8), MPa per N and N mm of the patterns, at y >= 0 and z >= 0.

    In the bore the hoop stress and the stress along z, at `HEIGHTS` and `ANGLES`; else along the
    meridian and around the rod's axis, at `ARC` or `WITHIN` and `AROUND`.
    """
    found = np.zeros((ROWS[place], ALONG[place], 2, len(PATTERNS)))
    for fitted in _fits():
        if fitted.place == place:
            found[..., list(fitted.patterns)] = fitted.at(proportions(rod, place))
    return np.asarray(found * scales(rod, place))


def pressed(rod: TubeRod, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Radial and shear stress (k, 8) in a bore, of the patterns themselves, MPa per N and N mm."""
    radius, width = rod.hole / 2, rod.eye_width
    radial, shear = np.zeros((2, len(angles), len(PATTERNS)))
    for k, name in enumerate(PATTERNS[:_COUPLE]):
        wave, number = name.split()
        size = (np.cos if wave == "cos" else np.sin)(int(number) * angles)
        radial[:, k] = -size / (np.pi * radius * width)
    shear[:, _COUPLE] = -1 / (2 * np.pi * radius**2 * width)
    return radial, shear


@cache
def _fits() -> Sequence[Fitted]:
    text = files("checks.models").joinpath("rod_eyes.json").read_text(encoding="utf-8")
    return [_fit_of(entry) for entry in json.loads(text)["fits"]]


def _fit_of(entry: Mapping[str, Any]) -> Fitted:
    names = ("middle", "spread", "lengths", "solids", "weights", "mean", "modes")
    arrays = {name: np.array(entry[name]) for name in names}
    return Fitted(entry["place"], entry["patterns"], slope=entry["slope"], **arrays)
