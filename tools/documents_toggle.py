"""The toggle press: what ballesta finds for the thesis' motion and forces, and its spreadsheet."""

from collections.abc import Callable, Sequence
from functools import cache
from math import acos, atan2, cos, degrees, hypot, radians, sin

import numpy as np
from documents_designs import Floats, design

import loads
from ballesta.machine.solved_cycles import linkage_of

# the thesis' bars: mass [t], centre and inertia [t mm2], slender
BAR = (4.14134e-3, (125.0, 0.0), 21.56947917)
MASSES = {"lower": BAR, "upper": BAR}
HEIGHT, BAR_LENGTH, BASE = 500.0, 250.0, 350.0
CYLINDER_SPEED = 100.0  # mm/s
KNEE_SPEED = 116.8  # mm/s, the thesis takes one for all positions
BAR_WEIGHT, MOULD_WEIGHT = 1.5 * 4.14134 * 9.81, 1.5 * 10.0 * 9.81  # N, with its factor


@cache
def _path(name: str, rear: float) -> tuple[loads.Path, loads.Coordinate]:
    """Return the press's positions nearly from folded to straight, and its cylinder's length."""
    changes = () if rear == BASE else (f"points.D={-rear:g}, 250 mm",)
    found = design(name, changes)
    stated = found.cycles["capacity"]
    height = stated.run.coordinate
    path = loads.trace(linkage_of(found, MASSES, stated), height, 5.0, 499.5)
    return path, stated.run.pace.coordinate


def _at(
    x: Sequence[float], pull: float = 11000.0, name: str = "toggle_press", rear: float = BASE
) -> tuple[loads.Motion, loads.ForceSolution]:
    """Return motion and forces at distances x from the dead centre [mm], the press closing."""
    path, cylinder = _path(name, rear)
    heights = HEIGHT - np.array(x, dtype=float)
    motion = loads.move(path.at(heights), cylinder, CYLINDER_SPEED, 1)
    return motion, loads.solve_forces(motion, {"cylinder": pull}, "process")


def press_force(x: float, pull: float = 11000.0, rear: float = BASE) -> float:
    """Return the press force [N] at x [mm] under a pull of the cylinder [N]."""
    return float(_at([x], pull, rear=rear)[1].efforts["process"][0])


def press_force_with_friction(x: float) -> float:
    """Return the press force [N] with coefficient 0.1 on the pins of 40 mm and the guide."""
    return float(_at([x], name="toggle_press_friction")[1].efforts["process"][0])


def _reach(force: float, press: Callable[[float], float]) -> float:
    low, high = 2.0, 20.0
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if press(middle) >= force else (low, middle)
    return low


def reach_with_friction(force: float) -> float:
    """Return x [mm] at which the press force with friction reaches a value [N]."""
    return _reach(force, press_force_with_friction)


def reach_formula(force: float) -> float:
    """Return x [mm] at which the spreadsheet's press force reaches a value [N]."""
    return _reach(force, press_force_formula)


def _tilt(x: float) -> float:
    return acos(1.0 - x / HEIGHT)


def _slope(x: float) -> float:
    return atan2(x / 2.0, BASE + BAR_LENGTH * sin(_tilt(x)))


def _centre_speed(x: float) -> float:
    """Return the thesis' speed of the upper bar's centre [mm/s], about the bar's pole."""
    half = BAR_LENGTH / 2.0
    return KNEE_SPEED * hypot(3.0 * sin(_tilt(x)) * half, cos(_tilt(x)) * half) / BAR_LENGTH


def weight_lower_formula(x: Sequence[float]) -> list[float]:
    """Return 1.5 m2 g v_G2 cos(90 deg + gamma) of the spreadsheet [W]."""
    return [-BAR_WEIGHT * KNEE_SPEED / 2e3 * sin(_tilt(value)) for value in x]


def weight_upper_formula(x: Sequence[float]) -> list[float]:
    """Return 1.5 m3 g v_G3 cos(180 deg - gamma) of the spreadsheet [W]."""
    return [-BAR_WEIGHT * _centre_speed(value) / 1e3 * cos(_tilt(value)) for value in x]


def press_force_formula(x: float, pull: float = 11000.0) -> float:
    """Return the spreadsheet's press force [N]: weights' powers [W] added to the pull [N]."""
    drive = pull + weight_lower_formula([x])[0] + weight_upper_formula([x])[0]
    return drive * cos(_tilt(x) - _slope(x)) / (2.0 * sin(_tilt(x))) - MOULD_WEIGHT


def press_forces(x: Sequence[float]) -> list[float]:
    """Return the press force [N] at several x [mm] under 11 kN."""
    return [press_force(value) for value in x]


def press_forces_formula(x: Sequence[float]) -> list[float]:
    """Return the spreadsheet's press force [N] at several x [mm]."""
    return [press_force_formula(value) for value in x]


def _rate(body: str, x: Sequence[float], way: float = 0.0) -> Floats:
    """Return the velocity (n, 2) [mm/s] of the point `way` along a body's x axis."""
    motion, _ = _at(x)
    row = motion.kinematics.index[body]
    angle, spin = motion.poses[:, row, 2], motion.velocities[:, row, 2:]
    rate: Floats = motion.velocities[:, row, :2] + way * spin * np.stack(
        [-np.sin(angle), np.cos(angle)], axis=1
    )
    return rate


def _size(rate: Floats) -> list[float]:
    return [float(value) / 1e3 for value in np.linalg.norm(rate, axis=1)]


def knee_speed(x: Sequence[float]) -> list[float]:
    """Return the speed of B [m/s] with the cylinder at 0.1 m/s."""
    return _size(_rate("upper", x))


def lower_centre_speed(x: Sequence[float]) -> list[float]:
    """Return the speed of the lower bar's centre [m/s]."""
    return _size(_rate("lower", x, 125.0))


def upper_centre_speed(x: Sequence[float]) -> list[float]:
    """Return the speed of the upper bar's centre [m/s]."""
    return _size(_rate("upper", x, 125.0))


def mould_speed(x: Sequence[float]) -> list[float]:
    """Return the speed of the mould [m/s]."""
    return _size(_rate("mould", x))


def mould_speed_formula(x: Sequence[float]) -> list[float]:
    """Return 2 v_B sin gamma [m/s] with the thesis' one v_B."""
    return [2.0 * KNEE_SPEED / 1e3 * sin(_tilt(value)) for value in x]


def mould_speed_half(x: Sequence[float]) -> list[float]:
    """Return v_B sin gamma [m/s]: with half the distance from A to the bar's pole."""
    return [value / 2.0 for value in mould_speed_formula(x)]


def upper_centre_speed_formula(x: Sequence[float]) -> list[float]:
    """Return the speed of the upper bar's centre [m/s] with the thesis' one v_B."""
    return [_centre_speed(value) / 1e3 for value in x]


def bar_speed(x: Sequence[float]) -> list[float]:
    """Return the angular speed of the bars [rad/s]."""
    motion, _ = _at(x)
    return [abs(float(v)) for v in motion.velocities[:, motion.kinematics.index["lower"], 2]]


def weight_lower(x: Sequence[float]) -> list[float]:
    """Return the power of the lower bar's weight [W]."""
    return [-4.14134 * 9.81 * float(v) / 1e3 for v in _rate("lower", x, 125.0)[:, 1]]


def weight_upper(x: Sequence[float]) -> list[float]:
    """Return the power of the upper bar's weight [W]."""
    return [-4.14134 * 9.81 * float(v) / 1e3 for v in _rate("upper", x, 125.0)[:, 1]]


def tilt(x: Sequence[float]) -> list[float]:
    """Return the angle of the bars from the vertical [deg]."""
    motion, _ = _at(x)
    return [90.0 - degrees(float(v)) for v in motion.poses[:, motion.kinematics.index["lower"], 2]]


def _knee(x: Sequence[float]) -> Floats:
    motion, _ = _at(x)
    return motion.kinematics.point(motion.poses, "lower", "B")


def offset(x: Sequence[float]) -> list[float]:
    """Return the horizontal offset of the knee [m]."""
    return [float(value) / 1e3 for value in _knee(x)[:, 0]]


def cylinder_slope(x: Sequence[float]) -> list[float]:
    """Return how far the cylinder is from level [deg]."""
    return [degrees(atan2(250.0 - y, px + BASE)) for px, y in _knee(x).tolist()]


def cylinder_length(x: Sequence[float]) -> list[float]:
    """Return the distance of the cylinder's pins [m]."""
    return [hypot(250.0 - y, px + BASE) / 1e3 for px, y in _knee(x).tolist()]


def pole_distance(x: Sequence[float]) -> list[float]:
    """Return the distance from A to the pole of the upper bar [m]: mould speed over bar speed."""
    return [v / w for v, w in zip(mould_speed(x), bar_speed(x), strict=True)]


def pole_distance_half(x: Sequence[float]) -> list[float]:
    """Return half of 2 a [m]."""
    return offset(x)


def centre_pole_distance(x: Sequence[float]) -> list[float]:
    """Return the distance from the upper bar's centre to its pole [m]."""
    return [v / w for v, w in zip(upper_centre_speed(x), bar_speed(x), strict=True)]


def cylinder_force(x: float) -> list[float]:
    """Return the components of 11 kN along the cylinder [N]: level and upright."""
    slope = radians(cylinder_slope([x])[0])
    return [11000.0 * cos(slope), 11000.0 * sin(slope)]


def support(joint: str, x: float) -> list[float]:
    """Return the sizes of the components of a joint's force [N]: level and upright."""
    force = _at([x])[1].joints[joint].force[0]
    return [abs(float(force[0])), abs(float(force[1]))]


def guide_force(x: float) -> float:
    """Return the force on the guide [N]."""
    return support("guide:mould", x)[0]


def bar_force(body: str, x: float) -> float:
    """Return the compression [N] of a bar at its outer end."""
    motion, solution = _at([x])
    angle = float(motion.poses[0, motion.kinematics.index[body], 2])
    along = np.array([cos(angle), sin(angle)])
    force = solution.joints["C" if body == "lower" else "A"].force[0]
    return float(force @ along)


def _statics() -> tuple[Floats, Floats]:
    """Return the thesis' forces on guide and foot at x = 2 mm [N]: no weights, rounded angles."""
    level, upright = 11e3 * cos(radians(0.15)), 11e3 * sin(radians(0.15))
    guide = level / 2.0 + upright * 0.02 / 0.4979
    return np.array([guide, 61152.0]), np.array([level - guide, 61152.0 - upright])


def bar_force_formula(body: str) -> float:
    """Return a bar's compression [N] at x = 2 mm by the thesis' statics."""
    upper, lower = _statics()
    return float(np.hypot(*(lower if body == "lower" else upper)))


def cylinder_force_formula() -> list[float]:
    """Return the components of 11 kN along the cylinder [N], its slope rounded to 0.15 deg."""
    return [11e3 * cos(radians(0.15)), 11e3 * sin(radians(0.15))]


def guide_force_formula() -> float:
    """Return the thesis' force on the guide [N]."""
    return float(_statics()[0][0])


def foot_formula() -> list[float]:
    """Return the thesis' force on the lower pivot [N]: level and upright."""
    return [float(value) for value in _statics()[1]]


def stroke_time() -> float:
    """Return how long a stroke and its return take [s]."""
    found = design("toggle_press")
    stated = found.cycles["press"]
    turn = loads.run_cycle(linkage_of(found, MASSES, stated), stated.run)
    return float(turn.times[-1])


def cylinder_stroke() -> float:
    """Return the cylinder's way from x = 200 mm to straight bars [mm]."""
    return cylinder_length([200.0])[0] * 1e3 - BASE


def retracting_force() -> float:
    """Return what a cylinder of bore 160 and rod 40 pulls with at 0.6 MPa [N]."""
    return _cylinder()[0]


def extending_force() -> float:
    """Return what the same cylinder pushes with [N]."""
    return _cylinder()[1]


def _cylinder() -> tuple[float, float]:
    key = 'forces.cylinder.available={ bore = "160 mm", rod = "40 mm", pressure = "0.6 MPa" }'
    pull, push = design("toggle_press", (key,)).available["cylinder"]
    return abs(pull), abs(push)


def cylinder_areas() -> list[float]:
    """Return the areas of that cylinder [mm2]: extending and retracting."""
    return [extending_force() / 0.6, retracting_force() / 0.6]


def bore_area() -> float:
    """Return the piston area [mm2] that pulls 11 kN at 0.6 MPa, without the rod's."""
    return 11000.0 / 0.6


def force_pulled_through(touch: float) -> float:
    """Return the largest press force [N] if 11 kN pull the knee through; contact at x [mm]."""
    found = design("toggle_press")
    linkage = linkage_of(found, MASSES, found.cycles["capacity"])
    result = loads.pull_through(linkage, "cylinder", 11000.0, "process", touch - HEIGHT)
    assert result is not None
    return result.force


def pin_moment(x: float) -> float:
    """Return the moment in the middle of the pin at B [N mm], its seats as in the design."""
    _, solution = _at([x])
    upper = -solution.joints["B"].force[0]  # of the upper bar on the pin
    slope = radians(cylinder_slope([x])[0])
    pull = 11000.0 * np.array([-cos(slope), sin(slope)])
    lower = -upper - pull
    moment = 0.5 * (42.95 * upper + 32.65 * lower)
    # half of the rod eye, 43 mm wide
    moment += 0.5 * pull * 43.0 / 4.0
    return float(np.hypot(*moment))
