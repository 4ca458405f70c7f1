"""Entries of kernels for Python: functions of arrays whose arguments are checked in compiled code.

A call of a small machine's kernel takes less than a microsecond; NumPy and Python take ten to check, join and pass on
its arguments. An entry is a built-in function (METH_FASTCALL) in the compiled language. It reads arrays where CPython
and NumPy keep them: after the head of an object, whose last word is its type, a float has its value, and an array

    data, number of axes, lengths, steps, base, type of the numbers, flags

as NumPy's ABI fixes it. Only contiguous arrays of doubles of the right lengths, and a float as time, are taken; for all
others an entry returns None, and the program reads, checks and refuses as always.

Source: Python/C API, "Common object structures"; NumPy C-API, PyArrayObject.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from llvmlite import ir

from ..native.arithmetic import REAL, WHOLE
from ..native.functions import instruction
from ..native.instructions import Integers, Parts, call, integers_at, reals_at
from ..native.loop import made, module_named
from .kernels import Kernel

HEAD = object.__basicsize__ // 8
"""Words before the fields of an object."""
USABLE = (
    sys.implementation.name == "cpython" and sys.byteorder == "little" and ctypes.sizeof(ctypes.c_void_p) == 8
)
LONGEST = 4096
"""Numbers of a state for which the stack has room."""
CONTIGUOUS, LOW = 0x0101, 0xFFFFFFFF  # flags: rows are contiguous, and aligned; the lower half of a word
KERNEL, CONSTANTS, PARTS, STATE, ARRAY, DOUBLE, FLOAT, EMPTY, SHAPE, CREATE, NONE, RETAIN, WIDTHS = range(13)
"""Places in the table of an entry."""

part = Parts()


@part
def entry(itself: int, arguments: Integers, count: int) -> int:
    """Return the outputs as a new array; None for arguments that are not plain."""
    table = integers_at(integers_at(itself)[HEAD])
    parts = table[PARTS]
    if count != parts and count != parts + 1:
        return refused(table)
    time = 0.0
    if count > parts:
        if integers_at(arguments[parts])[HEAD - 1] != table[FLOAT]:
            return refused(table)
        time = reals_at(arguments[parts])[HEAD]
    for k in range(parts):
        x = integers_at(arguments[k])
        if x[HEAD - 1] != table[ARRAY] or x[HEAD + 5] != table[DOUBLE]:
            return refused(table)
        if x[HEAD + 1] & LOW != 1 or x[HEAD + 6] & CONTIGUOUS != CONTIGUOUS:
            return refused(table)
        if integers_at(x[HEAD + 2])[0] != table[WIDTHS + k]:
            return refused(table)
    y = stack(table[STATE])
    place = 0
    for k in range(parts):
        numbers = reals_at(integers_at(arguments[k])[HEAD])
        for i in range(table[WIDTHS + k]):
            y[place + i] = numbers[i]
        place += table[WIDTHS + k]
    result = created(table[CREATE], table[EMPTY], table[SHAPE])
    if result != 0:
        call(table[KERNEL], time, y, 0, reals_at(table[CONSTANTS]), reals_at(integers_at(result)[HEAD]), 0)
    return result


@part
def refused(table: Integers) -> int:
    """Return None."""
    retain(table[RETAIN], table[NONE])
    return table[NONE]


@instruction("int")
def stack(builder: Any, count: Any) -> Any:
    """Memory of the function for so many real numbers."""
    return builder.alloca(REAL, size=count)


@instruction("int", "int", "int")
def created(builder: Any, function: Any, *objects: Any) -> Any:
    """Return what a callable object returns for a tuple of arguments (PyObject_CallObject); 0 after an error."""
    kind = ir.FunctionType(WHOLE, [WHOLE] * len(objects))
    return builder.call(builder.inttoptr(function, kind.as_pointer()), objects)


@instruction("int", "int")
def retain(builder: Any, function: Any, object_: Any) -> None:
    """Count a reference to an object (Py_IncRef)."""
    kind = ir.FunctionType(ir.VoidType(), [WHOLE])
    builder.call(builder.inttoptr(function, kind.as_pointer()), [object_])


class Table(np.ndarray[Any, Any]):
    """Table of an entry, which keeps what the entry needs alive."""

    needs: Any = None


class _Definition(ctypes.Structure):
    """PyMethodDef."""

    _fields_ = (
        ("name", ctypes.c_char_p), ("code", ctypes.c_void_p), ("flags", ctypes.c_int), ("text", ctypes.c_char_p),
    )  # fmt: skip


METH_FASTCALL = 0x80


@lru_cache(maxsize=1)
def definition() -> _Definition:
    """Return the definition of the built-in function, whose code is the same for all kernels."""
    place = __name__.partition(".")[2]
    loop = made(f"{place} {HEAD}", (place,), ("entry",), lambda: part.bound(dict(vars(module_named(place)))))
    result = _Definition(b"entry", loop.functions["entry"].address, METH_FASTCALL, None)
    result.loop = loop
    return result


def python_entry(
    kernel: Kernel, c: np.ndarray, widths: Sequence[int], shape: Sequence[int]
) -> Callable[..., Any] | None:
    """Return a function of arrays of these lengths, and of the time if it matters, whose result has this shape.

    It returns None for arguments that it does not take. The result is None where such functions are not possible.
    """
    if not USABLE or kernel.state > LONGEST or not shape:
        return None
    api, double = ctypes.pythonapi, np.dtype(float)
    arguments = (tuple(shape),)
    words = {
        KERNEL: kernel.address, CONSTANTS: c.ctypes.data, PARTS: len(widths), STATE: kernel.state,
        ARRAY: id(np.ndarray), DOUBLE: id(double), FLOAT: id(float), EMPTY: id(np.empty), SHAPE: id(arguments),
        CREATE: _address(api.PyObject_CallObject), NONE: id(None), RETAIN: _address(api.Py_IncRef),
    }  # fmt: skip
    table = np.array([*(words[k] for k in range(WIDTHS)), *widths], dtype=np.int64).view(Table)
    table.needs = (kernel, c, arguments, double)
    create = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p)(
        _address(api.PyCFunction_NewEx)
    )
    return create(ctypes.addressof(definition()), table, None)


def _address(function: Any) -> int:
    address = ctypes.cast(function, ctypes.c_void_p).value
    assert address is not None
    return address
