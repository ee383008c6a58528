"""The share that loads are of a bar's elastic buckling load, by the rung `formula`."""

from math import pi

import numpy as np

from checks.part.derived import numbers
from checks.result.derivation import Column, Given, Item, Step, Sum
from geometry.mesh import FloatArray

SHARE = "share"  # the symbol of the result
_QUOTIENT = "Timoshenko's quotient: Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 2.8"
_LATERAL = "Timoshenko and Gere, 2nd ed., 6.1 to 6.3"
_FORCE_SHARE = Step(SHARE, "share of the elastic buckling load", "max(0, F/F_cr)", main=True)


def column_items(
    force: float,
    stiffness: FloatArray,
    shear: FloatArray | float,
    length: float,
    sideways: float | None = None,
) -> list[Item]:
    """Formulas of the share of a bar between its pins, as a hinged column.

    force      N, compression
    stiffness  (k,) N mm2, E I of the section at even places from pin to pin
    shear      N, shear stiffness there, (k,) or of all; infinite where no shear strain is counted
    length     mm, between where the pins press
    sideways   share that its moments alone are of those that buckle it sideways; None where the
               share is the compression's alone
    """
    critical = _critical(force, stiffness, shear, length)
    return [*critical, *([_FORCE_SHARE] if sideways is None else _bent_besides(sideways))]


def stretch_items(force: float, local: float) -> list[Item]:
    """Formulas of the share of a stretch of a part that buckles by itself.

    force  N, compression
    local  1/N, share that 1 N is of the compression under which it buckles
    """
    return [
        Given("F", "largest compression", force, "N", "the loads", main=True),
        Given("F_cr", "force under which a stretch buckles by itself: plates and columns",
              1 / local, "N", "Timoshenko and Gere, 2nd ed., 9.2; docs/theory/rungs.md"),
        _FORCE_SHARE,
    ]  # fmt: skip


def _bent_besides(moments: float) -> list[Item]:
    """Out of the plane, where a bent bar also gives way sideways."""
    return [
        Step("p", "compression over it", "F/F_cr"),
        Given(
            "m",
            "share that the moments are of those that buckle the bar sideways: the lowest of an "
            "energy of three waves",
            moments,
            "",
            _LATERAL,
        ),
        Step(SHARE, "share of the elastic buckling load", "(p + sqrt(p^2 + 4*m^2))/2", "",
             _LATERAL, main=True),
    ]  # fmt: skip


def _critical(
    force: float, stiffness: FloatArray, shear: FloatArray | float, length: float
) -> list[Item]:
    """Compression, and the force under which such a hinged column buckles."""
    count = len(stiffness)
    weights = np.ones(count)
    weights[[0, -1]] = 0.5
    columns = [
        Column("t", "place over the length, times π", "", numbers(np.linspace(0, pi, count))),
        Column("w", "weight", "", numbers(weights)),
    ]
    bends = Column("B", "E I of the section there", "N mm2", numbers(stiffness))
    slides, gives = [], "w*sin(t)^2/B"
    if np.isfinite(shear).all():
        slides = [Column("K", "shear stiffness there", "N",
                         numbers(np.broadcast_to(np.asarray(shear), count)))]  # fmt: skip
        gives += " + w*(pi/L*cos(t))^2/K"
    names = tuple(f"station {number}" for number in range(1, count + 1))
    return [
        Given("F", "compression", force, "N", "the loads", main=True),
        Given("L", "length between where the pins press", length, "mm",
              "pins' distance less 8/(3π) of the bores' radii"),
        Sum("Q_1", "work of the force, one wave", "w*(pi/L*cos(t))^2", names, tuple(columns), "",
            _QUOTIENT),
        Sum("Q_2", "what bends and slides", gives, names, (*columns, bends, *slides), "",
            _QUOTIENT),
        Step("F_cr", "buckling force of the hinged column", "Q_1/Q_2", "N", _QUOTIENT, main=True),
    ]  # fmt: skip
