"""Slips that people make when they write down loads and motion, each with its correction."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from math import degrees, pi, radians

import numpy as np

from loads.bodies import FloatArray, Vector
from loads.kinematics import rotated, turned_left
from loads.measured import MeasuredBody, MeasuredLoad

ALL = "*"
KILOGRAM_FORCE, POUND_FORCE = 9.80665, 4.4482216152605  # N, NIST SP 811
_MILLI = 1e-3
_SMALL = 0.02  # a factor that all but takes away what it scales

Mend = Callable[[MeasuredBody], MeasuredBody]
MendLoad = Callable[[MeasuredLoad], MeasuredLoad]


@dataclass(frozen=True)
class Slip:
    """One slip, and how the data read without it.

    words   the correction, such as "reversing Fy at B"
    kind    of two slips of one kind at one point only one can have happened
    point   where; ALL for every point, None for the body's motion and mass
    rarity  0 for the commonest; breaks ties
    without where it makes something very small: that left out altogether
    """

    words: str
    kind: str
    point: str | None
    mend: Mend
    rarity: float = 0.0
    without: Mend | None = None

    def excludes(self, other: "Slip") -> bool:
        """Return True if both change the same reading, and so cannot have happened together."""
        return self.kind == other.kind and (
            self.point == other.point or ALL in (self.point, other.point)
        )


def slips_of(body: MeasuredBody, gravity: Vector, size: float) -> list[Slip]:
    """Return the slips that can have happened to the data of a body.

    In the order in which several are to be mended. Those that change nothing of the body's balance,
    or the same as one of their kind does, are left out.
    """
    found = [
        *_angle_slips(body),
        *(slip for load in body.loads for slip in _load_slips(load, load.point)),
        *_all_loads_slips(body),
        *_motion_slips(body, gravity),
        *_mass_slips(body, gravity),
    ]
    alike: dict[str, list[FloatArray]] = {}
    different = []
    for slip in found:
        known = alike.setdefault(slip.kind, [body.residual(gravity)])
        mended = slip.mend(body)
        left, limit = mended.residual(gravity), 1e-9 * mended.shares(gravity, size)[1]
        if all(float(np.abs(left - other).max()) > limit for other in known):
            known.append(left)
            different.append(slip)
    return different


def _at(point: str, change: MendLoad) -> Mend:
    def mend(body: MeasuredBody) -> MeasuredBody:
        return replace(
            body,
            loads=tuple(
                change(load) if point in (load.point, ALL) else load for load in body.loads
            ),
        )

    return mend


def _scaled(factor_x: float, factor_y: float, of_moment: float = 1.0) -> MendLoad:
    factors = np.array([factor_x, factor_y])
    return lambda load: replace(load, force=load.force * factors, moment=load.moment * of_moment)


def _load_slips(load: MeasuredLoad, point: str) -> Iterator[Slip]:
    """Yield the slips of the load at one point, or of the loads at all points."""
    at, the = ("at all points", "the forces") if point == ALL else (f"at {point}", "the force")

    def slip(words: str, kind: str, change: MendLoad, rarity: float = 0.0) -> Slip:
        return Slip(words, kind, point, _at(point, change), rarity)

    def shrunk(k: float, without: MendLoad) -> Mend | None:
        return _at(point, without) if k <= _SMALL else None

    yield slip(f"reversing Fx {at}", "force sign", _scaled(-1, 1))
    yield slip(f"reversing Fy {at}", "force sign", _scaled(1, -1))
    yield slip(f"reversing {the} {at}", "force sign", _scaled(-1, -1))
    yield slip(f"reversing the moment {at}", "moment sign", _scaled(1, 1, -1))
    yield Slip(
        f"reversing {the} and moment {at} (as given, they act by the body)",
        "force sign",
        point,
        _at(point, _scaled(-1, -1, -1)),
        0.2,
    )
    yield slip(
        f"swapping x and y of {the} {at}",
        "axes",
        lambda load: replace(load, force=load.force[:, ::-1]),
        0.5,
    )
    frame = "ground" if load.in_body_frame else "body"
    yield slip(
        f"taking {the} {at} as given in the {frame}'s frame",
        "frame",
        lambda load: replace(load, in_body_frame=not load.in_body_frame),
        0.3,
    )
    units = (
        ("kN", "N", 1e3, 0.0),
        ("kgf", "N", KILOGRAM_FORCE, 1.0),
        ("lbf", "N", POUND_FORCE, 1.0),
    )
    for unit, taken, factor, rarity in units:
        for has, stated, k in ((unit, taken, factor), (taken, unit, 1 / factor)):
            yield replace(
                slip(_times(f"{the} {at}", k, has, stated), "force unit", _scaled(k, k), rarity),
                without=shrunk(k, _scaled(0, 0)),
            )
    for has, stated, k in (("N m", "N mm", 1e3), ("N mm", "N m", _MILLI)):
        yield replace(
            slip(_times(f"the moment {at}", k, has, stated), "moment unit", _scaled(1, 1, k)),
            without=shrunk(k, _scaled(1, 1, 0)),
        )


def _times(what: str, factor: float, has: str, taken: str) -> str:
    reason = f"({has} taken for {taken})"
    if factor < 1:
        return f"dividing {what} by {1 / factor:.4g} {reason}"
    return f"multiplying {what} by {factor:.4g} {reason}"


def _all_loads_slips(body: MeasuredBody) -> Iterator[Slip]:
    if len(body.loads) < 2:
        return
    yield from _load_slips(body.loads[0], ALL)


def _angle_slips(body: MeasuredBody) -> Iterator[Slip]:
    turned = float(np.ptp(body.angle))

    def slip(
        words: str, kind: str, change: Callable[[FloatArray], FloatArray], rarity: float
    ) -> Slip:
        return Slip(words, kind, None, lambda body: replace(body, angle=change(body.angle)), rarity)

    yield slip(
        "taking the angle as deg (deg taken for rad)",
        "angle unit",
        lambda a: a * pi / 180,
        0.0 if turned > pi else 1.0,
    )
    yield slip(
        "taking the angle as rad (rad taken for deg)",
        "angle unit",
        lambda a: a * 180 / pi,
        0.0 if turned < radians(2 * pi) else 1.0,
    )
    yield slip("reversing the angle (it was counted clockwise)", "angle sign", lambda a: -a, 0.3)
    for turn in (pi, pi / 2, -pi / 2):
        yield slip(
            f"turning the angle by {degrees(turn):g} deg (it was counted from another axis)",
            "angle zero",
            partial(np.add, turn),
            1.0,
        )


def _motion_slips(body: MeasuredBody, gravity: Vector) -> Iterator[Slip]:
    def slip(words: str, kind: str, mend: Mend, rarity: float = 0.5) -> Slip:
        return Slip(words, kind, None, mend, rarity)

    def scaled(*factors: float) -> Mend:
        return lambda b: replace(b, acceleration=b.acceleration * np.array(factors))

    def turning(factor: float) -> Mend:
        return lambda b: replace(b, angular_acceleration=b.angular_acceleration * factor)

    yield slip("reversing the acceleration", "acceleration sign", scaled(-1, -1), 0.3)
    yield slip("reversing the acceleration along x", "acceleration sign", scaled(-1, 1))
    yield slip("reversing the acceleration along y", "acceleration sign", scaled(1, -1))
    yield slip(
        "swapping x and y of the acceleration",
        "acceleration axes",
        lambda b: replace(b, acceleration=b.acceleration[:, ::-1]),
    )
    frame = "ground" if body.acceleration_in_body_frame else "body"
    yield slip(
        f"taking the acceleration as given in the {frame}'s frame",
        "acceleration frame",
        lambda b: replace(b, acceleration_in_body_frame=not b.acceleration_in_body_frame),
        0.3,
    )
    for has, stated, k in (
        ("m/s2", "mm/s2", 1e3), ("mm/s2", "m/s2", _MILLI),
        ("g", "m/s2", 9.80665), ("m/s2", "g", 1 / 9.80665),
    ):  # fmt: skip
        yield replace(
            slip(_times("the acceleration", k, has, stated), "acceleration unit", scaled(k, k)),
            without=scaled(0, 0) if k <= _SMALL else None,
        )
    yield slip("reversing the angular acceleration", "turning sign", turning(-1), 0.3)
    for has, stated, k in (("deg/s2", "rad/s2", radians(1)), ("rad/s2", "deg/s2", degrees(1))):
        yield replace(
            slip(_times("the angular acceleration", k, has, stated), "turning unit", turning(k)),
            without=turning(0) if k <= _SMALL else None,
        )
    for point in body.body.points:
        yield slip(
            f"taking the acceleration as that of {point}, not of the centre of mass",
            "acceleration place",
            _moved_from(point),
        )
    if gravity != (0.0, 0.0):
        yield slip(
            "leaving the weight out (the acceleration has gravity in it already, or the forces "
            "are of a machine without weight)",
            "gravity",
            _with_gravity(gravity, 1.0),
            0.0,
        )
        yield slip(
            "taking gravity out of the acceleration (it has gravity in it, with the wrong sign)",
            "gravity",
            _with_gravity(gravity, -1.0),
            0.5,
        )


def _moved_from(point: str) -> Mend:
    """Return the mend that takes a file's acceleration as a point's and moves it to the centre."""

    def mend(body: MeasuredBody) -> MeasuredBody:
        arm = np.array(body.body.centre, dtype=float) - body.body.place(point)
        ground = np.tile(arm, (len(body.angle), 1))
        if not body.acceleration_in_body_frame:
            ground = rotated(ground, body.angle)
        moved = (
            body.acceleration
            + body.angular_acceleration[:, None] * turned_left(ground)
            - body.angular_velocity[:, None] ** 2 * ground
        )
        return replace(body, acceleration=moved)

    return mend


def _with_gravity(gravity: Vector, factor: float) -> Mend:
    def mend(body: MeasuredBody) -> MeasuredBody:
        added = np.tile(np.array(gravity) * factor, (len(body.angle), 1))
        if body.acceleration_in_body_frame:
            added = rotated(added, -body.angle)
        return replace(body, acceleration=body.acceleration + added)

    return mend


def _mass_slips(body: MeasuredBody, gravity: Vector) -> Iterator[Slip]:
    own = body.body

    def of(mass: float, inertia: float) -> Mend:
        changed = own.with_mass_properties(mass, own.centre, inertia)
        return lambda b: replace(b, body=changed)

    def slip(
        words: str,
        mass: float,
        inertia: float,
        rarity: float,
        without: Mend | None = None,
    ) -> Slip:
        return Slip(words, "mass", None, of(mass, inertia), rarity, without)

    for factor, units in ((_MILLI, "g taken for kg"), (1e3, "kg taken for g, or t for kg")):
        mass = own.mass * factor
        yield slip(
            f"a mass of {mass * 1e3:.4g} kg instead of {own.mass * 1e3:.4g} kg ({units})",
            mass, own.inertia, 0.5, of(0.0, own.inertia) if factor <= _SMALL else None,
        )  # fmt: skip
    for factor, units in (
        (1e-6, "kg mm2 taken for kg m2"), (1e6, "kg m2 taken for kg mm2"),
        (1e-4, "kg cm2 taken for kg m2"), (1e4, "kg m2 taken for kg cm2"),
    ):  # fmt: skip
        inertia = own.inertia * factor
        yield slip(
            f"an inertia of {inertia * _MILLI:.4g} kg m2 instead of "
            f"{own.inertia * _MILLI:.4g} kg m2 ({units})",
            own.mass, inertia, 1.0, of(own.mass, 0.0) if factor <= _SMALL else None,
        )  # fmt: skip
    for point, place in own.points.items():
        apart = (place[0] - own.centre[0]) ** 2 + (place[1] - own.centre[1]) ** 2
        inertia = own.inertia - own.mass * apart
        if apart and inertia > 0:
            yield slip(
                f"taking the inertia as that about {point}, not about the centre of mass",
                own.mass, inertia, 1.0,
            )  # fmt: skip
    yield slip(
        "leaving weight and inertia out (the forces are of a machine without mass)",
        0.0, 0.0, 0.7,
    )  # fmt: skip
