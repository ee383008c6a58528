"""A scene of the interactive window, from a result and through a folder to another process."""

import json
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from checks.result.live_fields import LiveFields, LivePeak, with_required_safety
from checks.result.motion import Motion
from checks.result.verdict import DesignResult
from reports.window_scene import Scene, ShownCycle, ShownPart, Worst

_TREE, _ARRAYS = "scene.json", "scene.npz"
_MARK = "$array"


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
    order = {part.name: k for k, part in enumerate(parts)}
    cycles = [
        _cycle(name, cycle, result.motion.get(name), order) for name, cycle in result.cycles.items()
    ]
    return Scene(result.name, parts, cycles)


def _worst(part: str, result: DesignResult) -> Worst | None:
    """Where a part's stress is largest, from the peaks of the cycles; None where nobody knows."""
    found = None
    for k, cycle in enumerate(result.cycles.values()):
        peaks = np.asarray((cycle.get("peaks") or {}).get(part, ()), dtype=np.float64)
        if peaks.size and (found is None or peaks.max() > found.value):
            found = Worst(k, int(peaks.argmax()), float(peaks.max()))
    return found


def _cycle(
    name: str, cycle: Mapping[str, Any], motion: Motion | None, order: Mapping[str, int]
) -> ShownCycle:
    shown = ShownCycle(
        name,
        cycle["shown_name"],
        cycle["unit"],
        np.asarray(cycle["position"], dtype=np.float64),
        list(cycle["phase"]),
    )
    if motion is None:
        return shown
    return replace(
        shown,
        index=np.asarray(motion.index, dtype=np.float64),
        frames={order[part]: frame for part, frame in motion.parts.items() if part in order},
        layers={order[part]: layer for part, layer in motion.layer.items() if part in order},
        pins=[
            (order[pin.on], pin.place, pin.force, pin.z)
            for pin in motion.pins.values()
            if pin.on in order
        ],
    )


def write_scene(scene: Scene, folder: Path) -> None:
    """Write a scene to a folder for `read_scene`; raises OSError."""
    arrays: dict[str, Any] = {}

    def plain(thing: Any) -> Any:
        if isinstance(thing, np.ndarray):
            arrays[f"a{len(arrays)}"] = thing
            return {_MARK: f"a{len(arrays) - 1}"}
        if isinstance(thing, Mapping):
            return [[key, plain(value)] for key, value in thing.items()]
        if isinstance(thing, list | tuple):
            return [plain(each) for each in thing]
        if isinstance(thing, LiveFields | LivePeak | ShownPart | ShownCycle | Worst):
            return {field.name: plain(getattr(thing, field.name)) for field in fields(thing)}
        return thing.item() if isinstance(thing, np.generic) else thing

    tree = {"title": scene.title, "parts": plain(scene.parts), "cycles": plain(scene.cycles)}
    (folder / _TREE).write_text(json.dumps(tree), encoding="utf-8")
    np.savez(folder / _ARRAYS, **arrays)


def read_scene(folder: Path) -> Scene:
    """The scene that was written to a folder."""
    tree = json.loads((folder / _TREE).read_text(encoding="utf-8"))
    with np.load(folder / _ARRAYS, allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}

    def made(thing: Any) -> Any:
        if isinstance(thing, dict):
            if _MARK in thing:
                return arrays[thing[_MARK]]
            return {key: made(value) for key, value in thing.items()}
        return [made(each) for each in thing] if isinstance(thing, list) else thing

    parts = [_part_of(made(part)) for part in tree["parts"]]
    return Scene(tree["title"], parts, [_cycle_of(made(cycle)) for cycle in tree["cycles"]])


def _part_of(tree: dict[str, Any]) -> ShownPart:
    live = tree["live"]
    for name in ("coefficients", "peaks", "fatigue", "missing"):
        live[name] = dict(live[name])
    live["notes"] = tuple(live["notes"])
    live["peak"] = None if live["peak"] is None else LivePeak(**live["peak"])
    worst = None if tree["worst"] is None else Worst(**tree["worst"])
    return ShownPart(tree["name"], LiveFields(**live), worst)


def _cycle_of(tree: dict[str, Any]) -> ShownCycle:
    for name in ("frames", "layers"):
        tree[name] = None if tree[name] is None else dict(tree[name])
    tree["pins"] = [tuple(pin) for pin in tree["pins"]]
    return ShownCycle(**tree)
