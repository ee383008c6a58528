"""Play of pins in their bores: what it adds to the loads as the force of a joint reverses.

Where a part states the fit of its pin, the loads with and without the hits of that joint's pin are
a doubt with bars (docs/theory/joint_play.md); where no fit is stated an assumption tells how much
the usual one would add.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from math import inf

import numpy as np

import loads
from ballesta.machine.blows import driven
from ballesta.machine.drive_speed import LoadPair, Solved
from checks.design.data import Design, Part
from checks.handbook.fits import DEFAULT, clearances_of
from checks.result.words import number
from geometry.mesh import Interface

_NEAT = 1.51  # k / (E' L) of a pin without play in a bore, both as stiff as the stiffer of them
_NOTHING = 1e-3  # of a joint's largest force: less is not worth the loads at another end
_TOLD = 0.02


@dataclass(frozen=True)
class _Seat:
    """Play that a joint's pin can cross, mm on diameter.

    stiffness  N/mm, of its contact at the most, and of the joint where the design states it
    """

    play: float
    stiffness: float


def play_pairs(design: Design, solved: Solved) -> tuple[list[LoadPair], list[tuple[str, str]]]:
    """Loads without and with the hits of every joint that has a fit, and what is assumed of others.

    Of several bores of a joint with fits the largest plays add up.
    """
    pairs, silent = [], list[tuple[float, str, str]]()
    for joint in (one for joints in design.joints.values() for one in joints if solved):
        stated = _seat(design, joint, stated=True)
        seat = stated or _seat(design, joint, stated=False)
        if seat is None:
            continue
        name, play = joint.name, seat.play
        drives = {cycle: _inertia(design, cycle) for cycle in solved}
        hits = {
            cycle: loads.play_hits(own, name, play, seat.stiffness, drives[cycle])
            for cycle, own in solved.items()
        }
        added = max((hit.added for own in hits.values() for hit in own), default=0.0)
        most = max(float(np.hypot(*own.reactions[name].force.T).max()) for own in solved.values())
        if stated is None and added > _TOLD * most:
            share = added / most
            said = f"{number(added)} N on top of its largest force of {number(most)} N"
            silent.append((share, joint.point_b, said))
        elif stated is not None and added > _NOTHING * most:
            end = {
                cycle: loads.with_hits(own, name, hits[cycle], drives[cycle])
                for cycle, own in solved.items()
            }
            words = f"play of {play:g} mm in {name} as its force reverses"
            pairs.append(LoadPair(words, (solved, end)))
    return pairs, _assumed(silent)


def _assumed(silent: list[tuple[float, str, str]]) -> list[tuple[str, str]]:
    if not silent:
        return []
    _, point, said = max(silent, key=lambda one: one[0])
    others = f" (less in {len(silent) - 1} more)" if len(silent) > 1 else ""
    reason = (
        f"none is stated: pins without play; with {DEFAULT} that of {point} hits its bore by up to "
        f"{said} where its force reverses{others}: bodies as if rigid, not in the error bars"
    )
    return [("parts.fits", reason)]


def _inertia(design: Design, cycle: str) -> float:
    _, inertia, known = driven(design, design.cycles[cycle].run.pace)
    return inertia if known else inf


def _seat(design: Design, joint: loads.Joint, *, stated: bool) -> _Seat | None:
    """The joint's seat; None where no part has a bore for it, or none with a fit.

    Plays of stated fits add up, and so does what gives way. Else a pin turns in one bore.
    """
    if not isinstance(joint, loads.Revolute):
        return None
    seats = []
    for part, bore in _bores(design, joint):
        if stated and bore.name not in part.clearances:
            continue
        pin = next((one for one in design.parts.values() if one.joint == joint.point_b), part)
        moduli = [
            m.youngs_modulus / (1.0 - m.poisson_ratio**2) for m in (part.material, pin.material)
        ]
        soft = 1.0 / (_NEAT * max(moduli) * bore.length)
        if stated:
            seats.append((part.clearances[bore.name][1], soft))
        else:
            with suppress(ValueError):  # a bore larger than any of the table
                seats.append((clearances_of(DEFAULT, 2.0 * bore.radius)[1], soft))
    if not seats:
        return None
    play, soft = np.sum(seats, axis=0) if stated else max(seats)
    if play <= 0.0:
        return None
    for one in design.compliance:
        if isinstance(one, loads.JointCompliance) and one.joint == joint.name:
            soft += 1.0 / one.stiffness
    return _Seat(float(play), float(1.0 / soft))


def _bores(design: Design, joint: loads.Revolute) -> Iterator[tuple[Part, Interface]]:
    for body, point in ((joint.body_a, joint.point_a), (joint.body_b, joint.point_b)):
        part = design.part_of(body)
        if part is None:
            continue
        for face in part.geometry.placed_interfaces:
            if face.kind == "bore" and part.interfaces.get(face.name) == point:
                yield part, face
