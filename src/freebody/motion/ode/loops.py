"""The compiled loop of an integration method: `step_control` with `dop853` or another method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...native.loop import Loop, address, made, module_named, sibling

CALLED = ("piece", "sample", "observe")


def functions(method: str = "dop853") -> Loop:
    """Return the compiled functions of a method: `step_control.piece`, `sample` and `observe`."""
    return made(method, (place(method),), CALLED, lambda: module_named(place(method)).FUNCTIONS)


def place(method: str) -> str:
    """Return the name of the module of a method, such as ``"motion.ode.dop853"``."""
    return sibling(__name__, method)


_loaded: dict[str, Callable[[int], int]] = {}
"""`step_control.piece` of each method whose code is loaded in this process."""


def use(method: str) -> Callable[[int], int]:
    """Return `step_control.piece` of a method, a function of an address, and load the code of the method.

    Call this before any other function of the method, so that no other method has to be compiled.
    """
    if method not in _loaded:
        _loaded[method] = functions(method).functions["piece"].code
    return _loaded[method]


def sample(method: str, *arguments: Any) -> None:
    """Compute states at given times by `step_control.sample`."""
    functions(method).functions["sample"](*arguments)


def observe(*arguments: Any) -> None:
    """Compute outputs of a kernel at given states by `step_control.observe`, which is the same in all methods."""
    functions(next(iter(_loaded), "dop853")).functions["observe"](*arguments)


def observed(kernel: int, outputs: int, t: float, y: Any, constants: int) -> list[float]:
    """Return the outputs of the kernel at an address at one state, with the constants at another address."""
    memory = np.array([t, *y, *outputs * (0.0,)])
    time, n = address(memory), len(y)
    state = time + memory.itemsize
    observation = functions(next(iter(_loaded), "dop853")).functions["observe"]
    observation.code(kernel, 1, time, state, n, constants, state + n * memory.itemsize, outputs)
    return list(memory[1 + n :].tolist())
