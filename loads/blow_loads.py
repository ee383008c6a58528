"""Loads of a blow in a solved cycle: the transient of all bodies, put where the contact is met.

Modes of the elastic linkage with its drive held (`loads/vibration.py`) answer to the force of the
workpiece (`loads/blow_force.py`). A unit force of the contact, in equilibrium with the held drive,
deforms the linkage by s; its share in mode i, of deformations e_i of unit length, is a_i = e_i . s,
and the shape of the struck point is phi_i = omega_i a_i, as its static answer phi / omega^2 has the
energy a^2 / 2. What is left, s . s - sum a_i^2, yields without mass.

At every moment the bodies are in equilibrium with the force F and their inertia -M u'', where
u'' = sum of shapes times q'', q'' = phi F - omega^2 q: joint forces are those before the blow, and
what F and these inertia forces add, the drive held. Poses stay as they are.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from loads.blow_force import BlowForce, Struck, blow_force
from loads.bodies import FloatArray, IntArray
from loads.contact import Touch
from loads.cycle_loads import CycleLoads
from loads.forces import JointLoad, unit_forces
from loads.vibration import cycle_modes, grown, joint_strains, pushed_motion, with_body_loads

_ROUND_OFF = 1e-9  # of a compliance


@dataclass(frozen=True, eq=False)
class BlowLoads:
    """A blow in a cycle.

    row    of the cycle, at which the contact is met
    blow   its force
    loads  the cycle at the moments of the blow alone, its times since the cycle's start
    """

    row: int
    blow: BlowForce
    loads: CycleLoads


def blow_loads(
    cycle: CycleLoads, elastic: CycleLoads, force: str, row: int, struck: Struck, damping: float
) -> BlowLoads:
    """Return the blow of a contact that is met at a row of a cycle.

    elastic  the cycle of a linkage in which everything gives way that can

    Raises LinkageError where nothing of the linkage is elastic, or the blow cannot be followed.
    """
    modes = cycle_modes(elastic, np.array([row]))
    pushed = pushed_motion(modes, elastic.pace)
    (unit,) = unit_forces(pushed, [force], 1.0, modes.holder)
    strain = joint_strains(modes.kinematics, modes.motion.poses, unit, modes.lumps)[0]
    free = np.isfinite(modes.frequencies[0])
    omega = 2.0 * np.pi * modes.frequencies[0, free]
    shares = modes.strains[0][:, free].T @ strain
    left = float(strain @ strain - shares @ shares)
    rate = float(cycle.rate(force)[row])
    way = -np.sign(rate) * cycle.linkage.force(force).sign  # of the effort that the workpiece is
    blow = blow_force(
        omega,
        way * omega * shares,
        left if left > _ROUND_OFF * float(strain @ strain) else 0.0,
        abs(rate),
        struck,
        damping,
    )
    count = len(blow.times)
    rows = np.full(count, row)
    push = way * blow.force
    shapes = modes.shapes[0][:, free]
    # elastic inertia forces M u'' of the modes, without and with the force itself
    answer = blow.modal * omega**2 - np.outer(blow.force, way * omega * shares)
    lumped = modes.lumps.masses * (answer @ shapes.T)
    still = at_rows(elastic, rows)
    moved = with_body_loads(modes.at(np.zeros(count, dtype=int)), still, lumped)
    reactions = {
        name: grown(load, unit.joints[name], push) for name, load in moved.reactions.items()
    }
    efforts = dict(moved.efforts)
    efforts[force] = efforts[force] + push
    efforts[modes.holder] = efforts[modes.holder] + unit.efforts[modes.holder] * push
    times = cycle.times[row] + blow.times
    own = cycle.phase_of == cycle.phase_of[row]
    loads = replace(
        at_rows(cycle, rows),
        times=times,
        positions=np.interp(times, cycle.times[own], cycle.positions[own]),
        accelerations=moved.accelerations,
        reactions=reactions,
        efforts=efforts,
    )
    return BlowLoads(row, blow, loads)


def with_blow(cycle: CycleLoads, blow: BlowLoads) -> CycleLoads:
    """Return the cycle with the moments of a blow in place of its own positions in that time."""
    end = blow.loads.times[-1]
    after = np.arange(len(cycle.times)) > blow.row
    kept = np.flatnonzero(
        after & ((cycle.times > end) | (cycle.phase_of != blow.loads.phase_of[0]))
    )
    before = np.arange(blow.row + 1)
    return joined([at_rows(cycle, before), blow.loads, at_rows(cycle, kept)])


def at_rows(cycle: CycleLoads, rows: IntArray) -> CycleLoads:
    """Return the cycle at some of its positions."""
    return _mapped([cycle], lambda arrays: arrays[0][rows])


def joined(parts: Sequence[CycleLoads]) -> CycleLoads:
    """Return stretches of one cycle, one after another."""
    return _mapped(parts, np.concatenate)


def _mapped(
    parts: Sequence[CycleLoads], change: Callable[[Sequence[FloatArray]], FloatArray]
) -> CycleLoads:
    """Return the first cycle with every array over the positions made of those of all."""
    first = parts[0]

    def of(name: str) -> FloatArray:
        return change([getattr(part, name) for part in parts])

    def over(owner: str, kind: type[Any]) -> dict[str, Any]:
        return {
            key: kind(
                *(
                    change([getattr(getattr(part, owner)[key], field.name) for part in parts])
                    for field in fields(kind)
                )
            )
            for key in getattr(first, owner)
        }

    changed: dict[str, Any] = {
        name: of(name)
        for name in ("positions", "times", "phase_of", "poses", "velocities", "accelerations",
                     "heading", "conditioning")
    }  # fmt: skip
    return replace(
        first,
        **changed,
        reactions=over("reactions", JointLoad),
        efforts={key: change([part.efforts[key] for part in parts]) for key in first.efforts},
        touches=over("touches", Touch),
    )
