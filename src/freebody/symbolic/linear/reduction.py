"""Linear equations of a machine with constraints, reduced to independent deviations; for any scalar.

    M u' + h - Q = Gᵀ λ,      φ = 0,      ψ = G u + g = 0,      α = G u' + γ = 0

    ξ = T p,      δu = S v + P p,      δu' = S v' + W v + Z p,      G S = 0

The equations of motion, with the multipliers λ constant, and the conditions ψ and α are differentiated on dual numbers.
Multiplication by Sᵀ removes δλ, so that λ enters only through second derivatives of the conditions,
Sᵀ (∂(Gᵀ λ)/∂ξ) T. Only the block of G that belongs to the dependent speeds is inverted.

Sources: Meijaard, Papadopoulos, Ruina & Schwab (2007), appendix; Neimark & Fufaev, Dynamics of Nonholonomic Systems
(1972), chapter V.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.linearized import linearized
from ...dynamics.newton_euler import inverse_dynamics
from ...dynamics.state import State
from ...model.model import Model
from ...scalar.algebra import Scalar
from ...scalar.dual import DualField, slope_of, value_of
from .operating_point import perturbed, tangent_drift, tangent_names

Array = Any
Solve = Callable[[Array, Array], Array]
"""Function that returns X with A X = B, for square A."""


@dataclass(frozen=True)
class Choice:
    """Indices of the independent speeds and of the carried deviations; together the independent deviations.

    ``active`` are the indices of independent conditions.
    """

    speeds: tuple[int, ...]
    carried: tuple[int, ...]
    dependent_speeds: tuple[int, ...]
    dependent: tuple[int, ...]  # deviations
    active: tuple[int, ...]


@dataclass(frozen=True)
class Slopes:
    """Values and derivatives at a state, with respect to all speeds and deviations.

    ``residual`` is M u' + h - Q, ``by_*`` are its derivatives with λ constant; ``G`` is the matrix of the active
    conditions and ``G_rate`` its rate along the motion; ``speed_by_q`` is ∂ψ/∂ξ; ``acceleration_by_*`` are the
    derivatives of α; ``touched`` are the derivatives of all conditions with respect to the inputs.
    """

    residual: Array
    by_q: Array
    by_u: Array
    M: Array
    B: Array
    G: Array
    G_rate: Array
    multipliers: Array
    speed_by_q: Array
    acceleration_by_q: Array
    acceleration_by_u: Array
    touched: Array


def slopes(
    at: State,
    udot: Sequence[Scalar],
    inputs: Sequence[str],
    choice: Choice,
    solve: Solve,
    entry: Callable[[Scalar], Scalar],
) -> Slopes:
    """Return the derivatives of the equations of motion and the active conditions, ``entry`` applied to each scalar."""
    model, n = at.model, at.model.n_u
    symbols = {p.name: p.symbol for p in model.parameters}
    place = {name: 3 * n + k for k, name in enumerate(name for name in inputs if name in symbols)}
    dual = DualField(at.field)
    clock = 3 * n + len(place)
    later = dual.dual(at.t, {clock: 1})
    state = perturbed(model, at.field, at.q, at.u, later, at.values, [symbols[name] for name in place])
    accelerations = [dual.dual(x, {2 * n + j: 1}) for j, x in enumerate(udot)]
    balance = inverse_dynamics(model, state, accelerations)
    conditions = linearized(model, state)
    kinds = rows(model)
    active = choice.active
    G = [conditions.matrix[i] for i in active]

    def table(xs: Sequence[Scalar], start: int, count: int) -> Array:
        return _array([[entry(slope_of(x, start + j)) for j in range(count)] for x in xs], (len(xs), count))

    values_of_G = _array([[entry(value_of(x)) for x in row] for row in G], (len(G), n))
    residual = _array([entry(value_of(x)) for x in balance], (n,))
    fixed = list(choice.dependent_speeds)
    multipliers = solve(values_of_G[:, fixed].T, residual[fixed]) if fixed else residual[:0]

    def reaction_slope(i: int, k: int) -> Scalar:
        """Slope of (Gᵀ λ)_i with λ constant."""
        parts = zip(G, multipliers, strict=True)
        return sum((entry(slope_of(row[i], k)) * m for row, m in parts), 0)

    slopes_of = [
        {k: entry(slope_of(x, k)) - reaction_slope(i, k) for k in range(clock)} for i, x in enumerate(balance)
    ]

    def block(start: int) -> Array:
        return _array([[row[start + j] for j in range(n)] for row in slopes_of], (n, n))

    names = tangent_names(model)
    B = [
        [-row[place[name]] if name in place else int(names[i] == name) for name in inputs]
        for i, row in enumerate(slopes_of)
    ]
    rate = [
        [
            sum((entry(slope_of(x, j)) * entry(w) for j, w in enumerate(at.u)), entry(slope_of(x, clock)))
            for x in row
        ]
        for row in G
    ]
    alpha = []
    for i, row in zip(active, G, strict=True):
        total = conditions.bias[i]
        for x, a in zip(row, accelerations, strict=True):
            total = total + x * a
        alpha.append(total)
    psi = [conditions.rate[i] for i in active]
    by_input = [*psi, *alpha, *(conditions.residual[i] for i in active if not kinds[i].on_speeds)]
    return Slopes(
        residual=residual,
        by_q=block(0),
        by_u=block(n),
        M=block(2 * n),
        B=_array(B, (n, len(inputs))),
        G=values_of_G,
        G_rate=_array(rate, (len(G), n)),
        multipliers=multipliers,
        speed_by_q=table(psi, 0, n),
        acceleration_by_q=table(alpha, 0, n),
        acceleration_by_u=table(alpha, n, n),
        touched=table(by_input, 3 * n, len(place)),
    )


def _array(entries: Any, shape: tuple[int, ...]) -> Array:
    """Return an array of objects, whose products and sums are those of its scalars."""
    result = np.empty(shape, dtype=object)
    if result.size:
        result[...] = entries
    return result


def reduced(
    model: Model, derivatives: Slopes, drifts: tuple[Array, Array], choice: Choice, solve: Solve
) -> dict[str, Array]:
    """Return M, C, K, B and the residual of the independent deviations, and K_carried, E, E_rates of the carried ones.

    c' = E (ξ, c) + E_rates ξ'. ``T``, ``S`` and ``P`` are as at the head of this file, with w = ξ' in place of
    v = w - to_rates p. ``drifts`` are `tangent_drift` of speeds and accelerations. With many states, the first axis of
    the matrices runs over them.
    """
    kinds = rows(model)
    speeds, carried = list(choice.speeds), list(choice.carried)
    free = [*speeds, *carried]
    m, f = len(speeds), len(free)
    holonomic = [k for k, i in enumerate(choice.active) if not kinds[i].on_speeds]
    G, M = derivatives.G, derivatives.M
    n = M.shape[-1]

    def zeros(rows: int, columns: int) -> Array:
        return np.zeros((*M.shape[:-2], rows, columns), dtype=M.dtype)

    T, T_rate = zeros(n, f), zeros(n, f)
    T[..., free, range(f)] = 1
    if choice.dependent:
        dependent, H = list(choice.dependent), G[..., holonomic, :]
        T[..., dependent, :] = -solve(H[..., dependent], H[..., free])
        T_rate[..., dependent, :] = -solve(H[..., dependent], derivatives.G_rate[..., holonomic, :] @ T)
    fixed = list(choice.dependent_speeds)
    S, P, W, Z = zeros(n, m), zeros(n, f), zeros(n, m), zeros(n, f)
    S[..., speeds, range(m)] = 1
    if fixed:
        D = G[..., fixed]
        S[..., fixed, :] = -solve(D, G[..., speeds])
        P[..., fixed, :] = -solve(D, derivatives.speed_by_q @ T)
        W[..., fixed, :] = -solve(D, derivatives.acceleration_by_u @ S)
        Z[..., fixed, :] = -solve(D, derivatives.acceleration_by_u @ P + derivatives.acceleration_by_q @ T)
    A, A_rate = drifts
    # p' = v + (P + A T) p in the rows of the independent speeds; w = p' replaces v
    drift = P + A @ T
    to_w = drift[..., speeds, :]
    to_w_rate = (A_rate @ T + A @ T_rate)[..., speeds, :]
    E_rates = S[..., carried, :]
    E = drift[..., carried, :] - E_rates @ to_w
    unit = zeros(m, m)
    unit[..., range(m), range(m)] = 1
    p_by_w = np.concatenate([unit, E_rates], axis=-2)
    p_by_p = np.concatenate([zeros(m, f), E], axis=-2)
    St = np.swapaxes(S, -1, -2)
    mass = St @ M @ S
    V = St @ (M @ W + derivatives.by_u @ S)
    K = St @ (M @ Z + derivatives.by_u @ P + derivatives.by_q @ T)
    C = V - mass @ to_w @ p_by_w
    K = K - V @ to_w - mass @ (to_w @ p_by_p + to_w_rate)
    return {
        "M": mass, "C": C, "K": K[..., :m], "K_carried": K[..., m:], "B": St @ derivatives.B, "E": E,
        "E_rates": E_rates,
        "residual": (St @ derivatives.residual[..., None])[..., 0], "T": T, "S": S, "P": P, "to_rates": to_w,
    }  # fmt: skip


def drifts(
    model: Model, u: Sequence[Scalar], udot: Sequence[Scalar], entry: Callable[[Scalar], Scalar]
) -> tuple[Array, Array]:
    """Return `tangent_drift` of speeds and accelerations as arrays, ``entry`` applied to each scalar."""
    first, second = (
        _array([[entry(x) for x in row] for row in tangent_drift(model, w)], (model.n_u, model.n_u))
        for w in (u, udot)
    )
    return first, second
