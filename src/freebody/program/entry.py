"""Entries of kernels for Python: functions of arrays whose arguments are checked in compiled code.

A call of a small machine's kernel takes less than a microsecond; NumPy and Python take ten to check, join and pass on
its arguments. An entry is a built-in function (METH_FASTCALL) in the compiled language. It reads floats and arrays
as the records that CPython and NumPy's ABI make of them. Only contiguous arrays of doubles of the right lengths, and a
float as time, are taken; for all others an entry returns None, and the program reads, checks and refuses as always.

Source: Python/C API, "Common object structures"; NumPy C-API, PyArrayObject.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Annotated, Any

import numpy as np
from llvmlite import ir

from ..native.arithmetic import REAL, WHOLE
from ..native.functions import instruction
from ..native.instructions import Integers, Parts, reals_at
from ..native.loop import made, module_named
from ..native.records import Count, Kernel, Real, Record, Row, Wholes, record
from . import kernels

USABLE = (
    sys.implementation.name == "cpython" and sys.byteorder == "little"
    and (ctypes.sizeof(ctypes.c_void_p), object.__basicsize__) == (8, 16)
)  # fmt: skip
LONGEST = 4096
"""Numbers of a state for which the stack has room."""
CONTIGUOUS, LOW = 0x0101, 0xFFFFFFFF  # flags: rows are contiguous, and aligned; the lower half of a word


@record
class Object(Record):
    """A float of Python: number of references, address of its type, value. All objects begin so."""

    references: Count
    kind: Count
    value: Real


@record
class ArrayObject(Record):
    """An array of NumPy."""

    references: Count
    kind: Count
    data: Row
    axes: Count
    lengths: Wholes
    steps: Wholes
    base: Count
    numbers: Count
    flags: Count


@record
class Plain(Record):
    """What an entry knows of its kernel, and addresses of objects and functions of Python.

    ``pieces``, ``lengths``       number of arrays that are the state together, and their lengths
    ``state``                     numbers of a state
    ``array``, ``real``           types of arrays and floats; ``doubles``: type of the numbers in an array
    ``empty``, ``shape``          ``numpy.empty``, and its arguments for a result
    ``create``, ``retain``        PyObject_CallObject, Py_IncRef
    """

    kernel: Kernel
    constants: Row
    pieces: Count
    state: Count
    array: Count
    real: Count
    doubles: Count
    empty: Count
    shape: Count
    none: Count
    create: Count
    retain: Count
    lengths: Annotated[Wholes, "pieces"]


part = Parts()


@part
def entry(itself: int, arguments: Integers, count: int) -> int:
    """Return the outputs as a new array; None for arguments that are not plain."""
    plain = Plain(ArrayObject(reals_at(itself)).data)
    parts = plain.pieces
    if count != parts and count != parts + 1:
        return refused(plain)
    time = 0.0
    if count > parts:
        number = Object(reals_at(arguments[parts]))
        if number.kind != plain.real:
            return refused(plain)
        time = number.value
    for k in range(parts):
        x = ArrayObject(reals_at(arguments[k]))
        if x.kind != plain.array or x.numbers != plain.doubles:
            return refused(plain)
        if x.axes & LOW != 1 or x.flags & CONTIGUOUS != CONTIGUOUS:
            return refused(plain)
        if x.lengths[0] != plain.lengths[k]:
            return refused(plain)
    y = stack(plain.state)
    place = 0
    for k in range(parts):
        numbers = ArrayObject(reals_at(arguments[k])).data
        for i in range(plain.lengths[k]):
            y[place + i] = numbers[i]
        place += plain.lengths[k]
    result = created(plain.create, plain.empty, plain.shape)
    if result != 0:
        plain.kernel(time, y, plain.constants, ArrayObject(reals_at(result)).data)
    return result


@part
def refused(plain: Plain) -> int:
    """Return None."""
    retain(plain.retain, plain.none)
    return plain.none


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


class Memory(np.ndarray[Any, Any]):
    """Memory of an entry, which keeps what the entry needs alive."""

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
    loop = made(place, (place,), ("entry",), lambda: part.bound(dict(vars(module_named(place)))))
    result = _Definition(b"entry", loop.functions["entry"].address, METH_FASTCALL, None)
    result.loop = loop
    return result


def python_entry(
    kernel: kernels.Kernel, c: np.ndarray, widths: Sequence[int], shape: Sequence[int]
) -> Callable[..., Any] | None:
    """Return a function of arrays of these lengths, and of the time if it matters, whose result has this shape.

    It returns None for arguments that it does not take. The result is None where such functions are not possible.
    """
    if not USABLE or kernel.state > LONGEST or not shape:
        return None
    api, doubles, arguments = ctypes.pythonapi, np.dtype(float), (tuple(shape),)
    plain = Plain.made(pieces=len(widths))
    plain.kernel, plain.constants, plain.state = kernel.address, c, kernel.state
    plain.array, plain.real, plain.doubles = id(np.ndarray), id(float), id(doubles)
    plain.empty, plain.shape, plain.none = id(np.empty), id(arguments), id(None)
    plain.create, plain.retain = _address(api.PyObject_CallObject), _address(api.Py_IncRef)
    plain.lengths[:] = widths
    memory = plain.memory.view(Memory)
    memory.needs = (plain, kernel, arguments, doubles)
    create = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p)(
        _address(api.PyCFunction_NewEx)
    )
    return create(ctypes.addressof(definition()), memory, None)


def _address(function: Any) -> int:
    address = ctypes.cast(function, ctypes.c_void_p).value
    assert address is not None
    return address
