"""Contacts of a cycle: place, range, force and speed of impact."""

from collections.abc import Mapping

import numpy as np

from loads import GROUND, CycleLoads
from reports.loads_figures import ContactSpan, ContactStated, ContactSummary, FloatArray


def contact_summaries(
    loads: CycleLoads, shown: FloatArray, stated: Mapping[str, ContactStated]
) -> list[ContactSummary]:
    """Every contact of a cycle; `shown` (n,) is the position as people see it."""
    result = []
    for name, contact in loads.contacts.items():
        coordinate = loads.linkage.force(name).coordinate
        effort = np.abs(loads.efforts[name])
        most = int(np.where(contact.touching, effort, -1.0).argmax())
        gap = loads.touches[name].gap
        pushed = [body for body in coordinate.bodies if body != GROUND]
        spans = _spans(loads, name, shown)
        held = contact.held[contact.touching]
        result.append(
            ContactSummary(
                name=name,
                body=" and ".join(pushed),
                angular=coordinate.angular,
                stated=stated.get(name),
                spans=spans,
                always=bool(contact.touching.all()),
                start_depth=-float(gap[0]) if contact.touching[0] else None,
                nearest=None if spans else float(gap.min()),
                largest=float(effort.max()),
                largest_at=float(shown[most]),
                largest_phase=loads.phases[int(loads.phase_of[most])],
                deflection=float(np.abs(contact.deflection).max()),
                least_held=float(held.min(initial=1.0)),
                most_held=float(held.max(initial=0.0)),
                approach_speed=max((span.approach_speed or 0.0 for span in spans), default=0.0),
                energy=sum(span.energy or 0.0 for span in spans),
            )
        )
    return result


def _spans(loads: CycleLoads, name: str, shown: FloatArray) -> tuple[ContactSpan, ...]:
    """Stretches of touch; the positions where it begins and ends stand in the cycle, untouched."""
    contact = loads.contacts[name]
    touching, last = contact.touching, len(shown) - 1
    impacts = dict(zip(contact.begins.tolist(), contact.impacts.tolist(), strict=True))
    gap = loads.touches[name].gap
    edges = np.flatnonzero(np.diff(np.concatenate([[False], touching, [False]]).astype(int)))
    spans = []
    for first, behind in edges.reshape(-1, 2).tolist():
        start, stop = max(first - 1, 0), min(behind, last)
        # where the phase before has no contact, it is not met on the way but put there
        met = first > 0 and np.isfinite(gap[start])
        if not met:
            start = first
        if not np.isfinite(gap[stop]):
            stop = behind - 1
        speed = abs(float(contact.rate[start])) if met else None
        spans.append(
            ContactSpan(
                start=float(shown[start]),
                start_phase=loads.phases[int(loads.phase_of[first])],
                stop=float(shown[stop]),
                stop_phase=loads.phases[int(loads.phase_of[behind - 1])],
                approach_speed=speed,
                energy=float(impacts[start]) if start in impacts else None,
            )
        )
    return tuple(spans)
