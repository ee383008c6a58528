"""Cylinders: buckling and bending of a column of two lengths, and their checks in a design."""

import json
from dataclasses import replace
from functools import cache
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq

from ballesta import check
from ballesta.cli import main
from ballesta.design.read import read_design
from checks.columns.cylinders import KINDS, not_checked_of
from checks.columns.cylinders import cylinder_checks as cylinder_checks_of
from checks.handbook.column_curves import buckling_force, largest_moments

EI = (2.1e5 * pi / 64 * (72**4 - 60**4), 2.1e5 * pi / 64 * 30**4)
LENGTHS = (850.0, 450.0)


def one(values):
    return np.array([float(values)])


@pytest.mark.parametrize("stiffer", [1.0 + 1e-9, 1.5, 17.0, 300.0])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.97])
def test_two_lengths_buckle_at_the_root_of_their_equation(stiffer, share):
    lengths, stiffness = (1000 * share, 1000 * (1 - share)), (stiffer * 8e9, 8e9)

    def equation(force):
        k1, k2 = np.sqrt(force / stiffness[0]), np.sqrt(force / stiffness[1])
        a, b = k1 * lengths[0], k2 * lengths[1]
        return k2 * np.sin(a) * np.cos(b) + k1 * np.cos(a) * np.sin(b)

    forces = np.geomspace(0.999 / stiffer, 1.001, 4000) * pi**2 * stiffness[0] / 1e6
    signs = np.sign([equation(force) for force in forces])
    first = int(np.flatnonzero(signs[1:] != signs[:-1])[0])
    found = buckling_force((one(lengths[0]), one(lengths[1])), stiffness)
    root = brentq(equation, forces[first], forces[first + 1], xtol=1e-9)
    assert_allclose(found, root, rtol=1e-9)


def test_an_even_column_buckles_at_eulers_force():
    found = buckling_force((np.array([300.0, 500.0]), np.array([900.0, 700.0])), (EI[1], EI[1]))
    assert_allclose(found, pi**2 * EI[1] / 1200**2, rtol=1e-12)


def test_a_column_of_beam_elements_buckles_alike():
    """Cubic elements, 20 on each length: K w = F K_G w with hinged ends."""
    n, size = 41, np.repeat(LENGTHS, 20) / 20
    stiff, turned = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n))
    for k, h in enumerate(size):
        own = slice(2 * k, 2 * k + 4)
        stiff[own, own] += EI[k // 20] / h**3 * np.array(
            [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
             [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]])  # fmt: skip
        turned[own, own] += 1 / (30 * h) * np.array(
            [[36, 3 * h, -36, 3 * h], [3 * h, 4 * h * h, -3 * h, -h * h],
             [-36, -3 * h, 36, -3 * h], [3 * h, -h * h, -3 * h, 4 * h * h]])  # fmt: skip
    free = np.delete(np.arange(2 * n), [0, 2 * n - 2])
    lowest = eigh(stiff[np.ix_(free, free)], turned[np.ix_(free, free)], eigvals_only=True)[0]
    found = buckling_force((one(LENGTHS[0]), one(LENGTHS[1])), EI)[0]
    assert_allclose(found, lowest, rtol=1e-6)


@pytest.mark.parametrize("load", [0.02, 0.6, 0.97])
@pytest.mark.parametrize(
    ("tube", "rod", "kink"),
    [(0.4, 0.06, 0.002), (0.0, 0.0, 0.003), (0.4, 0.06, 0.0), (0.01, 0.5, 0.001)],
)
def test_moments_are_those_of_the_second_order_equation(load, tube, rod, kink):
    """M over the axis integrated from both eyes, with what makes both meet."""
    lengths = (one(LENGTHS[0]), one(LENGTHS[1]))
    force = load * buckling_force(lengths, EI)
    found = largest_moments(force, lengths, EI, (one(tube), one(rod)), one(kink))
    (l1, l2), n = LENGTHS, float(force[0])

    def integrated(stiffness, weight, length, first, points=4001):
        """M and its slope from an eye on, where its slope is `first`."""
        run = solve_ivp(
            lambda _, y: [y[1], -weight - n / stiffness * y[0]], (0.0, length), [0.0, first],
            "DOP853", rtol=1e-12, atol=1e-6, t_eval=np.linspace(0.0, length, points),
        )  # fmt: skip
        return run.y

    own = [integrated(*one, 0.0) for one in ((EI[0], tube, l1), (EI[1], rod, l2))]
    unit = [integrated(*one, 1e3) for one in ((EI[0], 0.0, l1), (EI[1], 0.0, l2))]
    matrix = [[unit[0][0, -1], -unit[1][0, -1]], [unit[0][1, -1], unit[1][1, -1]]]
    right = [own[1][0, -1] - own[0][0, -1], n * kink - own[0][1, -1] - own[1][1, -1]]
    shares = np.linalg.solve(matrix, right)
    largest = [(a + c * b)[0].max() for a, b, c in zip(own, unit, shares, strict=True)]
    assert_allclose([found[0][0], found[1][0]], largest, rtol=1e-6)


def test_without_a_push_weight_alone_bends():
    lengths = (one(LENGTHS[0]), one(LENGTHS[1]))
    for force in (0.0, -5e4):
        both = largest_moments(one(force), lengths, EI, (one(0.3), one(0.3)), one(0.01))
        assert_allclose(max(float(m[0]) for m in both), 0.3 * 1300**2 / 8, rtol=2e-3)


JIB = """
name = "Jib of a workshop crane"
ground = ["O", "D"]
[points]
O = "0, 1500 mm"
D = "0, 600 mm"
E = "600, 1500 mm"
F = "1500, 1500 mm"
[bodies.jib]
pins = ["O", "E", "F"]
mass = "60 kg"
centre = "750, 0 mm"
[forces.lift]
between = ["D", "E"]
[forces.load]
body = "jib"
at = "F"
direction = "0, -1"
[cycles.hoist]
coordinate = "jib.angle"
start = "0 deg"
pace = { coordinate = "lift.length", speed = "1 mm/s" }
positions = 7
phases = [{ name = "up", to = "30 deg", forces = { load = "5 kN" }, solve = "lift" }]
[cylinders.lift]
force = "lift"
rod = "30 mm"
bore = "60 mm"
wall = "6 mm"
closed = "950 mm"
stroke = "500 mm"
tube = "850 mm"
material = "C45"
tube_material = "S355"
guide = "60 mm"
play = "0.1 mm"
[parts.jib]
body = "jib"
shape = { lever = ["O", "E", "F"] }
interfaces = { O = "O", E = "E", F = "F" }
material = "S355"
thickness = "40 mm"
surface = "hot_rolled"
[parts.jib.holes]
O = { diameter = "40 mm", eye = "120 mm" }
E = { diameter = "40 mm", eye = "160 mm" }
F = { diameter = "40 mm", eye = "100 mm" }
"""


@pytest.fixture
def jib(tmp_path):
    path = tmp_path / "jib.toml"
    path.write_text(JIB)
    return path


@cache
def checked(text, overrides):
    with TemporaryDirectory() as folder:
        path = Path(folder) / "jib.toml"
        path.write_text(text)
        return check(path, fidelity="formula", overrides=overrides)


def cylinder_checks(path, overrides=()):
    result = checked(path.read_text(), tuple(overrides))
    names = [kind.quantity.format("lift") for kind in KINDS]
    found = {one.quantity: one for one in result.linkage}
    return [found[name] for name in names if name in found], result


def test_force_share_and_stress_of_a_jib_are_those_by_hand(jib):
    """At 30 deg the cylinder is longest, 1308 mm; its force by moments about O."""
    (buckling, rod, tube), _ = cylinder_checks(jib)
    angle = np.radians(30.0)
    e = np.array([600 * np.cos(angle), 1500 + 600 * np.sin(angle)])
    reach = e - [0.0, 600.0]
    length = float(np.hypot(*reach))
    arm = abs((e[0]) * reach[1] - (e[1] - 1500) * reach[0]) / length
    by_moments = (5000 * 1500 + 60 * 9.81 * 750) * np.cos(angle) / arm
    n = buckling.derivation.number("N")
    assert_allclose(n, by_moments, rtol=1e-5)  # the rate of the angle is small, not nothing
    assert_allclose(buckling.derivation.number("L"), length, rtol=1e-9)
    force = buckling_force((one(850), one(length - 850)), EI)[0]
    assert_allclose(buckling.value, n / force, rtol=1e-9)
    assert buckling.position == "jib.angle = 30 deg up"
    density = 7.85e-9
    masses = density * pi / 4 * np.array([72**2 - 60**2 + 30**2, 30**2])
    across = 9810 * abs(reach[0]) / length
    kink = 0.1 / (60 + 1450 - length)

    def moments(factor):
        weights = tuple(one(factor * m * across) for m in masses)
        lengths = one(850), one(length - 850)
        return largest_moments(one(factor * n), lengths, EI, weights, one(kink))

    def stress(factor):
        """Of the rod, MPa: bending grows faster than the loads."""
        return factor * n / (pi / 4 * 900) + moments(factor)[1][0] / (pi / 32 * 27_000)

    by_hand = brentq(lambda factor: stress(factor) - 305, 1, 0.999 * force / n)
    assert_allclose(rod.safety, by_hand, rtol=2e-3)  # density of the table
    assert by_hand < 0.61 * 305 / stress(1)
    p, modulus = n / (pi / 4 * 3600), pi / 32 * (72**4 - 60**4) / 72
    hoop = p * (72**2 + 60**2) / (72**2 - 60**2)

    def of_tube(factor):
        return factor * hoop + max(factor * p, moments(factor)[0][0] / modulus)

    by_hand = brentq(lambda factor: of_tube(factor) - 355, 1, (1 - 1e-9) * force / n)
    assert_allclose(tube.safety, by_hand, rtol=1e-4)
    assert by_hand < 0.82 * 355 / of_tube(1)
    assert_allclose(tube.below, (1 - np.sqrt(3) / 2) * tube.value, rtol=1e-9)
    assert (rod.limit, tube.limit) == (305.0, 355.0)


def test_a_load_factor_is_on_the_cylinder_s_own_weight_too(jib):
    """As twice the force and twice the weight of all, the cylinder's own included."""
    factor = cylinder_checks(jib, overrides=["load_factor=2"])[0]
    twice = ["gravity=0, -19.62 m/s2", "cycles.hoist.phases[0].forces.load=10 kN"]
    stated = cylinder_checks(jib, overrides=twice)[0]
    assert_allclose([one.value for one in factor], [one.value for one in stated], rtol=1e-6)


@pytest.mark.parametrize(("which", "yields"), [(1, 305.0), (2, 355.0)])
def test_loads_times_the_safety_make_rod_and_tube_yield(jib, which, yields):
    safety = (1 - 1e-7) * cylinder_checks(jib)[0][which].safety  # the tube's is the column's
    more = cylinder_checks(jib, overrides=[f"load_factor={safety!r}"])[0][which]
    assert_allclose(more.value, yields, rtol=1e-6)


def test_the_tube_holds_the_pressure_that_the_drive_has(jib):
    """25 MPa, more than the force takes: Lame's hoop stress and the pressure itself."""
    stated = 'forces.lift.available={bore="60 mm",rod="30 mm",pressure="25 MPa"}'
    tube = cylinder_checks(jib, overrides=[stated])[0][2]
    assert_allclose(tube.value, 25 * ((72**2 + 60**2) / (72**2 - 60**2) + 1), rtol=1e-9)
    assert tube.value > 2.9 * cylinder_checks(jib)[0][2].value


def test_a_slender_rod_fails_and_has_no_stress(jib):
    checks, result = cylinder_checks(jib, overrides=["cylinders.lift.rod=12 mm"])
    assert [one.kind for one in checks] == ["buckling"]
    assert checks[0].value > 1.0
    assert result.status.name == "FAIL"


@pytest.mark.slow
def test_a_thicker_rod_is_told_that_makes_the_design_pass(jib, capsys):
    """The next sizes of R20 up to the first that passes: 20 and 22.4 mm do not, 25 mm does."""
    thin = ["--set", "cylinders.lift.rod=20 mm"]
    out = str(jib.parent / "out")
    main(["check", str(jib), "--fidelity", "formula", "--json", *thin, "--out", out])
    result = json.loads(capsys.readouterr().out)[0]
    told = {change["key"]: change for change in result["changes"]}
    assert told.keys() >= {"cylinders.lift.rod"}
    size = told["cylinders.lift.rod"]["value"]
    passes = {}
    for rod in ("20 mm", "22.4 mm", "25 mm"):
        checks, _ = cylinder_checks(jib, overrides=[f"cylinders.lift.rod={rod}"])
        passes[rod] = all(one.status.name == "PASS" for one in checks)
    assert size == next(rod for rod, right in passes.items() if right)
    assert not passes["20 mm"]


def test_what_is_left_out_is_told(jib):
    _, result = cylinder_checks(jib)
    assert any("seals of lift" in words for words in result.not_checked)
    assert not any("play of the guides" in words for words in result.not_checked)
    jib.write_text(JIB.replace('guide = "60 mm"\nplay = "0.1 mm"\n', ""))
    (_, straight, _), result = cylinder_checks(jib)
    assert any("play of the guides of lift" in words for words in result.not_checked)
    jib.write_text(JIB)
    assert straight.value < cylinder_checks(jib)[0][1].value


@pytest.mark.parametrize(("change", "said"), [
    ("cylinders.lift.force=lifts", 'cylinders.lift.force: no force between two points is named'),
    ("cylinders.lift.force=load", "cylinders.lift.force: no force between two points is named"),
    ("cylinders.lift.material=C46", "cylinders.lift.material: "),
    ("cylinders.lift.rod=60 mm", "cylinders.lift.rod: must be thinner than the bore of 60 mm"),
    ("cylinders.lift.tube=950 mm", "cylinders.lift.tube: must be shorter than closed, 950 mm"),
    ("cylinders.lift.stroke=850 mm", "cylinders.lift.stroke: must be shorter than the tube"),
    ("cylinders.lift.stroke=300 mm", "cylinders.lift.stroke: its eyes come from 1082 to 1308 mm"),
    ("cylinders.lift.closed=1100 mm", "cylinders.lift.closed: its eyes come from 1082 to 1308"),
    ("cylinders.lift.guide=400 mm", "cylinders.lift.guide: with the stroke must find room"),
    ('forces.lift.available={bore="63 mm",pressure="20 MPa"}',
     "cylinders.lift.bore: is 60 mm, but forces.lift.available.bore is 63 mm"),
])  # fmt: skip
def test_wrong_input_is_refused_with_its_key(jib, change, said, capsys):
    assert main(["check", str(jib), "--fidelity", "formula", "--set", change,
                 "--out", str(jib.parent / "out")]) == 2  # fmt: skip
    assert said in " ".join(capsys.readouterr().err.split())


def test_json_why_and_sweep_know_cylinders(jib, capsys):
    out = str(jib.parent / "out")
    assert main(["check", str(jib), "--fidelity", "formula", "--json", "--out", out]) == 1
    linkage = json.loads(capsys.readouterr().out)[0]["linkage"]
    assert {one["quantity"] for one in linkage} >= {k.quantity.format("lift") for k in KINDS}
    main(["why", f"{out}/jib", "linkage", "static", "--all"])
    said = " ".join(capsys.readouterr().out.split())  # lines break where the terminal ends
    assert "n·σ_h + max(n·p, M/W)" in said


def test_order_of_keys_and_units_change_nothing(jib):
    before = [one.value for one in cylinder_checks(jib)[0]]
    head, table = JIB.split("[cylinders.lift]\n")
    lines, rest = table.split("[parts.jib]\n")
    turned = "\n".join(reversed(lines.strip().splitlines())).replace('"950 mm"', '"0.95 m"')
    jib.write_text(f"{head}[cylinders.lift]\n{turned}\n[parts.jib]\n{rest}")
    assert read_design(jib).cylinders["lift"].closed == 950.0
    assert [one.value for one in cylinder_checks(jib)[0]] == before


def test_measured_runs_say_nothing_of_cylinders(jib):
    design = read_design(jib)
    assert cylinder_checks_of(design, {}) == []
    assert not any("measured" in words for words in not_checked_of(design))
    measured = replace(design, measured={"run": None})
    assert "buckling and stress of lift in run: measured" in " ".join(not_checked_of(measured))
