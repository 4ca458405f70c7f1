"""Records: numbers, rows and kernels at fixed places of one block of memory, with one declaration for both languages.

    @record
    class Run:
        t: Real                              a real number
        taken: Whole                         an integer
        width: Count                         an integer that compiled code only reads
        y: Annotated[Row, "width"]           pointer to real numbers; ``width`` of them, if Python makes the memory
        signs: Wholes                        pointer to integers
        k: Annotated[Rows, 16, "width"]      pointer to the first of several rows, and their length
        rates: Kernel                        pointer to a function f(t, y, c, out)
        search: Search                       another record, in place

Compiled code reads ``run.t``, ``run.y[i]``, ``run.k[j]`` (a row) and ``run.k[j, i]``, calls ``run.rates(t, y, c, out)``
and assigns numbers: ``run.t = 1.0``. It cannot assign rows, kernels and counts. So they are loaded once in a loop,
whatever the loop calls.

Python makes a record with its rows, ``Run.made(width=8)``, and reads and assigns the same fields: ``run.t = 1.0``,
``run.y[0] = 2.0`` (an array, which shares the memory), ``run.rates = address``. ``Run.dtype`` is the layout for NumPy.

Every field takes one word of 8 bytes, `Rows` take two. This file needs no compiler: a run with code from the disk loads
none.
"""

from __future__ import annotations

import ast
import ctypes
import struct
import sys
from collections.abc import Mapping
from functools import reduce
from operator import mul
from typing import Any, ClassVar, TypeVar

import numpy as np

Real = float
Whole = int
Count = int
Row = Any
Wholes = Any
Rows = Any
Kernel = Any

WIDTH = 8
"""Number of doubles in a vector: a register of 512 bits. LLVM splits vectors on processors with shorter registers."""
WORD, LINE = 8, 64
"""Bytes of a field and of a cache line."""
ASSIGNED = {"Real": "d", "Whole": "q"}
"""Kinds of fields that compiled code assigns, with their letters in `struct`."""
_WORDS = {"Real": 1, "Whole": 1, "Count": 1, "Row": 1, "Wholes": 1, "Rows": 2, "Kernel": 1}
_DIMENSIONS = {"Row": 1, "Wholes": 1, "Rows": 2}

Shape = tuple[int | str, ...]
T = TypeVar("T")


def padded(n: int) -> int:
    """Length of a row that holds ``n`` numbers: the next multiple of `WIDTH`.

    >>> padded(1), padded(8), padded(9)
    (8, 8, 16)
    """
    return -(-max(n, 1) // WIDTH) * WIDTH


def address(array: Any) -> int:
    """Address of the first number of an array; 0 for an empty array."""
    if not array.size:
        return 0
    try:  # several times as fast as .ctypes.data
        return ctypes.addressof(ctypes.c_char.from_buffer(array))
    except (ValueError, TypeError):  # a read-only array
        return int(array.ctypes.data)


class Field:
    """A field of a record: kind, place in bytes, and the shape of the row that Python makes for it."""

    def __init__(self, name: str, kind: str, place: int, shape: Shape = (), nested: Any = None) -> None:
        self.name, self.kind, self.place, self.shape, self.nested = name, kind, place, shape, nested

    def __get__(self, memory: Any, owner: Any = None) -> Any:
        if memory is None:
            return self
        if self.nested is not None:
            return memory.parts[self.name]
        if self.kind in _DIMENSIONS:
            return memory.arrays.get(self.name)
        view = memory.reals if self.kind == "Real" else memory.wholes
        return view[(memory.begin + self.place) // WORD]

    def __set__(self, memory: Any, value: Any) -> None:
        if self.nested is not None:
            raise TypeError(
                f"Expected an assignment to a field of '{self.name}', which is a record, got {value!r}."
            )
        place = (memory.begin + self.place) // WORD
        if self.kind == "Real":
            memory.reals[place] = value
        elif self.kind in _DIMENSIONS:
            memory.arrays[self.name] = array = self._checked(value)
            memory.wholes[place] = address(array)
            if self.kind == "Rows":
                memory.wholes[place + 1] = array.shape[1]
        else:
            memory.wholes[place] = value

    def _checked(self, array: Any) -> Any:
        """Return the array, or raise TypeError if it cannot stand in this field."""
        number = np.int64 if self.kind == "Wholes" else np.float64
        dimensions = _DIMENSIONS[self.kind]
        if (
            not isinstance(array, np.ndarray) or array.dtype != number or array.ndim < dimensions
            or not array.flags.c_contiguous
        ):  # fmt: skip
            got = f"{array.dtype} of shape {array.shape}" if isinstance(array, np.ndarray) else repr(array)
            raise TypeError(
                f"Expected a contiguous array of {np.dtype(number).name} with {dimensions} dimension"
                f"{'s' * (dimensions > 1)} for '{self.name}', got {got}. "
                "np.ascontiguousarray(..., dtype=...) makes one."
            )
        return array


class Record:
    """Base of all records: their memory, seen from Python."""

    fields: ClassVar[dict[str, Field]]
    size: ClassVar[int]
    dtype: ClassVar[Any]

    def __init__(self, memory: Any, begin: int = 0) -> None:
        """Take the record at byte ``begin`` of ``memory``, an array of real numbers, which it keeps alive."""
        self.memory, self.begin = memory, begin
        view = memoryview(memory).cast("B")
        self.reals, self.wholes = view.cast("d"), view.cast("q")
        self.address = address(memory) + begin
        self.arrays: dict[str, Any] = {}
        self.parts = {
            field.name: field.nested(memory, begin + field.place)
            for field in self.fields.values()
            if field.nested is not None
        }

    @classmethod
    def made(cls: type[T], **sizes: int) -> T:
        """Return a record in new memory filled with zeros, and its rows with a shape, in one piece after it.

        ``sizes`` are the values of the names in the shapes; counts with such a name have that value. Every row begins
        at a cache line: one that lies across two would be read and written in two parts.
        """
        of: Any = cls
        arrays, end = _placed(of.arrays_of(sizes), _rounded(of.size))
        memory = np.zeros(end // WORD + LINE // WORD)
        shift = -memory.ctypes.data % LINE // WORD
        memory = memory[shift : shift + end // WORD]
        result = of(memory)
        for path, kind, shape, place in arrays:
            *parts, name = path
            owner = reduce(lambda part, step: part.parts[step], parts, result)
            count = reduce(mul, shape, 1)
            array = memory[place // WORD : place // WORD + count].reshape(shape)
            setattr(owner, name, array.view(np.int64) if kind == "Wholes" else array)
        result._count(sizes)
        made: T = result
        return made

    def _count(self, sizes: Mapping[str, int]) -> None:
        """Set the counts that are sizes."""
        for field in self.fields.values():
            if field.kind == "Count" and field.name in sizes:
                setattr(self, field.name, sizes[field.name])
        for part in self.parts.values():
            part._count(sizes)

    def take(self, other: Record) -> None:
        """Copy the numbers and the made rows of another record of this kind and of these sizes."""
        for name, field in self.fields.items():
            if field.kind in ASSIGNED or field.kind == "Count":
                setattr(self, name, getattr(other, name))
            elif field.shape:
                getattr(self, name)[...] = getattr(other, name)
            elif field.nested is not None:
                self.parts[name].take(other.parts[name])

    def share(self, other: Record) -> None:
        """Take the numbers of another record of this kind, and its rows as they are, in the same memory."""
        for name, field in self.fields.items():
            if field.nested is not None:
                self.parts[name].share(other.parts[name])
            elif field.kind not in _DIMENSIONS or name in other.arrays:
                setattr(self, name, getattr(other, name))

    @classmethod
    def arrays_of(
        cls, sizes: Mapping[str, int], path: tuple[str, ...] = ()
    ) -> list[tuple[Any, str, tuple[int, ...]]]:
        """Return path, kind and shape of every array that belongs to the record."""
        result: list[tuple[Any, str, tuple[int, ...]]] = []
        for field in cls.fields.values():
            here = (*path, field.name)
            if field.nested is not None:
                result += field.nested.arrays_of(sizes, here)
            elif field.shape:
                shape = tuple(x if isinstance(x, int) else sizes[x] for x in field.shape)
                result.append((here, field.kind, shape))
        return result

    @classmethod
    def packer(cls, *names: str) -> tuple[struct.Struct, int]:
        """Return a `struct` of fields that follow each other, and the place of the first [bytes].

        One call reads or assigns all of them, in a tenth of the time of single accesses.
        """
        fields = [cls.fields[name] for name in names]
        for before, after in zip(fields, fields[1:], strict=False):
            if after.place != before.place + WORD:
                raise TypeError(
                    f"Expected '{after.name}' next to '{before.name}' in '{cls.__name__}'; they are apart."
                )
        letters = "".join(ASSIGNED.get(field.kind, "q") for field in fields)
        return struct.Struct(letters), fields[0].place


def _rounded(size: int) -> int:
    return -(-size // LINE) * LINE


def _placed(arrays: Any, begin: int) -> tuple[list[tuple[Any, str, tuple[int, ...], int]], int]:
    """Return the arrays with their places from ``begin`` on, and the end [bytes]."""
    result = []
    for path, kind, shape in arrays:
        result.append((path, kind, shape, begin))
        begin += _rounded(WORD * reduce(mul, shape, 1))
    return result, begin


def record(declaration: type[T]) -> type[T]:
    """Return the record that a class declares by its annotations.

    Raises
    ------
    TypeError            a field of unknown kind, or a value in the declaration
    """
    space = vars(sys.modules[declaration.__module__])
    own = {"memory", "begin", "address", "reals", "wholes", "arrays", "parts", "fields", "size", "dtype"}
    fields, place = {}, 0
    for name, text in declaration.__dict__.get("__annotations__", {}).items():
        kind, shape, nested = _kind(declaration.__name__, name, text, space)
        if name in declaration.__dict__ or hasattr(Record, name) or name in own:
            raise TypeError(
                f"Expected a free name without a value for a field of '{declaration.__name__}', got '{name}'. "
                "Rename it, and assign its value to the record."
            )
        fields[name] = Field(name, kind, place, shape, nested)
        place += nested.size if nested is not None else WORD * _WORDS[kind]
    letters = {"Real": np.dtype("f8"), "Rows": np.dtype((np.int64, 2))}
    dtype = np.dtype(
        {
            "names": list(fields),
            "formats": [
                f.nested.dtype if f.nested else letters.get(f.kind, np.dtype("i8")) for f in fields.values()
            ],
            "offsets": [f.place for f in fields.values()],
            "itemsize": place,
        }
    )
    attributes = {
        "__doc__": declaration.__doc__, "__module__": declaration.__module__, "fields": fields, "size": place,
        "dtype": dtype, **fields,
    }  # fmt: skip
    return type(declaration.__name__, (Record,), attributes)


def _size(node: ast.expr, space: Mapping[str, Any]) -> int | str:
    """Return a size in an annotation: an integer, a name in quotes, or a constant of the module."""
    value: int | str = space[node.id] if isinstance(node, ast.Name) else ast.literal_eval(node)
    return value


def _kind(owner: str, name: str, text: Any, space: Mapping[str, Any]) -> tuple[str, Shape, Any]:
    """Return the kind, the shape and the nested record of an annotation."""
    node = ast.parse(text, mode="eval").body if isinstance(text, str) else None
    shape: Shape = ()
    if (
        isinstance(node, ast.Subscript)
        and ast.unparse(node.value) == "Annotated"
        and isinstance(node.slice, ast.Tuple)
    ):
        node, *sizes = node.slice.elts
        shape = tuple(_size(size, space) for size in sizes)
    kind = node.id if isinstance(node, ast.Name) else ""
    nested = space.get(kind)
    if kind in _WORDS and (not shape or len(shape) == _DIMENSIONS.get(kind)):
        return kind, shape, None
    if isinstance(nested, type) and issubclass(nested, Record) and not shape:
        return kind, (), nested
    raise TypeError(
        f"Expected {', '.join(_WORDS)} or a record for '{owner}.{name}', got '{text}'. "
        "A row has one size, as in Annotated[Row, 8], and Rows two; postponed annotations (from __future__) are needed."
    )
