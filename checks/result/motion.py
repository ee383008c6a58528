"""Motion of a machine's parts through a cycle, and the forces at their pins, for pictures."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from checks.result.verdict import DesignResult
from checks.result.words import brief
from geometry.mesh import FloatArray, IntArray
from loads import JointLoad, Kinematics, Linkage

MOST_POSITIONS = 361  # of a cycle whose bodies turn little from one to the next


@dataclass(frozen=True, eq=False)
class PinForce:
    """The force on a part at one of its interfaces, in the machine's frame.

    on, interface  the part, and its interface
    point          the linkage's point, or the slot or guide that runs on the part
    place          (k, 2) mm, where the force acts; it moves on the part where a contact slides
    force          (k, 2) N
    z              mm, the height at which it acts
    halves         mm, heights of a pair of lugs that take half of it each; () where it is not one
    """

    on: str
    interface: str
    point: str
    place: FloatArray
    force: FloatArray
    z: float = 0.0
    halves: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class PartsMotion:
    """Pose of every part in the machine's frame at the kept positions of a cycle.

    index        (k,)    rows of the cycle's positions that are kept, rising
    times        (k,)    s, from the start of the cycle
    parts        name -> (k, 3) mm, mm, rad: the part's frame in the machine's, without jumps of
                 the angle
    layer        name -> mm, height of the part's plane z = 0 over the machine's
    layers_told  what the layers come from, in words
    pins         "<part> <interface>" -> force on the part there
    bodies       part -> body of the linkage that carries it; a pin turns with that body
    linkage, poses (k, bodies, 3), reactions, efforts (k,)  the linkage itself, as in CycleLoads
    """

    index: IntArray
    times: FloatArray
    parts: Mapping[str, FloatArray]
    layer: Mapping[str, float]
    layers_told: str
    pins: Mapping[str, PinForce]
    bodies: Mapping[str, str]
    linkage: Linkage
    poses: FloatArray
    reactions: Mapping[str, JointLoad]
    efforts: Mapping[str, FloatArray]

    def __post_init__(self) -> None:
        k = len(self.index)
        if not k or (np.diff(self.index) <= 0).any():
            raise ValueError(f"a motion keeps one or more rising positions, got {k}")
        shapes: dict[str, tuple[FloatArray, tuple[int, ...]]] = {"times": (self.times, (k,))}
        shapes["poses"] = (self.poses, (k, len(self.linkage.body_names), 3))
        shapes |= {f"the frame of {name!r}": (pose, (k, 3)) for name, pose in self.parts.items()}
        for label, pin in self.pins.items():
            shapes[f"the place of {label!r}"] = (pin.place, (k, 2))
            shapes[f"the force of {label!r}"] = (pin.force, (k, 2))
        for what, (values, shape) in shapes.items():
            if values.shape != shape or not np.isfinite(values).all():
                raise ValueError(
                    f"{what} needs finite numbers of shape {shape}, has {values.shape}"
                )
        for name in self.parts:
            if name not in self.layer or name not in self.bodies:
                raise ValueError(f"part {name!r} needs a layer and a body that carries it")

    def row_of(self, position: float) -> float:
        """Row (fractional) of the kept positions at a row (fractional) of the cycle's positions."""
        return float(np.interp(position, self.index, np.arange(len(self.index))))

    @cached_property
    def _kinematics(self) -> Kinematics:
        return Kinematics(self.linkage)

    def point(self, body: str, point: str) -> FloatArray:
        """Positions (k, 2) of a point of a body, mm."""
        return self._kinematics.point(self.poses, body, point)

    def travel(self, joint: str) -> FloatArray:
        """Travel of a pin along its slot or guide (k,), mm from the line's point."""
        return self._kinematics.travel_of(self.poses, joint)


def motion_gaps(result: DesignResult) -> list[str]:
    """A sentence for every cycle whose motion nobody knows."""
    return [
        f"{brief(name, 60)}: no motion is shown; its loads were measured or stated, no linkage was "
        "solved for it, so nobody knows where the parts are"
        for name in result.cycles
        if name not in result.motion
    ]
