"""Errors. A message says what was expected, what came and the cure, in the user's names."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

LONGEST = 300
"""Greatest length, in characters, of a value shown in a message."""

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
Thing = TypeVar("Thing")


class FreebodyError(Exception):
    """Base of every error that freebody raises on purpose."""


class ArgumentError(FreebodyError, TypeError):
    """A call with an argument that the function does not have, or without a required argument."""


class ModelError(FreebodyError, ValueError):
    """A machine that is described wrongly or cannot exist."""


class ExpressionError(FreebodyError, ValueError):
    """Text that is not an expression of the system's names."""


class DivisorError(ExpressionError, ZeroDivisionError):
    """An expression divided by zero."""


class TooManyTermsError(FreebodyError, ValueError):
    """A formula that would be too long to hold in memory or to compute; the message names it and the cure."""

    def __init__(self, reason: str, cure: str) -> None:
        super().__init__(reason, cure)
        self.reason = reason

    def __str__(self) -> str:
        return " ".join(self.args)


class MassError(ModelError):
    """Mass properties that no body can have."""


class UndefinedError(FreebodyError, ZeroDivisionError):
    """A law that has no value at a state."""


class SimulationError(FreebodyError, RuntimeError):
    """A motion that cannot be computed."""


class NoDerivativesError(SimulationError):
    """A motion without derivatives by the unknowns."""


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
    names = sorted({*known_names})
    close = [x for x in names if x.lower() == name.lower()] or get_close_matches(name, names, n=1)
    if close:
        return f"did you mean '{close[0]}'?"
    if not names:
        return "no names are known yet."
    if command:
        return f"`{command}` lists the known names."
    return "known names: " + ", ".join(names) + "."


def arguments_named(thing: Thing) -> Thing:
    """Decorator: a call with wrong arguments raises an error that names the arguments of the function.

    Of a class, that holds for its public methods, for making an instance, and for calling one.

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
    if not isinstance(thing, type):
        return cast("Thing", _named(cast("Callable[..., Any]", thing), None, ""))
    for name, value in list(vars(thing).items()):
        if inspect.isfunction(value) and not hasattr(value, "__wrapped__"):
            called = name in ("__init__", "__call__")
            if called or not name.startswith("_"):
                title = getattr(thing, "named", thing.__name__) if called else value.__name__
                setattr(thing, name, _named(value, title, "method"))
    return thing


def _named(function: Callable[..., Any], title: str | None, kind: str) -> Callable[..., Any]:
    """Return a function that says what its arguments are where it is called with others."""

    @wraps(function)
    def called(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except TypeError:
            signature = inspect.signature(function)
            try:
                signature.bind(*args, **kwargs)
            except TypeError as wrong:
                names = list(signature.parameters)[1 if kind == "method" else 0 :]
                own = title or function.__name__
                own = own.removesuffix("_system").removesuffix("_batch")
                for name in kwargs:
                    if name not in names:
                        alike = [x for x in names if x in name.split("_")] or names  # time_step is step
                        raise ArgumentError(
                            f"Expected an argument of {own}, got '{name}='; {nearest(name, alike)}"
                        ) from None
                such_as = _example(function, own, kind == "method")
                raise ArgumentError(f"Expected {own}({', '.join(names)}): {wrong}.{such_as}") from None
            raise

    return called


def _example(function: Callable[..., Any], title: str, method: bool) -> str:
    """Return a sentence with the first call of a function that one line of its docstring shows, or an empty text."""
    of = r"(?!fb\.)\w+\." if method else r"(?:fb\.)?"
    for line in (inspect.getdoc(function) or "").splitlines():
        found = re.search(rf">>> .*?(?<![\w.])({of}{title}\()", line)
        if found:
            depth = 0
            for place in range(found.end(1) - 1, len(line)):
                depth += {"(": 1, ")": -1}.get(line[place], 0)
                if depth == 0:
                    call = line[found.start(1) : place + 1]
                    return f" An example: {call if method else 'fb.' + call.removeprefix('fb.')}"
    return ""
