"""Style and colours of a part's surface in pictures, and pictures without graphics libraries.

Grey, or in the colours of a utilisation.
"""

import json
from functools import cache
from importlib.resources import files
from io import BytesIO
from typing import Any

import numpy as np

from geometry.mesh import FloatArray, IntArray


@cache
def colour_maps() -> dict[str, Any]:
    """Maps by name: of matplotlib, as base64 of 256 times red, green, blue; and "use".

    That of utilisations has the colours `low` up to 1 and `high` above, each evenly spread; of 256
    of them `least` is the last of `low` where little or nothing is above 1.
    """
    text = files("reports.live").joinpath("colour_maps.json").read_text(encoding="utf-8")
    return dict(json.loads(text))


def use_colours(uses: FloatArray, end: float) -> FloatArray:
    """Red, green, blue (n, 3), 0 to 255, of utilisations (n,); end of their scale, above 1."""
    low, high = (np.array(colour_maps()["use"][name]) for name in ("low", "high"))
    over = uses[:, None] > 1
    return np.where(over, _between(high, (uses - 1) / (end - 1)), _between(low, uses))


def _between(stops: FloatArray, share: FloatArray) -> FloatArray:
    return np.stack([np.interp(share, np.linspace(0, 1, len(stops)), c) for c in stops.T], axis=1)


PLAIN, ESTIMATE = "plain", "estimate"  # views that are drawn without graphics libraries
AHEAD = "ahead"  # a file of a folder that is not waited for
LIGHTING = "light kit"
# Much ambient light: shading tells the shape, and must not change what a colour says.
FACES = {"smooth_shading": False, "ambient": 0.6, "diffuse": 0.42, "specular": 0.0}
LINES = {"color": "black", "line_width": 1.5, "opacity": 0.6, "lighting": False}
GREY = 211  # of 255, of a part without colours: "lightgrey"
MARK = "#d81b60"  # colour of the dot on the largest value
SHARP = 35.0  # deg, by which a surface turns at an edge that is drawn


def sharp_edges(surface: Any) -> Any:
    """The edges of a pyvista surface that are drawn as lines: sharp ones, and its border."""
    return surface.extract_feature_edges(
        feature_angle=SHARP, manifold_edges=False, non_manifold_edges=False
    )


_FINER = 2  # pixels drawn per pixel shown, each way
_AMBIENT, _DIFFUSE = (0.6, 0.8), (0.42, 0.22)  # of grey, of colours
_LIGHT = np.array([-0.25, 0.45, 0.86])  # towards it: right, up, towards the eye
_OPACITY = 0.6  # of edges
_CLEAR = 2e-3  # of the diagonal, by which edges are clear of the faces that they bound
_TOGETHER = 256  # triangles
_FULL = 1.12  # height and width of the scene over those of the part


def plain_still(
    nodes: FloatArray,
    triangles: IntArray,
    direction: FloatArray,
    size: tuple[int, int],
    scene: float,
    uses: FloatArray | None = None,
) -> bytes:
    """PNG of a surface on white, in grey or by its utilisation, seen along parallel lines, z up.

    nodes      (n, 3) mm
    triangles  (m, 3) numbers of nodes
    direction  (3,) unit vector towards the eye, not along z
    size       width and height in pixels
    scene      share of the width, from the left, that the surface may take; the rest is the scale's
    uses       (n,) utilisations; None: grey
    """
    from PIL import Image

    width, height = (_FINER * pixels for pixels in size)
    right = np.cross((0.0, 0.0, 1.0), direction)
    right /= np.linalg.norm(right)
    seen = nodes @ np.column_stack([right, np.cross(direction, right), direction])
    corners = np.array(np.meshgrid(*zip(nodes.min(axis=0), nodes.max(axis=0), strict=True)))
    box = corners.reshape(3, -1).T @ np.column_stack([right, np.cross(direction, right)])
    spans = np.maximum(np.ptp(box, axis=0), 1e-300)
    scale = min(scene * width / spans[0], height / spans[1]) / _FULL
    middle = (box.max(axis=0) + box.min(axis=0)) / 2
    places = np.column_stack(
        [
            scene * width / 2 + scale * (seen[:, 0] - middle[0]),
            height / 2 - scale * (seen[:, 1] - middle[1]),
            seen[:, 2],
            *([] if uses is None else [uses]),
        ]
    )
    normals = _normals(seen, triangles)
    depth = np.full(width * height, -np.inf)
    shade = np.full((width * height, 1 if uses is None else 3), 255.0)
    pixels, owners, used = _front(places[triangles], depth, width)
    some = int(uses is not None)
    light = _AMBIENT[some] + _DIFFUSE[some] * np.abs(normals @ (_LIGHT / np.linalg.norm(_LIGHT)))
    end = max(255 / (colour_maps()["use"]["least"] + 0.5), 0.0 if uses is None else uses.max())
    paint = np.array([[GREY]]) if uses is None else use_colours(used[0], end)
    shade[pixels] = paint * np.minimum(light, 1.0)[owners, None]
    clear = _CLEAR * float(np.linalg.norm(np.ptp(nodes, axis=0)))
    lines = _drawn(places[_sharp_edges(triangles, normals)], depth, clear, width, height)
    shade[lines] *= 1 - _OPACITY
    pixel = np.rint(shade.reshape(height, width, -1)).astype(np.uint8)
    picture = Image.fromarray(pixel.squeeze()).reduce(_FINER)
    if uses is not None:
        _add_scale(picture, scene, end)
    out = BytesIO()
    picture.save(out, format="PNG")
    return out.getvalue()


def _add_scale(picture: Any, scene: float, end: float) -> None:
    """Draw the colours of utilisations right of the scene, with the limit and both ends."""
    from PIL import ImageDraw, ImageFont

    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(16)
    width, height = picture.size
    left, right = int((0.8 * scene + 0.2) * width), int((0.6 * scene + 0.4) * width)
    top, tall = 0.1 * height, 0.8 * height
    rows = np.arange(int(tall))
    colours = np.rint(use_colours(end * (1 - rows / tall), end)).astype(int).tolist()
    for row, colour in zip(rows, colours, strict=True):
        draw.line([(left, top + row), (right, top + row)], fill=tuple(colour))
    draw.text((left, top - 8), "estimate", fill="black", font=font, anchor="ls")
    for use in (0.0, 1.0, end):
        at = (right + 8, top + tall * (1 - use / end))
        draw.text(at, f"{use:.3g}", fill="black", font=font, anchor="lm")


def _normals(nodes: FloatArray, triangles: IntArray) -> FloatArray:
    """Unit normals of triangles (m, 3); zero of those without an area."""
    first, second, third = (nodes[triangles[:, k]] for k in range(3))
    normals = np.cross(second - first, third - first)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(lengths > 0, lengths, 1.0), dtype=np.float64)


def _runs(starts: IntArray, counts: IntArray) -> tuple[IntArray, IntArray]:
    """Whole numbers from each start on, one after the other, and the number of their run."""
    owners = np.repeat(np.arange(len(counts)), counts)
    before = np.cumsum(counts) - counts
    return np.arange(len(owners)) - before[owners] + starts[owners], owners


def _front(
    corners: FloatArray, depth: FloatArray, width: int
) -> tuple[IntArray, IntArray, FloatArray]:
    """Pixels that are covered, the triangle in front there, and what else is linear on it (k, n).

    corners  (m, 3, 3 + k) x, y in pixels, depth and what else is linear between them
    depth    (width * height,) from -inf; becomes the depth of the triangles in front

    Taken in portions that stay in the processor's cache, the nearest first: of a hidden one little
    is kept.
    """
    planes = _planes(corners)
    found = []
    nearest = np.argsort(-corners[:, :, 2].max(axis=1), kind="stable")
    for some in np.array_split(nearest, -(-len(nearest) // _TOGETHER)):
        rows, columns, owners = _covered(corners[some], width, len(depth) // width)
        owners = some[owners]
        base, by_x, by_y = (plane[0] for plane in planes)
        depths = base[owners] + columns * by_x[owners] + rows * by_y[owners]
        pixels = rows * width + columns
        near = np.flatnonzero(depths >= depth[pixels])
        pixels, owners, depths = pixels[near], owners[near], depths[near]
        np.maximum.at(depth, pixels, depths)
        found.append((pixels, owners, depths))
    pixels, owners, depths = (np.concatenate(each) for each in zip(*found, strict=True))
    front = depths >= depth[pixels]
    pixels, owners = pixels[front], owners[front]
    rows, columns = np.divmod(pixels, width)
    base, by_x, by_y = (plane[1:, owners] for plane in planes)
    return pixels, owners, base + columns * by_x + rows * by_y


def _planes(corners: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values (k, m) at the pixel 0, 0 of what is linear on triangles, and slopes over x and y."""
    across, down = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0]
    area = np.where(area != 0, area, np.inf)
    one, two, levels = (one[:, 2:].T for one in (across, down, corners[:, 0]))
    by_x = (one * down[:, 1] - across[:, 1] * two) / area
    by_y = (across[:, 0] * two - one * down[:, 0]) / area
    base = levels + (0.5 - corners[:, 0, 0]) * by_x + (0.5 - corners[:, 0, 1]) * by_y
    return base, by_x, by_y


def _covered(corners: FloatArray, width: int, height: int) -> tuple[IntArray, IntArray, IntArray]:
    """Rows and columns of pixels whose middle lies in a triangle, and the triangle's number.

    corners  (m, 3, ...) x, y in pixels
    """
    tops = np.ceil(corners[:, :, 1].min(axis=1) - 0.5).astype(np.int64).clip(0)
    ends = np.ceil(corners[:, :, 1].max(axis=1) - 0.5).astype(np.int64).clip(max=height)
    rows, owners = _runs(tops, np.maximum(ends - tops, 0))
    x, y = corners[owners, :, 0], corners[owners, :, 1]
    level = rows + 0.5
    left, right = np.full(len(rows), np.inf), np.full(len(rows), -np.inf)
    for k in range(3):
        low, high = y[:, k], y[:, (k + 1) % 3]
        crosses = (low > level) != (high > level)
        rise = np.where(crosses, high - low, 1.0)
        at = x[:, k] + (level - low) / rise * (x[:, (k + 1) % 3] - x[:, k])
        left = np.where(crosses, np.minimum(left, at), left)
        right = np.where(crosses, np.maximum(right, at), right)
    hit = right > left
    rows, owners, left, right = rows[hit], owners[hit], left[hit], right[hit]
    starts = np.ceil(left - 0.5).astype(np.int64).clip(0)
    stops = np.ceil(right - 0.5).astype(np.int64).clip(max=width)
    columns, runs = _runs(starts, np.maximum(stops - starts, 0))
    return rows[runs], columns, owners[runs]


def _sharp_edges(triangles: IntArray, normals: FloatArray) -> IntArray:
    """Edges (e, 2) at which the surface turns by much, and those of its border."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owners = np.repeat(np.arange(len(triangles)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owners = edges[order], owners[order]
    first = np.flatnonzero(np.any(np.diff(edges, axis=0, prepend=-1), axis=1))
    counts = np.diff(first, append=len(edges))
    pairs = first[counts == 2]
    turn = (normals[owners[pairs]] * normals[owners[pairs + 1]]).sum(axis=1)
    sharp = pairs[turn < np.cos(np.radians(SHARP))]
    return np.asarray(edges[np.concatenate([sharp, first[counts == 1]])], dtype=np.int64)


def _drawn(ends: FloatArray, depth: FloatArray, clear: float, width: int, height: int) -> IntArray:
    """Pixels, each once, of lines that no face hides.

    ends   (e, 2, 3) x, y in pixels, depth
    depth  (width * height,) of the faces
    """
    lengths = np.linalg.norm(ends[:, 1, :2] - ends[:, 0, :2], axis=1)
    steps, owners = _runs(np.zeros(len(ends), np.int64), np.ceil(lengths).astype(np.int64) + 1)
    share = (steps / np.maximum(np.ceil(lengths)[owners], 1.0))[:, None]
    points = ends[owners, 0] * (1 - share) + ends[owners, 1] * share
    found = []
    for aside, below in ((0, 0), (1, 0), (0, 1), (-1, 0), (0, -1)):
        columns = np.floor(points[:, 0]).astype(np.int64) + aside
        rows = np.floor(points[:, 1]).astype(np.int64) + below
        inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
        pixels = rows[inside] * width + columns[inside]
        found.append(pixels[points[inside, 2] + clear >= depth[pixels]])
    return np.unique(np.concatenate(found))
