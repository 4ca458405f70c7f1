"""Dual numbers: derivatives that agree with those of the trace, on every field."""

import math

import numpy as np
import pytest
import sympy

from freebody.dynamics import inverse_dynamics, traced_state
from freebody.dynamics.state import State
from freebody.model import assemble
from freebody.scalar.algebra import FUNCTIONS, floats
from freebody.scalar.arrays import arrays, column
from freebody.scalar.derivative import forward
from freebody.scalar.dual import Dual, DualField, NumericDual, slope_of, value_of
from freebody.scalar.polynomial import Ring
from freebody.scalar.series import SeriesField
from freebody.scalar.trace import Tape
from freebody.testing import random_system

TWO = {"atan2", "pow", "min", "max"}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_agree_with_the_trace(name):
    field = DualField(floats)
    x, y = 0.4, 0.7
    arguments = (x, y) if name in TWO else (x,)
    mine = field.apply(name, *(field.variable(v, k) for k, v in enumerate(arguments)))
    tape = Tape()
    inputs = [tape.input(f"x{k}") for k in range(len(arguments))]
    out = tape.apply(name, *inputs)
    for k in range(len(arguments)):
        (slope,) = forward(tape, [out], [inputs[k]], [1])
        (expected,) = tape.evaluate([slope], {f"x{i}": v for i, v in enumerate(arguments)})
        assert slope_of(mine, k) == pytest.approx(expected, rel=4e-16)
    assert value_of(mine) == pytest.approx(floats.apply(name, *arguments))


def test_arithmetic():
    field = DualField(floats)
    x, y = field.variable(2.0, 0), field.variable(3.0, 1)
    z = (x / y - 1 / x + 4 - y) * 2 - 3 * x**3 + x**-2
    assert z.value == pytest.approx((2 / 3 - 1 / 2 + 4 - 3) * 2 - 24 + 1 / 4)
    assert z.slopes[0] == pytest.approx((1 / 3 + 1 / 4) * 2 - 36 - 2 / 8)
    assert z.slopes[1] == pytest.approx((-2 / 9 - 1) * 2)
    assert type(x - x) is float and x * 0 == 0  # nothing varies any more: a plain number
    assert (x**0.5).slopes[0] == pytest.approx(0.5 / math.sqrt(2))


def test_polynomials_stay_canonical():
    ring = Ring()
    q = ring.generator(sympy.Function("q")(sympy.Symbol("t")))
    field = DualField(ring)
    x = field.variable(q, 0)
    unity = field.sin(x) * field.sin(x) + field.cos(x) * field.cos(x)
    assert unity == 1 and not isinstance(unity, Dual)


def test_series_of_duals():
    field = DualField(floats)
    series = SeriesField(field, 2)
    x = series.series([field.variable(0.3, 0), 1])
    y = field.variable(2.0, 1) * series.apply("sin", x) / x
    assert slope_of(y.c[0], 0) == pytest.approx(2 * (math.cos(0.3) / 0.3 - math.sin(0.3) / 0.09))
    assert slope_of(y.c[0], 1) == pytest.approx(math.sin(0.3) / 0.3)


@pytest.mark.parametrize("seed", range(4))
def test_machines_agree_with_the_trace(seed):
    """∂(M u' + h - Q)/∂u by duals, on arrays, equals the derivative of the recorded program."""
    model = assemble(random_system(seed, bodies=4))
    rng = np.random.default_rng(seed)
    tape = Tape()
    state = traced_state(model, tape)
    udot = [tape.input(f"a{j}") for j in range(model.n_u)]
    left = inverse_dynamics(model, state, udot)
    numbers = model.values()
    values = {p.symbol: numbers[p.name] for p in model.parameters}
    q, u, a = (rng.uniform(0.2, 1, size=(n, 2)) for n in (model.n_q, model.n_u, model.n_u))
    field = DualField(arrays)
    speeds = [field.variable(column(x), j) for j, x in enumerate(u)]
    mine = inverse_dynamics(
        model, State(model, field, column(np.zeros(2)), [*map(column, q)], speeds, values), [*map(column, a)]
    )
    for k in range(2):
        at = {"t": 0.0, **numbers, **{f"a{j}": x[k] for j, x in enumerate(a)}}
        at |= {c.name: x[k] for c, x in zip(model.coordinates, q, strict=True)}
        at |= {s.name: x[k] for s, x in zip(model.speeds, u, strict=True)}
        for j in range(model.n_u):
            recorded = tape.evaluate(forward(tape, left, [state.u[j]], [1]), at)
            own = [np.broadcast_to(slope_of(x, j), 2)[k] for x in mine]
            scale = max(1.0, float(np.max(np.abs(recorded))))
            assert np.max(np.abs(np.array(own, dtype=float) - recorded)) < 1e-13 * scale


@pytest.mark.parametrize("h", [0, 1e-4, 0.1, 0.7, 1.2, 1.57])
def test_an_angle_over_its_sine_has_a_slope_where_both_are_zero(h):
    field = DualField(floats)
    found = field.arc_over_sine(field.variable(math.cos(h), 0))
    mpmath = pytest.importorskip("mpmath")
    with mpmath.workdps(50):
        c = mpmath.mpf(math.cos(h))
        value = mpmath.acos(c) / mpmath.sqrt(1 - c * c) if h else mpmath.mpf(1)
        slope = (c * value - 1) / (1 - c * c) if h else -mpmath.mpf(1) / 3
    assert value_of(found) == pytest.approx(float(value), rel=4e-16)
    assert slope_of(found, 0) == pytest.approx(float(slope), rel=2e-15)


def test_an_angle_over_its_sine_is_a_closed_form_in_formulas():
    ring, c = Ring(), sympy.Symbol("c", positive=True)
    found = ring.to_sympy(ring.arc_over_sine(ring.from_sympy(c)))
    assert float(found.subs(c, 0.3)) == pytest.approx(math.acos(0.3) / math.sqrt(1 - 0.3**2), rel=1e-15)
    assert found.has(sympy.acos) and ring.arc_over_sine(1) == 1


def test_a_dual_number_for_functions_of_a_user():
    """NumPy and comparisons take it; what would lose its derivatives raises TypeError."""
    field = DualField(floats)
    x, y = (NumericDual(field.variable(value, i)) for i, value in enumerate((0.5, 2.0)))
    cases = [
        (np.float64(2) * x - 1, (0.0, 2, 0)),
        (np.sin(x) / y, (math.sin(0.5) / 2, math.cos(0.5) / 2, -math.sin(0.5) / 4)),
        (np.array([1.0, 3.0]) @ np.array([x, y]), (6.5, 1, 3)),
        (np.clip(x, -1, 1) + np.maximum(y, 0) + np.abs(-x), (3.0, 2, 1)),
        (x**y + 2**x, (0.25 + 2**0.5, 1.0 + math.log(2) * 2**0.5, math.log(0.5) / 4)),
        (np.arctan2(x, y), (math.atan2(0.5, 2), 2 / 4.25, -0.5 / 4.25)),
        ((1 - x) ** 2 + 1 / x + x**0.5, (2.25 + 0.5**0.5, -5 + 0.5 * 0.5**-0.5, 0)),
    ]
    for found, (value, by_x, by_y) in cases:
        assert value_of(found) == pytest.approx(value, rel=1e-15)
        assert (slope_of(found, 0), slope_of(found, 1)) == pytest.approx((by_x, by_y), rel=1e-14)
    assert x < y and y >= 1 and x != 0 and bool(x) and np.sign(-x) == -1
    assert f"{x:.2f} {x!r}" == "0.50 0.5 with derivatives"
    assert np.clip(3 * y, -1, 1) == 1
    for lost in (math.sin, float, round, np.floor, lambda x: np.linalg.solve(np.eye(1), [x])):
        with pytest.raises((TypeError, AttributeError)):
            lost(x)
    with pytest.raises(
        ArithmeticError, match="it compares 0.5 with the same number, and a derivative decides"
    ):
        assert x > 0.5
