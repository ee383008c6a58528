"""Buckling of a long plate at the edge on which it is pressed, where nothing holds that edge."""

from math import pi


def pressed_edge_stress(
    thickness: float, width: float, youngs_modulus: float, poisson_ratio: float
) -> float:
    """Pressure, MPa, on the free end of a long plate, its sides simply supported, that buckles it.

    thickness, width  mm, the width between the supported sides

    With w = f(x) sin(pi y/b), pressure k pi^2 D/(b^2 t) and lengths over b/pi the plate's equation
    (f'' - f) differentiated alike, f'''' + (k - 2) f'' + f = 0, has for k < 4 two conjugate
    solutions that die away from the end, of sum -2 sqrt(1 - k/4) and product 1. At the free end
    f'' = nu f and f''' + (k - 2 + nu) f' = 0 (no moment; shear of the plate's edge and of the
    pressure, which keeps its direction). Both hold for k = (3 + nu)(1 - nu): 2.31 for steel,
    against 4 of a plate whose ends are held.
    """
    if not (thickness > 0 and width > 0):
        raise ValueError(f"a plate needs sizes above 0 mm, got {thickness:g} and {width:g}")
    factor = (3 + poisson_ratio) * (1 - poisson_ratio)
    euler = pi**2 * youngs_modulus / (12 * (1 - poisson_ratio**2))
    return factor * euler * (thickness / width) ** 2
