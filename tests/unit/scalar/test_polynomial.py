"""Canonical polynomials: one form for equal elements, zero, derivatives, SymPy both ways."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest
import sympy as sp

from freebody.errors import ExpressionError
from freebody.scalar.polynomial import Polynomial, Ring

t = sp.Symbol("t")
m, M, a, b, k, x, y, w = sp.symbols("m M a b k x y omega", real=True)
p, r = sp.symbols("p r", positive=True)
q, q1, q2, q3 = (sp.Function(n)(t) for n in ("q", "q1", "q2", "q3"))

DIGITS = 50
# Cancellation in sums of a few dozen terms of order one costs at most a few of the 50 digits.
TOLERANCE = sp.Float(10) ** -40


def close(left, right, seed=0):
    """Whether two expressions agree at a random 50-digit point, 0.3 < atom < 0.9."""
    together = sp.Tuple(sp.sympify(left), sp.sympify(right))
    rng = random.Random(seed)
    atoms = together.atoms(sp.Symbol, sp.core.function.AppliedUndef, sp.Derivative)
    # derivatives first: a function replaced inside its derivative would leave that of a number
    ordered = sorted(atoms, key=lambda e: (not e.is_Derivative, not e.is_Function, str(e)))
    for e in ordered:
        together = together.xreplace({e: sp.Rational(rng.randint(300, 900), 1000)})
    u, v = (sp.N(e, DIGITS) for e in together)
    return abs(u - v) <= TOLERANCE * (1 + abs(u))


def same(ring, left, right):
    """Two routes to one element: one value, one hash, one text."""
    u, v = ring.coerce(ring.from_sympy(left)), ring.coerce(ring.from_sympy(right))
    return u == v and hash(u) == hash(v) and str(u) == str(v)


# ------------------------------------------------------------------------------- canonical form
IDENTITIES = [
    ("pythagoras", sp.sin(q) ** 2 + sp.cos(q) ** 2, 1),
    ("double angle", sp.sin(2 * q), 2 * sp.sin(q) * sp.cos(q)),
    ("difference", sp.cos(q2 - q1), sp.cos(q1) * sp.cos(q2) + sp.sin(q1) * sp.sin(q2)),
    ("with a parameter", sp.sin(w * t + b), sp.sin(b) * sp.cos(w * t) + sp.cos(b) * sp.sin(w * t)),
    ("triple angle", sp.cos(3 * q), 4 * sp.cos(q) ** 3 - 3 * sp.cos(q)),
    ("half after whole", sp.sin(q) * sp.sin(q / 2) * sp.cos(q / 2), sp.sin(q) ** 2 / 2),
    ("half after whole, square", sp.cos(q) + 2 * sp.sin(q / 2) ** 2, 1),
    ("thirds and halves", sp.sin(q / 2) - 3 * sp.sin(q / 6) + 4 * sp.sin(q / 6) ** 3, 0),
    ("quarter turn", sp.sin(q + sp.pi / 2), sp.cos(q)),
    ("sixty degrees", sp.sin(sp.pi / 3) * 2, sp.sqrt(3)),
    ("fifteen degrees", 4 * sp.sin(sp.pi / 12), sp.sqrt(6) - sp.sqrt(2)),
    ("twelfths shifted", sp.cos(q + sp.pi / 6) * 2, sp.sqrt(3) * sp.cos(q) - sp.sin(q)),
    ("difference of squares", (m**2 - M**2) / (m + M), m - M),
    ("inverse", (2 * m) ** -1 * m, sp.Rational(1, 2)),
    ("series masses", 1 / (1 / m + 1 / M), m * M / (m + M)),
    ("partial fractions", 1 / m - 1 / (m + M), M / (m * (m + M))),
    ("three sums", 1 / (m + M) - 1 / (m + M + a), a / ((m + M) * (m + M + a))),
    ("not monic", 1 / (2 * m + 3 * M) + 1 / M, (2 * m + 4 * M) / (M * (2 * m + 3 * M))),
    ("cubic", (m**3 - M**3) / (m - M), m**2 + m * M + M**2),
    ("tangent", sp.tan(q) ** 2 + 1, 1 / sp.cos(q) ** 2),
    ("inverse sines", 1 / sp.sin(q) ** 2, 1 / ((1 - sp.cos(q)) * (1 + sp.cos(q)))),
    ("half angle tangent", (1 - sp.cos(q)) / sp.sin(q), sp.sin(q) / (1 + sp.cos(q))),
    ("root of a number", sp.sqrt(12), 2 * sp.sqrt(3)),
    ("root of a fraction", sp.sqrt(sp.Rational(3, 8)), sp.sqrt(6) / 4),
    ("root squared", sp.sqrt(a**2 + b**2) ** 4, (a**2 + b**2) ** 2),
    ("inverse root", 1 / sp.sqrt(a**2 + b**2), sp.sqrt(a**2 + b**2) / (a**2 + b**2)),
    ("positive square", sp.Pow(p**2 * r, sp.Rational(1, 2), evaluate=False), p * sp.sqrt(r)),
    ("frequency", sp.sqrt(p / r) * r, sp.sqrt(p * r)),
    ("rationalized", 1 / (a + sp.sqrt(2) * b), (a - sp.sqrt(2) * b) / (a**2 - 2 * b**2)),
    ("absolute squared", sp.Abs(x) ** 2, x**2),
    ("absolute product", sp.Abs(x * y), sp.Abs(x) * sp.Abs(y)),
    ("exponentials", sp.exp(x + 2 * y) * sp.exp(-x), sp.exp(y) ** 2),
    ("exponential halves", sp.exp(x) - sp.exp(x / 2) ** 2, 0),
    ("hyperbolic", sp.cosh(x) ** 2 - sp.sinh(x) ** 2, 1),
    ("hyperbolic sum", sp.sinh(x + y), sp.sinh(x) * sp.cosh(y) + sp.cosh(x) * sp.sinh(y)),
    ("sine of arc sine", sp.sin(sp.asin(x, evaluate=False)), x),
    ("cosine of atan2", sp.cos(sp.atan2(y, x)) * sp.sqrt(x**2 + y**2), x),
    ("odd function", sp.atan(x - y) + sp.atan(y - x), 0),
    ("opaque, equal arguments", sp.log((x + y) ** 2), sp.log(x**2 + 2 * x * y + y**2)),
]  # fmt: skip


@pytest.mark.parametrize("left, right", [pytest.param(u, v, id=name) for name, u, v in IDENTITIES])
def test_two_routes_to_one_element(left, right):
    assert same(Ring(), left, right)
    # whichever side comes first: generators are then made in another order
    ring = Ring()
    ring.from_sympy(sp.sympify(right))
    assert same(ring, left, right)


@pytest.mark.parametrize("left, right", [pytest.param(u, v, id=name) for name, u, v in IDENTITIES])
def test_zero_is_recognised(left, right):
    ring = Ring()
    difference = ring.from_sympy(left) - ring.from_sympy(sp.sympify(right))
    assert type(difference) is not Polynomial  # a plain number, the int 0 unless both were fractions
    assert difference == 0


@pytest.mark.parametrize("capacity", [2, 64])
def test_all_identities_hold_together_in_one_ring(capacity):
    # relations of different generators overlap here (1/sin, halves of q, sums of masses)
    ring = Ring(capacity)
    for _, left, right in IDENTITIES:
        assert ring.from_sympy(left) - ring.from_sympy(sp.sympify(right)) == 0


def test_exact_zero_and_one_are_plain():
    ring = Ring()
    z = ring.generator(x)
    assert z * 0 == 0 and type(z * 0) is int
    assert 1 * z is z and z + 0 is z and 0 + z is z
    assert type(z - z) is int
    assert type(z / z) is int and z / z == 1


def test_different_elements_differ():
    ring = Ring()
    u, v = ring.generator(x), ring.generator(y)
    assert u != v and u * v != u and u != 1 and u + 1 != u and (u / 2) != u
    assert u != "x"


def test_growth_keeps_elements():
    ring = Ring(capacity=4)
    u = ring.generator(m) * ring.generator(M) + ring.sin(ring.generator(q))
    before = hash(u)
    symbols = sp.symbols("c0:40")
    total = sum((ring.generator(s) * (i + 1) for i, s in enumerate(symbols)), 0)
    v = ring.sin(ring.generator(q)) + ring.generator(m) * ring.generator(M)
    assert u == v and before == hash(v) == hash(u)
    assert (u * total - total * v) == 0
    assert (u * u + total).to_sympy() == sp.expand(((m * M + sp.sin(q)) ** 2).expand()).replace(
        sp.sin(q) ** 2, 1 - sp.cos(q) ** 2
    ) + sum((i + 1) * s for i, s in enumerate(symbols))


def test_unit_norm_of_a_quaternion():
    e = sp.symbols("e0:4", real=True)
    ring = Ring()
    ring.unit_norm(*e)
    e0, e1, e2, e3 = (ring.generator(s) for s in e)
    R = (
        (1 - 2 * (e2 * e2 + e3 * e3), 2 * (e1 * e2 - e0 * e3), 2 * (e1 * e3 + e0 * e2)),
        (2 * (e1 * e2 + e0 * e3), 1 - 2 * (e1 * e1 + e3 * e3), 2 * (e2 * e3 - e0 * e1)),
        (2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), 1 - 2 * (e1 * e1 + e2 * e2)),
    )
    for i in range(3):
        for j in range(3):
            assert sum(R[i][n] * R[j][n] for n in range(3)) == (i == j)
    with pytest.raises(ExpressionError, match="declare each unit norm once"):
        ring.unit_norm(*e)


def test_assume_positive():
    ring = Ring()
    z = ring.generator(m)
    assert str(ring.sqrt(z * z)) == "Abs(m)"
    ring.assume_positive(m)
    assert ring.sqrt(z * z) == z
    assert ring.apply("abs", z) == z and ring.apply("sign", z) == 1


def test_assumptions_keep_their_order():
    """What is built from them, such as a ring of half angles, is the same in every process."""
    ring, x = Ring(), sp.symbols("x:40")
    for k in x:
        ring.generator(k, "parameter")
    said = [x[k] - x[k + 1] for k in (7, 3, 30, 1, 22, 11, 38, 0)]
    for difference in said:
        ring.assume_positive(difference)
    assert list(map(ring.to_sympy, ring.positive)) == said


def test_assume_positive_expressions():
    ring = Ring()
    ring.assume_positive(2 * m)  # says the same as m
    assert ring.from_sympy(sp.sqrt(m**2)) == ring.generator(m)
    ring.assume_positive(a - b)
    assert ring.from_sympy(sp.Abs(a - b)) == ring.from_sympy(a - b)
    assert ring.from_sympy(sp.Abs(b - a) + sp.sign(b - a)) == ring.from_sympy(a - b - 1)
    assert ring.from_sympy(sp.sqrt((3 * a - 3 * b) ** 2)) == ring.from_sympy(3 * a - 3 * b)
    ring.assume_positive(sp.Integer(3))  # says nothing
    ring.assume_positive(a**2)  # of the sign of a neither
    assert str(ring.from_sympy(sp.Abs(a))) == "Abs(a)"


def test_angles_far_from_each_other_are_separate_atoms():
    # the documented limit: a multiple beyond 24 is not expanded
    ring = Ring()
    z = ring.from_sympy(sp.sin(sp.Rational(2469, 2000) * q))
    assert z.to_sympy() == sp.sin(2469 * q / 2000)
    assert len(ring.from_sympy(sp.sin(24 * q))) > 1


# ------------------------------------------------------------------------------------- division
def test_division_cancels():
    ring = Ring()
    f = ring.from_sympy
    assert (f((m + M) * sp.sin(q)) / f(m + M)).to_sympy() == sp.sin(q)
    assert (f(3 * a * sp.sin(q)) / f(a * sp.sin(q))) == 3
    assert len([g for g in ring.generators if g.kind == "inverse"]) == 0  # nothing had to be inverted
    assert f(x) / 2 * 2 == f(x)


def test_division_by_zero_is_refused():
    ring = Ring()
    z = ring.generator(x)
    with pytest.raises(ExpressionError, match=r"Expected a divisor that is not zero in \(x\) / 0"):
        z / 0
    with pytest.raises(ExpressionError, match="divisor that is not zero"):
        ring.from_sympy(1 / (sp.Symbol("u") + 1)) / (ring.sin(z) ** 2 + ring.cos(z) ** 2 - ring.coerce(1))
    with pytest.raises(ExpressionError, match="divisor that is not zero"):
        z / ring.constant(0)


def test_factor():
    ring = Ring()
    c, factors = ring.from_sympy((m + M) ** 2 * a / 2).factor()
    assert c == Fraction(1, 2)
    assert {(str(f), n) for f, n in factors} == {("a", 1), ("M + m", 2)}
    product = c
    for f, n in factors:
        product = f**n * product
    assert product == ring.from_sympy((m + M) ** 2 * a / 2)


# ---------------------------------------------------------------------------------- derivatives
DIFFERENTIABLE = [
    sp.sin(x * y) * m,
    sp.cos(x / 2) * sp.cos(x),
    sp.tan(x),
    sp.sqrt(x**2 + y**2),
    1 / (x + y),
    sp.exp(-x * y),
    sp.log(x + 1),
    sp.atan2(y, x),
    sp.asin(x / 2),
    sp.acos(x * y),
    sp.atan(x**2),
    sp.sinh(x) * sp.cosh(2 * x),
    sp.tanh(x),
    sp.Abs(x - 3 * y),
    x**y,
    sp.Max(x, y) + sp.Min(x, 2 * y),
    sp.sqrt(1 + sp.sin(x)) / (2 + sp.cos(y)),
    sp.exp(sp.sin(x)),
    x ** sp.Rational(1, 3),
]


@pytest.mark.parametrize("expr", DIFFERENTIABLE, ids=str)
@pytest.mark.parametrize("atom", [x, y], ids=str)
def test_derivative_is_sympys(expr, atom):
    ring = Ring()
    mine = ring.coerce(ring.coerce(ring.from_sympy(expr)).derivative(atom)).to_sympy()
    theirs = sp.diff(expr, atom).rewrite(sp.Piecewise).doit() if expr.has(sp.Max) else sp.diff(expr, atom)
    for seed in range(3):
        assert close(mine, theirs, seed)


def test_sign_is_piecewise_constant():
    ring = Ring()
    assert ring.from_sympy(sp.sign(x - y)).derivative(x) == 0


def test_total_derivative():
    ring = Ring()
    qd, qdd = sp.Derivative(q, t), sp.Derivative(q, (t, 2))
    expr = m * sp.sin(q) * qd**2 + sp.cos(w * t)
    rates = {q: ring.generator(qd), qd: ring.generator(qdd)}
    mine = ring.from_sympy(expr).total_derivative(rates)
    assert mine == ring.from_sympy(sp.diff(expr, t).doit())
    assert ring.from_sympy(m).total_derivative(rates) == 0


def test_unknown_atom_has_derivative_zero():
    ring = Ring()
    assert ring.from_sympy(sp.sin(x)).derivative(sp.Symbol("never")) == 0


# ---------------------------------------------------------------------------------------- SymPy
@pytest.mark.parametrize("expr", [u for _, u, _ in IDENTITIES if sp.sympify(u).free_symbols], ids=str)
def test_round_trip_at_random_points(expr):
    ring = Ring()
    z = ring.coerce(ring.from_sympy(expr))
    for seed in range(2):
        assert close(z.to_sympy(), expr, seed)
    assert ring.from_sympy(z.to_sympy()) == z


def test_built_expression_is_what_sympy_would_build():
    # to_sympy sorts terms by itself; SymPy compares structure, so the order must be SymPy's own
    rng = random.Random(3)
    pool = [m, M, a, q1, q2, sp.sin(q1), sp.cos(q1), sp.cos(q2), sp.Derivative(q1, t), sp.Symbol("L1")]
    ring = Ring()
    for _ in range(20):
        terms = [
            sp.Rational(rng.randint(-5, 5), rng.choice([1, 2, 12]))
            * sp.prod(rng.choices(pool, k=rng.randint(0, 4)))
            for _ in range(rng.randint(1, 12))
        ]
        z = ring.coerce(ring.from_sympy(sp.Add(*terms)))
        built = z.to_sympy()
        assert built == built.func(*[term.func(*term.args) if term.args else term for term in built.args])
        assert sp.Add(*sp.Add.make_args(built)) == built
        assert sp.expand(built) == built


def test_atoms():
    ring = Ring()
    assert ring.from_sympy(sp.sin(q1 - q2) * sp.sqrt(m + M)).atoms() == {q1, q2, m, M}


def test_numbers_are_exact():
    ring = Ring()
    assert ring.coerce(0.1).number() == Fraction(1, 10)
    z = ring.generator(x)
    assert z * 0.5 == z / 2
    assert z * sp.Rational(1, 3) == z / 3
    assert hash(ring.constant(2)) == hash(2) and ring.constant(2) == 2
    assert float(ring.constant(Fraction(1, 4))) == 0.25


# --------------------------------------------------------------------------------------- refusals
def test_not_a_number_is_refused():
    ring = Ring()
    z = ring.generator(x)
    for bad in (float("nan"), float("inf")):
        with pytest.raises(ExpressionError, match="Expected a finite number"):
            ring.constant(bad)
        with pytest.raises(ExpressionError, match="Expected a finite number"):
            z * bad
    with pytest.raises(ExpressionError, match="Expected a finite real expression"):
        ring.from_sympy(sp.nan + x)
    with pytest.raises(ExpressionError, match="Expected a finite real expression"):
        ring.from_sympy(sp.I * x)


def test_what_is_not_an_expression_is_refused():
    ring = Ring()
    with pytest.raises(ExpressionError, match="got the text 'x \\+'"):
        ring.from_sympy("x +")
    with pytest.raises(ExpressionError, match="Expected a SymPy expression, got"):
        ring.from_sympy(object())
    with pytest.raises(ExpressionError, match="Expected one SymPy expression, got"):
        ring.from_sympy(sp.Eq(x, y))
    with pytest.raises(ExpressionError, match="Known functions"):
        ring.from_sympy(sp.gamma(x))
    with pytest.raises(ExpressionError, match="Expected a number, got 'x'"):
        ring.constant(x)


def test_unknown_names_offer_the_nearest():
    ring = Ring()
    with pytest.raises(ExpressionError, match="Unknown function 'sine': did you mean 'sin'"):
        ring.apply("sine", ring.generator(x))
    with pytest.raises(ExpressionError, match="Unknown constant 'Pi': did you mean 'pi'"):
        ring.constant("Pi")
    with pytest.raises(ExpressionError, match="Unknown kind 'speeds' of a generator: did you mean 'speed'"):
        ring.generator(x, "speeds")
    with pytest.raises(ExpressionError, match="Expected a symbol, a function of time or a derivative"):
        ring.generator(x + y)
    with pytest.raises(ExpressionError, match="Expected 2 arguments of atan2, got 1"):
        ring.apply("atan2", ring.generator(x))


def test_negative_radicand_and_domain_are_refused():
    ring = Ring()
    with pytest.raises(ExpressionError, match="Expected a radicand that can be positive"):
        ring.sqrt(ring.constant(-2))
    with pytest.raises(ExpressionError, match="Expected arguments where log is real, got -1"):
        ring.apply("log", -1)
    with pytest.raises(ExpressionError, match="where asin is real"):
        ring.apply("asin", 2)


def test_two_rings_do_not_mix():
    u, v = Ring().generator(x), Ring().generator(x)
    assert u != v
    with pytest.raises(ExpressionError, match="elements of one ring"):
        u + v.ring.generator(y) * v
    with pytest.raises(ExpressionError, match="element of this ring"):
        u.ring.coerce(v)


def test_no_order_and_no_number():
    z = Ring().generator(x)
    with pytest.raises(TypeError, match="no algorithm may branch"):
        _ = z < 1
    with pytest.raises(ExpressionError, match="Expected a number, got x"):
        float(z)


def test_polynomial_is_exported():
    element = Ring().generator(x)
    assert isinstance(element, Polynomial) and element.ring.to_sympy(element) == x
