"""Derivatives on tapes against SymPy's, in 40 digits."""

from __future__ import annotations

import mpmath
import pytest
import sympy

from freebody.errors import ExpressionError
from freebody.scalar.algebra import FUNCTIONS
from freebody.scalar.derivative import forward, jacobian, reverse, transposed
from freebody.scalar.trace import Tape, Traced

X, Y, Z = sympy.symbols("x y z", real=True)
SYMBOLS = {"x": X, "y": Y, "z": Z}
POINT = {"x": 0.31, "y": 0.74, "z": -1.3}


def setup():
    tape = Tape()
    return tape, tape.input("x"), tape.input("y"), tape.input("z")


def value(tape, x):
    return tape.evaluate([x], POINT)[0]


def exact(expression, *variables):
    """Derivative of a SymPy expression at the point, with 40 digits."""
    derivative = sympy.diff(expression, *variables)
    with mpmath.workdps(40):
        function = sympy.lambdify((X, Y, Z), derivative, "mpmath")
        return float(function(*(mpmath.mpf(v) for v in POINT.values())))


BINARY = ("atan2", "pow", "min", "max")


@pytest.mark.parametrize("function", FUNCTIONS)
def test_every_function(function):
    tape, x, y, z = setup()
    arguments = (x * y + x / 4, y - x / 5) if function in BINARY else (x * y + x / 4,)
    f = tape.apply(function, *arguments) * y
    expression = tape.to_sympy(f, SYMBOLS)
    if function == "sign":  # SymPy leaves a Dirac delta
        expected = [0.0, value(tape, f) / POINT["y"], 0.0]
    else:
        expected = [exact(expression, s) for s in (X, Y, Z)]
    gradient = reverse(tape, f, [x, y, z])
    assert [value(tape, g) for g in gradient] == pytest.approx(expected, rel=1e-13)
    for variable, e in zip((x, y, z), expected, strict=True):
        (d,) = forward(tape, [f], [variable], [1])
        assert value(tape, d) == pytest.approx(e, rel=1e-13)


def program(tape, x, y, z):
    a = tape.sin(x * y) / (2 + tape.cos(z)) - z**3
    b = tape.apply("exp", a / 3) * x - 1 / (x + y)
    c = tape.sqrt(a * a + b * b) + a * b * 5 - x
    return [a, b, c, -a, x, 7]


def test_jacobian_of_a_program():
    tape, x, y, z = setup()
    outputs = program(tape, x, y, z)
    J = jacobian(tape, outputs, [x, y, z])
    for row, f in zip(J, outputs, strict=True):
        expression = tape.to_sympy(f, SYMBOLS)
        for entry, s in zip(row, (X, Y, Z), strict=True):
            assert value(tape, entry) == pytest.approx(exact(expression, s), rel=1e-13, abs=1e-15)
    by_reverse = [reverse(tape, f, [x, y, z]) for f in outputs]
    assert [value(tape, e) for row in by_reverse for e in row] == pytest.approx(
        [value(tape, e) for row in J for e in row], rel=1e-13
    )


def test_forward_along_a_direction_and_reverse_with_weights_are_adjoint():
    tape, x, y, z = setup()
    outputs = program(tape, x, y, z)
    direction, weights = (0.3, -1.2, 0.7), (0.2, 1, -0.4, 3, 0.5, 9)
    tangents = forward(tape, outputs, [x, y, z], direction)
    gradient = transposed(tape, outputs, weights, [x, y, z])
    left = sum(w * value(tape, t) for w, t in zip(weights, tangents, strict=True))
    right = sum(d * value(tape, g) for d, g in zip(direction, gradient, strict=True))
    assert left == pytest.approx(right, rel=1e-14)


def test_second_derivatives():
    tape, x, y, z = setup()
    f = program(tape, x, y, z)[2]
    expression = tape.to_sympy(f, SYMBOLS)
    for i, g in enumerate(reverse(tape, f, [x, y, z])):
        for j, h in enumerate(forward(tape, [g], [v], [1])[0] for v in (x, y, z)):
            assert value(tape, h) == pytest.approx(exact(expression, (X, Y, Z)[i], (X, Y, Z)[j]), rel=1e-12)


def test_seeds_may_be_traced():
    """The total derivative: d/dt f(x(t)) = ∂f/∂x x'."""
    tape, x, y, z = setup()
    (rate,) = forward(tape, [x * tape.sin(y)], [x, y], [y, z])
    assert tape.to_sympy(rate, SYMBOLS) - (Y * sympy.sin(Y) + X * sympy.cos(Y) * Z) == 0


def test_constants_cost_nothing():
    tape, x, y, z = setup()
    f = tape.sin(x) * tape.apply("exp", x)
    length = len(tape)
    assert reverse(tape, f, [y, z]) == [0, 0]
    assert forward(tape, [f, 3], [y], [1]) == [0, 0]
    assert reverse(tape, 5, [x]) == [0]
    assert reverse(tape, x, [x]) == [1]
    assert len(tape) == length


def test_exponent_that_is_a_number_needs_no_logarithm():
    tape, x, _, _ = setup()
    (d,) = reverse(tape, x**2.7, [x])
    assert tape.to_sympy(d, SYMBOLS).has(sympy.log) is False
    assert value(tape, d) == pytest.approx(2.7 * 0.31**1.7, rel=1e-14)


def test_an_intermediate_result_may_be_a_variable():
    tape, x, y, _ = setup()
    u = x * y
    f = u * u + x
    assert tape.to_sympy(reverse(tape, f, [u])[0], SYMBOLS) == 2 * X * Y
    assert reverse(tape, f, [u, x])[1] == 1
    assert forward(tape, [f], [x, u], [1, 0]) == [1]


def test_gradient_costs_a_few_operations_each():
    """Griewank and Walther (2008), eq (4.21): at most about four times the operations of the function."""
    tape = Tape()
    xs = [tape.input(f"x{i}") for i in range(200)]
    f = 1
    for i, x in enumerate(xs):
        f = f * tape.sin(x + i) + x / 3
    size = len(tape)
    gradient = reverse(tape, f, xs)
    assert all(isinstance(g, Traced) for g in gradient)
    assert len(tape) - size < 5 * size


def test_errors():
    tape, x, y, _ = setup()
    other = Tape().input("x")
    with pytest.raises(ExpressionError, match="Expected variables that are scalars of the tape"):
        reverse(tape, x, [other])
    with pytest.raises(ExpressionError, match="Expected variables that are scalars of the tape, got 3"):
        forward(tape, [x], [3], [1])
    with pytest.raises(ExpressionError, match="Expected outputs of the tape"):
        reverse(tape, other, [x])
    with pytest.raises(ExpressionError, match="Expected one seed for each of the 2 variables, got 1"):
        forward(tape, [x], [x, y], [1])
    with pytest.raises(ExpressionError, match="Expected one weight for each of the 1 outputs, got 2"):
        transposed(tape, [x], [1, 2], [x])


def test_products_with_a_length_have_a_derivative_where_it_is_zero():
    """d(|v| v_x) = |v| dv_x + v_x (v·dv)/|v|, which is 0 at rest; a root that is no length stays infinite there."""
    tape, x, y, _ = setup()
    length = tape.sqrt(x * x + y * y)
    (by_x, by_y), (root,) = jacobian(tape, [length * x], [x, y])[0], jacobian(tape, [tape.sqrt(x)], [x])[0]
    assert tape.evaluate([by_x, by_y], {"x": 0.0, "y": 0.0}) == [0, 0]
    assert tape.evaluate([by_x, by_y], {"x": 3.0, "y": 4.0}) == pytest.approx([5 + 9 / 5, 12 / 5], rel=1e-15)
    with pytest.raises(ZeroDivisionError):
        tape.evaluate([root], {"x": 0.0, "y": 0.0})
