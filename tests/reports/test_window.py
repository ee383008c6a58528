import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from checks.result.live_fields import LiveFields, LivePeak, grey
from reports.pictures import run_worker
from reports.window import NO_WINDOW, SIZE, open_window, probe_window, window_picture
from reports.window_scene import View, Worst, read_scene, scene_of, signed_principal, write_scene

from . import motion_results, results

STRICT = (sys.executable, "-W", "error", "-m", "reports.window")


def worker(code):
    return (sys.executable, "-c", code)


def live(scale=1.0, size=(250.0, 80.0, 60.0)):
    """A box pulled along x, harder towards one end, and bent by a second unit load."""
    surface = results.box(size, n=6)
    n = len(surface.nodes)
    stress = np.zeros((2, n, 6))
    stress[0, :, 0] = surface.nodes[:, 0] / 250
    stress[1, :, 0] = -surface.nodes[:, 1] / 80
    moved = np.zeros((2, n, 3))
    moved[0, :, 0] = surface.nodes[:, 0] * 1e-5
    moved[1, :, 1] = surface.nodes[:, 0] ** 2 * 1e-7
    motion = motion_results.press().motion["press"]
    count = int(motion.index[-1]) + 1
    weights = scale * np.stack([np.linspace(0, 100, count), np.linspace(0, 50, count)])
    return LiveFields(
        nodes=surface.nodes,
        triangles=surface.triangles,
        stress=stress,
        displacement=moved,
        coefficients={"press": weights},
        peaks={"press": weights[0]},
        fatigue={"utilisation": np.linspace(0, 0.8, n)},
        missing={"amplitude": "fatigue was not judged: no cycle of the duty loads this part"},
        peak=LivePeak(3, "press", count - 1, 100.0 * scale, "end"),
    )


@pytest.fixture(scope="module")
def result():
    press = motion_results.press()
    bare = grey(results.box(n=4).nodes, results.box(n=4).triangles, "decided by formula")
    fields = [live(), live(0.5, (250.0, 40.0, 90.0)), bare]
    parts = [replace(part, live=each) for part, each in zip(press.parts, fields, strict=True)]
    return replace(press, parts=parts)


@pytest.fixture(scope="module")
def scene(result):
    return scene_of(result)


def test_a_result_without_fields_is_refused():
    with pytest.raises(ValueError, match="'bar_upper' has no fields"):
        scene_of(motion_results.press())


def test_utilisation_counts_the_required_safety_as_the_page_does(result):
    part, *others = result.parts
    judged = results.check(part.name, kind="fatigue", required=1.25)
    made = replace(result, parts=[replace(part, checks=[judged]), *others])
    shown = scene_of(made).values(View(0, field="utilisation"))
    assert_allclose(shown, 1.25 * part.live.fatigue["utilisation"], rtol=1e-6)


def test_a_scene_comes_back_from_its_folder(tmp_path, scene):
    write_scene(scene, tmp_path)
    again = read_scene(tmp_path)
    assert again.title == scene.title
    for one, other in zip(again.parts, scene.parts, strict=True):
        assert one.name == other.name
        assert (one.live.stress == other.live.stress).all()
        assert one.live.missing == other.live.missing
        assert one.live.peak == other.live.peak
        assert one.worst == other.worst
    assert again.told(scene.first_view()) == scene.told(scene.first_view())


def test_it_begins_at_the_worst_position_of_the_part_that_is_asked_for(scene):
    last = scene.cycles[0].n - 1
    assert scene.first_view() == View(0, 0, last)
    assert scene.first_view("bar_lower") == View(1, 0, last)


def test_a_grey_part_begins_where_the_peaks_of_the_cycles_say(scene, result):
    peaks = result.cycles["rig"]["peaks"]["pin_B"]
    worst = Worst(1, int(np.argmax(peaks)), float(max(peaks)))
    assert scene.parts[2].live.peak is None
    assert scene.parts[2].worst == worst
    assert scene.first_view("pin_B") == View(2, worst.cycle, worst.position)


def test_where_all_are_grey_it_begins_with_the_worst(scene):
    bare = scene.parts[2].live
    worst = (Worst(0, 3, 5.0), None, Worst(1, 7, 8.0))
    grey_ones = [
        replace(part, live=bare, worst=at) for part, at in zip(scene.parts, worst, strict=True)
    ]
    all_grey = replace(scene, parts=grey_ones)
    assert all_grey.first_view() == View(2, 1, 7)
    assert all_grey.first_view("bar_upper") == View(0, 0, 3)
    assert all_grey.first_view("bar_lower") == View(1, 0, 0)  # nobody knows
    nothing = replace(scene, parts=[replace(part, worst=None) for part in grey_ones])
    assert nothing.first_view() == View(0, 0, 0)


def test_a_position_is_counted_as_people_do(scene):
    n = scene.cycles[0].n
    assert scene.place(View(0)) == f"position 1 of {n}"
    assert scene.place(View(0, 0, n - 1)) == f"position {n} of {n}"


def test_stress_that_decides_no_check_is_told_to_be_for_looking_at(scene):
    one, other, bare = scene.parts
    drawn = replace(one, live=replace(one.live, decides=False))
    mixed = replace(scene, parts=[drawn, other, bare])
    said = "to look at: no error bar, decides no check"
    assert said in mixed.told(View(0))
    assert said not in mixed.told(View(1))
    assert said not in mixed.told(View(0, field="amplitude"))  # not known: nothing is seen
    assert not any("to look at" in line for line in scene.told(View(0)))


def test_the_field_is_the_superposition_and_its_limits_hold_over_the_cycle(scene):
    part = scene.parts[0].live
    view = View(0, 0, 40)
    expected = part.at("press", 40)[:, 0]
    assert_allclose(scene.values(view), np.abs(expected), rtol=1e-5, atol=1e-4)
    assert_allclose(scene.values(replace(view, field="principal")), expected, atol=1e-4)
    low, high = scene.limits(view)
    assert low == 0
    assert high == pytest.approx(100, rel=1e-5)
    low, high = scene.limits(replace(view, field="principal"))
    assert low == -high  # signed colours keep 0 in the middle
    assert scene.limits(replace(view, position=3)) == scene.limits(view)


def test_displacements_are_drawn_so_large_that_they_are_seen(scene):
    last = scene.cycles[0].n - 1
    view = View(0, 0, last, deformed=True)
    moved = np.linalg.norm(scene.shape(view) - scene.shape(View(0, 0, last)), axis=1).max()
    assert moved == pytest.approx(0.05 * scene.parts[0].size, rel=1e-6)
    assert any("displacements drawn" in line for line in scene.told(view))


def test_what_is_not_known_is_told_with_the_reason(scene):
    assert "not known: decided by formula" in scene.told(View(2))
    told = scene.told(View(0, field="amplitude"))
    assert any("no cycle of the duty loads this part" in line for line in told)
    assert any("nothing loads this part in this cycle" in line for line in scene.told(View(0, 1)))


def test_the_signed_principal_stress_is_that_of_the_eigenvalues():
    stress = np.random.default_rng(1).normal(size=(200, 6)) * 100
    stress[:3] = [[5, 5, 5, 0, 0, 0], [0, 0, 0, 0, 0, 0], [-80, 0, 0, 0, 0, 0]]
    tensors = stress[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    values = np.linalg.eigvalsh(tensors)
    largest = values[np.arange(200), np.abs(values).argmax(axis=1)]
    assert_allclose(signed_principal(stress), largest, rtol=1e-9, atol=1e-9)


@pytest.fixture(scope="module")
def pictures(scene, tmp_path_factory):
    """Pictures of the window after some keys, by what they do."""
    folder = tmp_path_factory.mktemp("window")
    write_scene(scene, folder)
    steps = {
        "first": [], "field": ["6"], "back": ["1"], "cycle": ["c"], "worst": ["p"],
        "displaced": ["d"], "next": ["d", "n"], "grey": ["n"],
    }  # fmt: skip
    order = [each for name, keys in steps.items() for each in (*keys, str(folder / f"{name}.png"))]
    ended = run_worker([*STRICT, str(folder), "", *order], folder, 120)
    assert ended.words == ""
    found = {}
    for name in steps:
        with Image.open(folder / f"{name}.png") as image:
            found[name] = np.asarray(image.convert("RGB")).astype(int)
    return found


def test_a_picture_is_written_in_place_of_a_window(scene, tmp_path):
    file = tmp_path / "out" / "window.png"
    assert window_picture(scene, file, "bar_lower", ["d"], worker=STRICT) is None
    with Image.open(file) as image:
        assert image.size == SIZE


@pytest.mark.parametrize("name", ["field", "cycle", "next", "grey", "displaced"])
def test_every_key_changes_the_picture(pictures, name):
    """Below the words, so that it is not they alone that changed."""
    changed = np.abs(pictures[name] - pictures["first"]).max(axis=2)[150:650] > 30
    assert changed.mean() > 0.004


@pytest.mark.parametrize("name", ["back", "worst"])
def test_the_field_and_the_worst_position_bring_the_first_picture_back(pictures, name):
    """The first picture is of the von Mises stress at the worst position."""
    assert np.abs(pictures[name] - pictures["first"]).max() == 0


def test_stress_is_coloured_and_what_is_not_known_is_grey(pictures):
    def coloured(image):
        scene_only = image[150:650, :1150]
        return (np.ptp(scene_only, axis=2) > 60).mean()

    assert coloured(pictures["first"]) > 0.03
    assert coloured(pictures["grey"]) < 0.2 * coloured(pictures["first"])


def test_the_colour_bar_stands_only_beside_what_is_coloured(pictures):
    def coloured(image):
        return (np.ptp(image[200:600, 1180:], axis=2) > 60).mean()

    assert coloured(pictures["first"]) > 0.05
    assert coloured(pictures["grey"]) == 0


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("import os; os._exit(139)", "exit code 139, signal SIGSEGV"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "signal SIGSEGV"),
        ("raise ImportError('libGL.so.1: cannot open')", "it said: ImportError: libGL.so.1"),
    ],
)
def test_a_worker_that_dies_is_trouble_with_its_cure(scene, tmp_path, monkeypatch, code, words):
    monkeypatch.setenv("DISPLAY", ":1")
    for trouble in (
        probe_window(worker=worker(code)),
        open_window(scene, worker=worker(code)),
        window_picture(scene, tmp_path / "none.png", worker=worker(code)),
    ):
        assert words in trouble.words
        assert "apt-get install libgl1 libegl1" in trouble.words
        assert not trouble.display
    assert not (tmp_path / "none.png").exists()


def test_a_worker_that_hangs_is_stopped(scene, tmp_path, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":1")
    hanging = worker("import time; time.sleep(60)")
    for trouble in (
        probe_window(worker=hanging, timeout=0.3),
        window_picture(scene, tmp_path / "none.png", worker=hanging, timeout=0.3),
    ):
        assert "took longer than 0.3 s and was stopped" in trouble.words


def test_a_worker_that_draws_nothing_or_is_not_there_is_trouble(scene, tmp_path):
    trouble = window_picture(scene, tmp_path / "none.png", worker=worker(""))
    assert "drew nothing" in trouble.words
    assert "did not start" in window_picture(scene, tmp_path / "a.png", worker=["/no"]).words


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere DISPLAY says nothing")
def test_without_a_display_nothing_is_started(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    trouble = probe_window(worker=["/no/such"])
    assert trouble.display
    assert "DISPLAY is not set" in trouble.words
    assert "--off-screen FILE.png" in trouble.words


def test_a_display_that_does_not_answer_is_told(monkeypatch):
    monkeypatch.setenv("DISPLAY", ":1")
    trouble = probe_window(worker=worker(f"raise SystemExit({NO_WINDOW})"))
    assert trouble.display
    assert "DISPLAY is :1" in trouble.words


DRIVE = """
import sys
from pathlib import Path
from reports.window_scene import read_scene
from reports.window import Window
window = Window(read_scene(Path(sys.argv[1])), None, False)
steps = ["2", "n", "c", "p", "q"]
seen, ticks = [], [0]
def told():
    ticks[0] += 1
    if ticks[0] % 6 or not steps:
        return
    seen.append((window.view.field, window.view.part, window.view.cycle))
    key, keys = steps.pop(0), window.plotter.iren.interactor
    if key:
        keys.SetKeySym(key)
        keys.SetKeyCode(key if len(key) == 1 else " ")
        keys.KeyPressEvent()
        keys.CharEvent()
window.plotter.iren.add_observer("TimerEvent", lambda *_: told())
start = window.plotter.iren.start
def started():
    window.plotter.iren.interactor.CreateRepeatingTimer(40)
    start()
window.plotter.iren.start = started
window.show()
fields, parts, cycles = zip(*seen)
assert fields == ("mises",) + ("principal",) * 4, fields
assert parts == (0, 0, 1, 1, 1), parts
assert cycles == (0, 0, 0, 1, 0), cycles
"""


@pytest.fixture
def display():
    """A display of its own; skipped where there is no Xvfb."""
    program = shutil.which("Xvfb")
    if program is None:
        pytest.skip("there is no Xvfb: apt-get install xvfb")
    reading, writing = os.pipe()
    started = subprocess.Popen(
        [program, "-displayfd", str(writing), "-screen", "0", "1400x900x24"],
        pass_fds=[writing], stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(writing)
    try:
        with os.fdopen(reading) as told:
            number = told.readline().strip()
        for _ in range(50):  # until it answers
            with socket.socket(socket.AF_UNIX) as door:
                if door.connect_ex(f"/tmp/.X11-unix/X{number}") == 0:
                    break
            time.sleep(0.1)
        yield f":{number}"
    finally:
        started.send_signal(signal.SIGTERM)
        started.wait(10)


@pytest.mark.slow
def test_the_window_opens_obeys_its_keys_and_closes(scene, tmp_path, display, monkeypatch):
    """The keys go through the window's own interactor; q ends it, so the process ends."""
    monkeypatch.setenv("DISPLAY", display)
    assert probe_window() is None
    write_scene(scene, tmp_path)
    begun = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", DRIVE, str(tmp_path)],
        capture_output=True, text=True, timeout=90, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert time.monotonic() - begun < 60
