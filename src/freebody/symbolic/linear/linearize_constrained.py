"""Linear equations of a machine with constraints, in numbers and in independent coordinates.

    φ(q) = 0,   ψ = G u + g = 0,      G_h T = 0,   δu = S v + P p,   ξ = T p

The coordinates of the operating point are corrected until φ = 0, the independent speeds are chosen by pivoting, and the
equations are reduced (`reduction`). They are evaluated again a little later: about a steady motion they may not change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics.composite import mass_matrix
from ...dynamics.conditions.constrained import (
    DEPENDENT,
    STEPS,
    constrained_dynamics,
    independent_of,
    no_direction,
    not_met,
)
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.linearized import linearized
from ...dynamics.conditions.mobility import check_mobility
from ...dynamics.kinematics import coordinate_rates
from ...dynamics.state import State
from ...errors import ModelError
from ...model.model import Model
from ...scalar.algebra import Scalar, floats
from ..derivation.contact_modes import sticking_only
from .checks import SMALL, Checks, check_count, check_untouched, not_independent
from .linear_model import LinearModel
from .operating_point import moved, tangent_names
from .recorded_functions import Points, Recorded
from .reduction import Choice, Slopes, drifts, reduced, slopes

Array = NDArray[np.float64]
ROUNDING = 10 * float(np.finfo(float).eps)
"""Relative size up to which an entry is the round-off of an exact zero."""
STEP = 20
"""Steps per radian of the fastest speed along a motion whose dependent speeds change."""


def constrained(
    programs: Recorded,
    points: Points,
    names_given: frozenset[str],
    inputs: Sequence[str],
    independent: Sequence[str],
    checks: Checks,
) -> LinearModel:
    """Linear equations about equilibria or steady motions.

    Coordinates and speeds not in ``names_given`` follow from the constraints.
    """
    model = programs.model
    speeds = {name: j for j, name in enumerate(model.speed_names)}
    fixed = [j for name, j in speeds.items() if name.removesuffix("'") in names_given]
    points = _closed(programs, points, fixed)
    points = _consistent_speeds(
        programs, points, [speeds[name] for name in names_given if name in speeds], checks
    )
    choice = _choice(programs, points, independent, checks)
    if not choice.speeds:
        raise ModelError(
            f"The constraints and drives of '{model.name}' leave it no freedom: it has no small motions to linearise."
        )
    names = tangent_names(model)
    first = _terms(programs, points, inputs, choice)
    speed_indices = list(choice.speeds)
    checks.balance(
        first["udot"][:, speed_indices],
        first["size"][:, speed_indices],
        [names[j] for j in speed_indices],
        "the accelerations of its independent coordinates are",
    )
    carried = [names[j] for j in choice.carried]
    fastest = np.abs(points.u).max(axis=1, initial=0)
    moving_states = np.flatnonzero(fastest > 0)
    if len(moving_states):
        start, before = points[moving_states], {key: x[moving_states] for key, x in first.items()}
        act_back = _acting_back(before, len(speed_indices))
        for later_points, which in _later(programs, start, before, fastest[moving_states], choice.active):
            later = _terms(programs, later_points, inputs, choice)
            same = {key: x[which] for key, x in before.items()}
            for key in ("M", "C", "K", "B"):
                checks.same(same[key], later[key], key, moving_states[which])
            active_rows = act_back[which][:, :, None]
            checks.same(same["E"] * active_rows, later["E"] * active_rows, "E", moving_states[which])
            change = sum(_greatest(later[key] - same[key]) for key in ("E", "E_rates"))
            if np.any(
                (change > 10**4 * SMALL * np.maximum(_greatest(same["E_rates"]), 1))
                & ~act_back[which].any(axis=1)
            ):
                # the carried deviations do not act back, and their equations change with time: leave them out
                carried = []
    terms = {key: first[key] for key in (*"MCKB", "T", "S", "P", "to_rates", "udot")}
    if carried:
        terms.update({key: first[key] for key in ("K_carried", "E", "E_rates")})
    terms = {key: x.reshape(*checks.shape, *x.shape[1:]) for key, x in terms.items()}
    terms["chosen"] = choice
    return LinearModel(
        model,
        [names[j] for j in choice.speeds],
        inputs,
        terms,
        point=checks.named(points.q, points.u),
        values=checks.values,
        carried=carried,
    )


def constrained_along(
    programs: Recorded,
    points: Points,
    shape: tuple[int, ...],
    numbers: Mapping[Any, float],
    inputs: Sequence[str],
    independent: Sequence[str],
    checks: Checks,
) -> LinearModel:
    """Linear equations along a trajectory; the independent coordinates are chosen at its first time."""
    model = programs.model
    choice = _choice(programs, points, independent, checks)
    blocks = _terms(programs, points, inputs, choice)
    names = tangent_names(model)
    keys = ("M", "C", "K", "B", *(("K_carried", "E", "E_rates") if choice.carried else ()))
    return LinearModel(
        model,
        [names[j] for j in choice.speeds],
        inputs,
        {key: blocks[key].reshape(*shape, *blocks[key].shape[1:]) for key in keys},
        point=checks.named(points.q, points.u),
        values={p.name: numbers[p.symbol] for p in model.parameters},
        times=points.t.reshape(shape),
        carried=[names[j] for j in choice.carried],
    )


def _conditions(state: State) -> dict[str, Any]:
    conditions = linearized(state.model, state)
    return {"residual": conditions.residual, "rate": conditions.rate, "matrix": conditions.matrix}


def _closed(programs: Recorded, points: Points, fixed: Sequence[int]) -> Points:
    """Return coordinates with φ = 0, by the steps of `closed_coordinates` for all states at once.

    Coordinates of the ``fixed`` speeds are not changed.
    """
    model = programs.model
    active = [i for i, kind in enumerate(rows(model)) if not kind.on_speeds]
    free = [j for j in range(model.n_u) if j not in set(fixed)]
    q = points.q.copy()
    best, stalled = np.full(len(points), np.inf), np.zeros(len(points), dtype=int)
    small = DEPENDENT * (1 + np.abs(q).max(axis=1, initial=0))
    open_states = np.arange(len(points)) if active else np.arange(0)
    for _ in range(STEPS):
        if not len(open_states):
            break
        conditions = programs("conditions", _conditions, points[open_states].at(q=q[open_states]))
        phi, G = conditions["residual"][:, active], conditions["matrix"][:, active][..., free]
        finite = np.isfinite(phi).all(axis=1) & np.isfinite(G).all(axis=(1, 2))
        if not finite.all():
            raise no_direction(model, q[open_states[np.argmin(finite)]].tolist())
        size = np.abs(phi).max(axis=1, initial=0)
        stalled[open_states] = np.where(size >= best[open_states], stalled[open_states] + 1, 0)
        best[open_states] = np.minimum(best[open_states], size)
        continuing = ~((size == 0) | (stalled[open_states] >= 2) & (size < small[open_states]))
        open_states, phi, G = open_states[continuing], phi[continuing], G[continuing]
        if not len(open_states):
            break
        step = np.zeros((len(open_states), model.n_u))
        step[:, free] = -(np.linalg.pinv(G, rcond=DEPENDENT) @ phi[..., None])[..., 0]
        step /= np.maximum(1, np.abs(step).max(axis=1, initial=0))[:, None]
        q[open_states] += programs("rates", _rates, points[open_states].at(q=q[open_states], u=step))["rates"]
        for start in model.quaternions:
            q[open_states, start : start + 4] /= np.linalg.norm(q[open_states, start : start + 4], axis=1)[
                :, None
            ]
    for i in open_states:
        values = {p.name: float(x) for p, x in zip(model.parameters, points.values[i], strict=True)}
        remaining, refusal = not_met(model, q[i].tolist(), float(points.t[i]), values, STEPS)
        if not remaining < small[i]:
            raise refusal
    return points.at(q=q)


def _rates(state: State) -> dict[str, Any]:
    return {"rates": coordinate_rates(state.model, state)}


def _consistent_speeds(programs: Recorded, points: Points, fixed: Sequence[int], checks: Checks) -> Points:
    """Return speeds that satisfy all conditions: the ``fixed`` ones unchanged, the least change of the others."""
    model = programs.model
    conditions = programs("conditions", _conditions, points)
    G, rate = conditions["matrix"].reshape(len(points), -1, model.n_u), conditions["rate"]
    free = [j for j in range(model.n_u) if j not in set(fixed)]
    u = points.u.copy()
    if free and rate.size:
        step = -(np.linalg.pinv(G[..., free], rcond=SMALL) @ rate[..., None])
        u[:, free] += step[..., 0]
        rate = rate + (G[..., free] @ step)[..., 0]
    size = SMALL * np.abs(G).max(axis=(1, 2), initial=0) * np.abs(u).max(axis=1, initial=0)
    off = np.abs(rate) > size[:, None]
    if off.any():
        i = int(np.argmax(off.any(axis=1)))
        missed = {kind.name: r for kind, r, bad in zip(rows(model), rate[i], off[i], strict=True) if bad}
        shown = ", ".join(f"{name}: {r:.6g}" for name, r in missed.items())
        raise ModelError(
            f"The speeds given in `about` do not satisfy the constraints of '{model.name}'{checks.which(i)}: they "
            f"miss {shown}. Leave out those that follow from the others."
        )
    return points.at(u=u)


def _choice(programs: Recorded, points: Points, independent: Sequence[str], checks: Checks) -> Choice:
    """Choose independent speeds and deviations at the first state; raise if they are not independent at another.

    Unless the user names them, pivoting makes the best conditioned columns dependent.
    """
    model = programs.model
    names = tangent_names(model)
    n = model.n_u
    kinds = rows(model)
    state = State(model, floats, 0, points.q[0].tolist(), points.u[0].tolist(), checks.first)
    sticking_only(linearized(model, state), "A linearization")
    G = programs("conditions", _conditions, points)["matrix"].reshape(len(points), -1, n)
    M = programs("mass", lambda state: {"M": mass_matrix(model, state)}, points)["M"]
    check_mobility(model, M[0])
    active = independent_of(G[0], M[0])
    scaled_all = G / np.sqrt(np.abs(np.diagonal(M, axis1=1, axis2=2)))[:, None, :]
    scaled = scaled_all[0, list(active)]
    holonomic = np.array([not kinds[i].on_speeds for i in active], dtype=bool)
    named = [names.index(name) for name in independent]
    if named:
        check_count(model, independent, len(active))
    remaining = [j for j in range(n) if j not in named]
    # conditions on coordinates come first: a coordinate that they make dependent has a dependent speed
    dependent = _pivots(scaled[holonomic], remaining)
    reduced = _eliminated(scaled[~holonomic], scaled[holonomic], dependent)
    dependent_on_speeds = _pivots(reduced, [j for j in remaining if j not in dependent])
    if len(dependent) + len(dependent_on_speeds) < len(active):
        raise not_independent(model, independent)
    fixed = {*dependent, *dependent_on_speeds}
    speeds = named or [j for j in range(n) if j not in fixed]
    carried = [j for j in range(n) if j not in set(speeds) | set(dependent)]
    choice = Choice(
        tuple(speeds), tuple(carried), tuple(sorted(fixed)), tuple(sorted(dependent)), tuple(active)
    )
    _check_choice(model, choice, scaled_all, M, checks)
    return choice


def _check_choice(model: Model, choice: Choice, scaled: Array, M: Array, checks: Checks) -> None:
    """Raise if other conditions or other coordinates are independent at a state than at the first one."""
    if len(scaled) == 1 or not choice.active:
        return
    active = scaled[:, list(choice.active)]
    for block in (scaled, active, active[..., list(choice.dependent_speeds)]):
        sizes = np.linalg.svd(block, compute_uv=False)
        rank = np.sum(sizes > DEPENDENT * sizes[:, :1], axis=1)
        bad = ~np.isfinite(M).all(axis=(1, 2)) | (rank != len(choice.active))
        if bad.any():
            i = int(np.argmax(bad))
            raise ModelError(
                f"The independent coordinates of '{model.name}' chosen at the first state are not "
                f"independent{checks.which(i)}: other conditions are independent there, or its coordinates can no "
                "longer move separately. Linearise these states in another call, or name others with independent=."
            )


def _pivots(G: Array, columns: Sequence[int]) -> list[int]:
    """Choose, among ``columns``, as many well-conditioned columns as G has rows."""
    from scipy.linalg import qr

    if not len(G) or not columns:
        return []
    R, order = qr(G[:, columns], mode="r", pivoting=True)
    sizes = np.abs(np.diagonal(R))
    rank = int(np.sum(sizes > SMALL * np.abs(G).max()))
    return [columns[k] for k in order[: min(rank, len(G))]]


def _eliminated(lower: Array, upper: Array, pivots: Sequence[int]) -> Array:
    """Return the rows of ``lower`` with their pivot columns eliminated by the rows of ``upper``."""
    if not len(upper) or not len(lower):
        return lower
    return lower - lower[:, pivots] @ np.linalg.solve(upper[:, pivots], upper)


def _terms(programs: Recorded, points: Points, inputs: Sequence[str], choice: Choice) -> dict[str, Any]:
    model = programs.model
    motion = programs(("motion", choice.active), lambda state: _motion(state, choice.active), points)
    udot, multipliers = motion["udot"], motion["multipliers"]
    blocks = programs(
        ("slopes", choice, tuple(inputs)),
        lambda state, a, b: _slopes(state, a, b, inputs, choice),
        points, udot, multipliers,
    )  # fmt: skip
    slopes_at = Slopes(**{f.name: blocks[f.name] for f in fields(Slopes)})
    _check_inputs(model, slopes_at, inputs)
    terms = reduced(model, slopes_at, (blocks["drift"], blocks["drift_rate"]), choice, np.linalg.solve)
    by_q, by_u = (np.abs(np.linalg.solve(slopes_at.M, x)) for x in (slopes_at.by_q, slopes_at.by_u))
    unit = np.sqrt(np.diagonal(terms["M"], axis1=1, axis2=2))
    terms["M"] = np.where(np.abs(terms["M"]) <= ROUNDING * unit[:, :, None] * unit[:, None, :], 0, terms["M"])
    size = ROUNDING * _greatest(terms["M"]) * np.maximum(_greatest(by_q), _greatest(by_u))
    for key in ("C", "K", "K_carried"):
        terms[key] = np.where(np.abs(terms[key]) <= size[:, None, None], 0, terms[key])
    fast = np.abs(points.u).max(axis=1, initial=0)
    size = ROUNDING * _greatest(terms["E_rates"])
    for key, scale in (("E_rates", size), ("E", np.maximum(ROUNDING * _greatest(terms["E"]), size * fast))):
        terms[key] = np.where(np.abs(terms[key]) <= scale[:, None, None], 0, terms[key])
    # an acceleration that vanishes together with its derivatives is round-off of the greatest term
    greatest = (by_q.sum(axis=2) + (1 + fast)[:, None] * by_u.sum(axis=2)).max(axis=1, initial=0) + fast**2
    return {**terms, "udot": udot, "size": np.repeat(greatest[:, None], model.n_u, axis=1)}


def _motion(state: State, active: Sequence[int]) -> dict[str, Any]:
    udot, multipliers = constrained_dynamics(state.model, state, active)
    return {
        "udot": udot,
        "multipliers": [multipliers[i] for i in active],
        "rates": coordinate_rates(state.model, state),
    }


def _slopes(
    state: State, udot: Sequence[Scalar], multipliers: Sequence[Scalar], inputs: Sequence[str], choice: Choice
) -> dict[str, Any]:
    """`slopes` with the multipliers of the motion, and `drifts`, as one dictionary."""
    known_multipliers = np.array(multipliers, dtype=object)
    values = {p.symbol: state.values[p.symbol] for p in state.model.parameters}
    at = State(state.model, state.field, state.t, state.q, state.u, values)
    derivatives = slopes(at, udot, inputs, choice, lambda A, B: known_multipliers, _unchanged)
    first, second = drifts(state.model, state.u, udot, _unchanged)
    return {
        **{f.name: getattr(derivatives, f.name) for f in fields(derivatives)},
        "drift": first,
        "drift_rate": second,
    }


def _unchanged(x: Scalar) -> Scalar:
    return x


def _greatest(x: Array) -> Array:
    """Greatest magnitude in each matrix."""
    magnitude: Array = np.abs(x).max(axis=(-1, -2), initial=0)
    return magnitude


def _check_inputs(model: Model, derivatives: Slopes, inputs: Sequence[str]) -> None:
    """Raise if an input changes the constraints: the deviations would not satisfy them."""
    parameters = {p.name for p in model.parameters}
    size = SMALL * _greatest(derivatives.G)
    moved = np.any(np.abs(derivatives.touched) > size[:, None, None], axis=(0, 1))
    check_untouched(model, [name for name in inputs if name in parameters], moved)


def _acting_back(terms: Mapping[str, Any], m: int) -> NDArray[np.bool_]:
    """Mark, per state, the carried deviations that act back on the independent ones, directly or through others."""
    feedback, coupling = np.abs(terms["K_carried"]), np.abs(terms["E"][..., m:])
    size = np.maximum(_greatest(terms["K"]), _greatest(feedback))
    matter = np.any(feedback > SMALL * size[:, None, None], axis=1)
    edges = coupling > SMALL * _greatest(coupling)[:, None, None]
    for _ in range(matter.shape[1]):
        matter = matter | np.any(edges & matter[:, :, None], axis=1)
    return matter


def _later(
    programs: Recorded, points: Points, first: Mapping[str, Any], fastest: Array, active: Sequence[int]
) -> list[tuple[Points, NDArray[np.int_]]]:
    """Return the states later in the motion, each with the indices of its states.

    If all speeds are constant: after 1 and 3 radians of the fastest speed; else: after one Runge-Kutta step.
    """
    constant = np.abs(first["udot"]).max(axis=1, initial=0) <= SMALL * fastest**2
    result = []
    steady, changing = np.flatnonzero(constant), np.flatnonzero(~constant)
    if len(steady):
        result = [(moved(programs.model, points[steady], k / fastest[steady]), steady) for k in (1, 3)]
    if not len(changing):
        return result
    start, n_q = points[changing], programs.model.n_q

    def rates(y: Array) -> Array:
        motion = programs(
            ("motion", tuple(active)), lambda s: _motion(s, active), start.at(q=y[:, :n_q], u=y[:, n_q:])
        )
        return np.concatenate([motion["rates"], motion["udot"]], axis=1)

    h = 1 / (STEP * fastest[changing])[:, None]
    y = np.concatenate([start.q, start.u], axis=1)
    k1 = rates(y)
    k2 = rates(y + h / 2 * k1)
    k3 = rates(y + h / 2 * k2)
    k4 = rates(y + h * k3)
    y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)  # Runge-Kutta of order 4
    return [*result, (start.at(q=y[:, :n_q], u=y[:, n_q:], t=start.t + h[:, 0]), changing)]
