"""Linear equations of a machine with constraints, at numbers, in coordinates that are independent.

    φ(q) = 0,   ψ = G u + g = 0,      G_h T = 0,   δu = S v + P p,   ξ = T p

The operating point is closed, the independent speeds are chosen by pivoting, the equations reduced (`reduction`), and
looked at again a little later: those about a steady motion may not change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
from .contact_modes import sticking_only
from .linear_model import LinearModel
from .operating_point import along, tangent_names
from .reduction import Choice, Slopes, reduced, slopes

Array = NDArray[np.float64]
SMALL = 10**-9
ROUNDING = 10 * float(np.finfo(float).eps)
"""Relative size of what is round-off of an exact zero."""
STEP = 20
"""Steps a radian of the fastest speed by which a motion is followed whose dependent speeds change."""


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
    terms = {key: first[key] for key in (*"MCKB", "T", "S", "P", "to_rates", "udot")}
    terms["chosen"] = choice
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
    udot = motion(model, State(model, floats, t, q, u, numbers), choice.active).udot
    found = slopes(model, floats, q, u, udot, t, numbers, inputs, choice, _solve, float)
    _check_inputs(model, found, inputs)
    objects = reduced(model, found, u, udot, choice, _solve, float)
    terms = {key: np.array(x, dtype=float).reshape(x.shape) for key, x in objects.items()}
    M = np.array(found.M, dtype=float)
    by_q, by_u = (np.linalg.solve(M, np.array(x, dtype=float)) for x in (found.by_q, found.by_u))
    own = np.sqrt(np.diagonal(terms["M"]))
    terms["M"][np.abs(terms["M"]) <= ROUNDING * np.outer(own, own)] = 0
    size = ROUNDING * np.abs(terms["M"]).max() * np.abs(np.concatenate([by_q, by_u])).max(initial=0)
    for key in ("C", "K", "K_carried"):
        terms[key][np.abs(terms[key]) <= size] = 0
    fast = np.abs(u).max(initial=0)
    return {
        **terms,
        "udot": np.array(udot, dtype=float),
        # an acceleration that vanishes in all derivatives too is round-off of the greatest
        "size": np.full(n, (np.abs(by_q).sum(axis=1) + (1 + fast) * np.abs(by_u).sum(axis=1)).max(initial=0) + fast**2),
    }  # fmt: skip


def _solve(A: Any, B: Any) -> Any:
    return np.linalg.solve(np.array(A, dtype=float), np.array(B, dtype=float)).astype(object)


def _check_inputs(model: Model, found: Slopes, inputs: Sequence[str]) -> None:
    """Refuse inputs that change the constraints: the deviations would not satisfy them."""
    parameters = {p.name for p in model.parameters}
    size = SMALL * np.abs(np.array(found.G, dtype=float)).max(initial=0)
    moved = np.any(np.abs(np.array(found.touched, dtype=float)) > size, axis=0)
    check_untouched(model, [name for name in inputs if name in parameters], moved)


def check_untouched(model: Model, inputs: Sequence[str], moved: Sequence[Any]) -> None:
    """Refuse inputs that the constraints hold."""
    for name, one in zip(inputs, moved, strict=True):
        if one:
            raise ModelError(
                f"The input '{name}' stands in the constraints of '{model.name}': its deviations would move them. "
                "Take it out of `inputs`; inputs are loads, parameters of loads and of masses, and forces along "
                "coordinates."
            )


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
