"""Records: numbers, rows and kernels at fixed places of one block of memory, with one declaration for both languages.

    @record
    class Run(Record):
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

A record that is declared by `record_of_lanes` has a number for each lane in every `Real` and `Whole` and in every place
of a `Row` or of `Rows`: ``Run.of(8).made(width=5)`` for eight lanes, ``Run.made(width=5)`` for one. A field then takes
as many words as there are lanes, and a row has one more dimension. Its counts, kernels and `Wholes` are those of all
lanes.
"""

from __future__ import annotations

import ast
import ctypes
import struct
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from operator import mul
from typing import Any, ClassVar, NamedTuple, Self, TypeVar, cast

import numpy as np

Real = Any  # a number, or one for each lane
Whole = Any
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


def zeros(count: int) -> Any:
    """Array of zeros that begins at a cache line: a vector that lies across two would be read in two parts."""
    memory = np.zeros(count + LINE // WORD)
    shift = -address(memory) % LINE // WORD
    return memory[shift : shift + count]


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

    def __init__(
        self, name: str, kind: str, place: int, shape: Shape = (), nested: Any = None, lanes: int = 1
    ) -> None:
        self.name, self.kind, self.place, self.shape, self.nested = name, kind, place, shape, nested
        self.lanes = lanes

    def of(self, lanes: int) -> Field:
        """The same field for so many lanes."""
        shape = (*self.shape, lanes) if self.shape and self.kind != "Wholes" else self.shape
        nested = self.nested and self.nested.of(lanes)
        return Field(self.name, self.kind, self.place * lanes, shape, nested, lanes)

    def __get__(self, memory: Any, owner: Any = None) -> Any:
        if memory is None:
            return self
        if self.nested is not None:
            return memory.parts[self.name]
        if self.kind in _DIMENSIONS:
            array = memory.arrays.get(self.name)
            return memory.row(self.name) if array is None else array
        view, place = (
            memory.reals if self.kind == "Real" else memory.wholes,
            (memory.begin + self.place) // WORD,
        )
        if self.lanes > 1 and self.kind in ASSIGNED:
            return np.asarray(view)[place : place + self.lanes]
        return view[place]

    def __set__(self, memory: Any, value: Any) -> None:
        if self.nested is not None:
            raise TypeError(
                f"Expected an assignment to a field of '{self.name}', which is a record, got {value!r}."
            )
        place = (memory.begin + self.place) // WORD
        if self.lanes > 1 and self.kind in ASSIGNED:
            self.__get__(memory)[:] = value
        elif self.kind == "Real":
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
        dimensions = _DIMENSIONS[self.kind] + (self.lanes > 1 and self.kind != "Wholes")
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


@cache
def nested_fields(kind: type[Record]) -> list[Field]:
    """Return the fields of a record that are records."""
    return [field for field in kind.fields.values() if field.nested is not None]


class Record:
    """Base of all records: their memory, seen from Python."""

    fields: ClassVar[dict[str, Field]]
    size: ClassVar[int]
    dtype: ClassVar[Any]
    lanes: ClassVar[int] = 1
    widths: ClassVar[
        dict[int, Any]
    ] = {}  # the same record for other numbers of lanes, if it may have several

    @classmethod
    def of(cls, lanes: int) -> Any:
        """The record for so many lanes; one that is not declared by `record_of_lanes` is of one run at every width."""
        if cls.widths and lanes not in cls.widths:
            fields = {name: field.of(lanes) for name, field in cls.widths[1].fields.items()}
            cls.widths[lanes] = _declared(cls, fields, cls.widths[1].size * lanes, lanes, cls.widths)
        return cls.widths.get(lanes, cls)

    def __init__(self, memory: Any, begin: int = 0, whole: Record | None = None) -> None:
        """Take the record at byte ``begin`` of ``memory``, an array of real numbers, which it keeps alive.

        ``whole`` is the record that it is a part of.
        """
        self.memory, self.begin = memory, begin
        self.keep: Any = None  # the owner of what fields point to
        if whole is None:
            view = memoryview(memory).cast("B")
            self.reals, self.wholes = view.cast("d"), view.cast("q")
            self.address = address(memory) + begin
        else:
            self.reals, self.wholes = whole.reals, whole.wholes
            self.address = whole.address + begin - whole.begin
        self.arrays: dict[str, Any] = {}
        self.placed: Mapping[str, Any] = {}
        parts = nested_fields(type(self))  # type: ignore[arg-type]
        self.parts = {field.name: field.nested(memory, begin + field.place, self) for field in parts}

    def __getitem__(self, k: int) -> Self:
        """Return the record that stands k records further in memory."""
        result = type(self)(self.memory, self.begin + k * self.size)
        result.keep = self
        return result

    @classmethod
    def made(cls, **sizes: int) -> Self:
        """Return a record in new memory filled with zeros, and its rows with a shape, in one piece after it.

        ``sizes`` are the values of the names in the shapes; counts with such a name have that value. Every row begins
        at a cache line.
        """
        layout = _layout(cls, tuple(sizes.items()))  # type: ignore[arg-type]
        memory = zeros(layout.size)
        words = memory[: layout.words.size].view(np.int64)
        words[:] = layout.words
        words[layout.pointers] += address(memory)
        result = cls(memory)
        result._place(layout.rows)
        return result

    def _place(self, rows: Mapping[str, Any]) -> None:
        """Note where the rows of this record and of its parts are."""
        self.placed = rows
        for name, part in self.parts.items():
            part._place(rows[name])

    def row(self, name: str) -> Any:
        """Return a row that was made with the record, as an array; None if there is none."""
        if name not in self.placed:
            return None
        place, whole, shape = self.placed[name]
        count = reduce(mul, shape, 1)
        array = self.memory[place : place + count].reshape(shape)
        self.arrays[name] = array = array.view(np.int64) if whole else array
        return array

    def take(self, other: Record) -> None:
        """Copy the numbers and the made rows of another record of this kind and of these sizes."""
        for name, field in self.fields.items():
            if field.kind in ASSIGNED or field.kind == "Count":
                setattr(self, name, getattr(other, name))
            elif field.shape:
                getattr(self, name)[...] = getattr(other, name)
            elif field.nested is not None:
                self.parts[name].take(other.parts[name])

    def copies(self, count: int) -> Self:
        """Return the first of several records with these numbers and with the same rows, one after the other."""
        words = self.memory[self.begin // WORD : (self.begin + self.size) // WORD]
        result = type(self)(np.tile(words, count))
        result.keep = self
        return result

    def image_at(self, base: int, others: Sequence[Record] = ()) -> bytes:
        """Return the memory of a record made with its rows as it is at another address, for another memory.

        Rows must stand in the memory of the record or in that of ``others``, which follow it.
        """
        moves, end, images = [], base, []
        for one in (self, *others):
            moves.append((address(one.memory), one.memory.nbytes, end))
            end += _rounded(one.memory.nbytes)
        for one in (self, *others):
            words = one._moved(one.memory.view(np.int64).copy(), moves)
            images.append(words.tobytes().ljust(_rounded(words.nbytes), b"\0"))
        return b"".join(images)

    def copied(self) -> Self:
        """Return a copy of a record made with its rows, in memory of its own."""
        memory = zeros(self.memory.size)
        memory[:] = self.memory
        self._moved(memory.view(np.int64), [(address(self.memory), memory.nbytes, address(memory))])
        result = type(self)(memory, self.begin)
        result._place(self.placed)
        return result

    def _moved(self, words: Any, moves: Sequence[tuple[int, int, int]]) -> Any:
        """Return the words of a copy of the memory with the addresses of its rows changed.

        ``moves`` are the address, the size [bytes] and the new address of each memory in which they may stand.
        """
        at = _words_of_rows(type(self)) + self.begin // WORD  # type: ignore[arg-type]
        rows = words[at]
        known, result = rows == 0, rows.copy()
        for first, size, new in moves:
            inside = (rows - first).view(np.uint64) < size
            result += inside * (new - first)
            known |= inside
        if not known.all():
            raise ValueError("Expected rows in the memory of the record, got one elsewhere.")
        words[at] = result
        return words

    def places_of(self, *names: str) -> dict[str, tuple[int, str, tuple[int, ...]]]:
        """Return for each field its place in the memory [bytes], its kind, and the shape of its row.

        The place of a row that was made with the record is that of its first number.
        """
        result = {}
        for name in names:
            field = self.fields[name]
            if name in self.placed:
                place, _, shape = self.placed[name]
                result[name] = WORD * place, field.kind, shape
            else:
                result[name] = self.begin + field.place, field.kind, ()
        return result

    @classmethod
    def packer(cls, *names: str) -> tuple[struct.Struct, int]:
        """Return a `struct` of fields that follow each other, and the place of the first [bytes].

        A row is an address; `Rows` are an address and a length. One call reads or assigns all of them, in a tenth of
        the time of single accesses.
        """
        fields = [cls.fields[name] for name in names]
        for before, after in zip(fields, fields[1:], strict=False):
            if after.place != before.place + WORD * _WORDS[before.kind]:
                raise TypeError(
                    f"Expected '{after.name}' next to '{before.name}' in '{cls.__name__}'; they are apart."
                )
        letters = "".join(ASSIGNED.get(field.kind, "q" * _WORDS[field.kind]) for field in fields)
        return struct.Struct(letters), fields[0].place


@cache
def _words_of_rows(record: type[Record]) -> Any:
    """Return the words of a record, and of records in it, that are addresses of rows."""
    words: list[int] = []
    for field in record.fields.values():
        if field.nested is not None:
            words += (_words_of_rows(field.nested) + field.place // WORD).tolist()
        elif field.kind in _DIMENSIONS:
            words.append(field.place // WORD)
    return np.array(words, dtype=np.int64)


@dataclass(frozen=True)
class Alone:
    """Type of an argument: the record of one run, in a function of any width. ``OneRun = Alone(Run)`` names it."""

    record: type[Record]

    @property
    def __name__(self) -> str:
        """Name of the record."""
        return self.record.__name__


class _Layout(NamedTuple):
    """Memory of a record with rows of some sizes: numbers in all; its words at first, with the places of rows [bytes]
    in those of ``pointers``; and place [numbers], whether integers, and shape of every row by name.
    """

    size: int
    words: Any
    pointers: Any
    rows: Mapping[str, Any]


@cache
def _layout(record: type[Record], sizes: tuple[tuple[str, int], ...]) -> _Layout:
    """Return the layout of a record with rows of these sizes."""
    words, pointers = np.zeros(record.size // WORD, dtype=np.int64), []
    end, known = _rounded(record.size), dict(sizes)

    def placed(part: type[Record], begin: int) -> dict[str, Any]:
        nonlocal end
        rows: dict[str, Any] = {}
        for field in part.fields.values():
            word = (begin + field.place) // WORD
            if field.nested is not None:
                rows[field.name] = placed(field.nested, begin + field.place)
            elif field.shape:
                shape = tuple(x if isinstance(x, int) else known[x] for x in field.shape)
                if field.kind == "Rows":
                    words[word + 1] = shape[1]
                if 0 not in shape:
                    words[word] = end
                    pointers.append(word)
                rows[field.name] = (end // WORD, field.kind == "Wholes", shape)
                end += _rounded(WORD * reduce(mul, shape, 1))
            elif field.kind == "Count":
                words[word] = known.get(field.name, 0)
        return rows

    rows = placed(record, 0)
    places = np.array(pointers, dtype=np.int64)
    for array in (words, places):
        array.setflags(write=False)
    return _Layout(end // WORD, words, places, rows)


def _rounded(size: int) -> int:
    return -(-size // LINE) * LINE


def record(declaration: type[T]) -> type[T]:
    """Return the record that a class declares by its annotations.

    Raises
    ------
    TypeError            a field of unknown kind, or a value in the declaration
    """
    space = vars(sys.modules[declaration.__module__])
    own = {
        "memory", "begin", "address", "reals", "wholes", "arrays", "parts", "keep", "fields", "size", "dtype", "lanes",
        "widths", "of",
    }  # fmt: skip
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
    return _declared(declaration, fields, place)


def record_of_lanes(declaration: type[T]) -> type[T]:
    """Return the record that a class declares by its annotations, which may have several lanes (`Record.of`)."""
    result: Any = record(declaration)
    result.widths = {1: result}
    for field in result.fields.values():
        if field.nested is not None and not field.nested.widths:
            raise TypeError(
                f"Expected a record of lanes inside '{declaration.__name__}', got '{field.nested.__name__}'. "
                "Declare it by @record_of_lanes."
            )
    return cast(type[T], result)


def _declared(
    declaration: Any,
    fields: dict[str, Field],
    size: int,
    lanes: int = 1,
    widths: dict[int, Any] | None = None,
) -> Any:
    """Return the class of a record with these fields."""

    def kind(field: Field) -> Any:
        if field.nested is not None:
            return field.nested.dtype
        of_one = np.dtype("f8") if field.kind == "Real" else np.dtype("i8")
        count = field.lanes if field.kind in ASSIGNED else _WORDS[field.kind]
        return np.dtype((of_one, count)) if count > 1 else of_one

    dtype = np.dtype(
        {
            "names": list(fields), "formats": [*map(kind, fields.values())],
            "offsets": [f.place for f in fields.values()], "itemsize": size,
        }
    )  # fmt: skip
    attributes = {
        "__doc__": declaration.__doc__, "__module__": declaration.__module__, "fields": fields, "size": size,
        "dtype": dtype, "lanes": lanes, "widths": {} if widths is None else widths, **fields,
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
