"""Scene of the interactive window: parts with their fields, cycles, and the view of them.

Plain arrays and no graphics; a folder takes it to the window's own process.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from checks.result.live_fields import FATIGUE, LiveFields, von_mises, with_required_safety
from checks.result.verdict import DesignResult
from checks.result.words import brief, number, place_text
from checks.store.store import from_record, to_record
from geometry.mesh import FloatArray

FIELDS = {
    "mises": ("von Mises stress", "MPa"),
    "principal": ("signed principal stress", "MPa"),
    "utilisation": ("fatigue utilisation, required safety included", ""),
    "amplitude": ("stress amplitude over the duty", "MPa"),
    "mean": ("mean stress over the duty (tension)", "MPa"),
    "displacement": ("displacement", "mm"),
}
SIGNED = ("principal", "mean")
_SAMPLES = 25  # positions of a cycle from which limits of colours are taken, beside the worst
_BULGE = 0.05  # of a part's size: how far the largest displacement is drawn
_TREE, _ARRAYS = "scene.json", "scene.npz"


@dataclass(frozen=True)
class Worst:
    """Largest stress of a part: number of the cycle, position in it, MPa."""

    cycle: int
    position: int
    value: float


@dataclass(frozen=True, eq=False)
class ShownPart:
    """A part: fields at its nodes (live), or a bare surface with the reason.

    worst  as the checks found it, also of a part without fields; None where nobody knows
    """

    name: str
    live: LiveFields
    worst: Worst | None = None

    @cached_property
    def size(self) -> float:
        """Diagonal of its box, mm."""
        return float(np.linalg.norm(np.ptp(self.live.nodes, axis=0)))


@dataclass(frozen=True, eq=False)
class CycleAxis:
    """A cycle's positions."""

    name: str
    shown_name: str
    unit: str
    position: FloatArray
    phase: Sequence[str]

    @property
    def n(self) -> int:
        """Number of positions."""
        return len(self.position)


@dataclass(frozen=True)
class View:
    """View of a scene: part, cycle, position in it, field, deformed."""

    part: int
    cycle: int = 0
    position: int = 0
    field: str = "mises"
    deformed: bool = False


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that the window can show."""

    title: str
    parts: Sequence[ShownPart]
    cycles: Sequence[CycleAxis]

    def first_view(self, part: str | None = None) -> View:
        """First view: the part that is asked for, else one with stress, at its peak."""
        k = next((k for k, shown in enumerate(self.parts) if shown.name == part), None)
        if k is None:
            k = next((k for k, p in enumerate(self.parts) if p.live.peak is not None), None)
        if k is None:
            k = max(range(len(self.parts)), key=self._worst_of)
        return self.at_peak(View(k))

    def at_peak(self, view: View) -> View:
        """The view at the position of the part's largest stress.

        Of a part that is grey it is where the checks found that.
        """
        part = self.parts[view.part]
        peak, names = part.live.peak, [cycle.name for cycle in self.cycles]
        if peak is not None and peak.cycle in names:
            return replace(view, cycle=names.index(peak.cycle), position=peak.position)
        if part.worst is not None:
            return replace(view, cycle=part.worst.cycle, position=part.worst.position)
        return view

    def _worst_of(self, part: int) -> float:
        worst = self.parts[part].worst
        return -1.0 if worst is None else worst.value

    def values(self, view: View) -> FloatArray | None:
        """The field at the part's nodes (n,), None where it is not known."""
        live = self.parts[view.part].live
        if view.field in FATIGUE:
            found = live.fatigue.get(view.field)
            return None if found is None else found.astype(np.float64)
        name = self.cycles[view.cycle].name if self.cycles else ""
        if not live.n_fields or name not in live.coefficients:
            return None
        if view.field == "displacement":
            moved = live.moved(name, view.position)
            return None if moved is None else np.linalg.norm(moved, axis=1)
        stress = live.at(name, view.position)
        return von_mises(stress) if view.field == "mises" else signed_principal(stress)

    def limits(self, view: View) -> tuple[float, float]:
        """Ends of the colours: the same at all positions of a cycle; 0 is among them."""
        low, high = self._range(view)
        if view.field in SIGNED:
            low, high = -max(-low, high), max(-low, high)
        return low, high if high > low else low + 1.0

    def _range(self, view: View) -> tuple[float, float]:
        """Least and largest value of a field over a cycle, and 0."""
        key = view.part, view.cycle, view.field
        if key not in self._ranges:
            rows = [0]
            if self.cycles and view.field not in FATIGUE:
                cycle = self.cycles[view.cycle]
                rows = np.linspace(0, cycle.n - 1, min(cycle.n, _SAMPLES)).round().tolist()
                peaks = self.parts[view.part].live.peaks.get(cycle.name)
                rows += [] if peaks is None else [int(np.argmax(peaks))]
            found = [self.values(replace(view, position=int(row))) for row in rows]
            known = np.concatenate([np.zeros(1), *(each for each in found if each is not None)])
            self._ranges[key] = float(known.min()), float(known.max())
        return self._ranges[key]

    @cached_property
    def _ranges(self) -> dict[tuple[int, int, str], tuple[float, float]]:
        return {}

    def bulge(self, part: int) -> float:
        """By how much displacements are exaggerated where they are drawn."""
        views = [View(part, cycle, field="displacement") for cycle in range(len(self.cycles))]
        largest = max((self._range(view)[1] for view in views), default=0.0)
        return _BULGE * self.parts[part].size / largest if largest else 0.0

    def shape(self, view: View) -> FloatArray:
        """The nodes (n, 3) in the part's frame, displaced if that is asked for, mm."""
        live = self.parts[view.part].live
        name = self.cycles[view.cycle].name if self.cycles else ""
        moved = live.moved(name, view.position) if name in live.coefficients else None
        if moved is None or not view.deformed:
            return live.nodes
        return live.nodes + self.bulge(view.part) * moved

    def told(self, view: View) -> list[str]:
        """Caption of a view, in lines of words."""
        part, (quantity, unit) = self.parts[view.part], FIELDS[view.field]
        lines = [
            f"{brief(self.title, 40)}: {brief(part.name, 40)}",
            quantity + (f" [{unit}]" if unit else ""),
        ]
        if self.cycles:
            cycle = self.cycles[view.cycle]
            where = place_text(float(cycle.position[view.position]))
            shown = f"{brief(cycle.shown_name, 20)} = {where} {brief(cycle.unit, 10)}".rstrip()
            phase = cycle.phase[view.position] if len(cycle.phase) else ""
            lines.append(
                f"{brief(cycle.name, 30)}: {shown}{f', {brief(phase, 24)}' if phase else ''}"
            )
        values = self.values(view)
        if values is None:
            nothing = "nothing loads this part in this cycle"
            lines.append(f"not known: {brief(part.live.missing.get(view.field, nothing), 160)}")
        else:
            most = float(values[np.abs(values).argmax()])
            lines.append(f"largest now: {number(most, 4)} {unit}".rstrip())
            if part.live.n_fields and not part.live.decides:
                lines.append("to look at: no error bar, decides no check")
        if view.deformed:
            lines.append(f"displacements drawn {number(self.bulge(view.part), 2)} times")
        return lines

    def place(self, view: View) -> str:
        """Number of the position shown in the cycle, counted from 1."""
        return f"position {view.position + 1} of {self.cycles[view.cycle].n}"


def scene_of(result: DesignResult) -> Scene:
    """The scene of a result that was computed with its fields (check_design with live=True).

    Raises ValueError for a part without them.
    """
    parts = []
    for part in result.parts:
        if not isinstance(part.live, LiveFields):
            raise ValueError(f"part {part.name!r} has no fields; it was not checked for them")
        live = with_required_safety(part.live, part.required_safety("fatigue"))
        parts.append(ShownPart(part.name, live, _worst(part.name, result)))
    cycles = [
        CycleAxis(
            name,
            cycle["shown_name"],
            cycle["unit"],
            np.asarray(cycle["position"], dtype=np.float64),
            list(cycle["phase"]),
        )
        for name, cycle in result.cycles.items()
    ]
    return Scene(result.name, parts, cycles)


def _worst(part: str, result: DesignResult) -> Worst | None:
    """Largest stress of a part by the peaks of the cycles; None if no cycle has any."""
    found = None
    for k, cycle in enumerate(result.cycles.values()):
        peaks = np.asarray((cycle.get("peaks") or {}).get(part, ()), dtype=np.float64)
        if peaks.size and (found is None or peaks.max() > found.value):
            found = Worst(k, int(peaks.argmax()), float(peaks.max()))
    return found


def write_scene(scene: Scene, folder: Path) -> None:
    """Write a scene to a folder for `read_scene`; raises OSError."""
    tree, pieces = to_record(scene)
    (folder / _TREE).write_text(json.dumps(tree), encoding="utf-8")
    np.savez(folder / _ARRAYS, *[np.asarray(piece) for piece in pieces])


def read_scene(folder: Path) -> Scene:
    """The scene that was written to a folder."""
    tree = json.loads((folder / _TREE).read_text(encoding="utf-8"))
    with np.load(folder / _ARRAYS, allow_pickle=False) as stored:
        scene = from_record(tree, [stored[name] for name in stored.files])
    assert isinstance(scene, Scene)
    return scene


def signed_principal(stress: FloatArray) -> FloatArray:
    """The principal stress of largest size, with its sign (n,), of stress (n, 6), MPa.

    Closed form of the eigenvalues of a symmetric matrix (Smith, CACM 4 (1961) 168).
    """
    xx, yy, zz, xy, yz, zx = stress.T
    mean = (xx + yy + zz) / 3.0
    a, b, c = xx - mean, yy - mean, zz - mean
    size = np.sqrt((a**2 + b**2 + c**2 + 2.0 * (xy**2 + yz**2 + zx**2)) / 6.0)
    third = a * b * c + 2.0 * xy * yz * zx - a * yz**2 - b * zx**2 - c * xy**2
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.nan_to_num(third / (2.0 * size**3))
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)) / 3.0
    high = mean + 2.0 * size * np.cos(angle)
    low = mean + 2.0 * size * np.cos(angle + 2.0 * np.pi / 3.0)
    return np.asarray(np.where(np.abs(high) >= np.abs(low), high, low))
