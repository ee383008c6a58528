"""Loads of any planar linkage of one degree of freedom over its cycle, part by part."""

from loads.bodies import GROUND, Body, LinkageError
from loads.cycle import Cycle, Phase, run_cycle
from loads.cycle_loads import CycleLoads
from loads.elements import (
    Angle,
    Coordinate,
    Distance,
    Fixed,
    Force,
    Friction,
    Joint,
    PointCoordinate,
    Prismatic,
    Revolute,
    Slot,
)
from loads.forces import ForceSolution, JointLoad, solve_forces
from loads.history import LoadHistory
from loads.linkage import Linkage
from loads.motion import Geometry, Motion, Path, move, trace
from loads.point_loads import PointLoad

__all__ = [
    "GROUND",
    "Angle",
    "Body",
    "Coordinate",
    "Cycle",
    "CycleLoads",
    "Distance",
    "Fixed",
    "Force",
    "ForceSolution",
    "Friction",
    "Geometry",
    "Joint",
    "JointLoad",
    "Linkage",
    "LinkageError",
    "LoadHistory",
    "Motion",
    "Path",
    "Phase",
    "PointCoordinate",
    "PointLoad",
    "Prismatic",
    "Revolute",
    "Slot",
    "move",
    "run_cycle",
    "solve_forces",
    "trace",
]
