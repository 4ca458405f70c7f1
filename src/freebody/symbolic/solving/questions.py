"""Questions to the equations of a model: each has a name for refusals, and a budget of its own."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from ...errors import Arguments, Result


def named(subject: str) -> Callable[[Callable[Arguments, Result]], Callable[Arguments, Result]]:
    """What a method of the equations, or of a product of them, forms is called ``subject`` where it is too long."""

    def of_method(method: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
        @wraps(method)
        def asked(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
            e: Any = getattr(args[0], "_e", args[0])
            with e.question(subject):
                return method(*args, **kwargs)

        return asked

    return of_method
