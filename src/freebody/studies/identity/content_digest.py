"""Digest of a value by its content: the same in every process, different if anything in the value differs.

    digest(x) = SHA-256(kind of x, digests of its parts)

The content of numbers, texts, containers, arrays and SymPy expressions is their value; of a record of freebody, its
fields. The content of a Python function is its code, its default arguments, the object it is bound to, and the values
of the outer names that it reads, functions and classes among them; of another object, its class and its state, as
pickle stores them. Installed modules (the standard library, packages) are represented by name and version. An object
that is reached twice counts as one object reached twice. Left out are file names, line numbers, and objects that code
looks up by a text that it makes while it runs.
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
"""Attributes of a class that tell its place in the source, or follow from its other attributes."""


class NoContentError(Exception):
    """A value whose content cannot be read; ``args`` are the value and, from the inside out, the objects around it."""


def digest(value: Any, named: tuple[type, ...] = (), aliases: Mapping[str, str] | None = None) -> str:
    """Return the digest of a value, in hexadecimal.

    Parameters
    ----------
    value : any
    named : types, optional
        Records of these types are represented by their names alone; their content belongs to other parts.
    aliases : mapping, optional
        Other names for symbols and for these records.

    Raises
    ------
    NoContentError
        A file, a lock, a generator, or another object that cannot be sent to another process.

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
    """Return the digest of a value without parts."""
    content = content.encode("utf-8", "surrogatepass") if isinstance(content, str) else content
    return hashlib.sha256(f"leaf {kind}\n".encode() + content).digest()


def _node(kind: str, parts: Iterable[bytes]) -> bytes:
    """Return the digest of a value from the digests of its parts."""
    parts = list(parts)
    return hashlib.sha256(f"node {kind} {len(parts)}\n".encode() + b"".join(parts)).digest()


class _Reader:
    """Reader of one value, with memory of the objects that it has read."""

    def __init__(self, named: tuple[Any, ...], aliases: Mapping[str, str]) -> None:
        self.named, self.aliases = named, aliases
        self.read: dict[
            int, tuple[int, Any]
        ] = {}  # holds the object too, so that its address is not used again
        self.expressions: dict[Any, bytes] = {}
        self.dummies: dict[Any, int] = {}

    def of(self, x: Any) -> bytes:
        """Return the digest of a value."""
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
            # each element by a reader of its own, since their order differs from process to process
            return _node("set", sorted(_Reader(self.named, self.aliases).of(element) for element in x))
        if kind is CodeType:
            return self.code(x)
        if self.named and isinstance(x, self.named):
            return _leaf(kind.__name__, self.aliases.get(x.name, x.name))
        if id(x) in self.read:
            return _leaf("again", str(self.read[id(x)][0]))
        if not _is_record(x):  # records are immutable, and the same as their equals
            self.read[id(x)] = len(self.read), x
        try:
            return self.shared(x, kind)
        except NoContentError as error:
            error.args = (*error.args, _called(x))
            raise

    def shared(self, x: Any, kind: type) -> bytes:
        """Return the digest of an object that may be reached in several ways."""
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
            # fields that are not compared do not count
            values = [getattr(x, field.name) for field in fields(x) if field.compare]
            return _node(f"record {kind.__qualname__}", map(self.of, values))
        if hasattr(x, "__wrapped__"):  # such as by functools.lru_cache
            return _node(f"wrapped {_name(kind)}", [self.of(x.__wrapped__)])
        if kind is BuiltinFunctionType and isinstance(x.__self__, ModuleType | NoneType):
            return _leaf("builtin", _name(x))
        return self.object(x, kind)

    # -- numbers and expressions ----------------------------------------------------------------------------

    def expression(self, e: Any) -> bytes:
        """Return the digest of a SymPy expression; sums and products have no order."""
        result = self.expressions.get(e)
        if result is None:
            result = self.expressions[e] = self._expression(e)
        return result

    def _expression(self, e: Any) -> bytes:
        if e.is_Rational and e.is_finite:
            return _leaf("number", str(Fraction(int(e.p), int(e.q))))
        if e.is_Float:
            return _leaf("Float", repr(e._mpf_))
        if e.is_Symbol:
            number = self.dummies.setdefault(e, len(self.dummies)) if isinstance(e, sympy.Dummy) else ""
            parts = [self.of(vars(e))] if getattr(e, "__dict__", None) else []  # samples of a signal
            name = self.aliases.get(e.name, e.name)
            assumed = _leaf("assumed", repr(sorted(e.assumptions0.items())))
            return _node("symbol", [_leaf(f"{type(e).__name__} {number}", name), assumed, *parts])
        kind = "function" if isinstance(e, sympy.core.function.AppliedUndef) else "expression"
        parts = [self.of(x) for x in e.args]
        if e.is_Add or e.is_Mul:
            parts.sort()
        return _node(kind, [_leaf("of", f"{type(e).__name__} {'' if e.args else e}"), *parts])

    # -- code -----------------------------------------------------------------------------------------------

    def function(self, f: FunctionType) -> bytes:
        """Return the digest of a Python function: its code, its closure and defaults, and the names of its module."""
        cells = [cell.cell_contents if _is_set(cell) else ... for cell in f.__closure__ or ()]
        others = {name: x for name, x in vars(f).items() if name != "__wrapped__"}
        parts = [self.of(x) for x in (f.__code__, f.__defaults__, f.__kwdefaults__, others)]
        names = frozenset(_names(f.__code__))
        parts += [self.module(x, names) if isinstance(x, ModuleType) else self.of(x) for x in cells]
        if not _installed(f.__code__.co_filename):
            for name in sorted(set(_globals(f.__code__))):
                if name in f.__globals__:
                    x = f.__globals__[name]
                    content = self.module(x, names) if isinstance(x, ModuleType) else self.of(x)
                    parts.append(_node(f"global {name}", [content]))
            for name in sorted(set(_imported(f.__code__, f.__globals__.get("__package__") or ""))):
                parts.append(self._module_named(name, names))
        return _node("python function", parts)

    def code(self, code: CodeType) -> bytes:
        """Return the digest of instructions and constants, without places in the source and the name."""
        attributes = (
            code.co_code, code.co_exceptiontable, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars,
            code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags, code.co_consts,
        )  # fmt: skip
        return _node("code", map(self.of, attributes))

    def module(self, module: ModuleType, names: frozenset[str] | None = None) -> bytes:
        """Return the digest of a module: by name if it is installed, else by the values of these names, or of all."""
        if _is_installed_module(module):
            return _leaf("module", _versioned(module.__name__))
        if names is not None:
            members = sorted(name for name in names if name in vars(module))
        else:
            members = sorted(name for name in vars(module) if not name.startswith("__"))
        kind = "main" if module.__name__ == "__main__" else f"module {module.__name__}"
        return _node(kind, (self._member(vars(module), name, names) for name in members))

    def _member(self, members: Any, name: str, names: frozenset[str] | None = None) -> bytes:
        x = members[name]
        return _node(f"member {name}", [self.module(x, names) if isinstance(x, ModuleType) else self.of(x)])

    def _module_named(self, name: str, names: frozenset[str]) -> bytes:
        try:
            module = importlib.import_module(name)
        except Exception:  # the controller will raise the same error
            return _leaf("no module", name)
        return self.module(module, names)

    def of_class(self, cls: type) -> bytes:
        """Return the digest of a class: its name and, unless it is installed, its bases and members."""
        module = sys.modules.get(cls.__module__)
        if module is not None and _is_installed_module(module):
            return _leaf("class", _name(cls))
        members = sorted(name for name in vars(cls) if name not in _NO_MEMBERS)
        parts = [self._member(vars(cls), name) for name in members]
        return _node(f"class {cls.__qualname__}", [self.of(cls.__bases__), *parts])

    def object(self, x: Any, kind: type) -> bytes:
        """Return the digest of another object: its class, and its state as pickle stores it."""
        if kind in (property, staticmethod, classmethod):
            functions = (x.fget, x.fset, x.fdel) if kind is property else (x.__func__,)
            return _node(kind.__name__, map(self.of, functions))
        if kind.__name__ in (
            "member_descriptor",
            "getset_descriptor",
            "wrapper_descriptor",
            "method_descriptor",
        ):
            return _leaf(kind.__name__, x.__name__)
        reduced = copyreg.dispatch_table.get(kind)
        try:
            state = x.__reduce_ex__(4) if reduced is None else reduced(x)
            if isinstance(state, str):
                return self.named_in_module(x, kind, state)
        except Exception:
            raise NoContentError(x) from None
        parts = [self.of(kind)]
        for part in state:
            parts.append(_node("items", map(self.of, part)) if isinstance(part, Iterator) else self.of(part))
        return _node("object", parts)

    def named_in_module(self, x: Any, kind: Any, name: str) -> bytes:
        """Return the digest of an object that a package holds under a name, such as a function of NumPy."""
        module = pickle.whichmodule(x, name)  # type: ignore[attr-defined]
        owner: Any = sys.modules[module]
        if not _installed(owner.__file__) or getattr(owner, name) is not x:
            raise NoContentError(x)
        return _node("named", [self.of(kind), _leaf("name", f"{_versioned(module)} {name}")])


def _is_record(x: Any) -> bool:
    return is_dataclass(x) and not isinstance(x, type) and type(x).__module__.startswith(f"{_OWN}.")


def _is_installed_module(module: ModuleType) -> bool:
    """Return True if a module is part of freebody, of Python or of a package; code that is typed in has no file."""
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
    """Yield a code object and the code objects of the functions and classes within."""
    yield code
    for x in code.co_consts:
        if isinstance(x, CodeType):
            yield from _codes(x)


def _names(code: CodeType) -> Iterator[str]:
    for part in _codes(code):
        yield from part.co_names


def _globals(code: CodeType) -> Iterator[str]:
    for part in _codes(code):
        yield from (x.argval for x in dis.get_instructions(part) if x.opname in _LOOKED_UP)


def _imported(code: CodeType, package: str) -> Iterator[str]:
    """Yield the names of modules that a code object imports."""
    for part in _codes(code):
        before: list[Any] = [None, None]
        for x in dis.get_instructions(part):
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
    """Return the folders of Python and of packages."""
    paths = sysconfig.get_paths()
    folders = [paths[name] for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    folders += [*site.getsitepackages(), site.getusersitepackages()]
    return tuple(dict.fromkeys(Path(folder).resolve() for folder in folders))


@cache
def _installed(file: str) -> bool:
    """Return True if a file is part of Python, of a package, or of freebody; typed code has a name like <stdin>."""
    if file.startswith("<"):
        return file.startswith("<frozen")
    parents = Path(file).resolve().parents
    if any(folder in parents for folder in (Path(__file__).parents[2], *_folders())):
        return True
    # packages of another environment, which a .pth file or PYTHONPATH adds
    return any(folder.name in ("site-packages", "dist-packages") for folder in parents)


def _versioned(module: str) -> str:
    """Return the name of a module with the version of its package; without, for freebody (`study_identity.version`)."""
    top = module.partition(".")[0]
    if top == _OWN:
        return module
    python = f"{sys.version_info.major}.{sys.version_info.minor}"  # version of the standard library
    version = getattr(sys.modules.get(top), "__version__", None)
    return f"{module} {version if isinstance(version, str) else python}"


def _name(x: Any) -> str:
    return f"{_versioned(x.__module__ or 'builtins')} {x.__qualname__}"


def _called(x: Any) -> str:
    return getattr(x, "__qualname__", None) or type(x).__qualname__
