"""The spring hammer: what ballesta finds for the thesis' numbers, and the thesis' own formulae.

The formulae of the thesis stand here with their errors, as its scripts have them: positions are
right, speeds and accelerations come from Jacobians whose inverse has both off-diagonal signs wrong,
and the scripts step by 0.01 rad.
"""

from collections.abc import Callable
from math import exp, hypot, pi, radians, sin, sqrt
from types import SimpleNamespace

import numpy as np
from documents_designs import Floats, crossed, run

TOUCH = 1113.5  # mm, D.y where the dies would touch
FINE = ("cycles.at_5.positions=1441",)
BENDING = 210e3 * 60.0 * 9.6**3 / 12  # N mm2, of one leaf
MODULUS = 60.0 * 9.6**2 / 6  # mm3, of one leaf
RAM, WEIGHT = 39.85e-3, 39.85e-3 * 9800.0  # t, N
R, RAM_LINE, ROCKER = (-202.0, 1250.0), 427.0, 460.0  # mm


def _crank(radius: float) -> tuple[str, ...]:
    """Return the override that sets the crank's radius; C of the design stays where it is."""
    reach = hypot(258.0, 1250.0)
    along = (radius**2 + reach**2 - 1275.0**2) / (2 * reach)
    across = sqrt(radius**2 - along**2)
    x, y = 258.0 / reach, 1250.0 / reach
    return (f"points.B={along * x + across * y:.10f}, {along * y - across * x:.10f} mm",)


def gap(crank: float) -> list[float]:
    """Return the smallest and largest distance of the dies [mm] for a crank radius [mm]."""
    height = run("spring_hammer", "at_5", _crank(crank) + FINE).point("ram", "D")[:, 1]
    return [float(height.min()) - TOUCH, float(height.max()) - TOUCH]


def smallest_gap(crank: float) -> float:
    """Return the smallest distance of the dies [mm]."""
    return gap(crank)[0]


def largest_gap(crank: float) -> float:
    """Return the largest distance of the dies [mm]."""
    return gap(crank)[1]


def torque(speed: int) -> list[float]:
    """Return the range of the drive torque without a workpiece [N m]."""
    drive = run("spring_hammer", f"at_{speed}", FINE).drive("drive")
    return [drive.smallest / 1e3, drive.largest / 1e3]


def idle_mean(speed: int) -> float:
    """Return the mean drive torque without a workpiece [N m]."""
    return run("spring_hammer", f"at_{speed}", FINE).drive("drive").mean_effort / 1e3


def reduced_inertia() -> float:
    """Return the mean reduced inertia at the crank [kg m2], of all bodies."""
    return run("spring_hammer", "at_5", FINE).drive("drive").mean_reduced_mass / 1e3


def least_reduced_inertia() -> float:
    """Return the least reduced inertia at the crank [kg m2]."""
    reduced = run("spring_hammer", "at_5", FINE).drive("drive").reduced_mass
    return float(reduced.min()) / 1e3


def energy_ripple(speed: int) -> float:
    """Return the energy [J] that a constant speed has stored and given back within a turn."""
    ripple = run("spring_hammer", f"at_{speed}", FINE).drive("drive").energy_ripple
    assert ripple is not None
    return ripple / 1e3


def irregularity(speed: int) -> float:
    """Return the irregularity of the speed that this energy would cause without a flywheel."""
    found = run("spring_hammer", f"at_{speed}", FINE).drive("drive").irregularity
    assert found is not None
    return found


def ram_acceleration(speed: int) -> list[float]:
    """Return the range of the ram's acceleration without a workpiece [m/s2]."""
    found = _ram_acceleration(speed)
    return [float(found.min()) / 1e3, float(found.max()) / 1e3]


def _ram_acceleration(speed: int) -> Floats:
    turn = run("spring_hammer", f"at_{speed}", FINE)
    result: Floats = turn.accelerations[:, turn.body_index("ram"), 1]
    return result


def _law(
    height: Floats,
    acceleration: Floats,
    span: Floats | float,
    work: float,
    n: int,
    everywhere: bool = False,
) -> Floats:
    """Return the forging force (6.8) [N] of n leaves of one span [mm] on both sides."""
    deflection = work - (height - TOUCH)
    size = 3.0 * n * deflection * BENDING / (2.0 * span**3) + RAM * (acceleration + 9800.0)
    return np.where(everywhere | (deflection > 0.0), size, 0.0)


def law_force(speed: int, work: float, leaves: int = 3) -> float:
    """Return the largest force of (6.8) [N] on ballesta's motion, its L the distance R-D there."""
    turn = run("spring_hammer", f"at_{speed}", FINE)
    place = turn.point("ram", "D")
    span = np.hypot(place[:, 0] - R[0], place[:, 1] - R[1])
    return float(_law(place[:, 1], _ram_acceleration(speed), span, work, leaves).max())


def law_mean_torque(speed: int, work: float, leaves: int = 3) -> float:
    """Return the mean drive torque with (6.8) on ballesta's motion [N m], by its work."""
    turn = run("spring_hammer", f"at_{speed}", FINE)
    place = turn.point("ram", "D")
    span = np.hypot(place[:, 0] - R[0], place[:, 1] - R[1])
    # as if it pushed everywhere, over the way below the touch: nothing is lost at its jump
    force = _law(place[:, 1], _ram_acceleration(speed), span, work, leaves, everywhere=True)
    depth = place[:, 1] - TOUCH - work
    k = np.flatnonzero(depth[1:] * depth[:-1] < 0.0)
    steps = np.arange(float(len(depth)))
    all_steps = np.sort(np.concatenate([steps, k + depth[k] / (depth[k] - depth[k + 1])]))
    force = np.interp(all_steps, steps, force)
    way = np.diff(np.minimum(np.interp(all_steps, steps, depth), 0.0))
    work_done = float(np.sum(0.5 * (force[:-1] + force[1:]) * way))
    return idle_mean(speed) - work_done / (2 * pi) / 1e3


def law_stress(speed: int, work: float, leaves: int = 3) -> float:
    """Return the largest bending stress at R by the workpiece, (6.8) on ballesta's motion [MPa]."""
    turn = run("spring_hammer", f"at_{speed}", FINE)
    place = turn.point("ram", "D")
    span = np.hypot(place[:, 0] - R[0], place[:, 1] - R[1])
    acceleration = _ram_acceleration(speed)
    force = _law(place[:, 1], acceleration, span, work, leaves)
    normal = (force - RAM * (acceleration + 9800.0)) * span / RAM_LINE  # over cos of the leaf
    return float((normal * span).max()) / (leaves * MODULUS)


def _pressed(speed: int, work: float, leaves: int) -> tuple[str, tuple[str, ...]]:
    bending = leaves * BENDING / 1e6
    return f"at_{speed}_work_{work:g}", (f"bodies.rocker.elastic.bending={bending:.10g} N m2",)


def contact_force(speed: int, work: float, leaves: int = 3) -> float:
    """Return the largest force of ballesta's contact on a rigid workpiece [N]."""
    cycle, leaf = _pressed(speed, work, leaves)
    return float(run("spring_hammer", cycle, leaf).efforts["workpiece"].max())


def contact_mean_torque(speed: int, work: float) -> float:
    """Return the mean drive torque with ballesta's contact [N m]."""
    return run("spring_hammer", f"at_{speed}_work_{work:g}").drive("drive").mean_effort / 1e3


def law_rise(work: float) -> float:
    """Return how much the force of (6.8) rises from 3 to 6 rad/s on ballesta's motion [N]."""
    return law_force(6, work) - law_force(3, work)


def contact_rise(work: float) -> float:
    """Return how much the force of ballesta's contact rises from 3 to 6 rad/s [N]."""
    return contact_force(6, work) - contact_force(3, work)


def _stress(cycle: str, overrides: tuple[str, ...], leaves: int) -> Floats:
    turn = run("spring_hammer", cycle, overrides)
    arm = turn.point("ram", "D") - np.array(R)
    moment = crossed(arm, -turn.reactions["slot"].force)
    return moment / (leaves * MODULUS)


def stress(speed: int) -> list[float]:
    """Return the range of the bending stress left of R without a workpiece [MPa]."""
    found = _stress(f"at_{speed}", FINE, 3)
    return [float(found.min()), float(found.max())]


def contact_stress(speed: int, work: float, leaves: int = 3) -> float:
    """Return the largest bending stress at R by the workpiece, ballesta's contact [MPa]."""
    return float(-_stress(*_pressed(speed, work, leaves), leaves).min())


def contact_stress_range(speed: int, work: float) -> float:
    """Return how far the bending stress at R goes over a turn [MPa], ballesta's contact."""
    return float(np.ptp(_stress(*_pressed(speed, work, 3), 3)))


# -- the thesis' own formulae, errors included


def _script(speed: float) -> SimpleNamespace:
    """Return one turn as the scripts compute it: 0.01 rad apart, their Jacobians, SI."""
    l1, l2, l3, left, up, r = 0.135, 1.275, 0.46, 0.202, 1.25, 0.427
    one = np.arange(0.0, 2.0 * pi, 0.01)
    x, y = l1 * np.cos(one), l1 * np.sin(one)
    reach = np.hypot(-left - x, up - y)
    two = np.arctan2(up - y, -left - x) - np.arccos((reach**2 + l2**2 - l3**2) / (2 * reach * l2))
    end_x, end_y = x + l2 * np.cos(two), y + l2 * np.sin(two)
    three = np.arctan2(up - end_y, -left - end_x) % (2 * pi)
    between = np.sin(three - two)
    rod = l1 * np.sin(one + three) * speed / (l2 * between)  # right: one - three
    rocker = l1 * np.sin(two + one) * speed / (l3 * between)  # right: two - one
    pull_x = (
        l1 * np.cos(one) * speed**2 + l2 * np.cos(two) * rod**2 + l3 * np.cos(three) * rocker**2
    )
    pull_y = (
        l1 * np.sin(one) * speed**2 + l2 * np.sin(two) * rod**2 + l3 * np.sin(three) * rocker**2
    )
    # right: + l3 sin(three) pull_y and - l2 cos(two) pull_x
    rod_alpha = (l3 * np.cos(three) * pull_x - l3 * np.sin(three) * pull_y) / (l2 * l3 * between)
    rocker_alpha = (l2 * np.cos(two) * pull_x - l2 * np.sin(two) * pull_y) / (l2 * l3 * between)
    span = -r / np.cos(three)
    ram = span * np.cos(2 * three) / np.cos(three) * rocker  # right: without cos(2 three)
    slide = span * np.tan(three) * rocker
    first = (
        -span * np.sin(three) * rocker_alpha
        - 2 * slide * np.sin(three) * rocker
        - span * np.cos(three) * rocker**2
    )
    second = (
        span * np.cos(three) * rocker_alpha
        + 2 * slide * np.cos(three) * rocker
        - span * np.sin(three) * rocker**2
    )
    ram_acceleration = np.tan(three) * first + second  # right: second - tan(three) first
    rod_lift = l1 * speed * np.cos(one) + l2 / 2 * rod * np.cos(two)
    rod_drift = -l1 * speed * np.sin(one) - l2 / 2 * rod * np.sin(two)
    # the rod's centre accelerates only across the rod: neither crank pin nor centripetal part
    rod_power = 1.467 * (
        l2 / 2 * rod_alpha * (np.cos(two) * rod_lift - np.sin(two) * rod_drift) + 9.8 * rod_lift
    )
    ram_weight = 39.85 * (ram_acceleration + 9.8)
    power = rod_power + 0.224 * rod_alpha * rod + 0.995 * rocker_alpha * rocker + ram_weight * ram
    return SimpleNamespace(
        height=(up - r * np.tan(three)) * 1e3,
        tilt=three - pi,
        span=span * 1e3,
        frozen=float(span[-1]) * 1e3,
        ram=ram,
        ram_acceleration=ram_acceleration * 1e3,
        rocker=rocker,
        lumped=0.995 * rocker_alpha * 1e3,
        power=power,
        speed=speed,
    )


def torque_formula(speed: float) -> list[float]:
    """Return the range of the script's torque without a workpiece [N m]."""
    turn = _script(speed)
    return [float((turn.power / speed).min()), float((turn.power / speed).max())]


def idle_mean_formula(speed: float) -> float:
    """Return the mean of the script's torque without a workpiece [N m]."""
    return float((_script(speed).power / speed).mean())


def _script_force(turn: SimpleNamespace, work: float, leaves: int) -> Floats:
    return _law(turn.height, turn.ram_acceleration, turn.frozen, work, leaves)


def force_formula(speed: float, work: float, leaves: int = 3) -> float:
    """Return the largest force of the script [N]: (6.8) with L of the last position throughout."""
    return float(_script_force(_script(speed), work, leaves).max())


def rise_formula(work: float) -> float:
    """Return how much the script's force rises from 3 to 6 rad/s [N]."""
    return force_formula(6, work) - force_formula(3, work)


def mean_torque_formula(speed: float, work: float, leaves: int = 3) -> float:
    """Return the script's mean torque with a workpiece [N m]."""
    turn = _script(speed)
    return float(((turn.power - _script_force(turn, work, leaves) * turn.ram) / speed).mean())


def _script_stress(
    speed: float, work: float, leaves: int, couple: Callable[[SimpleNamespace], Floats | float]
) -> Floats:
    turn = _script(speed)
    load = RAM * (turn.ram_acceleration + 9800.0)
    normal = (_script_force(turn, work, leaves) - load) / np.cos(turn.tilt)
    stress: Floats = (normal * turn.span + couple(turn)) / (leaves * MODULUS)
    return stress


def stress_formula(speed: float) -> list[float]:
    """Return the range of the script's stress at R without a workpiece, bent down [MPa]."""
    found = -_script_stress(speed, -1.0, 3, lambda turn: turn.lumped)
    return [float(found.min()), float(found.max())]


def contact_stress_formula(speed: float, work: float, leaves: int = 3) -> float:
    """Return the largest stress at R by the workpiece in the script [MPa].

    The leaves' angular acceleration is frozen at the last position, as the span in the force.
    """
    return float(_script_stress(speed, work, leaves, lambda turn: turn.lumped[-1]).max())


def energy_ripple_formula(speed: float) -> float:
    """Return the mean size of the script's torque times the speed: a power [W], no energy."""
    return float(np.abs(_script(speed).power).mean())


def ram_acceleration_formula(speed: float) -> list[float]:
    """Return the range of the script's acceleration of the ram [m/s2]."""
    found = _script(speed).ram_acceleration / 1e3
    return [float(found.min()), float(found.max())]


def reduced_inertia_formula() -> float:
    """Return the mean of (8.5) [kg m2]: pulley, leaves and ram with the script's speeds."""
    turn = _script(1.0)
    return float((0.293 + 0.995 * turn.rocker**2 + 39.85 * turn.ram**2).mean())


# -- by hand


def upset_force() -> float:
    """Return Kf Y A [N] with friction and the diameter that belongs to the area (3.2)-(3.7)."""
    diameter = sqrt(4.0 * 1000.0 / pi)
    return (1.0 + 0.4 * 0.18 * diameter / 10.0) * 16.5 * 1000.0


def upset_force_formula() -> float:
    """Return Y A [N], Kf = 1."""
    return 16.5 * 1000.0


def pivot_inertia() -> float:
    """Return the leaves' inertia about R [kg m2], parallel axis."""
    return 14.623 * 0.0539**2 + 0.952


def slack_side(torque: float) -> float:
    """Return the slack-side tension [N] for a torque of the large pulley [N m], V-belt 40 deg."""
    return torque / 0.15975 / (exp(0.3 / sin(radians(20.0)) * 2.596) - 1.0)


def slack_side_formula(torque: float) -> float:
    """Return the same with the torque of the small pulley on the radius of the large one."""
    return slack_side(torque * 90.5 / 319.5)
