"""From Laplace transforms back to functions of time, by partial fractions over exact factors.

    N(s) / Π f_i^n_i = Σ r_ij(s) / f_i^j

    1 / (s + a)^k  ->  t^(k-1) e^(-a t) / (k-1)!
    g_1 = sin(w t) / w,   g_(k+1) = -(1 / 2 k w) ∂g_k/∂w   ->   1 / (s² + w²)^k;     s / (s² + w²)^k  ->  g_k'

Source: Bracewell, The Fourier Transform and Its Applications (3rd ed.), chapter 14; Knuth, TAOCP 2, §4.6.1 (expansion).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from ..errors import ModelError
from .characteristic import Characteristic, S, determinant
from .forcing import T, Term

_W = sympy.Symbol("w", positive=True)


def inverse_transform(character: Characteristic, rows: Sequence[Sequence[Any]], term: Term | None) -> Any:
    """The function of time of det(rows) / Δ(s), times the transform of an input."""
    ring = character.ring
    top = determinant(ring, rows)
    if top == 0:
        return sympy.Integer(0)
    lead = character.coefficients[-1]
    factors: list[tuple[Any, int]] = []
    for f in character.factors:
        factors.append((_monic([ring.to_sympy(c) for c in f.coefficients]), f.times))
    upper = ring.to_sympy(top) / ring.to_sympy(lead)
    if term is not None:
        above, below, times = _transform(term)
        upper = upper * above
        for k, (f, count) in enumerate(factors):
            if sympy.cancel(sympy.together(f - below)) == 0:
                factors[k] = (f, count + times)
                break
        else:
            factors.append((below, times))
    return _expanded(upper, factors)


def _monic(coefficients: Sequence[Any]) -> Any:
    return sum(sympy.cancel(c / coefficients[-1]) * S**k for k, c in enumerate(coefficients))


def _transform(term: Term) -> tuple[Any, Any, int]:
    """(N, D, k) of the transform N / D^k of an input."""
    moved = S - term.growth
    if term.frequency == 0:
        return term.cosine * sympy.factorial(term.power), moved, term.power + 1
    below = sympy.expand(moved**2 + term.frequency**2)
    above, k = term.cosine * moved + term.sine * term.frequency, 1
    for _ in range(term.power):  # t f(t) -> -F'(s)
        above, k = k * above * below.diff(S) - above.diff(S) * below, k + 1
    return sympy.expand(above), below, k


def _expanded(upper: Any, factors: Sequence[tuple[Any, int]]) -> Any:
    def poly(x: Any) -> Any:
        return sympy.Poly(x, S, field=True)

    N = poly(sympy.cancel(upper))
    powers = [poly(f) ** count for f, count in factors]
    total: Any = sympy.Integer(0)
    for k, (f, count) in enumerate(factors):
        others = poly(1)
        for i, other in enumerate(powers):
            if i != k:
                others = others * other
        part = (N * _inverse(others, powers[k])).rem(powers[k])
        base = poly(f)
        for j in range(count, 0, -1):  # part / f^count = Σ rest_j / f^j
            part, rest = part.div(base)
            if not rest.is_zero:
                total += _term_of_time(rest, base, j)
    return total


def _inverse(x: Any, modulus: Any) -> Any:
    return x.rem(modulus).invert(modulus) if modulus.degree() > 0 else x


def _term_of_time(rest: Any, f: Any, k: int) -> Any:
    c = [_tidy(f.coeff_monomial(S**i)) for i in range(f.degree() + 1)]
    r = [_tidy(rest.coeff_monomial(S**i)) for i in range(f.degree())]
    if f.degree() == 1:
        return r[0] * T ** (k - 1) / sympy.factorial(k - 1) * sympy.exp(-c[0] * T)
    if f.degree() == 2:
        return _quadratic(r, c, k)
    if f.degree() == 4 and c[1] == 0 and c[3] == 0 and k == 1:
        half, root = c[2] / 2, sympy.sqrt(sympy.factor(c[2] ** 2 / 4 - c[0]))
        low, high = half - root, half + root
        total = sympy.Integer(0)
        for w2, other in ((low, high), (high, low)):
            # s² = -w² in the numerator leaves what stands over s² + w²
            parts = [(r[0] - r[2] * w2) / (other - w2), (r[1] - r[3] * w2) / (other - w2)]
            total += _quadratic(parts, [w2, sympy.Integer(0)], 1)
        return total
    if k == 1:
        found = sympy.roots(f) if f.degree() <= 4 else {}
        if sum(found.values()) == f.degree():
            slope = f.diff(S)
            return sum(rest.eval(s) / slope.eval(s) * sympy.exp(s * T) for s in found)
    shown = f.as_expr()
    raise ModelError(
        f"The characteristic factor {shown} has no roots in closed form, so the response has none. "
        "Give numbers: model.numeric(values), or values= in fb.linearize."
    )


def _quadratic(r: Sequence[Any], c: Sequence[Any], k: int) -> Any:
    """(r1 s + r0) / (s² + c1 s + c0)^k."""
    decay = c[1] / 2
    w = sympy.sqrt(sympy.factor(c[0] - decay**2))
    g = sympy.sin(_W * T) / _W
    for j in range(1, k):
        g = -g.diff(_W) / (2 * j * _W)
    along, across = r[1], r[0] - r[1] * decay
    shape = along * g.diff(T) + across * g
    return (shape if decay == 0 else sympy.exp(-decay * T) * shape).subs(_W, w)


def _tidy(x: Any) -> Any:
    return sympy.factor(x) if x != 0 else x
