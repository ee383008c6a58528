"""One machine in many guises through the whole chain: the verdict must be that of the machine.

A crank pushes a slider by a rod, a plate link. The same machine is stated in other units, turned,
mirrored, started elsewhere, with its part the other way round, finer, faster, thinner.
"""

from dataclasses import dataclass, replace
from math import cos, radians, sin
from pathlib import Path
from tempfile import TemporaryDirectory

from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.pipeline import check_design
from checks.ladder.part_ladder import Effort
from checks.result.verdict import Check, DesignResult

DESIGNS = Path(__file__).resolve().parents[3] / "designs"
LOADS = tuple(10.0**k for k in range(-6, 7))  # over the 400 N of the machine
SPEEDS = (0.01, 0.1, 1.0, 10.0, 100.0, 1000.0)  # rad/s
COUNTS = (8, 16, 32, 64, 128, 360, 1000)


@dataclass(frozen=True)
class Units:
    """Names of units, and how large each is in mm, N, kg and MPa."""

    length: str = "mm"
    force: str = "N"
    mass: str = "kg"
    inertia: str = "kg m2"
    stress: str = "MPa"
    density: str = "kg/m3"
    millimetres: float = 1.0
    newtons: float = 1.0
    kilograms: float = 1.0
    square_metres: float = 1.0
    megapascals: float = 1.0
    cubic_metres: float = 1.0


METRIC = Units()
INCH, POUND, FORCE = 25.4, 0.45359237, 4.4482216152605
IMPERIAL = Units(
    "inch", "lbf", "lb", "lb inch2", "psi", "lb/inch3",
    INCH, FORCE, POUND, (INCH / 1e3) ** 2, FORCE / INCH**2, (INCH / 1e3) ** 3,
)  # fmt: skip


@dataclass(frozen=True)
class Guise:
    """How the machine is stated; lengths in mm, forces in N, angles in deg, gravity in m/s2.

    turned    of the whole machine
    mirrored  at the x axis, before it is turned
    start     of the crank, before it is mirrored and turned
    flipped   the part's first interface at the slider
    masses    over those of the machine
    gravity   turned and mirrored with it
    """

    units: Units = METRIC
    turned: float = 0.0
    mirrored: bool = False
    start: float = 90.0
    flipped: bool = False
    push: float = 400.0
    speed: float = 10.0
    masses: float = 1.0
    gravity: float = 9.81
    positions: int | None = None
    width: float = 30.0
    thickness: float = 8.0
    hole: float = 12.0
    fineness: float = 0.5

    @property
    def text(self) -> str:
        """The design file."""
        units = self.units

        def number(value: float) -> str:
            return repr(float(value))

        def length(value: float) -> str:
            return f'"{number(value / units.millimetres)} {units.length}"'

        def pair(x: float, y: float, unit: float) -> str:
            c, s = cos(radians(self.turned)), sin(radians(self.turned))
            y = -y if self.mirrored else y
            return f"{number((c * x - s * y) / unit)}, {number((s * x + c * y) / unit)}"

        def angle(value: float) -> str:
            return f'"{number((-value if self.mirrored else value) + self.turned)} deg"'

        def point(x: float, y: float) -> str:
            return f'"{pair(x, y, units.millimetres)} {units.length}"'

        def body(mass: float, inertia: float, centre: float) -> str:
            # centres lie on the line from a body's first pin along its own x axis
            weighed = self.masses * mass / units.kilograms
            turning = self.masses * inertia / units.kilograms / units.square_metres
            along = f'"{number(centre / units.millimetres)}, 0 {units.length}"'
            return (
                f'mass = "{number(weighed)} {units.mass}"\n'
                f'inertia = "{number(turning)} {units.inertia}"\ncentre = {along}\n'
            )

        def stress(value: float) -> str:
            return f'"{number(value / units.megapascals)} {units.stress}"'

        ends = '{ first = "B", second = "A" }' if self.flipped else '{ first = "A", second = "B" }'
        density = 7850.0 * units.cubic_metres / units.kilograms
        count = "" if self.positions is None else f"positions = {self.positions}\n"
        stop = self.start + 360.0
        return f"""
name = "Crank and slider"
gravity = "{pair(0, -1e3 * self.gravity, units.millimetres)} {units.length}/s2"
ground = ["O"]
[points]
O = {point(0, 0)}
A = {point(0, 60)}
B = {point(144, -12)}
[bodies.crank]
pins = ["O", "A"]
{body(0.1, 1e-4, 30)}
[bodies.rod]
pins = ["A", "B"]
{body(0.2, 5e-4, 80)}
[bodies.slider]
pins = ["B"]
mass = "{number(self.masses * 0.5 / units.kilograms)} {units.mass}"
guide = {{ along = "{pair(1, 0, 1)}" }}
[forces.drive]
turns = "crank"
at = "O"
[forces.push]
body = "slider"
at = "B"
direction = "{pair(-1, 0, 1)}"
[cycles.turn]
coordinate = "crank.angle"
start = {angle(self.start)}
pace = {{ coordinate = "crank.angle", speed = "{number(self.speed)} rad/s" }}
{count}
[[cycles.turn.phases]]
name = "round"
to = {angle(stop)}
forces = {{ push = "{number(self.push / units.newtons)} {units.force}" }}
solve = "drive"
[duty]
cycles = {{ turn = 1e6 }}
[materials.steel]
youngs_modulus = {stress(210e3)}
poisson_ratio = 0.3
density = "{number(density)} {units.density}"
yield_stress = {stress(275.0)}
ultimate_stress = {stress(430.0)}
source = "S275"
[parts.rod]
body = "rod"
shape = "plate_link"
interfaces = {ends}
material = "steel"
width = {length(self.width)}
thickness = {length(self.thickness)}
hole = {length(self.hole)}
mesh = {{ fineness = {self.fineness} }}
"""


PLAIN = Guise()


def checked(guise: Guise, effort: str = "formula") -> DesignResult:
    """The machine in a guise, checked."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "machine.toml"
        file.write_text(guise.text, encoding="utf-8")
        return check_design(read_design(file), effort=Effort(effort))


def unresolved(guise: Guise) -> float:
    """What the cycle says that it misses between its positions."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "machine.toml"
        file.write_text(guise.text, encoding="utf-8")
        return solve_cycles(read_design(file), {})["turn"].unresolved.share


def values(result: DesignResult) -> dict[tuple[str, str, str], float]:
    """Every number of a verdict, by part, kind and quantity."""
    return {(check.part, check.kind, check.quantity): check.value for check in result.checks}


def statuses(result: DesignResult) -> list[tuple[str, str, str]]:
    """Every status of a verdict, its own at the end."""
    each = [(check.kind, check.quantity, str(check.status)) for check in result.checks]
    return [*each, ("", "", str(result.status))]


def apart(one: DesignResult, other: DesignResult) -> float:
    """Largest relative difference of the numbers of two verdicts; raises where checks differ."""
    left, right = values(one), values(other)
    if left.keys() != right.keys():
        raise AssertionError(f"other checks: {sorted(left.keys() ^ right.keys())}")
    return max(
        abs(left[key] - right[key]) / max(abs(left[key]), abs(right[key]), 1e-300) for key in left
    )


def check_of(result: DesignResult, kind: str) -> Check:
    """The first check of the rod of a kind."""
    return next(check for check in result.checks if check.part == "rod" and check.kind == kind)


def with_count(positions: int) -> Guise:
    """The machine with so many positions asked for."""
    return replace(PLAIN, positions=positions)
