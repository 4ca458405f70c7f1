"""Functions of canonical polynomials: what has a canonical expansion is expanded, the rest is opaque.

- sine and cosine (and sinh, cosh) of a sum by the addition theorems; the atoms are sines and
  cosines of one monomial each, over a common denominator when fractions of it occur;
- exp of a sum as a product; √ by irreducible factors; abs likewise;
- everything else becomes one generator per function and canonical arguments.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import lcm
from typing import Any

import sympy
from flint import fmpz

from ..errors import ExpressionError
from .element import Polynomial, element

# sin(n x) is expanded in sin(x), cos(x) up to this n; beyond it is an atom of its own.
LARGEST_MULTIPLE = 24
_ODD = ("asin", "atan", "sign")


def apply(ring: Any, name: str, arguments: list[Polynomial]) -> Any:
    """The value of a function at elements of one ring."""
    expected = 2 if name in ("atan2", "pow") else None if name in ("min", "max") else 1
    if expected is not None and len(arguments) != expected:
        raise ExpressionError(
            f"Expected {expected} argument{'s' * (expected > 1)} of {name}, got {len(arguments)}."
        )
    x = arguments[0]
    if name in ("sin", "cos"):
        return _pair(ring, "sin", x)[name == "cos"]
    if name == "tan":
        s, c = _pair(ring, "sin", x)
        return _divide(ring, s, c)
    if name in ("sinh", "cosh"):
        return _pair(ring, "sinh", x)[name == "cosh"]
    if name == "tanh":
        s, c = _pair(ring, "sinh", x)
        return _divide(ring, s, c)
    if name == "exp":
        return _exponential(ring, x)
    if name == "sqrt":
        return _square_root(ring, x)
    if name == "abs":
        return _absolute(ring, x)
    if name == "pow":
        return _power(ring, *arguments)
    if all(a.is_number for a in arguments):
        return _of_numbers(ring, name, [a.number() for a in arguments])
    if name in _ODD and x.num.leading_coefficient() < 0:
        return -apply(ring, name, [-x])
    if name == "acos" and x.num.leading_coefficient() < 0:
        return ring.constant("pi") - apply(ring, name, [-x])
    if name == "sign":
        return _sign(ring, x)
    if name in ("min", "max"):
        distinct = sorted(set(arguments), key=lambda a: str(a.num))
        return distinct[0] if len(distinct) == 1 else _opaque(ring, name, distinct)
    return _opaque(ring, name, arguments)


def derivative(ring: Any, g: Any, atom: Any) -> Any:
    """∂g/∂atom of a derived generator."""
    d = [ring.derivative(a, atom) for a in g.arguments]
    itself = ring.variable(g.index)
    if g.kind == "inverse":  # (1/p)' = -p'/p²
        return -itself * itself * d[0]
    if g.kind == "sqrt":  # (√P)' = P'/(2√P) = P'√P/(2P)
        return _divide(ring, itself * d[0], 2 * g.arguments[0])
    if g.kind in ("sin", "sinh", "cosh"):
        return ring.variable(g.partner) * d[0]
    if g.kind == "cos":
        return -ring.variable(g.partner) * d[0]
    if g.name == "exp":
        return itself * d[0]
    if g.name in ("min", "max"):  # of a list: where the last argument or the rest decides
        *rest, last = g.arguments
        other = rest[0] if len(rest) == 1 else apply(ring, g.name, rest)
        step = apply(ring, "sign", [ring.coerce(last - other)])
        if g.name == "min":
            step = -step
        d_other = ring.derivative(other, atom)
        return ((d[-1] + d_other) + step * (d[-1] - d_other)) / 2
    if g.name == "sign":
        return 0
    if g.name == "pow":  # (x^y)' = x^y (y x'/x + log(x) y')
        x, y = g.arguments
        result = _divide(ring, itself * y * d[0], x) if d[0] != 0 else 0
        return result + (itself * apply(ring, "log", [x]) * d[1] if d[1] != 0 else 0)
    if g.name == "atan2":
        y, x = g.arguments
        return _divide(ring, x * d[0] - y * d[1], x * x + y * y)
    x = g.arguments[0]
    if g.name == "abs":
        return apply(ring, "sign", [x]) * d[0]
    if g.name == "log":
        return _divide(ring, d[0], x)
    if g.name == "atan":
        return _divide(ring, d[0], 1 + x * x)
    root = _square_root(ring, ring.coerce(1 - x * x))
    if g.name == "asin":
        return _divide(ring, d[0], root)
    if g.name == "acos":
        return -_divide(ring, d[0], root)
    raise AssertionError(g.name)


def is_positive(ring: Any, num: Any) -> bool:
    """Whether an fmpz_mpoly is known, or was assumed, to be nowhere negative."""
    if ring.positive and element(ring, num // int(num.content()), 1, ring.support(num)) in ring.positive:
        return True
    return all(
        c > 0 and all(e % 2 == 0 or _positive(ring, ring.generators[i]) for i, e in monomial)
        for monomial, c in ring.terms(num)
    )


def with_sines(ring: Any, factors: Sequence[tuple[Any, Any]]) -> tuple[int, list[tuple[Any, int]]]:
    """Factors (c - 1)(c + 1) of a denominator as -s², so that 1/sin² keeps its name."""
    left = [(p, int(n)) for p, n in factors]
    sign = 1
    for p, n in list(left):
        if len(p) != 2 or p.total_degree() != 1:
            continue
        g = ring.generators[ring.exponents(p.monomial(0))[0][0]]
        if g.kind != "cos":
            continue
        c = ring.promoted(ring.variable(g.index).num)
        if p == c - 1 and (c + 1, n) in left:
            left.remove((p, n))
            left.remove((c + 1, n))
            left.append((ring.variable(g.partner).num, 2 * n))
            sign *= (-1) ** n
    return sign, left


def _positive(ring: Any, g: Any) -> bool:
    if g.kind == "inverse":
        return is_positive(ring, g.arguments[0].num)
    return g.positive


def _divide(ring: Any, a: Any, b: Any) -> Any:
    return ring.quotient(ring.coerce(a), ring.coerce(b))


def _monomial(ring: Any, monomial: Sequence[tuple[int, int]]) -> Any:
    result: Any = ring.one
    for i, e in monomial:
        result = result * ring.variable(i) ** e
    return result


# ---------------------------------------------------------------------- sine and cosine
def _pair(ring: Any, kind: str, x: Polynomial) -> tuple[Any, Any]:
    """(sin x, cos x), or (sinh x, cosh x), by the addition theorems."""
    key = (kind, x)
    if key in ring.cache:
        return ring.cache[key]
    sign = -1 if kind == "sin" else 1
    S: Any = 0
    C: Any = 1
    for monomial, c in ring.terms(x.num):
        s, c = _multiple(ring, kind, monomial, Fraction(c, x.den))
        S, C = S * c + C * s, C * c + sign * (S * s)
    ring.cache[key] = S, C
    return S, C


def _multiple(ring: Any, kind: str, monomial: Any, q: Fraction) -> tuple[Any, Any]:
    """Sine and cosine of q times a monomial."""
    if q < 0:
        s, c = _multiple(ring, kind, monomial, -q)
        return -s, c
    g = ring.generators[monomial[0][0]] if len(monomial) == 1 and monomial[0][1] == 1 else None
    if kind == "sin" and g is not None and g.atom is sympy.pi:
        return _of_pi(ring, monomial, q % 2)
    if kind == "sin" and g is not None and q.denominator == 1 and q <= LARGEST_MULTIPLE:
        pair = _of_inverse_function(ring, g)
        if pair is not None:
            return _times(kind, pair, int(q))
    key, atom, n = _fraction(ring, kind, monomial, q)
    table = ring.cache.setdefault(("multiples", key), [(0, 1), atom])
    while len(table) <= n:
        table.append(_sum(kind, table[-1], atom))
    return table[n]


def _sum(kind: str, a: tuple[Any, Any], b: tuple[Any, Any]) -> tuple[Any, Any]:
    sign = -1 if kind == "sin" else 1
    return a[0] * b[1] + a[1] * b[0], a[1] * b[1] + sign * (a[0] * b[0])


def _times(kind: str, pair: tuple[Any, Any], n: int) -> tuple[Any, Any]:
    result: tuple[Any, Any] = (0, 1)
    for _ in range(n):
        result = _sum(kind, result, pair)
    return result


def _fraction(ring: Any, kind: str, monomial: Any, q: Fraction) -> tuple[Any, tuple[Any, Any], int]:
    """The atom pair of monomial/d and n with q = n/d; d grows when a new fraction is asked for."""
    chain = ring.cache.setdefault(("fractions", kind, monomial), [])
    n, d = q.numerator, q.denominator
    for known, pair in chain:
        if known % d == 0 and n * (known // d) <= LARGEST_MULTIPLE:
            return (kind, monomial, known), pair, n * (known // d)
    finest = chain[-1][0] if chain else 1
    common = lcm(finest, d) if chain else d
    if common // finest > LARGEST_MULTIPLE and chain or n * (common // d) > LARGEST_MULTIPLE:
        key = (kind, monomial, q)  # an atom of its own, not related to the others
        if key not in ring.cache:
            ring.cache[key] = _atoms(ring, kind, _monomial(ring, monomial) * q, None, 1)
        return key, ring.cache[key], 1
    pair = _atoms(
        ring,
        kind,
        _monomial(ring, monomial) * Fraction(1, common),
        chain[-1][1] if chain else None,
        common // finest,
    )
    chain.append((common, pair))
    return (kind, monomial, common), pair, n * (common // d)


def _atoms(ring: Any, kind: str, angle: Any, coarser: tuple[Any, Any] | None, k: int) -> tuple[Any, Any]:
    """New generators for sine and cosine of ``angle``; ``coarser`` is the pair of k times it."""
    angle = ring.coerce(angle)
    names = ("cos", "sin") if kind == "sin" else ("sinh", "cosh")  # the second leads the relation
    first = ring.new(names[0], (names[0], angle), arguments=(angle,))
    second = ring.new(names[1], (names[1], angle), arguments=(angle,), partner=first.index)
    first.partner = second.index
    a, b = ring.variable(first.index), ring.variable(second.index)
    (cosine, sine) = (a, b) if kind == "sin" else (b, a)
    if kind == "sin":
        square = b.num * b.num + a.num * a.num - 1  # sin² + cos² = 1
    else:
        square = b.num * b.num - a.num * a.num - 1  # cosh² = 1 + sinh²
        second.positive = True
    if coarser is None:
        ring.relations.add_square(1 << second.index, square)
        return sine, cosine
    # (c + i s)^k = C + i S in the new generators, before any relation
    sign = -1 if kind == "sin" else 1
    S, C = sine.num * 0, cosine.num * 0 + 1
    for _ in range(k):
        S, C = S * cosine.num + C * sine.num, C * cosine.num + sign * (S * sine.num)
    coarse = [ring.coerce(x) for x in coarser]
    relations = [
        square,
        S * coarse[0].den - ring.promoted(coarse[0].num),
        C * coarse[1].den - ring.promoted(coarse[1].num),
    ]
    ring.relations.add_general(relations, 1 << first.index | 1 << second.index)
    return ring.reduced(sine), ring.reduced(cosine)


def _of_pi(ring: Any, monomial: Any, q: Fraction) -> tuple[Any, Any]:
    """Sine and cosine of q π, 0 <= q < 2; exact for multiples of π/12."""
    quarter, rest = divmod(q * 2, 1)
    rest = rest / 2
    pair: tuple[Any, Any]
    if rest == 0:
        pair = (0, 1)
    elif (rest * 12).denominator == 1:
        angle = sympy.pi * sympy.Rational(rest.numerator, rest.denominator)
        pair = (ring.from_sympy(sympy.sin(angle)), ring.from_sympy(sympy.cos(angle)))
    else:
        key, atom, n = _fraction(ring, "sin", monomial, rest)
        pair = _times("sin", atom, n)
    for _ in range(int(quarter)):
        pair = (pair[1], -pair[0])
    return pair


def _of_inverse_function(ring: Any, g: Any) -> tuple[Any, Any] | None:
    if g.name == "asin":
        return g.arguments[0], _square_root(ring, ring.coerce(1 - g.arguments[0] * g.arguments[0]))
    if g.name == "acos":
        return _square_root(ring, ring.coerce(1 - g.arguments[0] * g.arguments[0])), g.arguments[0]
    if g.name in ("atan", "atan2"):
        y, x = g.arguments if g.name == "atan2" else (g.arguments[0], ring.one)
        r = _square_root(ring, ring.coerce(x * x + y * y))
        return _divide(ring, y, r), _divide(ring, x, r)
    return None


# ---------------------------------------------------------------------- powers and roots
def _exponential(ring: Any, x: Polynomial) -> Any:
    result: Any = 1
    for monomial, c in ring.terms(x.num):
        q = Fraction(c, x.den)
        g = ring.generators[monomial[0][0]] if len(monomial) == 1 and monomial[0][1] == 1 else None
        if g is not None and g.name == "log" and q.denominator == 1:  # exp(n log y) = yⁿ
            power = g.arguments[0] ** abs(int(q))
        else:
            base, n = _exponential_atom(ring, monomial, abs(q))
            power = base**n
        result = result * power if q > 0 else _divide(ring, result, power)
    return result


def _exponential_atom(ring: Any, monomial: Any, q: Fraction) -> tuple[Any, int]:
    chain = ring.cache.setdefault(("fractions", "exp", monomial), [])
    n, d = q.numerator, q.denominator
    for known, atom in chain:
        if known % d == 0:
            return atom, n * (known // d)
    finest = chain[-1][0] if chain else 1
    common = lcm(finest, d)
    if not monomial and common == 1:
        atom = ring.constant("E")
        ring.find(sympy.E).positive = True
    else:
        argument = ring.coerce(_monomial(ring, monomial) * Fraction(1, common))
        g = ring.new("function", ("exp", argument), name="exp", arguments=(argument,), positive=True)
        atom = ring.variable(g.index)
        if chain:  # exp(x/k)^k = exp(x)
            relation = atom.num ** (common // finest) - ring.promoted(chain[-1][1].num)
            ring.relations.add_general([relation], 1 << g.index)
    chain.append((common, atom))
    return atom, n * (common // d)


def _power(ring: Any, x: Polynomial, y: Polynomial) -> Any:
    if y.is_number:
        n = Fraction(y.number())
        if n.denominator <= 2:
            base = x if n.denominator == 1 else _square_root(ring, x)
            power = ring.coerce(base) ** abs(n.numerator)
            return power if n >= 0 else _divide(ring, 1, power)
    if x.is_number and x.number() == 1:
        return 1
    return _opaque(ring, "pow", [x, y])


def _square_root(ring: Any, x: Polynomial) -> Any:
    """√x with squares taken out: √(12 m²) = 2√3 m for a positive m, 2√3 |m| otherwise."""
    if not x:
        return 0
    outside: Any = 1
    x, divisor = _cleared(ring, x, even=True)  # √(N/d²ⁿ) = √N/|d|ⁿ
    # √(N/D) = √(N D)/D
    outside = Fraction(1, x.den)
    constant, factors = (x.num * x.den).factor()
    constant = int(constant)
    radicand: Any = 1 if constant > 0 else -1
    for p, n in factors:
        n = int(n)
        known = is_positive(ring, p)
        if not known and is_positive(ring, -p):
            p, known = -p, True
            radicand = radicand * (-1) ** n
        f = element(ring, p, 1, ring.support(p))
        if n >= 2:
            outside = outside * (f if known or (n // 2) % 2 == 0 else _absolute(ring, f)) ** (n // 2)
        if n % 2:
            if known:
                outside = outside * _root_generator(ring, f)
            else:
                radicand = radicand * f
    for prime, n in fmpz(abs(constant)).factor():
        outside = outside * int(prime) ** (int(n) // 2)
        if int(n) % 2:
            outside = outside * _root_generator(ring, ring.constant(int(prime)))
    if type(radicand) is Polynomial:
        outside = outside * _root_generator(ring, radicand)
    elif radicand < 0:
        raise ExpressionError(f"Expected a radicand that can be positive, got sqrt({x}).")
    for d, n in divisor:
        outside = _divide(ring, outside, (d if is_positive(ring, d.num) else _absolute(ring, d)) ** n)
    return outside


def _root_generator(ring: Any, radicand: Polynomial) -> Polynomial:
    key = ("sqrt", radicand)
    g = ring.find(key)
    if g is None:
        g = ring.new("sqrt", key, arguments=(radicand,), positive=True)
        r = ring.variable(g.index)
        ring.relations.add_square(1 << g.index, r.num * r.num - ring.promoted(radicand.num))
    return ring.variable(g.index)


def _cleared(ring: Any, x: Polynomial, even: bool) -> tuple[Polynomial, list[tuple[Polynomial, int]]]:
    """x times powers of what its inverse generators stand for, and these powers (halved if even)."""
    divisor: list[tuple[Polynomial, int]] = []
    for _ in range(len(ring.generators)):
        inverses = [g for g in ring.used(x) if g.kind == "inverse"]
        if not inverses:
            break
        i = inverses[-1].index
        n = int(x.num.degrees()[-1 - i])
        n = (n + 1) // 2 if even else n
        d = inverses[-1].arguments[0]
        divisor.append((d, n))
        x = ring.coerce(x * d ** (2 * n if even else n))
    return x, divisor


def _absolute(ring: Any, x: Polynomial) -> Any:
    if x.is_number:
        return abs(x.number())
    x, divisor = _cleared(ring, x, even=False)
    constant, factors = x.num.factor() if not x.is_number else (x.number(), [])
    result: Any = abs(Fraction(int(constant), x.den)) if factors else abs(x.number())
    for p, n in factors:
        f = element(ring, p, 1, ring.support(p))
        n = int(n)
        if n % 2 == 0 or is_positive(ring, p):
            result = result * f**n
            continue
        if is_positive(ring, -p):
            result = result * (-f) ** n
            continue
        result = result * f ** (n - 1) * _absolute_generator(ring, f)
    for d, n in divisor:
        result = _divide(ring, result, _absolute(ring, d) ** n)
    return result.numerator if isinstance(result, Fraction) and result.denominator == 1 else result


def _absolute_generator(ring: Any, f: Polynomial) -> Polynomial:
    if f.num.leading_coefficient() < 0:
        f = -f
    key = ("abs", f)
    g = ring.find(key)
    if g is None:
        square = ring.coerce(f * f)
        g = ring.new("function", key, name="abs", arguments=(f,), positive=True)
        r = ring.variable(g.index)
        if square.den == 1:  # |f|² = f²
            ring.relations.add_square(1 << g.index, r.num * r.num - ring.promoted(square.num))
    return ring.variable(g.index)


def _sign(ring: Any, x: Polynomial) -> Any:
    x = ring.coerce(x * x.den)
    x = ring.coerce(x / int(x.num.content()))
    if is_positive(ring, x.num) or is_positive(ring, -x.num):
        return 1 if is_positive(ring, x.num) else -1
    return _opaque(ring, "sign", [x])


# ---------------------------------------------------------------------- the rest
def _opaque(ring: Any, name: str, arguments: list[Polynomial]) -> Polynomial:
    key = (name, *arguments)
    g = ring.find(key)
    if g is None:
        g = ring.new("function", key, name=name, arguments=tuple(arguments))
    return ring.variable(g.index)


_SYMPY = {
    "asin": sympy.asin, "acos": sympy.acos, "atan": sympy.atan, "atan2": sympy.atan2, "log": sympy.log,
    "sign": sympy.sign, "min": sympy.Min, "max": sympy.Max,
}  # fmt: skip


def _of_numbers(ring: Any, name: str, numbers: list[Any]) -> Any:
    """A function of rational numbers: exact where SymPy knows it, else one opaque generator."""
    value = _SYMPY[name](*(sympy.Rational(n.numerator, n.denominator) for n in numbers))
    if value.is_real is False or value.has(sympy.I, sympy.nan, sympy.zoo, sympy.oo):
        raise ExpressionError(f"Expected arguments where {name} is real, got {', '.join(map(str, numbers))}.")
    if value.has(_SYMPY[name]):
        return _opaque(ring, name, [ring.constant(n) for n in numbers])
    return ring.from_sympy(value)
