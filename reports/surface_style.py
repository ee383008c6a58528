"""Style of a part's surface, the same in stills and in the window; used by both their workers."""

from typing import Any

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
