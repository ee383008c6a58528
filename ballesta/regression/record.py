"""Record of a result for its baseline: plain data, with the rung that decided each check."""

from collections.abc import Mapping, Sequence
from typing import Any

KINDS = ("static", "fatigue", "buckling")  # of checks that the rungs of the ladder decide
MASS = "mass [kg]"
LINKAGE = "linkage"
LADDER = ("formula", "solid")
# The one buckling check that is a rung's, as `checks.columns.stability.ELASTIC_SHARE` has it (a
# test compares them): its import would bring the solvers into every run of pytest.
ELASTIC_SHARE = "elastic load share"
_DIGITS = 12  # hex digits of a digest that a reader can still compare by eye


def record_of(
    result: Mapping[str, Any], stages: Mapping[str, str], accuracy: float
) -> dict[str, Any]:
    """The numbers of a result, as plain data (`DesignResult.to_dict`), that a baseline keeps.

    stages    digest of what the result was made from, by stage (`fingerprints.stages_of`)
    accuracy  numerical error, as a share, that the design asks its meshes for
    """
    return {
        "design": result["name"],
        "status": result["status"],
        "accuracy": accuracy,
        "parts": {
            part["name"]: {
                MASS: part["facts"][MASS],
                "rungs": rungs_of(part),
                "checks": _checks(part["checks"]),
            }
            for part in result["parts"]
        },
        LINKAGE: _checks(result[LINKAGE]),
        "stages": {stage: digest[:_DIGITS] for stage, digest in stages.items()},
    }


def rungs_of(part: Mapping[str, Any]) -> dict[str, str]:
    """The rung that decided each kind of check of a part.

    Where a solid was solved, kinds without an answer are the solid's: it was asked for them.
    """
    rungs = {
        check["kind"]: _rung(check)
        for check in part["checks"]
        if check["kind"] in KINDS
        and _rung(check) in LADDER
        and (check["kind"] != "buckling" or check["quantity"] == ELASTIC_SHARE)
    }
    if any(tried["rung"] == "solid" and tried["unknowns"] for tried in part["rungs"]):
        rungs = {kind: rungs.get(kind, "solid") for kind in KINDS}
    return rungs


def has_new_solid(
    rungs: Mapping[str, Mapping[str, str]], found: Mapping[str, Mapping[str, str]]
) -> bool:
    """True if a solid decided a kind that was not pinned to it: pinned, it is refined otherwise."""
    return any(
        "solid" in kinds.values() and dict(rungs.get(part, {})) != dict(kinds)
        for part, kinds in found.items()
    )


def _checks(checks: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Checks by kind and quantity; equal names are numbered, so that none is lost."""
    kept: dict[str, dict[str, Any]] = {}
    for check in checks:
        name = key = f"{check['kind']}: {check['quantity']}"
        number = 1
        while key in kept:
            number += 1
            key = f"{name} ({number})"
        kept[key] = {
            "value": check["value"],
            "unit": check["unit"],
            "safety": check["safety"],
            "status": check["status"],
            "rung": _rung(check),
            "numerical": _share(check),
            "above": check["model"],
            "below": check["model_below"],
            "limit": check["limit"],
            "required": check["required"],
        }
    return kept


def _rung(check: Mapping[str, Any]) -> str:
    """The rung of a check's method, such as "solid (two meshes)"."""
    return str(check["method"]).split(maxsplit=1)[0]


def verdicts_of(record: Mapping[str, Any]) -> dict[tuple[str, str], str]:
    """The verdict of every check of a record, by part and check."""
    named = {name: part["checks"] for name, part in record["parts"].items()}
    return {
        (name, key): check["status"]
        for name, checks in (named | {LINKAGE: record[LINKAGE]}).items()
        for key, check in checks.items()
    }


def _share(check: Mapping[str, Any]) -> float | None:
    """Numerical error bar over the value, None where it is not known."""
    if check["numerical"] is None:
        return None
    return float(check["numerical"] / check["value"]) if check["value"] else 0.0
