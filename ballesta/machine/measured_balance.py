"""Equilibrium of measured loads: on every body, and between the bodies on a pin."""

from collections.abc import Iterator, Mapping

import numpy as np

import loads
from checks.design.data import Design, MeasuredRun, Part
from checks.design.errors import Problems
from checks.part.part_loads import is_loaded
from checks.result.verdict import Gate

_SPIN = 0.1  # a difference quotient of 15 positions a turn is off by 3 %

Masses = Mapping[str, tuple[float, tuple[float, float], float]]


def measured_loads(design: Design, masses: Masses) -> dict[str, loads.MeasuredLoads]:
    """Return the measured runs of a design with the mass properties of their bodies.

    Raises DesignError, with what would mend it, where the loads on bodies or on a pin leave more
    than the run's tolerance. Bodies whose mass is not known yet are not asked.
    """
    found, problems = {}, Problems(design.file)
    for name, run in design.measured.items():
        known = dict(_known(design, run, masses))
        found[name] = run.loads.with_mass_properties(known)
        for body in known:
            diagnosis = loads.diagnose(found[name], body, run.tolerance)
            if diagnosis is not None:
                key = f"measured.{name}.bodies.{body}"
                problems.add(key, f"{run.file}: {diagnosis}{_taken_as_zero(run, key)}")
        for part in design.parts.values():
            _check_pin(part, run, problems)
    problems.raise_if_any()
    return found


def _taken_as_zero(run: MeasuredRun, key: str) -> str:
    """Accelerations that enter a body's balance as 0 since the design states none, in words."""
    assumed = {stated for stated, _ in run.assumed}
    said = ""
    if f"{key}.acceleration" in assumed:
        said += "; no acceleration is stated: taken as at rest"
    if f"{key}.angular_acceleration" in assumed:
        said += "; no angular_acceleration is stated: taken as 0"
    return said


def _known(
    design: Design, run: MeasuredRun, masses: Masses
) -> Iterator[tuple[str, tuple[float, tuple[float, float], float]]]:
    for name in run.loads.bodies:
        body = design.bodies[name]
        if name in masses:
            yield name, masses[name]
        elif None not in design.stated_masses.get(name, ()):
            yield name, (body.mass, body.centre, body.inertia)


def _check_pin(part: Part, run: MeasuredRun, problems: Problems) -> None:
    if part.joint is None:
        return
    found = pin_residual(part, run.loads)
    if found is None:
        return
    row, force, share = found
    if share > run.tolerance:
        bodies = " and ".join(part.interfaces)
        problems.add(
            f"parts.{part.name}.stack",
            f"{run.file}: pin {part.joint}: {bodies} press on it with {force:.4g} N too much "
            f"({loads.percent(share)} of the largest force) at "
            f"{loads.position_text(run.loads, row)}; what else acts there, or whose force has the "
            "wrong sign? Of one body in the stack the load may be left out, it follows",
        )


def pin_residual(part: Part, run: loads.MeasuredLoads) -> tuple[int, float, float] | None:
    """Return where the lugs of a pin are least in balance: row, force [N], share of the largest.

    None where one of the lugs was not measured, so that its load follows from the others.
    """
    assert part.joint is not None
    left = run.pin_residual(part.joint, {name: name for name in part.interfaces})
    if left is None:
        return None
    size = np.hypot(left[:, 0], left[:, 1])
    row = int(size.argmax())
    largest = max(
        float(np.hypot(*load.force.T).max())
        for name in part.interfaces
        for load in run.bodies[name].loads
        if load.point == part.joint
    )
    return row, float(size[row]), float(size[row]) / (largest or 1.0)


def balance_gates(design: Design, measured: Mapping[str, loads.MeasuredLoads]) -> list[Gate]:
    """Gates for the forces that the measured loads leave unbalanced, run by run."""
    gates = []
    for name, run in measured.items():
        limit = design.measured[name].tolerance
        gates += [
            Gate(
                f"{name}: balance of the loads on {body}",
                share,
                limit,
                "force and moment that the measured loads, weight and inertia leave, over the "
                "largest force; taken up by the inertia of the body",
            )
            for body, share in run.equilibrium_residual.items()
        ]
        for body in run.bodies:
            mismatch = run.spin_mismatch(body)
            if mismatch is not None:
                gates.append(
                    Gate(
                        f"{name}: angular velocity of {body}",
                        mismatch,
                        _SPIN,
                        "largest difference from the rate of its angle over the largest rate; no "
                        "balance sees it, but the centrifugal stress goes with its square",
                        binding=False,
                    )
                )
        for part in design.parts.values():
            found = None if part.joint is None else pin_residual(part, run)
            if found is not None:
                gates.append(
                    Gate(
                        f"{name}: balance of the lugs on {part.name}",
                        found[2],
                        limit,
                        "force that the lugs' loads leave, over the largest; shared evenly",
                    )
                )
    return gates


def not_measured(design: Design) -> list[str]:
    """The linkage in measured runs, and parts on which a run has no load, in words."""
    runs = " and ".join(design.measured)
    linkage = (
        f"the linkage in {runs}: its buckling, vibration, hits of pins in their play, and what "
        "lies between two rows of a file, as measured loads are taken row by row"
    )
    return [linkage][: len(design.measured)] + [
        f"{part.name} in {name}: {run.file} has no load on it"
        for name, run in design.measured.items()
        for part in design.parts.values()
        if not is_loaded(part, run.loads)
    ]
