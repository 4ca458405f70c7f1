"""Values in place of atoms, through sines, roots and inverses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .algebra import divide
from .element import Polynomial


def substitute(x: Any, values: Mapping[Any, Any], ring: Any, memo: dict[int, Any] | None = None) -> Any:
    """An element with elements (or numbers) in place of SymPy atoms, canonical again.

    Parameters
    ----------
    x : Polynomial, int or Fraction
    values : mapping
        SymPy atom -> element of the ring, or number.
    ring : Ring
    memo : dict, optional
        Values of generators, kept between calls with the same ``values``.

    Raises
    ------
    ExpressionError
        A divisor becomes zero.

    Examples
    --------
    >>> import sympy
    >>> from freebody.scalar.polynomial import Ring
    >>> ring, theta, m = Ring(), sympy.Function("theta")(sympy.Symbol("t")), sympy.Symbol("m")
    >>> substitute(ring.from_sympy(sympy.cos(theta) + m * sympy.sin(theta) + theta), {theta: 0}, ring)
    1
    """
    memo = {} if memo is None else memo
    mask = 0
    for atom in values:
        g = ring.find(atom)
        if g is not None:
            mask |= 1 << g.index
            memo.setdefault(g.index, values[atom])
    return _substituted(x, mask, memo, ring) if mask else x


def _substituted(x: Any, mask: int, memo: dict[int, Any], ring: Any) -> Any:
    if type(x) is not Polynomial:
        return x
    touched = {g.index for g in ring.used(x) if g.depends & mask}
    if not touched:
        return x
    for index in sorted(touched):
        if index not in memo:
            memo[index] = _value(ring.generators[index], mask, memo, ring)
    parts: dict[tuple[tuple[int, int], ...], list[tuple[Any, int]]] = {}
    for monomial, c in ring.terms(ring.promoted(x.num)):
        key = tuple(f for f in monomial if f[0] in touched)
        parts.setdefault(key, []).append((tuple(f for f in monomial if f[0] not in touched), c))
    total: Any = 0
    for key, terms in parts.items():
        factor: Any = 1
        for index, n in key:
            factor = factor * memo[index] ** n
        if factor == 0:
            continue
        rest: Any = 0
        for monomial, c in terms:
            term: Any = c
            for index, n in monomial:
                term = term * ring.variable(index) ** n
            rest = rest + term
        total = total + rest * factor
    return divide(total, x.den)


def _value(g: Any, mask: int, memo: dict[int, Any], ring: Any) -> Any:
    arguments = [_substituted(a, mask, memo, ring) for a in g.arguments]
    if g.kind == "inverse":
        return ring.quotient(ring.one, ring.coerce(arguments[0]))
    return ring.apply(g.name or g.kind, *arguments)
