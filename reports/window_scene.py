"""Scene of the interactive window: parts with their fields, cycles, motion, and the view of them.

Plain arrays and no graphics; `reports.window_files` takes it to the window's own process.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from checks.result.live_fields import FATIGUE, LiveFields, von_mises
from checks.result.motion import between
from checks.result.words import brief, number, place_text

FloatArray = npt.NDArray[np.float64]

LINKAGE = -1  # in place of a part: all of them, where they are in the machine
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


@dataclass(frozen=True)
class Worst:
    """Where a part is stressed most: number of the cycle, position of it, MPa."""

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
class ShownCycle:
    """A cycle's positions, and how the parts move: frames (k, 3), pins (on, place, force, z)."""

    name: str
    shown_name: str
    unit: str
    position: FloatArray
    phase: Sequence[str]
    index: FloatArray | None = None
    frames: Mapping[int, FloatArray] | None = None
    layers: Mapping[int, float] | None = None
    pins: Sequence[tuple[int, FloatArray, FloatArray, float]] = ()

    @property
    def n(self) -> int:
        """Number of positions."""
        return len(self.position)


@dataclass(frozen=True)
class View:
    """View of a scene: part (or LINKAGE), cycle, position in it, field, deformed, bands."""

    part: int
    cycle: int = 0
    position: int = 0
    field: str = "mises"
    deformed: bool = False
    bands: bool = False


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that the window can show."""

    title: str
    parts: Sequence[ShownPart]
    cycles: Sequence[ShownCycle]

    def first_view(self, part: str | None = None) -> View:
        """Where to begin: the part that is asked for, else one with stress, at its peak."""
        k = next((k for k, shown in enumerate(self.parts) if shown.name == part), None)
        if k is None:
            k = next((k for k, p in enumerate(self.parts) if p.live.peak is not None), None)
        if k is None:
            k = max(range(len(self.parts)), key=self._worst_of)
        return self.at_peak(View(k))

    def at_peak(self, view: View) -> View:
        """The view at the worst position of the worst part that is shown.

        Of parts that all are grey it is where the checks found their largest stress.
        """
        peaks = [p for k in self.shown(view) if (p := self.parts[k].live.peak) is not None]
        if not peaks:
            k = max(self.shown(view), key=self._worst_of, default=None)
            worst = None if k is None else self.parts[k].worst
            if worst is None:
                return view
            return replace(view, cycle=worst.cycle, position=worst.position)
        peak = max(peaks, key=lambda each: each.value)
        cycle = next((k for k, c in enumerate(self.cycles) if c.name == peak.cycle), None)
        return view if cycle is None else replace(view, cycle=cycle, position=peak.position)

    def _worst_of(self, part: int) -> float:
        worst = self.parts[part].worst
        return -1.0 if worst is None else worst.value

    def shown(self, view: View) -> list[int]:
        """The parts that a view shows."""
        if view.part != LINKAGE:
            return [view.part]
        frames = self.cycles[view.cycle].frames if self.cycles else None
        return sorted(frames or {})

    @property
    def moves(self) -> bool:
        """True if the parts' motion is known in any cycle."""
        return any(cycle.frames for cycle in self.cycles)

    def values(self, part: int, view: View) -> FloatArray | None:
        """The field at the part's nodes (n,), None where it is not known."""
        key = (part, view.cycle, view.position, view.field)
        if key not in self._known:
            if len(self._known) > 2 * len(self.parts):
                self._known.clear()
            self._known[key] = self._values(part, view)
        return self._known[key]

    @cached_property
    def _known(self) -> dict[tuple[int, int, int, str], FloatArray | None]:
        return {}

    def _values(self, part: int, view: View) -> FloatArray | None:
        live = self.parts[part].live
        if view.field in FATIGUE:
            found = live.fatigue.get(view.field)
            return None if found is None else found.astype(np.float64)
        if view.field == "displacement":
            moved = self._moved(part, view)
            return None if moved is None else np.linalg.norm(moved, axis=1)
        stress = self._stress(part, view)
        if stress is None:
            return None
        return von_mises(stress) if view.field == "mises" else signed_principal(stress)

    def why_not(self, part: int, view: View) -> str:
        """Why a field is not known, in words."""
        live = self.parts[part].live
        if view.field in live.missing:
            return live.missing[view.field]
        return "nothing loads this part in this cycle"

    def limits(self, view: View) -> tuple[float, float]:
        """Ends of the colours: the same at all positions of a cycle."""
        found = [
            self._range(part, view.cycle, view.field)
            for part in self.shown(view)
            if self.values(part, view) is not None
        ]
        low = min((low for low, _ in found), default=0.0)
        high = max((high for _, high in found), default=0.0)
        if view.field in SIGNED:
            most = max(-low, high)
            low, high = -most, most
        return (low, high) if high > low else (low, low + 1.0)

    def _range(self, part: int, cycle: int, name: str) -> tuple[float, float]:
        """Least (0 counts) and largest value of a field of a part over a cycle."""
        key = (part, cycle, name)
        if key not in self._ranges:
            low, high = 0.0, 0.0
            n = self.cycles[cycle].n if self.cycles else 1
            rows = [*np.linspace(0, n - 1, min(n, _SAMPLES)).round().astype(int).tolist()]
            peaks = self._peaks(part, cycle)
            rows += [int(np.argmax(peaks))] if peaks is not None else []
            for row in rows if name not in FATIGUE else [0]:
                values = self.values(part, View(part, cycle, row, name))
                if values is not None and len(values):
                    low, high = min(low, float(values.min())), max(high, float(values.max()))
            self._ranges[key] = low, high
        return self._ranges[key]

    @cached_property
    def _ranges(self) -> dict[tuple[int, int, str], tuple[float, float]]:
        return {}

    def _peaks(self, part: int, cycle: int) -> FloatArray | None:
        return self.parts[part].live.peaks.get(self.cycles[cycle].name) if self.cycles else None

    def bulge(self, part: int) -> float:
        """By how much displacements are exaggerated where they are drawn."""
        largest = max(
            (self._range(part, k, "displacement")[1] for k in range(len(self.cycles))), default=0.0
        )
        return _BULGE * self.parts[part].size / largest if largest else 0.0

    def shape(self, part: int, view: View) -> FloatArray:
        """The nodes (n, 3) in the part's frame, displaced if that is asked for, mm."""
        live = self.parts[part].live
        moved = self._moved(part, view) if view.deformed else None
        return live.nodes if moved is None else live.nodes + self.bulge(part) * moved

    def matrix(self, part: int, view: View) -> FloatArray:
        """From the part's frame to the picture's (4, 4): the machine's for the linkage."""
        result = np.eye(4)
        if view.part != LINKAGE:
            return result
        cycle = self.cycles[view.cycle]
        assert cycle.frames is not None
        assert cycle.layers is not None
        x, y, angle = between(cycle.frames[part], self._row(view))
        c, s = np.cos(angle), np.sin(angle)
        result[:2, :2] = [[c, -s], [s, c]]
        result[:3, 3] = x, y, cycle.layers[part]
        return result

    def pins(self, view: View) -> list[tuple[FloatArray, FloatArray]]:
        """Places (3,) mm and forces (3,) N at the pins, in the frame of the picture."""
        cycle = self.cycles[view.cycle] if self.cycles else None
        if cycle is None or cycle.frames is None:
            return []
        row = self._row(view)
        found = []
        for on, places, forces, z in cycle.pins:
            if view.part not in (LINKAGE, on):
                continue
            place = np.array([*between(places, row), z])
            force = np.array([*between(forces, row), 0.0])
            if view.part != LINKAGE:
                turn = np.linalg.inv(self.matrix(on, replace(view, part=LINKAGE)))
                place, force = (turn @ [*place, 1.0])[:3], turn[:3, :3] @ force
            found.append((place, force))
        return found

    def largest_force(self, view: View) -> float:
        """Of all pins over the cycle, N: the longest arrow."""
        pins = self.cycles[view.cycle].pins if self.cycles else ()
        return max((float(np.hypot(*force.T).max()) for _, _, force, _ in pins), default=0.0)

    def peak(self, view: View) -> tuple[int, int, float] | None:
        """Part, node and value where the field is largest (in size) now; None without a field."""
        best: tuple[int, int, float] | None = None
        for part in self.shown(view):
            values = self.values(part, view)
            if values is not None and len(values):
                node = int(np.abs(values).argmax())
                if best is None or abs(values[node]) > abs(best[2]):
                    best = part, node, float(values[node])
        return best

    def told(self, view: View) -> list[str]:
        """Caption of a view, in lines of words."""
        what = (
            "the whole linkage" if view.part == LINKAGE else brief(self.parts[view.part].name, 40)
        )
        quantity, unit = FIELDS[view.field]
        lines = [f"{brief(self.title, 40)}: {what}", quantity + (f" [{unit}]" if unit else "")]
        if self.cycles:
            cycle = self.cycles[view.cycle]
            where = place_text(float(cycle.position[view.position]))
            shown = f"{brief(cycle.shown_name, 20)} = {where} {brief(cycle.unit, 10)}".rstrip()
            phase = cycle.phase[view.position] if len(cycle.phase) else ""
            lines.append(
                f"{brief(cycle.name, 30)}: {shown}{f', {brief(phase, 24)}' if phase else ''}"
            )
        peak = self.peak(view)
        if peak is None:
            reasons = dict.fromkeys(self.why_not(part, view) for part in self.shown(view))
            lines += [f"not known: {brief(why, 160)}" for why in reasons]
        else:
            on = f" on {brief(self.parts[peak[0]].name, 30)}" if view.part == LINKAGE else ""
            lines.append(f"largest now{on}: {number(peak[2], 4)} {unit}".rstrip())
        if peak is not None:
            lines += self._undecided(view)
        if view.deformed and view.part != LINKAGE:
            lines.append(f"displacements drawn {number(self.bulge(view.part), 2)} times")
        return lines

    def _undecided(self, view: View) -> list[str]:
        """Say of stress that was computed to be looked at only that no check rests on it."""
        shown = [k for k in self.shown(view) if self.parts[k].live.n_fields]
        names = [self.parts[k].name for k in shown if not self.parts[k].live.decides]
        if not names:
            return []
        of = "" if len(names) == len(shown) else f" (of {brief(', '.join(names), 60)})"
        return [f"to look at{of}: no error bar, decides no check"]

    def place(self, view: View) -> str:
        """Which of the cycle's positions is shown, as people count."""
        return f"position {view.position + 1} of {self.cycles[view.cycle].n}"

    def _row(self, view: View) -> float:
        cycle = self.cycles[view.cycle]
        assert cycle.index is not None
        return float(np.interp(view.position, cycle.index, np.arange(len(cycle.index))))

    def _weights(self, part: int, view: View) -> FloatArray | None:
        live = self.parts[part].live
        name = self.cycles[view.cycle].name if self.cycles else ""
        if name not in live.coefficients or not live.n_fields:
            return None
        return live.coefficients[name][:, view.position]

    def _stress(self, part: int, view: View) -> FloatArray | None:
        weights = self._weights(part, view)
        if weights is None:
            return None
        return np.tensordot(weights, self.parts[part].live.stress, axes=1)

    def _moved(self, part: int, view: View) -> FloatArray | None:
        weights, unit = self._weights(part, view), self.parts[part].live.displacement
        return None if weights is None or unit is None else np.tensordot(weights, unit, axes=1)


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
