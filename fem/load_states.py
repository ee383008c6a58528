"""Which position of a cycle buckles first, without solving all of them.

The geometric stiffness is linear in the unit loads. The modes of a few load states that all
positions are made of, of either sign, are displacement fields that the part could take at any; the
largest mu of -K_s x = mu K x among them, at every position, is never above the true one (Rayleigh
and Ritz), and close to it where the part buckles alike. The position where it is largest is solved
next, its modes join, until the position that looks worst has been solved. The reported factor is a
solved one; that no other position has a lower one is not proved but sought.
"""

from collections.abc import Callable, Sequence

import numpy as np

from geometry.mesh import FloatArray

_MOST = 6  # positions that are solved
_TIE = 1e-6  # shares that are closer are equal: the first position is named
_PATTERNS = 4  # load states whose modes are taken to begin with
_SMALL = 0.1  # of the largest state: what is left of all states counts as known


def leading_states(measure: FloatArray, coefficients: FloatArray) -> list[FloatArray]:
    """Load states (n_basis,) that those of all positions are made of, to a tenth of the largest.

    What each position adds to the ones before it, the largest first.

    measure       (m, n_basis) of each unit load: a state's size is the norm of its combination
    coefficients  (n_basis, n) of the unit loads at the positions
    """
    left = np.linalg.qr(measure, mode="r") @ coefficients
    states = coefficients.copy()
    largest = float(np.linalg.norm(left, axis=0).max(initial=0.0))
    found: list[FloatArray] = []
    while largest > 0.0 and len(found) < _PATTERNS:
        sizes = np.linalg.norm(left, axis=0)
        most = int(sizes.argmax())
        if sizes[most] < _SMALL * largest:
            break
        found.append(states[:, most].copy())
        along = (left[:, most] @ left) / sizes[most] ** 2
        states -= np.outer(found[-1], along)
        left -= np.outer(left[:, most].copy(), along)
    return found


def worst_position(
    solve: Callable[[int], tuple[float, FloatArray]],
    shares: Callable[[FloatArray], FloatArray],
    fields: Sequence[FloatArray],
    *,
    starts: Sequence[int] = (),
    close: float,
) -> tuple[int, float] | None:
    """Return the position with the largest share of its buckling load found, and the share.

    solve   a position's share of its lowest buckling load, 0 without one, and its modes (m, k)
    shares  fields (m, k) to the share (n,) that each position has at least
    fields  (m, k) each, of the leading states
    starts  positions solved first
    close   an estimate that is this near the largest share asks for no further position

    None where no position buckles.
    """
    known, solved = list(fields), dict[int, float]()
    waiting = list(dict.fromkeys(starts))
    while len(solved) < _MOST:
        if not waiting:
            together = np.hstack(known) if known else np.zeros((0, 0))
            if not together.shape[1]:
                break
            estimates = shares(together)
            estimates[list(solved)] = 0.0
            likely = int(np.argmax(estimates))
            if not close * estimates[likely] > max(solved.values(), default=0.0):
                break
            waiting.append(likely)
        position = waiting.pop(0)
        solved[position], modes = solve(position)
        known.append(modes)
    largest = max(solved.values(), default=0.0)
    if not largest > 0.0:
        return None
    worst = min(k for k, share in solved.items() if share * (1.0 + _TIE) >= largest)
    return worst, solved[worst]
