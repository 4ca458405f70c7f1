"""Virtual motions in which the whole machine moves as one rigid body.

A rigid motion (w, v), with angular velocity w and velocity v at the ground's origin, is possible if the joints on the
ground allow it while all other joints are at rest:

    Σ ξ_j (motion of the body per unit of speed j) = (w, v + w × p),       Σ ξ_j ∂y/∂q_j = 0 elsewhere.

The components ξ_j are the multipliers of the equations of motion in the balance of momentum along (w, v).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Any

from ...dynamics.kinematics import link_postures, motions
from ...dynamics.state import State
from ...model.model import GROUND, Model
from ...scalar.algebra import Scalar, Vector, add, apply, apply_transpose, cross, divide, subtract
from ..derivation.determinant import determinant

Row = tuple[dict[int, Scalar], Scalar]
"""Σ coefficient_j ξ_j = right side."""


def rigid_motion(
    model: Model, state: State, w: Vector, v: Vector, at: Callable[[Scalar], Any] | None = None
) -> tuple[Scalar, ...] | None:
    """Components ξ of the rigid motion with angular velocity w and velocity v at the ground's origin, ground axes.

    None if a joint does not allow the motion. ``at`` evaluates a scalar at some state, for an early numerical check.
    """
    rows: list[Row] = []
    fixed: dict[int, Scalar] = {}
    postures = link_postures(model, state)
    for joint in model.joints.values():
        first, last = joint.links[0], joint.links[-1]
        if model.links[first].parent != GROUND:
            for i in joint.links:
                _add_rest(model, state, i, rows, fixed)
            continue
        p = postures[last].position
        target = add(v, cross(w, p))
        link = model.links[last]
        if link.own:
            R = postures[last].rotation
            fixed.update({link.u + k: x for k, x in enumerate(apply_transpose(R, w))})
            if link.flies:
                fixed.update({link.u + 3 + k: x for k, x in enumerate(apply_transpose(R, target))})
            elif any(x != 0 for x in target):
                return None
            continue
        columns: dict[int, list[Scalar]] = {}
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


def _add_rest(model: Model, state: State, i: int, rows: list[Row], fixed: dict[int, Scalar]) -> None:
    """Add the conditions that link i is at rest relative to its parent."""
    link = model.links[i]
    if link.u >= 0:
        fixed.update({link.u + k: 0 for k in range(link.n_speeds)})
    elif link.one_dof and not link.driven:
        rows.append(({j: state(partial) for j, partial in link.partials}, 0))


def solved(
    n: int, rows: Sequence[Row], fixed: dict[int, Scalar], at: Callable[[Scalar], Any] | None = None
) -> tuple[Scalar, ...] | None:
    """Return the exact solution of linear equations for n unknowns; None if there is none or it is not unique."""
    values = dict(fixed)
    remaining = list(rows)
    # equations with one unknown first: most need no division
    while True:
        remaining = [_reduced(row, values) for row in remaining]
        if any(not row and right != 0 for row, right in remaining):
            return None
        remaining = [(row, right) for row, right in remaining if row]
        single = next(((row, right) for row, right in remaining if len(row) == 1), None)
        if single is None:
            break
        ((j, c),) = single[0].items()
        values[j] = divide(single[1], c) if not isinstance(c, int) or c != 1 else single[1]
    unknowns = sorted({j for row, _ in remaining for j in row})
    if unknowns:
        if at is not None and not _is_consistent(remaining, unknowns, at):
            return None
        solution = _cramer(remaining, unknowns)
        if solution is None:
            return None
        values.update(solution)
        if any(row or right != 0 for row, right in (_reduced(row, values) for row in remaining)):
            return None
    return tuple(values[j] for j in range(n)) if len(values) == n else None


def _is_consistent(rows: Sequence[Row], unknowns: Sequence[int], at: Callable[[Scalar], Any]) -> bool:
    """True if the equations have a numerical solution, to round-off; divisions of polynomials are expensive."""
    import numpy as np

    A = np.array([[float(at(row.get(j, 0))) for j in unknowns] for row, _ in rows])
    b = np.array([float(at(right)) for _, right in rows])
    if not (np.isfinite(A).all() and np.isfinite(b).all()):
        return True
    x = np.linalg.lstsq(A, b, rcond=None)[0]
    return bool(np.linalg.norm(A @ x - b) <= np.sqrt(np.finfo(float).eps) * (1 + np.linalg.norm(b)))


def _reduced(row: Row, values: dict[int, Scalar]) -> Row:
    """Return an equation with the known values on the right side."""
    coefficients, right = row
    rest = {}
    for j, c in coefficients.items():
        if j in values:
            right = right - c * values[j]
        elif c != 0:
            rest[j] = c
    return rest, right


def _cramer(rows: Sequence[Row], unknowns: Sequence[int]) -> dict[int, Scalar] | None:
    """Solve the first independent equations by determinants, with one division per unknown; None if too few."""
    n = len(unknowns)
    if n > 6:
        return None
    chosen: list[Row] = []
    for row in rows:
        trial = [*chosen, row]
        if _are_independent(trial, unknowns):
            chosen = trial
        if len(chosen) == n:
            break
    if len(chosen) < n:
        return None
    A = [[row.get(j, 0) for j in unknowns] for row, _ in chosen]
    det = determinant(A)
    result = {}
    for k, j in enumerate(unknowns):
        replaced = [[*a[:k], right, *a[k + 1 :]] for a, (_, right) in zip(A, chosen, strict=True)]
        result[j] = divide(determinant(replaced), det)
    return result


def _are_independent(rows: Sequence[Row], unknowns: Sequence[int]) -> bool:
    A = [[row.get(j, 0) for j in unknowns] for row, _ in rows]
    return any(
        determinant([[a[k] for k in columns] for a in A]) != 0
        for columns in combinations(range(len(unknowns)), len(rows))
    )
