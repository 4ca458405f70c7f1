"""What a user may pass as ``executor=``, and what is sent to it."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from importlib import import_module
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
    elif isinstance(executor, str) and (executor == "ray" or executor.startswith("ray://")):
        yield ray_pool(executor)
    elif executor == "threads":
        yield None
    elif executor is not None and (isinstance(executor, type) or not hasattr(executor, "submit")):
        raise SimulationError(
            'Expected an executor with submit(), such as concurrent.futures.ProcessPoolExecutor(), "processes", "ray", '
            f"a dask Client, or its address, got {executor!r}."
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


class RayPool:
    """Tasks of ray as an executor: ``submit`` returns a future, and bytes go into ray's store once."""

    def __init__(self, ray: Any) -> None:
        self.ray = ray
        self.num_workers = max(1, int(ray.cluster_resources().get("CPU", 1)))
        self.tasks: dict[Any, Any] = {}
        self.objects: dict[int, Any] = {}

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return the future of a call. A call whose worker dies is not repeated here: the study does it."""
        if function not in self.tasks:
            self.tasks[function] = self.ray.remote(max_retries=0)(function)
        reference = self.tasks[function].remote(*map(self._kept, arguments))
        future = reference.future()
        future.add_done_callback(lambda future: future.cancelled() and self.ray.cancel(reference))
        return future

    def _kept(self, argument: Any) -> Any:
        """Return the reference of bytes, which are the same for all blocks, and other arguments as they are."""
        if not isinstance(argument, bytes):
            return argument
        key = hash(argument)
        if key not in self.objects:
            self.objects[key] = self.ray.put(argument)
        return self.objects[key]


def ray_pool(address: str) -> RayPool:
    """Return an executor of ray, here ("ray") or at an address ("ray://host:10001").

    Raises
    ------
    SimulationError
        ray is not installed, or none answers.
    """
    try:
        ray = import_module("ray")
    except ImportError:
        raise SimulationError(
            f"Expected ray for executor='{address}', but it is not installed. Run: pip install ray."
        ) from None
    if not ray.is_initialized():
        try:
            ray.init(None if address == "ray" else address, log_to_driver=False)
        except (ConnectionError, OSError, ValueError, RuntimeError) as error:
            raise SimulationError(
                f"Expected a cluster of ray at '{address}', but none answered: {error}. Start one with 'ray start "
                '--head\', or pass "ray" to use the processors of this computer.'
            ) from error
    return RayPool(ray)


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
