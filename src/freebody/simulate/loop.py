"""The compiled loop as functions of arrays: its machine code, from the disk or from numba.

numba compiles the loop of a method (`stepping`, with `dop853` or another) once, when a run first asks for it. What LLVM
makes of it stands alone, so it is kept with the kernels (`compile.cache`) under the hash of its source and of what
compiles it; later processes load it as they load a kernel, and never import numba.

Machine code that would need more than the libraries of C is not kept: then numba, which can supply what is missing,
compiles the loop in each process.
"""

from __future__ import annotations

import ctypes
import hashlib
import importlib
import importlib.util
import re
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np

from ..compile import cache as disk
from ..compile import native

SHARED = ("loop.py", "stepping.py", "machine.py", "rows.py", "layout.py")
SOURCES = {
    "dop853": ("dop853.py", "tableau.py"),
    "dop54": ("dop54.py",),
    "radau": ("radau.py",),
    "gauss": ("gauss.py", "collocation.py"),
    "taylor": ("taylor.py",),
    "structure": ("structure.py", "collocation.py"),
}
"""Modules that a method is made of, besides the shared ones."""
CALLED = ("run", "sample", "observe")
LANES = " lanes"
"""After the name of a method: with the loop over lanes, which adds ``lanes`` to what is called."""
UNWATCHED = " unwatched"
"""After the name of a method: without the search for events."""
WIDE = " wide"
"""After the name of a method: the loop over eight lanes, ``lanes_wide``, alone; `UNWATCHED` may follow."""
LIBRARIES = frozenset(
    ("pow", "exp", "exp2", "log", "log2", "fma", "floor", "ceil", "memcpy", "memset", "memmove")
)
"""Functions of C that the code may call, if this process has them."""

_REAL, _WHOLE = np.dtype(np.float64), np.dtype(np.int64)
_ONE = threading.Lock()
_DECLARED = re.compile(r'^declare [^@\n]*@"?([^"(\n]+)"?\(', re.MULTILINE)
_OUTSIDE = re.compile(r'^@"?([^"=\n]+?)"? = (?:external|extern_weak) ', re.MULTILINE)


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
    def compiled() -> Mapping[str, Any]:
        if WIDE in method:
            name, _, more = method.partition(WIDE)
            return _module("lanes_wide").functions(name, not more)
        if method.endswith(LANES):
            return _module("lanes").functions(method.removesuffix(LANES))
        if method.endswith(UNWATCHED):
            return _module(method.removesuffix(UNWATCHED)).FUNCTIONS.unwatched()
        return _module(method).FUNCTIONS

    return _made(_key(method), _called(method), compiled)


def code(module: str, name: str, sources: Sequence[str]) -> Function:
    """Another compiled function, of a module whose ``FUNCTIONS`` are made from these sources."""
    with _ONE:
        return _code(module, name, tuple(sources)).functions[name]


@cache
def _code(module: str, name: str, sources: tuple[str, ...]) -> Loop:
    return _made(_hash(module, sources), (name,), lambda: _module(module).FUNCTIONS)


def _module(name: str) -> Any:
    return importlib.import_module(f".{name}", __package__)


def _made(key: str, names: Sequence[str], make: Callable[[], Mapping[str, Any]]) -> Loop:
    """Code from the disk, or made and kept there."""
    found = disk.load(key)
    loaded = None if found is None else _loaded(*found, names)
    if loaded is not None:
        return Loop(*loaded, True)
    compiled = make()
    alone = _standalone(compiled, names)
    loaded = None if alone is None else _loaded(*alone, names)
    if alone is None or loaded is None:  # numba holds what the code needs besides
        called = {name: compiled[name] for name in names}
        functions = {
            name: Function(int(made.code.address), made.arguments, made.result)
            for name, made in called.items()
        }
        return Loop(functions, compiled, False)
    disk.store(key, *alone)
    return Loop(*loaded, False)


def _called(method: str) -> tuple[str, ...]:
    """What Python calls of a method."""
    if WIDE in method:
        return ("lanes_wide",)
    return (*CALLED, "lanes") if method.endswith(LANES) else CALLED


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


def _standalone(
    compiled: Mapping[str, Any], names: Sequence[str] = CALLED
) -> tuple[dict[str, Any], bytes] | None:
    """Header and object code of numba's functions; None if they need numba or Python to run."""
    context = llvm.create_context()
    for name in names:
        compiled[name].compile()
    # with what they call; a method may use one function in two places
    once = {id(f): f for f in compiled.values() if f.is_compiled}
    modules = [llvm.parse_assembly(f.code.inspect_llvm(), context=context) for f in once.values()]
    for module in modules[1:]:
        modules[0].link_in(module)
    text = str(modules[0])
    needed = outside(text)
    if not LIBRARIES.issuperset(needed):
        return None
    called = {name: compiled[name] for name in names}
    functions = {name: (made.code.native_name, made.arguments, made.result) for name, made in called.items()}
    header = {"needed": needed, "functions": functions}
    return header, native.object_code(text)


def outside(text: str) -> list[str]:
    """Names of what LLVM's text of a module asks of others.

    >>> outside("declare double @llvm.pow.f64(double, double)\\ndeclare void @PyErr_Clear()")
    ['PyErr_Clear', 'pow']
    """
    names = set(_OUTSIDE.findall(text))
    for name in _DECLARED.findall(text):
        part = name.split(".")
        if part[0] != "llvm":
            names.add(name)
        elif part[1] in LIBRARIES:  # the others become instructions
            names.add(part[1])
    return sorted(names)


def _key(method: str = "dop853") -> str:
    """Hash of the source of the loop and of what compiles it."""
    name, more = method.split()[0], tuple[str, ...]()
    if method.endswith(LANES) or WIDE in method:
        more = ("lanes.py", "lanes_layout.py")
    if WIDE in method:
        more = (*more, "lanes_wide.py", "machine_wide.py", f"{name}_wide.py")
    return _hash(method, (*SHARED, *SOURCES[name], *more))


def _hash(what: str, sources: Sequence[str]) -> str:
    digest = hashlib.sha256(f"loop {what} {disk.VERSION} {native.version()}\n".encode())
    for name in sources:
        digest.update(Path(__file__).with_name(name).read_bytes())
    # numba's version without an import of numba, which takes longer than a run
    numba = importlib.util.find_spec("numba")
    if numba is not None and numba.origin is not None:
        version = Path(numba.origin).with_name("_version.py")
        digest.update(version.read_bytes() if version.is_file() else b"")
    return digest.hexdigest()


_used: dict[str, Callable[[int], int]] = {}
"""`stepping.run` of the methods whose code is in this process."""


def use(method: str, watched: bool) -> Callable[[int], int]:
    """`stepping.run` of a method, which is loaded before anything else is called: a function of an address.

    Where nothing is ``watched``, the code of the search for events is not needed."""
    name = method if watched else method + UNWATCHED
    if name not in _used:
        _used[name] = loop(name).functions["run"].code
    return _used[name]


def sample(method: str, *arguments: Any) -> None:
    """`stepping.sample`: states at given times."""
    loop(method if method in _used else method + UNWATCHED).functions["sample"](*arguments)


def observe(*arguments: Any) -> None:
    """`stepping.observe`: outputs of a kernel at given states; all methods have it."""
    loop(next(iter(_used), "dop853" + UNWATCHED)).functions["observe"](*arguments)
