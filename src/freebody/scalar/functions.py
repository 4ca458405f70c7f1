"""Functions of canonical polynomials, expanded where a canonical expansion exists and opaque otherwise.

- sine and cosine (and sinh, cosh) of a sum by the addition theorems; the atoms are sines and
  cosines of one monomial each, over a common denominator when fractions of it occur;
- exp of a sum as a product; √ by irreducible factors; abs likewise;
- everything else becomes one generator per function and canonical arguments.
"""

from __future__ import annotations

from fractions import Fraction
from math import lcm
from typing import Any

import sympy

from ..errors import ExpressionError
from .angles import sine_and_cosine
from .element import Polynomial
from .roots import absolute, divide, is_positive, monomial_of, square_root

UNKNOWN = sympy.Dummy("z", real=True)
"""The unknown of the functions whose roots are generators."""

_ODD = ("asin", "atan", "sign")


def apply(ring: Any, name: str, arguments: list[Polynomial]) -> Any:
    """Value of a function at elements of one ring."""
    expected = 2 if name in ("atan2", "pow") else None if name in ("min", "max") else 1
    if expected is not None and len(arguments) != expected:
        raise ExpressionError(
            f"Expected {expected} argument{'s' * (expected > 1)} of {name}, got {len(arguments)}."
        )
    x = arguments[0]
    if name in ("sin", "cos"):
        return sine_and_cosine(ring, "sin", x)[name == "cos"]
    if name == "tan":
        s, c = sine_and_cosine(ring, "sin", x)
        return divide(ring, s, c)
    if name in ("sinh", "cosh"):
        return sine_and_cosine(ring, "sinh", x)[name == "cosh"]
    if name == "tanh":
        s, c = sine_and_cosine(ring, "sinh", x)
        return divide(ring, s, c)
    if name == "exp":
        return _exponential(ring, x)
    if name == "sqrt":
        return square_root(ring, x)
    if name == "abs":
        return absolute(ring, x)
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


def derivative_of_root(ring: Any, g: Any, atom: Any) -> Any:
    """∂x/∂atom = -(∂f/∂atom)/f' of a generator that is the root x of f(x, atoms)."""
    of_unknown = sympy.sympify(ring.to_sympy(ring.derivative(g.root.function, atom)))
    return divide(ring, -ring.from_sympy(of_unknown.xreplace({UNKNOWN: g.atom})), g.root.slope_there)


def derivative(ring: Any, g: Any, atom: Any) -> Any:
    """∂g/∂atom of a derived generator."""
    d = [ring.derivative(a, atom) for a in g.arguments]
    itself = ring.variable(g.index)
    if g.kind == "inverse":  # (1/p)' = -p'/p²
        return -itself * itself * d[0]
    if g.kind == "sqrt":  # (√P)' = P'/(2√P) = P'√P/(2P)
        return divide(ring, itself * d[0], 2 * g.arguments[0])
    if g.kind in ("sin", "sinh", "cosh"):
        return ring.variable(g.partner) * d[0]
    if g.kind == "cos":
        return -ring.variable(g.partner) * d[0]
    if g.name == "exp":
        return itself * d[0]
    if g.name in ("min", "max"):  # either the last argument or the extreme of the rest decides
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
        result = divide(ring, itself * y * d[0], x) if d[0] != 0 else 0
        return result + (itself * apply(ring, "log", [x]) * d[1] if d[1] != 0 else 0)
    if g.name == "atan2":
        y, x = g.arguments
        return divide(ring, x * d[0] - y * d[1], x * x + y * y)
    x = g.arguments[0]
    if g.name == "abs":  # |x|' = x x'/|x|, the form in which the direction of a force along x is written
        return divide(ring, x * d[0], itself)
    if g.name == "log":
        return divide(ring, d[0], x)
    if g.name == "atan":
        return divide(ring, d[0], 1 + x * x)
    if g.name in ("asin", "acos"):
        rate = divide(ring, d[0], square_root(ring, ring.coerce(1 - x * x)))
        return rate if g.name == "asin" else -rate
    raise AssertionError(g.name)


def _exponential(ring: Any, x: Polynomial) -> Any:
    """exp(x) as a product over the terms of x."""
    result: Any = 1
    for monomial, c in ring.terms(x.num):
        q = Fraction(c, x.den)
        g = ring.generators[monomial[0][0]] if len(monomial) == 1 and monomial[0][1] == 1 else None
        if g is not None and g.name == "log" and q.denominator == 1:  # exp(n log y) = yⁿ
            power = g.arguments[0] ** abs(int(q))
        else:
            base, n = _exponential_atom(ring, monomial, abs(q))
            power = base**n
        result = result * power if q > 0 else divide(ring, result, power)
    return result


def _exponential_atom(ring: Any, monomial: Any, q: Fraction) -> tuple[Any, int]:
    """The atom exp(monomial/d) and n with q = n/d; d grows when a new fraction occurs."""
    chain = ring.cache.setdefault(("fractions", "exp", monomial), [])
    n, d = q.numerator, q.denominator
    for level, atom in chain:
        if level % d == 0:
            return atom, n * (level // d)
    finest = chain[-1][0] if chain else 1
    common = lcm(finest, d)
    if not monomial and common == 1:
        atom = ring.constant("E")
        ring.find(sympy.E).positive = True
    else:
        argument = ring.coerce(monomial_of(ring, monomial) * Fraction(1, common))
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
            base = x if n.denominator == 1 else square_root(ring, x)
            power = ring.coerce(base) ** abs(n.numerator)
            return power if n >= 0 else divide(ring, 1, power)
    if x.is_number and x.number() == 1:
        return 1
    return _opaque(ring, "pow", [x, y])


def _sign(ring: Any, x: Polynomial) -> Any:
    x = ring.coerce(x * x.den)
    x = ring.coerce(x / int(x.num.content()))
    if is_positive(ring, x.num) or is_positive(ring, -x.num):
        return 1 if is_positive(ring, x.num) else -1
    return _opaque(ring, "sign", [x])


def _opaque(ring: Any, name: str, arguments: list[Polynomial]) -> Polynomial:
    """The generator for a function that is not expanded."""
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
    """Function of rational numbers: exact if SymPy knows the value, else one opaque generator."""
    value = _SYMPY[name](*(sympy.Rational(n.numerator, n.denominator) for n in numbers))
    if value.is_real is False or value.has(sympy.I, sympy.nan, sympy.zoo, sympy.oo):
        raise ExpressionError(f"Expected arguments where {name} is real, got {', '.join(map(str, numbers))}.")
    if value.has(_SYMPY[name]):
        return _opaque(ring, name, [ring.constant(n) for n in numbers])
    return ring.from_sympy(value)
