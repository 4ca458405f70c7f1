"""Constraints in the symbolic equations: reactions of loop-closing joints, and elimination of multipliers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...dynamics.constrained import DEPENDENT, closed_coordinates
from ...dynamics.constraints import rows, wrenches
from ...dynamics.indeterminate import self_stresses
from ...dynamics.state import float_state, rest_coordinates
from ...errors import ModelError, nearest
from ...model.closure import Closure
from ...model.contact import Touching
from ...scalar.algebra import ZERO, add, dot, floats, scale
from ...scalar.expression import evaluate
from .contact_modes import contact_reaction
from .reaction import Reaction, unknowns

if TYPE_CHECKING:
    from ..equations import Equations


def closure_reactions(e: Equations) -> dict[str, Reaction]:
    """Reactions of loop-closing joints and closed contacts: their components are unknowns of the equations."""
    result = {}
    acting = wrenches(e.model, e.state)
    for name, joint in e.model.constraints.items():
        if isinstance(joint, Touching):
            result[name] = contact_reaction(e, joint)
        if not isinstance(joint, Closure):
            continue
        force, moment, parts = ZERO, ZERO, {}
        for row, multiplier, pair in zip(rows(e.model), e.canonical_multipliers, acting, strict=True):
            if row.owner != name:
                continue
            _, f, m = pair[0]  # on the child
            force, moment = add(force, scale(multiplier, f)), add(moment, scale(multiplier, m))
            parts[row.name] = e.displayed(multiplier)
        result[name] = Reaction(
            joint=name,
            force=e.column(force),
            moment=e.column(moment),
            on=joint.child.name,
            about=f"point ({', '.join(map(str, joint.to))}) of {joint.child.name}",
            frame="ground",
            components=parts,
        )
    return result


def indeterminate(
    e: Equations, near: Mapping[Any, Any] | None, values: Mapping[Any, Any] | None
) -> tuple[str, ...]:
    """Names of the reaction components that the motion does not determine, at a closed position."""
    model = e.model
    q: list[Any] = list(rest_coordinates(model))
    given = model.values(values)
    numbers = {p.symbol: given[p.name] for p in model.parameters}
    for key, value in (near or {}).items():
        name = key if isinstance(key, str) else model.names.texts.get(key, str(key))
        if name not in model.coordinate_names:
            raise ModelError(f"Unknown coordinate '{name}' in near; {nearest(name, model.coordinate_names)}")
        number = model.names.expression(value, f"'{name}' in near")
        if model.names.depends(number, "coordinate", "speed", "time"):
            raise ModelError(
                f"Expected a number or an expression of parameters for '{name}' in near, got {value!r}."
            )
        q[model.coordinate_names.index(name)] = float(evaluate(number, numbers, floats))
    q = closed_coordinates(model, q, values=values)
    state = float_state(model, q, values=values)
    stresses = self_stresses(model, state)
    found: dict[str, None] = {}
    for stress in stresses:
        found.update({name: None for name, n in stress.multipliers.items() if n != 0})
    if stresses:
        for joint in model.joints:
            for c in unknowns(model, e.state, joint):
                along, of = (c.force, 0) if c.force != ZERO else (c.moment, 1)
                direction = [state(e.sympy(x)) for x in along]
                if any(abs(dot(direction, stress.joints[joint][of])) > DEPENDENT for stress in stresses):
                    found[c.name] = None
    return tuple(found)


def eliminated(e: Equations, independent: Sequence[Any]) -> tuple[Any, ...]:
    """Nᵀ (M u' + h - Q) with G N = 0, canonical; a row per independent speed."""
    chosen = [_speed(e, one) for one in independent]
    rest = [j for j in range(e.model.n_u) if j not in chosen]
    # the rows of G, but for sliding friction, whose forces must drop out
    G = [row for row in e.conditions.acting if any(x != 0 for x in row)]
    if len(set(chosen)) != len(chosen) or len(G) != len(rest):
        raise ModelError(
            f"Expected {e.model.n_u - len(G)} different independent speeds, since {len(G)} constraints act on "
            f"{e.model.n_u} speeds, got {len(chosen)}."
        )
    D = [[row[j] for j in rest] for row in G]
    det = determinant(D)
    if det == 0:
        names = ", ".join(e.model.speed_names[j] for j in rest)
        raise ModelError(f"The constraints do not determine {names}. Choose other independent speeds.")
    left = [a - Q for a, Q in zip(e.canonical_left, e.canonical_applied, strict=True)]
    result = []
    for j in chosen:
        total = det * left[j]
        right = [-row[j] for row in G]
        for k in range(len(rest)):
            # Cramer: det u_k = determinant with column k replaced
            replaced = [[*row[:k], x, *row[k + 1 :]] for row, x in zip(D, right, strict=True)]
            total = total + determinant(replaced) * left[rest[k]]
        result.append(total)
    return tuple(result)


def _speed(e: Equations, one: Any) -> int:
    text = one if isinstance(one, str) else e.model.names.texts.get(one, str(one))
    for name in (text, text + "'"):
        if name in e.model.speed_names:
            return e.model.speed_names.index(name)
    raise ModelError(f"Unknown speed '{text}'; {nearest(text, e.model.speed_names)}")


def determinant(A: Sequence[Sequence[Any]]) -> Any:
    """By expansion along the first row; the matrices are small and sparse."""
    if not A:
        return 1
    total: Any = 0
    sign = 1
    for k, entry in enumerate(A[0]):
        if entry != 0:
            total = total + sign * entry * determinant([[*row[:k], *row[k + 1 :]] for row in A[1:]])
        sign = -sign
    return total
