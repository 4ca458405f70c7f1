"""The compiled loop as functions of arrays: its machine code, from the disk or made now.

The loop of a method (`stepping`, with `dop853` or another) is translated (`translation`) and compiled by LLVM when a
run first asks for it. Its machine code needs nothing but the library of C, so it is kept with the kernels
(`compile.cache`) under the hash of its source and of what compiles it; later processes load it as they load a kernel.
"""

from __future__ import annotations

import ctypes
import hashlib
import importlib
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np

from ..compile import cache as disk
from ..compile import native

SHARED = ("loop.py", "stepping.py", "event_search.py", "machine.py", "translation.py", "rows.py", "layout.py")
SOURCES = {
    "dop853": ("dop853.py", "tableau.py"),
    "dop54": ("dop54.py",),
    "radau": ("radau.py",),
    "gauss": ("gauss.py", "collocation.py"),
    "crossing": ("crossing.py", "gauss.py", "collocation.py"),
    "taylor": ("taylor.py",),
    "structure": ("structure.py", "collocation.py"),
}
"""Modules that a method is made of, besides the shared ones."""
CALLED = ("run", "sample", "observe")
LANES = " lanes"
"""After the name of a method: the loop over lanes, a module and a function of this name."""
WIDE = " lanes_wide"
"""After the name of a method: the loop over eight lanes."""

_REAL, _WHOLE = np.dtype(np.float64), np.dtype(np.int64)
_ONE = threading.Lock()


class Loop(NamedTuple):
    """The functions that Python calls, by name, and what owns their code."""

    functions: dict[str, Function]
    keep: Any
    from_disk: bool


class Function:
    """A C function of integers and of arrays of integers or real numbers."""

    def __init__(self, address: int, arguments: Sequence[str], result: str) -> None:
        kinds: dict[str, Any] = {"None": None, "int": ctypes.c_int64, "float": ctypes.c_double}
        self.arguments = tuple(arguments)
        self.code = ctypes.CFUNCTYPE(
            kinds[result], *(kinds.get(kind, ctypes.c_void_p) for kind in self.arguments)
        )(address)

    def __call__(self, *values: Any) -> Any:
        """None stands for an array that is not used. Other threads run meanwhile; the keyboard is heard afterwards."""
        return self.code(*map(passed, values, self.arguments))


def passed(value: Any, kind: str) -> int | None:
    """What C gets of a value: an integer, or the address of the first number."""
    if value.__class__ is not np.ndarray:
        return value
    number = _REAL if kind == "Reals" else _WHOLE
    if value.dtype is not number and value.dtype != number or not value.flags.c_contiguous:
        raise TypeError(
            f"Expected a contiguous array of {number.name} for the compiled loop, got {value.dtype} of shape "
            f"{value.shape}. np.ascontiguousarray(..., dtype=...) makes one."
        )
    return address(value)


def address(array: Any) -> int:
    """Of the first number of an array, 0 if there is none."""
    if not array.size:
        return 0
    try:  # several times as fast as .ctypes.data
        return ctypes.addressof(ctypes.c_char.from_buffer(array))
    except (ValueError, TypeError):  # not to be written
        return int(array.ctypes.data)


def loop(method: str = "dop853") -> Loop:
    """The machine code of this process for a method."""
    with _ONE:  # two threads would make two, of which one is unloaded while it runs
        return _loop(method)


@cache
def _loop(method: str = "dop853") -> Loop:
    name, _, lanes = method.partition(" ")
    if lanes:
        return _made(_key(method), (lanes,), lambda: _module(lanes).functions(name))
    return _made(_key(method), CALLED, lambda: _module(name).FUNCTIONS)


def code(module: str, name: str, sources: Sequence[str]) -> Function:
    """Another compiled function, of a module, made from these sources."""
    with _ONE:
        return _code(module, name, tuple(sources)).functions[name]


@cache
def _code(module: str, name: str, sources: tuple[str, ...]) -> Loop:
    return _made(_hash(f"{module} {name}", sources), (name,), lambda: vars(_module(module)))


def _module(name: str) -> Any:
    return importlib.import_module(f".{name}", __package__)


def _made(key: str, names: Sequence[str], make: Callable[[], Mapping[str, Any]]) -> Loop:
    """Code from the disk, or made and kept there."""
    found = disk.load(key)
    loaded = None if found is None else _loaded(*found, names)
    if loaded is not None:
        return Loop(*loaded, True)
    made = _compiled(make(), names)
    loaded = _loaded(*made, names)
    if loaded is None:
        raise RuntimeError(
            f"Expected {', '.join(made[0]['needed'])} in this process's library of C, which the compiled loop calls, "
            "but not all of them are there."
        )
    disk.store(key, *made)
    return Loop(*loaded, False)


def _loaded(
    header: dict[str, Any], code: bytes, names: Sequence[str] = CALLED
) -> tuple[dict[str, Function], native.Library] | None:
    """Functions in object code; None if it is not what it should be."""
    if set(header) != {"functions", "needed"} or set(header["functions"]) != set(names):
        return None
    if not all(map(llvm.address_of_symbol, header["needed"])):  # LLVM would end the process for want of one
        return None
    try:
        library = native.Library(code)
    except RuntimeError:
        return None
    found = library.addresses(symbol for symbol, _, _ in header["functions"].values())
    if not all(found.values()):
        return None
    functions = {
        name: Function(found[symbol], *types) for name, (symbol, *types) in header["functions"].items()
    }
    return functions, library


def _compiled(made: Mapping[str, Any], names: Sequence[str]) -> tuple[dict[str, Any], bytes]:
    """Header and object code of functions, with what they call."""
    from .translation import translated  # not where code is found on the disk

    called = {name: made[name] for name in names}
    code, needed = native.optimised_code(translated({f"loop_{name}": one for name, one in called.items()}))
    functions = {name: (f"loop_{name}", one.arguments, one.result) for name, one in called.items()}
    return {"needed": needed, "functions": functions}, code


def _key(method: str = "dop853") -> str:
    """Hash of the source of the loop and of what compiles it."""
    name, more = method.split()[0], tuple[str, ...]()
    if method != name:
        more = ("lanes.py", "lanes_layout.py")
    if method.endswith(WIDE):
        more = (*more, "lanes_wide.py", "machine_wide.py", f"{name}_wide.py")
    return _hash(method, (*SHARED, *SOURCES[name], *more))


def _hash(what: str, sources: Sequence[str]) -> str:
    digest = hashlib.sha256(f"loop {what} {disk.VERSION} {native.version()}\n".encode())
    for name in sources:
        digest.update(Path(__file__).with_name(name).read_bytes())
    return digest.hexdigest()


_used: dict[str, Callable[[int], int]] = {}
"""`stepping.run` of the methods whose code is in this process."""


def use(method: str) -> Callable[[int], int]:
    """`stepping.run` of a method, which is loaded before anything else is called: a function of an address."""
    if method not in _used:
        _used[method] = loop(method).functions["run"].code
    return _used[method]


def sample(method: str, *arguments: Any) -> None:
    """`stepping.sample`: states at given times."""
    loop(method).functions["sample"](*arguments)


def observe(*arguments: Any) -> None:
    """`stepping.observe`: outputs of a kernel at given states; all methods have it."""
    loop(next(iter(_used), "dop853")).functions["observe"](*arguments)


def observed(kernel: int, outputs: int, t: float, y: Any, constants: int) -> list[float]:
    """Outputs of the kernel at an address at one state, with the constants at another."""
    room = np.array([t, *y, *outputs * (0.0,)])
    time, n = address(room), len(y)
    state = time + room.itemsize
    functions = loop(next(iter(_used), "dop853")).functions
    functions["observe"].code(kernel, 1, time, state, n, constants, state + n * room.itemsize, outputs)
    return list(room[1 + n :].tolist())
