"""Translation of functions of numbers and of arrays in memory from Python's syntax into LLVM's.

Compiled loops are written in a small part of Python, the compiled language (docs/compiled-language.md). Each of its
statements corresponds to instructions of a processor:

    integers, real numbers and truth values, one or one for each lane, and arrays of numbers, p[i];
    + - * / // % ** << >> & | ^, abs, comparisons, and, or, not, a if c else b, where(c, a, b), any, all,
    several names at once, if, while, for over range or over each lane, break, continue, return, calls

A variable has the type of its first value, and a value on every way to its use. Globals are constants: numbers, tables
(NumPy arrays), other functions of this kind, and instructions. Expressions of globals alone are evaluated during
translation, and a branch that they exclude is not translated. A function may call `Compiled` and `Instruction` objects;
any other call is refused.

One source serves one run and several lanes: the *width* of a translation is the number of lanes of the types `Real`,
`Whole`, `Truth` and `Row` (`WIDE_TYPES`), and of records of lanes (`records`). A function without such a type in its
signature is of one run at every width.

A module is translated function by function: their types and instructions (`functions`), statements (`statements`),
expressions (`expressions`), and arithmetic, which is that of the processor (`arithmetic`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from llvmlite import ir

from ..unreachable import no_collection
from .arithmetic import REAL, WHOLE, Refusal, constant
from .builder import Builder, ConstantTable, Function, Module
from .codegen import OWN
from .functions import Compiled, Inlined, signature
from .record_access import RecordPointer
from .statements import Body


def translated(functions: Mapping[str, Compiled], lanes: int = 1) -> str:
    """LLVM text of functions under these names, and of all functions that they call, for so many lanes."""
    with no_collection():
        return str(_unit(functions, lanes).module)


def by_heat(functions: Mapping[str, Compiled], lanes: int = 1) -> tuple[str, str]:
    """The same in two texts: the functions that are `instructions.hot`, and the others.

    Each declares those of the other. Functions without a name of the caller have names that begin with `codegen.OWN`.
    """
    with no_collection():
        unit = _unit(functions, lanes, prefix=OWN)
        parts: tuple[set[Any], set[Any]] = set(), set()
        for compiled, function in unit.defined:
            parts[compiled.hot].add(function)
            function.linkage = ""
        others, hot = parts
        return unit.module.without(others), unit.module.without(hot)


def parts(functions: Mapping[str, Compiled], lanes: int, public: bool = False) -> dict[str, str]:
    """LLVM text of functions, of the functions and the tables that they need, by name, for use in another module.

    Functions that the text calls but does not define are declared. The functions are ``public``, or internal.
    """
    result = {}
    with no_collection():
        for item in _unit(functions, lanes, internal=not public).module.globals.values():
            result[item.name] = str(item)
    return result


def _unit(functions: Mapping[str, Compiled], lanes: int, internal: bool = False, prefix: str = "") -> Unit:
    unit = Unit(prefix)
    for name, function in functions.items():
        unit.declare(function, lanes, name, internal)
    while unit.waiting:
        compiled, llvm_function, width = unit.waiting.pop()
        builder = Builder(llvm_function.append_basic_block())
        entry, begin = builder.block, builder.append_basic_block()
        builder.position_at_end(begin)
        body = Body(unit, compiled, builder, width)
        body.result = llvm_function.function_type.return_type
        body.write(llvm_function.args)
        builder.position_at_end(entry)  # the block of variables in memory
        builder.branch(begin)
    return unit


class Unit:
    """The functions of one module, each translated once for each width that is called."""

    def __init__(self, prefix: str = "") -> None:
        self.module, self.prefix = Module(), prefix
        self.waiting: list[tuple[Compiled, Any, int]] = []
        self.defined: list[tuple[Compiled, Any]] = []
        self._declared: dict[tuple[int, int], Any] = {}
        self._tables: dict[int, Any] = {}
        self._kept: list[Any] = []  # objects whose ids are in use
        self.inlining: list[Inlined] = []

    def _name(self, name: str) -> str:
        """Name that no other function or table has."""
        count, result = 0, name
        while result in self.module.globals:
            count += 1
            result = f"{name}.{count}"
        return result

    def declare(self, compiled: Compiled, lanes: int, name: str = "", internal: bool = False) -> Any:
        """Declare a function, which is translated later. A function without a name stays internal to the module."""
        if not compiled.has_width:
            lanes = 1
        key = id(compiled), lanes
        if key not in self._declared:
            *arguments, result = signature(compiled, lanes)
            suffix = f".{lanes}" if compiled.has_width else ""
            own = self._name(name or f"{self.prefix}{compiled.function.__name__}{suffix}")
            function = Function(self.module, ir.FunctionType(result, arguments), own)
            for k, kind in enumerate(arguments):
                if isinstance(kind, RecordPointer):  # its fields may be loaded before they are needed
                    function.of_arguments[k] = f"nonnull dereferenceable({kind.record.size}) "
            if internal or not name:
                function.linkage = "internal "
            # calls are not inlined: large modules then compile quickly
            function.attributes |= {"noinline", "nounwind"}
            self._declared[key] = function
            self._kept.append(compiled)
            self.waiting.append((compiled, function, lanes))
            self.defined.append((compiled, function))
        return self._declared[key]

    def inlined(self, function: Inlined, arguments: Sequence[Any], builder: Any, lanes: int) -> Any:
        """Result of a function that is translated at the place of its call."""
        if function in self.inlining:
            raise Refusal("a function that does not call itself", "Mark it with @compiled, or write a loop.")
        self.inlining.append(function)
        kinds = signature(function, lanes)[len(arguments) :]
        result = Body(self, function, builder, lanes).inline(arguments, kinds)
        self.inlining.pop()
        return result

    def table(self, numbers: Any, name: str) -> Any:
        """A constant array of numbers in memory."""
        if id(numbers) not in self._tables:
            kind = {"f": REAL, "i": WHOLE}.get(numbers.dtype.kind)
            if kind is None:
                cure = "np.array(..., dtype=float) or dtype=np.int64 makes one."
                raise Refusal("a table of numbers", cure, f"a table of {numbers.dtype}")
            array = ir.ArrayType(kind, numbers.size)
            content = array([constant(x.item(), kind) for x in numbers.flat])
            self._tables[id(numbers)] = ConstantTable(self.module, content, self._name(f"table.{name}"))
            self._kept.append(numbers)
        return self._tables[id(numbers)]
