"""The rung `beam`: a Timoshenko frame of the part, recovered at its fibres and at its notches."""

import numpy as np

from checks.design.data import Part
from checks.models.beam_buckling import buckling_of
from checks.models.beam_frames import plate_link, prismatic_tube, tube_rod
from checks.models.beam_leaves import leaf_pack
from checks.models.beam_lever import slotted_lever
from checks.models.beam_parts import PartFrame
from checks.models.beam_pins import pin
from checks.models.beam_solution import BeamSolution, solve_frame
from checks.models.beam_toggle import toggle_bar
from checks.models.unit_names import columns_of
from checks.part.part_loads import PartLoads
from checks.stress.part_model import RungModel
from fem.stress_history import StressHistory
from geometry.mesh import FloatArray
from geometry.parts import LeafPack, Pin, PlateLink, PrismaticTube, SlottedLever, ToggleBar, TubeRod


def model_of(part: Part, loads: PartLoads) -> RungModel | None:
    """A part's stress by its frame; None where the beam has no answer."""
    framed = frame_of(part)
    if framed is None:
        return None
    solved = solve_frame(framed)
    coefficients = solved.coefficients(loads)
    points, basis, places, fretting = _fibres(solved)
    return RungModel(
        rung="beam",
        history=StressHistory(np.arange(len(points)), points, basis, coefficients),
        places=places,
        units=columns_of([(entry.interface.name, entry.names) for entry in framed.entries]),
        fretting=fretting,
        numerical=solved.solution.residual,
        residual=solved.residual(loads, coefficients),
        deflection=solved.deflection(coefficients),
        buckling=buckling_of(part, loads, solved, coefficients),
        neglects=framed.neglects,
        unknowns=6 * len(framed.frame.nodes),
    )


def frame_of(part: Part) -> PartFrame | None:
    """A part as a frame; None for a part of a CAD file, and for a pin with a sharp step."""
    match part.geometry:
        case ToggleBar() as shape:
            return toggle_bar(part, shape)
        case PrismaticTube() as shape:
            return prismatic_tube(part, shape)
        case PlateLink() as shape:
            return plate_link(part, shape)
        case TubeRod() as shape:
            return tube_rod(part, shape)
        case SlottedLever() as shape:
            return slotted_lever(part, shape)
        case LeafPack() as shape:
            return leaf_pack(part, shape)
        case Pin() as shape:
            return pin(part, shape)
        case _:
            return None


def _fibres(solved: BeamSolution) -> tuple[FloatArray, FloatArray, list[str], FloatArray]:
    """Points (p, 3), basis (p, 6, n_basis), places and fretting (p,) of all sites and patches."""
    frame = solved.part.frame
    points, basis, places, fretting = [], [], [], []
    for site, forces in zip(solved.part.sites, solved.at_sites, strict=True):
        axes = frame.axes[site.member]
        start, end = frame.nodes[frame.members[site.member]]
        middle = start + site.at * (end - start)
        points.append(middle + site.fibres.places @ axes[1:])
        stress = site.fibres.turned(axes) @ forces
        if site.pressed is not None:
            stress[:, :, solved.part.columns(site.pressed)] += site.pressure
        basis.append(stress)
        places += [site.name] * len(site.fibres.places)
        fretting.append(np.full(len(site.fibres.places), site.fretting))
    for patch in solved.part.patches:
        stress = np.zeros((len(patch.points), 6, basis[0].shape[2]))
        stress[:, :, solved.part.columns(patch.interface)] = patch.unit
        points.append(patch.points)
        basis.append(stress)
        places += [patch.name] * len(patch.points)
        fretting.append(np.ones(len(patch.points)))
    return np.concatenate(points), np.concatenate(basis), places, np.concatenate(fretting)
