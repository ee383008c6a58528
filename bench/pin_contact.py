"""Pins in holes: CalculiX's contact against the cosine pressures on arcs that the checks use.

`python -m bench.pin_contact` prints the table of "Pins in holes" in bench/validation_notes.md, an
eye or cheek of each scene with clearance 0 and 0.1 mm; with `--sweep` also the same shapes over the
parameter E* dR t/F, and where they leave the band; with `--condensed` the contact of fem/contact
beside CalculiX's, three clearances and three forces. It needs CalculiX, `ccx` in the path. Plane
halves of six-node triangles, mesh and stress of both solutions are the same; only the pressure
differs.
"""

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from scipy.integrate import quad

from bench.frd_file import read_frd
from bench.pin_models import EYES, STEEL, Eye, Grid, deck
from fem.contact.condensed import ALLOWED, CondensedContact
from fem.contact.hats import Hats, disc_flexibility, sheet_flexibility
from fem.contact.persson import persson_half_arc, persson_pressure
from geometry.mesh import FloatArray
from tests.validation.plane.model import Given, PlaneModel, PlaneSolution
from tests.validation.plane.recovery import von_mises_plane

ARCS = (180.0, 150.0, 120.0)  # degrees: what the model band of a check is made of
CLEARANCES = (0.0, 0.1)  # mm, on diameter
SWEEP = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 64.0)  # E* dR t / F


@dataclass(frozen=True)
class Reading:
    """Effect of a pin on the edge of a hole: MPa and degrees from the force.

    arc      that the pin touches, up to 1 % of the largest pressure
    mises    largest von Mises stress of the edge, and where
    hoop     largest stress along the edge, where, and 90 degrees from the force
    carried  share of the force that the pressure on the hole amounts to, 1
    """

    arc: float
    pressure: float
    mises: float
    mises_at: float
    hoop: float
    hoop_at: float
    hoop_across: float
    carried: float


def model(grid: Grid) -> PlaneModel:
    """The eye, 1 mm thick."""
    return PlaneModel(grid.plate, *grid.eye.elastic, grid.eye.kind)


def read(grid: Grid, stress: FloatArray) -> Reading:
    """Read the edge of the hole; stress (n_nodes, 4), MPa."""
    nodes = grid.plate.edge_nodes("hole")
    x, y = grid.plate.nodes[nodes].T / grid.inner
    order = np.argsort(np.arctan2(y, x))
    x, y, edge = x[order], y[order], stress[nodes[order]]
    angles = np.arctan2(y, x)
    xx, yy, _, xy = edge.T
    pressure = -(xx * x * x + yy * y * y + 2 * xy * x * y)
    hoop = xx * y * y + yy * x * x - 2 * xy * x * y
    mises = von_mises_plane(edge)
    most = pressure.argmax()  # in thin eyes not at 0
    last = most + (pressure[most:] > 0.01 * pressure.max()).argmin() - 1
    eye = grid.eye
    carried = 2 * grid.inner * np.trapezoid(pressure * x, angles) / (eye.force / eye.thickness)
    top, pulled = mises.argmax(), hoop.argmax()
    return Reading(
        2 * np.degrees(angles[last]),
        pressure.max(),
        mises[top],
        np.degrees(angles[top]),
        hoop[pulled],
        np.degrees(angles[pulled]),
        np.interp(np.pi / 2, angles, hoop),
        carried,
    )


def cosine(grid: Grid, arc: float) -> Reading:
    """The pressure p cos(pi angle/arc) of a check; arc in degrees."""
    plate, eye, beta = model(grid), grid.eye, np.radians(arc)
    unit = quad(lambda a: np.cos(np.pi * a / beta) * np.cos(a), -beta / 2, beta / 2)[0]
    size = eye.force / eye.thickness / grid.inner / unit

    def traction(points: FloatArray, normals: FloatArray) -> FloatArray:
        angle = np.arctan2(points[..., 1], points[..., 0])
        inside = np.abs(angle) < beta / 2
        pressure = size * np.cos(np.pi * angle / beta) * inside
        return np.asarray(-normals * pressure[..., None])

    solution = plate.solve(dirichlet=_supports(grid), tractions={"hole": traction})
    return read(grid, solution.stress)


def contact(grid: Grid) -> Reading:
    """CalculiX's contact; the stress of its displacements is recovered as for `cosine`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "pin.inp")
        path.write_text(deck(grid), encoding="ascii")
        done = subprocess.run(["ccx", "pin"], cwd=folder, capture_output=True, text=True)
        if "Job finished" not in done.stdout:
            raise RuntimeError(f"ccx did not finish {grid.eye.name!r}:\n{done.stdout[-2000:]}")
        last = read_frd(path.with_suffix(".frd"))[-1]
    if last.time != 1:
        raise RuntimeError(f"ccx stopped {grid.eye.name!r} at {last.time} of the force")
    count = len(grid.plate.nodes)
    displacement = last.fields["DISP"][:count, :2]
    plate = model(grid)
    found = read(grid, PlaneSolution(plate, displacement, np.zeros((count, 2)), 0.0).stress)
    if abs(found.carried - 1) > 0.01:
        raise RuntimeError(f"{grid.eye.name!r}: the hole carries {found.carried:.3f} of the force")
    return found


def condensed(grid: Grid, long_waves: int = 8, hats_in_half_arc: int = 32) -> Reading:
    """The contact of fem/contact: long waves by the plate's elements, short ones as in a sheet.

    long_waves        harmonics that the plate answers for
    hats_in_half_arc  of pressure, over 1.3 times the half arc expected; a third as many beyond
    """
    eye, plate, radius = grid.eye, model(grid), grid.inner
    held = plate.held(_supports(grid))
    strain = eye.kind == "strain"

    def pressed(size: Callable[[FloatArray], FloatArray]) -> FloatArray:
        def traction(points: FloatArray, _normals: FloatArray) -> FloatArray:
            angle = np.arctan2(points[..., 1], points[..., 0])
            outward = points / np.linalg.norm(points, axis=-1, keepdims=True)
            return np.asarray(outward * size(angle)[..., None])

        return plate.loads({"hole": traction})

    numbers = np.arange(long_waves + 1)
    loads = np.stack(
        [pressed(lambda a, n=n: np.cos(n * a) / np.pi / radius / (1 if n else 2)) for n in numbers],
        axis=1,
    )
    moved = np.zeros_like(loads)
    moved[held.free], _ = held.factor.solve(loads[held.free])
    within = min(1.3 * grid.half_arc, np.pi / 2)
    near = np.linspace(0, within, hats_in_half_arc + 1)
    beyond = np.linspace(within, np.pi, hats_in_half_arc + 1)[1:]
    half = np.r_[near, beyond]
    hats = Hats(np.r_[half, 2 * np.pi - half[-2:0:-1]])
    young, poisson = eye.elastic
    if strain:
        young, poisson = young / (1 - poisson**2), poisson / (1 - poisson)
    long = numbers[2:]
    sheet = np.r_[(1 + poisson) / 2, 0.0, (2 * long + 1 - poisson) / (long**2 - 1)] / np.pi / young
    waves = np.column_stack([np.ones(len(hats.angles)), hats.waves(numbers[1:]).real])
    flexibility = disc_flexibility(hats, 1.0, *STEEL, strain=strain)
    flexibility += sheet_flexibility(hats, 1.0, *eye.elastic, strain=strain)
    flexibility += waves @ (2 * loads.T @ moved - np.diag(sheet)) @ waves.T
    problem = CondensedContact((flexibility + flexibility.T) / 2, hats.directions[:, :1])
    openings = np.full(len(hats.angles), grid.clearance / 2)
    state = problem.solve(
        openings,
        np.array([eye.force / eye.thickness]),
        np.cos(hats.angles) >= np.cos(grid.half_arc),
    )
    if max(state.unbalanced, state.not_complementary) > ALLOWED:
        raise RuntimeError(f"{eye.name!r}: no contact, {state.not_complementary:.1e}")
    pressures = state.forces / hats.extents / radius
    found = read(grid, held.solve(pressed(lambda a: hats.values(a) @ pressures)).stress)
    arc = float(np.degrees(hats.arc(pressures)))
    return replace(found, arc=arc, pressure=float(pressures.max()))


def _supports(grid: Grid) -> dict[str | int, tuple[Given, Given]]:
    """The cut of symmetry, and the end that is held."""
    supports: dict[str | int, tuple[Given, Given]] = {"ahead": (None, 0.0), "behind": (None, 0.0)}
    held = np.flatnonzero(np.abs(grid.plate.nodes[:, 0] - grid.eye.held) < 1e-9)
    return supports | {int(node): (0.0, None) for node in held}


@dataclass(frozen=True, eq=False)
class Comparison:
    """A pin's contact beside what cosine pressures on ARCS make of the same mesh."""

    eye: Eye
    clearance: float
    found: Reading
    cosines: tuple[Reading, ...]

    def band(self, quantity: str) -> tuple[float, float]:
        """The least and the largest of the cosines, MPa."""
        values = [getattr(reading, quantity) for reading in self.cosines]
        return min(values), max(values)

    def beyond(self, quantity: str) -> float:
        """How far the contact lies above (+) or below (-) the band, over the nearer limit."""
        low, high = self.band(quantity)
        value = getattr(self.found, quantity)
        return float(max(value / high - 1, 0.0) + min(value / low - 1, 0.0))


def compare(
    eye: Eye, clearance: float, fineness: float = 1.0, arcs: tuple[float, ...] = ARCS
) -> Comparison:
    """Solve one eye with one clearance on diameter, mm; the cosines' arcs in degrees."""
    grid = Grid(eye, persson_half_arc(eye.parameter(clearance)), clearance, fineness)
    return Comparison(eye, clearance, contact(grid), tuple(cosine(grid, arc) for arc in arcs))


def table(rows: list[Comparison]) -> str:
    """Return the Markdown table; in brackets Persson's arc and pressure, and the cosines' band."""
    lines = [
        "| Part | Clearance, mm | E\\* ΔR t/F | Arc, deg (Persson) | Pressure (Persson) | "
        "Von Mises (band) | Hoop (band) | Hoop at 90° (band) |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        eye, found, parameter = row.eye, row.found, row.eye.parameter(row.clearance)
        half = persson_half_arc(parameter)
        theory = persson_pressure(half) * eye.force / eye.thickness / (eye.hole / 2)
        cells = [
            eye.name,
            f"{row.clearance:g}",
            f"{parameter:.3g}",
            f"{found.arc:.0f} ({2 * np.degrees(half):.0f})",
            f"{found.pressure:.3g} ({theory:.3g})",
        ]
        for quantity in ("mises", "hoop"):
            value, at = getattr(found, quantity), getattr(found, quantity + "_at")
            low, high = row.band(quantity)
            away = row.beyond(quantity)
            mark = f" **{100 * away:+.0f} %**" if away else ""
            cells.append(f"{value:.3g} at {at:.0f}° ({low:.3g} to {high:.3g}){mark}")
        low, high = row.band("hoop_across")
        cells.append(f"{found.hoop_across:.3g} ({low:.3g} to {high:.3g})")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def sweep(eye: Eye) -> str:
    """Return where over E* dR t/F one shape stands to the band; a line for each value."""
    rows = []
    for value in SWEEP:  # the last arc is the small one of the rule, Hertz's of that parameter
        narrow = np.degrees(np.sqrt(16 / (np.pi * value))) if value else ARCS[-1]
        rows.append(compare(eye, eye.clearance(value), 0.6, (*ARCS, min(narrow, ARCS[-1]))))
    lines = [
        f"{eye.name}: E* dR t/F, arc, pressure, von Mises and hoop, beyond the band by, "
        "and beyond the band down to Hertz's arc by"
    ]
    for value, wide in zip(SWEEP, rows, strict=True):
        band = replace(wide, cosines=wide.cosines[:-1])
        found = wide.found
        away = [100 * row.beyond(q) for row in (band, wide) for q in ("mises", "hoop")]
        lines.append(
            f"{value:6g} {found.arc:5.0f} {found.pressure:8.3g} {found.mises:8.3g} "
            f"{found.hoop:8.3g} " + " ".join(f"{percent:+6.1f} %" for percent in away)
        )
    return "\n".join(lines)


def condensed_table() -> str:
    """Return contact by CalculiX and by fem/contact: clearances, forces; a line for each."""
    lines = ["part, clearance mm, force: CalculiX's and condensed contact, per cent between them"]
    for eye, clearance, share in product(EYES, (0.0, 0.02, 0.1), (0.25, 1.0, 4.0)):
        loaded = replace(eye, force=share * eye.force)
        grid = Grid(loaded, persson_half_arc(loaded.parameter(clearance)), clearance)
        start = time.process_time()
        ours = condensed(grid)
        middle = time.process_time()
        reference = contact(grid)
        cells = [f"arc {reference.arc:.1f} {ours.arc:.1f}"]
        for quantity in ("pressure", "mises", "hoop"):
            one, other = getattr(reference, quantity), getattr(ours, quantity)
            cells.append(f"{quantity} {one:.4g} {other:.4g} {100 * (other / one - 1):+.1f} %")
        lines.append(
            f"{eye.name}, {clearance:g}, x{share:g}: {'; '.join(cells)}; {middle - start:.2f} s"
        )
    return "\n".join(lines)


def main() -> None:
    """Measure and print."""
    if shutil.which("ccx") is None:
        sys.exit("bench.pin_contact compares with CalculiX, and there is no `ccx` in the path")
    print(table([compare(eye, clearance) for eye in EYES for clearance in CLEARANCES]))
    if "--condensed" in sys.argv:
        print(f"\n{condensed_table()}", flush=True)
    if "--sweep" in sys.argv:
        for eye in EYES:
            print(f"\n{sweep(eye)}", flush=True)


if __name__ == "__main__":
    main()
