"""Arguments of the methods that make constraints: their expressions, and the words in which errors show them."""

from __future__ import annotations

from typing import Any

import sympy

from ...errors import ModelError
from ..description import Description, names_of


def text_of(system: Description, expression: Any) -> str:
    """Return the text of an expression in the user's terms: x and x', not functions of time."""
    return str(
        expression.xreplace({atom: sympy.Symbol(text) for atom, text in names_of(system).texts.items()})
    )


def fixed(system: Description, value: Any, what: str, *kinds: str) -> Any:
    """Return an expression; raise ModelError if it depends on names of these kinds."""
    expression = system.expression(value, what)
    moving = names_of(system).depends(expression, *kinds)
    if moving:
        raise ModelError(
            f"{what[0].upper()}{what[1:]} cannot depend on {', '.join(moving)}. Write the condition out with "
            f"s.constrain."
        )
    return expression


def store(system: Description, constraint: Any) -> Any:
    """Return a constraint after it is added to the system."""
    system.constraints[constraint.name] = constraint
    return constraint
