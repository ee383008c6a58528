"""Waves of pressure around and along a round bore in a body, and a round bar: how they give way.

Pressure p cos(n a) cos(k z) on a cylinder of radius R, three-dimensional elasticity. Three
solutions of Navier's equations, with F = I_n(k r) in a bar and K_n(k r) around a bore:

    2 G u = -grad(F cos(n a) cos(k z))
    2 G u = 4 (1 - nu) B - grad(r B_r),  B = F_(n+1) (cos(n a), sin(n a), 0) cos(k z)
    2 G u = curl(0, 0, F sin(n a) cos(k z))

(the first two are Papkovich's and Neuber's, B harmonic as B_x + i B_y is F_(n+1) exp(i (n + 1) a)).
Their sum has the pressure and no shear on the cylinder. As k falls the plane's closed forms in
plane strain return (fem/contact/hats.py), but for n = 1: a bore moves as log(1/(k R)), a bar bends.
"""

import numpy as np

from geometry.mesh import FloatArray


def shear_of_bar(poisson_ratio: float) -> float:
    """E A/(G A_s) of a round bar as a Timoshenko beam that pressure p cos(a) bends.

    The limit of `bar_waves` of n = 1 beside 4/(k R)^4, which is 1/(E I k^4), for long waves. Less
    than Cowper's (7 + 6 nu)/3 of a force that is spread over the section: pressed at the rim the
    section narrows across, which bends the bar back.
    """
    return (7 - 8 * poisson_ratio**2) / (3 * (1 + poisson_ratio))


def bore_waves(last: int, x: FloatArray, poisson_ratio: float) -> FloatArray:
    """Outward displacement (last + 1, m) of a bore, over p R/E, of waves n along x = k R (m,)."""
    ratio = np.empty((last + 2, len(x)))  # K_(n+1)/K_n
    turn = np.linspace(0.0, 12.0, 1201)  # K_n(x) = integral of exp(-x cosh t) cosh(n t)
    falling = np.exp(-np.outer(x, np.cosh(turn) - 1))
    falling[:, 0] /= 2
    ratio[0] = falling @ np.cosh(turn) / falling.sum(axis=1)
    for n in range(1, last + 2):
        ratio[n] = 2 * n / x + 1 / ratio[n - 1]
    numbers = np.arange(last + 2)[:, None]
    return _radial(numbers - x * ratio, x, poisson_ratio)


def bar_waves(last: int, x: FloatArray, poisson_ratio: float) -> FloatArray:
    """Inward displacement (last + 1, m) of a bar over p R/E, as `bore_waves`."""
    ratio = np.zeros(len(x))  # I_(n+1)/I_n
    found = np.empty((last + 2, len(x)))
    for n in range(last + 60 + int(2 * x.max()), -1, -1):
        ratio = 1 / (2 * (n + 1) / x + ratio)
        if n < last + 2:
            found[n] = ratio
    numbers = np.arange(last + 2)[:, None]
    return -_radial(numbers + x * found, x, poisson_ratio)


def local_bar_waves(last: int, x: FloatArray, poisson_ratio: float) -> FloatArray:
    """`bar_waves` without what a bar moves as a beam: 1/(E I k^4) + 1/(G A_s k^2)."""
    found = bar_waves(last, x, poisson_ratio)
    found[1] -= 4 / x**4 + shear_of_bar(poisson_ratio) / x**2
    return found


def _radial(slope: FloatArray, x: FloatArray, nu: float) -> FloatArray:
    """Outward displacement over p R/E, by x F_n'/F_n (last + 2, m) on the cylinder; R = 1."""
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
    rows = []
    for k in range(3):
        volume = du[k] + u[k] + n * v[k] + x * w[k]
        around = np.where(n > 0, dv[k] - v[k] - n * u[k], 1.0 if k == 2 else 0.0)
        rows.append([du[k] + nu / (1 - 2 * nu) * volume, around, dw[k] - x * u[k]])
    system = np.moveaxis(np.array(rows), (0, 1), (-1, -2))
    right = np.zeros((*f1.shape, 3, 1))
    right[..., 0, 0] = -1.0
    amounts = np.linalg.solve(system, right)[..., 0]
    return np.asarray((1 + nu) * (np.moveaxis(np.array(u), 0, -1) * amounts).sum(axis=-1))
