"""The share that loads are of a bar's elastic buckling load, by the rung `formula`."""

from collections.abc import Sequence
from math import pi

import numpy as np

from geometry.mesh import FloatArray
from reports.derivation import Column, Given, Item, Step, Sum

SHARE = "share"  # the symbol of the result
_QUOTIENT = "Timoshenko's quotient: Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 2.8"
_LATERAL = "Timoshenko and Gere, 2nd ed., 6.1 to 6.3"


def as_column(
    force: float, stiffness: FloatArray, shear: FloatArray | float, length: float
) -> list[Item]:
    """Compression over the buckling force of a hinged column with these E I (k,), N mm2."""
    return [
        *_critical(force, stiffness, shear, length),
        Step(SHARE, "share of the elastic buckling load", "max(0, F/F_cr)", main=True),
    ]


def sideways(
    force: float,
    stiffness: FloatArray,
    shear: FloatArray | float,
    length: float,
    bent: float,
) -> list[Item]:
    """The same out of the plane, where a bent bar also gives way sideways.

    bent  share that the moments alone are of those under which it does
    """
    return [
        *_critical(force, stiffness, shear, length),
        Step("p", "compression over it", "F/F_cr"),
        Given(
            "m",
            "share that the moments are of those that buckle the bar sideways: the lowest of an "
            "energy of three waves",
            bent,
            "",
            _LATERAL,
        ),
        Step(SHARE, "share of the elastic buckling load", "(p + sqrt(p^2 + 4*m^2))/2", "",
             _LATERAL, main=True),
    ]  # fmt: skip


def by_itself(force: float, local: float) -> list[Item]:
    """A stretch of the part that buckles by itself; local: 1/N, its share per force."""
    return [
        Given("F", "largest compression", force, "N", "the loads", main=True),
        Given("F_cr", "force under which a stretch buckles by itself: plates and columns",
              1 / local, "N", "Timoshenko and Gere, 2nd ed., 9.2; docs/theory/rungs.md"),
        Step(SHARE, "share of the elastic buckling load", "max(0, F/F_cr)", main=True),
    ]  # fmt: skip


def _critical(
    force: float, stiffness: FloatArray, shear: FloatArray | float, length: float
) -> list[Item]:
    count = len(stiffness)
    weights = np.ones(count)
    weights[[0, -1]] = 0.5
    columns = [
        Column("t", "place over the length, times π", "", _numbers(np.linspace(0, pi, count))),
        Column("w", "weight", "", _numbers(weights)),
    ]
    bends = Column("B", "E I of the section there", "N mm2", _numbers(stiffness))
    slides, gives = [], "w*sin(t)^2/B"
    if np.isfinite(shear).all():
        slides = [Column("K", "shear stiffness there", "N",
                         _numbers(np.broadcast_to(np.asarray(shear), count)))]  # fmt: skip
        gives += " + w*(pi/L*cos(t))^2/K"
    names = tuple(f"station {number}" for number in range(1, count + 1))
    return [
        Given("F", "compression", force, "N", "the loads", main=True),
        Given("L", "length between the pins", length, "mm", "the part's shape"),
        Sum("Q_1", "work of the force, one wave", "w*(pi/L*cos(t))^2", names, tuple(columns), "",
            _QUOTIENT),
        Sum("Q_2", "what bends and slides", gives, names, (*columns, bends, *slides), "",
            _QUOTIENT),
        Step("F_cr", "buckling force of the hinged column", "Q_1/Q_2", "N", _QUOTIENT, main=True),
    ]  # fmt: skip


def _numbers(values: FloatArray | Sequence[float]) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
