"""Linear equations of a machine with constraints, in symbols, in coordinates that are independent.

The operating point names what is known. Coordinates that it does not name and that the conditions hold linearly follow
from them, the others are zero; speeds that it does not name follow from ψ = G u + g = 0. Those that then change with
time (the velocity of a wheel's centre along a circle) are followed as functions of time, and their coordinates as
symbols that nothing may depend on.

The file is longer than others: what is known of the operating point is passed on from step to step.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...dynamics.constraints import linearized, rows
from ...dynamics.state import State
from ...errors import ModelError
from ...model.model import Model
from ...scalar.polynomial import Ring
from ...scalar.ratio import Ratio
from ..printing.display import displayed, text
from ..printing.systems import Row, Terms, collect, eliminate
from .checks import balanced, check_untouched, steady
from .linear_model import LinearModel
from .operating_point import OperatingPoint, along, tangent_names
from .reduction import Choice, drifts, reduced, slopes


@dataclass(frozen=True)
class Motion:
    """q(t), u(t) and u'(t) of a steady motion, the speeds that change, and the mask of what nothing may depend on."""

    q: tuple[Any, ...]
    u: tuple[Any, ...]
    udot: tuple[Any, ...]
    varying: tuple[int, ...]
    moving: int


def constrained_symbols(
    model: Model,
    ring: Ring,
    point: OperatingPoint,
    q: Sequence[Any],
    u: Sequence[Any],
    t: Any,
    values: Mapping[Any, Any],
    inputs: Sequence[str],
    independent: Sequence[str],
) -> LinearModel:
    """About an equilibrium or a steady motion of canonical values ``q`` and ``u`` at the time zero."""
    q = _closed(model, ring, point, q, u, values)
    u = _followed(model, ring, point, 0, q, u, values)
    moved = _motion(model, ring, point, q, u, t, values)
    choice = _choice(model, ring, moved, point, t, values, independent)
    if not choice.speeds:
        raise ModelError(
            f"The constraints and drives of '{model.name}' leave it no freedom: it has no small motions to linearise."
        )

    def entry(x: Any) -> Ratio:
        return Ratio(ring, x)

    def solve(A: Any, B: Any) -> Any:
        return _solved(ring, A, B)

    found = slopes(model, ring, moved.q, moved.u, moved.udot, t, values, inputs, choice, solve, entry)
    parameters = {p.name for p in model.parameters}
    check_untouched(
        model, [name for name in inputs if name in parameters], [any(column) for column in found.touched.T]
    )
    terms = reduced(model, found, drifts(model, moved.u, moved.udot, entry), choice, solve)
    names = tangent_names(model)
    chosen = [names[j] for j in choice.speeds]
    if not point.rounded:
        balanced(
            model, ring, [_whole(ring, x) for x in terms["residual"]], chosen, moved.moving,
            "with the constraint forces eliminated, the equations of its independent coordinates leave",
        )  # fmt: skip
    canonical: dict[str, Any] = {
        key: [[_whole(ring, x) for x in row] for row in terms[key]]
        for key in ("M", "C", "K", "K_carried", "B", "E", "E_rates", "T", "S", "P", "to_rates")
    }
    carried = [names[j] for j in choice.carried]
    steady(model, ring, canonical, chosen, moved.moving)
    if carried and _changing(ring, canonical, moved.moving):
        _check_carried(model, ring, canonical, carried, moved.moving)
        carried = []
    if not carried:
        for key in ("K_carried", "E", "E_rates"):
            del canonical[key]
    canonical["chosen"] = choice
    canonical["udot"] = list(moved.udot)
    shown = [displayed(x, ring) for x in (*q, *u)]
    return LinearModel(
        model,
        chosen,
        inputs,
        canonical,
        ring=ring,
        point=dict(zip((*model.coordinate_names, *model.speed_names), shown, strict=True)),
        carried=carried,
    )


# -- the operating point --------------------------------------------------------------------------


def _closed(
    model: Model,
    ring: Ring,
    point: OperatingPoint,
    q: Sequence[Any],
    u: Sequence[Any],
    values: Mapping[Any, Any],
) -> tuple[Any, ...]:
    """Coordinates with φ = 0: those not named that φ holds linearly are solved for."""
    kinds = rows(model)
    held = [i for i, kind in enumerate(kinds) if not kind.on_speeds]
    open_ = {
        i: ring.generator(c.symbol, "coordinate")
        for i, c in enumerate(model.coordinates)
        if c.kind == "scalar" and c.name not in point.given
    }
    left = [linearized(model, State(model, ring, 0, q, u, values)).residual[i] for i in held]
    while any(x != 0 for x in left) and open_:
        trial = [open_.get(i, x) for i, x in enumerate(q)]
        phi = [linearized(model, State(model, ring, 0, trial, u, values)).residual[i] for i in held]
        # an angle stands in sines and cosines: it keeps its value zero
        inside = 0
        for x in phi:
            for g in ring.used(ring.coerce(x)):
                if g.kind not in ("coordinate", "inverse"):
                    inside |= g.depends
        angles = [i for i, x in open_.items() if x.mask & inside]
        if angles:
            for i in angles:
                del open_[i]
            continue
        places = {x.mask.bit_length() - 1: (i, 1) for i, x in open_.items()}
        system = [Row(kinds[i].name, collect(x, places, ring)) for i, x in zip(held, phi, strict=True)]
        solved, _ = eliminate(system, [sorted(open_)])
        result = list(q)
        for i, terms in solved.items():
            # what is left undetermined is zero
            result[i] = _whole(ring, terms.get((), Ratio(ring, 0)))
        q = result
        left = [linearized(model, State(model, ring, 0, q, u, values)).residual[i] for i in held]
        break
    missed = {kinds[i].name: x for i, x in zip(held, left, strict=True) if x != 0}
    if missed and not point.rounded:
        shown = "; ".join(f"{name}: {text(x, ring)}" for name, x in missed.items())
        rest = [c.name for c in model.coordinates if c.name not in point.given and c.kind == "scalar"]
        raise ModelError(
            f"The position given does not satisfy the constraints of '{model.name}': they leave {shown} in place of 0. "
            f"Name the coordinates that are not zero in `about` (not named: {', '.join(rest) or 'none'}), "
            "as expressions that close it, or give relations among parameters as where={parameter: expression}; "
            "with values= coordinates not named are found in numbers."
        )
    return tuple(q)


def _followed(
    model: Model,
    ring: Ring,
    point: OperatingPoint,
    t: Any,
    q: Sequence[Any],
    u: Sequence[Any],
    values: Mapping[Any, Any],
) -> tuple[Any, ...]:
    """Speeds with ψ = 0: those not named follow."""
    start = [x if name in point.given else 0 for name, x in zip(model.speed_names, u, strict=True)]
    given = linearized(model, State(model, ring, t, q, start, values))
    if all(x == 0 for x in given.rate):
        return tuple(start)
    free = [j for j, name in enumerate(model.speed_names) if name not in point.given]
    system = _conditions(model, ring, given.matrix, given.rate, free)
    # the speed of a coordinate that is named stays zero where the others suffice
    named = [j for j in free if model.speed_names[j].removesuffix("'") in point.given]
    solved, left = eliminate(system, [[j for j in free if j not in named], named])
    if left:
        shown = ", ".join(f"{row.name}: {text(_whole(ring, row.terms[()]), ring)}" for row in left)
        raise ModelError(
            f"The speeds given in `about` do not satisfy the constraints of '{model.name}': they miss {shown}. "
            "Leave out those that follow from the others."
        )
    result = list(start)
    for j, found in solved.items():
        value = found.get((), Ratio(ring, 0))
        others = sorted({v for monomial in found for v, _ in monomial} - set(named))
        if value and others:
            names = ", ".join(model.speed_names[v] for v in others)
            raise ModelError(
                f"The speeds given in `about` leave '{model.speed_names[j]}' of '{model.name}' open. Give it as well, "
                f"or {names} (0 where it stands still)."
            )
        result[j] = _whole(ring, value)
    return tuple(result)


def _conditions(
    model: Model, ring: Ring, matrix: Sequence[Any], rest: Sequence[Any], columns: Sequence[int]
) -> list[Row]:
    """Σ_j G_kj x_j + rest_k of every condition, over some columns."""
    result = []
    for kind, row, x in zip(rows(model), matrix, rest, strict=True):
        terms: Terms = {((j, 1),): Ratio(ring, row[j]) for j in columns if row[j] != 0}
        if x != 0:
            terms[()] = Ratio(ring, x)
        result.append(Row(kind.name, terms))
    return result


def _motion(
    model: Model,
    ring: Ring,
    point: OperatingPoint,
    q: Sequence[Any],
    u: Sequence[Any],
    t: Any,
    values: Mapping[Any, Any],
) -> Motion:
    """Where the motion is at any time: speeds that follow from the constraints may change."""
    n = model.n_u
    varying: tuple[int, ...] = ()
    moving = ring.generator(model.names.atoms["t"]).mask
    names = list(model.coordinate_names)
    while True:
        later = list(along(model, ring, q, u, t, values))
        for j in varying:
            i = names.index(model.speed_names[j].removesuffix("'"))
            later[i] = ring.generator(model.coordinates[i].symbol, "coordinate")
            moving |= later[i].mask
        then = _followed(model, ring, point, t, later, u, values)
        changed = tuple(j for j in range(n) if j in varying or then[j] != u[j])
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
    given = linearized(model, State(model, ring, t, later, then, values))
    off = {
        kind.name: x
        for kind, x in zip(rows(model), given.residual, strict=True)
        if x != 0 and not kind.on_speeds
    }
    if off and not point.rounded:
        shown = "; ".join(f"{name}: {text(x, ring)}" for name, x in off.items())
        raise ModelError(
            f"The motion given leaves the constraints of '{model.name}' as it goes on: {shown} in place of 0. Its "
            "speeds are not constant; linearise about a trajectory (about=fb.simulate(...))."
        )
    udot: list[Any] = [0] * n
    solved, left = eliminate(_conditions(model, ring, given.matrix, given.bias, varying), [varying])
    if left:
        shown = "; ".join(
            f"{row.name}: {text(_whole(ring, row.terms[()]), ring)}" for row in left if () in row.terms
        )
        raise ModelError(
            f"The speeds of the motion given can not all stay: the accelerations of the constraints of '{model.name}' "
            f"leave {shown} in place of 0. Name fewer speeds in `about`, or linearise about a trajectory."
        )
    for j, found in solved.items():
        udot[j] = _whole(ring, found.get((), Ratio(ring, 0)))
    return Motion(tuple(later), tuple(then), tuple(udot), varying, moving)


# -- independent speeds and deviations ------------------------------------------------------------


def _choice(
    model: Model,
    ring: Ring,
    moved: Motion,
    point: OperatingPoint,
    t: Any,
    values: Mapping[Any, Any],
    independent: Sequence[str],
) -> Choice:
    """Dependent are, first, speeds that change, then coordinates that `about` does not name, then short pivots."""
    names = tangent_names(model)
    n = model.n_u
    kinds = rows(model)
    G = linearized(model, State(model, ring, t, moved.q, moved.u, values)).matrix
    named = [names.index(name) for name in independent]
    given = {name.removesuffix("'") for name in point.given}
    groups: list[list[int]] = [[], [], []]
    for j in range(n):
        if j not in named:
            groups[0 if j in moved.varying else 1 if names[j] not in given else 2].append(j)

    def run(
        of: Sequence[int], groups: Sequence[Sequence[int]], taken: Iterable[int]
    ) -> tuple[dict[int, int], int]:
        """Pivot column -> condition, and the number of conditions that bind only what is left."""
        system = [Row(str(i), {((j, 1),): Ratio(ring, x) for j, x in enumerate(G[i]) if x != 0}) for i in of]
        pivots: dict[int, int] = {}
        left = [row for row in system if row.terms]
        for group in (list(taken), *groups):
            while True:
                best: tuple[Any, Row, int] | None = None
                for row in left:
                    for j in group:
                        c = row.terms.get(((j, 1),))
                        if c is None or j in pivots:
                            continue
                        cost = (0 if c.is_number else len(c), len(row.terms), -j)
                        if best is None or cost < best[0]:
                            best = (cost, row, j)
                if best is None:
                    break
                _, row, j = best
                left.remove(row)
                pivots[j] = int(row.name)
                c = row.terms[((j, 1),)]
                for other in left:
                    d = other.terms.get(((j, 1),))
                    if d is None:
                        continue
                    factor = d / c
                    for key, x in row.terms.items():
                        total = other.terms.get(key, Ratio(ring, 0)) - factor * x
                        if total:
                            other.terms[key] = total
                        else:
                            other.terms.pop(key, None)
                left = [row for row in left if row.terms]
        return pivots, len(left)

    on_coordinates = [i for i, kind in enumerate(kinds) if not kind.on_speeds]
    dependent, unbound = run(on_coordinates, groups, ())
    every = [*dependent.values(), *(i for i, kind in enumerate(kinds) if kind.on_speeds)]
    fixed, more = run(every, groups, dependent)
    if unbound or more:
        rank = len(run(range(len(kinds)), [range(n)], ())[0])
        if len(named) != n - rank:
            raise ModelError(
                f"Expected {n - rank} independent coordinates of '{model.name}' ({n} speeds, {rank} conditions), got "
                f"{len(named)}: {', '.join(independent)}."
            )
        raise ModelError(
            f"The coordinates {', '.join(independent)} are not independent: with them held, '{model.name}' can "
            "still move, and the constraints relate them. Name others, or leave the choice out."
        )
    if named and len(named) != n - len(fixed):
        raise ModelError(
            f"Expected {n - len(fixed)} independent coordinates of '{model.name}' ({n} speeds, {len(fixed)} "
            f"conditions), got {len(named)}: {', '.join(independent)}."
        )
    speeds = named or [j for j in range(n) if j not in fixed]
    carried = [j for j in range(n) if j not in set(speeds) | set(dependent)]
    if any(j in moved.varying for j in speeds):
        name = names[next(j for j in speeds if j in moved.varying)]
        raise ModelError(
            f"The speed of '{name}' changes along this motion of '{model.name}', so '{name}' can not be independent. "
            "Name others in `independent`, or leave the choice out."
        )
    active = sorted(fixed.values())
    return Choice(
        tuple(speeds), tuple(carried), tuple(sorted(fixed)), tuple(sorted(dependent)), tuple(active)
    )


# -- checks ---------------------------------------------------------------------------------------


def _changing(ring: Ring, terms: Mapping[str, Any], moving: int) -> bool:
    return any(
        ring.depends(x) & moving for key in ("K_carried", "E", "E_rates") for row in terms[key] for x in row
    )


def _check_carried(
    model: Model, ring: Ring, terms: Mapping[str, Any], carried: Sequence[str], moving: int
) -> None:
    """What is carried and follows at changing rates may not act back."""
    for row in terms["K_carried"]:
        for name, x in zip(carried, row, strict=True):
            if x != 0:
                raise ModelError(
                    f"The motion given is balanced, but '{name}' of '{model.name}', which acts back on the other "
                    "deviations, follows them at rates that change with time. Linearise about a trajectory "
                    "(about=fb.simulate(...))."
                )


# -- canonical algebra ----------------------------------------------------------------------------


def _whole(ring: Ring, x: Any) -> Any:
    return Ratio(ring, x).whole() if not isinstance(x, Ratio) else x.tidy().whole()


def _solved(ring: Ring, A: Any, B: Any) -> Any:
    """X with A X = B, by Gauss and Jordan; a pivot is never zero, since zero is recognised."""
    n = len(A)
    right = B.reshape(n, -1)
    table = [[*A[i], *right[i]] for i in range(n)]
    done: list[int] = []
    for column in range(n):
        candidates = [i for i in range(n) if i not in done and table[i][column] != 0]
        i = min(candidates, key=lambda k: (not table[k][column].is_number, len(table[k][column]), k))
        done.append(i)
        pivot = table[i][column]
        table[i] = [x / pivot if x else x for x in table[i]]
        for k in range(n):
            factor = table[k][column]
            if k != i and factor:
                table[k] = [x - factor * y if y else x for x, y in zip(table[k], table[i], strict=True)]
    result = np.empty(right.shape, dtype=object)
    for column, i in enumerate(done):
        result[column] = table[i][n:]
    return result.reshape(B.shape)
