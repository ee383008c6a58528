"""Names of unit loads, with where each acts, and the units of their coefficients."""

from collections.abc import Sequence

from checks.handbook.pin_loaded_hole import PATTERNS
from checks.stress.part_model import UnitName
from fem.unit_loads import ACCELERATIONS

_WRENCH = ("F_x", "F_y", "F_z", "M_x", "M_y", "M_z")
_ACCELERATIONS = {"a_x": "mm/s2", "a_y": "mm/s2", "alpha": "rad/s2", "omega2": "1/s2"}
_COUPLES = ("couple", "M_x", "M_y", "M_z")


def interface_units(interface: str, columns: Sequence[str]) -> list[UnitName]:
    """Names of an interface's columns as the solid's unit loads have them."""
    return [(f"{interface} {name}", "N mm" if name in _COUPLES else "N") for name in columns]


def bearing_units(interface: str) -> list[UnitName]:
    """Names of a bore's columns: harmonics of the pressure and the friction couple."""
    return interface_units(interface, PATTERNS)


def wrench_units(place: str) -> list[UnitName]:
    """Names of the six forces and couples at a place."""
    return [(f"{name} at {place}", "N mm" if name in _COUPLES else "N") for name in _WRENCH]


def acceleration_units() -> list[UnitName]:
    """Names of the four accelerations of a part's frame."""
    return [(name, _ACCELERATIONS[name]) for name in ACCELERATIONS]


def columns_of(interfaces: Sequence[tuple[str, Sequence[str]]]) -> list[UnitName]:
    """Names of the columns of all interfaces, then of the accelerations."""
    own = [
        name for interface, columns in interfaces for name in interface_units(interface, columns)
    ]
    return own + acceleration_units()
