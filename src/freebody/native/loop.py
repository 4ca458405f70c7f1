"""The compiled loop as functions of arrays: its machine code, from the disk or made now.

The loop of a method (`stepping`, with `dop853` or another) is translated (`translation`) and compiled by LLVM when a
run first asks for it. Its machine code needs nothing but the library of C, so it is kept with the kernels
(`native.cache`) under the hash of its source and of what compiles it (`native.sources`); later processes load it as
they load a kernel.
"""

from __future__ import annotations

import ctypes
import hashlib
import importlib
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np

from . import cache as disk
from . import codegen, sources

_REAL, _WHOLE = np.dtype(np.float64), np.dtype(np.int64)
_ONE = threading.Lock()
_loops: dict[str, Loop] = {}


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


def made(
    what: str, modules: Sequence[str], names: Sequence[str], make: Callable[[], Mapping[str, Any]]
) -> Loop:
    """Return functions by name, made of compiled functions that ``make`` returns, once in a process.

    ``what`` tells loops of the same modules apart; ``modules``, such as ``"motion.ode.dop853"``, are those
    whose sources shape the code.
    """
    with _ONE:  # two threads would make two, of which one is unloaded while it runs
        if what not in _loops:
            _loops[what] = _made(key(what, *modules), names, make)
        return _loops[what]


def code(module: str, name: str) -> Function:
    """Return a compiled function of a module, such as ``"motion.start.gauss_newton"``."""
    found = made(f"{module} {name}", (module,), (name,), lambda: vars(module_named(module)))
    return found.functions[name]


def module_named(name: str) -> Any:
    """Return a module of the package by its name, such as ``"motion.ode.dop853"``."""
    return importlib.import_module(f"{__name__.partition('.')[0]}.{name}")


def key(what: str, *modules: str) -> str:
    """Hash of the sources of a loop and of what compiles it."""
    source = sources.identity(*modules, __name__.partition(".")[2])
    return hashlib.sha256(f"loop {what} {source} {codegen.version()} {np.__version__}".encode()).hexdigest()


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
    header: dict[str, Any], code: bytes, names: Sequence[str]
) -> tuple[dict[str, Function], codegen.Library] | None:
    """Functions in object code; None if it is not what it should be."""
    if set(header) != {"functions", "needed"} or set(header["functions"]) != set(names):
        return None
    if not all(map(llvm.address_of_symbol, header["needed"])):  # LLVM would end the process for want of one
        return None
    try:
        library = codegen.Library(code)
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
    code, needed = codegen.optimised_code(translated({f"loop_{name}": one for name, one in called.items()}))
    functions = {name: (f"loop_{name}", one.arguments, one.result) for name, one in called.items()}
    return {"needed": needed, "functions": functions}, code
