"""The gallery's machines against a hand calculation each: two joint forces and one stress.

Every value comes from a closed form with the numbers of the design's own comments; nothing of the
rooms is used for it. Accelerations are second differences of closed positions. What a hand
calculation leaves out, such as the weight of a link, stands beside its tolerance.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from ballesta.design.read import read_design
from ballesta.pipeline import check_design
from checks.design.effort import Effort
from checks.result.verdict import DesignResult

from ..lighter import buckling_of_no_linkage, without_fatigue

GALLERY = Path(__file__).parents[2] / "designs" / "gallery"
G = 9.81  # m/s2
RPM = 2 * np.pi / 60


@dataclass(frozen=True)
class Value:
    """A value that the tool gives, and the hand calculation's, which the design's comment tells."""

    what: str
    tool: float
    hand: float
    tolerance: float
    unit: str = "N"

    @property
    def told(self) -> str:
        """The hand calculation's value as the design tells it."""
        return (
            f"{self.hand:.4g} {self.unit}"
            if self.hand < 9999
            else f"{self.hand / 1e3:.4g} k{self.unit}"
        )


class Machine:
    """What the tool finds by formulas without fatigue; loads do not depend on the rung."""

    def __init__(self, name: str) -> None:
        design = without_fatigue(read_design(GALLERY / f"{name}.toml"))
        with buckling_of_no_linkage():
            self.result: DesignResult = check_design(design, effort=Effort("formula"))
        (self.cycle,) = self.result.cycles.values()

    def nearest(self, position: float) -> int:
        """Index of the position next to one of the shown coordinate."""
        found = int(np.abs(np.array(self.cycle["position"]) - position).argmin())
        assert abs(self.cycle["position"][found] - position) < 1e-3, "no such position"
        return found

    def force(self, link: str, at: float | int) -> float:
        """Resultant [N] at an interface: at a position, or at an index of the cycle."""
        k = at if isinstance(at, int) else self.nearest(at)
        return self.cycle["links"][link][k]

    def effort(self, name: str, at: float) -> float:
        """Force [N] or torque [N mm] at a position."""
        of = self.cycle["efforts"] | self.cycle["torques"]
        return of[name][self.nearest(at)]

    def check(self, part: str, kind: str, quantity: str = "") -> float:
        """Value of a part's check of a kind whose quantity begins so."""
        (found,) = (p for p in self.result.parts if p.name == part)
        (value,) = (
            c.value for c in found.checks if c.kind == kind and c.quantity.startswith(quantity)
        )
        return value

    def largest(self, link: str) -> int:
        """Index of the position at which an interface carries most."""
        return int(np.argmax(self.cycle["links"][link]))

    def at(self, k: int) -> float:
        """The shown coordinate at an index of the cycle."""
        return self.cycle["position"][k]


def second_difference(of: Callable[[float], np.ndarray], theta: float, speed: float) -> np.ndarray:
    """Acceleration of a position (or angle) that depends on an angle turning at constant speed."""
    h = 1e-4
    return (of(theta + h) - 2 * of(theta) + of(theta - h)) / h**2 * speed**2


def masses_of_plate(length, width, thickness, hole, second_hole, density=7.85e-6):
    """Mass [kg], its centre's x [mm] and inertia about it [kg mm2] of a plate with round ends."""
    r = width / 2
    bar = np.array([length * width, length / 2, length * width * (length**2 + width**2) / 12])
    half, lever = np.pi * r**2 / 2, 4 * r / (3 * np.pi)
    own = half * (r**2 / 2 - lever**2)
    pieces = [bar, np.array([half, -lever, own]), np.array([half, length + lever, own])]
    for x, d in ((0.0, hole), (length, second_hole)):
        pieces.append(np.array([-np.pi * d**2 / 4, x, -np.pi * d**4 / 32]))
    area = sum(p[0] for p in pieces)
    centre = sum(p[0] * p[1] for p in pieces) / area
    polar = sum(p[2] + p[0] * (p[1] - centre) ** 2 for p in pieces)
    return density * thickness * area, centre, density * thickness * polar


def mass_of_solid_rod(length, diameter, eye_diameter, eye_width, hole, density=7.85e-6):
    """Mass [kg] of a round rod between two balls with flats and holes, without its fillets."""
    ball, half = eye_diameter / 2, eye_width / 2
    eye = 2 * np.pi * (ball**2 * half - half**3 / 3) - np.pi * hole**2 / 4 * eye_width
    between = length - 2 * np.sqrt(ball**2 - diameter**2 / 4)
    return density * (2 * eye + np.pi * diameter**2 / 4 * between)


def pin_bending(force, arm, middle, diameter):
    """Stress [MPa] of a pin whose lug in the middle pulls against two others, `arm` apart.

    They press evenly; half of the middle one's width stands a quarter of it beside the middle.
    """
    return 32 * (force / 2 * (arm - middle / 4)) / (np.pi * diameter**3)


def gas_engine(m):
    r, b, w = 0.06, 0.24, 1800 * RPM
    inner = w**2 * r * (1 + r / b)  # acceleration of the piston at the dead centre of ignition
    gudgeon = 9440 - 1.2 * (inner - G)
    rod = mass_of_solid_rod(240, 14, 34, 26, 20)
    crank = gudgeon - rod * ((inner + w**2 * r) / 2 - G)
    area, angle = np.pi * 80**2 / 4, np.radians(43.5)
    piston = 0.8 * area - 1.2 * (w**2 * r * (np.cos(angle) + r / b * np.cos(2 * angle)) - G)
    thrust = piston / np.cos(np.arcsin(r / b * np.sin(angle)))
    assert thrust == pytest.approx(2171, rel=0.01)  # as the example has it
    bending = pin_bending(gudgeon, 22, 26, 20)
    screw = (1.2 * (inner - G) + rod * ((inner + w**2 * r) / 2 - G)) / 2  # exhaust: no pressure
    return [
        Value("screw of the cap at exhaust", m.check("rod", "bolts", "opening"), screw, 1e-3),
        Value("gudgeon pin at ignition", m.force("rod second", 0), gudgeon, 1e-4),
        Value("crank pin at ignition", m.force("rod first", 0), crank, 0.01),
        # the rod's own mass pushes it aside
        Value("thrust of the example", m.force("rod second", 133.5), thrust, 0.02),
        Value("gudgeon pin", m.check("gudgeon_pin", "pin bending"), bending, 1e-4, "MPa"),
    ]


def air_compressor(m):
    r, b, w = 41.402, 144.907, 1500 * RPM
    theta = np.radians(417.2 - 90)  # from the upper dead centre, where delivery begins
    small, big = 0.9072 / 3, 0.9072 * 2 / 3  # the rod is two masses

    def height(t):
        return r * np.cos(t) + np.sqrt(b**2 - (r * np.sin(t)) ** 2)

    up = second_difference(height, theta, w) / 1e3 + G
    from_crank = np.array([r * np.sin(theta), height(theta) - r * np.cos(theta)]) / b
    piston = 4002 + 0.4536 * up
    thrust = (piston + small * up) / from_crank[1]
    gudgeon = np.hypot(piston, thrust * from_crank[0])
    inward = r / 1e3 * w**2 * np.array([np.sin(theta), -np.cos(theta)])
    crank = np.hypot(*(thrust * from_crank + big * (inward + np.array([0, G]))))
    pressure = gudgeon / (14 * 6)
    return [
        Value("gudgeon pin", m.force("rod second", 417.2), gudgeon, 1e-4),
        Value("crank pin", m.force("rod first", 417.2), crank, 1e-4),
        Value("small end", m.check("rod", "bearing"), pressure, 1e-4, "MPa"),
    ]


def crank_rocker(m):
    a, b, c, d = 40.0, 150.0, 80.0, 150.0

    def coupler(degrees):
        """Force of the coupler and torque of the crank for 100 N m on the rocker, no masses."""
        crank_pin = a * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        x, y = crank_pin - [d, 0]
        far = np.hypot(x, y)
        turn = np.arctan2(y, x) - np.arccos((c**2 + far**2 - b**2) / (2 * c * far))
        arm = c * np.array([np.cos(turn), np.sin(turn)])
        u = (arm - [x, y]) / b
        force = 1e5 / abs(arm[0] * u[1] - arm[1] * u[0])
        return force, force * abs(crank_pin[0] * u[1] - crank_pin[1] * u[0]) / 1e3

    left, worst = m.largest("coupler first"), m.largest("coupler second")
    bending = pin_bending(coupler(m.at(worst))[0], 9, 6, 10)
    k = 100
    return [  # the links' masses, below 0.3 kg each, add some newtons
        Value("coupler", m.force("coupler second", worst), coupler(m.at(worst))[0], 0.01),
        Value("motor", abs(m.cycle["torques"]["motor"][k]) / 1e3, coupler(m.at(k))[1], 0.01, "N m"),
        Value("coupler's other end", m.force("coupler first", left), coupler(m.at(left))[0], 0.01),
        Value("pin at the rocker", m.check("pin_C", "pin bending"), bending, 0.01, "MPa"),
    ]


def shaper(m):
    w = 60 * RPM

    def ram(t):
        lever = np.arctan2(75 * np.cos(t), 200 + 75 * np.sin(t))
        return 360 * np.sin(lever) - np.sqrt(100**2 - (350 - 360 * np.cos(lever)) ** 2)

    k = int(np.abs(np.array(m.cycle["position"]) - 90).argmin())
    theta = np.radians(m.at(k))
    along = 2500 - 40 * second_difference(ram, theta, w) / 1e3  # what the link gives the ram
    link = along / np.cos(np.arcsin(10 / 100))
    slot = along * 360 / 275  # moments about the lever's pivot, the lever upright
    return [  # the link has 0.3 kg; the lever is upright within 0.3 deg
        Value("link", m.force("link first", k), link, 0.005),
        Value("block in the slot", m.force("lever slot", k), slot, 0.005),
        Value("link's bearing", m.check("link", "bearing"), link / (20 * 10), 0.06, "MPa"),
    ]


def scissors_jack(m):
    slope = np.radians(30)
    load = 1960 + 0.3 * G
    weight = masses_of_plate(200, 22, 7.5, 10, 10)[0] * G
    top = np.hypot(load / 2, (load + weight) / 2 / np.tan(slope))
    screw = (load + 2 * weight) / np.tan(slope)  # virtual work: C and D rise half as fast as B
    column = (load + 3 * weight) / (2 * np.sin(slope)) / (22 * 7.5)
    return [
        Value("upper link at the saddle", m.force("upper_left first", 0), top, 1e-4),
        Value("screw", m.effort("screw", 200.0), screw, 1e-4),
        Value("lower link", m.check("lower_left", "buckling", "column in"), column, 0.003, "MPa"),
    ]


def punching_press(m):
    def pitman(angle):
        return (835700 - 150 * G) / np.cos(np.arcsin(50 / 400 * np.sin(np.radians(angle - 90))))

    begins, ends = pitman(201.959), pitman(254.6604)
    at_end = m.cycle["phase"].index("up") - 1
    assert m.at(at_end) > 254.6
    while m.cycle["phase"][at_end] != "punch":
        at_end -= 1
    bending = pin_bending(begins, 115, 140, 110)
    return [  # nothing moves fast
        Value(
            "pitman, punch meets plate",
            m.force("pitman second", m.largest("pitman second")),
            begins,
            1e-4,
        ),
        Value("pitman, punch through", m.force("pitman second", at_end), ends, 1e-4),
        Value("pin in the ram", m.check("pin_B", "pin bending"), bending, 1e-4, "MPa"),
    ]


def steam_engine(m):
    r, b, w = 0.4, 1.6, 200 * RPM
    rod = mass_of_solid_rod(1600, 45, 110, 60, 60)
    inner = w**2 * r * (1 + r / b)
    crosshead = np.hypot(160 * inner, rod * G / 2)  # at the dead centre, where there is no steam
    crank = np.hypot(160 * inner + rod * (inner + w**2 * r) / 2, rod * G / 2)
    # 10 deg before it: 18 kN of steam against the crosshead
    angle = np.radians(10)
    inner = w**2 * r * (np.cos(angle) + r / b * np.cos(2 * angle))
    along = 18000 + 160 * inner + rod * (inner + w**2 * r * np.cos(angle)) / 2
    pressure = along / np.cos(np.arcsin(r / b * np.sin(angle))) / (60 * 60)
    return [
        Value("crosshead at the dead centre", m.force("rod second", 0), crosshead, 1e-3),
        Value("crank pin at the dead centre", m.force("rod first", 0), crank, 2e-3),
        Value("big end", m.check("rod", "bearing"), pressure, 3e-3, "MPa"),
    ]


def push_pull_clamp(m):
    link = 4300 / np.cos(np.radians(2))
    hand = link * 40 * np.sin(np.radians(4)) / 1e3
    bending = pin_bending(link, 6, 6, 8)
    return [  # handle and plunger have less than 4 N of weight
        Value("link", m.force("link second", m.largest("link second")), link, 1e-3),
        Value("hand", abs(m.effort("hand", 2.0)) / 1e3, hand, 0.02, "N m"),
        Value("pin", m.check("pin_A", "pin bending"), bending, 1e-3, "MPa"),
    ]


def yoke_actuator(m):
    normal = 1e6 / np.hypot(100, 100)
    # Hertz, a roller on a flat of the same steel
    line = normal / 36 * (210e3 / (2 * (1 - 0.3**2))) / (np.pi * 14.9)
    return [  # the yoke of 2.5 kg has its weight below 25 N
        Value("roller", m.force("yoke slot", -100.0), normal, 0.005),
        Value("air", m.effort("air", -100.0), normal * np.cos(np.pi / 4), 0.005),
        Value("roller on the slot", m.check("yoke", "contact"), np.sqrt(line), 0.003, "MPa"),
    ]


def gripper(m):
    end, piston = np.array([-30.0, 20.0]), np.array([-82.30678755, 0.0])
    u = (piston - end) / 56
    arm = end - np.array([0.0, 60.0])
    link = 500 * 75 / abs(arm[0] * u[1] - arm[1] * u[0])
    return [
        Value("link", m.force("upper_link first", m.largest("upper_link first")), link, 1e-3),
        Value("piston", max(m.cycle["efforts"]["air"]), 2 * link * abs(u[0]), 1e-3),
        Value("link's bearing", m.check("upper_link", "bearing"), link / (8 * 6), 1e-3, "MPa"),
    ]


def sickle_mower(m):
    r, b, e, w = 25.4, 325.0, -60.0, 1237.5 * RPM
    mass, centre, inertia = masses_of_plate(b, 24, 5.5, 14, 14)

    def lean(t):
        return np.arcsin((e - r * np.sin(t)) / b)

    def knife(t):
        return r * np.cos(t) + b * np.cos(lean(t))

    def middle(t):
        turned = centre * np.array([np.cos(lean(t)), np.sin(lean(t))])
        return r * np.array([np.cos(t), np.sin(t)]) + turned

    theta = np.radians(m.at(0))  # the knife turns round on the right
    pull = 2.5 * second_difference(knife, theta, w) / 1e3 - 400  # on the knife, by the pitman
    moved = mass * (second_difference(middle, theta, w) / 1e3 + np.array([0, G]))
    turned = inertia * second_difference(lean, theta, w) / 1e3
    arm = b * np.array([np.cos(lean(theta)), np.sin(lean(theta))])
    # moments on the pitman about the crank pin: the knife gives it (-pull, across)
    own = (arm[0] * moved[1] - arm[1] * moved[0]) * centre / b + turned
    across = (own - arm[1] * pull) / arm[0]
    knife_pin = np.hypot(pull, across)
    crank_pin = np.hypot(moved[0] + pull, moved[1] - across)
    bending = pin_bending(knife_pin, 8, 5.5, 14)
    return [
        Value("knife's pin", m.force("pitman second", 0), knife_pin, 1e-3),
        Value("crank pin", m.force("pitman first", 0), crank_pin, 1e-3),
        Value("knife's pin in bending", m.check("pin_B", "pin bending"), bending, 0.01, "MPa"),
    ]


def tail_lift(m):
    down = np.arcsin(450 / 700)
    weight = 600 * G
    upper = weight * 750 / 200 / np.cos(down)  # moments about D: the arms pull and push along
    d = np.array([700 * np.cos(down), -450.0])
    push = d - np.array([0.0, -300.0])
    push /= np.hypot(*push)
    across = np.array([np.sin(down), np.cos(down)])  # to the arms
    cylinder = weight * across[1] / (push @ across)
    return [  # the arms have 5 kg each
        Value("upper arm", m.force("upper_arm end", -450.0), upper, 0.005),
        Value("cylinder", abs(m.effort("cylinder", -450.0)), cylinder, 0.01),
        Value(
            "upper arm's bearing",
            m.check("upper_arm", "bearing"),
            upper / (25 * 2 * 5),
            0.005,
            "MPa",
        ),
    ]


def pumpjack(m):
    inch = 25.4
    front, rear, across, pitman, up, shaft, radius = (
        inch * size for size in (64, 48.17, 48, 57.5, 98.5, 37, 18)
    )
    crank = complex(across, shaft - up)  # from the saddle; the tail is pitman - radius away
    apart, far = pitman - radius, abs(crank)
    along = (rear**2 - apart**2 + far**2) / (2 * far)
    tail = crank / far * (along + 1j * np.sqrt(rear**2 - along**2))
    pull = (crank - tail) / apart
    force = 30e3 * front / abs((tail.conjugate() * pull).imag)

    def arm(a, b, c):  # two discs and what their common tangents enclose
        share = (a - b) / c
        turn = np.arccos(share)
        return (a + b) * c * np.sin(turn) + a * a * (np.pi - turn) + b * b * turn

    area = arm(200, 70, front) + arm(200, 90, rear) - np.pi * 200**2
    area -= np.pi / 4 * (60**2 + 120**2 + 70**2)
    weight = area * 40 * 7.85e-6 * G
    head = -1j * tail / abs(tail) * 30e3
    saddle = abs(head + force * pull - 1j * weight)
    at = 277.76246
    return [  # the beam's weight acts 0.1 m from the saddle, its inertia is left out
        Value("pitman at the tail", m.force("beam T", at), force, 0.005),
        Value("saddle", m.force("beam S", at), saddle, 0.005),
        Value("tail's bearing", m.check("beam", "bearing"), force / (70 * 40), 0.005, "MPa"),
    ]


def riveting_press(m):
    a, b = np.radians(3), np.arcsin(240 * np.sin(np.radians(3)) / 540)
    toggle = 60e3 / np.cos(b)
    c = np.array([245.675006453, -249.286564428])
    knee = c + 240 * np.array([np.cos(a), np.sin(a)])
    plates = (
        masses_of_plate(540, 80, 30, 40, 40),
        masses_of_plate(240, 80, 30, 40, 40),
        masses_of_plate(360, 60, 20, 30, 30),
    )
    hung = sum(plate[0] for plate in plates) / 2 * G  # half of the links that meet there
    knee_load = -toggle * np.array([np.cos(b), -np.sin(b)]) - np.array([0.0, hung])
    coupler = knee / np.hypot(*knee)  # stretched with the crank
    rocker = np.array([np.cos(a), np.sin(a)])
    along_rocker, along_coupler = np.linalg.solve(np.array([rocker, coupler]).T, -knee_load)
    bending = pin_bending(toggle, 26, 30, 40)
    k = m.largest("toggle second")
    return [  # the links' inertia is left out
        Value("toggle", m.force("toggle second", k), toggle, 1e-3),
        Value("rocker", m.force("rocker second", k), abs(along_rocker), 3e-3),
        Value("coupler", m.force("coupler second", k), abs(along_coupler), 0.03),
        Value("pin in the slider", m.check("pin_D", "pin bending"), bending, 1e-3, "MPa"),
    ]


MACHINES = (
    air_compressor,
    crank_rocker,
    gas_engine,
    gripper,
    pumpjack,
    punching_press,
    push_pull_clamp,
    riveting_press,
    scissors_jack,
    shaper,
    sickle_mower,
    steam_engine,
    tail_lift,
    yoke_actuator,
)


def test_every_machine_of_the_gallery_has_its_hand_calculation():
    assert {path.stem for path in GALLERY.glob("*.toml")} == {m.__name__ for m in MACHINES}


@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.__name__)
def test_forces_and_a_stress_are_those_of_the_hand_calculation(machine):
    name = machine.__name__
    design = (GALLERY / f"{name}.toml").read_text(encoding="utf-8")
    for value in machine(Machine(name)):
        assert value.told in design, f"{value.what}: the design tells another value"
        assert value.tool == pytest.approx(value.hand, rel=value.tolerance), value.what


def test_every_machine_of_the_gallery_has_its_baseline():
    assert all(path.with_suffix(".baseline.json").exists() for path in GALLERY.glob("*.toml"))
