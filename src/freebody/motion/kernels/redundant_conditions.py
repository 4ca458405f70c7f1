"""Conditions that were redundant at the start of a motion, and are watched in it."""

from __future__ import annotations

from collections.abc import Sequence

from ...dynamics import State
from ...dynamics.conditions.constrained import condition_groups
from ...dynamics.conditions.constraints import rows
from ...dynamics.conditions.linearized import linearized
from ...dynamics.linear import Factorization, applied, is_zero, products
from ...model import Model
from ...scalar.algebra import Scalar, divide

LOOSE = 100
"""Factor by which a dependent condition must exceed an independent one before it replaces that condition."""


def redundant_conditions(
    model: Model, state: State, active: Sequence[int]
) -> tuple[tuple[str, ...], list[Scalar]]:
    """Return the names of the conditions beside the ``active`` ones that do not hold identically, and what shows them.

    These are their residuals and rates in turn, then a sign: 1 if one of them is a large multiple of active conditions,
    else 0 or -1. Without names, nothing is shown.
    """
    linear, kinds = linearized(model, state), rows(model)
    dropped = [
        i
        for i in range(len(kinds))
        if i not in active and not (is_zero(linear.residual[i]) and is_zero(linear.rate[i]))
    ]
    if not dropped:
        return (), []
    unit: dict[int, list[Scalar]] = {}
    for group in condition_groups(model):
        square = sum((x * x for i in group for x in linear.matrix[i]), 0)
        size = 1 if is_zero(square) else state.field.sqrt(square)
        unit |= {i: [divide(x, size) for x in linear.matrix[i]] for i in group}
    held = [unit[i] for i in active]
    gram, largest = Factorization(products(held, held)), 0
    for i in dropped:
        for part in gram.solve(applied(held, unit[i])):
            largest = state.field.apply("max", largest, part * part)
    shown = [x for i in dropped for x in (linear.residual[i], linear.rate[i])]
    return tuple(kinds[i].name for i in dropped), [*shown, state.field.apply("sign", largest - LOOSE * LOOSE)]
