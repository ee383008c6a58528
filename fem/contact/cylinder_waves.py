"""Waves of pressure around and along a round bore in a body, and a round bar: how they give way.

Pressure p cos(n a) cos(k z) on a cylinder of radius R, three-dimensional elasticity. Three
solutions of Navier's equations, with F = I_n(k r) in a bar and K_n(k r) around a bore:

    2 G u = -grad(F cos(n a) cos(k z))
    2 G u = 4 (1 - nu) B - grad(r B_r),  B = F_(n+1) (cos(n a), sin(n a), 0) cos(k z)
    2 G u = curl(0, 0, F sin(n a) cos(k z))

(the first two are Papkovich's and Neuber's, B harmonic as B_x + i B_y is F_(n+1) exp(i (n + 1) a)).
Their sum has the pressure and no shear on the cylinder. As k falls the plane's closed forms in
plane strain return (fem/contact/hats.py), but for n = 1: a bore moves as log(1/(k R)), a bar bends.
A bush in the bore has those of a bar and of a bore, both, and is bonded to the bore.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyval

from geometry.mesh import FloatArray, IntArray

_GAUSS = np.polynomial.legendre.leggauss(8)
_SHORT = 40  # n, or k R of waves along, from which the series does, to 1e-12
_FADED = 300.0  # exponent of what crosses no bush


@dataclass(frozen=True)
class Lining:
    """A bush in a bore.

    ratio  of its outer to its inner radius, above 1
    """

    ratio: float
    youngs_modulus: float
    poisson_ratio: float


def shear_of_bar(poisson_ratio: float) -> float:
    """E A/(G A_s) of a round bar as a Timoshenko beam that pressure p cos(a) bends.

    The limit of `bar_waves` of n = 1 beside 4/(k R)^4, which is 1/(E I k^4), for long waves. Less
    than Cowper's (7 + 6 nu)/3 of a force that is spread over the section: pressed at the rim the
    section narrows across, which bends the bar back.
    """
    return (7 - 8 * poisson_ratio**2) / (3 * (1 + poisson_ratio))


def bore_waves(last: int, x: FloatArray, poisson_ratio: float) -> FloatArray:
    """Outward displacement (last + 1, m) of a bore, over p R/E, of waves n along x = k R (m,)."""
    return _radial(_decaying(last, x), x, poisson_ratio)


def bar_waves(last: int, x: FloatArray, poisson_ratio: float) -> FloatArray:
    """Inward displacement (last + 1, m) of a bar over p R/E, as `bore_waves`."""
    return -_radial(_growing(last, x), x, poisson_ratio)


def local_bar_waves(last: int, x: FloatArray, poisson_ratio: float) -> FloatArray:
    """`bar_waves` without what a bar moves as a beam: 1/(E I k^4) + 1/(G A_s k^2)."""
    found = bar_waves(last, x, poisson_ratio)
    found[1] -= 4 / x**4 + shear_of_bar(poisson_ratio) / x**2
    return found


def lined_bore_waves(
    last: int, x: FloatArray, youngs_modulus: float, poisson_ratio: float, lining: Lining
) -> FloatArray:
    """`bore_waves`, over p R/E of the bore's own E, of a bore with a bush bonded into it.

    R is the inner radius of the bush, where the pressure acts.
    """
    thick, outer = lining.ratio, lining.ratio * x
    shear = (1 + lining.poisson_ratio) / (1 + poisson_ratio)  # modulus of bore over bush
    shear *= youngs_modulus / lining.youngs_modulus
    around, around_stress = _fields(_decaying(last, outer), outer, poisson_ratio)
    system = np.zeros((last + 1, len(x), 9, 9))  # no shear inside; both move and pull as one
    system[..., 3:6, 6:], system[..., 6:, 6:] = -around, -around_stress / thick
    inward = np.empty((last + 1, len(x), 6))
    for first, slope in ((0, _decaying), (3, _growing)):
        change = _change(partial(slope, last), x, thick)
        far = np.stack([change[:-1] / thick, change[1:], change[:-1] / thick], axis=-1)
        near = np.ones_like(far)  # each is 1 where it is largest
        if slope is _growing:
            near, far = 1 / far, near
        own = slice(first, first + 3)
        moves, stress = _fields(slope(last, x), x, lining.poisson_ratio)
        inward[..., own] = moves[..., 0, :] * near
        system[..., :3, own] = stress * near[..., None, :]
        moves, stress = _fields(slope(last, outer), outer, lining.poisson_ratio)
        system[..., 3:6, own] = moves * far[..., None, :] * shear
        system[..., 6:, own] = stress * far[..., None, :] / thick
    system[0, :, [1, 4, 7]] = 0.0  # without a turn around, nothing twists
    system[0, :, [1, 4, 7], [2, 5, 8]] = 1.0
    right = np.zeros((*system.shape[:2], 9, 1))
    right[..., 0, 0] = -1.0
    amounts = np.linalg.solve(system, right)[..., :6, 0]
    return np.asarray((1 + poisson_ratio) * shear * (inward * amounts).sum(axis=-1))


def _decaying(last: int, x: FloatArray) -> FloatArray:
    """Slope x K_n'/K_n (last + 2, m), around a bore."""
    numbers = np.arange(last + 2)[:, None]
    found = _short(numbers, x, -1.0)
    some = x < _SHORT
    if not some.any():
        return found
    x = x[some]
    ratio = np.empty((min(last + 2, _SHORT), len(x)))  # K_(n+1)/K_n
    turn = np.linspace(0.0, 12.0, 1201)  # K_n(x) = integral of exp(-x cosh t) cosh(n t)
    falling = np.exp(-np.outer(x, np.cosh(turn) - 1))
    falling[:, 0] /= 2
    ratio[0] = falling @ np.cosh(turn) / falling.sum(axis=1)
    for n in range(1, len(ratio)):
        ratio[n] = 2 * n / x + 1 / ratio[n - 1]
    found[: len(ratio), some] = numbers[: len(ratio)] - x * ratio
    return found


def _growing(last: int, x: FloatArray) -> FloatArray:
    """Slope x I_n'/I_n (last + 2, m), in a bar."""
    found = _short(np.arange(last + 2)[:, None], x, 1.0)
    some = x < _SHORT
    if not some.any():
        return found
    x = x[some]
    ratio = (_short(np.array([[_SHORT]]), x, 1.0)[0] - _SHORT) / x  # I_(n+1)/I_n
    for n in range(_SHORT - 1, -1, -1):
        ratio = 1 / (2 * (n + 1) / x + ratio)
        if n < last + 2:
            found[n, some] = n + x * ratio
    return found


def _short(numbers: IntArray, x: FloatArray, side: float) -> FloatArray:
    """Slope x F'/F (k, m) of waves n (k, 1) that are short, of a bar (side 1) or a bore (-1).

    x L' + L^2 = n^2 + x^2 = s^2 by Bessel's equation, so L = sum l_k(t)/(side s)^k from k = -1,
    t = n^2/s^2: l_-1 = 1, 2 l_(k+1) = k (1 - t) l_k + 2 t (1 - t) l_k' - sum_(i+j=k) l_i l_j.
    """
    size = side * np.hypot(numbers, x)
    t = (numbers / size) ** 2
    found = np.zeros_like(t)
    for term in reversed(_SERIES[1:]):
        found = found / size + polyval(t, term)
    return np.asarray(found + size)


def _series(count: int) -> list[FloatArray]:
    """Coefficients of the l_k of `_short`, from k = -1."""
    t = Polynomial([0.0, 1.0])
    found = [Polynomial([1.0])]
    for k in range(-1, count - 2):
        last, inner = found[-1], found[1:]
        twice = (1 - t) * (k * last + 2 * t * last.deriv())
        twice -= sum((a * b for a, b in zip(inner, reversed(inner), strict=True)), 0 * t)
        found.append(twice / 2)
    return [np.asarray(term.coef) for term in found]


_SERIES = _series(9)


def _change(slope: Callable[[FloatArray], FloatArray], x: FloatArray, ratio: float) -> FloatArray:
    """F(ratio x)/F(x) (last + 2, m), as its logarithm rises by x F'/F per log(x)."""
    steps = np.log(ratio) * (1 + _GAUSS[0]) / 2
    rise = sum(
        weight * slope(x * np.exp(step)) for step, weight in zip(steps, _GAUSS[1], strict=True)
    )
    return np.asarray(np.exp(np.clip(np.log(ratio) / 2 * rise, -_FADED, _FADED)))


def _radial(slope: FloatArray, x: FloatArray, nu: float) -> FloatArray:
    """Outward displacement over p R/E, by x F_n'/F_n (last + 2, m) on the cylinder; R = 1."""
    moves, system = _fields(slope, x, nu)
    system[0, :, 1] = 0.0, 0.0, 1.0  # without a turn around, nothing twists
    right = np.zeros((*system.shape[:2], 3, 1))
    right[..., 0, 0] = -1.0
    amounts = np.linalg.solve(system, right)[..., 0]
    return np.asarray((1 + nu) * (moves[..., 0, :] * amounts).sum(axis=-1))


def _fields(slope: FloatArray, x: FloatArray, nu: float) -> tuple[FloatArray, FloatArray]:
    """2 G u and stress on the cylinder (last + 1, m, 3, 3) of the solutions, by x F_n'/F_n; R = 1.

    Rows: r, around, along. Columns: solutions, whose F or B is 1. Shear stress twice.
    """
    n = np.arange(len(slope) - 1, dtype=float)[:, None]
    one, none = np.ones_like(slope[:-1]), np.zeros_like(slope[:-1])
    f1 = slope[:-1]
    f2 = n**2 + x**2 - f1  # Bessel's equation
    h1 = slope[1:]
    h2 = (n + 1) ** 2 + x**2 - h1
    rise = 4 * (1 - nu)
    u = [-f1, rise - 1 - h1, n * one]
    du = [-f2, (rise - 2) * h1 - h2, n * (f1 - 1)]
    v = [n * one, (rise + n) * one, -f1]
    dv = [n * (f1 - 1), (rise + n) * h1, -f2]
    w = [x * one, x * one, none]
    dw = [x * f1, x * (1 + h1), none]
    pulls = []
    for k in range(3):
        volume = du[k] + u[k] + n * v[k] + x * w[k]
        around = dv[k] - v[k] - n * u[k]
        pulls.append([du[k] + nu / (1 - 2 * nu) * volume, around, dw[k] - x * u[k]])
    return _rows([list(three) for three in zip(u, v, w, strict=True)]), _rows(pulls)


def _rows(columns: list[list[FloatArray]]) -> FloatArray:
    return np.moveaxis(np.array(columns), (0, 1), (-1, -2))
