"""Outlines of lugs about a pin's hole, and how the rest of a part holds them, in points."""

from math import pi

import numpy as np

from checks.handbook.pin_loaded_hole import ComplexArray, LugOutline
from geometry.mesh import FloatArray

_POINTS = 90  # of half an outline


def strip_outline(
    half_width: float,
    end: float | None,
    cut: float,
    stringer: float = 0.0,
    stringer_from: float = -np.inf,
) -> LugOutline:
    """Lug that goes on as a strip of the same width along +x, cut at x = `cut`.

    half_width     mm
    end            mm, from the hole's middle to its square end; None: round about the middle
    cut            mm; the strip is held there as a bar: evenly, with M y/I and V S/(I t)
    stringer       mm, area of a stringer along both edges over the lug's thickness
    stringer_from  mm, x from which on it is there; none where that is beyond the cut
    """
    h = half_width
    if stringer_from >= cut:
        stringer = 0.0
    length = (h * pi / 2 if end is None else end + h) + cut + h
    size = length / _POINTS
    pieces = []
    if end is None:
        angles, weights = _even(pi, pi / 2, h * pi / 2, size)
        outward = np.exp(1j * angles)
        pieces.append((h * outward, outward, weights))
        start = 0.0
    else:
        y, weights = _even(0.0, h, h, size)
        pieces.append((-end + 1j * y, np.full(len(y), -1.0 + 0j), weights))
        start = -end
    x, weights = _even(start, cut, cut - start, size)
    pieces.append((x + 1j * h, np.full(len(x), 1j), weights))
    y, weights = _even(h, 0.0, h, size)
    pieces.append((cut + 1j * y, np.full(len(y), 1.0 + 0j), weights))
    points, normals = (np.concatenate([piece[k] for piece in pieces]) for k in (0, 1))
    weights = np.concatenate([piece[2] for piece in pieces])
    on_cut = np.arange(len(points)) >= len(points) - len(y)
    on_edge = (normals == 1j) & (points.real >= stringer_from)
    forced = np.zeros((3, len(points)), complex)
    area, inertia = 2 * (h + stringer), 2 * h**3 / 3 + 2 * stringer * h**2
    y = points[on_cut].imag
    forced[0, on_cut] = -1 / area
    forced[1, on_cut] = -cut * y / inertia - 1j * (stringer * h + (h**2 - y**2) / 2) / inertia
    forced[2, on_cut] = y / inertia
    return LugOutline(points, normals, weights, forced, np.where(on_edge, stringer, 0.0))


def round_outline(radius: float, shank: float) -> LugOutline:
    """Round eye that a shank along +x holds: evenly, with M y/I and an even V, on its own width.

    radius  mm, of the eye
    shank   mm, half the width of the shank, below the radius
    """
    at = np.arcsin(shank / radius)
    size = pi * radius / _POINTS
    free, first = _even(pi, at, (pi - at) * radius, size)
    joined, second = _even(at, 0.0, at * radius, size / 2)
    angles, weights = np.concatenate([free, joined]), np.concatenate([first, second])
    normals = np.exp(1j * angles)
    points: ComplexArray = np.asarray(radius * normals)
    held = np.arange(len(points)) >= len(free)
    y, slope = points[held].imag, normals[held].real  # dy = slope ds
    inertia, place = 2 * shank**3 / 3, points[held].real
    forced = np.zeros((3, len(points)), complex)
    forced[0, held] = -slope / (2 * shank)
    # V acts at different places along x: what M balances is its moment at their mean
    mean = (place * slope * second).sum() / shank
    forced[1, held] = -1j * slope / (2 * shank) - mean * y * slope / inertia
    forced[2, held] = y * slope / inertia
    return LugOutline(points, normals, weights, forced, np.zeros(len(points)))


def _even(start: float, stop: float, length: float, size: float) -> tuple[FloatArray, FloatArray]:
    """Middles of even pieces between two places, and the length of each."""
    count = max(4, int(np.ceil(length / size)))
    places = start + (stop - start) * (np.arange(count) + 0.5) / count
    return places, np.full(count, length / count)


def mirrored(points: ComplexArray) -> ComplexArray:
    """Mirror the points of a lug with its free end at +x to one with its free end at -x."""
    return np.asarray(-points.conj())
