"""A pin tearing out behind its hole: mean shear stress in the two planes, against yield in shear.

The plane taken is the shortest, straight behind the hole's crown (Melcon and Hoblit, Product
Engineering 24 (1953) no. 6, start theirs at 40 degrees, where it is longer).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from checks.design.data import Part
from checks.joints.lugs import lugs_of
from checks.joints.tear_planes import plate_tear_lengths, tear_lengths
from checks.part.derived import EXACT, Heading, Series, shear_yield, yield_stress
from checks.part.first_maximum import first_largest
from checks.part.kind import Kind
from checks.part.loaded_part import LoadedPart
from checks.result.derivation import Step
from checks.result.verdict import Check
from geometry.cad_body import SolidBody
from geometry.mesh import FloatArray, Mesh
from geometry.parts.plate import Plate, as_plate
from geometry.shape import Ligament

SHEAR_OUT = Kind(
    name="shear-out",
    quantity="mean shear stress behind the pin F/(2 A)",
    demand="mean shear stress in two planes behind the hole",
    limit="yield stress over √3",
    require="static",
    source="Melcon and Hoblit 1953; [fits](../theory/fits.md)",
)
KINDS = (SHEAR_OUT,)

_DIRECTIONS = 72
_FITS = "docs/theory/fits.md"


def checks(loaded: LoadedPart) -> Iterator[Check]:
    """Shear stress tau = F/(2 A) behind the bore where it is largest, if a pin pulls at one."""
    bores = [lug.interface for lug in lugs_of(loaded)]
    body = loaded.measurable
    found = [
        _torn(loaded, bore, ligament)
        for bore in bores
        if body.interfaces[bore].kind == "bore"
        for ligament in ligaments(loaded.part, body, bore)
    ]
    if found and max(check.value for check in found) > 0:
        (most,) = first_largest(np.array([check.value for check in found]))
        yield found[most]


def _torn(loaded: LoadedPart, bore: str, ligament: Ligament) -> Check:
    pull, area = _pull(loaded.loads.wrenches[bore], ligament)
    return loaded.worst(
        Heading(
            kind=SHEAR_OUT,
            place=f"{bore}, towards {ligament.until}",
            basis="yield stress over sqrt 3",
            note=lambda found: (
                f"F = {found['F']:.0f} N that way, A = {found['A']:.4g} mm2 in each of two planes"
            ),
        ),
        [
            Series("F", f"pull of the pin in {bore} towards {ligament.until}", pull, "N",
                   main=True),
            Series("A", "area of one of the two planes behind it", area, "mm2",
                   f"the part's shape: {_FITS}"),
            Step("tau", "mean shear stress in both planes", "F/(2*A)", "MPa", _FITS, main=True),
        ],
        [yield_stress(loaded.part), shear_yield()],
        EXACT,
    )  # fmt: skip


def _pull(wrench: FloatArray, ligament: Ligament) -> tuple[FloatArray, FloatArray]:
    """Force (n,) that tears a ligament, N, and the area (n,) of one plane, mm2."""
    if ligament.direction is not None:
        pull = np.maximum(wrench[:, :2] @ np.array(ligament.direction), 0.0)
        return pull, np.full(len(pull), ligament.area[0])
    angle = np.arctan2(wrench[:, 1], wrench[:, 0])
    sector = np.round(angle / (2 * np.pi) * _DIRECTIONS).astype(int) % _DIRECTIONS
    return np.hypot(wrench[:, 0], wrench[:, 1]), np.array(ligament.area)[sector]


def ligaments(part: Part, body: Mesh | SolidBody, interface: str) -> Sequence[Ligament]:
    """Ligaments that a pin can tear out of a hole: towards the part's end, or into a slot beside.

    Of a part from CAD the ligament is looked for in all directions.
    """
    plate, known = as_plate(part.geometry), part.geometry.ligaments(interface)
    if plate is not None:
        return [_of_plate(plate, interface)]
    if known is not None:
        return known
    if not isinstance(body, Mesh):
        raise TypeError("the ligaments of a CAD part are measured on its mesh")
    return [ligament_all_round(body, interface)]


def _of_plate(plate: Plate, name: str) -> Ligament:
    """The ligament of a plate's hole in every direction, by its outline."""
    angles = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    areas = plate.thickness * plate_tear_lengths(plate, name, angles.tolist())
    return Ligament(None, tuple(areas.tolist()), "the wall that the force points at")


def ligament_all_round(mesh: Mesh, name: str) -> Ligament:
    """The ligament of a hole in every direction, as the shear planes are on the mesh."""
    angles = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    areas = mesh.interfaces[name].length * tear_lengths(mesh, name, angles.tolist())
    return Ligament(None, tuple(areas.tolist()), "the wall that the force points at")
