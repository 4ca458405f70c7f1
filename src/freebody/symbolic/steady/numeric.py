"""All roots of the conditions of steady motion in numbers.

One unknown: roots of a polynomial, in the unknown itself or in exp(i x) of an angle. Several: Newton's method from many
starts. Every root is refined by Newton's method with exact derivatives; its residual, relative to the size of the
terms, and the last step are reported.

A root is isolated, or open in some unknowns, which then may have any value, or one of a family of roots
(:mod:`freebody.symbolic.steady.family`), of which one is given for each connected piece.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from ...scalar.polynomial import Ring
from .conditions import EPS, Conditions, vanishes
from .factors import coefficients, factors
from .family import deficiency, dimension, representatives

STARTS = 256


@dataclass(frozen=True)
class NumericRoot:
    """One root: values of the unknowns, relative residual, last Newton step, and what is free at it.

    ``open`` marks unknowns that may have any value, given as zero; ``family`` is the dimension of the family of roots
    in the other ones.
    """

    values: np.ndarray
    residual: float
    error: float
    open: np.ndarray
    family: int


def roots(
    ring: Ring, conditions: Sequence[Any], unknowns: Sequence[Any], given: Mapping[Any, Any],
    held: Sequence[Any] = (),
) -> list[NumericRoot]:  # fmt: skip
    """Every root found, and of a family one root of each connected piece. In a family ``held`` unknowns are constant.

    Raises
    ------
    Underdetermined
        Fewer conditions than unknowns on every branch.
    """
    known, n = set(unknowns), len(unknowns)
    conditions = [x for x in conditions if not _holds(ring, x, known, given)]
    if not conditions:  # all unknowns are open
        return [NumericRoot(np.zeros(n), float(0), float(0), np.ones(n, dtype=bool), 0)]
    choices = []
    for x in conditions:
        pieces = factors(ring, x, known)
        if pieces is None:
            return []
        if pieces:
            choices.append(pieces)
    # what a smaller set of factors allows, a larger one does not add to
    sets = sorted({frozenset(pieces) for pieces in product(*choices)}, key=len)
    branches = []
    for k, branch in enumerate(sets):
        if any(other < branch for other in sets[:k]):
            continue
        dead = [p for p in branch if not ring.atoms_of(p) & known]
        if all(vanishes(Conditions(ring, [p], [], given)) for p in dead):
            alive = (p for p in branch if ring.atoms_of(p) & known)
            branches.append(sorted(alive, key=lambda p: (len(p), str(p))))
    determined = [live for live in branches if len(live) >= len(unknowns)]
    if branches and not determined:
        raise Underdetermined
    # a branch that leaves unknowns open is one root, if each of its conditions has one unknown
    determined += [
        live
        for live in branches
        if live and live not in determined and all(len(ring.atoms_of(p) & known) == 1 for p in live)
    ]
    found: list[NumericRoot] = []
    for live in determined:
        for root in _of_branch(Conditions(ring, live, unknowns, given), held):
            if not any(_same(root.values, other.values) for other in found):
                found.append(root)
    return sorted(found, key=lambda root: tuple(root.values))


class Underdetermined(Exception):
    """Fewer conditions than unknowns."""


def _holds(ring: Ring, x: Any, known: set[Any], given: Mapping[Any, Any]) -> bool:
    """Whether a condition has a factor without unknowns that vanishes at what is given."""
    found = (f for f, _ in ring.factor(x)[1])
    return any(not ring.atoms_of(f) & known and vanishes(Conditions(ring, [f], [], given)) for f in found)


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    return bool((np.abs(a - b) <= np.sqrt(EPS) * (1 + np.abs(a))).all())


def _of_branch(one: Conditions, held: Sequence[Any]) -> list[NumericRoot]:
    constant = np.array([a in held for a in one.unknowns], dtype=bool)
    result: list[NumericRoot] = []
    for x in _starts(one, dict.fromkeys(range(len(one.pieces))), {}).T:
        x = one.newton(x[:, None], 8)[:, 0]
        if not np.isfinite(x).all():
            continue
        with np.errstate(all="ignore"):
            F, size, J = one.values(x), one.size(x), one.jacobian(x)
        if not (np.isfinite(F).all() and np.isfinite(J).all()):
            continue  # |y| has no slope at y = 0
        residual = float((np.abs(F) / np.maximum(size, EPS * EPS)).max(initial=0))
        if residual > 1024 * EPS:
            continue
        x = np.where(one.angles, np.pi - np.mod(np.pi - x, 2 * np.pi), x)
        step = float(np.abs(np.linalg.pinv(J) @ F).max(initial=0))
        free = _open(one, x)
        x = np.where(free, 0, x)
        rounded = np.where(np.abs(x) <= EPS * EPS, 0, x)  # Newton's method does not tell less from zero
        with np.errstate(all="ignore"):
            x = rounded if np.isfinite(one.jacobian(rounded)).all() else x
        if not any(_same(x, other.values) for other in result):
            result.append(NumericRoot(x, residual, step, free, deficiency(one, x, free | constant)))
    kept = [root for root in result if not root.family]
    for kernel in sorted({root.family for root in result} - {0}):
        some = [root for root in result if root.family == kernel]
        for k in representatives(one, [root.values for root in some], constant, kernel):
            root = some[k]
            kept.append(replace(root, family=dimension(one, root.values, root.open | constant)))
    return kept


def _starts(one: Conditions, left: dict[int, None], fixed: dict[Any, float]) -> np.ndarray:
    """Points (n, N) near all roots: conditions of one unknown first, the others from many starts."""
    ring = one.ring
    rest = [a for a in one.unknowns if a not in fixed]
    given = {**one.given, **fixed}
    if not rest or not left:
        return np.array([[fixed.get(a, 0)] for a in one.unknowns], dtype=float)
    for k in left:
        alone = [a for a in rest if a in ring.atoms_of(one.pieces[k])]
        if len(alone) != 1:
            continue
        values = _univariate(Conditions(ring, [one.pieces[k]], alone, given))
        if values is None:
            continue
        remaining = {i: None for i in left if i != k}
        columns = [_starts(one, remaining, {**fixed, alone[0]: float(x)}) for x in values[0]]
        return np.hstack(columns) if columns else np.zeros((len(one.unknowns), 0))
    part = Conditions(ring, [one.pieces[k] for k in left], rest, given)
    n = len(rest)
    random = np.random.default_rng(n)
    spread = random.uniform(-1, 1, (n, STARTS)) * np.power(float(10), random.uniform(-2, 2, (n, STARTS)))
    turned = random.uniform(-np.pi, np.pi, (n, STARTS))
    x = part.newton(np.where(part.angles[:, None], turned, spread))
    x = x[:, np.isfinite(x).all(axis=0)]
    x = np.where(part.angles[:, None], np.pi - np.mod(np.pi - x, 2 * np.pi), x)
    with np.errstate(all="ignore"):
        near = np.abs(part.values(x)).max(axis=0) <= np.cbrt(EPS) * (1 + np.abs(x).max(axis=0, initial=0))
    x = x[:, near]
    _, first = np.unique(np.round(x, 6), axis=1, return_index=True)
    rows = {a: row for a, row in zip(rest, x[:, np.sort(first)], strict=True)}
    count = len(first)
    return np.array([rows[a] if a in rows else np.full(count, fixed[a]) for a in one.unknowns])


def _open(one: Conditions, x: np.ndarray) -> np.ndarray:
    """Which unknowns may have any value at a root: azimuth of what hangs on the axis."""
    result = np.zeros(len(x), dtype=bool)
    for i in range(len(x)):
        moved = x.copy()
        moved[i] += 1
        result[i] = bool((np.abs(one.values(moved)) <= 1024 * EPS * one.size(moved)).all())
    return result


def _univariate(one: Conditions) -> np.ndarray | None:
    """Starts (1, N) that reach every root of a polynomial in the unknown, or in its sine and cosine."""
    ring, x = one.ring, one.pieces[0]
    if len(one.pieces) != 1:
        return None
    (atom,) = one.unknowns
    index = ring.find(atom).index  # type: ignore[union-attr]
    depending = [g for g in ring.used(x) if g.depends & 1 << index]
    if len(depending) == 1 and depending[0].index == index:
        c = coefficients(ring, x, index)
        table = [_number(ring, c.get(k, 0), one.given) for k in range(max(c), -1, -1)]
        found = np.roots(table)
        near = np.abs(found.imag) <= np.sqrt(EPS) * (np.abs(found) + np.abs(found).max(initial=0) * EPS)
        return found[near].real[None, :]
    if not one.angles[0]:
        return None
    first = depending[0]
    s, c_ = (first.index, first.partner) if first.kind == "sin" else (first.partner, first.index)
    degree = 0
    parts: dict[tuple[int, int], Any] = {}
    for power, rest in coefficients(ring, x, s).items():
        inner = coefficients(ring, ring.coerce(rest), c_)
        for other, value in inner.items():
            parts[power, other] = _number(ring, value, one.given)
            degree = max(degree, power + other)
    # sin = (z - 1/z)/(2i), cos = (z + 1/z)/2, times z^degree
    total = np.zeros(2 * degree + 1, dtype=complex)
    sine, cosine = np.array([1, 0, -1]) / complex(0, 2), np.array([1, 0, 1]) / 2
    for (i, j), value in parts.items():
        term = np.array([value], dtype=complex)
        for factor, times in ((sine, i), (cosine, j)):
            for _ in range(times):
                term = np.convolve(term, factor)
        missing = degree - i - j
        total[missing : len(total) - missing] += term
    found = np.roots(total)
    # double roots lie off the circle by the root of round-off; Newton decides
    near = np.abs(np.abs(found) - 1) <= 1 / np.float64(1024)
    return np.angle(found[near])[None, :]


def _number(ring: Ring, c: Any, given: Mapping[Any, Any]) -> float:
    """A coefficient, zero where only round-off is left of its terms: the degree is lower at such values."""
    part = Conditions(ring, [ring.coerce(c)], [], given)
    return float(0) if vanishes(part) else float(part.values(np.zeros((0,)))[0])
