"""Laws of a ring, and of its derivative, on elements that Hypothesis draws."""

from __future__ import annotations

from fractions import Fraction

import sympy as sp
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from freebody.scalar.polynomial import Ring

m, M, x = sp.symbols("m M x", real=True)
q1, q2 = sp.symbols("q1 q2", real=True)

LEAVES = [
    m, M, x, sp.sin(q1), sp.cos(q1), sp.sin(q1 - q2), sp.cos(q2 / 2), 1 / m, 1 / (m + M), sp.sqrt(2),
    sp.sqrt(m**2 + x**2), sp.exp(x),
]  # fmt: skip
numbers = st.fractions(min_value=-3, max_value=3, max_denominator=6)
leaves = st.one_of(st.sampled_from(LEAVES), numbers.map(lambda n: sp.Rational(n.numerator, n.denominator)))
expressions = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(lambda p: sp.Add(*p)), st.tuples(inner, inner).map(lambda p: sp.Mul(*p))
    ),
    max_leaves=6,
)
# all multiples of 1/12, so that no angle is more than 24 times the smallest
parts = st.sampled_from([Fraction(n, d) for d in (1, 2, 3, 4, 6) for n in range(-d, d + 1)])
quick = settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])


def of(ring, *exprs):
    return [ring.coerce(ring.from_sympy(e)) for e in exprs]


def alike(u, v):
    """Equal values, equal hashes, and one text."""
    return u == v and hash(u) == hash(v) and str(u) == str(v)


@quick
@given(expressions, expressions, expressions)
def test_ring_laws(f, g, h):
    ring = Ring()
    a, b, c = of(ring, f, g, h)
    assert alike(a + b, b + a)
    assert alike(a * b, b * a)
    assert alike((a + b) + c, a + (b + c))
    assert alike(ring.coerce(a * b) * c, a * ring.coerce(b * c))
    assert alike(a * ring.coerce(b + c), a * b + a * c)
    assert a - a == 0 and a * 0 == 0 and alike(a * 1, a)
    assert alike(-1 * (-a), a)


@quick
@given(expressions, expressions)
def test_division_undoes_multiplication(f, g):
    ring = Ring()
    a, b = of(ring, f, g)
    if b != 0:
        product = ring.coerce(a * b)
        assert alike(product / b, a)


@quick
@given(expressions, expressions)
def test_derivative_is_a_derivation(f, g):
    ring = Ring()
    a, b = of(ring, f, g)
    for atom in (m, q1):
        left = ring.coerce(a * b).derivative(atom)
        assert left == a.derivative(atom) * b + a * b.derivative(atom)
        assert ring.coerce(a + b).derivative(atom) == a.derivative(atom) + b.derivative(atom)


@quick
@given(expressions)
def test_round_trip_and_expansion(f):
    ring = Ring()
    (a,) = of(ring, f)
    assert alike(ring.coerce(ring.from_sympy(a.to_sympy())), a)
    assert alike(ring.coerce(ring.from_sympy(sp.expand(f))), a)


@quick
@given(expressions, st.integers(0, 4))
def test_powers(f, n):
    ring = Ring()
    (a,) = of(ring, f)
    product = 1
    for _ in range(n):
        product = product * a
    assert a**n == product


@quick
@given(st.lists(numbers, min_size=2, max_size=5))
def test_numbers_are_numbers(values):
    ring = Ring()
    total = sum((ring.constant(v) for v in values), 0)
    assert total == sum(values, Fraction(0))
    assert hash(ring.coerce(total)) == hash(sum(values, Fraction(0)))


@quick
@given(parts, parts)
def test_addition_theorem(u, v):
    # whatever fractions of the angle come first, sine and cosine of the sum are the same elements
    ring = Ring()
    angle = ring.generator(x)
    s, c = ring.sin(angle * u), ring.cos(angle * u)
    S, C = ring.sin(angle * v), ring.cos(angle * v)
    assert ring.sin(angle * (u + v)) - (s * C + c * S) == 0
    assert ring.cos(angle * (u + v)) - (c * C - s * S) == 0
    assert s * s + c * c == 1
