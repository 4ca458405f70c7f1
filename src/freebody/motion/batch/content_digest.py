"""Digest of a value by its content: the same in every process, another as soon as anything in it differs.

    digest(x) = SHA-256(kind of x, digests of its parts)

Numbers, texts, containers, arrays and SymPy expressions are their values; a record of freebody is its fields. A Python
function is its code, its default arguments, what it is bound to, and the values of the names outside of it that it
reads, functions and classes among them; an object is its class and its state, as pickle would keep them. What is
installed (the standard library, packages) is named with its version. What is reached twice counts as one thing reached
twice. Left out are file names, line numbers, and what code looks up by a text that it makes while it runs.
"""

from __future__ import annotations

import copyreg
import dis
import hashlib
import importlib.util
import pickle
import site
import sys
import sysconfig
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import (
    BuiltinFunctionType,
    CodeType,
    EllipsisType,
    FunctionType,
    MappingProxyType,
    MethodType,
    ModuleType,
    NoneType,
    NotImplementedType,
)
from typing import Any

import numpy as np
import sympy

_PLAIN = (NoneType, bool, str, bytes, complex, range, slice, EllipsisType, NotImplementedType)
_OWN = __name__.partition(".")[0]
_LOOKED_UP = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS")
_NO_MEMBERS = frozenset(
    [
        "__dict__",
        "__weakref__",
        "__module__",
        "__doc__",
        "__abstractmethods__",
        "_abc_impl",
        "__firstlineno__",
        "__static_attributes__",
    ]
)
"""Of a class: what Python keeps of where it stands, and what follows from the rest."""


class NoContentError(Exception):
    """A value of which no content can be read; ``args`` are the value and, from the inside out, where it stands."""


def digest(value: Any, named: tuple[type, ...] = (), aliases: Mapping[str, str] | None = None) -> str:
    """Digest of a value, in hexadecimal.

    Parameters
    ----------
    value : any
    named : types, optional
        Records of these types are told apart by their names alone: what is in them is told elsewhere.
    aliases : mapping, optional
        Names of symbols and of these records that are read as others.

    Raises
    ------
    NoContentError
        A file, a lock, a generator, or whatever else no other process could be given.

    Examples
    --------
    >>> digest([1, 2.5]) == digest([1, 2.5]), digest([1, 2.5]) == digest([1, 2.75])
    (True, False)
    >>> gains = [3]
    >>> control = lambda t, x: -gains[0] * x["theta"]
    >>> before = digest(control)
    >>> gains[0] = 4
    >>> digest(control) == before
    False
    """
    try:
        return _Reader(named, aliases or {}).of(value).hex()
    except RecursionError:
        raise NoContentError(value) from None


def _leaf(kind: str, content: bytes | str) -> bytes:
    content = content.encode("utf-8", "surrogatepass") if isinstance(content, str) else content
    return hashlib.sha256(f"leaf {kind}\n".encode() + content).digest()


def _node(kind: str, parts: Iterable[bytes]) -> bytes:
    parts = list(parts)
    return hashlib.sha256(f"node {kind} {len(parts)}\n".encode() + b"".join(parts)).digest()


class _Reader:
    """Reads one value; knows what it has read."""

    def __init__(self, named: tuple[Any, ...], aliases: Mapping[str, str]) -> None:
        self.named, self.aliases = named, aliases
        self.seen: dict[int, tuple[int, Any]] = {}  # the value too, or another could get its address
        self.expressions: dict[Any, bytes] = {}
        self.dummies: dict[Any, int] = {}

    def of(self, x: Any) -> bytes:
        """Digest of a value."""
        if isinstance(x, sympy.Basic):
            return self.expression(x)
        kind: Any = type(x)
        if kind in _PLAIN:
            return _leaf(kind.__name__, repr(x))
        if kind in (int, Fraction):
            return _leaf("number", str(x))
        if kind is float:
            return _leaf("float", x.hex())
        if isinstance(x, np.generic) and not x.dtype.hasobject:
            return _leaf(f"numpy {x.dtype.str}", x.tobytes())
        if kind is tuple:
            return _node("tuple", map(self.of, x))
        if kind in (set, frozenset):
            # each by itself: their order differs from process to process
            return _node("set", sorted(_Reader(self.named, self.aliases).of(one) for one in x))
        if kind is CodeType:
            return self.code(x)
        if self.named and isinstance(x, self.named):
            return _leaf(kind.__name__, self.aliases.get(x.name, x.name))
        if id(x) in self.seen:
            return _leaf("again", str(self.seen[id(x)][0]))
        if not _is_record(x):  # which can not be changed, and is the same as its equal
            self.seen[id(x)] = len(self.seen), x
        try:
            return self.reached(x, kind)
        except NoContentError as error:
            error.args = (*error.args, _called(x))
            raise

    def reached(self, x: Any, kind: type) -> bytes:
        """Digest of what may be reached in several ways."""
        if kind in (list, MappingProxyType, dict):
            items = x if kind is list else (y for pair in x.items() for y in pair)
            return _node(kind.__name__, map(self.of, items))
        if isinstance(x, np.ndarray) and kind is np.ndarray:
            if x.dtype.hasobject:
                return _node(f"array {x.shape}", map(self.of, x.ravel().tolist()))
            return _leaf(f"array {x.shape} {x.dtype.descr}", np.ascontiguousarray(x).tobytes())
        if isinstance(x, FunctionType):
            return self.function(x)
        if kind is MethodType:
            return _node("method", (self.of(x.__func__), self.of(x.__self__)))
        if isinstance(x, ModuleType):
            return self.module(x)
        if isinstance(x, type):
            return self.of_class(x)
        if _is_record(x):
            # what two of them may differ in and still be equal is not what they are
            own = [getattr(x, one.name) for one in fields(x) if one.compare]
            return _node(f"record {kind.__qualname__}", map(self.of, own))
        if hasattr(x, "__wrapped__"):  # such as by functools.lru_cache
            return _node(f"wrapped {_name(kind)}", [self.of(x.__wrapped__)])
        if kind is BuiltinFunctionType and isinstance(x.__self__, ModuleType | NoneType):
            return _leaf("builtin", _name(x))
        return self.object(x, kind)

    # -- numbers and expressions ----------------------------------------------------------------------------

    def expression(self, e: Any) -> bytes:
        """A SymPy expression; sums and products have no order."""
        found = self.expressions.get(e)
        if found is None:
            found = self.expressions[e] = self._expression(e)
        return found

    def _expression(self, e: Any) -> bytes:
        if e.is_Rational and e.is_finite:
            return _leaf("number", str(Fraction(int(e.p), int(e.q))))
        if e.is_Float:
            return _leaf("Float", repr(e._mpf_))
        if e.is_Symbol:
            known = self.dummies.setdefault(e, len(self.dummies)) if isinstance(e, sympy.Dummy) else ""
            parts = [self.of(vars(e))] if getattr(e, "__dict__", None) else []  # of a signal: its samples
            name = self.aliases.get(e.name, e.name)
            assumed = _leaf("assumed", repr(sorted(e.assumptions0.items())))
            return _node("symbol", [_leaf(f"{type(e).__name__} {known}", name), assumed, *parts])
        kind = "function" if isinstance(e, sympy.core.function.AppliedUndef) else "expression"
        parts = [self.of(x) for x in e.args]
        if e.is_Add or e.is_Mul:
            parts.sort()
        return _node(kind, [_leaf("of", f"{type(e).__name__} {'' if e.args else e}"), *parts])

    # -- code -----------------------------------------------------------------------------------------------

    def function(self, f: FunctionType) -> bytes:
        """A Python function: its code, what it was made with, and what it reads of its module."""
        cells = [cell.cell_contents if _is_set(cell) else ... for cell in f.__closure__ or ()]
        others = {name: x for name, x in vars(f).items() if name != "__wrapped__"}
        parts = [self.of(x) for x in (f.__code__, f.__defaults__, f.__kwdefaults__, others)]
        names = frozenset(_names(f.__code__))
        parts += [self.module(x, names) if isinstance(x, ModuleType) else self.of(x) for x in cells]
        if not _installed(f.__code__.co_filename):
            for name in sorted(set(_globals(f.__code__))):
                if name in f.__globals__:
                    x = f.__globals__[name]
                    found = self.module(x, names) if isinstance(x, ModuleType) else self.of(x)
                    parts.append(_node(f"global {name}", [found]))
            for name in sorted(set(_imported(f.__code__, f.__globals__.get("__package__") or ""))):
                parts.append(self._module_named(name, names))
        return _node("python function", parts)

    def code(self, code: CodeType) -> bytes:
        """Instructions and constants; neither where they stand nor what they are called."""
        said = (
            code.co_code, code.co_exceptiontable, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars,
            code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags, code.co_consts,
        )  # fmt: skip
        return _node("code", map(self.of, said))

    def module(self, module: ModuleType, names: frozenset[str] | None = None) -> bytes:
        """A module that is installed, by name; of another, the values of these names, or of all."""
        if _known(module):
            return _leaf("module", _versioned(module.__name__))
        if names is not None:
            found = sorted(name for name in names if name in vars(module))
        else:
            found = sorted(name for name in vars(module) if not name.startswith("__"))
        kind = "main" if module.__name__ == "__main__" else f"module {module.__name__}"
        return _node(kind, (self._member(vars(module), name, names) for name in found))

    def _member(self, where: Any, name: str, names: frozenset[str] | None = None) -> bytes:
        x = where[name]
        return _node(f"member {name}", [self.module(x, names) if isinstance(x, ModuleType) else self.of(x)])

    def _module_named(self, name: str, names: frozenset[str]) -> bytes:
        try:
            module = importlib.import_module(name)
        except Exception:  # the controller will tell
            return _leaf("no module", name)
        return self.module(module, names)

    def of_class(self, cls: type) -> bytes:
        """A class: its name and, unless it is installed, its bases and its members."""
        module = sys.modules.get(cls.__module__)
        if module is not None and _known(module):
            return _leaf("class", _name(cls))
        members = sorted(name for name in vars(cls) if name not in _NO_MEMBERS)
        parts = [self._member(vars(cls), name) for name in members]
        return _node(f"class {cls.__qualname__}", [self.of(cls.__bases__), *parts])

    def object(self, x: Any, kind: type) -> bytes:
        """Any other object: its class, and its state as pickle would keep it."""
        if kind in (property, staticmethod, classmethod):
            inside = (x.fget, x.fset, x.fdel) if kind is property else (x.__func__,)
            return _node(kind.__name__, map(self.of, inside))
        if kind.__name__ in (
            "member_descriptor",
            "getset_descriptor",
            "wrapper_descriptor",
            "method_descriptor",
        ):
            return _leaf(kind.__name__, x.__name__)
        reduced = copyreg.dispatch_table.get(kind)
        try:
            kept = x.__reduce_ex__(4) if reduced is None else reduced(x)
            if isinstance(kept, str):
                return self.named_in_module(x, kind, kept)
        except Exception:
            raise NoContentError(x) from None
        parts = [self.of(kind)]
        for one in kept:
            parts.append(_node("items", map(self.of, one)) if isinstance(one, Iterator) else self.of(one))
        return _node("object", parts)

    def named_in_module(self, x: Any, kind: Any, name: str) -> bytes:
        """What a package knows by a name, such as a function of NumPy."""
        module = pickle.whichmodule(x, name)  # type: ignore[attr-defined]
        found: Any = sys.modules[module]
        if not _installed(found.__file__) or getattr(found, name) is not x:
            raise NoContentError(x)
        return _node("named", [self.of(kind), _leaf("name", f"{_versioned(module)} {name}")])


def _is_record(x: Any) -> bool:
    return is_dataclass(x) and not isinstance(x, type) and type(x).__module__.startswith(f"{_OWN}.")


def _known(module: ModuleType) -> bool:
    """Whether a module is freebody's, or part of Python or of a package; what is typed in has no file."""
    file = getattr(module, "__file__", None)
    if module.__name__.partition(".")[0] == _OWN or module.__name__ in sys.builtin_module_names:
        return True
    spec = getattr(module, "__spec__", None)
    return (spec is not None and spec.origin == "frozen") if file is None else _installed(file)


def _is_set(cell: Any) -> bool:
    try:
        cell.cell_contents  # noqa: B018
    except ValueError:
        return False
    return True


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A code and those of the functions and classes within."""
    yield code
    for x in code.co_consts:
        if isinstance(x, CodeType):
            yield from _codes(x)


def _names(code: CodeType) -> Iterator[str]:
    for one in _codes(code):
        yield from one.co_names


def _globals(code: CodeType) -> Iterator[str]:
    for one in _codes(code):
        yield from (x.argval for x in dis.get_instructions(one) if x.opname in _LOOKED_UP)


def _imported(code: CodeType, package: str) -> Iterator[str]:
    """Names of modules that a code imports."""
    for one in _codes(code):
        before: list[Any] = [None, None]
        for x in dis.get_instructions(one):
            if x.opname == "IMPORT_NAME":
                level = before[0] if isinstance(before[0], int) else 0
                yield (
                    importlib.util.resolve_name("." * level + x.argval, package)
                    if level and package
                    else x.argval
                )
            before = [before[1], x.argval]


@cache
def _folders() -> tuple[Path, ...]:
    paths = sysconfig.get_paths()
    known = [paths[name] for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    known += [*site.getsitepackages(), site.getusersitepackages()]
    return tuple(dict.fromkeys(Path(one).resolve() for one in known))


@cache
def _installed(file: str) -> bool:
    """Whether a file is part of Python, of a package, or of freebody itself; what is typed is <stdin> or the like."""
    if file.startswith("<"):
        return file.startswith("<frozen")
    above = Path(file).resolve().parents
    return any(one in above for one in (Path(__file__).parents[2], *_folders()))


def _versioned(module: str) -> str:
    """The name of a module with the version of its package; of freebody itself, without (see `identity.version`)."""
    top = module.partition(".")[0]
    if top == _OWN:
        return module
    python = f"{sys.version_info.major}.{sys.version_info.minor}"  # of its own modules
    version = getattr(sys.modules.get(top), "__version__", None)
    return f"{module} {version if isinstance(version, str) else python}"


def _name(x: Any) -> str:
    return f"{_versioned(x.__module__ or 'builtins')} {x.__qualname__}"


def _called(x: Any) -> str:
    return getattr(x, "__qualname__", None) or type(x).__qualname__
