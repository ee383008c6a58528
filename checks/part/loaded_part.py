"""A part with its loads, and with what its machine asks of it."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from checks.design.data import Design, Duty, Part, StatedMass
from checks.design.errors import DesignError
from checks.design.model import Requirements
from checks.part.part_loads import Doubt, PartLoads, Runs, loads_on
from checks.part.placing import interface_distance
from geometry.mesh import Interface


@dataclass(frozen=True, eq=False)
class LoadedPart:
    """A part of a design under its loads over all cycles: what every model and check is given.

    design  the machine that it is a part of
    loads   on its interfaces, in its own axes, at all positions
    runs    name -> loads of the whole linkage in a computed cycle or a measured run
    """

    design: Design
    part: Part
    loads: PartLoads
    runs: Runs = field(default_factory=dict)

    @staticmethod
    def of(
        design: Design,
        part: Part,
        runs: Runs,
        interfaces: Mapping[str, Interface],
        doubts: Sequence[Doubt] = (),
    ) -> "LoadedPart":
        """Gather a part's loads over all runs.

        interfaces  of its body
        doubts      what the runs may be instead

        Raises loads.LinkageError where a force meets the part at no interface, or nothing loads it,
        and DesignError where a contact slides off the stretch that the part has for it.
        """
        found = LoadedPart(design, part, loads_on(design, part, runs, doubts), runs)
        check_reach(found, interfaces)
        return found

    def under(self, loads: PartLoads) -> "LoadedPart":
        """The same part under other loads."""
        return replace(self, loads=loads)

    @property
    def name(self) -> str:
        """Name of the part."""
        return self.part.name

    @property
    def stated(self) -> StatedMass:
        """Mass properties that the file states beside the part's own."""
        return self.design.stated_mass(self.part)

    @property
    def duty(self) -> Duty:
        """How often each cycle runs."""
        return self.design.duty

    @property
    def required(self) -> Requirements:
        """Least safety factors, by kind of check."""
        return self.design.require

    @property
    def accuracy(self) -> float:
        """Numerical error, as a share of a stress, that a mesh is refined to."""
        return self.design.accuracy

    @property
    def pin_distance(self) -> float:
        """Distance of the first two interfaces, mm."""
        return interface_distance(self.design, self.part)


def check_reach(loaded: LoadedPart, interfaces: Mapping[str, Interface]) -> None:
    """Raise DesignError where a contact slides off the stretch that the part has for it."""
    part = loaded.part
    for name, reach in loaded.loads.reaches.items():
        interface = interfaces[name]
        low, high = interface.travel
        slack = 1e-6 * (high - low)
        first, last = float(reach.min()), float(reach.max())
        if first >= low - slack and last <= high + slack:
            continue
        loads, worst = loaded.loads, int(np.argmax(np.maximum(low - reach, reach - high)))
        zero = float(interface.centre[0])
        stated = [
            field.name
            for field in dataclasses.fields(part.geometry)
            if field.name.startswith(("travel_", "contact_", "slot_"))
        ]
        raise DesignError(
            loaded.design.file,
            f"parts.{part.name}.interfaces.{name}",
            f"the contact slides from x = {zero + first:.4g} to {zero + last:.4g} mm along the "
            f"part, which has it from {zero + low:.4g} to {zero + high:.4g} mm; at "
            f"{loads.cycle_names[worst]}, {loads.labels[worst]} it leaves that; change "
            f"{', '.join(stated)}",
        )
