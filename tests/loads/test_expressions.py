"""Forces by a formula: against closed forms, beside the laws that say the same, and refused."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import loads
from loads import Apply, Number, Reading

CRANK, ROD = 60.0, 200.0  # mm
LENGTH = loads.Distance("ground", "O", "slider", "B", "gas")
F0, L0, N = 400.0, 260.0, 1.2


def op(name, *terms):
    return Apply(name, tuple(Number(t) if isinstance(t, float) else t for t in terms))


GAS = loads.Expression(
    "-F * (L / gas.length)**n",
    op("*", -F0, op("**", op("/", L0, Reading(LENGTH)), N)),
)


def slider_crank(law, turns=1.0, pace=None):
    """An in-line slider-crank with a force between its pivot and its slider, crank stretched."""
    linkage = loads.Linkage(
        (
            loads.Body("ground", {"O": (0.0, 0.0)}),
            loads.Body("crank", {"O": (0.0, 0.0), "A": (CRANK, 0.0)}, 1e-3, 2.0, (30.0, 0.0)),
            loads.Body("rod", {"A": (0.0, 0.0), "B": (ROD, 0.0)}),
            loads.Body("slider", {"B": (0.0, 0.0)}, 2e-3),
        ),
        (
            loads.Revolute("O", "ground", "crank", "O"),
            loads.Revolute("A", "crank", "rod", "A"),
            loads.Revolute("B", "rod", "slider", "B"),
            loads.Prismatic("guide", "ground", "slider", "O", "B", (1.0, 0.0)),
        ),
        (loads.Force("drive", loads.Angle("crank")), loads.Force("gas", LENGTH, -1)),
        {"crank": (0.0, 0.0, 0.0), "rod": (CRANK, 0.0, 0.0), "slider": (CRANK + ROD, 0.0, 0.0)},
        gravity=(0.0, 0.0),
    )
    angle = loads.Angle("crank")
    phase = loads.Phase("turn", 2 * np.pi * turns, {"gas": law}, "drive")
    pace = pace or loads.SteadyPace(angle, 5.0)
    return loads.run_cycle(linkage, loads.Cycle("cycle", angle, 0.0, pace, (phase,), 721))


def length(angle):
    return CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)


def test_a_gas_spring_has_its_polytropic_force_and_stores_its_work():
    """From stretched to folded it takes F0 L0 / (n - 1) ((L0 / L)^(n - 1) - 1), by integration."""
    run = slider_crank(GAS, turns=0.5)
    assert_allclose(run.efforts["gas"], -F0 * (L0 / length(run.positions)) ** N, rtol=1e-9)
    stored = F0 * L0 / (N - 1) * ((L0 / (ROD - CRANK)) ** (N - 1) - 1)
    assert run.drive("gas").work == pytest.approx(-stored, rel=1e-4)
    assert run.power_balance_error < 1e-9
    assert abs(slider_crank(GAS).drive("gas").work) < 1e-6 * stored


@pytest.mark.parametrize(
    "name", ["sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan"]
)
def test_every_function_of_one_term_is_that_of_the_mathematics_library(name):
    """Of the length over 400 mm, 0.35 to 0.65; inverse functions by their own inverse."""
    run = slider_crank(loads.Expression(name, op(name, op("/", Reading(LENGTH), 400.0))))
    wanted = [getattr(math, name)(value / 400.0) for value in length(run.positions)]
    assert_allclose(run.efforts["gas"], wanted, rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "wanted"),
    [("+", lambda x: x + 200), ("-", lambda x: x - 200), ("*", lambda x: 200 * x),
     ("/", lambda x: x / 200), ("**", lambda x: x**1.5), ("abs", lambda x: abs(x - 200)),
     ("min", lambda x: min(x, 200)), ("max", lambda x: max(x, 200))],
)  # fmt: skip
def test_operators_and_choices_are_those_of_arithmetic(name, wanted):
    terms = {"**": (1.5,), "abs": ()}.get(name, (200.0,))
    first = op("-", Reading(LENGTH), 200.0) if name == "abs" else Reading(LENGTH)
    run = slider_crank(loads.Expression(name, op(name, first, *terms)))
    assert_allclose(
        run.efforts["gas"], [wanted(x) for x in length(run.positions)], rtol=1e-9, atol=1e-6
    )


def test_a_rate_in_a_formula_is_the_damper_that_a_force_against_the_motion_is():
    """c q', which pulls as the length grows, beside { viscous = c }; nothing jumps at reversals."""
    damper = loads.Expression("c * rate", op("*", 0.2, Reading(LENGTH, rate=True)))
    by_formula, by_law = slider_crank(damper), slider_crank(loads.Opposing(viscous=0.2))
    at = np.linspace(0.1, 6.1, 40)
    for name in ("gas", "drive"):
        one, other = (
            np.interp(at, run.positions, run.efforts[name]) for run in (by_formula, by_law)
        )
        assert_allclose(one, other, atol=2e-4 * np.abs(other).max())
    assert by_formula.drive("gas").work < 0.0


def test_a_motor_turns_a_damper_by_formula_as_it_turns_one_by_law():
    angle = loads.Angle("crank")
    motor = loads.Geared(loads.Motor(3000.0, 150.0, 157.0, 2.5), 20.0, 1.0, 1.0)
    pace = loads.MotorPace(loads.SteadyPace(angle, 7.5), motor, 100.0)
    damper = loads.Expression("c * rate", op("*", 0.2, Reading(LENGTH, rate=True)))
    speeds = []
    for law in (damper, loads.Opposing(viscous=0.2)):
        run = slider_crank(law, pace=pace)
        speeds.append(2 * np.pi / run.times[-1])
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-7)
    assert speeds[0] != pytest.approx(7.85, rel=1e-3)


@pytest.mark.parametrize("switch", ["max", "min", "abs"])
def test_a_position_stands_where_a_formula_has_a_kink(switch):
    """A stop below 170 mm: the force begins at the angle that the triangle has there."""
    way = op("-", 170.0, Reading(LENGTH))
    term = {
        "max": op("max", 0.0, way),
        "min": op("*", -1.0, op("min", 0.0, op("*", -1.0, way))),
        "abs": op("*", 0.5, op("+", way, op("abs", way))),
    }[switch]
    run = slider_crank(loads.Expression("stop", op("*", -100.0, term)))
    by_hand = -100.0 * np.maximum(0.0, 170.0 - length(run.positions))
    assert_allclose(run.efforts["gas"], by_hand, atol=1e-6)
    begins = np.arccos((CRANK**2 + 170.0**2 - ROD**2) / (2 * CRANK * 170.0))
    assert np.abs(run.positions - begins).min() < 1e-9
    assert np.abs(run.positions - (2 * np.pi - begins)).min() < 1e-9


@pytest.mark.parametrize(
    "shape", ["exp", "lorentz", "parabola", "arcs", "logistic", "atan", "acos"]
)
def test_a_position_stands_at_a_peak_narrower_than_a_step(shape):
    """1 kN within 1e-4 or 0.01 mm of the length of 170 mm, where a step is 0.3 mm wide."""
    square = op("**", op("/", op("-", Reading(LENGTH), 170.0), 1e-4), 2.0)
    up, down = (op("/", op("-", Reading(LENGTH), at), 1e-6) for at in (170.0, 170.01))
    below = [op("+", 1.0, op("exp", op("*", sign, one))) for sign, one in ((-1.0, up), (1.0, down))]
    peak = {
        "arcs": op("/", op("-", op("atan", up), op("atan", down)), np.pi),
        "logistic": op("/", op("/", 1.0, below[0]), below[1]),
        "exp": op("exp", op("*", -1.0, square)),
        "lorentz": op("/", 1.0, op("+", 1.0, square)),
        "parabola": op("max", 0.0, op("-", 1.0, square)),
        "atan": op("-", 1.0, op("/", op("atan", square), np.pi / 2)),
        "acos": op("/", op("acos", op("min", 1.0, op("sqrt", op("*", 1e-4, square)))), np.pi / 2),
    }[shape]
    run = slider_crank(loads.Expression("peak", op("*", -1000.0, peak)))
    assert run.efforts["gas"].min() == pytest.approx(-1000.0, rel=1e-3)
    assert run.efforts["gas"].max() > -1.0


@pytest.mark.parametrize(
    "below",
    [
        op("/", 1e3, op("-", Reading(LENGTH), 250.001)),
        op("**", op("-", Reading(LENGTH), 250.001), -3.0),
        op("tan", op("/", Reading(LENGTH), 160.0)),
    ],
    ids=["division", "negative power", "tangent"],
)
def test_a_pole_between_two_positions_is_refused(below):
    """A grid does not see it, as the values on both sides are finite."""
    with pytest.raises(loads.LinkageError, match=r"force 'gas': pole divides by nothing"):
        slider_crank(loads.Expression("pole", below))


def test_a_formula_without_a_number_is_refused_with_the_place():
    root = op("sqrt", op("-", Reading(LENGTH), 200.0))
    with pytest.raises(loads.LinkageError, match=r"root is no finite number at crank\.angle = "):
        slider_crank(loads.Expression("root", root))
    with pytest.raises(loads.LinkageError, match=r"force 'gas': far: .*sledge"):
        slider_crank(loads.Expression("far", Reading(loads.PointCoordinate("sledge", "B", (1, 0)))))
