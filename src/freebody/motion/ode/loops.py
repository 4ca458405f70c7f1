"""Compiled loop of an integration method: `step_control` with `dop853` or another method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...native.loop import Loop, address, made, module_named

CALLED = ("run", "sample", "observe")


def functions(method: str = "dop853") -> Loop:
    """Return the compiled functions of a method: `step_control.run`, `sample` and `observe`."""
    return made(method, (place(method),), CALLED, lambda: module_named(place(method)).FUNCTIONS)


def place(method: str) -> str:
    """Name of the module of a method, such as ``"motion.ode.dop853"``."""
    return f"{__name__.partition('.')[2].rpartition('.')[0]}.{method}"


_used: dict[str, Callable[[int], int]] = {}
"""`step_control.run` of the methods whose code is in this process."""


def use(method: str) -> Callable[[int], int]:
    """`step_control.run` of a method, which is loaded before anything else is called: a function of an address."""
    if method not in _used:
        _used[method] = functions(method).functions["run"].code
    return _used[method]


def sample(method: str, *arguments: Any) -> None:
    """`step_control.sample`: states at given times."""
    functions(method).functions["sample"](*arguments)


def observe(*arguments: Any) -> None:
    """`step_control.observe`: outputs of a kernel at given states; all methods have it."""
    functions(next(iter(_used), "dop853")).functions["observe"](*arguments)


def observed(kernel: int, outputs: int, t: float, y: Any, constants: int) -> list[float]:
    """Outputs of the kernel at an address at one state, with the constants at another."""
    room = np.array([t, *y, *outputs * (0.0,)])
    time, n = address(room), len(y)
    state = time + room.itemsize
    look = functions(next(iter(_used), "dop853")).functions["observe"]
    look.code(kernel, 1, time, state, n, constants, state + n * room.itemsize, outputs)
    return list(room[1 + n :].tolist())
