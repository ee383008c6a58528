"""A whole mesh made of a half and its mirror image."""

from dataclasses import replace

import numpy as np

from geometry.mesh import SYMMETRY

# The mirror turns elements inside out: two corners change places, and the mid-sides with them.
ELEMENT = [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]
FACET = [0, 2, 1, 5, 4, 3]


def whole_of(half, *, tilts=False):
    """The whole mesh, whose first nodes are the half's."""
    count = len(half.nodes)
    beside = np.setdiff1d(np.arange(count), half.cut_nodes)
    image = np.arange(count)
    image[beside] = count + np.arange(len(beside))
    return replace(
        half,
        nodes=np.concatenate([half.nodes, half.nodes[beside] * [1, 1, -1]]),
        elements=np.concatenate([half.elements, image[half.elements[:, ELEMENT]]]),
        surfaces={
            name: np.concatenate([facets, image[facets[:, FACET]]])
            for name, facets in half.surfaces.items()
            if name != SYMMETRY
        },
        interfaces={n: replace(i, tilts=tilts) for n, i in half.interfaces.items()},
        volume_cad=2 * half.volume_cad,
        half=False,
    )
