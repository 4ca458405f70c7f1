"""Linear equations of a machine with constraints, at numbers, in coordinates that are independent.

    φ(q) = 0,   ψ = G u + g = 0,      G_h T = 0,   δu = S v + P p,   ξ = T p

The operating point is closed, the independent speeds are chosen by pivoting, the equations reduced (`reduction`), and
looked at again a little later: those about a steady motion may not change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dynamics.composite import mass_matrix
from ...dynamics.constrained import (
    DEPENDENT,
    STEPS,
    constrained_dynamics,
    independent_of,
    no_direction,
    not_met,
)
from ...dynamics.constraints import linearized, rows
from ...dynamics.kinematics import coordinate_rates
from ...dynamics.mobility import check_mobility
from ...dynamics.state import State
from ...errors import ModelError
from ...model.model import Model
from ...scalar.algebra import floats
from ..free_body.contact_modes import sticking_only
from .checks import SMALL, Checks, check_untouched
from .linear_model import LinearModel
from .operating_point import moved, tangent_names
from .recorded_functions import Points, Recorded
from .reduction import Choice, Slopes, drifts, reduced, slopes

Array = NDArray[np.float64]
ROUNDING = 10 * float(np.finfo(float).eps)
"""Relative size of what is round-off of an exact zero."""
STEP = 20
"""Steps a radian of the fastest speed by which a motion is followed whose dependent speeds change."""


def constrained(
    programs: Recorded,
    points: Points,
    given: frozenset[str],
    inputs: Sequence[str],
    independent: Sequence[str],
    checks: Checks,
) -> LinearModel:
    """About equilibria or steady motions; coordinates and speeds not given follow from the constraints."""
    model = programs.model
    speeds = {name: j for j, name in enumerate(model.speed_names)}
    held = [j for name, j in speeds.items() if name.removesuffix("'") in given]
    points = _closed(programs, points, held)
    points = _with_speeds(programs, points, [speeds[name] for name in given if name in speeds], checks)
    choice = _choice(programs, points, independent, checks)
    if not choice.speeds:
        raise ModelError(
            f"The constraints and drives of '{model.name}' leave it no freedom: it has no small motions to linearise."
        )
    names = tangent_names(model)
    first = _terms(programs, points, inputs, choice)
    own = list(choice.speeds)
    checks.balance(
        first["udot"][:, own],
        first["size"][:, own],
        [names[j] for j in own],
        "the accelerations of its independent coordinates are",
    )
    carried = [names[j] for j in choice.carried]
    fastest = np.abs(points.u).max(axis=1, initial=0)
    go = np.flatnonzero(fastest > 0)
    if len(go):
        start, before = points[go], {key: x[go] for key, x in first.items()}
        kept = _that_matter(before, len(own))
        for later_points, which in _later(programs, start, before, fastest[go], choice.active):
            later = _terms(programs, later_points, inputs, choice)
            same = {key: x[which] for key, x in before.items()}
            for key in ("M", "C", "K", "B"):
                checks.same(same[key], later[key], key, go[which])
            held_rows = kept[which][:, :, None]
            checks.same(same["E"] * held_rows, later["E"] * held_rows, "E", go[which])
            moving = sum(_greatest(later[key] - same[key]) for key in ("E", "E_rates"))
            if np.any(
                (moving > 10**4 * SMALL * np.maximum(_greatest(same["E_rates"]), 1))
                & ~kept[which].any(axis=1)
            ):
                # what is carried does not act back, and follows at rates that change with time: it is left out
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
    """Along a trajectory; the independent coordinates are those of its first time."""
    model = programs.model
    choice = _choice(programs, points, independent, checks)
    found = _terms(programs, points, inputs, choice)
    names = tangent_names(model)
    keys = ("M", "C", "K", "B", *(("K_carried", "E", "E_rates") if choice.carried else ()))
    return LinearModel(
        model,
        [names[j] for j in choice.speeds],
        inputs,
        {key: found[key].reshape(*shape, *found[key].shape[1:]) for key in keys},
        point=checks.named(points.q, points.u),
        values={p.name: numbers[p.symbol] for p in model.parameters},
        times=points.t.reshape(shape),
        carried=[names[j] for j in choice.carried],
    )


def _conditions(state: State) -> dict[str, Any]:
    given = linearized(state.model, state)
    return {"residual": given.residual, "rate": given.rate, "matrix": given.matrix}


def _closed(programs: Recorded, points: Points, held: Sequence[int]) -> Points:
    """Coordinates that satisfy the conditions on them, by the steps of `closed_coordinates`, all states at once."""
    model = programs.model
    active = [i for i, kind in enumerate(rows(model)) if not kind.on_speeds]
    free = [j for j in range(model.n_u) if j not in set(held)]
    q = points.q.copy()
    best, stalled = np.full(len(points), np.inf), np.zeros(len(points), dtype=int)
    small = DEPENDENT * (1 + np.abs(q).max(axis=1, initial=0))
    todo = np.arange(len(points)) if active else np.arange(0)
    for _ in range(STEPS):
        if not len(todo):
            break
        found = programs("conditions", _conditions, points[todo].at(q=q[todo]))
        phi, G = found["residual"][:, active], found["matrix"][:, active][..., free]
        finite = np.isfinite(phi).all(axis=1) & np.isfinite(G).all(axis=(1, 2))
        if not finite.all():
            raise no_direction(model, q[todo[np.argmin(finite)]].tolist())
        size = np.abs(phi).max(axis=1, initial=0)
        stalled[todo] = np.where(size >= best[todo], stalled[todo] + 1, 0)
        best[todo] = np.minimum(best[todo], size)
        go = ~((size == 0) | (stalled[todo] >= 2) & (size < small[todo]))
        todo, phi, G = todo[go], phi[go], G[go]
        if not len(todo):
            break
        step = np.zeros((len(todo), model.n_u))
        step[:, free] = -(np.linalg.pinv(G, rcond=DEPENDENT) @ phi[..., None])[..., 0]
        step /= np.maximum(1, np.abs(step).max(axis=1, initial=0))[:, None]
        q[todo] += programs("rates", _rates, points[todo].at(q=q[todo], u=step))["rates"]
        for start in model.quaternions:
            q[todo, start : start + 4] /= np.linalg.norm(q[todo, start : start + 4], axis=1)[:, None]
    for i in todo:
        values = {p.name: float(x) for p, x in zip(model.parameters, points.values[i], strict=True)}
        found_size, refusal = not_met(model, q[i].tolist(), float(points.t[i]), values, STEPS)
        if not found_size < small[i]:
            raise refusal
    return points.at(q=q)


def _rates(state: State) -> dict[str, Any]:
    return {"rates": coordinate_rates(state.model, state)}


def _with_speeds(programs: Recorded, points: Points, held: Sequence[int], checks: Checks) -> Points:
    """Speeds that satisfy all conditions, those held as given and the others as small as possible."""
    model = programs.model
    given = programs("conditions", _conditions, points)
    G, rate = given["matrix"].reshape(len(points), -1, model.n_u), given["rate"]
    free = [j for j in range(model.n_u) if j not in set(held)]
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
    """Independent speeds and deviations; where they are not named, those are dependent that the conditions fix best.

    They are chosen at the first state, and must do at all others.
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
    choice = Choice(
        tuple(speeds), tuple(carried), tuple(sorted(fixed)), tuple(sorted(dependent)), tuple(active)
    )
    _check_choice(model, choice, scaled_all, M, checks)
    return choice


def _check_choice(model: Model, choice: Choice, scaled: Array, M: Array, checks: Checks) -> None:
    """Refuse states where other conditions are independent, or other coordinates, than at the first one."""
    if len(scaled) == 1 or not choice.active:
        return
    kept = scaled[:, list(choice.active)]
    for block in (scaled, kept, kept[..., list(choice.dependent_speeds)]):
        sizes = np.linalg.svd(block, compute_uv=False)
        rank = np.sum(sizes > DEPENDENT * sizes[:, :1], axis=1)
        bad = ~np.isfinite(M).all(axis=(1, 2)) | (rank != len(choice.active))
        if bad.any():
            i = int(np.argmax(bad))
            raise ModelError(
                f"The independent coordinates of '{model.name}' chosen at the first state do not do{checks.which(i)}: "
                "other conditions are independent there, or its coordinates can no longer move each by itself. Ask for "
                "these separately, or name others with independent=."
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


def _terms(programs: Recorded, points: Points, inputs: Sequence[str], choice: Choice) -> dict[str, Any]:
    model = programs.model
    found = programs(("motion", choice.active), lambda state: _motion(state, choice.active), points)
    udot, multipliers = found["udot"], found["multipliers"]
    made = programs(
        ("slopes", choice, tuple(inputs)),
        lambda state, a, b: _slopes(state, a, b, inputs, choice),
        points, udot, multipliers,
    )  # fmt: skip
    slopes_at = Slopes(**{f.name: made[f.name] for f in fields(Slopes)})
    _check_inputs(model, slopes_at, inputs)
    terms = reduced(model, slopes_at, (made["drift"], made["drift_rate"]), choice, np.linalg.solve)
    by_q, by_u = (np.abs(np.linalg.solve(slopes_at.M, x)) for x in (slopes_at.by_q, slopes_at.by_u))
    own = np.sqrt(np.diagonal(terms["M"], axis1=1, axis2=2))
    terms["M"] = np.where(np.abs(terms["M"]) <= ROUNDING * own[:, :, None] * own[:, None, :], 0, terms["M"])
    size = ROUNDING * _greatest(terms["M"]) * np.maximum(_greatest(by_q), _greatest(by_u))
    for key in ("C", "K", "K_carried"):
        terms[key] = np.where(np.abs(terms[key]) <= size[:, None, None], 0, terms[key])
    fast = np.abs(points.u).max(axis=1, initial=0)
    # an acceleration that vanishes in all derivatives too is round-off of the greatest
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
    state: State, udot: Sequence[Any], multipliers: Sequence[Any], inputs: Sequence[str], choice: Choice
) -> dict[str, Any]:
    """Those of `reduction`, with the multipliers of the motion."""
    known = np.array(multipliers, dtype=object)
    values = {p.symbol: state.values[p.symbol] for p in state.model.parameters}
    found = slopes(
        state.model,
        state.field,
        state.q,
        state.u,
        udot,
        state.t,
        values,
        inputs,
        choice,
        lambda A, B: known,
        _same,
    )
    first, second = drifts(state.model, state.u, udot, _same)
    return {**{f.name: getattr(found, f.name) for f in fields(found)}, "drift": first, "drift_rate": second}


def _same(x: Any) -> Any:
    return x


def _greatest(x: Array) -> Array:
    """The greatest magnitude in each matrix."""
    found: Array = np.abs(x).max(axis=(-1, -2), initial=0)
    return found


def _check_inputs(model: Model, found: Slopes, inputs: Sequence[str]) -> None:
    """Refuse inputs that change the constraints: the deviations would not satisfy them."""
    parameters = {p.name for p in model.parameters}
    size = SMALL * _greatest(found.G)
    moved = np.any(np.abs(found.touched) > size[:, None, None], axis=(0, 1))
    check_untouched(model, [name for name in inputs if name in parameters], moved)


def _that_matter(terms: Mapping[str, Any], m: int) -> NDArray[np.bool_]:
    """Which carried deviations act back on the independent ones, directly or through others; a row per state."""
    back, among = np.abs(terms["K_carried"]), np.abs(terms["E"][..., m:])
    size = np.maximum(_greatest(terms["K"]), _greatest(back))
    matter = np.any(back > SMALL * size[:, None, None], axis=1)
    edges = among > SMALL * _greatest(among)[:, None, None]
    for _ in range(matter.shape[1]):
        matter = matter | np.any(edges & matter[:, :, None], axis=1)
    return matter


def _later(
    programs: Recorded, points: Points, first: Mapping[str, Any], fastest: Array, active: Sequence[int]
) -> list[tuple[Points, NDArray[np.int_]]]:
    """The motions a little and half a turn later, where all speeds are constant; else a step of them later."""
    constant = np.abs(first["udot"]).max(axis=1, initial=0) <= SMALL * fastest**2
    result = []
    still, other = np.flatnonzero(constant), np.flatnonzero(~constant)
    if len(still):
        result = [(moved(programs.model, points[still], k / fastest[still]), still) for k in (1, 3)]
    if not len(other):
        return result
    start, n_q = points[other], programs.model.n_q

    def rates(y: Array) -> Array:
        found = programs(
            ("motion", tuple(active)), lambda s: _motion(s, active), start.at(q=y[:, :n_q], u=y[:, n_q:])
        )
        return np.concatenate([found["rates"], found["udot"]], axis=1)

    h = 1 / (STEP * fastest[other])[:, None]
    y = np.concatenate([start.q, start.u], axis=1)
    k1 = rates(y)
    k2 = rates(y + h / 2 * k1)
    k3 = rates(y + h / 2 * k2)
    k4 = rates(y + h * k3)
    y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)  # Runge-Kutta of order 4
    return [*result, (start.at(q=y[:, :n_q], u=y[:, n_q:], t=start.t + h[:, 0]), other)]
