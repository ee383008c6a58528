import subprocess
import sys
from dataclasses import replace
from io import BytesIO
from time import monotonic, sleep

import numpy as np
import psutil
import pytest
from PIL import Image

from checks.result.live_fields import LiveFields
from checks.result.verdict import NOT_MESHED
from checks.result.words import utilisation_text
from reports import pictures_worker
from reports.live.section import estimate_of, with_encoded_fields
from reports.page import report_html
from reports.page_parts import _captions
from reports.pictures import (
    Ended,
    StandingWorker,
    _ahead,
    draw_ahead,
    drawing,
    prepare_drawing,
    stress_field,
)
from reports.pictures_worker import SIZE, corner_view, view_of
from reports.plain_still import AHEAD

from . import chart_results, results

DIES = "import os; os._exit(139)"


def worker(code):
    return (sys.executable, "-c", code)


def render_stills(parts, **options):
    with drawing(parts, **options) as pictures:
        return pictures()


@pytest.fixture(scope="module")
def drawn():
    return render_stills(results.mixed().parts)


def test_every_part_is_drawn_in_both_views(drawn):
    assert drawn.reason == ""
    assert {name: set(views) for name, views in drawn.images.items()} == {
        "bar_upper": {"whole", "peak"},
        "pin_B": {"whole", "peak"},
    }
    for views in drawn.images.values():
        for image in views.values():
            assert Image.open(BytesIO(image)).size == SIZE
            assert len(image) < 400_000


def test_a_still_shows_the_part_its_colours_and_the_marker_on_white(drawn):
    pixels = np.asarray(Image.open(BytesIO(drawn.images["bar_upper"]["whole"])).convert("RGB"))
    assert (pixels[-1, 0] == 255).all()
    assert 0.1 < (pixels.min(axis=2) < 200).mean() < 0.9
    red, green, blue = pixels.astype(int).transpose(2, 0, 1)
    marker = (red > 150) & (green < 90) & (blue < 160) & (red > blue + 40)
    assert 40 < marker.sum() < 2000
    rows, columns = np.nonzero(marker)
    # The peak of the box is its front corner: right of the middle of the scene, inside it.
    assert 0.4 * SIZE[0] < columns.mean() < 0.83 * SIZE[0]
    assert 0.3 * SIZE[1] < rows.mean() < 0.7 * SIZE[1]


def test_a_buckling_mode_is_drawn_as_it_displaces_the_part():
    part = results.mixed().parts[0]
    moved = np.asarray(part.surface.nodes) * [1.0, 1.0, 2.0]
    size = np.linspace(0.0, 1.0, len(moved))
    mode = replace(part.surface, nodes=moved, fields={"buckling mode": size}, peak=len(moved) - 1)
    pictures = render_stills([replace(part, mode=mode)])
    assert pictures.reason == ""
    assert list(pictures.images[part.name]) == ["whole", "peak", "mode"]
    assert pictures.images[part.name]["mode"] != pictures.images[part.name]["whole"]


def test_a_part_that_was_not_meshed_is_grey_without_a_marker_or_a_colour_bar():
    """Its one field is zero everywhere: colours would claim a stress that nobody knows."""
    surface = replace(results.box(), fields={NOT_MESHED: np.zeros(len(results.box().nodes))})
    part = results.part(surface=surface, meshes=[], checks=[results.check(method="formula")])
    pictures = render_stills([part])
    assert pictures.reason == ""
    assert list(pictures.images["bar_upper"]) == ["plain"]
    image = Image.open(BytesIO(pictures.images["bar_upper"]["plain"])).convert("RGB")
    pixels = np.asarray(image).astype(int)
    assert np.ptp(pixels, axis=2).max() < 12  # nothing coloured, whatever the lights' tint
    assert (pixels.min(axis=2) < 240).mean() > 0.1
    assert (pixels[:, int(0.9 * SIZE[0]) :] == 255).all()
    page = report_html(results.design(part), pictures)
    assert "Not meshed: decided by formula." in page
    assert 'alt="The whole part of bar_upper, not meshed, without colours of stress"' in page


def formula_part(*, limit=355.0, **check):
    """A box that a formula decided: the estimated stress grows along x to 200 and 300 MPa."""
    box = results.box()
    x = np.asarray(box.nodes)[:, 0]
    stress, sizes = np.zeros((1, len(x), 6)), np.array([200.0, 300.0])
    stress[0, :, 0] = x / x.max()
    live = LiveFields(
        nodes=box.nodes, triangles=box.triangles, stress=stress, displacement=None,
        coefficients={"press": sizes[None]}, peaks={"press": sizes},
        estimated=True, decides=False,
    )  # fmt: skip
    surface = replace(box, fields={NOT_MESHED: np.zeros(len(x))})
    checks = [results.check(method="formula", limit=limit, required=1.5, **check)]
    return results.part(surface=surface, meshes=[], checks=checks, live=live)


@pytest.mark.parametrize(("value", "above"), [(200.0, True), (400.0, False)])
def test_an_estimate_above_the_check_that_decides_says_why_in_its_caption(value, above):
    """It is 0.75; the check 0.5 or 1 and its bars."""
    told = _captions(formula_part(limit=600.0, value=value))["estimate"][2]
    assert ("that is less, as what presses on a bent part relieves it" in told) == above


@pytest.mark.parametrize(("limit", "red"), [(600.0, False), (300.0, True)])
def test_a_part_that_a_formula_decided_is_painted_by_its_estimate(limit, red):
    """300 MPa of 600 / 1.5 allowed is 0.75, in blue; of 300 / 1.5 it is 1.5, red where x > 2/3."""
    part = formula_part(limit=limit)
    pictures = render_stills([part])
    assert pictures.reason == ""
    assert list(pictures.images[part.name]) == ["estimate"]
    image = Image.open(BytesIO(pictures.images[part.name]["estimate"])).convert("RGB")
    pixels = np.asarray(image).astype(int)[:, : int(0.83 * SIZE[0])]
    r, _, b = pixels[pixels.min(axis=2) < 235].T
    assert len(np.unique(b - r)) > 20  # grey to blue
    assert ((r - b) > 60).any() == red
    shown = with_encoded_fields(results.design(part))
    page = report_html(shown, pictures)
    assert f"at most {450 / limit:.3g} of 1, by formula: stress of the section forces" in page
    assert "Static utilisation (von Mises), estimate" in page
    checked = utilisation_text(part.checks[0].utilisation)
    assert f"are not in it: utilisation {checked} of the check that decides" in page
    again = render_stills(shown.parts)  # as one is drawn whose result was kept without its stills
    assert again.images == pictures.images


def test_the_estimate_is_that_of_the_deciding_check_as_the_live_view_has_it():
    part = formula_part()
    used = np.linspace(0.0, 0.5, len(part.live.nodes))
    live = replace(part.live, fatigue={"utilisation": used}, judged=True)
    fatigue = results.check(kind="fatigue", value=180.0, limit=150.0, required=1.3)
    estimate = estimate_of(replace(part, live=live, checks=[*part.checks, fatigue]))
    assert stress_field(estimate) == "fatigue utilisation over the duty, estimate"
    assert estimate.fields[stress_field(estimate)] == pytest.approx(1.3 * used)
    column = formula_part(kind="buckling", value=200.0)
    assert "column" in stress_field(estimate_of(column))
    assert estimate_of(replace(column, live=None)) is None
    assert estimate_of(replace(column, live=replace(live, estimated=False))) is None
    bearing = formula_part(kind="bearing")  # nothing says how much stress is allowed
    assert estimate_of(bearing) is None


def test_surfaces_that_are_alike_are_drawn_once():
    """A worker that draws the first alone: nothing is missing where the second is the same."""
    part = results.mixed().parts[0]
    moved = np.asarray(part.surface.nodes) + 1.0
    one = worker(
        "while name := input():\n"
        "  for view in 'whole', 'peak': open(f'{name}/part_0_{view}.png', 'w').write('png')\n"
        "  print(name, flush=True)"
    )
    same = render_stills([part, replace(part, name="again")], worker=one)
    assert same.reason == ""
    assert same.images["again"] == same.images[part.name] == {"whole": b"png", "peak": b"png"}
    other = replace(part, name="other", surface=replace(part.surface, nodes=moved))
    assert "2 of 4 pictures are missing" in render_stills([part, other], worker=one).reason


def test_who_asks_for_pictures_loads_nothing_that_draws():
    code = (
        "import sys, reports.page, reports.pictures, reports.charts\n"
        "print({'PIL', 'matplotlib', 'pyvista'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_a_part_that_is_drawn_ahead_is_not_drawn_again(monkeypatch):
    """Another design's parts are: nothing of a design is kept beyond it."""

    class Here:
        """Draws in this process."""

        runs = True

        def hand(self, folder):
            ahead = (folder / AHEAD).is_file()
            (pictures_worker.draw_ahead if ahead else pictures_worker.draw_folder)(folder)

        def answer(self, folder, timeout):
            return Ended(0, "")

    result = chart_results.design()
    monkeypatch.setattr("reports.pictures._standing", lambda _: Here())
    made = []
    still = pictures_worker.still
    monkeypatch.setattr(
        pictures_worker, "still", lambda *given: made.append(given) or still(*given)
    )
    draw_ahead(result.parts[0])
    before = len(made)
    assert before > 0
    with drawing(result.parts[:1]) as pictures:
        found = pictures()
    assert len(made) == before
    assert found.reason == ""
    assert set(found.images[result.parts[0].name]) == {"whole", "peak"}
    with drawing(result.parts[:1]) as pictures:
        assert pictures().images == found.images
    assert len(made) == 2 * before
    assert not any(folder.exists() for folder in _ahead)


def test_one_process_draws_for_design_after_design(monkeypatch):
    started = []

    class Counted(StandingWorker):
        def __init__(self, command):
            started.append(command)
            super().__init__(command)

    monkeypatch.setattr("reports.pictures.StandingWorker", Counted)
    echo = worker("import sys\nfor line in sys.stdin: print(line, end='', flush=True)")
    prepare_drawing(echo)
    for _ in range(3):
        assert "left pictures out" in render_stills(results.mixed().parts, worker=echo).reason
    assert len(started) == 1
    assert "SIGSEGV" in render_stills(results.mixed().parts, worker=worker(DIES)).reason
    assert "SIGSEGV" in render_stills(results.mixed().parts, worker=worker(DIES)).reason
    assert len(started) == 3  # what has ended is started anew


@pytest.mark.slow
def test_pictures_that_nobody_waits_for_cost_the_next_design_none():
    """Their folder vanishes while they are drawn; the process had died of it at the next ones."""
    parts = results.mixed().parts
    for _ in range(3):
        with drawing(results.mixed().parts):
            pass
    assert render_stills(parts).reason == ""


def test_the_process_that_draws_ends_with_the_one_that_started_it():
    """Also where that is killed: it is then told by the end of its input."""
    code = (
        "import os, signal, reports.pictures as p\n"
        "p.prepare_drawing()\n"
        "[worker] = p._running.values()\n"
        "print(worker._process.pid, flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    latest = monotonic() + 60
    while _runs(int(done.stdout)) and monotonic() < latest:
        sleep(0.05)
    assert not _runs(int(done.stdout))


def _runs(process):
    try:
        return psutil.Process(process).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def test_hostile_names_are_drawn():
    hostile = results.hostile()
    pictures = render_stills(hostile.parts[:1])
    assert pictures.reason == ""
    assert len(pictures.images[results.HOSTILE]) == 2


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (DIES, "exit code 139, signal SIGSEGV"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "exit code -9, signal SIGKILL"),
        ("raise ImportError('libGL.so.1: cannot open')", "it said: ImportError: libGL.so.1"),
        ("raise SystemExit(3)", "exit code 3"),
        ("", "left pictures out"),
    ],
)
def test_a_worker_that_dies_is_a_reason_with_its_cure(code, words):
    pictures = render_stills(results.mixed().parts, worker=worker(code))
    assert words in pictures.reason
    assert "4 of 4 pictures are missing" in pictures.reason
    assert "apt-get install libgl1 libegl1" in pictures.reason
    assert "pictures are missing" in report_html(results.mixed(), pictures)


def test_what_was_drawn_before_the_end_is_kept():
    code = "import os; open(input() + '/part_0_whole.png', 'wb').write(b'png'); os.abort()"
    pictures = render_stills(results.mixed().parts, worker=worker(code))
    assert pictures.images == {"bar_upper": {"whole": b"png"}, "pin_B": {}}
    assert "3 of 4 pictures are missing: the worker ended with exit code -6" in pictures.reason


def test_a_worker_that_hangs_is_stopped():
    pictures = render_stills(
        results.mixed().parts, timeout=0.5, worker=worker("import time; time.sleep(60)")
    )
    assert "drawing took longer than 0.5 s and was stopped" in pictures.reason


def test_a_worker_that_is_not_there_is_a_reason():
    assert "did not start" in render_stills(results.mixed().parts, worker=["/no/such"]).reason


def test_no_parts_need_no_worker():
    pictures = render_stills([], worker=["/no/such"])
    assert (pictures.images, pictures.reason) == ({}, "")


def test_the_stress_is_drawn_and_not_another_field():
    surface = results.box()
    fields = {"displacement x": surface.nodes[:, 0], **surface.fields}
    assert stress_field(replace(surface, fields=fields)) == "von Mises [MPa]"
    with pytest.raises(ValueError, match="without fields"):
        stress_field(replace(surface, fields={}))


def test_the_camera_avoids_the_opposite_wall_of_a_bore():
    """A ring wall seen from inside: straight along the normal the other wall is in the way."""
    angles, heights = np.linspace(0, 2 * np.pi, 25)[:-1], np.linspace(-5, 5, 5)
    nodes = np.array([[10 * np.cos(a), 10 * np.sin(a), h] for h in heights for a in angles])
    index = np.arange(len(nodes)).reshape(5, 24)
    right = np.roll(index, -1, axis=1)
    a, b, c, d = (x.ravel() for x in (index[:-1], right[:-1], right[1:], index[1:]))
    inwards = np.concatenate([np.column_stack([a, c, b]), np.column_stack([a, d, c])])
    peak = 2 * 24  # at (10, 0, 0), where inwards is -x
    direction, hidden = view_of(nodes, inwards, peak)
    assert not hidden
    assert direction[0] < -0.1
    # It must leave through an open end: past the rim (height 5) before the far wall (20 away).
    assert abs(direction[2]) / abs(direction[0]) > 5 / 20
    outwards, _ = view_of(nodes, inwards[:, ::-1], peak)
    assert outwards[0] > 0.8


@pytest.mark.parametrize("corner", [(250.0, 0.0, 60.0), (0.0, 80.0, 0.0), (0.0, 0.0, 60.0)])
def test_the_whole_part_is_seen_from_the_side_of_its_peak(corner):
    surface = results.box()
    peak = int(np.linalg.norm(surface.nodes - corner, axis=1).argmin())
    direction, hidden = corner_view(surface.nodes, surface.triangles, peak)
    normal = np.subtract(corner, (125, 40, 30)) / (125, 40, 30)
    assert not hidden
    # A corner's own triangles may face any of its three sides, and one must be looked at.
    assert (np.sign(direction) == normal).any()


def test_a_peak_that_nobody_can_see_is_called_hidden():
    """A box turned inside out: the inner side of a face's middle is behind the other faces."""
    surface = results.box()
    middle = int(np.linalg.norm(surface.nodes - (250, 40, 30), axis=1).argmin())
    for view in (corner_view, view_of):
        assert not view(surface.nodes, surface.triangles, middle)[1]
        assert view(surface.nodes, surface.triangles[:, ::-1], middle)[1]
