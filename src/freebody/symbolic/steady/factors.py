"""Factors, coefficients and numerators of canonical polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...scalar.algebra import divide
from ...scalar.polynomial import Polynomial, Ring
from ...scalar.roots import is_positive, monomial_of


def product(pieces: Sequence[Any]) -> Any:
    """Of all pieces."""
    total: Any = 1
    for piece in pieces:
        total = total * piece
    return total


def factors(ring: Ring, x: Any, unknowns: set[Any]) -> list[Any] | None:
    """Factors that may be zero; none for zero, None if the product can not be zero.

    Factors of parameters alone are taken as not zero, unless there are no others: then the product is a requirement.
    """
    if x == 0:
        return []
    if type(x) is not Polynomial:
        return None
    found = [
        f for f, _ in ring.factor(x)[1] if not is_positive(ring, f.num) and not is_positive(ring, -f.num)
    ]
    live = [f for f in found if ring.atoms_of(f) & unknowns]
    return live or ([product(found)] if found else None)


def excluded(ring: Ring, x: Any, unknowns: set[Any]) -> list[Any]:
    """Sums of parameters that :func:`factors` takes as not zero: where one is, its condition says nothing."""
    kept = factors(ring, x, unknowns)
    if not kept or not ring.atoms_of(kept[0]) & unknowns:
        return []
    rest = (f for f, _ in ring.factor(x)[1] if len(f) > 1 and not ring.atoms_of(f) & unknowns)
    return [f for f in rest if not is_positive(ring, f.num) and not is_positive(ring, -f.num)]


def sign_kept(ring: Ring, x: Any) -> Any:
    """x without factors that are known to be positive: of the same sign."""
    if type(x) is not Polynomial:
        return x
    content, found = ring.factor(x)
    result: Any = 1 if content > 0 else -1
    for f, n in found:
        if is_positive(ring, f.num):
            continue
        if is_positive(ring, -f.num):
            result = result * (-1) ** n
        elif n % 2:
            result = result * f
    return result


def coefficients(ring: Ring, x: Any, index: int) -> dict[int, Any]:
    """Of a polynomial in one generator, by power."""
    result: dict[int, Any] = {}
    for monomial, c in x.terms():
        power = next((e for i, e in monomial if i == index), 0)
        rest = monomial_of(ring, [(i, e) for i, e in monomial if i != index])
        result[power] = result.get(power, 0) + divide(c, x.den) * rest
    return {n: ring.reduced(ring.coerce(y)) for n, y in result.items() if y != 0}


def fraction(ring: Ring, x: Any) -> tuple[Any, Any]:
    """(N, D) without inverse generators, x = N / D."""
    D: Any = 1
    while type(x) is Polynomial:
        inverse = next((g for g in reversed(ring.used(x)) if g.kind == "inverse"), None)
        if inverse is None:
            break
        factor = inverse.arguments[0]
        x, D = x * factor, D * factor
    return x, D


def cleared(ring: Ring, x: Any) -> Any:
    """The numerator."""
    return fraction(ring, x)[0]
