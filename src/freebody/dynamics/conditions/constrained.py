"""Motion under constraints: accelerations and multipliers together.

    M u' = f + Gᵀ λ,   G u' = -γ      =>      (G M⁻¹ Gᵀ) λ = -γ - G M⁻¹ f

Both matrices are symmetric positive definite if dependent conditions are left out (:func:`independent_rows`).

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), §8.5 (method 2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
import sympy

from ...describe.constraints.constraint import Condition, Gear, Rope, SpeedCondition
from ...describe.names import TIME
from ...errors import ModelError
from ...model.closure import Closure
from ...model.contact_modes import Touching
from ...model.model import GROUND, Model
from ...scalar.algebra import Scalar, Vector, apply_transpose, cross, divide, scale, subtract
from ...scalar.expression import exact
from ...space.spatial import plus
from ..composite import mass_diagonal, mass_matrix
from ..kinematics import coordinate_rates, link_postures, place_of, point_position
from ..linear import (
    Elimination,
    Factorization,
    Selection,
    applied,
    combined,
    entries,
    products,
    scalar_product,
)
from ..loads.actions import accelerating, scaled
from ..loads.loading import Loading, act, loading
from ..newton_euler import bias
from ..state import State, float_state
from .constraint_forces import (
    Action,
    closed_forces,
    friction_along_tangents,
    separating_force,
    torques,
    wrenches,
)
from .constraints import residuals, rows
from .contact import rows_of
from .linearized import linearized
from .loops import articulated_masses, loop_motion, own_speeds
from .mobility import check_mobility


def constrained_dynamics(
    model: Model, state: State, active: Sequence[int], forces: Sequence[Scalar] | None = None
) -> tuple[tuple[Scalar, ...], tuple[Scalar, ...]]:
    """Return the accelerations u' and the multipliers λ, which are zero for all but the ``active`` conditions.

    Returns
    -------
    udot : tuple, length n_u
    multipliers : tuple, one per condition of :func:`rows`
    """
    f = [-x for x in bias(model, state)]
    if forces is not None:
        f = [a + b for a, b in zip(f, forces, strict=True)]
    conditions = linearized(model, state)
    multipliers: list[Scalar] = [0] * len(conditions.bias)
    speeds = deep_speeds(model) if conditions.symmetric else None
    turned, back = conditions.in_loop_axes(active)
    if not conditions.symmetric:
        active = _slipping_last(model, active)
    G = [turned[i][0] if i in turned else conditions.matrix[i] for i in active]
    gamma = [turned[i][1] if i in turned else conditions.bias[i] for i in active]
    if speeds is not None:
        udot, lam = loop_motion(model, state, speeds, f, G, [-x for x in gamma])
    else:
        acting = [G[k] if i in turned else conditions.acting[i] for k, i in enumerate(active)]
        udot, lam = _by_mass_matrix(model, state, f, G, gamma, acting, conditions.symmetric)
    for i, multiplier in zip(active, lam, strict=True):
        multipliers[i] = multiplier
    for places, R in back:
        for i, value in zip(places, applied(R, [multipliers[i] for i in places]), strict=True):
            multipliers[i] = value
    return tuple(udot), tuple(multipliers)


def _by_mass_matrix(
    model: Model,
    state: State,
    f: Sequence[Scalar],
    G: Sequence[Sequence[Scalar]],
    gamma: Sequence[Scalar],
    acting: Sequence[Sequence[Scalar]],
    symmetric: bool,
) -> tuple[list[Scalar], list[Scalar]]:
    """Return u' and λ with the forces Wᵀ λ, where W has the rows ``acting``."""
    M = Factorization(mass_matrix(model, state))
    free = M.forward(f)
    # G M⁻¹ Wᵀ = (L⁻¹ Gᵀ)ᵀ D⁻¹ (L⁻¹ Wᵀ)
    W = [M.forward(row) for row in acting]
    weighed = [M.divided(row) for row in (W if symmetric else [M.forward(row) for row in G])]
    A = products(weighed, W)
    right = [-(a + along) for a, along in zip(gamma, applied(weighed, free), strict=True)]
    lam = (Factorization(A) if symmetric else Elimination(A)).solve(right)
    return M.back(combined(free, lam, W)), lam


DEEP = 10
"""Number of speeds in series from which :func:`loop_motion` takes fewer operations than M and its factors."""


def deep_speeds(model: Model) -> list[list[int]] | None:
    """Return the speeds of each link's own motions for models with many speeds in series, None for others."""
    speeds = own_speeds(model)
    if speeds is None or accelerating(model):
        return None
    depth: list[int] = []
    for link, link_speeds in zip(model.links, speeds, strict=True):
        depth.append(len(link_speeds) + (0 if link.parent == GROUND else depth[link.parent]))
    return speeds if max(depth, default=0) >= DEEP else None


def _slipping_last(model: Model, active: Sequence[int]) -> list[int]:
    """Return the rows with those of sliding contacts last, so that the leading block is positive definite."""
    slips = [
        isinstance(model.constraints[row.owner], Touching) and model.constraints[row.owner].slips
        for row in rows(model)
    ]
    return sorted(active, key=lambda i: (slips[i], i))


def constrained_loading(
    model: Model, state: State, multipliers: Sequence[Scalar], udot: Sequence[Scalar] | None = None
) -> Loading:
    """Return the loads of the model together with the forces of its constraints, at accelerations u' (or at 0)."""
    loads = loading(model, state, udot=udot)
    result = Loading(dict(loads.wrenches), dict(loads.along), dict(loads.generalized))
    conditions = linearized(model, state)
    for i, (row, acting) in enumerate(zip(rows(model), wrenches(model, state), strict=True)):
        value, owner = multipliers[i], model.constraints[row.owner]
        if isinstance(value, int) and value == 0:
            continue
        if isinstance(owner, Touching) and owner.contact.law is not None:
            first = next(k for k, other in enumerate(rows(model)) if other.owner == row.owner)
            for action in closed_forces(model, state, owner)[i - first]:
                act(model, state, result, owner.contact.law, [scaled(action, value)])
            continue
        for place, force, moment in acting:
            _press(model, state, result, place, scale(value, force), scale(value, moment))
        if isinstance(owner, Gear):
            for _, link, factor in torques(model, state, owner):
                result.along[link] = result.along.get(link, 0) + factor * value
            pair, size = separating_force(model, state, owner)
            for place, force, moment in pair:
                pressure = size * state.field.apply("abs", value)
                _press(model, state, result, place, scale(pressure, force), scale(pressure, moment))
        elif not acting:
            for j, entry in enumerate(conditions.matrix[i]):
                result.generalized[j] = result.generalized.get(j, 0) + entry * value
    return result


def with_wrenches(model: Model, state: State, loads: Loading, acting: Sequence[Action]) -> Loading:
    """Return the loads together with further (place, force, moment) in ground axes; places as in :func:`wrenches`."""
    result = Loading(dict(loads.wrenches), dict(loads.along), dict(loads.generalized))
    for place, force, moment in acting:
        _press(model, state, result, place, force, moment)
    return result


def _press(model: Model, state: State, result: Loading, place: Any, force: Vector, moment: Vector) -> None:
    """Add a wrench at a point; ``place`` may be (body, point) with a point that is not fixed in the body."""
    body, point = place if isinstance(place, tuple) else (place.body, place)
    link, _ = place_of(model, body)
    if link < 0:
        return
    posture = link_postures(model, state)[link]
    arm = subtract(point_position(model, state, point), posture.position)
    n = apply_transpose(posture.rotation, plus((moment, force), (cross(arm, force), (0, 0, 0)))[0])
    f = apply_transpose(posture.rotation, force)
    result.wrenches[link] = plus(result.wrench(link), (n, f))


def constraint_power(model: Model, state: State, multipliers: Sequence[Scalar]) -> Scalar:
    """Return the power that conditions with explicit time put in: -Σ λ g, where ψ = G u + g [W].

    Joints, gears and wheels do no work between their bodies; if they are driven, the drive does the work. A rope does
    work if it is hauled in. A contact that slips takes out μ N |γ|.
    """
    conditions = linearized(model, state)
    total: Scalar = 0
    for kind, value, rate, row in zip(
        rows(model), multipliers, conditions.rate, conditions.matrix, strict=True
    ):
        owner = model.constraints[kind.owner]
        if isinstance(owner, Condition | SpeedCondition):
            total = total - value * (rate - scalar_product(row, state.u))
        elif isinstance(owner, Touching) and owner.slips and not owner.contact.frictionless:
            slip = rows_of(model, state, (owner.contact,)).rate[1:]
            # that of an adhesion is the power of a load
            total = total + scalar_product(friction_along_tangents(model, state, owner, value), slip)
        elif isinstance(owner, Rope) and isinstance(owner.length, sympy.Basic):
            total = total - value * state(exact(owner.length.diff(TIME)))
    return total


def position_correction(model: Model, state: State, active: Sequence[int]) -> tuple[Scalar, ...]:
    """Return the coordinates after one Newton step to φ = 0 that moves the masses least.

    δ = -M⁻¹ Gᵀ (G M⁻¹ Gᵀ)⁻¹ φ
    """
    kinds = rows(model)
    on_coordinates = [i for i in active if not kinds[i].on_speeds]
    conditions = linearized(model, state)
    G = [conditions.matrix[i] for i in on_coordinates]
    step = _least(model, state, G, [conditions.residual[i] for i in on_coordinates])
    moved = State(model, state.field, state.t, state.q, step, state.values)
    return tuple(a + b for a, b in zip(state.q, coordinate_rates(model, moved), strict=True))


def speed_correction(model: Model, state: State, active: Sequence[int]) -> tuple[Scalar, ...]:
    """Return the speeds with ψ = 0 that change the motion of the masses least."""
    conditions = linearized(model, state)
    G = [conditions.matrix[i] for i in active]
    step = _least(model, state, G, [conditions.rate[i] for i in active])
    return tuple(a + b for a, b in zip(state.u, step, strict=True))


def moved_onto(model: Model, state: State, active: Sequence[int]) -> list[Scalar]:
    """Return (q, u) moved onto the constraints by one Newton step for q, then one for u.

    The state after a step is off by the local error. The error of a Newton step is the square of that, so one step
    reaches round-off.
    """
    q = position_correction(model, state, active)
    on_constraints = State(model, state.field, state.t, q, state.u, state.values)
    return [*q, *speed_correction(model, on_constraints, active)]


def least_speed_change(model: Model, state: State, selection: Selection) -> list[Scalar]:
    """Return the change δ of the speeds with G δ = -ψ in the selected conditions and speeds, of the least ½ δᵀ M δ."""
    conditions = linearized(model, state)
    return _least(model, state, list(conditions.matrix), list(conditions.rate), selection)


def _least(
    model: Model, state: State, G: Sequence[Any], residual: Sequence[Scalar], selection: Selection | None = None
) -> list[Scalar]:  # fmt: skip
    """Return the step with G step = -residual of the least ½ stepᵀ M step."""
    if not G:
        return [0] * model.n_u
    if selection is not None:
        residual = [a * r for a, r in zip(selection.active, residual, strict=True)]
        G = selection.rows(G)
    speeds = deep_speeds(model)
    if speeds is not None:
        f, g = [0] * model.n_u, [-r for r in residual]
        return loop_motion(model, state, speeds, f, G, g, selection)[0]
    masses = mass_matrix(model, state)
    M = Factorization(masses if selection is None else selection.masses(masses))
    Y = [M.forward(row) for row in G]
    K = products([M.divided(y) for y in Y], Y)
    if selection is not None:
        for c, a in enumerate(selection.active):
            K[c][c] = K[c][c] + (1 - a)
    return M.back(combined([0] * model.n_u, Factorization(K).solve([-r for r in residual]), Y))


def articulated_diagonal(model: Model, state: State) -> list[Scalar]:
    """Return, for each speed, the mass that it moves if the speeds eliminated before it follow freely (pivots of M).

    If some speeds together move no mass, one of these is 0.
    """
    speeds = deep_speeds(model)
    if speeds is not None:
        return articulated_masses(model, state, speeds)
    factors = Factorization(mass_matrix(model, state))
    pivots = dict(zip(factors.order, factors.D, strict=True))
    return [pivots[j] for j in range(model.n_u)]


def condition_groups(model: Model) -> list[list[int]]:
    """Return the conditions of each constraint in groups of one unit: those along directions, and those of turns."""
    if "condition_groups" not in model.memo:
        model.memo["condition_groups"] = _condition_groups(model)
    return cast("list[list[int]]", model.memo["condition_groups"])


def _condition_groups(model: Model) -> list[list[int]]:
    groups: dict[Any, list[int]] = {}
    counts: dict[str, int] = {}
    for i, row in enumerate(rows(model)):
        owner, place = model.constraints[row.owner], counts.get(row.owner, 0)
        counts[row.owner] = place + 1
        turns = isinstance(owner, Closure) and place >= len(owner.along)
        groups.setdefault((row.owner, row.on_speeds, turns), []).append(i)
    return list(groups.values())


def independence(model: Model, state: State, active: Sequence[int]) -> Scalar:
    """Return the least s² of the active conditions, where s is the part of a row of G independent of the others.

    Columns are measured by the masses they move, rows by the longest of their group (:func:`condition_groups`). A row
    that vanishes beside others of its joint, or follows from other rows, has s = 0. There another motion branches off.
    """
    G, masses = linearized(model, state).matrix, mass_diagonal(model, state)

    def length(i: int) -> Scalar:
        return sum((divide(x * x, masses[j]) for j, x in entries(G[i])), 0)

    longest: dict[int, Scalar] = {}
    for group in condition_groups(model):
        most: Scalar = None
        for i in group:
            if entries(G[i]):
                most = length(i) if most is None else state.field.apply("max", most, length(i))
        longest |= dict.fromkeys(group, most)
    nonzero = [i for i in active if entries(G[i])]
    weighed: list[list[Scalar]] = []
    for i in nonzero:
        row: list[Scalar] = [0] * model.n_u
        for j, x in entries(G[i]):
            row[j] = divide(x, masses[j])
        weighed.append(row)
    factors = Factorization(products(weighed, [G[i] for i in nonzero]))
    least: Scalar = 1
    for k, pivot in zip(factors.order, factors.D, strict=True):
        least = state.field.apply("min", least, divide(pivot, longest[nonzero[k]]))
    return least


# Rows of G are compared at unit length; the remainder of a dependent row after Gram-Schmidt is round-off.
DEPENDENT = 10**-9
POOR = 10**-4

STEPS = 50
"""Gauss-Newton steps after which the conditions count as impossible to meet."""


def independent_rows(model: Model, state: State) -> tuple[int, ...]:
    """Return the conditions that are independent at a state of floats; earlier conditions go before later ones.

    Raises
    ------
    ModelError
        Speeds that move no mass.
    """
    G = np.array([[float(x) for x in row] for row in linearized(model, state).matrix]).reshape(-1, model.n_u)
    M = np.array([[float(x) for x in row] for row in mass_matrix(model, state)])
    check_mobility(model, M)
    return independent_of(G, M)


def independent_of(G: Any, M: Any) -> tuple[int, ...]:
    """Return the rows of G that are independent, measured by the masses M; earlier rows go before later ones.

    A row of which less than :data:`POOR` is independent of the earlier rows is taken only if no later row is better,
    since it would become dependent a little later in the motion.
    """
    scaled = G / np.sqrt(M.diagonal())
    largest = np.linalg.norm(scaled, axis=1).max(initial=0)
    basis: list[Scalar] = []
    independent: list[int] = []
    for least in (POOR, DEPENDENT):
        for i, row in enumerate(scaled):
            length = np.linalg.norm(row)
            if i in independent or length <= least * largest:
                continue
            rest = row / length
            for _ in range(2):
                for b in basis:
                    rest = rest - (b @ rest) * b
            # round-off of a short row has any direction: its remainder must be large beside the largest row, too
            if np.linalg.norm(rest) > least and np.linalg.norm(rest) * length > DEPENDENT * largest:
                basis.append(rest / np.linalg.norm(rest))
                independent.append(i)
    return tuple(sorted(independent))


def closed_coordinates(
    model: Model,
    q: Sequence[float],
    t: float = 0,
    values: Mapping[Any, Any] | None = None,
    fixed: Sequence[int] = (),
    steps: int = STEPS,
) -> list[float]:
    """Return coordinates near ``q`` that satisfy the conditions on coordinates, by Gauss-Newton steps.

    Parameters
    ----------
    fixed : sequence of int
        Indices of the speeds whose coordinates stay fixed.

    Raises
    ------
    ModelError
        The message names the worst condition and its residual.
    """
    kinds = rows(model)
    free = [j for j in range(model.n_u) if j not in set(fixed)]
    q = [*map(float, q)]
    active = [i for i, kind in enumerate(kinds) if not kind.on_speeds]
    best = float("inf")
    stalled = 0
    # round-off of a machine of any size
    small = DEPENDENT * (1 + float(np.abs(q).max(initial=0)))
    for _ in range(steps):
        try:
            conditions = linearized(model, float_state(model, q, t=t, values=values))
            phi = np.array([float(conditions.residual[i]) for i in active])
            G = np.array([[float(conditions.matrix[i][j]) for j in free] for i in active])
        except (ZeroDivisionError, ValueError):
            phi = G = np.array([np.nan])
        if not (np.isfinite(phi).all() and np.isfinite(G).all()):
            raise no_direction(model, q)
        size = float(np.abs(phi).max(initial=0))
        stalled = stalled + 1 if size >= best else 0
        best = min(best, size)
        if size == 0 or (stalled >= 2 and size < small):
            return q
        step = np.zeros(model.n_u)
        step[free] = -np.linalg.lstsq(G, phi, rcond=DEPENDENT)[0]
        length = np.abs(step).max(initial=0)
        step /= max(1, length)
        moved = float_state(model, q, [float(x) for x in step], t, values)
        q = [a + float(b) for a, b in zip(q, coordinate_rates(model, moved), strict=True)]
        for start in model.quaternions:
            norm = float(np.linalg.norm(q[start : start + 4]))
            q[start : start + 4] = [x / norm for x in q[start : start + 4]]
    residual, error = not_met(model, q, t, values, steps)
    if residual < small:
        return q
    raise error


def no_direction(model: Model, q: Sequence[float]) -> ModelError:
    """Return the error for coordinates at which conditions, or their derivatives, are not finite numbers."""
    where = ", ".join(f"{c.name} = {x:.6g}" for c, x in zip(model.coordinates, q, strict=True))
    return ModelError(
        f"A constraint of '{model.name}' ({', '.join(model.constraints)}) has no direction at {where}: two "
        f"points of a rope in one place, a wheel that lies flat, or an expression without a value there. Start "
        f"elsewhere."
    )


def not_met(
    model: Model, q: Sequence[float], t: float, values: Mapping[Any, Any] | None, steps: int
) -> tuple[float, ModelError]:
    """Return the greatest residual at coordinates, and the error for coordinates that do not close."""
    final = residuals(model, float_state(model, q, t=t, values=values))
    missed = {kind.name: float(r) for kind, r in zip(rows(model), final, strict=True) if not kind.on_speeds}
    worst = max(missed, key=lambda name: abs(missed[name]))
    return abs(missed[worst]), ModelError(
        f"The constraints cannot be met near the coordinates given: after {steps} steps '{worst}' is still missed by "
        f"{missed[worst]:.3g}. Start nearer to a closed position, or check the lengths."
    )
