"""The interactive window of a checked design, and pictures of it, from a process of its own.

python -m reports.window WHAT is that process. WHAT is --probe (open a window and close it again),
--probe-picture (draw without one), or the FOLDER of a scene with the name of a part ("" for any)
and, for pictures in place of a window, keys that are pressed and .png files that are written, one
after the other. It ends with NO_WINDOW where there is a graphics library but nothing to open a
window on.

Where there is no display, or graphics libraries are missing, a message says so and gives the cure:
neither can crash or hang the process that asked for the window.
"""

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from geometry import INSTALL
from reports.files import replacing
from reports.pictures import run_worker
from reports.pictures_worker import FACES, LIGHTING, LINES, MARK, sharp_edges
from reports.window_scene import FIELDS, SIGNED, Scene, read_scene, write_scene

_WORKER = (sys.executable, "-m", "reports.window")
_PROBING = 60.0  # s
_DRAWING = 180.0
_NO_DISPLAY = (
    "there is no display to open a window on{said}: run it in a desktop session, over ssh with "
    "ssh -X, or write a picture with --off-screen FILE.png; the report of ballesta check shows the "
    "same fields in a browser"
)


@dataclass(frozen=True)
class Trouble:
    """Reason that nothing could be shown; display: True for lack of one, not of graphics."""

    words: str
    display: bool = False


def probe_window(
    *, off_screen: bool = False, worker: Sequence[str] = _WORKER, timeout: float = _PROBING
) -> Trouble | None:
    """Try to open a window (or to draw without one) and tell what keeps it from it."""
    if not off_screen and sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        return Trouble(_NO_DISPLAY.format(said=" (DISPLAY is not set)"), display=True)
    with TemporaryDirectory(prefix="ballesta-") as name:
        what = "--probe-picture" if off_screen else "--probe"
        ended = run_worker([*worker, what], Path(name), timeout, window=not off_screen)
    return _trouble(ended.code, ended.words)


def open_window(
    scene: Scene, part: str | None = None, *, worker: Sequence[str] = _WORKER
) -> Trouble | None:
    """Show a scene in a window, from the named part on, until it is closed."""
    with TemporaryDirectory(prefix="ballesta-") as name:
        write_scene(scene, Path(name))
        ended = run_worker([*worker, name, part or ""], Path(name), None, window=True)
    return _trouble(ended.code, ended.words)


def window_picture(
    scene: Scene,
    file: Path,
    part: str | None = None,
    keys: Sequence[str] = (),
    *,
    worker: Sequence[str] = _WORKER,
    timeout: float = _DRAWING,
) -> Trouble | None:
    """Write a picture of the window to a PNG file, after some keys were pressed in it.

    Raises OSError where the file cannot be written.
    """
    with TemporaryDirectory(prefix="ballesta-") as name:
        folder = Path(name)
        write_scene(scene, folder)
        drawn = folder / "window.png"
        ended = run_worker([*worker, name, part or "", *keys, str(drawn)], folder, timeout)
        if ended.words or not drawn.is_file():
            return _trouble(ended.code, ended.words or "the worker ended well but drew nothing")
        with replacing(file) as temporary:
            temporary.write_bytes(drawn.read_bytes())
    return None


def _trouble(code: int | None, words: str) -> Trouble | None:
    if not words:
        return None
    if code == NO_WINDOW:
        said = os.environ.get("DISPLAY", "")
        return Trouble(_NO_DISPLAY.format(said=f" (DISPLAY is {said[:60]})"), display=True)
    return Trouble(f"{words}. Where GL libraries are missing: {INSTALL}")


NO_WINDOW = 4  # exit code
SIZE = (1280, 800)
_BAR = " "  # title of the scalar bar: the quantity stands in the words
_WINDOWLESS = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow", "vtkGenericOpenGLRenderWindow")
HELP = "1-6 field   n part   c cycle   p worst position   d displaced   r whole picture   q close"


class Window:
    """A plotter that shows a view of a scene, and the keys and the slider that change the view."""

    def __init__(self, scene: Scene, part: str | None, off_screen: bool) -> None:
        import pyvista as untyped

        self.pyvista: Any = untyped
        self.scene, self.view = scene, scene.first_view(part)
        self.plotter: Any = self.pyvista.Plotter(
            off_screen=off_screen, window_size=list(SIZE), lighting=LIGHTING,
            title=f"ballesta: {scene.title[:80]}",
        )  # fmt: skip
        self.plotter.set_background("white")
        self.plotter.add_text(HELP, position="lower_left", font_size=8, color="dimgrey")
        self.slider: Any = None  # told of its first value while it is made
        if scene.cycles:
            self.slider = self.plotter.add_slider_widget(
                lambda value: self.slider and self.go(round(value)), [0, max(1, self._last)],
                value=0, fmt="%.0f", title=" ", title_height=0.02, pointa=(0.3, 0.1),
                pointb=(0.7, 0.1), color="black", style="modern", interaction_event="always",
            )  # fmt: skip
            # a bare number would read as an angle
            self.slider.GetRepresentation().ShowSliderLabelOff()
        self.keys: dict[str, Callable[[], None]] = {
            **{
                str(number): partial(self.change, field=name)
                for number, name in enumerate(FIELDS, start=1)
            },
            "n": self.next_part,
            "c": self.next_cycle,
            "p": self.worst,
            "d": lambda: self.change(deformed=not self.view.deformed),
        }
        self.update()
        self.whole()

    @property
    def _last(self) -> int:
        cycles = self.scene.cycles
        return cycles[self.view.cycle].n - 1 if cycles else 0

    def change(self, **changes: Any) -> None:
        """Show another view."""
        self.view = replace(self.view, **changes)
        self.update()

    def go(self, position: int) -> None:
        """Show a position of the cycle."""
        position = min(max(position, 0), self._last)
        if position != self.view.position:
            self.change(position=position)

    def next_part(self) -> None:
        """Show the next part."""
        self.change(part=(self.view.part + 1) % len(self.scene.parts))
        self.whole()

    def next_cycle(self) -> None:
        """Show the next cycle."""
        if self.scene.cycles:
            self.change(cycle=(self.view.cycle + 1) % len(self.scene.cycles), position=0)

    def worst(self) -> None:
        """Show the position of the largest stress."""
        self.view = self.scene.at_peak(self.view)
        self.update()

    def whole(self) -> None:
        """Move the camera so that the whole part is seen."""
        self.plotter.camera_position = "iso"
        self.plotter.reset_camera(bounds=self.plotter.actors["part"].bounds)
        self.plotter.camera.zoom(0.85)  # room for words and slider
        self.plotter.render()

    def update(self) -> None:
        """Draw the view as it is now."""
        scene, view = self.scene, self.view
        values, nodes = scene.values(view), scene.shape(view)
        triangles = scene.parts[view.part].live.triangles
        surface = self.pyvista.PolyData.from_regular_faces(nodes, triangles)
        if _BAR in self.plotter.scalar_bars:
            self.plotter.remove_scalar_bar(_BAR, render=False)
        quiet = {"reset_camera": False, "render": False}
        self.plotter.add_mesh(
            surface, name="part", scalars=values, color="lightgrey", clim=scene.limits(view),
            cmap="coolwarm" if view.field in SIGNED else "viridis", **FACES, **quiet,
            show_scalar_bar=values is not None, scalar_bar_args={
                "title": _BAR, "color": "black", "vertical": True, "fmt": "%.3g", "n_labels": 6,
                "position_x": 0.92, "position_y": 0.2, "height": 0.6, "width": 0.05,
                "label_font_size": 15, "render": False,
            },
        )  # fmt: skip
        edges = sharp_edges(surface)
        if edges.n_points:
            self.plotter.add_mesh(edges, name="edges", **LINES, **quiet)
        else:
            self.plotter.remove_actor("edges", render=False)
        if values is None:
            self.plotter.remove_actor(["largest-points", "largest-labels"], render=False)
        else:  # a dot that is seen through the part
            self.plotter.add_point_labels(
                nodes[[np.abs(values).argmax()]], ["largest"], name="largest", point_color=MARK,
                point_size=16, render_points_as_spheres=True, always_visible=True, font_size=13,
                shape_color="white", shape_opacity=0.8, text_color="black", **quiet,
            )  # fmt: skip
        self.plotter.add_text(
            "\n".join(scene.told(view)), position="upper_left", font_size=11, color="black",
            name="words", render=False,
        )  # fmt: skip
        if self.slider is not None:
            told = self.slider.GetRepresentation()
            told.SetMaximumValue(max(1, self._last))
            told.SetValue(view.position)
            told.SetTitleText(scene.place(view))
        self.plotter.render()

    def press(self, key: str) -> None:
        """Do what a key does; one that has no meaning does nothing."""
        self.keys.get(key, lambda: None)()

    def show(self) -> None:
        """Open the window until it is closed."""
        for key, action in self.keys.items():
            self.plotter.add_key_event(key, action)
        interactor = self.plotter.iren
        self.plotter.show(interactive=False, auto_close=False)
        if windowless(self.plotter):
            raise SystemExit(NO_WINDOW)
        # VTK's own meaning of letters (p picks, 3 is stereo) must not come on top of these keys;
        # an observer on the style takes the place of its default
        style = interactor.interactor.GetInteractorStyle()
        style.AddObserver("CharEvent", lambda *_: self._typed())
        interactor.start()
        self.plotter.close()

    def _typed(self) -> None:
        interactor = self.plotter.iren.interactor
        if interactor.GetKeySym() in ("q", "e", "Escape"):
            interactor.TerminateApp()
        elif interactor.GetKeySym() == "r":
            self.whole()


def windowless(plotter: Any) -> bool:
    """Return True if the render window that was opened is off-screen."""
    return plotter.render_window.GetClassName() in _WINDOWLESS


def probe(off_screen: bool) -> None:
    """Open a window and close it; ends the process with NO_WINDOW where that is impossible.

    off_screen  draw without one instead
    """
    import pyvista as untyped

    pyvista: Any = untyped
    plotter = pyvista.Plotter(off_screen=off_screen, window_size=[64, 64])
    plotter.add_mesh(pyvista.Sphere(theta_resolution=6, phi_resolution=6))
    plotter.show(interactive=False, auto_close=False)
    missing = not off_screen and windowless(plotter)
    plotter.close()
    if missing:
        raise SystemExit(NO_WINDOW)


def main(arguments: list[str]) -> None:
    """Probe, open the window, or write a picture of it."""
    if arguments[0] in ("--probe", "--probe-picture"):
        probe(off_screen=arguments[0] == "--probe-picture")
        return
    folder, part, *rest = arguments
    window = Window(read_scene(Path(folder)), part or None, off_screen=bool(rest))
    if not rest:
        window.show()
        return
    for each in rest:
        if each.endswith(".png"):
            window.plotter.screenshot(each)
        else:
            window.press(each)
    window.plotter.close()


if __name__ == "__main__":
    main(sys.argv[1:])
