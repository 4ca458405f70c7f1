"""Questions to the equations of a model: each has a subject, which a refusal names, and its own budget."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from ...errors import Arguments, Result


def named(subject: str) -> Callable[[Callable[Arguments, Result]], Callable[Arguments, Result]]:
    """Run a function or method as a question with this subject, which the refusal names if the formula is too long.

    The first argument is a derivation, or a product with a derivation ``_e``.
    """

    def decorator(method: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
        @wraps(method)
        def question(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
            e: Any = getattr(args[0], "_e", args[0])
            with e.question(subject):
                return method(*args, **kwargs)

        return question

    return decorator
