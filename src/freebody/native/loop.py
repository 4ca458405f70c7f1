"""Compiled loops as functions of arrays, loaded from the disk or compiled now.

The loop of a method (`motion.ode.step_control` with `dop853` or another) is translated (`translation`) and compiled by
LLVM when a run first needs it. Its machine code needs nothing but the C library, so it is stored with the kernels
(`cache`) under the hash of its source and of the source that compiles it (`sources`). Later processes load it from the
disk like a kernel.
"""

from __future__ import annotations

import ctypes
import hashlib
import importlib
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np

from . import cache as disk
from . import codegen, sources
from .records import Record, address

_REAL, _WHOLE = np.dtype(np.float64), np.dtype(np.int64)
_loops: dict[str, Loop] = {}
_locks: dict[str, threading.Lock] = {}
_translating = threading.Lock()
"""Of the thread that translates: of several at once, each would be late, and LLVM would wait for the first."""


class Loop(NamedTuple):
    """The functions that Python calls, by name, and the library that owns their code."""

    functions: dict[str, Function]
    library: Any
    from_disk: bool


class Function:
    """A C function of integers and of arrays of integers or real numbers."""

    def __init__(self, address: int, arguments: Sequence[str], result: str) -> None:
        kinds: dict[str, Any] = {"None": None, "int": ctypes.c_int64, "float": ctypes.c_double}
        self.arguments, self.address = tuple(arguments), address
        self.code = ctypes.CFUNCTYPE(
            kinds[result], *(kinds.get(kind, ctypes.c_void_p) for kind in self.arguments)
        )(address)

    def __call__(self, *values: Any) -> Any:
        """Call the function; None stands for an array that is not used.

        Other threads run meanwhile. An interrupt from the keyboard takes effect after the call.
        """
        return self.code(*map(passed, values, self.arguments))


def passed(value: Any, kind: str) -> int | None:
    """Return a value as C receives it: a number, or the address of a record or of the first number of an array."""
    if value.__class__ is not np.ndarray:
        return value.address if isinstance(value, Record) else value
    number = _REAL if kind == "Reals" else _WHOLE
    if value.dtype is not number and value.dtype != number or not value.flags.c_contiguous:
        raise TypeError(
            f"Expected a contiguous array of {number.name} for the compiled loop, got {value.dtype} of shape "
            f"{value.shape}. np.ascontiguousarray(..., dtype=...) makes one."
        )
    return address(value)


def made(
    label: str,
    modules: Sequence[str],
    names: Sequence[str],
    make: Callable[[], Mapping[str, Any]],
    lanes: int = 1,
    passes: str = "all",
) -> Loop:
    """Return the functions ``names`` as a loop, made once in a process from the functions that ``make`` returns.

    ``lanes`` is the width of the translation; ``passes`` are those of `codegen.optimised_code`, which the functions may
    say themselves, or "hot": all for functions that are marked so (`instructions.hot`), a few for the others.
    ``label`` tells loops of the same modules apart. The sources of ``modules``, such as ``"motion.ode.dop853"``, shape
    the code.
    """
    with _locks.setdefault(label, threading.Lock()):
        if label not in _loops:  # two threads would make two loops, and one would be unloaded while it runs
            _loops[label] = _made(key(label, *modules), names, make, lanes, passes)
        return _loops[label]


def make_together(makers: Sequence[Callable[[], Any]]) -> None:
    """Make the loops that these functions return: LLVM compiles one while the next is translated."""
    with ThreadPoolExecutor(len(makers), thread_name_prefix="freebody") as pool:
        for maker in makers:  # none goes on after this: the process may fork later
            pool.submit(maker)  # what it refuses is refused again where the loop is needed


def code(module: str, name: str) -> Function:
    """Return a compiled function of a module, such as ``"motion.start.gauss_newton"``."""
    result = made(f"{module} {name}", (module,), (name,), lambda: vars(module_named(module)))
    return result.functions[name]


def module_named(name: str) -> Any:
    """Return a module of the package by its name, such as ``"motion.ode.dop853"``."""
    return importlib.import_module(f"{__name__.partition('.')[0]}.{name}")


def sibling(module: str, name: str) -> str:
    """Return the name of a module in the folder of another one, whose ``__name__`` is given.

    >>> sibling("freebody.motion.ode.loops", "dop853")
    'motion.ode.dop853'
    """
    return f"{module.partition('.')[2].rpartition('.')[0]}.{name}"


def key(label: str, *modules: str) -> str:
    """Hash of the sources of a loop and of the sources that compile it."""
    source = sources.identity(*modules, __name__.partition(".")[2])
    return hashlib.sha256(f"loop {label} {source} {codegen.version()} {np.__version__}".encode()).hexdigest()


def _made(
    key: str, names: Sequence[str], make: Callable[[], Mapping[str, Any]], lanes: int = 1, passes: str = "all",
) -> Loop:  # fmt: skip
    """Return the loop from the disk, or compile and store it."""
    stored = disk.load(key)
    loaded = None if stored is None else _loaded(*stored, names)
    if loaded is not None:
        return Loop(*loaded, True)
    header, code = _compiled(make(), names, lanes, passes)
    loaded = _loaded(header, code, names)
    if loaded is None:
        raise RuntimeError(
            f"Expected {', '.join(header['needed'])} in this process's C library, which the compiled loop calls, "
            "but not all of them are there."
        )
    disk.store(key, header, code)
    return Loop(*loaded, False)


def _loaded(
    header: dict[str, Any], code: bytes, names: Sequence[str]
) -> tuple[dict[str, Function], codegen.Library] | None:
    """Return the functions in object code and their library; None if the code is damaged, of other functions or of
    another processor.
    """
    if set(header) != {"functions", "needed", "target"} or set(header["functions"]) != set(names):
        return None
    if header["target"] != codegen.version():  # code of another processor must not run
        return None
    codegen.initialize()
    if not all(map(llvm.address_of_symbol, header["needed"])):  # without one, LLVM would end the process
        return None
    try:
        library = codegen.Library(code)
    except RuntimeError:
        return None
    addresses = library.addresses(symbol for symbol, _, _ in header["functions"].values())
    if not all(addresses.values()):
        return None
    functions = {
        name: Function(addresses[symbol], *types) for name, (symbol, *types) in header["functions"].items()
    }
    return functions, library


def _compiled(
    space: Mapping[str, Any], names: Sequence[str], lanes: int = 1, passes: str = "all",
) -> tuple[dict[str, Any], bytes]:  # fmt: skip
    """Header and object code of the functions ``names`` of a name space and of the functions that they call."""
    from .translation import by_heat, translated  # imported late: not needed if the code is on the disk

    chosen, passes = {name: space[name] for name in names}, getattr(space, "passes", passes)
    public, others = {f"loop_{name}": f for name, f in chosen.items()}, ""
    with _translating:
        if passes == "hot":
            text, others = by_heat(public, lanes)
        else:
            text = translated(public, lanes)
    code, needed = codegen.optimised_code(text, passes=passes, wide=lanes > 1, others=others)
    functions = {
        name: (f"loop_{name}", [getattr(x, "__name__", x) for x in f.arguments], f.result)
        for name, f in chosen.items()
    }
    return {"needed": needed, "functions": functions, "target": codegen.version()}, code
