"""The rung "plane": a part as a sheet of varying thickness in plane stress (and plate bending).

What it is made of: geometry/plane_shapes.py (how each shape looks along z), fem/plane_bores.py and
fem/plane_unit_solutions.py (unit loads on it), docs/theory/rungs_plane.md (what it leaves out).
"""

from collections.abc import Mapping, Sequence
from math import inf

import numpy as np

from ballesta.design_data import Part
from ballesta.part_loads import PartLoads
from ballesta.part_strength import elastic_of
from ballesta.rungs.model import RungModel, UnitName
from ballesta.rungs.plane_levels import PlaneLevel, solve_levels
from ballesta.rungs.unit_names import columns_of, interface_units
from fem.plane_bores import plane_resultants
from geometry.mesh import FloatArray
from geometry.parts import (
    LeafPack,
    PlateLink,
    PrismaticTube,
    SlottedLever,
    ToggleBar,
    TubeRod,
)
from geometry.plane_outlines import PlaneOutline
from geometry.plane_shapes import outline_of

_OUT_OF_PLANE = 1e-9  # of a wrench: what is round-off
_ALL = (
    "stress across the sheet, and its change through the thickness; sideways buckling; narrower "
    "arcs of contact"
)
_OF_SHAPE: dict[type, str] = {
    PlateLink: "",
    ToggleBar: "; the cheeks' and the side walls' bending out of their planes, and the fillet of "
    "the cut-out but for the depth that it adds",
    SlottedLever: "; the notch at the boss's foot but for the depth that its fillet adds",
    TubeRod: "; the rod's round surface: each strip along z moves as one, which is too much in the "
    "fillets, and the inside of the tube",
    PrismaticTube: "; the walls' bending out of their planes",
    LeafPack: "; the leaves' anticlastic bending across their width, and their parting where they "
    "would have to pull on each other",
}


def model_of(
    part: Part,
    loads: PartLoads,
    *,
    fineness: float = 1.0,
    accuracy: float = 0.02,
    deadline: float = inf,
) -> RungModel | None:
    """The part's stress by the rung, or None for a shape or a load that is none of a sheet's.

    deadline  on the clock of `perf_counter`: no third mesh is begun that is expected to end later

    Raises MeshError and SolverError.
    """
    outline = outline_of(part.geometry)
    if outline is None or not _carries(outline, loads):
        return None
    material = elastic_of(part)
    last, states, bar = solve_levels(outline, material, loads, fineness, accuracy, deadline)
    return RungModel(
        rung="plane",
        history=last.history,
        places=_places(outline, last),
        units=_units(last),
        sheet=last,
        fretting=_fretting(part.geometry.notch_factors, last),
        numerical=bar,
        residual=_residual(last, loads),
        deflection=_deflection(last, states),
        buckling=None,
        neglects=_ALL + _OF_SHAPE[type(part.geometry)] + _closed(last, loads),
        unknowns=last.solutions.unknowns,
    )


def _carries(outline: PlaneOutline, loads: PartLoads) -> bool:
    """Whether the sheet has unit loads for all that acts on it; none acts along z."""
    for interface in outline.interfaces:
        wrench = np.abs(loads.wrenches[interface.name])
        refused = [2] if interface.tilts else [2, 3, 4]
        if wrench[:, refused].max(initial=0.0) > _OUT_OF_PLANE * wrench.max(initial=0.0):
            return False
    return True


def _places(outline: PlaneOutline, level: PlaneLevel) -> list[str]:
    """What stands at each point: the edge's name, a seam, or the outline."""
    mesh = level.solutions.sheet.mesh
    names = np.full(len(mesh.nodes), outline.seams, dtype=object)
    names[mesh.boundary] = "outline"
    for name in mesh.edges:
        names[mesh.edge_nodes(name)] = name
    return [str(name) for name in names[level.history.nodes]]


def _units(level: PlaneLevel) -> list[UnitName]:
    """Names of the columns: in the plane, accelerations, and couples where the sheet is bent."""
    solutions = level.solutions
    names = columns_of([(unit.interface.name, unit.names) for unit in solutions.interfaces])
    couples = [name for of in solutions.tilting for name in interface_units(of, ("M_x", "M_y"))]
    bent = len(level.history.coefficients) > len(names)
    return names + couples if bent else names


def _fretting(factors: Mapping[str, float], level: PlaneLevel) -> FloatArray:
    """Factor at each point by which fretting lowers the endurance limit."""
    fretting = np.ones(len(level.history.nodes))
    for name, factor in factors.items():
        on = np.isin(level.history.nodes, level.solutions.sheet.mesh.edge_nodes(name))
        fretting[on] = np.maximum(fretting[on], factor)
    return fretting


def _residual(level: PlaneLevel, loads: PartLoads) -> float:
    """Largest reaction of the supports, or load that missed the mesh, over the largest force."""
    solutions, coefficients = level.solutions, level.history.coefficients
    nodes = solutions.model.mesh.nodes
    size = float(np.ptp(nodes, axis=0).max())
    worst, first = float(np.abs(solutions.reactions(coefficients)).max()), 0
    for unit in solutions.interfaces:
        columns = slice(first, first + len(unit.names))
        first = columns.stop
        unit_wrenches = plane_resultants(nodes, unit.vectors, unit.interface.centre[:2])
        wanted = loads.wrenches[unit.interface.name][:, [0, 1, 5]].T
        missing = np.abs(unit_wrenches @ coefficients[columns] - wanted)
        missing[2] /= unit.interface.radius or size
        worst = max(worst, float(missing.max()))
    return worst / (loads.largest_force or 1.0)


def _deflection(level: PlaneLevel, states: Sequence[FloatArray]) -> float:
    """Largest displacement of any node at the two positions that decide, less rigid motion, mm.

    states  of the first, and what is between it and the second
    """
    solutions, largest = level.solutions, 0.0
    flat = solutions.displacement.shape[1]
    modes = solutions.model.rigid_modes
    for state in (states[0], states[0] + states[1]):
        moved = solutions.displacement @ state[:flat]
        share, *_ = np.linalg.lstsq(modes, moved, rcond=None)
        moved = (moved - modes @ share).reshape(-1, 2)
        across = np.zeros(len(moved))
        if len(state) > flat:
            lifted = solutions.bent @ state[flat:]
            turns = solutions.plate.rigid_modes
            share, *_ = np.linalg.lstsq(turns, lifted, rcond=None)
            across = (lifted - turns @ share)[0::3]
        size = np.sqrt((moved**2).sum(axis=1) + across**2)
        largest = max(largest, float(size.max()))
    return largest


def _closed(level: PlaneLevel, loads: PartLoads) -> str:
    """A word on the inertia that was added to balance loads of other mass properties."""
    solutions = level.solutions
    first = solutions.displacement.shape[1] - 4
    added = np.abs(solutions.resultants[:2, first : first + 3] @ level.added.T).max(initial=0.0)
    share = float(added) / (loads.largest_force or 1.0)
    return f"; {100 * share:.1g} % of the largest force were balanced" if share > 0.01 else ""
