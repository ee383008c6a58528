"""Loads of any planar linkage of one degree of freedom over its cycle, part by part."""

from loads.assembly import assembly_gap
from loads.blow_force import BlowForce, Struck
from loads.blow_loads import BlowLoads, at_rows, blow_loads, moments_of_blows, with_blow
from loads.blows import Blow, JointImpulse, blow
from loads.bodies import GROUND, Body, LinkageError, Pose
from loads.compliance import BeamCompliance, Compliance, JointCompliance, MatrixCompliance
from loads.cycle import (
    CycleError,
    forces_again,
    moves_alike,
    run_at_positions,
    run_at_rates,
    run_cycle,
    try_cycle,
)
from loads.cycle_loads import ContactLoads, CycleLoads
from loads.dead_centre import PullThrough, pull_through
from loads.diagnosis import Diagnosis, diagnose, percent, position_text
from loads.drive import DriveFigures
from loads.events import EVENTS, Event, EventRun, solve_event
from loads.forces import ForceSolution, JointLoad, solve_forces
from loads.joint_play import Hit, play_hits, with_hits
from loads.joints import (
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
    shared_pins,
)
from loads.kinematics import Kinematics
from loads.laws import (
    FUNCTIONS,
    Apply,
    Contact,
    Expression,
    Law,
    Number,
    Opposing,
    Reading,
    Table,
    Term,
)
from loads.linkage import Linkage
from loads.measured import MeasuredBody, MeasuredLoad, MeasuredLoads
from loads.motion import Geometry, Motion, move
from loads.pace import Geared, Motor, MotorPace, Pace, RunPace, SteadyPace, StrokePace
from loads.path import Path, trace
from loads.phases import Cycle, Phase
from loads.point_loads import LoadHistory, PointLoad
from loads.reversals import split_cycle
from loads.swing import Swing, SwungCycle, swung_cycle, without_contact
from loads.turning import RunawayError, StallError, UnsettledError

__all__ = [
    "EVENTS",
    "FUNCTIONS",
    "GROUND",
    "Angle",
    "Apply",
    "BeamCompliance",
    "Blow",
    "BlowForce",
    "BlowLoads",
    "Body",
    "Compliance",
    "Contact",
    "ContactLoads",
    "Coordinate",
    "Cycle",
    "CycleError",
    "CycleLoads",
    "Diagnosis",
    "Distance",
    "DriveFigures",
    "Event",
    "EventRun",
    "Expression",
    "Fixed",
    "Force",
    "ForceSolution",
    "Friction",
    "Geared",
    "Geometry",
    "Hit",
    "Joint",
    "JointCompliance",
    "JointImpulse",
    "JointLoad",
    "Kinematics",
    "Law",
    "Linkage",
    "LinkageError",
    "LoadHistory",
    "MatrixCompliance",
    "MeasuredBody",
    "MeasuredLoad",
    "MeasuredLoads",
    "Motion",
    "Motor",
    "MotorPace",
    "Number",
    "Opposing",
    "Pace",
    "Path",
    "Phase",
    "PointCoordinate",
    "PointLoad",
    "Pose",
    "Prismatic",
    "PullThrough",
    "Reading",
    "Revolute",
    "RunPace",
    "RunawayError",
    "Slot",
    "StallError",
    "SteadyPace",
    "StrokePace",
    "Struck",
    "Swing",
    "SwungCycle",
    "Table",
    "Term",
    "UnsettledError",
    "assembly_gap",
    "at_rows",
    "blow",
    "blow_loads",
    "diagnose",
    "forces_again",
    "moments_of_blows",
    "move",
    "moves_alike",
    "percent",
    "play_hits",
    "position_text",
    "pull_through",
    "run_at_positions",
    "run_at_rates",
    "run_cycle",
    "shared_pins",
    "solve_event",
    "solve_forces",
    "split_cycle",
    "swung_cycle",
    "trace",
    "try_cycle",
    "with_blow",
    "with_hits",
    "without_contact",
]
