"""Inverse Laplace transforms by partial fractions over exact factors.

    N(s) / Π f_i^n_i = Σ r_ij(s) / f_i^j

    1 / (s + a)^k  ->  t^(k-1) e^(-a t) / (k-1)!
    g_1 = sin(w t) / w,   g_(k+1) = -(1 / 2 k w) ∂g_k/∂w   ->   1 / (s² + w²)^k;     s / (s² + w²)^k  ->  g_k'

Source: Bracewell, The Fourier Transform and Its Applications (3rd ed.), chapter 14; Knuth, TAOCP 2, §4.6.1 (expansion).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ...errors import ModelError
from ...scalar.algebra import Scalar
from ..printing.rational import Rationals, S
from .characteristic import Characteristic, biquadratic, determinant
from .forcing import T, Term

_W = sympy.Dummy("w", positive=True)


def inverse_transform(character: Characteristic, rows: Sequence[Sequence[Scalar]], term: Term | None) -> Any:
    """Return the inverse transform of det(rows) / Δ(s) times the transform of an input."""
    ring = character.ring
    top = determinant(ring, rows)
    if top == 0:
        return sympy.Integer(0)
    s = ring.generator(S)
    above: Scalar = 1
    below: Scalar = 1
    times = 0
    if term is not None:
        above, below, times = _transform(ring, s, term)
    field = Rationals(
        ring, [top, character.determinant, above, below, *(f.element for f in character.factors)]
    )
    factors = [(field.poly(f.element).monic(), f.times) for f in character.factors]
    if times:
        other = field.poly(below).monic()
        for k, (f, count) in enumerate(factors):
            if f == other:
                factors[k] = (f, count + times)
                break
        else:
            factors.append((other, times))
    lead = field(character.coefficients[-1])
    upper = (field.poly(top) * field.poly(above)).quo_ground(lead)
    return _expanded(field, upper, factors)


def _transform(ring: Any, s: Any, term: Term) -> tuple[Any, Any, int]:
    """Return (N, D, k) of the transform N / D^k of an input."""
    cosine, sine, growth, frequency = (
        ring.from_sympy(x) for x in (term.cosine, term.sine, term.growth, term.frequency)
    )
    moved = s - growth
    if frequency == 0:
        return cosine * int(sympy.factorial(term.power)), moved, term.power + 1
    below = ring.coerce(moved * moved + frequency * frequency)
    above, k = cosine * moved + sine * frequency, 1
    for _ in range(term.power):  # t f(t) -> -F'(s)
        above = k * above * ring.derivative(below, S) - ring.derivative(above, S) * below
        k += 1
    return above, below, k


def _expanded(field: Rationals, upper: Any, factors: Sequence[tuple[Any, int]]) -> Any:
    powers = [f**count for f, count in factors]
    total: Any = sympy.Integer(0)
    for k, (f, count) in enumerate(factors):
        product = field.of([field.domain.one])
        for i, other in enumerate(powers):
            if i != k:
                product = (product * other).rem(powers[k])
        part = (upper * product.invert(powers[k])).rem(powers[k])
        for j in range(count, 0, -1):  # part / f^count = Σ rest_j / f^j
            part, remainder = part.div(f)
            if not remainder.is_zero:
                total += _of_time(field, remainder, f, j)
    return total


def _of_time(field: Rationals, numerator: Any, f: Any, k: int) -> Any:
    """Return the inverse transform of numerator(s) / f(s)^k."""
    degree = f.degree()
    c = field.listed(f)
    r = field.listed(numerator)
    r += [sympy.Integer(0)] * (degree - len(r))
    if degree == 1:
        return r[0] * T ** (k - 1) / sympy.factorial(k - 1) * sympy.exp(-c[0] * T)
    if degree == 2:
        return _quadratic(r, c, k)
    if degree == 4 and c[1] == 0 and c[3] == 0 and k == 1:
        low, high = biquadratic(field.ring, c[2], c[0])
        total = sympy.Integer(0)
        for w2, other in ((low, high), (high, low)):
            # s² = -w² in the numerator gives the part over s² + w²
            parts = [(r[0] - r[2] * w2) / (other - w2), (r[1] - r[3] * w2) / (other - w2)]
            total += _quadratic(parts, [w2, sympy.Integer(0)], 1)
        return total
    poly = sympy.Poly(list(reversed(c)), S)
    closed = sympy.roots(poly) if degree <= 4 and k == 1 else {}
    if sum(closed.values()) == degree:
        above, slope = sympy.Poly(list(reversed(r)), S), poly.diff(S)
        return sum(above.eval(s) / slope.eval(s) * sympy.exp(s * T) for s in closed)
    raise ModelError(
        f"The characteristic factor {poly.as_expr()} (power {k}) has no roots in closed form, so the response "
        "has none. Give numbers: model.numeric(values), or values= in fb.linearize."
    )


def _quadratic(r: Sequence[Any], c: Sequence[Any], k: int) -> Any:
    """Return the inverse transform of (r1 s + r0) / (s² + c1 s + c0)^k."""
    decay = c[1] / 2
    w = sympy.sqrt(c[0] if decay == 0 else sympy.factor(c[0] - decay**2))
    g = sympy.sin(_W * T) / _W
    for j in range(1, k):
        g = -g.diff(_W) / (2 * j * _W)
    shape = r[1] * g.diff(T) + (r[0] - r[1] * decay) * g
    return (shape if decay == 0 else sympy.exp(-decay * T) * shape).subs(_W, w)
