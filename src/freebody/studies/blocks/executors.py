"""What a user may pass as ``executor=``, and what is sent to it."""

from __future__ import annotations

import io
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

from ...errors import SimulationError
from ...model import Model
from .block import Work

ADDRESSES = ("tcp://", "tls://", "ws://", "wss://", "ucx://", "inproc://", "dask://")
"""Beginnings of texts that are the address of a scheduler of dask."""


@contextmanager
def executor_of(executor: Any) -> Iterator[Any]:
    """Context with the executor that an argument stands for; one that is made here ends with it.

    Raises
    ------
    SimulationError
        An object without ``submit``, an address at which no scheduler answers.
    """
    if executor == "processes":
        with ProcessPoolExecutor() as pool:
            yield pool
    elif isinstance(executor, str) and executor.startswith(ADDRESSES):
        with _client(executor) as client:
            yield client
    elif executor == "threads":
        yield None
    elif executor is not None and (isinstance(executor, type) or not hasattr(executor, "submit")):
        raise SimulationError(
            'Expected an executor with submit(), such as concurrent.futures.ProcessPoolExecutor(), "processes", a '
            f"dask Client, or its address, got {executor!r}."
        )
    else:
        yield executor


def _client(address: str) -> Any:
    """Return a client of a scheduler."""
    try:
        from distributed import Client
    except ImportError:
        raise SimulationError(
            f"Expected dask for executor='{address}', but distributed is not installed. Run: "
            "pip install 'freebody[cluster]'."
        ) from None
    try:
        return Client(address.replace("dask://", "tcp://", 1), timeout="10s", set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise SimulationError(
            f"Expected a scheduler of dask at '{address}', but none answered: {error}. Start one with "
            "'dask scheduler', or pass the address that it prints."
        ) from error


def sent(work: Work, model: Model) -> bytes:
    """Return work as it is sent to other processes: functions of a script or a notebook go along by value.

    Raises
    ------
    SimulationError
        Before anything runs: names the controller, or other object, that cannot be sent.
    """
    import cloudpickle

    error = unsendable(work)
    if error is None:
        return bytes(cloudpickle.dumps(work))
    cure = "Open or make what it holds within the function, or run the lanes in this process: leave out executor=."
    for controller in model.controllers:
        reason = unsendable(controller.function)
        if reason is not None:
            raise SimulationError(
                f"Expected a controller that can be sent to other processes, but '{controller.name}' is "
                f"{controller.function!r}: {reason}. {cure}"
            )
    raise SimulationError(
        f"Expected a machine and options that can be sent to other processes, but '{model.name}' cannot be pickled: "
        f"{error}. Make it of numbers, expressions and functions. {cure}"
    )


def unsendable(value: Any) -> str | None:
    """Return the reason why a value cannot be pickled; None if it can."""
    import cloudpickle

    try:
        cloudpickle.dump(value, io.BytesIO())
    except Exception as error:  # classes of the user may raise anything
        return f"{type(error).__name__}: {error}".rstrip(".")
    return None
