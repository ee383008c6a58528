"""Solids of eyes of round rods, and the fit of their stress that the formula of `tube_rod` has.

python -m bench.rod_eyes [--count N]   resumes; writes bench/rungs/rod_eyes.jsonl
python -m bench.rod_eyes --fit         writes checks/models/rod_eyes.json, says what it misses

An eye of 100 mm and its shank, cut where the eye is no longer felt, are solved as half a part at
z >= 0. The cut takes the force and couple of each pattern as a bar's end does. Proportions are
drawn by Sobol's sequence; three of ten shanks are solid. A line of JSON holds an eye's proportions,
its v at the places of `checks.models.shapes.tube_rod` and its largest von Mises stress.
"""

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import exp, log, sqrt
from pathlib import Path
from time import process_time
from typing import Any, ClassVar

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import cKDTree
from scipy.stats import qmc

from checks.handbook.pin_loaded_hole import PATTERNS
from checks.models.shapes.tube_rod import (
    ALONG,
    ANGLES,
    ARC,
    AROUND,
    BORE,
    FILLET,
    FULLEST,
    HEIGHTS,
    INSIDE,
    PARITY,
    ROWS,
    WITHIN,
    kernel,
    pressed,
    proportions,
    scales,
)
from fem.recovery import tensor, von_mises
from fem.solvers import SolverError
from fem.threads import one_thread
from fem.unit_loads import bearing_coefficients
from fem.unit_solutions import Elastic, solve_unit_loads
from geometry.mesh import BoolArray, FloatArray, Interface, MeshError
from geometry.meshing import mesh_shape
from geometry.parameters import ParameterError
from geometry.parts import TubeRod
from geometry.parts._plates import bore_at
from geometry.shape import Body, Half, Region, faces_where

FILE = Path(__file__).parent / "rungs" / "rod_eyes.jsonl"
FIT = Path(__file__).parents[1] / "checks/models/rod_eyes.json"
EYE = 100.0  # mm
SEED = 20261127
STEEL = Elastic(210e3, 0.3, 7.85e-9)
HELD_OUT = 25  # every such solid is left out of the fit, for the tests
FORCES = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # pull, push, across
FINENESS = 1.2
_SHANK = 2.0  # tube diameters from the fillet or the bore's hemisphere to the cut
_SOLID = 0.3  # of the shanks
_LOW = np.array([0.22, 0.4, 0.2, 0.06, 0.1])  # hole, width and tube / eye, wall and fillet / tube
_HIGH = np.array([0.78, 0.96, 0.78, 0.42, 1.1])
_SLIMMEST = 0.98  # of the tube over the width
_NEIGHBOURS = 8  # surface points whose stress makes that of a place
_MODES = 8
_TUNED = 5  # modes whose likelihood the lengths are of
_EVEN, _ODD = [0, 1, 3, 5], [2, 4, 6, 7]
_BLOCKS = [(BORE, _EVEN), (BORE, _ODD)] + [
    (place, some) for place in (FILLET, INSIDE) for some in ([1], [0, 3, 5], [2, 7], [4, 6])
]


@dataclass(frozen=True)
class RodEye:
    """The half at x < length / 2 of a rod: its first eye, and its shank cut across."""

    rod: TubeRod

    middle_plane: ClassVar[bool] = True

    @property
    def length(self) -> float:
        """Distance from the pin's axis to the cut, mm."""
        return self.rod.length / 2

    def build(self, gmsh: Any) -> Body:
        """Build the rod in gmsh's current model and cut it."""
        self.rod.build(gmsh)
        occ, far = gmsh.model.occ, 2 * self.rod.length
        box = occ.addBox(-far, -far, -far, far + self.length, 2 * far, 2 * far)
        occ.intersect(gmsh.model.getEntities(3), [(3, box)])
        occ.synchronize()
        return self.named(gmsh)

    def named(self, gmsh: Any) -> Body:
        """Return the body of the model, of the whole eye or its half at z >= 0."""
        rod, end, tube = self.rod, self.length, self.rod.tube_diameter
        bore = bore_at(gmsh, 0.0, rod.hole)
        fillet = faces_where(gmsh, lambda _, kind: kind == "Torus")
        cut = faces_where(
            gmsh, lambda box, kind: kind == "Plane" and bool(abs(box[0] - end) < 1e-5 * end)
        )
        inside = faces_where(
            gmsh, lambda box, kind: kind == "Sphere" and bool(box[0] > 0.49 * rod.eye_diameter)
        )
        sizes = [
            (bore, rod.hole / 16, rod.hole / 2),
            (fillet, min(rod.fillet / 2.4, tube / 8), tube / 2),
            (cut, tube / 9, tube),
            (inside, min(rod.bore / 7, 0.75 * (tube - rod.bore)), tube / 2),
        ]
        return Body(
            surfaces={"first": bore, "cut": cut},
            interfaces=[
                Interface("first", "bore", np.zeros(3), rod.hole / 2, rod.eye_width),
                Interface("cut", "face", np.array([end, 0.0, 0.0])),
            ],
            size=tube / (3 if rod.bore else 2.5),
            regions=[
                Region([(2, tag) for tag in faces], size, reach)
                for faces, size, reach in sizes
                if faces
            ],
        )


def rod_of(numbers: Sequence[float] | FloatArray) -> TubeRod:
    """Rod of hole, width and tube over the eye, wall and fillet over the tube; wall 0.5: solid."""
    hole, width, tube, wall, fillet = (float(number) for number in numbers)
    size = tube * EYE

    def rod(length: float) -> TubeRod:
        return TubeRod(
            length=length,
            tube_diameter=size,
            wall=None if wall >= 0.5 else wall * size,
            eye_diameter=EYE,
            eye_width=width * EYE,
            hole=hole * EYE,
            fillet=fillet * size,
        )

    long = rod(1000 * EYE)
    return rod(2 * (max(long.shank_end, (EYE + long.bore) / 2) + _SHANK * size))


def drawn(count: int) -> Iterator[tuple[int, FloatArray]]:
    """Number and proportions of the first draws that the shape takes."""
    sobol, made, number = qmc.Sobol(6, seed=SEED), 0, 0
    while made < count:
        *shares, kind = sobol.random()[0]
        number += 1
        numbers = _LOW + np.array(shares) * (_HIGH - _LOW)
        numbers[3:] = _LOW[3:] * (_HIGH[3:] / _LOW[3:]) ** np.array(shares[3:])
        if kind < _SOLID:
            numbers[3] = 0.5
        hole, width, tube = numbers[:3]
        if width > FULLEST * sqrt(1 - hole**2) or tube > _SLIMMEST * width:
            continue
        try:
            rod_of(numbers)
        except ParameterError:
            continue
        made += 1
        yield number, numbers


def solved(rod: TubeRod, fineness: float = FINENESS) -> tuple[FloatArray, FloatArray, int]:
    """Points (n, 3), stress (n, 6, 8) of the patterns, MPa per N and N mm, number of unknowns.

    Raises MeshError and SolverError.
    """
    eye = RodEye(rod)
    mesh = mesh_shape(Half(eye), fineness=fineness)
    solutions = solve_unit_loads(mesh, STEEL)
    count = len(PATTERNS)
    stress = solutions.basis[:, :, :count].copy()
    along, across, turned = np.moveaxis(solutions.basis[:, :, count : count + 3], 2, 0)
    stress[:, :, PATTERNS.index("cos 1")] -= along
    stress[:, :, PATTERNS.index("sin 1")] += eye.length * turned - across
    stress[:, :, PATTERNS.index("couple")] -= turned
    return mesh.nodes[solutions.recovery.points], stress, 3 * len(mesh.nodes)


def places_of(rod: TubeRod, points: FloatArray, stress: FloatArray) -> dict[str, FloatArray]:
    """Stress (rows, along, 2, 8) at the places of `checks.models.shapes.tube_rod`, by kind.

    points, stress  as `solved` gives them
    """
    on = surfaces(rod, points)
    x, y, z = points.T
    none = np.zeros_like(x)
    angle, round_x = np.arctan2(y, x), np.arctan2(z, y)
    hoop = np.stack([-np.sin(angle), np.cos(angle), none], axis=1)
    aside = np.stack([none, none, none + 1], axis=1)
    outward = np.stack([none, np.cos(round_x), np.sin(round_x)], axis=1)
    around = np.stack([none, -np.sin(round_x), np.cos(round_x)], axis=1)
    radius, half, tube = rod.hole / 2, rod.eye_width / 2, rod.tube_diameter / 2
    values = _along(stress, on[BORE], hoop, aside)
    at = np.column_stack([angle, z])[on[BORE]] * [radius, 1.0]
    pool = _with_images(at, values, [(0, 0.0, PARITY), (0, np.pi * radius, PARITY), (1, 0.0, None)])
    found = {BORE: _interpolated(*pool, HEIGHTS * half, ANGLES * radius, swapped=True)}
    images = [(1, np.pi / 2 * tube, PARITY), (1, 0.0, None)]
    arcs = [(FILLET, *_on_fillet(rod, x), ARC), (INSIDE, *_in_bore(rod, x), WITHIN)]
    for place, arc, slope, scale, rows in arcs:
        if not on[place].any():
            continue
        meridian = np.cos(slope)[:, None] * [1.0, 0.0, 0.0] - np.sin(slope)[:, None] * outward
        values = _along(stress, on[place], meridian, around)
        at = np.column_stack([arc * scale, round_x * tube])[on[place]]
        pool = _with_images(at, values, images)
        found[place] = _interpolated(*pool, rows * scale, AROUND * tube)
    return found


def surfaces(rod: TubeRod, points: FloatArray) -> dict[str, BoolArray]:
    """Which points (n,) are in the bore, on the fillet or beside it, in the tube's bore's end."""
    x, y, z = points.T
    tube, fillet, near = rod.tube_diameter / 2, rod.fillet, 1e-3 * EYE
    off = np.hypot(y, z)
    arc = np.abs(np.hypot(x - rod.shank_end, off - tube - fillet) - fillet) < near
    arc &= (x > rod.joint - 1e-8 * EYE) & (x < rod.shank_end + 1e-8 * EYE)
    beside = (np.abs(off - tube) < near) & (x > rod.shank_end) & (x < rod.shank_end + 0.3 * tube)
    inside = (off < rod.bore / 2 + near) & (x > EYE / 2 - near)
    inside &= np.abs(x - (EYE + rod.bore) / 2) < rod.bore / 2
    return {
        BORE: np.abs(np.hypot(x, y) - rod.hole / 2) < 1e-3 * rod.hole,
        FILLET: arc | beside,
        INSIDE: inside & bool(rod.bore),
    }


def _on_fillet(rod: TubeRod, x: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Share of the fillet's arc (n,), slope of its meridian, length of the arc, mm."""
    whole = np.arcsin((rod.shank_end - rod.joint) / rod.fillet)
    length = float(rod.fillet * whole)
    slope = np.arcsin(np.clip((rod.shank_end - x) / rod.fillet, 0.0, 1.0))
    return np.where(slope > 0, slope / whole, (rod.shank_end - x) / length), slope, length


def _in_bore(rod: TubeRod, x: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Angle of the hemisphere from the cylinder on (n,), rad, slope and radius, mm."""
    radius = rod.bore / 2 or 1.0
    arc = (EYE / 2 + radius - x) / radius
    angle = np.arcsin(np.clip(arc, 0.0, 1.0))
    return np.where(arc > 0, angle, arc), -angle, radius


def _along(stress: FloatArray, chosen: BoolArray, *vectors: FloatArray) -> FloatArray:
    """Direct stress (k, 2, 8) of the chosen points along two unit vectors (n, 3) at each point."""
    full = tensor(np.moveaxis(stress[chosen], 1, 2))
    return np.stack([np.einsum("ni,npij,nj->np", v[chosen], full, v[chosen]) for v in vectors], 1)


_Images = Sequence[tuple[int, float, FloatArray | None]]


def _with_images(
    at: FloatArray, values: FloatArray, mirrors: _Images
) -> tuple[FloatArray, FloatArray]:
    """Points with their images at mirrors: coordinate, where, sign of each pattern's image."""
    for axis, where, sign in mirrors:
        image = at.copy()
        image[:, axis] = 2 * where - image[:, axis]
        at = np.concatenate([at, image])
        values = np.concatenate([values, values if sign is None else values * sign])
    return at, values


def _interpolated(
    at: FloatArray,
    values: FloatArray,
    rows: FloatArray,
    along: FloatArray,
    *,
    swapped: bool = False,
) -> FloatArray:
    """Values (rows, along, 2, 8) by planes through the neighbours, the nearer the heavier.

    swapped  True if the rows go along the second coordinate
    """
    tree, found = cKDTree(at), []
    for row in rows:
        for other in along:
            wanted = np.array([other, row] if swapped else [row, other])
            away, near = tree.query(wanted, k=_NEIGHBOURS)
            weights = (1 / (away + 0.3 * away.max()))[:, None]
            design = np.column_stack([np.ones(len(near)), at[near] - wanted])
            some = values[near].reshape(len(near), -1)
            plane, *_ = np.linalg.lstsq(design * weights, some * weights, rcond=None)
            found.append(plane[0])
    return np.array(found).reshape(len(rows), len(along), *values.shape[1:])


def line_of(number: int, numbers: FloatArray) -> dict[str, Any]:
    """Solve one eye; what the file holds of it. Raises MeshError and SolverError."""
    rod = rod_of(numbers)
    points, stress, unknowns = solved(rod)
    return {
        "number": number,
        "proportions": [round(float(one), 6) for one in numbers],
        "unknowns": unknowns,
        "peaks": peaks_of(rod, points, stress),
        **{
            place: [round(float(one), 3) for one in (values / scales(rod, place)).ravel()]
            for place, values in places_of(rod, points, stress).items()
        },
    }


def peaks_of(rod: TubeRod, points: FloatArray, stress: FloatArray) -> list[float]:
    """Largest von Mises stress under 1 N pulled, pushed and across, off the shank, MPa."""
    under = bearing_coefficients(FORCES, inward=False)
    mises = von_mises(np.moveaxis(stress @ under.T, 1, 2))
    here = np.any(list(surfaces(rod, points).values()), axis=0)
    return [float(f"{one:.5g}") for one in mises[here].max(axis=0)]


def known() -> dict[int, dict[str, Any]]:
    """The lines of the file, by number."""
    if not FILE.exists():
        return {}
    lines = (json.loads(line) for line in FILE.read_text().splitlines())
    return {line["number"]: line for line in lines}


Table = Mapping[str, FloatArray]  # v (n, rows, along, 2, 8) of n eyes, by kind of place


def fit(lines: Sequence[Mapping[str, Any]]) -> tuple[list[dict[str, Any]], Table]:
    """Fit every kind of place and group of patterns; and v of each eye by the other eyes."""
    entries = []
    others = {
        place: np.full((len(lines), rows, ALONG[place], 2, len(PATTERNS)), np.nan)
        for place, rows in ROWS.items()
    }
    for place, some in _BLOCKS:
        here = [k for k, line in enumerate(lines) if place in line]
        entry, found = _fitted([lines[k] for k in here], place, some)
        entries.append(entry)
        others[place][np.ix_(here, *map(range, others[place].shape[1:4]), some)] = found
    return entries, others


def missed(lines: Sequence[Mapping[str, Any]], others: Table) -> FloatArray:
    """Largest von Mises stress over the solid's (n, 3): pulled, pushed and across."""
    under = bearing_coefficients(np.concatenate([FORCES, -FORCES[2:]]), inward=False)
    found = []
    for k, line in enumerate(lines):
        rod, peaks = rod_of(line["proportions"]), []
        for place, values in others.items():
            if place not in line:
                continue
            first, second = np.moveaxis((values[k] * scales(rod, place)) @ under.T, 2, 0)
            third = pressed(rod, ANGLES)[0] @ under.T if place == BORE else np.zeros(4)
            squares = (first - second) ** 2 + (second - third) ** 2 + (third - first) ** 2
            peaks.append(np.sqrt(squares / 2).max(axis=(0, 1)))
        pulled, pushed, up, down = np.max(peaks, axis=0)
        found.append(np.array([pulled, pushed, max(up, down)]) / line["peaks"])
    return np.array(found)


def _fitted(
    lines: Sequence[Mapping[str, Any]], place: str, some: Sequence[int]
) -> tuple[dict[str, Any], FloatArray]:
    """Entry of the fit, and v (n, rows, along, 2, patterns) of each eye by the others."""
    table = np.array([line[place] for line in lines])
    table = table.reshape(len(lines), -1, len(PATTERNS))[:, :, list(some)].reshape(len(lines), -1)
    asked = np.array([proportions(rod_of(line["proportions"]), place) for line in lines])
    middle, spread = asked.mean(axis=0), asked.std(axis=0)
    solids, mean = (asked - middle) / spread, table.mean(axis=0)
    left, sizes, modes = np.linalg.svd(table - mean, full_matrices=False)
    factors = (left * sizes)[:, :_MODES]
    count = len(lines)

    def covariance(settings: FloatArray) -> FloatArray:
        own = kernel(solids, solids, np.exp(settings[:5]), exp(settings[6]))
        return np.asarray(own + exp(settings[5]) * np.eye(count))

    def unlikely(settings: FloatArray) -> float:
        own = covariance(settings)
        _, determinant = np.linalg.slogdet(own)
        held = (factors * np.linalg.solve(own, factors)).sum(axis=0) / count
        return float((count * np.log(held) + determinant)[:_TUNED].sum())

    bounds = [(log(0.5), log(15.0))] * 5 + [(log(1e-6), log(0.1)), (-5.0, 7.0)]
    start = np.array([log(2.5)] * 5 + [log(1e-4), 0.0])
    options = {"maxfev": 500, "xtol": 0.05, "ftol": 1e-3}
    best = minimize(unlikely, start, method="Powell", bounds=bounds, options=options).x
    inverse = np.linalg.inv(covariance(best))
    weights = inverse @ factors
    # of each eye by the others: Rasmussen and Williams, equation 5.12
    left_out = mean + (factors - weights / np.diag(inverse)[:, None]) @ modes[:_MODES]
    entry = {
        "place": place,
        "patterns": list(some),
        "middle": _short(middle, 6),
        "spread": _short(spread, 6),
        "lengths": _short(np.exp(best[:5]), 4),
        "slope": float(f"{exp(best[6]):.4g}"),
        "solids": _short(solids, 5),
        "weights": _short(weights, 5),
        "mean": _short(mean, 4),
        "modes": _short(modes[:_MODES], 4),
    }
    return entry, left_out.reshape(count, ROWS[place], ALONG[place], 2, len(some))


def _short(values: FloatArray, digits: int) -> Any:
    if values.ndim > 1:
        return [_short(row, digits) for row in values]
    return [float(f"{one:.{digits}g}") for one in values]


@one_thread()
def main() -> None:
    """Add what is missing, or fit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=150)
    parser.add_argument("--fit", action="store_true")
    options = parser.parse_args()
    if options.fit:
        lines = [line for line in known().values() if line["number"] % HELD_OUT]
        entries, others = fit(lines)
        data = {"command": "python -m bench.rod_eyes --fit", "fits": entries}
        FIT.write_text(json.dumps(data, separators=(",", ":")) + "\n")
        logs = np.log(missed(lines, others))
        for name, some in zip(("pulled", "pushed", "across"), logs.T, strict=True):
            low, high = np.exp(some.mean() + np.array([-1.96, 1.96]) * some.std())
            print(
                f"{name}: {len(some)} eyes, each by the fit to the others, over the solid's: 95 % "
                f"{low:.3f} to {high:.3f}, all {exp(some.min()):.3f} to {exp(some.max()):.3f}"
            )
        return
    done = known()
    for number, numbers in drawn(options.count):
        if number in done:
            continue
        start = process_time()
        try:
            line = line_of(number, numbers)
        except (MeshError, SolverError) as error:
            print(number, error, flush=True)
            continue
        with FILE.open("a") as file:
            file.write(json.dumps(line) + "\n")
        print(f"{number}: {line['unknowns']}, {process_time() - start:.1f} s", flush=True)


if __name__ == "__main__":
    main()
