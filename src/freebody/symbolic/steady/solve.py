"""Closed forms of the conditions of steady motion: factors, quadratics, angles from their cosine and sine.

A w² + B w + C = 0:    w = (-B ± sqrt(B² - 4 A C)) / (2 A)      exists for B² - 4 A C >= 0
                       w -> -B/A (fast), -C/B (slow)            for B² much larger than 4 A C
a sin(x) + b cos(x) + d = 0:   x = atan2(-a d ± b r, -b d ∓ a r),   r = sqrt(a² + b² - d²)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ...errors import ExpressionError
from ...scalar.algebra import Scalar, divide
from ...scalar.polynomial import Polynomial, Ring
from ...scalar.roots import is_positive
from ...scalar.substitute import Substitution
from .factors import cleared, coefficients, factors, fraction, product, signed_part


@dataclass(frozen=True)
class Root:
    """One canonical value of an unknown and the conditions under which it exists.

    ``exists`` are polynomials that must not be negative, ``positive`` polynomials that the label assumes positive,
    ``nonzero`` polynomials that must not be zero.
    """

    value: Scalar
    exists: tuple[Scalar, ...] = ()
    positive: tuple[Scalar, ...] = ()
    label: str = ""
    limit: Scalar = None
    nonzero: tuple[Scalar, ...] = ()


@dataclass(frozen=True)
class Solution:
    """A solution of the conditions: values by unknown, in closed form, and the remaining conditions."""

    values: dict[Any, Scalar] = field(default_factory=dict)
    exists: tuple[Scalar, ...] = ()
    positive: tuple[Scalar, ...] = ()
    nonzero: tuple[Scalar, ...] = ()
    labels: tuple[str, ...] = ()
    limits: dict[Any, Scalar] = field(default_factory=dict)
    remaining: tuple[Scalar, ...] = ()
    branch: tuple[Scalar, ...] = ()


def solutions(
    ring: Ring, conditions: Sequence[Scalar], unknowns: Sequence[Any], others: Sequence[Any]
) -> list[Solution]:
    """Return all solutions of the conditions for the ``unknowns``, one for each choice of factors.

    Factors without any of them are solved for one of the ``others``. A root of the numerators at which a condition has
    no value is none.
    """
    numerators = tuple(cleared(ring, x) for x in conditions)
    found = _solved(ring, numerators, tuple(unknowns), tuple(others), Solution())
    candidates = [solution for solution in found if _have_values(ring, conditions, solution)]
    return [
        solution
        for k, solution in enumerate(candidates)
        if not any(
            _covers(other, solution) and (j < k or not _covers(solution, other))
            for j, other in enumerate(candidates)
            if j != k
        )
    ]


def _have_values(ring: Ring, conditions: Sequence[Scalar], solution: Solution) -> bool:
    """Return True if no condition divides by zero at a solution."""
    put_in = Substitution(ring, ring, solution.values)
    try:
        for x in conditions:
            put_in(x)
    except ZeroDivisionError:
        return False
    return True


def _covers(general: Solution, special: Solution) -> bool:
    """Return True if ``special`` is ``general`` with more unknowns fixed."""
    return (
        not general.remaining
        and set(general.exists) <= set(special.exists)
        and all(a in special.values and special.values[a] == x for a, x in general.values.items())
    )


def _solved(
    ring: Ring,
    conditions: tuple[Scalar, ...],
    unknowns: tuple[Any, ...],
    others: tuple[Any, ...],
    solution: Solution,
) -> Iterator[Solution]:
    open_conditions = []
    atoms = set(unknowns) | set(others)
    for x in conditions:
        pieces = factors(ring, x, atoms)
        if pieces is None:
            return  # a nonzero number or a positive polynomial: no solution
        if pieces:
            open_conditions.append(pieces)
    if not open_conditions:
        yield solution
        return
    # the condition that splits into the simplest pieces first
    open_conditions.sort(
        key=lambda pieces: max(len(ring.atoms_of(p) & atoms) * 1000 + len(p) for p in pieces)
    )
    for piece in open_conditions[0]:
        later_conditions = tuple(product(pieces) for pieces in open_conditions[1:])
        atom, roots = _closed_form(ring, piece, unknowns, others)
        if atom is None:
            yield from _solved(
                ring,
                later_conditions,
                unknowns,
                others,
                replace(solution, remaining=(*solution.remaining, piece)),
            )
            continue
        for root in roots:
            put_in = Substitution(ring, ring, {atom: root.value})
            try:
                values = {a: put_in(x) for a, x in solution.values.items()} | {atom: root.value}
                step = Solution(
                    values=values,
                    exists=(*(put_in(x) for x in solution.exists), *root.exists),
                    positive=(*solution.positive, *root.positive),
                    nonzero=(*(put_in(x) for x in solution.nonzero), *root.nonzero),
                    labels=(*solution.labels, root.label) if root.label else solution.labels,
                    limits=solution.limits | ({atom: root.limit} if root.limit is not None else {}),
                    remaining=tuple(cleared(ring, put_in(x)) for x in solution.remaining),
                    branch=(*solution.branch, piece),
                )
                next_conditions = tuple(cleared(ring, put_in(x)) for x in later_conditions)
            except (ZeroDivisionError, ExpressionError):
                continue  # this root makes a divisor of an earlier value zero, or the value not real
            yield from _solved(
                ring,
                next_conditions,
                tuple(a for a in unknowns if a != atom),
                tuple(a for a in others if a != atom),
                step,
            )


def _closed_form(
    ring: Ring, x: Scalar, unknowns: Sequence[Any], others: Sequence[Any]
) -> tuple[Any, list[Root]]:
    """Return (unknown, its roots) of an irreducible polynomial; (None, []) if no unknown has a closed form."""
    present = ring.atoms_of(x)
    preferred = [a for a in unknowns if a in present]
    for atom in preferred or [a for a in others if a in present]:
        roots = roots_of(ring, x, atom)
        if roots is not None:
            return atom, roots
    return None, []


def roots_of(ring: Ring, x: Scalar, atom: Any) -> list[Root] | None:
    """Return the solutions of ``x = 0`` for one atom in closed form; None if there is no closed form."""
    g = ring.find(atom)
    assert g is not None
    bit = 1 << g.index
    depending = [generator for generator in ring.used(x) if generator.depends & bit]
    if len(depending) == 1 and depending[0].index == g.index:
        return _polynomial(ring, coefficients(ring, x, g.index))
    indices = {generator.index for generator in depending}
    first = depending[0]
    if first.kind not in ("sin", "cos") or not indices <= {first.index, first.partner}:
        return None
    argument = first.arguments[0]
    factor = divide(argument, ring.variable(g.index)) if argument != ring.variable(g.index) else 1
    if bit & ring.depends(factor):
        return None
    s, c = (first.index, first.partner) if first.kind == "sin" else (first.partner, first.index)
    roots = _angle(ring, x, s, c)
    if roots is None:
        return None
    return [replace(root, value=divide(root.value, factor)) for root in roots]


def _polynomial(ring: Ring, c: dict[int, Scalar]) -> list[Root] | None:
    degree = max(c)
    if degree == 1:
        return [Root(divide(-c.get(0, 0), c[1]), nonzero=_nonzero(ring, c[1]))]
    if degree == 2:
        return _quadratic(ring, c[2], c.get(1, 0), c.get(0, 0))
    if degree == 4 and not c.keys() & {1, 3}:
        result = []
        for root in _quadratic(ring, c[4], c.get(2, 0), c.get(0, 0)):
            result += _square_roots(ring, root)
        return result
    return None


def _quadratic(ring: Ring, A: Scalar, B: Scalar, C: Scalar) -> list[Root]:
    if B == 0:
        return _square_roots(ring, Root(divide(-C, A), nonzero=_nonzero(ring, A)))
    D = B * B - 4 * A * C
    if type(D) is not Polynomial and D < 0:
        return []
    exists = _not_negative(ring, D)
    r = ring.apply("sqrt", D) if type(D) is Polynomial or D != 0 else 0
    nonzero = _nonzero(ring, A)
    if r == 0:
        return [Root(divide(-B, 2 * A), nonzero=nonzero)]
    side = signed_part(ring, -B)
    if type(side) is Polynomial:
        # with the sign of its content, so that a leading letter, such as a spin, is assumed positive
        signed = 1 if ring.factor(side)[0] > 0 else -1
        positive: tuple[Scalar, ...] = (signed * side,)
    else:
        positive, signed = (), side  # the sign is known: the fast root has the sign of -B
    roots = []
    for label, sign, limit in (
        ("fast", signed, divide(-B, A)),
        ("slow", -signed, divide(-C, B) if C != 0 else 0),
    ):
        roots.append(Root(divide(-B + sign * r, 2 * A), exists, positive, label, limit, nonzero))
    return roots


def _square_roots(ring: Ring, square: Root) -> list[Root]:
    """Return ±√ of a value that must not be negative."""
    x = square.value
    if type(x) is not Polynomial:
        if x < 0:
            return []
        if x == 0:
            return [square]
    N, D = fraction(ring, x)
    exists = (*square.exists, *_not_negative(ring, N * D))
    # both signs are roots, so that no absolute value is needed
    r = divide(ring.apply("sqrt", N * D), D)
    return [replace(square, value=sign * r, exists=exists, label="", limit=None) for sign in (1, -1)]


def _nonzero(ring: Ring, x: Scalar) -> tuple[Scalar, ...]:
    """Return (x,) without its positive factors if it may be zero, else ()."""
    y = signed_part(ring, x)
    return (y,) if type(y) is Polynomial else ()


def _not_negative(ring: Ring, x: Scalar) -> tuple[Scalar, ...]:
    """Return (x,) without its positive factors if x >= 0 is a condition, else ()."""
    y = signed_part(ring, x)
    if type(y) is not Polynomial and y > 0:
        return ()
    return (y,) if y != 0 else ()


def _angle(ring: Ring, x: Scalar, s: int, c: int) -> list[Root] | None:
    """Return the roots of a polynomial in the sine ``s`` and cosine ``c`` of one angle."""
    has_sine = x.mask & 1 << s and any(i == s for m, _ in x.terms() for i, _ in m)
    has_cosine = any(i == c for m, _ in x.terms() for i, _ in m)
    pi = ring.constant("pi")
    if has_sine != has_cosine:
        values = _polynomial(ring, coefficients(ring, x, s if has_sine else c))
        if values is None:
            return None
        result = []
        for root in values:
            exists = _within_one(ring, root.value)
            if exists is None:
                continue
            angle = ring.apply("asin" if has_sine else "acos", root.value)
            other = pi - angle if has_sine else angle if angle == pi else -angle
            for value in dict.fromkeys((angle, other)):
                result.append(replace(root, value=value, exists=(*root.exists, *exists), limit=None))
        return result
    in_sine = coefficients(ring, x, s)
    if set(in_sine) - {0, 1} or any(i in (s, c) for m, _ in ring.coerce(in_sine[1]).terms() for i, _ in m):
        return None
    in_cosine = coefficients(ring, ring.coerce(in_sine.get(0, 0)), c)
    if set(in_cosine) - {0, 1}:
        return None
    a, b, d = in_sine[1], in_cosine.get(1, 0), in_cosine.get(0, 0)
    if d == 0:
        angle = ring.apply("atan", divide(-b, a))
        return [Root(angle, nonzero=_nonzero(ring, a)), Root(angle + pi, nonzero=_nonzero(ring, a))]
    square = a * a + b * b - d * d
    r = ring.apply("sqrt", square)
    exists = _not_negative(ring, square)
    return [
        Root(ring.apply("atan2", -a * d + sign * b * r, -b * d - sign * a * r), exists) for sign in (1, -1)
    ]


def _within_one(ring: Ring, x: Scalar) -> tuple[Scalar, ...] | None:
    """Return polynomials that must not be negative for |x| <= 1; None if |x| > 1 always."""
    if type(x) is not Polynomial:
        return () if abs(x) <= 1 else None
    N, D = fraction(ring, x)
    if type(D) is not Polynomial:
        D = ring.coerce(D)
    N, D = N * D.den, D * D.den
    if type(N) is Polynomial and is_positive(ring, D.num):
        if is_positive(ring, N.num):
            return _not_negative(ring, D - N)
        if is_positive(ring, -N.num):
            return _not_negative(ring, D + N)
    return _not_negative(ring, D * D - N * N)
