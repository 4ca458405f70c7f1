"""All roots of the conditions of steady motion in numbers.

With one unknown they are roots of a polynomial, in the unknown or in exp(i x) of an angle; with several unknowns,
Newton's method starts from many points. Newton's method with exact derivatives refines every root; its residual,
relative to the size of the terms, and its last step are reported.

A root is isolated, or some unknowns are open (they may have any value), or it is a member of a family of roots
(:mod:`freebody.symbolic.steady.family`), of which one root for each connected piece is given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from ...scalar.algebra import Scalar
from ...scalar.polynomial import Ring
from .conditions import EPS, Conditions, vanishes
from .factors import coefficients, factors
from .family import deficiency, dimension, representatives

STARTS = 256
"""Number of random starts."""


@dataclass(frozen=True)
class NumericRoot:
    """One root: values of the unknowns, relative residual, last Newton step, open unknowns and dimension of its family.

    ``open`` marks unknowns that may have any value; they are returned as zero. ``family`` is the dimension of the
    family of roots in the other unknowns.
    """

    values: np.ndarray
    residual: float
    error: float
    open: np.ndarray
    family: int


def roots(
    ring: Ring, conditions: Sequence[Scalar], unknowns: Sequence[Any], numbers: Mapping[Any, Any],
    fixed: Sequence[Any] = (),
) -> list[NumericRoot]:  # fmt: skip
    """Return all roots, and for a family one root of each connected piece.

    The ``fixed`` unknowns are constant along a family.

    Raises
    ------
    Underdetermined
        There are fewer conditions than unknowns on every branch.
    """
    atoms, n = set(unknowns), len(unknowns)
    conditions = [x for x in conditions if not _holds(ring, x, atoms, numbers)]
    if not conditions:  # all unknowns are open
        return [NumericRoot(np.zeros(n), float(0), float(0), np.ones(n, dtype=bool), 0)]
    choices = []
    for x in conditions:
        pieces = factors(ring, x, atoms)
        if pieces is None:
            return []
        if pieces:
            choices.append(pieces)
    # the roots of a larger set of factors are among those of a smaller one that it contains
    sets = sorted({frozenset(pieces) for pieces in product(*choices)}, key=len)
    branches = []
    for k, branch in enumerate(sets):
        if any(other < branch for other in sets[:k]):
            continue
        dead = [p for p in branch if not ring.atoms_of(p) & atoms]
        if all(vanishes(Conditions(ring, [p], [], numbers)) for p in dead):
            alive = (p for p in branch if ring.atoms_of(p) & atoms)
            branches.append(sorted(alive, key=lambda p: (len(p), str(p))))
    determined = [live for live in branches if len(live) >= len(unknowns)]
    if branches and not determined:
        raise Underdetermined
    # a branch that leaves unknowns open is one root, if each of its conditions has one unknown
    determined += [
        live
        for live in branches
        if live and live not in determined and all(len(ring.atoms_of(p) & atoms) == 1 for p in live)
    ]
    result: list[NumericRoot] = []
    for live in determined:
        for root in _branch_roots(Conditions(ring, live, unknowns, numbers), fixed):
            if not any(_same(root.values, other.values) for other in result):
                result.append(root)
    return sorted(result, key=lambda root: tuple(root.values))


class Underdetermined(Exception):
    """There are fewer conditions than unknowns."""


def _holds(ring: Ring, x: Scalar, unknowns: set[Any], numbers: Mapping[Any, Any]) -> bool:
    """Return True if a condition has a factor without unknowns that is zero at the given numbers."""
    candidates = (f for f, _ in ring.factor(x)[1])
    return any(
        not ring.atoms_of(f) & unknowns and vanishes(Conditions(ring, [f], [], numbers)) for f in candidates
    )


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    return bool((np.abs(a - b) <= np.sqrt(EPS) * (1 + np.abs(a))).all())


def _branch_roots(conditions: Conditions, fixed: Sequence[Any]) -> list[NumericRoot]:
    constant = np.array([a in fixed for a in conditions.unknowns], dtype=bool)
    result: list[NumericRoot] = []
    for x in _starts(conditions, dict.fromkeys(range(len(conditions.pieces))), {}).T:
        x = conditions.newton(x[:, None], 8)[:, 0]
        if not np.isfinite(x).all():
            continue
        with np.errstate(all="ignore"):
            F, size, J = conditions.values(x), conditions.size(x), conditions.jacobian(x)
        if not (np.isfinite(F).all() and np.isfinite(J).all()):
            continue  # |y| has no slope at y = 0
        residual = float((np.abs(F) / np.maximum(size, EPS * EPS)).max(initial=0))
        if residual > 1024 * EPS:
            continue
        x = np.where(conditions.angles, np.pi - np.mod(np.pi - x, 2 * np.pi), x)
        step = float(np.abs(np.linalg.pinv(J) @ F).max(initial=0))
        free = _open(conditions, x)
        x = np.where(free, 0, x)
        rounded = np.where(np.abs(x) <= EPS * EPS, 0, x)  # Newton's method cannot distinguish less from zero
        with np.errstate(all="ignore"):
            x = rounded if np.isfinite(conditions.jacobian(rounded)).all() else x
        if not any(_same(x, other.values) for other in result):
            result.append(NumericRoot(x, residual, step, free, deficiency(conditions, x, free | constant)))
    kept_roots = [root for root in result if not root.family]
    for kernel in sorted({root.family for root in result} - {0}):
        members = [root for root in result if root.family == kernel]
        for k in representatives(conditions, [root.values for root in members], constant, kernel):
            root = members[k]
            kept_roots.append(replace(root, family=dimension(conditions, root.values, root.open | constant)))
    return kept_roots


def _starts(conditions: Conditions, unused: dict[int, None], known: dict[Any, float]) -> np.ndarray:
    """Return points (n, N) near all roots: from conditions in one unknown first, then from many starts."""
    ring = conditions.ring
    open_unknowns = [a for a in conditions.unknowns if a not in known]
    numbers = {**conditions.numbers, **known}
    if not open_unknowns or not unused:
        return np.array([[known.get(a, 0)] for a in conditions.unknowns], dtype=float)
    for k in unused:
        single = [a for a in open_unknowns if a in ring.atoms_of(conditions.pieces[k])]
        if len(single) != 1:
            continue
        values = _univariate(Conditions(ring, [conditions.pieces[k]], single, numbers))
        if values is None:
            continue
        remaining = {i: None for i in unused if i != k}
        columns = [_starts(conditions, remaining, {**known, single[0]: float(x)}) for x in values[0]]
        return np.hstack(columns) if columns else np.zeros((len(conditions.unknowns), 0))
    part = Conditions(ring, [conditions.pieces[k] for k in unused], open_unknowns, numbers)
    n = len(open_unknowns)
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
    rows = {a: row for a, row in zip(open_unknowns, x[:, np.sort(first)], strict=True)}
    count = len(first)
    return np.array([rows[a] if a in rows else np.full(count, known[a]) for a in conditions.unknowns])


def _open(conditions: Conditions, x: np.ndarray) -> np.ndarray:
    """Mark the unknowns that may have any value at a root, such as the azimuth of a body on the axis."""
    result = np.zeros(len(x), dtype=bool)
    for i in range(len(x)):
        moved = x.copy()
        moved[i] += 1
        result[i] = bool((np.abs(conditions.values(moved)) <= 1024 * EPS * conditions.size(moved)).all())
    return result


def _univariate(conditions: Conditions) -> np.ndarray | None:
    """Return starts (1, N) near every root of a polynomial in the unknown or its sine and cosine; None for others."""
    ring, x = conditions.ring, conditions.pieces[0]
    if len(conditions.pieces) != 1:
        return None
    (atom,) = conditions.unknowns
    index = ring.find(atom).index  # type: ignore[union-attr]
    depending = [g for g in ring.used(x) if g.depends & 1 << index]
    if len(depending) == 1 and depending[0].index == index:
        c = coefficients(ring, x, index)
        table = [_number(ring, c.get(k, 0), conditions.numbers) for k in range(max(c), -1, -1)]
        roots_found = np.roots(table)
        near = np.abs(roots_found.imag) <= np.sqrt(EPS) * (
            np.abs(roots_found) + np.abs(roots_found).max(initial=0) * EPS
        )
        return roots_found[near].real[None, :]
    if not conditions.angles[0]:
        return None
    first = depending[0]
    s, c_ = (first.index, first.partner) if first.kind == "sin" else (first.partner, first.index)
    degree = 0
    parts: dict[tuple[int, int], Any] = {}
    for power, cofactor in coefficients(ring, x, s).items():
        inner = coefficients(ring, ring.coerce(cofactor), c_)
        for other, value in inner.items():
            parts[power, other] = _number(ring, value, conditions.numbers)
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
    roots_found = np.roots(total)
    # double roots lie off the circle by the square root of round-off; Newton's method decides
    near = np.abs(np.abs(roots_found) - 1) <= 1 / np.float64(1024)
    return np.angle(roots_found[near])[None, :]


def _number(ring: Ring, c: Scalar, numbers: Mapping[Any, Any]) -> float:
    """Return a coefficient, zero if its terms cancel up to round-off: the degree is then lower."""
    part = Conditions(ring, [ring.coerce(c)], [], numbers)
    return float(0) if vanishes(part) else float(part.values(np.zeros((0,)))[0])
