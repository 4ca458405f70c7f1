"""Constraints in the symbolic equations: indeterminate reactions, and elimination of multipliers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...dynamics.conditions.constrained import DEPENDENT, closed_coordinates
from ...dynamics.conditions.indeterminate import self_stresses
from ...dynamics.state import float_state, rest_coordinates
from ...errors import ModelError, nearest
from ...scalar.algebra import ZERO, Expression, Scalar, dot, floats
from ...scalar.expression import evaluate
from ..derivation.derivation import Derivation
from ..derivation.determinant import determinant
from .reaction import unknowns


def indeterminate(
    e: Derivation, near: Mapping[Any, Expression] | None, values: Mapping[Any, Expression] | None
) -> tuple[str, ...]:
    """Names of the reaction components that the motion does not determine, at a closed configuration."""
    model = e.model
    q: list[Any] = list(rest_coordinates(model))
    parameter_values = model.values(values)
    numbers = {p.symbol: parameter_values[p.name] for p in model.parameters}
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
    names: dict[str, None] = {}
    for stress in stresses:
        names.update({name: None for name, n in stress.multipliers.items() if n != 0})
    if stresses:
        for joint in model.joints:
            for c in unknowns(model, e.state, joint):
                components, part = (c.force, 0) if c.force != ZERO else (c.moment, 1)
                direction = [state(e.sympy(x)) for x in components]
                if any(abs(dot(direction, stress.joints[joint][part])) > DEPENDENT for stress in stresses):
                    names[c.name] = None
    return tuple(names)


def eliminated(e: Derivation, independent: Sequence[Any]) -> tuple[Scalar, ...]:
    """Nᵀ (M u' + h - Q) with G N = 0, canonical; an entry per independent speed."""
    chosen = [_speed(e, speed) for speed in independent]
    rest = [j for j in range(e.model.n_u) if j not in chosen]
    # rows of G, which include sliding friction here (W_N - μ Σ d W_T), so that its forces drop out too
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


def _speed(e: Derivation, speed: Any) -> int:
    """Index of a speed that is given by its name or symbol, or by its coordinate."""
    text = speed if isinstance(speed, str) else e.model.names.texts.get(speed, str(speed))
    for name in (text, text + "'"):
        if name in e.model.speed_names:
            return e.model.speed_names.index(name)
    raise ModelError(f"Unknown speed '{text}'; {nearest(text, e.model.speed_names)}")
