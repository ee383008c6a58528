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
from reports.window import (
    NO_WINDOW,
    SIZE,
    Window,
    scene_of,
    signed_principal,
    try_window,
    write_picture,
)

from . import motion_results, results


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
    shown = scene_of(made).values(part.name, "utilisation", 0)
    assert_allclose(shown, 1.25 * part.live.fatigue["utilisation"], rtol=1e-6)


def test_positions_of_all_cycles_follow_each_other(scene, result):
    counts = [len(cycle["position"]) for cycle in result.cycles.values()]
    assert len(scene.places) == sum(counts)
    first, second = list(result.cycles)
    assert scene.places[0][:2] == (first, 0)
    assert scene.places[counts[0]][:2] == (second, 0)
    assert scene.places[counts[0] - 1][2].endswith(f", {counts[0]} of {counts[0]}")


def test_it_begins_at_the_largest_stress(scene, result):
    """Of a grey part where the checks found it, here in the second cycle."""
    assert scene.places[scene.worst["bar_upper"]][:2] == ("press", 362)
    cycle, position, _ = scene.places[scene.worst["pin_B"]]
    peaks = result.cycles["rig"]["peaks"]["pin_B"]
    assert cycle == "rig"
    assert peaks[position] == max(peaks)
    assert scene.first == result.deciding.part


def test_stress_that_decides_no_check_is_told_to_be_for_looking_at(scene):
    drawn = replace(scene.parts["bar_upper"], decides=False)
    mixed = replace(scene, parts={**scene.parts, "bar_upper": drawn})
    said = "to look at: no error bar, decides no check"
    assert said in mixed.told("bar_upper", "mises", 0)
    assert said not in mixed.told("bar_lower", "mises", 0)
    assert said not in mixed.told("bar_upper", "amplitude", 0)  # not known: nothing is seen


def test_the_field_is_the_superposition_and_its_limits_hold_over_the_cycle(scene):
    expected = scene.parts["bar_upper"].at("press", 40)[:, 0]
    assert_allclose(scene.values("bar_upper", "mises", 40), np.abs(expected), rtol=1e-5, atol=1e-4)
    assert_allclose(scene.values("bar_upper", "principal", 40), expected, atol=1e-4)
    low, high = scene.limits("bar_upper", "mises")
    assert low == 0
    assert high == pytest.approx(100, rel=1e-5)
    low, high = scene.limits("bar_upper", "principal")
    assert low == -high  # signed colours keep 0 in the middle


def test_what_is_not_known_is_told_with_the_reason(scene, result):
    assert "not known: decided by formula" in scene.told("pin_B", "mises", 0)
    told = scene.told("bar_upper", "amplitude", 0)
    assert any("no cycle of the duty loads this part" in line for line in told)
    other = len(scene.places) - 1
    told = scene.told("bar_upper", "mises", other)
    assert any("nothing loads this part in this cycle" in line for line in told)


def test_the_signed_principal_stress_is_the_largest_by_its_size():
    """Pulled, pressed and sheared bars: the stress, and its larger end in size."""
    stress = np.zeros((4, 6))
    stress[0, 0], stress[1, 0], stress[2, 3], stress[3, :3] = 5.0, -80.0, 7.0, (3.0, -4.0, 1.0)
    assert_allclose(signed_principal(stress), [5.0, -80.0, 7.0, -4.0])


@pytest.fixture
def window(scene):
    shown = Window(scene, "bar_upper", off_screen=True)
    yield shown
    shown.plotter.close()


def pixels(window):
    return window.plotter.screenshot(None, return_img=True).astype(int)


def move(slider, value):
    slider.GetRepresentation().SetValue(value)
    for event in ("InteractionEvent", "EndInteractionEvent"):
        slider.InvokeEvent(event)


def test_the_sliders_show_fields_positions_and_parts(window, scene):
    """Below the words, so that it is not they alone that change."""
    fields, parts, places = window.plotter.widgets.slider_widgets
    first = pixels(window)
    seen = [first]

    def changes():
        seen.append(pixels(window))
        assert (np.abs(seen[-1] - seen[-2]).max(axis=2)[150:650] > 30).mean() > 0.004

    move(fields, 5)
    assert window.field == "displacement"
    changes()
    move(fields, 0)
    assert np.abs(pixels(window) - first).max() == 0
    move(places, 0)
    assert window.place == 0
    changes()
    move(parts, 2)
    assert (window.part, window.place) == ("pin_B", scene.worst["pin_B"])
    changes()


def test_colours_and_their_bar_stand_only_where_stress_is_known(window):
    def coloured(image):
        return (np.ptp(image, axis=2) > 60).mean()

    known = pixels(window)
    window.show(part="pin_B")
    bare = pixels(window)
    assert coloured(known[150:650, :1150]) > 0.03
    assert coloured(bare[150:650, :1150]) < 0.2 * coloured(known[150:650, :1150])
    assert coloured(known[200:600, 1170:]) > 0.05
    assert coloured(bare[200:600, 1170:]) == 0


def test_a_picture_is_written_in_place_of_a_window(scene, tmp_path):
    file = tmp_path / "out" / "window.png"
    write_picture(scene, file, "bar_lower")
    with Image.open(file) as image:
        assert image.size == SIZE


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("import os; os._exit(139)", "exit code 139, signal SIGSEGV"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "signal SIGSEGV"),
        ("raise ImportError('libGL.so.1: cannot open')", "it said: ImportError: libGL.so.1"),
        ("import time; time.sleep(60)", "took longer than 2 s and was stopped"),
    ],
)
def test_a_trial_that_dies_or_hangs_is_trouble_with_its_cure(monkeypatch, code, words):
    monkeypatch.setenv("DISPLAY", ":1")
    trouble = try_window(worker=worker(code), timeout=2.0)
    assert words in trouble.words
    assert "apt-get install libgl1 libegl1" in trouble.words
    assert not trouble.display


def test_a_picture_can_be_drawn_here():
    assert try_window(off_screen=True) is None


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere DISPLAY says nothing")
def test_without_a_display_nothing_is_started(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    trouble = try_window(worker=["/no/such"])
    assert trouble.display
    assert "DISPLAY is not set" in trouble.words
    assert "--off-screen FILE.png" in trouble.words


def test_a_display_that_does_not_answer_is_told(monkeypatch):
    monkeypatch.setenv("DISPLAY", ":1")
    trouble = try_window(worker=worker(f"raise SystemExit({NO_WINDOW})"))
    assert trouble.display
    assert "DISPLAY is :1" in trouble.words


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
def test_a_window_opens_on_a_display(display, monkeypatch):
    monkeypatch.setenv("DISPLAY", display)
    assert try_window() is None
