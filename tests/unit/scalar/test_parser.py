"""The expression parser: what texts mean, and that no text makes it work for long."""

from __future__ import annotations

from fractions import Fraction
from time import perf_counter

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from freebody.errors import ExpressionError
from freebody.scalar.parser import FUNCTIONS, MAX_DEPTH, MAX_LENGTH, parse

t = sympy.Symbol("t")
k, m = sympy.symbols("k m", real=True)
theta = sympy.Function("theta")(t)
NAMES = {"k": k, "m": m, "t": t, "theta": theta, "theta'": theta.diff(t), "theta''": theta.diff(t, 2)}
R = sympy.Rational


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2", 2),
        ("0.1", R(1, 10)),
        (".5", R(1, 2)),
        ("5.", 5),
        ("1.5e-3", R(3, 2000)),
        ("1E3", 1000),
        ("  k  ", k),
        ("k + m - 2", k + m - 2),
        ("k - m - 1", k - m - 1),
        ("k/m/2", k / m / 2),
        ("k/m*2", 2 * k / m),
        ("-k**2", -(k**2)),
        ("(-k)**2", k**2),
        ("2*-k", -2 * k),
        ("--k", k),
        ("+-+k", -k),
        ("2**-1", R(1, 2)),
        ("2^3^2", 512),
        ("k^m", k**m),
        ("k**(1/2)", sympy.sqrt(k)),
        ("2*(k + m)*3", 6 * (k + m)),
        ("pi/2", sympy.pi / 2),
        ("75deg", 5 * sympy.pi / 12),
        ("-180 * 1deg", -sympy.pi),
        ("2rad", 2),
        ("theta'", theta.diff(t)),
        ("theta''*m - k*theta'", theta.diff(t, 2) * m - k * theta.diff(t)),
        ("sin(theta)**2", sympy.sin(theta) ** 2),
        ("atan2(k, m)", sympy.atan2(k, m)),
        ("max(k, m, 0)", sympy.Max(k, m, 0)),
        ("min(1, 2)", 1),
        ("abs(-k)", sympy.Abs(k)),
        ("sqrt(8)", 2 * sympy.sqrt(2)),
        ("exp(0) + log(1) + sign(-3) + cosh(0)", 1),
        ("k\n * m", k * m),
    ],
)
def test_text_means(text: str, expected: object) -> None:
    assert parse(text, NAMES) == expected


def test_every_function_is_the_one_of_sympy() -> None:
    same = {"abs": "Abs", "min": "Min", "max": "Max"}
    for name, function in FUNCTIONS.items():
        arguments = ("k", "m")[: function.least]
        expected = getattr(sympy, same.get(name, name))(*(NAMES[a] for a in arguments))
        assert parse(f"{name}({', '.join(arguments)})", NAMES) == expected


def test_a_name_of_the_user_wins_over_a_constant() -> None:
    own = sympy.Symbol("pi_own")
    assert parse("2*pi", {"pi": own}) == 2 * own


def test_no_float_ever_appears() -> None:
    assert not parse("0.1*k + 2.5e-3*sin(0.7)*75.5deg", NAMES).atoms(sympy.Float)


number = st.fractions(min_value=-100, max_value=100, max_denominator=1000)
leaf = st.one_of(st.sampled_from(["k", "m", "theta", "theta'"]), number.map(lambda f: f"({f})"))
tree = st.recursive(
    leaf,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*"), inner).map(lambda p: f"({p[0]} {p[1]} {p[2]})"),
        inner.map(lambda e: f"sin({e})"),
        inner.map(lambda e: f"(-{e})^2"),
    ),
    max_leaves=12,
)


@settings(max_examples=60)
@given(tree)
def test_same_number_as_python(text: str) -> None:
    """Random expressions, against Python's own arithmetic on floats."""
    from math import isclose, sin

    values = {"theta'": "2.1", "theta": "0.4", "m": "-1.3", "k": "0.7"}  # the speed before its coordinate
    expression = parse(text, NAMES).subs({NAMES[name]: Fraction(value) for name, value in values.items()})
    python = text.replace("theta'", "speed").replace("^", "**")
    arguments = []

    def sine(x: float) -> float:
        arguments.append(abs(x))
        return sin(x)

    scope = {"sin": sine, "k": 0.7, "m": -1.3, "theta": 0.4, "speed": 2.1}
    expected = eval(python, {"__builtins__": {}}, scope)  # text made above, not input
    # a sine has lost to rounding what its argument has: squares of squares reach 1e10 and more
    lost = 1e-12 * max(arguments, default=0)
    assert isclose(float(expression), expected, rel_tol=1e-9, abs_tol=1e-6 + lost)


@settings(max_examples=300)
@given(st.text(alphabet="k1.e'*/+-^(), sintheta=[]{}\\\"_é°\n", max_size=40))
def test_any_text_is_read_or_refused_in_order(text: str) -> None:
    try:
        result = parse(text, NAMES)
    except ExpressionError as error:
        assert "xpected" in str(error)
    else:
        assert isinstance(result, sympy.Expr)


@pytest.mark.parametrize(
    "text",
    [
        "9**9**9**9",
        "2**(2**4096)",
        "(k + m)**100000",
        "(k + m)**(1/100000)",
        "1e999999999",
        "9" * 5000,
        "10**10**pi",
        "*".join(["10**1000"] * 1500),
        "sqrt(" * 300 + "k" + ")" * 300,
        "(" * 10_000,
        "-" * 15_000,
        "2**" * 6000 + "2",
        "max(" + "k, " * 5000 + "m)",
        "k" * (MAX_LENGTH + 1),
        "exp(exp(exp(exp(10))))",
        "exp(-exp(exp(10)))",
        "exp(10)^exp(10)",
        "pi^pi^pi^pi^pi",
        "k*sinh(exp(9))",
        "sin(exp(exp(exp(exp(9)))))",
        "((k + m)**100)**100" + "**100" * 40,
    ],
)
def test_hostile_text_is_refused_at_once(text: str) -> None:
    start = perf_counter()
    with pytest.raises(ExpressionError):
        parse(text, NAMES)
    assert perf_counter() - start < 2


def test_long_sums_and_products_take_linear_time() -> None:
    assert parse(" + ".join(["k"] * 3000), NAMES) == 3000 * k
    assert parse("*".join(["k"] * 3000), NAMES) == k**3000


def test_depth_up_to_the_limit_is_read() -> None:
    assert parse("(" * (MAX_DEPTH - 1) + "k" + ")" * (MAX_DEPTH - 1), NAMES) == k
