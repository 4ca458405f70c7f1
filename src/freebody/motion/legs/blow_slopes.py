"""Derivatives after a blow: its law is differentiated.

    M Δu = Jᵀ P + Gᵀ Λ,    G Δu = 0

A change (σ, τ, dp) of the state before, of the time and of the unknowns gives

    M (σ⁺ - σ⁻) + d(M Δu) = d(Jᵀ P) + Σ Λ dG + Gᵀ dΛ,    G σ⁺ = -d(G u⁺ + γ)

where P is an impulse, whose components are expressions, or P n with n·v⁺ = -e n·v⁻ of the point that hits a surface,

    d(n·v⁺) = -e d(n·v⁻) - de n·v⁻,

one equation for dP. Jᵀ P, n·v and e are evaluated on dual numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...dynamics.bearing_loads import shared
from ...dynamics.impulse import (
    blows_on,
    generalized_impulse,
    impulsive_reactions,
    speed_jumps,
    with_constraints,
)
from ...dynamics.kinematics import link_twists, point_velocity
from ...dynamics.state import State
from ...errors import NoDerivativesError
from ...scalar.algebra import ZERO, divide, dot
from ...scalar.dual import slope_of, value_of
from ..ode.dense_output import Array
from ..trajectory.event import expressions_of
from .blow import Blow, call_of
from .driven_slopes import dual_of, dual_state
from .impulse import resolved_blow


class Struck(NamedTuple):
    """A blow of a run: the time, and the states (q, u) before and after it."""

    blow: Blow
    t: float
    before: Array
    after: Array


def check_blow(blow: Blow) -> None:
    """Refuse a blow whose law has no derivatives here."""
    if blow.options["restitution"] is not None and blow.options["moment"] is not None:
        raise NoDerivativesError(
            f"Expected a blow with restitution= or with moment= for sensitivities=, but '{blow.name}' has both. Make "
            "it two blows at one time."
        )


def reactions_of_blow(
    slopes: Any, hit: Struck, sigma: Array, tau: Array
) -> tuple[Array, tuple[Array, Array]]:
    """Return the speeds after a blow without the friction of joints, and the impulses that press their bearings.

    These are the forces at the places of the bearings, shape (joints, 7), and their derivatives, (unknowns, joints, 7).
    """
    model, state, options = slopes.model, _state(slopes, hit.t, hit.before, sigma, tau), hit.blow.options
    keys = ("at", "impulse", "moment", "frame")
    blows = [resolved_blow(model, state, *(options[key] for key in keys))]
    impulses, active = generalized_impulse(model, state, blows_on(model, state, blows)), slopes.kernels.active
    jump, multipliers = speed_jumps(model, state, impulses, active)
    acting = blows_on(model, state, with_constraints(model, state, blows, multipliers))
    found = impulsive_reactions(model, state, link_twists(model, state, jump), acting)
    laws = [contact.law for contact in model.contacts if contact.loaded]
    rows = [shared(model, state, law, *found[law.joint.name]) for law in laws]
    after = hit.before.copy()
    after[model.n_q : slopes.moved] += [float(value_of(x)) for x in jump]
    changes = [[[float(slope_of(x, j)) for x in row] for row in rows] for j in range(len(sigma))]
    return after, (np.array([[float(value_of(x)) for x in row] for row in rows]), np.array(changes))


def after_blow(slopes: Any, hit: Struck, sigma: Array, tau: Array) -> Array:
    """Return the derivatives after a blow; ``slopes`` are `contact.derivatives.slopes.Slopes`."""
    n_q, n, moved = slopes.model.n_q, slopes.model.n_u, slopes.moved
    M, G = slopes.mass(hit.t, hit.before)
    jump = (hit.after - hit.before)[n_q:moved]
    # σ⁻ moves what acts, and the point before it; after it, at fixed speeds, they count by themselves
    acting, value, change = _law(slopes, hit, hit.before, sigma, tau)
    still = sigma.copy()
    still[:, n_q:] = 0
    rebounds = acting.shape[0] > 0
    if rebounds:
        _, after, change_after = _law(slopes, hit, hit.after, still, tau)
        P = float(np.linalg.lstsq(np.vstack([acting, G]).T, M @ jump, rcond=None)[0][0])
        e, v = value[0], value[1]
        given = P * acting[0]
    else:
        given = value[:n]
    own = np.linalg.lstsq(G.T, M @ jump - given, rcond=None)[0]
    size = n + len(G) + rebounds
    A = np.zeros((size, size))
    A[:n, :n], A[:n, n : n + len(G)], A[n : n + len(G), :n] = M, -G.T, G
    if rebounds:
        A[:n, -1], A[-1, :n] = -acting[0], acting[0]
    result = sigma.copy()
    for j, s in enumerate(sigma):
        dp, right = slopes.seeds[j], np.zeros(size)
        speeds = slopes.of_conditions(hit.t, hit.after, still[j], tau[j], dp)[0]
        dG = slopes.of_conditions(hit.t, hit.before, still[j], tau[j], dp)[1]
        right[:n] = M @ s[n_q:] - slopes.of_momentum(hit.t, hit.before, jump, still[j], tau[j], dp) + own @ dG
        right[n : n + len(G)] = -speeds
        if rebounds:
            right[:n] += P * change[j, 2:]
            right[-1] = -change_after[j, 1] - e * change[j, 1] - change[j, 0] * v
        else:
            right[:n] += change[j]
        result[j, n_q:] = np.linalg.lstsq(A, right, rcond=None)[0][:n]
    return result


def _law(slopes: Any, hit: Struck, y: Array, sigma: Array, tau: Array) -> tuple[Array, Array, Array]:
    """Return the row of an impulse that restitution decides, if any; the numbers of a law, and their derivatives.

    The numbers are Jᵀ P, or e, n·v and Jᵀ n.
    """
    state, options = _state(slopes, hit.t, y, sigma, tau), hit.blow.options
    model, at, frame = slopes.model, options["at"], options["frame"]
    if options["restitution"] is None:
        point, P, moment = resolved_blow(model, state, at, options["impulse"], options["moment"], frame)
        found = _conjugate(state, point, P, moment)
    else:
        point, normal, _ = resolved_blow(model, state, at, options["normal"], None, frame)
        length = state.field.sqrt(dot(normal, normal))
        n: Any = tuple(divide(x, length) for x in normal)
        e = state(model.names.expression(options["restitution"], "the coefficient of restitution"))
        found = [e, dot(n, point_velocity(model, state, point)), *_conjugate(state, point, n, ZERO)]
    values = np.array([float(value_of(x)) for x in found])
    change = np.array([[float(slope_of(x, j)) for x in found] for j in range(len(sigma))])
    row = values[2:] if options["restitution"] is not None else np.empty((0, slopes.model.n_u))
    return row.reshape(-1, slopes.model.n_u), values, change


def _conjugate(state: State, point: Any, P: Any, moment: Any) -> list[Any]:
    """Return Jᵀ P."""
    return list(generalized_impulse(state.model, state, blows_on(state.model, state, [(point, P, moment)])))


def event_along(
    slopes: Any, blow: Blow, moment: tuple[float, Array, Array], changes: tuple[Array, Array]
) -> Array:
    """Return the expression whose zero calls for a blow, its rate, and its derivatives along changes of the state.

    ``moment`` is the time, the state and its rates; ``changes`` are those of the state and of the time.
    """
    t, y, f = moment
    sigma, tau = changes
    (expression,) = expressions_of(slopes.model, (call_of(blow),))
    state = _state(slopes, t, y, np.vstack([sigma, f]), np.append(tau, 1.0))
    value = state(expression)
    return np.array(
        [value_of(value), *(slope_of(value, j) for j in (len(tau), *range(len(tau))))], dtype=float
    )


def _state(slopes: Any, t: float, y: Array, sigma: Array, tau: Array) -> State:
    """Return a state of dual numbers."""
    values: list[Any] = slopes.parameters.tolist()
    for symbol, seed in zip(slopes.symbols, slopes.seeds.T, strict=True):
        place = next(i for i, p in enumerate(slopes.model.parameters) if p.symbol == symbol)
        values[place] = dual_of(values[place], seed)
    moved: Sequence[Any] = [dual_of(x, s) for x, s in zip(y[: slopes.moved], sigma.T, strict=True)]
    return dual_state(slopes.model, dual_of(t, tau), moved, values)
