"""Errors. A message says what was expected, what came and the cure, in the user's names."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

LONGEST = 300
"""Greatest length, in characters, of a value shown in a message."""

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class FreebodyError(Exception):
    """Base of every error that freebody raises on purpose."""


class ArgumentError(FreebodyError, TypeError):
    """A call with an argument that the function does not have, or without a required argument."""


class ModelError(FreebodyError, ValueError):
    """A machine that is described wrongly or cannot exist."""


class ExpressionError(FreebodyError, ValueError):
    """Text that is not an expression of the system's names."""


class TooManyTermsError(FreebodyError, ValueError):
    """A formula that would be too long to hold in memory or to compute; the message names it and the cure."""

    def __init__(self, reason: str, cure: str) -> None:
        super().__init__(reason, cure)
        self.reason = reason

    def __str__(self) -> str:
        return " ".join(self.args)


class MassError(ModelError):
    """Mass properties that no body can have."""


class SimulationError(FreebodyError, RuntimeError):
    """A motion that cannot be computed."""


class FormatError(FreebodyError, ValueError):
    """A file that is not a model."""


def shown(thing: Any) -> str:
    """Text of a value for a message: its representation, or its type if that is an address or too long.

    >>> shown("2*x"), shown(object())
    ("'2*x'", 'an object')
    """
    text = repr(thing)
    if " at 0x" not in text and (len(text) <= LONGEST or isinstance(thing, str | int)):
        return text
    kind = type(thing).__name__
    return f"{'an' if kind[0] in 'aeiouAEIOU' else 'a'} {kind}"


def path_of(path: Any, what: str, error: type[FreebodyError]) -> Path:
    """Return the path of a file; ``what`` names its content in the message of the error.

    >>> path_of("run.nc", "a trajectory", SimulationError).name
    'run.nc'
    """
    if not isinstance(path, str | os.PathLike) or not Path(path).name:
        raise error(f"Expected the path of a file for {what}, such as 'run.nc', got {path!r}.")
    return Path(path)


def nearest(name: str, known_names: Iterable[str], command: str = "") -> str:
    """End of a message about an unknown name: the nearest known name, all known names, or the command that lists them.

    >>> nearest("thetta", ["theta", "x"])
    "did you mean 'theta'?"
    >>> nearest("l", ["L", "g"])
    "did you mean 'L'?"
    >>> nearest("y", ["theta", "x"], "freebody gallery")
    '`freebody gallery` lists the known names.'
    """
    names = sorted(known_names)
    close = [x for x in names if x.lower() == name.lower()] or get_close_matches(name, names, n=1)
    if close:
        return f"did you mean '{close[0]}'?"
    if not names:
        return "no names are known yet."
    if command:
        return f"`{command}` lists the known names."
    return "known names: " + ", ".join(names) + "."


def arguments_named(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Decorator: a call with wrong arguments raises an error that names the arguments of the function.

    >>> @arguments_named
    ... def spring(on, *, stiffness, rest=0):
    ...     return stiffness
    >>> spring("rail", stifness=3)
    Traceback (most recent call last):
    ...
    freebody.errors.ArgumentError: Expected an argument of spring, got 'stifness='; did you mean 'stiffness'?
    >>> spring("rail")
    Traceback (most recent call last):
    ...
    freebody.errors.ArgumentError: Expected spring(on, stiffness, rest): missing a required argument: 'stiffness'.
    """

    @wraps(function)
    def called(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        try:
            return function(*args, **kwargs)
        except TypeError:
            signature = inspect.signature(function)
            try:
                signature.bind(*args, **kwargs)
            except TypeError as wrong:
                names = [name for name in signature.parameters if name not in ("self", "system")]
                title = function.__name__.removesuffix("_system").removesuffix("_batch")
                for name in kwargs:
                    if name not in names:
                        raise ArgumentError(
                            f"Expected an argument of {title}, got '{name}='; {nearest(name, names)}"
                        ) from None
                raise ArgumentError(f"Expected {title}({', '.join(names)}): {wrong}.") from None
            raise

    return called
