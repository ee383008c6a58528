"""Missing and redundant joints of a linkage whose mobility is not 1."""

from typing import TYPE_CHECKING

import numpy as np

from loads.bodies import FloatArray
from loads.kinematics import Kinematics

if TYPE_CHECKING:
    from loads.linkage import Linkage

_SINGULAR = 1e-6  # of the largest: the assembled pose may be stated in rounded numbers
_NOTICED = 0.05  # share of a joint in what is held twice


def freedom_problem(linkage: "Linkage") -> str | None:
    """Return the fault of the count of joints, in words; None for one degree of freedom."""
    n_bodies = len(linkage.moving)
    n_constraints = sum(joint.n_constraints for joint in linkage.joints)
    freedom = 3 * n_bodies - n_constraints
    if freedom == 1:
        return None
    count = (
        f"{freedom} degrees of freedom (3 x {n_bodies} bodies - {n_constraints} constraints of "
        f"joints {', '.join(joint.name for joint in linkage.joints) or 'none'}), must be 1"
    )
    kinematics = Kinematics(linkage)
    left, sizes, right = np.linalg.svd(kinematics.joints_jacobian(kinematics.assembled)[0])
    rank = int(np.sum(sizes > _SINGULAR * sizes.max(initial=0.0)))
    if freedom > 1:
        return f"{count}: {freedom - 1} too many, {_missing(linkage, right[rank:])}"
    return f"{count}: {1 - freedom} too few, {_redundant(kinematics, left[:, rank:].T)}"


def _missing(linkage: "Linkage", motions: FloatArray) -> str:
    """Name the bodies that are held least; motions (k, 3 moving) span what can move."""
    ways = {}
    for i, body in enumerate(linkage.moving):
        own = motions[:, 3 * i : 3 * i + 3]
        ways[body.name] = int(np.sum(np.linalg.svd(own, compute_uv=False) > _SINGULAR))
    most = max(ways.values())
    loose = [name for name in ways if ways[name] == most]
    told = []
    for name in loose:
        held = [j.name for j in linkage.joints if name in (j.body_a, j.body_b)]
        told.append(f"{name!r} ({'only joint' if len(held) == 1 else 'joints'} {', '.join(held)})")
        if not held:
            told[-1] = f"{name!r} (no joint)"
    one = len(told) == 1
    return (
        f"a joint or guide is missing on body {told[0]}"
        if one
        else f"a joint or guide is missing on one of the bodies {', '.join(told)}"
    ) + (f", which can move in {most} ways" if most > 1 else "")


def _redundant(kinematics: Kinematics, stresses: FloatArray) -> str:
    """Name the joints that hold the same motion; stresses (k, constraints) balance themselves."""
    if not len(stresses):
        return "nothing can move: a joint is one too many"
    shares = {
        name: float(np.linalg.norm(stresses[:, rows])) for name, rows in kinematics.rows.items()
    }
    names = sorted((n for n in shares if shares[n] > _NOTICED), key=lambda n: -shares[n])
    return (
        f"joints {', '.join(names)} hold the same motion: one of them is stated twice or too many"
    )
