"""Closed forms that solids and formulas are compared with."""

_FITTED = (0.15, 0.75)  # hole over width for which the lug factor was fitted


def lug_factor(hole: float, width: float) -> float | None:
    """Peak stress beside the hole of a pulled lug over F / ((H - d) t); None outside the fit.

    Peterson's chart as fitted by Pilkey: 12.882 - 52.714 u + 89.762 u^2 - 51.667 u^3, u = d/H, for
    a close pin and an end distance of at least H. An end that is round about the pin, H/2 away,
    raises it: at u = 0.4 from 2.85 to 3.35 (under a cosine pressure).

    >>> round(lug_factor(20.0, 50.0), 3)
    2.852
    """
    u = hole / width
    if not _FITTED[0] <= u <= _FITTED[1]:
        return None
    return 12.882 - 52.714 * u + 89.762 * u**2 - 51.667 * u**3


def engesser_force(euler: float, shear_stiffness: float) -> float:
    """Buckling force, N, of a hinged column that also gives way by shear.

    euler            N, without shear strain
    shear_stiffness  N, G times the shear area; of two plates that rack, 24 E I/length^2 with both
                     their ends clamped and 6 E I/length^2 with one end of each hinged

    Engesser (1889); Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., 2.17. Haringx lets
    the shear force act square to the section instead of the axis and comes out higher (0.8 % for a
    bar five times as long as high); Engesser's is on the safe side.

    >>> round(engesser_force(1381744.616, 5 / 6 * 200 * 210e3 / 2.6), 1)
    1253119.6
    """
    return euler / (1 + euler / shear_stiffness)
