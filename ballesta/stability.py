"""Buckling of a part at its worst position: column formulas in both planes, and eigenvalues."""

from collections.abc import Sequence

import numpy as np

from ballesta.design_data import Design, Part
from ballesta.machine import interface_distance
from ballesta.part_loads import PartLoads
from fem.buckling import BucklingMode, buckling_modes
from fem.columns import column_strength
from fem.unit_solutions import UnitSolutions
from geometry.mesh import FloatArray
from reports.verdict import Check, Status

# Half-width of the bar while only the coarse mesh has been asked. Between the two meshes the factor
# changes by 1.4 % for the toggle bar and by 13 % for the local mode of a thin-walled tube.
_ONE_MESH_BAR = 0.25
_FAR = 3.0  # times the required safety: beyond it the stiffer fork's bound is not computed


def axial_compression(part: Part, loads: PartLoads) -> FloatArray:
    """Compressive force (n,) at that of a part's two ends where it is larger, N; < 0 is tension.

    The ends differ by the part's weight and inertia.
    """
    first, second = part.geometry.interfaces[:2]
    return np.asarray(np.maximum(loads.wrenches[first][:, 0], -loads.wrenches[second][:, 0]))


def column_checks(design: Design, part: Part, loads: PartLoads) -> list[Check]:
    """One check per plane: the section with the least safety by yield, Johnson or Euler."""
    if not part.geometry.sections:
        return []
    force = axial_compression(part, loads)
    worst = int(force.argmax())
    if not force[worst] > 0:
        return []
    own = interface_distance(design, part)
    planes = (
        ("in plane", "inertia_in_plane", "length", part.column.in_plane or own),
        (
            "out of plane",
            "inertia_out_of_plane",
            "length_out_of_plane",
            part.column.out_of_plane or own,
        ),
    )
    checks = []
    for plane, inertia, effective, whole in planes:
        found = []
        for section in part.geometry.sections:
            length = getattr(section, effective) or whole
            strength = column_strength(
                section.area,
                getattr(section, inertia),
                length,
                part.material.yield_stress,
                part.material.youngs_modulus,
            )
            stress = force[worst] / section.area
            found.append((strength.critical / stress, section, stress, strength, length))
        _, section, stress, strength, length = min(found, key=lambda entry: entry[0])
        shorter = column_strength(
            section.area,
            getattr(section, inertia),
            min(length, own),
            part.material.yield_stress,
            part.material.youngs_modulus,
        ).critical
        others = "; ".join(
            f"{s.name}: {value:.2f} ({st.governs}, slenderness {st.slenderness:.1f})"
            for value, s, _, st, _ in found
            if s is not section
        )
        checks.append(
            Check(
                part=part.name,
                kind="buckling",
                quantity=f"column {plane}",
                value=float(stress),
                unit="MPa",
                numerical=0.0,
                model=0.0,
                model_below=float(stress * (1 - strength.critical / shorter)),
                limit=strength.critical,
                required=design.require.buckling,
                cycle=loads.cycle_names[worst],
                position=loads.labels[worst],
                place=section.name,
                method="formula",
                basis=f"{strength.governs}; slenderness {strength.slenderness:.1f} over "
                f"{length:.4g} mm; Euler {strength.euler:.4g} MPa; value is axial stress",
                note=f"other sections, safety: {others}" if others else "",
            )
        )
    return checks


def eigenvalue_check(
    design: Design,
    part: Part,
    loads: PartLoads,
    levels: Sequence[tuple[UnitSolutions, FloatArray]],
) -> tuple[Check, BucklingMode] | None:
    """Return the lowest buckling factor of the solid at the worst position, ends free to tilt.

    levels  solutions and coefficients (n_basis, n) of the meshes, coarse to fine

    The fork's other bound, ends that cannot tilt, stands in the note. None without compression or
    without a positive factor.
    """
    if not part.geometry.sections:
        return None
    force = axial_compression(part, loads)
    worst = int(force.argmax())
    if not force[worst] > 0:
        return None
    solutions, coefficients = levels[0]
    modes = buckling_modes(solutions, coefficients[:, worst], tilt_held=False)
    if not modes:  # large negative ones may stand before it
        modes = buckling_modes(solutions, coefficients[:, worst], tilt_held=False, count=12)
    if not modes:
        return None
    forks = "higher"
    if modes[0].factor < _FAR * design.require.buckling:
        held = buckling_modes(solutions, coefficients[:, worst], tilt_held=True)
        forks = f"{held[0].factor:.3g}" if held else "none"
    by_plane = {mode.plane: mode.factor for mode in reversed(modes)}
    planes = ", ".join(f"{factor:.3g} {plane}" for plane, factor in by_plane.items())

    def checked(mode: BucklingMode, bar: float, meshes: str) -> Check:
        return Check(
            part=part.name,
            kind="buckling",
            quantity="elastic load share",
            value=1 / mode.factor,
            unit="",
            numerical=bar / mode.factor,
            model=0.0,
            limit=1.0,
            required=design.require.buckling,
            cycle=loads.cycle_names[worst],
            position=loads.labels[worst],
            place=f"{mode.plane} mode",
            method=f"solid ({meshes})",
            basis="linear eigenvalue, both ends held sideways: knows neither yield nor crookedness",
            note=f"lowest factors {planes}; with forks that hold the ends against tilting: {forks}",
        )

    check = checked(modes[0], _ONE_MESH_BAR, "one mesh")
    if check.status is Status.UNDECIDED and len(levels) > 1:
        solutions, coefficients = levels[-1]
        finer = buckling_modes(solutions, coefficients[:, worst], tilt_held=False)
        if finer:
            bar = abs(finer[0].factor / modes[0].factor - 1)
            return checked(finer[0], bar, "two meshes"), finer[0]
    return check, modes[0]
