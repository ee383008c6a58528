"""Draws for `reports.pictures`: folders come in as lines, and go out when all in them is drawn.

An empty line has it load the graphics libraries, which it else does when a still first needs them.

A folder holds jobs.json (field, views) and part_<i>.npz (nodes, triangles, values, peak), and
receives part_<i>_<view>.png: "peak" from near, any other view of the whole surface, "plain" without
colours, colour bar and marker, "estimate" in the colours of a utilisation. One that holds a file
"ahead" is removed, and not answered: the parts of a result are drawn beside other work once they
are there, and taken from memory when the same come again.
"""

import json
import os
import shutil
import signal
import sys
from hashlib import sha256
from io import BytesIO
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from PIL import PngImagePlugin  # noqa: F401 (each still needs it: loaded beside other work)

from geometry.mesh import FloatArray
from reports.plain_still import (
    AHEAD,
    ESTIMATE,
    FACES,
    LIGHTING,
    LINES,
    MARK,
    PLAIN,
    plain_still,
    sharp_edges,
)

SIZE = (900, 600)
_ISOMETRIC = np.array([1.0, -1.3, 0.9]) / np.linalg.norm([1.0, -1.3, 0.9])
_SCENE = 0.83  # of the width, the rest is the scalar bar's
_CLOSE = 0.14  # of the part's diagonal: half the height of the view of the peak


def main() -> None:
    """Draw what each folder asks for, until the input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent: it ends our input
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # what a library prints is no answer
    for line in sys.stdin.buffer:
        if not line.strip():
            _draw_a_tetrahedron()
            continue
        folder = Path(os.fsdecode(line.rstrip(b"\n")))
        if (folder / AHEAD).is_file():
            draw_ahead(folder)
            continue
        draw_folder(folder)
        answers.write(line)


_stills: dict[bytes, bytes] = {}  # of a design's parts


def draw_ahead(folder: Path) -> None:
    """Draw the stills of a folder, and keep them for what comes next."""
    for index, job in enumerate(_jobs(folder)):
        data, digest = _data(folder, index)
        for view in job["views"]:
            _stills[_key(job, view, digest)] = still(data, job["field"], view)
    shutil.rmtree(folder, ignore_errors=True)


def draw_folder(folder: Path) -> None:
    """Draw the stills of a folder, the last one of its design: these may end the process."""
    for index, job in enumerate(_jobs(folder)):
        data, digest = _data(folder, index)
        for view in job["views"]:
            drawn = _stills.get(_key(job, view, digest))
            picture = drawn or still(data, job["field"], view)
            _write(folder / f"part_{index}_{view}.png", picture)
    _stills.clear()


def _key(job: dict[str, Any], view: str, digest: bytes) -> bytes:
    return f"{job['field']} {view} ".encode() + digest


def _jobs(folder: Path) -> list[dict[str, Any]]:
    jobs: list[dict[str, Any]] = json.loads((folder / "jobs.json").read_text(encoding="utf-8"))
    return jobs


def _data(folder: Path, index: int) -> tuple[dict[str, Any], bytes]:
    """The arrays of a job, and a digest of them."""
    content = (folder / f"part_{index}.npz").read_bytes()
    with np.load(BytesIO(content), allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}, sha256(content).digest()


def _write(file: Path, content: bytes) -> None:
    """Write a file that is there whole or not at all."""
    temporary = file.with_suffix(".tmp")
    temporary.write_bytes(content)
    temporary.replace(file)


def _draw_a_tetrahedron() -> None:
    """Have the graphics libraries loaded and used once."""
    nodes = np.vstack([np.zeros(3), np.eye(3)])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    still({"nodes": nodes, "triangles": triangles, "values": nodes[:, 0], "peak": 1}, "x", "whole")


def still(data: dict[str, Any], field: str, view: str) -> bytes:
    """PNG of one view of a surface, coloured by its values unless it is to be plain."""
    nodes, triangles, peak = data["nodes"], data["triangles"], int(data["peak"])
    if view == PLAIN:
        return plain_still(nodes, triangles, _ISOMETRIC, SIZE, _SCENE)
    if view == ESTIMATE:
        direction, _ = corner_view(nodes, triangles, peak)
        return plain_still(nodes, triangles, direction, SIZE, _SCENE, data["values"])
    import pyvista as untyped
    from PIL import Image

    pyvista: Any = untyped
    faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    surface = pyvista.PolyData(nodes, faces)
    surface.point_data[field] = data["values"]
    plotter = pyvista.Plotter(
        off_screen=True, window_size=list(SIZE), lighting=LIGHTING, shape=(1, 2),
        col_weights=[_SCENE, 1 - _SCENE], border=False,
    )  # fmt: skip
    plotter.set_background("white", all_renderers=True)
    plotter.subplot(0, 0)
    actor = plotter.add_mesh(
        surface, scalars=field, cmap="viridis", **FACES, nan_color="lightgrey",
        show_scalar_bar=False,
    )  # fmt: skip
    seen = view_of if view == "peak" else corner_view
    direction, hidden = seen(nodes, triangles, peak)
    diagonal = float(np.linalg.norm(np.ptp(nodes, axis=0)))
    edges = sharp_edges(surface)
    if edges.n_points:
        edges.points += 2e-3 * diagonal * direction  # clear of the faces they bound
        plotter.add_mesh(edges, **LINES)
    _mark_peak(plotter, data, field, direction, hidden)
    _place_camera(plotter, nodes, peak, direction, view)
    plotter.enable_anti_aliasing("ssaa")
    _add_scalar_bar(plotter, actor.mapper, field)
    picture = plotter.screenshot(None, return_img=True)
    plotter.close()
    out = BytesIO()
    Image.fromarray(picture).save(out, format="PNG")
    return out.getvalue()


def _mark_peak(
    plotter: Any, data: dict[str, Any], field: str, direction: FloatArray, hidden: bool
) -> None:
    nodes, peak = data["nodes"], int(data["peak"])
    diagonal = float(np.linalg.norm(np.ptp(nodes, axis=0)))
    # The marker floats towards the camera, so that nothing hides it.
    plotter.add_points(
        (nodes[peak] + diagonal * direction)[None, :], color=MARK, point_size=26,
        render_points_as_spheres=True,
    )  # fmt: skip
    quantity, unit = _quantity_and_unit(field)
    text = f"{quantity}, at the dot {data['values'][peak]:.3g} {unit}"
    text += ", hidden behind the surface" if hidden else ""
    label = plotter.add_text(text, position=(8, SIZE[1] - 34), font_size=11, color="black")
    label.prop.background_color, label.prop.background_opacity = "white", 0.85


def _add_scalar_bar(plotter: Any, mapper: Any, field: str) -> None:
    _, unit = _quantity_and_unit(field)
    plotter.subplot(0, 1)
    plotter.add_scalar_bar(
        unit or " ", mapper=mapper, color="black", vertical=True, fmt="%.3g", n_labels=6,
        position_x=0.2, position_y=0.08, height=0.84, width=0.45, title_font_size=17,
        label_font_size=16,
    )  # fmt: skip


def _quantity_and_unit(field: str) -> tuple[str, str]:
    quantity, _, unit = (text.strip(" ]") for text in field.partition("["))
    return quantity, unit


def _place_camera(
    plotter: Any, nodes: FloatArray, peak: int, direction: FloatArray, view: str
) -> None:
    diagonal = float(np.linalg.norm(np.ptp(nodes, axis=0)))
    middle = (nodes.max(axis=0) + nodes.min(axis=0)) / 2
    centre = nodes[peak] if view == "peak" else middle
    up = (0.0, 0.0, 1.0) if abs(direction[2]) < 0.95 else (0.0, 1.0, 0.0)
    plotter.camera_position = [centre + 2 * diagonal * direction, centre, up]
    plotter.enable_parallel_projection()
    if view != "peak":
        # As large as the corners of the bounding box allow.
        corners = np.array(np.meshgrid(*zip(nodes.min(axis=0), nodes.max(axis=0), strict=True)))
        offset = corners.reshape(3, -1).T - centre
        right = np.cross(up, direction) / np.linalg.norm(np.cross(up, direction))
        upwards = np.cross(direction, right)
        half_width = np.abs(offset @ right).max() / (_SCENE * SIZE[0] / SIZE[1])
        plotter.camera.parallel_scale = 1.12 * max(np.abs(offset @ upwards).max(), half_width)
    else:
        plotter.camera.parallel_scale = _CLOSE * diagonal
    plotter.renderer.ResetCameraClippingRange()


def corner_view(nodes: FloatArray, triangles: Any, peak: int) -> tuple[FloatArray, bool]:
    """Isometric direction that sees the peak if any does, and whether the peak is hidden."""
    normal = _normal(nodes, triangles, peak)
    for signs in product((1, -1), (1, -1), (1, -1)):
        direction = _ISOMETRIC * signs[::-1]
        if _sees(nodes, triangles, peak, normal, direction):
            return direction, False
    return _ISOMETRIC, True


def view_of(nodes: FloatArray, triangles: Any, peak: int) -> tuple[FloatArray, bool]:
    """Direction that sees the peak as squarely as may be, and whether the peak is hidden.

    A peak in a bore looks at the opposite wall, so its normal alone would not do.
    """
    normal = _normal(nodes, triangles, peak)
    turns = np.arange(200) + 0.5  # points of a spiral, evenly spread over the sphere
    height, angle = 1 - turns / 100, np.pi * (1 + 5**0.5) * turns
    ring = np.sqrt(1 - height**2)
    directions = np.column_stack([ring * np.cos(angle), ring * np.sin(angle), height])
    for best in np.argsort(-(directions @ normal + 0.5 * directions @ _ISOMETRIC)):
        if _sees(nodes, triangles, peak, normal, directions[best]):
            return np.asarray(directions[best], dtype=np.float64), False
    return _ISOMETRIC, True


def _normal(nodes: FloatArray, triangles: Any, peak: int) -> FloatArray:
    """Mean outward direction of the triangles at the peak, or zero."""
    touching = triangles[(triangles == peak).any(axis=1)]
    corners = nodes[touching]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
    length = np.linalg.norm(normal)
    return np.asarray(normal / length if length else normal, dtype=np.float64)


def _sees(
    nodes: FloatArray, triangles: Any, peak: int, normal: FloatArray, direction: FloatArray
) -> bool:
    """Return True if the peak faces a direction, with nothing in between."""
    if normal @ direction <= 0.1:
        return False
    origin = nodes[peak] + 1e-3 * np.linalg.norm(np.ptp(nodes, axis=0)) * normal
    return not _hits(nodes, triangles, origin, direction)


def _hits(nodes: FloatArray, triangles: Any, origin: FloatArray, ray: FloatArray) -> bool:
    """Return True if a ray meets a triangle (Moeller and Trumbore 1997, J. Graphics Tools 2(1))."""
    first = nodes[triangles[:, 0]]
    one, two = nodes[triangles[:, 1]] - first, nodes[triangles[:, 2]] - first
    across = np.cross(ray, two)
    determinant = np.einsum("ij,ij->i", one, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1 / determinant
        away = origin - first
        u = np.einsum("ij,ij->i", away, across) * inverse
        turned = np.cross(away, one)
        v = turned @ ray * inverse
        distance = np.einsum("ij,ij->i", two, turned) * inverse
        return bool(((u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0)).any())


if __name__ == "__main__":
    main()
