"""A part as a Timoshenko frame: its members, where its interfaces press, the fibres looked at."""

from collections.abc import Sequence
from dataclasses import dataclass

from fem.frame import Frame, FrameLoads
from fem.frame_fibres import Fibres
from geometry.mesh import FloatArray, Interface


@dataclass(frozen=True, eq=False)
class Site:
    """Fibres of a member's section that the rung looks at.

    at        0 .. 1 along the member
    fretting  factor by which fretting lowers the endurance limit
    pressed   interface whose pressure adds stress of its own here, None without one
    pressure  (f, 6, n_columns) MPa, that stress by the interface's columns
    """

    member: int
    at: float
    fibres: Fibres
    name: str
    fretting: float = 1.0
    pressed: str | None = None
    pressure: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Patch:
    """Points about an interface whose stress its own columns tell.

    interface  its name
    points     (p, 3) mm
    unit       (p, 6, n_columns) MPa by the interface's columns
    """

    interface: str
    points: FloatArray
    unit: FloatArray
    name: str


@dataclass(frozen=True, eq=False)
class Entry:
    """How the wrench of an interface comes into the frame.

    names   of the columns, as the solid's unit loads have them
    loads   one case per column
    """

    interface: Interface
    names: tuple[str, ...]
    loads: FrameLoads


@dataclass(frozen=True, eq=False)
class PartFrame:
    """A part as a frame, with all that acts on it and all that is asked of it.

    held  node at which the frame is held while it is solved; nothing is left to hold there
    massless  members that only join others: they have no mass
    pins  of the first two interfaces of a part that may buckle between them, the nodes at each
    """

    frame: Frame
    held: int
    entries: Sequence[Entry]
    sites: Sequence[Site]
    neglects: str
    pins: tuple[Sequence[int], ...] = ()
    patches: Sequence[Patch] = ()
    massless: Sequence[int] = ()

    def columns(self, interface: str) -> slice:
        """Which columns of the basis are an interface's."""
        first = 0
        for entry in self.entries:
            if entry.interface.name == interface:
                return slice(first, first + len(entry.names))
            first += len(entry.names)
        raise KeyError(interface)
