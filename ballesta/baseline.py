"""A small, readable record of what a design's numbers are, to notice when they change."""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from reports.verdict import DesignResult

# The same versions repeat to 1e-9; another processor's arithmetic may move the last digits.
BAND = 1e-4


def baseline_of(result: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of a result, as plain data (`DesignResult.to_dict`), that a baseline keeps."""
    parts = {
        part["name"]: {
            "mass [kg]": part["facts"]["mass [kg]"],
            "checks": _checks(part["checks"]),
        }
        for part in result["parts"]
    }
    return {
        "format": "ballesta-baseline/1",
        "design": result["name"],
        "status": result["status"],
        "band": BAND,
        "largest efforts [N]": {
            name: {force: max(values, key=abs) for force, values in cycle["efforts"].items()}
            for name, cycle in result["cycles"].items()
        },
        "parts": parts,
        "linkage": _checks(result["linkage"]),
    }


def _checks(checks: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Value, limit and status of checks by kind and quantity."""
    return {
        f"{check['kind']}: {check['quantity']}": {
            "value": check["value"],
            "limit": check["limit"],
            "status": check["status"],
        }
        for check in checks
    }


def baseline_path(design_file: str | Path) -> Path:
    """Where a design's baseline stands: beside it."""
    path = Path(design_file)
    return path.with_name(f"{path.stem}.baseline.json")


def write_baseline(result: DesignResult) -> Path:
    """Write the baseline beside the design, whole or not at all; returns its path."""
    path = baseline_path(result.file)
    text = json.dumps(baseline_of(result.to_dict()), indent=1, allow_nan=False)
    temporary = path.with_name(path.name + ".tmp")
    temporary.write_text(text + "\n", encoding="utf-8")
    os.replace(temporary, path)
    return path


def differences(baseline: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return what has left the baseline: a line per quantity with baseline, now and the band."""
    band = float(baseline["band"])
    before, after = dict(_flat(baseline)), dict(_flat(now))
    lines = []
    for key in sorted(set(before) | set(after)):
        old, new = before.get(key), after.get(key)
        if isinstance(old, float) and isinstance(new, float):
            if abs(new - old) > band * max(abs(old), 1e-9):
                lines.append(f"{key}: baseline {old:.8g}, now {new:.8g}, band {band:g} of it")
        elif old != new:
            lines.append(f"{key}: baseline {old!r}, now {new!r}")
    return lines


def _flat(value: Any, key: str = "") -> list[tuple[str, Any]]:
    if isinstance(value, Mapping):
        return [pair for k, v in value.items() for pair in _flat(v, f"{key} / {k}" if key else k)]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return [(key, float(value) if number else value)]
