"""Recorded programs: identities, folding, errors."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
import sympy

from freebody.errors import ExpressionError
from freebody.scalar.trace import ADD, CODES, DIV, MUL, NEG, SUB, Tape, Traced


@pytest.fixture
def tape():
    return Tape()


def symbols(*names):
    return [sympy.Symbol(name) for name in names]


def test_equal_operations_are_one_object(tape):
    x, y = tape.input("x"), tape.input("y")
    assert x * y is y * x
    assert x + y is y + x
    assert x - y is -(y - x)
    assert tape.sin(x) is tape.sin(tape.input("x"))
    assert x / y is x / y
    assert tape.apply("min", x, y) is tape.apply("min", y, x)
    assert tape.apply("atan2", x, y) is not tape.apply("atan2", y, x)


def test_zeros_and_ones_disappear(tape):
    x = tape.input("x")
    length = len(tape)
    assert [0 * x, x * 0, x - x, 0 / x, 0.0 * x] == [0] * 5
    assert all(r is x for r in (x + 0, 0 + x, x - 0, 1 * x, x * 1, x / 1, x**1, +x, -(-x), x * 1.0))  # noqa: B002
    assert x / x == 1
    assert x**0 == 1
    assert len(tape) == length + 1  # only -x
    assert type(0 * x) is int


def test_signs_move_outward(tape):
    x, y = tape.input("x"), tape.input("y")
    xy, q = x * y, x / y
    assert x + (-y) is x - y
    assert x - (-y) is x + y
    assert (-x) * (-y) is xy
    assert (-x) * y is -xy
    assert x * (-2) is -(x * 2)
    assert (-x) / y is -q
    assert x / (-y) is -q
    assert -x + y is y - x
    assert -x - y is -(x + y)
    assert tape.sin(-x) is -tape.sin(x)
    assert tape.cos(-x) is tape.cos(x)
    assert abs(-x) is abs(x)
    assert x + (-3) is x - 3
    assert 3 - x is -(x - 3)


def test_constants_join(tape):
    x = tape.input("x")
    assert (x * 2) * Fraction(1, 2) is x
    assert (x + 2) - 2 is x
    assert (x - 2) + 5 is x + 3
    assert x + x is 2 * x
    assert x / 4 is x * Fraction(1, 4)
    assert 1 / (x / tape.input("y")) is tape.input("y") / x
    assert x * 2 is x * 2.0


def test_powers(tape):
    x = tape.input("x")
    X = sympy.Symbol("x")
    assert x**2 is x * x
    assert tape.to_sympy(x**7) == X**7
    assert tape.to_sympy(x**-3) == X**-3
    assert tape.to_sympy(x ** Fraction(3, 2)) == X ** sympy.Rational(3, 2)
    assert tape.to_sympy(x ** Fraction(-1, 2)) == 1 / sympy.sqrt(X)
    assert tape.to_sympy(2**x) == 2**X
    assert tape.to_sympy(x ** tape.input("n")) == X ** sympy.Symbol("n")
    assert tape.op[(x ** Fraction(1, 3)).index] == CODES["pow"]


@pytest.mark.parametrize(
    ("function", "arguments", "value"),
    [
        ("sin", (0,), 0), ("cos", (0,), 1), ("sqrt", (4,), 2), ("sqrt", (Fraction(1, 9),), Fraction(1, 3)),
        ("exp", (0,), 1), ("log", (1,), 0), ("atan2", (0, 2), 0), ("abs", (-3,), 3), ("sign", (-3,), -1),
        ("min", (3, 2), 2), ("max", (3, 2), 3), ("pow", (2, -2), Fraction(1, 4)), ("acos", (1,), 0),
    ],
)  # fmt: skip
def test_functions_of_numbers_fold_exactly(tape, function, arguments, value):
    result = tape.apply(function, *arguments)
    assert result == value
    assert type(result) is type(value)
    assert len(tape) == 0


def test_functions_of_numbers_fold_in_double_precision(tape):
    assert tape.sin(1) == math.sin(1)
    assert tape.sqrt(2) == math.sqrt(2)
    assert tape.constant("pi") == math.pi
    assert tape.sqrt(0.25) == 0.5


def test_numpy_numbers(tape):
    x = tape.input("x")
    assert np.float64(2) * x is 2 * x
    assert x + np.int64(3) is x + 3
    assert np.float64(1) / x is 1 / x
    assert np.float64(4) - x is 4 - x


def test_to_sympy_uses_given_symbols(tape):
    x, y = tape.input("x"), tape.input("y")
    X, Y = sympy.symbols("X Y", positive=True)
    r = tape.apply("atan2", x, y) + math.pi * x - tape.apply("max", x, 3) / 7
    assert tape.to_sympy(r, {"x": X, "y": Y}) == sympy.atan2(X, Y) + sympy.pi * X - sympy.Max(X, 3) / 7
    assert tape.to_sympy(Fraction(2, 3)) == sympy.Rational(2, 3)


def test_evaluate_agrees_with_sympy(tape):
    x, y = tape.input("x"), tape.input("y")
    r = tape.sin(x * y) / (1 + x * x) - tape.apply("exp", -y) + abs(x - y) ** 3 + tape.apply("sign", x - y)
    expected = float(tape.to_sympy(r).subs({"x": 0.3, "y": 0.7}))
    values = tape.evaluate([r, 5, r], {"x": 0.3, "y": 0.7})
    assert values == pytest.approx([expected, 5, expected], rel=1e-14)


def test_used_leaves_out_dead_code(tape):
    x, y = tape.input("x"), tape.input("y")
    dead = tape.sin(y)
    live = x * x + 1
    used = tape.used([live, 3])
    assert dead.index not in used
    assert y.index not in used
    assert used == sorted(used)
    assert used[-1] == live.index
    assert tape.used([1, 2]) == []


def test_codes_are_consistent(tape):
    x, y = tape.input("x"), tape.input("y")
    results = {ADD: x + y, SUB: x - y, MUL: x * y, DIV: x / y, NEG: -x}
    for code, r in results.items():
        assert tape.op[r.index] == code
    assert isinstance(x + y, Traced)


@pytest.mark.parametrize("branch", [bool, float, lambda x: x < 0, lambda x: x >= 1, lambda x: 1 if x else 2])
def test_branch_on_a_value_is_refused(tape, branch):
    with pytest.raises(TypeError, match="no branch on the value of a recorded scalar"):
        branch(tape.input("x"))


def test_scalars_of_two_tapes_are_refused(tape):
    x, y = tape.input("x"), Tape().input("y")
    for operation in (lambda: x + y, lambda: x - y, lambda: x * y, lambda: x / y, lambda: tape.sin(y)):
        with pytest.raises(ExpressionError, match="Expected scalars of one tape"):
            operation()


def test_unknown_functions_and_arguments_are_refused(tape):
    x = tape.input("x")
    with pytest.raises(ExpressionError, match="function that can be compiled, got 'gamma'. Known: sin, cos"):
        tape.apply("gamma", x)
    with pytest.raises(ExpressionError, match=r"Expected 2 argument\(s\) of atan2, got 1"):
        tape.apply("atan2", x)
    with pytest.raises(ExpressionError, match=r"Expected arguments where sqrt is real, got sqrt\(-1\)"):
        tape.sqrt(-1)
    with pytest.raises(ExpressionError, match="Expected a real number"):
        tape.sin("x")
    with pytest.raises(ZeroDivisionError, match="divisor other than 0"):
        x / 0
    with pytest.raises(TypeError):
        x + "y"


def test_size_stays_linear(tape):
    x = tape.input("x")
    y = x
    for _ in range(1000):
        y = y * y + x
    assert len(tape) == 2001


def test_what_a_scalar_depends_on():
    tape = Tape()
    x, y, m = map(tape.input, "xym")
    assert tape.depends(tape.sin(x * m) - 2, {x.index, y.index})
    assert not tape.depends(2 * m - 1, {x.index, y.index})
    assert not tape.depends(3, {x.index})
    assert tape.depends(-y, {y.index})
    assert all(map(tape.uses, (x, y, m))) and not tape.uses(tape.input("z"))


def test_numbers_of_a_model_are_data_where_a_tape_says_so():
    plain, tape = Tape(), Tape(numbers_are_data=True)
    assert plain.datum(0.5) == 0.5
    assert [tape.datum(x) for x in (0, 1, -1)] == [0, 1, -1]
    half = tape.datum(0.5)
    assert tape.datum(0.5) is half
    assert tape.evaluate([half * tape.input("x")], {"x": 3.0}) == [1.5]
