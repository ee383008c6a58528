"""Accuracy of quadratic tetrahedra near incompressibility: only the mean stress suffers.

The mean stress is the bulk modulus E / (3 (1 - 2 nu)) times a change of volume that the elements
have to make small: its error grows like 1 / (1 - 2 nu), and it differs from element to element. The
deviatoric stress is not touched (Hughes, The Finite Element Method, 2000, section 4.4). Measured
on a pressed thick cylinder in plane strain (docs/extremes.md): on a mesh with a von Mises stress
right to 1 %, direct stresses are wrong by 1 % at 0.3, 2 % at 0.45, 4 % at 0.48, 8 % at 0.49 and
40 % at 0.499; displacements stay within 0.2 % and von Mises stress within 2 %. On a regular mesh
nothing of it is seen up to 0.49.
"""

LARGEST_RATIO = 0.45  # the mean stress is as exact as the von Mises stress, to a factor of 2
MEANING = (
    "Poisson's ratio: nearer to 0.5 von Mises stress and displacement hold, but the mean stress is "
    "inexact (measured 4 % at 0.48, 8 % at 0.49, 40 % at 0.499) and with it principal stresses and "
    "the mean stress of fatigue; error bars do not see it"
)
