"""Functions of the compiled language: their types, and calls that are replaced by instructions.

Compiled        a function to be translated; an `Inlined` one is translated at the place of each call
Instruction     a call that is replaced by instructions of LLVM
TYPES           types of arguments and results, by annotation
"""

from __future__ import annotations

import ast
import inspect
import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

from llvmlite import ir

from .arithmetic import REAL, TRUTH, WHOLE, Refusal, compared, lanes_of, mathematical, size, wide
from .record_access import RecordPointer
from .records import Alone, Record

TYPES = {
    "None": ir.VoidType(),
    "int": WHOLE,
    "float": REAL,
    "Reals": REAL.as_pointer(),
    "Integers": WHOLE.as_pointer(),
}
"""LLVM type of an argument or a result, by its annotation."""
WIDE_TYPES = {"Real": REAL, "Whole": WHOLE, "Truth": TRUTH}
"""Type of the number in each lane, by annotation. A `Row` points to numbers of type `Real`."""


def type_of(annotation: Any, lanes: int) -> Any:
    """LLVM type of an annotation in a translation for so many lanes; None if there is none."""
    if isinstance(annotation, Alone):
        return RecordPointer(annotation.record)
    if isinstance(annotation, type) and issubclass(annotation, Record):
        return RecordPointer(annotation.of(lanes))
    name = annotation if isinstance(annotation, str) else getattr(annotation, "__name__", str(annotation))
    if name == "Row":
        return wide(REAL, lanes).as_pointer()
    return wide(WIDE_TYPES[name], lanes) if name in WIDE_TYPES else TYPES.get(name)


def is_wide(annotation: Any) -> bool:
    """Return whether a type depends on the width."""
    if isinstance(annotation, type) and issubclass(annotation, Record):
        return bool(annotation.widths)
    return annotation == "Row" or annotation in WIDE_TYPES


class Compiled:
    """A function to be translated, with the types of its annotations."""

    hot = False
    """True if a loop spends most of its time here (`instructions.hot`)."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        records = {
            k: v for k, v in function.__globals__.items()
            if isinstance(v, Alone) or isinstance(v, type) and issubclass(v, Record)
        }  # fmt: skip
        annotations: list[Any] = [records.get(x, x) for x in function.__annotations__.values()] or [""]
        self.arguments, self.result = annotations[:-1], annotations[-1]

    @cached_property
    def has_width(self) -> bool:
        """Whether its types depend on the width."""
        return any(map(is_wide, (*self.arguments, self.result)))

    def __call__(self, *arguments: Any) -> Any:
        """Raise an error: only compiled code can call this object."""
        raise TypeError(
            f"Expected compiled code to call '{self.function.__name__}', got a call from Python. "
            "freebody.native.loop has the functions for Python."
        )


class Inlined(Compiled):
    """A function that is translated anew at the place of each call. It returns one value or several, at its end."""


class Instruction:
    """A call that is replaced by instructions: ``write(builder, *values)`` writes them and returns the result.

    The result is an LLVM value or None. ``kinds`` are the types of the arguments (`TYPES`, `WIDE_TYPES`); "" accepts
    any type.
    """

    def __init__(self, write: Callable[..., Any], *kinds: str) -> None:
        self.write, self.kinds = write, kinds

    def __call__(self, *arguments: Any) -> Any:
        """Raise an error: only compiled code can call this object."""
        raise TypeError(f"Expected compiled code to call '{self.write.__name__}', got a call from Python.")


def instruction(*kinds: str) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that makes an `Instruction` with arguments of these kinds."""
    return lambda write: Instruction(write, *kinds)


# -- building blocks of instructions -------------------------------------------------------------------


def variable(builder: Any, value: Any) -> Any:
    """Pointer to local memory of the function, set to this value."""
    with builder.goto_entry_block():
        place = builder.alloca(value.type)
    builder.store(value, place)
    return place


@contextmanager
def counted(builder: Any, stop: Any, step: int) -> Iterator[Any]:
    """Write a loop around the body of the context, whose value is the counter: 0, step, … below ``stop``."""
    before = builder.block
    head, body, done = (builder.append_basic_block() for _ in range(3))
    builder.branch(head)
    builder.position_at_end(head)
    number = builder.phi(WHOLE)
    number.add_incoming(WHOLE(0), before)
    builder.cbranch(builder.icmp_signed("<", number, stop), body, done)
    builder.position_at_end(body)
    yield number
    number.add_incoming(builder.add(number, WHOLE(step)), builder.block)
    builder.branch(head)
    builder.position_at_end(done)


@instruction("Real")
def _finite(builder: Any, x: Any) -> Any:
    return compared(builder, ast.Lt, mathematical(builder, "fabs", x), math.inf)


@instruction("Real")
def _logarithm2(builder: Any, x: Any) -> Any:
    return mathematical(builder, "log2", x)


@instruction("Real")
def _root(builder: Any, x: Any) -> Any:
    return mathematical(builder, "sqrt", x)


@instruction("Real", "Real")
def _signed(builder: Any, x: Any, sign: Any) -> Any:
    return mathematical(builder, "copysign", x, sign)


def _of_mask(sign: str, number: int) -> Instruction:
    """Instruction that compares the bits of a truth value for each lane with a number."""

    def reduced(builder: Any, c: Any) -> Any:
        if lanes_of(c.type) == 1:
            return c
        bits = ir.IntType(lanes_of(c.type))
        return builder.icmp_unsigned(sign, builder.bitcast(c, bits), bits(number))

    return Instruction(reduced, "Truth")


_abs = Instruction(size, "")
EQUIVALENTS: dict[Any, Instruction] = {
    abs: _abs, math.fabs: _abs, math.isfinite: _finite, math.log2: _logarithm2, math.sqrt: _root,
    math.copysign: _signed, any: _of_mask("!=", 0), all: _of_mask("==", -1),
}  # fmt: skip
"""Instructions that stand for functions of Python."""


# -- types of a function -------------------------------------------------------------------------------


def signature(compiled: Compiled, lanes: int) -> list[Any]:
    """Types of the arguments and of the result of a function."""
    function = compiled.function
    code = function.__code__
    where = f"({Path(code.co_filename).name}, line {code.co_firstlineno})"
    names = [*code.co_varnames[: code.co_argcount]]
    by_position = not code.co_posonlyargcount and not code.co_kwonlyargcount and not function.__defaults__
    if not by_position or code.co_flags & (inspect.CO_VARARGS | inspect.CO_VARKEYWORDS):
        parameters = inspect.signature(function).parameters.values()
        for p in parameters:
            if p.kind is p.POSITIONAL_OR_KEYWORD and p.default is p.empty:
                continue
            raise TypeError(
                f"Expected arguments by position without defaults for '{function.__name__}', which is to be machine "
                f"code, got '{p}' {where}. Pass every argument."
            )
    if [*function.__annotations__] != [*names, "return"]:
        missing = [name for name in (*names, "return") if name not in function.__annotations__]
        raise TypeError(
            f"Expected a type for every argument and for the result of '{function.__name__}', which is to be machine "
            f"code, got none for {', '.join(missing)} {where}. Annotate it: {', '.join([*TYPES, *WIDE_TYPES, 'Row'])}."
        )
    kinds = []
    annotations = [*zip((*names, "return"), (*compiled.arguments, compiled.result), strict=True)]
    results = re.fullmatch(r"tuple\[(.+)\]", str(compiled.result))
    if results and isinstance(compiled, Inlined):
        annotations[-1:] = [("return", part.strip()) for part in results[1].split(",")]
    for name, annotation in annotations:
        kind = type_of(annotation, lanes)
        if kind is None or isinstance(kind, ir.VoidType) and name != "return":
            raise TypeError(
                f"Expected a type of the compiled language for '{name}' of '{function.__name__}', got '{annotation}' "
                f"{where}. Types are {', '.join([*TYPES, *WIDE_TYPES, 'Row'])}, and records; None is for "
                "results."
            )
        kinds.append(kind)
    return kinds


# -- what is rare --------------------------------------------------------------------------------------


def _each(builder: Any, c: Any) -> Any:
    raise Refusal("a loop over each(c)", "Write for lane in each(c).")


def _rare(builder: Any, c: Any) -> Any:
    return c


each = Instruction(_each, "Truth")
"""``for lane in each(c)``: the lanes in which c holds, for what is rare."""
rare = Instruction(_rare, "Truth")
"""``if rare(c)``: c, which seldom holds, so that what follows stands aside from the path of the code."""
unrolled = Instruction(_each)
"""``for i in unrolled(1, 12)``: i = 1 ... 11, a constant in each round, which is translated anew."""
components = Instruction(_each)
"""``for i in components(n)``: i = 0 ... n - 1, components of rows that do not depend on each other (`rows`)."""
