"""Linear equations of a machine with constraints, at numbers, in coordinates that are independent.

    φ(q) = 0,   ψ = G u + g = 0,      G_h T = 0,   δu = S v + P p,   ξ = T p

The accelerations u'(q, u) that satisfy the constraints are differentiated on dual numbers and projected on admissible
deviations: those of the coordinates lie in the null space of the conditions on coordinates, those of the speeds satisfy
all conditions to first order. This is exact, since the conditions hold along every motion that begins on them.

Sources: Meijaard, Papadopoulos, Ruina & Schwab (2007), appendix; Neimark & Fufaev, Dynamics of Nonholonomic Systems
(1972), chapter V.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dynamics.composite import mass_matrix
from ..dynamics.constrained import closed_coordinates, independent_rows
from ..dynamics.constraints import linearized, rows
from ..dynamics.kinematics import coordinate_rates
from ..dynamics.motion import motion
from ..dynamics.state import State
from ..errors import ModelError
from ..model.model import Model
from ..scalar.algebra import floats
from ..scalar.dual import slope_of, value_of
from .contact_modes import sticking_only
from .linear_model import LinearModel
from .operating_point import along, perturbed, tangent_drift, tangent_names

Array = NDArray[np.float64]
SMALL = 10**-9
STEP = 20
"""Steps a radian of the fastest speed by which a motion is followed whose dependent speeds change."""


@dataclass(frozen=True)
class Choice:
    """Indices of the independent speeds, and of the independent deviations: the same ones, then those carried."""

    speeds: tuple[int, ...]
    carried: tuple[int, ...]
    dependent_speeds: tuple[int, ...]
    dependent: tuple[int, ...]  # deviations
    active: tuple[int, ...]


def constrained(
    model: Model,
    q: Sequence[float],
    u: Sequence[float],
    given: frozenset[str],
    numbers: Mapping[Any, float],
    inputs: Sequence[str],
    independent: Sequence[str],
) -> LinearModel:
    """About an equilibrium or a steady motion; coordinates and speeds not given follow from the constraints."""
    from .linearize import check_balance, check_same

    values = {p.name: numbers[p.symbol] for p in model.parameters}
    speeds = {name: j for j, name in enumerate(model.speed_names)}
    held = [j for name, j in speeds.items() if name.removesuffix("'") in given]
    q = closed_coordinates(model, q, values=values, held=held)
    start = State(model, floats, 0, q, u, numbers)
    u = _speeds(model, start, [speeds[name] for name in given if name in speeds])
    state = State(model, floats, 0, q, u, numbers)
    active = independent_rows(model, state)
    choice = _choice(model, state, active, independent)
    if not choice.speeds:
        raise ModelError(
            f"The constraints and drives of '{model.name}' leave it no freedom: it has no small motions to linearise."
        )
    names = tangent_names(model)
    first = _terms(model, q, u, 0, numbers, inputs, choice)
    check_balance(
        model,
        first["udot"][list(choice.speeds)],
        first["size"][list(choice.speeds)],
        [names[j] for j in choice.speeds],
        "the accelerations of its independent coordinates are",
    )
    fastest = max((abs(x) for x in u), default=0)
    carried = [names[j] for j in choice.carried]
    if fastest > 0:
        kept = _that_matter(first, len(choice.speeds))
        for t, later_q, later_u in _later(model, q, u, first, numbers, fastest, active):
            later = _terms(model, later_q, later_u, t, numbers, inputs, choice)
            for key in ("M", "C", "K", "B"):
                check_same(model, first[key], later[key], key)
            check_same(model, first["E"][kept], later["E"][kept], "E")
            moving = np.abs(later["E"] - first["E"]).max(initial=0) + np.abs(
                later["E_rates"] - first["E_rates"]
            ).max(initial=0)
            if moving > 10**4 * SMALL * np.abs(first["E_rates"]).max(initial=1) and not kept.any():
                # what is carried does not act back, and follows at rates that change with time: it is left out
                carried = []
    terms = {key: first[key] for key in "MCKB"}
    if carried:
        terms.update({key: first[key] for key in ("K_carried", "E", "E_rates")})
    return LinearModel(
        model,
        [names[j] for j in choice.speeds],
        inputs,
        terms,
        point={
            **dict(zip(model.coordinate_names, q, strict=True)),
            **dict(zip(model.speed_names, u, strict=True)),
        },
        values=values,
        carried=carried,
    )


def constrained_along(
    model: Model,
    q: Sequence[Array],
    u: Sequence[Array],
    times: Array,
    shape: tuple[int, ...],
    numbers: Mapping[Any, float],
    inputs: Sequence[str],
    independent: Sequence[str],
) -> LinearModel:
    """Along a trajectory, one time after another; the independent coordinates are those of its first time."""
    Q, U = np.array(q, dtype=float).T, np.array(u, dtype=float).T
    state = State(model, floats, float(times[0]), Q[0].tolist(), U[0].tolist(), numbers)
    choice = _choice(model, state, independent_rows(model, state), independent)
    found = [
        _terms(model, a.tolist(), b.tolist(), float(t), numbers, inputs, choice)
        for t, a, b in zip(times, Q, U, strict=True)
    ]
    names = tangent_names(model)
    keys = ("M", "C", "K", "B", *(("K_carried", "E", "E_rates") if choice.carried else ()))
    terms = {key: np.array([one[key] for one in found]) for key in keys}
    terms = {key: x.reshape(*shape, *x.shape[1:]) for key, x in terms.items()}
    return LinearModel(
        model,
        [names[j] for j in choice.speeds],
        inputs,
        terms,
        point={
            **{name: x.reshape(shape) for name, x in zip(model.coordinate_names, q, strict=True)},
            **{name: x.reshape(shape) for name, x in zip(model.speed_names, u, strict=True)},
        },
        values={p.name: numbers[p.symbol] for p in model.parameters},
        times=times.reshape(shape),
        carried=[names[j] for j in choice.carried],
    )


def _speeds(model: Model, state: State, held: Sequence[int]) -> list[float]:
    """Speeds that satisfy all conditions, those held as given and the others as small as possible."""
    given = linearized(model, state)
    G = np.array(given.matrix, dtype=float).reshape(-1, model.n_u)
    rate = np.array(given.rate, dtype=float)
    free = [j for j in range(model.n_u) if j not in set(held)]
    u = np.array(state.u, dtype=float)
    if free:
        step = np.linalg.lstsq(G[:, free], -rate, rcond=SMALL)[0]
        u[free] += step
        rate = rate + G[:, free] @ step
    size = SMALL * np.abs(G).max(initial=0) * np.abs(u).max(initial=0)
    missed = {kind.name: r for kind, r in zip(rows(model), rate, strict=True) if abs(r) > size}
    if missed:
        shown = ", ".join(f"{name}: {r:.6g}" for name, r in missed.items())
        raise ModelError(
            f"The speeds given in `about` do not satisfy the constraints of '{model.name}': they miss {shown}. "
            "Leave out those "
            "that follow from the others."
        )
    return u.tolist()


def _choice(model: Model, state: State, active: Sequence[int], independent: Sequence[str]) -> Choice:
    """Independent speeds and deviations; where they are not named, those are dependent that the conditions fix best."""
    names = tangent_names(model)
    n = model.n_u
    kinds = rows(model)
    given = linearized(model, state)
    sticking_only(given, "A linearization")
    G = np.array([given.matrix[i] for i in active], dtype=float).reshape(-1, n)
    scaled = G / np.sqrt(np.array([row[i] for i, row in enumerate(mass_matrix(model, state))], dtype=float))
    holonomic = np.array([not kinds[i].on_speeds for i in active], dtype=bool)
    named = [names.index(name) for name in independent]
    wanted = n - len(active)
    if named and len(named) != wanted:
        raise ModelError(
            f"Expected {wanted} independent coordinates of '{model.name}' ({n} speeds, {len(active)} conditions), got "
            f"{len(named)}: {', '.join(independent)}."
        )
    rest = [j for j in range(n) if j not in named]
    # the conditions on coordinates first: what they make dependent is dependent among the speeds too
    dependent = _pivots(scaled[holonomic], rest)
    reduced = _eliminated(scaled[~holonomic], scaled[holonomic], dependent)
    further = _pivots(reduced, [j for j in rest if j not in dependent])
    if len(dependent) + len(further) < len(active):
        raise ModelError(
            f"The coordinates {', '.join(independent)} are not independent: with them held, '{model.name}' can "
            "still move, and "
            "the constraints relate them. Name others, or leave the choice out."
        )
    fixed = {*dependent, *further}
    speeds = named or [j for j in range(n) if j not in fixed]
    carried = [j for j in range(n) if j not in set(speeds) | set(dependent)]
    return Choice(
        tuple(speeds), tuple(carried), tuple(sorted(fixed)), tuple(sorted(dependent)), tuple(active)
    )


def _pivots(G: Array, columns: Sequence[int]) -> list[int]:
    """As many columns as G has rows, the best conditioned among those given."""
    from scipy.linalg import qr

    if not len(G) or not columns:
        return []
    R, order = qr(G[:, columns], mode="r", pivoting=True)
    sizes = np.abs(np.diagonal(R))
    rank = int(np.sum(sizes > SMALL * np.abs(G).max()))
    return [columns[k] for k in order[: min(rank, len(G))]]


def _eliminated(lower: Array, upper: Array, pivots: Sequence[int]) -> Array:
    """Rows of ``lower`` with the pivot columns removed by rows of ``upper``."""
    if not len(upper) or not len(lower):
        return lower
    return lower - lower[:, pivots] @ np.linalg.solve(upper[:, pivots], upper)


def _terms(
    model: Model,
    q: Sequence[float],
    u: Sequence[float],
    t: float,
    numbers: Mapping[Any, float],
    inputs: Sequence[str],
    choice: Choice,
) -> dict[str, Any]:
    n = model.n_u
    kinds = rows(model)
    symbols = {p.name: p.symbol for p in model.parameters}
    parameters = [name for name in inputs if name in symbols]
    dual = perturbed(model, floats, q, u, t, numbers, [symbols[name] for name in parameters])
    moved = motion(model, dual, choice.active).udot
    conditions = linearized(model, dual).rate
    plain = State(model, floats, t, q, u, numbers)
    G = np.array([linearized(model, plain).matrix[i] for i in choice.active], dtype=float).reshape(-1, n)
    M = np.array(mass_matrix(model, plain), dtype=float)
    holonomic = [k for k, i in enumerate(choice.active) if not kinds[i].on_speeds]

    def slopes(xs: Sequence[Any], start: int, count: int) -> Array:
        return np.array([[slope_of(x, start + j) for j in range(count)] for x in xs], dtype=float).reshape(
            len(xs), count
        )

    by_q, by_u = slopes(moved, 0, n), slopes(moved, n, n)
    by_input = slopes(moved, 3 * n, len(parameters))
    speeds, carried = list(choice.speeds), list(choice.carried)
    free = [*speeds, *carried]
    # ξ = T p
    T = np.zeros((n, len(free)))
    T[free, range(len(free))] = 1
    if choice.dependent:
        fixed, H = list(choice.dependent), G[holonomic]
        T[fixed] = -np.linalg.solve(H[:, fixed], H[:, free])
    # δu = S v + P p, with ψ = 0 to first order
    fixed = list(choice.dependent_speeds)
    S = np.zeros((n, len(speeds)))
    S[speeds, range(len(speeds))] = 1
    P = np.zeros((n, len(free)))
    if fixed:
        S[fixed] = -np.linalg.solve(G[:, fixed], G[:, speeds])
        bend = slopes([conditions[i] for i in choice.active], 0, n) @ T
        P[fixed] = -np.linalg.solve(G[:, fixed], bend)
    A = np.array(tangent_drift(model, u), dtype=float)
    # p' = v + (P + A T) p in the rows of the independent speeds; w = p' takes the place of v
    drift = P + A @ T
    to_w = drift[speeds]
    v_by_p = (by_u @ P + by_q @ T)[speeds]
    v_by_v = (by_u @ S)[speeds]
    m = len(speeds)
    # w' = v' + to_w p',   p' = (w, E p + E_rates w)
    E = drift[carried] - S[carried] @ to_w
    E_rates = S[carried]
    p_by_w = np.vstack([np.eye(m), E_rates])
    p_by_p = np.vstack([np.zeros((m, len(free))), E])
    w_by_w = v_by_v + to_w @ p_by_w
    w_by_p = v_by_p - v_by_v @ to_w + to_w @ p_by_p
    reduced = S.T @ M @ S
    own = np.sqrt(np.diagonal(reduced))
    reduced[np.abs(reduced) <= 10 * np.finfo(float).eps * np.outer(own, own)] = 0  # round-off of exact zeros
    names = tangent_names(model)
    B = np.zeros((m, len(inputs)))
    for k, name in enumerate(inputs):
        if name in symbols:
            B[:, k] = reduced @ by_input[speeds, parameters.index(name)]
        else:
            B[:, k] = S[names.index(name)]
    C, K = -reduced @ w_by_w, -reduced @ w_by_p
    for X in (C, K):  # round-off of exact zeros
        X[
            np.abs(X)
            <= 10
            * np.finfo(float).eps
            * np.abs(reduced).max()
            * np.abs(np.concatenate([by_q, by_u])).max(initial=0)
        ] = 0
    udot = np.array([value_of(x) for x in moved], dtype=float)
    fast = np.abs(u).max(initial=0)
    return {
        "M": reduced, "C": C, "K": K[:, :m], "K_carried": K[:, m:], "B": B, "E": E, "E_rates": E_rates,
        "udot": udot,
        # an acceleration that vanishes in all derivatives too is round-off of the greatest
        "size": np.full(n, (np.abs(by_q).sum(axis=1) + (1 + fast) * np.abs(by_u).sum(axis=1)).max(initial=0) + fast**2),
    }  # fmt: skip


def _that_matter(terms: Mapping[str, Any], m: int) -> NDArray[np.bool_]:
    """Which carried deviations act back on the independent ones, directly or through others."""
    K, E = terms["K_carried"], terms["E"][:, m:]
    size = max(np.abs(terms["K"]).max(initial=0), np.abs(K).max(initial=0))
    matter = np.any(np.abs(K) > SMALL * size, axis=0)
    for _ in range(len(matter)):
        matter = matter | np.any(np.abs(E[matter]) > SMALL * np.abs(E).max(initial=0), axis=0)
    return matter


def _later(
    model: Model,
    q: Sequence[float],
    u: Sequence[float],
    first: Mapping[str, Any],
    numbers: Mapping[Any, float],
    fastest: float,
    active: Sequence[int],
) -> list[tuple[float, list[float], list[float]]]:
    """The motion a little and half a turn later, where all speeds are constant; else a step of it later."""
    if np.abs(first["udot"]).max(initial=0) <= SMALL * fastest**2:
        times = [k / fastest for k in (1, 3)]
        return [(t, list(along(model, floats, q, u, t, numbers)), list(u)) for t in times]

    def rates(y: Array) -> Array:
        state = State(model, floats, 0, y[: model.n_q].tolist(), y[model.n_q :].tolist(), numbers)
        return np.array([*coordinate_rates(model, state), *motion(model, state, active).udot], dtype=float)

    h = 1 / (STEP * fastest)
    y = np.array([*q, *u], dtype=float)
    k1 = rates(y)
    k2 = rates(y + h / 2 * k1)
    k3 = rates(y + h / 2 * k2)
    k4 = rates(y + h * k3)
    y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)  # Runge-Kutta of order 4
    return [(h, y[: model.n_q].tolist(), y[model.n_q :].tolist())]
