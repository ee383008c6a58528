"""The interactive window, in a process of its own: python -m reports.window_worker WHAT.

WHAT is --probe (open a window and close it again), --probe-picture (draw without one), or the
FOLDER of a scene with the name of a part ("" for any) and, for pictures in place of a window, keys
that are pressed and .png files that are written, one after the other. Ends with NO_WINDOW where
there is a graphics library but nothing to open a window on.
"""

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from reports.surface_style import FACES, LIGHTING, LINES, MARK, sharp_edges
from reports.window_files import read_scene
from reports.window_scene import FIELDS, LINKAGE, SIGNED, Scene

NO_WINDOW = 4  # exit code
SIZE = (1280, 800)
_TICK = 40  # ms between two positions while it plays
_FRAMES = 150  # in which a cycle is played
_ARROW = 0.18  # length of the longest arrow over the picture's size
_BANDS, _SMOOTH = 10, 256  # colours
_WINDOWLESS = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow", "vtkGenericOpenGLRenderWindow")
HELP = (
    "1-6 field   n part   l whole linkage   c cycle   space play   left right position\n"
    "p worst position   d displaced   b bands   r whole picture   q close"
)


class Window:
    """A plotter that shows a view of a scene, and the keys and the slider that change the view."""

    def __init__(self, scene: Scene, part: str | None, off_screen: bool) -> None:
        import pyvista as untyped

        self.pyvista: Any = untyped
        self.scene, self.view = scene, scene.first_view(part)
        self.playing = False
        self.plotter: Any = self.pyvista.Plotter(
            off_screen=off_screen, window_size=list(SIZE), lighting=LIGHTING,
            title=f"ballesta: {scene.title[:80]}",
        )  # fmt: skip
        self.plotter.set_background("white")
        self.colours: Any = self.pyvista.LookupTable("viridis", n_values=_SMOOTH)
        self.colours.nan_color = "lightgrey"
        self.meshes = [self._surface(k) for k in range(len(scene.parts))]
        self.bar: Any = self.plotter.add_scalar_bar(
            " ", mapper=self.meshes[0][1].mapper, color="black", vertical=True, fmt="%.3g",
            n_labels=6, position_x=0.92, position_y=0.2, height=0.6, width=0.05,
            title_font_size=16, label_font_size=15,
        )  # fmt: skip
        self.arrows: Any = None
        self.words: Any = self.plotter.add_text(
            " ", position="upper_left", font_size=11, color="black"
        )
        self.plotter.add_text(HELP, position="lower_left", font_size=8, color="dimgrey")
        self.slider: Any = None  # told of its first value while it is made
        self.slider = self._slider()
        self.update()
        self.whole()

    def _surface(self, part: int) -> tuple[Any, Any, Any, Any]:
        """Mesh and actor of a part, its sharp edges and their actor."""
        live = self.scene.parts[part].live
        faces = np.column_stack([np.full(len(live.triangles), 3), live.triangles]).ravel()
        mesh = self.pyvista.PolyData(live.nodes.copy(), faces)
        mesh.point_data["node"] = np.arange(len(live.nodes))
        edges = sharp_edges(mesh)
        mesh.point_data["shown"] = np.zeros(len(live.nodes))
        actor = self.plotter.add_mesh(
            mesh, scalars="shown", cmap=self.colours, **FACES, show_scalar_bar=False,
            reset_camera=False,
        )  # fmt: skip
        actor.mapper.lookup_table = self.colours
        lines = None
        if edges.n_points:
            lines = self.plotter.add_mesh(edges, **LINES, reset_camera=False)
        return mesh, actor, edges, lines

    def _slider(self) -> Any:
        """The slider over the cycle; none of a scene without positions."""
        if not self.scene.cycles:
            return None
        slider = self.plotter.add_slider_widget(
            self._slide, [0, max(1, self._last)], value=0, fmt="%.0f",
            title=" ", title_height=0.02, pointa=(0.3, 0.1), pointb=(0.7, 0.1), color="black",
            style="modern", interaction_event="always",
        )  # fmt: skip
        slider.GetRepresentation().ShowSliderLabelOff()  # a bare number would read as an angle
        return slider

    def _slide(self, value: float) -> None:
        if self.slider is not None:
            self.go(round(value))

    @property
    def _last(self) -> int:
        cycles = self.scene.cycles
        return cycles[self.view.cycle].n - 1 if cycles else 0

    @property
    def keys(self) -> dict[str, Callable[[], None]]:
        """Action of every key."""
        fields = {
            str(number): lambda name=name: self.change(field=name)
            for number, name in enumerate(FIELDS, start=1)
        }
        return {
            **fields,
            "n": self.next_part,
            "l": self.linkage,
            "c": self.next_cycle,
            "space": self.play,
            "Left": lambda: self.step(-1),
            "Right": lambda: self.step(1),
            "p": self.worst,
            "d": lambda: self.change(deformed=not self.view.deformed),
            "b": lambda: self.change(bands=not self.view.bands),
            "r": self.whole,
        }

    def change(self, **changes: Any) -> None:
        """Show another view."""
        self.view = replace(self.view, **changes)
        self.update()

    def go(self, position: int) -> None:
        """Show a position of the cycle."""
        position = min(max(position, 0), self._last)
        if position != self.view.position:
            self.change(position=position)

    def step(self, by: int) -> None:
        """Show a position further on; after the last comes the first."""
        self.playing = False
        self.go((self.view.position + by) % (self._last + 1))

    def next_part(self) -> None:
        """Show the next part alone."""
        self.change(part=(self.view.part + 1) % len(self.scene.parts))
        self.whole()

    def linkage(self) -> None:
        """Show all parts where they are in the machine, in a cycle whose motion is known."""
        if not self.scene.moves:
            return
        cycles = self.scene.cycles
        known = [k for k, cycle in enumerate(cycles) if cycle.frames]
        cycle = self.view.cycle if self.view.cycle in known else known[0]
        last = cycles[cycle].n - 1
        self.change(part=LINKAGE, cycle=cycle, position=min(self.view.position, last))
        self.whole()

    def next_cycle(self) -> None:
        """Show the next cycle; of the whole linkage one whose motion is known."""
        cycles = self.scene.cycles
        for by in range(1, len(cycles) + 1):
            k = (self.view.cycle + by) % len(cycles)
            if self.view.part != LINKAGE or cycles[k].frames:
                self.change(cycle=k, position=0)
                return

    def worst(self) -> None:
        """Show the position of the largest stress."""
        self.playing = False
        self.view = self.scene.at_peak(self.view)
        self.update()

    def play(self) -> None:
        """Play the cycle, or stop."""
        self.playing = not self.playing

    def tick(self) -> None:
        """Move on while it plays."""
        if self.playing:
            by = max(1, round(self._last / _FRAMES))
            self.go((self.view.position + by) % (self._last + 1))

    def whole(self) -> None:
        """Move the camera so that everything is seen that is shown."""
        self.plotter.camera_position = "iso" if self.view.part != LINKAGE else "xy"
        self.plotter.reset_camera(bounds=self._bounds())
        self.plotter.camera.zoom(0.85)  # room for words and slider
        self.plotter.render()

    def _bounds(self) -> Any:
        corners = []
        for part in self.scene.shown(self.view):
            nodes = self.scene.parts[part].live.nodes
            turn = self.scene.matrix(part, self.view)
            placed = nodes @ turn[:3, :3].T + turn[:3, 3]
            corners += [placed.min(axis=0), placed.max(axis=0)]
        low, high = np.min(corners, axis=0), np.max(corners, axis=0)
        return np.column_stack([low, high]).ravel().tolist()

    def update(self) -> None:
        """Draw the view as it is now."""
        scene, view = self.scene, self.view
        low, high = scene.limits(view)
        self.colours.apply_cmap(
            "coolwarm" if view.field in SIGNED else "viridis", _BANDS if view.bands else _SMOOTH
        )
        self.colours.scalar_range = (low, high)
        shown = scene.shown(view)
        self.bar.SetVisibility(any(scene.values(part, view) is not None for part in shown))
        for part, (mesh, actor, edges, lines) in enumerate(self.meshes):
            for each in (actor, lines):
                if each is not None:
                    each.SetVisibility(part in shown)
            if part not in shown:
                continue
            values, nodes = scene.values(part, view), scene.shape(part, view)
            mesh.points = nodes
            mesh.point_data["shown"] = np.full(len(nodes), np.nan) if values is None else values
            mesh.set_active_scalars("shown")
            actor.mapper.scalar_range = (low, high)
            actor.user_matrix = scene.matrix(part, view)
            if lines is not None:
                edges.points = nodes[edges.point_data["node"]]
                lines.user_matrix = scene.matrix(part, view)
        self._mark()
        self._point()
        self.words.SetText(2, "\n".join(scene.told(view)))
        if self.slider is not None:
            told = self.slider.GetRepresentation()
            told.SetMaximumValue(max(1, self._last))
            told.SetValue(view.position)
            told.SetTitleText(scene.place(view))
        self.plotter.render()

    def _mark(self) -> None:
        """A dot on the place of the largest value; it is seen through the part."""
        peak = self.scene.peak(self.view)
        if peak is None:
            self.plotter.remove_actor(["largest-points", "largest-labels"], render=False)
            return
        part, node, _ = peak
        turn = self.scene.matrix(part, self.view)
        place = turn[:3, :3] @ self.scene.shape(part, self.view)[node] + turn[:3, 3]
        self.plotter.add_point_labels(
            place[None, :], ["largest"], name="largest", point_color=MARK, point_size=16,
            render_points_as_spheres=True, always_visible=True, shape_color="white",
            shape_opacity=0.8, text_color="black", font_size=13, reset_camera=False, render=False,
        )  # fmt: skip

    def _point(self) -> None:
        """Arrows of the forces at the pins."""
        if self.arrows is not None:
            self.plotter.remove_actor(self.arrows, render=False)
            self.arrows = None
        largest = self.scene.largest_force(self.view)
        bounds = np.array(self._bounds()).reshape(3, 2)
        length = _ARROW * float(np.linalg.norm(np.ptp(bounds, axis=1))) / (largest or 1.0)
        drawn = [
            self.pyvista.Arrow(
                start=place,
                direction=force,
                scale=length * size,
                shaft_radius=0.02,
                tip_radius=0.05,
            )
            for place, force in self.scene.pins(self.view)
            if (size := float(np.linalg.norm(force))) > 0.01 * largest
        ]
        if drawn:
            self.arrows = self.plotter.add_mesh(
                self.pyvista.merge(drawn), color="#d55e00", lighting=False, reset_camera=False,
                render=False,
            )  # fmt: skip

    def press(self, key: str) -> None:
        """Do what a key does; one that has no meaning does nothing."""
        self.keys.get(key, lambda: None)()

    def show(self) -> None:
        """Open the window until it is closed."""
        for key, action in self.keys.items():
            self.plotter.add_key_event(key, action)
        interactor = self.plotter.iren
        interactor.add_observer("TimerEvent", lambda *_: self.tick())
        self.plotter.show(interactive=False, auto_close=False)
        if windowless(self.plotter):
            raise SystemExit(NO_WINDOW)
        # VTK's own meaning of letters (p picks, 3 is stereo) must not come on top of these keys;
        # an observer on the style takes the place of its default, and q closes as before
        style = interactor.interactor.GetInteractorStyle()
        style.AddObserver("CharEvent", lambda *_: self._close_at_q())
        interactor.interactor.CreateRepeatingTimer(_TICK)
        interactor.start()
        self.plotter.close()

    def _close_at_q(self) -> None:
        interactor = self.plotter.iren.interactor
        if interactor.GetKeySym() in ("q", "e", "Escape"):
            interactor.TerminateApp()


def windowless(plotter: Any) -> bool:
    """Return True if the window that was opened is one that nobody sees."""
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
