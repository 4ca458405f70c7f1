"""The compiled loop of an integration method: `step_control` with `dop853` or another method."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ...native.loop import Loop, address, made, module_named, sibling
from . import tableau

CALLED = {"": ("piece", "sample", "observe"), "steps": ("piece", "observe"), "states": ("sample", "observe")}
"""Functions of `step_control` and `states` that Python calls: all; of runs without event functions; of states between
steps. A first run compiles what it calls and no more."""


def functions(method: str = "dop853", part: str = "") -> Loop:
    """Return the compiled functions of a method, all or those of a part (`CALLED`)."""
    name = _name(method, part)
    _loaded[name] = result = made(
        name, (place(method),), CALLED[part], lambda: compiled_functions(method, watched=part != "steps")
    )
    return result


def _name(method: str, part: str) -> str:
    return f"{label(method)} {part}" if part else label(method)


def place(method: str) -> str:
    """Return the name of the module of a method, such as ``"motion.ode.dop853"``."""
    return sibling(__name__, "runge_kutta" if method in tableau.OWN else method)


def label(method: str) -> str:
    """Return what tells the code of a method from that of others of the same module: its name, and coefficients."""
    return f"{method} {tableau.OWN[method].identity}" if method in tableau.OWN else method


def compiled_functions(method: str, watched: bool = True) -> Any:
    """Return the functions of a method (`step_control.Functions`), of runs with event functions or without."""
    module = module_named(place(method))
    result = module.functions(tableau.OWN[method]) if method in tableau.OWN else module.FUNCTIONS
    return result if watched else type(result)(result.method, watched)


_loaded: dict[str, Loop] = {}
"""The functions whose code is loaded in this process, by the label of the method and the part."""


def use(method: str, watched: bool) -> Callable[[int], int]:
    """Return `step_control.piece` of a method, a function of an address, for runs with event functions or without.

    Call this before any other function of the method, so that no other method has to be compiled.
    """
    part = "" if watched else "steps"
    loop = _loaded.get(_name(method, part)) or functions(method, part)
    piece: Callable[[int], int] = loop.functions["piece"].code
    return piece


def _any_loop() -> Loop:
    """Return the functions of a method that is loaded, for what is the same in all methods."""
    return next(iter(_loaded.values()), None) or functions(part="states")


@contextlib.contextmanager
def ahead(method: str, watched: bool) -> Iterator[None]:
    """Load the code of a method in a thread of its own, which ends with the context.

    On a new computer a loop is translated by Python, and a machine compiled by LLVM, which leaves Python to others.
    """
    thread = threading.Thread(target=_load, args=(method, watched), name="freebody")
    if _name(method, "" if watched else "steps") not in _loaded:
        thread.start()
    try:
        yield
    finally:
        if thread.ident is not None:
            thread.join()


def _load(method: str, watched: bool) -> None:
    with contextlib.suppress(Exception):  # the run loads the code itself, and says what is wrong
        use(method, watched)


def sample(method: str, *arguments: Any) -> None:
    """Compute states at given times by `step_control.sample`."""
    part = "" if _name(method, "") in _loaded else "states"
    functions(method, part).functions["sample"](*arguments)


def observe(*arguments: Any) -> None:
    """Compute outputs of a kernel at given states by `step_control.observe`, which is the same in all methods."""
    _any_loop().functions["observe"](*arguments)


def observed(kernel: int, outputs: int, t: float, y: Any, constants: int) -> list[float]:
    """Return the outputs of the kernel at an address at one state, with the constants at another address."""
    memory = np.array([t, *y, *outputs * (0.0,)])
    time, n = address(memory), len(y)
    state = time + memory.itemsize
    observation = _any_loop().functions["observe"]
    observation.code(kernel, 1, time, state, n, constants, state + n * memory.itemsize, outputs)
    return list(memory[1 + n :].tolist())
