"""The window of a checked design, by pyvista's own sliders: the stress of a part at a position.

python -m reports.window is its trial (with --off-screen: of a picture), in a process of its own:
VTK kills it where graphics libraries are missing. It ends with NO_WINDOW where these are there, but
nothing to open a window on.
"""

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from tempfile import gettempdir
from typing import Any

import numpy as np

from checks.result.live_fields import FATIGUE, LiveFields, von_mises, with_required_safety
from checks.result.verdict import DesignResult
from checks.result.words import brief, number, place_text
from geometry import INSTALL
from geometry.mesh import FloatArray
from reports.files import write_whole
from reports.pictures import run_worker, without_display
from reports.plain_still import FACES, LIGHTING, LINES, MARK, sharp_edges

FIELDS = {
    "von Mises stress [MPa]": "mises",
    "signed principal stress [MPa]": "principal",
    "fatigue utilisation, required safety included": "utilisation",
    "stress amplitude over the duty [MPa]": "amplitude",
    "mean stress over the duty (tension) [MPa]": "mean",
    "displacement [mm]": "displacement",
}
NO_WINDOW = 4  # exit code
SIZE = (1280, 800)
_SIGNED = ("principal", "mean")
_SAMPLES = 25  # positions from which ends of colours are taken, beside the worst
_WORKER = (sys.executable, "-m", "reports.window")
_TRIAL = 60.0  # s
_WINDOWLESS = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow", "vtkGenericOpenGLRenderWindow")


@dataclass(frozen=True)
class Trouble:
    """Reason that nothing could be shown; display: True for lack of one, not of graphics."""

    words: str
    display: bool = False


def try_window(
    *, off_screen: bool = False, worker: Sequence[str] = _WORKER, timeout: float = _TRIAL
) -> Trouble | None:
    """Try to open a window (or to draw without one) and tell what keeps it from it."""
    display = os.environ.get("DISPLAY", "")
    missing = not off_screen and sys.platform.startswith("linux") and not display
    if not missing:
        command = [*worker, "--off-screen"] if off_screen else worker
        ended = run_worker(command, Path(gettempdir()), timeout, window=not off_screen)
        if not ended.words:
            return None
        if ended.code != NO_WINDOW:
            return Trouble(f"{ended.words}. Where GL libraries are missing: {INSTALL}")
    said = f"DISPLAY is {display[:60] or 'not set'}"
    return Trouble(
        f"there is no display to open a window on ({said}): run it in a desktop session, over ssh "
        "with ssh -X, or write a picture with --off-screen FILE.png; the report of ballesta check "
        "shows the same fields in a browser",
        display=True,
    )


@dataclass(frozen=True, eq=False)
class Scene:
    """Parts with their fields, and the positions of all cycles, one after the other.

    places  (cycle, position in it, words)
    worst   part -> number of the place with its largest stress; of a grey one as checks found it
    first   part that is shown first
    """

    title: str
    parts: Mapping[str, LiveFields]
    places: Sequence[tuple[str, int, str]]
    worst: Mapping[str, int]
    first: str

    def values(self, part: str, field: str, place: int) -> FloatArray | None:
        """The field at the part's nodes (n,), None where it is not known."""
        live = self.parts[part]
        if field in FATIGUE:
            found = live.fatigue.get(field)
            return None if found is None else found.astype(np.float64)
        cycle, position, _ = self.places[place] if self.places else ("", 0, "")
        if not live.n_fields or cycle not in live.coefficients:
            return None
        if field == "displacement":
            moved = live.moved(cycle, position)
            return None if moved is None else np.linalg.norm(moved, axis=1)
        stress = live.at(cycle, position)
        return von_mises(stress) if field == "mises" else signed_principal(stress)

    def limits(self, part: str, field: str) -> tuple[float, float]:
        """Ends of the colours: the same at all positions; 0 is among them."""
        last = max(len(self.places) - 1, 0)
        places = {*np.linspace(0, last, _SAMPLES).round().astype(int).tolist(), self.worst[part]}
        found = [self.values(part, field, place) for place in places]
        known = np.concatenate([np.zeros(1), *(each for each in found if each is not None)])
        low, high = float(known.min()), float(known.max())
        if field in _SIGNED:
            low, high = -max(-low, high), max(-low, high)
        return low, high if high > low else low + 1.0

    def told(self, part: str, field: str, place: int) -> list[str]:
        """Caption, in lines of words."""
        live, values = self.parts[part], self.values(part, field, place)
        lines = [f"{brief(self.title, 40)}: {brief(part, 40)}"]
        if values is None:
            why = live.missing.get(field, "nothing loads this part in this cycle")
            return [*lines, f"not known: {brief(why, 160)}"]
        lines.append(f"largest now: {number(float(values[np.abs(values).argmax()]), 4)}")
        if live.n_fields and not live.decides:
            lines.append("to look at: no error bar, decides no check")
        return lines


def scene_of(result: DesignResult) -> Scene:
    """The scene of a result that was computed with its fields (check_design with live=True).

    Raises ValueError for a part without them.
    """
    parts, worst = {}, {}
    for part in result.parts:
        if not isinstance(part.live, LiveFields):
            raise ValueError(f"part {part.name!r} has no fields; it was not checked for them")
        live = with_required_safety(part.live, part.required_safety("fatigue"))
        missing = {field: advising(why) for field, why in live.missing.items()}
        parts[part.name] = replace(live, missing=missing)
        peaks = live.peaks or {
            name: cycle["peaks"][part.name]
            for name, cycle in result.cycles.items()
            if part.name in (cycle.get("peaks") or {})
        }
        sizes = [
            peaks.get(name, np.zeros(len(cycle["position"])))
            for name, cycle in result.cycles.items()
        ]
        worst[part.name] = int(np.argmax(np.concatenate(sizes))) if sizes else 0
    places = [
        (name, k, f"{brief(name, 30)}: {brief(cycle['shown_name'], 20)} = {place_text(shown)} "
         f"{brief(cycle['unit'], 10)}, {k + 1} of {len(cycle['position'])}")
        for name, cycle in result.cycles.items()
        for k, shown in enumerate(map(float, cycle["position"]))
    ]  # fmt: skip
    decides = result.deciding.part if result.checks else ""
    first = decides if decides in parts else next(iter(parts))
    return Scene(result.name, parts, places, worst, first)


def advising(words: str) -> str:
    """Words that advise the option of `ballesta show` in place of the other command's."""
    return words.replace("ballesta check --fields", "ballesta show --fields")


def signed_principal(stress: FloatArray) -> FloatArray:
    """The principal stress of largest size, with its sign (n,), of stress (n, 6), MPa."""
    values = np.linalg.eigvalsh(stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3))
    low, high = values[:, 0], values[:, -1]
    return np.asarray(np.where(high >= -low, high, low))


class Window:
    """A plotter that shows a part of a scene, with sliders for position, field and part."""

    def __init__(self, scene: Scene, part: str | None = None, *, off_screen: bool = False) -> None:
        if off_screen:
            os.environ.update(without_display())
        import pyvista as untyped

        self.pyvista: Any = untyped
        self.scene, self.part, self.field = scene, part or scene.first, "mises"
        self.place, self.limits = scene.worst[self.part], (0.0, 1.0)
        self.plotter: Any = self.pyvista.Plotter(
            off_screen=off_screen, window_size=list(SIZE), lighting=LIGHTING,
            title=f"ballesta: {scene.title[:80]}",
        )  # fmt: skip
        self.plotter.set_background("white")
        look = {"color": "black", "style": "modern"}
        names, fields = list(scene.parts), list(FIELDS)
        self.slider: Any = None  # while it is made, each slider asks for its own value
        self.plotter.add_text_slider_widget(
            lambda name: self.show(field=FIELDS[name]), fields, value=0,
            pointa=(0.62, 0.9), pointb=(0.95, 0.9), **look,
        )  # fmt: skip
        if len(names) > 1:
            self.plotter.add_text_slider_widget(
                lambda name: self.show(part=name), names, value=names.index(self.part),
                pointa=(0.03, 0.08), pointb=(0.23, 0.08), **look,
            )  # fmt: skip
        self.slider = self.plotter.add_slider_widget(
            lambda value: self.show(place=round(value)), [0, max(1, len(scene.places) - 1)],
            value=self.place, title=" ", title_height=0.02, pointa=(0.3, 0.08),
            pointb=(0.7, 0.08), interaction_event="always", **look,
        )  # fmt: skip
        self.slider.GetRepresentation().ShowSliderLabelOff()
        self.show(part=self.part)

    def show(self, part: str = "", field: str = "", place: int | None = None) -> None:
        """Show another part, at its worst position and as a whole, another field or position."""
        if self.slider is None:
            return
        self.part, self.field = part or self.part, field or self.field
        if part:
            place = self.scene.worst[part]
        if place is not None:
            self.place = min(place, max(len(self.scene.places) - 1, 0))
        if part or field:
            self.limits = self.scene.limits(self.part, self.field)
        self._draw()
        if part:
            self.plotter.view_isometric(bounds=self.plotter.actors["part"].bounds)
            self.plotter.camera.zoom(0.85)  # room for words and sliders
        self.plotter.render()

    def _draw(self) -> None:
        live = self.scene.parts[self.part]
        values = self.scene.values(self.part, self.field, self.place)
        surface = self.pyvista.PolyData.from_regular_faces(live.nodes, live.triangles)
        quiet = {"reset_camera": False, "render": False}
        self.plotter.remove_actor(["largest-points", "largest-labels", "edges"], render=False)
        if self.plotter.scalar_bars:
            self.plotter.remove_scalar_bar(render=False)
        self.plotter.add_mesh(
            surface, name="part", scalars=values, color="lightgrey", clim=self.limits,
            cmap="coolwarm" if self.field in _SIGNED else "viridis", **FACES, **quiet,
            show_scalar_bar=values is not None, scalar_bar_args={
                "title": " ", "color": "black", "vertical": True, "fmt": "%.3g", "n_labels": 6,
                "position_x": 0.92, "position_y": 0.2, "height": 0.6, "render": False,
            },
        )  # fmt: skip
        edges = sharp_edges(surface)
        if edges.n_points:
            self.plotter.add_mesh(edges, name="edges", **LINES, **quiet)
        if values is not None:  # a dot that is seen through the part
            self.plotter.add_point_labels(
                live.nodes[[np.abs(values).argmax()]], ["largest"], name="largest", font_size=13,
                point_color=MARK, point_size=16, render_points_as_spheres=True,
                always_visible=True, shape_color="white", shape_opacity=0.8, **quiet,
            )  # fmt: skip
        words = "\n".join(self.scene.told(self.part, self.field, self.place))
        self.plotter.add_text(words, font_size=11, color="black", name="words", render=False)
        slider = self.slider.GetRepresentation()
        slider.SetValue(self.place)
        slider.SetTitleText(self.scene.places[self.place][2] if self.scene.places else " ")


def write_picture(scene: Scene, file: Path, part: str | None = None) -> None:
    """Write the window as it opens to a PNG file; raises OSError where that cannot be written."""
    plotter, picture = Window(scene, part, off_screen=True).plotter, BytesIO()
    plotter.screenshot(picture)
    plotter.close()
    write_whole(file, picture.getvalue())


def main(off_screen: bool) -> None:
    """Open a window for trial and close it; ends with NO_WINDOW where that is impossible."""
    import pyvista as untyped

    pyvista: Any = untyped
    plotter = pyvista.Plotter(off_screen=off_screen, window_size=[64, 64])
    plotter.add_mesh(pyvista.Sphere(theta_resolution=6, phi_resolution=6))
    plotter.show(interactive=False, auto_close=False)
    missing = not off_screen and plotter.render_window.GetClassName() in _WINDOWLESS
    plotter.close()
    if missing:
        raise SystemExit(NO_WINDOW)


if __name__ == "__main__":
    main("--off-screen" in sys.argv)
