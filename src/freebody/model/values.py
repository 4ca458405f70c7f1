"""Checks of the values of parameters against the assumptions on them."""

from __future__ import annotations

from collections.abc import Mapping

from ..errors import ModelError
from ..scalar.algebra import Expression, floats
from ..scalar.expression import evaluate
from .model import Model


def check_assumptions(model: Model, numbers: Mapping[str, float]) -> None:
    """Refuse values that contradict the assumptions on the parameters (`Model.assumed`).

    Raises
    ------
    ModelError
        If an expression is not positive; the message shows it with its values.
    """
    for expression in model.assumed:
        check_assumption(model, expression, numbers)


def check_assumption(
    model: Model, expression: Expression, numbers: Mapping[str, float], where: str = ""
) -> None:
    """Refuse values for which an expression that is assumed positive is not; ``where`` begins the message."""
    symbols = {symbol.name: symbol for symbol in expression.free_symbols}
    value = float(evaluate(expression, {symbol: numbers[name] for name, symbol in symbols.items()}, floats))
    if not value > 0:
        values = ", ".join(f"{name} = {numbers[name]:g}" for name in sorted(symbols))
        raise ModelError(
            f"{where}Expected {str(expression).replace('**', '^')} > 0 in '{model.name}', as s.assume or its use says, "
            f"but {values} makes it {value:g}. Change the values, or take the assumption back."
        )
