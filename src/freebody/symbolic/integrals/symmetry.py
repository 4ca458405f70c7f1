"""Virtual motions in which the whole machine moves as one rigid body.

A rigid motion (w, v), the rates of turning and of the point at the ground's origin, is one of the machine's own if
the joints on the ground allow it while all other joints stand still:

    Σ ξ_j (motion of the body per unit of speed j) = (w, v + w × p),       Σ ξ_j ∂y/∂q_j = 0 elsewhere.

Its components ξ_j are the multipliers of the equations of motion in the balance of momentum along (w, v).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Any

from ...dynamics.kinematics import link_postures, motions
from ...dynamics.state import State
from ...model.model import GROUND, Model
from ...scalar.algebra import Vector, add, apply, apply_transpose, cross, divide, subtract
from ..derivation.determinant import determinant

Row = tuple[dict[int, Any], Any]
"""Σ coefficient_j ξ_j = right side."""


def rigid_motion(
    model: Model, state: State, w: Vector, v: Vector, at: Callable[[Any], Any] | None = None
) -> tuple[Any, ...] | None:
    """Components ξ of the rigid motion with rate of turning w and velocity v at the ground's origin, ground axes.

    None where a joint does not allow it. ``at`` gives the number of a scalar at some state, to refuse early.
    """
    rows: list[Row] = []
    fixed: dict[int, Any] = {}
    postures = link_postures(model, state)
    for joint in model.joints.values():
        first, last = joint.links[0], joint.links[-1]
        if model.links[first].parent != GROUND:
            for i in joint.links:
                _at_rest(model, state, i, rows, fixed)
            continue
        p = postures[last].position
        target = add(v, cross(w, p))
        link = model.links[last]
        if link.kind in ("ball", "free"):
            R = postures[last].rotation
            fixed.update({link.u + k: x for k, x in enumerate(apply_transpose(R, w))})
            if link.kind == "free":
                fixed.update({link.u + 3 + k: x for k, x in enumerate(apply_transpose(R, target))})
            elif any(x != 0 for x in target):
                return None
            continue
        columns: dict[int, list[Any]] = {}
        for i in joint.links:
            R = postures[i].rotation
            for j, factor, (a, b) in motions(model, state, i):
                w_N = apply(R, a)
                v_N = add(apply(R, b), cross(w_N, subtract(p, postures[i].position)))
                column = columns.setdefault(j, [0] * 6)
                columns[j] = [x + factor * y for x, y in zip(column, (*w_N, *v_N), strict=True)]
        for k, right in enumerate((*w, *target)):
            rows.append(({j: c[k] for j, c in columns.items() if c[k] != 0}, right))
    return solved(model.n_u, rows, fixed, at)


def _at_rest(model: Model, state: State, i: int, rows: list[Row], fixed: dict[int, Any]) -> None:
    link = model.links[i]
    if link.u >= 0:
        fixed.update({link.u + k: 0 for k in range(6 if link.kind == "free" else 3)})
    elif link.one_dof and not link.driven:
        rows.append(({j: state(partial) for j, partial in link.partials}, 0))


def solved(
    n: int, rows: Sequence[Row], fixed: dict[int, Any], at: Callable[[Any], Any] | None = None
) -> tuple[Any, ...] | None:
    """The solution of linear equations for n unknowns, exact; None if there is none or it is not unique."""
    known = dict(fixed)
    left = list(rows)
    # equations with a plain number in front of an unknown first: they need no division
    while True:
        left = [_reduced(row, known) for row in left]
        if any(not row and right != 0 for row, right in left):
            return None
        left = [(row, right) for row, right in left if row]
        single = next(((row, right) for row, right in left if len(row) == 1), None)
        if single is None:
            break
        ((j, c),) = single[0].items()
        known[j] = divide(single[1], c) if not isinstance(c, int) or c != 1 else single[1]
    unknown = sorted({j for row, _ in left for j in row})
    if unknown:
        if at is not None and not _consistent(left, unknown, at):
            return None
        found = _cramer(left, unknown)
        if found is None:
            return None
        known.update(found)
        if any(row or right != 0 for row, right in (_reduced(row, known) for row in left)):
            return None
    return tuple(known[j] for j in range(n)) if len(known) == n else None


def _consistent(rows: Sequence[Row], unknown: Sequence[int], at: Callable[[Any], Any]) -> bool:
    """Whether the equations have a solution in numbers, to round-off: divisions of polynomials are dear."""
    import numpy as np

    A = np.array([[float(at(row.get(j, 0))) for j in unknown] for row, _ in rows])
    b = np.array([float(at(right)) for _, right in rows])
    if not (np.isfinite(A).all() and np.isfinite(b).all()):
        return True
    x = np.linalg.lstsq(A, b, rcond=None)[0]
    return bool(np.linalg.norm(A @ x - b) <= np.sqrt(np.finfo(float).eps) * (1 + np.linalg.norm(b)))


def _reduced(row: Row, known: dict[int, Any]) -> Row:
    coefficients, right = row
    rest = {}
    for j, c in coefficients.items():
        if j in known:
            right = right - c * known[j]
        elif c != 0:
            rest[j] = c
    return rest, right


def _cramer(rows: Sequence[Row], unknown: Sequence[int]) -> dict[int, Any] | None:
    """By determinants of the first equations that are independent: one division per unknown."""
    n = len(unknown)
    if n > 6:
        return None
    chosen: list[Row] = []
    for row in rows:
        trial = [*chosen, row]
        if _independent(trial, unknown):
            chosen = trial
        if len(chosen) == n:
            break
    if len(chosen) < n:
        return None
    A = [[row.get(j, 0) for j in unknown] for row, _ in chosen]
    det = determinant(A)
    result = {}
    for k, j in enumerate(unknown):
        replaced = [[*a[:k], right, *a[k + 1 :]] for a, (_, right) in zip(A, chosen, strict=True)]
        result[j] = divide(determinant(replaced), det)
    return result


def _independent(rows: Sequence[Row], unknown: Sequence[int]) -> bool:
    A = [[row.get(j, 0) for j in unknown] for row, _ in rows]
    return any(
        determinant([[a[k] for k in columns] for a in A]) != 0
        for columns in combinations(range(len(unknown)), len(rows))
    )
