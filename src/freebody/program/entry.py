"""Entries of kernels for Python: functions of arrays whose arguments are checked in compiled code.

A call of a small machine's kernel takes less than a microsecond; NumPy and Python take ten to check, join and pass on
its arguments. An entry is a built-in function (METH_FASTCALL) in the compiled language, and stands in place of the
program's method. It reads floats and arrays as the records that CPython and NumPy's ABI make of them. Only contiguous
arrays of doubles of the right lengths, and a float as time, are taken; all other calls are passed on to the method.

Source: Python/C API, "Common object structures"; NumPy C-API, PyArrayObject.
"""

from __future__ import annotations

import ctypes
import inspect
import sys
from collections.abc import Callable, Sequence
from functools import lru_cache
from operator import is_not
from typing import Annotated, Any

import numpy as np
from llvmlite import ir

from ..native.arithmetic import REAL, WHOLE
from ..native.functions import instruction
from ..native.instructions import Integers, Parts, reals_at
from ..native.loop import made, module_named
from ..native.records import Count, Kernel, Real, Record, Row, Wholes, record
from .arguments import of_list
from .kernel import Kernel as CompiledKernel

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
    ``empty``, ``retain``         PyArray_Empty, Py_IncRef
    ``axes``, ``shape``           shape of a result
    ``call``, ``method``          PyObject_Vectorcall, and the function for all other arguments
    """

    kernel: Kernel
    constants: Row
    pieces: Count
    state: Count
    array: Count
    real: Count
    doubles: Count
    empty: Count
    retain: Count
    call: Count
    method: Count
    axes: Count
    shape: Annotated[Wholes, "axes"]
    lengths: Annotated[Wholes, "pieces"]


part = Parts()


@part
def entry(itself: int, arguments: Integers, count: int, names: int) -> int:
    """Return the outputs as a new array; what the method returns for arguments that are not plain."""
    plain = Plain(ArrayObject(reals_at(itself)).data)
    parts = plain.pieces
    if names != 0 or (count != parts and count != parts + 1):
        return passed_on(plain.call, plain.method, arguments, count, names)
    time = 0.0
    if count > parts:
        number = Object(reals_at(arguments[parts]))
        if number.kind != plain.real:
            return passed_on(plain.call, plain.method, arguments, count, names)
        time = number.value
    for k in range(parts):
        x = ArrayObject(reals_at(arguments[k]))
        if x.kind != plain.array or x.numbers != plain.doubles:
            return passed_on(plain.call, plain.method, arguments, count, names)
        if x.axes & LOW != 1 or x.flags & CONTIGUOUS != CONTIGUOUS:
            return passed_on(plain.call, plain.method, arguments, count, names)
        if x.lengths[0] != plain.lengths[k]:
            return passed_on(plain.call, plain.method, arguments, count, names)
    y = stack(plain.state)
    place = 0
    for k in range(parts):
        numbers = ArrayObject(reals_at(arguments[k])).data
        for i in range(plain.lengths[k]):
            y[place + i] = numbers[i]
        place += plain.lengths[k]
    retain(plain.retain, plain.doubles)  # PyArray_Empty takes a reference
    result = created(plain.empty, plain.axes, plain.shape, plain.doubles)
    if result != 0:
        plain.kernel(time, y, plain.constants, ArrayObject(reals_at(result)).data)
    return result


@instruction("int")
def stack(builder: Any, count: Any) -> Any:
    """Memory of the function for so many real numbers."""
    return builder.alloca(REAL, size=count)


@instruction("int", "int", "Integers", "int")
def created(builder: Any, function: Any, axes: Any, shape: Any, numbers: Any) -> Any:
    """Return a new array (PyArray_Empty), of rows; 0 after an error."""
    short = ir.IntType(32)
    kind = ir.FunctionType(WHOLE, [short, shape.type, WHOLE, short])
    call = builder.inttoptr(function, kind.as_pointer())
    return builder.call(call, [builder.trunc(axes, short), shape, numbers, short(0)])


@instruction("int", "int", "Integers", "int", "int")
def passed_on(builder: Any, function: Any, *arguments: Any) -> Any:
    """Return what a callable object returns for these arguments (PyObject_Vectorcall)."""
    kind = ir.FunctionType(WHOLE, [argument.type for argument in arguments])
    return builder.call(builder.inttoptr(function, kind.as_pointer()), arguments)


@instruction("int", "int")
def retain(builder: Any, function: Any, object_: Any) -> None:
    """Count a reference to an object (Py_IncRef)."""
    kind = ir.FunctionType(ir.VoidType(), [WHOLE])
    builder.call(builder.inttoptr(function, kind.as_pointer()), [object_])


class Memory(np.ndarray[Any, Any]):
    """Memory of an entry, which keeps what the entry needs alive.

    It is the ``self`` of the built-in function; of a pickled one, that of the method is.
    """

    needs: Any = None
    method: Any = None

    def __reduce__(self) -> Any:
        """Pickle the owner of the method."""
        return _itself, (self.method.__self__,)


def _itself(owner: Any) -> Any:
    return owner


class _Definition(ctypes.Structure):
    """PyMethodDef."""

    _fields_ = (
        ("name", ctypes.c_char_p), ("code", ctypes.c_void_p), ("flags", ctypes.c_int), ("text", ctypes.c_char_p),
    )  # fmt: skip


FASTCALL, KEYWORDS = 0x80, 0x02
EMPTY = 184
"""Place of PyArray_Empty in the table of NumPy's C functions."""


@lru_cache(maxsize=1)
def code() -> Any:
    """Return the code of the built-in functions, which is the same for all kernels."""
    place = __name__.partition(".")[2]
    return made(place, (place,), ("entry",), lambda: part.bound(dict(vars(module_named(place)))))


def python_entry(
    method: Callable[..., Any],
    kernel: CompiledKernel,
    c: np.ndarray,
    widths: Sequence[int],
    shape: Sequence[int],
) -> Callable[..., Any] | None:
    """Return a function of arrays of these lengths, and of the time if it matters, whose result has this shape.

    Calls with other arguments are those of the method. Lists are made arrays first. The result is None where such
    functions are not possible.
    """
    if not USABLE or kernel.state > LONGEST or not shape:
        return None

    def others(*arguments: Any, **options: Any) -> Any:
        arrays = [*map(of_list, arguments)]
        if not options and any(map(is_not, arrays, arguments)):
            return result(*arrays)
        return method(*arguments, **options)

    api, doubles = ctypes.pythonapi, np.dtype(float)
    plain = Plain.made(pieces=len(widths), axes=len(shape))
    plain.kernel, plain.constants, plain.state = kernel.address, c, kernel.state
    plain.array, plain.real, plain.doubles = id(np.ndarray), id(float), id(doubles)
    plain.empty, plain.retain = _array_function(EMPTY), _address(api.Py_IncRef)
    plain.call, plain.method = _address(api.PyObject_Vectorcall), id(others)
    plain.lengths[:], plain.shape[:] = widths, shape
    told = _Definition(
        method.__name__.encode(), code().functions["entry"].address, FASTCALL | KEYWORDS, _about(method)
    )
    memory = plain.memory.view(Memory)
    memory.method, memory.needs = method, (plain, kernel, doubles, others, told, code())
    create = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p)(
        _address(api.PyCFunction_NewEx)
    )
    result = create(ctypes.addressof(told), memory, None)
    return result


def _about(method: Callable[..., Any]) -> bytes:
    """Return signature and description of a method, as built-in functions have them."""
    signature = inspect.signature(method)
    bare = [
        parameter.replace(annotation=inspect.Parameter.empty) for parameter in signature.parameters.values()
    ]
    arguments = str(inspect.Signature(bare)).removeprefix("(")
    return f"{method.__name__}($self, {arguments}\n--\n\n{method.__doc__}".encode()


def _address(function: Any) -> int:
    address = ctypes.cast(function, ctypes.c_void_p).value
    assert address is not None
    return address


def _array_function(place: int) -> int:
    """Return the address of one of NumPy's C functions, by its place in their table, which its ABI has fixed."""
    from numpy._core import _multiarray_umath  # type: ignore[attr-defined]

    api, capsule = ctypes.pythonapi, _multiarray_umath._ARRAY_API
    name = ctypes.PYFUNCTYPE(ctypes.c_char_p, ctypes.py_object)(_address(api.PyCapsule_GetName))
    pointer = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)
    table = pointer(_address(api.PyCapsule_GetPointer))(capsule, name(capsule))
    address = ctypes.cast(table, ctypes.POINTER(ctypes.c_void_p))[place]
    assert address is not None
    return address
