"""Beams of blocks along x with clamps and sliding contacts on them, alone or as a stack of leaves.

A beam is centred at y = 0 and z = 0.
"""

from dataclasses import replace

import numpy as np

from geometry.mesh import Interface, Mesh, Tie, boundary_facets

from .blocks import block

YOUNG, POISSON = 210e3, 0.3


def patch(mesh, *, y, x=(-np.inf, np.inf)):
    """Boundary facets at a height y with all their corners between two places x."""
    facets = boundary_facets(mesh.elements)
    at = mesh.nodes[facets]
    flat = np.isclose(at[..., 1], y, atol=1e-9).all(axis=1)
    within = ((at[..., 0] > x[0] - 1e-9) & (at[..., 0] < x[1] + 1e-9)).all(axis=1)
    return facets[flat & within]


def clamped(mesh, name, place, half_length):
    """The same mesh with a clamp about x = `place` on its lowest and highest faces."""
    low, high = mesh.nodes[:, 1].min(), mesh.nodes[:, 1].max()
    x = (place - half_length, place + half_length)
    facets = np.concatenate([patch(mesh, y=y, x=x) for y in (low, high)])
    interface = Interface(name, "clamp", np.array([place, (low + high) / 2, 0.0]))
    return replace(
        mesh,
        surfaces={**mesh.surfaces, name: facets},
        interfaces={**mesh.interfaces, name: interface},
    )


def sliding(mesh, name, travel, half_length, x=(-np.inf, np.inf)):
    """The same mesh with a contact that slides along it; a force along +y presses from below."""
    low, high = mesh.nodes[:, 1].min(), mesh.nodes[:, 1].max()
    interface = Interface(
        name, "slide", np.array([0.0, (low + high) / 2, 0.0]), travel=travel, patch=half_length
    )
    surfaces = {f"{name}+": patch(mesh, y=low, x=x), f"{name}-": patch(mesh, y=high, x=x)}
    return replace(
        mesh,
        surfaces={**mesh.surfaces, **surfaces},
        interfaces={**mesh.interfaces, name: interface},
    )


def stack(leaves, counts, sizes, *, start=0.0, axes=(1,), bolted=True):
    """Leaves of one size on top of each other, without interfaces.

    counts, sizes  of one leaf's bricks and edges along x, y, z
    start          x of their ends, mm
    axes           along which all touching nodes are tied; `bolted`: at x = 0 along all three
    """
    length, height, width = sizes
    nodes, elements, bottoms, tops = [], [], [], []
    count = 0
    for leaf in range(leaves):
        low = (leaf - leaves / 2) * height
        one = block(counts, sizes, start=(start, low, -width / 2))
        for faces, y in ((bottoms, low), (tops, low + height)):
            on = np.flatnonzero(np.isclose(one.nodes[:, 1], y, atol=1e-9))
            order = np.lexsort(np.round(one.nodes[on][:, [2, 0]], 6).T)
            faces.append(count + on[order])
        nodes.append(one.nodes)
        elements.append(count + one.elements)
        count += len(one.nodes)
    nodes, elements = np.concatenate(nodes), np.concatenate(elements)
    touching = zip(tops[:-1], bottoms[1:], strict=True)
    pairs = np.concatenate([np.column_stack(pair) for pair in touching])
    ties = [Tie(axis, pairs) for axis in axes]
    if bolted:
        middle = pairs[np.abs(nodes[pairs[:, 0], 0]) < 1e-9]
        ties += [Tie(axis, middle) for axis in range(3) if axis not in axes]
    volume = leaves * length * height * width
    return Mesh(nodes, elements, {}, {}, volume, ties=tuple(ties))
