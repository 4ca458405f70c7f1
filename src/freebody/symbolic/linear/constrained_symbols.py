"""Linear equations of a machine with constraints, in symbols and in independent coordinates.

The user names some coordinates and speeds of the operating point. Coordinates not named follow from the conditions that
are linear in them, else they are zero. Speeds not named follow from ψ = G u + g = 0. Some of these speeds may change
with time (the velocity of a wheel's centre along a circle): they are functions of time, and their coordinates are
symbols on which the linear equations may not depend.

The file is longer than others: each step uses all that the steps before found about the operating point.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.linearized import linearized
from ...dynamics.state import State
from ...errors import ModelError
from ...model.model import Model
from ...scalar.algebra import Scalar
from ...scalar.polynomial import Ring
from ...scalar.ratio import Ratio
from ..printing.display import displayed, text
from ..printing.systems import Row, Terms, added, collect, eliminate, scaled
from .checks import balanced, check_count, check_untouched, not_independent, steady
from .linear_model import LinearModel
from .operating_point import OperatingPoint, along, tangent_names
from .reduction import Choice, drifts, reduced, slopes


@dataclass(frozen=True)
class Motion:
    """q(t), u(t) and u'(t) of a steady motion.

    ``varying`` are the indices of the speeds that change, ``moving`` the mask of the generators that change with time.
    """

    q: tuple[Scalar, ...]
    u: tuple[Scalar, ...]
    udot: tuple[Scalar, ...]
    varying: tuple[int, ...]
    moving: int


def constrained_symbols(
    point: OperatingPoint, start: State, inputs: Sequence[str], independent: Sequence[str]
) -> LinearModel:
    """Linear equations about an equilibrium or a steady motion.

    ``start`` has the time as a symbol, and canonical values of the coordinates and speeds at time zero.
    """
    model, ring = start.model, _ring(start)
    q = _closed(point, start)
    u = _consistent_speeds(point, _at(start, q, start.u, 0))
    motion = _motion(point, _at(start, q, u))
    at = _at(start, motion.q, motion.u)
    choice = _choice(at, motion, point, independent)
    if not choice.speeds:
        raise ModelError(
            f"The constraints and drives of '{model.name}' leave it no freedom: it has no small motions to linearise."
        )

    def entry(x: Scalar) -> Ratio:
        return Ratio(ring, x)

    def solve(A: Any, B: Any) -> Any:
        return _solved(ring, A, B)

    derivatives = slopes(at, motion.udot, inputs, choice, solve, entry)
    parameters = {p.name for p in model.parameters}
    check_untouched(
        model,
        [name for name in inputs if name in parameters],
        [any(column) for column in derivatives.touched.T],
    )
    terms = reduced(model, derivatives, drifts(model, motion.u, motion.udot, entry), choice, solve)
    names = tangent_names(model)
    chosen = [names[j] for j in choice.speeds]
    if not point.rounded:
        balanced(
            model, ring, [_whole(ring, x) for x in terms["residual"]], chosen, motion.moving,
            "with the constraint forces eliminated, the equations of its independent coordinates leave",
        )  # fmt: skip
    canonical: dict[str, Any] = {
        key: [[_whole(ring, x) for x in row] for row in terms[key]]
        for key in ("M", "C", "K", "K_carried", "B", "E", "E_rates", "T", "S", "P", "to_rates")
    }
    carried = [names[j] for j in choice.carried]
    steady(model, ring, canonical, chosen, motion.moving)
    if carried and _changing(ring, canonical, motion.moving):
        _check_carried(model, ring, canonical, carried, motion.moving)
        carried = []
    if not carried:
        for key in ("K_carried", "E", "E_rates"):
            del canonical[key]
    canonical["chosen"] = choice
    canonical["udot"] = list(motion.udot)
    shown = [displayed(x, ring) for x in (*q, *u)]
    return LinearModel(
        model,
        chosen,
        inputs,
        canonical,
        ring=ring,
        point=dict(zip(model.state_names, shown, strict=True)),
        carried=carried,
    )


# -- the operating point --------------------------------------------------------------------------


def _ring(state: State) -> Ring:
    """Return the ring of a state of canonical polynomials."""
    return cast(Ring, state.field)


def _at(state: State, q: Sequence[Scalar], u: Sequence[Scalar], t: Scalar | None = None) -> State:
    """Return another state of the same machine with the same parameters, at the same time unless ``t`` is given."""
    return State(state.model, state.field, state.t if t is None else t, q, u, state.values)


def _closed(point: OperatingPoint, start: State) -> tuple[Scalar, ...]:
    """Return coordinates with φ = 0, solved for coordinates not named in which φ is linear."""
    model, ring, q, u = start.model, _ring(start), list(start.q), start.u
    kinds = rows(model)
    on_coordinates = [i for i, kind in enumerate(kinds) if not kind.on_speeds]
    free = {
        i: ring.generator(c.symbol, "coordinate")
        for i, c in enumerate(model.coordinates)
        if c.kind == "scalar" and c.name not in point.names
    }
    residual = [linearized(model, _at(start, q, u, 0)).residual[i] for i in on_coordinates]
    while any(x != 0 for x in residual) and free:
        trial = [free.get(i, x) for i, x in enumerate(q)]
        phi = [linearized(model, _at(start, trial, u, 0)).residual[i] for i in on_coordinates]
        # an angle occurs in sines and cosines: it keeps its value zero
        inside = 0
        for x in phi:
            for g in ring.used(ring.coerce(x)):
                if g.kind not in ("coordinate", "inverse"):
                    inside |= g.depends
        angles = [i for i, x in free.items() if x.mask & inside]
        if angles:
            for i in angles:
                del free[i]
            continue
        places = {x.mask.bit_length() - 1: (i, 1) for i, x in free.items()}
        system = [
            Row(kinds[i].name, collect(x, places, ring)) for i, x in zip(on_coordinates, phi, strict=True)
        ]
        solved, _ = eliminate(system, [sorted(free)])
        result = list(q)
        for i, terms in solved.items():
            # undetermined coordinates are zero
            result[i] = _whole(ring, terms.get((), Ratio(ring, 0)))
        q = result
        residual = [linearized(model, _at(start, q, u, 0)).residual[i] for i in on_coordinates]
        break
    violations = {kinds[i].name: x for i, x in zip(on_coordinates, residual, strict=True) if x != 0}
    if violations and not point.rounded:
        shown = "; ".join(f"{name}: {text(x, ring)}" for name, x in violations.items())
        unnamed = [c.name for c in model.coordinates if c.name not in point.names and c.kind == "scalar"]
        raise ModelError(
            f"The position given does not satisfy the constraints of '{model.name}': they leave {shown} in place of 0. "
            f"Name the coordinates that are not zero in `about` (not named: {', '.join(unnamed) or 'none'}), "
            "as expressions that close it, or give relations among parameters as where={parameter: expression}; "
            "with values= coordinates not named are found in numbers."
        )
    return tuple(q)


def _consistent_speeds(point: OperatingPoint, state: State) -> tuple[Scalar, ...]:
    """Return speeds with ψ = 0, solved for the speeds not named."""
    model, ring = state.model, _ring(state)
    start = [x if name in point.names else 0 for name, x in zip(model.speed_names, state.u, strict=True)]
    conditions = linearized(model, _at(state, state.q, start))
    if all(x == 0 for x in conditions.rate):
        return tuple(start)
    free = [j for j, name in enumerate(model.speed_names) if name not in point.names]
    system = _conditions(model, ring, conditions.matrix, conditions.rate, free)
    # the speed of a named coordinate stays zero if the others suffice
    named = [j for j in free if model.speed_names[j].removesuffix("'") in point.names]
    solved, contradictions = eliminate(system, [[j for j in free if j not in named], named])
    if contradictions:
        shown = ", ".join(f"{row.name}: {text(_whole(ring, row.terms[()]), ring)}" for row in contradictions)
        raise ModelError(
            f"The speeds given in `about` do not satisfy the constraints of '{model.name}': they miss {shown}. "
            "Leave out those that follow from the others."
        )
    result = list(start)
    for j, terms in solved.items():
        value = terms.get((), Ratio(ring, 0))
        undetermined = sorted({v for monomial in terms for v, _ in monomial} - set(named))
        if value and undetermined:
            names = ", ".join(model.speed_names[v] for v in undetermined)
            raise ModelError(
                f"The speeds given in `about` leave '{model.speed_names[j]}' of '{model.name}' open. Give it as well, "
                f"or {names} (0 where it stands still)."
            )
        result[j] = _whole(ring, value)
    return tuple(result)


def _conditions(
    model: Model, ring: Ring, matrix: Sequence[Scalar], constants: Sequence[Scalar], columns: Sequence[int]
) -> list[Row]:
    """Rows Σ_j G_kj x_j + constant_k of all conditions, over some columns."""
    result = []
    for kind, row, x in zip(rows(model), matrix, constants, strict=True):
        terms: Terms = {((j, 1),): Ratio(ring, row[j]) for j in columns if row[j] != 0}
        if x != 0:
            terms[()] = Ratio(ring, x)
        result.append(Row(kind.name, terms))
    return result


def _motion(point: OperatingPoint, start: State) -> Motion:
    """Return the motion at any time; speeds that follow from the constraints may change."""
    model, ring, u, n = start.model, _ring(start), start.u, start.model.n_u
    varying: tuple[int, ...] = ()
    moving = ring.generator(model.names.atoms["t"]).mask
    names = list(model.coordinate_names)
    while True:
        later = list(along(model, ring, start.q, u, start.t, start.values))
        for j in varying:
            i = names.index(model.speed_names[j].removesuffix("'"))
            later[i] = ring.generator(model.coordinates[i].symbol, "coordinate")
            moving |= later[i].mask
        speeds = _consistent_speeds(point, _at(start, later, u))
        changed = tuple(j for j in range(n) if j in varying or speeds[j] != u[j])
        if changed == varying:
            break
        for j in changed:
            if model.speed_names[j].removesuffix("'") not in names:
                raise ModelError(
                    f"About this motion of '{model.name}' the speed {model.speed_names[j]} changes with time. In "
                    "symbols, use coordinates whose independent speeds are constant (sliders and a gimbal in place of "
                    "a free joint); or give numbers and a trajectory: about=fb.simulate(...)."
                )
        varying = changed
    conditions = linearized(model, _at(start, later, speeds))
    violations = {
        kind.name: x
        for kind, x in zip(rows(model), conditions.residual, strict=True)
        if x != 0 and not kind.on_speeds
    }
    if violations and not point.rounded:
        shown = "; ".join(f"{name}: {text(x, ring)}" for name, x in violations.items())
        raise ModelError(
            f"The motion given leaves the constraints of '{model.name}' as it goes on: {shown} in place of 0. Its "
            "speeds are not constant; linearise about a trajectory (about=fb.simulate(...))."
        )
    udot: list[Scalar] = [0] * n
    solved, contradictions = eliminate(
        _conditions(model, ring, conditions.matrix, conditions.bias, varying), [varying]
    )
    if contradictions:
        shown = "; ".join(
            f"{row.name}: {text(_whole(ring, row.terms[()]), ring)}"
            for row in contradictions
            if () in row.terms
        )
        raise ModelError(
            f"The speeds of the motion given cannot all stay constant: the accelerations of the constraints of "
            f"'{model.name}' leave {shown} in place of 0. Name fewer speeds in `about`, or linearise about "
            "a trajectory."
        )
    for j, terms in solved.items():
        udot[j] = _whole(ring, terms.get((), Ratio(ring, 0)))
    return Motion(tuple(later), tuple(speeds), tuple(udot), varying, moving)


# -- independent speeds and deviations ------------------------------------------------------------


def _choice(at: State, motion: Motion, point: OperatingPoint, independent: Sequence[str]) -> Choice:
    """Choose independent speeds and deviations.

    Dependent are, in this order: speeds that change, coordinates that `about` does not name, and short pivots.
    """
    model, ring, n = at.model, _ring(at), at.model.n_u
    names = tangent_names(model)
    kinds = rows(model)
    G = linearized(model, at).matrix
    named = [names.index(name) for name in independent]
    names_given = {name.removesuffix("'") for name in point.names}
    groups: list[list[int]] = [[], [], []]
    for j in range(n):
        if j not in named:
            groups[0 if j in motion.varying else 1 if names[j] not in names_given else 2].append(j)

    on_coordinates = [i for i, kind in enumerate(kinds) if not kind.on_speeds]
    dependent, unbound = _pivots(ring, G, on_coordinates, groups)
    every = [*dependent.values(), *(i for i, kind in enumerate(kinds) if kind.on_speeds)]
    fixed, more = _pivots(ring, G, every, [list(dependent), *groups])
    if unbound or more:
        check_count(model, independent, len(_pivots(ring, G, range(len(kinds)), [range(n)])[0]))
        raise not_independent(model, independent)
    if named:
        check_count(model, independent, len(fixed))
    speeds = named or [j for j in range(n) if j not in fixed]
    carried = [j for j in range(n) if j not in set(speeds) | set(dependent)]
    if any(j in motion.varying for j in speeds):
        name = names[next(j for j in speeds if j in motion.varying)]
        raise ModelError(
            f"The speed of '{name}' changes along this motion of '{model.name}', so '{name}' cannot be independent. "
            "Name others in `independent`, or leave the choice out."
        )
    active = sorted(fixed.values())
    return Choice(
        tuple(speeds), tuple(carried), tuple(sorted(fixed)), tuple(sorted(dependent)), tuple(active)
    )


def _pivots(
    ring: Ring, G: Sequence[Sequence[Scalar]], conditions: Iterable[int], groups: Iterable[Sequence[int]]
) -> tuple[dict[int, int], int]:
    """Eliminate in some conditions, with pivots from the first group of columns first.

    Returns
    -------
    dict
        Pivot column -> condition.
    int
        Number of conditions without a pivot.
    """
    rows = [
        Row(str(i), {((j, 1),): Ratio(ring, x) for j, x in enumerate(G[i]) if x != 0}) for i in conditions
    ]
    remaining = [row for row in rows if row.terms]
    pivots: dict[int, int] = {}
    for group in groups:
        while (best := _shortest_pivot(remaining, [j for j in group if j not in pivots])) is not None:
            row, j = best
            remaining.remove(row)
            pivots[j] = int(row.name)
            pivot = ((j, 1),)
            for other in remaining:
                if pivot in other.terms:
                    factor = other.terms[pivot] / row.terms[pivot]
                    other.terms = added(other.terms, scaled(row.terms, -factor))
            remaining = [row for row in remaining if row.terms]
    return pivots, len(remaining)


def _shortest_pivot(rows: Sequence[Row], columns: Sequence[int]) -> tuple[Row, int] | None:
    """Return the row and column of the shortest coefficient, then of the shortest row; None if there is none."""
    candidates = [(row, j) for row in rows for j in columns if ((j, 1),) in row.terms]

    def cost(candidate: tuple[Row, int]) -> tuple[int, int, int]:
        row, j = candidate
        c = row.terms[((j, 1),)]
        return 0 if c.is_number else len(c), len(row.terms), -j

    return min(candidates, key=cost, default=None)


# -- checks ---------------------------------------------------------------------------------------


def _changing(ring: Ring, terms: Mapping[str, Any], moving: int) -> bool:
    return any(
        ring.depends(x) & moving for key in ("K_carried", "E", "E_rates") for row in terms[key] for x in row
    )


def _check_carried(
    model: Model, ring: Ring, terms: Mapping[str, Any], carried: Sequence[str], moving: int
) -> None:
    """Raise if a carried deviation with time-dependent equations acts back on the others."""
    for row in terms["K_carried"]:
        for name, x in zip(carried, row, strict=True):
            if x != 0:
                raise ModelError(
                    f"The motion given is balanced, but '{name}' of '{model.name}', which acts back on the other "
                    "deviations, follows them at rates that change with time. Linearise about a trajectory "
                    "(about=fb.simulate(...))."
                )


# -- canonical algebra ----------------------------------------------------------------------------


def _whole(ring: Ring, x: Scalar) -> Scalar:
    return Ratio(ring, x).whole() if not isinstance(x, Ratio) else x.tidy().whole()


def _solved(ring: Ring, A: Any, B: Any) -> Any:
    """Return X with A X = B, by Gauss-Jordan elimination; canonical entries make a zero pivot recognisable."""
    n = len(A)
    right = B.reshape(n, -1)
    table = [[*A[i], *right[i]] for i in range(n)]
    pivot_rows: list[int] = []
    for column in range(n):
        candidates = [i for i in range(n) if i not in pivot_rows and table[i][column] != 0]
        i = min(candidates, key=lambda k: (not table[k][column].is_number, len(table[k][column]), k))
        pivot_rows.append(i)
        pivot = table[i][column]
        table[i] = [x / pivot if x else x for x in table[i]]
        for k in range(n):
            factor = table[k][column]
            if k != i and factor:
                table[k] = [x - factor * y if y else x for x, y in zip(table[k], table[i], strict=True)]
    result = np.empty(right.shape, dtype=object)
    for column, i in enumerate(pivot_rows):
        result[column] = table[i][n:]
    return result.reshape(B.shape)
