"""Factors, coefficients and numerators of canonical polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...scalar.algebra import Scalar, divide
from ...scalar.polynomial import Polynomial, Ring
from ...scalar.roots import is_positive, monomial_of

ZERO_ONLY_AT_ZERO = frozenset({"abs", "sqrt", "sinh", "tanh", "asin", "atan"})
"""Functions that are zero where their argument is, and nowhere else."""


def product(pieces: Sequence[Scalar]) -> Scalar:
    """Return the product of all factors."""
    total: Scalar = 1
    for piece in pieces:
        total = total * piece
    return total


def factors(ring: Ring, x: Scalar, unknowns: set[Any]) -> list[Scalar] | None:
    """Return the factors that may be zero: [] for zero, None if the product cannot be zero.

    Factors of parameters alone count as not zero, unless there are no others: then their product is a requirement.
    """
    if x == 0:
        return []
    if type(x) is not Polynomial:
        return None
    candidates: list[Scalar] = []
    for f, _ in ring.factor(x)[1]:
        used = ring.used(f)
        if len(used) == len(f) == 1 and (used[0].name or used[0].kind) in ZERO_ONLY_AT_ZERO:
            candidates += factors(ring, used[0].arguments[0], unknowns) or []
        elif not is_positive(ring, f.num) and not is_positive(ring, -f.num):
            candidates.append(f)
    candidates = list(dict.fromkeys(candidates))
    live = [f for f in candidates if ring.atoms_of(f) & unknowns]
    return live or ([product(candidates)] if candidates else None)


def live_factors(ring: Ring, x: Scalar, unknowns: set[Any]) -> list[Scalar]:
    """Return the factors that may be zero; x itself where none may."""
    return factors(ring, x, unknowns) or [x]


def excluded(ring: Ring, x: Scalar, unknowns: set[Any]) -> list[Scalar]:
    """Return the sums of parameters that :func:`factors` takes as not zero; if one is, the condition holds anyway."""
    possible = factors(ring, x, unknowns)
    if not possible or not ring.atoms_of(possible[0]) & unknowns:
        return []
    of_parameters = (f for f, _ in ring.factor(x)[1] if len(f) > 1 and not ring.atoms_of(f) & unknowns)
    return [f for f in of_parameters if not is_positive(ring, f.num) and not is_positive(ring, -f.num)]


def signed_part(ring: Ring, x: Scalar) -> Scalar:
    """Return x without factors known to be positive; the sign is the same."""
    if type(x) is not Polynomial:
        return x
    content, factors_of_x = ring.factor(x)
    result: Scalar = 1 if content > 0 else -1
    for f, n in factors_of_x:
        if is_positive(ring, f.num):
            continue
        if is_positive(ring, -f.num):
            result = result * (-1) ** n
        elif n % 2:
            result = result * f
    return result


def coefficients(ring: Ring, x: Scalar, index: int) -> dict[int, Scalar]:
    """Return the coefficients of a polynomial in one generator, by power."""
    result: dict[int, Scalar] = {}
    for monomial, c in x.terms():
        power = next((e for i, e in monomial if i == index), 0)
        cofactor = monomial_of(ring, [(i, e) for i, e in monomial if i != index])
        result[power] = result.get(power, 0) + divide(c, x.den) * cofactor
    return {n: ring.reduced(ring.coerce(y)) for n, y in result.items() if y != 0}


def fraction(ring: Ring, x: Scalar) -> tuple[Scalar, Scalar]:
    """Return (N, D) without inverse generators, x = N / D."""
    D: Scalar = 1
    while type(x) is Polynomial:
        inverse = next((g for g in reversed(ring.used(x)) if g.kind == "inverse"), None)
        if inverse is None:
            break
        factor = inverse.arguments[0]
        x, D = x * factor, D * factor
    return x, D


def cleared(ring: Ring, x: Scalar) -> Scalar:
    """Return the numerator of x."""
    return fraction(ring, x)[0]
