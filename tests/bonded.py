"""Stacks of bodies glued together, which what is tied must be as stiff as."""

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


def bonded(mesh):
    """The mesh with tied nodes made one: the bodies of the stack glued together."""
    pairs = np.concatenate([tie.pairs for tie in mesh.ties])
    links = coo_matrix((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(mesh.nodes),) * 2)
    _, place = connected_components(links, directed=False)
    _, kept, renumber = np.unique(place, return_index=True, return_inverse=True)
    return replace(
        mesh,
        nodes=mesh.nodes[kept],
        elements=renumber[mesh.elements],
        surfaces={name: renumber[facets] for name, facets in mesh.surfaces.items()},
        ties=(),
        entities=None,
    )
