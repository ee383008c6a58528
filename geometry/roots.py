"""The root of a function of one variable between two places."""

from collections.abc import Callable

_MOST = 200  # steps, for a root at 0, of which no share is anything


def root(function: Callable[[float], float], low: float, high: float, share: float) -> float:
    """Where a continuous function comes to 0 between two places, to a share of the place.

    Chandrupatla's method, which `scipy.optimize.elementwise.find_root` has, too (that takes a
    quarter of a second to load): inverse quadratic interpolation where the last three places allow
    it, halving elsewhere. Raises ValueError where the function has one sign at both ends.
    """
    x1, x2 = low, high
    y1, y2 = function(x1), function(x2)
    if y1 and y2 and (y1 > 0) == (y2 > 0):
        raise ValueError(f"no root between {low:g} and {high:g}: {y1:g} and {y2:g} there")
    x3, y3 = x2, y2
    part = 0.5
    for _ in range(_MOST):
        best = x1 if abs(y1) < abs(y2) else x2
        if y1 == 0 or y2 == 0 or abs(x2 - x1) <= 2 * share * abs(best):
            break
        least = share * abs(best) / abs(x2 - x1)
        x = x1 + min(max(part, least), 1 - least) * (x2 - x1)
        y = function(x)
        if (y > 0) == (y1 > 0):
            x3, y3 = x1, y1
        else:
            x3, y3, x2, y2 = x2, y2, x1, y1
        x1, y1 = x, y
        across, up = (x1 - x2) / (x3 - x2), (y1 - y2) / (y3 - y2)
        part = 0.5
        if up**2 < across and (1 - up) ** 2 < 1 - across:
            part = y1 / (y1 - y2) * y3 / (y3 - y2)
            part += (x3 - x1) / (x2 - x1) * y1 / (y3 - y1) * y2 / (y3 - y2)
    return best
